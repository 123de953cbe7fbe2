"""Fans, Zernike polynomials and wavefronts: orthonormality, known wavefronts, and the ray grid's own laws."""

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.wavefront import fringe_index, noll_indices, zernike_name, zernikes
from tests.core.analysis.grids.test_ray_grid import hyperbolic, of_angles
from tests.core.oracles import REFERENCE, lens


def perfect_grid(pupil=64):
    """The grid of a lens without aberrations, on the axis: a round pupil and W = 0."""
    stack = hyperbolic()
    return of_angles(stack, lb.film_distance(stack, inf), 0.0, pupil=pupil)


def test_zernike_polynomials_are_orthonormal_over_the_disk():
    node, weight = np.polynomial.legendre.leggauss(24)
    r, turn = np.sqrt(0.5 * (node + 1.0)), 2.0 * pi * np.arange(48) / 48
    values = zernikes(45, np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn)))
    products = np.einsum("jab,kab,a->jk", values, values, 0.5 * weight) / 48
    np.testing.assert_allclose(products, np.eye(45), atol=1e-12)


def test_polynomials_have_nolls_order_and_the_fringe_indices():
    table = {1: (0, 0, 1), 2: (1, 1, 2), 3: (1, -1, 3), 4: (2, 0, 4), 5: (2, -2, 6), 6: (2, 2, 5), 7: (3, -1, 8),
             8: (3, 1, 7), 9: (3, -3, 11), 10: (3, 3, 10), 11: (4, 0, 9), 22: (6, 0, 16), 37: (8, 0, 25)}
    for j, (n, m, fringe) in table.items():
        assert noll_indices(j) == (n, m) and fringe_index(n, m) == fringe
    assert sorted(fringe_index(*noll_indices(j)) for j in range(1, 7)) == [1, 2, 3, 4, 5, 6]
    assert zernike_name(*noll_indices(7)) == "coma, sine" and zernike_name(*noll_indices(11)) == "spherical aberration"


def test_a_known_wavefront_is_found_again_with_its_rms_and_strehl_ratio():
    grid = perfect_grid()
    perfect = lb.analysis.wavefronts(grid)
    middle, radius = perfect.centres[0], perfect.radii[0]
    # The marginal ray leaves the hyperboloid 10 mm above the axis, where its sag is negative
    assert radius == pytest.approx(np.sin(np.arctan(10.0 / (50.0 - hyperbolic().surfaces[1].sag(0.0, 10.0)))), rel=1e-3)
    x, y = ((each - at) / radius for each, at in
            zip(np.meshgrid(grid.pupil[0, 0], grid.pupil[0, 1]), middle, strict=True))
    amount = np.zeros(37)
    amount[[3, 6, 10]] = 2e-5, -1e-5, 3e-5              # mm: defocus, coma, spherical aberration

    def of(x, y):
        return np.einsum("j,jab->ab", amount, zernikes(37, x, y))

    # A ray lands at the slope of its path difference
    w, step = of(x, y), 1e-5
    slope_s, slope_t = ((of(x + step * a, y + step * b) - of(x - step * a, y - step * b)) / (2.0 * step * radius)
                        for a, b in ((1.0, 0.0), (0.0, 1.0)))
    at_s, at_t = ((own - at[None, None]) for own, at in zip((grid.pupil_s, grid.pupil_t), np.meshgrid(*grid.pupil[0]),
                                                            strict=True))
    aberrated = replace(grid, opd=grid.opd + w + slope_s * at_s + slope_t * at_t, offset_s=0.0 * grid.opd + slope_s,
                        offset_t=0.0 * grid.opd + slope_t)
    found = lb.analysis.wavefronts(aberrated)
    np.testing.assert_allclose(found.noll[0, 0], amount, atol=1e-8)
    assert found.residual[0, 0] < 2e-8                  # of W along its slope in cells at the rim
    np.testing.assert_allclose(found.fringe[0, 0, [3, 6, 10]], amount[[3, 6, 10]] * np.sqrt([3.0, 8.0, 5.0]), atol=5e-8)
    assert found.rms[0, 0] == pytest.approx(np.hypot(np.hypot(2e-5, 1e-5), 3e-5), rel=0.01)
    r, turn = np.meshgrid(np.linspace(0.0, 1.0, 201), np.linspace(0.0, 2.0 * pi, 361))
    within = of(r * np.cos(turn), r * np.sin(turn))     # no piston or tilt; to second order at the rim
    assert found.peak_to_valley[0, 0] == pytest.approx(within.max() - within.min(), rel=0.02)
    variance = (2.0 * pi * found.rms_waves[0, 0]) ** 2
    # This lens lights its pupil unevenly, and the exponential holds to the second order of the variance
    assert found.strehl[0, 0] == pytest.approx(np.exp(-variance), abs=0.05 * variance)
    assert perfect.strehl[0, 0] == pytest.approx(1.0, abs=1e-9)


def test_a_shifted_film_adds_the_path_of_a_defocused_sphere():
    """W = δ (1 − cos θ) of a perfect lens whose film is δ behind the focus, to second order in δ."""
    stack, shift = hyperbolic(), 1e-3
    grid = of_angles(stack, lb.film_distance(stack, inf) + shift, 0.0)
    p2 = grid.pupil_s**2 + grid.pupil_t**2
    np.testing.assert_allclose(grid.opd[grid.passed], (shift * (1.0 - np.sqrt(1.0 - p2)))[grid.passed], atol=1e-8)
    assert grid.opd[grid.passed].max() > 1.7e-5


def test_fans_hold_rays_of_the_grid_across_the_whole_stop():
    stack = lenses.load("pbrt-dgauss-50mm")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, lb.Film(), 3), 64)
    fans = lb.analysis.ray_fans(grid, 33)
    assert np.abs(fans.offset[:, :, 1, 16]).max() < 1e-9 and np.abs(fans.opd[:, :, 1, 16]).max() < 1e-12
    assert np.abs(fans.transverse[1:, 0] + fans.transverse[1:, 0, :, ::-1]).max() < 1e-9     # sagittal: antisymmetric
    # The axis sees the whole stop, the corner a part of it; the surfaces that end rays are named
    assert fans.passed[0, :, 1, 2:-2].all() and not fans.passed[2, 1, 1].all()
    assert set(np.unique(fans.victim[2, 1, 1])) > {-1}
    # Tangential rays lie on the curve of the grid's middle columns
    t, e = grid.pupil_t[2, 1, :, 31:33].mean(1), grid.offset_t[2, 1, :, 31:33].mean(1)
    passed = grid.passed[2, 1, :, 31:33].all(1)
    inner = fans.passed[2, 1, 1]
    w = np.interp(fans.transverse[2, 1, 1, inner], e[passed][np.argsort(e[passed])], t[passed][np.argsort(e[passed])])
    assert np.isfinite(w).all() and inner.sum() > 8
    slopes = np.diff(fans.opd[0, 1, 1]) / 1e-3
    assert np.abs(slopes + slopes[::-1]).max() < 1e-9


@pytest.mark.parametrize("name", ["dgauss", "cooke"])
def test_axial_fans_land_where_forty_digit_rays_do(name):
    stack, film = lens(name), REFERENCE[name]["film_z"]
    fans = lb.analysis.ray_fans(of_angles(stack, film - stack.length, 0.0), 41)
    for height, landing in zip(fans.heights, fans.transverse[0, 1, 0], strict=True):
        if not np.isfinite(landing) or abs(height) > 0.9:
            continue
        # The axial ray of that landing: at its height on the first surface, found from the stop
        entry = np.linspace(-1.2, 1.2, 2001) * stack.surfaces[0].semi_diameter
        t = lb.trace(stack, np.column_stack([0 * entry, entry, 0 * entry - 9.0]), [0.0, 0.0, 1.0], clip=False,
                     record=True)
        at_stop = t.paths[:, 1 + stack.stop_index, 1] / stack.stop.semi_diameter
        on_film = (t.points + ((film - t.points[:, 2]) / t.directions[:, 2])[:, None] * t.directions)[:, 1]
        good = np.isfinite(at_stop) & (np.abs(at_stop) < 1.1)
        # Rays are aimed from the film's centre, so that their height in the stop is known to the aberration alone
        assert landing == pytest.approx(np.interp(height, at_stop[good], on_film[good]), abs=2e-3)


def test_too_few_rays_or_terms_are_refused():
    with pytest.raises(lb.LensError, match="at least 3"):
        lb.analysis.ray_fans(perfect_grid(32), 2)
    with pytest.raises(lb.LensError, match="at least 4"):
        lb.analysis.wavefronts(perfect_grid(32), 3)
