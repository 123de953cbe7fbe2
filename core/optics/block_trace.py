"""The block tracer: rays through every surface of a lens, in either direction, as steps of a program.

Camera frame in and out: mm, the film's centre at the origin, the scene at −z. Between `enter_lens` and `leave_lens` the
stages of `block_refraction` work in the frame of the last vertex met, z running with the light; tilted and decentred
surfaces are met in a frame of their own (`change_frame`). `surface_steps` leads from the film or from the scene.
`path_steps` also gives optical path lengths and the surface that stops each ray, and traces blocked rays to their end,
so that a pupil function is smooth across its edge. `clearances` are the greatest r / semi-diameter on the way (lens
frame): a ray passes if it is ≤ 1. In float32, to a thousandth, they are three times as fast.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.block import (
    CLEARANCE, H0, H1, H2, H3, H4, H5, H6, H7, H8, KEYS, WEIGHT, B, L, M, N, Step, X, Y, Z, lane_buffer, offsets, pack,
    rows, stage
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Code, Program, run_steps
from lensbench.core.optics.block_refraction import BEND, CURVATURE, GAP, LEAST, RIM, RUNS, SLOWNESS, STEP
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LENS_FRAME, Frame
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surfaces import UNIT

# Parameters of `enter_lens` and `leave_lens`
SIGN, END = range(2)                    # 1 towards the film, −1 towards the scene; z of the last vertex along the light

# Parameters of `change_frame`: a rotation, row by row, and a shift (mm)
_, SHIFT, FRAME = offsets(9, 3)


@stage
def enter_lens(lanes, p, ints, key):
    """From the camera frame to z along the light, with no rim met. p: SIGN."""
    real = lanes.dtype.type
    row = rows(lanes)
    z, n, clearance = row[Z], row[N], row[CLEARANCE]
    sign = p[SIGN]
    for i in range(B):
        z[i] *= sign
        n[i] *= sign
        clearance[i] = real(0)


@stage
def leave_lens(lanes, p, ints, key):
    """Back to the camera frame from the last vertex. p: SIGN, END.

    CLEARANCE is then the greatest (r / semi-diameter)² on the way, inf for a ray that turns back, misses a surface or
    meets it beyond its equator. Where it is not ≤ 1, WEIGHT becomes 0.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    z, n, weight, clearance = row[Z], row[N], row[WEIGHT], row[CLEARANCE]
    sign, end = p[SIGN], p[END]
    for i in range(B):
        z[i] = (z[i] + end) * sign
        n[i] *= sign
        weight[i] = weight[i] if clearance[i] <= real(1) else real(0)


@stage
def change_frame(lanes, p, ints, key):
    """Into the frame of tilted surfaces, or back: point and direction, from the last vertex met as before."""
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    xx, xy, xz, yx, yy, yz, zx, zy, zz = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]
    a, b, c = p[SHIFT], p[SHIFT + 1], p[SHIFT + 2]
    for i in range(B):
        x, y, z, l, m, n = X_[i], Y_[i], Z_[i], L_[i], M_[i], N_[i]
        X_[i], Y_[i], Z_[i] = xx * x + xy * y + xz * z + a, yx * x + yy * y + yz * z + b, zx * x + zy * y + zz * z + c
        L_[i], M_[i], N_[i] = xx * l + xy * m + xz * n, yx * l + yy * m + yz * n, zx * l + zy * m + zz * n


@stage
def check_travel(lanes, p, ints, key):
    """Lose the rays that run against the light: CLEARANCE becomes inf. p: the lens's axis along it, in their frame."""
    real = lanes.dtype.type
    row = rows(lanes)
    l, m, n, clearance = row[L], row[M], row[N], row[CLEARANCE]
    a, b, c = p[0], p[1], p[2]
    for i in range(B):
        clearance[i] = clearance[i] if a * l[i] + b * m[i] + c * n[i] > real(0) else real(np.inf)


class SurfaceRecord(NamedTuple):
    """A surface as the light meets it."""

    surface: int
    kernel: Any                 # stage of its kind
    numbers: np.ndarray         # its record among the parameters of that stage
    move: np.ndarray | None     # parameters of `change_frame` from the frame of the surface before, or None in the same
    axis: np.ndarray | None     # parameters of `check_travel` behind a tilted surface; None for others


class Records(NamedTuple):
    """The surfaces of a lens in the order met."""

    surfaces: list[SurfaceRecord]
    move: np.ndarray | None     # parameters of `change_frame` behind the last one, back into the lens frame
    sign: float                 # 1 towards the film, −1 towards the scene
    end: float                  # z of the last vertex along the light (mm)


def surface_records(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
                    which: slice = slice(None)) -> Records:
    """The surfaces of a lens as the stages of the block tracer read them; the arguments are those of `surface_steps`.

    Tilted or decentred surfaces that move as one are met in their common frame.
    """
    indices, vertices = lens.indices(wavelength), lens.vertices
    sceneward = towards == "scene"
    sign = -1.0 if sceneward else 1.0
    mirror = np.array([1.0, 1.0, sign])
    end, frame = 0.0, LENS_FRAME
    records: list[SurfaceRecord] = []

    def move_to(other: Frame) -> np.ndarray | None:
        """Change the frame; the last vertex met stays the origin of z, which runs with the light."""
        nonlocal frame
        if other is frame:
            return None
        moved, frame = frame.into(other), other
        z = sign * end + lens.length + film_distance                # of the last vertex met, lens frame
        shift = mirror * (moved.shift + z * (moved.rotation[:, 2] - [0.0, 0.0, 1.0]))
        return np.concatenate([(mirror[:, None] * moved.rotation * mirror).ravel(), shift])

    for i in (range(len(vertices) - 1, -1, -1) if sceneward else range(len(vertices)))[which]:
        surface = lens.surfaces[i]
        kind, numbers = surface.shape
        before, after = (indices[i + 1], indices[i]) if sceneward else (indices[i], indices[i + 1])
        z, c = sign * (vertices[i] - lens.length - film_distance), sign * surface.curvature
        run = RUNS[kind]
        fields = {GAP: z - end, CURVATURE: c, RIM: numbers[UNIT],
                  SLOWNESS: before**-2, STEP: after**2 - before**2, BEND: before**2 * c, **run.columns(numbers, sign)}
        posed, axis = lens.frames[i], None
        if sceneward and i == 0:                                    # a fisheye may see beyond 90°
            fields[LEAST] = -np.inf
        elif posed is not None and posed.rotation[2, 2] < 1.0:      # tilted: N is not that along the axis of the lens
            fields[LEAST], axis = -np.inf, sign * mirror * LENS_FRAME.into(posed).rotation[:, 2]
        records.append(SurfaceRecord(i, run.stage, pack(run.length, fields), move_to(posed or LENS_FRAME), axis))
        end = z
    return Records(records, move_to(LENS_FRAME), sign, end)


def surface_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
                  which: slice = slice(None), at_stop: Sequence[Step] = ()) -> list[Step]:
    """Steps that trace the surfaces of a lens, with a circular stop.

    film_distance: last vertex → film (mm). wavelength: µm. towards: "scene" (from the film), or "film" (from the
    scene). which: of the surfaces in that order. at_stop: steps behind the stop, in its frame. A ray ends on the last
    surface. Between two parts, and in front of the lens, a direction has the length of the index there.
    """
    records = surface_records(lens, film_distance, wavelength, towards, which)
    steps = [Step(enter_lens, [records.sign])]
    run: list[SurfaceRecord] = []                       # of one kind, in one frame

    def close_run() -> None:
        """Append the step of the run."""
        if run:
            steps.append(Step(run[0].kernel, np.concatenate([record.numbers for record in run])))
            run.clear()

    for record in records.surfaces:
        if record.move is not None or run and record.kernel is not run[0].kernel:
            close_run()
        if record.move is not None:
            steps.append(Step(change_frame, record.move))
        run.append(record)
        if record.axis is not None:
            close_run()
            steps.append(Step(check_travel, record.axis))
        if at_stop and record.surface == lens.stop_index:
            close_run()
            steps += at_stop
    close_run()
    if records.move is not None:
        steps.append(Step(change_frame, records.move))
    return [*steps, Step(leave_lens, [records.sign, records.end])]


@stage
def scale_directions(lanes, p, ints, key):
    """The direction multiplied by p[0]: between unit vectors and vectors of the length of the index."""
    row = rows(lanes)
    l, m, n = row[L], row[M], row[N]
    factor = p[0]
    for i in range(B):
        l[i], m[i], n[i] = l[i] * factor, m[i] * factor, n[i] * factor


def trace_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
                blades: bool = True) -> list[Step]:
    """Steps that trace a lens between unit vectors, with the blades of its stop; the others as of `surface_steps`."""
    blocking = lens.iris.blocking(lens.stop.semi_diameter) if blades else []
    steps = surface_steps(lens, film_distance, wavelength, towards, at_stop=blocking)
    n = lens.front_index
    if n == 1.0:
        return steps
    return [*steps, Step(scale_directions, [1.0 / n])] if towards == "scene" else [Step(scale_directions, [n]), *steps]


PATH = H6               # optical path length (mm) from the given one, Σ n × length, to the last surface
VICTIM = H7             # index of the surface whose rim ends the ray, or that it misses; −1 if it passes
STOP_SHARE = H8         # (r / semi-diameter)² at the stop, NaN for a ray lost before it

# Parameters of `add_path`
AT_GAP, AT_SURFACE, AT_RIM = range(3)   # mm from the vertex before; index of the surface; 1 / h² at the stop, else 0


@stage
def keep_ray(lanes, p, ints, key):
    """Keep the ray as it comes into the lens, or into another frame: the path goes on from there."""
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    x0, y0, z0, l0, m0, n0 = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        x0[i], y0[i], z0[i] = x[i], y[i], z[i]
        l0[i], m0[i], n0[i] = l[i], m[i], n[i]


@stage
def begin_path(lanes, p, ints, key):
    """Nothing has ended the ray."""
    real = lanes.dtype.type
    victim = rows(lanes)[VICTIM]
    for i in range(B):
        victim[i] = real(-1)


@stage
def add_path(lanes, p, ints, key):
    """Path to this surface: the product of the way and the optical direction before it.  p: AT_GAP … AT_RIM."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    x0, y0, z0, l0, m0, n0 = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    path, victim, share, clearance = row[PATH], row[VICTIM], row[STOP_SHARE], row[CLEARANCE]
    gap, surface, rim = p[AT_GAP], p[AT_SURFACE], p[AT_RIM]
    at_stop = rim > real(0)
    for i in range(B):
        path[i] += (x[i] - x0[i]) * l0[i] + (y[i] - y0[i]) * m0[i] + (z[i] - z0[i] + gap) * n0[i]
        x0[i], y0[i], z0[i] = x[i], y[i], z[i]
        l0[i], m0[i], n0[i] = l[i], m[i], n[i]
        lives = (clearance[i] <= real(1)) | (victim[i] >= real(0))
        victim[i] = victim[i] if lives else surface
        share[i] = (x[i] * x[i] + y[i] * y[i]) * rim if at_stop else share[i]


def path_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> list[Step]:
    """Steps that trace unit vectors from the scene to the last surface, with PATH, VICTIM and STOP_SHARE.

    film_distance: last vertex → film (mm). wavelength: µm. PATH adds to what the row holds. CLEARANCE includes the
    blades.
    """
    records = surface_records(lens, film_distance, wavelength, "film")
    blocking = lens.iris.blocking(lens.stop.semi_diameter)
    steps = [] if lens.front_index == 1.0 else [Step(scale_directions, [lens.front_index])]
    steps += [Step(enter_lens, [records.sign]), Step(keep_ray), Step(begin_path)]
    for surface, kernel, numbers, move, axis in records.surfaces:
        if move is not None:
            steps += [Step(change_frame, move), Step(keep_ray)]
        is_stop = surface == lens.stop_index
        steps += [Step(kernel, numbers), *([] if axis is None else [Step(check_travel, axis)]),
                  *(blocking if is_stop else []),
                  Step(add_path, [numbers[GAP], surface, numbers[RIM] if is_stop else 0.0])]
    if records.move is not None:
        steps.append(Step(change_frame, records.move))
    return [*steps, Step(leave_lens, [records.sign, records.end])]


SINGLE = 1.2e-5             # greatest error of a clearance in float32, for a stop as large as the rear surface


class ClearanceTracer(NamedTuple):
    """Lane buffer, code and key that trace rays of a lens in float64 and float32; error of a clearance in float32."""

    double: tuple[Any, ...]
    single: tuple[Any, ...]
    error: float


def clearance_tracer(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> ClearanceTracer:
    """A tracer for one thread, since it owns its lane buffers. film_distance: mm; wavelength: µm."""
    double, single = ((lane_buffer(real), code, np.zeros(KEYS, np.uint32))
                      for real, code in zip((np.float64, np.float32), _codes(lens, film_distance, wavelength),
                                            strict=True))
    return ClearanceTracer(double, single, SINGLE * max(1.0, lens.surfaces[-1].semi_diameter / lens.stop.semi_diameter))


@lru_cache(maxsize=8)
def _codes(lens: Lens, film_distance: float, wavelength: float) -> tuple[Code, Code]:
    """The surfaces as the driver reads them, for float64 and float32 lanes: tracers of many pixels share them."""
    steps = surface_steps(lens, film_distance, wavelength)
    return Program(steps, np.float64).code, Program(steps, np.float32).code


@njit(cache=True, error_model="numpy", nogil=True)
def _trace(film_x, film_y, film_z, px, py, distance, out, lanes, code, key):
    """The clearances of the rays from film points to (px, py), block by block, into out (n,)."""
    n, real = out.size, lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, o, clearance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    for start in range(0, n, B):
        count = min(B, n - start)
        for i in range(count):
            dx, dy = px[start + i] - film_x[start + i], py[start + i] - film_y[start + i]
            away = distance + film_z[start + i]
            size, ahead = 1.0 / math.sqrt(dx * dx + dy * dy + away * away), film_z[start + i] / away
            x[i], y[i], z[i] = real(film_x[start + i] + ahead * dx), real(film_y[start + i] + ahead * dy), real(0)
            l[i], m[i], o[i] = real(dx * size), real(dy * size), real(-away * size)
        for i in range(count, B):           # fill the block with copies of the last ray
            x[i], y[i], z[i], l[i], m[i], o[i] = x[i - 1], y[i - 1], z[i - 1], l[i - 1], m[i - 1], o[i - 1]
        run_steps(lanes, code, key)
        for i in range(count):
            out[start + i] = math.sqrt(clearance[i]) if clearance[i] < math.inf else math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def clearances(film_x, film_y, film_z, px, py, distance, out, tracer, accuracy):
    """Clearances of the rays from (film_x, film_y, film_z) to (px, py), mm, into out (n,); inf for those that miss.

    distance: last vertex → film_z = 0 (mm). accuracy: acceptable error; 0 for float64.
    """
    if tracer.error <= accuracy:
        _trace(film_x, film_y, film_z, px, py, distance, out, *tracer.single)
    else:
        _trace(film_x, film_y, film_z, px, py, distance, out, *tracer.double)
