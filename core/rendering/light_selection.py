"""Which small lights are traced from their own side, as a lens sees them: straight, in mirrors, by balls.

Of those that it sees straight, the ones that the camera's rays would meet too seldom in their own picture.
What a mirror or ball shows of small lights is taken as a whole, or left to the camera's rays as a whole.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.film_landing import FilmLanding
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.kernels.block import WEIGHT, B, X, Y
from lensbench.kernels.program import Program
from lensbench.rendering.entrance_bounds import EntranceBounds, is_boundable, shared_entrance_bounds
from lensbench.rendering.light_rays import FLOW, light_parameters
from lensbench.rendering.specular_connection import (
    SpecularObject,
    connect_by_ball,
    connecting_directions,
    may_show,
    mirror_image,
    specular_objects,
)
from lensbench.scenery.objects import Disk, Sphere
from lensbench.scenery.scene import Scene
from lensbench.scenery.small_lights import SmallLight, light_samples, mean_radiances, small_lights

MET = 0.4               # part of the camera's rays in its own picture that meet a light: above it they do better
DENSITY = 16.0          # rays per pixel of the picture of a light that is a point, in one pass, if there is time
SHARED_DENSITY = 0.5    # of a light whose rays stand for many
MANY = 32               # rays that one ray stands for, at the most: a power of two
EACH = 4.0              # of these, as many for each pixel of the light's own image
STEADY = 0.1            # pixels: by how much, at the most, the image of a half-axis may change over the pupil
LEAST = 0.05            # part of that, below which the lights that need the most are left to the camera
BUDGET = 1.5            # samples of all lights for each pixel of the film, at the most, in one pass
FEW = 600e3             # rays of all lights that are never too many

STRAIGHT, FLAT, BALL = range(3)     # how a light is seen


class SelectedLight(NamedTuple):
    """A light that is traced from its own side, as `emit` reads it."""

    light: SmallLight
    how: int                    # STRAIGHT, FLAT or BALL
    by: int                     # number of the object that shows it; −1: none
    numbers: np.ndarray
    blocks: int                 # of B rays each, in one pass
    many: int                   # rays that a ray stands for, a power of two; 0: none but itself
    alone: float                # how many times as many rays it takes if each stands for itself
    round: bool                 # whether its places fill the unit disk
    image: np.ndarray           # (2, 2) pixels: x, y of the image of each of the half-axes
    points: np.ndarray          # (POINTS, 5) of the light
    covered: float              # pixels of its picture, each by the square of its brightness, at most that of white
    every: int = 1              # it is traced in one pass of so many

    def traced(self, blocks: int, every: int = 1) -> "SelectedLight":
        """The same with another number of rays, in one pass of so many."""
        if (blocks, every) == (self.blocks, self.every):
            return self
        numbers = self.numbers.copy()
        numbers[FLOW] *= self.blocks * every / (blocks * self.every)
        return self._replace(blocks=blocks, every=every, numbers=numbers)


class _Candidates(NamedTuple):
    """n lights as a lens sees them. Camera frame."""

    which: np.ndarray           # (n,) among the small lights
    by: np.ndarray              # (n,) among the bends; −1: straight
    balls: np.ndarray           # (n, 5) `Bend.ball`, 0: none
    centres: np.ndarray         # (n, 3)
    rights: np.ndarray          # (n, 3) half-axes of what hides it, of a parallelogram or, where `disks`, an ellipse
    ups: np.ndarray
    disks: np.ndarray           # (n,)
    front: EntranceBounds

    def only(self, keep: np.ndarray) -> "_Candidates":
        """Some of them."""
        front = EntranceBounds(*(values[keep] for values in self.front))
        return _Candidates(self.which[keep], self.by[keep], self.balls[keep], self.centres[keep], self.rights[keep],
                     self.ups[keep], self.disks[keep], front)


class _Pictures(NamedTuple):
    """Of n lights as they are seen: their pictures, and what tracing these takes."""

    image: np.ndarray           # (n, 2, 2) pixels, of each of the half-axes
    own: np.ndarray             # (n,) pixels that the light alone would cover
    met: np.ndarray             # (n,) part of the camera's rays in the picture that meet the light
    beside: np.ndarray          # (n,) whether the picture lies beside the film
    steady: np.ndarray          # (n,) whether the image is the same all over the pupil
    density: np.ndarray         # (n,) rays per pixel
    needed: np.ndarray          # (n,) rays in one pass


class LightSelection(NamedTuple):
    """What is traced from its own side."""

    lights_selected: list[SelectedLight]
    bent: tuple[SmallLight, ...]        # the lights of which all is traced that the things show by which any is


def select_lights(camera: Camera, scene: Scene, real) -> LightSelection:
    """The lights that a camera's rays would find too seldom, with what `emit` needs of them."""
    place = camera.world_from_camera
    if isinstance(place, AnimatedTransform) or scene.moves or camera.has_port:
        return LightSelection([], ())
    small = small_lights(scene.objects, tuple(place[:3, 3]))
    way = camera.way_back() if small else None
    if way is None:
        return LightSelection([], ())
    camera_from_world = np.linalg.inv(place)
    turn, shift = camera_from_world[:3, :3], camera_from_world[:3, 3]
    centres = np.array([light.centre for light in small]) @ turn.T + shift
    radii = np.array([light.radius for light in small])
    axes = [np.array(half) @ turn.T for half in zip(*((light.right, light.up) for light in small), strict=True)]
    objects = scene.objects
    balls = np.array([isinstance(objects[light.number], Sphere) for light in small])
    disks = np.array([isinstance(objects[light.number], Sphere | Disk) for light in small])
    things = specular_objects(scene, turn, shift)
    known, which, by, front = _entrance_bounds(way, things, centres, radii, real)
    lone = np.zeros((len(which), 5))
    where, half = centres[which], [axis[which] for axis in axes]
    for k, thing in enumerate(things):
        at = by == k
        if thing.radius > 0.0:
            lone[at] = thing.ball
        else:
            where[at] = mirror_image(thing, where[at], True)
            for axis in half:
                axis[at] = mirror_image(thing, axis[at], False)
    # What hides each light from all the places where its rays come from
    start = np.array([0.0, 0.0, way.front])
    origin = np.where(lone[:, 3:4] > 0.0, lone[:, :3], start)
    reach = np.sqrt((np.abs(front.axes).sum(1)**2).sum(1)) + np.sqrt(((front.middles - start)**2).sum(1))
    rights, ups = _hiding(balls[which], radii[which], half, where - origin,
                          np.where(lone[:, 3] > 0.0, lone[:, 3], reach))
    seen = _Candidates(which, by, lone, where, rights, ups, disks[which], front)
    pictures = _pictures(camera, way, seen)
    keep = _worthwhile(camera, seen, pictures)
    lights_selected = _selected_lights(camera, scene, small, things, seen.only(keep),
                           _Pictures(*(values[keep] for values in pictures)), way.radius == 0.0)
    return LightSelection(lights_selected, tuple(light for light, told in zip(small, known, strict=True) if told))


def _entrance_bounds(way: FilmLanding, things: list[SpecularObject], centres: np.ndarray, radii: np.ndarray, real):
    """Which lights the lens may see, and by which of the things or −1, both (n,); and the rectangles before the lens.

    Things of which it cannot be told are left out; lights of which it cannot be told for one are seen straight alone.
    """
    start = np.array([0.0, 0.0, way.front])
    known, parts = np.ones(len(centres), bool), [(np.arange(len(centres)), -1, centres, radii)]
    for k, thing in enumerate(things):
        if thing.radius > 0.0 and not is_boundable(way, thing.centre, thing.radius):
            continue
        there, odd = may_show(thing, centres, radii, start, way.radius)
        at = np.nonzero(there)[0]
        if thing.radius > 0.0:
            one = min(len(at), 1)                               # rectangle for all of the ball
            parts.append((at, k, np.tile(thing.centre, (one, 1)), np.full(one, thing.radius)))
        else:
            image = mirror_image(thing, centres[at], True)
            odd[at] = ~is_boundable(way, image, radii[at])
            parts.append((at, k, image, radii[at]))
        known &= ~odd
    found = shared_entrance_bounds(way, np.concatenate([points for _, _, points, _ in parts]),
                          np.concatenate([sizes for _, _, _, sizes in parts]), real)
    first = np.cumsum([0] + [len(points) for _, _, points, _ in parts])
    rows = np.concatenate([begin + np.minimum(np.arange(len(at)), max(len(points) - 1, 0))
                           for (at, _, points, _), begin in zip(parts, first, strict=False)])
    which = np.concatenate([at for at, _, _, _ in parts])
    by = np.concatenate([np.full(len(at), k) for at, k, _, _ in parts])
    keep = (found.passing[rows] > 0.0) & (known[which] | (by < 0))
    return known, which[keep], by[keep], EntranceBounds(*(values[rows[keep]] for values in found))


def _hiding(balls: np.ndarray, radii: np.ndarray, half: list[np.ndarray], away: np.ndarray, reach: np.ndarray
            ) -> tuple[np.ndarray, np.ndarray]:
    """Half-axes (n, 3) of what hides each light from all points within `reach` (mm) of one, `away` (n, 3) from it.

    balls (n,): of which light is a sphere of these radii; the others are flat, with these half-axes. Camera frame.
    """
    distance = np.sqrt((away**2).sum(1))
    towards = away / distance[:, None]
    seen = np.minimum(radii / distance, 0.5)
    slant = reach / distance
    size = seen * distance / np.sqrt(1.0 - seen**2) * (1.0 + slant**2) * (1.0 + 1.5 * slant * seen) * (1.0 + 1e-5)
    upright = np.abs(towards[:, 1:2]) > 0.9
    side = np.cross(np.where(upright, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), towards)
    side /= np.sqrt((side**2).sum(1))[:, None]
    return (np.where(balls[:, None], side * size[:, None], half[0]),
            np.where(balls[:, None], np.cross(towards, side) * size[:, None], half[1]))


def _pictures(camera: Camera, way: FilmLanding, seen: _Candidates) -> _Pictures:
    """How large they are, how much of that is due to the light's own size, and how many rays they take."""
    front, back = seen.front, Program(way.bounding)
    middle, image = _images(back, seen, front.best)
    steady = np.isfinite(image).all((1, 2))
    low, high = middle.copy(), middle.copy()
    for k in (0, 1) if way.radius > 0.0 else ():
        for part in (-0.5, 0.5):
            there, other = _images(back, seen, front.middles + part * front.axes[:, k])
            with np.errstate(invalid="ignore"):
                steady &= (np.abs(other - image) < STEADY).all((1, 2))
            there = 2.0 * there - middle                # from half of the pupil to all of it
            low, high = np.fmin(low, there), np.fmax(high, there)
    image = np.where(np.isfinite(image), image, 0.0)
    own = abs(np.linalg.det(image)) * np.where(seen.disks, math.pi, 4.0)
    blur = high - low
    whole = (np.sqrt(own) + np.sqrt(np.nan_to_num(math.pi / 4.0 * blur.prod(1))) + 1.0) ** 2
    reach = np.abs(image).sum(1) + 0.5 * blur + 2.0             # for certain, where the blur is not as even as that
    beside = ((high < -reach) | (low > [camera.film.pixels_x, camera.film.pixels_y] + reach)).any(1)
    density = np.where(steady, SHARED_DENSITY + (DENSITY - SHARED_DENSITY) / (1.0 + own), DENSITY)
    return _Pictures(image, own, own / whole, beside, steady, density, density * whole / front.passing)


def _images(back: Program, seen: _Candidates, through: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Raster points (n, 2) of lights by rays through these points (n, 3), and their half-axes there (n, 2, 2).

    back: from such a ray to the raster.
    """
    n = len(through)
    points = np.concatenate([seen.centres, seen.centres + seen.rights, seen.centres + seen.ups])
    through = np.tile(through, (3, 1))
    d = -connecting_directions(through, points, np.tile(seen.balls, (3, 1)))
    given = {X: through[:, 0], Y: through[:, 1], X + 2: through[:, 2], X + 3: d[:, 0], X + 4: d[:, 1], X + 5: d[:, 2],
             WEIGHT: np.ones(3 * n)}
    raster = back.run(given, [X, Y], 3 * n).T.astype(float)
    return raster[:n], np.stack([raster[n:2 * n] - raster[:n], raster[2 * n:] - raster[:n]], 1)


def budget(camera: Camera) -> float:
    """Rays of all lights in one pass, at the most."""
    return max(BUDGET * camera.film.pixels_x * camera.film.pixels_y, FEW)


def _worthwhile(camera: Camera, seen: _Candidates, pictures: _Pictures) -> np.ndarray:
    """Which of them to trace: straight, those that need it most; by each thing all on the film, or none."""
    most, needed = budget(camera), pictures.needed
    straight = np.nonzero((seen.by < 0) & (pictures.met < MET) & ~pictures.beside)[0]
    straight = straight[np.argsort(pictures.met[straight], kind="stable")]
    cost = np.cumsum(np.maximum(needed[straight] * LEAST, B))
    kept = [np.sort(straight[:int(np.searchsorted(cost, most / 2.0, "right"))])]
    most -= cost[len(kept[0]) - 1] if len(kept[0]) else 0.0
    groups = [np.nonzero((seen.by == k) & ~pictures.beside)[0] for k in range(seen.by.max(initial=-1) + 1)]
    for group in sorted(groups, key=len):
        cost = np.maximum(needed[group] * LEAST, B).sum()
        if group.size and cost <= most and (pictures.met[group] < MET).any():
            kept.append(group)
            most -= cost
    return np.concatenate(kept)


def _selected_lights(camera: Camera, scene: Scene, small: list[SmallLight], things: list[SpecularObject],
                     seen: _Candidates, pictures: _Pictures, pinhole: bool) -> list[SelectedLight]:
    """With as many rays as there is time for."""
    share = min(1.0, budget(camera) / max(pictures.needed.sum(), 1.0))
    blocks = np.maximum(1.0, np.ceil(share * pictures.needed / B))
    front, n = seen.front, len(seen.which)
    areas = np.ones(n) if pinhole else 4.0 * np.sqrt((front.axes**2).sum(2).prod(1))
    marks = [2.0 + small[k].number for k in seen.which]
    by = [things[k].number if k >= 0 else -1 for k in seen.by]
    first = np.zeros(n)
    bent = np.nonzero(seen.balls[:, 3] > 0.0)[0]
    if bent.size:
        first[bent] = connect_by_ball(front.best[bent], seen.centres[bent], seen.balls[bent])[1]
    numbers = light_parameters(marks, front.middles, front.axes, front.towards, seen.centres, seen.rights, seen.ups,
                               seen.disks, areas / (blocks * B), [-2.0 - number for number in by],
                               np.column_stack([seen.balls, first]))
    points, bright = light_samples(scene.objects), mean_radiances(scene.objects)
    parts = np.minimum(np.array([bright[small[k]] for k in seen.which]) * pictures.met, 1.0)
    covered = parts**2 * pictures.own / np.maximum(pictures.met, 1e-30)
    how = np.where(seen.balls[:, 3] > 0.0, BALL, np.where(seen.by >= 0, FLAT, STRAIGHT))
    many = np.where(pictures.steady, 2 ** np.ceil(np.log2(np.clip(EACH * pictures.own, 1, MANY))).astype(int), 0)
    alone, images = (DENSITY / pictures.density).tolist(), pictures.image.astype(np.float32)
    return [SelectedLight(small[k], *rest) for k, rest in zip(seen.which, zip(
        how.tolist(), by, numbers, blocks.astype(int).tolist(), many.tolist(), alone, seen.disks.tolist(), images,
        [points[small[k]] for k in seen.which], covered.tolist(), strict=True), strict=True)]
