"""Texts of figures: no power of ten that people do not use, no minus zero, words for what is no number."""

import ast
import math
import re
from decimal import ROUND_HALF_EVEN, Context, Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from lensbench.core.text import f_number_text, fixed, significant, true_minus

ROOT = Path(__file__).parents[2]
human = st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6)
digits = st.integers(1, 9)
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
FILES = {"core/text.py", "core/scenery/builtin/charts.py", "lenses/tables/text.py", "lenses/tables/rows.py",
         "lenses/formats/toml_header.py", "lenses/checks/figures.py", "app/drawing/sheet.py",
         "app/drawing/plot_axes.py",
         "app/bench/lens_choice.py", "app/scenes/opened_scenes.py", "app/settings/dial_scales.py",
         "app/studies/charts/curves.py",
         "app/studies/charts/methods.py", "app/studies/stability/sweep.py", "app/studies/stability/focusing.py"}


@given(human, digits)
def test_a_human_figure_has_no_power_of_ten_and_its_significant_digits(value, count):
    text = significant(value, count)
    assert re.fullmatch(r"-?\d+(\.\d*[1-9])?", text)
    exact = Context(prec=count, rounding=ROUND_HALF_EVEN).create_decimal(Decimal(value))
    assert float(text) == float(exact)


@given(st.floats(-1e300, 1e300), digits)
def test_every_other_figure_is_a_number_times_a_power_of_ten(value, count):
    text = significant(value, count)
    assert "e" not in text and not text.startswith("-0×") and text not in ("-0", "-0.0")
    mantissa, _, power = text.partition("×10")
    assert float(f"{mantissa}e{power.translate(RAISED) or 0}") == pytest.approx(value, rel=0.51 * 10.0 ** (1 - count))


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_fixed_decimals_are_rounded_and_have_no_minus_zero(value, decimals):
    text = fixed(value, decimals)
    assert re.fullmatch(rf"-?\d+(\.\d{{{decimals}}})?", text)
    assert abs(float(text) - value) <= 0.50001 * 10.0**-decimals
    assert not (text.startswith("-") and float(text) == 0.0)


@pytest.mark.parametrize(("value", "count", "text"), [
    (4900.0, 2, "4900"), (170.0, 2, "170"), (4932.0, 2, "4900"), (-0.0, 3, "0"), (1e-4, 2, "0.0001"), (2.5, 6, "2.5"),
    (1.5e-8, 3, "1.5×10⁻⁸"), (-2e12, 3, "-2×10¹²"), (999.96, 4, "1000"), (9.9996e-3, 4, "0.01"), (math.inf, 3, "∞"),
    (-math.inf, 3, "-∞"), (math.nan, 3, "nan"), (np.float32(0.5), 3, "0.5"), (36, 6, "36"),
    (Decimal("1.5"), 6, "1.5"),
])
def test_significant_digits(value, count, text):
    assert significant(value, count) == text


def test_signs_thousands_and_words():
    assert (significant(0.31, 2, signed=True), significant(0.0, 2, signed=True)) == ("+0.31", "0")
    assert (fixed(-0.0004, 3), fixed(-0.0006, 3), fixed(0.0004, 1, signed=True)) == ("0.000", "-0.001", "0.0")
    assert fixed(12345.67, 1, grouped=True) == "12,345.7"
    assert (fixed(math.nan, 2), fixed(-math.inf, 2)) == ("nan", "-∞")
    assert true_minus("-0.5 EV") == "−0.5 EV"


@pytest.mark.parametrize(("value", "text"), [
    (0.95, "f/0.95"), (1.0, "f/1"), (2.0, "f/2"), (2.8, "f/2.8"), (9.96, "f/10"), (22.0, "f/22"), (0.0, "none"),
    (None, "none"), (math.nan, "none"), (-4.0, "none"), (math.inf, "f/∞"), (0.004, "f/0.004"),
])
def test_an_f_number_is_engraved_and_never_zero(value, text):
    assert f_number_text(value) == text


def test_an_f_number_in_a_column_has_its_decimals():
    assert (f_number_text(2.0, 2), f_number_text(0.0, 2), f_number_text(0.001, 2)) == ("f/2.00", "none", "f/0.001")
    assert f_number_text(3.333, 2, "T/") == "T/3.33"


@pytest.mark.parametrize("room", ["core", "lenses", "app"])
def test_nothing_else_formats_figures(room):
    """Files, charts' axes and comparisons of digits have formats of their own (FILES)."""
    found = []
    for path in (ROOT / room).rglob("*.py"):
        if path.relative_to(ROOT).as_posix() in FILES:
            continue
        source = path.read_text(encoding="utf-8")
        if not re.search(r"[eEgGfF%]}", source):                # no format ends so
            continue
        for node in ast.walk(ast.parse(source)):
            spec = node.format_spec if isinstance(node, ast.FormattedValue) else None
            ends = spec.values[-1] if isinstance(spec, ast.JoinedStr) and spec.values else None
            if isinstance(ends, ast.Constant) and re.search(r"[eEgGfF%]$", str(ends.value)) and \
                    "DIGITS" not in ast.dump(spec):             # a number rounded to its digits, not a text
                found.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    assert found == []
