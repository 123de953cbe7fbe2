"""Programs of the samples of a picture: a camera and a scene become one list of stages, or one for each wavelength."""

from collections.abc import Callable

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.differentials import spread_step
from lensbench.cameras.pupil_footprint import footprint_steps
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import Step
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps
from lensbench.rendering.aovs import AVERAGED, aov_steps, arrival_steps
from lensbench.scenery.scene import Scene
from lensbench.scenery.small_lights import ExcludedLight


class SamplePrograms:
    """The programs that the samples of a picture run, and the numbers of these samples.

    With a camera that disperses, the first sample is of the d line, and every later one is three, one wavelength for
    each channel. The later ones are numbered from 0 again, since they replace the first.

    Parameters
    ----------
    camera, scene, seed, real, steps, shadows, view, filtered
        As for `Rendering`; the model of the camera is resolved.

    Attributes
    ----------
    before : list of Step
        Stages that place the samples, and give each the size of its part of the pixel.
    disperses : bool
        Whether samples after the first are traced at many wavelengths.
    counting : Program or None
        Counts the samples that arrive, for the AOVs that are means over these; None for other pictures.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real, steps: list[Step] | None, shadows: bool,
                 view: str, filtered: bool):
        film = camera.film
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._shadows, self._view = shadows, view
        self._timed = camera.moves or scene.moves
        timed = self._timed or view == "time"
        self.before = (sampling_steps(film.pixels_x, film.pixels_y, lit=shadows, timed=timed) if steps is None
                       else [*steps])
        self._pupil_part: list[Step] = []
        if filtered and not view:
            if scene.is_patterned or scene.is_rough:
                self.before.append(spread_step(camera, real))
            if scene.is_rough:
                size, self._pupil_part = footprint_steps(camera, real)
                self.before += size
        self.disperses = camera.disperses and not view
        self.counting = Program([*self.before, *arrival_steps(camera, timed)], real) if view in AVERAGED else None

    def compose(self, excluded: ExcludedLight | None) -> None:
        """Put the stages together. excluded: light that the camera's rays leave out."""
        self._after = self._after_camera(excluded)
        self._program = self.plain(excluded)
        self._channel_programs: dict[int, list[Program]] = {}   # of each part of the spectrum, one for each channel

    def plain(self, excluded: ExcludedLight | None) -> Program:
        """The program of the samples of the d line, where the camera's rays leave out this light."""
        camera = self._camera
        steps = aov_steps(camera, self._scene, self._view) if self._view else [
            *camera.steps(timed=self._timed), *self._after_camera(excluded)]
        return Program([*self.before, *steps], self._real)

    def _after_camera(self, excluded: ExcludedLight | None) -> list[Step]:
        """The stages that follow a ray into the scene."""
        return [*self._pupil_part,
                *self._scene.steps(self._shadows, self._camera.shutter_open, excluded, self._camera.medium)]

    def passes(self, samples: np.ndarray, counts: np.ndarray, is_first: bool, wanted: Callable[[], bool]
               ) -> list[tuple[Program, np.ndarray, np.ndarray]] | None:
        """The samples of some blocks as passes: program, number of the first sample of each block, number of samples.

        samples, counts: (blocks,) int64, number of the first sample of each block and of its samples. is_first: whether
        they are the first sample alone, of the d line. None when `wanted` returned False: the cameras of a new part of
        the spectrum take time.
        """
        if not self.disperses or is_first:
            return [(self._program, samples, counts)]
        passes = []
        ranges = np.unique(np.stack([samples, samples + counts]), axis=1).T
        for sample in np.unique(np.concatenate([np.arange(*each) for each in ranges])):
            if not wanted():
                return None
            now = ((samples <= sample) & (sample < samples + counts)).astype(np.int64)
            passes += [(program, np.full_like(samples, sample), now)
                       for program in self._channels(spectral_part(sample, self._seed))]
        return passes

    def numbers(self, done: int, samples: int) -> list[tuple[int, int | None]]:
        """Numbers of the samples that follow `done` samples, each with its part of the spectrum; None: the d line."""
        if not self.disperses or done + samples == 1:
            return [(sample, None) for sample in range(done, done + samples)]
        return [(sample, spectral_part(sample, self._seed)) for sample in range(max(done - 1, 0), done + samples - 1)]

    def numbers_so_far(self, done: int) -> list[tuple[int, int | None]]:
        """`numbers` of the samples that count among the first `done` samples; at least one."""
        if not self.disperses or done <= 1:
            return [(sample, None) for sample in range(max(done, 1))]
        return [(sample, spectral_part(sample, self._seed)) for sample in range(done - 1)]

    def counted(self, done: int) -> int:
        """Number of samples that the picture is the mean of: that of the d line is dropped once others follow."""
        return done - 1 if self.disperses and done > 1 else done

    def kept(self, done: int) -> int:
        """Number of samples among the first `done` that count when others follow."""
        return max(done - 1, 0) if self.disperses else done

    def _channels(self, place: int) -> list[Program]:
        """The programs of a part of the spectrum, one for each channel."""
        if place not in self._channel_programs:
            self._channel_programs[place] = [
                Program([*self.before, *self._camera.steps(row[place], self._timed), *self._after, channel_step(name)],
                        self._real)
                for name, row in WAVELENGTHS.items()]
        return self._channel_programs[place]
