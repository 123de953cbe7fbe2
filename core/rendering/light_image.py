"""The light image: small bright lights, traced from the light through the lens to the film.

A camera's ray meets a small light only by chance, so its blurred disk starts as a few bright dots and
fills in only after many rays. A ray that is traced from the light falls into that disk whenever it passes the lens.
`light_selection` decides which lights are traced this way, and by which mirrors and balls. The camera's rays see that
part of a light as black, so that no light is counted twice.

The first passes of a picture trace a number of whole blocks of every such light, and later only one pass in
some does (`light_period`); the light image therefore counts its own passes. Threads trace tasks to lists of rays, and
then each thread adds all lists, in their order, to its own rows of the film: the sums are the same, bit for bit, for
any number of threads.

One ray can represent rays from many points of its light through the same point of the lens, whose places on
the film differ by the image of the light. The image is found to first order, and used where it holds to a tenth
of a pixel and nothing hides a part of the light; elsewhere one ray is one ray.
"""

import math
import mmap
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import suppress
from itertools import count, islice, pairwise
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.core.kernels.block import (
    BLUE, DEPTH, GREEN, KEYS, PIXEL, RED, SAMPLE, SEED, V0, V1, WEIGHT, B, Step, X, Y, Z, lane_buffer, rows
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, raise_pending, run_steps
from lensbench.core.kernels.sampling import concentric_disk, sobol_net
from lensbench.core.optics.glass import D_LINE
from lensbench.core.rendering.light_layer import (
    DECIDED, FIRST_PASSES, LIST_BLUE, LIST_GREEN, LIST_RED, LIST_SIZE, LIST_V0, LIST_X, LIST_Y, LightLayer, LightPeriod,
    add_mean, add_rays
)
from lensbench.core.rendering.light_rays import (
    LIGHT_MARK, LIGHT_SIZE, MARK, apply_throughput, require_mirror, reverse_ray, trace_by_ball, trace_to_light
)
from lensbench.core.rendering.light_selection import BALL, STRAIGHT, SelectedLight, ray_budget, select_lights
from lensbench.core.rendering.sample_programs import SamplePrograms
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.bounces import specular_bounce
from lensbench.core.scenery.shading.illumination import begin_path, gather_emission
from lensbench.core.scenery.small_lights import ExcludedLight, SmallLight, split_light, with_unit_radiance

TASK = 8                # blocks that a thread takes at a time
HIDDEN_PERIOD = 8       # passes with lights of which one traces a light that seems hidden
CHECKED = 8             # lights that a thread checks for being hidden at a time
LISTS = 128             # tasks whose rays are listed before they are added to the film
MOST_KEPT = 2_000_000   # rays of the first pass that are kept for another picture
NO_IMAGE = np.zeros((2, 2), np.float32)


class _Task(NamedTuple):
    """Some blocks of one light in one pass."""

    program: Program
    light: int                  # index among the selected
    first: int                  # block
    blocks: int


class LightImage:
    """Contribution of small lights to a picture: sums of radiance over the passes so far.

    Parameters: the camera, whose model is resolved; the scene; the sampler seed; the real type of the kernels; the
    programs of the camera's rays; the number of passes that trace lights at the most, None: as many as repay their
    time.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real: type, programs: SamplePrograms,
                 most: int | None = None):
        self._camera_programs, self._most = programs, most
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._programs: dict[tuple[float, int, bool, int], Program] = {}
        self._selected, mirrored = select_lights(camera, scene, real)
        first, alone = split_light(scene.objects, tuple(self.lights))
        later, alone_later = split_light(scene.objects, mirrored)
        mirrors = frozenset(light.mirror for light in self._selected if light.kind != STRAIGHT)
        self.excluded = ExcludedLight(first, mirrors, later)
        self._things = alone, alone_later, alone_later      # of light on paths STRAIGHT, FLAT, BALL
        film = camera.film
        self._across, self._down = film.pixels_x, film.pixels_y
        self._sums = _sparse_zeros(film.pixels_x * film.pixels_y if self._selected else 0)
        self._passes = self._next = 0               # passes with lights, and the number of the next pass
        self._kept: list[tuple[int, np.ndarray]] | None = []     # lights and rays of the first pass
        self._layer: LightLayer | None = None
        self._is_prepared, self._period = not self._selected, LightPeriod((self._down, self._across), seed)

    @property
    def is_empty(self) -> bool:
        """Whether all lights are left to the camera's rays."""
        return not self._selected

    @property
    def lights(self) -> list[SmallLight]:
        """The lights that are traced straight; `excluded` is the scene as the camera's rays then see it."""
        return [light.light for light in self._selected if light.kind == STRAIGHT]

    def image(self) -> np.ndarray:
        """The mean of the passes so far: (h, w, 3)."""
        return self._sums.reshape(self._down, self._across, 3) * np.float32(1.0 / max(self._passes, 1))

    def add_to(self, picture: np.ndarray, top: int = 0) -> None:
        """Add the mean of the passes so far to lines of a picture (lines, w, 3), the first of which is `top`."""
        add_mean(picture, self._sums.reshape(self._down, self._across, 3)[top:top + len(picture)], self._passes)

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name, for `restore`."""
        return {"light_passes": np.array(self._passes, np.int64), "light_sums": self._sums} | self._period.state

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from such sums."""
        self._passes = int(state["light_passes"])
        if self._sums is not state["light_sums"]:
            self._sums[:] = state["light_sums"]
        self._period.restore(state)

    def layer(self) -> LightLayer | None:
        """Rays of the first pass, for another picture; None if several passes were added at once, or for too many."""
        if self._kept is not None and self._layer is None:
            self._layer = LightLayer.of(self._camera, self._selected, self._kept, self.left_out)
        return self._layer

    @property
    def left_out(self) -> ExcludedLight | None:
        """What the camera's rays must not see; None where no light is traced."""
        return None if self.is_empty else self.excluded

    def add(self, passes: list[tuple[int, int | None]], afresh: bool, pool: Executor, threads: int,
            wanted: Callable[[], bool]) -> bool:
        """Add passes: (number of the pass, its part of the spectrum or None for the d line alone).

        Passes that it has already are left out. afresh: discard the sums so far. Returns False when `wanted` did so on
        the way.
        """
        if not self._is_prepared:
            self._prepare(pool, threads)
        if afresh:
            self._sums = _sparse_zeros(len(self._sums))
            self._passes = self._next = 0
            self._period.clear()
        if self._next == 0:
            self._kept, self._layer = [] if len(passes) == 1 else None, None
        # Stop where the period needs the sums so far
        for begin, end in pairwise((0, FIRST_PASSES // 2, FIRST_PASSES, DECIDED, passes[-1][0] + 1)):
            piece = [(number, band) for number, band in passes if max(begin, self._next) <= number < end]
            if piece and not self._add_piece(piece, pool, threads, wanted):
                return False
        return True

    def _add_piece(self, passes: list[tuple[int, int | None]], pool: Executor, threads: int,
                   wanted: Callable[[], bool]) -> bool:
        """Add successive passes, of which the first alone may need to decide the period; see `add`."""
        is_first, period = self._next == 0, self._period
        is_due = passes[0][0] >= DECIDED and self._most is None and not period.is_decided
        if is_due and not period.decide(self._camera_programs.plain(self.excluded), pool, threads, wanted):
            return False
        self._next = passes[-1][0] + 1
        own = [(period.before(number), band) for number, band in passes if period.traces(number)]
        if self._most is not None:
            own = [(number, band) for number, band in own if number < self._most]
        tasks = self._tasks([(number, None if band is None else spectral_part(number, self._seed))
                             for number, band in own])
        lists = np.empty((LISTS, LIST_SIZE, TASK * B), np.float32)
        counts = np.zeros(LISTS, np.int64)
        while listed := list(islice(tasks, LISTS)):
            turns = count()

            def trace(_: int, listed: Any = listed, turns: Any = turns) -> bool:
                lanes = lane_buffer(self._real)
                while (k := next(turns)) < len(listed):
                    if not wanted():
                        return False
                    counts[k] = self._list_rays(lists[k], lanes, listed[k])
                return True

            def gather(i: int, listed: Any = listed) -> bool:
                top, bottom = self._down * i // threads, self._down * (i + 1) // threads
                for k, task in enumerate(listed):
                    if not wanted():
                        return False
                    light = self._selected[task.light]
                    add_rays(self._sums, lists[k], counts[k], self._across, top, bottom, light.image, light.points,
                              light.shared)
                return True

            if not all(list(pool.map(trace, range(threads)))) or not all(list(pool.map(gather, range(threads)))):
                return False
            if is_first and self._kept is not None:
                self._kept += [(task.light, lists[k, :, :counts[k]].copy()) for k, task in enumerate(listed)]
                if sum(rays.shape[1] for _, rays in self._kept) > MOST_KEPT:
                    self._kept = None
        self._passes += len(own)
        if self._next <= FIRST_PASSES:
            period.note(self._next, self._sums)
        return True

    def _list_rays(self, rays: np.ndarray, lanes: np.ndarray, task: _Task) -> int:
        """Trace a task and list the rays that reach the film; returns their number."""
        light, program = self._selected[task.light], task.program
        n = _list_rays(rays, lanes, program.code, task.light, task.first, task.blocks, self._seed,
                       light.image if light.shared > 0 else NO_IMAGE, light.is_round)
        raise_pending()
        return n

    def _tasks(self, passes: list[tuple[int, int | None]]) -> Iterator[_Task]:
        for number, band in passes:
            channels = [(D_LINE, 0)] if band is None else [(row[band], name) for name, row in WAVELENGTHS.items()]
            for wavelength, colour in channels:
                for j, light in enumerate(self._selected):
                    if (number + j) % light.period:
                        continue
                    program = self._program(wavelength, colour, light.shared > 0, light.kind)
                    for first in range(0, light.blocks, TASK):
                        yield _Task(program, j, number * light.blocks + first, min(TASK, light.blocks - first))

    # Programs

    def _program(self, wavelength: float, colour: int, shared: bool, kind: int) -> Program:
        """The stages from V0, V1 and U0, U1 to the raster at a wavelength (µm).

        colour: RED, GREEN, BLUE, or 0 for all. shared: whether each ray represents many, of lights of even radiance.
        kind: STRAIGHT, FLAT or BALL.
        """
        key = wavelength, colour, shared, kind
        if key not in self._programs:
            landing = self._camera.film_landing(wavelength)
            assert landing is not None
            parameters = np.concatenate([light.parameters for light in self._selected])
            steps = [*self._steps_to_light(kind, shared, parameters), Step(reverse_ray, parameters), *landing.steps,
                     *([channel_step(colour)] if colour else [])]
            self._programs[key] = Program(steps, self._real)
        return self._programs[key]

    def _steps_to_light(self, kind: int, shared: bool, parameters: np.ndarray) -> list[Step]:
        """The stages from the entrance plane to a light, or to what hides the light; see `_program`."""
        things, medium = self._things[kind], self._camera.medium
        connect = trace_by_ball if kind == BALL else trace_to_light
        steps = [Step(sobol_net), Step(connect, parameters, [light.is_round for light in self._selected]),
                 *self._camera.carried]
        met = self._scene.marking_steps(with_unit_radiance(things) if shared else things)
        if kind == STRAIGHT:
            return [*steps, *met, *([] if medium is None else medium.dimming)]
        fog = [] if medium is None else medium.steps
        return [*steps, Step(begin_path), *met, *fog, Step(gather_emission),
                Step(require_mirror, parameters), Step(specular_bounce), *met, *fog, Step(apply_throughput)]

    # Preparation with the first pass, whose threads help

    def _prepare(self, pool: Executor, threads: int) -> None:
        """See which lights are hidden, and share the rays out among the lights."""
        hidden = self._hidden_rays(pool, threads)
        period = HIDDEN_PERIOD if self._most is None else min(HIDDEN_PERIOD, self._most)
        checked = [_adapted(light, rays, period) for light, rays in zip(self._selected, hidden, strict=True)]
        share = min(1.0, ray_budget(self._camera) / B / max(sum(light.blocks for light in checked), 1))
        self._selected = [light.with_rays(max(1, round(light.blocks * share)), light.period) for light in checked]
        self._period.set_early(sum(light.blocks / light.period for light in self._selected) * B,
                               sum(light.covered for light in self._selected if light.period == 1))
        self._is_prepared = True

    def _hidden_rays(self, pool: Executor, threads: int) -> np.ndarray:
        """(lights,) how many of B rays to each selected light something hides."""
        parameters = np.stack([light.parameters for light in self._selected]).reshape(-1, LIGHT_SIZE)
        spheres = np.array([[*light.light.centre, 0.0 if any(light.light.right) else light.light.radius]
                            for light in self._selected])
        hidden, kinds = np.zeros(len(parameters), np.int64), np.array([light.kind for light in self._selected])
        for kind in np.unique(kinds):
            program = Program(self._steps_to_light(kind, True, parameters.ravel()), self._real)
            which, turns = np.nonzero(kinds == kind)[0], count(0, CHECKED)

            def check(_: int, program: Program = program, which: Any = which, turns: Any = turns) -> None:
                lanes = lane_buffer(self._real)
                while (first := next(turns)) < len(which):
                    _count_hidden(hidden, which[first:first + CHECKED], lanes, program.code,
                                  parameters[:, LIGHT_MARK], spheres)

            list(pool.map(check, range(threads)))
        return hidden


def _sparse_zeros(pixels: int) -> np.ndarray:
    """(pixels, 3) float32, 0: takes memory only near what is written, 4 kB at a time.

    The pages of numpy's own large arrays are 2 MB, so that few rays would fill the image of a large film.
    """
    if not hasattr(mmap, "MADV_NOHUGEPAGE"):        # of Linux
        return np.zeros((pixels, 3), np.float32)
    memory = mmap.mmap(-1, max(12 * pixels, 1), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    with suppress(OSError):                         # a kernel without huge pages
        memory.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(memory, np.float32, 3 * pixels).reshape(pixels, 3)


def _adapted(light: SelectedLight, hidden: int, period: int) -> SelectedLight:
    """A light of whose B rays some are hidden: one ray is one ray; one that is all hidden is traced once a period."""
    if not hidden:
        return light
    if hidden == B:                             # a part may still show
        return light.with_rays(1, period)._replace(shared=0)
    return light.with_rays(math.ceil(light.blocks * light.unshared))._replace(shared=0)


@njit(nogil=True, cache=True, error_model="numpy")
def _count_hidden(hidden, which, lanes, code, marks, spheres):
    """How many of B rays to each of these lights are hidden; spheres: centre (world), radius of a sphere or 0."""
    key = np.zeros(KEYS, np.uint32)
    row = rows(lanes)
    x, y, z, met, weight, depth = row[X], row[Y], row[Z], row[MARK], row[WEIGHT], row[DEPTH]
    for j in which:
        key[PIXEL] = j
        run_steps(lanes, code, key)
        cx, cy, cz, radius = spheres[j]
        for i in range(B):
            a, b, c = x[i] - cx, y[i] - cy, z[i] - cz
            before = depth[i] < math.sqrt(a * a + b * b + c * c) - 2.0 * radius
            # A ray may also miss a sphere, and meet what lies behind the sphere
            blocked = met[i] != marks[j] and (radius == 0.0 or before)
            hidden[j] += 1 if blocked or not weight[i] > 0.0 else 0


@njit(nogil=True, cache=True, error_model="numpy")
def _list_rays(rays, lanes, code, light, first, blocks, seed, image, is_round):
    """List the rays of some blocks of a light that reach the film; returns their number.

    The raster point is that of the light's centre, by the image of the half-axes, where that image is not 0.
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
        run_steps(lanes, code, key)
        for i in range(B):
            w = weight[i]
            if w > 0.0:
                a, b = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
                if is_round:
                    a, b = concentric_disk(real, v0[i], v1[i])
                rays[LIST_X, n] = x[i] - a * image[0, 0] - b * image[1, 0]
                rays[LIST_Y, n] = y[i] - a * image[0, 1] - b * image[1, 1]
                rays[LIST_RED, n], rays[LIST_GREEN, n], rays[LIST_BLUE, n] = w * red[i], w * green[i], w * blue[i]
                rays[LIST_V0, n] = v0[i]
                n += 1
    return n
