"""The sunstar: its number of rays, and the pattern of a square in closed form."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.blade_star import add_pattern, open_pupil

LENS = lenses.load("lib-tronnier-1953")
AWAY = lb.film_distance(LENS, inf)


def star(blades, film_xy=(0.0, 0.0), **more):
    return lb.analysis.sunstar(lb.stopped_down(replace(LENS, blades=blades, **more), 11.0), AWAY, film_xy, colours=12)


@pytest.mark.parametrize(("blades", "rays"), [(5, 10), (6, 6), (7, 14), (8, 8), (9, 18)])
def test_an_odd_number_of_blades_draws_twice_as_many_rays(blades, rays):
    found = star(blades)
    assert len(found.rays) == rays
    assert np.ptp(np.diff(found.rays)) < 0.5 / blades


def test_the_open_pupil_has_whole_corners():
    """Seven blades have seven corners on the circle of the stop; between them the lens bows the edges by a little."""
    outline = open_pupil(replace(lb.stopped_down(LENS, 11.0), blades=7, blade_reach=1.0), AWAY, (0.0, 0.0))
    before, edges = outline - np.roll(outline, 1, 0), np.roll(outline, -1, 0) - outline
    turns = np.arctan2(before[:, 0] * edges[:, 1] - before[:, 1] * edges[:, 0], (before * edges).sum(1))
    corners = outline[turns > 0.5]
    assert len(corners) == 7 and turns[turns > 0.5] == pytest.approx(np.full(7, 2.0 * pi / 7.0), abs=0.01)
    assert turns[turns <= 0.5].max() < 0.01
    assert np.hypot(*corners.T) == pytest.approx(np.full(7, np.hypot(*corners[0])), rel=1e-5)


def test_the_rays_lie_across_the_blades_and_turn_with_them():
    across = star(6).rays % (pi / 3.0)                  # at rotation 0 a corner points up
    assert np.minimum(across, pi / 3.0 - across).max() < 0.02
    turned = star(6, blade_rotation=0.3).rays % (pi / 3.0)
    np.testing.assert_allclose(turned, 0.3, atol=0.02)


@pytest.mark.slow
def test_rounded_blades_weaken_the_rays_and_a_round_stop_has_none():
    straight, rounded = star(7), star(7, roundness=0.2)
    assert rounded.profile.max() < 0.2 * straight.profile.max()
    with_none = lb.analysis.sunstar(lb.stopped_down(LENS, 11.0), AWAY, azimuths=96, colours=2)
    assert len(with_none.rays) == 0


def test_the_pattern_of_a_square_is_that_of_its_sides():
    a, line = 0.05, 5e-4
    square = 0.5 * a * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    radii, azimuths, found = np.array([0.001, 0.0137, 0.2]), np.array([0.0, 0.3, pi / 4.0, 1.2]), np.zeros((3, 4))
    add_pattern(square, radii, azimuths, np.array([line]), found)
    x, y = (a * radii[:, None] * each(azimuths) / line for each in (np.cos, np.sin))
    np.testing.assert_allclose(found, (a * a * np.sinc(x) * np.sinc(y) / line) ** 2, rtol=1e-9, atol=1e-12)


def test_impossible_stars_are_refused():
    for more in ({"azimuths": 47}, {"colours": 0}, {"radii": [0.0]}, {"film_xy": (0.0, 400.0)}):
        with pytest.raises(lb.LensError):
            lb.analysis.sunstar(replace(LENS, blades=6, blade_reach=1.0), AWAY, **more)
