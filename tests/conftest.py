"""Laws are tried with the same random examples in every run; `pytest --hypothesis-seed=N` tries others."""

import pytest
from hypothesis import HealthCheck, settings


def pytest_configure(config: pytest.Config) -> None:
    """Before the tests are read, which take their settings from this profile. No law fails on a busy machine."""
    same = config.getoption("--hypothesis-seed") is None
    settings.register_profile("laws", derandomize=same, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    settings.load_profile("laws")
