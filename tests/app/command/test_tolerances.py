"""The command `lensbench tolerances`: its table, its numbers and its chart."""

import json

import pytest

from lensbench.app.command.main import main
from lensbench.app.plots.tolerance_plots import amount

LENS = "lenshh-cooke-triplet-50"


@pytest.mark.slow
def test_the_command_prints_errors_and_percentiles_and_draws_a_chart(capsys, tmp_path):
    chart = tmp_path / "band.svg"
    assert main(["tolerances", LENS, "--f-number", "5.6", "--image-height", "15", "--copies", "50", "--decentre", "0.1",
                 "-o", str(chart)]) == 0
    said = capsys.readouterr().out
    assert "decentre of element at" in said.splitlines()[1] and "± 0.1 mm" in said.splitlines()[1]
    assert "50 copies, contrast at 30 cycles/mm" in said and "<svg" in chart.read_text(encoding="utf-8")
    assert main(["tolerances", LENS, "--f-number", "5.6", "--copies", "20", "--json", "--tilt", "0"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["copies"] == 20 and {error["kind"] for error in report["errors"]} == {
        "radius", "thickness", "index", "decentre"}
    low, high = (report["percentiles"][name][0][2][0] for name in ("5", "95"))
    assert low <= high


def test_what_cannot_be_drawn_or_drawn_at_random_is_refused(capsys):
    assert main(["tolerances", LENS, "-o", "band.pdf"]) == 2 and ".svg" in capsys.readouterr().err
    assert main(["tolerances", LENS, "--seed", "-1"]) == 2 and "--seed" in capsys.readouterr().err
    for option, value, told in (("radius", "80", "less than 50 PERCENT"), ("tilt", "-1", "less than 1719 ARCMIN"),
                                ("tilt", "nan", "--tilt nan"), ("thickness", "0.5", "less than 0.5 MM"),
                                ("image-height", "nan", "at least 0"), ("image-height", "0", "more than 0")):
        assert main(["tolerances", LENS, f"--{option}", value]) == 2
        assert told in capsys.readouterr().err
    assert [amount("radius", 0.001), amount("tilt", 0.00029088820866572158), amount("index", 0.0005)] == [
        "± 0.1 %", "± 1′", "± 0.0005"]
