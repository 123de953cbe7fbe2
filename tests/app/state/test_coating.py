"""The coating that the T-stop assumes."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.panels.readouts import Status, rows
from lensbench.app.state.coating import coating
from lensbench.app.state.figures import readings
from lensbench.app.state.settings import Settings

LENS = lenses.load("pbrt-dgauss-50mm")


@pytest.mark.parametrize(("year", "name"), [(1895, "uncoated"), (1945, "uncoated"), (1946, "single-layer"),
                                            (1970, "single-layer"), (1971, "multi-layer"), (None, "single-layer")])
def test_the_year_of_the_lens_says_the_coating(year, name):
    found = coating(Settings(), replace(LENS, year=year))
    assert found.name == name and (str(year) in found.why if year else "not known" in found.why)


def test_a_chosen_coating_wins_and_stands_beside_the_t_stop():
    for name in ("uncoated", "single-layer", "multi-layer"):
        settings = replace(Settings(), coating=name)
        got = readings(settings)
        stopped = lb.stopped_down(LENS, settings.f_number)
        assert got.t_number == pytest.approx(lb.t_number(stopped, name), rel=1e-9)
        row = next(row for row in rows(settings, got, Status()) if row.name.startswith("T-stop"))
        assert row.name == f"T-stop, {name}" and "chosen" in row.meaning


def test_the_coating_renders_nothing_again():
    assert replace(Settings(), coating="uncoated").picture == Settings().picture
