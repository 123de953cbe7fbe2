"""The ray grid: chief rays, the open pupil, optical paths and spots, against laws of optics and the scalar tracer."""

from dataclasses import replace
from math import inf, radians

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_beams import FieldBeams
from lensbench.core.optics.finding import Kind
from lensbench.core.optics.system import FieldPoint, SystemData
from lensbench.lenses.tables.paraxial import axial_heights
from tests.core.optics.test_surface_pose import SINGLET, posed
from tests.core.oracles import REFERENCE, lens

LISTED = {10.0: 17.485856, 14.0: 24.588739}             # real image heights of CODE V's chief rays, other film plane


def of_angles(stack, film_distance, *degrees, pupil=32, **more):
    """The grid of a lens for fields by angle at the d line."""
    given = lb.analysis.conditions(stack, None, degrees, [lb.D_LINE], field_kind=lb.FieldKind.ANGLE, **more)
    return lb.analysis.ray_grid(stack, film_distance, given, pupil)


def hyperbolic(index=1.5, focal_length=50.0, radius=10.0):
    """A plano-convex lens without spherical aberration: flat towards the scene, its rear a hyperboloid k = −n²."""
    return lb.Lens((lb.Surface(6.0, radius, lb.Glass(index), curvature=0.0),
                    lb.Surface(0.0, 2.0 * radius, curvature=-1.0 / (focal_length * (index - 1.0)), conic=-index**2)), 0)


@pytest.mark.parametrize("name", ["dgauss", "cooke", "codev"])
def test_chief_rays_meet_the_film_where_forty_digits_put_them(name):
    stack, film = lens(name), REFERENCE[name]["film_z"]
    angles = np.radians([0.0, 4.0, 11.0])
    found = find_chief_rays(stack, film - stack.length, np.column_stack([0.0 * angles, angles]))
    for i, angle in enumerate(angles):
        ray = lb.chief_ray(stack, float(angle))
        np.testing.assert_allclose(found.image_directions[i], ray.direction, atol=1e-13)
        at = ray.points[-1] + (film - ray.points[-1, 2]) / ray.direction[2] * ray.direction
        np.testing.assert_allclose(found.images[i], at[:2], atol=1e-12)


def test_a_fisheyes_fields_beyond_a_right_angle_and_beyond_its_sight():
    fisheye = lenses.load("lib-miyamoto-fisheye-1964")
    away = lb.film_distance(fisheye, inf)
    found = find_chief_rays(fisheye, away, np.array([[0.0, radians(98.0)], [0.0, radians(175.0)]]))
    np.testing.assert_allclose(found.points[0], lb.chief_ray(fisheye, radians(98.0)).points[0], atol=1e-11)
    assert np.isnan(found.images[1]).all()
    back = find_chief_rays(fisheye, away, found.images[:1], by_image=True)
    np.testing.assert_allclose(back.angles[0], [0.0, radians(98.0)], atol=1e-12)


def test_a_plane_object_lights_no_field_beyond_a_right_angle_and_its_fans_are_empty():
    fisheye = lenses.load("lib-miyamoto-fisheye-1964")
    given = lb.analysis.conditions(fisheye, None, (0.0, 8.1, 12.35), object_distance=160.0)
    rays = lb.analysis.ray_grid(fisheye, lb.film_distance(fisheye, inf), given, 16)
    assert np.degrees(rays.field_angles[1:]) == pytest.approx([60.0, 92.0], abs=2.0)
    assert rays.lit.tolist() == [True, True, False]
    said = [str(finding) for finding in rays.findings if "beyond 90°" in str(finding)]
    assert len(said) == 1 and not any("rims end all rays" in str(finding) for finding in rays.findings)
    passed = lb.analysis.ray_fans(rays, 9).passed.any((1, 2, 3))
    assert passed.tolist() == [True, True, False]


def test_a_field_beyond_a_right_angle_has_its_light():
    """The lens sees 95°. Its beams narrow smoothly: no field has less than half of the rays of one 4° nearer."""
    fisheye = lenses.load("canon-rf-l-dual-fisheye-52-f28")
    given = lb.analysis.conditions(fisheye, None, (0.0, 84.0, 88.0, 92.0), field_kind=lb.FieldKind.ANGLE)
    rays = lb.analysis.ray_grid(fisheye, lb.film_distance(fisheye, inf), given, 16)
    assert rays.lit.all() and not any(finding.kind is lenses.Kind.DARK for finding in rays.findings)
    light = rays.weight.sum((1, 2, 3))
    assert (light[2:] > 0.5 * light[1:-1]).all()


def test_chief_rays_of_an_anamorphic_lens_reach_film_points_of_any_azimuth():
    stack = lenses.load("lentil-schneider-anamorphic-31-2001")
    wanted = np.array([[0.0, 0.0], [6.0, 3.0], [-9.0, 5.0]])
    found = find_chief_rays(stack, lb.film_distance(stack, inf), wanted, by_image=True)
    np.testing.assert_allclose(found.images, wanted, atol=1e-11)
    t = lb.trace(stack, found.points - 20.0 * found.directions, found.directions, clip=False, record=True)
    assert np.abs(t.paths[:, 1 + stack.stop_index, :2]).max() < 1e-9


def test_a_lens_free_of_spherical_aberration_has_no_path_difference_and_a_point_for_a_spot():
    perfect = hyperbolic()
    grid = of_angles(perfect, lb.film_distance(perfect, inf), 0.0)
    assert np.nanmax(np.abs(grid.opd)) < 1e-12
    assert np.nanmax(np.hypot(grid.offset_s, grid.offset_t)) < 1e-12
    assert lb.analysis.spots(grid).geo[0, 0, 0] < 1e-12


@pytest.mark.parametrize("distance", [inf, 900.0])
def test_rays_land_at_the_slope_of_their_path_difference(distance):
    stack = lenses.load("pbrt-dgauss-50mm")
    grid = of_angles(stack, lb.film_distance(stack, inf) + 0.05, 0.0, 12.0, pupil=64, object_distance=distance)
    at = np.stack([grid.offset_s, grid.offset_t]), np.stack([grid.pupil_s, grid.pupil_t])
    # A ray off the centre of the reference sphere crosses it aslant: dW = e · dp / |e / R + p|, p of length 1
    (e, p), kappa = at, grid.sphere_curvatures[:, None, None, None]
    at = e / np.sqrt(1.0 + 2.0 * kappa * (e * p).sum(0) + kappa**2 * (e * e).sum(0)), p
    for axis in (2, 3):
        # From ray to ray, W grows by the mean of their landings times the step of the pupil (trapezium rule)
        offset, pupil = (np.moveaxis(each, 1 + axis, -1) for each in at)
        w = np.moveaxis(grid.opd, axis, -1)
        change = np.diff(w)
        expected = (0.5 * (offset[..., 1:] + offset[..., :-1]) * np.diff(pupil)).sum(0)
        good = np.isfinite(change)
        assert good.sum() > 5000
        off = (change - expected)[good]                 # 5 nm: the rule's error at the steep rim of the pupil
        assert np.abs(off).max() < 5e-6 and np.sqrt((off**2).mean()) < 1.5e-6 and np.abs(change[good]).max() > 1e-3


@pytest.mark.parametrize("degrees", [0.0, 10.0])
def test_spot_sizes_equal_those_of_a_dense_bundle_of_the_scalar_tracer(degrees):
    stack = lenses.load("pbrt-dgauss-50mm")
    away = lb.film_distance(stack, inf)
    spot = lb.analysis.spots(of_angles(stack, away, degrees), "centroid")
    rng, angle = np.random.default_rng(7), radians(degrees)
    reach = 1.2 * stack.surfaces[0].semi_diameter
    x, y = rng.uniform(-reach, reach, (2, 60_000))
    along, up = np.array([0.0, np.sin(angle), np.cos(angle)]), np.array([0.0, np.cos(angle), -np.sin(angle)])
    t = lb.trace(stack, np.outer(x, [1.0, 0.0, 0.0]) + np.outer(y, up) - 30.0 * along, along)
    run = (stack.length + away - t.points[:, 2]) / t.directions[:, 2]
    on_film = (t.points + run[:, None] * t.directions)[t.fate == lb.Fate.PASSED, :2]
    expected = np.sqrt(((on_film - on_film.mean(0)) ** 2).mean(0))
    # Of 15,000 random rays the standard deviation is known to 0.6 % or somewhat worse
    np.testing.assert_allclose(spot.rms[0, 0, 0], expected, rtol=0.02)


def test_the_open_area_is_the_irradiance_that_the_exit_pupil_gives():
    stack = lenses.load("pbrt-dgauss-50mm")
    given = lb.analysis.conditions(stack, lb.Film(), 4)
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), given, 64)
    expected = lb.falloff(stack, grid.film_distance, grid.image_heights).irradiance
    np.testing.assert_allclose(grid.open_area, expected, rtol=1e-3)     # the cells at corners of the region


def test_the_blades_of_the_stop_bound_the_open_pupil():
    from dataclasses import replace
    stack = lb.stopped_down(replace(lenses.load("pbrt-dgauss-50mm"), blades=6), 5.6)
    away = lb.film_distance(stack, inf)
    grid = of_angles(stack, away, 0.0, pupil=64)
    expected = lb.falloff(stack, away, [0.0]).irradiance[0]         # of a circle of as much area
    assert grid.open_area[0] == pytest.approx(expected, rel=4e-3)
    covered = grid.coverage[0, 0].sum() * grid.steps[0].prod()
    assert covered == pytest.approx(grid.open_area[0], rel=1e-2)
    box = grid.pupil[0, :, -1] - grid.pupil[0, :, 0]
    assert box[1] / box[0] == pytest.approx(2.0 / np.sqrt(3.0), rel=0.05)                   # a corner points up


def test_spots_through_focus_are_those_of_the_shifted_film():
    stack = lens("cooke")
    away = REFERENCE["cooke"]["film_z"] - stack.length
    shifts = [-0.2, 0.0, 0.15]
    found = lb.analysis.spots(of_angles(stack, away, 0.0, 14.0), "centroid", shifts)
    for k, shift in enumerate(shifts):
        there = lb.analysis.spots(of_angles(stack, away + shift, 0.0, 14.0), "centroid")
        np.testing.assert_allclose(found.rms_radius[:, :, k], there.rms_radius[:, :, 0], rtol=5e-3)
    best = found.best_shifts
    at_best = [lb.analysis.spots(found.rays, "centroid", [b - 1e-3, b, b + 1e-3]).white_rms_radius[i]
               for i, b in enumerate(best)]
    assert all(before > at < after for before, at, after in at_best)


def test_colours_share_the_reference_of_the_primary_wavelength():
    stack = lenses.load("pbrt-dgauss-50mm")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, lb.Film(), 3))
    assert np.abs(grid.chief[:, 1]).max() < 1e-12
    angle = float(grid.field_angles[2])
    for c, line in enumerate(grid.conditions.wavelengths):
        ray = lb.chief_ray(stack, angle, line)
        at = ray.points[-1] + (stack.length + grid.film_distance - ray.points[-1, 2]) / ray.direction[2] * ray.direction
        assert grid.chief[2, c, 1] == pytest.approx(at[1] - grid.images[2, 1], abs=1e-11)
    # The chief ray, the least of the paths about it, has no path difference
    blue = grid.grid_opd[2, 0]
    s, t = grid.pupil[2]
    assert abs(blue[np.abs(t - grid.chief_pupil[2, 1]).argmin(), np.abs(s).argmin()]) < 2e-4


def test_conditions_come_from_the_lens_or_say_that_they_are_assumed():
    stack = lenses.load("pbrt-dgauss-50mm")
    assumed = lb.analysis.conditions(stack)
    assert [finding.kind for finding in assumed.findings] == [Kind.ASSUMED, Kind.ASSUMED, Kind.GLASS]
    assert len(assumed.fields) == 12 and assumed.fields[-1][1] == pytest.approx(21.633, abs=1e-3)
    system = lb.SystemData(field_kind=lb.FieldKind.ANGLE, fields=(lb.FieldPoint(0.0, 0.0), lb.FieldPoint(0.0, 14.0)),
                           wavelengths=(lb.Wavelength(0.55, 2.0), lb.Wavelength(0.45, 1.0)))
    from dataclasses import replace
    stated = lb.analysis.conditions(replace(stack, system=system))
    assert stated.fields == ((0.0, 0.0), (0.0, 14.0)) and stated.field_kind is lb.FieldKind.ANGLE
    assert stated.wavelengths == (0.55, 0.45) and stated.weights == pytest.approx((2 / 3, 1 / 3))


def test_fields_that_no_light_reaches_are_named_and_left_empty():
    fisheye = lenses.load("pbrt-fisheye-10mm")
    given = lb.analysis.conditions(fisheye, None, [0.0, 20.0])
    grid = lb.analysis.ray_grid(fisheye, lb.film_distance(fisheye, inf), given)
    assert [finding.kind for finding in grid.findings][-1] is Kind.DARK and "20 mm" in str(grid.findings[-1])
    assert grid.lit.tolist() == [True, False] and np.isnan(grid.opd[1]).all()
    spot = lb.analysis.spots(grid)
    assert np.isnan(spot.rms_radius[1]).all() and np.isfinite(spot.rms_radius[0]).all()


def test_a_field_whose_rays_all_end_at_rims_is_dark_and_named():
    """Beyond the field of a phone lens: its film sees light there, but of no point whose chief ray meets it."""
    stack = lenses.load("phone-73-f4")
    grid = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), lb.analysis.conditions(stack, lb.Film()), 16)
    dark = [finding for finding in grid.findings if finding.kind is Kind.DARK]
    assert any("rims end all rays" in str(finding) for finding in dark)
    assert (grid.lit == grid.weight[:, 1].any((1, 2))).all() and (grid.lit == grid.coverage.any((1, 2, 3))).all()
    assert np.isfinite(lb.analysis.spots(grid).rms_radius[grid.lit]).all()


def test_a_lens_state_is_traced_once():
    stack = lenses.load("pbrt-dgauss-50mm")
    given = lb.analysis.conditions(stack, lb.Film(), 4)
    assert lb.analysis.ray_grid(stack, 35.0, given) is lb.analysis.ray_grid(stack, 35.0, given)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: of_angles(lb.Lens((lb.Surface(5.0, 8.0, lb.Glass(1.5), curvature=0.0),
                                lb.Surface(0.0, 8.0, curvature=0.0)), 0), 30.0, 0.0),
     "afocal"),
    (lambda: of_angles(hyperbolic(), -1.0, 0.0), "behind the last vertex"),
    (lambda: of_angles(hyperbolic(), 50.0, 0.0, pupil=4), "at least 8"),
    (lambda: of_angles(lenses.load("pbrt-dgauss-50mm"), 35.0, 70.0), "no ray through the middle"),
    (lambda: lb.analysis.spots(of_angles(hyperbolic(), 50.0, 0.0), "middle"), "chief, centroid"),
    (lambda: lb.analysis.conditions(hyperbolic(), None, 0), "at least 1"),
    (lambda: lb.analysis.conditions(hyperbolic(), None, [1.0], field_kind=lb.FieldKind.OBJECT_HEIGHT), "finite"),
])
def test_what_cannot_be_shown_is_said(make, message):
    with pytest.raises(lb.LensError, match=message):
        make()


@pytest.mark.parametrize("points", [12, 13])
def test_mirrored_beams_have_the_rays_of_beams_traced_in_full(monkeypatch, points):
    """Half of the rays are traced, and count for their mirror images: across any meridian, and behind five blades."""
    stack = replace(lens("dgauss"), blades=5, blade_reach=1.0)
    away, oblique = lb.film_distance(lens("dgauss"), inf), [(6.0, 8.0), (0.0, 15.0)]
    for each, fields in ((stack, [0.0, 12.0]), (lens("dgauss"), oblique)):
        given = lb.analysis.conditions(each, None, fields, [lb.D_LINE], 900.0)
        half = lb.analysis.ray_grid(each, away, given, points)
        assert half.beams.mirrored
        with monkeypatch.context() as patch:
            patch.setattr(FieldBeams, "mirrored", False)
            lb.analysis.ray_grid.cache_clear()
            whole = lb.analysis.ray_grid(each, away, given, points)
            otf = lb.analysis.mtf_map(each, away, given, fields=2, pupil=points).white
        lb.analysis.ray_grid.cache_clear()
        for name in ("offset_s", "slope_t", "pupil_s", "opd", "weight", "coverage", "open_centre", "intensity"):
            np.testing.assert_allclose(getattr(half, name), getattr(whole, name), atol=1e-10, err_msg=name)
        np.testing.assert_array_equal(half.victim, whole.victim)
        again = lb.analysis.mtf_map(each, away, given, fields=2, pupil=points).white
        np.testing.assert_allclose(again, otf, atol=1e-10)


def test_beams_behind_blades_that_lean_are_traced_in_full():
    oblique = replace(lens("dgauss"), blades=5, blade_reach=1.0)
    leaning = replace(oblique, blade_rotation=0.1)
    away = lb.film_distance(leaning, inf)
    for stack, field in ((leaning, (0.0, 12.0)), (oblique, (6.0, 8.0))):
        given = lb.analysis.conditions(stack, None, [field], [lb.D_LINE])
        rays = lb.analysis.ray_grid(stack, away, given, 24)
        assert not rays.beams.mirrored
        assert np.abs(rays.coverage - rays.coverage[..., ::-1]).max() > 0.1


@pytest.mark.parametrize(("name", "field", "reach", "part"), [
    ("lib-miyamoto-fisheye-1964", 0.0, 3.0, 0.003), ("lib-miyamoto-fisheye-1964", 11.8, 3.0, 0.003),
    ("fujifilm-fujinon-xf-r-lm-wr-23-f14", 13.4, 9.0, 0.006), ("lib-us7558005a", 0.0, 1.0, 0.012),
    ("lentil-minolta-fisheye-1978", 21.63, 5.0, 0.01),
])
def test_a_strongly_aberrated_beam_is_whole_and_counts_once(name, field, reach, part):
    """The rms radius is that of all rays of the object that pass, whatever the way that their pupil is found.

    The rays of the film's centre leave the fisheye, whose entrance pupil lies 21 mm behind the first surface, up to
    half a degree off the axis. Past the rims of the second lens, rays fold back into the beam; past those of the phone
    lens they land far from it; and at the edge of the other fisheye neighbouring rays part without limit.
    """
    stack = lenses.load(name)
    away = lb.film_distance(stack, inf)
    given = lb.analysis.conditions(stack, fields=((0.0, field),), wavelengths=[lb.D_LINE])
    rays = lb.analysis.ray_grid(stack, away, given, 48)
    assert not [each for each in rays.findings if each.kind is Kind.SAMPLING and "steep" not in each.figures]
    way, at = rays.beams.chief.directions[0], rays.beams.chief.points[0]
    side = np.cross(way, [1.0, 0.0, 0.0])
    plane = np.stack([[1.0, 0.0, 0.0] - way[0] * way, side / np.linalg.norm(side)])
    offsets = np.stack(np.meshgrid(*2 * [np.linspace(-reach, reach, 241)]), -1).reshape(-1, 2)
    went = lb.trace(stack, at - 50.0 * way + offsets @ plane, np.broadcast_to(way, (len(offsets), 3)), forward=True)
    passed = went.fate == lb.Fate.PASSED
    assert np.abs(offsets[passed]).max() < 0.97 * reach
    points, ways = went.points[passed], went.directions[passed]
    landed = points + ((stack.length + away - points[:, 2]) / ways[:, 2])[:, None] * ways
    expected = np.sqrt(((landed[:, :2] - rays.images[0]) ** 2).sum(1).mean())
    assert lb.analysis.spots(rays).white_rms_radius[0, 0] == pytest.approx(expected, rel=part)


def test_light_that_the_grid_misses_is_said():
    """At the edge of this field the rays of the pupil fold: two of them belong to one place of the beam."""
    stack = lenses.load("lentil-schneider-anamorphic-31-2001")
    given = lb.analysis.conditions(stack, fields=((0.0, 17.7),))
    rays = lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), given, 16)
    assert [str(each) for each in rays.findings if each.kind is Kind.SAMPLING] == [
        "strong aberrations: the rays of the grid miss a part of the light of 17.7 mm"]


@pytest.mark.parametrize("count", [1, 2, 7])
def test_a_number_of_fields_lies_evenly_from_the_middle_of_the_film_to_its_corner(count):
    stack, film = lens("dgauss"), lb.Film(30.0, 40.0, 3, 4)
    given = lb.analysis.conditions(stack, film, count)
    assert given.field_kind is lb.FieldKind.REAL_IMAGE_HEIGHT and len(given.fields) == count
    x, y = np.transpose(given.fields)
    assert (x == 0.0).all() and y[0] == 0.0 and (count == 1 or y[-1] == pytest.approx(25.0))
    assert np.diff(y) == pytest.approx([25.0 / (count - 1)] * (count - 1) if count > 1 else [])
    for none in (0, -1):
        with pytest.raises(lb.LensError, match="at least 1 is needed"):
            lb.analysis.conditions(stack, film, none)


@pytest.mark.parametrize(("wavelengths", "message"), [
    ([550.0], "0.55 for 550 nm"),
    ([(0.5, -1.0), (0.6, 2.0)], "must not be negative"),
])
def test_wavelengths_in_nanometres_and_negative_weights_are_refused(wavelengths, message):
    with pytest.raises(lb.LensError, match=message):
        lb.analysis.conditions(hyperbolic(), wavelengths=wavelengths)


def test_glasses_without_dispersion_are_said_for_one_wavelength_and_among_others():
    flint = lb.Surface(1.0, 5.0, lb.Glass(1.62, 36.0), curvature=0.0)
    for stack, lines, text in ((hyperbolic(), [0.248], "no dispersion data for this lens"),
                               (hyperbolic(), [lb.D_LINE], None),
                               (lb.Lens((flint, *hyperbolic().surfaces), 0), None, "the dispersion of 1 of 2 glasses")):
        said = [str(each) for each in lb.analysis.conditions(stack, wavelengths=lines).findings
                if each.kind is Kind.GLASS]
        assert [each[:len(text or "")] for each in said] == ([] if text is None else [text])


def test_a_fan_of_a_folded_pupil_is_one_smooth_curve_with_a_gap():
    """At the rim of this field two rays meet one height of the stop, and beyond there is none."""
    stack = lenses.load("lentil-schneider-anamorphic-31-2001")
    away = lb.film_distance(stack, 1820.0)
    given = lb.analysis.conditions(stack, None, [4.24, 11.3], [lb.D_LINE],
                                   object_distance=1820.0 - away - stack.length)
    along = lb.analysis.ray_fans(lb.analysis.ray_grid(stack, away, given, 16)).transverse[:, 1, 0]
    assert np.isfinite(along[0]).all() and np.abs(np.diff(along[0], 2)).max() < 0.015        # mm
    assert np.isnan(along[1, -3:]).all() and np.isfinite(along[1, :-3]).all()


def test_rims_at_which_aspheres_end_cut_no_beam_off():
    """Rays just outside the rims of this lens miss its surfaces: the grid does not widen in search of them."""
    stack = lenses.load("apple-phone-6-elements-4-f18")
    away = lb.film_distance(stack, 690.0)
    given = lb.analysis.conditions(stack, None, [0.0, 0.7648], None,
                                   object_distance=690.0 - away - stack.length)
    rays = lb.analysis.ray_grid(stack, away, given, 16)
    assert ((rays.coverage[:, 1] > 0.0).sum((1, 2)) > 90).all()


@pytest.mark.parametrize(("points", "field"), [(16, 1.09374), (32, 1.7968592)])
def test_rays_past_the_rims_of_aspheres_bring_no_light(points, field):
    """Rays from the film that miss a surface, or fold back into the beam, had a hundred times the light of others."""
    stack, frequency = lenses.load("apple-phone-6-elements-4-f18"), 40.0
    away = lb.film_distance(stack, 1200.0)
    distance = 1200.0 - away - stack.length
    given = lb.analysis.conditions(stack, None, [field], [lb.D_LINE], object_distance=distance)
    rays = lb.analysis.ray_grid(stack, away, given, points)
    way, at = rays.beams.chief.directions[0], rays.beams.chief.points[0]
    point = at - (distance + at[2]) / way[2] * way
    offsets = np.stack(np.meshgrid(*2 * [np.linspace(-1.6, 1.6, 129)]), -1).reshape(-1, 2)
    ways = at + np.column_stack([offsets, np.zeros(len(offsets))]) - point
    starts, ways = point + 0.99 * ways, ways / np.linalg.norm(ways, axis=1)[:, None]
    went = lb.trace(stack, starts, ways, forward=True)
    passed = went.fate == lb.Fate.PASSED
    assert np.abs(offsets[passed]).max() < 1.5
    light = ways[passed, 2] ** 4                        # of even places on a plane across the axis, by Lambert's law
    landed = went.points[passed] + ((stack.length + away - went.points[passed, 2])
                                    / went.directions[passed, 2])[:, None] * went.directions[passed]
    turns = np.exp(2j * np.pi * frequency * (landed[:, :2] - rays.images[0]))
    expected = np.abs(light @ turns) / light.sum()      # x is sagittal, y tangential
    found = np.abs(lb.analysis.mtf(rays, [frequency], "geometric").otf[0, 0, :, 0])
    np.testing.assert_allclose(found, expected, atol=0.4 / points)


def test_no_light_is_missed_where_rays_fold_past_the_rim():
    stack = lenses.load("apple-phone-6-elements-4-f18")
    away = lb.film_distance(stack, 1200.0)
    given = lb.analysis.conditions(stack, None, [0.35, 0.4], [lb.D_LINE], object_distance=1200.0 - away - stack.length)
    rays = lb.analysis.ray_grid(stack, away, given, 16)
    assert not [each for each in rays.findings if each.kind is Kind.SAMPLING and "fields" in each.figures]


def test_widened_cells_are_as_fine_as_the_light_allows():
    stack = lenses.load("phone-72-f4")
    away = lb.film_distance(stack, 1200.0)
    given = lb.analysis.conditions(stack, None, [4.0], [lb.D_LINE], object_distance=1200.0 - away - stack.length)
    rays = lb.analysis.ray_grid(stack, away, given, 16)
    assert (rays.coverage > 0.0).sum() > 150


def test_a_sliver_of_light_has_a_grid_of_its_own_size():
    """At the edge of light rims leave a triangle, a sixth of the stop's image: its rays had a third too much light."""
    stack = lenses.load("nikon-af-p-dx-nikkor-g-vr-10-20-f45").at(zoom=0.0, close=0.0)
    given = lb.analysis.conditions(stack, fields=(9.95,), wavelengths=[lb.D_LINE])
    coarse, fine = (lb.analysis.ray_grid(stack, lb.film_distance(stack, inf), given, points) for points in (12, 96))
    assert (coarse.coverage > 0.0).sum() > 0.1 * 12**2
    assert coarse.open_area[0] == pytest.approx(float(fine.open_area[0]), rel=0.04)
    assert lb.analysis.spots(coarse).white_rms_radius[0, 0] == pytest.approx(
        float(lb.analysis.spots(fine).white_rms_radius[0, 0]), rel=5e-3)


def test_rays_of_rims_that_carry_the_spot_are_a_finding():
    """The rms radius is a third too large at 32 points: rays just outside the rim land 2 mm away."""
    stack = lenses.load("fujifilm-fujinon-xf-r-wr-23-f2").at(zoom=0.0, close=0.0)
    given = lb.analysis.conditions(stack, fields=(0.0, 7.05), wavelengths=[lb.D_LINE])
    away = lb.film_distance(stack, inf)
    finding, = (each for each in lb.analysis.ray_grid(stack, away, given, 32).findings if each.kind is Kind.SAMPLING)
    assert "7.05 mm" in str(finding) and finding.figures == {"uneven": 1.0}


def test_light_through_a_hole_far_smaller_than_the_stop_is_found():
    """A rim of 1 µm: the paraxial ray that touches it has the slope y / (y₂ f), by the height y at the surface."""
    stack = lenses.load("pbrt-dgauss-50mm")
    rims = [0.001 if i == 2 else each.semi_diameter for i, each in enumerate(stack.surfaces)]
    hole = replace(stack, surfaces=tuple(replace(each, semi_diameter=rim) for each, rim in zip(
        stack.surfaces, rims, strict=True)))
    rays = lb.analysis.ray_grid(hole, lb.film_distance(hole, inf), lb.analysis.conditions(hole, fields=(0.0, 1.0)), 24)
    slope = 0.001 / (axial_heights(stack.surfaces)[2] * lb.first_order(stack).efl)
    assert rays.open_area[0] == pytest.approx(np.pi * slope**2, rel=5e-3) and rays.lit.all()


@pytest.mark.parametrize("pose", [{}, {"tilt_x": 0.2}, {"decentre_x": 0.4, "decentre_y": -0.8, "tilt_x": 0.1,
                                                       "tilt_y": -0.25}])
def test_the_chief_ray_passes_the_middle_of_a_stop_however_it_leans(pose):
    leaning = posed(SINGLET, 2, 2, **pose)
    beams = of_angles(leaning, lb.film_distance(leaning, inf), 0.0, 4.0).beams
    np.testing.assert_allclose(beams.on_stop(beams.chief_pupil[:, :1], beams.chief_pupil[:, 1:]), 0.0, atol=1e-6)


def test_vignetting_factors_that_rims_replace_are_said():
    stack = lenses.load("pbrt-dgauss-50mm")
    for factors, said in (((0.0, 0.0, 0.3, 0.3), 1), ((0.0,) * 4, 0)):
        stated = replace(stack, system=SystemData(field_kind=lb.FieldKind.ANGLE,
                                                  fields=(FieldPoint(0.0, 0.0), FieldPoint(0.0, 14.0, 1.0, factors))))
        found = lb.analysis.conditions(stated).findings
        assert sum("vignetting factors of 1" in str(each) for each in found) == said
