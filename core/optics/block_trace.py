"""The block tracer: rays through every surface of a lens, in either direction.

Camera frame in and out: mm, the film's centre at the origin, the scene at −z. The steps between `enter_lens` and
`leave_lens` are those of `block_refraction`, in the frame of the last vertex met, where z runs with the light; surfaces
out of line are met in a frame of their own (`change_frame`).
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lensbench.kernels.block import CLEARANCE, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.layout import offsets, pack
from lensbench.optics.block_refraction import (
    BEND,
    CURVATURE,
    GAP,
    LEAST,
    RIM,
    RUNS,
    SLOWNESS,
    STEP,
)
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.optics.surface_pose import IN_LINE
from lensbench.optics.surfaces import UNIT

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

    CLEARANCE is then the greatest (r / semi-diameter)² on the way, inf for a ray that
    turns back, or that meets a surface beyond its equator or not at all. Where it is not ≤ 1, WEIGHT becomes 0.
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
    """Into the frame of surfaces out of line, or back: point and direction, from the last vertex met as before."""
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
                    part: slice = slice(None)) -> Records:
    """The surfaces of a lens as the stages of the block tracer read them; the arguments are those of `surface_steps`.

    Surfaces out of line that move as one are met in their common frame, in which the lens is in line.
    """
    indices, vertices = lens.indices(wavelength), lens.vertices
    sceneward = towards == "scene"
    sign = -1.0 if sceneward else 1.0
    mirror = np.array([1.0, 1.0, sign])
    end, frame = 0.0, IN_LINE
    found: list[SurfaceRecord] = []

    def move_to(other) -> np.ndarray | None:
        """Change the frame; the last vertex met stays the origin of z, which runs with the light."""
        nonlocal frame
        if other is frame:
            return None
        moved, frame = frame.into(other), other
        z = sign * end + lens.length + film_distance                # of the last vertex met, lens frame
        shift = mirror * (moved.shift + z * (moved.rotation[:, 2] - [0.0, 0.0, 1.0]))
        return np.concatenate([(mirror[:, None] * moved.rotation * mirror).ravel(), shift])

    for i in (range(len(vertices) - 1, -1, -1) if sceneward else range(len(vertices)))[part]:
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
            fields[LEAST], axis = -np.inf, sign * mirror * IN_LINE.into(posed).rotation[:, 2]
        found.append(SurfaceRecord(i, run.stage, pack(run.length, fields), move_to(posed or IN_LINE), axis))
        end = z
    return Records(found, move_to(IN_LINE), sign, end)


def surface_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
                  part: slice = slice(None), at_stop: Sequence[Step] = ()) -> list[Step]:
    """Steps that trace the surfaces of a lens, with a circular stop.

    film_distance: last vertex → film (mm). wavelength: µm. towards: "scene" (from the film), or "film" (from the
    scene). part: of the surfaces in that order. at_stop: steps behind the stop, in its frame. A ray ends on the last
    surface. Between two parts, and in front of the lens, a direction has the length of the index there.
    """
    records = surface_records(lens, film_distance, wavelength, towards, part)
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
    """Steps that trace a lens between unit vectors; the first four arguments are those of `surface_steps`.

    blades: whether the blades of the stop block rays, or its circle alone.
    """
    blocking = lens.iris.blocking(lens.stop.semi_diameter) if blades else []
    steps = surface_steps(lens, film_distance, wavelength, towards, at_stop=blocking)
    n = lens.front_index
    if n == 1.0:
        return steps
    return [*steps, Step(scale_directions, [1.0 / n])] if towards == "scene" else [Step(scale_directions, [n]), *steps]
