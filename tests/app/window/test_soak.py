"""A tour and a minute of random use of the window: no exception, no thread that stays (`make soak` takes two hours)."""

import math
import re
import subprocess
import sys

import pytest

from trials.soak import growth


def test_growth_is_the_slope_of_the_samples_after_a_time_with_its_error():
    samples = [(float(t), 300.0 + 40.0 * min(t, 10) + 0.25 * t) for t in range(61)]       # first uses, then growth
    assert growth(samples, 10.0) == pytest.approx((0.25, 0.0), abs=1e-6)
    assert growth(samples, 0.0)[0] > 1.0
    noisy = [(t, memory + (-1.0) ** t) for t, memory in samples]
    slope, error = growth(noisy, 10.0)
    assert slope == pytest.approx(0.25, abs=3.0 * error) and 0.005 < error < 0.015       # 1 / (√51 · 14.7)
    assert all(math.isnan(x) for x in growth(samples, 58.0))                        # three samples have no error


@pytest.mark.slow
@pytest.mark.long
def test_a_tour_and_random_use_end_without_a_failure():
    done = subprocess.run([sys.executable, "-m", "trials.soak", "--minutes", "2.5", "--hurry", "--seed", "3"],
                          capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "at rest;" in done.stdout                                                      # after the whole tour
    actions = re.findall(r"(\d+) actions 0 exceptions", done.stdout)
    assert int(actions[-1]) > 10
