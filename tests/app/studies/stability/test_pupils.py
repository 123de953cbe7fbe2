"""Light of exit-pupil regions: against the solved area, closed forms, and laws of lost light."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability import pupils, sampling
from lensbench.app.studies.stability.pupils import FilmPoint


def film_point(name="pbrt-dgauss-50mm", radius=0.0, stop=1.0, azimuth=0.0):
    lens = lenses.load(name)
    lens = lens.with_stop_radius(stop * lens.stop.semi_diameter)
    film = radius * math.cos(azimuth), radius * math.sin(azimuth)
    return FilmPoint(lens, lb.film_distance(lens, math.inf), film, 22.0)


@pytest.mark.parametrize(("radius", "stop"), [(0.0, 1.0), (15.0, 1.0), (21.0, 0.3), (8.0, 1e-3)])
def test_cells_of_rays_count_the_area_that_the_rim_encloses(radius, stop):
    where = film_point(radius=radius, stop=stop)
    solved = lb.exit_pupil(where.lens, where.film_distance, [radius]).area[0]
    # 9,000 cells and more: a rim of some 300 of them, each by half, at random
    assert pupils.true_area(where) == pytest.approx(solved, rel=0.01)


def test_an_open_ring_has_the_area_of_a_disk():
    """For a stop alone the region is the shadow of the stop on its own plane."""
    alone = lb.Lens((lb.Surface(0.0, 3.0, curvature=0.0),), 0)
    point = FilmPoint(alone, 20.0, (4.0, 2.0), 10.0)
    assert pupils.true_area(point) == pytest.approx(9.0 * math.pi, rel=0.01)
    result = pupils.result(point, lambda uv: (12.0 * uv - 6.0, np.full(len(uv), 144.0)))
    assert result.waste == pytest.approx(1.0 - 9.0 * math.pi / 144.0, abs=0.01)
    assert result.light < 0.02


@pytest.mark.parametrize(("radius", "azimuth"), [(10.0, 0.0), (10.0, 2.0), (19.0, 4.0)])
def test_every_method_finds_the_light_where_it_is_easy(radius, azimuth):
    where = film_point(radius=radius, stop=0.5, azimuth=azimuth)
    results = {name: pupils.result(where, method(where)) for name, method in pupils.METHODS.items()
             if name != "paraxial disk"}
    assert all(result.light < 0.02 for result in results.values())
    assert results["solved region"].waste < 0.02 < results["boxes of 1,048,576 rays"].waste < (
        results["boxes of 32,768 rays"].waste) < results["boxes of 1,024 rays"].waste


def test_a_small_stop_is_found_by_the_solver_and_by_no_box():
    where = film_point(radius=15.0, stop=1e-3)
    own, box = (pupils.result(where, pupils.METHODS[name](where)) for name in ("solved region", "boxes of 32,768 rays"))
    assert own.light < 0.01 and own.waste < 0.05
    assert box.light > 0.5 and box.waste > 0.99


def test_of_a_bent_region_the_outline_around_all_loses_nothing_and_what_one_centre_sees_does():
    end = pupils._end(pupils.BENT)
    lens = lenses.load(pupils.BENT)
    where = FilmPoint(lens, lb.film_distance(lens, math.inf), (0.98 * end, 0.0), 1.0001 * end)
    own, one = (pupils.result(where, method(where)) for method in (pupils.solved, pupils.star))
    # eight in ten of 4,096 samples miss the crescent
    assert own.light < 0.03 and 0.5 < own.waste < 0.95
    assert one.light > 0.3


def test_what_is_left_out_of_a_region_is_lost_as_its_square():
    sweep = sampling.lost_light()
    for curve in sweep.curves:
        far = sweep.values > 0.01
        np.testing.assert_allclose(curve.errors[far], 1.0 - (1.0 - sweep.values[far]) ** 2, atol=2e-3)


@pytest.mark.slow
def test_white_noise_falls_with_what_passes_by_bernoullis_law_and_the_net_is_never_noisier():
    sweep = sampling.noise(0.0)
    net, white, edge, white_edge = (curve.errors for curve in sweep.curves)
    # RMSE of the mean of 64 that pass with probability p, each then worth 1 / p; half of that behind an edge
    for values, p in ((white, sweep.values), (white_edge, 0.5 * sweep.values)):
        np.testing.assert_allclose(values, np.sqrt((1.0 - p) / (64.0 * p)), rtol=0.15, atol=0.012)
    assert (net[1:] < 0.5 * white[1:]).all() and (edge < 0.9 * white_edge).all()


def test_differentials_hold_to_the_very_rim_and_the_next_pixels_ray_does_not():
    sweep = sampling.differentials()
    verdicts = {curve.name: sweep.verdict(curve) for curve in sweep.curves}
    assert verdicts["at the same place of the pupil, float64"].worst < 1e-6
    assert verdicts["at the same place of the pupil, float32"].fails_at is None
    neighbour = sweep.curves[0]
    assert neighbour.errors[0] > 0.01 and neighbour.returned[-1] == "weight 0"
