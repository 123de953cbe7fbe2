"""The coating that the T-stop assumes."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import coating, missing_ghost
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.panels.readouts import Status, rows
from lensbench.app.settings.settings import Settings

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


def test_a_ghost_that_an_edit_took_away_is_named():
    shown = replace(Settings(), ghosts=True, ghost_pair="3-7")
    assert missing_ghost(shown) == missing_ghost(Settings()) == ""
    last = len(LENS.surfaces) - 1
    gone = replace(shown, ghost_pair=f"3-{last + 1}")
    said = missing_ghost(gone)
    assert said.startswith(f"no ghost of surfaces 3 and {last + 1}") and f"to {last}" in said
    assert missing_ghost(replace(gone, ghosts=False)) == missing_ghost(replace(gone, camera="fisheye")) == ""
    stop = LENS.stop_index                                  # of air on both sides: it reflects nothing
    assert f"surfaces 0 and {stop}" in missing_ghost(replace(shown, ghost_pair=f"0-{stop}"))
