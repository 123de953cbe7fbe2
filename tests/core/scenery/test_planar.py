"""Patterns of planar shapes, stage by stage, without a footprint; the stage of plain shapes."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import A1, A2, A3, PITCH, B, lane_buffer
from lensbench.core.scenery.intersect.planar import COLUMNS, HALF_U, HALF_V, LINE, LINES, PLANAR, _grid


def test_the_lines_of_a_grid_begin_and_end_at_its_edges():
    q, lanes = np.zeros(PLANAR), lane_buffer(np.float64)
    q[COLUMNS], q[LINES], q[LINE], q[HALF_U], q[HALF_V] = 5.0, 3.0, 6.0, 100.0, 60.0
    row = lanes.reshape(-1, PITCH)[:, :B]
    random = np.random.default_rng(2)
    u, v = random.uniform(-1.0, 1.0, (2, B))
    u[:B // 2:2], v[1:B // 2:2] = 0.13, -0.37              # the lines of one direction alone, and its very edges
    u[1:B // 2:2] = np.linspace(-1.0 + 1e-9, 1.0 - 1e-9, B // 4)
    v[:B // 2:2] = np.linspace(-1.0 + 1e-9, 1.0 - 1e-9, B // 4)
    row[A1], row[A2] = u, v
    _grid(lanes, q)
    # as many cells between one line more, all 6 mm wide, from edge to edge
    ink = [(half * (1.0 + at)) % ((2.0 * half - 6.0) / cells) < 6.0 for half, at, cells in (
        (100.0, u, 5), (60.0, v, 3))]
    np.testing.assert_allclose(row[A3], ink[0] | ink[1], atol=1e-9)


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_plain_shapes_look_the_same_beside_one_with_a_pattern(real):
    camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 48, 32), fov=0.5)
    shiny = lb.Material((0.1, 0.4, 0.9), "coat")
    plain = (lb.Rectangle((-150.0, 20.0, -1000.0), (120.0, 0.0, 60.0), (0.0, 90.0, 0.0), lb.Material((0.8, 0.3, 0.1))),
             lb.Disk((120.0, -10.0, -900.0), (0.3, 0.1, 1.0), 90.0, shiny),
             lb.Disk((0.0, 150.0, -950.0), (0.0, 0.0, 1.0), 30.0, lb.Material((9.0, 8.0, 7.0), "lamp")))
    chess = lb.Material((0.5, 0.5, 0.5), pattern=lb.Pattern("checker"))
    behind = lb.Rectangle((0.0, 0.0, 5000.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0), chess)
    pictures = []
    for plates in (plain, (*plain, behind)):
        rendering = lb.Rendering(camera, lb.Scene(plates=plates), real=real)
        rendering.add(4)
        pictures.append(rendering.image())
    np.testing.assert_array_equal(*pictures)
    assert np.ptp(pictures[0]) > 0.3
