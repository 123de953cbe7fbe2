"""Small bright lights, traced from the light's side through the lens to the film.

A camera's ray meets a small light by chance alone, and a few bright dots stand for
a disk of light for as long as those are few. From the light's side every sample that
passes the lens falls into that disk. Which lights are splatted so is decided by how
many of the camera's rays would meet them in their own picture; to the camera's rays that part of a
light is black, in mirrors and coats it is what it was: no light is counted twice.

A pass of the picture holds a number of whole blocks of every such light. Threads trace
them to lists, and then each adds all lists, in their order, to a part of the film: the sums
are the same bit for bit for any number of threads.

A ray stands for rays from many points of its light to the same point before the lens, whose places on
the film differ by the image of the light. That is found to first order, and used where it is right to a tenth
of a pixel and nothing hides a part of the light; elsewhere every ray stands for itself.
"""

import math
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from itertools import count, islice
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.cameras.camera import Camera
from lensbench.cameras.landing import WayBack
from lensbench.disk import concentric
from lensbench.driver import Program, perform
from lensbench.emission import FLOW, MARK, emit, light_parameters, turn_back
from lensbench.fronts import Fronts, fronts
from lensbench.glass import D_LINE
from lensbench.lanes import (
    BLUE,
    DEPTH,
    GLOW,
    GREEN,
    KEYS,
    PITCH,
    PIXEL,
    RED,
    SAMPLE,
    SEED,
    V0,
    V1,
    WEIGHT,
    B,
    Step,
    X,
    Y,
    bench,
    rows,
)
from lensbench.motion import AnimatedTransform
from lensbench.sampling import net
from lensbench.scene import Scene
from lensbench.scenery.objects import Disk, Sphere
from lensbench.scenery.small_lights import POINTS, SmallLight, divided, evened, light_points, small_lights
from lensbench.spectrum import WAVELENGTHS, channel

MET = 0.4               # part of the camera's rays in its own picture that meet a light: above it they do better
DENSITY = 16.0          # rays per pixel of the picture of a light that is a point, in one pass, if there is time
SHARED_DENSITY = 2.0    # of a light whose rays stand for many
MANY = 32               # rays that one ray stands for, at the most; no more than the light's own image has pixels
STEADY = 0.1            # pixels: by how much, at the most, the image of a half-axis may change over the pupil
LEAST = 0.05            # part of that, below which the lights that need the most are left to the camera
BUDGET = 1.5            # samples of all lights for each pixel of the film, at the most, in one pass
FEW = 300e3             # rays of all lights that are never too many
TASK = 8                # blocks that a thread takes at a time
LIST = 128              # tasks whose samples are listed before they are added to the film


TURN = 19               # points of a light from one ray's first to the next ray's: without a common divisor of POINTS
NO_IMAGE = np.zeros((2, 2), np.float32)


class Chosen(NamedTuple):
    """A light that is splatted, as `emit` reads it."""

    light: SmallLight
    numbers: np.ndarray
    blocks: int                 # of B rays each, in one pass
    many: int                   # rays that a ray stands for; 0: none but itself
    alone: float                # how many times as many rays it takes if each stands for itself
    round: bool                 # whether its places fill the unit disk
    image: np.ndarray           # (2, 2) pixels: x, y of the image of each of the half-axes
    points: np.ndarray          # (POINTS, 5) of the light

    def with_blocks(self, blocks: int) -> "Chosen":
        """The same with another number of rays."""
        numbers = self.numbers.copy()
        numbers[FLOW] *= self.blocks / blocks
        return self._replace(blocks=blocks, numbers=numbers)


class Splats:
    """What small lights add to a picture: sums over the passes so far, radiance of (pixels, 3)."""

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real=np.float32):
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._programs: dict[tuple[float, int, bool], Program] = {}
        self._chosen = _choose(camera, scene, real)
        self.left, self._alone = divided(scene.objects, tuple(self.lights))
        film = camera.film
        self._across, self._down = film.pixels_x, film.pixels_y
        self._sums = np.zeros((film.pixels_x * film.pixels_y if self._chosen else 0, 3), np.float32)
        self._passes = 0
        settled = self._settled() if self._chosen else []
        share = min(1.0, _budget(camera) / B / max(sum(chosen.blocks for chosen in settled), 1))
        self._chosen = [chosen.with_blocks(max(1, round(chosen.blocks * share))) for chosen in settled]
        self._programs.clear()              # of the numbers before

    def _settled(self) -> list[Chosen]:
        """The lights as they are, or with more rays that each stand for themselves where some are blocked."""
        program, lanes, key = self._program(D_LINE, 0, True), bench(self._real), np.zeros(KEYS, np.uint32)
        table, settled = lanes.reshape(-1, PITCH)[:, :B], []
        for j, chosen in enumerate(self._chosen):
            key[PIXEL] = j
            perform(lanes, program.code, program.gated, program.data, program.ends, key)
            away = math.dist(chosen.numbers[:3], chosen.numbers[12:15])
            hidden = table[GLOW] != chosen.numbers[MARK]
            if not any(chosen.light.right):             # a ray may also miss a sphere, and meet what is behind it
                hidden &= table[DEPTH] < away - 2.0 * chosen.light.radius
            blocks = math.ceil(chosen.blocks * chosen.alone) if not hidden.all() else 1     # for what may peep out
            settled.append(chosen.with_blocks(blocks)._replace(many=0) if hidden.any() else chosen)
        return settled

    @property
    def lights(self) -> list[SmallLight]:
        """Those that are traced from their own side; what is left to the camera's rays is `left`, objects."""
        return [chosen.light for chosen in self._chosen]

    def _program(self, wavelength: float, colour: int, shared: bool) -> Program:
        """The light's way at a wavelength (µm), for one colour RED, GREEN, BLUE, or 0: all of them.

        shared: of lights of radiance 1, for rays that stand for many.
        """
        kind = wavelength, colour, shared
        if kind not in self._programs:
            way = self._camera.way_back(wavelength)
            assert way is not None
            numbers = np.concatenate([chosen.numbers for chosen in self._chosen])
            dimming = [] if self._camera.medium is None else self._camera.medium.dimming
            things = evened(self._alone) if shared else self._alone
            steps = [Step(net, []), Step(emit, numbers), *self._camera.carried, *self._scene.marking_steps(things),
                     *dimming, Step(turn_back, numbers), *way.steps, *([channel(colour)] if colour else [])]
            self._programs[kind] = Program(steps, self._real)
        return self._programs[kind]

    def _tasks(self, passes: list[tuple[int, int | None]]) -> Iterator[tuple[Program, int, int, int]]:
        """Program, number of the light among the chosen, first block, blocks."""
        for number, place in passes:
            ways = [(D_LINE, 0)] if place is None else [(row[place], name) for name, row in WAVELENGTHS.items()]
            for wavelength, colour in ways:
                for j, chosen in enumerate(self._chosen):
                    program = self._program(wavelength, colour, chosen.many > 0)
                    for first in range(0, chosen.blocks, TASK):
                        yield program, j, number * chosen.blocks + first, min(TASK, chosen.blocks - first)

    def add(self, passes: list[tuple[int, int | None]], afresh: bool, pool: Executor, threads: int,
            wanted: Callable[[], bool]) -> bool:
        """Add passes: (number of the pass, which part of the spectrum or None for the d line alone).

        afresh: what there was so far is forgotten. False where `wanted` said no on the way.
        """
        if afresh:
            self._sums[:] = 0.0
            self._passes = 0
        self._passes += len(passes)
        tasks = self._tasks(passes)
        lists = np.empty((LIST, 5, TASK * B), np.float32)
        counts = np.zeros(LIST, np.int64)
        while part := list(islice(tasks, LIST)):
            turns = count()

            def shoot(_: int, part=part, turns=turns) -> bool:
                lanes = bench(self._real)
                while (k := next(turns)) < len(part):
                    if not wanted():
                        return False
                    program, j, first, blocks = part[k]
                    light = self._chosen[j]
                    image = light.image if light.many > 0 else NO_IMAGE
                    counts[k] = _shoot(lists[k], lanes, program.code, program.gated, program.data, program.ends, j,
                                       first, blocks, self._seed, image, light.round)
                return True

            def gather(i: int, part=part) -> bool:
                top, bottom = self._down * i // threads, self._down * (i + 1) // threads
                for k, (_, j, _, _) in enumerate(part):
                    if not wanted():
                        return False
                    light = self._chosen[j]
                    _drop(self._sums, lists[k], counts[k], self._across, top, bottom, light.image, light.points,
                          light.many)
                return True

            if not all(list(pool.map(shoot, range(threads)))) or not all(list(pool.map(gather, range(threads)))):
                return False
        return True

    def image(self) -> np.ndarray:
        """The mean of the passes so far: (h, w, 3)."""
        return self._sums.reshape(self._down, self._across, 3) * np.float32(1.0 / max(self._passes, 1))


def _choose(camera: Camera, scene: Scene, real) -> list[Chosen]:
    """The lights that a camera's rays would find too seldom, with what `emit` needs of them."""
    place = camera.world_from_camera
    if isinstance(place, AnimatedTransform) or scene.moves or camera.has_port:
        return []
    small = small_lights(scene.objects, tuple(place[:3, 3]))
    way = camera.way_back() if small else None
    if way is None:
        return []
    camera_from_world = np.linalg.inv(place)
    turn, shift = camera_from_world[:3, :3], camera_from_world[:3, 3]
    centres = np.array([light.centre for light in small]) @ turn.T + shift
    front = fronts(way, centres, np.array([light.radius for light in small]), real)
    seen = np.nonzero(front.passing > 0.0)[0]
    if not seen.size:
        return []
    small, centres, front = [small[k] for k in seen], centres[seen], Fronts(*(values[seen] for values in front))
    start = np.array([0.0, 0.0, way.front])
    rights, ups, disks = _hiding(scene, small, turn, centres - start, np.sqrt((np.abs(front.axes).sum(1)**2).sum(1))
                                 + np.sqrt(((front.middles - start)**2).sum(1)))
    # How large its picture is, in pixels, and how much of that is due to the light's own size
    middle, image = _images(way, centres, rights, ups, front.best)
    steady = np.ones(len(small), bool)
    for k in (0, 1) if way.radius > 0.0 else ():
        for part in (-0.5, 0.5):
            _, other = _images(way, centres, rights, ups, front.middles + part * front.axes[:, k])
            steady &= (np.abs(other - image) < STEADY).all((1, 2))
    own = abs(np.linalg.det(image)) * np.where(disks, math.pi, 4.0)
    blur = front.blur if way.radius > 0.0 else np.repeat(middle, 2, 1)
    wide, high = blur[:, 1] - blur[:, 0], blur[:, 3] - blur[:, 2]
    whole = (np.sqrt(own) + np.sqrt(math.pi / 4.0 * wide * high) + 1.0) ** 2
    met = own / whole
    reach = np.abs(image).sum(1) + 1.0
    film = camera.film
    beside = ((blur[:, 1] < -reach[:, 0]) | (blur[:, 0] > film.pixels_x + reach[:, 0])
              | (blur[:, 3] < -reach[:, 1]) | (blur[:, 2] > film.pixels_y + reach[:, 1]))
    # As many samples as there is time for
    density = np.where(steady, SHARED_DENSITY + (DENSITY - SHARED_DENSITY) / (1.0 + own), DENSITY)
    needed = density * whole / front.passing
    order = [int(k) for k in np.argsort(met, kind="stable") if met[k] < MET and not beside[k]]
    budget = _budget(camera)
    order = order[:int(np.searchsorted(np.cumsum(np.maximum(needed[order] * LEAST, B)), budget, "right"))]
    share = min(1.0, budget / max(needed[order].sum(), 1.0))
    keep = np.sort(np.array(order, int))
    blocks = np.maximum(1.0, np.ceil(share * needed[keep] / B))
    areas = 4.0 * np.sqrt((front.axes[keep]**2).sum(2).prod(1)) if way.radius > 0.0 else 1.0
    numbers = light_parameters([2.0 + small[k].number for k in keep], front.middles[keep], front.axes[keep],
                               front.towards[keep], centres[keep], rights[keep], ups[keep], disks[keep],
                               areas / (blocks * B))
    return [Chosen(small[k], row, int(size), int(np.clip(own[k], 1, MANY)) if steady[k] else 0,
                   float(DENSITY / density[k]), bool(disks[k]),
                   np.ascontiguousarray(image[k], np.float32),
                   light_points(scene.objects[small[k].number], small[k]).astype(np.float32))
            for k, row, size in zip(keep, numbers, blocks, strict=True)]


def _budget(camera: Camera) -> float:
    """Rays of all lights in one pass, at the most."""
    return max(BUDGET * camera.film.pixels_x * camera.film.pixels_y, FEW)


def _hiding(scene: Scene, lights: list[SmallLight], turn: np.ndarray, away: np.ndarray,
            reach: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Half-axes (n, 3) of what hides each light from all points within `reach` (mm) of one; and which are ellipses.

    From that one the lights lie at `away` (n, 3). Camera frame, turned by `turn` from the world.
    """
    distance = np.sqrt((away**2).sum(1))
    towards = away / distance[:, None]
    seen = np.array([light.radius for light in lights]) / distance
    slant = reach / distance
    size = seen * distance / np.sqrt(1.0 - seen**2) * (1.0 + slant**2) * (1.0 + 1.5 * slant * seen) * (1.0 + 1e-5)
    upright = np.abs(towards[:, 1:2]) > 0.9
    side = np.cross(np.where(upright, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), towards)
    side /= np.sqrt((side**2).sum(1))[:, None]
    ball = np.array([isinstance(scene.objects[light.number], Sphere) for light in lights])
    rights, ups = (np.array(axes) @ turn.T for axes in zip(*((light.right, light.up) for light in lights), strict=True))
    rights = np.where(ball[:, None], side * size[:, None], rights)
    ups = np.where(ball[:, None], np.cross(towards, side) * size[:, None], ups)
    return rights, ups, np.array([isinstance(scene.objects[light.number], Sphere | Disk) for light in lights])


def _images(way: WayBack, centres: np.ndarray, rights: np.ndarray, ups: np.ndarray, through: np.ndarray):
    """Raster points (n, 2) of lights by rays through these points (n, 3), and their half-axes there (n, 2, 2)."""
    middle = _raster(way, centres, through)
    return middle, np.stack([_raster(way, centres + axis, through) - middle for axis in (rights, ups)], 1)


def _raster(way: WayBack, points: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Raster points (n, 2) of rays from points (n, 3) through others of the camera frame."""
    d = through - points
    d /= np.sqrt((d**2).sum(1))[:, None]
    given = {X: through[:, 0], Y: through[:, 1], X + 2: through[:, 2], X + 3: d[:, 0], X + 4: d[:, 1], X + 5: d[:, 2],
             WEIGHT: np.ones(len(d))}
    return Program(way.bounding).run(given, [X, Y], len(d)).T.astype(float)


@njit(nogil=True, cache=True, error_model="numpy")
def _shoot(found, lanes, code, gated, data, ends, light, first, blocks, seed, image, disk):
    """List x, y, red, green, blue of what reaches the film from so many blocks of a light; returns how many do.

    x, y are those of the light's centre, by the image of its half-axes, where that is not 0.
    """
    key = np.empty(KEYS, np.uint32)
    key[SEED], key[PIXEL] = seed, light
    row = rows(lanes)
    x, y, weight, red, green, blue = row[X], row[Y], row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    v0, v1 = row[V0], row[V1]
    real = lanes.dtype.type
    n = 0
    for block in range(first, first + blocks):
        key[SAMPLE] = block
        perform(lanes, code, gated, data, ends, key)
        for i in range(B):
            w = weight[i]
            if w > 0.0:
                a, b = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
                if disk:
                    a, b = concentric(real, v0[i], v1[i])
                found[0, n] = x[i] - a * image[0, 0] - b * image[1, 0]
                found[1, n] = y[i] - a * image[0, 1] - b * image[1, 1]
                found[2, n], found[3, n], found[4, n] = w * red[i], w * green[i], w * blue[i]
                n += 1
    return n


@njit(nogil=True, cache=True, error_model="numpy")
def _drop(sums, found, n, across, top, bottom, image, points, many):
    """Add listed rays to the pixels that they fall on, in the rows top … bottom − 1.

    Each as `many` rays from points of its light, as many further on from ray to ray; many = 0: as itself.
    """
    step = POINTS // max(many, 1)
    share = np.float32(1.0 / max(many, 1))
    for k in range(n):
        x, y, r, g, b = found[0, k], found[1, k], found[2, k] * share, found[3, k] * share, found[4, k] * share
        for m in range(max(many, 1)):
            px, py, pr, pg, pb = x, y, r, g, b
            if many > 0:
                j = (k * TURN + m * step) % POINTS
                px += points[j, 0] * image[0, 0] + points[j, 1] * image[1, 0]
                py += points[j, 0] * image[0, 1] + points[j, 1] * image[1, 1]
                pr, pg, pb = r * points[j, 2], g * points[j, 3], b * points[j, 4]
            if (px >= 0.0) & (px < across) & (py >= top) & (py < bottom):
                i = int(py) * across + int(px)
                sums[i, 0] += pr
                sums[i, 1] += pg
                sums[i, 2] += pb
