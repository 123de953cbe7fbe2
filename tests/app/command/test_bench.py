"""`lensbench bench`: its parts and its figures."""

import json

import pytest

from lensbench.app.benchmark import parts as benchmark
from lensbench.app.command.main import main


def test_a_part_is_run_by_its_name(monkeypatch, capsys):
    monkeypatch.setitem(benchmark.PARTS, "light-tracing", lambda: iter([("error", 1.5, "‰")]))
    assert main(["bench", "light-tracing", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["figures"] == {"error": {"value": 1.5, "unit": "‰"}}


@pytest.mark.parametrize("words", [["speed"], ["--only", "pupil,speed"]])
def test_an_unknown_part_is_an_error_in_one_line_that_lists_the_parts(capsys, words):
    assert main(["bench", *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith("lensbench: ") and error.count("\n") == 1
    assert "no part is called 'speed': choose from start, drag" in error


def test_each_figure_is_printed_as_it_is_measured_and_only_the_wanted_parts_run(monkeypatch, capsys):
    parts_run = []

    def measured(name):
        for value in (1.0, 2.0):
            yield f"{name} {value}", value, "ms"
            parts_run.append(capsys.readouterr().out)        # printed before the next figure is measured

    for name in ("tracer", "pupil", "precision"):
        monkeypatch.setitem(benchmark.PARTS, name, lambda name=name: measured(name))
    assert main(["bench", "--only", "pupil,tracer"]) == 0
    assert ["pupil 1.0", "pupil 2.0", "tracer 1.0", "tracer 2.0"] == [
        line[:len("pupil 1.0") + line.startswith("tracer")] for text in parts_run for line in text.splitlines()[-1:]]
