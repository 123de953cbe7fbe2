"""Stages of an iris: samples of the disk become samples of its opening, and its blades block rays.

The shape is that of `iris.Iris`, which packs the parameters.
"""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    CLEARANCE,
    U0,
    U1,
    WEIGHT,
    B,
    X,
    Y,
    gather,
    rows,
    stage,
)

# Parameters of `map_to_iris`: chords, azimuth of the first corner (turns), then their ends: x of all, y of all
CHORDS, CORNER, ENDS = range(3)
# Parameters of `block_by_blades`: coefficient of r², then those of x and y for each blade
BULGE, SIDES = range(2)


@stage
def map_to_iris(lanes, p, ints, key):
    """Pupil samples U0, U1 of the whole disk become samples of the opening of an iris, by equal areas.

    The concentric map of the result fills the opening evenly.  p: as `iris._chords` gives them.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    u, v = row[U0], row[U1]
    chord, along, ax, ay, bx, by = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    n, begin = p[CHORDS], p[CORNER]
    count = np.int64(n)
    end_x, end_y = p[ENDS:], p[ENDS + count + 1:]
    # Azimuth of the sample in turns, by the concentric map; its chord and the position along it
    for i in range(B):
        a, b = real(2) * v[i] - real(1), real(2) * u[i] - real(1)
        steep = abs(b) > abs(a)
        far, near = (b, a) if steep else (a, b)
        safe = far if far != real(0) else real(1)
        quarter = (real(0.25) if steep else real(0)) + (real(0.5) if far < real(0) else real(0))
        turns = quarter + real(0.125) * (-near / safe if steep else near / safe) - begin
        position = (turns - np.floor(turns)) * n
        # The last chord where rounding makes n of it, and for NaN
        first = np.floor(position) if position < n else n - real(1)
        chord[i], along[i] = first, position - first
    # Ends of the chord
    gather(ax, end_x, chord)
    gather(bx, end_x[1:], chord)
    gather(ay, end_y, chord)
    gather(by, end_y[1:], chord)
    for i in range(B):
        a, b = abs(real(2) * v[i] - real(1)), abs(real(2) * u[i] - real(1))
        reach = a if a > b else b
        f = along[i]
        x, y = (ax[i] + f * (bx[i] - ax[i])) * reach, (ay[i] + f * (by[i] - ay[i])) * reach
        # Back to the square by the inverse concentric map; within an octant atan q = 2 atan(q / (1 + √(1 + q²)))
        steep = abs(y) > abs(x)
        far, near = (y, x) if steep else (x, y)
        q = near / (far if far != real(0) else real(1))
        q = q / (real(1) + math.sqrt(real(1) + q * q))
        s = q * q
        arctangent = q * (real(1) - s * (real(1 / 3) - s * (real(1 / 5) - s * (real(1 / 7) - s * (real(1 / 9) - s * (
            real(1 / 11) - s * (real(1 / 13) - s * (real(1 / 15) - s * real(1 / 17)))))))))
        out = math.sqrt(x * x + y * y)
        far = -out if far < real(0) else out
        near = arctangent * far * real(8 / math.pi)
        c, d = (near, far) if steep else (far, near)
        v[i], u[i] = real(0.5) + real(0.5) * c, real(0.5) + real(0.5) * d


@stage
def block_by_blades(lanes, p, ints, key):
    """Rays at the stop that meet the blades: WEIGHT becomes 0, and CLEARANCE greater than 1.

    p: BULGE, then the coefficients of x and y for each blade; a ray meets a blade where BULGE r² + a x + b y > 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, weight, clearance, most = row[X], row[Y], row[WEIGHT], row[CLEARANCE], row[A0]
    for i in range(B):
        most[i] = real(-1e30)
    for s in range(SIDES, p.size, 2):
        a, b = p[s], p[s + 1]
        for i in range(B):
            side = a * x[i] + b * y[i]
            most[i] = most[i] if most[i] >= side else side
    bulge = p[BULGE]
    for i in range(B):
        out = most[i] + bulge * (x[i] * x[i] + y[i] * y[i])
        clearance[i] = clearance[i] if clearance[i] >= out else out
        weight[i] = weight[i] if out <= real(1) else real(0)
