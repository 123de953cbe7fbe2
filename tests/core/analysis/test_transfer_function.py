"""MTF against closed forms, Hopkins's defocus, the rays alone, and its own map over field and focus."""

from dataclasses import replace
from math import acos, inf, pi, sin, sqrt

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.focus_map import best_places
from lensbench.core.analysis.transfer_function import neighbours_apart, pupil_functions
from lensbench.core.optics.finding import Kind
from tests.core.analysis.test_wavefront import perfect_grid

NA = 0.2
LINE = 1e-3 * lb.D_LINE
CUTOFF = 2.0 * NA / LINE


def pupil_of(shape, pupil=64, opd=lambda s, t: 0.0 * s, slopes=lambda s, t: (0.0 * s, 0.0 * s)):
    """A grid with an evenly lit pupil of NA 0.2: shape(s, t) is negative inside, in pupil coordinates over NA."""
    grid = perfect_grid(pupil)
    at = 1.05 * NA * ((np.arange(pupil) + 0.5) / pupil * 2.0 - 1.0)
    s, t = np.meshgrid(at, at)
    fine = 1.05 * ((np.arange(32 * pupil) + 0.5) / (32 * pupil) * 2.0 - 1.0)
    inside = shape(*np.meshgrid(fine, fine)) < 0.0
    cover = inside.reshape(pupil, 32, pupil, 32).mean((1, 3))[None, None]
    e = slopes(s, t)
    return replace(grid, pupil=np.stack([at, at])[None], pupil_s=s[None, None], pupil_t=t[None, None], coverage=cover,
                   weight=cover, open_centre=np.zeros((2, *cover.shape)), intensity=np.ones((1, pupil, pupil)),
                   chief_pupil=np.zeros((1, 2)), opd=opd(s, t)[None, None] + 0.0 * cover,
                   offset_s=e[0][None, None], offset_t=e[1][None, None], slope_s=s[None, None], slope_t=t[None, None],
                   victim=np.where(cover > 0.0, -1, 0))


def circle(s, t):
    return np.hypot(s, t) - 1.0


def overlap(r, other, d):
    """Area that two circles share at the distance d."""
    if d >= r + other:
        return 0.0
    if d <= abs(r - other):
        return pi * min(r, other) ** 2
    a, b = acos((d * d + r * r - other * other) / (2 * d * r)), acos((d * d + other * other - r * r) / (2 * d * other))
    return r * r * (a - 0.5 * sin(2 * a)) + other * other * (b - 0.5 * sin(2 * b))


def annulus_mtf(nu, inner):
    d = 2.0 * nu / CUTOFF
    return (overlap(1.0, 1.0, d) - 2.0 * overlap(1.0, inner, d) + overlap(inner, inner, d)) / (pi * (1.0 - inner**2))


@pytest.mark.parametrize(("shape", "closed"), [
    (circle, lambda nu: annulus_mtf(nu, 0.0) if nu < CUTOFF else 0.0),
    (lambda s, t: np.maximum(circle(s, t), 0.5 - np.hypot(s, t)), lambda nu: annulus_mtf(nu, 0.5)),
    (lambda s, t: np.maximum(np.abs(s), np.abs(t)) - 1.0, lambda nu: max(0.0, 1.0 - nu / CUTOFF)),
], ids=["circle", "annulus", "square"])
def test_the_mtf_of_perfect_pupils_has_its_closed_form(shape, closed):
    nu = np.array([0.0, 1.0, 10.0, 40.0, 0.1 * CUTOFF, 0.37 * CUTOFF, 0.8 * CUTOFF, 0.95 * CUTOFF, 1.1 * CUTOFF])
    found = lb.analysis.mtf(pupil_of(shape), nu)
    expected = [closed(each) for each in nu]
    for a in (0, 1):
        np.testing.assert_allclose(found.modulus[0, 0, a], expected, atol=1e-3)
        np.testing.assert_allclose(found.limit[0, 0, a], expected, atol=1e-3)


@pytest.mark.parametrize("waves", [0.25, 0.5, 1.0, 2.0])
def test_the_mtf_of_a_defocused_perfect_lens_is_hopkins_integral(waves):
    """4/(π a) ∫ cos(a x / 2 · …): the overlap of two circles under a linear phase, integrated by quadrature."""
    w20 = waves * LINE

    def slopes(s, t):
        return 2.0 * w20 * s / NA**2, 2.0 * w20 * t / NA**2

    grid = pupil_of(circle, opd=lambda s, t: w20 * (s * s + t * t) / NA**2, slopes=slopes)
    nu = np.array([0.05, 0.2, 0.4, 0.6]) * CUTOFF
    node, weight = np.polynomial.legendre.leggauss(400)
    expected = []
    for each in nu:
        half = each / CUTOFF                            # half the shift, in pupil radii
        x = node * (1.0 - half)
        height = 2.0 * np.sqrt(1.0 - (np.abs(x) + half) ** 2)
        expected.append((weight * (1.0 - half) * height * np.cos(8.0 * pi * waves * half * x)).sum() / pi)
    np.testing.assert_allclose(lb.analysis.mtf(grid, nu).otf[0, 0, 1].real, expected, atol=2e-3)


def test_the_map_equals_the_mtf_of_a_film_at_each_place():
    stack = lenses.load("lib-tronnier-1953")
    away = lb.film_distance(stack, inf)
    given = lb.analysis.conditions(stack, lb.Film())
    shifts = np.linspace(-0.2, 0.2, 5)
    found = lb.analysis.mtf_map(stack, away, given, 20.0, shifts, fields=3)
    for k, shift in enumerate(shifts):
        single = lb.analysis.mtf(found.rays, [20.0], shift=shift)
        np.testing.assert_allclose(found.modulus[..., k], single.modulus[..., 0], atol=1e-3)
        np.testing.assert_allclose(found.white[..., k], single.white_modulus[..., 0], atol=1e-3)
    # The shifted film itself, traced anew: other cells of the pupil, about other reference points
    there = lb.analysis.mtf_map(stack, away + 0.2, given, 20.0, [-0.2, 0.0, 0.2], fields=3)
    np.testing.assert_allclose(there.white[..., 1], found.white[..., 4], atol=0.02)


def test_the_best_focus_of_the_map_curves_as_the_lens_does():
    stack = lenses.load("lib-tronnier-1953")
    stack = lb.stopped_down(stack, 8.0)
    away = lb.film_distance(stack, inf)
    given = lb.analysis.conditions(stack, None, [0.0, 8.0])
    found = lb.analysis.mtf_map(stack, away, given, 40.0, np.linspace(-0.6, 0.6, 61), fields=3)
    curves = lb.analysis.field_curves(stack, away, given, 3)
    # Stopped down, the best place is near the paraxial foci about the chief ray; the mean of the colours
    for a, foci in ((0, curves.sagittal), (1, curves.tangential)):
        np.testing.assert_allclose(found.best_shifts[:, a] - found.best_shifts[0, a],
                                   foci.mean(1) - foci.mean(1)[0], atol=0.06)
    # The best mean of both is the highest of the map to half a step, and lies between the best of each
    highest = found.shifts[found.white.mean(1).argmax(-1)]
    assert np.abs(found.best_mean_shifts - highest).max() <= 0.5 * (found.shifts[1] - found.shifts[0])
    low, high = np.sort(found.best_shifts, axis=1).T
    assert (low - 0.01 < found.best_mean_shifts).all() and (found.best_mean_shifts < high + 0.01).all()


def test_diffraction_turns_into_the_rays_alone_where_the_blur_is_large():
    """Far from focus and at low frequencies the wave adds nothing: both agree, the better the larger the blur."""
    stack = lenses.load("lib-tronnier-1953")
    given = lb.analysis.conditions(stack, None, [0.0, 15.0], [lb.D_LINE])
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf) + 1.0, given, 64)
    nu = np.linspace(0.2, 6.0, 12)
    wave, rays = (lb.analysis.mtf(grid, nu, method).modulus for method in ("diffraction", "geometric"))
    np.testing.assert_allclose(wave, rays, atol=0.015)
    assert wave.min() < 0.15
    near = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), given, 64)
    far = np.linspace(200.0, 400.0, 3)
    assert np.abs(lb.analysis.mtf(near, far).modulus - lb.analysis.mtf(near, far, "geometric").modulus).max() > 0.02


def test_white_light_and_the_limit():
    stack = lenses.load("lib-tronnier-1953")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, lb.Film(), 4), 32)
    found = lb.analysis.mtf(grid, [0.0, 10.0, 40.0])
    np.testing.assert_allclose(found.white_modulus[..., 0], 1.0, atol=1e-9)
    assert (found.white_modulus <= found.white_limit + 1e-3).all()
    assert (found.white_modulus <= np.average(found.modulus, 1, (1, 1, 1)) + 0.01).all()     # phases only take away
    f_number = lb.working_f_number(stack, grid.film_distance)
    x = 40.0 * LINE * f_number
    assert found.limit[0, 1, 0, 2] == pytest.approx(2.0 / pi * (acos(x) - x * sqrt(1.0 - x * x)), abs=2e-3)


def test_samples_that_do_not_suffice_are_said():
    stack = lenses.load("pbrt-dgauss-50mm")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf) + 2.0, lb.analysis.conditions(stack, lb.Film(), 2))
    assert [finding.kind for finding in lb.analysis.mtf(grid, [60.0]).findings] == [Kind.SAMPLING]
    assert not lb.analysis.mtf(grid, [2.0]).findings


def test_cells_beyond_the_rim_continue_the_slope_of_their_neighbours():
    """A plane of W continues as itself to either side, above and below."""
    a, b = 3.0 * LINE / NA, -2.0 * LINE / NA
    grid = pupil_of(circle, opd=lambda s, t: a * s + b * t, slopes=lambda s, t: (a + 0.0 * s, b + 0.0 * t))
    strip = np.arange(grid.opd.shape[-1]) % 3 == 1              # with known neighbours on two sides alone
    for holes in (strip, strip[:, None], strip & strip[:, None]):
        found = pupil_functions(replace(grid, opd=np.where(holes, np.nan, grid.opd)))
        np.testing.assert_allclose(found, pupil_functions(grid), atol=1e-9)


@pytest.mark.parametrize(("call", "message"), [
    (lambda grid: lb.analysis.mtf(grid, [-1.0]), "negative"),
    (lambda grid: lb.analysis.mtf(grid, [1.0], "wave"), "diffraction, geometric"),
    (lambda grid: lb.analysis.mtf_map(grid.lens, grid.film_distance, grid.conditions, 0.0), "positive"),
    (lambda grid: lb.analysis.mtf_map(grid.lens, grid.film_distance, grid.conditions, 9.0, [0.0, 1.0]), "even steps"),
    (lambda grid: lb.analysis.mtf_map(grid.lens, grid.film_distance, grid.conditions, 9.0, [0.0] * 3), "even steps"),
    (lambda grid: lb.analysis.mtf(grid, [1.0], shift=np.nan), "finite"),
    (lambda grid: lb.analysis.mtf(grid, [1.0], "geometric", shift=np.inf), "finite"),
    (lambda grid: lb.analysis.mtf_map(grid.lens, grid.film_distance, grid.conditions, fields=1), "at least 2"),
])
def test_impossible_demands_are_refused(call, message):
    with pytest.raises(lb.LensError, match=message):
        call(perfect_grid(32))


def test_the_best_place_of_a_parabola_is_its_vertex():
    """None at the ends of the range, where a better place may lie beyond, and none of what is not known."""
    shifts = np.linspace(-0.3, 0.3, 13)
    vertices = np.linspace(-0.26, 0.26, 40)
    assert best_places(shifts, 0.9 - 2.0 * (shifts - vertices[:, None])**2) == pytest.approx(vertices, abs=1e-12)
    for values in (shifts, -shifts, np.full(13, np.nan)):
        assert np.isnan(best_places(shifts, values))


def test_neighbours_of_a_defocused_point_lie_the_shift_times_a_cell_apart_and_closed_cells_do_not_count():
    pupil = pupil_of(circle, 16)
    closed, step = pupil.victim != -1, 1.05 * NA * 2.0 / 16
    assert neighbours_apart(pupil, 0.3) == pytest.approx([0.3 * step])
    astray = replace(pupil, offset_s=np.where(closed, 1e3, 0.0), offset_t=np.where(closed, 1e3, 0.0))
    assert neighbours_apart(astray, 0.3) == pytest.approx([0.3 * step])
