"""The reference tracer: exact rays through surfaces of every kind, one at a time, each with its fate.

Lengths in mm, in the lens frame: the first vertex is the origin and light travels
along +z, from scene to film. Rays may run in either direction. Inside the kernel directions are
optical: (p, q, r) has the length of the index of the medium.
"""

from dataclasses import dataclass
from enum import IntEnum
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surfaces import (
    AFTER, AXES, BEFORE, COLUMNS, CURVATURE, PLACE, RIM2, SPHERE, VERTEX, SurfaceTable, intersect
)


class Fate(IntEnum):
    """The end of a ray.

    PASSED: it leaves the lens. MISSED: it meets no point of the surface on the vertex's side of the equator,
    or none that Newton's method finds. CLIPPED: it meets the surface outside the rim.
    TOTAL_REFLECTION: it does not enter the next medium. BACKWARD: a refraction turned it against its travel, but for
    the last one on the way to the scene: a fisheye may see beyond 90°.
    """

    PASSED = 0
    MISSED = 1
    CLIPPED = 2
    TOTAL_REFLECTION = 3
    BACKWARD = 4


PASSED, MISSED, CLIPPED, TOTAL_REFLECTION, BACKWARD = (int(fate) for fate in Fate)
BEFORE_THE_LENS = -1


@dataclass(frozen=True, eq=False)
class Trace:
    """The results for n rays.

    Attributes:
        points: (n, 3) ndarray. Point on the last surface reached, or the origin if there is none (mm, lens frame).
        directions: (n, 3) ndarray. Unit vectors after the refraction there (lens frame); before it for a ray that was
            clipped or totally reflected.
        fate: (n,) ndarray of int. Values of `Fate`.
        surface: (n,) ndarray of int. Index of the last surface reached; −1 before the first.
        paths: (n, surfaces + 1, 3) ndarray or None. The origin, then the points in the order met (mm, lens frame), NaN
            after the end; None if not recorded.
    """

    points: np.ndarray
    directions: np.ndarray
    fate: np.ndarray
    surface: np.ndarray
    paths: np.ndarray | None = None


def trace(lens: Lens, origins: ArrayLike, directions: ArrayLike, wavelength: float = D_LINE,
          dtype: DTypeLike = np.float64, clip: bool = True, record: bool = False,
          forward: bool | None = None) -> Trace:
    """Rays through the whole lens, by the reference tracer (Welford, Aberrations of Optical Systems, ch. 4).

    Args:
        lens: The lens.
        origins: (n, 3) or (3,) array_like. Points of the rays (mm, lens frame); broadcast against `directions`.
        directions: (n, 3) or (3,) array_like. Directions of any length (lens frame).
        wavelength: Micrometres.
        dtype: float32 or float64, the precision of all arithmetic.
        clip: Whether rims, the stop and its blades end rays, and a picture in the stop where it is opaque.
        record: Whether to keep the paths.
        forward: True for light from the scene, False for light from the film, None to go by the sign of direction z. A
            fisheye that sees beyond 90° needs True or False: light may reach its first surface against +z. With None a
            ray with z = 0 is MISSED before the lens.
    Raises:
        ValueError: For arrays of other shapes, numbers that are not finite, a direction of length 0, or another dtype.
        GlassError: If a glass of the lens is not known at this wavelength.
    """
    real = np.dtype(dtype)
    if real not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise ValueError(f"dtype {real}: rays are traced in float32 or float64")
    starts, units = _rays(origins, directions)
    count, surfaces = len(starts), len(lens.surfaces)
    points, after = np.empty((count, 3), real), np.empty((count, 3), real)
    fate, surface = np.empty(count, np.int32), np.empty(count, np.int32)
    bladed = clip and not lens.iris.is_round
    paths = np.full((count, surfaces + 1, 3), np.nan, real) if record or bladed else None
    order = 0 if forward is None else 1 if forward else -1
    trace_rays(surface_table(lens, wavelength, real), clip, starts.astype(real), units.astype(real),
               points, after, fate, surface, paths, order)
    if bladed and paths is not None:
        _meet_blades(lens, (units[:, 2] if order == 0 else np.full(count, order)) > 0, points, after, fate, surface,
                     paths)
    return Trace(points, after, fate, surface, paths if record else None)


def _meet_blades(lens: Lens, forward: np.ndarray, points: np.ndarray, after: np.ndarray, fate: np.ndarray,
                 surface: np.ndarray, paths: np.ndarray) -> None:
    """End the rays that meet the blades of the stop; forward (n,): whether a ray runs from the scene."""
    for from_scene in (True, False):
        stop = 1 + (lens.stop_index if from_scene else len(lens.surfaces) - 1 - lens.stop_index)
        x, y, _ = (lens.in_frame_of(lens.stop_index, paths[:, stop]) / lens.stop.semi_diameter).T
        met = (forward == from_scene) & np.isfinite(x) & ~lens.iris.contains(x, y)
        met &= (fate != CLIPPED) | (surface != lens.stop_index)
        travel = paths[met, stop] - paths[met, stop - 1]
        points[met], after[met] = paths[met, stop], travel / np.linalg.norm(travel, axis=1)[:, None]
        fate[met], surface[met] = CLIPPED, lens.stop_index
        paths[met, stop + 1:] = np.nan


def surface_table(lens: Lens, wavelength: float = D_LINE, dtype: DTypeLike = np.float64) -> SurfaceTable:
    """The lens as the kernels read it (mm, lens frame), at a wavelength in µm; the numbers are a copy of their own."""
    known = lens.known.get(("surface table", wavelength))
    if known is None:
        known = lens.known["surface table", wavelength] = _surface_table(lens, wavelength)
    return SurfaceTable(known.kinds, known.posed, known.numbers.astype(dtype))


def _surface_table(lens: Lens, wavelength: float) -> SurfaceTable:
    n = lens.indices(wavelength)
    kinds, numbers = np.empty(len(lens.surfaces), np.int64), np.empty((len(lens.surfaces), COLUMNS))
    posed = np.zeros(len(lens.surfaces), np.bool_)
    for i, (surface, z) in enumerate(zip(lens.surfaces, lens.vertices, strict=True)):
        kinds[i], numbers[i] = surface.shape
        numbers[i, [VERTEX, RIM2, BEFORE, AFTER]] = z, surface.semi_diameter**2, n[i], n[i + 1]
        if (frame := lens.frames[i]) is not None:
            posed[i] = True
            numbers[i, PLACE:AXES], numbers[i, AXES:AXES + 9] = lens.vertex(i), frame.rotation.ravel()
    return SurfaceTable(kinds, posed, numbers)


@njit(inline="always")
def _into(numbers, i, x, y, z):
    """A vector of the lens frame in the frame of surface i, which is tilted or decentred."""
    return (numbers[i, AXES] * x + numbers[i, AXES + 3] * y + numbers[i, AXES + 6] * z,
            numbers[i, AXES + 1] * x + numbers[i, AXES + 4] * y + numbers[i, AXES + 7] * z,
            numbers[i, AXES + 2] * x + numbers[i, AXES + 5] * y + numbers[i, AXES + 8] * z)


@njit(inline="always")
def _out_of(numbers, i, x, y, z):
    """A vector of the frame of surface i in the lens frame."""
    return (numbers[i, AXES] * x + numbers[i, AXES + 1] * y + numbers[i, AXES + 2] * z,
            numbers[i, AXES + 3] * x + numbers[i, AXES + 4] * y + numbers[i, AXES + 5] * z,
            numbers[i, AXES + 6] * x + numbers[i, AXES + 7] * y + numbers[i, AXES + 8] * z)


@njit(cache=True, nogil=True, error_model="numpy")
def trace_ray(table, clip, x, y, z, dx, dy, dz, paths, ray, order):
    """One ray (origin, unit direction) → (x, y, z, dx, dy, dz, fate, surface).

    order: 1 from the first surface to the last, −1 back, 0 by the sign of dz. Welford's quotient from the foot of the
    perpendicular from the vertex: neither a flat surface nor a far origin causes cancellation. paths[ray] receives the
    points unless paths is None.
    """
    kinds, posed, numbers = table.kinds, table.posed, table.numbers
    count = kinds.size
    zero, one = numbers.dtype.type(0), numbers.dtype.type(1)
    forward = dz > zero if order == 0 else order > 0
    sign = one if forward else -one
    reached = BEFORE_THE_LENS
    if paths is not None:
        paths[ray, 0, 0], paths[ray, 0, 1], paths[ray, 0, 2] = x, y, z
    if dz == zero and order == 0:
        return x, y, z, dx, dy, dz, MISSED, reached

    first = 0 if forward else count - 1
    index = numbers[first, BEFORE] if forward else numbers[first, AFTER]
    p, q, r = index * dx, index * dy, index * dz
    for step in range(count):
        i = step if forward else count - 1 - step
        c, vertex = numbers[i, CURVATURE], numbers[i, VERTEX]
        index, index_after = numbers[i, BEFORE], numbers[i, AFTER]
        if not forward:
            index, index_after = index_after, index

        # End a ray that the last refraction turned against its travel
        if step > 0 and r * sign <= zero:
            return x, y, z, p / index, q / index, r / index, BACKWARD, reached

        # Take the frame of the surface: its vertex is the origin
        x_foot, y_foot, z_foot, l, m, n = x, y, z - vertex, p, q, r
        if posed[i]:
            x_foot, y_foot, z_foot = _into(numbers, i, x - numbers[i, PLACE], y - numbers[i, PLACE + 1],
                                           z - numbers[i, PLACE + 2])
            l, m, n = _into(numbers, i, p, q, r)

        # Move to the foot of the perpendicular from the vertex
        squared = index * index
        back = (l * x_foot + m * y_foot + n * z_foot) / squared
        x_foot, y_foot, z_foot = x_foot - back * l, y_foot - back * m, z_foot - back * n
        if step == 0:                                   # repeat: a far origin leaves a coarse rounding error
            back = (l * x_foot + m * y_foot + n * z_foot) / squared
            x_foot, y_foot, z_foot = x_foot - back * l, y_foot - back * m, z_foot - back * n

        # Intersect the surface
        if kinds[i] == SPHERE:
            F = c * (x_foot * x_foot + y_foot * y_foot + z_foot * z_foot) - z_foot - z_foot
            cos2_in = n * n - squared * c * F
            if not cos2_in >= zero:
                return x, y, z, p / index, q / index, r / index, MISSED, reached
            cos_in = sign * sqrt(cos2_in)
            t = F / (n + cos_in)
            z_hit = z_foot + t * n
            if not c * z_hit < one:
                return x, y, z, p / index, q / index, r / index, MISSED, reached
            x_hit, y_hit = x_foot + t * l, y_foot + t * m
            normal_x, normal_y, normal_z, steepness = -c * x_hit, -c * y_hit, one - c * z_hit, one
        else:
            x_hit, y_hit, z_hit, normal_x, normal_y, normal_z = intersect(
                table, i, x_foot, y_foot, z_foot, l, m, n, sign)
            if not z_hit == z_hit:
                return x, y, z, p / index, q / index, r / index, MISSED, reached
            steepness = normal_x * normal_x + normal_y * normal_y + normal_z * normal_z
            cos_in = (l * normal_x + m * normal_y + n * normal_z) / sqrt(steepness)
            cos2_in = cos_in * cos_in
        reached = i
        x, y, z = x_hit, y_hit, z_hit + vertex
        if posed[i]:
            x, y, z = _out_of(numbers, i, x_hit, y_hit, z_hit)
            x, y, z = x + numbers[i, PLACE], y + numbers[i, PLACE + 1], z + numbers[i, PLACE + 2]
        if paths is not None:
            paths[ray, step + 1, 0], paths[ray, step + 1, 1], paths[ray, step + 1, 2] = x, y, z

        # Clip at the rim
        if clip and x_hit * x_hit + y_hit * y_hit > numbers[i, RIM2]:
            return x, y, z, p / index, q / index, r / index, CLIPPED, reached

        # Refract
        cos2_out = cos2_in + (index_after - index) * (index_after + index)
        if not cos2_out >= zero:
            return x, y, z, p / index, q / index, r / index, TOTAL_REFLECTION, reached
        g = (sign * sqrt(cos2_out) - cos_in) / sqrt(steepness)
        p, q, r = l + g * normal_x, m + g * normal_y, n + g * normal_z
        if posed[i]:
            p, q, r = _out_of(numbers, i, p, q, r)

    index = numbers[count - 1, AFTER] if forward else numbers[0, BEFORE]
    return x, y, z, p / index, q / index, r / index, PASSED if r > zero or not forward else BACKWARD, reached


@njit(cache=True, nogil=True, error_model="numpy")
def trace_rays(table, clip, origins, directions, points, after, fate, surface, paths, order):
    """`trace_ray` for n rows into points, after (n, 3), fate, surface (n,), paths (n, surfaces + 1, 3) or None."""
    for i in range(origins.shape[0]):
        x, y, z, dx, dy, dz, fate[i], surface[i] = trace_ray(
            table, clip, origins[i, 0], origins[i, 1], origins[i, 2],
            directions[i, 0], directions[i, 1], directions[i, 2], paths, i, order)
        points[i, 0], points[i, 1], points[i, 2] = x, y, z
        after[i, 0], after[i, 1], after[i, 2] = dx, dy, dz


def _rays(origins: ArrayLike, directions: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions as contiguous (n, 3) in float64; ValueError for invalid ones."""
    starts = np.atleast_2d(np.asarray(origins, np.float64))
    vectors = np.atleast_2d(np.asarray(directions, np.float64))
    for name, rays in (("origins", starts), ("directions", vectors)):
        if rays.ndim != 2 or rays.shape[1] != 3:
            raise ValueError(f"{name} have the shape {rays.shape}: it must be (n, 3)")
        bad = ~np.isfinite(rays).all(axis=1)
        if bad.any():
            raise ValueError(f"{name}: row {int(np.argmax(bad))} contains a number that is not finite")
    lengths = np.hypot(np.hypot(vectors[:, 0], vectors[:, 1]), vectors[:, 2])
    if not lengths.all():
        raise ValueError(f"directions: row {int(np.argmin(lengths))} is zero")
    try:
        starts, vectors = np.broadcast_arrays(starts, vectors / lengths[:, None])
    except ValueError:
        raise ValueError(f"{len(starts)} origins and {len(vectors)} directions do not broadcast") from None
    return np.ascontiguousarray(starts), np.ascontiguousarray(vectors)
