"""`lensbench check`: its table, its JSON, and 0, 1 or 2 for clean, found and no lens."""

import json

import pytest

from lensbench import lenses
from lensbench.app.command.main import main

NAME = "pbrt-dgauss-50mm"


@pytest.fixture
def spoiled(tmp_path):
    """A double Gauss whose first radius has lost its sign."""
    text = (lenses.library.catalogue.path_of(NAME)).read_text(encoding="utf-8")
    assert "29.475" in text
    path = tmp_path / "spoiled.toml"
    path.write_text(text.replace("29.475", "-29.475", 1), encoding="utf-8")
    return str(path)


def test_a_clean_lens_ends_with_0(capsys):
    assert main(["check", NAME]) == 0
    assert capsys.readouterr().out == f"{NAME}: nothing found\n"


def test_findings_end_with_1_and_say_where_and_what(capsys, spoiled):
    assert main(["check", spoiled]) == 1
    out = capsys.readouterr().out
    assert out.startswith(f"{spoiled}: ") and "focal-length" in out
    assert "Proposal: radius of surface 0: 29.475 instead of -29.475" in out
    assert out.index("Probable cause\n") < out.index("Proposal") < out.index("Findings\n") < out.index("focal-length")


def test_a_file_without_a_lens_ends_with_2_and_one_line_and_the_others_are_checked(capsys, spoiled, tmp_path):
    assert main(["check", str(tmp_path / "none.toml"), NAME, spoiled]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1 and "there is no such file" in captured.err
    assert f"{NAME}: nothing found" in captured.out and "Proposal" in captured.out


def test_json_is_a_list_of_files_with_their_findings(capsys, spoiled, tmp_path):
    assert main(["check", "--json", NAME, spoiled, str(tmp_path / "none.toml")]) == 2
    clean, damaged, missing = json.loads(capsys.readouterr().out)
    assert clean == {"file": NAME, "error": None, "findings": []}
    assert {"kind", "surface", "message", "proposal", "severity", "figures", "change"} == damaged["findings"][0].keys()
    first = damaged["findings"][0]
    assert first["kind"] == "sign"
    assert first["change"] == {"quantity": "radius", "surface": 0, "before": -29.475, "after": 29.475}
    assert first["figures"]["focal_length"] < 0.0
    assert first["figures"]["focal_length_after"] == pytest.approx(50.0, rel=0.01)
    assert missing["findings"] == [] and "no such file" in missing["error"]


def test_what_a_reader_assumed_is_told_and_does_not_count(capsys, tmp_path):
    lenses.save(lenses.load(NAME), tmp_path / "lens.dat")
    text = (tmp_path / "lens.dat").read_text(encoding="utf-8")
    rows = [line.split() for line in text.split("\n") if line and not line.startswith("#")]
    in_cm = "\n".join(f"{float(r) / 10} {float(t) / 10} {n} {float(d) / 10}" for r, t, n, d in rows)
    (tmp_path / "cm.dat").write_text(f"# units: cm\n{in_cm}\n", encoding="utf-8")
    assert main(["check", str(tmp_path / "cm.dat")]) == 0
    assert "unit" in capsys.readouterr().out
