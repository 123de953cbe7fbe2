"""Light on surfaces: the sky's and the ambient light, and the bookkeeping of a path.

Without shadows, mirrors and lamps all of it is one stage, `daylight`. Otherwise
a round of stages is: what is met (the objects), `clearcoat`, `gather_emission`, then each
light adds to the sum S, then perhaps `specular_bounce` and the next round; `finish_path` ends.
"""

import math

import numpy as np
from numba import njit

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    BLUE,
    DEPTH,
    EMITS,
    GLASS,
    GLOSS,
    GREEN,
    METAL,
    NX,
    NY,
    NZ,
    RED,
    SB,
    SG,
    SPECULAR,
    SR,
    TB,
    TG,
    TR,
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

# ∫ (w·u)₊ (w·n)₊ dw / π over the cosine of the angle between u and n: a quartic, exact at −1, 0 and 1, within 0.002
RISE0, RISE1, RISE2, RISE4 = 2 / (3 * math.pi), 1 / 3, 1 / (3 * math.pi), 1 / 3 - 1 / math.pi
INDEX = 1.5             # of glass and coats
F0 = ((INDEX - 1) / (INDEX + 1)) ** 2

POINT = 10              # numbers of a lamp that casts no shadows
BENDS, SMALL = -1.0, 2.0        # EMITS of what bends a path away from small lights, and of one of those lights


@stage
def daylight(lanes, p, key):
    """Sky and sun without shadows, in one: RED, GREEN, BLUE become radiance.

    p: sky_parameters (12), ambient radiance (3), direction to the sun (3, unit), its irradiance / π (3).
    """
    real = lanes.dtype.type
    row = rows(lanes)
    glow, nx, ny, nz = row[EMITS], row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    zr, zg, zb = p[0] - p[3], p[1] - p[4], p[2] - p[5]
    half = real(0.5)
    er, eg, eb = p[12] + half * (p[3] + p[6]), p[13] + half * (p[4] + p[7]), p[14] + half * (p[5] + p[8])
    dr, dg, db = half * (p[3] - p[6]), half * (p[4] - p[7]), half * (p[5] - p[8])
    ux, uy, uz, sx, sy, sz, sr, sg, sb = p[9], p[10], p[11], p[15], p[16], p[17], p[18], p[19], p[20]
    for i in range(B):
        up = ux * nx[i] + uy * ny[i] + uz * nz[i]
        rise = real(RISE0) + up * (real(RISE1) + up * (real(RISE2) + up * up * real(RISE4)))
        slant = sx * nx[i] + sy * ny[i] + sz * nz[i]
        slant = slant if slant > real(0) else real(0)
        shine = glow[i] > real(0)
        red[i] *= real(1) if shine else er + up * dr + rise * zr + slant * sr
        green[i] *= real(1) if shine else eg + up * dg + rise * zg + slant * sg
        blue[i] *= real(1) if shine else eb + up * db + rise * zb + slant * sb


@stage
def begin_path(lanes, p, key):
    """A path starts: it carries all of its light (T = 1) and has gathered none (S = 0)."""
    real = lanes.dtype.type
    row = rows(lanes)
    tr, tg, tb, sr, sg, sb, bent = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB], row[SPECULAR]
    for i in range(B):
        bent[i] = real(0)
        tr[i], tg[i], tb[i] = real(1), real(1), real(1)
        sr[i], sg[i], sb[i] = real(0), real(0), real(0)


@stage
def gather_emission(lanes, p, key):
    """Take what is met into the path's account.

    Emission goes to S, but that of a SMALL light where the path is SPECULAR. Albedo becomes T · albedo, what a unit of
    irradiance / π adds to S. Metal and glass tint T (Schlick's reflectance; a ball's two transmissions (1 − F)²,
    a pane's (1 − F) / (1 + F)) and have no albedo.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, nx, ny, nz = row[L], row[M], row[N], row[NX], row[NY], row[NZ]
    glow, gloss, red, green, blue = row[EMITS], row[GLOSS], row[RED], row[GREEN], row[BLUE]
    tr, tg, tb, sr, sg, sb, bent = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB], row[SPECULAR]
    mirrors = np.int32(0)
    for i in range(B):
        r, g, b = red[i] * tr[i], green[i] * tg[i], blue[i] * tb[i]
        shine = glow[i] > real(0)
        seen = shine & (glow[i] + bent[i] < real(SMALL + 1))
        sr[i] += r if seen else real(0)
        sg[i] += g if seen else real(0)
        sb[i] += b if seen else real(0)
        red[i], green[i], blue[i] = real(0) if shine else r, real(0) if shine else g, real(0) if shine else b
        mirrors = np.int32(mirrors + np.int32(gloss[i] >= real(METAL)))
    if mirrors == 0:
        return
    for i in range(B):
        cosine = -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        edge = real(1) - (cosine if cosine > real(0) else real(0))
        edge2 = edge * edge
        edge5 = edge2 * edge2 * edge
        f = real(F0) + real(1 - F0) * edge5
        clear = (real(1) - f) * (real(1) - f) if gloss[i] > real(GLASS) else (real(1) - f) / (real(1) + f)
        mirror, glass = gloss[i] >= real(METAL), gloss[i] >= real(GLASS)
        r, g, b = red[i], green[i], blue[i]
        tr[i] = r * clear if glass else r + edge5 * (tr[i] - r) if mirror else tr[i]
        tg[i] = g * clear if glass else g + edge5 * (tg[i] - g) if mirror else tg[i]
        tb[i] = b * clear if glass else b + edge5 * (tb[i] - b) if mirror else tb[i]
        red[i] = real(0) if mirror else r
        green[i] = real(0) if mirror else g
        blue[i] = real(0) if mirror else b


@stage
def finish_path(lanes, p, key):
    """RED, GREEN, BLUE: what the path has gathered."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB]
    for i in range(B):
        red[i], green[i], blue[i] = sr[i], sg[i], sb[i]


@stage
def count_lit(lanes):
    """How many lanes of the block have an albedo that light can fall on."""
    real = lanes.dtype.type
    row = rows(lanes)
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    many = np.int32(0)
    for i in range(B):
        many = np.int32(many + np.int32(red[i] + green[i] + blue[i] > real(0)))
    return many


@stage
def ambient(lanes, p, key):
    """Add the light of the sky and the ambient light, less what spheres near by hold off in closed form.

    A sphere of radius r at distance d, its centre at the angle θ from the normal, covers cos θ r²/d² of the
    irradiance of a uniform sky (exact where it stands wholly above the surface's horizon); several multiply.
    p: sky_parameters (12), ambient radiance (3), then 4 for each sphere: centre, radius² (glass: a part of it).
    """
    if count_lit(lanes) == 0:
        return
    sky_begin(lanes)
    sky_occlusion(lanes, p[15:])
    add_sky(lanes, p)


@stage
def open_light(lanes, p, key):
    """Add the light of the sky, the ambient light and that of lamps, each as a point at its middle, without shadows.

    A plate gives L cos θ cos θ′ A / (π d²), a sphere by its solid angle, L cos θ · 2 (1 − cos θm). p: the 15 numbers of
    `ambient`, then POINT for each lamp: its middle, unit normal times area / π, radius² (a plate: 0), radiance.
    """
    if count_lit(lanes) == 0:
        return
    sky_begin(lanes)
    add_sky(lanes, p)
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    hx, hy, hz, sr, sg, sb = row[A0], row[A1], row[A2], row[SR], row[SG], row[SB]
    for s in range(15, p.size, POINT):
        cx, cy, cz, ux, uy, uz, r2, er, eg, eb = (p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6],
                                                  p[s + 7], p[s + 8], p[s + 9])
        if r2 > real(0):
            for i in range(B):
                qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
                d2 = qx * qx + qy * qy + qz * qz
                sine2 = r2 / d2 if r2 < d2 else real(1)
                light = (nx[i] * qx + ny[i] * qy + nz[i] * qz) / math.sqrt(d2)
                light *= real(2) * sine2 / (real(1) + math.sqrt(real(1) - sine2))
                light = light if light > real(0) else real(0)
                sr[i] += red[i] * light * er
                sg[i] += green[i] * light * eg
                sb[i] += blue[i] * light * eb
            continue
        for i in range(B):
            qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
            per = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
            slant = (nx[i] * qx + ny[i] * qy + nz[i] * qz) * per
            light = slant * abs(ux * qx + uy * qy + uz * qz) * (per * per * per)
            light = light if light > real(0) else real(0)
            sr[i] += red[i] * light * er
            sg[i] += green[i] * light * eg
            sb[i] += blue[i] * light * eb


@stage
def sky_begin(lanes):
    """A0, A1, A2: the points that are lit; A3, the part of the sky's light that reaches them: all of it."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    hx, hy, hz, free = row[A0], row[A1], row[A2], row[A3]
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i], free[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i], real(1)


@stage
def sky_occlusion(lanes, p):
    """A3, less what spheres hold off; p: 4 for each, as `ambient` has them."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, free = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[A3]
    for s in range(0, p.size, 4):
        cx, cy, cz, r2 = p[s], p[s + 1], p[s + 2], p[s + 3]
        for i in range(B):
            free[i] *= unoccluded(real, cx - hx[i], cy - hy[i], cz - hz[i], r2, nx[i], ny[i], nz[i])


@njit(inline="always")
def unoccluded(real, ax, ay, az, r2, nx, ny, nz):
    """What a sphere, its centre at a from the point and its radius² r2, leaves of the sky's light there."""
    d2 = ax * ax + ay * ay + az * az
    above = ax * nx + ay * ny + az * nz
    held = r2 * above / (d2 * math.sqrt(d2))
    held = held if held > real(0) else real(0)
    return real(1) - (held if held < real(1) else real(1))


@stage
def add_sky(lanes, p):
    """Add the light of the sky and the ambient light, as far as A3 lets it; p: the 15 numbers of `ambient`."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    sr, sg, sb, free = row[SR], row[SG], row[SB], row[A3]
    zr, zg, zb = p[0] - p[3], p[1] - p[4], p[2] - p[5]
    half = real(0.5)
    er, eg, eb = p[12] + half * (p[3] + p[6]), p[13] + half * (p[4] + p[7]), p[14] + half * (p[5] + p[8])
    gr, gg, gb = half * (p[3] - p[6]), half * (p[4] - p[7]), half * (p[5] - p[8])
    ux, uy, uz = p[9], p[10], p[11]
    for i in range(B):
        up = ux * nx[i] + uy * ny[i] + uz * nz[i]
        rise = real(RISE0) + up * (real(RISE1) + up * (real(RISE2) + up * up * real(RISE4)))
        sr[i] += red[i] * free[i] * (er + up * gr + rise * zr)
        sg[i] += green[i] * free[i] * (eg + up * gg + rise * zg)
        sb[i] += blue[i] * free[i] * (eb + up * gb + rise * zb)
