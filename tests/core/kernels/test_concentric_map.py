"""Directions about a normal, by the moments that the cosine law gives them."""

import numpy as np
import pytest

from lensbench.core.kernels.sampling import cosine_direction


def directions(side, normal):
    """Directions about a normal, of the middles of side² parts of the square."""
    places = (np.arange(side) + 0.5) / side
    return np.array([cosine_direction.py_func(np.float64, u, v, *normal) for v in places for u in places])


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.6, 0.0, 0.8), (0.0, -0.8, -0.6),
                                    (0.48, 0.64, 0.6), (-0.64, 0.6, -0.48)])
def test_directions_are_of_length_one_and_lean_on_their_normal_by_the_cosine_law(normal):
    """In proportion to the cosine, the mean direction is 2/3 of the normal n, and that of its square (1 + n nᵀ) / 4."""
    n = np.array(normal)
    found = directions(100, n)
    np.testing.assert_allclose((found**2).sum(1), 1.0, atol=1e-12)
    assert (found @ n > 0.0).all()
    np.testing.assert_allclose(found.mean(0), 2.0 / 3.0 * n, atol=1e-3)
    np.testing.assert_allclose(found.T @ found / len(found), (np.eye(3) + np.outer(n, n)) / 4.0, atol=1e-3)
