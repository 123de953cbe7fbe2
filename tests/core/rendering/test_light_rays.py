"""Rays to lights by way of a ball: their directions and étendue against a solver of its own and its differences."""

import numpy as np
import pytest

from lensbench.kernels.block import U0, U1, V0, V1, WEIGHT, B, L, M, N, Step, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.rendering.light_rays import light_parameters, trace_by_ball
from lensbench.rendering.specular_connection import connect_by_ball


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
