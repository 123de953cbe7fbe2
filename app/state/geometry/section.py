"""The lens section: its stop, film, ray fans and cardinal points; `elements` has the glass.

Lengths in mm, lens frame, in the meridional plane: points are (z, y), or from above (z, x) of a lens turned by a
quarter. The ideal thin lens of the perspective camera lies at z = 0.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import lensbench as lb
from lensbench.app.state.build import Setup, design, published, setup
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.figures import AIR
from lensbench.app.state.geometry.elements import cut
from lensbench.app.state.geometry.ray_fans import FIELDS, Fan, fans, ideal_fan
from lensbench.app.state.geometry.top_view import quarter_turned
from lensbench.app.state.settings import Settings
from lensbench.app.state.water_window import port_of
from lensbench.cameras.flat_port import FlatPort

UNMARKED = "No F, P, E: the elements are out of line"


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
    glasses: behind each surface, with their dispersion, which `lens` lacks where it is that of another line than d.
    above: whether it is the section x–z, and `lens` turned for it. unmarked: why there are no cardinal points.
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
    glasses: tuple[lb.Glass, ...] = ()
    above: bool = False
    unmarked: str = ""
    port: FlatPort = AIR            # the window into water, distances from the film

    @property
    def stop_is_in_line(self) -> bool:
        """Whether the stop is neither decentred nor tilted."""
        return self.lens is None or self.lens.stop.pose is None

    def on_stop(self, height: float, widest: float) -> tuple[float, float]:
        """The point (z, y) of the stop's plane at a height (mm) from its middle; widest: the largest one drawn."""
        if self.lens is None or self.stop_is_in_line:
            return self.stop_z, height
        z, y = cut(self.lens, self.lens.stop_index, height, widest)
        return float(z), float(y)


def sketch(settings: Settings, above: bool = False) -> Sketch:
    """The sketch of these settings, from the side or from above; ValueError or OSError if there is nothing to draw."""
    if settings.kind.ideal_lens:
        return _of_ideal_lens(settings.optics)
    if not settings.has_lens:
        raise ValueError(readings(settings).reason or "This camera has no lens to draw")
    glasses = tuple(surface.glass for surface in published(settings).surfaces)
    built = setup(settings)
    if above:
        lens = quarter_turned(built.lens)
        built = replace(built, lens=lens, first_order=lb.first_order(lens))
    return _of_lens(built, design(settings), glasses, settings.optics, above)


@lru_cache(maxsize=16)
def _of_lens(lens_setup: Setup, wide_open: lb.Lens, glasses: tuple[lb.Glass, ...], settings: Settings,
             above: bool) -> Sketch:
    lens, fo = lens_setup.lens, lens_setup.first_order
    focus = lens_setup.focus_distance
    if lens_setup.refused:                                       # not focused as set: find the actual focus distance
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
    is_marked = lens.is_in_line or not settings.follows_lens
    return Sketch(
        lens=lens, fans=fans(lens_setup, focus, settings.follows_lens, settings.has_stop, wide_open.stop.semi_diameter),
        marks=tuple(Mark(sign, z, meaning) for sign, z, meaning in points if math.isfinite(z) and is_marked),
        film_z=lens_setup.film_z, film_height=0.5 * lens_setup.film.diagonal, rear_z=lens.length,
        glass_radius=max(s.semi_diameter for s in lens.surfaces),
        near_stop=max(s.semi_diameter for s in lens.surfaces[max(lens.stop_index - 2, 0):lens.stop_index + 3]),
        stop_z=lens.vertices[lens.stop_index],
        stop_radius=lens.stop.semi_diameter if settings.has_stop else None,
        open_radius=wide_open.stop.semi_diameter if settings.has_stop else None,
        ideal=not settings.follows_lens, reason=lens_setup.reason, glasses=glasses, above=above,
        unmarked="" if is_marked else UNMARKED, port=lens_setup.port,
    )


@lru_cache(maxsize=16)
def _of_ideal_lens(settings: Settings) -> Sketch:
    got = readings(settings)
    if got.efl is None:
        raise ValueError(got.reason)
    film, radius = settings.film, 0.0 if settings.f_number is None else 0.5 * (got.entrance_pupil or 0.0)
    half, focus = 0.5 * film.diagonal, port_of(settings).apparent(settings.focus_distance)
    # The film stays at the focal length: the power of the lens rises with a nearer focus
    found = tuple(ideal_fan(name, part * half, 1.0 / (1.0 / got.efl + 1.0 / focus), 0.0, 0.0, got.efl,
                            0.0, radius, 9 if radius else 1, -8.0 * got.efl) for name, part in FIELDS)
    return Sketch(
        lens=None, fans=found, marks=(Mark("O", 0.0, "Centre of projection"),), film_z=got.efl, film_height=half,
        rear_z=0.0, glass_radius=max(radius, 0.2 * half), near_stop=radius, stop_z=0.0, stop_radius=radius or None,
        open_radius=None, ideal=True, reason=got.reason, port=replace(port_of(settings), window=got.efl),
    )
