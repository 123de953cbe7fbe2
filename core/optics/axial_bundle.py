"""Real rays from a point on the axis: width at the clear aperture that limits them, course, and light.

Lengths in mm, lens frame; the film is in air. A point on the axis is given by its nearness in 1/mm: 1 / distance before
the first vertex (behind the last, for light that runs backwards), 0 at infinity; a ray by its point on the plane of the
vertex that it meets first. The rays of one meridian represent all of a rotationally symmetric lens, those of a quadrant
a lens with cylinders; a tilted or decentred lens is traced in all four quadrants.
"""

from functools import lru_cache
from math import cos, hypot, inf, pi, prod, sin, sqrt

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.optics.coatings import BARE, Coating, named_coating
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import PASSED, Fate, surface_table, trace, trace_ray
from lensbench.core.optics.surfaces import RIM2, VERTEX
from lensbench.core.text import significant

ZONES = 24                      # over the pupil's area: 8 suffice for the rms, 24 for the extent of a spot to 1 %
FAN = 5                         # directions in a quadrant of a pupil without rotational symmetry
WITHIN_THE_RIM = 1.0 - 1e-12    # outermost ray over the marginal height: within the rounding error of the search
_SCAN = 24                      # steps outwards to the first ray that fails; a ring of light beyond does not count
_HALVINGS = 46                  # of such a step, to the rounding error of the height


@lru_cache
def zone_rule() -> tuple[np.ndarray, np.ndarray]:
    """Heights over the marginal one, the outermost last, and weights of sum 1: Gauss's rule over the pupil's area."""
    nodes, weights = gauss_rule(ZONES)
    return np.append(np.sqrt(nodes), WITHIN_THE_RIM), np.append(weights, 0.0)


def fan_rule(lens: Lens, nearness: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, a, 2), x and y, and their weights (n, a) per squared marginal height in the pupil's area.

    By the trapezium rule over equal areas of the elliptical paraxial pupil. nearness: (n,), 1/mm.
    """
    if lens.is_rotationally_symmetric:
        return np.tile([0.0, 1.0], (len(nearness), 1, 1)), np.ones((len(nearness), 1))
    axes = []
    for section in lens.sections:
        a, b, _, _ = ray_matrix(section, 0, lens.stop_index)
        axes.append(1.0 / np.maximum(np.abs(a + b * nearness * lens.front_index), 1e-6))
    if lens.is_mirror_symmetric:
        azimuth, weights = np.linspace(0.0, 0.5 * pi, FAN), np.ones(FAN)
        weights[[0, -1]] = 0.5
    else:
        azimuth, weights = 2.0 * pi * np.arange(4 * FAN) / (4 * FAN), np.ones(4 * FAN)
    corners = np.array([axes[0], axes[-1]]).T[:, None, :] * np.stack([np.cos(azimuth), np.sin(azimuth)], 1)
    reach2 = (corners**2).sum(2, keepdims=True)
    return corners / np.sqrt(reach2), weights / reach2[..., 0]


def pupil_rays(lens: Lens, nearness: np.ndarray, wavelength: float = D_LINE
               ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bundles of axis points of nearness (n,) in 1/mm that cover the open pupil evenly, its edge included.

    Blades count as a circle of as much area. wavelength: µm. → points and slopes (n, rays, 2) on the plane of the last
    vertex (mm, mm/mm), and weights (n, rays) of sum 1, by the area on the plane of the first vertex.
    """
    lens = lens.with_round_stop
    (zones, zone_weights), (directions, weights) = zone_rule(), fan_rule(lens, nearness)
    points, slopes = np.empty((2, *directions.shape[:2], len(zones), 2))
    rims = np.empty(directions.shape[:2])
    trace_bundles(surface_table(lens, wavelength), nearness, zones, directions, points, slopes, rims)
    area = weights * np.maximum(rims, 1e-30) ** 2
    shares = (area / area.sum(1, keepdims=True))[:, :, None] * zone_weights
    n = len(nearness)
    return points.reshape(n, -1, 2), slopes.reshape(n, -1, 2), shares.reshape(n, -1)


@njit(cache=True, nogil=True, error_model="numpy")
def trace_axial(table, height, nearness, forward, across, up):
    """A ray of an axis point through height · (across, up) on the plane of the vertex met first, where it starts.

    → (x, y, dx/dz, dy/dz, fate) on the plane of the vertex met last.
    """
    numbers = table.numbers
    last = numbers.shape[0] - 1
    slope = height * nearness
    scale = 1.0 / sqrt(1.0 + slope**2)
    along = scale if forward else -scale
    start, end = (numbers[0, VERTEX], numbers[last, VERTEX]) if forward else (numbers[last, VERTEX], numbers[0, VERTEX])
    x, y, z, dx, dy, dz, fate, _ = trace_ray(
        table, True, across * height, up * height, start, across * slope * scale, up * slope * scale, along, None, 0, 0)
    slope_x, slope_y = dx / dz, dy / dz
    return x + (end - z) * slope_x, y + (end - z) * slope_y, slope_x, slope_y, fate


@njit(cache=True, nogil=True, error_model="numpy")
def marginal_height(table, nearness, forward, across=0.0, up=1.0):
    """Height (mm) on the plane of the vertex met first of the outermost ray that passes; 0 if none does.

    (across, up): its direction from the axis, a unit vector.
    """
    rim = 2.0 * sqrt(table.numbers[0 if forward else table.kinds.size - 1, RIM2])
    inside, outside = 0.0, 0.0
    for step in range(1, _SCAN + 1):
        outside = rim * step / _SCAN
        if trace_axial(table, outside, nearness, forward, across, up)[4] != PASSED:
            break
        inside = outside
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        if trace_axial(table, middle, nearness, forward, across, up)[4] == PASSED:
            inside = middle
        else:
            outside = middle
    return inside


@njit(cache=True, nogil=True, error_model="numpy")
def trace_bundles(table, nearness, zones, directions, points, slopes, rims):
    """Forward bundles of n axis points into points, slopes (n, a, k, 2) on the plane of the last vertex (mm, mm/mm).

    nearness (n,): 1/mm; directions (n, a, 2); zones (k,): heights over the marginal heights, which rims (n, a)
    receives.
    """
    for i in range(nearness.shape[0]):
        for j in range(directions.shape[1]):
            across, up = directions[i, j, 0], directions[i, j, 1]
            rims[i, j] = marginal_height(table, nearness[i], True, across, up)
            for k in range(zones.shape[0]):
                x, y, slope_x, slope_y, _ = trace_axial(table, zones[k] * rims[i, j], nearness[i], True, across, up)
                points[i, j, k, 0], points[i, j, k, 1] = x, y
                slopes[i, j, k, 0], slopes[i, j, k, 1] = slope_x, slope_y


AZIMUTHS = 16           # of the marginal rays of a lens with tilted or decentred surfaces
RAYS, REACH = 1 << 15, 1.5      # of a lens that is dark along the axis; their disk over the rear rim


def working_f_number(lens: Lens, film_distance: float) -> float:
    """Working f-number 1 / (2 sin θ′) of the real marginal ray at the axis point of the film.

    All rims and the magnification count; blades count as a circle of as much area, within the rims.

    Args:
        lens: The lens. For a cylinder or toroid the result is the geometric mean of the sections, as the light is; with
            tilted or decentred surfaces that of AZIMUTHS directions, or, where they cut off the ray along the axis,
            that of a round pupil with as much light.
        film_distance: Last vertex → film (mm).
    Returns:
        The working f-number; inf if no ray passes, as the film's middle is dark.
    Raises:
        LensError: If the film is not behind the last vertex.
    """
    if not film_distance > 0.0:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    lens = lens.with_round_stop
    meridians = [(0.0, 1.0)] if lens.is_rotationally_symmetric else [(0.0, 1.0), (1.0, 0.0)]
    if not lens.is_centred:
        meridians = [(cos(turn), sin(turn)) for turn in (2.0 * pi * k / AZIMUTHS for k in range(AZIMUTHS))]
    sines = []
    for across, up in meridians:
        height = marginal_height(surface_table(lens), 1.0 / film_distance, False, across, up)
        sines.append(height / hypot(height, film_distance))
    if not lens.is_centred and not min(sines) > 0.0:
        return _by_light(lens, film_distance)
    sine = prod(sines) ** (1.0 / len(sines)) if len(sines) != 1 else sines[0]
    return 1.0 / (2.0 * sine) if sine > 0.0 else inf


def _by_light(lens: Lens, film_distance: float) -> float:
    """Working f-number of a round pupil with the light of the axis point of the film: E = π L / (2 N)²; inf if dark.

    By rays at equal areas of a disk on the plane of the last vertex.
    """
    rear, frame = lens.surfaces[-1], lens.frames[-1]
    reach = REACH * rear.semi_diameter + (0.0 if frame is None else float(hypot(*lens.vertex(-1)[:2])))
    turn, radius = pi * (3.0 - sqrt(5.0)) * np.arange(RAYS), reach * np.sqrt((np.arange(RAYS) + 0.5) / RAYS)
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    film = np.array([0.0, 0.0, lens.length + film_distance])
    ways = np.column_stack([x, y, np.full(RAYS, -film_distance)])
    passed = trace(lens.with_open_stop, film, ways).fate == Fate.PASSED
    cos2 = film_distance**2 / (film_distance**2 + radius**2)
    light = pi * reach**2 / film_distance**2 * float(np.where(passed, cos2**2, 0.0).mean())     # E / L
    return 0.5 * sqrt(pi / light) if light > 0.0 else inf


def surface_coatings(lens: Lens, coating: str | Coating = "uncoated") -> tuple[Coating, ...]:
    """The coating of each surface: its own, else the given one where it meets air, else none.

    coating: "uncoated", "single-layer", "multi-layer" (`COATINGS`) or any; CoatingError for another name.
    """
    usual, n = named_coating(coating), lens.indices()
    return tuple(surface.coating if surface.coating is not None else usual if 1.0 in n[i:i + 2] else BARE
                 for i, surface in enumerate(lens.surfaces))


def transmission(lens: Lens, wavelength: float | None = None, coating: str | Coating = "uncoated") -> float:
    """Transmitted part of the light on the axis: Π (1 − R), R the reflectance of each surface at normal incidence.

    Args:
        lens: The lens; absorption in the glass is neglected.
        wavelength: Micrometres; None: the lens's `reference_wavelength`.
        coating: As of `surface_coatings`.
    Returns:
        From 0 to 1.
    Raises:
        CoatingError: For an unknown coating.
    """
    wavelength = lens.reference_wavelength if wavelength is None else wavelength
    n = lens.indices(wavelength)
    return prod(_passed(own, before, after, wavelength)
                for own, before, after in zip(surface_coatings(lens, coating), n[:-1], n[1:], strict=True)
                if before != after)


@lru_cache(maxsize=1024)
def _passed(coating: Coating, before: float, after: float, wavelength: float) -> float:
    """Part of the light that passes a coated surface on the axis; it does not depend on focus and aperture."""
    return 1.0 - float(coating.reflectance(before, after, wavelength=wavelength).mean)


def t_number(lens: Lens, coating: str | Coating = "uncoated", wavelength: float | None = None) -> float:
    """f-number of a lens without losses that passes as much light.

    It is N / √(transmission · that of a picture in the stop), N the f-number for an object at infinity.

    Args:
        lens: The lens.
        coating: As of `surface_coatings`.
        wavelength: Micrometres, of the f-number and the transmission; None: the lens's `reference_wavelength`.
    Returns:
        The T-number.
    """
    iris = lens.iris
    passed = transmission(lens, wavelength, coating) * iris.area / (pi * iris.equivalent_radius**2)
    return first_order(lens, wavelength).f_number / sqrt(passed)
