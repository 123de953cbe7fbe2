"""The form of the panel *Light field* that says what to record.

Settings of a light-field capture: its kind, views, samples and pixels.
"""

from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from imgui_bundle import icons_fontawesome_6, imgui

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.light_field_query import f_number_match
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.session.notices import Request
from lensbench.app.settings import dial_scales
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import Task
from lensbench.core.text import fixed

KINDS = {"lens": "Lens", "microlenses": "Microlenses", "array": "Array"}


@dataclass
class Form:
    """Entries of the capture form, and the panel's requests to the window."""

    kind: str = "lens"                                  # a key of KINDS
    views: int = 9                                      # across, and down; or the pixels behind a microlens
    samples: int = 16                                   # for each pixel of each view
    longer: int = 640                                   # pixels
    microlenses: int = 240                              # along the longer side
    f_number: float | None = None                       # of the microlenses; None: that which matches the lens
    moments: int = 1                                    # parts of the exposure that are kept apart
    spacing: float = 5.0                                # mm from pinhole to pinhole
    open: bool = False                                  # the form is shown although a recording exists
    requests: set[Request] = field(default_factory=set) # to the window

    def settings(self, current: Settings) -> Settings:
        """The current settings with the form's pixels and samples."""
        longer = self.microlenses if self.kind == "microlenses" else self.longer
        return replace(with_longer_side(current, longer), samples=self.samples, view="picture")

    def bytes(self, current: Settings) -> int:
        """Memory (bytes) that the recording will take."""
        film, square = self.settings(current).film, (self.views, self.views)
        if self.kind == "lens":
            with suppress(ValueError, OSError):         # which recording reports
                return _recorded(self.settings(current).picture, square, self.moments)
        size = lb.light_field_bytes(film, square)
        return size if self.kind != "microlenses" else size + lb.light_field_bytes(film, square, np.float32)

    def plenoptic(self, current: Settings) -> lb.PlenopticCamera:
        """The plenoptic camera; raises as `lb.PlenopticCamera` for impossible entries."""
        return _plenoptic(self.settings(current).picture, self.views, self.f_number)


@lru_cache(maxsize=4)
def _recorded(settings: Settings, views: tuple[int, int], moments: int) -> int:
    return lb.recording_bytes(camera(settings), views, moments=moments)


@lru_cache(maxsize=4)
def _plenoptic(settings: Settings, pixels: int, f_number: float | None) -> lb.PlenopticCamera:
    return lb.PlenopticCamera(camera(settings), pixels, f_number)


fa = icons_fontawesome_6
MOMENTS = (1, 2, 4, 8)
VIEWS, SAMPLES, SIDES, MICROLENSES = (5, 9, 13, 17), (1, 4, 16, 64), (320, 480, 640, 960), (120, 160, 240, 320)
KIND_TIPS = {
    "lens": "One picture through each cell of the pupil: the best light field",
    "array": "Pinholes in a plane about the middle of the pupil: views from other places, also nearer to the scene",
    "microlenses": "As a camera can do it in one exposure: microlenses on the film sort the light\n"
                   "by where in the pupil it comes from",
}


def recording_form(settings: Settings, form: Form, task: Task | None, can_go_back: bool) -> None:
    """Form of a capture: its kind and sizes, the memory it takes, and the buttons."""
    if form.kind == "lens":
        paragraph("Record the light through every part of the pupil; choose focus, aperture and viewpoint afterwards.")
    form.kind = toggles("Method", KINDS, form.kind, KIND_TIPS, 4.8)
    tip = {"lens": "Cells of the pupil across and down: more of them can be focused farther from the recorded distance",
           "microlenses": "Pixels of the sensor behind each microlens: each gives one view",
           "array": "Pinholes across and down"}[form.kind]
    form.views = toggles("Pixels" if form.kind == "microlenses" else "Views", {n: f"{n} × {n}" for n in VIEWS},
                         form.views, dict.fromkeys(VIEWS, tip), 4.8)
    form.samples = toggles("Samples", {n: f"{n}" for n in SAMPLES}, form.samples, dict.fromkeys(
        SAMPLES, "For each pixel of each view: a picture focused afterwards adds those of its views"), 4.8)
    if form.kind != "microlenses":
        form.longer = toggles("Pixels", {n: f"{n}" for n in SIDES}, form.longer, dict.fromkeys(
            SIDES, "Along the longer side of each view"), 4.8)
        if form.kind == "lens":
            form.moments = toggles("Moments", {n: f"{n}" for n in MOMENTS}, form.moments, dict.fromkeys(
                MOMENTS, "Equal parts of the exposure that are kept apart, where something moves; each has its part\n"
                         "of the samples. 1: the exposure as a whole"), 4.8)
        if form.kind == "array":
            form.spacing = dial("Spacing", form.spacing, dial_scales.lens_radius_scale(100.0, 5.0),
                                "Distance between neighbouring pinholes, in mm. They lie in a plane about the "
                                "middle of the camera's pupil") or 0.1
    else:
        _microlenses(settings, form)
    paragraph(f"Takes {fixed(form.bytes(settings) / 1e6, 0, grouped=True)} MB of memory; the picture pauses meanwhile",
              True)
    if task is not None:
        task_progress(task)
    else:
        if imgui.button(fa.ICON_FA_CIRCLE_DOT + "  Record###Record"):
            form.requests.add(Request.RECORD)
        imgui.set_item_tooltip("Record the current view of the camera")
        imgui.same_line()
        if imgui.button(fa.ICON_FA_FOLDER_OPEN + "  Open…###Open light field"):
            form.requests.add(Request.OPEN)
        imgui.set_item_tooltip("Open a recorded light field (.npz)")
    if can_go_back:
        if task is None:
            imgui.same_line()
        if imgui.button("Back"):
            form.open = False
        imgui.set_item_tooltip("Back to the light field that is recorded")


def _microlenses(settings: Settings, form: Form) -> None:
    """The number of microlenses, their f-number, and its match with the lens."""
    form.microlenses = toggles("Lenses", {n: f"{n}" for n in MICROLENSES}, form.microlenses, dict.fromkeys(
        MICROLENSES, "Microlenses along the longer side of the film: the pixels of each view along that side"), 4.8)
    try:
        of = form.plenoptic(settings)
        matched = of.matched_f_number
        turned = dial("Microlens f-number", of.microlens_f_number, dial_scales.aperture_scale(1.0, round(matched, 3)),
                      "Focal length of a microlens over its side. Double click: the f-number that matches the lens")
        if turned != of.microlens_f_number:
            form.f_number = None if abs(turned / matched - 1.0) < 0.002 else turned
        theme.small()
        paragraph(f"Fill {fixed(of.fill, 2)}   used {fixed(100.0 * of.used, 0)} %   spilled "
                  f"{fixed(100.0 * of.spilled, 0)} %", True)
        imgui.set_item_tooltip("\n".join(f"{name} {value}: {meaning}" for name, value, meaning in f_number_match(of)))
        imgui.pop_font()
    except (ValueError, OSError) as error:
        paragraph(str(error), True)
