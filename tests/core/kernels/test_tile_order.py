"""The order of a film's pixels: each of them once, those of a block close together, each unrolled to its place."""

import numpy as np
import pytest

from lensbench.core.kernels.block import U0, U1, B, Step, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import BAND_LINES, STRIP_WIDTH, add_corners, raster_image, sampling_steps

SHAPES = [(1, 1), (1, 700), (700, 1), (31, 9), (32, 16), (33, 16), (65, 3), (427, 40), (640, 36), (1000, 7),
          (1, 513), (3, 1024), (32, 1500), (33, 1025), (70, 1100)]


def in_order(w: int, h: int) -> np.ndarray:
    """(w · h, 2) whole numbers: column and line of the pixels in their order."""
    zero = np.zeros(w * h)
    return Program([Step(add_corners, [w, h])]).run({X: zero, Y: zero}, [X, Y], w * h).T.astype(int)


def by_blocks(values: np.ndarray) -> np.ndarray:
    """Values (n, c) of pixels in that order as a film holds them: (blocks, c B), the last block filled up."""
    n, c = values.shape
    full = np.concatenate([values, np.full((-n % B, c), -1.0)])
    return full.reshape(-1, B, c).transpose(0, 2, 1).reshape(-1, c * B)


@pytest.mark.parametrize(("w", "h"), SHAPES)
def test_the_order_holds_every_pixel_once_and_raster_image_inverts_it(w, h):
    places = in_order(w, h)
    assert (np.sort(places @ [1, w]) == np.arange(w * h)).all()
    lines, columns = np.mgrid[0:h, 0:w]
    assert (raster_image(by_blocks(places), w, h, 2.0) == 2.0 * np.stack([columns, lines], 2)).all()


@pytest.mark.parametrize(("w", "h"), [(64, 64), (427, 90), (640, 360), (639, 361), (1921, 50)])
def test_the_pixels_of_a_block_lie_close_together(w, h):
    """Strips of a film of WIDE pixels or more are at least half as wide, and a block lies in at most two of them."""
    places = in_order(w, h)
    assert np.abs(np.diff(places, axis=0)).max() <= 2 * STRIP_WIDTH
    for start in range(0, w * h, B):
        x, y = np.ptp(places[start:start + B], 0)
        assert x < 2 * STRIP_WIDTH and y <= 2 * B // STRIP_WIDTH


def test_a_band_of_lines_is_whole_blocks_in_the_order_of_a_film_of_these_lines_alone():
    w, places = 70, in_order(70, 2 * BAND_LINES + 30)
    for first, lines in ((0, BAND_LINES), (BAND_LINES, BAND_LINES), (2 * BAND_LINES, 30)):
        assert first * w % B == 0
        assert (places[first * w:(first + lines) * w] - [0, first] == in_order(w, lines)).all()


def test_the_numbers_of_a_pixel_depend_on_its_place_alone_and_not_on_the_film_round_it():
    found = []
    for w, h in ((150, 40), (33, 50), (640, 20)):
        n = w * h
        x, y, u, v = Program(sampling_steps(w, h, lit=False), np.float64).run({}, [X, Y, U0, U1], n)
        places = in_order(w, h)
        assert (np.floor([x, y]).T == places).all()
        found.append(raster_image(by_blocks(np.column_stack([x, y, u, v])), w, h)[:20, :33])
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
