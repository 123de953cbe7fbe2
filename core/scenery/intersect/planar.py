"""Rectangles and disks, seen from both sides, plain or with a pattern: one stage for all of them.

A plate has a centre and two half-axes a and b at right angles; a point of its
plane has u, v in [−1, 1] along them. A pattern mixes the plate's two colours,
or is an image; which one is decided once for a block, never for a lane. Of a pattern
a lane sees the mean over the footprint of its pixel; of an image, in one of its reductions.
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
    A6,
    A7,
    A8,
    BEAM,
    BLUE,
    DEPTH,
    EMITS,
    GLOSS,
    GREEN,
    NX,
    NY,
    NZ,
    PIXEL_SIDE,
    PIXEL_SPREAD,
    RED,
    SPECULAR,
    B,
    L,
    M,
    N,
    X,
    Y,
    Z,
    gather,
    rows,
    stage,
)
from lensbench.scenery.intersect.block_bounds import beam_misses
from lensbench.scenery.intersect.spheres import gloss_of
from lensbench.scenery.shading.pattern_filter import filtered_contrast, footprint_stretch, line_coverage

PLATE = 29              # numbers before the texels of a plate's image
PLAIN, CHECKER, GRID, STAR, RULER, IMAGE = range(6)
ENOUGH = 1.3            # how many texels of a reduction a footprint covers at least
KINDS = {"checker": CHECKER, "grid": GRID, "star": STAR, "ruler": RULER, "image": IMAGE}


def plate_frame(plate) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Centre, half-axes a and b (mm), unit normal a × b, and 1.0 for a disk or 0.0 for a rectangle."""
    a, b = np.asarray(plate.right, np.float64), np.asarray(plate.up, np.float64)
    normal = np.cross(a, b)
    return np.asarray(plate.centre, np.float64), a, b, normal / math.sqrt(normal @ normal), float(plate.round)


def plate_parameters(plates, glows=None, bent=None) -> np.ndarray:
    """What the stage `plates` reads: for each its length in p, frame, material and pattern.

    glows: the EMITS of each, in place of 1 for what shines and 0 for what does not. bent: the same plates, as they are
    seen where a path is SPECULAR: with other images.
    """
    packed = []
    glows = [float(plate.material.shines) for plate in plates] if glows is None else glows
    for plate, glow, other in zip(plates, glows, plates if bent is None else bent, strict=True):
        centre, a, b, normal, disk = plate_frame(plate)
        material, pattern = plate.material, plate.material.pattern
        texels, further = np.zeros(0), 0
        kind, second, numbers = PLAIN, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0)
        if pattern is not None:
            kind, second = KINDS[pattern.kind], pattern.colour
            numbers = (pattern.columns, pattern.rows, pattern.line, 0.0)
            if pattern.image is not None:
                numbers = (pattern.image.width, pattern.image.height, 0.0, 0.0)
                texels = ripmap(pattern.image.values)
                if other.material.pattern != pattern:
                    more = _texels(ripmap(other.material.pattern.image.values))
                    texels, further = np.concatenate([texels, more]), more.size // 3
        half = math.sqrt(a @ a), math.sqrt(b @ b)
        head = [PLATE + texels.size, *centre, *normal, *(a / (a @ a)), *(b / (b @ b)), disk, *material.colour,
                glow, gloss_of(material), kind, *second, *numbers[:3], *half, further]
        packed.append(np.concatenate([head, texels]))
    return np.concatenate(packed)


def _levels(size: int) -> int:
    """In how many sizes an image of so many texels along a side is there: at least two, the last of 2 or 3 texels."""
    return max(2, size.bit_length() - 1)


def _binned(values: np.ndarray, bins: int) -> np.ndarray:
    """Means over equal parts of the first axis."""
    sums = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, 0, np.float64)])
    edges = np.linspace(0.0, len(values), bins + 1)
    k = np.minimum(edges.astype(int), len(values) - 1)
    sums = sums[k] + (edges - k)[:, None, None] * values[k]
    return np.diff(sums, axis=0) * (bins / len(values))


def ripmap(image: np.ndarray) -> np.ndarray:
    """An image (height, width, 3) with all that it is reduced to: halved again and again in width and height, apart.

    Levels across and down; texels across of each level, texels down of each; where each begins, in texels: first the
    image, then those reduced in both, a level across after the other; then the texels. Half of it is the image.
    """
    height, width = image.shape[:2]
    across = [max(2, width >> k) for k in range(_levels(width))]
    down = [max(2, height >> k) for k in range(_levels(height))]
    parts = [image, *(_binned(_binned(image.transpose(1, 0, 2), m).transpose(1, 0, 2), n)
                      for m in across[1:] for n in down[1:])]
    starts = np.cumsum([0] + [part.size // 3 for part in parts[:-1]])
    return np.concatenate([[len(across), len(down)], across, down, starts, *(part.ravel() for part in parts)])


def _texels(reduced: np.ndarray) -> np.ndarray:
    """Of `reductions`, the texels alone."""
    across, down = int(reduced[0]), int(reduced[1])
    return reduced[2 + across + down + 1 + (across - 1) * (down - 1):]


@stage
def _half(seen, k, q, long_a, long_b):
    """The half-width of a plate along one of the beam's axes.  q: its numbers; the squares of its half-axes."""
    return (abs(seen[k] * q[7] + seen[k + 1] * q[8] + seen[k + 2] * q[9]) * long_a
            + abs(seen[k] * q[10] + seen[k + 1] * q[11] + seen[k + 2] * q[12]) * long_b)


@stage
def _footprint(lanes, q):
    """A7, A8: the sides of the footprint in u and v.  q: the numbers of the plate."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, foot, spread = row[L], row[M], row[N], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    met, wide_u, wide_v = row[A0], row[A7], row[A8]
    ux, uy, uz, ax, ay, az, bx, by, bz = q[4], q[5], q[6], q[7], q[8], q[9], q[10], q[11], q[12]
    half_a, half_b = q[26], q[27]
    for i in range(B):
        steep = real(1) / (dx[i] * ux + dy[i] * uy + dz[i] * uz)
        wide = abs(foot[i] + met[i] * spread[i])
        wide_u[i] = wide / half_a * footprint_stretch(real, (dx[i] * ax + dy[i] * ay + dz[i] * az) * half_a, steep)
        wide_v[i] = wide / half_b * footprint_stretch(real, (dx[i] * bx + dy[i] * by + dz[i] * bz) * half_b, steep)


@stage
def _checker(lanes, q):
    """A3: which of the two colours, 0 or 1, or as much of the second as the footprint sees.  q: as for _footprint."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    columns, lines = q[23], q[24]
    half_columns, half_lines = real(0.5) * columns, real(0.5) * lines
    for i in range(B):
        ka, kb = (u[i] + real(1)) * half_columns, (v[i] + real(1)) * half_lines
        k = np.floor(ka) + np.floor(kb)
        sharp = filtered_contrast(real, abs(ka - np.floor(ka + real(0.5))), wide_u[i] * half_columns)
        sharp *= filtered_contrast(real, abs(kb - np.floor(kb + real(0.5))), wide_v[i] * half_lines)
        second[i] = real(0.5) + (real(2) * (k * real(0.5) - np.floor(k * real(0.5))) - real(0.5)) * sharp


@stage
def _grid(lanes, q):
    """A3, see _checker, of lines round cells."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    columns, lines, line, half_a, half_b = q[23], q[24], q[25], q[26], q[27]
    # lines of the width `line` (mm) round `columns` × `lines` cells, the outermost ones whole and inside
    wide_a, wide_b = half_a - real(0.5) * line, half_b - real(0.5) * line
    per_a, per_b = real(0.5) * columns / wide_a, real(0.5) * lines / wide_b
    for i in range(B):
        a = line_coverage(real, (u[i] * half_a + wide_a) * per_a, line * per_a, wide_u[i] * half_a * per_a)
        b2 = line_coverage(real, (v[i] * half_b + wide_b) * per_b, line * per_b, wide_v[i] * half_b * per_b)
        second[i] = a + b2 - a * b2


@stage
def _star(lanes, q):
    """A3, see _checker, of sectors round the middle."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u, wide_v = row[A1], row[A2], row[A3], row[A7], row[A8]
    columns = q[23]
    # `columns` pairs of sectors; the arc tangent by a polynomial, to 1e-5 rad
    for i in range(B):
        a, b2 = abs(u[i]), abs(v[i])
        small, big = (a, b2) if a < b2 else (b2, a)
        low = small / (big + real(1e-20))
        q2 = low * low
        angle = low * (real(0.99997726) + q2 * (real(-0.33262347) + q2 * (real(0.19354346) + q2 * (
            real(-0.11643287) + q2 * (real(0.05265332) + q2 * real(-0.01172120))))))
        angle = real(0.5 * math.pi) - angle if b2 > a else angle
        angle = real(math.pi) - angle if u[i] < real(0) else angle
        angle = real(2 * math.pi) - angle if v[i] < real(0) else angle
        sector = angle * columns * real(1 / math.pi)
        k = np.floor(sector)
        du, dv = v[i] * wide_u[i], u[i] * wide_v[i]
        wide = math.sqrt(du * du + dv * dv) / (a * a + b2 * b2 + real(1e-20)) * columns * real(1 / math.pi)
        sharp = filtered_contrast(real, abs(sector - np.floor(sector + real(0.5))), wide)
        second[i] = real(0.5) + (real(2) * (k * real(0.5) - np.floor(k * real(0.5))) - real(0.5)) * sharp


@stage
def _ruler(lanes, q):
    """A3, see _checker, of ticks along an edge."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, second, wide_u = row[A1], row[A2], row[A3], row[A7]
    columns, line, half_a, half_b = q[23], q[25], q[26], q[27]
    # ticks every millimetre, 5 and 10 along a, standing on the edge v = −1; `line` is their width in mm
    for i in range(B):
        along, high = (u[i] + real(1)) * half_a, (v[i] + real(1)) * half_b
        per = (real(1) if high < real(0.5) * columns else real(0.2) if high < real(0.75) * columns
               else real(0.1))
        ticks = line_coverage(real, along * per, line * per, wide_u[i] * half_a * per)
        second[i] = ticks if high < columns else real(0)


@stage
def _meet(lanes, q):
    """A0: the distance to the plate where a ray meets it nearer than anything, else 0; A1, A2: u and v there.

    How many rays do.  q: the numbers of the plate.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    met, u, v = row[A0], row[A1], row[A2]
    cx, cy, cz, ux, uy, uz = q[1], q[2], q[3], q[4], q[5], q[6]
    ax, ay, az, bx, by, bz, disk = q[7], q[8], q[9], q[10], q[11], q[12], q[13]
    crossed = np.int32(0)
    for i in range(B):
        ox, oy, oz = x[i] - cx, y[i] - cy, z[i] - cz
        t = -(ox * ux + oy * uy + oz * uz) / (dx[i] * ux + dy[i] * uy + dz[i] * uz)
        qx, qy, qz = ox + t * dx[i], oy + t * dy[i], oz + t * dz[i]
        qa, qb = qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz
        a2, b2 = qa * qa, qb * qb
        most = a2 if a2 > b2 else b2
        hit = (most + disk * (a2 + b2 - most) <= real(1)) & (t > real(0)) & (t < depth[i])
        met[i], u[i], v[i] = t if hit else real(0), qa, qb
        crossed = np.int32(crossed + np.int32(hit))
    return crossed


@stage
def _take(lanes, q):
    """Where a ray has met the plate (A0): distance, normal and surface are those of the plate."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, met = row[L], row[M], row[N], row[A0]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[EMITS], row[GLOSS], row[NX], row[NY], row[NZ]
    ux, uy, uz, shine, coat = q[4], q[5], q[6], q[17], q[18]
    for i in range(B):
        t = met[i]
        hit = t > real(0)
        side = real(-1) if dx[i] * ux + dy[i] * uy + dz[i] * uz > real(0) else real(1)
        depth[i] = t if hit else depth[i]
        nx[i] = side * ux if hit else nx[i]
        ny[i] = side * uy if hit else ny[i]
        nz[i] = side * uz if hit else nz[i]
        glow[i] = shine if hit else glow[i]
        gloss[i] = coat if hit else gloss[i]


@stage
def _paint(lanes, q):
    """Where a ray has met the plate (A0): its two colours, as much of the second as A3 has."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue, met, second = row[RED], row[GREEN], row[BLUE], row[A0], row[A3]
    r, g, b, sr, sg, sb = q[14], q[15], q[16], q[20], q[21], q[22]
    for i in range(B):
        hit, mix = met[i] > real(0), second[i]
        red[i] = r + mix * (sr - r) if hit else red[i]
        green[i] = g + mix * (sg - g) if hit else green[i]
        blue[i] = b + mix * (sb - b) if hit else blue[i]


@stage
def plates(lanes, p, key):
    """Offer the plates where they are nearer, after `beam`; normals turn towards the ray.  p: plate_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue, met, second = row[RED], row[GREEN], row[BLUE], row[A0], row[A3]
    er, eg, eb = row[A4], row[A5], row[A6]
    seen = row[BEAM]
    s = 0
    while s < p.size:
        q = p[s:s + int(p[s])]
        s += q.size
        kind, long_a, long_b = q[19], q[26] * q[26], q[27] * q[27]
        if beam_misses(seen, q[1], q[2], q[3], _half(seen, 4, q, long_a, long_b), _half(seen, 7, q, long_a, long_b),
                   _half(seen, 10, q, long_a, long_b)) or _meet(lanes, q) == 0:
            continue
        _take(lanes, q)
        if kind != PLAIN:
            _footprint(lanes, q)
        if kind == IMAGE:
            _image(lanes, q[PLATE:], q[28])
            for i in range(B):
                hit = met[i] > real(0)
                red[i] = q[14] * er[i] if hit else red[i]
                green[i] = q[15] * eg[i] if hit else green[i]
                blue[i] = q[16] * eb[i] if hit else blue[i]
            continue
        if kind == CHECKER:
            _checker(lanes, q)
        elif kind == GRID:
            _grid(lanes, q)
        elif kind == STAR:
            _star(lanes, q)
        elif kind == RULER:
            _ruler(lanes, q)
        else:
            for i in range(B):
                second[i] = real(0)
        _paint(lanes, q)


@stage
def _image(lanes, p, further):
    """A4, A5, A6: the image at u, v (A1, A2), between its texels linear; its first row lies at v = 1.

    Of the reduction whose texels are about as large as the footprint, A7 of u wide and A8 of v. p: reductions;
    where the path is SPECULAR, of another image, its texels so many further on.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, at, across, down = row[A1], row[A2], row[A3], row[A1], row[A2]
    level_u, level_v, columns, lines, start, bent = row[A4], row[A5], row[A7], row[A8], row[A6], row[SPECULAR]
    most_u, most_v = int(p[0]), int(p[1])
    sizes_u, sizes_v = p[2:], p[2 + most_u:]
    starts = sizes_v[most_v:]
    texels = starts[1 + (most_u - 1) * (most_v - 1):]
    for i in range(B):
        level_u[i], level_v[i] = real(0), real(0)
    least = real(2 * ENOUGH)
    for level in range(1, max(most_u, most_v)):
        size_u, size_v = least / sizes_u[0] * real(2), least / sizes_v[0] * real(2)
        for i in range(B):
            level_u[i] += real(1) if (columns[i] > size_u) & (level < most_u) else real(0)
            level_v[i] += real(1) if (lines[i] > size_v) & (level < most_v) else real(0)
        least *= real(2)
    across_levels = real(most_v - 1)
    for i in range(B):
        either = level_u[i] + level_v[i] > real(0)
        a, b = level_u[i], level_v[i]
        a, b = a if a > real(1) else real(1), b if b > real(1) else real(1)
        level_u[i], level_v[i] = a if either else real(0), b if either else real(0)
        at[i] = real(1) + (a - real(1)) * across_levels + b - real(1) if either else real(0)
    gather(columns, sizes_u, level_u)
    gather(lines, sizes_v, level_v)
    gather(start, starts, at)
    for i in range(B):
        wide, high = columns[i], lines[i]
        a = (u[i] + real(1)) * real(0.5) * wide - real(0.5)
        b = (real(1) - v[i]) * real(0.5) * high - real(0.5)
        a = a if a > real(0) else real(0)
        a = a if a < wide - real(1) else wide - real(1)
        b = b if b > real(0) else real(0)
        b = b if b < high - real(1) else high - real(1)
        ka, kb = np.floor(a), np.floor(b)
        ka = ka if ka < wide - real(2) else wide - real(2)
        kb = kb if kb < high - real(2) else high - real(2)
        at[i], across[i], down[i] = start[i] + bent[i] * further + kb * wide + ka, a - ka, b - kb
    right = np.uint64(3)
    for c in range(3):
        colour = row[A4 + c]
        first = np.uint64(c)
        for i in range(B):
            k = np.uint64(np.uint32(at[i])) * right + first
            below = k + np.uint64(np.uint32(columns[i])) * right
            e, f = texels[k], texels[k + right]
            g, h = texels[below], texels[below + right]
            upper, lower = e + across[i] * (f - e), g + across[i] * (h - g)
            colour[i] = upper + down[i] * (lower - upper)
