"""Figures of analyses in files: every layer in SVG and PNG, the numbers in CSV."""

import csv
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.drawing import sheet
from lensbench.app.drawing.sheet import look, write_figure
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.plot import Area, Axis, Bars, Curve, Figure, Label, Map, Plot, Points, Table
from lensbench.app.plots.query import query
from lensbench.app.session.export import ExportError
from lensbench.app.settings.settings import Settings

X = np.linspace(0.0, 1.0, 5)
LAYERS = (Map("contrast", np.outer(X, X), (0.0, 1.0), (0.0, 1.0), levels=(0.5,)), Curve("587 nm", X, X**2, 0.5876),
          Points("486 nm", X, X, 0.4861, "triangle"), Bars("S_I", X, X, 0.1, "chart2"), Label(0.5, 0.5, "axis"),
          Area((0.0, 1.0), (0.0, 1.0), "said of it"))
FIGURE = Figure("Everything", ((Plot(Axis("Field (mm)", 0.0, 1.0), Axis("Contrast", 0.0, 1.0), LAYERS, "One"),),),
                Table(("field (mm)", "fan", "value"), ((0.0, "sagittal", 0.25), (1.0, "tangential", np.nan))),
                "object 1.20 m", ("3 rays are lost",))


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_a_drawn_figure_has_its_words_and_is_the_same_each_time(tmp_path, suffix):
    paths = tmp_path / f"one{suffix}", tmp_path / f"two{suffix}"
    for path in paths:
        write_figure(FIGURE, path, "A lens")
    first, second = (path.read_bytes() for path in paths)
    assert first == second and len(first) > 2000
    if suffix == ".svg":
        assert all(words in first.decode() for words in ("A lens: Everything", "587 nm", "3 rays are lost"))


@pytest.mark.slow
def test_the_axis_of_surfaces_has_no_figure_beyond_the_last(tmp_path):
    figure = replace(FIGURE, rows=((Plot(Axis("Surface", -0.6, 12.2, whole=10), Axis("Sum", 0.0, 1.0), LAYERS[1:2]),),))
    write_figure(figure, tmp_path / "sums.svg", "A lens")
    drawn = (tmp_path / "sums.svg").read_text(encoding="utf-8")
    assert "<!-- 10 -->" in drawn and "<!-- 12 -->" not in drawn


def test_numbers_are_read_back_and_a_missing_one_is_empty(tmp_path):
    write_figure(FIGURE, tmp_path / "data.csv")
    with (tmp_path / "data.csv").open(newline="") as file:
        assert list(csv.reader(file)) == [["field (mm)", "fan", "value"], ["0", "sagittal", "0.25"],
                                          ["1", "tangential", ""]]


def test_an_infinite_number_is_written_as_such_and_not_as_a_missing_one():
    """The farthest sharp distance beyond the hyperfocal one; a reader such as `float` takes both words."""
    table = Table(("nearest (m)", "farthest (m)", "none"), ((-np.inf, np.float64(np.inf), np.nan),))
    assert table.text() == "nearest (m),farthest (m),none\n-inf,inf,\n"
    assert table.text("\t").splitlines()[1] == "-inf\tinf\t"


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(ExportError, match="suffixes"):
        write_figure(FIGURE, tmp_path / "figure.gif")


@pytest.mark.slow
def test_a_map_of_equal_units_is_drawn_without_distortion(tmp_path):
    from PIL import Image

    y, x = np.mgrid[-1.0:1.0:41j, -1.0:1.0:41j]
    disc = Map("", np.where(np.hypot(x, y) < 0.8, 0.0, np.nan), (-1.0, 1.0), (-1.0, 1.0))
    plot = Plot(Axis(None, -1.0, 1.0), Axis(None, -1.0, 1.4), (disc,), equal=True)
    write_figure(Figure("Disc", ((plot,),), Table((), ()), ""), tmp_path / "disc.png", "A lens")
    dark = np.asarray(Image.open(tmp_path / "disc.png").convert("L")) < 8
    dark[:dark.shape[0] // 8] = False                           # the title
    rows, columns = np.flatnonzero(dark.any(1)), np.flatnonzero(dark.any(0))
    assert np.ptp(rows) > 50 and np.ptp(rows) == pytest.approx(np.ptp(columns), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("lens", ["lentil-schneider-anamorphic-31-2001", "lv-nikon-z-58f095-noct"])
def test_words_of_every_sheet_lie_within_it_and_beside_the_legend(lens):
    """Long conditions were cut off at the right, and the title ran into the legend."""
    asked = query(replace(Settings(), lens=lens, f_number=4.0, blades=7))
    for name, about in ANALYSES.items():
        try:
            figure = about.figure(asked, 16)
        except lb.LensError:
            continue
        with look():
            drawn = sheet._drawn(figure, f"{asked.lens.name}, f/2.8")
            drawn.draw_without_rendering()
            page, title = drawn.bbox, drawn._suptitle.get_window_extent()
            for words in (title, drawn._supxlabel.get_window_extent(),
                          *(axes.title.get_window_extent() for axes in drawn.axes)):
                assert page.x0 <= words.x0 and words.x1 <= page.x1, name
            assert all(not title.overlaps(legend.get_window_extent()) for legend in drawn.legends), name
