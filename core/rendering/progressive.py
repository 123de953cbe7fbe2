"""Pictures: a camera and a scene become one list of stages, run over the film band by band."""

import os
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor
from itertools import count

import numpy as np

from lensbench.analysis.model_choice import resolved
from lensbench.cameras.base import Camera
from lensbench.cameras.differentials import spread_step
from lensbench.cameras.pupil_footprint import footprint_steps
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import GREEN, RED, TIME, U0, U1, WEIGHT, B, N, Step, X, Y, Z, lane_buffer
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps
from lensbench.kernels.tile_order import raster_image
from lensbench.rendering.aovs import AVERAGED, aov_steps, arrival_steps
from lensbench.rendering.light_image import LightImage
from lensbench.scenery.scene import Scene

BAND = 16               # blocks that a thread takes at a time


def _always() -> bool:
    return True


class Rendering:
    """A picture that is being taken: the film's sums, to which samples are added.

    Every block is worked on by one thread, and its random numbers depend on the
    pixel alone: the film is the same bit for bit for any number of threads.
    steps: what places the samples, the scrambled net by default. shadows=False
    leaves shadows and occlusion out of the scene. view: one of `views.VIEWS`, to see
    in place of the light what the samples are. splat: whether small bright lights are traced from their own side
    (`splats`), where nothing moves; otherwise the camera's rays have to find
    them. filtered: whether patterns are averaged over the part of the pixel that a sample stands for, by the camera's
    ray differentials, so that the first sample is free of aliasing. A LensCamera of the model "auto" takes the
    model that the scene needs; a view shows its rays traced in full.

    With a camera that disperses, the first sample is of the d line, a picture without
    colour fringes that is there at once; every later one is three, of a wavelength for each
    channel, and from the second on these alone are the picture. A channel takes the same places
    of film and pupil as the others, so that its noise has no colour.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: int = 0, real=np.float32, steps=None, shadows: bool = True,
                 view: str = "", light_tracing: bool = True, filtered: bool = True):
        camera = camera if view else resolved(camera, scene)
        film = camera.film
        self.shape = (film.pixels_y, film.pixels_x)
        self.seed = np.uint32(seed & 0xFFFFFFFF)
        self.samples = 0
        self._timed = camera.moves or scene.moves
        timed = self._timed or view == "time"
        self._before = (sampling_steps(film.pixels_x, film.pixels_y, lit=shadows, timed=timed) if steps is None
                        else [*steps])
        part: list[Step] = []
        if filtered and not view:
            if scene.is_patterned or scene.is_rough:
                self._before.append(spread_step(camera, real))
            if scene.is_rough:
                size, part = footprint_steps(camera, real)
                self._before += size
        splats = LightImage(camera, scene, self.seed, real) if light_tracing and not view else None
        self._light_image = splats if splats is not None and not splats.is_empty else None
        taken = None if self._light_image is None else self._light_image.taken
        self._after = [*part, *scene.steps(shadows, camera.shutter_open, taken, camera.medium)]
        self._camera, self._real = camera, real
        self._disperses = camera.disperses and not view
        seen = aov_steps(camera, scene, view) if view else [*camera.steps(timed=self._timed), *self._after]
        self._program = Program([*self._before, *seen], real)
        # Of a view that is a mean over the samples that arrive: what counts them
        self._counting = Program([*self._before, *arrival_steps(camera, timed)], real) if view in AVERAGED else None
        self._colours: dict[int, list[Program]] = {}            # of each part of the spectrum, one for each channel
        self._sums = np.zeros((-(-film.pixels_x * film.pixels_y // B), 3 * B), real)
        self._arrived = np.zeros_like(self._sums) if self._counting else None

    @property
    def light_traced(self) -> frozenset[int]:
        """Numbers of the objects of the scene whose light, or part of it, is traced from its own side."""
        image = self._light_image
        return frozenset() if image is None else frozenset(light.number for light in image.lights)

    def _passes(self, samples: int) -> list[tuple[Program, int, int]]:
        """What these next samples are made of: programs, and which samples of theirs, from and how many."""
        if not self._disperses or self.samples + samples == 1:
            return [(self._program, self.samples, samples)]
        return [(program, sample, 1) for sample, place in self._numbers(samples) if place is not None
                for program in self._channels(place)]

    def _numbers(self, samples: int) -> list[tuple[int, int | None]]:
        """The next samples, each with the part of the spectrum that it takes, or None: the d line."""
        if not self._disperses or self.samples + samples == 1:
            return [(sample, None) for sample in range(self.samples, self.samples + samples)]
        return [(sample, spectral_part(sample, self.seed))
                for sample in range(max(self.samples - 1, 0), self.samples + samples - 1)]

    def _channels(self, place: int) -> list[Program]:
        if place not in self._colours:
            self._colours[place] = [
                Program([*self._before, *self._camera.steps(row[place], self._timed), *self._after, channel_step(name)],
                        self._real)
                for name, row in WAVELENGTHS.items()]
        return self._colours[place]

    def add(self, samples: int = 1, pool: Executor | None = None, wanted: Callable[[], bool] = _always,
            threads: int | None = None) -> bool:
        """Add samples to every pixel; False where `wanted` said no on the way, and the film is to be thrown away.

        pool: the threads to use, `threads` tasks at a time (all cores by default); None: threads of its own.
        """
        bands, stop = count(0, BAND), len(self._sums)
        passes = self._passes(samples)
        afresh = self._disperses and self.samples == 1       # the d line has had its day

        def work(_: int) -> bool:
            lanes = lane_buffer(self._program.real)
            while (first := next(bands)) < stop:
                if not wanted():
                    return False
                last = min(first + BAND, stop)
                if afresh:
                    self._sums[first:last] = 0.0
                for program, sample, number in passes:
                    program.expose(self._sums, lanes, first, last, sample, number, self.seed)
                    if self._counting and self._arrived is not None:
                        self._counting.expose(self._arrived, lanes, first, last, sample, number, self.seed)
            return True

        threads = threads or os.cpu_count() or 1
        if pool is None:
            with ThreadPoolExecutor(threads) as own:
                return self.add(samples, own, wanted, threads)
        done = self._light_image is None or self._light_image.add(self._numbers(samples), afresh, pool, threads, wanted)
        done = done and all(list(pool.map(work, range(threads))))
        self.samples += samples
        return done

    def image(self) -> np.ndarray:
        """The mean of the samples so far: float32 (h, w, 3), linear, a fresh array."""
        h, w = self.shape
        if self._arrived is not None:
            return raster_image(self._sums, w, h) / np.maximum(raster_image(self._arrived, w, h), np.float32(1))
        counted = self.samples - 1 if self._disperses and self.samples > 1 else self.samples
        mean = raster_image(self._sums, w, h, 1.0 / max(counted, 1))
        if self._light_image is not None:
            mean += self._light_image.image()
        return mean.astype(np.float32, copy=False)


def render(camera: Camera, scene: Scene, samples: int = 64, seed: int = 0, threads: int | None = None) -> np.ndarray:
    """Take a picture: float32 (h, w, 3), linear. ValueError for fewer than one sample.

    The same for any number of threads.
    """
    if samples < 1:
        raise ValueError(f"{samples} samples a pixel: at least 1 is needed")
    rendering = Rendering(camera, scene, seed)
    rendering.add(samples, threads=threads)
    return rendering.image()


def depth_map(camera: Camera, scene: Scene, time: float = 0.5) -> np.ndarray:
    """How far before the camera's origin, along −z, each pixel's centre looks: float32 (h, w) mm.

    Along the ray through the middle of the pupil, at `time` in [0, 1) of the shutter where
    something moves; inf where there is only sky, NaN where the camera is dark.
    """
    camera, film = resolved(camera, scene), camera.film
    h, w = film.pixels_y, film.pixels_x
    y, x = np.mgrid[0:h, 0:w] + 0.5
    n = w * h
    middle = camera.pupil_centre
    given = {X: x.ravel(), Y: y.ravel(), U0: np.full(n, middle[0]), U1: np.full(n, middle[1]), TIME: np.full(n, time)}
    steps = [*camera.steps(timed=scene.moves), *scene.depth_steps(camera.shutter_open)]
    along, hit, weight = Program(steps).run(given, [RED, GREEN, WEIGHT], n)
    z, slope, clock = Program([camera.clock, camera.film_step, *camera.aimed()]).run(given, [Z, N, TIME], n)
    place = camera.world_from_camera
    scale = place.scale_at(camera.shutter_open + clock) if isinstance(place, AnimatedTransform) else 1.0
    with np.errstate(invalid="ignore", over="ignore"):
        depth = -(z * scale + slope * along)
    depth = np.where(hit > 0.0, depth, np.inf)
    return np.where(weight > 0.0, depth, np.nan).reshape(h, w).astype(np.float32)
