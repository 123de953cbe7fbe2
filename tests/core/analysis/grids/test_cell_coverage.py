"""Cells that a straight rim crosses: their open parts against clipped polygons, their centroids against rectangles."""

import numpy as np
import pytest

from lensbench.core.analysis.grids.grid_cells import cover, towards_centroids

N = 6
STEP = np.array([0.3, 0.5])             # pupil coordinates per cell, sagittal and tangential
MIDDLE = (np.arange(N) - 2.5)[None, :] * STEP[:, None]


def covered(slopes, aside):
    """Open parts of cells and of the cells of a beam aside by (s, t) cells, and the centroids of the latter."""
    s, t = np.meshgrid(*(MIDDLE + (aside * STEP)[:, None]))
    level = (1.0 - 0.3 - slopes[0] * s / STEP[0] - slopes[1] * t / STEP[1])[None, None]
    out = np.zeros((2, 1, 1, N, N))
    centre = np.zeros((2, 1, 1, N, N))
    cover(level, 0, s[None, None], t[None, None], MIDDLE[None], False, out[0], out[1], centre)
    return out[0, 0, 0], out[1, 0, 0], centre[:, 0, 0]


def clipped_area(distance, slopes):
    """Area of the unit square about 0 where distance + slopes · x > 0, by clipping its edges."""
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    kept = []
    for a, b in zip(corners, np.roll(corners, -1, 0), strict=True):
        here, there = distance + a @ slopes, distance + b @ slopes
        if here >= 0.0:
            kept.append(a)
        if here * there < 0.0:
            kept.append(a + here / (here - there) * (b - a))
    x, y = np.array(kept).reshape(-1, 2).T
    return 0.5 * abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.2, -0.35)])
@pytest.mark.parametrize("slopes", [(0.4, 0.0), (0.0, -0.7), (0.5, 0.2), (-0.3, 0.9)])
def test_open_parts_are_the_areas_of_squares_that_a_line_clips(slopes, aside):
    slopes, aside = np.array(slopes), np.array(aside)
    parts, of_beam, _ = covered(slopes, aside)
    for found, moved in ((parts, np.zeros(2)), (of_beam, aside)):
        for i in range(N):
            for j in range(N):
                place = np.array([j - 2.5, i - 2.5]) + moved
                assert found[i, j] == pytest.approx(clipped_area(0.3 + slopes @ place, slopes), abs=1e-12)


def test_a_ray_without_pupil_coordinates_counts_as_that_of_the_middle_of_its_cell():
    """It reaches the stop, and so has a level, and may miss the pupil: of a ball lens the coverage was nan."""
    level = np.linspace(0.2, 1.5, N * N).reshape(1, 1, N, N)
    s, t = np.meshgrid(*MIDDLE)
    found = []
    for places in (np.stack([s, t]), np.full((2, N, N), np.nan)):
        parts, of_beam, centre = np.zeros((1, 1, N, N)), np.zeros((1, 1, N, N)), np.zeros((2, 1, 1, N, N))
        cover(level, 0, *places[:, None, None], MIDDLE[None], False, parts, of_beam, centre)
        np.testing.assert_array_equal(parts, of_beam)
        found.append(parts)
    assert ((found[0] > 0.0) & (found[0] < 1.0)).any()
    np.testing.assert_array_equal(found[1], found[0])


def test_no_cell_is_open_whose_neighbours_carry_no_light():
    """Rays that nearly miss a surface have levels that leap, and pass the pupil many cells from their own."""
    random = np.random.default_rng(5)
    for _ in range(200):
        level = random.uniform(1.0, 4.0, (N, N))
        level[random.random((N, N)) < 0.3] = np.nan
        lit = random.integers(0, N, 2)
        level[tuple(lit)] = 0.9
        s, t = (each + random.normal(0.0, 8.0, (N, N)) * step for each, step in
                zip(np.meshgrid(*MIDDLE), STEP, strict=True))
        parts, of_beam, centre = np.zeros((1, 1, N, N)), np.zeros((1, 1, N, N)), np.zeros((2, 1, 1, N, N))
        cover(level[None, None], 0, s[None, None], t[None, None], MIDDLE[None], False, parts, of_beam, centre)
        away = np.abs(np.mgrid[:N, :N] - lit[:, None, None]).max(0)
        assert not np.maximum(parts, of_beam)[0, 0][away > 1].any()


@pytest.mark.parametrize("slopes", [(0.4, 0.0), (-0.4, 0.0), (0.0, 0.7), (0.0, -0.7)])
def test_a_rim_along_the_cells_leaves_rectangles_with_their_centroids(slopes):
    _, parts, centre = covered(np.array(slopes), np.zeros(2))
    cut = (parts > 0.0) & (parts < 1.0)
    assert cut.any()
    for axis in (0, 1):
        np.testing.assert_allclose(centre[axis][cut], 0.5 * np.sign(slopes[axis]) * (1.0 - parts[cut]), atol=1e-12)
        np.testing.assert_array_equal(centre[axis][parts == 1.0], 0.0)


def test_a_plane_of_values_is_still_the_plane_halfway_to_the_centroids():
    i, j = np.mgrid[:N, :N].astype(float)
    ds, dt = np.random.default_rng(3).uniform(-0.5, 0.5, (2, N, N))
    found = np.full((1, N, N), np.nan)
    towards_centroids((2.0 + 3.0 * i - 0.7 * j)[None], np.ones((1, N, N)), np.stack([ds, dt])[:, None], found)
    np.testing.assert_allclose(found[0], 2.0 + 3.0 * (i + 0.5 * dt) - 0.7 * (j + 0.5 * ds), atol=1e-12)
