"""The figures of fans, field curves and MTF against the analyses that they show."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.analysis.transfer_function import mtf
from lensbench.app.state.analysis.fans import fans_figure
from lensbench.app.state.analysis.field_figures import field_figure
from lensbench.app.state.analysis.figure import Curve, Map
from lensbench.app.state.analysis.film_drag import focus_at
from lensbench.app.state.analysis.mtf_figures import mtf_field_figure, mtf_frequency_figure, mtf_map_figure
from lensbench.app.state.analysis.query import query
from lensbench.app.state.settings import Settings

ASKED = query(Settings())


def column(figure, name):
    at = figure.table.head.index(name)
    return np.array([row[at] for row in figure.table.rows], float)


def test_a_vignetted_part_of_a_fan_is_grey_and_meets_the_other():
    figure = fans_figure(ASKED, 16, rows=2)
    tangential = figure.rows[-1][0]
    grey = next(layer for layer in tangential.layers if isinstance(layer, Curve) and layer.name == "vignetted")
    full = next(layer for layer in tangential.layers if isinstance(layer, Curve) and layer.name == "588 nm")
    shown, lost = np.isfinite(full.y), np.isfinite(grey.y)
    assert 0 < shown.sum() < full.y.size and (shown | lost).all()
    assert 1 <= (shown & lost).sum() <= 2
    assert "lost" in tangential.title and "lost" not in figure.rows[0][0].title


def test_curves_over_the_field_end_where_the_light_ends():
    fisheye = query(replace(Settings(), lens="pbrt-fisheye-10mm", f_number=None))
    corner = 0.5 * fisheye.setup.film.diagonal
    assert fisheye.largest_height < corner
    figure = field_figure(fisheye, 8)
    heights = column(figure, "image height (mm)")
    assert heights[-1] == pytest.approx(fisheye.largest_height, rel=1e-3)
    assert any("edge of light" in remark for remark in figure.remarks)
    assert [plot.x.high for plot in figure.rows[0]] == pytest.approx([heights[-1]] * 3)


def test_an_anamorphic_lens_has_no_curves_over_the_field_and_says_why():
    squeezed = query(replace(Settings(), lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    with pytest.raises(lb.LensError, match="cylinder"):
        field_figure(squeezed, 8)


def test_the_mtf_of_the_maker_chart_is_that_of_the_curves():
    rays = ASKED.grid(16, ASKED.parts(0.0, 0.7, 1.0))
    expected = mtf(rays, [10.0]).white_modulus[:, :, 0]
    figure = mtf_frequency_figure(ASKED, 16)
    at_10 = column(figure, "frequency (lp/mm)") == 10.0
    np.testing.assert_allclose(column(figure, "sagittal")[at_10], expected[:, 0], rtol=1e-9)
    curves = {layer.name: layer for layer in mtf_field_figure(ASKED, 16).rows[0][0].layers}
    assert np.interp(0.0, curves["10 T"].x, curves["10 T"].y) == pytest.approx(expected[0, 1], rel=1e-6)


def test_the_film_dragged_to_a_shift_of_the_map_is_focused_there():
    figure = mtf_map_figure(ASKED, 8)
    shades = figure.rows[0][0].layers[0]
    assert isinstance(shades, Map) and shades.values.shape == (9, 17)
    assert focus_at(ASKED, 0.0) == pytest.approx(ASKED.focus_distance, rel=1e-6)
    near = focus_at(ASKED, 0.1)
    assert near < ASKED.focus_distance
    moved = query(replace(Settings(), focus_distance=near, focus_position="paraxial"))
    still = query(replace(Settings(), focus_position="paraxial"))
    assert moved.setup.film_distance - still.setup.film_distance == pytest.approx(0.1, abs=1e-3)
