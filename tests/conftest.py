"""Laws are tried with the same random examples in every run; `pytest --hypothesis-seed=N` tries others."""

import pytest
from hypothesis import settings


def pytest_configure(config: pytest.Config) -> None:
    """Before the tests are read, which take their settings from this profile."""
    if config.getoption("--hypothesis-seed") is None:
        settings.register_profile("same", derandomize=True)
        settings.load_profile("same")
