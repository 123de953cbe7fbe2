"""The status bar: no speed above zero reads as none."""

import pytest

from lensbench.app.window.bars import speed_text


@pytest.mark.parametrize(("rate", "text"), [
    (134.4e6, "134"), (9.96e6, "10"), (9.94e6, "9.9"), (4.21e6, "4.2"), (0.3e6, "0.3"), (43210.0, "0.043")])
def test_a_speed_has_two_digits_at_least(rate, text):
    assert speed_text(rate) == f"{text} Msamples/s"
