"""Small lights of a scene, which are traced from the light to the film.

A plain light is one small light. A rectangle with a luminous image has one for each bright patch, if the patches lie
apart, as the windows of a house by night do. An image is linear between its texels, so that it is the sum of one that
holds the patches alone and one that holds the rest.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.scenery.objects.material import Image
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.values import Triple, triple

MOST_KEPT, NEWEST = 32 << 20, 4         # bytes of the shapes of scenes seen before; of two pictures that are compared
SMALL = 0.05            # radians: greatest angular radius of a small light
BRIGHT = 0.05           # of the brightest texel: brighter texels belong to a patch
MOST_TEXELS = 1 << 16   # of an image that is searched for patches
MOST_TRIANGLES = 4096   # of a mesh that is a small light: each picture builds trees of it
MOST_LIT = 0.3          # greatest part of its area that the patches may cover together
BLACK = (0.0, 0.0, 0.0)
POINTS = 64             # samples of a light in the first passes
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0

Patch = tuple[int, int, int, int]       # of texels: first and last row, first and last column


class SmallLight(NamedTuple):
    """A light, or one bright patch of a luminous image. World frame, mm."""

    number: int                 # index of the shape in `Scene.objects`
    centre: Triple
    radius: float               # of a sphere around it
    right: Triple               # half-axes of a planar light or patch; (0, 0, 0) for a sphere or a mesh
    up: Triple
    patch: Patch | None         # None: the whole shape


class ExcludedLight(NamedTuple):
    """Light that the camera's rays do not see, because it is traced from the light."""

    first: tuple[Shape, ...]    # the shapes as a ray from the camera sees them
    bends: frozenset[int]       # indices of the shapes whose reflections show the others as `later`
    later: tuple[Shape, ...]    # the shapes as they are seen there

    def is_same(self, other: "ExcludedLight") -> bool:
        """Whether it is the same light; split shapes of a scene are cached, so the same shapes."""
        return (self.bends == other.bends and all(a is b for a, b in zip(self.first, other.first, strict=True))
                and all(a is b for a, b in zip(self.later, other.later, strict=True)))


def small_lights(objects: tuple[Shape, ...], eye: Triple = BLACK) -> list[SmallLight]:
    """Lights that are small as seen from a place in the world (mm)."""
    return [light for light in _all(objects) if light.radius < SMALL * math.dist(light.centre, eye)]


@byte_cache(MOST_KEPT, 16, NEWEST)
def _all(objects: tuple[Shape, ...]) -> tuple[SmallLight, ...]:
    lights: list[SmallLight] = []
    for j, o in enumerate(objects):
        if not o.material.shines or o.moves or o.triangle_count > MOST_TRIANGLES:
            continue
        if o.material.pattern is None:
            right, up = o.half_axes
            radius = math.hypot(*right) + math.hypot(*up) or o.bounding_radius
            lights.append(SmallLight(j, o.centre, radius, right, up, None))
        elif o.material.pattern.image is not None and o.family == "planar" and not o.round:
            lights += [_patch(j, o, patch) for patch in _patches(o.material.pattern.image)]
    return tuple(lights)


def _patch(number: int, plate: Shape, patch: Patch) -> SmallLight:
    """The part of an image that the texels of a patch brighten, up to the middles of their neighbours."""
    assert plate.material.pattern is not None and plate.material.pattern.image is not None
    image = plate.material.pattern.image
    top, bottom, left, right = patch
    u0, u1 = ((np.clip([left - 0.5, right + 1.5], 0.0, image.width) / image.width) * 2.0 - 1.0)
    v1, v0 = (1.0 - (np.clip([top - 0.5, bottom + 1.5], 0.0, image.height) / image.height) * 2.0)
    a, b = (np.asarray(axis) for axis in plate.half_axes)
    half_a, half_b = a * ((u1 - u0) / 2.0), b * ((v1 - v0) / 2.0)
    centre = np.asarray(plate.centre) + a * ((u0 + u1) / 2.0) + b * ((v0 + v1) / 2.0)
    return SmallLight(number, triple(centre), float(np.linalg.norm(half_a) + np.linalg.norm(half_b)), triple(half_a),
                      triple(half_b), patch)


@byte_cache(MOST_KEPT, 64)
def _patches(image: Image) -> tuple[Patch, ...]:
    """Boxes around the bright texels of an image, at least two dark texels apart; none if they do not lie apart."""
    if image.width * image.height > MOST_TEXELS:
        return ()
    values = image.values.max(2)
    lit = values > BRIGHT * values.max()
    if not lit.any() or lit.mean() > MOST_LIT:
        return ()
    # Grow runs of bright texels into boxes, and merge boxes within two texels of each other
    boxes: list[list[int]] = []
    for line in range(image.height):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], lit[line], [0]])))
        for left, end in zip(edges[::2], edges[1::2], strict=True):
            box = [line, line, int(left), int(end) - 1]
            while True:
                near = [k for k, other in enumerate(boxes) if box[0] - other[1] <= 2 and other[0] - box[1] <= 2
                        and box[2] - other[3] <= 2 and other[2] - box[3] <= 2]
                if not near:
                    break
                for k in reversed(near):
                    other = boxes.pop(k)
                    box = [min(box[0], other[0]), max(box[1], other[1]), min(box[2], other[2]), max(box[3], other[3])]
            boxes.append(box)
    area = sum((b[1] - b[0] + 1) * (b[3] - b[2] + 1) for b in boxes)
    return tuple((b[0], b[1], b[2], b[3]) for b in boxes) if area < MOST_LIT * lit.size else ()


@byte_cache(MOST_KEPT, 16, NEWEST)
def split_light(objects: tuple[Shape, ...],
                taken: tuple[SmallLight, ...]) -> tuple[tuple[Shape, ...], tuple[Shape, ...]]:
    """The shapes without the light of some small lights, and with that light alone."""
    parts: dict[int, list[Patch | None]] = {}
    for light in taken:
        parts.setdefault(light.number, []).append(light.patch)
    left, alone = [], []
    for j, o in enumerate(objects):
        patches = parts.get(j)
        if patches is None:
            left.append(o)
            alone.append(_darkened(o) if o.material.shines else o)
        elif patches[0] is None:
            left.append(_darkened(o))
            alone.append(o)
        else:
            pattern = o.material.pattern
            assert pattern is not None and pattern.image is not None
            inside = np.zeros((pattern.image.height, pattern.image.width, 1), bool)
            for patch in patches:
                assert patch is not None
                inside[patch[0]:patch[1] + 1, patch[2]:patch[3] + 1] = True
            for kept, values in ((left, np.where(inside, 0.0, pattern.image.values)),
                                 (alone, np.where(inside, pattern.image.values, 0.0))):
                kept.append(replace(o, material=replace(o.material, pattern=replace(pattern, image=Image.of(values)))))
    return tuple(left), tuple(alone)


@byte_cache(MOST_KEPT, 16, NEWEST)
def light_samples(objects: tuple[Shape, ...]) -> dict[SmallLight, np.ndarray]:
    """Samples of each small light, see `samples_of`, in single precision."""
    return {light: samples_of(objects[light.number], light).astype(np.float32) for light in _all(objects)}


@byte_cache(MOST_KEPT, 16, NEWEST)
def mean_radiances(objects: tuple[Shape, ...]) -> dict[SmallLight, float]:
    """The mean radiance of each small light, of its brightest channel."""
    return {light: float(points[:, 2:].mean(0).max()) for light, points in light_samples(objects).items()}


def samples_of(thing: Shape, light: SmallLight) -> np.ndarray:
    """Samples of a light, (POINTS, 5): place from −1 to 1 along its half-axes, or in the unit disk, and radiance.

    The density of the places is proportional to the radiance of the light, and their radiance is divided by it: the
    mean over the samples of any function of the place, times the radiance, is the mean over the light.
    """
    k = np.arange(POINTS)
    u, v = (k + 0.5) / POINTS, (k * GOLDEN + 0.5) % 1.0
    colour = np.asarray(thing.material.colour, float)
    pattern = thing.material.pattern
    if pattern is None:
        if thing.round:
            radius, turn = np.sqrt(u), 2.0 * math.pi * v
            places = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
        else:
            places = 2.0 * np.column_stack([u, v]) - 1.0
        return np.column_stack([places, np.tile(colour, (POINTS, 1))])
    # Interpolate the texels of a patch, each of which reaches to the middles of its neighbours
    assert light.patch is not None and pattern.image is not None
    top, bottom, left, right = light.patch
    image = pattern.image
    fine = 8
    lines, columns = bottom - top + 2, right - left + 2         # between the middles of texels
    y, x = ((np.arange(n * fine) + 0.5) / fine - 1.0 for n in (lines, columns))
    texels = image.values[top:bottom + 1, left:right + 1].astype(float) * colour
    down = np.maximum(1.0 - np.abs(y[:, None] - np.arange(bottom - top + 1)), 0.0)
    over = np.maximum(1.0 - np.abs(x[:, None] - np.arange(right - left + 1)), 0.0)
    for weights, position, first, size in ((down, y, top, image.height), (over, x, left, image.width)):
        if first == 0:                                          # a texel at the border reaches it
            weights[position < 0.0, 0] = 1.0
        if first + weights.shape[1] == size:
            weights[position > weights.shape[1] - 1, -1] = 1.0
    y, x = y + top, x + left
    within_y, within_x = (y > -0.5) & (y < image.height - 0.5), (x > -0.5) & (x < image.width - 0.5)
    shine = np.einsum("ia,jb,abc->ijc", down[within_y], over[within_x], texels)
    bright = shine.sum(2)
    # Invert the cumulative distribution, over the lines and then along each
    cumulative = np.cumsum(bright.sum(1)) / bright.sum()
    i = np.searchsorted(cumulative, u).clip(0, len(cumulative) - 1)
    along = np.cumsum(bright, 1) / bright.sum(1, keepdims=True)
    j = np.array([np.searchsorted(along[a], b) for a, b in zip(i, v, strict=True)]).clip(0, bright.shape[1] - 1)
    places = np.column_stack([(j + 0.5) / bright.shape[1] * 2.0 - 1.0, 1.0 - (i + 0.5) / bright.shape[0] * 2.0])
    tint = shine[i, j] / bright[i, j][:, None]
    return np.column_stack([places, tint * (shine.mean((0, 1)) / tint.mean(0))])


@byte_cache(MOST_KEPT, 16, NEWEST)
def with_unit_radiance(objects: tuple[Shape, ...]) -> tuple[Shape, ...]:
    """The shapes with every light of uniform radiance 1."""
    return tuple(replace(o, material=replace(o.material, colour=(1.0, 1.0, 1.0), pattern=None))
                 if o.material.shines else o for o in objects)


def _darkened(light: Shape) -> Shape:
    """A light with radiance 0."""
    return replace(light, material=replace(light.material, colour=BLACK, pattern=None))
