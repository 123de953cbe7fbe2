"""The text under the cursor of every map against the numbers of its figure."""

import re
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.plot import Area, Curve, Map, told
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings
from tests.core.test_figures import RAISED

ASKED = query(replace(Settings(), f_number=4.0, blades=6))
READ = re.compile(r"(.+?) ([+−-]?\d[\d.]*(?:e[+−-]?\d+)?)( .+|°)?")


def number(text):
    mantissa, _, power = text.replace("−", "-").partition("×10")
    return float(f"{mantissa}e{power.translate(RAISED) or 0}")


def close(shown, value):
    """Within the three printed digits."""
    return abs(number(shown) - value) <= 0.006 * abs(value) + 1e-12


def map_plots():
    """Every plot with a named map in the figures of all analyses."""
    for name, analysis in ANALYSES.items():
        try:
            figure = analysis.figure(ASKED, 16)
        except lb.LensError:
            continue
        for row in figure.rows:
            for plot in row:
                if any(isinstance(layer, Map) and layer.name for layer in plot.layers):
                    yield name, figure, plot


MAPS = list(map_plots())


def test_several_analyses_have_maps():
    assert {name for name, _, _ in MAPS} >= {"mtf-map", "psf", "sunstar", "wavefront"}


@pytest.mark.parametrize(("name", "figure", "plot"), MAPS, ids=[name for name, _, _ in MAPS])
def test_the_text_names_both_coordinates_and_the_value_of_the_cell(name, figure, plot):
    shades = next(layer for layer in plot.layers if isinstance(layer, Map))
    rows, columns = shades.values.shape
    x, y = (low + (np.arange(n) + 0.5) / n * (high - low) for (low, high), n in ((shades.x, columns), (shades.y, rows)))
    rng, areas = np.random.default_rng(3), [layer for layer in plot.layers if isinstance(layer, Area)]
    for _ in range(60):
        i, j = int(rng.integers(rows)), int(rng.integers(columns))
        if any(area.x[0] <= x[j] < area.x[1] and area.y[0] <= y[i] < area.y[1] for area in areas):
            continue
        lines = told(plot, x[j], y[i]).split("\n")
        if plot.x.label is not None:
            head, lines = lines[0].split(", "), lines[1:]
            assert len(head) == 2
            for words, axis, coordinate in zip(head, (plot.x, plot.y), (x[j], y[i]), strict=True):
                if abs(coordinate) < 1e-9:                      # zero but for rounding
                    continue
                label, unit = axis.label.rstrip(")").split(" (")
                match = READ.fullmatch(words)
                assert match is not None and match[1] == label and (match[3] or "").strip() == unit
                assert close(match[2], coordinate)
        value = next(line.split("   ")[1] for line in lines if line.startswith(f"{shades.name}   "))
        cell_value = shades.values[i, j]
        assert value == "–" if np.isnan(cell_value) else close(value, cell_value)
        for curve in (layer for layer in plot.layers if isinstance(layer, Curve) and layer.name):
            line = next((line for line in lines if line.startswith(f"{curve.name}   ")), None)
            if line is not None:                        # the curve read at the height of the cursor, with its unit
                shown, unit = line.split("   ")[1].split(" ")
                known = np.isfinite(curve.x + curve.y)
                assert unit == "mm" and close(shown, np.interp(y[i], curve.y[known], curve.x[known]))


def test_the_map_of_contrast_reads_as_its_table():
    figure, plot = next((figure, plot) for name, figure, plot in MAPS if name == "mtf-map")
    for height, shift, _, sagittal, tangential in figure.table.rows[::37]:
        head, value = told(plot, shift, height).split("\n")[:2]
        film, image = (words.rsplit(" ", 2) for words in head.split(", "))
        assert film[0] == "Film shift" and close(film[1], shift) and image[0] == "Image height"
        assert close(image[1], height) and close(value.split("   ")[1], 0.5 * (sagittal + tangential))


def test_the_map_of_a_point_reads_as_its_table():
    figure, plot = next((figure, plot) for name, figure, plot in MAPS if name == "psf")
    light = np.array(figure.table.rows, float)
    for across, up, density in light[::71]:
        value = told(plot, across, up).split("\n")[1].split("   ")[1]
        assert close(value, density / light[:, 2].max())
