"""What occludes the light of the sky: the spheres of a scene as they are."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.scenery.shading.illumination import CENTRE, OCCLUDER, RADIUS2, REACH, sky_occluders

PAPER = lb.Material((1.0, 1.0, 1.0))


def test_a_ball_occludes_the_sky_as_the_ball_it_is():
    numbers, _ = sky_occluders([lb.Sphere((30.0, -20.0, -900.0), 40.0, PAPER)])
    assert numbers.shape == (OCCLUDER,)
    assert numbers[CENTRE:CENTRE + 3] == pytest.approx([30.0, -20.0, -900.0])
    assert (numbers[RADIUS2], numbers[REACH]) == (1600.0, 40.0)


def test_many_balls_occlude_from_afar_as_much_as_they_do_one_by_one():
    random = np.random.default_rng(1)
    balls = [lb.Sphere(tuple(place), radius, PAPER) for place, radius in zip(
        random.normal(0.0, 900.0, (50, 3)), random.uniform(5.0, 90.0, 50), strict=True)]
    numbers, below = sky_occluders(balls)
    covers, below = np.reshape(numbers, (-1, OCCLUDER))[:, RADIUS2], np.asarray(below)
    assert sorted(covers[below == 0]) == pytest.approx(sorted(ball.radius**2 for ball in balls))
    assert below.max() > 1
    for k in np.flatnonzero(below):
        own = slice(k + 1, k + 1 + below[k])
        assert covers[k] == pytest.approx(covers[own][below[own] == 0].sum())
