"""Focus shift, breathing and relative illumination, against third order, single rays and the falloff."""

from dataclasses import replace
from math import atan, inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.axial_curves import axial_rays, on_axis
from lensbench.core.analysis.focus_map import through_focus
from lensbench.core.optics.finding import Kind
from tests.core.oracles import biconvex, of_one_colour

AXIS = lb.analysis.Conditions(lb.FieldKind.ANGLE, ((0.0, 0.0),), (lb.D_LINE,), (1.0,), 0)


def test_the_focus_shifts_as_third_order_aberration_has_it():
    """Least rms blur lies S_I / (3 NA²) before the paraxial focus: W = W040 ρ⁴ + W20 ρ², least at W20 = −4/3 W040."""
    single = biconvex(0.02, 4.0, 1.5, 5.0)
    fo = lb.first_order(single)
    numbers = fo.f_number * np.array([1.0, 1.4, 2.0, 2.8])
    found = lb.analysis.focus_shift(single, fo.bfl, AXIS, numbers)
    for number, place in zip(numbers, found.least_blur, strict=True):
        radius = 0.5 * fo.efl / number
        expected = -lb.seidel(single, 0.0, radius).total[0] / (3.0 * (radius / fo.efl) ** 2)
        # What is left is of the fifth order: 1 / N² of the third
        assert place == pytest.approx(expected, rel=0.6 / number)
    assert found.paraxial == pytest.approx(0.0, abs=1e-12) and (found.shift >= 0.0).all()
    assert found.depth == pytest.approx(0.03 * numbers, rel=0.02)       # of a point that lights its pupil evenly


def test_the_mtf_and_the_blur_agree_about_the_focus_of_small_aberrations():
    stack = lb.stopped_down(lenses.load("lib-tronnier-1953"), 8.0)
    found = lb.analysis.focus_shift(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack), [8.0, 11.0])
    assert (np.abs(found.best_mtf - found.least_blur) < 0.15 * found.depth).all()


def test_blades_shift_the_focus_as_a_round_stop_of_their_area():
    """Corners of straight blades reach farther out: their mean of r⁴ over that of r² is 2 % above that of the disc."""
    plain = biconvex(0.02, 4.0, 1.5, 5.0)
    fo = lb.first_order(plain)
    numbers = fo.f_number * np.array([1.05, 1.2, 1.6])
    round_, bladed = (lb.analysis.focus_shift(replace(plain, blades=count), fo.bfl, AXIS, numbers) for count in (0, 7))
    assert bladed.least_blur == pytest.approx(round_.least_blur, rel=0.03)
    assert bladed.depth == pytest.approx(round_.depth, rel=0.03)


def test_a_lens_focused_as_a_whole_breathes_with_its_extension():
    stack = lenses.load("pbrt-dgauss-50mm")
    film, distances = lb.Film(), [inf, 3000.0, 1000.0]
    found = lb.analysis.breathing(stack, film, distances)
    assert found.change[0] == 0.0 and (np.diff(found.change) < 0.0).all()
    for distance, half_angle in zip(distances, found.half_angles, strict=True):
        away = lb.film_distance(stack, distance)
        chief = lb.chief_ray(stack, float(half_angle))
        at = chief.points[-1] + (stack.length + away - chief.points[-1, 2]) / chief.direction[2] * chief.direction
        assert at[1] == pytest.approx(0.5 * film.diagonal, abs=1e-9)
    assert found.half_angles[0] == pytest.approx(atan(0.5 * film.diagonal / 50.0), abs=0.03)
    refused = lb.analysis.breathing(stack, film, [inf, 50.0])
    assert np.isnan(refused.half_angles[1]) and [each.kind for each in refused.findings] == [Kind.FIELD]


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm"])
def test_the_magnification_is_that_of_a_small_object_in_the_plane_in_focus(name):
    """A ray from its tip, 1e-4 of its distance from the axis, ends on the film as high as its image."""
    stack = lenses.load(name)
    found = lb.analysis.breathing(stack, lb.Film(), [inf, 3000.0, 700.0])
    assert found.magnifications[0] == pytest.approx(0.0, abs=1e-12)
    for distance, magnification in zip(found.distances[1:], found.magnifications[1:], strict=True):
        away = lb.film_distance(stack, distance)
        tip = np.array([0.0, 1e-4 * distance, stack.length + away - distance])
        t = lb.trace(stack, tip, -tip, clip=False)
        at = t.points[0] + (stack.length + away - t.points[0, 2]) / t.directions[0, 2] * t.directions[0]
        assert -at[1] / tip[1] == pytest.approx(magnification, rel=1e-4)


@pytest.mark.parametrize("name", ["lib-tronnier-1953", "lv-minolta-af-100mm-f28-macro"])
def test_a_film_that_is_focused_for_another_colour_stays_where_that_lens_has_it(name):
    """Groups and film are those of the lens of that colour; focal length and view those of this one."""
    stack, film = lenses.load(name), lb.Film()
    red = of_one_colour(stack, 0.9)
    found = lb.analysis.breathing(stack, film, [inf, 900.0], lb.D_LINE, focusing=red)
    for i, distance in enumerate(found.distances.tolist()):
        there = lb.focused(red, distance)
        away = lb.film_distance(there, distance)
        moved = stack.at(close=there.positions.close) if stack.has_focus_groups else stack
        assert found.focal_lengths[i] == pytest.approx(lb.first_order(moved).efl, rel=1e-12)
        assert found.magnifications[i] == pytest.approx(lb.magnification(moved, away, distance), rel=1e-12)
        chief = lb.chief_ray(moved, float(found.half_angles[i]))
        at = chief.points[-1] + (moved.length + away - chief.points[-1, 2]) / chief.direction[2] * chief.direction
        assert at[1] == pytest.approx(0.5 * film.diagonal, abs=1e-8)
    if stack.has_focus_groups:
        nearest = lb.analysis.breathing(stack, film, wavelength=lb.D_LINE, focusing=red).distances[-1]
        assert nearest == pytest.approx(lb.nearest_focus(red), rel=1e-8)
        assert nearest != pytest.approx(lb.nearest_focus(stack), rel=1e-6)


def test_the_view_of_a_lens_with_cylinders_ends_at_the_corner_of_the_film():
    """A small film against the focal lengths of both sections, and Newton's equation for the section y–z."""
    stack = lenses.load("lentil-schneider-anamorphic-31-2001")
    across, up = (lb.first_order(stack.section(axis)) for axis in ("x", "y"))
    found = lb.analysis.breathing(stack, lb.Film(0.2, 0.15), [inf, 3000.0, 1500.0])
    expected = atan(np.hypot(0.1 / across.efl, 0.075 / up.efl))
    # The film lies between the two foci
    assert found.half_angles[0] == pytest.approx(expected, rel=5e-3) and expected > 1.5 * atan(0.125 / up.efl)
    assert (np.diff(found.change) < 0.0).all() and found.magnifications[0] == 0.0
    for distance, magnification in zip(found.distances[1:], found.magnifications[1:], strict=True):
        before = distance - lb.film_distance(stack, distance) - stack.length
        assert magnification == pytest.approx(up.efl / (before + up.ffl), rel=1e-9)


def test_relative_illumination_flattens_as_vignetting_ends():
    stack = lenses.load("pbrt-dgauss-50mm")
    found = lb.analysis.relative_illumination(stack, lb.film_distance(stack, inf), lb.Film(), [2.0, 2.8, 4.0, 5.6])
    assert [words for words, _ in found] == ["f/2", "f/2.8", "f/4", "f/5.6"]
    corner = [falloff.vignetting[-1] for _, falloff in found]
    assert (np.diff(corner) > 0.0).all() and corner[0] < 0.5
    for _, falloff in found:
        np.testing.assert_allclose(falloff.total, falloff.natural * falloff.vignetting)
        assert falloff.radii[0] == 0.0 and falloff.radii[-1] == pytest.approx(np.hypot(18.0, 12.0))     # the corner


def test_the_view_and_the_falloff_of_a_colour_are_those_of_a_lens_of_this_colour():
    stack, film = lb.stopped_down(lenses.load("lib-tronnier-1953"), 4.0), lb.Film()
    for distance in (inf, 2000.0):
        blue = lb.analysis.breathing(stack, film, [distance], 0.4358, focusing=stack)
        away, one = lb.film_distance(stack, distance), of_one_colour(stack, 0.4358)
        assert blue.focal_lengths[0] == pytest.approx(lb.first_order(one).efl, rel=1e-12)
        assert blue.focal_lengths[0] != pytest.approx(lb.first_order(stack).efl, rel=1e-5)
        if distance < inf:
            assert blue.magnifications[0] == pytest.approx(lb.magnification(one, away, distance), rel=1e-12)
            assert blue.magnifications[0] != pytest.approx(lb.magnification(stack, away, distance), rel=1e-5)
        chief = lb.chief_ray(one, float(blue.half_angles[0]))
        at = chief.points[-1] + (one.length + away - chief.points[-1, 2]) / chief.direction[2] * chief.direction
        assert at[1] == pytest.approx(0.5 * film.diagonal, abs=1e-8)
    away = lb.film_distance(stack, inf)
    (_, blue), = lb.analysis.relative_illumination(stack, away, film, [4.0], 5, 0.4358)
    one, yellow = (lb.falloff(it, away, blue.radii) for it in (of_one_colour(stack, 0.4358), stack))
    np.testing.assert_allclose(blue.natural, one.natural, rtol=1e-9)
    np.testing.assert_allclose(blue.vignetting, one.vignetting, rtol=1e-9)
    assert np.abs(blue.natural / yellow.natural - 1.0).max() > 1e-6


def test_an_afocal_lens_has_no_focus_to_shift():
    plate = lb.Lens((lb.Surface(5.0, 8.0, lb.Glass(1.5), curvature=0.0), lb.Surface(0.0, 8.0, curvature=0.0)), 0)
    with pytest.raises(lb.LensError, match="afocal"):
        lb.analysis.focus_shift(plate, 30.0, AXIS)


@pytest.mark.parametrize("distance", [inf, 200.0])
def test_one_fan_gives_the_grids_of_all_smaller_stops(distance):
    """The rays of a meridian and a quarter of two round pupils give what the grid's rays and cells give."""
    stack = lenses.load("pbrt-dgauss-50mm")
    away = lb.film_distance(stack, distance) + 0.3
    conditions = lb.analysis.conditions(stack, object_distance=distance - away - stack.length)
    wide = axial_rays(stack, away, conditions, np.linspace(0.0, 1.03, 97))
    places, weights = np.linspace(-0.5, 0.1, 7), np.array(conditions.weights)
    for number in (2.8, 8.0):
        stopped = lb.stopped_down(stack, number)
        share = stopped.stop.semi_diameter / stack.stop.semi_diameter
        assert wide.pass_within(share)
        beams = wide.within(share)
        rays = lb.analysis.ray_grid(stopped, away, on_axis(conditions), 96)
        expected = through_focus(rays, 30.0, places)[0]
        found = np.stack([beam.through_focus(30.0, places) for beam in beams])
        # Cells at the round rim leave 4e-4 of the grid's pupil in doubt
        np.testing.assert_allclose(expected, found[:, None] * np.ones((1, 2, 1)), atol=2e-3)
        part = weights[:, None, None] * rays.weight[0] / rays.weight[0].sum((1, 2), keepdims=True)
        s, t, m_s, m_t = rays.light[:, 0]
        product, square = weights @ np.array([beam.moments() for beam in beams])
        assert square == pytest.approx((part * (m_s**2 + m_t**2)).sum(), rel=3e-4)
        assert product == pytest.approx((part * (s * m_s + t * m_t)).sum(), rel=5e-4)
    assert not wide.pass_within(1.05)


@pytest.mark.parametrize("call", [
    lambda lens, away: lb.analysis.focus_shift(lens, away, AXIS, [2.8], -3.0),
    lambda lens, away: lb.analysis.focus_shift(lens, away, AXIS, [2.8], 30.0, float("nan")),
    lambda lens, away: lb.analysis.relative_illumination(lens, away, lb.Film(), points=1),
    lambda lens, away: lb.analysis.ghosts(lens, away, wavelength=550.0),
    lambda lens, away: lb.analysis.conditions(lens, fields=[(1.0, 2.0, 3.0)]),
])
def test_numbers_that_mean_nothing_are_refused(call):
    stack = lenses.load("pbrt-dgauss-50mm")
    with pytest.raises(lb.LensError, match="positive|at least 2|micrometres|one number"):
        call(stack, lb.film_distance(stack, inf))
