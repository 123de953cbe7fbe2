"""Chief rays of many fields at once: rays from the middle of the stop to both sides.

Lengths in mm, lens frame. A chief ray is given by its direction at the stop, which determines the point of the scene
that it comes from as well as the point of the film that it meets. For a rotationally symmetric lens one meridian holds
all of them: it is sampled once, and each field's place in it found by the secant rule. Other lenses take Newton's
method in two directions. Rims do not end chief rays.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isinf, pi

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import PASSED, surface_table, trace_ray
from lensbench.core.optics.surfaces import SurfaceTable

SAMPLES = 513           # directions at the stop, in which fields are bracketed
STEEPEST = 0.4999 * pi  # of them, rad
ITERATIONS = 8          # of the secant rule, from a bracket of 3 mrad
HALVINGS = 40           # of the last stretch of the field
NEWTON = 30             # iterations for a lens without rotational symmetry
SLOPE_STEP = 1e-6       # rad, for its derivatives
NEIGHBOUR = 1e-5        # direction cosine at the stop, of the chief rays beside one
FARTHEST = 10.0         # × the size of the lens, of an entrance pupil from the first surface
ROUNDING = 1e-14        # of an angle (rad), or over the size of the lens of a length


@dataclass(frozen=True, eq=False)
class ChiefRays:
    """Chief rays of n fields at one wavelength; NaN where a field has none.

    Args:
        at_stop: (n, 2) x and y of the unit direction at the stop, before the stop's own refraction.
        points, directions: (n, 3) point on the first surface, or in the stop where the lens begins with it, and unit
            direction in the scene, along the light.
        images, image_directions: (n, 2) x and y on the film, and (n, 3) unit direction there.
    """

    at_stop: np.ndarray
    points: np.ndarray
    directions: np.ndarray
    images: np.ndarray
    image_directions: np.ndarray

    @property
    def angles(self) -> np.ndarray:
        """(n, 2) angle from the axis in the scene, as a vector along the azimuth of the direction, rad."""
        return _angles(self.directions)


def shoot(lens: Lens, film_distance: float, at_stop: np.ndarray, table: SurfaceTable) -> ChiefRays:
    """The chief rays of these directions at the stop, x and y (n, 2) of unit vectors; table: of the scalar tracer."""
    made = np.empty((5, len(at_stop), 3))
    stop = lens.stop_index
    _shoot(table.part(0, stop), table.part(stop, len(lens.surfaces)), lens.vertex(stop),
           lens.length + film_distance, np.ascontiguousarray(at_stop), made)
    start, points, directions, images, image_directions = made
    return ChiefRays(start[:, :2].copy(), points, directions, images[:, :2].copy(), image_directions)


def pupil_distances(lens: Lens, film_distance: float, chief: ChiefRays, wavelength: float) -> np.ndarray:
    """(F,) distance along each chief ray from its point to the entrance pupil of the field, where neighbours cross it.

    0 where no neighbour is known; at most FARTHEST × the size of the lens.
    """
    table = surface_table(lens, wavelength)
    product, square = np.zeros((2, len(chief.points)))
    for step in NEIGHBOUR * np.eye(2):
        beside = shoot(lens, film_distance, chief.at_stop + step, table)
        apart, turned = beside.points - chief.points, beside.directions - chief.directions
        apart = apart - (apart * chief.directions).sum(1)[:, None] * chief.directions
        product += (apart * turned).sum(1)
        square += (turned * turned).sum(1)
    most = FARTHEST * (lens.length + lens.surfaces[0].semi_diameter)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.nan_to_num(np.clip(-product / square, -most, most))


@njit(cache=True, nogil=True, error_model="numpy")
def _shoot(before, behind, position, film_z, at_stop, made):
    """Chief rays of directions at the stop (n, 2) into made (5, n, 3): the fields of ChiefRays; NaN for a lost ray.

    before, behind: tables of the scalar tracer, up to the stop and from it on; position (3,) of the middle of the
    stop, film_z: of the film, lens frame, mm.
    """
    for i in range(at_stop.shape[0]):
        l, m = at_stop[i, 0], at_stop[i, 1]
        square = 1.0 - l * l - m * m
        good = square > 0.0
        if good:
            n = np.sqrt(square)
            x, y, z, dx, dy, dz = position[0], position[1], position[2], -l, -m, -n
            if before.kinds.size > 0:
                x, y, z, dx, dy, dz, fate, surface = trace_ray(
                    before, False, position[0], position[1], position[2], -l, -m, -n, None, i, -1)
                good = fate == PASSED
            u, v, w, du, dv, dw, fate, surface = trace_ray(
                behind, False, position[0], position[1], position[2], l, m, n, None, i, 1)
            good = good and fate == PASSED
        if not good:
            made[:, i] = np.nan
            continue
        away = (film_z - w) / dw
        made[0, i, 0], made[0, i, 1], made[0, i, 2] = l, m, n
        made[1, i, 0], made[1, i, 1], made[1, i, 2] = x, y, z
        made[2, i, 0], made[2, i, 1], made[2, i, 2] = -dx, -dy, -dz
        made[3, i, 0], made[3, i, 1], made[3, i, 2] = u + away * du, v + away * dv, film_z
        made[4, i, 0], made[4, i, 1], made[4, i, 2] = du, dv, dw


def find_chief_rays(lens: Lens, film_distance: float, aims: np.ndarray, object_distance: float = inf,
                    by_image: bool = False, wavelength: float = D_LINE, near: np.ndarray | None = None) -> ChiefRays:
    """The chief rays of fields.

    Args:
        lens: The lens.
        film_distance: Last vertex → film, mm.
        aims: (n, 2) points of the film, mm, where by_image; otherwise points of the object plane, mm, or for an
            object at infinity the angle vectors of its light (rad).
        object_distance: Object plane → first vertex, mm; inf for an object at infinity.
        by_image: Which of them `aims` holds.
        wavelength: µm.
        near: (n, 2) directions at the stop close to those sought, such as those of another wavelength; saves the
            search.
    Returns:
        NaN for fields that no ray from the middle of the stop reaches.
    """
    aims = np.asarray(aims, float).reshape(-1, 2)

    def value(rays: ChiefRays) -> np.ndarray:
        """(n, 2) of a field, in the quantity and unit of `aims`."""
        if by_image:
            return rays.images
        if isinf(object_distance):
            return rays.angles
        with np.errstate(divide="ignore", invalid="ignore"):
            away = (-object_distance - rays.points[:, 2]) / rays.directions[:, 2]
        away = np.where(away < rays.points[:, 2] + 1e-9, away, np.nan)          # the object lies before the lens
        return rays.points[:, :2] + away[:, None] * rays.directions[:, :2]

    scale = 1.0 if isinf(object_distance) and not by_image else max(lens.length, abs(film_distance))
    table = surface_table(lens, wavelength)

    def rays(at_stop: np.ndarray) -> ChiefRays:
        return shoot(lens, film_distance, at_stop, table)

    small = ROUNDING * scale
    if not lens.is_rotationally_symmetric:
        return rays(_in_plane(rays, value, aims, small, near))
    return rays(_in_meridian(rays, value, aims, small) if near is None else
                _beside(rays, value, aims, small, near))


def _in_meridian(rays: Callable[[np.ndarray], ChiefRays], value: Callable[[ChiefRays], np.ndarray], aims: np.ndarray,
                 small: float) -> np.ndarray:
    """(n, 2) at the stop, by the secant rule along one meridian."""
    def reached(angle: np.ndarray) -> np.ndarray:
        return value(rays(np.column_stack([0.0 * angle, np.sin(angle)])))[:, 1]

    angles = np.linspace(0.0, STEEPEST, SAMPLES)
    heights = reached(angles)
    sign = 1.0 if heights[1] >= 0.0 else -1.0
    rises = np.append(True, np.diff(sign * heights) > 0.0)
    end = int(np.argmin(rises)) if not rises.all() else SAMPLES      # the field ends where it no longer grows
    size = np.hypot(aims[:, 0], aims[:, 1])
    after = np.searchsorted(sign * heights[:end], size, side="left")
    if 1 < end < SAMPLES and (after == end).any():      # the last stretch, up to the ray that is lost or turns
        low, high = angles[end - 1], angles[end]
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            reach = sign * reached(np.array([middle, max(low, middle - 1e-7)]))
            low, high = (middle, high) if reach[0] >= reach[1] else (low, middle)
        angles, heights = np.append(angles[:end], low), np.append(heights[:end], reached(np.array([low])))
        after = np.where(size <= sign * heights[-1], np.minimum(after, end), end + 1)
        end += 1
    lost = after >= end
    after = np.clip(after, 1, max(end - 1, 1))
    low, angle = angles[after - 1], angles[after]
    before, off_before, off = low.copy(), sign * heights[after - 1] - size, sign * heights[after] - size
    high = angle.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(ITERATIONS):
            if not (np.abs(off[~lost]) > small).any():
                break
            trial = np.clip(angle - off * (angle - before) / (off - off_before), low, high)
            trial = np.where(np.isfinite(trial), trial, angle)
            before, off_before = angle, off
            angle, off = trial, sign * reached(trial) - size
        angle = np.where(size == 0.0, 0.0, angle)
        along = np.where((size > 0.0)[:, None], aims / np.where(size > 0.0, size, 1.0)[:, None], [0.0, 1.0])
    return np.where(lost[:, None], np.nan, sign * np.sin(angle)[:, None] * along)


def _beside(rays: Callable[[np.ndarray], ChiefRays], value: Callable[[ChiefRays], np.ndarray], aims: np.ndarray,
            small: float, near: np.ndarray) -> np.ndarray:
    """(n, 2) at the stop in the meridians of `near`, by the secant rule from there."""
    size = np.hypot(near[:, 0], near[:, 1])
    along = np.where((size > 0.0)[:, None], near / np.where(size > 0.0, size, 1.0)[:, None], [0.0, 1.0])

    def off(angle: np.ndarray) -> np.ndarray:
        return ((value(rays(np.sin(angle)[:, None] * along)) - aims) * along).sum(1)

    angle = np.arcsin(size)
    before = angle * (1.0 + SLOPE_STEP)
    now, was = off(angle), off(before)
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(ITERATIONS):
            if not (np.abs(now) > small).any():
                break
            trial = angle - now * (angle - before) / (now - was)
            trial = np.where(np.isfinite(trial), trial, angle)
            before, was, angle = angle, now, trial
            now = off(angle)
    return np.sin(angle)[:, None] * along


def _in_plane(rays: Callable[[np.ndarray], ChiefRays], value: Callable[[ChiefRays], np.ndarray], aims: np.ndarray,
              small: float, near: np.ndarray | None) -> np.ndarray:
    """(n, 2) at the stop, by Newton's method from `near`, or the axis; a step that does not reduce the error is cut."""
    pupil, advance = np.zeros_like(aims), np.zeros_like(aims)
    if near is not None:
        pupil = np.where(np.isfinite(near), near, 0.0)
    error = np.full(len(aims), inf)
    for _ in range(NEWTON):
        trial = pupil + advance
        values, beside, above = (value(rays(trial + offset)) for offset in
                                 ([0.0, 0.0], [SLOPE_STEP, 0.0], [0.0, SLOPE_STEP]))
        off = values - aims
        size = np.hypot(off[:, 0], off[:, 1])
        better = size < error
        slopes = np.stack([beside - values, above - values], 2) / SLOPE_STEP
        determinant = slopes[:, 0, 0] * slopes[:, 1, 1] - slopes[:, 0, 1] * slopes[:, 1, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -np.stack([slopes[:, 1, 1] * off[:, 0] - slopes[:, 0, 1] * off[:, 1],
                              slopes[:, 0, 0] * off[:, 1] - slopes[:, 1, 0] * off[:, 0]], 1) / determinant[:, None]
        pupil[better], error[better] = trial[better], size[better]
        advance = np.where(better[:, None], step, 0.25 * advance)
        if not (error > small).any() or not (np.abs(advance) > 1e-16).any():
            break
    return np.where((error < 1e6 * small)[:, None], pupil, np.nan)


def _angles(directions: np.ndarray) -> np.ndarray:
    """(n, 2) angle vectors of unit directions (n, 3)."""
    across = np.hypot(directions[:, 0], directions[:, 1])
    size = np.arctan2(across, directions[:, 2])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((across > 0.0)[:, None], directions[:, :2] * (size / across)[:, None], directions[:, :2])
