"""Spots against tables of 40-digit rays: the same rays one by one, and the grid's own."""

import json
from math import radians

import numpy as np
import pytest

import lensbench as lb
from tests.core.analysis.grids.test_ray_grid import of_angles
from tests.core.oracles import DATA, REFERENCE, lens

TABLES = json.loads((DATA / "spots.json").read_text(encoding="utf-8"))
ROWS = [(name, *row) for name in TABLES if name != "about" for row in TABLES[name]["spots"]]
# Of a square grid of 65 × 65 rays that rims cut, about one in its edge's 200 counts or not by chance: 1 % and more
SAMPLED = 0.035


@pytest.mark.parametrize(("name", "degrees", "line", "whole", "cut"), ROWS)
def test_single_rays_have_the_spots_of_forty_digits(name, degrees, line, whole, cut):
    stack, film = lens(name, line), REFERENCE[name]["film_z"]
    z, radius = TABLES[name]["enp"]
    side = np.linspace(-1.0, 1.0, 65)
    px, py = (each[side[:, None] ** 2 + side**2 <= 1.0] for each in np.meshgrid(side, side))
    way = np.array([0.0, np.sin(radians(degrees)), np.cos(radians(degrees))])
    origins = np.column_stack([radius * px, radius * py - z * way[1] / way[2], 0.0 * px])
    for clip, known in ((False, whole), (True, cut)):
        if known is None:
            continue
        t = lb.trace(stack, origins, way, clip=clip)
        through = t.fate == lb.Fate.PASSED
        assert through.sum() == known[0]
        at = t.points[through] + ((film - t.points[through, 2]) / t.directions[through, 2])[:, None] * \
            t.directions[through]
        away = np.hypot(*(at[:, :2] - at[:, :2].mean(0)).T)
        assert at[:, 1].mean() == pytest.approx(known[1], rel=1e-11, abs=1e-11)
        assert np.sqrt((away**2).mean()) == pytest.approx(known[2], rel=1e-11, abs=1e-11)
        assert away.max() == pytest.approx(known[3], rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(("name", "degrees", "line", "cut"), [
    (name, degrees, line, cut) for name, degrees, line, _, cut in ROWS
    # The real entrance pupil of a fisheye moves with the field: rays at the paraxial one miss a part of it
    if line == "d" and cut is not None and not (name == "fisheye" and degrees >= 40)])
def test_spots_of_the_grid_are_those_of_the_table(name, degrees, line, cut):
    stack, film = lens(name, line), REFERENCE[name]["film_z"]
    rays = of_angles(stack, film - stack.length, degrees, pupil=64)
    spots = lb.analysis.spots(rays, "centroid")
    wanted = cut[2]
    # On the axis the rims pass a little more than the paraxial pupil, most of all the wide double Gauss
    assert spots.rms_radius[0, 0, 0] == pytest.approx(wanted, rel=SAMPLED if degrees else 0.075)
    centroid = rays.images[0, 1] + spots.references[0, 0, 1]
    assert centroid == pytest.approx(cut[1], abs=SAMPLED * wanted)


def test_the_white_spot_reaches_as_far_as_the_farthest_ray_of_any_colour():
    stack, film = lens("dgauss"), REFERENCE["dgauss"]["film_z"]
    given = lb.analysis.conditions(stack, None, (0.0, 8.0), [lb.F_LINE, lb.D_LINE, lb.C_LINE],
                                   field_kind=lb.FieldKind.ANGLE)
    spots = lb.analysis.spots(lb.analysis.ray_grid(stack, film - stack.length, given, 16), "centroid",
                              np.array([-0.1, 0.0, 0.05, 0.2]))
    assert spots.geo.shape == (2, 3, 4) and spots.white_geo.shape == (2, 4)
    np.testing.assert_array_equal(spots.white_geo, [np.max(list(field), axis=0) for field in spots.geo])
    assert (spots.white_rms_radius < spots.white_geo).all()


def test_each_beam_is_narrowest_at_its_line_foci():
    """Against the weighted spread of the rays themselves, at the focus and 20 µm to either side of it."""
    stack, film = lens("dgauss"), REFERENCE["dgauss"]["film_z"]
    given = lb.analysis.conditions(stack, None, (0.0, 8.0, 16.0), field_kind=lb.FieldKind.ANGLE)
    grid = lb.analysis.ray_grid(stack, film - stack.length, given, 16)
    foci = lb.analysis.spots(grid).line_foci
    assert foci[0, 0] == pytest.approx(foci[0, 1], abs=1e-9) and abs(foci[2, 0] - foci[2, 1]) > 0.01
    for field in range(3):
        for axis, (offset, slope) in enumerate(zip(grid.light[:2], grid.light[2:], strict=True)):
            lit = grid.weight[field] > 0.0
            weight = grid.weight[field][lit]
            spread = []
            for shift in foci[field, axis] + np.array([-0.02, 0.0, 0.02]):
                at = (offset[field] + shift * slope[field])[lit]
                spread.append(np.average((at - np.average(at, weights=weight)) ** 2, weights=weight))
            assert spread[1] < spread[0] == pytest.approx(spread[2], rel=1e-2)


def test_the_white_spot_is_smallest_at_its_best_shift():
    """Its mean square is a parabola of the shift: alike to both sides of its vertex, also between two line foci."""
    stack, film = lens("dgauss"), REFERENCE["dgauss"]["film_z"]
    given = lb.analysis.conditions(stack, None, (0.0, 8.0, 16.0), field_kind=lb.FieldKind.ANGLE)
    grid = lb.analysis.ray_grid(stack, film - stack.length, given, 16)
    for field, best in enumerate(lb.analysis.spots(grid).best_shifts.tolist()):
        size = lb.analysis.spots(grid, "centroid", best + np.array([-0.05, 0.0, 0.05])).white_rms_radius[field]
        assert size[1] < size[0] == pytest.approx(size[2], rel=1e-9)


def test_a_dark_field_has_no_spot_and_a_shift_is_a_length():
    """At 80° no ray through the middle of the stop enters: a size of 0 would be the sharpest of all fields."""
    stack, film = lens("dgauss"), REFERENCE["dgauss"]["film_z"]
    given = lb.analysis.conditions(stack, None, (0.0, 80.0), field_kind=lb.FieldKind.ANGLE)
    grid = lb.analysis.ray_grid(stack, film - stack.length, given, 16)
    assert grid.lit.tolist() == [True, False]
    spots = lb.analysis.spots(grid, "centroid", [0.0, 0.1])
    for size in (spots.white_rms_radius, spots.white_geo, spots.white_rms[..., 0]):
        assert np.isfinite(size[0]).all() and np.isnan(size[1]).all()
    for shift in (np.nan, np.inf):
        with pytest.raises(lb.LensError, match="finite"):
            lb.analysis.spots(grid, "centroid", [0.0, shift])
