"""Geometry of the lens section: glass, stop, film, ray fans and cardinal points.

Lengths in mm, lens frame, meridional plane. The ideal thin lens of the perspective camera lies at z = 0.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import lensbench as lb
from lensbench.app.state.build import Setup, design, setup
from lensbench.app.state.figures import readings
from lensbench.app.state.ray_fans import FIELDS, Fan, fans, ideal_fan
from lensbench.app.state.settings import Settings


@dataclass(frozen=True)
class Mark:
    """A cardinal point on the axis, with its symbol and name."""

    sign: str
    z: float
    meaning: str


@dataclass(frozen=True, eq=False)
class Sketch:
    """Everything that the section draws; `lens` is None for the perspective camera.

    stop_radius, open_radius: of the stop at stop_z, now and wide open; both None for a pinhole.
    """

    lens: lb.Lens | None
    fans: tuple[Fan, ...]
    marks: tuple[Mark, ...]
    film_z: float
    film_height: float              # half of the diagonal
    rear_z: float
    glass_radius: float             # the largest semi-diameter
    near_stop: float                # the largest semi-diameter beside the stop
    stop_z: float
    stop_radius: float | None
    open_radius: float | None
    ideal: bool                     # the rays are those of an ideal lens
    reason: str = ""


def sketch(settings: Settings) -> Sketch:
    """The sketch of these settings; ValueError or OSError if there is nothing to draw."""
    if settings.kind.ideal_lens:
        return _of_ideal_lens(settings.optics)
    if not settings.has_lens:
        raise ValueError(readings(settings).reason or "A hole and a film: there is no lens to draw")
    return _of_lens(setup(settings), design(settings), settings.optics)


@lru_cache(maxsize=16)
def _of_lens(lens_setup: Setup, wide_open: lb.Lens, settings: Settings) -> Sketch:
    lens, fo = lens_setup.lens, lens_setup.first_order
    focus = settings.focus_distance
    if lens_setup.reason:                                        # not focused as set: find the actual focus distance
        try:
            focus = lb.focused_distance(lens, lens_setup.film_distance)
        except lb.LensError:
            focus = math.inf
    points = (
        ("P", fo.front_principal, "Front principal plane"),
        ("P′", lens.length + fo.rear_principal, "Rear principal plane"),
        ("F", fo.ffl, "Front focus"), ("F′", lens.length + fo.bfl, "Rear focus"),
        ("E", fo.entrance_pupil.z, "Entrance pupil: the stop as the scene sees it"),
        ("E′", fo.exit_pupil.z, "Exit pupil: the stop as the film sees it"),
    )
    return Sketch(
        lens=lens, fans=fans(lens_setup, focus, settings.follows_lens, settings.has_stop, wide_open.stop.semi_diameter),
        marks=tuple(Mark(sign, z, meaning) for sign, z, meaning in points if math.isfinite(z)),
        film_z=lens_setup.film_z, film_height=0.5 * lens_setup.film.diagonal, rear_z=lens.length,
        glass_radius=max(s.semi_diameter for s in lens.surfaces),
        near_stop=max(s.semi_diameter for s in lens.surfaces[max(lens.stop_index - 2, 0):lens.stop_index + 3]),
        stop_z=lens.vertices[lens.stop_index],
        stop_radius=lens.stop.semi_diameter if settings.has_stop else None,
        open_radius=wide_open.stop.semi_diameter if settings.has_stop else None,
        ideal=not settings.follows_lens, reason=lens_setup.reason,
    )


@lru_cache(maxsize=16)
def _of_ideal_lens(settings: Settings) -> Sketch:
    got = readings(settings)
    if got.efl is None:
        raise ValueError(got.reason)
    film, radius = settings.film, 0.0 if settings.f_number is None else 0.5 * (got.entrance_pupil or 0.0)
    half = 0.5 * film.diagonal
    # The film stays at the focal length: the power of the lens rises with a nearer focus
    found = tuple(ideal_fan(name, part * half, 1.0 / (1.0 / got.efl + 1.0 / settings.focus_distance), 0.0, 0.0, got.efl,
                            0.0, radius, 9 if radius else 1, -8.0 * got.efl) for name, part in FIELDS)
    return Sketch(
        lens=None, fans=found, marks=(Mark("O", 0.0, "Centre of projection"),), film_z=got.efl, film_height=half,
        rear_z=0.0, glass_radius=max(radius, 0.2 * half), near_stop=radius, stop_z=0.0, stop_radius=radius or None,
        open_radius=None, ideal=True, reason=got.reason,
    )
