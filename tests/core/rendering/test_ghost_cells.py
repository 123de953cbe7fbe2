"""Cells of ghosts on the film: the same light in bands of rows as in one piece."""

import numpy as np

from lensbench.core.rendering.ghost_lights import add_cells


def test_bands_of_rows_have_the_light_that_they_have_together_also_of_rays_without_a_place():
    random = np.random.default_rng(8)
    cells, across, down = 6, 20, 16
    x, y = np.meshgrid(np.linspace(2.0, 17.0, cells + 1), np.linspace(1.0, 14.0, cells + 1))
    found = np.concatenate([[x.ravel(), y.ravel()], random.uniform(0.5, 1.0, (3, x.size))])
    found[:2] += random.uniform(-0.4, 0.4, (2, x.size))
    lost = random.random(x.size) < 0.2
    found[:2, lost], found[2:, lost] = np.nan, 0.0
    found, gain = found.astype(np.float32), np.array([1.0, 0.5, 2.0], np.float32)
    whole = np.zeros((down, across + 1, 3))
    add_cells(whole, found, cells, across, 0, down, gain)
    # Rows before and behind those of a band are its neighbours' own
    room = np.zeros((5 * down, across + 1, 3))
    for top, bottom in ((0, 5), (5, 11), (11, down)):
        add_cells(room[2 * down + top:2 * down + bottom], found, cells, across, top, bottom, gain)
    np.testing.assert_allclose(room[2 * down:3 * down], whole, atol=1e-12)
    assert whole.any() and not room[:2 * down].any() and not room[3 * down:].any()
