"""Progressive pictures: a camera and a scene become one list of stages, run over the film band by band."""

import os
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from itertools import count

import numpy as np

from lensbench.analysis.model_choice import resolved
from lensbench.cameras.base import Camera
from lensbench.cameras.differentials import spread_step
from lensbench.cameras.pupil_footprint import footprint_steps
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import B, Step, lane_buffer
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps
from lensbench.kernels.tile_order import raster_image
from lensbench.optics.finding import Finding
from lensbench.rendering.aovs import AVERAGED, aov_steps, arrival_steps
from lensbench.rendering.flare_image import FlareImage
from lensbench.rendering.ghost_image import Flare
from lensbench.rendering.light_image import LightImage
from lensbench.rendering.light_layer import LightLayer
from lensbench.scenery.scene import Scene
from lensbench.scenery.small_lights import ExcludedLight

BAND = 16               # blocks that a thread takes at a time


def _always() -> bool:
    return True


class Rendering:
    """A progressive picture: sums over the film, to which samples are added.

    One thread works on each block, and the random numbers of a block depend on its pixels alone: the film is the
    same, bit for bit, for any number of threads.

    With a camera that disperses, the first sample is of the d line, a picture without
    colour fringes that is ready at once. Every later sample is three, one wavelength for each
    channel, and from the second sample on these alone are the picture. The channels share their points
    on film and pupil, so that the noise has no colour.

    Parameters
    ----------
    camera
        Any camera. A LensCamera of the model "auto" takes the model that the scene needs (`choose_model`); for an AOV
        its rays are traced in full.
    scene
        The scene, world frame, mm.
    seed
        Sampler seed; its lower 32 bits count.
    real
        np.float32 or np.float64: the numbers of the stages.
    steps
        Stages that place the samples (raster X, Y, pupil U0, U1, TIME); None: the scrambled Sobol net.
    shadows
        Whether light is hidden by objects; False leaves out shadows and ambient occlusion.
    view
        "" for the picture, or one of `lb.VIEWS` to show an AOV of its samples.
    light_tracing
        Whether small bright lights are traced from the light to the film, where nothing moves; False leaves them to
        the camera's rays.
    layer
        The light layer of another picture of this scene, to be shown until `adopt` gives this picture its own light
        image; None: select and trace the small lights with the first sample.
    filtered
        Whether patterns are averaged over the part of a pixel that a sample represents, by ray differentials,
        so that the first sample is free of aliasing.
    light_passes
        Number of samples that trace lights at the most, for small pictures of few samples; None: as many as repay
        their time.
    flare
        Ghosts and stars of the sun and of small lights, added to the picture of a lens; None: none. `why_no_ghosts`
        says where there are none for other reasons.

    Attributes
    ----------
    shape
        (h, w) pixels.
    samples
        Samples per pixel so far.

    Raises
    ------
    ValueError
        For an unknown view.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: int = 0, real=np.float32, steps=None, shadows: bool = True,
                 view: str = "", light_tracing: bool = True, filtered: bool = True, light_passes: int | None = None,
                 layer: LightLayer | None = None, flare: Flare | None = None):
        camera.check_overrides()
        camera = camera if view else resolved(camera, scene)
        film = camera.film
        self.shape = (film.pixels_y, film.pixels_x)
        self.seed = np.uint32(seed & 0xFFFFFFFF)
        self.samples = 0
        self._camera, self._real = camera, real
        self._timed = camera.moves or scene.moves
        timed = self._timed or view == "time"
        self._before = (sampling_steps(film.pixels_x, film.pixels_y, lit=shadows, timed=timed) if steps is None
                        else [*steps])
        pupil_part: list[Step] = []
        if filtered and not view:
            if scene.is_patterned or scene.is_rough:
                self._before.append(spread_step(camera, real))
            if scene.is_rough:
                size, pupil_part = footprint_steps(camera, real)
                self._before += size
        self._disperses = camera.disperses and not view
        self._light_image: LightImage | None = None
        self._borrowed = layer if light_tracing and not view and layer is not None and layer.suits(camera) else None
        self._borrowed_image: np.ndarray | None = None      # with the first sample
        if light_tracing and not view and self._borrowed is None:
            self._light_image = LightImage(camera, scene, self.seed, real, light_passes)
        self._light_passes = light_passes
        self._flare = None if flare is None or view else FlareImage(camera, scene, flare)
        self._scene, self._view, self._shadows, self._pupil_part = scene, view, shadows, pupil_part
        self._compose()
        # Counts the samples that arrive, for the AOVs that are means over these
        self._counting = Program([*self._before, *arrival_steps(camera, timed)], real) if view in AVERAGED else None
        self._sums = np.zeros((-(-film.pixels_x * film.pixels_y // B), 3 * B), real)
        self._arrived = np.zeros_like(self._sums) if self._counting else None

    @property
    def camera(self) -> Camera:
        """The camera, its model resolved."""
        return self._camera

    @property
    def excluded(self) -> ExcludedLight | None:
        """Light that the camera's rays leave out, because it is traced from the light; None: nothing."""
        if self._borrowed is not None:
            return self._borrowed.excluded
        return None if self._light_image is None else self._light_image.left_out

    def leaves_out(self, excluded: ExcludedLight | None) -> bool:
        """Whether the camera's rays leave out just this light.

        Parameters
        ----------
        excluded : ExcludedLight or None
            Light that is traced from the lights.

        Returns
        -------
        bool
        """
        own = self.excluded
        return own is excluded if own is None or excluded is None else own.is_same(excluded)

    def _compose(self) -> None:
        """Put the stages together."""
        camera = self._camera
        self._after = [*self._pupil_part,
                       *self._scene.steps(self._shadows, camera.shutter_open, self.excluded, camera.medium)]
        steps = aov_steps(camera, self._scene, self._view) if self._view else [*camera.steps(timed=self._timed),
                                                                               *self._after]
        self._program = Program([*self._before, *steps], self._real)
        self._channel_programs: dict[int, list[Program]] = {}   # of each part of the spectrum, one for each channel

    # Light of another picture

    @property
    def is_borrowing(self) -> bool:
        """Whether the picture shows the light layer of another one, and `own_light` is still to be made."""
        return self._borrowed is not None

    def layer(self) -> LightLayer | None:
        """Light of the small lights for the first samples of another picture.

        Returns
        -------
        LightLayer or None
            None without light tracing.
        """
        if self._borrowed is not None:
            return self._borrowed
        return None if self._light_image is None else self._light_image.layer()

    def own_light(self, pool: Executor, threads: int, wanted: Callable[[], bool] = _always) -> LightImage | None:
        """The picture's own light image, with the passes of the samples so far; from any thread.

        Parameters
        ----------
        pool : Executor
            Runs the passes.
        threads : int
            Parts of a pass that run at the same time.
        wanted : function
            Called without arguments from any thread; False cancels.

        Returns
        -------
        LightImage or None
            None if it was cancelled.
        """
        light_image = LightImage(self._camera, self._scene, self.seed, self._real, self._light_passes)
        if not light_image.is_empty:
            for number in self._numbers_so_far():
                if not light_image.add([number], False, pool, threads, wanted):
                    return None
        return light_image

    def adopt(self, light_image: LightImage) -> None:
        """Take the picture's own light image in place of the borrowed layer.

        Where the camera's rays have left out other light, the samples so far are dropped: `samples` is 0 again.

        Parameters
        ----------
        light_image : LightImage
            From `own_light`.
        """
        former = self.excluded
        self._light_image, self._borrowed, self._borrowed_image = light_image, None, None
        if not self.leaves_out(former):
            self._compose()
            self._sums[:] = 0.0
            self.samples = 0

    def _numbers_so_far(self) -> list[tuple[int, int | None]]:
        """The numbers of the samples so far, as of `_numbers`."""
        if not self._disperses or self.samples <= 1:
            return [(sample, None) for sample in range(max(self.samples, 1))]
        return [(sample, spectral_part(sample, self.seed)) for sample in range(self.samples - 1)]

    @property
    def _traced(self) -> LightImage | None:
        """The picture's own light image; None where nothing is traced from lights."""
        image = self._light_image
        return None if image is None or image.is_empty else image

    @property
    def light_traced(self) -> frozenset[int]:
        """Numbers of the objects in `scene.objects` whose light, or a part of it, is traced to the film."""
        return frozenset(() if self._light_image is None else (light.number for light in self._light_image.lights))

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name: `restore` of another rendering of the same arguments goes on with them.

        A borrowed layer of light is not among them.
        """
        found = {"samples": np.array(self.samples, np.int64), "sums": self._sums}
        if self._arrived is not None:
            found["arrived"] = self._arrived
        return found | {name: value for part in (self._traced, self._flare) if part is not None
                        for name, value in part.state.items()}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the picture leaves out: why it has no ghosts, or which lights have none, known with the first sample."""
        return () if self._flare is None else self._flare.findings

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from the sums of a rendering of the same arguments.

        Parameters
        ----------
        state
            As `state` gave them.

        Raises
        ------
        ValueError
            For sums of another picture; the rendering is then unchanged.
        """
        own = self.state
        if own.keys() != state.keys() or any(
                (value.shape, value.dtype) != (state[name].shape, state[name].dtype) for name, value in own.items()):
            raise ValueError("these are sums of another picture")
        self.samples = int(state["samples"])
        self._sums[:] = state["sums"]
        if self._arrived is not None:
            self._arrived[:] = state["arrived"]
        for part in (self._traced, self._flare):
            if part is not None:
                part.restore(state)

    def _passes(self, samples: int) -> list[tuple[Program, int, int]]:
        """The next samples as passes: program, first sample, number of samples."""
        numbers = self._numbers(samples)
        if not numbers or numbers[0][1] is None:
            return [(self._program, self.samples, samples)]
        return [(program, sample, 1) for sample, place in numbers if place is not None
                for program in self._channels(place)]

    def _numbers(self, samples: int) -> list[tuple[int, int | None]]:
        """The numbers of the next samples, each with its part of the spectrum, or None: the d line."""
        if not self._disperses or self.samples + samples == 1:
            return [(sample, None) for sample in range(self.samples, self.samples + samples)]
        return [(sample, spectral_part(sample, self.seed))
                for sample in range(max(self.samples - 1, 0), self.samples + samples - 1)]

    def _channels(self, place: int) -> list[Program]:
        """The programs of a part of the spectrum, one for each channel."""
        if place not in self._channel_programs:
            self._channel_programs[place] = [
                Program([*self._before, *self._camera.steps(row[place], self._timed), *self._after, channel_step(name)],
                        self._real)
                for name, row in WAVELENGTHS.items()]
        return self._channel_programs[place]

    def add(self, samples: int = 1, pool: Executor | None = None, wanted: Callable[[], bool] = _always,
            threads: int | None = None) -> bool:
        """Add samples to every pixel.

        Parameters
        ----------
        samples
            Number of samples per pixel to add.
        pool
            Threads to use; None: threads of its own.
        wanted
            Called between bands from any thread; return False to cancel.
        threads
            Tasks at a time; None: one for each core.

        Returns
        -------
        bool
            False when `wanted` cancelled; the rendering is then incomplete, to be thrown away.
        """
        threads = threads or os.cpu_count() or 1
        if pool is None:
            with ThreadPoolExecutor(threads) as own:
                return self.add(samples, own, wanted, threads)
        bands, stop = count(0, BAND), len(self._sums)
        passes = self._passes(samples)
        afresh = self._disperses and self.samples == 1       # forget the sample of the d line

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

        if self._borrowed is not None and self._borrowed_image is None:
            self._borrowed_image = self._borrowed.seen_by(self._camera, pool, threads, wanted)
        traced = self._traced
        done = traced is None or traced.add(self._numbers(samples), afresh, pool, threads, wanted)
        done = done and (self._flare is None or self._flare.add(samples, pool, threads, wanted))
        done = done and all(list(pool.map(work, range(threads))))
        self.samples += samples
        return done

    def image(self) -> np.ndarray:
        """The mean of the samples so far.

        Returns
        -------
        ndarray
            float32 (h, w, 3), linear RGB, the top row first; a fresh array.
        """
        mean = self.camera_image()
        if self._borrowed_image is not None:
            mean += self._borrowed_image
        elif (own := self._traced) is not None:
            own.add_to(mean)
        if self._flare is not None:
            self._flare.add_to(mean)
        return mean.astype(np.float32, copy=False)

    def camera_image(self) -> np.ndarray:
        """The part of `image` that the camera's rays see.

        Returns
        -------
        (h, w, 3) array
            A fresh array of the stages' numbers.
        """
        h, w = self.shape
        if self._arrived is not None:
            return raster_image(self._sums, w, h) / np.maximum(raster_image(self._arrived, w, h), np.float32(1))
        counted = self.samples - 1 if self._disperses and self.samples > 1 else self.samples
        return raster_image(self._sums, w, h, 1.0 / max(counted, 1))

    def light(self) -> np.ndarray | None:
        """The part of `image` that is traced from small lights, its own or borrowed, with ghosts and stars.

        Returns
        -------
        (h, w, 3) array or None
            float32; None without any.
        """
        own = self._traced
        traced = self._borrowed_image if self._borrowed is not None else None if own is None else own.image()
        if self._flare is None or self._flare.is_empty:
            return traced
        traced = np.zeros((*self.shape, 3), np.float32) if traced is None else traced.copy()
        self._flare.add_to(traced)
        return traced
