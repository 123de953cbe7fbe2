"""The sun and the lamps: one point of the light a sample, V0 and V1 choose which, and one shadow ray to it.

Lights cast no shadow themselves. A glass ball's shadow is bright in its middle:
it lets through what its two surfaces transmit, gathered towards the axis, an
approximation without a second ray (its flux is right, its place for contact).
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
    BLUE,
    DEPTH,
    GREEN,
    NX,
    NY,
    NZ,
    RED,
    SB,
    SG,
    SR,
    V0,
    V1,
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
from lensbench.scenery.intersect.block_bounds import boxes_disjoint, plane_misses, shadow_bounds
from lensbench.scenery.intersect.planar import plate_frame
from lensbench.scenery.shading.illumination import count_lit

BALL = 5                # numbers per sphere: centre, radius², what it lets through
SHADE = 17              # per plate: its frame, what it lets through, its half-widths along x, y, z
GLASS_BALL = 0.85       # part of the light that passes a glass ball, all incidences together
RECTANGLE_LAMP, DISK_LAMP, SPHERE_LAMP = range(3)
SUN, LAMP = 12, 18      # numbers before the casters of the sun, of a lamp


def occluder_parameters(spheres, plates) -> np.ndarray:
    """What `shadow` reads: the number of spheres, the spheres, then the plates; lights are left out."""
    balls = [s for s in spheres if not s.material.shines]
    packed = [float(len(balls))]
    for s in balls:
        packed += [*s.centre, s.radius**2, GLASS_BALL if s.material.kind == "glass" else 0.0]
    for plate in plates:
        if not plate.material.shines:
            centre, a, b, normal, disk = plate_frame(plate)
            packed += [*centre, *normal, *(a / (a @ a)), *(b / (b @ b)), disk, float(plate.material.kind == "glass"),
                       *(abs(a) + abs(b))]
    return np.array(packed)


def lamp_parameters(light) -> np.ndarray:
    """Kind, centre, half-axes, unit normal, area, radius², radiance of a plate or sphere that is a lamp."""
    if not hasattr(light, "right"):
        return np.array([SPHERE_LAMP, *light.centre, *(0.0,) * 9, 0.0, light.radius**2, *light.material.colour])
    centre, a, b, normal, disk = plate_frame(light)
    area = math.sqrt((a @ a) * (b @ b)) * (math.pi if disk else 4.0)
    return np.array([DISK_LAMP if disk else RECTANGLE_LAMP, *centre, *a, *b, *normal, area, 0.0,
                     *light.material.colour])


def point_parameters(light) -> np.ndarray:
    """What `open_light` reads of a lamp."""
    numbers = lamp_parameters(light)
    return np.array([*numbers[1:4], *(numbers[10:13] * numbers[13] / math.pi), *numbers[14:]])


@stage
def shadow(lanes, p):
    """A7, light that arrives at A0 A1 A2 from the unit direction A3 A4 A5 at distance A6, less what stands between."""
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz, far, light = (row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7])
    if p.size == 1:
        return
    box = shadow_bounds(lanes)
    end = 1 + BALL * int(p[0])
    for s in range(1, end, BALL):
        cx, cy, cz, r2, clear = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4]
        radius = math.sqrt(r2)
        if boxes_disjoint(box, cx, cy, cz, radius, radius, radius):
            continue
        for i in range(B):
            ax, ay, az = cx - hx[i], cy - hy[i], cz - hz[i]
            along = ax * wx[i] + ay * wy[i] + az * wz[i]
            ox, oy, oz = ax - along * wx[i], ay - along * wy[i], az - along * wz[i]
            room = r2 - (ox * ox + oy * oy + oz * oz)
            inner = room / r2
            held = (room > real(0)) & (along > real(0)) & (along < far[i])
            # ∫ 4 (1 − ρ²)³ dρ² = 1: the flux over the ball's disk stays `clear`
            light[i] *= clear * real(4) * inner * inner * inner if held else real(1)
    for s in range(end, p.size, SHADE):
        cx, cy, cz, ux, uy, uz = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5]
        ax, ay, az, bx, by, bz, disk, clear = (p[s + 6], p[s + 7], p[s + 8], p[s + 9], p[s + 10], p[s + 11],
                                               p[s + 12], p[s + 13])
        wide_x, wide_y, wide_z = p[s + 14], p[s + 15], p[s + 16]
        if boxes_disjoint(box, cx, cy, cz, wide_x, wide_y, wide_z) or plane_misses(box, cx, cy, cz, ux, uy, uz):
            continue
        for i in range(B):
            ox, oy, oz = hx[i] - cx, hy[i] - cy, hz[i] - cz
            off = ox * ux + oy * uy + oz * uz
            # a point of the plate itself is off it by the rounding of its coordinates, whatever the angle
            blur = real(4e-6) * (abs(hx[i]) + abs(hy[i]) + abs(hz[i]))
            t = -off / (wx[i] * ux + wy[i] * uy + wz[i] * uz)
            qx, qy, qz = ox + t * wx[i], oy + t * wy[i], oz + t * wz[i]
            qa, qb = qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz
            a2, b2 = qa * qa, qb * qb
            most = a2 if a2 > b2 else b2
            held = (most + disk * (a2 + b2 - most) <= real(1)) & (t > real(0)) & (t < far[i]) & (abs(off) > blur)
            light[i] *= clear if held else real(1)


@stage
def disk_points(lanes):
    """A6, A7: the points V0, V1 of the square on the unit disk, of equal area, neighbours kept."""
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1, p, q = row[V0], row[V1], row[A6], row[A7]
    for i in range(B):
        p[i], q[i] = concentric_disk(real, v0[i], v1[i])


@stage
def sun(lanes, p, key):
    """Add the light of the sun.

    p: unit direction (3), two unit axes across it times the tangent of its angular radius (6), irradiance / π (3),
    then occluder_parameters.
    """
    if count_lit(lanes) == 0:
        return
    sample_sun(lanes, p)
    shadow(lanes, p[SUN:])
    add_light(lanes, p[9], p[10], p[11])


@stage
def add_light(lanes, r, g, b):
    """Add the light A7, of this colour, to what the path gathers."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb, light = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB], row[A7]
    for i in range(B):
        sr[i] += red[i] * light[i] * r
        sg[i] += green[i] * light[i] * g
        sb[i] += blue[i] * light[i] * b


@stage
def sample_sun(lanes, p):
    """A0 … A7 as `shadow` reads them, towards a point of the sun; p: as `sun` has it."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, nx, ny, nz, hx, hy, hz = row[DEPTH], row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    disk_points(lanes)
    for i in range(B):
        t, a, b = depth[i], far[i], light[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        qx, qy, qz = p[0] + a * p[3] + b * p[6], p[1] + a * p[4] + b * p[7], p[2] + a * p[5] + b * p[8]
        size = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
        qx, qy, qz = qx * size, qy * size, qz * size
        slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
        wx[i], wy[i], wz[i], far[i] = qx, qy, qz, real(math.inf)
        light[i] = slant if slant > real(0) else real(0)


@stage
def lamp(lanes, p, key):
    """Add the light of one lamp: a rectangle or disk that shines to both sides, or a sphere.

    A point of a plate is drawn by area: L cos θ cos θ′ A / (π d²). A sphere is drawn by the solid angle
    2π (1 − cos θm), sin θm = r / d, that it fills: L cos θ · 2 (1 − cos θm). p: lamp_parameters, occluder_parameters.
    """
    if count_lit(lanes) == 0:
        return
    sample_lamp(lanes, p)
    shadow(lanes, p[LAMP:])
    add_light(lanes, p[15], p[16], p[17])


@stage
def sample_lamp(lanes, p):
    """A0 … A7 as `shadow` reads them, towards a point of the lamp; p: lamp_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, nx, ny, nz, hx, hy, hz = row[DEPTH], row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    v0, v1, wx, wy, wz, far, light = row[V0], row[V1], row[A3], row[A4], row[A5], row[A6], row[A7]
    kind, cx, cy, cz = p[0], p[1], p[2], p[3]
    ax, ay, az, bx, by, bz, ux, uy, uz = p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], p[12]
    flow, r2 = p[13] * real(1 / math.pi), p[14]
    if kind == RECTANGLE_LAMP:
        for i in range(B):
            far[i], light[i] = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
    else:
        disk_points(lanes)
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
    if kind == SPHERE_LAMP:
        for i in range(B):
            a, b = far[i], light[i]
            qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
            d2 = qx * qx + qy * qy + qz * qz
            size = real(1) / math.sqrt(d2)
            qx, qy, qz = qx * size, qy * size, qz * size
            sine2 = r2 / d2
            sine2 = sine2 if sine2 < real(1) else real(1)
            cap = sine2 / (real(1) + math.sqrt(real(1) - sine2))
            low = (a * a + b * b) * cap
            out = math.sqrt(cap * (real(2) - low))
            # two axes across q, without a branch (Duff et al. 2017)
            sign = real(1) if qz >= real(0) else real(-1)
            e = real(-1) / (sign + qz)
            f = qx * qy * e
            a, b, c = a * out, b * out, real(1) - low
            px = c * qx + a * (real(1) + sign * qx * qx * e) + b * f
            py = c * qy + a * sign * f + b * (sign + qy * qy * e)
            pz = c * qz - a * sign * qx - b * qy
            slant = nx[i] * px + ny[i] * py + nz[i] * pz
            wx[i], wy[i], wz[i], far[i] = px, py, pz, math.sqrt(d2 - r2 if d2 > r2 else real(0))
            light[i] = real(2) * cap * (slant if slant > real(0) else real(0))
    else:
        for i in range(B):
            a, b = far[i], light[i]
            qx, qy, qz = cx + a * ax + b * bx - hx[i], cy + a * ay + b * by - hy[i], cz + a * az + b * bz - hz[i]
            d2 = qx * qx + qy * qy + qz * qz
            size = real(1) / math.sqrt(d2)
            qx, qy, qz = qx * size, qy * size, qz * size
            slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
            facing = abs(ux * qx + uy * qy + uz * qz)
            arriving = slant * facing * flow / d2
            wx[i], wy[i], wz[i], far[i] = qx, qy, qz, d2 * size
            light[i] = arriving if arriving > real(0) else real(0)
