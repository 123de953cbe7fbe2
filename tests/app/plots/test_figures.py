"""The figures of fans, field curves and MTF against the analyses that they show."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.focus_plane import focus_at
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.plots.aperture_plots import Stack, focus_shift_figure, illumination_figure, stack_figure
from lensbench.app.plots.field_plots import depth_figure, field_figure
from lensbench.app.plots.light_plots import Ripple, bokeh_figure, ripple_surface, star_figure
from lensbench.app.plots.pixel_rays import beam, film_place
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.plots.plot import Bars, Curve, Map, told
from lensbench.app.plots.point_plots import (
    encircled_figure, focus_range, line_spread_figure, mtf_field_figure, mtf_frequency_figure, mtf_map_figure,
    psf_figure, seen_point_figure
)
from lensbench.app.plots.query import query
from lensbench.app.plots.ray_plots import fans_figure, grid_figure, seidel_figure, wavefront_figure
from lensbench.app.plots.spots import field_label, spots_figure
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.grids.traced_grid import close_foci
from lensbench.core.analysis.transfer_function import mtf
from lensbench.core.analysis.wavefront import wavefronts
from lensbench.core.optics.depth_of_field import real_circle_of_confusion

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
    assert "blocked" in tangential.title and "blocked" not in figure.rows[0][0].title


def test_curves_over_the_field_end_where_the_light_ends():
    fisheye = query(replace(Settings(), lens="pbrt-fisheye-10mm", f_number=None))
    corner = 0.5 * fisheye.bench.film.diagonal
    assert fisheye.largest_height < corner
    figure = field_figure(fisheye, 8)
    heights = column(figure, "image height (mm)")
    assert heights[-1] == pytest.approx(fisheye.largest_height, rel=1e-3)
    assert any("edge of light" in remark for remark in figure.remarks)
    assert [plot.x.high for plot in figure.rows[0]] == pytest.approx([heights[-1]] * 3)


def test_the_fields_end_where_a_ray_through_the_middle_of_the_stop_does():
    """Of a phone lens the corner has a sliver of light beside it: the last field was dark in all figures."""
    asked = query(with_lens(Settings(), "apple-phone-6-elements-4-f18"))
    corner = 0.5 * asked.bench.film.diagonal
    assert lit_radius(asked.bench) == corner and 0.9 * corner < asked.largest_height < corner
    figure = spots_figure(asked, 16)
    assert not any("no ray" in each or "no light" in each for each in figure.remarks)
    assert any("has light next to the middle of the stop alone" in each for each in figure.remarks)


def test_an_anamorphic_lens_has_curves_along_both_sides_of_the_film():
    squeezed = query(replace(Settings(), lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    figure = field_figure(squeezed, 8)
    along = np.array([row[0] for row in figure.table.rows])
    angle, height = (column(figure, name) for name in ("field (deg)", "place on the film (mm)"))
    sections = squeezed.lens.sections
    for way, section in zip(("width", "height"), sections, strict=True):
        close = np.flatnonzero(along == way)[1]         # its height over its angle is the focal length of the section
        assert height[close] / np.tan(np.radians(angle[close])) == pytest.approx(
            abs(lb.first_order(section).efl), rel=0.05)
    assert len(figure.rows[0]) == 3 and np.isfinite(column(figure, "tangential focus (mm)")).any()


def test_the_grid_is_distorted_by_the_percent_of_the_curve():
    figure = grid_figure(ASKED, 16)
    ideal, real = (np.column_stack([column(figure, f"{name} {axis} (mm)") for axis in "xy"]) for name in
                   ("ideal", "image"))
    corner = np.argmax(np.hypot(*ideal.T))
    curve = field_figure(ASKED, 16)
    percent = np.interp(np.hypot(*real[corner]), column(curve, "image height (mm)"),
                        column(curve, "distortion f tan (%)"))
    moved = 100.0 * (np.hypot(*real[corner]) / np.hypot(*ideal[corner]) - 1.0)
    assert moved == pytest.approx(percent, abs=0.03) and abs(percent) > 1.0
    said = told(figure.rows[0][0], *ideal[corner])
    assert "% of the radius" in said and f"{abs(moved):.1f}" in said


def test_the_grid_of_a_small_image_circle_lies_within_it():
    fisheye = query(replace(Settings(), lens="canon-rf-l-dual-fisheye-52-f28", f_number=None))
    figure = grid_figure(fisheye, 16)
    assert np.isfinite(column(figure, "image x (mm)")).all() and "edge of light" in figure.remarks[0]
    assert "equidistant" in figure.rows[0][0].title


def test_the_field_of_a_leaning_lens_runs_from_edge_to_edge_and_is_mirrored_with_it(tmp_path):
    """Curves of one side alone hid what a decentred lens does."""
    lens, found = lenses.load("pbrt-dgauss-50mm"), []
    for way in (1.0, -1.0):
        leaning = replace(lens, surfaces=tuple(
            replace(each, pose=lb.SurfacePose(decentre_y=way * 0.5, tilt_x=way * 0.01)) if 2 <= i <= 4 else each
            for i, each in enumerate(lens.surfaces)))
        lenses.save(leaning, str(tmp_path / "leaning.toml"))
        figure = field_figure(query(replace(Settings(), lens=str(tmp_path / "leaning.toml"), f_number=4.0)), 8)
        rows = np.array([row[2:] for row in figure.table.rows if row[0] == "height"], float)
        assert figure.rows[0][0].x.low == -figure.rows[0][0].x.high == pytest.approx(-18.0)
        assert not any("corner" in remark for remark in figure.remarks)
        found.append(rows)
    np.testing.assert_allclose(found[1][::-1] * [-1.0, 1.0, 1.0, 1.0], found[0], atol=2e-6)
    assert np.nanmax(np.abs(found[0][::-1, 2] - found[0][:, 2])) > 0.3


def test_fields_of_a_lens_without_symmetry_lie_on_the_film_and_have_one_direction():
    squeezed = query(replace(Settings(), lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    film, places = squeezed.bench.film, np.array(squeezed.parts(0.0, 0.5, 1.0))
    assert (np.abs(places) <= [0.5 * film.width, 0.5 * film.height]).all()
    rays = squeezed.grid(16, tuple(map(tuple, places.tolist())))
    assert field_label(rays, 0) == "axis"
    found = mtf(rays, [5.0]).white_modulus[:, :, 0]             # no jump from the axis to a field close to it
    close = mtf(squeezed.grid(16, squeezed.parts(0.01)), [5.0]).white_modulus[0, :, 0]
    assert found[0] == pytest.approx(close, abs=0.03) and abs(found[0, 0] - found[0, 1]) < 0.5
    assert any("lower left corner" in remark for remark in mtf_field_figure(squeezed, 16).remarks)


def test_the_mtf_of_the_maker_chart_is_that_of_the_curves():
    rays = ASKED.grid(16, ASKED.parts(0.0, 0.7, 1.0))
    expected = mtf(rays, [10.0]).white_modulus[:, :, 0]
    figure = mtf_frequency_figure(ASKED, 16)
    at_10 = column(figure, "frequency (lp/mm)") == 10.0
    np.testing.assert_allclose(column(figure, "sagittal")[at_10], expected[:, 0], rtol=1e-9)
    curves = {layer.name: layer for layer in mtf_field_figure(ASKED, 16).rows[0][0].layers}
    assert np.interp(0.0, curves["10 lp/mm T"].x, curves["10 lp/mm T"].y) == pytest.approx(expected[0, 1], rel=1e-6)


def test_the_film_dragged_to_a_shift_of_the_map_is_focused_there():
    figure = mtf_map_figure(ASKED, 8)
    shades = figure.rows[0][0].layers[0]
    assert isinstance(shades, Map) and shades.values.shape == (9, 17)
    assert focus_at(ASKED.bench, 0.0) == pytest.approx(ASKED.focus_distance, rel=1e-6)
    assert all(np.isfinite(curve.x).any() for curve in figure.rows[0][0].layers[1:3])
    blurred = mtf_map_figure(ASKED, 8, 2000.0)              # side maxima of nothing are no best focus
    assert all(np.isnan(curve.x).all() for curve in blurred.rows[0][0].layers[1:3])
    assert blurred.remarks[0] == "no best focus is drawn where the contrast stays below 0.1"
    assert not any("mm from the film" in remark for remark in figure.remarks)
    # Sharp far from the film at its edge
    wide = query(replace(Settings(), lens="canon-50-f12", f_number=1.2, white="fdc"))
    assert "no best focus is drawn where it lies more than 0.15 mm from the film" in mtf_map_figure(wide, 8).remarks
    near = focus_at(ASKED.bench, 0.1)
    assert near < ASKED.focus_distance
    moved = query(replace(Settings(), focus_distance=near, focus_position="paraxial"))
    still = query(replace(Settings(), focus_position="paraxial"))
    assert moved.bench.film_distance - still.bench.film_distance == pytest.approx(0.1, abs=1e-3)


def test_the_map_of_one_colour_is_that_of_this_wavelength_alone():
    asked = query(replace(Settings(), lens="lib-tronnier-1953"))
    lines = asked.conditions().wavelengths
    maps = [mtf_map_figure(asked, 8, line=line).rows[0][0].layers[0].values for line in (None, *lines)]
    for line, shades in zip(lines, maps[1:], strict=True):
        alone = lb.analysis.conditions(asked.lens, asked.bench.film, asked.conditions().fields, [line],
                                       asked.object_distance)
        shifts = np.linspace(-focus_range(asked), focus_range(asked), 17)
        found = lb.analysis.mtf_map(asked.lens, asked.bench.film_distance, alone, 30.0, shifts, 9, 8)
        np.testing.assert_allclose(shades, found.white.mean(1), atol=1e-12)
    assert np.abs(maps[0] - maps[2]).max() > 0.01


def test_seidel_bars_add_up_to_those_of_the_lens():
    figure = seidel_figure(ASKED, 16)
    assert figure.rows[0][0].x.whole == len(figure.table.rows) - 2      # the last surface; the last row is the sum
    bars = [layer for layer in figure.rows[0][0].layers if isinstance(layer, Bars) and layer.name]
    for shares, total in zip(bars[::2], bars[1::2], strict=True):
        assert shares.name == total.name and total.y == pytest.approx([shares.y.sum()], abs=1e-9)
    assert len(bars) == 2 * 5                           # no colour without dispersion
    assert len(figure.table.rows) == len(ASKED.lens.surfaces) + 1


def test_the_bokeh_far_from_focus_is_as_wide_as_the_circle_of_confusion():
    figure = bokeh_figure(ASKED, 16)
    row = next(row for row in figure.table.rows if row[0] == 0.0 and np.isinf(row[1]))
    diameter = real_circle_of_confusion(ASKED.lens, ASKED.bench.film_distance, [np.inf])[0][0]
    assert 2.0 * np.sqrt(2.0) * np.hypot(row[3], row[4]) == pytest.approx(1000.0 * diameter, rel=0.02)
    shades = [layer for layer in figure.rows[0][0].layers if isinstance(layer, Map)]
    assert len(shades) == 16 and max(float(np.nanmax(each.values)) for each in shades) == pytest.approx(1.0)


def test_the_wavefront_of_the_axis_has_its_strehl_ratio_in_the_title():
    figure = wavefront_figure(ASKED, 24)
    strehl = wavefronts(ASKED.grid(24, ASKED.parts(0.0, 0.7, 1.0))).strehl[0, 0]
    assert f"Strehl {strehl:.3f}" in figure.rows[0][0].title
    assert [row[1] for row in figure.table.rows[:3]] == [1.0, 2.0, 3.0]


def test_the_bars_of_a_wavefront_in_the_fringe_order_are_noll_s_scaled_to_the_rim():
    noll, fringe = (wavefront_figure(ASKED, 24, "full", order) for order in ("noll", "fringe"))
    (first, second) = (next(layer for layer in figure.rows[1][0].layers if isinstance(layer, Bars))
                       for figure in (noll, fringe))
    assert second.x.tolist() == list(range(4, 21))
    by_noll = dict(zip(first.x.tolist(), first.y.tolist(), strict=True))
    by_fringe = dict(zip(second.x.tolist(), second.y.tolist(), strict=True))
    # Wyant's table: Z4 √3 (2 r² − 1), Z8 √8 (3 r³ − 2 r) sin, Z11 √5 (6 r⁴ …), Z22 √7 (20 r⁶ …) are 4, 8, 9, 16
    for noll_index, fringe_index, scale in ((4, 4, 3.0), (7, 8, 8.0), (11, 9, 5.0), (22, 16, 7.0)):
        assert by_fringe[fringe_index] == pytest.approx(scale ** 0.5 * by_noll[noll_index], rel=1e-12)


def test_focus_shift_and_illumination_are_those_of_the_lens_wide_open():
    open_ = query(replace(Settings(), f_number=None))
    shift = focus_shift_figure(open_, 16, 2.8)
    assert shift.table.rows[0][0] == pytest.approx(open_.bench.f_number)
    light = illumination_figure(open_, 16)
    corners = [row[2] for row in light.table.rows if row[1] == light.table.rows[-1][1]]
    assert light.table.rows[0][2:] == pytest.approx((1.0, 1.0, 1.0))
    assert len(corners) == 4 and corners[0] < corners[1] < corners[2]


@pytest.mark.parametrize("make", [fans_figure, mtf_field_figure, mtf_map_figure, bokeh_figure, wavefront_figure])
def test_a_field_beyond_the_image_circle_does_not_stop_a_figure(make):
    phone = query(replace(Settings(), lens="apple-phone-6-elements-4-f18", f_number=None))
    assert make(phone, 16).rows


def test_seidel_sums_of_a_fisheye_are_those_of_45_degrees_and_say_so():
    wide = query(replace(Settings(), lens="canon-rf-l-dual-fisheye-52-f28", f_number=None))
    figure = seidel_figure(wide, 16)
    assert "field 45°" in figure.conditions and "third order says nothing" in figure.remarks[0]
    assert figure.rows[0][0].y.high < 1e5


def test_light_of_a_point_adds_up_in_circles_and_across_lines():
    stopped = query(replace(Settings(), f_number=8.0))
    figure = encircled_figure(stopped, 24)
    axis, perfect = (next(layer for layer in figure.rows[0][0].layers if layer.name.startswith(name))
                     for name in ("axis", "perfect"))
    held = axis.y[np.isfinite(axis.y)]
    assert (np.diff(held) > -1e-6).all() and held[-1] > 0.95
    assert (perfect.y[:len(held)] > held - 0.03).all()
    at, sagittal = (column(line_spread_figure(stopped, 24), name) for name in ("distance (um)", "sagittal (% a um)"))
    first = slice(0, len(at) // 3)
    assert np.trapezoid(sagittal[first], at[first]) == pytest.approx(100.0, abs=4.0)
    picture = psf_figure(stopped, 24, "axis", "log")
    shades = picture.rows[0][0].layers[0]
    assert isinstance(shades, Map) and shades.values.max() == 1.0 and shades.shades.min() == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("raster", [(170.5, 60.5), (40.5, 130.5)])
def test_the_picture_of_what_a_pixel_shows_is_as_wide_as_its_spot(raster):
    settings = replace(Settings(), pixels_x=240, pixels_y=160)
    seen, got = beam(settings, raster), pixel_readings(settings, raster)
    figure = seen_point_figure(query(settings), 64, film_place(settings, raster), seen.ahead, "linear")
    shades = next(layer for layer in figure.rows[0][0].layers if isinstance(layer, Map))
    light, half = shades.values / shades.values.sum(), shades.x[1]
    at = half * (2.0 * (np.arange(len(light)) + 0.5) / len(light) - 1.0)
    middle = light.sum(0) @ at, light.sum(1) @ at
    square = (light * ((at[None, :] - middle[0])**2 + (at[:, None] - middle[1])**2)).sum()
    assert 2.0 * np.sqrt(2.0 * square) == pytest.approx(1000.0 * got.diameter, rel=0.05)
    assert format_distance(seen.ahead) in figure.conditions


def test_a_point_that_touches_the_lens_has_no_picture():
    with pytest.raises(lb.LensError, match="touches the lens"):
        seen_point_figure(ASKED, 16, (0.0, 0.0), 0.5 * ASKED.bench.film_z)


def test_depth_of_field_over_the_field_widens_with_the_stop():
    wide, small = (depth_figure(query(replace(Settings(), f_number=n)), 16, 0.03) for n in (5.6, 16.0))
    near, far = (column(wide, name)[0] for name in ("nearest (m)", "farthest (m)"))
    assert column(small, "nearest (m)")[0] < near < Settings().focus_distance / 1000.0 < far
    assert far < column(small, "farthest (m)")[0]


def test_a_stack_costs_contrast_away_from_the_axis_and_an_adapter_costs_infinity():
    figure = stack_figure(ASKED, 16, Stack(4.0, 1.52, 0.0))
    bare, behind = column(figure, "tangential bare"), column(figure, "tangential")
    assert np.nanmax(np.abs(behind - bare)[2:]) > 0.05
    still = stack_figure(ASKED, 16, Stack(0.0, 1.52, 0.0))
    np.testing.assert_array_equal(column(still, "tangential"), column(still, "tangential bare"))
    assert any("does not reach infinity" in each for each in stack_figure(ASKED, 16, Stack(2.0, 1.52, 0.1)).remarks)


def test_a_stack_behind_an_anamorphic_lens_has_foci():
    squeezed = query(replace(Settings(), lens="lentil-schneider-anamorphic-31-2001", f_number=None))
    contrast, foci = stack_figure(squeezed, 16).rows[0]
    named = {layer.name: layer.y for layer in foci.named()}
    assert contrast.title == "MTF" and all(np.isfinite(named[way]).any() for way in ("sagittal", "tangential"))
    still = {layer.name: layer.y for layer in stack_figure(squeezed, 16, Stack(0.0, 1.52, 0.0)).rows[0][1].named()}
    rays = squeezed.grid(16, squeezed.parts(*np.linspace(0.0, 1.0, 13).tolist()))
    np.testing.assert_allclose(still["sagittal"][1:], close_foci(rays)[1:, rays.conditions.primary, 0], rtol=1e-9)


def test_the_focus_shift_is_seen_beside_a_far_greater_depth_of_focus():
    """Of a picture of few pixels the depth of focus made the shift a flat line."""
    few = query(replace(Settings(), pixels_x=90, pixels_y=60))
    figure = focus_shift_figure(few, 16)
    shift, axis = 1000.0 * np.abs(column(figure, "least blur (mm)")).max(), figure.rows[0][0].y
    assert 1000.0 * column(figure, "depth of focus (mm)")[0] > axis.high > shift > 0.2 * axis.high
    assert any("lies beyond the plot" in each for each in figure.remarks)


def test_a_star_needs_blades_and_counts_its_rays():
    with pytest.raises(lb.LensError, match="round stop"):
        star_figure(query(replace(Settings(), f_number=8.0)), 16)
    figure = star_figure(query(replace(Settings(), f_number=8.0, blades=5)), 16)
    assert figure.rows[0][0].title == "10 rays"


@pytest.mark.slow
def test_the_bokeh_of_an_afocal_lens_says_which_distance_it_does_not_image():
    glass = lb.Glass(1.5)               # thin lenses of 100 and 50 mm, their foci together
    front = lb.Lens((lb.Surface(4.0, 8.0, glass, curvature=1 / 50), lb.Surface(10.0, 8.0, curvature=0.0)), 0)
    back = lb.Lens((lb.Surface(2.0, 8.0, glass, curvature=1 / 25), lb.Surface(10.0, 8.0, curvature=0.0)), 0)
    gap = lb.first_order(front).bfl + lb.first_order(back).bfl
    relay = lb.Lens((front.surfaces[0], lb.Surface(gap, 8.0, curvature=0.0), lb.Surface(2.0, 8.0, glass, curvature=0.0),
                     lb.Surface(0.0, 8.0, curvature=-1 / 25)), 0)
    assert np.isinf(lb.first_order(relay).efl)
    near = replace(ASKED, lens=relay, bench=replace(ASKED.bench, lens=relay, film_distance=60.0),
                   object_distance=500.0, focus_distance=500.0)
    figure = bokeh_figure(near, 16)
    assert figure.remarks[0].startswith("∞: an afocal lens")
    pictured = {row[1] for row in figure.table.rows}
    assert pictured == {0.3, 0.5, 0.8}


@pytest.mark.slow
def test_a_ripple_draws_rings_into_the_bokeh_and_says_what_it_is():
    ripple = Ripple(ripple_surface(ASKED.lens), 2.0, 3e-4)
    plain, rings = (bokeh_figure(ASKED, 48, "linear", each) for each in (None, ripple))
    assert "every 2 mm, 300 nm high" in rings.conditions and "ripple" not in plain.conditions
    axis = [next(layer for layer in figure.rows[0][0].layers if isinstance(layer, Map)).values
            for figure in (plain, rings)]
    middle = [slice(5 * len(values) // 12, 7 * len(values) // 12) for values in axis]
    spread = [np.std(values[each, each]) for values, each in zip(axis, middle, strict=True)]
    assert spread[1] > 2.0 * spread[0]


def test_apertures_of_a_lens_that_focuses_by_its_groups_are_those_at_infinity():
    near = replace(Settings(), lens="lv-minolta-af-100mm-f28-macro", f_number=None, focus_distance=360.0)
    asked = query(near)
    assert lb.first_order(asked.bench.lens).f_number < 1.9              # at magnification 0.8, where it is shorter
    assert focus_shift_figure(asked, 8).rows[0][0].x.low == pytest.approx(2.83, rel=1e-3)
    assert illumination_figure(asked, 8).rows[0][0].layers[0].name.startswith("f/2.8")
    assert lb.stopped_down(asked.bench.lens, 5.66).stop.semi_diameter == pytest.approx(
        0.5 * asked.bench.lens.stop.semi_diameter, rel=1e-3)
