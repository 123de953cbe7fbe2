"""Rays of light tracing: from a point of a small light to a point on the entrance rectangle of the lens.

Both points are drawn uniformly: the first from a parallelogram or ellipse that covers the light as seen from the lens,
the second from the rectangle on the entrance plane through which all light that can pass the lens passes
(`entrance_bounds`). The ray is followed *from* the entrance plane *to* the light, as a camera's own ray is, so that the
same stages find what lies between; then it is reversed.

One specular object may lie on the path. A flat mirror shows a light at its mirror image; a pane shows it where it is.
The path by a ball lies in the plane of its ends and the ball's centre, and passes the centre at the same distance
before and after the ball; the angle at the centre between its ends grows with that distance, so that there is one path,
and Newton's method finds it.

Camera frame, mm. The step parameters are those of `light_parameters`, LIGHT_SIZE numbers for each light; the integers
of the stages that aim are 1 for each light that is an ellipse and 0 for a parallelogram. key[PIXEL] holds the number
of the light.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, ALIVE, BLUE, EMITS, GREEN, H0, H1, H2, H3, H4, H5, LOST, PIXEL, RED,
    TB, TG, TR, U0, U1, V0, V1, WEIGHT, B, L, M, N, X, Y, Z, offsets, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.scenery.intersect.moving_objects import keep_world
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.illumination import INDEX

# One light. ENTRANCE, ENTRANCE_A, ENTRANCE_B: middle and half-axes of the rectangle on the entrance plane (mm), and its
# unit normal towards the light; CENTRE, RIGHT, UP: of what covers the light, middle and half-axes (mm), NORMAL: unit,
# of these; ETENDUE: area of the light × area of the rectangle × share of one sample (mm⁴); LIGHT_MARK, MIRROR_MARK:
# MARK of the object that shines and of the specular one on the path; BALL: centre and radius (mm) of the ball on the
# path; BALL_SIDE: on which side of its centre the ray passes, seen from the light: 1 metal, −1 glass; BALL_START: first
# guess of b (mm)
(ENTRANCE, ENTRANCE_A, ENTRANCE_B, ENTRANCE_NORMAL, CENTRE, RIGHT, UP, NORMAL, ETENDUE, LIGHT_MARK, MIRROR_MARK, BALL,
 BALL_RADIUS, BALL_SIDE, BALL_START, LIGHT_SIZE) = offsets(3, 3, 3, 3, 3, 3, 3, 3, 1, 1, 1, 3, 1, 1, 1)
MARK = EMITS            # the row where `Scene.marking_steps` leaves which object was met

# Rows that `trace_by_ball` and its parts share
(AXIS_X, AXIS_Y, AXIS_Z,        # unit, from the entrance point to the ball's centre
 CROSS_X, CROSS_Y, CROSS_Z,     # unit, across that in the plane of the path, to the side where the ray passes
 BALL_DISTANCE,                 # from the entrance point to the ball's centre, mm
 LIGHT_ALONG, LIGHT_ACROSS,     # from the ball's centre to the point of the light along both axes, mm
 OFFSET,                        # b: distance at which the ray passes the ball's centre, mm
 RESIDUAL,                      # by how much the ray with this b misses the point of the light, mm
 ) = A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10
# Rows that hold the ray as it leaves the entrance plane, while others follow it
KEPT_X, KEPT_Y, KEPT_Z, KEPT_L, KEPT_M, KEPT_N = H0, H1, H2, H3, H4, H5

NEWTON_STEPS = 4        # from the b of the light's middle
LARGEST_OFFSET = 1.0 - 1e-6     # b over the ball's radius, at the most


def light_parameters(marks: ArrayLike, middles: np.ndarray, half_axes: np.ndarray, towards: np.ndarray,
                     centres: np.ndarray, rights: np.ndarray, ups: np.ndarray, disks: np.ndarray, shares: np.ndarray,
                     mirrors: ArrayLike, balls: np.ndarray) -> np.ndarray:
    """Parameters (n, LIGHT_SIZE) of n lights for the stages below; camera frame, mm.

    marks (n,): MARK of the objects that shine; middles (n, 3), half_axes (n, 2, 3), towards (n, 3): of the
    rectangles on the entrance planes, unit normals towards the light; centres, rights, ups (n, 3), disks (n,) bool:
    the ellipses or parallelograms that cover the lights, by half-axes; shares (n,): rectangle area over the
    number of samples; mirrors (n,): MARK of the specular objects on the paths; balls (n, 6): of those that are
    balls the centre, radius, side and first guess of b.
    """
    normals = np.cross(rights, ups)
    areas = np.sqrt((normals**2).sum(1))
    numbers = np.empty((len(middles), LIGHT_SIZE))
    for column, vectors in ((ENTRANCE, middles), (ENTRANCE_A, half_axes[:, 0]), (ENTRANCE_B, half_axes[:, 1]),
                        (ENTRANCE_NORMAL, towards), (CENTRE, centres), (RIGHT, rights), (UP, ups),
                        (NORMAL, normals / areas[:, None])):
        numbers[:, column:column + 3] = vectors
    numbers[:, ETENDUE] = areas * np.where(disks, math.pi, 4.0) * shares
    numbers[:, LIGHT_MARK], numbers[:, MIRROR_MARK] = marks, mirrors
    numbers[:, BALL:] = balls
    return numbers


@stage
def trace_to_light(lanes, p, ints, key):
    """The ray from an entrance point (by U0, U1) to a point of the light (by V0, V1); WEIGHT: its étendue, mm²·sr."""
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT_SIZE
    (wx, wy, wz), (ux, uy, uz), etendue = vector(p, s + ENTRANCE_NORMAL), vector(p, s + NORMAL), p[s + ETENDUE]

    # Sample both ends
    _sample_ends(lanes, p, s, ints[np.int64(key[PIXEL])])

    # Connect them
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    for i in range(B):
        a, b, c = l[i] - x[i], m[i] - y[i], n[i] - z[i]
        per = real(1) / (a * a + b * b + c * c)
        size = math.sqrt(per)
        # cos · cos / d²: each product below holds one d
        weight[i] = abs(a * wx + b * wy + c * wz) * per * abs(a * ux + b * uy + c * uz) * per * etendue
        l[i], m[i], n[i] = a * size, b * size, c * size
    keep_world(lanes, X, L, False)


@stage
def _sample_ends(lanes, p, s, is_round):
    """X, Y, Z: a point of the entrance rectangle; L, M, N: a point of the light (not yet a direction).

    is_round: 1 for an ellipse, 0 for a parallelogram.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1]
    v0, v1 = row[V0], row[V1]
    (px, py, pz), (ax, ay, az) = vector(p, s + ENTRANCE), vector(p, s + ENTRANCE_A)
    (bx, by, bz), (cx, cy, cz) = vector(p, s + ENTRANCE_B), vector(p, s + CENTRE)
    (ex, ey, ez), (fx, fy, fz) = vector(p, s + RIGHT), vector(p, s + UP)
    for i in range(B):
        a, b = real(2) * u[i] - real(1), real(2) * v[i] - real(1)
        x[i], y[i], z[i] = px + a * ax + b * bx, py + a * ay + b * by, pz + a * az + b * bz
    for i in range(B):
        q, r = concentric_disk(real, v0[i], v1[i])
        a = q if is_round else real(2) * v0[i] - real(1)
        b = r if is_round else real(2) * v1[i] - real(1)
        l[i], m[i], n[i] = cx + a * ex + b * fx, cy + a * ey + b * fy, cz + a * ez + b * fz


@njit(inline="always")
def _deflected(real, b, distance, per, metal):
    """Direction of a ray after a ball whose centre it passes at b (2), d deflection / d b, direction before it (2).

    Directions in the plane of the path: along the axis to the centre, `distance` mm long, and across. per: 1 / R.
    """
    sine, inner = b * per, real(1) if metal else b * per * real(1 / INDEX)
    cosine, within = math.sqrt(real(1) - sine * sine), math.sqrt(real(1) - inner * inner)
    # θ − θ′, and twice that
    c, e = cosine * within + sine * inner, sine * within - cosine * inner
    turn_c, turn_s = real(2) * c * c - real(1), real(2) * e * c
    slope = real(2) * per * (real(1) / cosine - (real(0) if metal else real(1 / INDEX) / within))
    leaving_s = b / distance
    leaving_c = math.sqrt(real(1) - leaving_s * leaving_s)
    return (leaving_c * turn_c + leaving_s * turn_s, leaving_s * turn_c - leaving_c * turn_s, slope,
            leaving_c, leaving_s)


@stage
def trace_by_ball(lanes, p, ints, key):
    """The ray from an entrance point to a point of the light by way of a ball; WEIGHT: its étendue, mm²·sr.

    The path lies in the plane of its ends and the ball's centre. It passes the centre at the same distance b
    before and after the ball, which deflects it by 2 (θ − θ′), sin θ = b / R; θ′ is the angle inside the glass, π/2
    for a mirror. Newton's method finds b. The slope of the deflection gives the area of the light that a
    solid angle at the entrance plane covers.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT_SIZE
    radius, metal = p[s + BALL_RADIUS], p[s + BALL_SIDE] > real(0)

    # Sample both ends
    _sample_ends(lanes, p, s, ints[np.int64(key[PIXEL])])
    _find_path_plane(lanes, p, s)

    # Find b by Newton's method
    per, most = real(1) / radius, radius * real(LARGEST_OFFSET)
    distance, along, across = row[BALL_DISTANCE], row[LIGHT_ALONG], row[LIGHT_ACROSS]
    offset, residual = row[OFFSET], row[RESIDUAL]
    for _ in range(NEWTON_STEPS):
        for i in range(B):
            b, d = offset[i], distance[i]
            vx, vy, slope, leaving_c, _ = _deflected(real, b, d, per, metal)
            ahead = along[i] * vx + across[i] * vy
            residual[i] = across[i] * vx - along[i] * vy - b
            b += residual[i] / (ahead * (real(1) / (d * leaving_c) - slope) + real(1))
            b = b if b > real(0) else real(0)
            offset[i] = b if b < most else most

    # Set the ray and its étendue
    _aim_at_ball(lanes, p, s)
    keep_world(lanes, X, L, False)


@stage(inlined=True)
def _find_path_plane(lanes, p, s):
    """AXIS, CROSS: the axes of the path's plane; BALL_DISTANCE, LIGHT_ALONG, LIGHT_ACROSS in it; OFFSET: first b."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    ax, ay, az, bx, by, bz = row[AXIS_X], row[AXIS_Y], row[AXIS_Z], row[CROSS_X], row[CROSS_Y], row[CROSS_Z]
    distance, along, across, offset = row[BALL_DISTANCE], row[LIGHT_ALONG], row[LIGHT_ACROSS], row[OFFSET]
    cx, cy, cz = vector(p, s + BALL)
    side, start = p[s + BALL_SIDE], p[s + BALL_START]
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
        distance[i], along[i], across[i], offset[i] = d, t, side * size, start


@stage(inlined=True)
def _aim_at_ball(lanes, p, s):
    """L, M, N: the ray that passes the ball's centre at OFFSET; WEIGHT: its étendue, 0 where b is wrong."""
    real = lanes.dtype.type
    row = rows(lanes)
    l, m, n, weight = row[L], row[M], row[N], row[WEIGHT]
    ax, ay, az, bx, by, bz = row[AXIS_X], row[AXIS_Y], row[AXIS_Z], row[CROSS_X], row[CROSS_Y], row[CROSS_Z]
    distance, along, across = row[BALL_DISTANCE], row[LIGHT_ALONG], row[LIGHT_ACROSS]
    offset, residual = row[OFFSET], row[RESIDUAL]
    (wx, wy, wz), (ux, uy, uz), etendue = vector(p, s + ENTRANCE_NORMAL), vector(p, s + NORMAL), p[s + ETENDUE]
    radius, metal = p[s + BALL_RADIUS], p[s + BALL_SIDE] > real(0)
    per = real(1) / radius
    for i in range(B):
        b, d = offset[i], distance[i]
        vx, vy, slope, leaving_c, leaving_s = _deflected(real, b, d, per, metal)
        ahead = along[i] * vx + across[i] * vy
        # Change with b of the angle at the centre between the ends; and b over the sine of that angle
        opening = abs(slope - real(1) / (d * leaving_c) - real(1) / ahead)
        aside = abs(across[i])
        ratio = b / aside if aside > real(1e-4) * ahead else real(1) / (ahead * opening)
        gx, gy, gz = vx * ax[i] + vy * bx[i], vx * ay[i] + vy * by[i], vx * az[i] + vy * bz[i]
        x, y, z = leaving_c * ax[i] + leaving_s * bx[i], leaving_c * ay[i] + leaving_s * by[i], (
            leaving_c * az[i] + leaving_s * bz[i])
        spread = ratio * abs(gx * ux + gy * uy + gz * uz) / (d * d * leaving_c * ahead * opening)
        converged = (abs(residual[i]) < real(1e-4) * ahead) & (ahead > real(0))
        weight[i] = abs(x * wx + y * wy + z * wz) * spread * etendue if converged else real(0)
        l[i], m[i], n[i] = x, y, z


@stage
def require_mirror(lanes, p, ints, key):
    """WEIGHT: 0 for rays that have not met the specular object of their path; MARK as marking_steps leaves it."""
    real = lanes.dtype.type
    row = rows(lanes)
    mark = p[np.int64(key[PIXEL]) * LIGHT_SIZE + MIRROR_MARK]
    weight, met = row[WEIGHT], row[MARK]
    left = np.int32(0)
    for i in range(B):
        weight[i] = weight[i] if met[i] == mark else real(0)
        left = np.int32(left + np.int32(weight[i] > real(0)))
    if left == 0:
        key[ALIVE] = np.uint32(LOST)


@stage
def apply_throughput(lanes, p, ints, key):
    """RED, GREEN, BLUE: times the throughput TR, TG, TB of the path."""
    row = rows(lanes)
    red, green, blue, tr, tg, tb = row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB]
    for i in range(B):
        red[i], green[i], blue[i] = red[i] * tr[i], green[i] * tg[i], blue[i] * tb[i]


@stage
def reverse_ray(lanes, p, ints, key):
    """The kept ray, reversed to run towards the lens; WEIGHT: 0 where something else than the light was met."""
    real = lanes.dtype.type
    row = rows(lanes)
    mark = p[np.int64(key[PIXEL]) * LIGHT_SIZE + LIGHT_MARK]
    x, y, z, l, m, n, weight, met = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[MARK]
    hx, hy, hz, hl, hm, hn = row[KEPT_X], row[KEPT_Y], row[KEPT_Z], row[KEPT_L], row[KEPT_M], row[KEPT_N]
    for i in range(B):
        x[i], y[i], z[i], l[i], m[i], n[i] = hx[i], hy[i], hz[i], -hl[i], -hm[i], -hn[i]
        weight[i] = weight[i] if met[i] == mark else real(0)


BALL_STEPS = 8
MOST_CURVED = 0.6       # sum of a ball's radius over the distances of both ends of a path, at the most
NEAREST = 4.0           # radii of a light: its least distance from a ball
MISS_FACTOR = 1.5       # on the first-order bound of the angle by which a path can miss a ball


class SpecularObject(NamedTuple):
    """An object that shows lights: a flat mirror or pane, or a ball."""

    number: int                 # of the object in the scene
    metal: bool
    centre: np.ndarray          # (3,)
    radius: float               # of a ball; 0: flat
    axes: np.ndarray            # (2, 3) half-axes of a flat one
    disk: bool                  # whether a flat one is an ellipse

    @property
    def ball(self) -> np.ndarray:
        """(5,) Centre, radius, and side of the centre on which rays pass, seen from the light: 1 metal, −1 glass."""
        return np.array([*self.centre, self.radius, 1.0 if self.metal else -1.0])


def specular_objects(scene: Scene, rotation: np.ndarray, shift: np.ndarray) -> list[SpecularObject]:
    """The specular objects of a scene that do not move; a world point p lies at rotation p + shift, camera frame."""
    mirrors = []
    for j, o in enumerate(scene.objects):
        if o.material.kind in ("metal", "glass") and not o.moves and o.family in ("sphere", "planar"):
            metal = o.material.kind == "metal"
            radius = o.bounding_radius if o.family == "sphere" else 0.0
            axes = np.array(o.half_axes) @ rotation.T
            mirrors.append(SpecularObject(j, metal, rotation @ np.asarray(o.centre) + shift, radius, axes, o.round))
    return mirrors


def mirror_image(flat: SpecularObject, vectors: np.ndarray, points: bool) -> np.ndarray:
    """Points or directions (n, 3) as a flat mirror or pane shows them."""
    if not flat.metal:
        return vectors
    normal = _normal(flat)
    above = (vectors - flat.centre if points else vectors) @ normal
    return vectors - 2.0 * above[:, None] * normal


def visible_lights(thing: SpecularObject, centres: np.ndarray, radii: np.ndarray, eye: np.ndarray, eye_radius: float
                   ) -> tuple[np.ndarray, np.ndarray]:
    """Which lights (n,) an object may show to an eye, and for which lights this is undecided.

    centres (n, 3), radii (n,): spheres about the lights; the eye is the sphere of eye_radius about a point (3,). A
    light that is in neither answer is certainly not shown.
    """
    if thing.radius > 0.0:
        return _visible_by_ball(thing, centres, radii, eye, eye_radius)
    normal = _normal(thing)
    height, own = (centres - thing.centre) @ normal, float((eye - thing.centre) @ normal)
    same, height, own = (height * own > 0.0) == thing.metal, abs(height), abs(own)
    odd = (height < radii) | (own < eye_radius)                     # the light or the eye touches the mirror's plane
    # Lines from all over the eye to all over the light's image cross the plane between these parts of their length,
    with np.errstate(divide="ignore", invalid="ignore"):
        least = (own - eye_radius) / (own - eye_radius + height + radii)
        most = (own + eye_radius) / (own + eye_radius + height - radii)
    # and, along the axes of the mirror, between these places
    image, nearest = mirror_image(thing, centres, True) - thing.centre, np.zeros((2, len(centres)))
    for k, axis in enumerate(thing.axes):
        size = math.sqrt(axis @ axis)
        eye_at, image_at = (eye - thing.centre) @ axis / size, image @ axis / size
        low = np.minimum(*((1.0 - t) * (eye_at - eye_radius) + t * (image_at - radii) for t in (least, most)))
        high = np.maximum(*((1.0 - t) * (eye_at + eye_radius) + t * (image_at + radii) for t in (least, most)))
        nearest[k] = np.maximum(np.maximum(low, -high), 0.0) / size
    within = np.hypot(*nearest) <= 1.0 if thing.disk else (nearest <= 1.0).all(0)
    return same & within & ~odd, odd


def _visible_by_ball(thing: SpecularObject, centres: np.ndarray, radii: np.ndarray, eye: np.ndarray, eye_radius: float
                     ) -> tuple[np.ndarray, np.ndarray]:
    """`visible_lights` of a ball; undecided where first order does not hold: too near or too strongly curved."""
    far, near = np.sqrt(((centres - thing.centre)**2).sum(1)), math.dist(eye, thing.centre)
    curved = thing.radius / (far - radii) + thing.radius / (near - eye_radius) > MOST_CURVED
    odd = curved | (far < NEAREST * radii + thing.radius)
    _, _, miss = connect_by_ball(np.tile(eye, (len(centres), 1)), centres, np.tile(thing.ball, (len(centres), 1)))
    return ~odd & (miss < MISS_FACTOR * (radii / far + eye_radius / near)), odd


def _normal(flat: SpecularObject) -> np.ndarray:
    normal = np.cross(*flat.axes)
    normal /= math.sqrt(normal @ normal)
    return normal


def connect_by_ball(starts: np.ndarray, points: np.ndarray, balls: np.ndarray
                    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from points before the lens by balls to points of lights, all (n, 3).

    balls: (n, 5), `SpecularObject.ball`. Returns unit directions (n, 3); the distances (n,) at which the rays pass the
    centres; and the angles (n,) by which a ray that grazes the ball falls short of the point: a path exists where
    it is 0 or less.
    """
    directions, passing, miss = np.empty((len(points), 3)), np.empty(len(points)), np.empty(len(points))
    _connect_by_ball(starts, points, balls, directions, passing, miss)
    return directions, passing, miss


@njit(nogil=True, cache=True, error_model="numpy")
def _connect_by_ball(starts, points, balls, directions, passing, miss):
    """`connect_by_ball`, into the given arrays."""
    for i in range(len(points)):
        # Axes of the path's plane: a to the ball's centre, b across, to the light
        cx, cy, cz, radius, side = balls[i, 0], balls[i, 1], balls[i, 2], balls[i, 3], balls[i, 4]
        ax, ay, az = cx - starts[i, 0], cy - starts[i, 1], cz - starts[i, 2]
        near = math.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax / near, ay / near, az / near
        bx, by, bz = points[i, 0] - cx, points[i, 1] - cy, points[i, 2] - cz
        far, along = math.sqrt(bx * bx + by * by + bz * bz), bx * ax + by * ay + bz * az
        bx, by, bz = bx - along * ax, by - along * ay, bz - along * az
        aside = math.sqrt(bx * bx + by * by + bz * bz)

        # Find the angle of incidence θ by Newton's method
        central_angle = -side * math.atan2(aside, along)
        theta, last = 0.0, -1.0
        for _ in range(BALL_STEPS):
            if theta == last:
                break
            value, slope = _central_angle(theta, side > 0.0, radius, near, far)
            last, theta = theta, theta + (central_angle - value) / slope
            if theta < 0.0:                     # NaN remains NaN
                theta = 0.0
            elif theta > math.pi / 2.0:
                theta = math.pi / 2.0
        miss[i] = central_angle - _central_angle(math.pi / 2.0, side > 0.0, radius, near, far)[0]

        # Set the ray that leaves for this place of the ball
        passing[i] = radius * math.sin(theta)
        sine = passing[i] / near
        c, s = math.sqrt(1.0 - sine * sine), sine * side / max(aside, 1e-12)
        directions[i, 0], directions[i, 1], directions[i, 2] = c * ax + s * bx, c * ay + s * by, c * az + s * bz


@njit(nogil=True, cache=True, error_model="numpy")
def _central_angle(theta, metal, radius, near, far):
    """Angle at a ball's centre between the ends of the path with this angle of incidence, less π; and its slope."""
    sine, cosine = math.sin(theta), math.cos(theta)
    p, q = radius * sine / near, radius * sine / far
    inner, inner_slope = math.pi / 2.0, 0.0
    if not metal:
        inner, inner_slope = math.asin(sine / INDEX), cosine / math.sqrt(INDEX**2 - sine * sine)
    slope = 2.0 * (1.0 - inner_slope)
    slope -= radius * cosine * (1.0 / (near * math.sqrt(1.0 - p * p)) + 1.0 / (far * math.sqrt(1.0 - q * q)))
    return 2.0 * (theta - inner) - math.asin(p) - math.asin(q), slope


def connecting_directions(starts: np.ndarray, points: np.ndarray, balls: np.ndarray) -> np.ndarray:
    """Unit directions (n, 3) from points before the lens to points of lights, straight or by balls.

    balls: (n, 5), 0 for a straight connection. NaN where no path exists.
    """
    directions = points - starts
    directions = directions / np.sqrt((directions**2).sum(1))[:, None]
    bent = np.nonzero(balls[:, 3] > 0.0)[0]
    if bent.size:
        by_ball, _, miss = connect_by_ball(starts[bent], points[bent], balls[bent])
        directions[bent] = np.where(miss[:, None] <= 0.0, by_ball, math.nan)
    return directions
