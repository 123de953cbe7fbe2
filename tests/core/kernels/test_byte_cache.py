"""Caches bounded by bytes: what stays, what goes, and what counts once."""

import numpy as np

from lensbench.core.kernels.byte_cache import buffers, byte_cache


def test_the_oldest_goes_when_all_hold_too_much_and_the_newest_stays():
    made = []

    @byte_cache(10_000, 8)
    def zeros(count):
        made.append(count)
        return np.zeros(count, np.uint8)

    assert zeros(4000) is zeros(4000) and zeros(5000) is zeros(5000) and made == [4000, 5000]
    zeros(4000)                                         # used again: 5000 is now the oldest
    zeros(3000)
    assert zeros.held == 7000
    zeros(4000)
    assert made == [4000, 5000, 3000]
    large = zeros(50_000)
    assert zeros(50_000) is large and zeros.held == 50_000
    zeros.cache_clear()
    assert zeros.held == 0


def test_the_number_is_bounded_too_and_shared_buffers_count_once():
    shared = np.zeros(5000, np.uint8)

    @byte_cache(10_000, 3)
    def view(first):
        return {"part": (shared[first:], [np.frombuffer(bytes(2000), np.uint8)])}

    for first in range(3):
        view(first)
    assert view.held == 5000 + 2 * 2000                 # a third one of 2000 was too much
    assert buffers((shared[:10], shared)) == {id(shared): 5000}


def test_the_newest_stay_by_number_whatever_they_hold():
    made = []

    @byte_cache(10_000, 8, least=3)
    def zeros(key):
        made.append(key)
        return np.zeros(9000, np.uint8)

    for key in (1, 2, 3, 1, 2, 3):
        zeros(key)
    assert made == [1, 2, 3] and zeros.held == 27_000
    zeros(4)
    assert zeros.held == 27_000
    zeros(1)
    assert made == [1, 2, 3, 4, 1]


def test_what_a_value_gains_later_counts():
    class Grows:
        def __init__(self):
            self.first = np.zeros(3000, np.uint8)

    Grows.__module__ = "lensbench"

    @byte_cache(10_000, 8)
    def grown(key):
        return Grows()

    grown(1).later = np.zeros(6000, np.uint8)
    grown(2)
    assert grown.held == 3000                           # 12 000 were too much


def test_as_many_small_values_stay_as_allowed_and_names_have_no_order():
    made = []

    @byte_cache(10_000, 3)
    def word(first, second=0):
        made.append((first, second))
        return f"{first} {second}"

    for first in (1, 2, 3, 1, 2, 3):
        word(first)
    assert made == [(1, 0), (2, 0), (3, 0)] and word.held == 0
    word(4)
    word(2)
    word(1)
    assert made[3:] == [(4, 0), (1, 0)]
    assert word(first=5, second=6) is word(second=6, first=5) and made[5:] == [(5, 6)]
