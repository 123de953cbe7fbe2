"""Rough rims of regions: their centroids, and points evenly spaced along them."""

import numpy as np
import pytest

from lensbench.core.pupils.rim_solver import _centroids, _directions

TURN = np.linspace(0.0, np.pi, 81)              # of the upper half, from +x on; the lower is its mirror image


def circle(aside):
    """Distances of the rim of a circle of radius 1 from a point of the x axis that lies so far from its centre."""
    return aside * -np.cos(TURN) + np.sqrt(1.0 - (aside * np.sin(TURN)) ** 2)


def test_the_centroid_of_a_circle_is_its_centre_from_wherever_it_is_seen():
    places = np.array([0.0, 0.3, -0.6])
    rough = np.array([circle(place) for place in places])
    np.testing.assert_allclose(_centroids(5.0 + places, rough, np.cos(TURN), np.sin(TURN)), 5.0, atol=1e-3)


@pytest.mark.parametrize("moved", [0.0, -0.3, 0.45])
def test_points_along_a_rim_are_evenly_spaced_from_one_end_to_the_other(moved):
    points = 33
    rough = np.array([circle(-0.2), 0.5 + 0.4 * np.cos(TURN) ** 2])
    cosine, sine, guess = np.zeros((3, 2, points))
    _directions(np.full(2, moved), rough, np.cos(TURN), np.sin(TURN), 1e-9, cosine, sine, guess)
    for k in (0, 1):
        rim = np.stack([rough[k] * np.cos(TURN), rough[k] * np.sin(TURN)], 1)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rim, axis=0).T))])
        wanted = np.stack([np.interp(np.linspace(0.0, along[-1], points), along, each) for each in rim.T], 1)
        found = np.stack([guess[k] * cosine[k], guess[k] * sine[k]], 1) + (moved, 0.0)
        np.testing.assert_allclose(found, wanted, atol=1e-9)
