"""A ripple on a surface against the trace of a lens that has it as an asphere."""

from dataclasses import replace
from math import factorial, inf, pi

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.optics.finding import Kind

LENS = lenses.load("lib-tronnier-1953")
AWAY = lb.film_distance(LENS, inf)
PERIOD, HEIGHT = 40.0, 2e-6             # so long that ten powers of the radius hold it to 1e-9


def grid(lens, pupil=32):
    return lb.analysis.ray_grid(lens, AWAY, lb.analysis.conditions(LENS, lb.Film(), 2), pupil)


@pytest.mark.parametrize("surface", [0, 4, len(LENS.surfaces) - 1])
def test_a_long_ripple_is_the_asphere_of_its_power_series(surface):
    k = 2.0 * pi / PERIOD
    terms = tuple((2 * m, 0.5 * HEIGHT * (-1) ** m * k ** (2 * m) / factorial(2 * m)) for m in range(1, 9))
    bumped = replace(LENS, surfaces=tuple(replace(each, aspheric=terms) if i == surface else each
                                          for i, each in enumerate(LENS.surfaces)))
    plain, exact = grid(LENS), grid(bumped)
    found = lb.analysis.rippled(plain, surface, PERIOD, HEIGHT)
    passed = plain.passed[0] & exact.passed[0]
    change = (exact.opd - plain.opd)[0][passed]
    assert np.abs((found.opd - plain.opd)[0][passed] - change).max() < 2e-3 * np.abs(change).max()
    landed = (exact.offset_t - plain.offset_t)[0][passed]
    assert np.median(np.abs((found.offset_t - plain.offset_t)[0][passed] - landed)) < 0.02 * np.abs(landed).max()


def test_rings_that_the_points_do_not_resolve_are_said_and_impossible_ones_refused():
    rays = grid(LENS)
    assert all(each.kind is not Kind.SAMPLING for each in lb.analysis.rippled(rays, 0, 3.0, 1e-5).findings)
    assert lb.analysis.rippled(rays, 0, 0.4, 1e-5).findings[-1].kind is Kind.SAMPLING
    for surface, period, height in ((len(LENS.surfaces), 1.0, 1e-5), (0, 0.0, 1e-5), (0, 1.0, -1e-5)):
        with pytest.raises(lb.LensError):
            lb.analysis.rippled(rays, surface, period, height)


def test_a_ripple_of_a_surface_that_refracts_nothing_is_refused():
    with pytest.raises(lb.LensError, match=f"surface {LENS.stop_index} is the aperture stop"):
        lb.analysis.rippled(grid(LENS), LENS.stop_index, PERIOD, HEIGHT)
