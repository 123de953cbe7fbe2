"""`lensbench lightfield chart`: figures of how near refocused light fields come, and the bound on their range."""

import json
import math

import pytest

from lensbench.app.command.main import main
from lensbench.app.studies.charts import methods

ARGUMENTS = ["lightfield", "chart", "pbrt-dgauss-50mm", "--lens-model", "thin", "--focus", "1.2m", "--f-number", "2.8",
             "--size", "48x32", "--views"]


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    path = tmp_path_factory.mktemp("chart") / "field.json"
    with pytest.MonkeyPatch.context() as patch:                 # less noise than the differences that are tested
        patch.setattr(methods, "LIGHT_FIELDS_RAYS", 4 * methods.LIGHT_FIELDS_RAYS)
        patch.setattr(methods, "TRUTH", 2 * methods.TRUTH)
        assert main([*ARGUMENTS, "2,6", "-o", str(path)]) == 0
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_more_views_come_nearer_and_reach_farther(figures):
    few, dense = figures["fields"]
    assert dense["near"] < few["near"] < 1200.0 and few["distances"] == dense["distances"]
    # Blur of two views across is four dots, wherever it is wide
    for distance, coarse, fine in zip(few["distances"], few["decibels"], dense["decibels"], strict=True):
        assert distance == 1200.0 or fine > coarse + 1.0


@pytest.mark.slow
def test_the_bound_is_where_views_part_by_a_pixel(figures):
    """A thin lens of aperture A focused at s sees a point at z aside by A f (1 / z − 1 / s) from side to side.

    Over n views these are n pixels.
    """
    few, dense = figures["fields"]
    parts = [1.0 / field["near"] - 1.0 / 1200.0 for field in (few, dense)]
    # Three times as many views reach three times as far, but for the lens that moves as it is focused: some percent
    assert parts[1] / parts[0] == pytest.approx(3.0, rel=0.15)
    assert few["far"] in ("inf", math.inf) or few["far"] > 1200.0


@pytest.mark.slow
def test_a_chart_is_drawn_and_what_cannot_be_is_said(tmp_path, capsys):
    assert main([*ARGUMENTS, "1,3", "-o", str(tmp_path / "field.svg")]) == 0
    assert "a pixel apart at" in capsys.readouterr().out
    assert "views" in (tmp_path / "field.svg").read_text(encoding="utf-8")
    for views, output, says in (("0", "a.svg", "whole numbers from 1"), ("3", "a.txt", "its figures as .json")):
        assert main([*ARGUMENTS, views, "-o", str(tmp_path / output)]) == 2
        assert says in capsys.readouterr().err and not (tmp_path / output).exists()
