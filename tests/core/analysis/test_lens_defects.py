"""A ripple against the trace of a lens that has it as an asphere, a plane plate against its closed forms."""

from dataclasses import replace
from math import factorial, inf, pi

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.optics.finding import Kind
from tests.core.analysis.grids.test_ray_grid import hyperbolic, of_angles

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


def test_a_plate_before_a_perfect_lens_has_the_spherical_aberration_of_its_closed_form():
    perfect, thickness, n = hyperbolic(), 3.0, 1.52
    away = lb.film_distance(perfect, inf)
    stacked, behind = lb.analysis.with_sensor_stack(perfect, away, thickness, n)
    rays = of_angles(stacked, behind, 0.0)
    passed = rays.passed[0, 0]
    sine = np.sin(np.arctan(np.hypot(rays.slope_s, rays.slope_t)[0, 0][passed]))
    late = thickness * (1.0 / n - np.sqrt((1.0 - sine**2) / (n * n - sine**2)))
    landed = np.hypot(rays.offset_s, rays.offset_t)[0, 0][passed]
    np.testing.assert_allclose(landed, np.abs(late) * sine / np.sqrt(1.0 - sine**2), rtol=1e-6, atol=1e-10)
    assert landed.max() > 1e-4


def test_the_focus_follows_the_plate_and_the_adapter():
    stacked, behind = lb.analysis.with_sensor_stack(LENS, AWAY, 2.0, 1.5)
    assert lb.film_distance(stacked, inf) == pytest.approx(behind, abs=1e-9)
    first = lb.first_order(stacked)
    assert first.efl == pytest.approx(lb.first_order(LENS).efl)
    _, still = lb.analysis.with_sensor_stack(LENS, AWAY, 2.0, 1.5, refocused=False)
    assert stacked.length + behind == pytest.approx(LENS.length + AWAY + 2.0 / 3.0)
    bare, off = lb.analysis.with_sensor_stack(LENS, AWAY, 0.0, adapter_error=0.05)
    assert bare is LENS and off == pytest.approx(AWAY + 0.05) and still != behind


@pytest.mark.parametrize(("thickness", "index", "adapter", "message"), [
    (-1.0, 1.5, 0.0, "0 or more"), (2.0, 0.9, 0.0, "1 or more"), (400.0, 1.5, 0.0, "no room"),
    (2.0, 1.5, -AWAY, "no room"), (2.0, 1.5, inf, "finite"),
])
def test_plates_that_cannot_be_are_refused(thickness, index, adapter, message):
    with pytest.raises(lb.LensError, match=message):
        lb.analysis.with_sensor_stack(LENS, AWAY, thickness, index, adapter)
