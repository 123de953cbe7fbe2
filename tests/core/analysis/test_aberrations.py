"""Seidel sums, colour and Coddington's foci against 40-digit values, real rays and closed forms."""

import json
from dataclasses import replace
from math import atan, cos, inf, pi, radians, sin, tan

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import DATA, LAW, REFERENCE, TRACED, biconvex, lens

THIRD_ORDER = json.loads((DATA / "third_order.json").read_text(encoding="utf-8"))
LINES = {"F": lb.F_LINE, "d": lb.D_LINE, "C": lb.C_LINE}
RADIUS = st.one_of(st.floats(15.0, 100.0), st.floats(-100.0, -15.0))


def coloured(name):
    """A reference lens whose glasses are tables of their indices at F, d and C."""
    plain, rows = lens(name), REFERENCE[name]["surfaces"]
    return replace(plain, surfaces=tuple(
        replace(s, glass=lb.Glass(n["d"], formula="table",
                                  coefficients=tuple((LINES[line], n[line]) for line in ("F", "d", "C")))) if n else s
        for s, (_, _, _, n, *_) in zip(plain.surfaces, rows, strict=True)))


def pupil_radius(name):
    return REFERENCE[name]["paraxial"]["d"]["enp_radius"]


@pytest.mark.parametrize("name", TRACED)
def test_seidel_sums_agree_with_forty_digits_surface_by_surface(name):
    expected = THIRD_ORDER[name]
    sums = lb.seidel(lens(name), radians(expected["field_deg"]), pupil_radius(name))
    assert sums.invariant == pytest.approx(expected["invariant"], rel=1e-12)
    np.testing.assert_allclose(sums.surfaces, np.array(expected["per_surface"])[:, :5], rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(sums.total, expected["sum"][:5], rtol=1e-9)


@pytest.mark.parametrize("name", ["cooke", "codev"])
def test_axial_and_lateral_colour_agree_with_forty_digits_surface_by_surface(name):
    expected = np.array(THIRD_ORDER[name]["per_surface"])[:, 5:]
    sums = lb.seidel(coloured(name), radians(THIRD_ORDER[name]["field_deg"]), pupil_radius(name),
                     colour=(lb.F_LINE, lb.C_LINE))
    np.testing.assert_allclose(sums.axial_colour, expected[:, 0], rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(sums.lateral_colour, expected[:, 1], rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("name", TRACED)
def test_chief_rays_and_coddingtons_foci_agree_with_forty_digits(name):
    film = REFERENCE[name]["film_z"]
    for degrees, (tangential, sagittal, launch, image) in THIRD_ORDER[name]["foci"].items():
        angle = radians(float(degrees))
        ray = lb.chief_ray(lens(name), angle)
        assert -ray.pupil_z * tan(angle) == pytest.approx(launch, abs=1e-11)
        x, y, z = ray.points[-1]
        assert y + (film - z) / ray.direction[2] * ray.direction[1] == pytest.approx(image, abs=1e-11)
        assert x == 0.0 and abs(ray.points[REFERENCE[name]["stop"], 1]) < 1e-12
        foci = np.array(lb.astigmatic_foci(lens(name), angle)) - film
        np.testing.assert_allclose(foci, [tangential, sagittal], rtol=0.0, atol=1e-9)


@LAW
@given(RADIUS, st.floats(-3.0, 2.0), st.floats(-1e-5, 1e-5), st.floats(-2e-3, 2e-3), st.floats(1.3, 1.9))
def test_real_rays_approach_the_spherical_aberration_of_a_figured_surface(radius, k, a_4, a_2, n):
    """Transversely −S_I / (2 n′ u′) at the pupil's edge, falling as h³; r² and r⁶ terms included."""
    glass = lb.Lens((lb.Surface(0.0, 5.0, lb.Glass(n), k, ((2, a_2), (4, a_4), (6, 1e-10)), curvature=1.0 / radius),),
                    0)
    fo = lb.first_order(glass)
    assume(abs(fo.efl) < 1e3)
    h = 0.003 * min(abs(radius), abs(fo.efl))
    t = lb.trace(glass, [0.0, h, -1.0], [0.0, 0.0, 1.0], clip=False)
    across = t.points[0, 1] + (fo.bfl - t.points[0, 2]) * t.directions[0, 1] / t.directions[0, 2]
    expected = lb.seidel(glass, 0.0, h).total[0] / (2.0 * -h / fo.efl)
    # what is left is of the fifth order; 1e-13: the rounding of the ray
    assert across == pytest.approx(expected, rel=0.02, abs=2e-3 * h * (h / fo.efl) ** 2 + 1e-13)


@LAW
@given(st.floats(15.0, 80.0), st.floats(1.4, 1.9), st.floats(0.01, 0.5))
def test_petzvals_sum_is_that_of_the_first_order(radius, n, angle):
    stack = biconvex(1.0 / radius, 4.0, n, 3.0)
    sums = lb.seidel(stack, angle)
    assert sums.total[3] == pytest.approx(-sums.invariant**2 / lb.first_order(stack).petzval_radius, rel=1e-12)


def test_a_conic_free_of_spherical_aberration_has_a_first_sum_of_zero():
    n = 1.6
    shell = lb.Lens((lb.Surface(0.0, 5.0, lb.Glass(n), curvature=0.02, conic=-1.0 / n**2),), 0)
    assert lb.seidel(shell, 0.2).total[0] == pytest.approx(0.0, abs=1e-16)
    assert abs(lb.seidel(replace(shell, surfaces=(replace(shell.stop, conic=0.0),)), 0.2).total[0]) > 1e-5


@LAW
@given(st.floats(0.05, 0.6), st.floats(20.0, 80.0))
def test_coddingtons_foci_are_where_close_rays_meet_the_chief_ray(angle, radius):
    """On an aspheric surface behind a stop, against real rays a hundredth of a millimetre aside."""
    stack = lb.Lens((lb.Surface(6.0, 3.0, curvature=0.0), lb.Surface(3.0, 20.0, lb.Glass(1.5), -0.7, ((4, 1e-5),),
                                                                     curvature=-1.0 / radius),
                     lb.Surface(0.0, 20.0, lb.AIR, 0.3, curvature=-1.5 / radius)), 0)
    ray = lb.chief_ray(stack, angle)
    direction = np.array([0.0, sin(angle), cos(angle)])
    e = 1e-2
    for focus, aside in zip(lb.astigmatic_foci(stack, angle), ([0.0, e, 0.0], [e, 0.0, 0.0]), strict=True):
        assume(abs(focus) < 1e3)
        ends = [lb.trace(stack, sign * np.array(aside) - 1.0 * direction, direction, clip=False) for sign in (1, -1)]
        at = [t.points[0] + (focus - t.points[0, 2]) / t.directions[0, 2] * t.directions[0] for t in ends]
        closed = np.linalg.norm(at[0] - at[1])
        opened = np.linalg.norm(ends[0].points[0] - ends[1].points[0])
        assert closed < 2e-5 * opened * max(1.0, abs(focus) / 10.0)         # of the second order in the offset
    assert ray.pupil_z == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", ["lib-miyamoto-fisheye-1964", "lenshh-laikin-fisheye160-f2",
                                  "lentil-minolta-fisheye-1978"])
def test_a_fisheyes_chief_rays_run_back_from_the_stop_into_their_angle_beyond_a_right_one_too(name):
    """Traced from the middle of the stop towards the scene through the front of the lens alone."""
    fisheye = lenses.load(name)
    z_stop = fisheye.vertices[fisheye.stop_index]
    front = lb.Lens(fisheye.surfaces[:fisheye.stop_index], 0)
    image = []
    for degrees in (1.0, 30.0, 70.0, 89.0, 89.9999, 90.0, 90.0001, 91.0, 100.0, 104.0):
        ray = lb.chief_ray(fisheye, radians(degrees))
        np.testing.assert_array_equal(ray.points[fisheye.stop_index], [0.0, 0.0, z_stop])
        # and so does light that comes in at that angle; 1e-16 of it on arms of 100 mm, magnified by the surfaces
        light = lb.trace(fisheye, [0.0, 0.0, ray.pupil_z], [0.0, np.sin(ray.field_angle), np.cos(ray.field_angle)],
                         clip=False, record=True, forward=True)
        np.testing.assert_allclose(light.paths[0, 1:], ray.points, rtol=0.0, atol=1e-9)
        way = ray.points[fisheye.stop_index - 1] - [0.0, 0.0, z_stop]
        back = lb.trace(front, [0.0, 0.0, z_stop], way, clip=False)
        assert (back.fate[0], back.surface[0]) == (lb.Fate.PASSED, 0)
        _, y, z = -back.directions[0]
        assert np.arctan2(y, z) == pytest.approx(radians(degrees), abs=1e-12)
        np.testing.assert_allclose(back.points[0], ray.points[0], rtol=0.0, atol=1e-11)
        image.append(ray.points[-1, 1])
    assert (np.diff(image) >= 0.0).all()
    mirrored = lb.chief_ray(fisheye, radians(-100.0))
    np.testing.assert_allclose(mirrored.points * [1.0, -1.0, 1.0], lb.chief_ray(fisheye, radians(100.0)).points,
                               rtol=0.0, atol=1e-12)


def test_the_foci_of_a_fisheye_continue_smoothly_beyond_a_right_angle():
    fisheye = lenses.load("lib-miyamoto-fisheye-1964")
    before, at, after = (np.array(lb.astigmatic_foci(fisheye, 0.5 * pi + e)) for e in (-1e-5, 0.0, 1e-5))
    np.testing.assert_allclose(before + after, 2.0 * at, rtol=0.0, atol=1e-2 * np.abs(after - before).min())


def test_a_dark_field_names_the_surface_that_ends_it_and_the_angle():
    fisheye = lenses.load("lib-miyamoto-fisheye-1964")
    with pytest.raises(lb.LensError, match=r"no chief ray at 95°: beyond 92\.19° it would meet the rim of surface 0"):
        lb.chief_ray(fisheye, radians(95.0), clip=True)
    assert lb.chief_ray(fisheye, radians(92.18), clip=True).points.shape == (len(fisheye.surfaces), 3)
    with pytest.raises(lb.LensError, match=r"no chief ray at -120°: beyond -105\.9° it would miss surface 1"):
        lb.chief_ray(fisheye, radians(-120.0))
    with pytest.raises(lb.LensError, match="below 180°"):
        lb.chief_ray(fisheye, pi)
    with pytest.raises(lb.LensError, match=r"no chief ray at 90°: beyond 90° it would not meet surface 0"):
        lb.chief_ray(biconvex(), 0.5 * pi + 1e-6)


def test_a_term_of_the_third_power_has_no_seidel_sums():
    figured = lb.Lens((lb.Surface(0.0, 5.0, lb.Glass(1.5), curvature=0.02, aspheric=((3, 1e-5), (4, 1e-6))),), 0)
    with pytest.raises(lb.LensError, match="surface 0 has an r³ term"):
        lb.seidel(figured, 0.1)
    assert lb.seidel(replace(figured, surfaces=(replace(figured.stop, aspheric=((4, 1e-6), (5, 1e-4))),)), 0.1)


def test_lenses_without_chief_ray_or_symmetry_are_refused():
    with pytest.raises(lb.LensError, match="below 90°"):
        lb.seidel(biconvex(), 0.5 * pi)
    for radius in (-5.0, 0.0, float("nan"), inf):
        with pytest.raises(lb.LensError, match="pupil radius"):
            lb.seidel(biconvex(), 0.1, radius)
    with pytest.raises(lb.LensError, match="cylinder or toroid"):
        lb.seidel(lb.Lens((lb.Surface(4.0, 5.0, curvature=0.02, curvature_x=0.0),), 0), 0.1)
    telecentric = lb.Lens((*(replace(s, thickness=t) for s, t in zip(
        biconvex().surfaces, (4.0, lb.first_order(biconvex()).bfl), strict=True)),
        lb.Surface(0.0, 3.0, curvature=0.0)), 2)
    with pytest.raises(lb.LensError, match="at infinity"):
        lb.chief_ray(telecentric, 0.1)
    with pytest.raises(lb.LensError, match="no chief ray"):
        lb.chief_ray(lb.Lens((lb.Surface(60.0, 3.0, curvature=0.0),
                              lb.Surface(2.0, 20.0, lb.Glass(1.5), curvature=-0.02),
                              lb.Surface(0.0, 20.0, curvature=0.0)), 0), atan(1.5))
    window = lb.Lens((lb.Surface(1.0, 3.0, lb.Glass(1.5), curvature=0.0), lb.Surface(0.0, 3.0, curvature=0.0)), 0)
    assert lb.astigmatic_foci(window, 0.1) == (inf, inf)
