"""Regions of a film's nodes: outlines around others, and by how much they grow to hold what lies between nodes."""

import numpy as np
import pytest

from lensbench.core.imaging.film import STEEPEST_SIDE, FilmPose
from lensbench.core.pupils.film_grid import POINTS, _hull, _needed_growth, _placement


def test_the_outline_around_points_is_the_polygon_of_their_corners():
    """A square and a turned one, whose normals are among the directions; and a crowd within them changes nothing."""
    turn = 2.0 * np.pi * np.arange(POINTS) / POINTS
    way = np.column_stack([np.cos(turn), np.sin(turn)])
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    crowd = np.random.default_rng(1).uniform(-0.9, 0.9, (50, 2))
    square = way / np.abs(way).max(1)[:, None]
    diamond = way / np.abs(way).sum(1)[:, None]
    for points, wanted in ((corners, square), ((corners + corners[[1, 2, 3, 0]]) / 2.0, diamond)):
        np.testing.assert_allclose(_hull(3.0 * points), 3.0 * wanted, atol=1e-12)
    np.testing.assert_allclose(_hull(np.concatenate([corners, crowd])), square, atol=1e-12)


def test_grown_polygons_hold_the_rims_and_grow_no_more_than_some_rim_needs():
    """Each rim point lies within the triangle of its direction; corners grow only where a chord beside them must."""
    random = np.random.default_rng(2)
    corners, points = 25, 64
    turn = 2.0 * np.pi * np.arange(corners) / (corners - 1)
    polygon = np.column_stack([np.cos(turn), np.sin(turn)])
    along = 2.0 * np.pi * (np.arange(points) + 0.3) / points
    rims = (random.uniform(0.6, 1.5, (2, 3, points))[..., None]
            * np.column_stack([np.cos(along), np.sin(along)]))
    offsets = random.normal(0.0, 0.05, (2, 3, 2))
    factors = _needed_growth(np.broadcast_to(polygon, (2, 3, corners, 2)).copy(), rims, offsets)
    assert (factors >= 1.0).all() and (factors[..., 0] == factors[..., -1]).all()
    place = rims + offsets[:, :, None]
    # each point as a combination of the corners of its sector: outside by the sum of its parts
    k = np.floor(np.mod(np.arctan2(place[..., 1], place[..., 0]), 2.0 * np.pi) / turn[1]).astype(int)
    parts = np.linalg.solve(np.stack([polygon[k], polygon[k + 1]], -1), place[..., None])[..., 0]
    assert (parts > -1e-9).all()
    needed = np.maximum(parts.sum(-1), 1.0)
    own = np.ones((2, 3, corners))
    for node in np.ndindex(2, 3):
        for end in (k[node], k[node] + 1):
            np.maximum.at(own[node], end, needed[node])
    own[..., 0] = own[..., -1] = np.maximum(own[..., 0], own[..., -1])
    np.testing.assert_allclose(factors, own, rtol=1e-9)


@pytest.mark.parametrize("radius", [-60.0, 45.0])
def test_beside_the_sphere_of_a_curved_film_points_are_as_deep_as_its_side(radius):
    place = _placement(FilmPose(radius=radius), -1e9)
    turn, r = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 200), np.linspace(1e-3, 100.0, 200)
    points = place(np.column_stack([r * np.cos(turn), r * np.sin(turn)]))
    np.testing.assert_allclose(points[:, :2], np.column_stack([r * np.cos(turn), r * np.sin(turn)]), atol=1e-12)
    high = np.minimum(r, STEEPEST_SIDE * abs(radius))
    # on the sphere about (0, 0, radius)
    np.testing.assert_allclose(points[:, 2], radius - np.sign(radius) * np.sqrt(radius**2 - high**2), atol=1e-12)
