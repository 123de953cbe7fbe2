"""How a recorded light field is looked at: where it is focused, through what part of the pupil, and what is shown.

A look is a frozen value as Settings are; what it shows is a pure function of it and of the recording.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.depth_colours import confidence_codes, depth_codes
from lensbench.app.state.scales import format_distance, format_f_number
from lensbench.app.state.settings import Settings

SHOWN = {"camera": "Camera", "focus": "Focus", "view": "View", "rays": "Rays", "depth": "Depth"}
ELSEWHERE = {"camera": "Camera", "novel": "Another place"}      # of an array of pinholes
SURFACES = {"recorded": "As recorded", "plane": "On a plane"}   # where it takes things to be
DEEP = {"sharp": "All in focus", "depth": "Depth", "sure": "Confidence"}       # what of the depth is shown
EDGE = 0.999                    # of the pupil: as far as the middle of an aperture goes


@dataclass(frozen=True, eq=False)
class Recording:
    """A light field with the settings that it was recorded with: its samples count for each pixel of each view.

    raw: of a plenoptic camera, what its sensor saw, whose microlenses are the settings' pixels.
    """

    field: lb.LightField
    settings: Settings
    raw: lb.RawPicture | None = None

    @property
    def views(self) -> tuple[int, int]:
        """Across and down."""
        return self.field.views

    @property
    def size(self) -> int:
        """Bytes of memory."""
        raw = 0 if self.raw is None else self.raw.picture.nbytes + self.raw.white.nbytes
        moments = 0 if self.field.moments is None else self.field.moments.nbytes
        return self.field.light.nbytes + self.field.coverage.nbytes + raw + moments

    def during(self, moment: int) -> lb.LightField:
        """The light of one of the moments that were kept apart; of the whole exposure for −1, or where none were."""
        return self.field if moment < 0 or self.field.moments is None else self.field.instants[moment]

    @property
    def pupil_radius(self) -> float:
        """On the plane of the paraxial exit pupil, mm for 1 of u; negative where the stop is seen upside down."""
        lens = self.field.camera.gaussian
        return -lens.approach_pupil / lens.approach_film if lens.approach_film else math.inf

    def of_moment(self, look: "Look") -> tuple[int, int]:
        """Which of how many parts of the exposure a look shows."""
        moments = self.field.moments
        return (0, 1) if look.moment < 0 or moments is None else (look.moment, len(moments))


@dataclass(frozen=True, eq=False)
class ArrayRecording:
    """What an array of pinholes about the settings' camera recorded."""

    array: lb.Lumigraph
    settings: Settings

    @property
    def views(self) -> tuple[int, int]:
        """Across and down."""
        return self.array.views

    @property
    def size(self) -> int:
        """Bytes of memory."""
        return self.array.texels.nbytes

    @property
    def half(self) -> tuple[float, float]:
        """How far the pinholes reach from the middle, mm."""
        return tuple(self.array.places[-1, -1].tolist())


Recorded = Recording | ArrayRecording


@dataclass(frozen=True)
class Look:
    """What a person chose. Lengths in mm; places in the pupil in its radii; f_number None: the whole aperture."""

    show: str = "camera"                        # a key of SHOWN, or of ELSEWHERE
    distance: float = 1200.0
    f_number: float | None = None
    view: tuple[float, float] = (0.0, 0.0)
    cell: tuple[int, int] = (0, 0)              # the single view: across and down
    pixel: tuple[int, int] = (0, 0)             # of the views, across and down: what the pupil's cells are seen from
    sensor: bool = False                        # of a plenoptic camera: its raw picture, and no single view
    band: int = -1                              # of the three that is looked at; −1: all as a colour
    moment: int = -1                            # of those that were kept apart; −1: the whole exposure
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)     # by an array, mm: to the right, up, forwards
    surface: str = "recorded"                   # a key of SURFACES; the plane lies at `distance` from the array
    deep: str = "sharp"                         # a key of DEEP

    @classmethod
    def of(cls, recording: Recorded) -> "Look":
        """As it was recorded."""
        if isinstance(recording, ArrayRecording):
            return cls("novel", recording.array.distance)
        across, down = recording.field.views
        film = recording.settings.film
        return cls("focus", recording.settings.focus_distance, cell=(across // 2, down // 2),
                   pixel=(film.pixels_x // 2, film.pixels_y // 2))

    @property
    def asked(self) -> "Look":
        """What the picture depends on: the rest is left out."""
        if self.show == "view":
            return Look("view", sensor=True) if self.sensor else Look("view", cell=self.cell, moment=self.moment)
        if self.show == "depth":
            return Look("depth", deep=self.deep)
        if self.show == "novel":
            return replace(Look("novel", self.distance) if self.surface == "plane" else Look("novel"),
                           place=self.place, surface=self.surface)
        return Look("focus", self.distance, self.f_number, self.view, moment=self.moment)

    @property
    def coded(self) -> bool:
        """Whether the picture is of colours that stand for something else than light."""
        return self.show == "depth" and self.deep != "sharp"


def radius(look: Look, field: lb.LightField) -> float:
    """Of the aperture, in radii of the pupil."""
    return 1.0 if look.f_number is None else field.f_number / look.f_number


def with_aperture(look: Look, f_number: float, field: lb.LightField) -> Look:
    """With another aperture, no wider than what was recorded; its middle goes only as far as it stays in the pupil."""
    part = min(field.f_number / f_number, 1.0)
    off, far = math.hypot(*look.view), 1.0 - part
    view = look.view if off <= far else (look.view[0] * far / off, look.view[1] * far / off)
    whole = part == 1.0
    return replace(look, f_number=None if whole else f_number, view=(0.0, 0.0) if whole else view)


def with_view(look: Look, view: tuple[float, float], field: lb.LightField) -> Look:
    """With its aperture about another place, as far as that lies in the pupil; a wide aperture gives way."""
    off = math.hypot(*view)
    if off > EDGE:
        view = (view[0] * EDGE / off, view[1] * EDGE / off)
    room = 1.0 - min(off, EDGE)
    if radius(look, field) <= room:
        return replace(look, view=view)
    return replace(look, view=view, f_number=field.f_number / room)


def light_field_picture(recording: Recording, look: Look, depth: lb.Depth | None) -> NDArray[np.float32]:
    """The picture of a look that shows one: float32 (h, w, 3), linear, or codes where it is `coded`.

    depth: what was found of it; where there is none, a look at the depth is one at the recorded focus.
    """
    if look.show == "view" and look.sensor and recording.raw is not None:
        return recording.raw.picture
    if look.show == "view":
        return recording.during(look.moment).view(*look.cell)
    if look.show == "depth" and depth is not None:
        return {"sharp": depth.picture, "depth": depth_codes(depth), "sure": confidence_codes(depth)}[look.deep]
    if look.show == "depth":
        return recording.field.refocus(recording.settings.focus_distance)
    return recording.during(look.moment).refocus(look.distance, look.f_number, look.view)


def novel_view(recording: ArrayRecording, look: Look) -> lb.NovelView:
    """What a pinhole elsewhere sees by an array."""
    x, y, forwards = look.place
    moved = np.eye(4)
    moved[:3, 3] = x, y, -forwards
    middle = recording.array.camera
    there = replace(middle, world_from_camera=middle.placement() @ moved)
    return recording.array.seen_by(there, "recorded" if look.surface == "recorded" else look.distance)


def picture_settings(recording: Recorded, look: Look) -> Settings:
    """Those of a camera that is focused and stopped as the look is."""
    if isinstance(recording, ArrayRecording):
        return recording.settings
    if look.show == "view" and look.sensor and recording.raw is not None:
        across, down = recording.raw.camera.sensor
        return replace(recording.settings, pixels_x=across, pixels_y=down)
    if look.show in ("view", "depth"):
        return recording.settings
    return replace(recording.settings, focus_distance=look.distance,
                   f_number=recording.settings.f_number if look.f_number is None else look.f_number)


def format_place(view: tuple[float, float]) -> str:
    """A place in the pupil, in its radii: +0.20, −0.50."""
    return f"{view[0]:+.2f}, {view[1]:+.2f}".replace("-", "−")


def note(recording: Recorded, look: Look) -> str:
    """What the picture is, in a few words."""
    if isinstance(recording, ArrayRecording):
        right, up, forwards = (f"{mm:+.0f} mm".replace("-", "−") for mm in look.place)
        return f"By the array: {right} to the right, {up} up, {forwards} forwards"
    if look.show == "view" and look.sensor and recording.raw is not None:
        film, lenses = recording.settings.film, recording.raw.camera
        return (f"Sensor: {film.pixels_x} × {film.pixels_y} microlenses of f/{lenses.microlens_f_number:.2f} with "
                f"{lenses.pixels} × {lenses.pixels} pixels each")
    if look.show == "view":
        u, v = recording.field.places[look.cell[1], look.cell[0]]
        return f"Light field: the view from {format_place((u, v))} of the pupil{_when(recording, look)}"
    if look.show == "depth":
        return {"sharp": "Light field: all in focus", "depth": "Light field: depth; what is not sure is dark",
                "sure": "Light field: how sure the depth is, from black to white"}[look.deep]
    f_number = look.f_number or recording.field.f_number
    off = "" if look.view == (0.0, 0.0) else f", from {format_place(look.view)}"
    return (f"Light field: focused at {format_distance(look.distance)}, {format_f_number(f_number)}{off}"
            f"{_when(recording, look)}")


def _when(recording: Recording, look: Look) -> str:
    """Which moment is looked at, where one is."""
    moment, number = recording.of_moment(look)
    return "" if number == 1 else f", moment {moment + 1} of {number}"


def radiance(recording: Recording, pixel: tuple[int, int]) -> NDArray[np.float32]:
    """(down, across, 3) what a pixel of the views sees through each cell of the pupil; 0 where no light comes."""
    return _of_pixel(recording, recording.field.light, pixel)


def radiance_over_time(recording: Recording, pixel: tuple[int, int]) -> NDArray[np.float32]:
    """(moments, down, across, 3) as `radiance`, of the moments that were kept apart; the whole where none were."""
    field = recording.field
    return _of_pixel(recording, field.light[None] if field.moments is None else field.moments, pixel)


def _of_pixel(recording: Recording, light: NDArray, pixel: tuple[int, int]) -> NDArray[np.float32]:
    x, y = pixel
    light = light[..., y, x].astype(np.float32)
    covered = np.broadcast_to(recording.field.coverage[:, :, y, x].astype(np.float32)[..., None], light.shape)
    return np.divide(light, covered, np.zeros_like(light), where=covered > 0.0)


def epipolar(recording: Recording, row: int, down: int) -> NDArray[np.float32]:
    """(across, w, 3) what each view of one row of the pupil sees along a line of the picture; the first is the left."""
    light = recording.field.light[down, :, :, row].astype(np.float32)
    covered = recording.field.coverage[down, :, row].astype(np.float32)[:, None]
    return np.divide(light, covered, np.zeros_like(light), where=covered > 0.0).transpose(0, 2, 1)


def ray(recording: Recording, pixel: tuple[int, int], cell: tuple[int, int]) -> tuple[tuple[float, float], ...]:
    """Where the middle ray of a pixel and a cell meets the film and the plane of the exit pupil: (x, y) mm each.

    The film's x and y are those of the camera frame, in which the picture on the film stands upside down.
    """
    field, film = recording.field, recording.settings.film
    across, down = np.array(pixel) + 0.5 + field.offsets[cell[1], cell[0]]
    u, v = field.places[cell[1], cell[0]] * recording.pupil_radius
    return ((0.5 - float(across) / film.pixels_x) * film.width, (float(down) / film.pixels_y - 0.5) * film.height), \
        (float(u), float(v))


def f_number_match(of: lb.PlenopticCamera) -> tuple[tuple[str, str, str], ...]:
    """How the microlenses' f-number meets that of the main lens: names, values, meanings."""
    return (
        ("Main", f"f/{of.main_f_number:.2f}", "f-number of the cone of light that the microlenses see on the axis"),
        ("Match", f"f/{of.matched_f_number:.2f}", "f-number of microlenses whose pictures of the pupil just touch"),
        ("Fill", f"{of.fill:.2f}", "Diameter of the pupil's picture over the distance to the next:\n"
                                   "more than 1 overlaps, less leaves the sensor dark"),
        ("Used", f"{100.0 * of.used:.0f} %", "Part of the sensor that light comes to: π/4 where round pictures touch"),
        ("Spilled", f"{100.0 * of.spilled:.0f} %", "Part of the light that falls beside its microlens's own pixels:\n"
                                                   "it cannot be told from its neighbour's"))
