"""A plane plate before the film against its closed forms."""

from math import inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.analysis.grids.test_ray_grid import hyperbolic, of_angles

LENS = lenses.load("lib-tronnier-1953")
AWAY = lb.film_distance(LENS, inf)


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
