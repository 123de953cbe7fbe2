"""The sheet of charts: text on its axes, and its files."""

import pytest

from lensbench.app.drawing.sheet import look, plot, save, sheet
from lensbench.app.session.export import ExportError


def drawn(values):
    figure = sheet(4.0, 3.0)
    plot(figure.add_subplot(), "Cost (ns)", "Error (px)", "A lens", log=True).plot(values, values)
    return figure


def test_ticks_are_plain_digits_where_these_are_few_and_powers_elsewhere():
    with look():
        figure = drawn([1e-6, 1e7])
        figure.canvas.draw()
        written = {label.get_position()[0]: label.get_text() for label in figure.axes[0].get_xticklabels()}
    assert written[1.0] == "1"
    assert {written.get(1e-5), written.get(1e-6)} & {"$10^{-5}$", "$10^{-6}$"}
    assert {written.get(1e3), written.get(100.0)} & {"1000", "100"}
    assert {written.get(1e6), written.get(1e7)} & {"$10^{6}$", "$10^{7}$"}


@pytest.mark.parametrize("suffix, begins", [("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_a_figure_is_written_as_its_suffix_says_the_same_bytes_each_time(tmp_path, suffix, begins):
    files = [tmp_path / f"{name}.{suffix}" for name in "ab"]
    for path in files:
        with look():
            save(drawn([1.0, 100.0]), path)
    first, second = (path.read_bytes() for path in files)
    assert first == second and first.startswith(begins)
    assert len(list(tmp_path.iterdir())) == 2          # no part is left


def test_what_no_chart_can_be_written_as_is_said(tmp_path):
    with look(), pytest.raises(ExportError, match=r"\.svg or \.png"):
        save(drawn([1.0, 2.0]), tmp_path / "chart.pdf")
    with look(), pytest.raises(ExportError, match="no folder"):
        save(drawn([1.0, 2.0]), tmp_path / "nowhere" / "chart.svg")
