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
    assert "choose from tracer, render" in capsys.readouterr().err
