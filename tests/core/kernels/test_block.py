"""The workbench and the driver: what a stage may rely on."""

import numpy as np
import pytest

from lensbench.core.kernels.block import (
    A0, A1, A2, ALIVE, BLUE, GREEN, LOST, RED, WEIGHT, B, Step, X, Y, gather, lane_buffer, rows, stage, weigh_four
)
from lensbench.core.kernels.program import Program


@stage
def add(lanes, p, ints, key):
    """RED grows by p[0]."""
    row = rows(lanes)
    for i in range(B):
        row[RED][i] += p[0]


@stage
def fetch(lanes, p, ints, key):
    """RED = p[X]."""
    row = rows(lanes)
    gather(row[RED], p, row[X])


@stage
def weigh(lanes, p, ints, key):
    """RED, GREEN, BLUE, WEIGHT: four numbers from X, and half of each four from Y, from X + 1 and from X again."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, red, green, blue, weight = row[X], row[Y], row[RED], row[GREEN], row[BLUE], row[WEIGHT]
    for i in range(B):
        at, there = np.uint32(x[i]), np.uint32(y[i])
        red[i], green[i], blue[i], weight[i] = weigh_four(
            p, (at, there, at + np.uint32(1), at), (real(1), real(0.5), real(0.5), real(0.5)))


@stage
def show_parity(lanes, p, ints, key):
    """RED: parity of the first integer; GREEN: of the second."""
    real = lanes.dtype.type
    row = rows(lanes)
    for i in range(B):
        row[RED][i], row[GREEN][i] = real(ints[0] & 1), real(ints[1] & 1)


@stage
def halt(lanes, p, ints, key):
    """Nothing goes on."""
    key[ALIVE] = np.uint32(p[0])


REALS = pytest.mark.parametrize("real", [np.float32, np.float64])


@REALS
def test_four_numbers_side_by_side_are_weighed(real):
    table, random = np.random.default_rng(0).random(1000).astype(real), np.random.default_rng(1)
    x, y = random.integers(0, 995, (2, 3 * B))
    found = Program([Step(weigh, table)], real).run({X: x, Y: y}, [RED, GREEN, BLUE, WEIGHT], 3 * B)
    four = np.arange(4)[:, None]
    wanted = 1.5 * table[x + four] + 0.5 * table[y + four] + 0.5 * table[x + 1 + four]
    assert np.abs(found - wanted).max() < 8.0 * np.finfo(real).eps


@REALS
def test_a_gather_reads_the_element_that_the_index_names(real):
    table = np.random.default_rng(0).random(1000)
    index = np.random.default_rng(1).integers(0, 1000, 700)
    found = Program([Step(fetch, table)], real).run({X: index}, [RED], 700)
    assert np.array_equal(found[0], table.astype(real)[index])


@REALS
def test_lanes_beyond_the_last_block_are_padding_only(real):
    for n in (1, B - 1, B, B + 1, 3 * B + 7):
        out = Program([Step(add, [2.5])], real).run({RED: np.arange(n)}, [RED, A0], n)
        assert np.array_equal(out[0], np.arange(n, dtype=real) + real(2.5))
        assert not out[1].any()


def test_gated_steps_wait_while_no_lane_goes_on_and_lost_ends_the_block():
    stopped = Program([Step(halt, [0]), Step(add, [1.0], gated=True), Step(add, [10.0])])
    lost = Program([Step(halt, [LOST]), Step(add, [1.0], gated=True), Step(add, [10.0])])
    going = Program([Step(add, [1.0], gated=True), Step(add, [10.0])])
    assert [program.run({}, [RED], 1)[0, 0] for program in (stopped, lost, going)] == [10.0, 0.0, 11.0]


@REALS
def test_integers_keep_all_digits_in_either_precision(real):
    between = Step(add, [1.0], [0, 0])
    for a, b in ((2**53 + 1, 2**24 + 2), (2**24, 2**62 - 1)):
        found = Program([between, Step(show_parity, [], [a, b])], real).run({}, [RED, GREEN], 1)[:, 0]
        assert found.tolist() == [a % 2, b % 2]


@REALS
def test_rows_share_no_lane_and_begin_on_cache_lines(real):
    lanes = lane_buffer(real)
    assert lanes.ctypes.data % 64 == 0
    out = Program([Step(add, [1.0])], real).run({A1: np.full(B, 3.0)}, [A0, A1, A2, RED], B)
    assert np.array_equal(out, np.repeat(np.array([[0.0], [3.0], [0.0], [1.0]], real), B, 1))
