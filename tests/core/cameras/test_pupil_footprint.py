"""The part of the pupil that a sample covers, as stages in single precision give it."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.cameras.pupil_footprint import footprint_steps
from lensbench.core.kernels.block import OX, OY, OZ, PUPIL_RADIUS, PUPIL_SPREAD, U0, U1, X, Y
from lensbench.core.kernels.program import Program

FILM = lb.Film(36.0, 24.0, 90, 60)


@pytest.mark.parametrize("radius, focus, window", [
    (60.0, 1000.0, None), (20.0, 800.0, (-0.3, 1.0, -0.5, 0.5)), (5.0, 30.0, None), (150.0, 1e6, None)])
def test_the_cone_of_a_telecentric_lens_begins_as_wide_as_the_lens_and_ends_in_focus(radius, focus, window):
    """Its chief rays are parallel, so that they cross at no distance that single precision could hold."""
    camera = lb.OrthographicCamera(FILM, 700.0, lens_radius=radius, focus_distance=focus, window=window)
    before, after = footprint_steps(camera, np.float32)
    random, n = np.random.default_rng(1), 1000
    x, y, u, v = random.uniform((0.0, 0.0, 0.0, 0.0), (90.0, 60.0, 1.0, 1.0), (n, 4)).T
    width, fan, *off = Program([*before, *camera.steps(), *after], np.float32).run(
        {X: x, Y: y, U0: u, U1: v}, [PUPIL_RADIUS, PUPIL_SPREAD, OX, OY, OZ], n).astype(float)
    assert np.abs(width) == pytest.approx(np.full(n, radius), rel=0.02)     # its size is known by 16 rays
    cosine = focus / np.hypot(focus, radius)
    assert -width / fan == pytest.approx(np.full(n, focus), rel=1.0 / cosine - 1.0 + 2e-3)
    # the first samples cover the whole pupil: the disk about the middle of each begins at the lens's centre
    points = lb.unit_disk(np.stack([u, v], 1)) * radius
    middle = points - (width * np.stack(off[:2])).T
    assert np.hypot(*middle.T).max() < 0.05 * radius
    assert math.hypot(*np.ptp(off[2:], axis=1)) < 0.2
