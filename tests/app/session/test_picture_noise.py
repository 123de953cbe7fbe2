"""The estimated noise of a picture: its error, and the samples at which it is estimated."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.session.export import develop
from lensbench.app.session.picture_render import Noise
from lensbench.app.settings.settings import Settings


class Made:
    """A rendering whose samples are known: white noise of a given strength about middle grey."""

    def __init__(self, deviation):
        self._random, self._deviation = np.random.default_rng(1), deviation
        self._sum, self.samples = np.zeros((120, 120, 3)), 0

    def add(self, samples):
        for _ in range(samples):
            self._sum += 0.2 + self._random.normal(0.0, self._deviation, self._sum.shape)
        self.samples += samples

    @property
    def shape(self):
        return self._sum.shape[:2]

    def bands(self):
        image = (self._sum / self.samples).astype(np.float32)
        return iter((image[:50], image[50:]))

    def image(self):
        return np.concatenate([*self.bands()])


def test_the_noise_is_the_error_of_the_developed_picture():
    settings, made = replace(Settings(), tone="none"), Made(0.02)
    meter = Noise(settings, 1e-3)
    looks = []
    while not meter.is_enough:
        made.add(meter.next_look - made.samples)
        meter.look(made)
        if meter.noise is not None:
            truth = develop(np.full((1, 1, 3), 0.2, np.float32), settings)
            error = np.sqrt(np.mean((develop(made.image(), settings) - truth) ** 2))
            assert meter.noise == pytest.approx(error, rel=0.02)        # 43,000 numbers: 0.3 %, and as much again
            looks.append(made.samples)
    assert 300 < looks[-1] < 700            # 0.02 / √n in codes of slope 1.16: 540 samples bring it to 0.001
