"""Random lenses and cameras: rays of finite numbers and unit directions, or a clear refusal. Short `make numbers`."""

import pytest

from tests.core.odd_cameras import faults


@pytest.mark.slow
def test_rays_of_odd_cameras_are_finite_and_their_directions_unit_vectors():
    assert faults(300, "short") == []
