"""Regions of several pieces at the edge of the light of a fisheye, against counted rays."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses

RAYS = 700                      # across and up, over the box of the region


@pytest.fixture(scope="module")
def camera():
    return lb.LensCamera(lenses.load("lib-miyamoto-fisheye-1964"), lb.Film(36.0, 36.0, 100, 100))


def counted(camera, r):
    """Area (mm²) and ∫ cos⁴θ dA of the rays that the reference tracer passes, from cells of the rear plane."""
    lens, z = camera.lens, camera.film_distance
    x0, x1, top = 9.0, 14.0, 3.0                # holds the regions of film radii of 12 to 12.4 mm
    x, y = (a.ravel() for a in np.meshgrid(x0 + (x1 - x0) * (np.arange(2 * RAYS) + 0.5) / (2 * RAYS),
                                           top * (np.arange(RAYS) + 0.5) / RAYS))
    way = np.column_stack([x - r, y, np.full(x.size, -z)])
    passed = lb.trace(lens, [r, 0.0, lens.length + z], way).fate == lb.Fate.PASSED
    cell = 2.0 * (x1 - x0) / (2 * RAYS) * top / RAYS
    cos4 = (z / np.linalg.norm(way, axis=1)) ** 4
    return passed.sum() * cell, cos4[passed].sum() * cell


@pytest.mark.slow
@pytest.mark.parametrize("r", [12.05, 12.13, 12.15, 12.2, 12.25, 12.3, 12.35, 12.4])
def test_all_pieces_of_a_region_count(camera, r):
    area, light = counted(camera, r)
    pupil = lb.exit_pupil(camera.lens, camera.film_distance, [0.0, r])
    assert pupil.area[1] == pytest.approx(area, rel=0.01)
    assert pupil.cos4_area[1] == pytest.approx(light, rel=0.01)


@pytest.mark.parametrize("r", [12.2, 12.25])
def test_of_the_cells_at_the_edges_of_the_pieces_the_lit_part_counts(camera, r):
    """Where the pieces are wide: half a cell more or less at each edge would be 0.3 % of them and more."""
    area, light = counted(camera, r)
    pupil = lb.exit_pupil(camera.lens, camera.film_distance, [0.0, r])
    assert pupil.area[1] == pytest.approx(area, rel=1e-3)
    assert pupil.cos4_area[1] == pytest.approx(light, rel=1e-3)


def test_the_falloff_at_the_rim_of_a_fisheye_is_that_of_its_light(camera):
    lens, z = camera.lens, camera.film_distance
    total = lb.falloff(lens, z, [12.15, 12.2]).total
    np.testing.assert_allclose(total, [0.4115, 0.2385], atol=0.002)     # by rays counted through the reference tracer


def test_no_polynomial_is_fitted_to_split_regions(camera):
    with pytest.raises(lb.LensError, match="no polynomial: near the edge of the light"):
        lb.LensCamera(camera.lens, camera.film, model="polynomial").generate_rays([[20.0, 50.0]], [[0.5, 0.5]])
