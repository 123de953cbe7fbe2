"""The difference of two figures claims no digit that one of them does not have."""

import pytest

from lensbench.app.plots.comparison import difference


@pytest.mark.parametrize(("a", "b", "apart"), [
    ("50.4", "800", "+750"), ("17.3", "5.42", "−11.9"), ("46.5°", "3.10°", "−43.4°"), ("ø 18.0", "ø 8.99", "−9.0"),
    ("14", "5.42", "−8.6"), ("−1.5", "2", "+3.5"), ("16", "24", "+8"), ("10.0", "9.99", "0.0"),
    ("f/2.80", "f/5.60", "−2.0 EV"), ("36.1", "36.1", ""), ("1 : 21.9", "1 : 27.9", ""),
    ("22.0", "–", "")])
def test_a_difference_has_the_digits_of_the_less_precise_figure(a, b, apart):
    assert difference(a, b) == apart
