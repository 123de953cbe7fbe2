"""The figures of the panel *Tolerances*: what is drawn is what the table says, and the design lies by the median."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.plots.plot import Bars, Curve, Label, Map, unit_of
from lensbench.app.plots.query import query
from lensbench.app.plots.tolerance_plots import (
    SHARES, SHOWN, copies_figure, cost_figure, error_name, pictures_figure, with_copy
)
from lensbench.app.settings.settings import Settings
from lensbench.core.design.tolerances import Tolerances

TRIPLET = replace(Settings(), lens="lenshh-cooke-triplet-50", f_number=5.6, film_width=24.0, film_height=16.0)


@pytest.mark.slow
def test_the_costs_are_bars_with_the_signs_of_their_errors():
    figure = cost_figure(query(TRIPLET), 1, Tolerances(decentre=0.1))
    assert [unit_of(plot.y.label) for row in figure.rows for plot in row] == ["µm", "% contrast"]   # all of a low panel
    (spots,), (losses,) = figure.rows
    for plot, column, scale in ((spots, 3, 1000.0), (losses, 4, -100.0)):
        (bars,) = [layer for layer in plot.layers if isinstance(layer, Bars)]
        assert bars.y.tolist() == [scale * row[column] for row in figure.table.rows[:SHOWN]]
        assert plot.y.low < bars.y.min() <= bars.y.max() < plot.y.high
        labels = [layer.text for layer in plot.layers if isinstance(layer, Label)]
        assert labels[0] == f"d{figure.table.rows[0][1]:.0f}" and len(labels) == SHOWN
    assert figure.remarks == (f"the costliest: {error_name('decentre', int(figure.table.rows[0][1]))}, ± 0.1 mm",)


@pytest.mark.slow
def test_the_copies_lie_around_the_design():
    figure = copies_figure(query(TRIPLET), 60, Tolerances())
    (axis, _, corner), = figure.rows
    curves = [layer for layer in corner.layers if isinstance(layer, Curve)]
    assert len(axis.layers) == 4 and len(curves) == 8
    for median, low, high in (curves[0:3], curves[4:7]):
        assert (low.y <= median.y).all() and (median.y <= high.y).all()
    assert np.abs(curves[0].y - curves[3].y).max() < 0.1
    assert len(figure.table.rows) == 5 * len(curves[0].x) * 2 and "60 copies" in figure.conditions


@pytest.mark.slow
def test_the_pictures_stand_in_the_order_of_their_contrast_and_a_copy_is_taken_as_an_edited_lens():
    figure = pictures_figure(query(TRIPLET), 1, Tolerances(decentre=0.05))
    ((plot,),) = figure.rows
    assert sum(isinstance(layer, Map) for layer in plot.layers) == 3 * (1 + len(SHARES))
    design, *copies = figure.table.rows
    assert [row[0] for row in copies] == list(SHARES)
    contrast = [row[2] for row in copies]
    assert contrast == sorted(contrast, reverse=True) and 0.0 < design[2] < 1.0
    longer = replace(TRIPLET, focal_length=75.0)
    copies = pictures_figure(query(longer), 1, Tolerances(decentre=0.05)).table.rows[1:]
    taken = with_copy(longer, Tolerances(decentre=0.05), 4)
    lens = query(taken).lens
    assert not lens.is_rotationally_symmetric and lens.name.endswith(f"copy {copies[4][1]}")
    assert query(taken).bench.at_infinity.efl == pytest.approx(75.0, rel=1e-2)


@pytest.mark.slow
def test_errors_that_darken_a_field_are_shown_and_said():
    """A phone lens at the edge of its light: copies of which no ray of the outermost field arrives."""
    asked, within = query(with_lens(Settings(), "apple-phone-6-elements-4-f18")), Tolerances(thickness=0.4)
    costs, copies, pictures = (make(asked, count, within) for make, count in (
        (cost_figure, 16), (copies_figure, 60), (pictures_figure, 16)))
    assert any("no light of a field arrives" in each for each in costs.remarks)
    assert any("of the copies" in each for each in copies.remarks)
    assert "dark" in [layer.text for layer in costs.rows[0][0].layers if isinstance(layer, Label)]
    for figure in (costs, copies, pictures):
        for plot in (plot for row in figure.rows for plot in row):
            assert np.isfinite([plot.x.low, plot.x.high, plot.y.low, plot.y.high]).all()
            assert not any(np.isnan(layer.y).any() for layer in plot.layers if isinstance(layer, Curve))
