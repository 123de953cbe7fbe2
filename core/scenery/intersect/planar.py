"""Rectangles and disks, seen from both sides, plain or with a pattern: one stage for all of them.

A planar shape has a centre and two half-axes a and b at right angles; a point of its plane has u, v in [−1, 1] along
them. A pattern mixes two colours or is an image; it is chosen once for a block, never for a lane. A lane sees the
mean of the pattern over the footprint of its pixel; of an image, a reduction.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, BEAM, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, PIXEL_SIDE, PIXEL_SPREAD,
    RED, B, L, M, N, Packed, X, Y, Z, join, offsets, pack, rows, stage, vector
)
from lensbench.core.scenery.intersect.block_bounds import FORWARD, RIGHTWARD, UPWARD, beam_misses
from lensbench.core.scenery.intersect.spheres import inside_edge, plane_point
from lensbench.core.scenery.intersect.texture import (
    checker_contrast, filtered_contrast, footprint_stretch, line_coverage, look_up, parity, ripmap
)

# AXIS_U, AXIS_V: half-axes over their squared lengths (1/mm); HALF_U, HALF_V: lengths of the half-axes (mm); COLOUR2,
# COLUMNS, LINES, LINE: the pattern. An image follows
(CENTRE, NORMAL, AXIS_U, AXIS_V, HALF_U, HALF_V, COLOUR, EMISSION, OWN_FINISH, COLOUR2, COLUMNS, LINES, LINE,
 PLANAR) = offsets(3, 3, 3, 3, 1, 1, 3, 1, 1, 3, 1, 1, 1)
# Integers: how many numbers and integers a shape has; KIND of its pattern; IS_DISK: 1 for a disk, 0 for a rectangle.
# Those of an image follow
LENGTH, COUNT, KIND, IS_DISK, PLANAR_INTEGERS = range(5)
PLAIN, CHECKER, GRID, STAR, RULER, IMAGE = range(6)
KINDS = {"checker": CHECKER, "grid": GRID, "star": STAR, "ruler": RULER, "image": IMAGE}


def planar_parameters(shapes: Sequence[Any], emission: Sequence[float] | None = None,
                      specular: Sequence[Any] | None = None) -> Packed:
    """Parameters of the stage `planar`, shape after shape.

    emission: value of the row EMITS for each shape; by default 1 where it shines and 0 elsewhere. specular: the same
    shapes with the images that other paths than DIRECT ones see.
    """
    emission = [float(o.material.shines) for o in shapes] if emission is None else emission
    packed = []
    for o, emits, other in zip(shapes, emission, shapes if specular is None else specular, strict=True):
        fields, pattern = fields_of(o, emits), o.material.pattern
        kind, image = PLAIN, []
        if pattern is not None:
            kind = KINDS[pattern.kind]
            fields |= {COLOUR2: pattern.colour, COLUMNS: pattern.columns, LINES: pattern.rows, LINE: pattern.line}
            if pattern.image is not None:
                shown = other.material.pattern
                image = ripmap(pattern.image.values).packed(*([] if shown == pattern else [ripmap(shown.image.values)]))
        sizes = [PLANAR + sum(level.parameters.size for level in image),
                 PLANAR_INTEGERS + sum(np.size(level.integers) for level in image)]
        packed += [Packed(pack(PLANAR, fields), [*sizes, kind, o.round]), *image]
    return join(*packed)


def fields_of(shape: Any, emission: float) -> dict[int, Any]:
    """The numbers of a planar shape without its pattern."""
    centre, a, b, normal = shape.frame
    return {CENTRE: centre, NORMAL: normal, AXIS_U: a / (a @ a), AXIS_V: b / (b @ b), HALF_U: math.sqrt(a @ a),
            HALF_V: math.sqrt(b @ b), COLOUR: shape.material.colour, EMISSION: emission,
            OWN_FINISH: shape.material.finish()}


@stage
def planar(lanes, p, ints, key):
    """Intersect rays with planar shapes, after `beam`; the nearest surface stays.  p, ints: planar_parameters."""
    s, k = 0, 0
    while s < p.size:
        q, kind, is_disk, image = p[s:s + ints[k + LENGTH]], ints[k + KIND], ints[k + IS_DISK], k + PLANAR_INTEGERS
        s, k = s + q.size, k + ints[k + COUNT]
        if meet(lanes, q, is_disk) == 0:
            continue
        if kind == PLAIN:
            _paint(lanes, q)
            continue
        footprint(lanes, q)
        if kind == IMAGE:
            look_up(lanes, q[PLANAR:], ints[image:k])
            paint_image(lanes, q[COLOUR:])
            continue
        if kind == CHECKER:
            _checker(lanes, q)
        elif kind == GRID:
            _grid(lanes, q)
        elif kind == STAR:
            _star(lanes, q)
        else:
            _ruler(lanes, q)
        _mix(lanes, q)


@stage
def plain_planar(lanes, p, ints, key):
    """What `planar` does, for shapes without patterns: a third of its code, for the first picture of many scenes."""
    s, k = 0, 0
    while s < p.size:
        q, is_disk = p[s:s + ints[k + LENGTH]], ints[k + IS_DISK]
        s, k = s + q.size, k + ints[k + COUNT]
        if meet(lanes, q, is_disk) > 0:
            _paint(lanes, q)


@stage
def meet(lanes, q, is_disk):
    """Intersect rays with the shape q, and record the surface but its colour. Returns the number of rays that see it.

    is_disk: 1 for a disk, 0 for a rectangle. A0, A1, A2 as `intersect` leaves them, unless no ray sees it.
    """
    bounds = rows(lanes)[BEAM]
    u2, v2 = q[HALF_U] * q[HALF_U], q[HALF_V] * q[HALF_V]
    if beam_misses(bounds, q[CENTRE], q[CENTRE + 1], q[CENTRE + 2], _half(bounds, FORWARD, q, u2, v2),
                   _half(bounds, UPWARD, q, u2, v2), _half(bounds, RIGHTWARD, q, u2, v2)):
        return np.int32(0)
    crossed = intersect(lanes, q, is_disk)
    if crossed > 0:
        record(lanes, q)
    return crossed


@stage
def _half(bounds, k, q, u2, v2):
    """Half-width of a shape q along the beam's axis at k; u2, v2: squared lengths of its half-axes."""
    (bx, by, bz), (ax, ay, az), (cx, cy, cz) = vector(bounds, k), vector(q, AXIS_U), vector(q, AXIS_V)
    return abs(bx * ax + by * ay + bz * az) * u2 + abs(bx * cx + by * cy + bz * cz) * v2


@stage
def intersect(lanes, q, is_disk):
    """A0: distance to the shape q where it is the nearest surface, else 0; A1, A2: u and v there.

    is_disk: 1 for a disk, 0 for a rectangle.

    Returns the number of rays that meet it.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    met, u, v = row[A0], row[A1], row[A2]
    (cx, cy, cz), (ux, uy, uz) = vector(q, CENTRE), vector(q, NORMAL)
    (ax, ay, az), (bx, by, bz), disk = vector(q, AXIS_U), vector(q, AXIS_V), real(is_disk)
    crossed = np.int32(0)
    for i in range(B):
        t, qa, qb = plane_point(x[i] - cx, y[i] - cy, z[i] - cz, dx[i], dy[i], dz[i], ux, uy, uz,
                                ax, ay, az, bx, by, bz)
        hit = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < depth[i])
        met[i], u[i], v[i] = t if hit else real(0), qa, qb
        crossed = np.int32(crossed + np.int32(hit))
    return crossed


@stage
def record(lanes, q):
    """Distance, normal, emission and gloss of the shape q where a ray meets it (A0)."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, met = row[L], row[M], row[N], row[A0]
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    (ux, uy, uz), emission, own_finish = vector(q, NORMAL), q[EMISSION], q[OWN_FINISH]
    for i in range(B):
        t = met[i]
        hit = t > real(0)
        side = real(-1) if dx[i] * ux + dy[i] * uy + dz[i] * uz > real(0) else real(1)
        depth[i] = t if hit else depth[i]
        nx[i] = side * ux if hit else nx[i]
        ny[i] = side * uy if hit else ny[i]
        nz[i] = side * uz if hit else nz[i]
        emits[i] = emission if hit else emits[i]
        finish[i] = own_finish if hit else finish[i]


@stage
def footprint(lanes, q):
    """A7, A8: sides of the footprint in u and v on the shape q."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, side, spread = row[L], row[M], row[N], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    met, wide_u, wide_v = row[A0], row[A7], row[A8]
    (ux, uy, uz), (ax, ay, az), (bx, by, bz) = vector(q, NORMAL), vector(q, AXIS_U), vector(q, AXIS_V)
    half_a, half_b = q[HALF_U], q[HALF_V]
    for i in range(B):
        steep = real(1) / (dx[i] * ux + dy[i] * uy + dz[i] * uz)
        wide = abs(side[i] + met[i] * spread[i])
        wide_u[i] = wide / half_a * footprint_stretch(real, (dx[i] * ax + dy[i] * ay + dz[i] * az) * half_a, steep)
        wide_v[i] = wide / half_b * footprint_stretch(real, (dx[i] * bx + dy[i] * by + dz[i] * bz) * half_b, steep)


@stage
def _paint(lanes, q):
    """The one colour of the shape q where a ray meets it (A0)."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue, met = row[RED], row[GREEN], row[BLUE], row[A0]
    r, g, b = vector(q, COLOUR)
    for i in range(B):
        hit = met[i] > real(0)
        red[i] = r if hit else red[i]
        green[i] = g if hit else green[i]
        blue[i] = b if hit else blue[i]


@stage
def paint_image(lanes, colour):
    """RED, GREEN, BLUE: A4 A5 A6 times a colour (3), where A0 is positive."""
    real = lanes.dtype.type
    row = rows(lanes)
    met, er, eg, eb, red, green, blue = row[A0], row[A4], row[A5], row[A6], row[RED], row[GREEN], row[BLUE]
    r, g, b = vector(colour, 0)
    for i in range(B):
        hit = met[i] > real(0)
        red[i] = r * er[i] if hit else red[i]
        green[i] = g * eg[i] if hit else green[i]
        blue[i] = b * eb[i] if hit else blue[i]


@stage
def _mix(lanes, q):
    """Mix of the two colours of the shape q where a ray meets it (A0): the part A3 of the second."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue, met, second = row[RED], row[GREEN], row[BLUE], row[A0], row[A3]
    (r, g, b), (sr, sg, sb) = vector(q, COLOUR), vector(q, COLOUR2)
    for i in range(B):
        hit, mix = met[i] > real(0), second[i]
        red[i] = r + mix * (sr - r) if hit else red[i]
        green[i] = g + mix * (sg - g) if hit else green[i]
        blue[i] = b + mix * (sb - b) if hit else blue[i]


@stage
def _checker(lanes, q):
    """A3: part of the second colour of a checker over the footprint A7, A8 at A1, A2."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    half_columns, half_lines = real(0.5) * q[COLUMNS], real(0.5) * q[LINES]
    for i in range(B):
        ka, kb = (u[i] + real(1)) * half_columns, (v[i] + real(1)) * half_lines
        sharp = checker_contrast(real, ka, kb, wide_u[i] * half_columns, wide_v[i] * half_lines)
        odd = parity(real, np.floor(ka) + np.floor(kb))
        second[i] = real(0.5) + (real(2) * odd - real(0.5)) * sharp


@stage
def _grid(lanes, q):
    """A3, as `_checker` does, for lines around cells; the outermost lines lie inside the edge at full width."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    columns, lines, line, half_a, half_b = q[COLUMNS], q[LINES], q[LINE], q[HALF_U], q[HALF_V]
    wide_a, wide_b = half_a - real(0.5) * line, half_b - real(0.5) * line
    per_a, per_b = real(0.5) * columns / wide_a, real(0.5) * lines / wide_b
    for i in range(B):
        a = line_coverage(real, (u[i] * half_a + wide_a) * per_a, line * per_a, wide_u[i] * half_a * per_a)
        b = line_coverage(real, (v[i] * half_b + wide_b) * per_b, line * per_b, wide_v[i] * half_b * per_b)
        second[i] = a + b - a * b


@stage
def _star(lanes, q):
    """A3, as `_checker` does, for pairs of sectors about the middle."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    columns = q[COLUMNS]
    for i in range(B):
        # Find the angle of the point; the arc tangent by a polynomial, to 1e-5 rad
        a, b = abs(u[i]), abs(v[i])
        small, big = (a, b) if a < b else (b, a)
        low = small / (big + real(1e-20))
        q2 = low * low
        angle = low * (real(0.99997726) + q2 * (real(-0.33262347) + q2 * (real(0.19354346) + q2 * (
            real(-0.11643287) + q2 * (real(0.05265332) + q2 * real(-0.01172120))))))
        angle = real(0.5 * math.pi) - angle if b > a else angle
        angle = real(math.pi) - angle if u[i] < real(0) else angle
        angle = real(2 * math.pi) - angle if v[i] < real(0) else angle

        # Average its sector over the footprint
        sector = angle * columns * real(1 / math.pi)
        odd = parity(real, np.floor(sector))
        du, dv = v[i] * wide_u[i], u[i] * wide_v[i]
        wide = math.sqrt(du * du + dv * dv) / (a * a + b * b + real(1e-20)) * columns * real(1 / math.pi)
        sharp = filtered_contrast(real, abs(sector - np.floor(sector + real(0.5))), wide)
        second[i] = real(0.5) + (real(2) * odd - real(0.5)) * sharp


@stage
def _ruler(lanes, q):
    """A3, as `_checker` does, for ticks that begin at the edge v = −1: every millimetre, every 5 and every 10."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u = row[A1], row[A2], row[A3], row[A7]
    longest, line, half_a, half_b = q[COLUMNS], q[LINE], q[HALF_U], q[HALF_V]
    for i in range(B):
        along, high = (u[i] + real(1)) * half_a, (v[i] + real(1)) * half_b
        per = (real(1) if high < real(0.5) * longest else real(0.2) if high < real(0.75) * longest
               else real(0.1))
        ticks = line_coverage(real, along * per, line * per, wide_u[i] * half_a * per)
        second[i] = ticks if high < longest else real(0)
