"""The exit-pupil region against 40-digit bounds, pbrt's boxes and rays traced one by one."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import clearance_tracer, clearances
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.pupils.radial_sampler import RINGS, PupilTable
from lensbench.core.pupils.rim_solver import ROUGH, solve_rims
from tests.core.oracles import DATA, REFERENCE, lens as reference_lens
from tests.library import CLASSICS

BOUNDS = json.loads((DATA / "exit_pupils.json").read_text())
SHAPES = ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "pbrt-wide-22mm", "lenshh-cooke-triplet-50",
          "lv-zeiss-biogon-21-f45", "lentil-nikon-retrofocus-1971"]


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_the_meridional_bounds_agree_with_forty_digits(name):
    lens, reference = lenses.load(name), BOUNDS[name]
    fields = reference["fields"]
    pupil = lb.exit_pupil(lens, reference["film_distance"], [field["film_y"] for field in fields])
    tolerance = 3e-10 * lens.surfaces[-1].semi_diameter
    for i, field in enumerate(fields):
        assert pupil.bounds[i, 0] == pytest.approx(field["low"], abs=tolerance)
        assert pupil.bounds[i, 2] == pytest.approx(field["high"], abs=tolerance)
        assert pupil.area[i] == pytest.approx(field["area"], rel=1e-3)      # the reference counts cells of 0.03 mm


@pytest.mark.parametrize("name", ["rf50", "codev"])
def test_the_bounds_of_aspheric_lenses_agree_with_forty_digits(name):
    lens, reference = reference_lens(name), REFERENCE[name]
    heights = reference["exit_pupils"]
    pupil = lb.exit_pupil(lens, reference["film_z"] - lens.length, [float(y) for y in heights])
    for bounds, (low, high) in zip(pupil.bounds, heights.values(), strict=True):
        assert (bounds[0], bounds[2]) == pytest.approx((low, high), abs=1e-9)


@pytest.mark.parametrize("distance", [1200.0, 3000.0])
def test_a_film_close_behind_its_cover_glass_sees_a_region_far_smaller_than_the_glass(distance):
    # The Noct's film stands 1 mm behind a glass of 45 mm: of that the axis sees one millimetre
    camera = lb.LensCamera(lenses.load("lv-nikon-z-58f095-noct"), lb.Film(36.0, 24.0), distance)
    lens, away, cell = camera.lens, camera.film_distance, 0.01
    side = np.arange(-0.8, 0.8, cell) + 0.5 * cell
    x, y = (grid.ravel() for grid in np.meshgrid(side, side))
    for film_x in (0.0, 1e-3, 0.1):
        rays = lb.trace(lens, [film_x, 0.0, lens.length + away],
                        np.column_stack([x, y, np.full(x.size, -away)]))
        counted = float((rays.fate == lb.Fate.PASSED).sum()) * cell**2
        # Cells that the rim cuts: about 2π·0.55 mm / 0.01 mm of them, each off by a third at random
        assert lb.exit_pupil(lens, away, [film_x]).area[0] == pytest.approx(counted, rel=0.005)


def test_a_lens_that_is_telecentric_towards_the_scene_has_its_regions_without_an_f_number():
    glass = lenses.load("pbrt-dgauss-50mm").surfaces[0].glass
    front = Surface(6.0, 20.0, glass, curvature=1.0 / 60.0), Surface(0.0, 20.0, curvature=0.0)
    focus = lb.first_order(lb.Lens((*front, Surface(0.0, 4.0, curvature=0.0)), 2)).bfl
    lens = lb.Lens((front[0], Surface(focus, 20.0, curvature=0.0), Surface(40.0, 4.0, curvature=0.0),
                    Surface(6.0, 20.0, glass, curvature=1.0 / 60.0),
                    Surface(0.0, 20.0, curvature=-1.0 / 80.0)), 2)
    assert lb.first_order(lens).f_number == 0.0
    camera = lb.LensCamera(lens, lb.Film(12.0, 8.0), 400.0)
    radii, away, cell, n = [0.0, 5.0], camera.film_distance, 0.004, 1 << 12
    pupil, table = lb.exit_pupil(camera.lens, away, radii), camera.pupil
    x, y = (grid.ravel() for grid in np.meshgrid(*[np.arange(-0.8, 0.8, cell) + 0.5 * cell] * 2))
    for radius, area, centre in zip(radii, pupil.area, pupil.centres, strict=True):
        start = [radius, 0.0, lens.length + away]
        rays = lb.trace(camera.lens, start, np.column_stack([x + centre - radius, y, np.full(x.size, -away)]))
        # Cells that the rim cuts: about 2π·0.3 mm / 0.004 mm of them, each off by a third at random
        assert area == pytest.approx(float((rays.fate == lb.Fate.PASSED).sum()) * cell**2, rel=0.002)
        l, m, n_, weight = Program([table.step(1.0)], np.float64).run(
            {X: np.full(n, radius), U0: (np.arange(n) + 0.5) / n, U1: np.arange(n) * 0.6180339887498949 % 1.0,
             WEIGHT: np.ones(n)}, [L, M, N, WEIGHT], n)
        passed = lb.trace(camera.lens, start, np.stack([l, m, n_], 1)).fate == lb.Fate.PASSED
        assert passed.mean() > 0.98
        assert (weight / n_**4 * passed).mean() == pytest.approx(area, rel=3e-3)        # lattice points, as below


def test_a_lens_without_rotational_symmetry_has_no_pupil_by_radius():
    rod = lb.Lens((lb.Surface(4.0, 5.0, lb.Glass(1.5), curvature=0.02, curvature_x=0.0),
                   lb.Surface(0.0, 5.0, curvature=0.0)), 0)
    with pytest.raises(lb.LensError, match="cylinder or toroid"):
        lb.exit_pupil(rod, 50.0, [0.0])


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_pbrts_boxes_hold_the_region_of_their_bucket(name):
    """pbrt's boxes come from a million rays each, from anywhere in a bucket: a little larger than one region."""
    reference = BOUNDS[name]["pbrt"]
    buckets, distance, diagonal = np.array(reference["boxes"]), reference["film_distance"], reference["diagonal"]
    radii = (np.array(reference["buckets"]) + 0.5) / 64 * diagonal / 2
    pupil = lb.exit_pupil(lenses.load(name), distance, radii)
    lit = pupil.area > 0.0
    full = 1.5 * lenses.load(name).surfaces[-1].semi_diameter       # what pbrt takes where it finds no light at all
    dark = np.array(reference["buckets"]) / 64 * diagonal / 2 > PupilTable.of(
        lenses.load(name), distance, diagonal / 2).dark_beyond
    assert not lit[dark].any() and np.allclose(buckets[dark], [-full, -full, full, full], rtol=1e-3)
    cell = reference["cell"]
    assert np.abs(pupil.bounds[lit] - buckets[lit]).max() < 3.0 * cell + diagonal / 2 / 64 * 0.7


@pytest.mark.parametrize("name", SHAPES)
def test_rays_just_inside_the_rim_pass_and_just_outside_are_blocked(name):
    lens = lenses.load(name)
    distance = lb.first_order(lens).bfl
    table = PupilTable.of(lens, distance, 21.0)
    radii = np.linspace(0.0, 0.97 * min(table.radius, 21.0), 7)
    pupil = lb.exit_pupil(lens, distance, radii, points=65)
    for i, r in enumerate(radii):
        rim = pupil.boundary(i)
        centre = np.array([pupil.centres[i], 0.0])
        for factor, fate in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
            target = centre + (rim - centre) * factor
            d = np.column_stack([target - [r, 0.0], np.full(len(rim), -distance)])
            origin = np.array([r, 0.0, lens.length + distance])
            assert ((lb.trace(lens, origin, d).fate == lb.Fate.PASSED) == fate).all()


@pytest.mark.parametrize("stop", [0.5, 0.02, 1e-3])
def test_a_closing_stop_leaves_a_region_that_shrinks_with_its_square(stop):
    lens = lenses.load("pbrt-dgauss-50mm")
    distance = lb.first_order(lens).bfl
    pupil = lb.exit_pupil(lens.with_stop_radius(stop), distance, [0.0, 8.0])
    fo = lb.first_order(lens)
    # the exit pupil, seen from the axis point and projected onto the rear plane
    expected = math.pi * (fo.exit_pupil.radius * stop / fo.stop_radius) ** 2
    expected *= (distance / (lens.length + distance - fo.exit_pupil.z)) ** 2
    assert pupil.area[0] == pytest.approx(expected, rel=3e-3 if stop > 0.1 else 1e-4)
    assert pupil.area[1] > 0.5 * pupil.area[0]


@pytest.mark.parametrize(("name", "closed", "focus"), [
    ("lv-nikon-z-58f095-noct", 22, 2000.0), ("lentil-meyer-primoplan-1936", 100, math.inf),
    ("lib-us10281683", 100, math.inf), ("pbrt-fisheye-10mm", 1000, math.inf)])
def test_where_the_reference_tracer_finds_light_through_a_small_stop_the_region_is_found(name, closed, focus):
    """The film close behind a wide rear surface, or the stop's image folded over: a coarse search misses it."""
    lens = lenses.load(name)
    lens = lb.focused(lens.with_stop_radius(lens.stop.semi_diameter / closed), focus)
    distance, a = lb.film_distance(lens, focus), lens.surfaces[-1].semi_diameter
    field = np.linspace(0.0, 1.3 * lb.first_order(lens).efl, 21)
    radii = np.append(field, [2.6756, 19.264, 19.33, 19.4])            # where narrow rings were dark
    area = lb.exit_pupil(lens, distance, radii, points=17).area
    for r, found in zip(radii, area, strict=True):
        # from where the ray of the stop's centre would leave, to both sides ever more coarsely
        steps = np.sort(np.concatenate([sign * np.geomspace(1e-4, 2.5, 4000) * a for sign in (-1, 1)]))
        at = np.concatenate([steps, np.linspace(-a, a, 20001)])
        way = np.column_stack([at - r, 0.0 * at, np.full(at.size, -distance)])
        lit = (lb.trace(lens, [r, 0.0, lens.length + distance], way).fate == lb.Fate.PASSED).any()
        assert found > 0.0 or not lit
    assert area[0] > 0.0


@pytest.mark.parametrize("name", [*SHAPES, "lib-us7558005a"])
@pytest.mark.parametrize("stop", [1.0, 0.1, 0.01])
def test_single_precision_clearances_keep_their_stated_error(name, stop):
    """Of rays about the rims of regions all over the film; of all lenses, the last one has the largest errors."""
    lens = lenses.load(name)
    lens = lens.with_stop_radius(lens.stop.semi_diameter * stop)
    distance, radii = lb.first_order(lens).bfl, np.linspace(0.0, 21.6, 33)
    pupil, by = lb.exit_pupil(lens, distance, radii, points=33), clearance_tracer(lens, distance)
    share = np.array([0.9, 0.97, 1.0, 1.03])
    lit = pupil.area > 0.0
    points = (pupil.centres[lit, None, None, None] * [1.0, 0.0]
              + share[:, None] * pupil.rims[lit, :, None]).reshape(-1, 2)
    film, zero = np.repeat(radii[lit], 33 * len(share)), np.zeros(len(points))
    double, single = np.empty((2, len(points)))
    for out, error in ((double, math.inf), (single, 0.0)):
        clearances(film, zero, zero, *np.ascontiguousarray(points.T), distance, out, by._replace(error=error), 0.0)
    near = double < 1.1                 # beyond the rims of steep aspheres Newton's method may end too early
    assert near.sum() > 500 and np.abs(single - double)[near].max() < by.error


@pytest.mark.parametrize("name", SHAPES)
def test_first_scans_in_single_precision_lead_to_the_same_rims(name):
    """Each rim to a thousandth of the axis's, as a camera solves it: the first look only says where to look closely."""
    lens = lenses.load(name)
    distance, radii = lb.first_order(lens).bfl, np.linspace(0.0, 21.6, 33)
    by = clearance_tracer(lens, distance)
    assert by.error < ROUGH
    (centre, rim), (single_centre, single_rim) = (
        solve_rims(lens, distance, radii, 257, 1e-8, by=by._replace(error=error)) for error in (math.inf, by.error))
    # Where the light ends, a thousandth of a millimetre decides; else chords alone differ, as the points lie elsewhere
    lit = rim[:, 0, 0] > 0.01 * rim[0, 0, 0]
    for ends in (0, -1):
        there, here = centre + rim[:, ends, 0], single_centre + single_rim[:, ends, 0]
        np.testing.assert_allclose(here[lit], there[lit], atol=1e-7)
    area, single = ((r[:, :-1, 0] * r[:, 1:, 1] - r[:, 1:, 0] * r[:, :-1, 1]).sum(1) for r in (rim, single_rim))
    np.testing.assert_allclose(single[lit], area[lit], atol=1e-4 * area[0])


def test_a_film_point_that_no_light_reaches_has_an_empty_region():
    lens = lenses.load("pbrt-fisheye-10mm")
    pupil = lb.exit_pupil(lens, lb.first_order(lens).bfl, [0.0, 20.0, 60.0])
    assert pupil.area[0] > 0.0 and pupil.area[1] == 0.0 and pupil.area[2] == 0.0
    assert np.isfinite(pupil.boundary(2)).all()


@pytest.mark.parametrize("name", SHAPES)
def test_samples_through_the_region_pass_and_little_of_it_is_lost(name):
    """98 % at least of the samples pass, and their weighted mean finds all the light that a fine grid finds."""
    lens = lenses.load(name)
    distance = lb.first_order(lens).bfl
    table = PupilTable.of(lens, distance, 20.0)
    radii = np.linspace(0.0, 0.9 * table.radius, 5)
    n = 1 << 14
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    pupil = lb.exit_pupil(lens, distance, [0.0, table.radius if table.dark_beyond < math.inf else 20.0])
    exact = lb.exit_pupil(lens, distance, radii)
    for i, r in enumerate(radii):
        points, areas = pupil.sample(np.tile([r, 0.0], (n, 1)), uv)
        d = np.column_stack([points - [r, 0.0], np.full(n, -distance)])
        passed = lb.trace(lens, [r, 0.0, lens.length + distance], d).fate == lb.Fate.PASSED
        assert passed.mean() >= 0.98
        # lattice points err by a few parts in n^(3/4), 2e-3; the region may lose 5e-4 of what the axis gets besides
        assert (areas * passed).mean() == pytest.approx(exact.area[i], abs=2e-3 * exact.area[i] + 5e-4 * exact.area[0])


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lib-miyamoto-fisheye-1964"])
def test_a_stop_of_a_fiftieth_of_a_millimetre_gets_its_light_between_the_rings_too(name):
    """Its region moves by many times its own size from ring to ring; what is lost there would show as rings."""
    wide = lenses.load(name)
    lens = wide.with_stop_radius(0.01)
    distance = lb.first_order(lens).bfl
    pupil = lb.exit_pupil(lens, distance, [0.0, 12.0])
    radii = np.linspace(0.5, 11.8, 60)
    n = 1 << 12
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    for r, area in zip(radii, lb.exit_pupil(lens, distance, radii).area, strict=True):
        points, areas = pupil.sample(np.tile([r, 0.0], (n, 1)), uv)
        d = np.column_stack([points - [r, 0.0], np.full(n, -distance)])
        passed = lb.trace(lens, [r, 0.0, lens.length + distance], d).fate == lb.Fate.PASSED
        assert passed.mean() > 0.97
        assert (areas * passed).mean() == pytest.approx(area, rel=3e-3)     # lattice points, as above


@pytest.mark.parametrize(("name", "f_number"), [
    ("lv-nikon-z-58f095-noct", 22.0), ("lv-nikon-z-58f095-noct", 256.0), ("lib-us7558005a", 256.0),
    ("lib-us10281683", 64.0)])
def test_a_film_close_behind_a_lens_that_is_stopped_down_gets_its_light_between_the_rings(name, f_number):
    """Half a millimetre or one behind it a region is as small as 0.001 mm, and a ring away from it by 0.3 mm."""
    lens = lb.stopped_down(replace(lenses.load(name), blades=0), f_number)     # without corners
    lens = lb.focused(lens, 1200.0)
    distance, n = lb.film_distance(lens, 1200.0), 1 << 12
    u0, u1 = (np.arange(n) + 0.5) / n, np.arange(n) * 0.6180339887498949 % 1.0
    for widened, most_blocked, most_lost in ((True, 0.04, 5e-3), (False, 0.015, 0.015)):
        table = PupilTable.of(lens, distance, 21.6, widened=widened)
        radii = np.linspace(0.013, 0.93, 21) * table.radius
        for r, area in zip(radii, lb.exit_pupil(lens, distance, radii).area, strict=True):
            l, m, n_, weight = Program([table.step(1.0)], np.float64).run(
                {X: np.full(n, r), U0: u0, U1: u1, WEIGHT: np.ones(n)}, [L, M, N, WEIGHT], n)
            way = np.stack([l, m, n_], 1)
            passed = lb.trace(lens, [r, 0.0, lens.length + distance], way).fate == lb.Fate.PASSED
            assert passed.mean() > 1.0 - most_blocked
            # Where a second rim sets in between two rings, a straight line cuts a corner; beside that the lattice errs
            assert (weight / n_**4 * passed).mean() == pytest.approx(area, rel=most_lost)


@pytest.mark.parametrize("part", [0.9446, 0.9462, 0.9477, 0.9492, 0.951, 0.97, 0.985, 0.99])
def test_an_irregular_region_is_sampled_whole(part):
    """The edge of this fisheye's light: a hole opens in the region, which falls in two, then bends round its centre."""
    lens = lenses.load("lib-miyamoto-fisheye-1964")
    distance = lb.first_order(lens).bfl
    end = PupilTable.of(lens, distance, 20.0).dark_beyond
    r, n = part * end, 400
    # A fine grid over all places of light, the reference tracer's
    x, y = (a.ravel() for a in np.meshgrid(9.0 + 3.6 * (np.arange(n) + 0.5) / n, 1.6 * (np.arange(n) + 0.5) / n))
    grid = np.column_stack([x - r, y, np.full(n * n, -distance)])
    start = [r, 0.0, lens.length + distance]
    area = 2.0 * 3.6 * 1.6 * (lb.trace(lens, start, grid).fate == lb.Fate.PASSED).mean()
    m = 1 << 15
    uv = np.column_stack([(np.arange(m) + 0.5) / m, (np.arange(m) * 0.6180339887498949) % 1.0])
    points, areas = lb.exit_pupil(lens, distance, [0.0, end]).sample(np.tile([r, 0.0], (m, 1)), uv)
    way = np.column_stack([points - [r, 0.0], np.full(m, -distance)])
    passed = lb.trace(lens, start, way).fate == lb.Fate.PASSED
    # a few thousand of the samples pass, in lattice points; the grid's cells are 1e-5 of the axis's 7 mm²
    assert (areas * passed).mean() == pytest.approx(area, rel=0.03)


@pytest.mark.parametrize("name", [name for name in CLASSICS if lenses.load(name).is_rotationally_symmetric])
def test_a_coarse_and_a_fine_solution_agree_at_every_radius(name):
    """41 points at a loose tolerance against 257 at a tight one: the chords alone differ, below 1 % of the axis."""
    lens = lenses.load(name)
    distance, radii = lb.first_order(lens).bfl, np.linspace(0.0, 21.6, 48)
    close = lb.exit_pupil(lens, distance, radii)
    _, rims = solve_rims(lens, distance, radii, 41, 2e-4 * lens.surfaces[-1].semi_diameter)
    x, y = rims[..., 0], rims[..., 1]
    area = (x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]).sum(1)
    whole = np.array([k not in close.irregular for k in range(len(radii))])
    assert np.abs(area - close.area)[whole].max() < 0.01 * close.area.max()


@pytest.mark.parametrize("name", ["pbrt-fisheye-10mm", "lv-zeiss-biogon-21-f45", "pbrt-wide-22mm", "lenshh-petzval"])
@pytest.mark.parametrize("stop", [1.0, 0.1])
def test_light_from_the_scene_lands_only_where_a_region_exists(name, stop):
    """Meridional rays through the front element, traced by the reference: each film radius they reach is lit."""
    wide = lenses.load(name)
    lens, front = wide.with_stop_radius(wide.stop.semi_diameter * stop), wide.surfaces[0]
    distance = lb.first_order(lens).bfl
    height, angle = (a.ravel() for a in np.meshgrid(
        np.linspace(-1.0, 1.0, 401) * front.semi_diameter, np.linspace(0.0, 1.5, 601)))
    way = np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    sag = front.curvature * height**2 / (1.0 + np.sqrt(np.maximum(0.0, 1.0 - (front.curvature * height) ** 2)))
    light = lb.trace(lens, np.column_stack([height, 0.0 * height, sag]) - 5.0 * way, way)
    (x, _, z), (dx, _, dz) = light.points[light.fate == 0].T, light.directions[light.fate == 0].T
    radii = np.abs(x + (lens.length + distance - z) * dx / dz)
    radii = np.unique(np.append(radii.max(), radii[::50]))
    assert radii[-1] > 5.0 and (lb.exit_pupil(lens, distance, radii, points=33).area > 0.0).all()
    assert PupilTable.of(lens, distance, 2.0 * radii[-1]).dark_beyond >= radii[-1]


def test_a_pupil_of_the_axis_alone_can_be_sampled_and_none_beyond_its_film():
    lens = lenses.load("pbrt-dgauss-50mm")
    alone, more = (lb.exit_pupil(lens, 36.1, radii) for radii in ([0.0], [0.0, 20.0]))
    uv = np.random.default_rng(0).random((200, 2))
    points, areas = alone.sample(np.zeros((200, 2)), uv)
    assert np.abs(points - more.sample(np.zeros((200, 2)), uv)[0]).max() < 0.01
    assert areas.mean() == pytest.approx(alone.area[0], rel=0.01)
    with pytest.raises(lb.LensError, match="up to 20 mm"):
        more.sample([[15.0, 14.0]], [[0.5, 0.5]])


def test_the_region_turns_with_its_film_point():
    pupil = lb.exit_pupil(lenses.load("pbrt-dgauss-50mm"), 36.1, [0.0, 20.0])
    uv = np.random.default_rng(0).random((500, 2))
    along, _ = pupil.sample(np.tile([9.0, 0.0], (500, 1)), uv)
    across, _ = pupil.sample(np.tile([0.0, 9.0], (500, 1)), uv)
    np.testing.assert_allclose(across, np.column_stack([-along[:, 1], along[:, 0]]), atol=1e-9)


def test_a_table_ends_where_the_light_does():
    lens = lenses.load("pbrt-fisheye-10mm")
    distance = lb.first_order(lens).bfl
    table = PupilTable.of(lens, distance, 21.6)
    just = lb.exit_pupil(lens, distance, [table.dark_beyond * 0.999, table.dark_beyond * 1.001])
    assert just.area[0] > 0.0 and just.area[1] == 0.0
    assert table.outline.shape[0] == RINGS


@pytest.mark.parametrize(("distance", "radii"), [(0.0, [1.0]), (-1.0, [1.0]), (math.nan, [1.0]), (30.0, [-1.0]),
                                                 (30.0, [math.nan]), (30.0, [math.inf])])
def test_invalid_radii_and_distances_are_refused(distance, radii):
    with pytest.raises(lb.LensError, match="exit pupil"):
        lb.exit_pupil(lenses.load("pbrt-dgauss-50mm"), distance, radii)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm"])
def test_the_samples_of_the_corner_fill_the_region_of_the_last_ring(name):
    """The corners of the sectors, as they are sampled from the very edge of the table and from just inside of it."""
    lens = lenses.load(name)
    film_distance = lb.film_distance(lens, 2000.0)
    table = PupilTable.of(lens, film_distance, 21.6, widened=False)
    outline, sectors = table.outline, table.outline.shape[1] - 1
    for inside in (0.0, 0.3, 0.9):                      # of the way to the ring before
        r = table.radius
        if inside:                                      # the film radius at this place between the last two rings
            r = table.end * (1.0 - (1.0 - (RINGS - 1.0 - inside) / table.scale) ** 2)
        n = sectors
        given = {X: np.full(n, r * (1.0 - 1e-9)), U0: (np.arange(n) + 1e-9) / (2.0 * sectors), U1: np.ones(n)}
        l, m, n_ = Program([table.step(1.0)], np.float64).run(given, [L, M, N], n)
        rear = np.stack([given[X] - l / n_ * film_distance, -m / n_ * film_distance], 1)
        wanted = (1.0 - inside) * outline[-1] + inside * outline[-2]
        wanted = wanted[:-1] + [table.centre(given[X][:1])[0], 0.0]
        np.testing.assert_allclose(rear, wanted, atol=2e-3 * np.abs(outline).max())


def _marched(lens: lb.Lens, distance: float, r: float, x: np.ndarray) -> np.ndarray:
    """Whether meridional rays from the film point (r, 0) through (x, 0) of the rear plane pass.

    In steps along each ray to its first crossing with a surface, then by bisection; Snell's law with angles.
    """
    at, z, angle = np.full(x.size, r), np.full(x.size, lens.length + distance), np.arctan2(x - r, distance)
    passes, index = np.ones(x.size, bool), lens.indices()
    for k in range(len(lens.surfaces) - 1, -1, -1):
        surface, vertex = lens.surfaces[k], lens.vertex(k)[2]
        h = surface.semi_diameter
        sag = surface.sag(np.linspace(0.0, h, 999))
        first, last = (z - vertex - end for end in (sag.max() + 1e-9, sag.min() - 1e-9))    # ways towards the scene

        def above(way, start=(at, z, angle), surface=surface, vertex=vertex, h=h):
            height = start[0] + way * np.tan(start[2])
            return start[1] - way - vertex - np.where(np.abs(height) <= h, surface.sag(np.minimum(np.abs(height), h)),
                                                      np.nan)

        ways = first + (last - first) * np.linspace(0.0, 1.0, 401)[:, None]
        gaps = above(ways)
        met = (gaps[:-1] > 0.0) & (gaps[1:] <= 0.0)
        j, rays = met.argmax(0), np.arange(x.size)
        low, high = ways[j, rays], ways[j + 1, rays]
        for _ in range(50):
            middle = 0.5 * (low + high)
            out = above(middle) > 0.0
            low, high = np.where(out, middle, low), np.where(out, high, middle)
        at, z = at + high * np.tan(angle), z - high
        passes &= met.any(0) & (np.abs(at) <= h)
        near = np.minimum(np.abs(at), h * (1.0 - 1e-5))
        slope = np.sign(at) * (surface.sag(near + 1e-6 * h) - surface.sag(np.abs(near - 1e-6 * h))) / (2e-6 * h)
        normal = np.arctan(-slope)          # of the direction towards the scene, as `angle`: height over way
        with np.errstate(invalid="ignore"):
            angle = -normal + np.arcsin(np.sin(angle + normal) * index[k + 1] / index[k])
        passes &= np.isfinite(angle)
        at, angle = np.where(passes, at, 0.0), np.where(passes, angle, 0.0)
    return passes


@pytest.mark.parametrize("r", [1.0, 2.2, 2.5, 3.0, 3.4])
def test_regions_behind_strong_aspheres_end_where_rays_found_by_small_steps_do(r):
    """Newton's method began on the conic, far outside: the region ended at 2 mm, and rays were lost up to 3.5 mm."""
    lens = lenses.load("apple-phone-6-elements-4-f18")
    distance = lb.film_distance(lens, math.inf)
    pupil = lb.exit_pupil(lens, distance, [r])
    x = np.linspace(0.6 * r - 0.5, 0.9 * r + 0.5, 801)
    lit = x[_marched(lens, distance, r, x)]
    ways = np.column_stack([x - r, 0.0 * x, np.full(x.size, -distance)])
    traced = x[lb.trace(lens, [r, 0.0, lens.length + distance], ways).fate == lb.Fate.PASSED]
    step = x[1] - x[0]
    ends = pupil.centres[0] + pupil.rims[0, [-1, 0], 0]
    assert np.abs(lit[[0, -1]] - traced[[0, -1]]).max() <= 1.01 * step
    assert np.abs(lit[[0, -1]] - ends).max() <= 1.01 * step


def test_a_film_point_moved_along_its_ray_has_the_same_clearance():
    lens, away = lenses.load("pbrt-dgauss-50mm"), 38.0
    film, rear = np.array([[9.0, -4.0], [-2.0, 11.0], [0.0, 0.0]]), np.array([[2.0, 3.0], [-5.0, 1.0], [6.0, 0.0]])
    found = []
    for moved in (0.0, 3.0, -8.0):
        x, y = np.ascontiguousarray((rear + (film - rear) * (away + moved) / away).T)
        out = np.empty(3)
        clearances(x, y, np.full(3, moved), *np.ascontiguousarray(rear.T), away, out, clearance_tracer(lens, away), 0.0)
        found.append(out)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-12)
