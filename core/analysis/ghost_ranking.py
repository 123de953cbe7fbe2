"""Ghosts of a light, by pairs of surfaces and ranked; and the light budget of one ray, all its reflections followed.

Lengths in mm. The estimate is paraxial: a ray matrix with two mirrors gives the focus, the size on the film and, by the
surface that limits the beam, the light of each pair. The traced figures follow rays from a light of any field through
the pair with all clear apertures, blades and reflectances.

In a budget a ray divides at every surface. Light that leaves towards the film after 0 reflections makes the picture,
after 2, 4, … the ghosts; after an odd number it leaves towards the scene. The parts add up to 1: glass absorbs nothing,
and light counts as unpolarised at every surface.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import check_wavelength
from lensbench.core.cameras.film_landing import landing_step
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import lane_buffer
from lensbench.core.kernels.pauses import pause
from lensbench.core.optics.coatings import Coating
from lensbench.core.optics.ghost_grid import entrance_grid, pair_boxes
from lensbench.core.optics.ghost_path import DIRECT, Meetings, Pair, ghost_order, ghost_pairs, pair_share
from lensbench.core.optics.ghost_trace import GhostTracer
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import CLIPPED, PASSED

LEAST = 1e-6            # part of the light below which a ray is not followed: of a large lens, 1e-3 is then left
MOST_RAYS = 400_000     # that one budget follows


@dataclass(frozen=True)
class LightBudget:
    """Parts of the light of one ray, which add up to 1.

    Attributes:
        to_film: Leaves towards the film, by the number of reflections: [0] the picture, [2], [4], … the ghosts.
        to_scene: Leaves towards the scene, by the number of reflections.
        clipped: Ends at rims, the stop and its blades: the mount absorbs it.
        lost: Meets no surface where it should, or turns sideways: it ends in the barrel.
        left: In rays too weak to be followed.
    """

    to_film: tuple[float, ...]
    to_scene: tuple[float, ...]
    clipped: float
    lost: float
    left: float

    @property
    def total(self) -> float:
        """Sum of all parts."""
        return sum(self.to_film) + sum(self.to_scene) + self.clipped + self.lost + self.left


def light_budget(lens: Lens, origin: ArrayLike, direction: ArrayLike, wavelength: float = D_LINE,
                 coating: str | Coating = "uncoated", least: float = LEAST) -> LightBudget:
    """The light budget of one ray.

    Args:
        lens: The lens.
        origin, direction: (3,) array_like. The ray towards the lens (mm, lens frame); the direction may have any
            length.
        wavelength: Micrometres.
        coating: Of the surfaces to air that have none of their own: "uncoated", "single-layer", "multi-layer", or any
            coating.
        least: Part of the light below which a ray is not followed.
    Raises:
        LensError: For a direction that is no finite vector, and if more than 400,000 rays would have to be followed:
            choose a larger `least`.
    """
    meetings, count = Meetings(lens, wavelength, coating), len(lens.surfaces)
    unit = np.asarray(direction, float)
    length = float(np.linalg.norm(unit))
    if not 0.0 < length < math.inf or not np.isfinite(np.asarray(origin, float)).all():
        raise LensError("light budget: a ray has an origin of finite numbers, and a direction that is not 0")
    unit = unit / length
    to_film: dict[int, float] = {}
    to_scene: dict[int, float] = {}
    clipped = lost = left = 0.0
    rays = 0
    # Next surface, whether towards the film, origin, direction, part of the light, reflections so far
    work = [(0, True, tuple(np.asarray(origin, float).tolist()), tuple(unit.tolist()), 1.0, 0)]
    while work:
        i, forward, point, ray, light, reflections = work.pop()
        if not 0 <= i < count:
            leaving = to_film if forward else to_scene
            leaving[reflections] = leaving.get(reflections, 0.0) + light
            continue
        if light < least:
            left += light
            continue
        rays += 1
        if rays > MOST_RAYS:
            raise LensError(f"light budget: more than {MOST_RAYS} rays; follow only those above a larger part `least`")
        met = meetings.meet(i, forward, point, ray)
        if met.fate != PASSED:
            clipped, lost = (clipped + light, lost) if met.fate == CLIPPED else (clipped, lost + light)
            continue
        back, on = light * met.reflectance, light * (1.0 - met.reflectance)
        step = 1 if forward else -1
        for after, share, ahead, more in ((met.refracted, on, forward, 0), (met.reflected, back, not forward, 1)):
            if share <= 0.0 or after is None:
                continue
            if (after[2] > 0.0) != ahead and (i > 0 or ahead):      # a fisheye may send light behind it
                lost += share                       # turned sideways: it meets no next surface in order
            else:
                work.append((i + (step if not more else -step), ahead, met.point, after, share, reflections + more))
    return LightBudget(_by_order(to_film), _by_order(to_scene), clipped, lost, left)


def _by_order(light: dict[int, float]) -> tuple[float, ...]:
    return tuple(light.get(k, 0.0) for k in range(max(light, default=0) + 1))


CELLS = 31              # along a side of the first grid of rays of one pair
PASSING = 2             # × the cells of the first grid: rays that pass, below which a finer grid is traced
RIM = 512               # points of the front rim
FINEST = 12             # × its side: of the finest grid
SHIFT = (0.5, 0.3)      # of the grids, in cells: the edges of light on the axis would meet all sides of a grid alike


@dataclass(frozen=True)
class Ghost:
    """One pair of surfaces.

    Attributes:
        first, second: Surfaces that reflect; the light meets `second` first.
        focus: Film → focus of the ghost of a distant light on the axis, paraxial, positive behind the film (mm); inf
            where the ghost leaves the lens parallel. This and the next two are NaN for a lens without rotational
            symmetry.
        paraxial_diameter: Of the ghost on the film, for a distant light on the axis (mm).
        paraxial_share: Light of that ghost, as a part of the light of the picture of the light.
        share: Traced: light that reaches the plane of the film, as a part of that of the picture of the light; 0 where
            none.
        centre: (2,) tuple of float. Middle of that light on the film (mm, as the film's frame: x right, y up,
            inverted); NaN where none.
        diameter: Traced: four times the root mean square distance of that light from `centre`, over √2: the diameter of
            an even disk (mm); NaN where none.
    """

    first: int
    second: int
    focus: float
    paraxial_diameter: float
    paraxial_share: float
    share: float
    centre: tuple[float, float]
    diameter: float

    @property
    def brightness(self) -> float:
        """Traced: mean irradiance on the film for 1 mm² of the picture's light, share / area (1/mm²)."""
        area = 0.25 * math.pi * self.diameter**2
        return self.share / area if area > 0.0 else math.inf if self.share > 0.0 else 0.0


@dataclass(frozen=True)
class Ghosts:
    """The ghosts of a lens for one light, from `ghosts`, the one with the most light per area first.

    Attributes:
        rows: All pairs.
        direct: Part of the light that enters the front rim that the picture of the light gets. A rim that light meets
            at an angle θ lets in cos θ of what it lets in along the axis.
        wavelength: Micrometres.
    """

    rows: tuple[Ghost, ...]
    direct: float
    wavelength: float

    @property
    def total(self) -> float:
        """Light of all ghosts as a part of the picture of the light: veiling glare by two reflections."""
        return sum(row.share for row in self.rows)


def ghosts(lens: Lens, film_distance: float, light: Sequence[float] = (0.0, 0.0, math.inf), wavelength: float = D_LINE,
           coating: str | Coating = "uncoated", cells: int = CELLS) -> Ghosts:
    """Every ghost of a light, estimated by matrices and traced.

    Args:
        lens: The lens, focused and stopped down.
        film_distance: Last vertex → film (mm).
        light: (3,) array_like. Angles of a distant light from the axis, across to the right and up (radians), and inf;
            or the place of a near one (mm, lens frame: z is negative before the lens).
        wavelength: Micrometres.
        coating: Of the surfaces to air that have none of their own: "uncoated", "single-layer", "multi-layer", or any
            coating.
        cells: Along a side of the first grid of rays of one pair, 4 to 512; a finer one follows where few rays pass.
    Raises:
        LensError: For a light that is not before the lens, a film that is not behind it, and a number that is no
            wavelength.
        CoatingError: For an unknown coating.
    """
    check_wavelength(wavelength)
    if not 4 <= cells <= 512:
        raise LensError(f"{cells} cells: a grid of ghosts has 4 to 512")
    if not 0.0 < film_distance < math.inf:
        raise LensError("the film must lie behind the last vertex")
    tracer = GhostTracer(lens, film_distance, [landing_step(Film(2.0, 2.0, 2, 2), 1.0)], wavelength, coating=coating,
                         real=np.float64)
    source = light_place(lens, film_distance, light)
    lanes = lane_buffer(np.float64)
    direct = traced_spot(tracer, lanes, source, DIRECT, cells)
    ranked, symmetric = [], lens.is_rotationally_symmetric
    for pair in ghost_pairs(lens, wavelength):
        pause()
        estimate = paraxial_ghost(lens, film_distance, pair, wavelength, coating) if symmetric else (math.nan,) * 3
        light_there, x, y, diameter = traced_spot(tracer, lanes, source, pair, cells)
        share = light_there / direct[0] if direct[0] > 0.0 else math.nan if light_there > 0.0 else 0.0
        ranked.append(Ghost(*pair, *estimate, share, (x, y), diameter))
    ranked.sort(key=lambda row: (-np.nan_to_num(row.brightness), row.first, row.second))
    return Ghosts(tuple(ranked), direct[0] / entering_light(lens, tracer.front_z, source), wavelength)


def entering_light(lens: Lens, front_z: float, light: np.ndarray) -> float:
    """Light through the front clear aperture (mm² across the beam, at the distance of the first vertex).

    Its area as a distant light sees it, or a near one's solid angle times (distance of the vertex)². light: of
    `light_place`; front_z: of the first vertex (mm, camera frame).
    """
    surface, near = lens.surfaces[0], bool(light[3])
    towards = light[:3] - np.array([0.0, 0.0, front_z * near])
    x, y, z = lens.in_frame_of(0, towards[None] + (0.0 if near else lens.vertex(0)))[0].tolist()
    if not near:
        return math.pi * surface.semi_diameter**2 * abs(z)
    # The solid angle of a disk by its edge: ∮ (x dy − y dx) / (s (s + h)), from the foot of the light
    turns = np.linspace(0.0, 2.0 * math.pi, RIM, endpoint=False)
    across, up = surface.semi_diameter * np.cos(turns), surface.semi_diameter * np.sin(turns)
    h = abs(float(surface.sag(surface.semi_diameter)) - z)
    s = np.sqrt((across - x)**2 + (up - y)**2 + h * h)
    around = ((across - x) * across + (up - y) * up) / (s * (s + h))
    return 2.0 * math.pi * float(around.mean()) * float(towards @ towards)


def light_place(lens: Lens, film_distance: float, light: Sequence[float]) -> np.ndarray:
    """A light as four numbers of the camera frame: its place (mm) and 1, or for a distant one the direction and 0."""
    x, y, z = (float(value) for value in light)
    if math.isinf(z):
        if not (abs(x) < 0.5 * math.pi and abs(y) < 0.5 * math.pi):
            raise LensError("a distant light lies less than 90° from the axis")
        towards = np.array([math.tan(x), math.tan(y), -1.0])
        return np.array([*(towards / np.linalg.norm(towards)), 0.0])
    if not (math.isfinite(x + y + z) and z < 0.0):
        raise LensError("a near light lies before the first vertex: its z must be negative")
    return np.array([x, y, z - lens.length - film_distance, 1.0])


def traced_spot(tracer: GhostTracer, lanes: np.ndarray, source: np.ndarray, pair: Pair, cells: int
                ) -> tuple[float, float, float, float]:
    """Light (mm² of the entering beam), middle x and y, and diameter on the film (mm) of one pair; NaN where none."""
    boxes = pair_boxes(tracer, lanes, source, pair)
    side = cells
    while True:
        landed = np.concatenate([np.empty((6, 0)), *(entrance_grid(tracer, lanes, source, pair, box, side, SHIFT)
                                                     for box in boxes)], 1)
        light = landed[3]
        lit = (light > 0.0) & np.isfinite(landed[0]) & np.isfinite(landed[1])
        passing = int(np.count_nonzero(lit))
        if passing >= PASSING * cells**2 * len(boxes) or side >= FINEST * cells:
            break
        side = min(math.ceil(side * math.sqrt(1.2 * PASSING * cells**2 * len(boxes) / max(passing, 1))), FINEST * cells)
    total = float(light[lit].sum())
    if not total > 0.0:
        return 0.0, math.nan, math.nan, math.nan
    # The landing's raster of 2 × 2 pixels of 1 mm: back to millimetres
    places = np.stack([1.0 - landed[0][lit], landed[1][lit] - 1.0])
    x, y = (places * light[lit]).sum(1) / total
    spread = (((places - [[x], [y]])**2).sum(0) * light[lit]).sum() / total
    return total, float(x), float(y), 2.0 * math.sqrt(2.0 * spread)


def paraxial_ghost(lens: Lens, film_distance: float, pair: Pair, wavelength: float = D_LINE,
                   coating: str | Coating = "uncoated") -> tuple[float, float, float]:
    """Film → focus, diameter on the film (mm) and share of the direct light, of a distant light on the axis.

    The surface with the greatest height over semi-diameter limits the beam. A mirror of curvature c in a medium n has
    the power −2 n c for light towards the film, 2 n c against it.
    """
    height, slope, limit = _marginal(lens, pair, wavelength)
    _, _, direct_limit = _marginal(lens, DIRECT, wavelength)
    on_film = height + film_distance * slope
    focus = -height / slope - film_distance if slope else math.inf
    share = (direct_limit / limit)**2 * pair_share(lens, pair, wavelength, coating) / pair_share(
        lens, DIRECT, wavelength, coating)
    return focus, 2.0 * abs(on_film) / limit, share


def _marginal(lens: Lens, pair: Pair, wavelength: float) -> tuple[float, float, float]:
    """Height and slope behind the last surface of a parallel ray of height 1; greatest height / semi-diameter."""
    n = lens.indices(wavelength)
    height, slope, limit = 1.0, 0.0, 0.0            # slope: n dy along the light
    last = None
    for i, forward, mirror in ghost_order(len(lens.surfaces), pair):
        if last is not None:
            gap, medium = (lens.surfaces[last].thickness, n[last + 1]) if i > last else (
                lens.surfaces[i].thickness, n[i + 1])
            height += gap / medium * slope
        surface = lens.surfaces[i]
        limit = max(limit, abs(height) / surface.semi_diameter)
        c = surface.vertex_curvature
        if mirror:
            slope += 2.0 * c * height * (n[i] if forward else -n[i + 1])
        else:
            slope -= (n[i + 1] - n[i]) * c * height
        last = i
    return height, slope, limit
