"""The bokeh gallery: discs as large as their pictures hold, and a bar with their scale."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.plots.light_plots import BOKEH_FIELDS, bokeh_figure
from lensbench.app.plots.plot import Curve, Label, Map
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings


@pytest.mark.parametrize("lens", ["pbrt-fisheye-10mm", "apple-phone-6-elements-4-f18", "pbrt-dgauss-50mm"])
def test_the_bokeh_fills_its_pictures_and_a_bar_has_their_scale(lens):
    figure = bokeh_figure(query(with_lens(Settings(), lens)), 48)
    plot, table = figure.rows[0][0], figure.table
    light = [layer for layer in plot.layers if isinstance(layer, Map)]
    bars = [layer for layer in plot.layers if isinstance(layer, Curve)]
    named = [layer for layer in plot.layers if isinstance(layer, Label) and layer.side == "below"]
    for column in range(4):
        # A disk of even light that fills the picture has an rms radius of a third of its side
        widths = [row[2:5] for row in table.rows[4 * column:4 * column + 4]]
        assert max(np.hypot(s, t) / width for width, s, t in widths) > 0.08
        length = float(named[column].text.removesuffix(" µm"))
        cell = light[4 * column].x[1] - light[4 * column].x[0]
        assert np.ptp(bars[column].x) / cell == pytest.approx(length / widths[0][0], rel=1e-9)
        assert 0.15 < length / widths[0][0] < 0.6


def test_sizes_are_those_of_all_colours():
    """Second moments of all rays of all colours in one heap; those of the primary colour alone were listed."""
    asked = query(replace(with_lens(Settings(), "lenshh-cooke-triplet-50"), f_number=11.0, focus_distance=2000.0,
                          white="fdc"))
    rays = asked.grid(24, asked.few(*BOKEH_FIELDS))
    given = rays.conditions
    in_focus = [row for row in bokeh_figure(asked, 24).table.rows if row[1] == pytest.approx(2.0)]
    assert len(given.wavelengths) == 3 and len(in_focus) == len(BOKEH_FIELDS)
    for field, row in enumerate(in_focus):
        light = np.array(given.weights)[:, None, None] * rays.weight[field]
        for size, offset in zip(row[3:5], rays.light[:2, field], strict=True):
            white = np.average((offset - np.average(offset, weights=light)) ** 2, weights=light) ** 0.5
            assert size == pytest.approx(1000.0 * white, rel=1e-6)
            primary, own = light[given.primary], offset[given.primary]
            alone = np.average((own - np.average(own, weights=primary)) ** 2, weights=primary) ** 0.5
            assert white > 1.01 * alone


def test_names_of_fields_lie_beside_the_pictures():
    """They lay over the pictures of the first column, and over the distance above it."""
    plot = bokeh_figure(query(with_lens(Settings(), "pbrt-dgauss-50mm")), 24).rows[0][0]
    edge = min(layer.x[0] for layer in plot.layers if isinstance(layer, Map))
    names = [layer for layer in plot.layers if isinstance(layer, Label) and layer.side == "left middle"]
    assert [name.text for name in names] == ["axis", "10.8 mm", "17.3 mm", "21.6 mm"]
    assert all(plot.x.low < name.x <= edge for name in names)
