"""Directions to a sphere that shines, for its soft shadows."""

import numpy as np
import pytest

from lensbench.core.scenery.shading.soft_shadows import sphere_point


@pytest.mark.parametrize("centre", [(300.0, -200.0, 700.0), (-40.0, 30.0, -90.0), (0.0, 0.0, -80.0)])
def test_directions_to_a_sphere_are_unit_and_even_over_its_solid_angle(centre):
    """Points of the unit disk, whose squared radius is even, give cosines that are even from cos θ to 1."""
    q, radius = np.array(centre), 60.0
    distance = np.linalg.norm(q)
    cosine = np.sqrt(1.0 - (radius / distance) ** 2)
    for part in (0.0, 0.1, 0.5, 0.9, 1.0):
        for turn in (0.1, 2.0, 4.5):
            *way, reach, cap = sphere_point.py_func(np.float64, np.sqrt(part) * np.cos(turn),
                                                    np.sqrt(part) * np.sin(turn), *q, radius**2)
            assert np.linalg.norm(way) == pytest.approx(1.0, abs=1e-12)
            assert way @ q / distance == pytest.approx(1.0 - part * (1.0 - cosine), abs=1e-12)
            assert cap == pytest.approx(1.0 - cosine, rel=1e-12)
            assert reach == pytest.approx(distance * cosine, rel=1e-12)
