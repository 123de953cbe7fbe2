"""Laws are tried with the same random examples in every run; `pytest --hypothesis-seed=N` tries others."""

import os

import pytest
from hypothesis import HealthCheck, settings


def pytest_configure(config: pytest.Config) -> None:
    """Before the tests are read, which take their settings from this profile. No law fails on a busy machine."""
    same = config.getoption("--hypothesis-seed") is None
    settings.register_profile("laws", derandomize=same, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.load_profile("laws")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin the tests that take half a minute or more (`long`) first, one in each process: none is left for the end.

    Each of several processes (`-n`) begins with a stretch of neighbouring tests; a stretch begins with long ones.
    """
    count = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    long = [item for item in items if item.get_closest_marker("long")]
    short = [item for item in items if not item.get_closest_marker("long")]
    ends = [len(short) * k // count for k in range(count + 1)]
    items[:] = [item for k in range(count) for item in long[k::count] + short[ends[k]:ends[k + 1]]]
