"""Regions that are not star-shaped, at the edge of the light of some lenses, against counted rays."""

import math

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
@pytest.mark.parametrize("r", [12.2, 12.28, 12.29, 12.3, 12.31, 12.32, 12.33, 12.34, 12.36, 12.4, 12.8, 12.95])
def test_all_pieces_of_a_region_count(camera, r):
    area, light = counted(camera, r)
    pupil = lb.exit_pupil(camera.lens, camera.film_distance, [0.0, r])
    assert pupil.area[1] == pytest.approx(area, rel=0.01)
    assert pupil.cos4_area[1] == pytest.approx(light, rel=0.01)


@pytest.mark.parametrize("r", [12.3, 12.32])
def test_of_the_cells_at_the_edges_of_the_pieces_the_lit_part_counts(camera, r):
    """Where the pieces are wide: half a cell more or less at each edge would be 0.3 % of them and more."""
    area, light = counted(camera, r)
    pupil = lb.exit_pupil(camera.lens, camera.film_distance, [0.0, r])
    assert pupil.area[1] == pytest.approx(area, rel=1e-3)
    assert pupil.cos4_area[1] == pytest.approx(light, rel=1e-3)


def test_the_falloff_at_the_rim_of_a_fisheye_is_that_of_its_light(camera):
    lens, z = camera.lens, camera.film_distance
    axis = lb.exit_pupil(lens, z, [0.0, 1.0]).cos4_area[0]
    counted_light = [counted(camera, r)[1] / axis for r in (12.3, 12.32)]
    np.testing.assert_allclose(lb.falloff(lens, z, [12.3, 12.32]).total, counted_light, atol=0.002)


def test_no_polynomial_is_fitted_to_split_regions(camera):
    side = 12.32 * 2.0**0.5                     # its corners lie where the regions are split
    with pytest.raises(lb.LensError, match="no polynomial: some exit-pupil regions of this lens are split or bent"):
        lb.LensCamera(camera.lens, lb.Film(side, side, 100, 100), model="polynomial").generate_rays(
            [[20.0, 50.0]], [[0.5, 0.5]])


@pytest.mark.parametrize(("name", "stop", "r", "box"), [
    ("fisheye-16-f28", 1.0, 21.8813, (-2.2, 13.6, 6.2)),                        # a sickle far beside the rest
    ("nikon-af-fisheye-nikkor-d-16-f28", 1.0, 23.3272, (8.7, 11.4, 7.2)),       # a piece far above it
    ("apple-phone-6-elements-4-f18", 0.3, 3.22, (2.8, 3.05, 0.08)),             # two beside each other, small
    ("konica-hexanon-38-f28", 1.0, 35.35, (2.5, 5.1, 4.4)),                     # nothing on the meridian
    ("panasonic-lumix-g-asph-25-f17", 1.0, 14.7579, (11.3, 12.0, 3.4)),         # a long bow, of which an end is seen
    ("fujifilm-fujinon-gf-t-s-30-f56", 1.0, 46.3, (18.9, 20.7, 4.1))])          # float32 loses a quarter of it
def test_light_counts_wherever_it_lies(name, stop, r, box):
    lens = lenses.load(name)
    z = lb.film_distance(lens, math.inf)
    lens = lens.with_stop_radius(stop * lens.stop.semi_diameter)
    left, right, top = box
    x, y = (a.ravel() for a in np.meshgrid(left + (right - left) * (np.arange(1500) + 0.5) / 1500,
                                           top * (np.arange(400) + 0.5) / 400))
    passed = lb.trace(lens, [r, 0.0, lens.length + z],
                      np.column_stack([x - r, y, np.full(x.size, -z)])).fate == lb.Fate.PASSED
    counted_area = 2.0 * (right - left) * top * passed.mean()
    # Alone, or as one of many in any order
    assert lb.exit_pupil(lens, z, r).area[0] == pytest.approx(counted_area, rel=0.005)
    assert lb.exit_pupil(lens, z, [0.9 * r, r, 0.0]).area[1] == pytest.approx(counted_area, rel=0.005)
