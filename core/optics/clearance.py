"""Clearance of rays at the rims of a lens: the greatest r / semi-diameter on the way; a ray passes if it is ≤ 1.

A ray is given by its film point and its point on the plane of the last vertex, mm. The film in line lies film_distance
behind that plane, and a film point film_z behind the film in line. Rays are traced in blocks, in float64 or, where an
error of a thousandth is acceptable, in float32, which is three times as fast. Lens frame.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from lensbench.kernels.block import CLEARANCE, KEYS, B, L, M, N, X, Y, Z, lane_buffer, rows
from lensbench.kernels.cache import njit
from lensbench.kernels.program import Code, Program, run_steps
from lensbench.optics.block_trace import surface_steps
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens

SINGLE = 1.2e-5             # greatest error of a clearance in float32, for a stop as large as the rear surface


class ClearanceTracer(NamedTuple):
    """Lane buffer, code of a `Program` and key that trace rays of one lens and film, in float64 and in float32.

    error: of a clearance in float32.
    """

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
    """Clearances of the rays from (film_x, film_y, film_z) to (px, py), mm, into out (n,); inf for those that are lost.

    distance: last vertex → film_z = 0 (mm). accuracy: acceptable error; 0 for float64.
    """
    if tracer.error <= accuracy:
        _trace(film_x, film_y, film_z, px, py, distance, out, *tracer.single)
    else:
        _trace(film_x, film_y, film_z, px, py, distance, out, *tracer.double)
