"""Rays to lights, straight or by way of a ball: their directions and étendue against other solvers and differences."""

import numpy as np
import pytest

from lensbench.core.kernels.block import U0, U1, V0, V1, WEIGHT, B, L, M, N, Step, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.rendering.light_rays import connect_by_ball, light_parameters, trace_by_ball, trace_to_light


@pytest.mark.parametrize("disk", [False, True])
def test_a_straight_ray_joins_its_two_points_and_weighs_their_areas_cosines_and_distance(disk):
    """Étendue: area · cos · area · cos / d². The square fills the disk by rings of equal area."""
    light, right, up = np.array([400.0, 250.0, -3000.0]), np.array([30.0, -4.0, 10.0]), np.array([-5.0, 25.0, 3.0])
    entrance, across = np.array([2.0, 1.0, 0.0]), np.array([[12.0, 1.0, 2.0], [-2.0, 9.0, 1.0]])
    towards = np.array([0.1, 0.2, -np.sqrt(0.95)])
    p = light_parameters([2.0], entrance[None], across[None], towards[None], light[None], right[None], up[None],
                         np.array([disk]), 400.0, [-1.0], np.zeros((1, 6)))
    u0, u1, v0, v1 = np.random.default_rng(6).random((4, B))
    x, y, z, l, m, n, weight = Program([Step(trace_to_light, p, [disk])], np.float64).run(
        {U0: u0, U1: u1, V0: v0, V1: v1}, [X, Y, Z, L, M, N, WEIGHT], B)
    origins, ways = np.column_stack([x, y, z]), np.column_stack([l, m, n])
    np.testing.assert_allclose(
        origins, entrance + (2.0 * u0 - 1.0)[:, None] * across[0] + (2.0 * u1 - 1.0)[:, None] * across[1], atol=1e-9)
    normal = np.cross(right, up)
    t = (light - origins) @ normal / (ways @ normal)
    met = origins + t[:, None] * ways - light
    a, b = np.linalg.lstsq(np.column_stack([right, up]), met.T)[0]
    if disk:
        rings = np.sort(a * a + b * b)
        assert abs(rings - (np.arange(B) + 0.5) / B).max() < 0.08 and abs(np.mean([a, b], 1)).max() < 0.08
    else:
        np.testing.assert_allclose([a, b], [2.0 * v0 - 1.0, 2.0 * v1 - 1.0], atol=1e-9)
    areas = 400.0 * np.linalg.norm(normal) * (np.pi if disk else 4.0)
    np.testing.assert_allclose(weight, areas * abs(ways @ towards) * abs(ways @ normal) / np.linalg.norm(normal) / t**2,
                               rtol=1e-9)


@pytest.mark.parametrize("kind", ["metal", "glass"])
def test_a_ray_by_a_ball_meets_its_point_of_the_light_and_weighs_the_solid_angle_of_its_area(kind):
    """Étendue: the light's and the rectangle's areas × cos × the solid angle for an area, by differences."""
    centre, radius, side = np.array([30.0, -20.0, -1000.0]), 100.0, 1.0 if kind == "metal" else -1.0
    light = np.array([400.0, 250.0, 900.0 if kind == "metal" else -3000.0])
    right, up = np.array([30.0, 0.0, 10.0]), np.array([-5.0, 25.0, 0.0])
    entrance, across = np.array([2.0, 1.0, 0.0]), np.array([[12.0, 0.0, 0.0], [0.0, 9.0, 0.0]])
    ball = np.array([*centre, radius, side])
    start = connect_by_ball(entrance[None], light[None], ball[None])[1][0]
    p = light_parameters([2.0], entrance[None], across[None], np.array([[0.0, 0.0, -1.0]]), light[None], right[None],
                         up[None], np.array([False]), 4.0 * 12.0 * 9.0, [-2.0], np.array([[*ball, start]]))
    u0, u1, v0, v1 = np.random.default_rng(5).random((4, B))
    x, y, z, l, m, n, weight = Program([Step(trace_by_ball, p, [0])], np.float64).run(
        {U0: u0, U1: u1, V0: v0, V1: v1}, [X, Y, Z, L, M, N, WEIGHT], B)
    origins, found = np.column_stack([x, y, z]), np.column_stack([l, m, n])
    points = light + (2.0 * v0 - 1.0)[:, None] * right + (2.0 * v1 - 1.0)[:, None] * up

    def ways(shift=0.0):
        d, _, miss = connect_by_ball(origins, points + shift, np.tile(ball, (B, 1)))
        assert (miss < 0.0).all()
        return d

    np.testing.assert_allclose(found, ways(), atol=1e-9)
    slopes = [(ways(1e-3 * axis) - ways(-1e-3 * axis)) / 2e-3 for axis in (right, up)]
    solid = np.linalg.norm(np.cross(*slopes), axis=1)       # for a quarter of the light, which is 2 × 2 half-axes
    np.testing.assert_allclose(weight, 4.0 * solid * -n * 4.0 * 12.0 * 9.0, rtol=1e-5)
