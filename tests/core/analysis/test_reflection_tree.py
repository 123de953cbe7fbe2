"""The light budget of a ray: closed forms, energy, and what cannot be followed."""

import math

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.ghost_ranking import light_budget
from tests.core.optics.test_surface_pose import posed

N = 1.5
R = ((N - 1.0) / (N + 1.0)) ** 2
PLATE = lb.Lens((lb.Surface(4.0, 20.0, lb.Glass(N), curvature=0.0), lb.Surface(50.0, 20.0, curvature=0.0)), 0)


def test_a_plate_reflects_the_geometric_series_and_its_budget_is_whole():
    found = light_budget(PLATE, (0.0, 0.0, -5.0), (0.0, 0.0, 1.0), least=1e-12)
    assert found.to_film[0] == pytest.approx((1.0 - R)**2, rel=1e-12)
    assert found.to_film[2] == pytest.approx((1.0 - R)**2 * R**2, rel=1e-12)
    assert sum(found.to_film) == pytest.approx((1.0 - R) / (1.0 + R), abs=1e-9)
    assert found.total == pytest.approx(1.0, abs=1e-12) and found.left < 1e-9


def test_a_tilted_ray_in_a_plate_has_the_geometric_series_of_its_mean_reflectance():
    angle = 0.4
    inside = math.asin(math.sin(angle) / N)
    s = (math.sin(angle - inside) / math.sin(angle + inside))**2
    p = (math.tan(angle - inside) / math.tan(angle + inside))**2
    mean = 0.5 * (s + p)
    found = light_budget(PLATE, (0.0, 0.0, 0.0), (math.sin(angle), 0.0, math.cos(angle)), least=1e-12)
    assert sum(found.to_film) == pytest.approx((1.0 - mean) / (1.0 + mean), abs=1e-9)


def test_every_order_of_a_tilted_plate_adds_up_to_one():
    bent = posed(PLATE, 0, 1, decentre_x=1.0, tilt_x=0.4)
    tilted, upright = (light_budget(lens, origin, ray, least=1e-12) for lens, origin, ray in (
        (bent, (0.0, 0.0, -5.0), (0.0, 0.0, 1.0)), (PLATE, (0.0, 0.0, 0.0), (0.0, math.sin(0.4), math.cos(0.4)))))
    assert tilted.total == pytest.approx(1.0, abs=1e-12)
    assert tilted.to_film == pytest.approx(upright.to_film, rel=1e-9)       # Fresnel knows the angle to the plate alone


def test_every_order_of_a_singlet_adds_up_to_one():
    one = lb.Lens((lb.Surface(6.0, 12.0, lb.Glass(1.7), curvature=0.02), lb.Surface(40.0, 12.0, curvature=-0.03)), 0)
    for ray, coating in (((0.0, 0.1, 1.0), "uncoated"), ((0.3, 0.0, 1.0), "single-layer")):
        found = light_budget(one, (3.0, 2.0, -1.0), ray, coating=coating, least=1e-9)
        assert found.total == pytest.approx(1.0, abs=1e-12) and found.left < 1e-6
    direct = light_budget(one, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)).to_film[0]
    assert direct == pytest.approx(lb.transmission(one), rel=1e-12)


def test_light_that_grazes_a_steep_front_leaves_for_the_scene():
    """Light along the axis that meets a front of radius 10 at a height of 8 mm: Fresnel's formulas."""
    steep = lb.Lens((lb.Surface(8.0, 9.0, lb.Glass(N), curvature=0.1), lb.Surface(50.0, 20.0, curvature=0.0)), 1)
    found = light_budget(steep, (0.0, 8.0, -5.0), (0.0, 0.0, 1.0), least=1e-9)
    angle, inside = math.asin(0.8), math.asin(0.8 / N)
    s, p = ((math.sin(angle - inside) / math.sin(angle + inside))**2,
            (math.tan(angle - inside) / math.tan(angle + inside))**2)
    assert found.to_scene[1] == pytest.approx(0.5 * (s + p), rel=1e-12)
    assert found.total == pytest.approx(1.0, abs=1e-9)


@pytest.mark.slow
def test_a_lens_of_eleven_surfaces_has_a_budget_by_default():
    found = light_budget(lenses.load("pbrt-dgauss-50mm"), (0.0, 5.0, -10.0), (0.0, 0.0, 1.0))
    assert found.total == pytest.approx(1.0, abs=1e-12) and found.left < 2e-3


@pytest.mark.parametrize(("origin", "direction"), [
    ((0.0, 0.0, -10.0), (0.0, 0.0, 0.0)), ((0.0, 0.0, -10.0), (math.nan, 0.0, 1.0)),
    ((0.0, math.inf, -10.0), (0.0, 0.0, 1.0)),
])
def test_a_ray_without_direction_or_place_is_refused(origin, direction):
    with pytest.raises(lb.LensError, match="direction"):
        light_budget(PLATE, origin, direction)
