"""A checkered floor without end."""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
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
from lensbench.scenery.shading.pattern_filter import filtered_contrast, footprint_stretch


def floor_axes(floor) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit normal, and the two unit axes along the tiles."""
    normal = np.asarray(floor.normal, np.float64)
    normal = normal / math.sqrt(normal @ normal)
    along = np.cross(normal, (0.0, 0.0, 1.0) if abs(normal[2]) < 0.9 else (1.0, 0.0, 0.0))
    along /= math.sqrt(along @ along)
    across = np.cross(along, normal)
    c, s = math.cos(floor.turn), math.sin(floor.turn)
    return normal, c * along + s * across, c * across - s * along


def floor_parameters(floor) -> np.ndarray:
    """What the stage `floor` reads."""
    normal, a, b = floor_axes(floor)
    light, dark = np.array(floor.light), np.array(floor.dark)
    return np.array([*normal, floor.height, *(a / floor.tile), *(b / floor.tile), *floor.offset,
                     *(light + dark) / 2, *(light - dark) / 2, floor.gloss, 1.0 / floor.tile])


@stage
def floor(lanes, p, key):
    """Offer the floor where it is nearer; it is seen from above only.

    p: unit normal (3), distance from the origin along it (mm), two unit axes over the tile's edge (6, 1/mm), their
    offsets (2, tiles), mean colour (3), half the difference of the colours (3), gloss, 1 / the tile's edge.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[EMITS], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, foot, spread = row[RED], row[GREEN], row[BLUE], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    ux, uy, uz, height = p[0], p[1], p[2], p[3]
    ax, ay, az, bx, by, bz, a0, b0 = p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]
    mr, mg, mb, hr, hg, hb, shine, per = p[12], p[13], p[14], p[15], p[16], p[17], p[18], p[19]
    tile, met, slant = real(1) / per, row[A0], row[A1]
    many = np.int32(0)
    for i in range(B):
        steep = real(1) / (ux * dx[i] + uy * dy[i] + uz * dz[i])
        t = (height - (ux * x[i] + uy * y[i] + uz * z[i])) * steep
        hit = (t > real(0)) & (t < depth[i]) & (steep < real(0))
        met[i], slant[i] = t if hit else real(0), steep
        many = np.int32(many + np.int32(hit))
    if many == 0:
        return
    for i in range(B):
        t, steep = met[i], slant[i]
        hit = t > real(0)
        hx, hy, hz = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        a, b = a0 + ax * hx + ay * hy + az * hz, b0 + bx * hx + by * hy + bz * hz
        k = np.floor(a) + np.floor(b)
        odd = k * real(0.5) - np.floor(k * real(0.5))
        # as sharp as the footprint is narrow
        wide = abs(foot[i] + t * spread[i]) * per
        wide_a = wide * footprint_stretch(real, (ax * dx[i] + ay * dy[i] + az * dz[i]) * tile, steep)
        wide_b = wide * footprint_stretch(real, (bx * dx[i] + by * dy[i] + bz * dz[i]) * tile, steep)
        sharp = filtered_contrast(real, abs(a - np.floor(a + real(0.5))), wide_a) * filtered_contrast(
            real, abs(b - np.floor(b + real(0.5))), wide_b)
        side = (real(4) * odd - real(1)) * sharp
        depth[i] = t if hit else depth[i]
        glow[i] = real(0) if hit else glow[i]
        gloss[i] = shine if hit else gloss[i]
        nx[i] = ux if hit else nx[i]
        ny[i] = uy if hit else ny[i]
        nz[i] = uz if hit else nz[i]
        red[i] = mr + side * hr if hit else red[i]
        green[i] = mg + side * hg if hit else green[i]
        blue[i] = mb + side * hb if hit else blue[i]
