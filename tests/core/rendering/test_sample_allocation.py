"""Sample allocation: unbiased, each sample once, better where the error is, and the same however passes are cut."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import B
from lensbench.core.rendering.sample_allocation import EVEN, LEAST, MOST, SampleAllocation, _levels

SMALL = lb.Film(36.0, 24.0, 150, 100)


def camera(film=SMALL, **more):
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film, 1200.0, 2.8, **more)


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=200))
def test_shares_are_one_on_average_and_grow_with_the_error(errors):
    levels = _levels(np.array(errors))
    shares = np.exp2(levels)
    assert levels.min() >= LEAST and levels.max() <= MOST
    # A step that no longer fits leaves a part of one share
    assert len(errors) - 2.0**(MOST - 1) < shares.sum() <= len(errors)
    order = np.argsort(errors, kind="stable")
    assert (np.diff(levels[order]) >= -1).all()         # one step where the budget ends between equal gains


def test_equal_errors_get_equal_shares():
    assert (_levels(np.full(37, 0.3)) == 0).all() and (_levels(np.zeros(37)) == 0).all()


def test_shares_are_in_proportion_to_errors_within_a_power_of_two():
    errors = np.repeat([0.5, 1.0, 2.0, 4.0], [64, 64, 16, 16])
    shares = np.exp2(_levels(errors))
    ratio = shares / errors
    assert ratio.max() / ratio.min() <= 2.0


@given(st.integers(0, 2**32 - 1), st.integers(1, 400))
def test_no_sample_of_a_block_is_taken_twice_and_weights_add_up(seed, end):
    random = np.random.default_rng(seed)
    blocks = 6
    allocation, had = SampleAllocation(blocks, blocks, np.float32), [set() for _ in range(blocks)]
    sums, weighed, done = np.zeros((blocks, 3 * B), np.float32), np.zeros(blocks), 0
    while done < end:
        step = min(int(random.integers(1, 40)), end - done)
        for begin, last in allocation.pieces(done, done + step):
            first, count, weights = allocation.samples(begin, last)
            for block in range(blocks):
                new = set(range(first[block], first[block] + count[block]))
                assert len(new) == count[block] and not had[block] & new
                had[block] |= new
            weighed += count * weights
            sums += random.exponential(np.repeat([[0.1], [1.0], [1.0], [3.0], [9.0], [30.0]], 3 * B, 1))
            allocation.finish(last, sums)
        done += step
        assert (allocation.weights(done) == weighed).all()
        assert (weighed >= done).all() and (weighed < done + 2.0**-LEAST).all()
        if done % 2**-LEAST == 0:
            assert (weighed == done).all()


def test_samples_are_even_at_first():
    allocation = SampleAllocation(5, 5, np.float32)
    first, count, weights = allocation.samples(3, EVEN // 2)
    assert (first == 3).all() and (count == EVEN // 2 - 3).all() and (weights == 1.0).all()


def test_rare_light_keeps_its_mean():
    """A light in one sample of a hundred that a block sees as a whole: the least even case for a choice by samples.

    Among 40,000 blocks of 64 samples its mean has a standard error of 0.6 %. Means over all samples of a block, in
    which each counted as much, come out 26 % too dark.
    """
    blocks, chance, end = 40_000, 0.01, 64
    allocation = SampleAllocation(blocks, 40, np.float32)
    random = np.random.default_rng(5)
    sums, plain, number = np.zeros((blocks, 1)), np.zeros(blocks), np.zeros(blocks)
    for begin, last in allocation.pieces(0, end):
        _, count, weights = allocation.samples(begin, last)
        met = random.binomial(count, chance)
        sums[:, 0] += met * weights
        plain, number = plain + met, number + count
        allocation.finish(last, np.broadcast_to(1e-3 * last + sums, (blocks, 3 * B)).astype(np.float32))
    error = np.sqrt(chance / (blocks * end))
    assert abs(sums.mean() / end - chance) < 5.0 * error
    assert (plain / number).mean() < 0.8 * chance               # the test would see such a bias


@pytest.mark.parametrize("disperses", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_picture_does_not_depend_on_threads_nor_on_how_its_passes_are_cut(disperses):
    lens = lenses.load("lv-leica-summicron-m-50f2-v5")
    view, scene = lb.LensCamera(lens, SMALL, 1200.0, 2.0, dispersion=disperses), lb.builtin_scene("still-life")
    at_once, by_parts = (lb.Rendering(view, scene, light_passes=2) for _ in range(2))
    assert at_once.add(71, threads=2)
    with ThreadPoolExecutor(2) as pool:
        for samples in (1, 2, 7, 13, 3, 20, 25):
            assert by_parts.add(samples, pool=pool, threads=1)
    assert np.array_equal(at_once.image(), by_parts.image())
    assert len(set(at_once._sums.allocation._levels)) > 2


def test_a_picture_in_bands_shares_as_the_whole_one_and_goes_on_from_its_state():
    view = camera(lb.Film(2.0, 24.0, 90, 1080))
    scene = lb.builtin_scene("still-life")
    whole, in_bands = (lb.Rendering(view, scene, light_tracing=False, in_bands=each) for each in (False, True))
    assert whole.add(21)
    found = []
    while not found or in_bands.next_band():
        assert in_bands.add(21)
        found.append(in_bands.image())
    assert np.array_equal(np.concatenate(found), whole.image())
    resumed = lb.Rendering(view, scene, light_tracing=False)
    resumed.restore({name: value.copy() for name, value in whole.state.items()})
    assert resumed.add(20) and whole.add(20)
    assert np.array_equal(resumed.image(), whole.image())


@pytest.mark.parametrize("samples", [16, 17, 18, 19, 20, 45, 64])
def test_a_white_world_is_white_after_any_number_of_samples(samples):
    view = lb.PerspectiveCamera(SMALL, fov=0.5, weights="one")
    rendering = lb.Rendering(view, lb.Scene("white", sky=lb.Sky(*[(1.0,) * 3] * 3)))
    assert rendering.add(samples)
    assert np.abs(rendering.image() - 1.0).max() < 1e-6


def test_an_aov_and_samplers_of_others_take_even_samples():
    scene = lb.builtin_scene("still-life")
    for rendering in (lb.Rendering(camera(), scene, view="depth"), lb.Rendering(camera(), scene, adaptive=False)):
        assert not rendering._sums.allocation.state


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["still-life", "night-lights"])
def test_the_error_is_smaller_than_with_even_samples(scene):
    """At least 1.1 times as many even samples would be needed (seen at 128 samples: 1.2 to 1.6)."""
    view, found = camera(lb.Film(36.0, 24.0, 240, 160)), lb.builtin_scene(scene)
    truth = lb.Rendering(view, found, seed=99, light_tracing=False, adaptive=False)
    assert truth.add(1024)

    def error(adaptive):
        rendering = lb.Rendering(view, found, light_tracing=False, adaptive=adaptive)
        assert rendering.add(128)
        shown, right = (each / (each + 0.2) for each in (rendering.image(), truth.image()))
        return float(np.sqrt(((shown - right) ** 2).mean()))

    assert error(True) ** 2 < error(False) ** 2 / 1.1
