"""Progressive pictures: samples on the film, light traced to it, and ghosts and stars, added pass by pass."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from typing import Any

import numpy as np

from lensbench.core.analysis.model_choice import resolved
from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_cameras import AIRY
from lensbench.core.kernels.block import Step
from lensbench.core.kernels.sampling import BAND_LINES
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import D_LINE
from lensbench.core.rendering.ghost_image import Flare
from lensbench.core.rendering.light_image import LightImage
from lensbench.core.rendering.light_layer import LightLayer
from lensbench.core.rendering.sample_programs import FilmSums, SamplePrograms
from lensbench.core.rendering.star_image import FlareImage
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.small_lights import ExcludedLight
from lensbench.core.text import significant


def _always() -> bool:
    return True


class Rendering:
    """A progressive picture: sums over the film, to which samples are added.

    One thread works on each block, and the random numbers of a block depend on its pixels alone: the film is the
    same, bit for bit, for any number of threads.

    With a camera that disperses, the first sample is of the d line, a picture without colour fringes that is ready at
    once. Every later sample is three, one wavelength for each channel, and from the second sample on these alone are
    the picture. The channels share their points on film and pupil, so that the noise has no colour.

    Args:
        camera: Any camera. A LensCamera of the model "auto" takes the model that the scene needs (`choose_model`); for
            an AOV its rays are traced in full.
        scene: The scene, world frame, mm.
        seed: Sampler seed; its lower 32 bits count.
        real: np.float32 or np.float64: the numbers of the stages.
        steps: Stages that place the samples (raster X, Y, pupil U0, U1, TIME); None: the scrambled Sobol net.
        shadows: Whether light is hidden by objects; False leaves out shadows and ambient occlusion.
        view: "" for the picture, or one of `lb.VIEWS` to show an AOV of its samples.
        light_tracing: Whether small bright lights are traced from the light to the film, where nothing moves; False
            leaves them to the camera's rays.
        layer: The light layer of another picture of this scene, to be shown until `adopt` gives this picture its own
            light image; None: select and trace the small lights with the first sample.
        filtered: Whether patterns are averaged over the part of a pixel that a sample represents, by ray differentials,
            so that the first sample is free of aliasing.
        light_passes: Number of samples that trace lights at the most, for small pictures of few samples; None: as many
            as repay their time.
        flare: Ghosts and stars of the sun and of small lights, added to the picture of a lens; None: none.
            `why_no_ghosts` says where there are none for other reasons.
        adaptive: Whether parts of the film with a larger error take more of the samples after the first 16
            (`sample_allocation`); an AOV, and `steps`, take the same everywhere.
        in_bands: Whether the rendering holds one band of lines at a time, so that a large picture takes little memory:
            give the first band all of its samples, take its `image`, then `next_band`.
    Attributes:
        shape: (h, w) pixels.
        samples: Samples per pixel so far, on average; in bands, per pixel of the current one.
    Raises:
        ValueError: For an unknown view.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: int = 0, real: Any = np.float32,
                 steps: Sequence[Step] | None = None, shadows: bool = True, view: str = "", light_tracing: bool = True,
                 filtered: bool = True, light_passes: int | None = None,
                 layer: LightLayer | None = None, flare: Flare | None = None, adaptive: bool = True,
                 in_bands: bool = False):
        camera.check_overrides()
        camera = camera if view else resolved(camera, scene)
        film = camera.film
        self.shape = (film.pixels_y, film.pixels_x)
        self.seed = np.uint32(seed & 0xFFFFFFFF)
        self.samples = 0
        self._camera, self._scene, self._real = camera, scene, real
        self._programs = SamplePrograms(camera, scene, self.seed, real, steps, shadows, view, filtered)
        self._light_image: LightImage | None = None
        self._borrowed = layer if light_tracing and not view and layer is not None and layer.suits(camera) else None
        self._borrowed_image: np.ndarray | None = None      # with the first sample
        if light_tracing and not view and self._borrowed is None:
            self._light_image = LightImage(camera, scene, self.seed, real, self._programs, light_passes)
        self._light_passes = light_passes
        self._flare = None if flare is None or view else FlareImage(camera, scene, flare)
        self._no_diffraction = () if view else missing_diffraction(camera)
        self._programs.compose(self.excluded)
        self._sums = FilmSums(self.shape, self._programs, self.seed, real,
                              not adaptive or bool(view) or steps is not None, in_bands)

    @property
    def camera(self) -> Camera:
        """The camera, its model resolved."""
        return self._camera

    @property
    def lines(self) -> range:
        """The lines of the film in memory: all, or those of the current band."""
        return self._sums.lines

    @property
    def excluded(self) -> ExcludedLight | None:
        """Light that the camera's rays leave out, because it is traced from the light; None: nothing."""
        if self._borrowed is not None:
            return self._borrowed.excluded
        return None if self._light_image is None else self._light_image.left_out

    def leaves_out(self, excluded: ExcludedLight | None) -> bool:
        """Whether the camera's rays leave out just this light.

        Args:
            excluded: Light that is traced from the lights.
        """
        own = self.excluded
        return own is excluded if own is None or excluded is None else own.is_same(excluded)

    # Light of another picture

    @property
    def is_borrowing(self) -> bool:
        """Whether the picture shows the light layer of another one, and `own_light` is still to be made."""
        return self._borrowed is not None

    def layer(self) -> LightLayer | None:
        """Light of the small lights for the first samples of another picture.

        Returns:
            None without light tracing.
        """
        if self._borrowed is not None:
            return self._borrowed
        return None if self._light_image is None else self._light_image.layer()

    def own_light(self, pool: Executor, threads: int, wanted: Callable[[], bool] = _always) -> LightImage | None:
        """The picture's own light image, with the passes of the samples so far; from any thread.

        Args:
            pool: Runs the passes.
            threads: Parts of a pass that run at the same time.
            wanted: Called without arguments from any thread; False cancels.
        Returns:
            None if it was cancelled.
        """
        light_image = LightImage(self._camera, self._scene, self.seed, self._real, self._programs,
                                 self._light_passes)
        if not light_image.is_empty:
            for number in self._programs.numbers_so_far(self.samples):
                if not light_image.add([number], False, pool, threads, wanted):
                    return None
        return light_image

    def adopt(self, light_image: LightImage) -> None:
        """Take the picture's own light image instead of the borrowed layer.

        Where the camera's rays have left out other light, the samples so far are dropped: `samples` is 0 again.

        Args:
            light_image: From `own_light`.
        """
        former = self.excluded
        self._light_image, self._borrowed, self._borrowed_image = light_image, None, None
        if not self.leaves_out(former):
            self._programs.compose(self.excluded)
            self._sums.clear()
            self.samples = 0

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
        arrays = {"samples": np.array(self.samples, np.int64)}
        return arrays | {name: value for layer in (self._sums, self._traced, self._flare) if layer is not None
                        for name, value in layer.state.items()}

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What the scene's reader changed, and what the picture leaves out.

        Diffraction, where it would blur by more than a pixel; why it has no ghosts, or which lights have none, known
        with the first sample.
        """
        return (*(note(Kind.SCENE, text) for text in self._scene.notes), *self._no_diffraction,
                *(() if self._flare is None else self._flare.findings))

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from the sums of a rendering of the same arguments.

        Args:
            state: As `state` gave them; arrays of this rendering's own `state` may have been filled in place.
        Raises:
            ValueError: For sums of another picture; the rendering is then unchanged.
        """
        own = self.state
        if own.keys() != state.keys() or any(
                (value.shape, value.dtype) != (state[name].shape, state[name].dtype) for name, value in own.items()):
            raise ValueError("these are sums of another picture")
        self.samples = int(state["samples"])
        for layer in (self._sums, self._traced, self._flare):
            if layer is not None:
                layer.restore(state)

    def add(self, samples: int = 1, pool: Executor | None = None, wanted: Callable[[], bool] = _always,
            threads: int | None = None) -> bool:
        """Add samples to every pixel.

        Args:
            samples: Number of samples per pixel to add, at least 1.
            pool: Threads to use; None: threads of its own.
            wanted: Called many times from any thread; return False to cancel.
            threads: Tasks at a time; None: one for each core.
        Returns:
            False when `wanted` cancelled; the rendering is then incomplete, to be thrown away.
        Raises:
            ValueError: For fewer samples than 1.
        """
        if samples < 1:
            raise ValueError(f"{samples} samples a pixel: at least 1 is needed")
        threads = threads or os.cpu_count() or 1
        if pool is None:
            with ThreadPoolExecutor(threads) as own:
                return self.add(samples, own, wanted, threads)
        if self._borrowed is not None and self._borrowed_image is None:
            self._borrowed_image = self._borrowed.seen_by(self._camera, pool, threads, wanted)
        programs, end = self._programs, self.samples + samples
        if self.lines.start == 0:               # a later band has the light of the first one's samples
            traced = self._traced
            if traced is not None and not traced.add(programs.numbers(self.samples, samples), self._is_fresh, pool,
                                                     threads, wanted):
                return False
            if self._flare is not None and not self._flare.add(samples, pool, threads, wanted):
                return False
        if self._is_fresh:
            self._sums.drop_first()
        if not self._sums.add(programs.kept(self.samples), programs.counted(end), end == 1, pool, threads, wanted):
            return False
        self.samples = end
        return True

    @property
    def _is_fresh(self) -> bool:
        """Whether the next samples replace that of the d line."""
        return self._programs.disperses and self.samples == 1

    def next_band(self) -> bool:
        """Go on to the next band of lines, of 0 samples: it needs as many as the first one has had.

        Returns:
            False when there is none: the current band stays.
        """
        is_next = self._sums.next_band()
        if is_next:
            self.samples = 0
        return is_next

    def image(self) -> np.ndarray:
        """The mean of the samples so far.

        Returns:
            float32 (h, w, 3), linear RGB, the top row first; a fresh array. In bands: the current `lines`.
        """
        return self._image(self.lines)

    def bands(self) -> Iterator[np.ndarray]:
        """The lines of `image` in bands, for pictures that are too large to be held once more.

        Yields:
            float32 (lines, w, 3), from the top down; a fresh array.
        """
        for top in self.lines[::BAND_LINES]:
            yield self._image(range(top, min(top + BAND_LINES, self.lines.stop)))

    def _image(self, lines: range) -> np.ndarray:
        mean = self._camera_image(lines)
        if self._borrowed_image is not None:
            mean += self._borrowed_image[lines.start:lines.stop]
        elif (own := self._traced) is not None:
            own.add_to(mean, lines.start)
        if self._flare is not None:
            self._flare.add_to(mean, lines.start)
        return mean.astype(np.float32, copy=False)

    def camera_image(self) -> np.ndarray:
        """The part of `image` that the camera's rays see.

        Returns:
            (h, w, 3) array. A fresh array of the stages' numbers.
        """
        return self._camera_image(self.lines)

    def _camera_image(self, lines: range) -> np.ndarray:
        """The part of whole bands of lines."""
        return self._sums.mean(lines, self._programs.counted(self.samples))

    def light(self) -> np.ndarray | None:
        """The part of `image` that is traced from small lights, its own or borrowed, with ghosts and stars.

        Returns:
            (h, w, 3) array or None. float32; None without any.
        """
        own = self._traced
        traced = self._borrowed_image if self._borrowed is not None else None if own is None else own.image()
        if self._flare is None or self._flare.is_empty:
            return traced
        traced = np.zeros((*self.shape, 3), np.float32) if traced is None else traced.copy()
        self._flare.add_to(traced)
        return traced


def missing_diffraction(camera: Camera) -> tuple[Finding, ...]:
    """The finding that a picture by rays lacks diffraction, where the Airy disk of the camera exceeds a pixel.

    Its diameter to the first dark ring is 2.44 λ N (Airy 1835), N the working f-number at the film, λ the d line.
    """
    try:
        lens = camera.gaussian
    except ValueError:                          # a panorama or a fisheye has no one aperture
        return ()
    slope = abs(lens.approach_pupil) * lens.iris.equivalent_radius
    if lens.is_hole or not slope > 0.0:         # a point lets all light pass, by assumption
        return ()
    across, _, down, _ = camera.film_step.parameters
    number, pixel = 0.5 / slope, min(abs(across), abs(down))
    disk = AIRY * 1e-3 * D_LINE * number
    if not disk > pixel:
        return ()
    return (note(Kind.NO_DIFFRACTION, f"the picture has no diffraction: at a working f-number of "
                 f"{significant(number, 2)} the Airy disk is {significant(1e3 * disk, 2)} µm across, "
                 f"{significant(disk / pixel, 2)} pixels. The MTF panel and `lensbench analyse` include it",
                 f_number=number, disk=disk, pixels=disk / pixel),)
