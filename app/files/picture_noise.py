"""Noise of a picture while it is rendered, estimated from its samples alone.

The samples before and after an earlier estimate are two pictures of the same scene, whose difference gives the
noise of their mean. The earlier picture is part of the state, so that a render that goes on estimates as one without
a stop.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.files.export import develop, parts
from lensbench.app.state.picture.exposure import exposed
from lensbench.app.state.settings import Settings

FIRST_LOOK = 8                  # samples at the first estimate of the noise
LOOKED = 1 << 20                # pixels by which the noise is estimated
LEAST_STEP, MOST_STEP = 1.1, 2.0        # growth of the samples between two estimates
NOISE_STATE = ("noise", "noise_samples", "noise_image")      # names of `Noise.state`


class Noise:
    """Noise of a picture while it is rendered: the root mean square error of its sRGB values, black 0 and white 1.

    The samples before and after an earlier estimate are two pictures of the same scene, whose difference gives the
    noise of their mean. Samples of a net are spread more evenly all together than in parts, so the estimate tends to be
    too high. Of a picture of more than LOOKED pixels, lines at even distances are looked at.

    Parameters
    ----------
    settings
        For exposure and tone curve; the noise of a sensor is left out.
    goal
        Noise that is enough.
    """

    def __init__(self, settings: Settings, goal: float):
        self._settings, self._goal = replace(settings, noise=False), goal
        self._earlier: tuple[int, np.ndarray] | None = None
        self.noise: float | None = None

    @property
    def is_enough(self) -> bool:
        """Whether the picture of the last estimate is as good as wanted."""
        return self.noise is not None and self.noise <= self._goal

    @property
    def next_look(self) -> int:
        """Samples at which the noise is to be estimated next."""
        if self._earlier is None:
            return FIRST_LOOK
        samples = self._earlier[0]
        if self.noise is not None:
            grown = min(max((self.noise / self._goal) ** 2, LEAST_STEP), MOST_STEP)
        else:                               # of many samples whose noise was not estimated, few more tell it
            grown = MOST_STEP if samples <= FIRST_LOOK else LEAST_STEP
        return int(np.ceil(grown * samples))

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The last estimate, by name; `restore` goes on with it. Empty before the first look."""
        if self._earlier is None:
            return {}
        noise = np.nan if self.noise is None else self.noise
        values = (np.array(noise), np.array(self._earlier[0], np.int64), self._earlier[1])
        return dict(zip(NOISE_STATE, values, strict=True))

    def restore(self, state: Mapping[str, np.ndarray], rendering: lb.Rendering) -> None:
        """Go on from the estimate of a rendering of the same arguments, whose samples are restored.

        Parameters
        ----------
        state
            As `state` gave it.
        rendering
            The rendering whose noise it was.

        Raises
        ------
        ValueError
            For the noise of another picture.
        """
        if state.keys() != set(NOISE_STATE):
            raise ValueError("the estimate of the noise is incomplete")
        noise, samples, image = (state[name] for name in NOISE_STATE)
        here = _looked(rendering)
        if noise.shape or samples.shape or (image.shape, image.dtype) != (here.shape, here.dtype) or not (
                0 < int(samples) <= rendering.samples):
            raise ValueError("this is the noise of another picture")
        self._earlier = int(samples), image
        self.noise = float(noise) if np.isfinite(noise) else None

    def look(self, rendering: lb.Rendering) -> None:
        """Estimate the noise from the samples since the last look."""
        samples, image = rendering.samples, _looked(rendering)
        if self._earlier is not None:
            before, earlier = self._earlier
            later = (samples * image - before * earlier) / np.float32(samples - before)
            apart = self._codes(later) - self._codes(earlier)
            self.noise = float(np.sqrt(np.mean(apart**2, dtype=np.float64) / (
                samples / before + samples / (samples - before))))
        self._earlier = samples, image

    def _codes(self, image: np.ndarray) -> np.ndarray:
        codes = np.empty(image.shape, np.float32)
        for lines, found in zip(parts(codes), parts(exposed(self._settings, image)), strict=True):
            lines[:] = develop(found, self._settings)
        return codes


def _looked(rendering: lb.Rendering) -> np.ndarray:
    """The lines of a picture by which its noise is estimated."""
    h, w = rendering.shape
    every, top, found = -(-h * w // LOOKED), 0, []
    for band in rendering.bands():
        found.append(band[-top % every::every].copy())
        top += len(band)
    return np.concatenate(found)
