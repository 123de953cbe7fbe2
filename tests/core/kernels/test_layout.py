"""Offsets name consecutive fields; parts are joined in order."""

import numpy as np

from lensbench.core.kernels.block import Packed, join, offsets, pack, vector


def test_offsets_are_consecutive_and_end_with_the_size():
    assert offsets(3, 1, 2) == (0, 3, 4, 6)


def test_packed_fields_are_read_back_at_their_offsets():
    centre, radius, size = offsets(3, 1)
    p = pack(size, {centre: (1.0, 2.0, 3.0), radius: 4.0})
    assert vector.py_func(p, centre) == (1.0, 2.0, 3.0) and p[radius] == 4.0


def test_joined_parts_keep_their_order_and_whole_integers():
    found = join(Packed(np.array([0.5]), [2**62]), Packed(np.array([1.5, 2.5])), Packed(np.zeros(0), [3]))
    assert found.parameters.tolist() == [0.5, 1.5, 2.5] and found.integers.tolist() == [2**62, 3]
    assert join().parameters.size == 0 and join().integers.dtype == np.int64
