"""The command `lensbench bench`: its parts by their present and former names."""

import json

import pytest

from lensbench.app.studies.benchmark import main as benchmark


@pytest.mark.parametrize(("part", "said"), [("light-tracing", ""),
                                            ("splats", "lensbench bench: splats is now light-tracing\n")])
def test_a_former_name_of_a_part_works_and_names_the_present_one(monkeypatch, capsys, part, said):
    monkeypatch.setitem(benchmark.PARTS, "light-tracing", lambda: iter([("error", 1.5, "‰")]))
    assert benchmark.main([part, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == said
    assert json.loads(printed.out)["figures"] == {"error": {"value": 1.5, "unit": "‰"}}


def test_an_unknown_part_is_an_error_that_lists_the_parts(capsys):
    with pytest.raises(SystemExit):
        benchmark.main(["speed"])
    assert "choose from start, drag" in capsys.readouterr().err


def test_each_figure_is_printed_as_it_is_measured_and_only_the_wanted_parts_run(monkeypatch, capsys):
    seen = []

    def measured(name):
        for value in (1.0, 2.0):
            yield f"{name} {value}", value, "ms"
            seen.append(capsys.readouterr().out)        # printed before the next figure is measured

    for name in ("tracer", "pupil", "precision"):
        monkeypatch.setitem(benchmark.PARTS, name, lambda name=name: measured(name))
    assert benchmark.main(["--only", "pupil,tracer"]) == 0
    assert ["pupil 1.0", "pupil 2.0", "tracer 1.0", "tracer 2.0"] == [
        line[:len("pupil 1.0") + line.startswith("tracer")] for text in seen for line in text.splitlines()[-1:]]
