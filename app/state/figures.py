"""What the optics of the bench say about its settings: every figure that a panel shows.

Pure functions of Settings, kept by value: asking again in every frame costs
next to nothing. Lengths in mm, angles in radians. Distances of objects are
measured from the film, as engraved on a lens; those of the perspective camera,
which has no lens of its own, from its centre of projection.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.state.build import camera, design, perspective_focal_length
from lensbench.app.state.focusing import FocusPosition, focusing
from lensbench.app.state.settings import LOOK, MOTION, PLACE, REAL, Settings
from lensbench.cameras.real_lens import missing_dispersion


@dataclass(frozen=True)
class Setup:
    """The lens as it stands before the film: stopped down, its focus groups moved, with its film distance (mm).

    `at_infinity` is what it has when focused there, where focal length and f-number count.
    `reason` says why it is not quite what was asked for: the lens is then wide open, or
    focused as near as it can be.
    """

    lens: lb.Lens
    first_order: lb.FirstOrder
    at_infinity: lb.FirstOrder
    film: lb.Film
    film_distance: float
    focusing: FocusPosition
    reason: str = ""

    @property
    def film_z(self) -> float:
        """The film plane in the lens frame (mm)."""
        return self.lens.length + self.film_distance

    @property
    def principal_offset(self) -> float:
        """Film → front principal plane (mm): what an engraved distance is longer than one from the lens."""
        return self.film_z - self.first_order.front_principal


@dataclass(frozen=True)
class Readings:
    """The read-outs; None where a figure has no meaning for the model, `reason` where something cannot be."""

    efl: float | None = None
    bfl: float | None = None
    ffl: float | None = None
    f_number: float | None = None
    widest_f_number: float | None = None
    working_f_number: float | None = None
    t_number: float | None = None
    fov_horizontal: float | None = None
    fov_vertical: float | None = None
    fov_diagonal: float | None = None
    equivalent: float | None = None
    limit: float | None = None
    near_limit: float | None = None
    far_limit: float | None = None
    hyperfocal: float | None = None
    magnification: float | None = None
    film_distance: float | None = None
    nearest_focus: float | None = None
    entrance_pupil: float | None = None         # diameters
    exit_pupil: float | None = None
    airy: float | None = None                   # diameter of the first dark ring at the d line
    across: float | None = None                 # focal length of the section x–z of a lens with cylinders
    foci: tuple[float, float] | None = None     # of its sections x–z and y–z, mm behind the film
    focusing: FocusPosition = FocusPosition("paraxial")
    reason: str = ""


@lru_cache(maxsize=64)
def optical(settings: Settings) -> Settings:
    """What lens and film depend on: everything else is set to its default."""
    return settings.plain(*(name for name in LOOK if name != "limit"), *MOTION, *PLACE, "scene", "seed", "view",
                          "visibility", "fog_light", "dispersion")


def blur_limit(settings: Settings) -> float:
    """The circle of confusion (mm) up to which a point counts as sharp."""
    film = settings.film
    return film.pitch if settings.limit == "pixel" else film.diagonal / 1500.0


def setup(settings: Settings) -> Setup:
    """The lens of the settings before its film; a ValueError or OSError where there is no lens to set up."""
    return _setup(design(settings), optical(settings))


@lru_cache(maxsize=64)
def _setup(lens: lb.Lens, settings: Settings) -> Setup:
    reasons = []
    if settings.f_number is not None:
        try:
            lens = lb.stopped_down(lens, settings.f_number)
        except lb.LensError as error:
            reasons.append(str(error))
    at_infinity = lb.first_order(lens)
    try:
        found = focusing(lens, settings)
        lens = lb.focused(lens, settings.focus_distance, found.method)
        film_distance = lb.film_distance(lens, settings.focus_distance, found.method)
    except lb.LensError as error:
        reasons.append(str(error))
        found, (lens, film_distance) = FocusPosition("paraxial"), _at_nearest(lens)
    return Setup(lens, lb.first_order(lens), at_infinity, settings.film, film_distance, found, "; ".join(reasons))


def _at_nearest(lens: lb.Lens) -> tuple[lb.Lens, float]:
    """The lens focused as near as it can be, with its film; or the film somewhere behind a lens that cannot focus."""
    try:
        nearest = lb.nearest_focus(lens)
        lens = lb.focused(lens, nearest)
        return lens, lb.film_distance(lens, nearest)
    except lb.LensError:
        return lens, max(lens.length, lens.surfaces[-1].semi_diameter)


class Colours(NamedTuple):
    """Whether dispersion is possible, whether a picture is traced with it, and in a sentence why (not)."""

    possible: bool
    used: bool
    why: str


def colours(settings: Settings) -> Colours:
    """What these settings make of the dispersion of the lens; a ValueError or OSError where there is no lens."""
    if settings.model not in REAL:
        return Colours(False, False, "Only the real lens disperses: this model is an ideal one, at the d line")
    lens = design(settings)
    if not any(surface.glass.disperses for surface in lens.surfaces):
        return Colours(False, False, "At the d line alone: of the glasses of this lens no dispersion is known")
    missing = missing_dispersion(lens)
    if missing:
        return Colours(False, False, f"At the d line alone: {missing}, and a picture sees 0.42 to 0.65 µm")
    if settings.dispersion == "off":
        return Colours(True, False, "At the d line alone: dispersion is turned off")
    return Colours(True, True, "Traced at 24 wavelengths, eight for each of red, green and blue: lateral and "
                               "longitudinal colour show. A sample takes three times as long"
                               + (". The automatic model does so where they amount to half a pixel"
                                  if settings.model == "auto" else ""))


def readings(settings: Settings) -> Readings:
    """All read-outs of these settings; a bad state gives its reason, never an exception."""
    try:
        lens = None if settings.lensless else design(settings)
        return _readings(lens, optical(settings))
    except (ValueError, OSError) as error:
        return Readings(reason=str(error))


@lru_cache(maxsize=64)
def _readings(lens: lb.Lens | None, settings: Settings) -> Readings:
    if lens is None:
        return IDEAL[settings.model](settings)
    stand = _setup(lens, settings)
    fo, designed, film, limit = stand.first_order, stand.at_infinity, stand.film, blur_limit(settings)
    pinhole = settings.model == "pinhole"
    plain = replace(
        _angles(film, designed.efl, _across(lens)),
        efl=_finite(designed.efl), bfl=_finite(designed.bfl), ffl=_finite(designed.ffl), limit=limit,
        widest_f_number=_finite(lb.first_order(lens).f_number), film_distance=stand.film_distance,
        focusing=stand.focusing,
        entrance_pupil=_finite(2.0 * fo.entrance_pupil.radius), exit_pupil=_finite(2.0 * fo.exit_pupil.radius),
        reason=stand.reason,
    )
    if not (math.isfinite(fo.efl) and fo.efl > 0.0):
        return plain

    # The closed forms measure from the front principal plane, the focus ring from the film
    offset, nearest = stand.principal_offset, lb.nearest_focus(stand.lens)
    if not lens.is_rotationally_symmetric:
        foci = lb.section_foci(stand.lens, max(settings.focus_distance, nearest), stand.film_distance)
        behind = (foci[0] - stand.film_distance, foci[1] - stand.film_distance)
        plain = replace(plain, across=_across(lens), foci=behind)
    focus = max(settings.focus_distance, nearest) - offset
    plain = replace(plain, nearest_focus=nearest, magnification=fo.efl / (focus - fo.efl))
    if pinhole:
        return replace(plain, f_number=None)
    near, far = lb.depth_of_field(fo.efl, fo.f_number, focus, limit)
    working = lb.working_f_number(stand.lens, stand.film_distance)
    return replace(
        plain, f_number=designed.f_number, working_f_number=_finite(working), airy=_airy(working),
        t_number=lb.t_number(stand.lens.at(close=0.0)),
        near_limit=near + offset, far_limit=far + offset,
        hyperfocal=lb.hyperfocal(fo.efl, fo.f_number, limit) + offset,
    )


def _of_perspective(settings: Settings) -> Readings:
    """The perspective camera: an ideal thin lens of the focal length that its field of view implies."""
    film, limit = settings.film, blur_limit(settings)
    efl = perspective_focal_length(settings)
    plain = replace(_angles(film, efl), efl=efl, limit=limit)
    if settings.f_number is None:
        return plain
    plain = replace(plain, f_number=settings.f_number, entrance_pupil=efl / settings.f_number,
                    hyperfocal=lb.hyperfocal(efl, settings.f_number, limit), nearest_focus=2.0 * efl)
    try:
        near, far = lb.depth_of_field(efl, settings.f_number, settings.focus_distance, limit)
    except lb.LensError as error:
        return replace(plain, reason=str(error))
    magnification = efl / (settings.focus_distance - efl)
    working = settings.f_number * (1.0 + magnification)
    return replace(plain, near_limit=near, far_limit=far, magnification=magnification, working_f_number=working,
                   airy=_airy(working))


def _of_orthographic(settings: Settings) -> Readings:
    return Readings(magnification=settings.film_width / settings.scene_width, limit=blur_limit(settings),
                    reason="An orthographic camera sees from everywhere: it has neither a focal length nor a field of "
                           "view")


def _of_fisheye(settings: Settings) -> Readings:
    """The ideal fisheye: twice the angle from the axis of rays at the film's sides and corner, within its circle."""
    film, of = settings.film, camera(settings)
    assert isinstance(of, lb.FisheyeCamera)
    edges = [[0.0, film.pixels_y / 2.0], [film.pixels_x / 2.0, 0.0], [0.0, 0.0]]
    rays = of.generate_rays(edges, np.full((3, 2), 0.5))
    angles = np.where(rays.weights > 0.0, 2.0 * np.arccos(np.clip(-rays.directions[:, 2], -1.0, 1.0)),
                      settings.fisheye_fov)
    across, down, diagonal = (float(angle) for angle in angles)
    return Readings(efl=of.focal_length, limit=blur_limit(settings), fov_horizontal=across, fov_vertical=down,
                    fov_diagonal=diagonal, reason="An ideal fisheye sees from a point: it has no lens to focus")


def _of_environment(settings: Settings) -> Readings:
    return Readings(fov_horizontal=2.0 * math.pi, fov_vertical=math.pi,
                    reason="A panorama sees in every direction from a point: nothing is out of focus")


def _of_hole(settings: Settings) -> Readings:
    """The pinhole of finite size: at every distance as sharp as its hole and diffraction leave it."""
    film, of = settings.film, camera(settings)
    assert isinstance(of, lb.PinholeCamera)
    return replace(_angles(film, of.distance), efl=of.distance, limit=blur_limit(settings), f_number=of.f_number,
                   working_f_number=of.f_number, film_distance=of.distance, entrance_pupil=2.0 * of.radius,
                   airy=of.diffraction())


def _of_bare(settings: Settings) -> Readings:
    return Readings(limit=blur_limit(settings), reason="Without a lens each place of the film gets light from the "
                    "whole scene: no picture forms")


IDEAL = {"perspective": _of_perspective, "orthographic": _of_orthographic, "fisheye": _of_fisheye,
         "environment": _of_environment, "hole": _of_hole, "bare": _of_bare}


def _across(lens: lb.Lens) -> float | None:
    """The focal length across (mm) of a lens that has another one there: with cylinders."""
    return None if lens.is_rotationally_symmetric else _finite(lb.first_order(lens.section("x")).efl)


def _angles(film: lb.Film, efl: float, across_efl: float | None = None) -> Readings:
    """Fields of view at infinity, 2 atan(h / 2f), and the focal length that sees the same diagonal on full frame.

    across_efl: of a lens that squeezes the picture; the film then counts as wide as what it sees.
    """
    if not (math.isfinite(efl) and efl > 0.0):
        return Readings()
    if across_efl is not None and across_efl > 0.0:
        film = replace(film, width=film.width * efl / across_efl)
    across, down, diagonal = (lb.field_of_view(efl, film, axis) for axis in ("horizontal", "vertical", "diagonal"))
    return Readings(fov_horizontal=across, fov_vertical=down, fov_diagonal=diagonal,
                    equivalent=lb.equivalent(efl, film).focal_length)


def _airy(working_f_number: float) -> float | None:
    """Diameter (mm) of the first dark ring of a point, 2.44 λ N."""
    return _finite(2.44 * lb.D_LINE * 1e-3 * working_f_number)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
