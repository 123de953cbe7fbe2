"""Offsets name consecutive fields, and counts survive single precision."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lensbench.kernels.layout import digits, integer, offsets, pack, vector


def test_offsets_are_consecutive_and_end_with_the_size():
    assert offsets(3, 1, 2) == (0, 3, 4, 6)


def test_packed_fields_are_read_back_at_their_offsets():
    centre, radius, size = offsets(3, 1)
    p = pack(size, {centre: (1.0, 2.0, 3.0), radius: 4.0})
    assert vector.py_func(p, centre) == (1.0, 2.0, 3.0) and p[radius] == 4.0


@given(st.integers(0, 2**36 - 1))
def test_a_count_survives_single_precision(count):
    assert integer.py_func(np.array([7.0, *digits(count)], np.float32), 1) == count
