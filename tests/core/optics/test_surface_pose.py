"""Tilted and decentred surfaces, in both tracers, against forty digits and against what a pose means."""

from dataclasses import replace
from math import inf, nan, radians

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.lens_surface import Frame, tilts_of
from lensbench.core.pupils.region import axis_irradiance
from tests.core.design.test_tolerances import DOUBLET, oracle

BACK = 90.0


def posed(lens, first, last, **pose):
    """The lens with surfaces first … last as one body about the front vertex."""
    return replace(lens, surfaces=tuple(
        replace(s, pose=lb.SurfacePose(**pose, pivot=i - first)) if first <= i <= last else s
        for i, s in enumerate(lens.surfaces)))


SINGLET = lb.Lens((lb.Surface(5.0, 9.0, lb.Glass(1.6), curvature=1 / 60.0), lb.Surface(6.0, 9.0, curvature=-1 / 70.0),
                   lb.Surface(0.0, 7.0, curvature=0.0)), 2)
BENT = {"decentre_x": 0.7, "decentre_y": -0.4, "tilt_x": 0.11, "tilt_y": -0.07, "roll": 0.4}    # round: roll is nothing
MIXED = posed(posed(DOUBLET, 0, 2, **BENT), 4, 5, decentre_x=-0.5, tilt_y=0.09)


def rays(count=40, reach=3.0):
    random = np.random.default_rng(5)
    origins = np.column_stack([random.uniform(-reach, reach, (count, 2)), np.full(count, -7.0)])
    directions = np.column_stack([random.normal(0.0, 0.05, (count, 2)), np.ones(count)])
    return origins, directions / np.linalg.norm(directions, axis=1)[:, None]


@pytest.mark.parametrize(("lens", "poses"), [
    (posed(SINGLET, 0, 1, **BENT), [(0.7, -0.4, 0.11, -0.07), (0.0, 0.0, 0.0, 0.0)]),
    (posed(DOUBLET, 4, 5, decentre_y=0.6), [(0, 0, 0, 0), (0, 0, 0, 0), (0.0, 0.6, 0.0, 0.0)]),
    (MIXED, [(0.7, -0.4, 0.11, -0.07), (0, 0, 0, 0), (-0.5, 0.0, 0.0, 0.09)])])
def test_tilted_bodies_agree_with_forty_digits(lens, poses):
    origins, directions = rays(3)
    made = lb.trace(lens, origins, directions, clip=False)
    slopes = made.directions[:, :2] / made.directions[:, 2:]
    at = made.points[:, :2] + (BACK - made.points[:, 2:]) * slopes
    wanted = np.array([oracle(lens, poses, BACK, o, d) for o, d in zip(origins, directions, strict=True)])
    assert np.abs(np.column_stack([at, slopes]) - wanted).max() < 1e-12


@pytest.mark.parametrize("towards", ["film", "scene"])
@pytest.mark.parametrize("change", [
    {}, {"conic": -0.6}, {"aspheric": ((4, 1e-6), (6, -1e-9))}, {"aspheric": ((3, 1e-5),)}, {"curvature_x": 0.01}])
def test_block_kernels_are_the_reference(change, towards):
    lens = posed(replace(SINGLET, surfaces=(replace(SINGLET.surfaces[0], **change), *SINGLET.surfaces[1:]), blades=5,
                         blade_reach=1.0),
                 0, 1, **BENT)
    lens = posed(lens, 2, 2, decentre_x=1.5, tilt_x=0.2)        # the stop, with its blades
    origins, directions = rays(600, 8.0)
    if towards == "scene":
        origins, directions = origins + [0.0, 0.0, 7.0 + lens.length + BACK], directions * [1.0, 1.0, -1.0]
    made = lb.trace(lens, origins, directions)
    back = origins - [0.0, 0.0, lens.length + BACK]
    given = dict(zip((X, Y, Z, L, M, N), (*back.T, *directions.T), strict=True))
    out = Program(trace_steps(lens, BACK, towards=towards), np.float64).run(
        {**given, WEIGHT: np.ones(len(back))}, [X, Y, Z, L, M, N, WEIGHT], len(back))
    passed = made.fate == lb.Fate.PASSED
    assert passed.any() and not passed.all() and ((out[6] > 0.0) == passed).all()
    assert np.abs(out[:3].T + [0.0, 0.0, lens.length + BACK] - made.points)[passed].max() < 1e-11
    assert np.abs(out[3:6].T - made.directions)[passed].max() < 1e-13


@pytest.mark.parametrize("angle", [30.0, 50.0])
def test_steep_rays_through_a_strongly_tilted_surface_are_those_of_the_reference(angle):
    """On the way back some of them run against the axis of the tilted surface, and still on along that of the lens."""
    lens = posed(lenses.load("pbrt-dgauss-50mm"), 2, 2, tilt_x=radians(angle))
    random, count, away = np.random.default_rng(0), 60_000, 36.0
    origins = np.column_stack([random.uniform(-30.0, 30.0, (count, 2)), np.full(count, -5.0)])
    ways = random.normal(0.0, 0.5, (count, 3)) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    found = lb.trace(lens, origins, ways)
    passed, frame = found.fate == lb.Fate.PASSED, np.array([0.0, 0.0, lens.length + away])
    assert passed.sum() > 50
    for towards, points, along in (("film", origins[passed], ways[passed]),
                                   ("scene", found.points[passed], -found.directions[passed])):
        given = dict(zip((X, Y, Z, L, M, N), (*(points - frame).T, *along.T), strict=True))
        weight = Program(trace_steps(lens, away, towards=towards), np.float64).run(
            {**given, WEIGHT: np.ones(len(along))}, [WEIGHT], len(along))[0]
        assert (weight > 0.0).all()


def test_a_lens_that_is_dark_along_its_axis_has_the_working_f_number_of_its_light():
    """Its stop lies beside the axis: E = π L / (2 N)², against the outline of the region; 32,768 rays err by 1 %."""
    lens = lb.Lens((lb.Surface(4.0, 12.0, lb.Glass(1.6), curvature=1 / 40.0),
                    lb.Surface(3.0, 12.0, curvature=-1 / 60.0),
                    lb.Surface(3.0, 2.5, curvature=0.0, pose=lb.SurfacePose(decentre_y=5.0)),
                    lb.Surface(0.0, 12.0, curvature=0.0)), 2)
    away = lb.film_distance(lens.centred, inf)
    light = axis_irradiance(lens, away) / away**2
    assert lb.working_f_number(lens, away) == pytest.approx(0.5 * np.sqrt(np.pi / light), rel=0.01)
    closed = replace(lens, surfaces=(*lens.surfaces[:2], replace(lens.surfaces[2], pose=lb.SurfacePose(
        decentre_y=40.0)), lens.surfaces[3]))
    assert lb.working_f_number(closed, away) == inf


def test_only_the_surface_itself_moves_and_a_body_moves_as_one():
    lens = posed(SINGLET, 0, 1, **BENT)
    cylindrical = posed(replace(SINGLET, surfaces=(replace(SINGLET.surfaces[0], curvature_x=0.01),
                                                   *SINGLET.surfaces[1:])), 0, 1, **BENT)
    for made, still in ((lens, SINGLET), (cylindrical, replace(cylindrical, surfaces=tuple(
            replace(s, pose=None) for s in cylindrical.surfaces)))):
        _check_body(made, still)
    assert lens.vertices == SINGLET.vertices and lens.centred == SINGLET


def _check_body(lens, in_place):
    assert lens.frames[0] is lens.frames[1] and lens.frames[2] is None
    # In its own frame the body is the centred lens
    frame = lens.frames[0]
    origins, directions = rays()
    moved = lb.trace(lens, origins @ frame.rotation.T + frame.shift, directions @ frame.rotation.T, clip=False,
                     record=True).paths[:, 1:3]
    still = lb.trace(in_place, origins, directions, clip=False, record=True).paths[:, 1:3]
    assert moved == pytest.approx(still @ frame.rotation.T + frame.shift, abs=1e-12)


CROSSED = lb.Lens((lb.Surface(4.0, 9.0, lb.Glass(1.6), curvature=1 / 40.0, curvature_x=0.0),
                   lb.Surface(3.0, 9.0, lb.Glass(1.5), curvature=0.0, curvature_x=-1 / 55.0),
                   lb.Surface(2.0, 9.0, curvature=0.0),
                   lb.Surface(0.0, 7.0, curvature=0.0)), 3, blades=3, blade_reach=1.0)


def test_a_roll_turns_what_is_not_round_and_the_rays_with_it():
    """All surfaces rolled about one axis are the lens turned as a whole; a quarter swaps the sections of a cylinder."""
    origins, directions = rays(600, 8.0)
    turn = np.array([[np.cos(0.4), -np.sin(0.4), 0.0], [np.sin(0.4), np.cos(0.4), 0.0], [0.0, 0.0, 1.0]])   # x to y
    still, made = lb.trace(CROSSED, origins, directions), lb.trace(
        posed(CROSSED, 0, 3, roll=0.4), origins @ turn.T, directions @ turn.T)
    passed = still.fate == lb.Fate.PASSED
    assert passed.any() and not passed.all() and (made.fate == still.fate).all()
    assert np.abs(made.points - still.points @ turn.T)[passed].max() < 1e-12
    assert np.abs(made.directions - still.directions @ turn.T)[passed].max() < 1e-14

    front = replace(CROSSED, surfaces=CROSSED.surfaces[:1], stop_index=0, blades=0)
    across = replace(front, surfaces=(replace(front.surfaces[0], curvature=0.0, curvature_x=1 / 40.0),))
    assert lb.trace(posed(front, 0, 0, roll=np.pi / 2), origins, directions).directions == pytest.approx(
        lb.trace(across, origins, directions).directions, abs=1e-14, nan_ok=True)


@pytest.mark.parametrize("roll", [0.3, -1.2, np.pi / 2])
def test_first_order_data_are_those_of_the_sections_of_a_rolled_surface(roll):
    """Against the limit of a traced ray near the axis: the slope across its own section, over its height."""
    lens = posed(CROSSED, 0, 1, roll=roll)
    for axis, k in (("x", 0), ("y", 1)):
        start = np.zeros(3)
        start[k], start[2] = 1e-4, -5.0
        slope = lb.trace(lens, start, [0.0, 0.0, 1.0]).directions[0, k] / 1e-4
        efl = lb.first_order(lens.section(axis)).efl
        assert slope == pytest.approx(-1.0 / efl, abs=4e-5)     # without the coupling of both sections
    assert lb.first_order(lens).efl == efl and lens.centred.is_centred      # efl of the section y–z
    first = lens.surfaces[0].centred
    assert (first.curvature, first.curvature_x) == pytest.approx((np.cos(roll)**2 / 40.0, np.sin(roll)**2 / 40.0))
    assert lens.surfaces[0].section("y").curvature == 1 / 40.0          # of its own axes


def test_signs_are_those_of_the_axes():
    plane = lb.Lens((lb.Surface(0.0, 20.0, curvature=0.0),), 0)
    up = lb.trace(posed(plane, 0, 0, tilt_x=0.1), [0.0, 10.0, -9.0], [0.0, 0.0, 1.0]).points[0]
    right = lb.trace(posed(plane, 0, 0, tilt_y=0.1), [10.0, 0.0, -9.0], [0.0, 0.0, 1.0]).points[0]
    bent = lb.Lens((lb.Surface(0.0, 20.0, curvature=0.02, curvature_x=0.0, pose=lb.SurfacePose(roll=np.pi / 6)),), 0)
    flat = lb.trace(bent, [np.cos(np.pi / 6), np.sin(np.pi / 6), -9.0], [0.0, 0.0, 1.0]).points[0]  # +x rolled up
    assert flat[2] == pytest.approx(0.0, abs=1e-15)
    assert up[2] == pytest.approx(10.0 * np.tan(0.1)) and right[2] == pytest.approx(-10.0 * np.tan(0.1))


POSES = [lb.SurfacePose(**BENT, pivot=1), lb.SurfacePose(roll=-2.9, tilt_x=-0.9), lb.SurfacePose(roll=1.2, tilt_y=0.6)]


@pytest.mark.parametrize("pose", POSES)
def test_mirrored_and_turned_poses_move_mirrored_and_turned_points(pose):
    frame = Frame.of(pose, 5.0)
    for across in (False, True):
        for up in (False, True):
            mirror = np.diag([-1.0 if across else 1.0, -1.0 if up else 1.0, 1.0])
            found = Frame.of(pose.mirrored(across, up), 5.0)
            np.testing.assert_allclose(found.rotation, mirror @ frame.rotation @ mirror, atol=1e-15)
            np.testing.assert_allclose(found.shift, mirror @ frame.shift, atol=1e-15)
    turn, found = np.diag([-1.0, 1.0, -1.0]), Frame.of(pose.turned(), -5.0)
    np.testing.assert_allclose(found.rotation, turn @ frame.rotation @ turn, atol=1e-15)
    np.testing.assert_allclose(found.shift, turn @ frame.shift, atol=1e-15)


@pytest.mark.parametrize("pose", POSES)
def test_the_tilts_of_the_axes_of_a_pose_are_its_own(pose):
    assert tilts_of(Frame.of(pose, 0.0).rotation) == pytest.approx((pose.tilt_x, pose.tilt_y, pose.roll), abs=1e-15)


def test_a_turned_lens_is_met_from_behind():
    lens = posed(SINGLET, 0, 1, **BENT)
    surfaces = tuple(s.reversed(*gap) for s, gap in zip(
        lens.surfaces[::-1], [(6.0, lb.AIR), (5.0, lb.Glass(1.6)), (0.0, lb.AIR)], strict=True))
    origins, directions = rays()
    made = lb.trace(lens, origins, directions, clip=False)
    back = lb.trace(replace(lens, surfaces=surfaces, stop_index=0), made.points * [-1, 1, -1] + [0, 0, lens.length],
                    made.directions * [1, -1, 1], clip=False)
    assert np.abs(back.directions - directions * [1, -1, 1]).max() < 1e-12


def test_a_decentred_element_shows_coma_on_the_axis():
    lens = lb.Lens((lb.Surface(4.0, 9.0, lb.Glass(1.6), curvature=1 / 40.0), lb.Surface(3.0, 9.0, curvature=-1 / 60.0),
                    lb.Surface(2.0, 9.0, lb.Glass(1.7), curvature=-1 / 50.0), lb.Surface(2.0, 9.0, curvature=0.0),
                    lb.Surface(0.0, 7.0, curvature=0.0)), 4)

    def skew(case):
        """Mean cube of the heights of a fan about their mean: of coma, and not of spherical aberration."""
        y = np.linspace(-5.0, 5.0, 41)
        made = lb.trace(case, np.column_stack([0.0 * y, y, 0.0 * y - 5.0]), [0.0, 0.0, 1.0])
        z = lb.first_order(case).bfl + case.length
        at = made.points[:, 1] + (z - made.points[:, 2]) * made.directions[:, 1] / made.directions[:, 2]
        off = at - at.mean()
        return (off**3).mean() / (off**2).mean() ** 1.5

    assert abs(skew(lens)) < 1e-9
    there, back = (skew(posed(lens, 2, 3, decentre_y=d)) for d in (0.4, -0.4))
    assert abs(there) > 0.2 and back == pytest.approx(-there)


@pytest.mark.parametrize(("pose", "said"), [
    ({"tilt_x": radians(90.0)}, "tilt_x 90° of a surface: it must lie from −60° to 60°"),
    ({"tilt_y": nan}, "tilt_y nan"), ({"roll": 3.5}, "roll 200.5.*° of a surface: it must lie from −180° to 180°"),
    ({"decentre_x": 1e9}, "it must lie from −10 m to 10 m"),
    ({"decentre_y": inf}, "decentre_y ∞"), ({"pivot": 1.5}, "whole number")])
def test_impossible_poses_are_refused(pose, said):
    with pytest.raises(lb.PoseError, match=said):
        lb.SurfacePose(**pose)


def test_a_pivot_lies_in_the_lens():
    with pytest.raises(lb.LensError, match="surface 0 pivots about the vertex of surface -1"):
        lb.Lens((lb.Surface(0.0, 5.0, curvature=0.01, pose=lb.SurfacePose(0.1, pivot=1)),), 0)
