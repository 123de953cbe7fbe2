"""Small bright lights, traced from the light's side through the lens to the film.

A camera's ray meets a small light by chance alone, and a few bright dots stand for
a disk of light for as long as those are few. From the light's side every sample that
passes the lens falls into that disk. Which lights are splatted so, and in which mirrors and
balls, is decided by how many of the camera's rays would meet them in their own picture (`sightings`); to the
camera's rays that part of a light is black, and what those mirrors show of it: no light is counted twice.

The first passes of a picture hold a number of whole blocks of every such light, later only one pass in
some: these sums have a count of their own. Threads trace
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

import numpy as np
from numba import njit

from lensbench.cameras.base import Camera
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import (
    BLUE,
    DEPTH,
    EMITS,
    GREEN,
    KEYS,
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
    Z,
    lane_buffer,
    rows,
)
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.kernels.program import Program, run_steps
from lensbench.kernels.sampling import sobol_net
from lensbench.optics.glass import D_LINE
from lensbench.rendering.light_rays import LIGHT, MARK, bent_there, carry_on, emit, emit_by_ball, turn_back
from lensbench.rendering.light_selection import BALL, STRAIGHT, SelectedLight, budget, select_lights
from lensbench.scenery.scene import Scene
from lensbench.scenery.shading.illumination import begin_path, gather_emission
from lensbench.scenery.shading.specular_bounce import specular_bounce
from lensbench.scenery.small_lights import POINTS, ExcludedLight, SmallLight, split_light, with_unit_radiance

TASK = 8                # blocks that a thread takes at a time
OFTEN, RARELY = 4, 4    # first passes of a picture that have splats, and of how many later ones one has at the most
RAREST = 8              # times that many, at the least
COVERED = 0.1           # part of the film: covered by splats that take the time of its samples, they come so often
SELDOM = 8              # of those, of which a light that seems hidden is traced in one
LOOK = 8                # lights that it looks for at a time, to see whether they are hidden
LIST = 128              # tasks whose samples are listed before they are added to the film
NO_IMAGE = np.zeros((2, 2), np.float32)


class LightImage:
    """What small lights add to a picture: sums over the passes so far, radiance of (pixels, 3)."""

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real=np.float32):
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._programs: dict[tuple[float, int, bool, int], Program] = {}
        self._chosen, bent = select_lights(camera, scene, real)
        left, alone = split_light(scene.objects, tuple(self.lights))
        later, alone_later = split_light(scene.objects, bent)
        by = frozenset(chosen.by for chosen in self._chosen if chosen.how != STRAIGHT)
        self.taken = ExcludedLight(left, by, later)
        self._things = alone, alone_later, alone_later      # of light seen STRAIGHT, FLAT, by BALL
        film = camera.film
        self._across, self._down = film.pixels_x, film.pixels_y
        self._sums = np.zeros((film.pixels_x * film.pixels_y if self._chosen else 0, 3), np.float32)
        self._passes = 0
        self._is_settled, self._rarely = not self._chosen, RARELY

    def _settle(self, pool: Executor, threads: int) -> None:
        """See which lights are hidden, and share the rays out among them. With the first pass: its threads help."""
        settled = self._settled(pool, threads)
        share = min(1.0, budget(self._camera) / B / max(sum(chosen.blocks for chosen in settled), 1))
        self._chosen = [chosen.traced(max(1, round(chosen.blocks * share)), chosen.every) for chosen in settled]
        self._rarely = RARELY * self._seldomness()
        self._is_settled = True

    def _seldomness(self) -> int:
        """How many times rarer than RARELY passes have splats: where these take long, or little is to be seen of them.

        The best share of the time goes as the root of both, cost and variance.
        """
        pixels = self._across * self._down
        cost = sum(chosen.blocks / chosen.every for chosen in self._chosen) * B / pixels
        covered = sum(chosen.covered for chosen in self._chosen if chosen.every == 1) / pixels
        return round(min(max(math.sqrt(cost * COVERED / max(covered, 1e-9)), 1.0), RAREST))

    def _settled(self, pool: Executor, threads: int) -> list[SelectedLight]:
        """The lights as they are, or with more rays that each stand for themselves where some are blocked."""
        numbers = np.concatenate([chosen.numbers for chosen in self._chosen])
        numbers = numbers.reshape(-1, LIGHT)
        lights = np.array([[*chosen.light.centre, 0.0 if any(chosen.light.right) else chosen.light.radius]
                           for chosen in self._chosen])
        hidden, how = np.zeros(len(numbers), np.int64), np.array([chosen.how for chosen in self._chosen])
        for kind in np.unique(how):
            program = Program(self._outward(kind, True, numbers.ravel()), self._real)
            which, turns = np.nonzero(how == kind)[0], count(0, LOOK)

            def look(_: int, program=program, which=which, turns=turns) -> None:
                lanes = lane_buffer(self._real)
                while (first := next(turns)) < len(which):
                    _look(hidden, which[first:first + LOOK], lanes, program.code, program.gated, program.data,
                          program.ends, numbers[:, MARK], lights)

            list(pool.map(look, range(threads)))
        settled = []
        for chosen, blocked in zip(self._chosen, hidden, strict=True):
            if blocked == B:                            # for what may peep out
                chosen = chosen.traced(1, SELDOM)
            elif blocked:
                chosen = chosen.traced(math.ceil(chosen.blocks * chosen.alone))
            settled.append(chosen._replace(many=0) if blocked else chosen)
        return settled

    @property
    def is_empty(self) -> bool:
        """Whether everything is left to the camera's rays."""
        return not self._chosen

    @property
    def lights(self) -> list[SmallLight]:
        """Those that are traced straight from their own side; what the camera's rays do not see for it is `taken`."""
        return [chosen.light for chosen in self._chosen if chosen.how == STRAIGHT]

    def _outward(self, how: int, shared: bool, numbers: np.ndarray) -> list[Step]:
        """From the plane before the lens to a light, or to what hides it; see `_program`."""
        things, medium = self._things[how], self._camera.medium
        steps = [Step(sobol_net, []), Step(emit_by_ball if how == BALL else emit, numbers), *self._camera.carried]
        met = self._scene.marking_steps(with_unit_radiance(things) if shared else things)
        if how == STRAIGHT:
            return [*steps, *met, *([] if medium is None else medium.dimming)]
        fog = [] if medium is None else medium.steps
        return [*steps, Step(begin_path, []), *met, *fog, Step(gather_emission, []), Step(bent_there, numbers),
                Step(specular_bounce, []), *met, *fog, Step(carry_on, [])]

    def _program(self, wavelength: float, colour: int, shared: bool, how: int) -> Program:
        """The light's way at a wavelength (µm), for one colour RED, GREEN, BLUE, or 0: all of them.

        shared: of lights of radiance 1, for rays that stand for many. how: STRAIGHT, FLAT or by a BALL.
        """
        kind = wavelength, colour, shared, how
        if kind not in self._programs:
            way = self._camera.way_back(wavelength)
            assert way is not None
            numbers = np.concatenate([chosen.numbers for chosen in self._chosen])
            steps = [*self._outward(how, shared, numbers), Step(turn_back, numbers), *way.steps,
                     *([channel_step(colour)] if colour else [])]
            self._programs[kind] = Program(steps, self._real)
        return self._programs[kind]

    def _tasks(self, passes: list[tuple[int, int | None]]) -> Iterator[tuple[Program, int, int, int]]:
        """Program, number of the light among the chosen, first block, blocks."""
        for number, place in passes:
            ways = [(D_LINE, 0)] if place is None else [(row[place], name) for name, row in WAVELENGTHS.items()]
            for wavelength, colour in ways:
                for j, chosen in enumerate(self._chosen):
                    if (number + j) % chosen.every:
                        continue
                    program = self._program(wavelength, colour, chosen.many > 0, chosen.how)
                    for first in range(0, chosen.blocks, TASK):
                        yield program, j, number * chosen.blocks + first, min(TASK, chosen.blocks - first)

    def add(self, passes: list[tuple[int, int | None]], afresh: bool, pool: Executor, threads: int,
            wanted: Callable[[], bool]) -> bool:
        """Add passes: (number of the pass, which part of the spectrum or None for the d line alone).

        afresh: what there was so far is forgotten. False where `wanted` said no on the way.
        """
        if not self._is_settled:
            self._settle(pool, threads)
        if afresh:
            self._sums[:] = 0.0
            self._passes = 0
        own = [(self._own_number(number), place) for number, place in passes
               if number < OFTEN or number % self._rarely == 0]
        self._passes += len(own)
        tasks = self._tasks([(number, None if place is None else spectral_part(number, self._seed))
                             for number, place in own])
        lists = np.empty((LIST, 6, TASK * B), np.float32)
        counts = np.zeros(LIST, np.int64)
        while listed := list(islice(tasks, LIST)):
            turns = count()

            def shoot(_: int, listed=listed, turns=turns) -> bool:
                lanes = lane_buffer(self._real)
                while (k := next(turns)) < len(listed):
                    if not wanted():
                        return False
                    program, j, first, blocks = listed[k]
                    light = self._chosen[j]
                    image = light.image if light.many > 0 else NO_IMAGE
                    counts[k] = _shoot(lists[k], lanes, program.code, program.gated, program.data, program.ends, j,
                                       first, blocks, self._seed, image, light.round)
                return True

            def gather(i: int, listed=listed) -> bool:
                top, bottom = self._down * i // threads, self._down * (i + 1) // threads
                for k, (_, j, _, _) in enumerate(listed):
                    if not wanted():
                        return False
                    light = self._chosen[j]
                    _drop(self._sums, lists[k], counts[k], self._across, top, bottom, light.image, light.points,
                          light.many)
                return True

            if not all(list(pool.map(shoot, range(threads)))) or not all(list(pool.map(gather, range(threads)))):
                return False
        return True

    def _own_number(self, number: int) -> int:
        """How many passes before this one had splats."""
        rarely = self._rarely
        return number if number < OFTEN else OFTEN + (number - 1) // rarely - (OFTEN - 1) // rarely

    def image(self) -> np.ndarray:
        """The mean of the passes so far: (h, w, 3)."""
        return self._sums.reshape(self._down, self._across, 3) * np.float32(1.0 / max(self._passes, 1))


@njit(nogil=True, cache=True, error_model="numpy")
def _look(hidden, which, lanes, code, gated, data, ends, marks, lights):
    """How many of B rays to these lights are hidden from them; lights: centre (world), radius of a sphere or 0."""
    key = np.zeros(KEYS, np.uint32)
    row = rows(lanes)
    x, y, z, glow, weight, depth = row[X], row[Y], row[Z], row[EMITS], row[WEIGHT], row[DEPTH]
    for j in which:
        key[PIXEL] = j
        run_steps(lanes, code, gated, data, ends, key)
        cx, cy, cz, radius = lights[j]
        for i in range(B):
            a, b, c = x[i] - cx, y[i] - cy, z[i] - cz
            before = depth[i] < math.sqrt(a * a + b * b + c * c) - 2.0 * radius
            # a ray may also miss a sphere, and meet what is behind it
            blocked = glow[i] != marks[j] and (radius == 0.0 or before)
            hidden[j] += 1 if blocked or not weight[i] > 0.0 else 0


@njit(nogil=True, cache=True, error_model="numpy")
def _shoot(found, lanes, code, gated, data, ends, light, first, blocks, seed, image, disk):
    """List x, y, red, green, blue, V0 of what reaches the film from so many blocks of a light; returns how many do.

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
        run_steps(lanes, code, gated, data, ends, key)
        for i in range(B):
            w = weight[i]
            if w > 0.0:
                a, b = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
                if disk:
                    a, b = concentric_disk(real, v0[i], v1[i])
                found[0, n] = x[i] - a * image[0, 0] - b * image[1, 0]
                found[1, n] = y[i] - a * image[0, 1] - b * image[1, 1]
                found[2, n], found[3, n], found[4, n] = w * red[i], w * green[i], w * blue[i]
                found[5, n] = v0[i]
                n += 1
    return n


@njit(nogil=True, cache=True, error_model="numpy")
def _drop(sums, found, n, across, top, bottom, image, points, many):
    """Add listed rays to the pixels that they fall on, in the rows top … bottom − 1.

    Each as `many` rays from points of its light; many = 0: as itself. Which points these are is told by V0, which is
    spread over the rays together with their places before the lens.
    """
    aside, tints = np.zeros((POINTS, 2), np.float32), np.ones((POINTS, 3), np.float32)
    reach, share = np.float32(0), np.float32(1.0 / max(many, 1))
    for j in range(POINTS if many > 0 else 0):              # loops alone: sums of whole arrays take seconds to compile
        for c in range(2):
            aside[j, c] = points[j, 0] * image[0, c] + points[j, 1] * image[1, c]
        for c in range(3):
            tints[j, c] = points[j, 2 + c] * share
        reach = max(reach, abs(aside[j, 1]))
    many = max(many, 1)
    step = POINTS // many
    for k in range(n):
        x, y, r, g, b = found[0, k], found[1, k], found[2, k], found[3, k], found[4, k]
        if not ((y + reach >= top) & (y - reach < bottom)):
            continue
        begin = int(found[5, k] * np.float32(step))
        for j in range(begin, POINTS, step):
            px, py = x + aside[j, 0], y + aside[j, 1]
            if (px >= 0.0) & (px < across) & (py >= top) & (py < bottom):
                i = int(py) * across + int(px)
                sums[i, 0] += r * tints[j, 0]
                sums[i, 1] += g * tints[j, 1]
                sums[i, 2] += b * tints[j, 2]
