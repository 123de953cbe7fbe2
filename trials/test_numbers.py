"""Rays of 20,000 random lenses and cameras: finite numbers, weights from 0, unit directions, or a clear refusal.

LENSBENCH_NUMBERS_TIMES=N is another number of cameras; a warning of numpy counts as a fault.
"""

import os

import pytest

from tests.core.odd_cameras import faults

TIMES, PARTS = int(os.environ.get("LENSBENCH_NUMBERS_TIMES", "20000")), 20


@pytest.mark.parametrize("share", range(PARTS))
def test_rays_of_odd_cameras_are_finite_and_their_directions_unit_vectors(share):
    assert faults(TIMES // PARTS, f"trial {share}") == []
