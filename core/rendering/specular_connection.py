"""Specular connections: how flat mirrors, panes and balls of metal and glass show small lights to the lens.

A flat mirror shows a light at its mirror image; a pane shows it in place. The path by a ball lies in
the plane of its ends and the ball's centre, and passes the centre at the same distance before and after the
ball; the angle at the centre between its ends grows with that distance, so that there is one path, and Newton's
method finds it. Camera frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.illumination import INDEX

NEWTON_STEPS = 8
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
        for _ in range(NEWTON_STEPS):
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
