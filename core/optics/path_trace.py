"""Block trace from the scene to the film with optical path lengths, and with the surface that ends each ray.

The surfaces are those of `block_trace`; a step behind each adds to the path and looks at the clearance. Rays that a rim
ends are traced to their end all the same, so that what a pupil function needs is smooth across its rim.

Camera frame in and out: mm, the film's centre at the origin, the scene at −z. Directions are optical on leaving: (L, M,
N) has the length of the index on the film's side.
"""

from lensbench.kernels.block import (
    CLEARANCE,
    H0,
    H1,
    H2,
    H3,
    H4,
    H5,
    H6,
    H7,
    H8,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.optics.block_refraction import GAP, RIM
from lensbench.optics.block_trace import (
    change_frame,
    check_travel,
    enter_lens,
    leave_lens,
    scale_directions,
    surface_records,
)
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens

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

    film_distance: last vertex → film (mm). wavelength: µm. PATH adds to what the row holds. CLEARANCE is the greatest
    (r / semi-diameter)² on the way, and the blades of the stop count in it.
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
