"""When the lines and columns of a rolling shutter are exposed."""

import numpy as np
import pytest

from lensbench.core.imaging.exposure import shutter_step
from lensbench.core.kernels.block import TIME, X, Y
from lensbench.core.kernels.program import Program


@pytest.mark.parametrize(("direction", "first", "last"), [
    ("down", (20.0, 0.0), (20.0, 40.0)), ("up", (20.0, 40.0), (20.0, 0.0)),
    ("right", (0.0, 20.0), (60.0, 20.0)), ("left", (60.0, 20.0), (0.0, 20.0))])
@pytest.mark.parametrize("ramp", [0.0, 0.01])
def test_a_rolling_shutter_begins_at_one_edge_and_takes_its_time_to_the_opposite_one(direction, first, last, ramp):
    step = shutter_step(0.05, ramp, 0.3, direction, 60, 40)
    ends = np.array([first, last, np.mean([first, last], 0)])
    for share in (0.0, 0.4, 1.0 - 1e-9):
        early, late, middle = Program([step], np.float64).run({TIME: np.full(3, share), X: ends[:, 0], Y: ends[:, 1]},
                                                              [TIME], 3)[0]
        assert late - early == pytest.approx(0.3, abs=1e-12)
        assert middle == pytest.approx(0.5 * (early + late), abs=1e-12)
        assert -1e-12 <= early <= 0.05 and (share > 0.0 or abs(early) < 1e-12)
