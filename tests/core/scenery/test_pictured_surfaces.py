"""Where rays meet a floor and a ball with a picture, and which line of it they see, stage by stage."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import DEPTH, NX, NY, NZ, RED, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.pictured import pictured_floor_step, pictured_step
from tests.core.scenery.test_scene import unit

LINES = 64
RAMP = lb.Image.of(np.tile(((np.arange(LINES) + 0.5) / LINES)[:, None, None], (1, 4, 3)))


@pytest.mark.parametrize("normal", [(0.0, 1.0, 0.0), (0.3, 0.8, -0.5), (-0.2, 0.1, 0.9)])
def test_rays_meet_a_floor_with_a_picture_in_its_plane_however_it_is_tilted(normal):
    floor, (o, d) = lb.Floor(-200.0, 40.0, normal=normal, image=RAMP), np.random.default_rng(1).normal(size=(2, 600, 3))
    o, d, up = 50.0 * o, unit(d), unit(np.array(normal))
    given = dict(zip([X, Y, Z, L, M, N, DEPTH], [*o.T, *d.T, np.full(600, 1e6)], strict=True))
    depth, *found = Program([pictured_floor_step(floor)], np.float64).run(given, [DEPTH, NX, NY, NZ], 600)
    t = (-200.0 - o @ up) / (d @ up)
    met = (d @ up < 0.0) & (t > 0.0) & (t < 1e6)            # from above
    assert 100 < met.sum() < 500
    np.testing.assert_allclose(depth, np.where(met, t, 1e6), rtol=1e-9)
    np.testing.assert_allclose(np.transpose(found), np.where(met[:, None], up, 0.0), atol=1e-12)


def test_the_lines_of_a_picture_lie_at_even_angles_from_the_top_of_a_ball():
    ball = lb.Sphere((50.0, -20.0, -900.0), 100.0, lb.Material((1.0,) * 3, "light",
                                                               pattern=lb.Pattern("image", image=RAMP)))
    away = unit(np.random.default_rng(2).normal(size=(600, 3)))
    o = np.array(ball.centre) + 300.0 * away
    given = dict(zip([X, Y, Z, L, M, N, DEPTH], [*o.T, *-away.T, np.full(600, 1e6)], strict=True))
    depth, seen = Program([pictured_step(ball, 1.0)], np.float64).run(given, [DEPTH, RED], 600)
    np.testing.assert_allclose(depth, 200.0, rtol=1e-9)
    share = np.arccos(away[:, 1]) / np.pi
    np.testing.assert_allclose(seen, np.clip(share, 0.5 / LINES, 1.0 - 0.5 / LINES), atol=2e-3)
