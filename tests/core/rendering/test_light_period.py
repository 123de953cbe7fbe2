"""The period of light passes follows from the noise of both kinds of rays."""

from concurrent.futures import ThreadPoolExecutor
from math import sqrt

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import B
from lensbench.core.rendering.light_layer import DECIDED, DENSEST, FIRST_PASSES, RAREST, RAY_TIME, LightPeriod

SHAPE = (96, 128)
PIXELS = SHAPE[0] * SHAPE[1]


class NoisySamples:
    """Samples of a grey picture, of a given radiance and standard deviation, instead of a program."""

    real = np.float32

    def __init__(self, deviation, radiance=1.0):
        self.deviation, self.radiance, self.rng = deviation, radiance, np.random.default_rng(1)

    def expose(self, film, lanes, first, last, sample, samples, seed, origin):
        assert last == first + 1 and origin == first
        noise = self.deviation * sqrt(samples) * self.rng.standard_normal(B)
        film[0] += np.tile(self.radiance * samples + noise, 3)


def decided(of_samples, of_light, rays):
    """The period for a camera's samples and light passes of these standard deviations, around 1 and around 0.5."""
    period, rng = LightPeriod(SHAPE, np.uint32(0)), np.random.default_rng(2)
    period.set_early(rays, 0.1 * PIXELS)
    sums = np.zeros((PIXELS, 3), np.float32)
    for number in range(FIRST_PASSES):
        sums += (0.5 + of_light * rng.standard_normal((PIXELS, 1))).astype(np.float32)
        period.note(number + 1, sums)
    with ThreadPoolExecutor(1) as pool:
        assert period.decide(NoisySamples(of_samples), pool, 1, lambda: True)
    return int(period.state["light_period"])


@pytest.mark.parametrize(("of_samples", "of_light", "rays_per_pixel"),
                         [(0.5, 0.1, 2.0), (0.3, 0.05, 5.0), (0.4, 0.2, 8.0)])
def test_the_period_makes_the_error_in_a_given_time_least(of_samples, of_light, rays_per_pixel):
    """Of all powers of two p: n passes leave a / n + b p / n, and take n (1 + t / p), t being that of a light pass."""
    # The mean of the picture is 1.5, to which each luminance is added
    a, b = (of_samples / 2.5) ** 2, (of_light / 2.0) ** 2
    periods = 2 ** np.arange(9)
    least = periods[np.argmin((a + b * periods) * (1.0 + RAY_TIME * rays_per_pixel / periods))]
    assert DENSEST < least < RAREST
    assert decided(of_samples, of_light, rays_per_pixel * PIXELS) == least


def test_a_period_stays_within_its_bounds():
    assert decided(0.5, 0.0, PIXELS) == RAREST
    assert decided(0.0, 0.1, PIXELS) == DENSEST
    assert decided(np.nan, 0.1, PIXELS) == decided(0.5, np.nan, PIXELS) == decided(np.inf, 0.1, PIXELS) == RAREST


@pytest.mark.parametrize("late", [2, 7, 32])
def test_the_passes_before_a_number_are_those_that_trace_lights(late):
    period = LightPeriod(SHAPE, np.uint32(0))
    period.set_early(PIXELS, 0.02 * PIXELS)
    period.state["light_period"][...] = late
    traced = [period.traces(number) for number in range(200)]
    assert traced[:FIRST_PASSES] == [True] * FIRST_PASSES
    assert np.flatnonzero(traced[DECIDED:]).tolist() == [k for k in range(200 - DECIDED) if (DECIDED + k) % late == 0]
    assert [period.before(number) for number in range(200)] == [sum(traced[:number]) for number in range(200)]


def test_lights_that_fill_the_film_are_traced_more_often_than_a_few_glints():
    film = lb.Film(36.0, 24.0, 240, 160)
    periods = []
    for name in ("night-lights", "still-life"):
        camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film, 1200.0, 2.0)
        rendering = lb.Rendering(camera, lb.builtin_scene(name), seed=1)
        rendering.add(DECIDED)
        assert rendering.state["light_period"] == 0
        rendering.add()
        periods.append(int(rendering.state["light_period"]))
    assert periods[0] < periods[1]


def test_a_dark_picture_has_a_period():
    period = LightPeriod(SHAPE, np.uint32(0))
    period.set_early(0.0, 0.0)
    with ThreadPoolExecutor(1) as pool:
        assert period.decide(NoisySamples(0.0, 0.0), pool, 1, lambda: True)
    assert period.state["light_period"] == RAREST


def test_a_cancelled_trial_decides_nothing():
    period = LightPeriod(SHAPE, np.uint32(0))
    period.set_early(PIXELS, PIXELS)
    with ThreadPoolExecutor(1) as pool:
        assert not period.decide(NoisySamples(1.0), pool, 1, lambda: False)
    assert period.state["light_period"] == 0
