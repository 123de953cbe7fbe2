"""The figure of the spots against the analysis that it shows, and queries that have none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.plots.plot import Area, Label, Map, Points
from lensbench.app.plots.query import query
from lensbench.app.plots.spots import BLUR, COLUMNS, spots_figure
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.spot_diagram import light_shares, spots
from lensbench.core.text import significant


def test_the_object_of_a_query_is_what_the_lens_is_focused_on():
    settings = Settings()
    asked = query(settings)
    assert asked.object_distance == pytest.approx(settings.focus_distance - asked.bench.film_z)
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


@pytest.mark.parametrize("reference", ["chief", "centroid"])
def test_the_blur_behind_a_spot_has_the_centroid_and_size_of_its_light(reference):
    """Samples of a 25th of a cell: the centroid to a tenth of one, the size but for the spread within a sample."""
    asked = query(replace(Settings(), lens="lenshh-cooke-triplet-50"))
    figure = spots_figure(asked, 24, reference=reference, rows=3, blur=True)
    (plot,), = figure.rows
    maps, rays = [layer for layer in plot.layers if isinstance(layer, Map)], asked.grid(24)
    shares, colours = light_shares(rays), len(rays.conditions.wavelengths)
    found = spots(rays, reference, [row[2] for row in figure.table.rows[:COLUMNS * colours:colours]])
    assert len(maps) == 3 * COLUMNS and plot.layers[:len(maps)] == tuple(maps)
    sample = 1.0 / BLUR
    at = (np.arange(BLUR) + 0.5) * sample - 0.5
    for light, (row, column) in zip(maps, np.ndindex(3, COLUMNS), strict=True):
        f = (0, 6, 11)[row]
        assert light.x == (column - 0.5, column + 0.5) and light.y == (-row - 0.5, 0.5 - row)
        share = light.values / light.values.sum()
        size = math.sqrt(share.sum(0) @ at**2 + share.sum(1) @ at**2)
        centre = shares[f] @ found.centroids[f, :, column] - found.references[f, column]
        assert (share.sum(0) @ at, share.sum(1) @ at) == pytest.approx(tuple(centre / plot.cell), abs=0.1 * sample)
        white = math.sqrt(float((shares[f] @ found.rms[f, :, column] ** 2).sum()))
        assert size == pytest.approx(white / plot.cell, rel=0.05, abs=0.3 * sample)
