"""References of the focusing sweeps against fifty digits and limits, and the verdicts about the methods."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability import focusing
from lensbench.app.studies.stability.focusing import bracketing_search, focus_of_one_ray, school_formula
from lensbench.app.studies.stability.refraction import exactly
from tests.core.oracles import rms_on_film
from tests.core.test_known_failures_focus import conjugate as fifty_digits

WIDE = lenses.load("pbrt-wide-22mm")


@pytest.mark.parametrize("name", ["pbrt-wide-22mm", "pbrt-dgauss-50mm", "optiland-telephoto-f56"])
@pytest.mark.parametrize("distance", [2e3, 1e4, 1e7])
def test_the_conjugate_is_that_of_another_fifty_digits(name, distance):
    lens = lenses.load(name)
    with exactly():
        film = focusing.conjugate(lens, distance)
    assert abs(float(film) - float(fifty_digits(lens, distance))) < 1e-14 * lens.length


def test_nearer_than_magnification_one_there_is_no_conjugate():
    with exactly():
        for distance in (98.0, 40.0, 5.0):
            assert not focusing.conjugate(WIDE, distance).is_finite()
        assert focusing.conjugate(WIDE, lb.nearest_focus(WIDE) * (1.0 + 1e-9)).is_finite()


@pytest.mark.parametrize("distance", [500.0, 5e3])
def test_the_least_blur_has_no_smaller_one_next_to_it(distance):
    film = focusing.least_blur(WIDE, distance)
    best, nearer, farther = (rms_on_film(WIDE, film + step, distance) for step in (0.0, -0.01, 0.01))
    assert best < min(nearer, farther)
    # of a disk of light the whole extent is √2 times its rms radius; of any spot it is at least the rms
    assert focusing.extent(WIDE, film, distance) > focusing.rms_radius(WIDE, film, distance) == pytest.approx(
        best, rel=0.01)


def test_one_ray_sees_the_paraxial_plane_as_it_nears_the_axis_and_another_one_far_from_it():
    film = lb.film_distance(WIDE, 10_000.0)
    assert focus_of_one_ray(WIDE, film, 1e-4, np.float64) == pytest.approx(10_000.0, rel=1e-3)
    assert not 8_000.0 < focus_of_one_ray(WIDE, film, 0.15, np.float64) < 12_000.0
    assert focus_of_one_ray(WIDE.with_stop_radius(0.02), film, 0.15, np.float64) is None


def test_the_search_ends_where_its_own_ray_meets_the_plane_that_was_asked_for():
    film = bracketing_search(WIDE, 2_000.0, np.float64)
    # its twenty halvings leave a part in two hundred over 2^20
    assert focus_of_one_ray(WIDE, film, 0.15, np.float64) == pytest.approx(2_000.0, rel=1e-3)
    assert bracketing_search(WIDE.with_stop_radius(0.1), 200.0, np.float64) == "no end"
    assert bracketing_search(WIDE, 50.0, np.float64) == "NaN"
    assert school_formula(WIDE, 2_000.0, np.float64) == pytest.approx(lb.film_distance(WIDE, 2_000.0), abs=1e-11)


def verdicts(sweep):
    return {curve.name: sweep.verdict(curve) for curve in sweep.curves}


@pytest.mark.slow
def test_the_closed_form_holds_at_every_distance_and_float32_loses_the_far_ones():
    far, near = verdicts(focusing.far_focus()), verdicts(focusing.near_focus())
    assert far["closed form"].fails_at is None and far["closed form"].worst < 1e-13
    assert 1e4 < far["school formula, float32"].safe_up_to < 1e6
    assert near["closed form"].fails_at is None and near["closed form"].returns == "FocusError"
    assert near["school formula, float64"].returns == "NaN"


@pytest.mark.slow
def test_the_whole_bundle_holds_at_every_stop_and_the_paraxial_focus_at_small_ones_alone():
    closing, opening = verdicts(focusing.closing_stop()), verdicts(focusing.best_focus(focusing.LENS))
    assert closing["whole bundle"].fails_at is None and closing["whole bundle"].worst < 1e-4
    assert opening["whole bundle"].fails_at is None
    assert 0.2 < opening["closed form"].safe_up_to < 0.6
    assert math.isclose(opening["closed form"].safe_up_to, opening["a fifth of the bundle"].safe_up_to)
