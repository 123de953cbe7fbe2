"""Boxes of the open region of a ray grid: narrowed to the cells with light."""

from types import SimpleNamespace

import numpy as np

from lensbench.core.analysis.grids.grid_cells import _tighten


def test_a_narrowed_box_holds_the_cells_with_light_and_half_a_cell_more():
    light = np.zeros((2, 1, 8, 8))
    light[0, 0, 3:5, 2:6] = 1.0                     # rows along t, columns along s
    light[1, 0, 0, 7] = 0.1                         # in a corner: the box ends there
    for coverage, weight in ((light, 0.0 * light), (0.0 * light, light)):
        boxes = np.array([[[-4.0, 4.0], [0.0, 16.0]], [[0.0, 8.0], [0.0, 8.0]]])
        _tighten(boxes, np.array([True, True]), SimpleNamespace(coverage=coverage, weight=weight))
        np.testing.assert_allclose(boxes, [[[-2.5, 2.5], [5.0, 11.0]], [[6.5, 8.0], [0.0, 1.5]]])
