"""Verdicts about curves, and the output of the command."""

import json
import math

import numpy as np
import pytest

from lensbench.app.command.main import main
from lensbench.app.studies.stability.sweep import LOST, Curve, Sweep, curve, quantity_text


def sweep(curves, values=(1.0, 10.0, 100.0), expected=()):
    return Sweep("Heat", "Heat", "K", np.array(values), "Length", "mm", 0.1, "a tenth", tuple(curves),
                  expected=expected)


def test_a_method_is_safe_before_its_first_failure_whatever_it_gives_later():
    method = curve("ruler", [0.01, 0.2, 0.001])
    result = sweep([method]).verdict(method)
    assert (result.safe_up_to, result.fails_at) == (1.0, 10.0)
    assert (result.returns, result.worst) == ("length off by 0.2 mm", 0.01)


def test_a_method_fails_where_it_has_no_answer_though_there_is_one():
    method = curve("ruler", [0.01, 0.02, "MISSED"])
    result = sweep([method]).verdict(method)
    assert (result.safe_up_to, result.fails_at, result.returns) == (10.0, 100.0, "MISSED")


@pytest.mark.parametrize("returned, right", [("MISSED", True), (LOST, True), ("NaN", False), (0.0, False)])
def test_where_there_is_no_answer_only_the_right_fate_is_right(returned, right):
    method = curve("ruler", [0.0, 0.0, returned])
    assert list(sweep([method], expected=("", "", "MISSED")).right(method)) == [True, True, right]


def test_a_method_that_is_wrong_at_once_is_safe_nowhere():
    method = curve("ruler", ["NaN", 0.0, 0.0])
    measured = sweep([method])
    assert measured.verdict(method).safe_up_to is None
    assert measured.words(method) == ("nowhere", "1 K", "NaN")


def test_a_curve_has_an_error_or_a_fate_at_every_value():
    with pytest.raises(ValueError, match="ruler"):
        Curve("ruler", np.array([math.nan]), ("",))
    with pytest.raises(ValueError, match="ruler"):
        Curve("ruler", np.array([0.1]), ("MISSED",))


@pytest.mark.parametrize("value, unit, words", [(1e12, "mm", "1e12 mm"), (0.00123456, "mm", "0.00123 mm"),
                                                (52.5, "°", "52.5°"), (1.78e-7, "", "1.8e-7"), (0.0, "px", "0 px")])
def test_numbers_have_three_digits_and_their_unit(value, unit, words):
    assert quantity_text(value, unit) == words


@pytest.mark.slow
def test_the_command_prints_a_table_and_writes_a_plot_of_each_sweep_with_an_index(tmp_path, capsys):
    folder = tmp_path / "sweeps"
    assert main(["stability", "refr", "-o", str(folder)]) == 0
    table = capsys.readouterr().out
    assert "Safe up to" in table and "TOTAL_REFLECTION" in table
    index = (folder / "index.md").read_text(encoding="utf-8")
    plots = {path.name for path in folder.glob("*.svg")}
    assert plots and all(f"({name})" in index for name in plots)
    assert {path.name for path in folder.iterdir()} == plots | {"index.md"}


def test_the_figures_are_json_that_any_reader_takes(capsys):
    assert main(["stability", "refraction", "--json"]) == 0
    for report in json.loads(capsys.readouterr().out):
        for method in report["methods"]:
            assert len(method["errors"]) == len(method["returned"]) == len(report["values"])
            assert all((error is None) == bool(fate)
                       for error, fate in zip(method["errors"], method["returned"], strict=True))


@pytest.mark.parametrize("wrong", [["optimism"], ["-o", "/dev/null/sweeps"], [""]])
def test_bad_input_is_one_line_that_says_what_to_do(wrong, capsys):
    assert main(["stability", *wrong]) == 2
    quantity_text = capsys.readouterr().err
    assert quantity_text.count("\n") == 1 and ("families are" in quantity_text or "name a folder" in quantity_text)


def test_ctrl_c_ends_the_command_in_one_line(monkeypatch, capsys):
    from lensbench.app.studies.stability import plots as families

    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr(families, "FAMILIES", {"Patience": {"Wait": interrupted}})
    assert main(["stability"]) == 130
    assert capsys.readouterr().err == "lensbench: stopped\n"
