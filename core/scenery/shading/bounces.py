"""Where a path continues: mirrors and glass, meshes of glass, and one bounce of diffuse light.

`specular_bounce` reflects at metal and crosses panes and balls. Inside a ball of glass the path is reflected k times,
k = 0, 1, … with the probability F^k (1 − F) of Fresnel's sum, F Schlick's reflectance, which is the same at each
meeting: all light that enters leaves, each part where it does.

Two pairs of stages around it send on what it does not: they find the ray before it, in H0 … H6, and send it after it.
`solid_bend` and `solid_leave`: at meshes of glass, from inside reflected with the probability F.
`diffuse_bend` and `diffuse_leave`: from the first matte surface of a path, in proportion to the cosine. What that ray
meets is lit by every light and adds its light to the path; the sky adds its own (`diffuse_sky`). Lights that it meets
by chance add nothing, because the surface has their light already. `diffuse_end` ends it; mirrors and glass do too, and
surfaces seen in mirrors have no such light.
"""

import math

import numpy as np
from numba import uint32

from lensbench.core.kernels.block import (
    ALIVE, BLUE, DEPTH, EMITS, FINISH, GREEN, H0, H1, H2, H3, H4, H5, H6, NX, NY, NZ, OX, OY, OZ, PATH, PIXEL,
    PIXEL_SIDE, PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD, RED, SAMPLE, SEED, TB, TG, TR, V0, V1, B, L, M, N, X, Y, Z,
    rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import cosine_direction, mix
from lensbench.core.scenery.intersect.sky import SKY_DISTANCE, gradient, sky_radiance
from lensbench.core.scenery.shading.illumination import AMBIENT, F0, INDEX, schlick_edge
from lensbench.core.scenery.surface_codes import (
    DARK, DIFFUSE, DIRECT, INSIDE, METAL, SPECULAR, ball_radius, is_ball, is_glass, is_solid, is_specular, shines
)


@njit(inline="always")
def rounded_length(hx, hy, hz, depth):
    """Length (mm) of which the point hx, hy, hz, met by a ray at the distance `depth`, is off by a part in 10⁷.

    Its coordinates are rounded, and so was the way to it: near the origin of the world, seen from afar, they are small
    and the way is long.
    """
    own = abs(hx) + abs(hy) + abs(hz)
    return own if own > depth else depth


SPECULAR_BOUNCE_LIFT = 4e-6             # offset of a new ray from the surface, as a fraction of `rounded_length`
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
    count, balls = np.int32(0), np.int32(0)
    for i in range(B):
        on = is_specular(real, finish[i]) & (tr[i] + tg[i] + tb[i] > real(0))
        tr[i] = tr[i] if on else real(0)
        tg[i] = tg[i] if on else real(0)
        tb[i] = tb[i] if on else real(0)
        path[i] = real(SPECULAR) if emits[i] < real(DARK) else real(DIRECT)
        count, balls = np.int32(count + np.int32(on)), np.int32(balls + np.int32(on & is_ball(real, finish[i])))
    if count == 0:
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
        dice, share = chance(real, key, salt, i, cosine) if inner_most else real(1), f
        for _ in range(inner_most):
            again = dice < share
            jx, jy, jz = ix - real(2) * inner * ex, iy - real(2) * inner * ey, iz - real(2) * inner * ez
            ix, iy, iz = jx if again else ix, jy if again else iy, jz if again else iz
            ex, ey, ez = (ex + real(2) * inner * ix if again else ex, ey + real(2) * inner * iy if again else ey,
                          ez + real(2) * inner * iz if again else ez)
            share *= f
        if inner_most:
            path[i] = real(DIRECT) if ball & (dice < f) else path[i]
        elif balls:
            clear = real(1) - f if ball else real(1)
            tr[i], tg[i], tb[i] = tr[i] * clear, tg[i] * clear, tb[i] * clear
        back = real(INDEX) * inner - cosine
        gx, gy, gz = real(INDEX) * ix - back * ex, real(INDEX) * iy - back * ey, real(INDEX) * iz - back * ez

        # Choose one of the three, and offset the ray from the surface
        lift = real(SPECULAR_BOUNCE_LIFT) * rounded_length(hx, hy, hz, t)
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


SOLID_BOUNCE_LIFT = 2e-5             # offset of the new ray from the surface, as a fraction of `rounded_length`


@stage
def solid_bend(lanes, p, ints, key):
    """H0 … H5: where paths that met a mesh of glass go on; H6: 1 for these, whose FINISH becomes METAL."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, finish, nx, ny, nz = row[DEPTH], row[FINISH], row[NX], row[NY], row[NZ]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    salt = chance_salt(key)
    for i in range(B):
        inside = finish[i] == real(INSIDE)
        solid = is_solid(real, finish[i])
        t = depth[i]
        u, v, w, ux, uy, uz = dx[i], dy[i], dz[i], nx[i], ny[i], nz[i]
        hx, hy, hz = x[i] + t * u, y[i] + t * v, z[i] + t * w
        cosine = -(u * ux + v * uy + w * uz)
        ratio = real(INDEX) if inside else real(1 / INDEX)
        square = real(1) - ratio * ratio * (real(1) - cosine * cosine)
        inner = math.sqrt(square if square > real(0) else real(0))
        f = real(F0) + real(1 - F0) * schlick_edge(real, inner if inside else cosine)
        total = (square < real(0)) | (inside & (chance(real, key, salt, i, cosine) < f))
        bend = ratio * cosine - inner
        a, b, c = ratio * u + bend * ux, ratio * v + bend * uy, ratio * w + bend * uz
        mirror = real(2) * cosine
        a, b, c = (u + mirror * ux if total else a, v + mirror * uy if total else b, w + mirror * uz if total else c)
        lift = real(SOLID_BOUNCE_LIFT) * rounded_length(hx, hy, hz, t)
        lift = lift if total else -lift
        px[i], py[i], pz[i] = hx + lift * ux, hy + lift * uy, hz + lift * uz
        size = real(1) / math.sqrt(a * a + b * b + c * c)
        qx[i], qy[i], qz[i] = a * size, b * size, c * size

        on[i] = real(1) if solid else real(0)
        finish[i] = real(METAL) if solid else finish[i]


@stage
def solid_leave(lanes, p, ints, key):
    """Send the paths that met a mesh of glass where `solid_bend` found, after `specular_bounce`."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, tr, tg, tb = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TR], row[TG], row[TB]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    for i in range(B):
        solid = (on[i] > real(0.5)) & (tr[i] + tg[i] + tb[i] > real(0))
        x[i], y[i], z[i] = px[i] if solid else x[i], py[i] if solid else y[i], pz[i] if solid else z[i]
        dx[i], dy[i], dz[i] = qx[i] if solid else dx[i], qy[i] if solid else dy[i], qz[i] if solid else dz[i]


DIFFUSE_BOUNCE_LIFT = 2e-5             # offset of the new ray from the surface, as a fraction of `rounded_length`
MARK = 2.0              # H6 of a path that bounces


@stage
def diffuse_bend(lanes, p, ints, key):
    """H0 … H5: a ray from each matte surface, in proportion to the cosine by V0 and V1; H6: MARK for these."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    nx, ny, nz, red, green, blue, v0, v1 = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE], row[V0], row[V1]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    for i in range(B):
        lit = red[i] + green[i] + blue[i] > real(0)
        t = depth[i]
        hx, hy, hz = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        lift = real(DIFFUSE_BOUNCE_LIFT) * rounded_length(hx, hy, hz, t)
        a, b, c = cosine_direction(real, v0[i], v1[i], nx[i], ny[i], nz[i])
        px[i] = hx + lift * nx[i] if lit else px[i]
        py[i] = hy + lift * ny[i] if lit else py[i]
        pz[i] = hz + lift * nz[i] if lit else pz[i]
        qx[i], qy[i], qz[i] = a if lit else qx[i], b if lit else qy[i], c if lit else qz[i]
        on[i] = real(MARK) if lit else on[i] if on[i] != real(MARK) else real(0)


@stage
def diffuse_leave(lanes, p, ints, key):
    """Send the rays of `diffuse_bend`, after `specular_bounce` and `solid_leave`, with light samples of their own."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, tr, tg, tb = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TR], row[TG], row[TB]
    red, green, blue, path, v0, v1 = row[RED], row[GREEN], row[BLUE], row[PATH], row[V0], row[V1]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    count = np.int32(0)
    for i in range(B):
        sent = on[i] == real(MARK)
        x[i], y[i], z[i] = px[i] if sent else x[i], py[i] if sent else y[i], pz[i] if sent else z[i]
        dx[i], dy[i], dz[i] = qx[i] if sent else dx[i], qy[i] if sent else dy[i], qz[i] if sent else dz[i]
        tr[i], tg[i], tb[i] = red[i] if sent else tr[i], green[i] if sent else tg[i], blue[i] if sent else tb[i]
        path[i] = real(DIFFUSE) if sent else path[i]
        count = np.int32(count + np.int32(sent))
    if count == 0:
        return
    key[ALIVE] = np.uint32(1)
    salt = mix(uint32(key[SAMPLE] + mix(uint32(key[SEED] + np.uint32(0x51ED270B)))))
    unit = real(1 / 16777216)
    for i in range(B):
        a = mix(uint32(uint32(key[PIXEL] + uint32(i)) ^ salt))
        b = mix(uint32(a + np.uint32(0x9E3779B9)))
        sent = on[i] == real(MARK)
        v0[i] = real(np.int32(a >> np.uint32(8))) * unit if sent else v0[i]
        v1[i] = real(np.int32(b >> np.uint32(8))) * unit if sent else v1[i]


@stage
def diffuse_sky(lanes, p, ints, key):
    """Sky and ambient light for rays after a diffuse bounce that meet the sky.  p: SURROUND numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, depth, emits, path = row[L], row[M], row[N], row[DEPTH], row[EMITS], row[PATH]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    colours, (ar, ag, ab) = gradient(p, 0), vector(p, AMBIENT)
    for i in range(B):
        escaped = (path[i] == real(DIFFUSE)) & (depth[i] >= real(SKY_DISTANCE)) & shines(real, emits[i])
        r, g, b = sky_radiance(real, colours, dx[i], dy[i], dz[i])
        red[i], green[i], blue[i] = (ar + r if escaped else red[i], ag + g if escaped else green[i],
                                     ab + b if escaped else blue[i])


@stage
def diffuse_end(lanes, p, ints, key):
    """End the paths of a diffuse bounce, after `gather_emission`: the light of their surface is still to be added."""
    real = lanes.dtype.type
    row = rows(lanes)
    tr, tg, tb, path = row[TR], row[TG], row[TB], row[PATH]
    for i in range(B):
        done = path[i] == real(DIFFUSE)
        tr[i], tg[i], tb[i] = real(0) if done else tr[i], real(0) if done else tg[i], real(0) if done else tb[i]
