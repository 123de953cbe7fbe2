"""Small lights as they are seen in flat mirrors, through panes and by balls of metal and glass. Camera frame, mm.

A flat mirror shows a light behind itself, at its mirror image; a pane shows it where it is. The path by a ball lies
in the plane of its ends and the ball's centre, and passes that at the same distance before and after the ball; the
angle at the centre between its ends grows with that distance, so that there is one path, and Newton's method finds it.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.scenery.intersect.planar import plate_frame
from lensbench.scenery.objects import Sphere
from lensbench.scenery.scene import Scene
from lensbench.scenery.shading.illumination import INDEX

ROUNDS = 8             # of Newton's method
APART = 0.6             # sum of a ball's radius over the distances of its path's two ends, at the most
NEAR = 4.0              # radii of a light: from a ball it is no nearer
AROUND = 1.5            # how much more than by the first order a path may miss a ball, to be surely beside it


class SpecularObject(NamedTuple):
    """A thing that shows lights: a flat mirror or pane, or a ball."""

    number: int                 # of the object in the scene
    metal: bool
    centre: np.ndarray
    radius: float               # of a ball; 0: a plate
    axes: np.ndarray            # (2, 3) half-axes of a plate
    disk: bool

    @property
    def ball(self) -> np.ndarray:
        """Centre, radius, and on which side of its centre rays pass, seen from the light: 1 metal, −1 glass."""
        return np.array([*self.centre, self.radius, 1.0 if self.metal else -1.0])


def specular_objects(scene: Scene, turn: np.ndarray, shift: np.ndarray) -> list[SpecularObject]:
    """All of them; a point p of the world lies at turn p + shift in the camera frame."""
    found = []
    for j, o in enumerate(scene.objects):
        if o.material.kind in ("metal", "glass") and not o.moves:
            metal = o.material.kind == "metal"
            if isinstance(o, Sphere):
                found.append(SpecularObject(j, metal, turn @ o.centre + shift, o.radius, np.zeros((2, 3)), True))
            else:
                centre, a, b, _, disk = plate_frame(o)
                axes = np.array([a, b]) @ turn.T
                found.append(SpecularObject(j, metal, turn @ centre + shift, 0.0, axes, bool(disk)))
    return found


def mirror_image(bend: SpecularObject, vectors: np.ndarray, points: bool) -> np.ndarray:
    """Points or directions (n, 3) as a plate shows them."""
    if not bend.metal:
        return vectors
    normal = np.cross(*bend.axes)
    normal /= math.sqrt(normal @ normal)
    above = (vectors - bend.centre if points else vectors) @ normal
    return vectors - 2.0 * above[:, None] * normal


def may_show(bend: SpecularObject, centres: np.ndarray, radii: np.ndarray, eye: np.ndarray, reach: float):
    """Which lights (n,) a thing may show to an eye of this radius, and of which it cannot be told.

    centres (n, 3), radii (n,): spheres about them. What is not shown for certain is the one or the other.
    """
    if bend.radius > 0.0:
        far, near = np.sqrt(((centres - bend.centre)**2).sum(1)), math.dist(eye, bend.centre)
        odd = (bend.radius / (far - radii) + bend.radius / (near - reach) > APART) | (far < NEAR * radii + bend.radius)
        _, _, miss = connect_by_ball(np.tile(eye, (len(centres), 1)), centres, np.tile(bend.ball, (len(centres), 1)))
        return ~odd & (miss < AROUND * (radii / far + reach / near)), odd
    normal = np.cross(*bend.axes)
    normal /= math.sqrt(normal @ normal)
    height, own = (centres - bend.centre) @ normal, float((eye - bend.centre) @ normal)
    same, height, own = (height * own > 0.0) == bend.metal, abs(height), abs(own)
    odd = (height < radii) | (own < reach)                          # it, or the eye, stands in the mirror's plane
    # The ways from all over the eye to all over its image cross the plane in between these parts of them,
    with np.errstate(divide="ignore", invalid="ignore"):
        least, most = (own - reach) / (own - reach + height + radii), (own + reach) / (own + reach + height - radii)
    # and, along the axes of the plate, in between these places
    image, nearest = mirror_image(bend, centres, True) - bend.centre, np.zeros((2, len(centres)))
    for k, axis in enumerate(bend.axes):
        size = math.sqrt(axis @ axis)
        here, there = (eye - bend.centre) @ axis / size, image @ axis / size
        low = np.minimum(*((1.0 - part) * (here - reach) + part * (there - radii) for part in (least, most)))
        high = np.maximum(*((1.0 - part) * (here + reach) + part * (there + radii) for part in (least, most)))
        nearest[k] = np.maximum(np.maximum(low, -high), 0.0) / size
    within = np.hypot(*nearest) <= 1.0 if bend.disk else (nearest <= 1.0).all(0)
    return same & within & ~odd, odd


def connect_by_ball(through: np.ndarray, points: np.ndarray, balls: np.ndarray
                    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from points before the lens by balls to points of lights, all (n, 3).

    balls: (n, 5), `Bend.ball`. Unit directions (n, 3); how far they pass from the centre (n,); and by how many
    radians a ray that grazes the ball falls short of the point, 0 or less where the path is there.
    """
    found, passing, miss = np.empty((len(points), 3)), np.empty(len(points)), np.empty(len(points))
    _connect_by_ball(through, points, balls, found, passing, miss)
    return found, passing, miss


@njit(nogil=True, cache=True, error_model="numpy")
def _connect_by_ball(through, points, balls, found, passing, miss):
    """As `by_ball`, into the arrays given."""
    for i in range(len(points)):
        cx, cy, cz, radius, side = balls[i, 0], balls[i, 1], balls[i, 2], balls[i, 3], balls[i, 4]
        ax, ay, az = cx - through[i, 0], cy - through[i, 1], cz - through[i, 2]
        near = math.sqrt(ax * ax + ay * ay + az * az)
        ax, ay, az = ax / near, ay / near, az / near
        bx, by, bz = points[i, 0] - cx, points[i, 1] - cy, points[i, 2] - cz
        far, along = math.sqrt(bx * bx + by * by + bz * bz), bx * ax + by * ay + bz * az
        bx, by, bz = bx - along * ax, by - along * ay, bz - along * az
        aside = math.sqrt(bx * bx + by * by + bz * bz)
        wanted = -side * math.atan2(aside, along)
        theta, last = 0.0, -1.0
        for _ in range(ROUNDS):
            if theta == last:
                break
            value, slope = _turned(theta, side > 0.0, radius, near, far)
            last, theta = theta, theta + (wanted - value) / slope
            if theta < 0.0:                     # and what is no number stays none
                theta = 0.0
            elif theta > math.pi / 2.0:
                theta = math.pi / 2.0
        miss[i] = wanted - _turned(math.pi / 2.0, side > 0.0, radius, near, far)[0]
        passing[i] = radius * math.sin(theta)
        sine = passing[i] / near
        c, s = math.sqrt(1.0 - sine * sine), sine * side / max(aside, 1e-12)
        found[i, 0], found[i, 1], found[i, 2] = c * ax + s * bx, c * ay + s * by, c * az + s * bz


@njit(nogil=True, cache=True, error_model="numpy")
def _turned(theta, metal, radius, near, far):
    """What the angle at a ball's centre has more than half a turn, and its slope; theta: where the ball is met."""
    sine, cosine = math.sin(theta), math.cos(theta)
    p, q = radius * sine / near, radius * sine / far
    inner, bending = math.pi / 2.0, 0.0
    if not metal:
        inner, bending = math.asin(sine / INDEX), cosine / math.sqrt(INDEX**2 - sine * sine)
    slope = 2.0 * (1.0 - bending)
    slope -= radius * cosine * (1.0 / (near * math.sqrt(1.0 - p * p)) + 1.0 / (far * math.sqrt(1.0 - q * q)))
    return 2.0 * (theta - inner) - math.asin(p) - math.asin(q), slope


def connecting_directions(through: np.ndarray, points: np.ndarray, balls: np.ndarray) -> np.ndarray:
    """Unit directions (n, 3) from points before the lens to points as they are seen, straight, or by balls.

    balls: (n, 5), 0 where there is none. NaN where no such path is there.
    """
    way = points - through
    way = way / np.sqrt((way**2).sum(1))[:, None]
    bent = np.nonzero(balls[:, 3] > 0.0)[0]
    if bent.size:
        found, _, miss = connect_by_ball(through[bent], points[bent], balls[bent])
        way[bent] = np.where(miss[:, None] <= 0.0, found, math.nan)
    return way
