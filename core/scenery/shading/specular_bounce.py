"""Mirrors and glass: where a path continues."""

import math

import numpy as np

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
    PIXEL_SIDE,
    PIXEL_SPREAD,
    PUPIL_RADIUS,
    PUPIL_SPREAD,
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
from lensbench.scenery.emission import DARK, DIRECT, SPECULAR
from lensbench.scenery.finish import ball_radius, is_ball, is_glass, is_specular
from lensbench.scenery.shading.illumination import INDEX
from lensbench.scenery.shading.rounding import rounded_length

LIFT = 4e-6             # offset of a new ray from the surface, as a fraction of `rounded_length`


@stage
def specular_bounce(lanes, p, ints, key):
    """Continue the paths that met metal or glass, end the others; key[ALIVE] = 0 where none continues.

    Metal reflects. A glass ball is crossed in one step, in closed form: refraction in, the chord 2 R cos θ′,
    refraction out at the same angle. A pane is crossed straight. A path that ends has no direction and meets nothing.
    It is SPECULAR where the surface BENDS. The footprint of a pixel grows with the length of the path, as it does
    behind plane mirrors; a ball of glass spreads it as it does near its axis.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, finish, nx, ny, nz = row[DEPTH], row[FINISH], row[NX], row[NY], row[NZ]
    tr, tg, tb, side, spread = row[TR], row[TG], row[TB], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    emits, path = row[EMITS], row[PATH]

    # End the paths that met neither
    many = np.int32(0)
    for i in range(B):
        on = is_specular(real, finish[i]) & (tr[i] + tg[i] + tb[i] > real(0))
        tr[i] = tr[i] if on else real(0)
        tg[i] = tg[i] if on else real(0)
        tb[i] = tb[i] if on else real(0)
        path[i] = real(SPECULAR) if emits[i] < real(DARK) else real(DIRECT)
        many = np.int32(many + np.int32(on))
    if many == 0:
        key[ALIVE] = np.uint32(0)
        return
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
        chord = real(2) * inner * ball_radius(real, finish[i])
        ex, ey, ez = ux + real(2) * inner * ix, uy + real(2) * inner * iy, uz + real(2) * inner * iz
        back = real(INDEX) * inner - cosine
        gx, gy, gz = real(INDEX) * ix - back * ex, real(INDEX) * iy - back * ey, real(INDEX) * iz - back * ez

        # Choose one of the three, and offset the ray from the surface
        lift = real(LIFT) * rounded_length(hx, hy, hz, t)
        lift = -lift if glass & (not ball) else lift
        sx, sy, sz = (ex, ey, ez) if ball else (ux, uy, uz)
        chord = chord if ball else real(0)
        px, py, pz = hx + chord * ix + lift * sx, hy + chord * iy + lift * sy, hz + chord * iz + lift * sz
        qx, qy, qz = (gx, gy, gz) if ball else (u, v, w) if glass else (mx, my, mz)
        size = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
        x[i], y[i], z[i] = px if on else x[i], py if on else y[i], pz if on else z[i]
        dx[i], dy[i], dz[i] = qx * size if on else real(0), qy * size if on else real(0), qz * size if on else real(0)

        # Carry the footprint: a glass ball is a thin lens at its centre, of the focal length n R / (2 (n − 1))
        radius = ball_radius(real, finish[i]) if ball else real(0)
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
