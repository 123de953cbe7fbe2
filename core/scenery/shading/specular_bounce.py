"""Mirrors and glass: where a path continues.

Inside a ball of glass the path is reflected k times, k = 0, 1, … with the probability F^k (1 − F) of Fresnel's sum, F
Schlick's reflectance, which is the same at each meeting: all light that enters leaves, each part where it does.
"""

import math

import numpy as np
from numba import uint32

from lensbench.kernels.block import (
    ALIVE,
    DEPTH,
    EMITS,
    FINISH,
    NX,
    NY,
    NZ,
    OX,
    OY,
    OZ,
    PATH,
    PIXEL,
    PIXEL_SIDE,
    PIXEL_SPREAD,
    PUPIL_RADIUS,
    PUPIL_SPREAD,
    SAMPLE,
    SEED,
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
from lensbench.kernels.cache import njit
from lensbench.kernels.sampling import mix
from lensbench.scenery.emission import DARK, DIRECT, SPECULAR
from lensbench.scenery.finish import ball_radius, is_ball, is_glass, is_specular
from lensbench.scenery.shading.illumination import F0, INDEX, schlick_edge
from lensbench.scenery.shading.rounding import rounded_length

LIFT = 4e-6             # offset of a new ray from the surface, as a fraction of `rounded_length`
MOST_INNER = 3          # reflections in a ball that a path is followed for; the light of more leaves as after these
INNER = 1.0             # the parameter of `specular_bounce` that asks for reflections in balls


@njit(inline="always")
def chance(real, key, salt, i, cosine):
    """A random number in [0, 1) for lane i, another one for each cosine of incidence, 0 to 1."""
    a = mix(uint32(uint32(key[PIXEL] + uint32(i)) ^ salt))
    a = mix(uint32(a ^ uint32(np.int32(cosine * real(16777216)))))
    return real(np.int32(a >> np.uint32(8))) * real(1 / 16777216)


@njit(inline="always")
def chance_salt(key):
    """What the numbers of `chance` of one sample of all pixels share."""
    return mix(uint32(key[SAMPLE] + mix(uint32(key[SEED] + np.uint32(0x3C6EF372)))))


@stage
def specular_bounce(lanes, p, ints, key):
    """Continue the paths that met metal or glass, end the others; key[ALIVE] = 0 where none continues.

    Metal reflects. A glass ball is crossed in one step, in closed form: refraction in, chords of 2 R cos θ′,
    refraction out at the same angle. A pane is crossed straight. A path that ends has no direction and meets nothing.
    It is SPECULAR where the surface BENDS and the path is not reflected inside. The footprint of a pixel grows with the
    length of the path, as it does behind plane mirrors; a ball of glass spreads it as it does near its axis.
    p: INNER draws the reflections inside; nothing follows the light that has none, less what they take.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    finish, tr, tg, tb, emits, path = row[FINISH], row[TR], row[TG], row[TB], row[EMITS], row[PATH]

    # End the paths that met neither
    many, balls = np.int32(0), np.int32(0)
    for i in range(B):
        on = is_specular(real, finish[i]) & (tr[i] + tg[i] + tb[i] > real(0))
        tr[i] = tr[i] if on else real(0)
        tg[i] = tg[i] if on else real(0)
        tb[i] = tb[i] if on else real(0)
        path[i] = real(SPECULAR) if emits[i] < real(DARK) else real(DIRECT)
        many, balls = np.int32(many + np.int32(on)), np.int32(balls + np.int32(on & is_ball(real, finish[i])))
    if many == 0:
        key[ALIVE] = np.uint32(0)
        return
    if balls == 0:
        _go_on(lanes, key, False, 0)
    elif p.size == 0:
        _go_on(lanes, key, True, 0)
    else:
        _go_on(lanes, key, True, MOST_INNER)


@njit(inline="always")
def _go_on(lanes, key, balls, inner_most):
    """Send on the paths of `specular_bounce`. balls: whether any meets one; inner_most: reflections in it, or 0."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, finish, nx, ny, nz = row[DEPTH], row[FINISH], row[NX], row[NY], row[NZ]
    tr, tg, tb, side, spread, path = row[TR], row[TG], row[TB], row[PIXEL_SIDE], row[PIXEL_SPREAD], row[PATH]
    salt = chance_salt(key)
    for i in range(B):
        t = depth[i]
        on = tr[i] + tg[i] + tb[i] > real(0)
        glass, ball = is_glass(real, finish[i]), is_ball(real, finish[i])
        u, v, w, ux, uy, uz = dx[i], dy[i], dz[i], nx[i], ny[i], nz[i]
        hx, hy, hz = x[i] + t * u, y[i] + t * v, z[i] + t * w
        cosine = -(u * ux + v * uy + w * uz)

        # Reflect at metal
        mx, my, mz = u + real(2) * cosine * ux, v + real(2) * cosine * uy, w + real(2) * cosine * uz

        # Refract into a glass ball, cross it, refract out
        inner = math.sqrt(real(1) - real(1 / INDEX**2) * (real(1) - cosine * cosine))
        bend = real(1 / INDEX) * cosine - inner
        ix, iy, iz = real(1 / INDEX) * u + bend * ux, real(1 / INDEX) * v + bend * uy, real(1 / INDEX) * w + bend * uz
        ex, ey, ez = ux + real(2) * inner * ix, uy + real(2) * inner * iy, uz + real(2) * inner * iz
        f = real(F0) + real(1 - F0) * schlick_edge(real, cosine)
        dice, part = chance(real, key, salt, i, cosine) if inner_most else real(1), f
        for _ in range(inner_most):
            again = dice < part
            jx, jy, jz = ix - real(2) * inner * ex, iy - real(2) * inner * ey, iz - real(2) * inner * ez
            ix, iy, iz = jx if again else ix, jy if again else iy, jz if again else iz
            ex, ey, ez = (ex + real(2) * inner * ix if again else ex, ey + real(2) * inner * iy if again else ey,
                          ez + real(2) * inner * iz if again else ez)
            part *= f
        if inner_most:
            path[i] = real(DIRECT) if ball & (dice < f) else path[i]
        elif balls:
            clear = real(1) - f if ball else real(1)
            tr[i], tg[i], tb[i] = tr[i] * clear, tg[i] * clear, tb[i] * clear
        back = real(INDEX) * inner - cosine
        gx, gy, gz = real(INDEX) * ix - back * ex, real(INDEX) * iy - back * ey, real(INDEX) * iz - back * ez

        # Choose one of the three, and offset the ray from the surface
        lift = real(LIFT) * rounded_length(hx, hy, hz, t)
        lift = -lift if glass & (not ball) else lift
        sx, sy, sz = (ex, ey, ez) if ball else (ux, uy, uz)
        radius = ball_radius(real, finish[i]) if ball else real(0)
        px, py, pz = (hx + radius * (sx - ux) + lift * sx, hy + radius * (sy - uy) + lift * sy,
                      hz + radius * (sz - uz) + lift * sz)
        qx, qy, qz = (gx, gy, gz) if ball else (u, v, w) if glass else (mx, my, mz)
        size = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
        x[i], y[i], z[i] = px if on else x[i], py if on else y[i], pz if on else z[i]
        dx[i], dy[i], dz[i] = qx * size if on else real(0), qy * size if on else real(0), qz * size if on else real(0)

        # Carry the footprint: a glass ball is a thin lens at its centre, of the focal length n R / (2 (n − 1))
        inside = side[i] + (t + radius) * spread[i]
        wider = spread[i] - (inside * real(2 * (INDEX - 1) / INDEX) / radius if ball else real(0))
        side[i], spread[i] = inside + radius * wider if on else side[i], wider if on else spread[i]


@stage
def bounce_pupil_part(lanes, p, ints, key):
    """PUPIL_RADIUS, PUPIL_SPREAD, OX, OY, OZ after metal and glass; runs before `specular_bounce`."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, finish, nx, ny, nz = row[DEPTH], row[FINISH], row[NX], row[NY], row[NZ]
    disk, fan, ox, oy, oz = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[OX], row[OY], row[OZ]
    for i in range(B):
        radius, ball = ball_radius(real, finish[i]), is_ball(real, finish[i])
        power = real(2 * (INDEX - 1) / INDEX) / radius if ball else real(0)
        radius = radius if ball else real(0)
        within = disk[i] + (depth[i] + radius) * fan[i]
        fan[i] -= within * power
        disk[i] = within + radius * fan[i]
        off = real(2) * (ox[i] * nx[i] + oy[i] * ny[i] + oz[i] * nz[i]) if not is_glass(real, finish[i]) else real(0)
        ox[i], oy[i], oz[i] = ox[i] - off * nx[i], oy[i] - off * ny[i], oz[i] - off * nz[i]
