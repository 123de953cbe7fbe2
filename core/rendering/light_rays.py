"""Light on its way to the camera: from a point of a small light to a point of a plane before the lens.

Both points are drawn evenly, the one from a parallelogram or ellipse that hides
the light as seen from there, the other from a rectangle through which passes all that
can pass the lens. The ray is followed *from* the plane to the light, as the
camera's own rays are, so that what is in between is found by the same stages; then
it is turned round. On its way it may be bent once: by a flat mirror or pane, behind which the light is
imagined, or by a ball (`detours`). Camera frame, mm.
"""

import math

import numpy as np
from numba import njit

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
    A9,
    A10,
    ALIVE,
    BLUE,
    EMITS,
    GREEN,
    H0,
    H1,
    H2,
    H3,
    H4,
    H5,
    LOST,
    PIXEL,
    RED,
    TB,
    TG,
    TR,
    U0,
    U1,
    V0,
    V1,
    WEIGHT,
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
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.scenery.shading.illumination import INDEX

LIGHT = 34              # numbers per light: see `light_parameters`
FLOW, MARK, BY, BALL = 25, 26, 27, 28       # of them the étendue of a sample, EMITS of the object and of the bend, ball
ROUNDS = 4              # of Newton, from where the light's middle is met
MOST = 1.0 - 1e-6       # of the ball's radius: how far from its centre a path may pass


def light_parameters(marks, middles, half_axes, towards, centres, rights, ups, disks, shares, by, balls) -> np.ndarray:
    """Numbers of n lights for `emit`, `emit_by_ball` and `turn_back`: (n, LIGHT).

    marks: the EMITS of what each shines from; middles (n, 3), half_axes (n, 2, 3), towards (n, 3): of the rectangle
    before the lens, its unit normal pointing at the light; centres, rights, ups (n, 3), disks (n,): what hides the
    light, half-axes; shares (n,): of its étendue that each sample stands for, with the rectangle's area in it; by (n,):
    the EMITS of what bends its rays; balls (n, 6): of that if it is a ball the centre, the radius, 1 for metal and −1
    for glass, and how far from the centre the ray of the light's middle passes it.
    """
    normals = np.cross(rights, ups)
    areas = np.sqrt((normals**2).sum(1))
    flows = areas * np.where(disks, math.pi, 4.0) * shares
    return np.column_stack([middles, half_axes.reshape(-1, 6), towards, centres, rights, ups, normals / areas[:, None],
                            disks, flows, marks, by, balls])


@stage
def emit(lanes, p, key):
    """From U0, U1 and V0, V1 a ray from the plane before the lens to light number key[PIXEL]; WEIGHT is its étendue.

    p: light_parameters of every light.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT
    wx, wy, wz, ux, uy, uz, flow = p[s + 9], p[s + 10], p[s + 11], p[s + 21], p[s + 22], p[s + 23], p[s + FLOW]
    _ends(lanes, p, s)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    for i in range(B):
        a, b, c = l[i] - x[i], m[i] - y[i], n[i] - z[i]
        per = real(1) / (a * a + b * b + c * c)
        size = math.sqrt(per)
        # cos · cos / d²: both of the products below hold d once
        weight[i] = abs(a * wx + b * wy + c * wz) * per * abs(a * ux + b * uy + c * uz) * per * flow
        l[i], m[i], n[i] = a * size, b * size, c * size
    _hold(lanes)


@stage
def _ends(lanes, p, s):
    """X, Y, Z: the point of the plane; L, M, N: the point of the light."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1]
    v0, v1 = row[V0], row[V1]
    px, py, pz, ax, ay, az, bx, by, bz = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6], p[s + 7], (
        p[s + 8])
    cx, cy, cz, ex, ey, ez, fx, fy, fz = p[s + 12], p[s + 13], p[s + 14], p[s + 15], p[s + 16], p[s + 17], p[s + 18], (
        p[s + 19]), p[s + 20]
    round_one = p[s + 24] > real(0)
    for i in range(B):
        a, b = real(2) * u[i] - real(1), real(2) * v[i] - real(1)
        x[i], y[i], z[i] = px + a * ax + b * bx, py + a * ay + b * by, pz + a * az + b * bz
    for i in range(B):
        q, r = concentric_disk(real, v0[i], v1[i])
        a = q if round_one else real(2) * v0[i] - real(1)
        b = r if round_one else real(2) * v1[i] - real(1)
        l[i], m[i], n[i] = cx + a * ex + b * fx, cy + a * ey + b * fy, cz + a * ez + b * fz


@stage
def _hold(lanes):
    """H0 … H5: the ray as it is now."""
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    hx, hy, hz, hl, hm, hn = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        hx[i], hy[i], hz[i], hl[i], hm[i], hn[i] = x[i], y[i], z[i], l[i], m[i], n[i]


@njit(inline="always")
def _turned(real, b, away, per, metal):
    """A ray that passes a ball's centre at b: its direction after it (2), d turn / d b, its direction before it (2).

    In the plane of the path, along the way to the centre, `away` mm long, and across; per: 1 / R.
    """
    sine, inner = b * per, real(1) if metal else b * per * real(1 / INDEX)
    cosine, within = math.sqrt(real(1) - sine * sine), math.sqrt(real(1) - inner * inner)
    c, e = cosine * within + sine * inner, sine * within - cosine * inner
    turn_c, turn_s = real(2) * c * c - real(1), real(2) * e * c
    slope = real(2) * per * (real(1) / cosine - (real(0) if metal else real(1 / INDEX) / within))
    leaving_s = b / away
    leaving_c = math.sqrt(real(1) - leaving_s * leaving_s)
    return (leaving_c * turn_c + leaving_s * turn_s, leaving_s * turn_c - leaving_c * turn_s, slope,
            leaving_c, leaving_s)


@stage
def emit_by_ball(lanes, p, key):
    """As `emit`, but the ray meets the light by way of a ball.

    The path lies in the plane of its ends and the ball's centre. It passes that at the same distance b before and
    after the ball, which turns it by 2 (θ − θ′), sin θ = b / R; θ′ is the angle in the glass, π/2 for a mirror. b is
    found by Newton's method. What a solid angle at the plane covers at the light follows from the slope of the turn.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT
    _ends(lanes, p, s)
    _plane_of_the_path(lanes, p[s + BALL:s + LIGHT])
    radius, metal = p[s + BALL + 3], p[s + BALL + 4] > real(0)
    per, most = real(1) / radius, radius * real(MOST)
    away, along, across, off, miss = row[A6], row[A7], row[A8], row[A9], row[A10]
    for _ in range(ROUNDS):
        for i in range(B):
            b, d = off[i], away[i]
            vx, vy, slope, leaving_c, _ = _turned(real, b, d, per, metal)
            ahead = along[i] * vx + across[i] * vy
            miss[i] = across[i] * vx - along[i] * vy - b
            b += miss[i] / (ahead * (real(1) / (d * leaving_c) - slope) + real(1))
            b = b if b > real(0) else real(0)
            off[i] = b if b < most else most
    _leave(lanes, p, s)
    _hold(lanes)


@stage
def _plane_of_the_path(lanes, p):
    """The plane of both ends and the ball's centre: unit axes from the end before the lens to the centre, A0 … A2, and
    across, to the side where the ray passes, A3 … A5; the centre's distance A6, and of the light from there A7, A8.

    A9: the first b. p: the ball's numbers of light_parameters.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    ax, ay, az, bx, by, bz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    away, along, across, off = row[A6], row[A7], row[A8], row[A9]
    cx, cy, cz, side, first = p[0], p[1], p[2], p[4], p[5]
    for i in range(B):
        a, b, c = cx - x[i], cy - y[i], cz - z[i]
        d = math.sqrt(a * a + b * b + c * c)
        a, b, c = a / d, b / d, c / d
        e, f, g = l[i] - cx, m[i] - cy, n[i] - cz
        t = a * e + b * f + c * g
        e, f, g = e - t * a, f - t * b, g - t * c
        size = math.sqrt(e * e + f * f + g * g) + real(1e-20)
        per = side / size
        ax[i], ay[i], az[i], bx[i], by[i], bz[i] = a, b, c, e * per, f * per, g * per
        away[i], along[i], across[i], off[i] = d, t, side * size, first


@stage
def _leave(lanes, p, s):
    """L, M, N: the ray that passes the ball's centre at the distance b, A9; WEIGHT: its étendue, 0 where b is wrong."""
    real = lanes.dtype.type
    row = rows(lanes)
    l, m, n, weight = row[L], row[M], row[N], row[WEIGHT]
    ax, ay, az, bx, by, bz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    away, along, across, off, miss = row[A6], row[A7], row[A8], row[A9], row[A10]
    wx, wy, wz, ux, uy, uz, flow = p[s + 9], p[s + 10], p[s + 11], p[s + 21], p[s + 22], p[s + 23], p[s + FLOW]
    radius, metal = p[s + BALL + 3], p[s + BALL + 4] > real(0)
    per = real(1) / radius
    for i in range(B):
        b, d = off[i], away[i]
        vx, vy, slope, leaving_c, leaving_s = _turned(real, b, d, per, metal)
        ahead = along[i] * vx + across[i] * vy
        # how much the angle at the centre between the ends changes with b, and b over the sine of that angle
        opening = abs(slope - real(1) / (d * leaving_c) - real(1) / ahead)
        aside = abs(across[i])
        ratio = b / aside if aside > real(1e-4) * ahead else real(1) / (ahead * opening)
        gx, gy, gz = vx * ax[i] + vy * bx[i], vx * ay[i] + vy * by[i], vx * az[i] + vy * bz[i]
        x, y, z = leaving_c * ax[i] + leaving_s * bx[i], leaving_c * ay[i] + leaving_s * by[i], (
            leaving_c * az[i] + leaving_s * bz[i])
        spread = ratio * abs(gx * ux + gy * uy + gz * uz) / (d * d * leaving_c * ahead * opening)
        found = (abs(miss[i]) < real(1e-4) * ahead) & (ahead > real(0))
        weight[i] = abs(x * wx + y * wy + z * wz) * spread * flow if found else real(0)
        l[i], m[i], n[i] = x, y, z


@stage
def bent_there(lanes, p, key):
    """A ray is lost where it has not met what is to bend it.  p: as for `emit`."""
    real = lanes.dtype.type
    row = rows(lanes)
    by = p[np.int64(key[PIXEL]) * LIGHT + BY]
    weight, glow = row[WEIGHT], row[EMITS]
    many = np.int32(0)
    for i in range(B):
        weight[i] = weight[i] if glow[i] == by else real(0)
        many = np.int32(many + np.int32(weight[i] > real(0)))
    if many == 0:
        key[ALIVE] = np.uint32(LOST)


@stage
def carry_on(lanes, p, key):
    """RED, GREEN, BLUE: as much of what is met as the path carries on."""
    row = rows(lanes)
    red, green, blue, tr, tg, tb = row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB]
    for i in range(B):
        red[i], green[i], blue[i] = red[i] * tr[i], green[i] * tg[i], blue[i] * tb[i]


@stage
def turn_back(lanes, p, key):
    """The ray of `emit` again, but towards the lens; lost where EMITS, as marking_steps left it, is another's.

    p: as for `emit`.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    mark = p[np.int64(key[PIXEL]) * LIGHT + MARK]
    x, y, z, l, m, n, weight, glow = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[EMITS]
    hx, hy, hz, hl, hm, hn = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        x[i], y[i], z[i], l[i], m[i], n[i] = hx[i], hy[i], hz[i], -hl[i], -hm[i], -hn[i]
        weight[i] = weight[i] if glow[i] == mark else real(0)
