"""The form of the panel *Light field* that says what to record."""

from imgui_bundle import icons_fontawesome_6, imgui

from lensbench.app.panels.light_field.capture_settings import KINDS, Form
from lensbench.app.panels.task_progress import task_progress
from lensbench.app.state import dial_scales
from lensbench.app.state.light_field_query import f_number_match
from lensbench.app.state.request import Request
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.paragraph import paragraph
from lensbench.app.widgets.toggles import toggles
from lensbench.app.workers.task import Task
from lensbench.kernels.figures import fixed

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
    paragraph(f"Takes {fixed(form.bytes(settings) / 1e6, 0, grouped=True)} MB of memory", True)
    if task is not None:
        task_progress(task)
    else:
        if imgui.button(fa.ICON_FA_CIRCLE_DOT + "  Record###Record"):
            form.requests.add(Request.RECORD)
        imgui.set_item_tooltip("Record the present view of the camera")
        imgui.same_line()
        if imgui.button(fa.ICON_FA_FOLDER_OPEN + "  Open…###Open light field"):
            form.requests.add(Request.OPEN_LIGHT_FIELD)
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
