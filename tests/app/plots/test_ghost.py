"""A behind B in the figures, the rays that surfaces end, and the ray of a mark."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.ray_fans import end_text
from lensbench.app.plots.aperture_plots import illumination_figure, stack_figure
from lensbench.app.plots.comparison import with_ghost
from lensbench.app.plots.field_plots import depth_figure, field_figure
from lensbench.app.plots.light_plots import bokeh_figure, field_direction, ghosts_figure, raster_of
from lensbench.app.plots.plot import Bars, Curve, Map, Points, told, unit_of
from lensbench.app.plots.point_plots import (
    encircled_figure, line_spread_figure, mtf_field_figure, mtf_frequency_figure, mtf_map_figure, psf_figure
)
from lensbench.app.plots.query import query, victims
from lensbench.app.plots.ray_plots import fans_figure, seidel_figure, wavefront_figure
from lensbench.app.plots.spots import nearest_ray, pointed_ray, spots_figure
from lensbench.app.settings.settings import Settings

B, A = query(replace(Settings(), f_number=4.0)), query(replace(Settings(), f_number=2.0))


def test_curves_of_a_are_behind_those_of_b_and_read_beside_them():
    b, a = mtf_field_figure(B, 16), mtf_field_figure(A, 16)
    both = with_ghost(b, a, "wide open")
    plot, own, other = both.rows[0][0], b.rows[0][0].layers[0], a.rows[0][0].layers[0]
    ghosts = [layer for layer in plot.layers if isinstance(layer, Curve) and layer.ghost]
    assert len(ghosts) == 4 and plot.layers.index(ghosts[-1]) < plot.layers.index(own)
    assert [layer.name for layer in plot.named()] == [*(layer.name for layer in b.rows[0][0].named()), "A"]
    line = next(each for each in told(plot, 0.0, 0.5).split("\n") if each.startswith(f"{own.name}   "))
    _, mine, its, less = line.split("   ")
    assert float(mine) == pytest.approx(own.y[0], abs=6e-4) and float(its[2:]) == pytest.approx(other.y[0], abs=6e-4)
    assert float(less.replace("−", "-")) == pytest.approx(own.y[0] - other.y[0], rel=0.06)
    assert both.table.head[0] == "lens" and {row[0] for row in both.table.rows} == {"A", "B"}
    assert any("wide open" in remark for remark in both.remarks)


def test_of_a_lens_with_other_surfaces_the_sums_are_drawn_and_all_columns_are_listed():
    other = query(replace(Settings(), lens="lv-nikon-z-58f095-noct", f_number=None))
    b, a = seidel_figure(B, 16), seidel_figure(other, 16)
    both = with_ghost(b, a, "Noct")
    assert len(a.table.rows) > len(b.table.rows) and len(a.table.head) > len(b.table.head)
    assert both.table.head == ("lens", *a.table.head)               # which has two colours more
    sums = {row[0]: row for row in both.table.rows if row[1] == "sum"}
    assert sums["A"][1:] == a.table.rows[-1] and sums["B"][1:len(b.table.head) + 1] == b.table.rows[-1]
    assert all(math.isnan(value) for value in sums["B"][len(b.table.head) + 1:])
    plot = both.rows[0][0]
    ghosts = [layer for layer in plot.layers if isinstance(layer, Bars) and layer.ghost]
    assert [layer.y[0] for layer in ghosts] == list(a.table.rows[-1][1:6])
    own = [layer for layer in plot.layers if isinstance(layer, Bars) and layer.x.size == 1 and not layer.ghost]
    assert [layer.x[0] for layer in ghosts] == [layer.x[0] for layer in own]
    assert "A: sum of all surfaces" in told(plot, own[2].x[0], 0.0)


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
    assert all(layer.x.size == 1 for layer in bars if isinstance(layer, Bars) and layer.ghost)
    assert "no such plot: afocal" in with_ghost(b, None, "A", "afocal").remarks[-1]


def test_rays_that_a_lit_surface_ends_are_marked_in_fans_and_spots():
    figure, fans = spots_figure(A, 16), fans_figure(A, 16)
    for layers in (figure.rows[0][0].layers, fans.rows[-1][0].layers):
        ended = {layer.surface for layer in layers if isinstance(layer, Points | Curve)} - {None}
        assert len(ended) >= 2
    lit = next(layer for layer in seidel_figure(A, 16).rows[0][0].layers if isinstance(layer, Bars))
    assert lit.surface == 0 and lit.x[0] == 0.0


def test_surfaces_have_the_numbers_of_the_table_of_surfaces_from_0():
    """Panels counted them from 1, and the table of surfaces, `check` and files from 0."""
    sums = seidel_figure(A, 16)
    assert [row[0] for row in sums.table.rows] == [*map(str, range(len(A.lens.surfaces))), "sum"]
    fans = fans_figure(A, 16)
    marked = {layer.surface for row in fans.rows for plot in row for layer in plot.layers} - {None}
    assert {str(surface) for surface in marked} <= {row[-1] for row in fans.table.rows}
    assert str(A.lens.stop_index) in {row[-1] for row in fans.table.rows}
    pairs = {row[0] for row in ghosts_figure(A, 8).table.rows}
    reflect = [i for i in range(len(A.lens.surfaces)) if i != A.lens.stop_index]
    assert {int(number) for pair in pairs for number in pair.split("-")} == set(reflect)
    assert "surface 3" in end_text(A.lens, lb.Fate.CLIPPED, 3)


@pytest.mark.parametrize("pose", [{}, {"rise": 6.0, "shift": -3.0}, {"tilt": 0.1, "swing": -0.05, "rise": 2.0}])
def test_the_picture_shows_a_ghost_where_its_ray_meets_the_film(pose):
    """The mark was that of a centred film."""
    settings, path = replace(Settings(), **pose), np.array([[2.0, -1.0, 40.0], [5.0, 4.0, 90.0]])
    pixel = raster_of(settings, path)
    film, (column, row) = settings.film, pixel
    own = (0.5 - column / film.pixels_x) * film.width, (row / film.pixels_y - 0.5) * film.height
    there = settings.film_pose.points(np.array([own]))[0] + [0.0, 0.0, 90.0]
    assert np.linalg.norm(np.cross(there - path[0], path[1] - path[0])) < 1e-9


def test_a_low_plot_of_ghosts_says_that_its_brightness_is_a_logarithm():
    """Its axis had the unit 1/mm² beside numbers from −6 to −12."""
    axis = ghosts_figure(query(Settings()), 16).rows[0][1].y
    assert axis.high <= 0.0 and unit_of(axis.label) == "log10 1/mm²"


def test_the_light_of_a_ghost_without_symmetry_comes_from_the_field_of_the_other_figures():
    squeezed = query(replace(Settings(), lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    figure = ghosts_figure(squeezed, 8, "middle")
    assert any(row[2] > 0.0 for row in figure.table.rows) and "lower left corner" in figure.conditions
    towards = np.array([*np.tan(field_direction(squeezed, "middle")), -1.0])
    lens, away = squeezed.lens, squeezed.bench.film_distance
    aims = np.stack([*np.meshgrid(*2 * [np.linspace(-15.0, 15.0, 31)]), np.zeros((31, 31))], -1).reshape(-1, 3)
    traced = lb.trace(lens, aims + 100.0 * towards, np.tile(-towards, (len(aims), 1)), forward=True)
    good = traced.fate == lb.Fate.PASSED
    reach = (lens.length + away - traced.points[good, 2:]) / traced.directions[good, 2:]
    landed = (traced.points[good] + reach * traced.directions[good])[:, :2].mean(0)
    assert landed == pytest.approx(squeezed.parts(0.7)[0], rel=0.15)


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
    column, row = (int(np.argmin(np.abs(rays.pupil[key[0], axis] - key[2 + axis]))) for axis in (1, 0))
    cell = key[0], rays.conditions.wavelengths.index(key[1]), column, row
    offset = rays.offset_s[cell] * rays.beams.axes[key[0], 0] + rays.offset_t[cell] * rays.beams.axes[key[0], 1]
    np.testing.assert_allclose(landed, offset, atol=1e-7)
    shown = np.array([marks.x[i] - 2.0, marks.y[i] + 2.0]) * plot.cell
    np.testing.assert_allclose(landed @ rays.beams.axes[key[0]].T, shown, atol=1e-7)
    assert len(ray.path) == len(B.lens.surfaces) + 2 and ": from" in ray.end
    assert nearest_ray(plot, 0.5, 0.5) is None


def test_a_point_of_a_fan_is_the_ray_that_lands_there_or_is_vignetted():
    settings = replace(Settings(), f_number=2.0)
    figure = fans_figure(A, 16)
    for fan, plot in enumerate(figure.rows[-1]):                        # tangential, then sagittal
        own = next(layer for layer in plot.layers if isinstance(layer, Curve) and layer.name.endswith("nm"))
        k = 3 + int(np.flatnonzero(np.isfinite(own.y))[3])
        key = nearest_ray(plot, float(own.x[k]), float(own.y[k]))
        ray, rays = pointed_ray(settings, figure.points, key), A.grid(figure.points)
        assert key[0] == len(rays.images) - 1 and ray.surface == -1
        offset = (ray.path[-1, :2] - rays.images[key[0]]) @ rays.beams.axes[key[0], 1 - fan]
        assert 1000.0 * offset == pytest.approx(own.y[k], abs=1e-3)
        stop = ray.path[1 + A.lens.stop_index, :2] @ rays.beams.axes[key[0], 1 - fan]
        if key[1] == rays.conditions.primary_wavelength:
            assert stop / A.lens.stop.semi_diameter == pytest.approx(own.x[k], abs=0.02)
    tangential = figure.rows[-1][0]
    dead = next(layer for layer in tangential.layers if layer.surface is not None)
    k = int(np.flatnonzero(np.isfinite(dead.y))[0])
    lost = pointed_ray(settings, figure.points, nearest_ray(tangential, float(dead.x[k]), float(dead.y[k])))
    assert lost.surface == dead.surface and "vignetted" in lost.end and lost.raster is None


def test_a_ray_of_a_lens_that_opens_no_further_says_why_it_is_not_followed():
    """The figures are of the open lens, and there is no picture."""
    settings = replace(Settings(), lens="carl-zeiss-tessar-100-f45", f_number=2.8)
    ray = pointed_ray(settings, 16, (0, query(settings).conditions().primary_wavelength, 0.0, 0.1))
    assert ray.raster is None and "maximum aperture" in ray.end
    with pytest.raises(lb.LensError):
        camera(settings)


def test_maps_of_a_stand_beside_those_of_b_with_the_same_axes():
    b, a = mtf_map_figure(B, 8), mtf_map_figure(A, 8)
    both = with_ghost(b, a, "wide open")
    (left, right), = both.rows
    assert left.title == "B" and right.title == "A" and (left.x, left.y) == (right.x, right.y)
    own, other = (next(layer for layer in plot.layers if isinstance(layer, Map) and not layer.ghost)
                  for plot in (left, right))
    assert own is b.rows[0][0].layers[0] and other is a.rows[0][0].layers[0]
    assert "   A 0." in told(left, 0.0, 5.0) and "   A 0." not in told(right, 0.0, 5.0)
    assert "at the right" in both.remarks[-1] or any("at the right" in each for each in both.remarks)


@pytest.mark.parametrize("figure", [mtf_field_figure, mtf_map_figure, field_figure, illumination_figure, depth_figure,
                                    stack_figure, mtf_frequency_figure, encircled_figure, line_spread_figure,
                                    bokeh_figure, partial(wavefront_figure, field="full"),
                                    partial(psf_figure, field="full")])
def test_each_figure_marks_what_the_rim_of_a_lit_surface_ends(figure):
    """Wide open the first and the last surface of the lens cut its corner; no rim but the stop cuts the axis."""
    plots = [plot for row in figure(A, 16).rows for plot in row]
    lit = [layer for plot in plots for layer in plot.layers if getattr(layer, "surface", None) is not None]
    known = victims(A.grid(16))
    corner = {surface for surface, part in known.items() if part[-1] > 0.05}
    assert len(corner) >= 2 and {layer.surface for layer in lit} >= corner
    assert A.lens.stop_index not in known
    for layer in lit:
        if isinstance(layer, Curve):                    # along the fields, away from the axis
            along = layer.y if np.ptp(layer.y[np.isfinite(layer.y)]) > 0.0 else layer.x
            cut = A.grid(16).image_heights[known[layer.surface] > 0.0]
            assert np.nanmin(along) <= cut.min() and np.nanmax(along) >= cut.max() and np.nanmin(along) > 0.0
