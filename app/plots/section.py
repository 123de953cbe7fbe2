"""The lens section: glass, stop, film, ray fans and cardinal points, seen from the side or from above.

Lengths in mm, lens frame, in the meridional plane: points are (z, y). From above they are (z, x) of a lens turned by a
quarter: what lies at +x before lies at +y after. The plane cuts tilted or decentred surfaces where they stand. Where
the two surfaces of an element have different semi-diameters, the smaller one ends in a flat shoulder, and the edge is a
cylinder of the larger one. The ideal thin lens of the perspective camera lies at z = 0.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

import lensbench as lb
from lensbench.app.bench.build import Bench, bench_of, design, published
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.ray_fans import FIELDS, Fan, fans, ideal_fan
from lensbench.app.bench.readouts import AIR
from lensbench.app.bench.water_window import port_of
from lensbench.app.settings.settings import Settings
from lensbench.core.cameras.flat_port import FlatPort
from lensbench.core.kernels.numeric import rotation_about_z
from lensbench.core.optics.lens_surface import Frame, SurfacePose, tilts_of
from lensbench.core.optics.stop_image import StopImage

STEP = 0.06             # of the edge's radius, the tallest strip: its chord errs by less than a pixel on a screen
SURFACE_POINTS = 33     # of an outline's curve, rim to rim
HEIGHTS = np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, SURFACE_POINTS))      # of the rim, closer towards it
CUT_STEPS = 20          # of the iteration for the cut of a tilted or decentred surface
EDGE_POINTS, EDGE_STEPS = 65, 7     # heights of which one is the edge, and how often the gap next to it is divided


@dataclass(frozen=True, eq=False)
class Element:
    """One piece of glass between surfaces `front` and `front` + 1.

    outline (n, 2): closed, counter-clockwise, from the lower end of the front surface.
    front_at, rear_at: points (n, 2) of the two surfaces at heights, which a tilted or decentred surface measures from
    its own axis; corners: heights from 0 at which the shape has corners.
    """

    front: int
    glass: lb.Glass
    outline: np.ndarray
    front_at: Callable[[ArrayLike], np.ndarray]
    rear_at: Callable[[ArrayLike], np.ndarray]
    corners: tuple[float, ...]

    @cached_property
    def strips(self) -> np.ndarray:
        """Quadrilaterals (m, 4, 2), each convex, that fill the outline without overlap."""
        upper, edge = [0.0], self.corners[-1]
        for low, high in pairwise(self.corners):
            count = max(1, math.ceil((high - low) / (STEP * edge)))
            upper += [low + (high - low) * (k + 1) / count for k in range(count)]
        y = np.array([-h for h in reversed(upper[1:])] + upper)
        left, right = self.front_at(y), self.rear_at(y)
        return np.stack([left[:-1], left[1:], right[1:], right[:-1]], axis=1)

    def holds(self, z: float, y: float) -> bool:
        """Whether a point lies in the glass."""
        inside = False
        points = self.outline
        for (z0, y0), (z1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            if (y0 > y) != (y1 > y) and z < z0 + (y - y0) / (y1 - y0) * (z1 - z0):
                inside = not inside
        return inside


def sag(surface: lb.Surface, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """Depth of a surface at points of its frame before its roll, flat beyond its rim and beyond a sphere's equator."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    c, height = surface.curvature, np.hypot(x, y)
    r = np.minimum(height, min(surface.semi_diameter, 1.0 / abs(c) if c else np.inf))
    depth = c * r * r / (1.0 + np.sqrt(np.maximum(1.0 - c * c * r * r, 0.0)))
    if not surface.is_spherical:
        roll = surface.pose.roll if surface.pose is not None else 0.0
        cosine, sine = math.cos(roll), math.sin(roll)
        within = surface.semi_diameter / np.maximum(height, surface.semi_diameter)
        own = surface.sag(within * (cosine * x + sine * y), within * (cosine * y - sine * x))
        depth = np.where(np.isfinite(own), own, depth)
    return depth


def before_roll(lens: lb.Lens, i: int) -> np.ndarray:
    """Axes (3, 3), in columns, of the frame of a tilted or decentred surface before its roll."""
    frame, pose = lens.frames[i], lens.surfaces[i].pose
    assert frame is not None and pose is not None
    return frame.rotation @ rotation_about_z(-pose.roll) if pose.roll else frame.rotation


@lru_cache(maxsize=32)
def elements(lens: lb.Lens) -> tuple[Element, ...]:
    """Every piece of glass of the lens, from the scene to the film."""
    return tuple(_element(lens, i) for i, surface in enumerate(lens.surfaces[:-1]) if surface.glass.n_d > 1.0)


def cut(lens: lb.Lens, i: int, heights: ArrayLike, reach: float) -> np.ndarray:
    """Points (n, 2) of surface i in the meridional plane, at heights from its own axis.

    The plane cuts a surface that is decentred or tilted sideways off its vertex: heights shrink there, so that they
    end at the circle of radius `reach` (mm) about its axis.
    """
    surface, frame, vertex = lens.surfaces[i], lens.frames[i], lens.vertices[i]
    y = np.asarray(heights, float)
    if frame is None:
        return np.stack([vertex + sag(surface, 0.0, y), y], axis=-1)
    axes = before_roll(lens, i)
    (xx, xy, xz), aside = axes[0], float(frame.at(vertex)[0])
    y = y * math.sqrt(max(0.0, 1.0 - min(1.0, (aside / (xx * reach)) ** 2)))
    x, depth = np.full(y.shape, -aside / xx), np.zeros(y.shape)
    for _ in range(CUT_STEPS):
        depth = sag(surface, x, y)
        x = np.clip(-(aside + xy * y + xz * depth) / xx, -reach, reach)
    points = np.stack([x, y, vertex + depth], axis=-1) @ axes.T + frame.shift
    return points[..., [2, 1]]


@lru_cache(maxsize=16)
def surface_curves(lens: lb.Lens) -> tuple[np.ndarray, ...]:
    """Each surface from rim to rim as points (n, 2) of (z, y), index by index."""
    return tuple(cut(lens, i, surface.semi_diameter * HEIGHTS, surface.semi_diameter)
                 for i, surface in enumerate(lens.surfaces))


def _element(lens: lb.Lens, index: int) -> Element:
    front, rear = lens.surfaces[index], lens.surfaces[index + 1]

    def glass_at(y: ArrayLike) -> np.ndarray:
        """Length of glass at heights, without decentres and tilts."""
        return front.thickness + sag(rear, 0.0, y) - sag(front, 0.0, y)

    # The edge lies at the largest height with glass between both surfaces
    edge = max(front.semi_diameter, rear.semi_diameter)
    if glass_at(edge) < 0.0:
        low, high = 0.0, edge
        for _ in range(EDGE_STEPS):
            heights = np.linspace(low, high, EDGE_POINTS)
            beyond = max(1, int(np.argmax(glass_at(heights) < 0.0)))
            low, high = float(heights[beyond - 1]), float(heights[beyond])
        edge = low

    def front_at(y: ArrayLike) -> np.ndarray:
        return cut(lens, index, y, edge)

    def rear_at(y: ArrayLike) -> np.ndarray:
        return cut(lens, index + 1, y, edge)

    def curve(curve_at: Callable[[ArrayLike], np.ndarray], semi_diameter: float) -> np.ndarray:
        """From the lower edge to the upper: shoulder, surface, shoulder."""
        rim = min(semi_diameter, edge)
        y = rim * HEIGHTS
        if rim < edge:
            y = np.concatenate([[-edge], y, [edge]])
        return curve_at(y)

    outline = np.concatenate([curve(front_at, front.semi_diameter), curve(rear_at, rear.semi_diameter)[::-1]])
    corners = sorted({0.0, min(front.semi_diameter, edge), min(rear.semi_diameter, edge), edge})
    return Element(index, front.glass, outline, front_at, rear_at, tuple(corners))


QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])     # +x becomes +y


def quarter_turned(lens: lb.Lens) -> lb.Lens:
    """The lens turned so that +x becomes +y; itself where it is rotationally symmetric."""
    if lens.is_rotationally_symmetric and lens.stop_image is None and not lens.blades:
        return lens
    return _quarter_turned(lens)


@lru_cache(maxsize=16)
def _quarter_turned(lens: lb.Lens) -> lb.Lens:
    image = lens.stop_image
    return replace(lens, surfaces=tuple(_turned(surface) for surface in lens.surfaces),
                   blade_rotation=lens.blade_rotation + 0.5 * math.pi if lens.blades else lens.blade_rotation,
                   stop_image=None if image is None else _turned_image(image))


def _turned(surface: lb.Surface) -> lb.Surface:
    pose = surface.pose
    if pose is not None:
        # The quarter turn of the place in its new coordinates: the shape is turned by itself
        tilt_x, tilt_y, roll = tilts_of(QUARTER @ Frame.of(pose, 0.0).rotation @ QUARTER.T)
        pose = SurfacePose(-pose.decentre_y or 0.0, pose.decentre_x, tilt_x, tilt_y, pose.pivot, roll)
    if surface.curvature_x is None:
        return surface if pose is None else replace(surface, pose=pose)
    return replace(surface, curvature=surface.curvature_x, curvature_x=surface.curvature, pose=pose)


def _turned_image(image: StopImage) -> StopImage:
    texels = np.frombuffer(image.texels, np.float32).reshape(image.side, image.side)
    return replace(image, texels=np.ascontiguousarray(np.rot90(texels)).tobytes())


def has_two_sections(settings: Settings, lens: lb.Lens | None) -> bool:
    """Whether the section from above differs from that from the side: of a lens without symmetry, or its film."""
    if lens is None:
        return False
    pose = settings.film_pose
    return not lens.is_rotationally_symmetric or pose.is_tilted or bool(pose.rise or pose.shift)


UNMARKED = "No F, P, E: elements are tilted or decentred"


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
    near_stop: float                # the largest semi-diameter around the stop
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
    def stop_is_centred(self) -> bool:
        """Whether the stop is neither decentred nor tilted."""
        return self.lens is None or self.lens.stop.pose is None

    def on_stop(self, height: float, widest: float) -> tuple[float, float]:
        """The point (z, y) of the stop's plane at a height (mm) from its middle; widest: the largest one drawn."""
        if self.lens is None or self.stop_is_centred:
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
    built = bench_of(settings)
    if above:
        lens = quarter_turned(built.lens)
        built = replace(built, lens=lens, first_order=lb.first_order(lens))
    return _of_lens(built, design(settings), glasses, settings.optics, above)


@lru_cache(maxsize=16)
def _of_lens(lens_setup: Bench, wide_open: lb.Lens, glasses: tuple[lb.Glass, ...], settings: Settings,
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
    is_marked = lens.is_centred or not settings.follows_lens
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
    traced = tuple(ideal_fan(name, share * half, 1.0 / (1.0 / got.efl + 1.0 / focus), 0.0, 0.0, got.efl,
                            0.0, radius, 9 if radius else 1, -8.0 * got.efl) for name, share in FIELDS)
    return Sketch(
        lens=None, fans=traced, marks=(Mark("O", 0.0, "Centre of projection"),), film_z=got.efl, film_height=half,
        rear_z=0.0, glass_radius=max(radius, 0.2 * half), near_stop=radius, stop_z=0.0, stop_radius=radius or None,
        open_radius=None, ideal=True, reason=got.reason, port=replace(port_of(settings), window=got.efl),
    )
