"""Foci of traced beams: near the axis, those of paraxial optics."""

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.traced_focus import beams, focused_plane


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
