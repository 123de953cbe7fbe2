"""Point spread functions: Airy's pattern and its energy, Parseval, the MTF, spots, and the blend of waves and rays."""

from math import inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.optics.finding import Kind
from tests.core.analysis.test_transfer_function import LINE, NA, circle, pupil_of
from tests.core.analysis.test_wavefront import perfect_grid

# Zeros of J1 over π, and the energy within the dark rings (Born and Wolf, 8.5.2)
RINGS = {1.2197: 0.838, 2.2331: 0.910, 3.2383: 0.938}


def test_a_round_perfect_pupil_gives_airys_pattern_and_its_energy():
    spread = lb.analysis.psf(pupil_of(circle), 255, 12.0 * LINE / NA)
    rings = np.array(list(RINGS)) * LINE / (2.0 * NA)
    np.testing.assert_allclose(lb.analysis.encircled_energy(spread, rings)[0, 0], list(RINGS.values()), atol=3e-3)
    x, middle = spread.offsets[0], spread.density[0, 0, 127]
    peak = np.pi * NA**2 / LINE**2
    assert spread.density.max() == pytest.approx(peak, rel=5e-3)
    dark = np.interp(rings, x, middle)
    assert (dark < 2e-3 * peak).all()


def test_the_pattern_holds_all_light_and_its_transform_is_the_mtf():
    """Parseval: the whole plane holds the light of the pupil; and the OTF is the transform of the pattern."""
    w20 = 0.6 * LINE
    grid = pupil_of(circle, opd=lambda s, t: w20 * (s * s + t * t) / NA**2,
                    slopes=lambda s, t: (2.0 * w20 * s / NA**2, 2.0 * w20 * t / NA**2))
    period = LINE / grid.steps[0, 0]                    # a whole period of the discrete transform
    spread = lb.analysis.psf(grid, 192, period, method="diffraction")
    light = (grid.coverage**2).sum() / grid.coverage.sum()      # amplitudes of the cells at the rim
    assert spread.captured[0, 0] == pytest.approx(light, abs=1e-5)
    nu = np.array([50.0, 150.0, 300.0])
    lines, x = spread.line_spread[0, 0, 0], spread.offsets[0]
    otf = np.exp(2j * np.pi * nu[:, None] * x) @ lines * spread.pitch[0]
    np.testing.assert_allclose(otf.real, lb.analysis.mtf(grid, nu).otf[0, 0, 0].real, atol=3e-3)


def test_a_window_beyond_the_period_of_the_samples_shows_one_pattern():
    """The pattern of a sampled pupil repeats; a window for the narrow side of a cut pupil reaches the copies."""
    grid = pupil_of(circle)
    period = LINE / grid.steps[0, 0]
    one, wide = (lb.analysis.psf(grid, 250, part * period, method="diffraction") for part in (1.0, 2.5))
    assert wide.captured[0, 0] == pytest.approx(one.captured[0, 0], rel=2e-3)
    beyond = np.abs(wide.offsets[0]) > 0.5 * period
    assert beyond.sum() > 100 and wide.density[0, 0][beyond].max() == wide.density[0, 0][:, beyond].max() == 0.0


@pytest.mark.parametrize("method", ["diffraction", "geometric"])
def test_the_centroid_is_that_of_the_spot(method):
    stack = lb.stopped_down(lenses.load("lib-tronnier-1953"), 4.0)
    given = lb.analysis.conditions(stack, None, [0.0, 12.0], [lb.D_LINE])
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), given, 64)
    spread, spot = lb.analysis.psf(grid, 128, method=method), lb.analysis.spots(grid, "centroid")
    for f in (0, 1):
        density, x = spread.density[f, 0].astype(float), spread.offsets[f]
        total = density.sum()
        across, up = (density.sum(0) * x).sum() / total, (density.sum(1) * x).sum() / total
        assert np.hypot(across, up) < 0.05 * spot.rms_radius[f, 0, 0] + 0.02 * spot.airy_radius.max()
        if method == "geometric":
            rms = np.sqrt(((density.sum(0) + density.sum(1)) * x**2).sum() / total)
            assert rms == pytest.approx(spot.rms_radius[f, 0, 0], rel=0.03)
            assert spread.captured[f, 0] == pytest.approx(1.0, abs=1e-3)


def test_rays_take_over_far_from_focus_and_the_result_says_so():
    stack = lenses.load("lib-tronnier-1953")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, None, [0.0]), 64)
    closed = lb.analysis.ray_grid(lb.stopped_down(stack, 8.0), grid.film_distance, grid.conditions, 64)
    near = lb.analysis.psf(closed, 64)
    assert (near.diffraction == 1.0).all() and not near.findings
    far = lb.analysis.psf(grid, 64, shift=0.6)
    assert (far.diffraction == 0.0).all() and [finding.kind for finding in far.findings] == [Kind.SAMPLING]
    # An even disk of the defocused cone
    assert far.white[0, 28:36, 28:36].min() > 0.2 * far.white[0].mean() > 0.0
    shifts = np.linspace(0.0, 0.6, 13)
    shares = [lb.analysis.psf(grid, 16, shift=float(shift)).diffraction[0, 1] for shift in shifts]
    assert shares[0] == 1.0 and shares[-1] == 0.0 and (np.diff(shares) <= 1e-12).all()


def test_a_pixel_averages_the_light_and_keeps_it():
    grid = pupil_of(circle)
    window = 20.0 * LINE / NA
    sharp, coarse = (lb.analysis.psf(grid, 128, window, pixel) for pixel in (0.0, 0.1 * window))
    assert coarse.captured[0, 0] == pytest.approx(sharp.captured[0, 0], rel=5e-3)
    side = 0.1 * 128
    middle = sharp.density[0, 0, 64 - 6:64 + 6, 64 - 6:64 + 6].sum() / side**2
    assert coarse.density[0, 0, 63:65, 63:65].mean() == pytest.approx(middle, rel=0.05)


@pytest.mark.parametrize(("call", "message"), [
    (lambda grid: lb.analysis.psf(grid, method="waves"), "auto, diffraction"),
    (lambda grid: lb.analysis.psf(grid, 4), "at least 8"),
    (lambda grid: lb.analysis.psf(grid, 64, -1.0), "positive"),
    (lambda grid: lb.analysis.psf(grid, 64, shift=np.nan), "finite"),
    (lambda grid: lb.analysis.encircled_energy(lb.analysis.psf(grid, 64), [-1e-3]), "negative"),
    (lambda grid: lb.analysis.encircled_energy(lb.analysis.psf(grid, 64), [np.nan]), "negative"),
])
def test_impossible_patterns_are_refused(call, message):
    with pytest.raises(lb.LensError, match=message):
        call(perfect_grid(32))


@pytest.mark.parametrize("samples", [40, 61, 80, 100, 256])
def test_an_even_disk_of_rays_shows_no_grid(samples):
    """Landing points that are linear in the pupil: the density is the same everywhere within the disk."""
    w20 = 40.0 * LINE
    grid = pupil_of(circle, slopes=lambda s, t: (2.0 * w20 * s / NA**2, 2.0 * w20 * t / NA**2))
    spread = lb.analysis.psf(grid, samples, method="geometric")
    x, radius = spread.offsets[0], lb.analysis.spots(grid, "centroid").geo[0, 0, 0]
    inside = spread.density[0, 0][np.hypot(x, x[:, None]) < 0.85 * radius]
    assert inside.std() < 0.008 * inside.mean()
    total, reached = spread.density[0, 0].sum(dtype=float), 2e-4 * radius       # a hundredth of a cell of the pupil
    assert abs((spread.density[0, 0].sum(0, dtype=float) * x).sum() / total) < reached
    assert abs((spread.density[0, 0].sum(1, dtype=float) * x).sum() / total) < reached


def test_a_shift_of_the_film_is_a_film_that_far_behind():
    stack = lb.stopped_down(lenses.load("lib-tronnier-1953"), 4.0)
    given, away = lb.analysis.conditions(stack, None, [0.0, 12.0], [lb.D_LINE]), lb.film_distance(stack, inf)
    rms = []
    for film, shift in ((away, 0.15), (away + 0.15, 0.0)):
        spread = lb.analysis.psf(lb.analysis.ray_grid(stack, film, given, 64), 96, shift=shift, method="geometric",
                                 window=0.2)
        x, density = spread.offsets[:, None, :], spread.density[:, 0].astype(float)
        across, up = density.sum(1), density.sum(2)
        rms.append(np.sqrt(((across + up) * x[:, 0]**2).sum(1) / density.sum((1, 2))))
    assert rms[0] == pytest.approx(rms[1], rel=0.01)
    unshifted = lb.analysis.psf(lb.analysis.ray_grid(stack, away, given, 64), 96, method="geometric")
    assert unshifted.captured[:, 0] == pytest.approx([1.0, 1.0], abs=1e-3)


def test_where_waves_and_rays_share_the_light_none_is_lost():
    stack = lenses.load("lib-tronnier-1953")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(
        stack, None, [0.0], [lb.D_LINE]), 64)
    found = [lb.analysis.psf(grid, 64, shift=float(shift)) for shift in np.linspace(0.0, 0.6, 25)]
    shared = [each for each in found if 0.2 < each.diffraction[0, 0] < 0.8]
    assert shared
    for each in shared:
        assert each.captured[0, 0] == pytest.approx(1.0, abs=0.1)       # 64 samples add up to a few percent
