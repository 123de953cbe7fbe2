"""Half a minute of random use of the window: no exception, and no thread that stays (`make soak` takes two hours)."""

import re
import subprocess
import sys

import pytest


@pytest.mark.slow
def test_random_use_ends_without_a_failure():
    done = subprocess.run([sys.executable, "-m", "trials.soak", "--minutes", "0.5", "--seed", "3"], capture_output=True,
                          text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    actions = re.findall(r"(\d+) actions 0 exceptions", done.stdout)
    assert int(actions[-1]) > 10
