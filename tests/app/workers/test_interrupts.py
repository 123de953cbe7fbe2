"""Thirty renders interrupted at random moments, with bounds checked (`make interrupts`: 20,000)."""

import re
import subprocess
import sys

import pytest


@pytest.mark.slow
@pytest.mark.long
def test_interrupted_renders_end_without_a_failure():
    done = subprocess.run([sys.executable, "-m", "trials.interrupts", "--times", "30", "--varieties", "2",
                           "--seed", "3"], capture_output=True, text=True, timeout=1500)
    assert done.returncode == 0, done.stdout + done.stderr
    counts = re.search(r"(\d+) interrupted, (\d+) ended, 0 refused, 0 failures", done.stdout)
    assert counts and int(counts[1]) >= 30, done.stdout
