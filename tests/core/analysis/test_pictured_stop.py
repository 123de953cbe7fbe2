"""A picture in the stop in spots, MTF and PSF: right side up, its light counted once, diffraction in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis import conditions, mtf, psf, ray_grid, spots
from tests.core.optics.test_stop_image import SHARE, F, in_letter

FILM = lb.Film()
LENS = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 4.0)
PICTURED = replace(LENS, stop_image=F)


def fields(lens, *points):
    return replace(conditions(lens, FILM), fields=points, wavelengths=(0.5875618,), weights=(1.0,), primary=0)


@pytest.fixture(scope="module")
def grids():
    away = lb.film_distance(LENS, math.inf) - 0.8           # before the focus: points are discs
    return away, *(ray_grid(lens, away, fields(lens, (0.0, 0.0), (0.0, 0.15)), 64) for lens in (LENS, PICTURED))


def landed(away, angle, count=700):
    """Film points (n, 2), from their chief ray, of a distant point's rays that meet the letter in the stop."""
    way = np.array([0.0, math.sin(angle), math.cos(angle)])
    at = (np.stack(np.meshgrid(*2 * [np.linspace(-14.0, 14.0, count)]), -1)).reshape(-1, 2)
    start = np.column_stack([at, np.zeros(len(at))])
    start -= 30.0 * way                                     # a plane of even density across x and y
    met = lb.trace(LENS, start, np.tile(way, (len(at), 1)), record=True)
    stop = met.paths[:, 1 + LENS.stop_index, :2] / LENS.stop.semi_diameter
    kept = (met.fate == lb.Fate.PASSED) & in_letter(*stop.T)
    o, d = met.points[kept], met.directions[kept]
    return o[:, :2] + ((LENS.length + away - o[:, 2]) / d[:, 2])[:, None] * d[:, :2]


@pytest.mark.parametrize("field", [0, 1])
def test_spots_are_those_of_the_rays_through_the_letter(grids, field):
    """Mean and covariance on the film: a mirrored, or turned, letter changes their signs."""
    away, _, rays = grids
    wanted = landed(away, rays.angles[field, 1]) - rays.images[field]
    across, along = rays.axes[field]
    offset = np.stack([rays.offset_s[field, 0], rays.offset_t[field, 0]])
    weight = rays.weight[field, 0]
    got = np.nan_to_num(offset)[0][..., None] * across + np.nan_to_num(offset)[1][..., None] * along
    total = weight.sum()
    mean = (weight[..., None] * got).sum((0, 1)) / total
    second = np.einsum("ij,ija,ijb->ab", weight, got - mean, got - mean) / total
    size = wanted.std()
    assert mean == pytest.approx(wanted.mean(0), abs=0.01 * size)
    assert second == pytest.approx(np.cov(wanted.T), abs=0.01 * size**2)
    for flip in ([-1.0, 1.0], [1.0, -1.0]):
        assert np.abs(mean - wanted.mean(0) * flip).max() > 0.1 * size


def test_the_mean_transmission_counts_once(grids):
    _, plain, rays = grids
    assert rays.open_area[0] / plain.open_area[0] == pytest.approx(SHARE, rel=0.01)     # cells of 1/64 at its edges
    assert rays.weight[0, 0][rays.weight[0, 0] > 0.0].mean() == pytest.approx(1.0)
    assert not rays.mirrored and plain.mirrored and not any("picture" in str(each) for each in rays.findings)
    for method, least in (("geometric", 1.0 - 1e-6), ("diffraction", 0.95)):    # its narrow bars spread a part widely
        assert least < psf(rays, method=method).captured[0, 0] < 1.0 + 1e-6


def test_an_even_grey_filter_changes_nothing_but_the_light():
    away = lb.film_distance(LENS, math.inf)
    grey = replace(LENS, stop_image=lb.StopImage.of(np.full((4, 4), 0.25)))
    asked = fields(LENS, (0.0, 0.0), (0.05, 0.12))
    one, two = (ray_grid(lens, away, asked, 32) for lens in (LENS, grey))
    assert two.open_area == pytest.approx(0.25 * one.open_area, rel=1e-9)
    for name in ("weight", "coverage", "intensity"):
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=1e-6)
    assert spots(two).rms_radius == pytest.approx(spots(one).rms_radius, rel=1e-6)
    frequencies = np.array([20.0, 80.0])
    assert mtf(two, frequencies).modulus == pytest.approx(mtf(one, frequencies).modulus, rel=1e-6)


def test_the_mtf_of_a_slit_is_a_triangle():
    """The autocorrelation of a rectangle; across it, half as wide as the stop, half the cutoff of the circle."""
    lens = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 16.0)       # diffraction alone
    picture = np.zeros((64, 64))
    picture[12:52, 16:48] = 1.0                                         # |x| ≤ 0.5, |y| ≤ 0.625
    away = lb.film_distance(lens, math.inf, "real")
    rays = ray_grid(replace(lens, stop_image=lb.StopImage.of(picture)), away, fields(lens, (0.0, 0.0)), 64)
    sine = 0.5 / lb.working_f_number(lens, away)
    cutoff = 2.0 * sine / 0.5875618e-3
    nu = np.array([0.1, 0.2, 0.3, 0.4]) * cutoff
    made = mtf(rays, nu).modulus[0, 0]                                  # sagittal (x), tangential (y)
    assert made[0] == pytest.approx(1.0 - nu / (0.5 * cutoff), abs=0.02)
    assert made[1] == pytest.approx(1.0 - nu / (0.625 * cutoff), abs=0.02)
