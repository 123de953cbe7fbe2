"""The figure of the spots against the analysis that it shows, and queries that have none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lensbench.analysis.spot_diagram import spots
from lensbench.app.state.analysis.figure import Area, Label, Points
from lensbench.app.state.analysis.query import query
from lensbench.app.state.analysis.spots import COLUMNS, spots_figure
from lensbench.app.state.settings import Settings
from lensbench.kernels.figures import significant


def test_the_object_of_a_query_is_what_the_lens_is_focused_on():
    settings = Settings()
    asked = query(settings)
    assert asked.object_distance == pytest.approx(settings.focus_distance - asked.setup.film_z)
    assert math.isinf(query(replace(settings, focus_distance=math.inf)).object_distance)
    assert asked.conditions().fields[-1][1] == pytest.approx(0.5 * settings.film.diagonal)


def test_a_camera_without_a_lens_has_nothing_to_analyse():
    with pytest.raises(ValueError, match="no lens to analyse"):
        query(replace(Settings(), camera="perspective"))


def test_every_drawn_point_is_a_ray_in_its_own_cell_and_the_table_holds_all_fields():
    asked = query(Settings())
    figure = spots_figure(asked, 16, rows=3)
    (plot,), = figure.rows
    (cloud,) = (layer for layer in plot.layers if isinstance(layer, Points) and layer.surface is None)
    cells = [layer for layer in plot.layers if isinstance(layer, Area)]
    assert len(cells) == 3 * COLUMNS
    inside = [sum(cell.x[0] <= x < cell.x[1] and cell.y[0] <= y < cell.y[1] for cell in cells)
              for x, y in zip(cloud.x, cloud.y, strict=True)]
    assert cloud.x.size > 500 and set(inside) == {1}
    # The middle column is the film: the rms radius of all its rays, in µm
    found = spots(asked.grid(16))
    words = [layer.text for layer in plot.layers if isinstance(layer, Label)]
    assert significant(1000.0 * found.white_rms_radius[0, 0], 2) in words and "axis" in words
    column = figure.table.head.index("rms radius (um)")
    of_film = [row[column] for row in figure.table.rows if row[2] == 0.0]
    np.testing.assert_allclose(of_film, 1000.0 * found.rms_radius.reshape(-1))
    assert figure.table.text().count("\n") == 1 + len(figure.table.rows) == 1 + 12 * COLUMNS


def test_a_lens_without_known_dispersion_has_one_wavelength_and_says_so():
    figure = spots_figure(query(Settings()), 16)
    assert "588 nm" in figure.conditions and "486" not in figure.conditions
    assert any("dispersion" in remark for remark in figure.remarks)
