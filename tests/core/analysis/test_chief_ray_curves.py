"""Curves over the field and on the axis, against 40-digit values, CODE V's listing, single rays and closed forms."""

from math import inf, radians, tan

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.axial_curves import paraxial_focus
from tests.core.analysis.test_aberrations import THIRD_ORDER, coloured
from tests.core.oracles import REFERENCE

# CODE V 10.8's listing of its sample double Gauss: chief ray's height and distortion, by field angle (other indices,
# so that its digits hold to some 1e-3 mm here)
CODEV = {10.0: (-0.4976,), 14.0: (-1.0557,)}


def by_angle(largest, **more):
    return lb.analysis.Conditions(lb.FieldKind.ANGLE, ((0.0, largest),), (lb.F_LINE, lb.D_LINE, lb.C_LINE), **more)


@pytest.mark.parametrize("name", ["cooke", "codev"])
def test_foci_and_heights_over_the_field_agree_with_forty_digits(name):
    stack, film = coloured(name), REFERENCE[name]["film_z"]
    for degrees, (tangential, sagittal, _, image) in THIRD_ORDER[name]["foci"].items():
        if float(degrees) == 0.0:
            continue
        found = lb.analysis.field_curves(stack, film - stack.length, by_angle(float(degrees)), 3)
        assert found.heights[-1] == pytest.approx(image, abs=1e-11)
        assert found.tangential[-1, 1] == pytest.approx(tangential, abs=1e-9)
        assert found.sagittal[-1, 1] == pytest.approx(sagittal, abs=1e-9)
        # The paraxial chief ray, from the entrance pupil, on the film beside the focus
        fo = lb.first_order(stack)
        beside = (fo.entrance_pupil.z - fo.ffl) * (film - stack.length - fo.bfl) / fo.efl
        ideal = (fo.efl + beside) * tan(radians(float(degrees)))
        assert found.distortion[-1] == pytest.approx(100.0 * (image / ideal - 1.0), abs=1e-9)
        if name == "codev":
            assert found.distortion[-1] == pytest.approx(CODEV[float(degrees)][0], abs=5e-3)
        # Lateral colour is the difference of the chief rays of two wavelengths
        blue = lb.chief_ray(stack, radians(float(degrees)), lb.F_LINE)
        on_film = blue.points[-1] + (film - blue.points[-1, 2]) / blue.direction[2] * blue.direction
        assert found.lateral_colour[-1, 0] == pytest.approx(on_film[1] - image, abs=1e-11)


def test_foci_of_a_near_object_are_where_close_rays_meet():
    stack = lenses.load("pbrt-dgauss-50mm")
    distance = 600.0
    away = lb.film_distance(stack, distance + stack.length + 40.0)
    found = lb.analysis.field_curves(stack, away, lb.analysis.conditions(stack, None, [0.0, 12.0], [lb.D_LINE],
                                                                         object_distance=distance), 3)
    grid = lb.analysis.ray_grid(stack, away, lb.analysis.conditions(stack, None, found.heights[2:], [lb.D_LINE],
                                                                    object_distance=distance), 64)
    # Offsets of rays near the chief ray are −focus × change of slope, to first order
    s, t = grid.pupil_s[0, 0], grid.pupil_t[0, 0] - grid.chief_pupil[0, 1]
    close = np.hypot(s, t) < 0.03
    for offset, slope, focus in ((grid.offset_s, grid.slope_s, found.sagittal), (grid.offset_t, grid.slope_t,
                                                                                found.tangential)):
        e, m = offset[0, 0][close], slope[0, 0][close]
        quadratic = np.column_stack([m, np.ones(len(m)), s[close]**2, s[close] * t[close], t[close]**2])
        # The slope of the fit is −focus; terms of third order are left, a part in (0.03 / 0.25)² of those at the rim
        assert -np.linalg.lstsq(quadratic, e, rcond=None)[0][0] == pytest.approx(focus[2, 0], abs=0.01)


@pytest.mark.parametrize("distance", [inf, 700.0])
def test_a_film_beside_the_paraxial_focus_has_another_scale_and_no_distortion_for_it(distance):
    stack = lenses.load("lib-tronnier-1953")
    away = lb.film_distance(stack, distance if distance == inf else distance + stack.length + 40.0) - 0.3
    given = lb.analysis.conditions(stack, None, [0.0, 15.0], [lb.D_LINE], object_distance=distance)
    found = lb.analysis.field_curves(stack, away, given, 301)
    assert abs(found.distortion[1]) < 1e-3 and found.distortion[0] == 0.0
    if distance == inf:
        np.testing.assert_allclose(found.distortion[100:], lb.distortion(stack, away, found.heights[100:]).percent,
                                   atol=1e-8)


def test_the_petzval_surface_bends_with_its_radius():
    stack = coloured("cooke")
    found = lb.analysis.field_curves(stack, 77.0, by_angle(14.0), 5)
    radius = lb.first_order(stack).petzval_radius
    np.testing.assert_allclose(found.petzval, found.heights**2 / (2.0 * radius))


def test_beyond_the_sight_of_a_lens_curves_end():
    stack = lenses.load("pbrt-fisheye-10mm")
    found = lb.analysis.field_curves(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, lb.Film()))
    assert np.isfinite(found.tangential[:20]).all() and np.isnan(found.tangential[-5:]).all()
    assert np.isfinite(found.f_theta_distortion[:20]).all()


def test_longitudinal_aberration_starts_at_the_paraxial_focus_and_follows_single_rays():
    stack, film = coloured("codev"), REFERENCE["codev"]["film_z"]
    found = lb.analysis.longitudinal_aberration(stack, film - stack.length, by_angle(0.0), 9)
    for c, line in enumerate((lb.F_LINE, lb.D_LINE, lb.C_LINE)):
        assert found.foci[c, 0] == pytest.approx(lb.first_order(stack, line).bfl - (film - stack.length), abs=1e-12)
    entry = np.linspace(0.1, 26.0, 4001)
    t = lb.trace(stack, np.column_stack([0 * entry, entry, 0 * entry]), [0.0, 0.0, 1.0], clip=False, record=True)
    at_stop = t.paths[:, 1 + stack.stop_index, 1] / stack.stop.semi_diameter
    cross = t.points[:, 2] - t.points[:, 1] * t.directions[:, 2] / t.directions[:, 1] - film
    good = np.isfinite(found.foci[1]) & (found.heights > 0.1)
    assert good.sum() > 5
    expected = np.interp(found.heights[good], at_stop, cross)
    np.testing.assert_allclose(found.foci[1][good], expected, atol=0.01 * np.ptp(expected))


def test_an_afocal_lens_images_a_near_object():
    """Two lenses of focal lengths f₁ and f₂, f₁ + f₂ apart, put the object at d at f₂ + (f₂ / f₁)² (f₁ − d) behind."""
    crown = lb.Glass(1.5)
    pair = lb.Lens((lb.Surface(0.0, 10.0, crown, curvature=0.01), lb.Surface(300.0, 10.0, curvature=0.0),
                    lb.Surface(0.0, 10.0, crown, curvature=0.0), lb.Surface(0.0, 10.0, curvature=-0.02)), 0)
    for distance in (200.0, 500.0):
        expected = 100.0 + 0.25 * (200.0 - distance)
        assert paraxial_focus(pair, distance, lb.D_LINE) == pytest.approx(expected, abs=1e-9)


def test_the_chromatic_focal_shift_passes_the_foci_of_the_lines():
    stack = lenses.load("lib-tronnier-1953")
    away = lb.film_distance(stack, inf)
    shift = lb.analysis.chromatic_focal_shift(stack, away, by_angle(0.0), 301)
    for line in (lb.F_LINE, lb.D_LINE, lb.C_LINE):
        assert np.interp(line, shift.wavelengths, shift.foci) == pytest.approx(
            lb.first_order(stack, line).bfl - away, abs=1e-4)


@pytest.mark.parametrize("call", [
    lambda: lb.analysis.field_curves(lenses.load("lentil-schneider-anamorphic-31-2001"), 40.0, by_angle(5.0)),
    lambda: lb.analysis.field_curves(coloured("cooke"), 40.0, by_angle(5.0), 1),
    lambda: lb.analysis.longitudinal_aberration(coloured("cooke"), 40.0, by_angle(5.0), 1),
    lambda: lb.analysis.chromatic_focal_shift(coloured("cooke"), 40.0, by_angle(5.0), 1),
])
def test_curves_that_cannot_be_drawn_are_refused(call):
    with pytest.raises(lb.LensError, match="at least 2|rotationally"):
        call()


def test_foci_of_close_rays_of_the_grid_are_coddingtons():
    stack = lenses.load("lib-tronnier-1953")
    away = lb.film_distance(stack, inf)
    rays = lb.analysis.ray_grid(stack, away, lb.analysis.conditions(stack, lb.Film(), [0.0, 8.0, 15.0]))
    found = lb.analysis.close_foci(rays)
    curves = lb.analysis.field_curves(stack, away, rays.conditions, 401)
    for c in range(3):
        for a, foci in enumerate((curves.sagittal, curves.tangential)):
            wanted = np.interp(rays.image_heights, curves.heights, foci[:, c])
            # Beams of other wavelengths are about the primary chief ray here, not about their own
            np.testing.assert_allclose(found[:, c, a], wanted, rtol=0.0, atol=2e-6 if c == 1 else 4e-4)


def test_a_thin_lens_images_a_near_object_by_its_equation():
    thin = lb.Lens((lb.Surface(0.0, 10.0, lb.Glass(1.5), curvature=0.015), lb.Surface(0.0, 10.0, curvature=-0.005)), 0)
    for distance in (60.0, 150.0, 300.0, 5000.0):
        assert paraxial_focus(thin, distance, lb.D_LINE) == pytest.approx(1.0 / (0.01 - 1.0 / distance), rel=1e-12)
