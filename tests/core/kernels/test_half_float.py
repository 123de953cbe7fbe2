"""Half floats in kernels against numpy's float16."""

import numpy as np
import pytest
from numba import njit

from lensbench.core.kernels.arrays import EXPONENT_SCALE, as_bits, prefetch, scale_of, texel_sum, unscaled

ALL = np.arange(0x7C00, dtype=np.uint16).view(np.float16)      # every finite half that is not negative


@njit
def read(numbers, out):
    for i in range(numbers.size):
        prefetch(numbers, min(i + 8, numbers.size - 1))
        out[i] = unscaled(numbers[i])


@njit
def sum_texels(numbers, places, down, across, at):
    return texel_sum(numbers, places, down, across, at)


@pytest.mark.parametrize("numbers", [ALL, ALL.astype(np.float32)], ids=["half", "single"])
def test_every_number_is_read_exactly(numbers):
    bits = as_bits(numbers)
    assert np.shares_memory(bits, numbers)
    out = np.empty(numbers.size, np.float32)
    read(bits, out)
    np.testing.assert_array_equal(out * scale_of(bits), numbers.astype(np.float32))


def test_a_sum_of_texels_is_the_weighted_sum_of_their_values():
    rng = np.random.default_rng(5)
    width, texels = 9, rng.uniform(0.0, 4.0, (7, 9, 4)).astype(np.float16)
    for _ in range(20):
        x, y = rng.integers(0, width - 3), rng.integers(0, 4)
        down, across = rng.random((2, 4)).astype(np.float32)
        at = np.float32(rng.uniform(0.0, 4.0))
        places = tuple(int(4 * ((y + line) * width + x)) for line in range(4))
        *colour, off = sum_texels(as_bits(texels).reshape(-1), places, tuple(down), tuple(across),
                                  np.float32(at / EXPONENT_SCALE))
        part = texels[y:y + 4, x:x + 4].astype(np.float64)
        expected = np.einsum("i,j,ijk->k", down.astype(np.float64), across.astype(np.float64), part)
        np.testing.assert_allclose(np.array(colour) * EXPONENT_SCALE, expected[:3], rtol=1e-6)     # float32 sums of 16
        assert off * EXPONENT_SCALE == pytest.approx(np.abs(part[..., 3] - at).max(), rel=1e-6)
