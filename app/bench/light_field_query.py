"""Query of a recorded light field: focus distance, part of the pupil, and the quantity that is shown.

A `Look` is a frozen value like Settings; its picture is a pure function of the look and the recording.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.tone import confidence_codes, depth_codes
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number, format_part
from lensbench.core.text import f_number_text, fixed, true_minus

SHOWN = {"camera": "Camera", "focus": "Focus", "view": "View", "rays": "Rays", "depth": "Depth"}
ELSEWHERE = {"camera": "Camera", "novel": "Another place"}      # for an array of pinholes
SURFACES = {"recorded": "As recorded", "plane": "On a plane"}   # assumed depth of the objects
DEEP = {"sharp": "All in focus", "depth": "Depth", "sure": "Confidence"}       # quantity of the depth that is shown
SEEN = 0.999                    # part of the aperture that must have been recorded of a pixel
EDGE = 0.999                    # pupil radii: farthest centre of a synthetic aperture


@dataclass(frozen=True, eq=False)
class Recording:
    """A light field and the settings of its capture, whose samples count for each pixel of each view.

    raw: picture on the sensor of a plenoptic camera; the pixels of the settings are its microlenses.
    """

    field: lb.LightField
    settings: Settings
    raw: lb.RawPicture | None = None

    @property
    def views(self) -> tuple[int, int]:
        """Number of views across and down."""
        return self.field.views

    @property
    def size(self) -> int:
        """Memory in bytes."""
        return self.field.nbytes + (0 if self.raw is None else self.raw.picture.nbytes + self.raw.white.nbytes)

    def during(self, moment: int) -> lb.LightField:
        """The light field of one stored moment; of the whole exposure for −1, or if no moments are stored."""
        return self.field if moment < 0 or self.field.moments is None else self.field.instants[moment]

    # Distances of a light field are those that its camera sees; all others are true, beyond a window into water as well

    @property
    def nearest(self) -> float:
        """The nearest distance (mm) that it can be focused on."""
        return float(self.field.camera.flat_port.true(self.field.nearest))

    @property
    def clear_range(self) -> tuple[float, float]:
        """The nearest and the farthest distance (mm) at which neighbouring views lie at most a pixel apart."""
        near, far = self.field.clear_range
        port = self.field.camera.flat_port
        return float(port.true(near)), float(port.true(far))

    def seen(self, distance: float) -> float:
        """A distance (mm) as the camera sees it."""
        return float(self.field.camera.flat_port.apparent(distance))

    def find_depth(self, nearest: float | None = None, farthest: float = math.inf,
                   progress: Callable[[float], bool] = lambda share: True) -> lb.Depth:
        """The depth of every pixel between two distances (mm); errors are those of `lb.find_depth`."""
        depth = lb.find_depth(self.field, None if nearest is None else self.seen(nearest), self.seen(farthest),
                              progress=progress)
        port = self.field.camera.flat_port
        return replace(depth, distance=port.true(depth.distance), error=port.index * depth.error)

    def unknown(self, look: "Look") -> float:
        """Part of a refocused picture's pixels that not all views of its aperture saw, 0 to 1; 0 for other looks."""
        if look.show != "focus":
            return 0.0
        return float((self.field.recorded(self.seen(look.distance), look.f_number, look.view) < SEEN).mean())

    @property
    def pupil_radius(self) -> float:
        """Radius (mm) of the paraxial exit pupil; negative if the image of the stop is inverted."""
        lens = self.field.camera.gaussian
        return -lens.approach_pupil / lens.approach_film if lens.approach_film else math.inf

    def of_moment(self, look: "Look") -> tuple[int, int]:
        """Index of the moment that a look shows, and the number of moments."""
        moments = self.field.moments
        return (0, 1) if look.moment < 0 or moments is None else (look.moment, len(moments))


@dataclass(frozen=True, eq=False)
class ArrayRecording:
    """Recording of an array of pinholes around the camera of the settings."""

    array: lb.Lumigraph
    settings: Settings

    @property
    def views(self) -> tuple[int, int]:
        """Number of views across and down."""
        return self.array.views

    @property
    def size(self) -> int:
        """Memory in bytes."""
        return self.array.texels.nbytes

    @property
    def half(self) -> tuple[float, float]:
        """Half width and half height (mm) of the array."""
        return tuple(self.array.places[-1, -1].tolist())


Recorded = Recording | ArrayRecording


@dataclass(frozen=True)
class Look:
    """Choices of the user. Lengths in mm; places in the pupil in its radii; f_number None: the whole aperture."""

    show: str = "camera"                        # a key of SHOWN, or of ELSEWHERE
    distance: float = 1200.0
    f_number: float | None = None
    view: tuple[float, float] = (0.0, 0.0)
    cell: tuple[int, int] = (0, 0)              # single view: across and down
    pixel: tuple[int, int] = (0, 0)             # pixel of the views whose pupil cells are shown
    sensor: bool = False                        # raw picture of a plenoptic camera instead of a single view
    band: int = -1                              # one of three colour bands; −1: all
    moment: int = -1                            # stored moment; −1: the whole exposure
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)     # of a novel view, mm: right, up, forwards
    surface: str = "recorded"                   # a key of SURFACES; `distance` is that of the plane
    deep: str = "sharp"                         # a key of DEEP

    @classmethod
    def of(cls, recording: Recorded) -> "Look":
        """The look that shows a recording with the settings of its capture."""
        if isinstance(recording, ArrayRecording):
            return cls("novel", recording.array.distance)
        across, down = recording.field.views
        film = recording.settings.film
        return cls("focus", recording.settings.focus_distance, cell=(across // 2, down // 2),
                   pixel=(film.pixels_x // 2, film.pixels_y // 2))

    @property
    def asked(self) -> "Look":
        """The look with all fields at their defaults that do not change the picture."""
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
        """Whether the colours of the picture encode a depth or a confidence instead of light."""
        return self.show == "depth" and self.deep != "sharp"


def radius(look: Look, field: lb.LightField) -> float:
    """Radius of the synthetic aperture, in pupil radii."""
    return 1.0 if look.f_number is None else field.pupil_f_number / look.f_number


def with_aperture(look: Look, f_number: float, field: lb.LightField) -> Look:
    """Look with another f-number, no wider than recorded; its centre moves until the aperture lies in the pupil."""
    whole, size = f_number <= field.f_number, min(field.pupil_f_number / f_number, 1.0)
    off, far = math.hypot(*look.view), 1.0 - size
    view = look.view if off <= far else (look.view[0] * far / off, look.view[1] * far / off)
    return replace(look, f_number=None if whole else f_number, view=(0.0, 0.0) if whole else view)


def with_view(look: Look, view: tuple[float, float], field: lb.LightField) -> Look:
    """Look with another centre of the aperture, at most EDGE; an aperture too wide for that centre is reduced."""
    off = math.hypot(*view)
    if off > EDGE:
        view = (view[0] * EDGE / off, view[1] * EDGE / off)
    room = 1.0 - min(off, EDGE)
    if radius(look, field) <= room:
        return replace(look, view=view)
    return replace(look, view=view, f_number=max(field.pupil_f_number / room, field.f_number))


def light_field_picture(recording: Recording, look: Look, depth: lb.Depth | None,
                        coarse: bool = False) -> NDArray[np.float32]:
    """Picture of a look: float32 (h, w, 3), linear light, or codes if the look is `coded`.

    depth: the estimated depth; without it, a look at the depth shows the picture at the recorded focus. coarse: as of
    `LightField.refocus`.
    """
    if look.show == "view" and look.sensor and recording.raw is not None:
        return recording.raw.picture
    if look.show == "view":
        return recording.during(look.moment).view(*look.cell)
    if look.show == "depth" and depth is not None:
        return {"sharp": depth.picture, "depth": depth_codes(depth), "sure": confidence_codes(depth)}[look.deep]
    if look.show == "depth":
        return recording.field.refocus(recording.seen(recording.settings.focus_distance))
    return recording.during(look.moment).refocus(recording.seen(look.distance), look.f_number, look.view, coarse)


def novel_view(recording: ArrayRecording, look: Look) -> lb.NovelView:
    """View of a pinhole at another place, from the recording of an array."""
    x, y, forwards = look.place
    moved = np.eye(4)
    moved[:3, 3] = x, y, -forwards
    middle = recording.array.camera
    there = replace(middle, world_from_camera=middle.placement() @ moved)
    return recording.array.seen_by(there, "recorded" if look.surface == "recorded" else look.distance)


def picture_settings(recording: Recorded, look: Look) -> Settings:
    """Settings of a camera with the focus and the f-number of the look."""
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
    """A point of the pupil in pupil radii, as text: +0.20, −0.50."""
    return true_minus(f"{fixed(view[0], 2, signed=True)}, {fixed(view[1], 2, signed=True)}")


def note(recording: Recorded, look: Look, is_found: bool = True) -> str:
    """Short description of the picture. is_found: the depth is known; until then it is the picture as recorded."""
    if isinstance(recording, ArrayRecording):
        right, up, forwards = (true_minus(f"{fixed(mm, 0, signed=True)} mm") for mm in look.place)
        return f"By the array: {right} to the right, {up} up, {forwards} forwards"
    if look.show == "view" and look.sensor and recording.raw is not None:
        film, lenses = recording.settings.film, recording.raw.camera
        return (f"Sensor: {film.pixels_x} × {film.pixels_y} microlenses of "
                f"f/{fixed(lenses.microlens_f_number, 2)} with {lenses.pixels} × {lenses.pixels} pixels each")
    if look.show == "view":
        u, v = recording.field.places[look.cell[1], look.cell[0]]
        return f"Light field: the view from {format_place((u, v))} of the pupil{_when(recording, look)}"
    if look.show == "depth" and not is_found:
        return (f"Light field: focused at {format_distance(recording.settings.focus_distance)}, as recorded; "
                "its depth is not found yet")
    if look.show == "depth":
        return {"sharp": "Light field: all in focus", "depth": "Light field: depth; uncertain pixels are dark",
                "sure": "Light field: confidence of the depth, from black to white"}[look.deep]
    f_number = look.f_number or recording.field.f_number
    off = "" if look.view == (0.0, 0.0) else f", from {format_place(look.view)}"
    return (f"Light field: focused at {format_distance(look.distance)}, {format_f_number(f_number)}{off}"
            f"{_when(recording, look)}")


def _when(recording: Recording, look: Look) -> str:
    """Text that names the moment, or "" for the whole exposure."""
    moment, number = recording.of_moment(look)
    return "" if number == 1 else f", moment {moment + 1} of {number}"


def radiance(recording: Recording, pixel: tuple[int, int]) -> NDArray[np.float32]:
    """Radiance (down, across, 3) of a pixel of the views through each cell of the pupil; 0 without light."""
    return _of_pixel(recording, recording.field.light, pixel)


def radiance_over_time(recording: Recording, pixel: tuple[int, int]) -> NDArray[np.float32]:
    """Radiance (moments, down, across, 3) as `radiance`, for each stored moment; one without stored moments."""
    field = recording.field
    return _of_pixel(recording, field.light[None] if field.moments is None else field.moments, pixel)


def _of_pixel(recording: Recording, light: NDArray, pixel: tuple[int, int]) -> NDArray[np.float32]:
    x, y = pixel
    return _over_coverage(light[..., y, x], recording.field.coverage[:, :, y, x][..., None])


def _over_coverage(light: NDArray, coverage: NDArray) -> NDArray[np.float32]:
    """The radiance of light as recorded; 0 where no sample passed."""
    light = light.astype(np.float32)
    covered = np.broadcast_to(coverage.astype(np.float32), light.shape)
    return np.divide(light, covered, np.zeros_like(light), where=covered > 0.0)


def epipolar(recording: Recording, row: int, down: int) -> NDArray[np.float32]:
    """Epipolar image (across, w, 3): a row of the picture in each view of one row of the pupil, from the left."""
    field = recording.field
    return _over_coverage(field.light[down, :, :, row], field.coverage[down, :, row][:, None]).transpose(0, 2, 1)


def ray(recording: Recording, pixel: tuple[int, int], cell: tuple[int, int]) -> tuple[tuple[float, float], ...]:
    """Points (x, y), mm, of a pixel's and cell's middle ray on film (camera frame) and exit-pupil plane."""
    field, film = recording.field, recording.settings.film
    across, down = np.array(pixel) + 0.5 + field.offsets[cell[1], cell[0]]
    u, v = field.places[cell[1], cell[0]] * recording.pupil_radius
    return ((0.5 - float(across) / film.pixels_x) * film.width, (float(down) / film.pixels_y - 0.5) * film.height), \
        (float(u), float(v))


def f_number_match(of: lb.PlenopticCamera) -> tuple[tuple[str, str, str], ...]:
    """Match of the f-numbers of microlenses and main lens: names, values, meanings."""
    return (
        ("Main", f_number_text(of.main_f_number, 2),
         "f-number of the cone of light that the microlenses see on the axis"),
        ("Match", f_number_text(of.matched_f_number, 2),
         "f-number of microlenses whose pictures of the pupil just touch"),
        ("Fill", fixed(of.fill, 2), "Diameter of the pupil's picture over the distance to the next:\n"
                                   "more than 1 overlaps, less leaves the sensor dark"),
        ("Used", format_part(of.used), "Part of the sensor that receives light: π/4 where round pictures touch"),
        ("Spilled", format_part(of.spilled), "Part of the light that misses the pixels of its microlens:\n"
                                                   "it mixes with the light of the neighbours"))
