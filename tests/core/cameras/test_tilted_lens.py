"""Cameras whose lens has decentred and tilted surfaces: no plane of symmetry is left."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.pupils.film_grid_sampler import PupilGrid
from tests.core.optics.test_surface_pose import posed

FILM = lb.Film(36.0, 24.0, 90, 60)
TRIPLET = lb.stopped_down(lenses.load("lenshh-cooke-triplet-50"), 5.6)
BENT = posed(TRIPLET, 2, 3, decentre_x=0.3, decentre_y=0.5, tilt_x=0.05, tilt_y=0.02)
ROLLED = posed(replace(TRIPLET, surfaces=tuple(replace(s, curvature_x=0.4 * s.curvature) if i == 2 else s
                                               for i, s in enumerate(TRIPLET.surfaces))), 2, 3, roll=0.6)
DISTANCE = 43.0


@pytest.fixture(scope="module", params=[BENT, ROLLED], ids=["bent", "rolled"])
def grid(request):
    return request.param, PupilGrid.of(request.param, DISTANCE, 18.0, 12.0)


def passing_area(lens, film, count=240, half=9.0):
    """Area (mm²) of the region of a film point by the reference tracer, on a square grid of the rear plane."""
    at = (np.arange(count) + 0.5) * (2.0 * half / count) - half
    rear = np.stack(np.meshgrid(at, at), -1).reshape(-1, 2)
    start = np.array([*film, lens.length + DISTANCE])
    made = lb.trace(lens, start, np.column_stack([rear, np.full(len(rear), lens.length)]) - start)
    return (made.fate == lb.Fate.PASSED).sum() * (2.0 * half / count) ** 2


@pytest.mark.slow
@pytest.mark.parametrize("film", [(0.0, 0.0), (9.0, 7.0), (-9.0, 7.0), (9.0, -7.0), (-9.0, -7.0), (-15.0, 0.5)])
def test_each_quadrant_of_the_film_samples_its_own_regions(grid, film):
    n, (lens, grid) = 4000, grid
    uv = np.random.default_rng(2).uniform(size=(n, 2))
    given = {X: np.full(n, film[0]), Y: np.full(n, film[1]), U0: uv[:, 0], U1: uv[:, 1], WEIGHT: np.ones(n)}
    l, m, n_, weight = Program([grid.step(1.0)], np.float64).run(given, [L, M, N, WEIGHT], n)
    rays = lb.trace(lens, [*film, lens.length + DISTANCE], np.column_stack([l, m, n_]))
    passed = rays.fate == lb.Fate.PASSED
    assert passed.mean() > 0.97                                         # hardly a sample is wasted
    area = (weight / n_**4 * passed).mean()
    assert area == pytest.approx(passing_area(lens, film), rel=0.01)          # and no light is lost
    rear = np.array(film) - DISTANCE * np.stack([l, m], 1) / n_[:, None]
    at = np.tile(film, (n, 1))
    assert grid.sampled_area(at, rear) == pytest.approx(weight / n_**4, rel=1e-6)


@pytest.mark.slow
def test_a_picture_projects_back_to_its_film_points():
    camera = lb.LensCamera(BENT, FILM, 2000.0)
    raster, uv = np.array([[10.0, 8.0], [45.0, 30.0], [80.0, 50.0], [15.0, 55.0]]), np.full((4, 2), [0.6, 0.4])
    rays = camera.generate_rays(raster, uv, np.zeros(4))
    found, seen = camera.raster_from_point(rays.origins + 1500.0 * rays.directions, uv)
    assert seen.all() and found == pytest.approx(raster, abs=1e-3)      # at the film's centre, four quadrants meet


@pytest.mark.slow
def test_blades_close_the_stop_of_a_tilted_lens():
    round_, bladed = (lb.LensCamera(replace(BENT, blades=blades, blade_reach=1.0), FILM, 2000.0)
                      for blades in (0, 5))
    assert bladed.axis_irradiance / round_.axis_irradiance == pytest.approx(
        2.5 / np.pi * np.sin(2.0 * np.pi / 5.0), rel=0.01)              # a pentagon in its circle


def test_the_foremost_point_of_a_tilted_dome_is_on_its_glass():
    """A sphere's foremost point is R before its centre, wherever its vertex has gone."""
    first = TRIPLET.surfaces[0]
    camera = lb.LensCamera(posed(TRIPLET, 0, 0, tilt_x=0.1), FILM, 2000.0)
    centre = np.cos(0.1) / first.curvature
    assert camera.front + camera.lens.length + camera.film_distance == pytest.approx(centre - 1.0 / first.curvature,
                                                                                     abs=2e-3)


def test_other_models_and_dark_films_are_refused():
    for model in ("polynomial", "thick", "thin", "pinhole"):
        with pytest.raises(lb.CameraError, match="this one has a tilted or decentred surface: choose the full trace"):
            lb.LensCamera(BENT, FILM, 2000.0, model=model)
    with pytest.raises(lb.CameraError, match="no light reaches the film's centre"):
        lb.LensCamera(posed(TRIPLET, 2, 3, decentre_x=40.0), FILM, 2000.0)


def test_the_blur_of_a_decentred_lens_is_that_about_its_own_spot():
    moved = posed(TRIPLET, 0, len(TRIPLET.surfaces) - 1, decentre_x=0.8)    # the same spot, beside the axis
    distances = [1500.0, 2000.0, 4000.0]
    film = lb.film_distance(TRIPLET, 2000.0, "real")
    assert lb.film_distance(moved, 2000.0, "real") == pytest.approx(film, abs=1e-4)
    wanted, found = (lb.real_circle_of_confusion(lens, film, distances)[0] for lens in (TRIPLET, moved))
    assert found == pytest.approx(wanted, rel=0.02)
    assert lb.working_f_number(moved, film) == pytest.approx(lb.working_f_number(TRIPLET, film), rel=0.02)
    assert lb.first_order(moved) == lb.first_order(TRIPLET)
