"""Samples: nets stay nets, seeds and pixels change them, and the mean of a function comes out."""

import numpy as np
import pytest

from lensbench.app.studies.charts.samplers import white_noise
from lensbench.core.kernels.block import KEYS, PITCH, PIXEL, SAMPLE, SEED, U0, U1, V0, V1, B, Step, X, Y, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import (
    DIMENSIONS, add_corners, concentric_disk, sample_lights, sample_pixels, sobol, sobol_net
)

COUNT = 256


def points(kernel, pixel: int = 0, seed: int = 0, count: int = COUNT, width: int = 640) -> np.ndarray:
    """(count, 6) of one pixel, counted line by line: place in it, in the pupil, on a light."""
    size, n = [width, 40], width * 40
    lights = [Step(sample_lights)] if kernel is sample_pixels else []
    program = Program([Step(kernel, size), *lights], np.float64)
    corners = Program([Step(add_corners, size)]).run({X: np.zeros(n), Y: np.zeros(n)}, [X, Y], n)
    line, column = divmod(pixel, width)
    pixel = int(np.flatnonzero((corners == [[column], [line]]).all(0))[0])
    film = np.zeros((pixel // B + 1, 3 * B))
    rows, lanes = [], lane_buffer(np.float64)
    for k in range(count):
        program.expose(film, lanes, pixel // B, pixel // B + 1, k, 1, seed)
        at = pixel % B
        rows.append([lanes[row * PITCH + at] for row in (X, Y, U0, U1, V0, V1)])
    out = np.array(rows)
    out[:, :2] -= [column, line]
    return out


@pytest.mark.parametrize("kernel", [sample_pixels, white_noise])
def test_samples_lie_in_their_pixel_and_in_the_unit_square(kernel):
    for pixel in (0, 511, 640 * 3 + 7):
        p = points(kernel, pixel, count=64)
        assert (p >= 0.0).all() and (p <= 1.0).all()
        assert (p[:, 2:] < 1.0).all()                   # a place in the pupil may not be 1: it would be the next sector


@pytest.mark.parametrize("pair", [(2, 3), (0, 1), (4, 5)])
def test_every_elementary_box_of_a_pair_of_dimensions_holds_one_point(pair):
    """The first 2^(a + b) points fill 2^a × 2^b boxes with one point each, whatever the pixel's key.

    So Sobol's dimensions (0, 1), the pupil's; the film's (2, 3) are a net of quality 1, two points to each of
    half as many boxes, and the light's (5, 6) are tested on coarse boxes only.
    """
    for pixel in (0, 12345):
        p = points(sample_pixels, pixel)[:, pair]
        if pair == (0, 1):                               # dimensions 2 and 3: t = 1
            counts = np.histogram2d(*p.T, bins=(8, 16), range=[[0, 1], [0, 1]])[0]
            assert (counts == 2).all()
        elif pair == (2, 3):
            for a in range(9):
                counts = np.histogram2d(*p.T, bins=(2**a, 2**(8 - a)), range=[[0, 1], [0, 1]])[0]
                assert (counts == 1).all()
        else:
            counts = np.histogram2d(*p.T, bins=(4, 4), range=[[0, 1], [0, 1]])[0]
            assert (counts == 16).all()


def test_one_dimension_of_sobol_is_scrambled_but_stays_stratified():
    for d in range(DIMENSIONS):
        for seed in (0, 1, 99):
            cells = {int(sobol(np.uint32(k), d, np.uint32(seed))) >> 24 for k in range(256)}
            assert cells == set(range(256))
        assert [int(sobol(np.uint32(k), d, np.uint32(0))) for k in range(8)] != [
            int(sobol(np.uint32(k), d, np.uint32(1))) for k in range(8)]


def test_film_and_pupil_are_not_the_same_pair_of_dimensions():
    """One index for two pairs of dimensions never converges: the mean of a function of all four must."""
    p = points(sample_pixels, 77, count=1024)
    f = np.cos(7.0 * (p[:, 0] - p[:, 2])) * np.cos(5.0 * (p[:, 1] - p[:, 3]))
    g = np.random.default_rng(0).random((2_000_000, 4))
    truth = (np.cos(7.0 * (g[:, 0] - g[:, 2])) * np.cos(5.0 * (g[:, 1] - g[:, 3]))).mean()
    assert abs(f.mean() - truth) < 4e-3                  # white noise of 1024 would err by 1.4e-2


def test_neighbouring_pixels_and_other_seeds_take_other_points():
    a, b = points(sample_pixels, 100, count=4), points(sample_pixels, 101, count=4)
    c = points(sample_pixels, 100, seed=1, count=4)
    assert (np.abs(a - b).max(0) > 1e-6).all() and (np.abs(a - c).max(0) > 1e-6).all()


def test_samples_do_not_depend_on_the_width_of_a_line_being_a_round_number():
    wide = {pixel: points(sample_pixels, pixel, width=131, count=2) for pixel in (130, 131, 511, 512, 700)}
    for p in wide.values():
        assert (p >= 0.0).all() and (p[:, :2] <= 1.0).all()


def test_the_concentric_map_keeps_areas_and_fills_the_disk():
    n = 256
    u, v = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    x, y = np.vectorize(lambda a, b: concentric_disk.py_func(np.float64, a, b))(u, v)
    r2 = x * x + y * y
    assert r2.max() <= 1.0 + 1e-6
    # the part of the points within r is r² of all, and every angle is as frequent: to the grid's 1/n
    for r in (0.25, 0.5, 0.75, 0.9):
        assert abs((r2 < r * r).mean() - r * r) < 2.0 / n
    angles = np.histogram(np.arctan2(y, x), bins=16, range=(-np.pi, np.pi))[0] / n**2
    assert np.abs(angles - 1 / 16).max() < 1e-3
    # octant edges meet: both formulas give the same point where |a| = |b|
    map_ = concentric_disk.py_func
    assert np.allclose(map_(np.float64, 0.9, 0.9), map_(np.float64, 0.9, 0.9 + 1e-12))
    assert concentric_disk.py_func(np.float64, 0.5, 0.5) == (0.0, 0.0)


@pytest.mark.parametrize("pixel", [0, 5])
def test_the_blocks_of_a_net_are_one_net(pixel):
    """Boxes of the pupil's pair of dimensions hold as many points of the first 2, 4 and 8 blocks each."""
    blocks = []
    key = np.zeros(KEYS, np.uint32)
    key[PIXEL], key[SEED] = pixel, 7
    for sample in range(8):
        key[SAMPLE], lanes = sample, lane_buffer(np.float64)
        sobol_net(lanes, np.zeros(0), np.zeros(0, np.int64), key)
        blocks.append([lanes[row * PITCH:row * PITCH + B].copy() for row in (U0, U1, V0, V1)])
    for many in (1, 2, 4, 8):
        u0, u1, v0, v1 = np.concatenate(blocks[:many], 1)
        for values in (u0, u1, v0, v1):
            assert (np.bincount((values * many * B).astype(int), minlength=many * B) == 1).all()
        counts = np.histogram2d(u0, u1, bins=(16, 32 * many), range=[[0, 1], [0, 1]])[0]
        assert (counts == 1).all()
