"""Light selection: which small lights are traced from the light to the film, straight or by specular objects.

Of the lights that the lens sees straight, those are selected that the camera's rays would meet too seldom within their
own images. The lights in a mirror or ball are selected all together, or all left to the camera's rays. Camera frame,
mm.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmLanding
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import WEIGHT, B, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.rendering.entrance_bounds import EntranceBounds, is_boundable, shared_entrance_bounds
from lensbench.core.rendering.light_rays import (
    ETENDUE, SpecularObject, connect_by_ball, connecting_directions, light_parameters, mirror_image, specular_objects,
    visible_lights
)
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.small_lights import SmallLight, light_samples, mean_radiances, small_lights

OFTEN_MET = 0.4         # share of the camera's rays in a light's image that meet the light: above it they do better
DENSITY = 16.0          # rays per pixel of the image of a point light, in one pass
SHARED_DENSITY = 0.5    # the same where one ray represents many
MOST_SHARED = 32        # rays that one ray represents, at most: a power of two
SHARED_PER_PIXEL = 4.0  # such rays for each pixel of the light's sharp image
STEADY = 0.1            # pixels by which the image of a half-axis may change over the pupil
LEAST = 0.05            # share of the wanted density below which a light is left to the camera
BUDGET = 1.5            # rays of all lights for each pixel of the film, at the most, in one pass
ALWAYS_ALLOWED = 600e3  # rays of all lights that are never too many

STRAIGHT, FLAT, BALL = range(3)     # kinds of paths: no specular object, a flat one, a ball


class SelectedLight(NamedTuple):
    """A light that is traced from the light to the film."""

    light: SmallLight
    kind: int                   # STRAIGHT, FLAT or BALL
    mirror: int                 # number of the specular object on the path; −1: none
    parameters: np.ndarray      # (LIGHT_SIZE,) for the stages of `light_rays`
    blocks: int                 # of B rays each, in one pass
    shared: int                 # rays that one ray represents, a power of two; 0: only itself
    unshared: float             # factor on the number of rays when one ray is one ray
    is_round: bool              # whether its points fill the unit disk
    image: np.ndarray           # (2, 2) pixels: images of both half-axes, x and y
    points: np.ndarray          # (POINTS, 5) of the light
    covered: float              # pixels of its image, each weighed by its squared brightness, white being 1
    centre: np.ndarray          # (3,) of the light, or of its mirror image in a flat mirror; camera frame, mm
    disc: np.ndarray            # (4,) centre and half-sizes of its blurred image, pixels
    period: int = 1             # passes of which one traces this light

    def with_rays(self, blocks: int, period: int = 1) -> "SelectedLight":
        """The same light with another number of blocks, in one of `period` passes."""
        if (blocks, period) == (self.blocks, self.period):
            return self
        parameters = self.parameters.copy()
        parameters[ETENDUE] *= self.blocks * period / (blocks * self.period)
        return self._replace(blocks=blocks, period=period, parameters=parameters)


class _Candidates(NamedTuple):
    """n paths on which the lens sees a small light. Camera frame."""

    which: np.ndarray           # (n,) index among the small lights
    by: np.ndarray              # (n,) index among the specular objects; −1: straight
    balls: np.ndarray           # (n, 5) `SpecularObject.ball`, 0: none
    centres: np.ndarray         # (n, 3) of the light, or its mirror image
    rights: np.ndarray          # (n, 3) half-axes of the parallelogram, or of the ellipse where `disks`,
    ups: np.ndarray             # (n, 3) that covers the light
    disks: np.ndarray           # (n,)
    filled: np.ndarray          # (n,) whether the light fills it; others have an outline of their own
    bounds: EntranceBounds

    def only(self, keep: np.ndarray) -> "_Candidates":
        """Some of the paths, by index."""
        bounds = EntranceBounds(*(values[keep] for values in self.bounds))
        return _Candidates(self.which[keep], self.by[keep], self.balls[keep], self.centres[keep], self.rights[keep],
                           self.ups[keep], self.disks[keep], self.filled[keep], bounds)


class _Images(NamedTuple):
    """The images of n candidates on the film, and the rays that these need."""

    axes: np.ndarray            # (n, 2, 2) pixels, of both half-axes
    sharp: np.ndarray           # (n,) pixels that the light would cover without blur
    discs: np.ndarray           # (n, 4) centre and half-sizes of the blurred image, pixels
    met: np.ndarray             # (n,) share of the camera's rays in the image that meet the light
    beside: np.ndarray          # (n,) whether the image lies beside the film
    steady: np.ndarray          # (n,) whether the image is the light's shape, the same all over the pupil
    density: np.ndarray         # (n,) rays per pixel
    needed: np.ndarray          # (n,) rays in one pass


class LightSelection(NamedTuple):
    """The lights that are traced from the light to the film."""

    lights: list[SelectedLight]
    mirrored: tuple[SmallLight, ...]    # lights whose specular paths are all selected wherever any light's is


def select_lights(camera: Camera, scene: Scene, real: Any) -> LightSelection:
    """The small lights that a camera's rays would meet too seldom; none where anything moves."""
    pose = camera.world_from_camera
    if isinstance(pose, AnimatedTransform) or scene.moves or camera.has_port:
        return LightSelection([], ())
    small = small_lights(scene.objects, tuple(pose[:3, 3]))
    landing = camera.film_landing() if small else None
    if landing is None:
        return LightSelection([], ())

    # Transform lights and specular objects to the camera frame
    camera_from_world = np.linalg.inv(pose)
    rotation, shift = camera_from_world[:3, :3], camera_from_world[:3, 3]
    centres = np.array([light.centre for light in small]) @ rotation.T + shift
    radii = np.array([light.radius for light in small])
    axes = [np.array(half) @ rotation.T for half in zip(*((light.right, light.up) for light in small), strict=True)]
    mirrors = specular_objects(scene, rotation, shift)

    # Find the paths, and select those that are worth tracing
    decided, which, by, bounds = _paths(landing, mirrors, centres, radii, real)
    candidates = _candidates(scene, landing, small, mirrors, (centres, radii, axes), (which, by, bounds))
    images = _images(camera, landing, candidates)
    keep = _worthwhile(camera, candidates, images)
    lights = _selected(camera, scene, small, mirrors, candidates.only(keep),
                       _Images(*(values[keep] for values in images)), landing.radius == 0.0)
    return LightSelection(lights, tuple(light for light, sure in zip(small, decided, strict=True) if sure))


# Decided lights (n,); of each path its light, its specular object or −1, and its bounds
_Paths = tuple[np.ndarray, np.ndarray, np.ndarray, EntranceBounds]


def _paths(landing: FilmLanding, mirrors: list[SpecularObject], centres: np.ndarray, radii: np.ndarray,
           real: Any) -> _Paths:
    """Paths on which the lens may see lights (n,): decided lights; light and specular object or −1, bounds, per path.

    A specular object near or beside the lens is left out. A light that is undecided for any specular object has its
    straight path only.
    """
    # Collect the points that need bounds: lights, their mirror images, and balls as a whole
    start = np.array(landing.front)
    decided, parts = np.ones(len(centres), bool), [(np.arange(len(centres)), -1, centres, radii)]
    for k, mirror in enumerate(mirrors):
        if mirror.radius > 0.0 and not is_boundable(landing, mirror.centre, mirror.radius):
            continue
        there, odd = visible_lights(mirror, centres, radii, start, landing.radius)
        indices = np.nonzero(there)[0]
        if mirror.radius > 0.0:
            one = min(len(indices), 1)                               # rectangle for the whole ball
            parts.append((indices, k, np.tile(mirror.centre, (one, 1)), np.full(one, mirror.radius)))
        else:
            image = mirror_image(mirror, centres[indices], True)
            odd[indices] = ~is_boundable(landing, image, radii[indices])
            parts.append((indices, k, image, radii[indices]))
        decided &= ~odd

    # Find the bounds, and give each path its own
    bounds = shared_entrance_bounds(landing, np.concatenate([points for _, _, points, _ in parts]),
                                   np.concatenate([sizes for _, _, _, sizes in parts]), real)
    first = np.cumsum([0] + [len(points) for _, _, points, _ in parts])
    rows = np.concatenate([begin + np.minimum(np.arange(len(indices)), max(len(points) - 1, 0))
                           for (indices, _, points, _), begin in zip(parts, first, strict=False)])
    which = np.concatenate([indices for indices, _, _, _ in parts])
    by = np.concatenate([np.full(len(indices), k) for indices, k, _, _ in parts])
    keep = (bounds.passing[rows] > 0.0) & (decided[which] | (by < 0))
    return decided, which[keep], by[keep], EntranceBounds(*(values[rows[keep]] for values in bounds))


def _candidates(scene: Scene, landing: FilmLanding, small: list[SmallLight], mirrors: list[SpecularObject],
                lights: tuple[np.ndarray, np.ndarray, list[np.ndarray]],
                paths: tuple[np.ndarray, np.ndarray, EntranceBounds]) -> _Candidates:
    """The lights on their paths. lights: centres, radii and half-axes; paths: as of `_paths`."""
    centres, radii, axes = lights
    which, by, bounds = paths
    is_ball = np.array([scene.objects[light.number].family != "planar" for light in small])
    is_round = is_ball | np.array([scene.objects[light.number].round for light in small])
    fills = np.array([scene.objects[light.number].family in ("sphere", "planar") for light in small])
    balls = np.zeros((len(which), 5))
    centres, axes = centres[which], [axis[which] for axis in axes]
    for k, mirror in enumerate(mirrors):
        mirrored = by == k
        if mirror.radius > 0.0:
            balls[mirrored] = mirror.ball
        else:
            centres[mirrored] = mirror_image(mirror, centres[mirrored], True)
            for axis in axes:
                axis[mirrored] = mirror_image(mirror, axis[mirrored], False)
    start = np.array(landing.front)
    origin = np.where(balls[:, 3:4] > 0.0, balls[:, :3], start)
    reach = np.sqrt((np.abs(bounds.axes).sum(1)**2).sum(1)) + np.sqrt(((bounds.middles - start)**2).sum(1))
    rights, ups = _covers(is_ball[which], radii[which], axes, centres - origin,
                          np.where(balls[:, 3] > 0.0, balls[:, 3], reach))
    return _Candidates(which, by, balls, centres, rights, ups, is_round[which], fills[which], bounds)


def _covers(spheres: np.ndarray, radii: np.ndarray, axes: list[np.ndarray], away: np.ndarray, reach: np.ndarray
            ) -> tuple[np.ndarray, np.ndarray]:
    """Half-axes (n, 3) of disks that cover spherical lights as seen from all points within `reach` (mm) of an origin.

    spheres (n,) bool: lights that are spheres of these radii; the others are flat and keep their half-axes.
    away: (n, 3) from the origin to the light.
    """
    distance = np.sqrt((away**2).sum(1))
    towards = away / distance[:, None]
    sine = np.minimum(radii / distance, 0.5)
    slant = reach / distance
    size = sine * distance / np.sqrt(1.0 - sine**2) * (1.0 + slant**2) * (1.0 + 1.5 * slant * sine) * (1.0 + 1e-5)
    upright = np.abs(towards[:, 1:2]) > 0.9
    side = np.cross(np.where(upright, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), towards)
    side /= np.sqrt((side**2).sum(1))[:, None]
    return (np.where(spheres[:, None], side * size[:, None], axes[0]),
            np.where(spheres[:, None], np.cross(towards, side) * size[:, None], axes[1]))


def _images(camera: Camera, landing: FilmLanding, candidates: _Candidates) -> _Images:
    """The images of candidates: their sizes without and with blur, and the rays that they need."""
    # Trace the light's centre and half-axes through the middle and towards the rim of the pupil
    bounds, program = candidates.bounds, Program(landing.bounding)
    middle, axes = _landed(program, candidates, bounds.best)
    steady = candidates.filled & np.isfinite(axes).all((1, 2))
    low, high = middle.copy(), middle.copy()
    for k in (0, 1) if landing.radius > 0.0 else ():
        for offset in (-0.5, 0.5):
            there, other = _landed(program, candidates, bounds.middles + offset * bounds.axes[:, k])
            with np.errstate(invalid="ignore"):
                steady &= (np.abs(other - axes) < STEADY).all((1, 2))
            there = 2.0 * there - middle                # from half of the pupil to all of it
            low, high = np.fmin(low, there), np.fmax(high, there)

    # Compare the sharp image with the blurred one
    axes = np.where(np.isfinite(axes), axes, 0.0)
    sharp = abs(np.linalg.det(axes)) * np.where(candidates.disks, math.pi, 4.0)
    blur = high - low
    whole = (np.sqrt(sharp) + np.sqrt(np.nan_to_num(math.pi / 4.0 * blur.prod(1))) + 1.0) ** 2
    reach = np.abs(axes).sum(1) + 0.5 * blur + 2.0              # wide, since blur may be uneven
    beside = ((high < -reach) | (low > [camera.film.pixels_x, camera.film.pixels_y] + reach)).any(1)
    density = np.where(steady, SHARED_DENSITY + (DENSITY - SHARED_DENSITY) / (1.0 + sharp), DENSITY)
    discs = np.column_stack([0.5 * (low + high), 0.5 * blur + np.abs(axes).sum(1)])
    return _Images(axes, sharp, discs, sharp / whole, beside, steady, density, density * whole / bounds.passing)


def _landed(program: Program, lights: _Candidates, through: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Raster points (n, 2) of the lights by rays through these points (n, 3), and of their half-axes (n, 2, 2)."""
    n = len(through)
    points = np.concatenate([lights.centres, lights.centres + lights.rights, lights.centres + lights.ups])
    through = np.tile(through, (3, 1))
    d = -connecting_directions(through, points, np.tile(lights.balls, (3, 1)))
    inputs = {X: through[:, 0], Y: through[:, 1], Z: through[:, 2], L: d[:, 0], M: d[:, 1], N: d[:, 2],
             WEIGHT: np.ones(3 * n)}
    raster = program.run(inputs, [X, Y], 3 * n).T.astype(float)
    return raster[:n], np.stack([raster[n:2 * n] - raster[:n], raster[2 * n:] - raster[:n]], 1)


def ray_budget(camera: Camera) -> float:
    """Rays of all lights in one pass, at the most."""
    return max(BUDGET * camera.film.pixels_x * camera.film.pixels_y, ALWAYS_ALLOWED)


def _worthwhile(camera: Camera, candidates: _Candidates, images: _Images) -> np.ndarray:
    """Indices of the paths to trace: the straight ones that need it most; of each specular object all, or none."""
    most, needed = ray_budget(camera), images.needed
    straight = np.nonzero((candidates.by < 0) & (images.met < OFTEN_MET) & ~images.beside)[0]
    straight = straight[np.argsort(images.met[straight], kind="stable")]
    cost = np.cumsum(np.maximum(needed[straight] * LEAST, B))
    kept = [np.sort(straight[:int(np.searchsorted(cost, most / 2.0, "right"))])]
    most -= cost[len(kept[0]) - 1] if len(kept[0]) else 0.0
    groups = [np.nonzero((candidates.by == k) & ~images.beside)[0] for k in range(candidates.by.max(initial=-1) + 1)]
    for group in sorted(groups, key=len):
        cost = np.maximum(needed[group] * LEAST, B).sum()
        if group.size and cost <= most and (images.met[group] < OFTEN_MET).any():
            kept.append(group)
            most -= cost
    return np.concatenate(kept)


def _selected(camera: Camera, scene: Scene, small: list[SmallLight], mirrors: list[SpecularObject],
              lights: _Candidates, images: _Images, pinhole: bool) -> list[SelectedLight]:
    """The candidates as selected lights, with as many rays as the budget allows."""
    # Share the rays out, and pack the parameters
    share = min(1.0, ray_budget(camera) / max(images.needed.sum(), 1.0))
    blocks = np.maximum(1.0, np.ceil(share * images.needed / B))
    bounds, n = lights.bounds, len(lights.which)
    areas = np.ones(n) if pinhole else 4.0 * np.sqrt((bounds.axes**2).sum(2).prod(1))
    marks = [2.0 + small[k].number for k in lights.which]
    mirror = [mirrors[k].number if k >= 0 else -1 for k in lights.by]
    start = np.zeros(n)
    bent = np.nonzero(lights.balls[:, 3] > 0.0)[0]
    if bent.size:
        start[bent] = connect_by_ball(bounds.best[bent], lights.centres[bent], lights.balls[bent])[1]
    parameters = light_parameters(marks, bounds.middles, bounds.axes, bounds.towards, lights.centres, lights.rights,
                                  lights.ups, lights.disks, areas / (blocks * B), [-2.0 - number for number in mirror],
                                  np.column_stack([lights.balls, start]))

    # Find what the light image needs besides
    points, bright = light_samples(scene.objects), mean_radiances(scene.objects)
    brightness = np.minimum(np.array([bright[small[k]] for k in lights.which]) * images.met, 1.0)
    covered = brightness**2 * images.sharp / np.maximum(images.met, 1e-30)
    kinds = np.where(lights.balls[:, 3] > 0.0, BALL, np.where(lights.by >= 0, FLAT, STRAIGHT))
    shared_count = 2 ** np.ceil(np.log2(np.clip(SHARED_PER_PIXEL * images.sharp, 1, MOST_SHARED))).astype(int)
    shared = np.where(images.steady, shared_count, 0)
    axes = images.axes.astype(np.float32)
    return [SelectedLight(small[k], int(kinds[i]), mirror[i], parameters[i], int(blocks[i]), int(shared[i]),
                          float(DENSITY / images.density[i]), bool(lights.disks[i]), axes[i], points[small[k]],
                          float(covered[i]), lights.centres[i], images.discs[i]) for i, k in enumerate(lights.which)]
