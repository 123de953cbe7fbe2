"""Depth of field over the field, against the closed form at small apertures and traced blurs at large ones."""

from math import inf

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis import depth_over_field
from lensbench.core.analysis.depth_over_field import _limits
from lensbench.core.optics.depth_of_field import real_circle_of_confusion
from tests.core.oracles import biconvex

LENS = lenses.load("lib-tronnier-1953")


def depth(f_number, focus, limit=0.03, fields=2):
    """The lens, the distance from its first vertex to the film, and its depth of field."""
    lens = lb.stopped_down(LENS, f_number)
    away = lb.film_distance(lens, focus)
    film_z = lens.length + away
    given = lb.analysis.conditions(lens, lb.Film(), fields, [lb.D_LINE], object_distance=focus - film_z)
    return lens, away, lb.analysis.field_depth(lens, away, given, limit)


def test_on_the_axis_both_limits_are_where_traced_points_blur_by_the_limit():
    lens, away, found = depth(4.0, 2000.0)
    film_z = lens.length + away
    ends = np.array([found.near[0], found.far[0], found.best[0]]) + film_z
    blur, _ = real_circle_of_confusion(lens, away, ends)
    np.testing.assert_allclose(blur[:2], found.limit, rtol=0.02)
    assert blur[2] == pytest.approx(found.least[0], rel=0.05) and found.near[0] < found.best[0] < found.far[0]


def test_at_small_apertures_the_limits_are_those_of_the_closed_form():
    lens, away, found = depth(22.0, 3000.0)
    first = lb.first_order(lens)
    near, far = lb.depth_of_field(first.efl, 22.0, 3000.0 - lens.length - away + first.front_principal, 0.03)
    ends = np.array([found.near[0], found.far[0]]) + first.front_principal
    assert ends[0] == pytest.approx(near, rel=0.02)
    assert 1.0 / ends[0] - 1.0 / ends[1] == pytest.approx(1.0 / near - 1.0 / far, rel=0.02)


def test_beyond_the_hyperfocal_distance_the_far_limit_is_infinite():
    assert depth(16.0, 12_000.0)[2].far[0] == inf
    assert depth(16.0, inf)[2].far[0] == inf


def test_a_field_that_is_never_sharp_is_named_and_has_no_limits():
    found = depth(4.0, 2000.0)[2]
    assert found.least[-1] > found.limit and np.isnan(found.near[-1]) and np.isnan(found.far[-1])
    assert any("blurs more than the limit" in str(each) for each in found.findings)


def curved_field():
    """Depth of field of a lens wide open, whose edge is sharpest far beyond the depth of field of the axis."""
    lens = lenses.load("lv-zeiss-planar-t-50f14")
    away = lb.film_distance(lens, 1180.0)
    given = lb.analysis.conditions(lens, lb.Film(), 5, [lb.D_LINE], object_distance=1180.0 - lens.length - away)
    return lb.analysis.field_depth(lens, away, given, 0.03)


def test_the_sharpest_distance_of_soft_fields_lies_between_distances_that_are_blurred_more():
    found, order = curved_field(), np.arange(5)
    lowest = found.blur.argmin(axis=0)
    assert (found.least > found.limit).sum() > 2 and (0 < lowest).all() and (lowest < len(found.distances) - 1).all()
    assert (found.distances[lowest - 1] < found.best).all() and (found.best < found.distances[lowest + 1]).all()
    assert (found.least <= found.blur[lowest, order]).all() and np.ptp(found.best[1:]) > 10.0


def test_a_least_blur_beyond_the_traced_distances_is_not_known(monkeypatch):
    monkeypatch.setattr(depth_over_field, "TRIALS", 1)
    found = curved_field()
    assert np.isnan(found.best[-1]) and any("the blur is least nearer or farther" in str(each)
                                            for each in found.findings)


def test_behind_a_film_before_the_rear_focus_infinity_is_the_sharpest():
    lens = lb.stopped_down(LENS, 8.0)
    found = lb.analysis.field_depth(lens, lb.film_distance(lens, inf) - 0.5, lb.analysis.conditions(
        lens, lb.Film(), 2, [lb.D_LINE]), 0.03)
    assert found.best == pytest.approx([inf, inf])
    assert not any("the blur is least nearer or farther" in str(each) for each in found.findings)


def test_fields_that_are_sharpest_nearer_than_the_depth_of_the_axis_are_found():
    """A single lens images the field on a bowl towards it: behind it the film has nearer objects in focus."""
    lens, focus = biconvex(0.02, 4.0, 1.5, 4.0), 3000.0
    away = lb.film_distance(lens, focus)
    given = lb.analysis.conditions(lens, None, [0.0, 7.2], [lb.D_LINE], object_distance=focus - lens.length - away)
    found = lb.analysis.field_depth(lens, away, given, 0.02)
    lowest = found.blur[:, 1].argmin()
    assert 0 < lowest < len(found.distances) - 1 and found.best[1] < 0.6 * found.best[0]
    assert found.distances[lowest - 1] < found.best[1] < found.distances[lowest + 1]


@pytest.mark.parametrize("vertex", [-0.1, 0.5, 1.2])
def test_the_limits_of_a_squared_blur_that_is_a_parabola_are_its_own(vertex):
    """Also where its vertex lies beyond the first or the last distance that is known; without end at nearness 0."""
    nearness = np.linspace(0.0, 1.0, 11)
    near, far, best, least = _limits(nearness, np.sqrt((nearness - vertex) ** 2 + 1e-4), 0.3)
    half = np.sqrt(0.3**2 - 1e-4)
    assert best == pytest.approx(np.clip(vertex, 0.0, 1.0), abs=1e-9)
    assert least == pytest.approx(np.hypot(best - vertex, 0.01), rel=1e-6)
    assert near == pytest.approx(vertex + half if vertex + half < 1.0 else np.nan, rel=1e-6, nan_ok=True)
    assert far == pytest.approx(max(vertex - half, 0.0), rel=1e-6)


def test_impossible_limits_and_fields_are_refused():
    angles = lb.analysis.conditions(LENS, None, [0.0], field_kind=lb.FieldKind.ANGLE)
    away = lb.film_distance(LENS, inf)
    with pytest.raises(lb.LensError, match="positions on the film"):
        lb.analysis.field_depth(LENS, away, angles, 0.03)
    with pytest.raises(lb.LensError, match="positive"):
        lb.analysis.field_depth(LENS, away, lb.analysis.conditions(LENS, lb.Film(), 2), 0.0)
