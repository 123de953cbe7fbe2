"""The ghost image: light of the sun and of small lights that two surfaces of the lens reflect onto the film.

Every pair of surfaces has a grid of rays for every light, whose cells land on the film (`ghost_cells`): a picture
without noise from the first pass on. Later passes shift the grids, and take other points of the lights; their mean has
softer edges of cells, and the true size of the lights. With many lights a pass draws some of the dim ghosts, by their
light, and each counts by the inverse of its chance. The first four passes of a picture add ghosts, then every fourth,
at most MOST of them.

Where the camera disperses, red, green and blue have grids of their own, each at a wavelength of its channel, another
one in every pass: ghosts have coloured edges.

A lens that was designed for one wavelength, which a picture may not see, reflects as at this one (`Flare.wavelength`).

Ghosts have the scale of the direct light: as a picture has no losses by reflection, they are divided by what the
surfaces transmit on the axis.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.real_lens import LensCamera
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import lane_buffer
from lensbench.core.optics.coatings import Coating
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.ghost_grid import Box, entrance_grid, entrance_reach, pair_boxes
from lensbench.core.optics.ghost_path import DIRECT, Pair, ghost_pairs, no_such_pair, pair_share
from lensbench.core.optics.ghost_trace import GhostTracer
from lensbench.core.optics.glass import D_LINE
from lensbench.core.rendering.ghost_lights import GhostLights, add_cells, add_lines, ghost_lights
from lensbench.core.rendering.light_layer import add_mean
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import significant

FIRST, PERIOD, MOST = 4, 4, 64  # passes that all add ghosts; then one in so many does; at the most
SIDE = 31                       # cells along a side of the grid of a bright ghost: 1,024 rays
SMALL_SIDE = 21                 # of the dim ones: 484 rays, less than a block
BEST, DRAWN = 150, 150          # grids in every pass: the brightest ones, and drawn ones
EVEN = 0.25                     # × the mean reflectance of pairs, added to each chance: oblique rays have others
LEAST = 1e-12                   # of that mean: no chance is 0
GOLDEN = 0.6180339887498949     # whose multiples modulo 1 are even
LINES = 60                      # of the film, to which a thread adds the cells of a batch at a time
BATCH = 64                      # grids that are traced before they are added to the film
PARTS = (3, 6, 1, 4, 0, 7, 2, 5)        # of a channel's wavelengths, in the order of the passes: the middle first


@dataclass(frozen=True)
class Flare:
    """Light of a lens about its lights: ghosts and stars.

    Args:
        coating: Of the surfaces to air that have none of their own: "uncoated", "single-layer", "multi-layer", or any
            coating.
        strength: Factor on the light of ghosts; 1 is true to scale with the direct light, 0 shows none.
        pairs: tuple of (int, int). Pairs of surfaces (first, second) to show; () for all.
        stars: Factor on the light that the edges of the open pupil diffract from the sun and small lights: the rays of
            the blades. 1 is true to scale, 0 none.
        wavelength: Of all light (µm), for a camera whose lens is that of a design for another wavelength than the
            picture's: its surfaces reflect, and its stop diffracts, as at this one. None: each channel has its own
            wavelengths.
    """

    coating: str | Coating = "uncoated"
    strength: float = 1.0
    pairs: tuple[Pair, ...] = ()
    stars: float = 0.0
    wavelength: float | None = None

    @property
    def channels(self) -> tuple[tuple[float, ...], ...]:
        """The wavelengths (µm) of red, green and blue."""
        return tuple(WAVELENGTHS.values()) if self.wavelength is None else ((self.wavelength,),) * len(WAVELENGTHS)


class _Task(NamedTuple):
    """The grid of one light and one pair, and how often it counts: more often than once where it is drawn.

    hue: the channel that it is for, or 0 where one grid serves all.
    """

    light: int
    pair: Pair
    cells: int
    times: float = 1.0
    hue: int = 0


class GhostImage:
    """Ghosts of a picture: sums over the passes so far; none where there is a `reason`.

    Parameters: the camera, whose model is resolved; the scene; what ghosts are shown; pixels that are added on every
    side of the film. With pairs=(DIRECT,) the image is that of the lights themselves.
    """

    def __init__(self, camera: Camera, scene: Scene, flare: Flare, margin: tuple[int, int] = (0, 0)):
        self.reason = why_no_ghosts(camera, scene)
        if not self.reason and isinstance(camera, LensCamera):
            self.reason = no_such_pair(camera.lens, flare.pairs)
        self._camera, self._scene, self._flare = camera, scene, flare
        film, self._margin = camera.film, np.array(margin)
        self._across, self._down = film.pixels_x + 2 * margin[0], film.pixels_y + 2 * margin[1]
        self._sums = np.zeros((0 if self.reason else self._across * self._down, 3), np.float32)
        self._passes = self._seen = 0
        self.is_dark = True                                 # no light has reached the image yet
        self._boxes: dict[tuple[int, Pair, int], list[Box]] = {}
        self._tracer: GhostTracer | None = None
        self._hues: dict[int, tuple[GhostTracer, ...]] = {}         # tracers of the channels, by part of their spectrum
        self._lights = GhostLights([], 0, 0.0)
        self._bright: list[_Task] = []
        self._dim: list[_Task] = []
        self._chances = np.zeros(0)                         # of the dim ones, not normalised

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Why there are no ghosts, or which lights have none; after the first pass, what follows from lights."""
        if self.reason:
            return (note(Kind.NO_GHOSTS, self.reason),)
        if self._passes and self.is_dark:
            return (note(Kind.NO_GHOSTS, "no ghosts: those of all lights miss the film"),)
        lights = self._lights
        if not lights.left_out:
            return ()
        some = "1 dimmer light has" if lights.left_out == 1 else f"{lights.left_out} dimmer lights have"
        return (note(Kind.DIM_LIGHTS, f"only the {len(lights.lights)} brightest lights have ghosts: {some} none, with "
                     f"{significant(100.0 * lights.left_share, 2)} % of the light at the lens",
                     lights=lights.left_out, share=lights.left_share),)

    @property
    def passes(self) -> int:
        """Number of passes so far."""
        return self._passes

    def add_to(self, picture: np.ndarray, top: int = 0) -> None:
        """Add the mean of the passes so far to lines of a picture (lines, w, 3), the first of which is `top`."""
        if self.reason:
            return
        add_mean(picture, self._sums.reshape(self._down, self._across, 3)[top:top + len(picture)], self._passes)

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name, for `restore`."""
        return {"ghost_passes": np.array([self._passes, self._seen], np.int64), "ghost_sums": self._sums}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from such sums."""
        self._passes, self._seen = map(int, state["ghost_passes"])
        if self._sums is not state["ghost_sums"]:
            self._sums[:] = state["ghost_sums"]
        self.is_dark = not self._sums.any()

    def add(self, samples: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Add the ghosts of so many samples; False when `wanted` cancelled on the way."""
        if self.reason:
            return True
        if self._tracer is None:
            self._prepare()
            if self.reason:
                return True
        numbers = range(self._seen, self._seen + samples)
        self._seen += samples
        due = sum(n < FIRST or n % PERIOD == 0 for n in numbers)
        return self.go_on_to(self._passes + due, pool, threads, wanted)

    def go_on_to(self, passes: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Add passes until there are so many, at most MOST; False when `wanted` cancelled on the way."""
        while self._passes < min(passes, MOST):
            if not self._add_pass(self._passes, pool, threads, wanted):
                return False
            self._passes += 1
            self.is_dark = self.is_dark and not self._sums.any()
        return True

    @property
    def light_count(self) -> int:
        """Number of lights that have ghosts; known after the first pass."""
        return len(self._lights.lights)

    def _prepare(self) -> None:
        assert isinstance(self._camera, LensCamera)
        camera = replace(self._camera, model="trace")       # surfaces reflect, whatever model the picture is taken with
        lens, distance = camera.lens, camera.film_distance
        landing = camera.film_landing()
        assert landing is not None
        channels = self._flare.channels
        self._tracer = GhostTracer(lens, distance, landing.steps[-1:], D_LINE, channels, self._flare.coating)
        self._landing = landing.steps[-1:]
        self._lights = ghost_lights(camera, self._scene, self._tracer.front_z, entrance_reach(self._tracer))
        if not self._lights.lights:
            self.reason = "no ghosts: the scene has no sun and no small light that the lens sees"
        direct = [np.mean([pair_share(lens, DIRECT, line, self._flare.coating) for line in row]) for row in channels]
        self._gain = self._flare.strength / np.array(direct)
        pairs = (*ghost_pairs(lens), DIRECT)
        shown = [pair for pair in pairs if pair in (self._flare.pairs or pairs[:-1])]
        tasks, chances = _by_chance(self._lights, shown, self._tracer.pair_reflectances(shown))
        self._bright, self._dim, self._chances = tasks[:BEST], tasks[BEST:], chances[BEST:]

    def _tracers(self, number: int) -> tuple[GhostTracer, ...]:
        """Tracers of a pass: one for each channel, or one for all."""
        assert self._tracer is not None and isinstance(self._camera, LensCamera)
        if not self._camera.disperses:
            return (self._tracer,)
        eighth = PARTS[number % len(PARTS)]
        if eighth not in self._hues:
            self._hues[eighth] = tuple(
                GhostTracer(self._tracer.lens, self._camera.film_distance, self._landing, row[eighth],
                            self._flare.channels, self._flare.coating) for row in WAVELENGTHS.values())
        return self._hues[eighth]

    def _add_pass(self, number: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Trace a batch of grids, and add their cells in order: the sums are the same for any number of threads."""
        tracers = self._tracers(number)
        due = [*self._bright, *_drawn(self._dim, self._chances, number)]
        masks = np.ones((1, 3)) if len(tracers) == 1 else np.eye(3)
        if len(tracers) > 1:
            due = [task._replace(hue=hue, cells=SMALL_SIDE) for task in due for hue in range(len(tracers))]
        for begin in range(0, len(due), BATCH):
            tasks = due[begin:begin + BATCH]
            grids: list[list[np.ndarray]] = [[]] * len(tasks)
            turns = count()

            def trace(_: int, tasks: Any = tasks, grids: Any = grids, turns: Any = turns) -> bool:
                lanes = lane_buffer(tracers[0].real)
                while (k := next(turns)) < len(tasks):
                    if not wanted():
                        return False
                    grids[k] = self._grids(tracers[tasks[k].hue], lanes, tasks[k], number)
                return True

            bands = count(0, LINES)

            def gather(_: int, tasks: Any = tasks, grids: Any = grids, bands: Any = bands) -> bool:
                while (top := next(bands)) < self._down:
                    bottom = min(top + LINES, self._down)
                    edges = np.zeros((bottom - top, self._across + 1, 3))
                    for task, parts in zip(tasks, grids, strict=True):
                        light = self._lights.lights[task.light].irradiance
                        gain = (task.times * self._gain * light * masks[task.hue]).astype(np.float32)
                        for grid in parts:
                            if not wanted():
                                return False
                            add_cells(edges, grid, task.cells, self._across, top, bottom, gain)
                    add_lines(self._sums, edges, top * self._across)
                return True

            if not all(list(pool.map(trace, range(threads)))) or not all(list(pool.map(gather, range(threads)))):
                return False
        return True

    def _grids(self, tracer: GhostTracer, lanes: np.ndarray, task: _Task, number: int) -> list[np.ndarray]:
        """The rays of a task in a pass, a grid for each island of the front that its light enters through."""
        points = self._lights.lights[task.light].points
        key = task.light, task.pair, task.hue
        if key not in self._boxes:
            self._boxes[key] = pair_boxes(tracer, lanes, points[0], task.pair)
        # Additive recurrences of the plastic number, and a stride through the points of the light
        shift = tuple((number * step + 0.5) % 1.0 - 0.5 for step in (0.7548776662466927, 0.5698402909980532))
        point = points[1 + (number * 37) % (len(points) - 1)] if number else points[0]
        grids = [entrance_grid(tracer, lanes, point, task.pair, box, task.cells, (shift[0], shift[1]))
                 for box in self._boxes[key]]
        for grid in grids:
            grid[:2] += self._margin[:, None]
        return grids


def _by_chance(lights: GhostLights, pairs: Sequence[Pair], reflectances: np.ndarray) -> tuple[list[_Task], np.ndarray]:
    """A grid for every light and pair, the brightest first, of SIDE cells for BEST of them; and their chances.

    reflectances (pairs, 3): both reflections of a pair, for red, green and blue at normal incidence.
    """
    light = np.array([light.irradiance for light in lights.lights]).reshape(-1, 1, 3)
    chances = (light * (reflectances + EVEN * np.maximum(reflectances.mean(0), LEAST))).sum(2).ravel()
    order = np.argsort(-chances, kind="stable")
    return [_Task(index // len(pairs), pairs[index % len(pairs)], SIDE if rank < BEST else SMALL_SIDE)
            for rank, index in enumerate(order.tolist())], chances[order]


def _drawn(dim: list[_Task], chances: np.ndarray, number: int) -> list[_Task]:
    """The dim grids of a pass: all of them, or DRAWN at even places of their added chances, counted by the inverse."""
    if len(dim) <= DRAWN:
        return dim
    ends = np.cumsum(chances)
    step = ends[-1] / DRAWN
    places = (np.arange(DRAWN) + (0.5 + number * GOLDEN) % 1.0) * step
    which, hits = np.unique(np.minimum(np.searchsorted(ends, places), len(dim) - 1), return_counts=True)
    times = hits * step / chances[which]
    return [dim[index]._replace(times=count) for index, count in zip(which.tolist(), times.tolist(), strict=True)]


def why_no_ghosts(camera: Camera, scene: Scene) -> str:
    """Why a picture has no ghosts.

    Args:
        camera: Any camera.
        scene: What it looks at.
    Returns:
        A sentence; "" if the picture can have ghosts.
    """
    if not isinstance(camera, LensCamera):
        return "ghosts need a lens with surfaces: this camera has none"
    if isinstance(camera.world_from_camera, AnimatedTransform) or scene.moves:
        return "ghosts are not traced where the camera or the scene moves"
    if camera.has_port:
        return "ghosts are not traced through a flat port"
    return ""
