"""Small lights as they are seen in flat mirrors, through panes and by balls of metal and glass. Camera frame, mm.

A flat mirror shows a light behind itself, at its mirror image; a pane shows it where it is. The path by a ball lies
in the plane of its ends and the ball's centre, and passes that at the same distance before and after the ball; the
angle at the centre between its ends grows with that distance, so that there is one path, and Newton's method finds it.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.scene import Scene
from lensbench.scenery.light import INDEX
from lensbench.scenery.objects import Sphere
from lensbench.scenery.plates import plate_frame

ROUNDS = 8             # of Newton's method
APART = 0.6             # sum of a ball's radius over the distances of its path's two ends, at the most
NEAR = 4.0              # radii of a light: from a ball it is no nearer
AROUND = 1.5            # how much more than by the first order a path may miss a ball, to be surely beside it


class Bend(NamedTuple):
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


def bends(scene: Scene, turn: np.ndarray, shift: np.ndarray) -> list[Bend]:
    """All of them; a point p of the world lies at turn p + shift in the camera frame."""
    found = []
    for j, o in enumerate(scene.objects):
        if o.material.kind in ("metal", "glass") and not o.moves:
            metal = o.material.kind == "metal"
            if isinstance(o, Sphere):
                found.append(Bend(j, metal, turn @ o.centre + shift, o.radius, np.zeros((2, 3)), True))
            else:
                centre, a, b, _, disk = plate_frame(o)
                found.append(Bend(j, metal, turn @ centre + shift, 0.0, np.array([a, b]) @ turn.T, bool(disk)))
    return found


def mirrored(bend: Bend, vectors: np.ndarray, points: bool) -> np.ndarray:
    """Points or directions (n, 3) as a plate shows them."""
    if not bend.metal:
        return vectors
    normal = np.cross(*bend.axes)
    normal /= math.sqrt(normal @ normal)
    above = (vectors - bend.centre if points else vectors) @ normal
    return vectors - 2.0 * above[:, None] * normal


def shown(bend: Bend, centres: np.ndarray, radii: np.ndarray, eye: np.ndarray, reach: float):
    """Which lights (n,) a thing may show to an eye of this radius, and of which it cannot be told.

    centres (n, 3), radii (n,): spheres about them. What is not shown for certain is the one or the other.
    """
    if bend.radius > 0.0:
        far, near = np.sqrt(((centres - bend.centre)**2).sum(1)), math.dist(eye, bend.centre)
        odd = (bend.radius / (far - radii) + bend.radius / (near - reach) > APART) | (far < NEAR * radii + bend.radius)
        _, _, miss = by_ball(np.tile(eye, (len(centres), 1)), centres, np.tile(bend.ball, (len(centres), 1)))
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
    image, nearest = mirrored(bend, centres, True) - bend.centre, np.zeros((2, len(centres)))
    for k, axis in enumerate(bend.axes):
        size = math.sqrt(axis @ axis)
        here, there = (eye - bend.centre) @ axis / size, image @ axis / size
        low = np.minimum(*((1.0 - part) * (here - reach) + part * (there - radii) for part in (least, most)))
        high = np.maximum(*((1.0 - part) * (here + reach) + part * (there + radii) for part in (least, most)))
        nearest[k] = np.maximum(np.maximum(low, -high), 0.0) / size
    within = np.hypot(*nearest) <= 1.0 if bend.disk else (nearest <= 1.0).all(0)
    return same & within & ~odd, odd


def by_ball(through: np.ndarray, points: np.ndarray, balls: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from points before the lens by balls to points of lights, all (n, 3).

    balls: (n, 5), `Bend.ball`. Unit directions (n, 3); how far they pass from the centre (n,); and by how many
    radians a ray that grazes the ball falls short of the point, 0 or less where the path is there.
    """
    radius, side = balls[:, 3], balls[:, 4]
    axis = balls[:, :3] - through
    near = np.sqrt((axis**2).sum(1))
    axis = axis / near[:, None]
    out = points - balls[:, :3]
    far, along = np.sqrt((out**2).sum(1)), (out * axis).sum(1)
    across = out - along[:, None] * axis
    aside = np.sqrt((across**2).sum(1))
    wanted = -side * np.arctan2(aside, along)
    metal = side > 0.0

    def turn(theta):
        """What the angle at the centre has more than half a turn, and its slope."""
        sine, cosine = np.sin(theta), np.cos(theta)
        inner = np.where(metal, math.pi / 2.0, np.arcsin(sine / INDEX))
        p, q = radius * sine / near, radius * sine / far
        slope = 2.0 * (1.0 - np.where(metal, 0.0, cosine / np.sqrt(INDEX**2 - sine**2)))
        slope -= radius * cosine * (1.0 / (near * np.sqrt(1.0 - p * p)) + 1.0 / (far * np.sqrt(1.0 - q * q)))
        return 2.0 * (theta - inner) - np.arcsin(p) - np.arcsin(q), slope

    with np.errstate(invalid="ignore", divide="ignore"):
        theta = np.zeros(len(points))
        for _ in range(ROUNDS):
            value, slope = turn(theta)
            theta = np.clip(theta + (wanted - value) / slope, 0.0, math.pi / 2.0)
        miss = wanted - turn(np.full(len(points), math.pi / 2.0))[0]
        passing = radius * np.sin(theta)
        sine = passing / near
        directions = np.sqrt(1.0 - sine**2)[:, None] * axis + (sine * side / np.maximum(aside, 1e-12))[:, None] * across
    return directions, passing, miss


def directions(through: np.ndarray, points: np.ndarray, balls: np.ndarray) -> np.ndarray:
    """Unit directions (n, 3) from points before the lens to points as they are seen, straight, or by balls.

    balls: (n, 5), 0 where there is none. NaN where no such path is there.
    """
    way = points - through
    way = way / np.sqrt((way**2).sum(1))[:, None]
    bent = np.nonzero(balls[:, 3] > 0.0)[0]
    if bent.size:
        found, _, miss = by_ball(through[bent], points[bent], balls[bent])
        way[bent] = np.where(miss[:, None] <= 0.0, found, math.nan)
    return way
