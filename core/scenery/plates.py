"""Rectangles and disks, seen from both sides, plain or with a pattern: one stage for all of them.

A plate has a centre and two half-axes a and b at right angles; a point of its
plane has u, v in [−1, 1] along them. A pattern mixes the plate's two colours,
or is an image; which one is decided once for a block, never for a lane.
"""

import math

import numpy as np

from lensbench.lanes import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    BLUE,
    DEPTH,
    GLOSS,
    GLOW,
    GREEN,
    NX,
    NY,
    NZ,
    RED,
    B,
    L,
    M,
    N,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.scenery.bounds import outside, wedge
from lensbench.scenery.spheres import gloss_of

PLATE = 28              # numbers before the texels of a plate's image
PLAIN, CHECKER, GRID, STAR, RULER, IMAGE = range(6)
KINDS = {"checker": CHECKER, "grid": GRID, "star": STAR, "ruler": RULER, "image": IMAGE}


def plate_frame(plate) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Centre, half-axes a and b (mm), unit normal a × b, and 1.0 for a disk or 0.0 for a rectangle."""
    a, b = np.asarray(plate.right, np.float64), np.asarray(plate.up, np.float64)
    normal = np.cross(a, b)
    return np.asarray(plate.centre, np.float64), a, b, normal / math.sqrt(normal @ normal), float(plate.round)


def plate_parameters(plates, glows=None) -> np.ndarray:
    """What the stage `plates` reads: for each its length in p, frame, material and pattern.

    glows: the GLOW of each, in place of 1 for what shines and 0 for what does not.
    """
    packed = []
    for plate, glow in zip(plates, [float(plate.material.shines) for plate in plates] if glows is None else glows,
                           strict=True):
        centre, a, b, normal, disk = plate_frame(plate)
        material, pattern = plate.material, plate.material.pattern
        texels = np.zeros(0)
        kind, second, numbers = PLAIN, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0)
        if pattern is not None:
            kind, second = KINDS[pattern.kind], pattern.colour
            numbers = (pattern.columns, pattern.rows, pattern.line, 0.0)
            if pattern.image is not None:
                numbers = (pattern.image.width, pattern.image.height, 0.0, 0.0)
                texels = pattern.image.values.ravel()
        half = math.sqrt(a @ a), math.sqrt(b @ b)
        head = [PLATE + texels.size, *centre, *normal, *(a / (a @ a)), *(b / (b @ b)), disk, *material.colour,
                glow, gloss_of(material), kind, *second, *numbers[:3], *half]
        packed.append(np.concatenate([head, texels]))
    return np.concatenate(packed)


@stage
def _along(seen, k, ax, ay, az):
    """A vector's part along one of the wedge's axes."""
    return seen[k] * ax + seen[k + 1] * ay + seen[k + 2] * az


@stage
def plates(lanes, p, key):
    """Offer the plates where they are nearer; the normal is turned towards the ray.  p: plate_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[GLOW], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    met, u, v, second = row[A0], row[A1], row[A2], row[A3]
    seen = wedge(lanes)
    s = 0
    while s < p.size:
        size = int(p[s])
        cx, cy, cz, ux, uy, uz = p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6]
        ax, ay, az, bx, by, bz, disk = p[s + 7], p[s + 8], p[s + 9], p[s + 10], p[s + 11], p[s + 12], p[s + 13]
        r, g, b, shine, coat, kind = p[s + 14], p[s + 15], p[s + 16], p[s + 17], p[s + 18], p[s + 19]
        long_a, long_b = p[s + 26] * p[s + 26], p[s + 27] * p[s + 27]
        if outside(seen, cx, cy, cz,
                   abs(_along(seen, 4, ax, ay, az)) * long_a + abs(_along(seen, 4, bx, by, bz)) * long_b,
                   abs(_along(seen, 7, ax, ay, az)) * long_a + abs(_along(seen, 7, bx, by, bz)) * long_b):
            s += size
            continue
        # where each ray meets the plane
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
        texels = p[s + PLATE:s + size]
        sr, sg, sb = p[s + 20], p[s + 21], p[s + 22]
        columns, lines, line, half_a, half_b = p[s + 23], p[s + 24], p[s + 25], p[s + 26], p[s + 27]
        s += size
        if crossed == 0:
            continue
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
        # which of the two colours
        if kind == PLAIN:
            for i in range(B):
                second[i] = real(0)
        elif kind == CHECKER:
            for i in range(B):
                k = np.floor((u[i] + real(1)) * real(0.5) * columns) + np.floor((v[i] + real(1)) * real(0.5) * lines)
                second[i] = real(2) * (k * real(0.5) - np.floor(k * real(0.5)))
        elif kind == GRID:
            # lines of the width `line` (mm) round `columns` × `lines` cells, the outermost ones whole and inside
            wide_a, wide_b = half_a - real(0.5) * line, half_b - real(0.5) * line
            cell_a, cell_b = real(2) * wide_a / columns, real(2) * wide_b / lines
            for i in range(B):
                ka = (u[i] * half_a + wide_a) / cell_a
                kb = (v[i] * half_b + wide_b) / cell_b
                off_a = abs(ka - np.floor(ka + real(0.5))) * cell_a
                off_b = abs(kb - np.floor(kb + real(0.5))) * cell_b
                off = off_a if off_a < off_b else off_b
                second[i] = real(1) if off <= real(0.5) * line else real(0)
        elif kind == STAR:
            # `columns` pairs of sectors; the arc tangent by a polynomial, to 1e-5 rad
            for i in range(B):
                a, b2 = abs(u[i]), abs(v[i])
                small, big = (a, b2) if a < b2 else (b2, a)
                q = small / (big + real(1e-20))
                q2 = q * q
                angle = q * (real(0.99997726) + q2 * (real(-0.33262347) + q2 * (real(0.19354346) + q2 * (
                    real(-0.11643287) + q2 * (real(0.05265332) + q2 * real(-0.01172120))))))
                angle = real(0.5 * math.pi) - angle if b2 > a else angle
                angle = real(math.pi) - angle if u[i] < real(0) else angle
                angle = real(2 * math.pi) - angle if v[i] < real(0) else angle
                k = np.floor(angle * columns * real(1 / math.pi))
                second[i] = real(2) * (k * real(0.5) - np.floor(k * real(0.5)))
        elif kind == RULER:
            # ticks every millimetre, 5 and 10 along a, standing on the edge v = −1; `line` is their width in mm
            for i in range(B):
                along, high = (u[i] + real(1)) * half_a, (v[i] + real(1)) * half_b
                one = abs(along - np.floor(along + real(0.5)))
                five = abs(along * real(0.2) - np.floor(along * real(0.2) + real(0.5))) * real(5)
                ten = abs(along * real(0.1) - np.floor(along * real(0.1) + real(0.5))) * real(10)
                long = columns * (real(1) if ten < line else real(0.75) if five < line else real(0.5))
                second[i] = real(1) if (one < real(0.5) * line) & (high < long) else real(0)
        if kind == IMAGE:
            _image(lanes, texels, columns, lines)
            er, eg, eb = row[A4], row[A5], row[A6]
            for i in range(B):
                hit = met[i] > real(0)
                red[i] = r * er[i] if hit else red[i]
                green[i] = g * eg[i] if hit else green[i]
                blue[i] = b * eb[i] if hit else blue[i]
        else:
            for i in range(B):
                hit, mix = met[i] > real(0), second[i]
                red[i] = r + mix * (sr - r) if hit else red[i]
                green[i] = g + mix * (sg - g) if hit else green[i]
                blue[i] = b + mix * (sb - b) if hit else blue[i]


@stage
def _image(lanes, texels, columns, lines):
    """A4, A5, A6: the image at u, v (A1, A2), between its texels linear; its first row lies at v = 1."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, at, across, down = row[A1], row[A2], row[A3], row[A1], row[A2]
    right, below = np.uint64(3), np.uint64(3) * np.uint64(columns)
    for i in range(B):
        a = (u[i] + real(1)) * real(0.5) * columns - real(0.5)
        b = (real(1) - v[i]) * real(0.5) * lines - real(0.5)
        a = a if a > real(0) else real(0)
        a = a if a < columns - real(1) else columns - real(1)
        b = b if b > real(0) else real(0)
        b = b if b < lines - real(1) else lines - real(1)
        ka, kb = np.floor(a), np.floor(b)
        ka = ka if ka < columns - real(2) else columns - real(2)
        kb = kb if kb < lines - real(2) else lines - real(2)
        at[i], across[i], down[i] = kb * columns + ka, a - ka, b - kb
    for c in range(3):
        colour = row[A4 + c]
        first = np.uint64(c)
        for i in range(B):
            k = np.uint64(np.uint32(at[i])) * np.uint64(3) + first
            e, f = texels[k], texels[k + right]
            g, h = texels[k + below], texels[k + below + right]
            upper, lower = e + across[i] * (f - e), g + across[i] * (h - g)
            colour[i] = upper + down[i] * (lower - upper)
