"""Foci of traced beams: near the axis, those of paraxial optics."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.focus_wedge import beams, focused_plane


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-telephoto-250mm"])
@pytest.mark.parametrize("distance", [2500.0, 12000.0])
def test_narrow_beams_near_the_axis_have_their_focus_in_the_plane_in_focus(name, distance):
    stack = lenses.load(name)
    away = lb.film_distance(stack, distance)
    film = 1e-3 * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    found = beams(stack, away, film)
    assert found.depth_nearness == pytest.approx(1.0 / distance, rel=1e-5)
    *normal, offset = focused_plane(stack, away, film)
    assert np.array(normal) / normal[2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-2)
    assert offset / normal[2] == pytest.approx(distance, rel=1e-3)


@pytest.mark.parametrize("f_number", [8.0, 16.0])
def test_a_whole_beam_leaves_the_lens_evenly_over_the_disc_of_the_entrance_pupil(f_number):
    """Mean squares of a disc of radius R are R² / 4; of its 256 rays a tenth lies beyond the rim."""
    stack, distance = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), f_number), 3000.0
    away = lb.film_distance(stack, distance)
    found, pupil = beams(stack, away, np.zeros((1, 3)), whole=True), lb.first_order(stack).entrance_pupil
    before = distance - away - stack.length
    radius = pupil.radius * before / (before + pupil.z)                 # of the cone where it crosses the first vertex
    assert found.across[0] == pytest.approx(np.diag([1.0, 1.0, 0.0]) * radius**2 / 4.0, abs=0.02 * radius**2 / 4.0)
    assert found.depth_nearness == pytest.approx(1.0 / distance, rel=0.1)


@pytest.mark.parametrize("whole", [False, True])
def test_places_and_slopes_of_a_beam_lie_across_its_middle(whole):
    stack = lenses.load("pbrt-dgauss-50mm")
    found = beams(stack, lb.film_distance(stack, 1000.0), np.array([[4.0, -9.0, 0.0], [0.0, 12.0, 0.0]]), whole=whole)
    for moments in (found.across, found.mixed, found.slopes):
        for each, way in zip(moments, found.directions, strict=True):
            size = np.abs(each).max()
            assert size > 0.0
            np.testing.assert_allclose(each @ way, 0.0, atol=1e-9 * size)
            np.testing.assert_allclose(way @ each, 0.0, atol=1e-9 * size)
