"""A checkered floor without end."""

import numpy as np

from lensbench.lanes import (
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


@stage
def floor(lanes, p, key):
    """Offer the floor where it is nearer.

    p: unit normal (3), its distance from the origin along that normal (mm), two unit axes in the plane over
    the tile's edge (6, 1/mm), their offsets (2, tiles), mean colour (3), half the colours' difference (3), gloss,
    fade: the angle of a pixel over the tile's edge (rad/mm); seen so finely the tiles run together to their mean.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[GLOW], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    ux, uy, uz, height = p[0], p[1], p[2], p[3]
    ax, ay, az, bx, by, bz, a0, b0 = p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]
    mr, mg, mb, hr, hg, hb, shine, fade = p[12], p[13], p[14], p[15], p[16], p[17], p[18], p[19]
    for i in range(B):
        px, py, pz, dx, dy, dz, near = x[i], y[i], z[i], l[i], m[i], n[i], depth[i]
        steep = real(1) / (ux * dx + uy * dy + uz * dz)
        t = (height - (ux * px + uy * py + uz * pz)) * steep
        hit = (t > real(0)) & (t < near) & (steep < real(0))
        hx, hy, hz = px + t * dx, py + t * dy, pz + t * dz
        k = np.floor(a0 + ax * hx + ay * hy + az * hz) + np.floor(b0 + bx * hx + by * hy + bz * hz)
        odd = k * real(0.5) - np.floor(k * real(0.5))
        blur = t * steep * fade
        sharp = real(1) + blur
        sharp = sharp if sharp > real(0) else real(0)
        side = (real(4) * odd - real(1)) * sharp
        depth[i] = t if hit else near
        glow[i] = real(0) if hit else glow[i]
        gloss[i] = shine if hit else gloss[i]
        nx[i] = ux if hit else nx[i]
        ny[i] = uy if hit else ny[i]
        nz[i] = uz if hit else nz[i]
        red[i] = mr + side * hr if hit else red[i]
        green[i] = mg + side * hg if hit else green[i]
        blue[i] = mb + side * hb if hit else blue[i]
