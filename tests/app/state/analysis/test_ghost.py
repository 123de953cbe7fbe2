"""A behind B in the figures, the rays that surfaces end, and the ray of a mark."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.panels.analysis.under_cursor import told
from lensbench.app.state.analysis.fans import fans_figure
from lensbench.app.state.analysis.field_figures import field_figure
from lensbench.app.state.analysis.figure import Bars, Curve, Points
from lensbench.app.state.analysis.ghost import with_ghost
from lensbench.app.state.analysis.mtf_figures import mtf_field_figure
from lensbench.app.state.analysis.query import query
from lensbench.app.state.analysis.seidel_figure import seidel_figure
from lensbench.app.state.analysis.spot_ray import nearest_ray, pointed_ray
from lensbench.app.state.analysis.spots import spots_figure
from lensbench.app.state.settings import Settings

B, A = query(replace(Settings(), f_number=4.0)), query(replace(Settings(), f_number=2.0))


def test_curves_of_a_are_behind_those_of_b_and_read_beside_them():
    b, a = mtf_field_figure(B, 16), mtf_field_figure(A, 16)
    both = with_ghost(b, a, "wide open")
    plot, own, other = both.rows[0][0], b.rows[0][0].layers[0], a.rows[0][0].layers[0]
    ghosts = [layer for layer in plot.layers if isinstance(layer, Curve) and layer.ghost]
    assert len(ghosts) == 8 and plot.layers.index(ghosts[-1]) < plot.layers.index(own)
    assert [layer.name for layer in plot.named()] == [*(layer.name for layer in b.rows[0][0].named()), "A"]
    line = next(each for each in told(plot, 0.0, 0.5).split("\n") if each.startswith(f"{own.name}   "))
    _, mine, its, less = line.split("   ")
    assert float(mine) == pytest.approx(own.y[0], abs=6e-4) and float(its[2:]) == pytest.approx(other.y[0], abs=6e-4)
    assert float(less.replace("−", "-")) == pytest.approx(own.y[0] - other.y[0], rel=0.06)
    assert both.table.head[0] == "lens" and {row[0] for row in both.table.rows} == {"A", "B"}
    assert any("wide open" in remark for remark in both.remarks)


def test_spots_of_a_have_the_scale_of_b():
    b, a = spots_figure(B, 16), spots_figure(A, 16)
    assert a.rows[0][0].cell > b.rows[0][0].cell            # wide open the spots are larger
    plot = with_ghost(b, a, "wide open").rows[0][0]
    ghost = next(layer for layer in plot.layers if isinstance(layer, Points) and layer.ghost)
    its = next(layer for layer in a.rows[0][0].layers if isinstance(layer, Points))
    middle = (np.round(its.x), np.round(its.y))
    size = np.hypot(its.x - middle[0], its.y - middle[1]) * a.rows[0][0].cell
    shown = np.hypot(ghost.x - np.round(ghost.x), ghost.y - np.round(ghost.y)) * b.rows[0][0].cell
    assert shown.max() <= 0.71 * b.rows[0][0].cell and len(shown) <= len(size)
    assert set(np.round(shown, 9)) <= set(np.round(size, 9))


def test_axes_hold_both_and_other_surfaces_or_no_figure_are_said():
    triplet = query(replace(Settings(), lens="lenshh-cooke-triplet-50", f_number=None))
    b, a = field_figure(B, 8), field_figure(A, 8)
    for one, whole in zip(a.rows[0], with_ghost(b, a, "A").rows[0], strict=True):
        assert whole.y.low <= one.y.low and whole.y.high >= one.y.high
    bars = with_ghost(seidel_figure(B, 16), seidel_figure(triplet, 16), "triplet").rows[0][0].layers
    assert not any(isinstance(layer, Bars) and layer.ghost for layer in bars)
    assert "no such figure: afocal" in with_ghost(b, None, "A", "afocal").remarks[-1]


def test_rays_that_a_lit_surface_ends_are_marked_in_fans_and_spots():
    figure, fans = spots_figure(A, 16), fans_figure(A, 16)
    for layers in (figure.rows[0][0].layers, fans.rows[-1][0].layers):
        ended = {layer.surface for layer in layers if isinstance(layer, Points | Curve)} - {None}
        assert len(ended) >= 2
    lit = next(layer for layer in seidel_figure(A, 16).rows[0][0].layers if isinstance(layer, Bars))
    assert lit.surface == 0 and lit.x[0] == 1.0


def test_the_ray_of_a_mark_lands_where_the_mark_is():
    settings = replace(Settings(), f_number=4.0)
    figure = spots_figure(B, 16)
    plot, marks = figure.rows[0][0], next(layer for layer in figure.rows[0][0].layers if isinstance(layer, Points))
    middle = np.flatnonzero((np.round(marks.x) == 2) & (np.round(marks.y) == -2))
    i = int(middle[7])
    key = nearest_ray(plot, float(marks.x[i]), float(marks.y[i]))
    assert key == tuple(marks.rays[i])
    ray, rays = pointed_ray(settings, figure.points, key), B.grid(figure.points)
    landed = ray.path[-1, :2] - rays.images[key[0]]
    offset = rays.offset_s[key] * rays.beams.axes[key[0], 0] + rays.offset_t[key] * rays.beams.axes[key[0], 1]
    np.testing.assert_allclose(landed, offset, atol=1e-7)
    shown = np.array([marks.x[i] - 2.0, marks.y[i] + 2.0]) * plot.cell
    np.testing.assert_allclose(landed @ rays.beams.axes[key[0]].T, shown, atol=1e-7)
    assert len(ray.path) == len(B.lens.surfaces) + 2 and ": from" in ray.end
    assert nearest_ray(plot, 0.5, 0.5) is None
