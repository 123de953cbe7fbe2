"""Planes of sharp focus: their geometry, whatever the length and sign of the normal that they are made of."""

import numpy as np
import pytest

from lensbench.analysis.focus_wedge import Plane


@pytest.mark.parametrize("size", [1.0, -1.0, 0.02, -30.0])
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.3, -0.5, 0.8), (0.0, 1.0, 0.0), (-0.4, 0.0, 0.0)])
def test_distances_from_a_plane_are_those_along_its_unit_normal_towards_the_camera_or_up(normal, size):
    unit = np.array(normal) / np.linalg.norm(normal)
    unit *= np.sign(unit[2] or unit[1] or unit[0])
    plane = Plane.facing(size * np.array(normal), size * 70.0)
    assert np.linalg.norm(plane.normal) == pytest.approx(1.0, rel=1e-12)
    foot = np.array(normal) * 70.0 / np.dot(normal, normal)          # normal · foot = 70
    across = np.cross(unit, [0.6, 0.5, 0.3])
    away = np.array([-900.0, 0.0, 3.0])
    np.testing.assert_allclose(plane.distance(foot + 40.0 * across + away[:, None] * unit), away, atol=1e-9)
