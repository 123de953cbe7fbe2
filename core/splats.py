"""Small bright lights, traced from the light's side through the lens to the film.

A camera's ray meets a small light by chance alone, and a few bright dots stand for
a disk of light for as long as those are few. From the light's side every sample that
passes the lens falls into that disk. Which lights are splatted so is decided by how
many of the camera's rays would meet them in their own picture; to the camera's rays that part of a
light is black, in mirrors and coats it is what it was: no light is counted twice.

A pass of the picture holds a number of whole blocks of every such light. Threads trace
them to lists, and then each adds all lists, in their order, to a part of the film: the sums
are the same bit for bit for any number of threads.
"""

import math
from collections.abc import Callable
from concurrent.futures import Executor
from itertools import count
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.cameras.camera import Camera
from lensbench.cameras.landing import WayBack
from lensbench.driver import Program, perform
from lensbench.emission import emit, light_parameters, turn_back
from lensbench.fronts import Fronts, fronts
from lensbench.glass import D_LINE
from lensbench.lanes import BLUE, GREEN, KEYS, PIXEL, RED, SAMPLE, SEED, WEIGHT, B, Step, X, Y, bench, rows
from lensbench.motion import AnimatedTransform
from lensbench.sampling import net
from lensbench.scene import Scene
from lensbench.scenery.objects import Disk, Sphere
from lensbench.scenery.small_lights import SmallLight, divided, small_lights
from lensbench.spectrum import WAVELENGTHS, channel

MET = 0.4               # part of the camera's rays in its own picture that meet a light: above it they do better
DENSITY = 24.0          # samples per pixel of the picture of a light that is a point, in one pass, if there is time
SPREAD_DENSITY = 8.0    # of a light whose samples are spread
LEAST = 0.05            # part of that, below which the lights that need the most are left to the camera
BUDGET = 3.0            # samples of all lights for each pixel of the film, at the most, in one pass
TASK = 8                # blocks that a thread takes at a time
LIST = 128              # tasks whose samples are listed before they are added to the film
BLUR = 2.0              # pixels: a first sample is spread over no more, and not over more than the light's own image


class Chosen(NamedTuple):
    """A light that is splatted, as `emit` reads it."""

    light: SmallLight
    numbers: np.ndarray
    blocks: int                 # of B samples each, in one pass
    side: float                 # pixels: of the square over which the first samples are spread


class Splats:
    """What small lights add to a picture: sums over the passes so far, radiance of (pixels, 3)."""

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real=np.float32):
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._chosen = _choose(camera, scene, real)
        self.left, self._alone = divided(scene.objects, self.lights)
        film = camera.film
        self._across, self._down = film.pixels_x, film.pixels_y
        self._sums = np.zeros((film.pixels_x * film.pixels_y if self._chosen else 0, 3), np.float32)
        self._passes = 0
        self._programs: dict[tuple[float, int], Program] = {}

    @property
    def lights(self) -> list[SmallLight]:
        """Those that are traced from their own side; what is left to the camera's rays is `left`, objects."""
        return [chosen.light for chosen in self._chosen]

    def _program(self, wavelength: float, colour: int) -> Program:
        """The light's way at a wavelength (µm), for one colour RED, GREEN, BLUE, or 0: all of them."""
        if (wavelength, colour) not in self._programs:
            way = self._camera.way_back(wavelength)
            assert way is not None
            numbers = np.concatenate([chosen.numbers for chosen in self._chosen])
            dimming = [] if self._camera.medium is None else self._camera.medium.dimming
            steps = [Step(net, []), Step(emit, numbers), *self._camera.carried,
                     *self._scene.marking_steps(self._alone), *dimming, Step(turn_back, numbers), *way.steps,
                     *([channel(colour)] if colour else [])]
            self._programs[wavelength, colour] = Program(steps, self._real)
        return self._programs[wavelength, colour]

    def add(self, passes: list[tuple[int, int | None]], afresh: bool, pool: Executor, threads: int,
            wanted: Callable[[], bool]) -> bool:
        """Add passes: (number of the pass, which part of the spectrum or None for the d line alone).

        afresh: what there was so far is forgotten. False where `wanted` said no on the way.
        """
        if afresh:
            self._sums[:] = 0.0
            self._passes = 0
        self._passes += len(passes)
        tasks = [(program, j, chosen.side / math.sqrt(1.0 + number), number * chosen.blocks + first,
                  min(TASK, chosen.blocks - first))
                 for number, place in passes
                 for program in ([self._program(D_LINE, 0)] if place is None else
                                 [self._program(row[place], name) for name, row in WAVELENGTHS.items()])
                 for j, chosen in enumerate(self._chosen) for first in range(0, chosen.blocks, TASK)]
        lists = np.empty((min(LIST, len(tasks)), 5, TASK * B), np.float32)
        counts = np.zeros(LIST, np.int64)
        for start in range(0, len(tasks), LIST):
            part = tasks[start:start + LIST]
            turns = count()

            def shoot(_: int, part=part, turns=turns) -> bool:
                lanes = bench(self._real)
                while (k := next(turns)) < len(part):
                    if not wanted():
                        return False
                    program, j, _side, first, blocks = part[k]
                    counts[k] = _shoot(lists[k], lanes, program.code, program.gated, program.data, program.ends, j,
                                       first, blocks, self._seed)
                return True

            def gather(i: int, part=part) -> bool:
                top, bottom = self._down * i // threads, self._down * (i + 1) // threads
                for k, (_, _, side, _, _) in enumerate(part):
                    if not wanted():
                        return False
                    if side < 1.0:
                        _drop(self._sums, lists[k], counts[k], self._across, top, bottom)
                    else:
                        _spread(self._sums, lists[k], counts[k], self._across, top, bottom, np.float32(side))
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
    middle = _raster(way, centres, front.best)
    image = np.stack([_raster(way, centres + axis, front.best) - middle for axis in (rights, ups)], 1)
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
    sides = np.minimum(BLUR, 0.5 * np.sqrt(own))
    needed = (SPREAD_DENSITY + (DENSITY - SPREAD_DENSITY) / (1.0 + sides**2)) * whole / front.passing
    order = [int(k) for k in np.argsort(met, kind="stable") if met[k] < MET and not beside[k]]
    budget = BUDGET * film.pixels_x * film.pixels_y
    order = order[:int(np.searchsorted(np.cumsum(np.maximum(needed[order] * LEAST, B)), budget, "right"))]
    share = min(1.0, budget / max(needed[order].sum(), 1.0))
    keep = np.sort(np.array(order, int))
    blocks = np.maximum(1.0, np.ceil(share * needed[keep] / B))
    areas = 4.0 * np.sqrt((front.axes[keep]**2).sum(2).prod(1)) if way.radius > 0.0 else 1.0
    numbers = light_parameters([2.0 + small[k].number for k in keep], front.middles[keep], front.axes[keep],
                               front.towards[keep], centres[keep], rights[keep], ups[keep], disks[keep],
                               areas / (blocks * B))
    return [Chosen(small[k], row, int(many), float(sides[k]))
            for k, row, many in zip(keep, numbers, blocks, strict=True)]


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


def _raster(way: WayBack, points: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Raster points (n, 2) of rays from points (n, 3) through others of the camera frame."""
    d = through - points
    d /= np.sqrt((d**2).sum(1))[:, None]
    given = {X: through[:, 0], Y: through[:, 1], X + 2: through[:, 2], X + 3: d[:, 0], X + 4: d[:, 1], X + 5: d[:, 2],
             WEIGHT: np.ones(len(d))}
    return Program(way.bounding).run(given, [X, Y], len(d)).T.astype(float)


@njit(nogil=True, cache=True, error_model="numpy")
def _shoot(found, lanes, code, gated, data, ends, light, first, blocks, seed):
    """List x, y, red, green, blue of what reaches the film from so many blocks of a light; returns how many do."""
    key = np.empty(KEYS, np.uint32)
    key[SEED], key[PIXEL] = seed, light
    row = rows(lanes)
    x, y, weight, red, green, blue = row[X], row[Y], row[WEIGHT], row[RED], row[GREEN], row[BLUE]
    n = 0
    for block in range(first, first + blocks):
        key[SAMPLE] = block
        perform(lanes, code, gated, data, ends, key)
        for i in range(B):
            w = weight[i]
            if w > 0.0:
                found[0, n], found[1, n] = x[i], y[i]
                found[2, n], found[3, n], found[4, n] = w * red[i], w * green[i], w * blue[i]
                n += 1
    return n


@njit(nogil=True, cache=True, error_model="numpy")
def _drop(sums, found, n, across, top, bottom):
    """Add listed samples to the pixels that they fall on, in the rows top … bottom − 1."""
    for k in range(n):
        x, y = found[0, k], found[1, k]
        if (x >= 0.0) & (x < across) & (y >= top) & (y < bottom):
            i = int(y) * across + int(x)
            sums[i, 0] += found[2, k]
            sums[i, 1] += found[3, k]
            sums[i, 2] += found[4, k]


@njit(nogil=True, cache=True, error_model="numpy")
def _spread(sums, found, n, across, top, bottom, side):
    """As `_drop`, each sample spread evenly over a square of so many pixels about its place."""
    half, share, one = np.float32(0.5) * side, np.float32(1.0) / (side * side), np.float32(1.0)
    parts = np.empty(int(BLUR) + 2, np.float32)
    for k in range(n):
        x0, y0 = found[0, k] - half, found[1, k] - half
        x1, y1 = x0 + side, y0 + side
        if not ((x1 > 0.0) & (x0 < across) & (y1 > top) & (y0 < bottom)):
            continue
        r, g, b = found[2, k] * share, found[3, k] * share, found[4, k] * share
        left, right = max(int(x0), 0), min(int(x1) + 1, across)
        for column in range(left, right):
            parts[column - left] = min(x1, np.float32(column) + one) - max(x0, np.float32(column))
        for line in range(max(int(y0), top), min(int(y1) + 1, bottom)):
            high = min(y1, np.float32(line) + one) - max(y0, np.float32(line))
            hr, hg, hb = high * r, high * g, high * b
            i = line * across + left
            for j in range(right - left):
                sums[i + j, 0] += parts[j] * hr
                sums[i + j, 1] += parts[j] * hg
                sums[i + j, 2] += parts[j] * hb
