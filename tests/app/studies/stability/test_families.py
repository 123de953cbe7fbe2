"""Families of sweeps: finite errors where a method is safe, a named fate beyond, and the claims of the docs."""

from functools import cache

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability.plots import FAMILIES
from lensbench.app.studies.stability.sweep import LOST, Sweep
from lensbench.core.rendering.progressive import Rendering

ROWS = [(family, title) for family, sweeps in FAMILIES.items() for title in sweeps]
TYPED = {fate.name for fate in lb.Fate} | {LOST}


@cache
def row(family: str, title: str) -> Sweep:
    return FAMILIES[family][title]()


def verdicts(title: str):
    """Safe up to, fails at, what is returned there, worst error before, of each method under a sweep."""
    (family,) = [family for family, sweeps in FAMILIES.items() if title in sweeps]
    result = row(family, title)
    return {curve.name: result.verdict(curve) for curve in result.curves}


@pytest.mark.slow
@pytest.mark.parametrize("family, title", ROWS)
def test_a_method_that_the_program_relies_on_never_gives_what_is_no_number(family, title):
    result = row(family, title)
    steps = np.diff(result.values)
    assert (steps > 0.0).all() or (steps < 0.0).all()                   # from easy to hard, one way
    assert {len(curve.errors) for curve in result.curves} == {len(result.values)}
    own = [curve for curve in result.curves if curve.own]
    assert own
    for curve in own:
        for returned in curve.returned:
            assert not returned or returned in TYPED or returned.endswith("Error"), curve.name
        verdict = result.verdict(curve)
        assert np.isfinite(verdict.worst) and verdict.worst <= result.limit
        assert verdict.fails_at is None or curve.switch, f"{curve.name} fails: what does the program do there?"


# Intersection


@pytest.mark.parametrize("title", ["Radius of a sphere", "Radius of a paraboloid"])
def test_the_programs_intersections_in_float32_stay_within_a_hundredth_of_a_micrometre_up_to_a_radius_of_1e12(title):
    verdict = verdicts(title)
    own = [name for name in verdict if "form" in name and "school" not in name]
    assert len(own) == 4
    for name in own:
        assert verdict[name].fails_at is None and verdict[name].worst < (1e-5 if "32" in name else 1e-13)


def test_pbrts_quadratic_in_float32_is_lost_on_flat_surfaces_and_far_rays():
    assert 3e3 < verdicts("Radius of a sphere")["pbrt's quadratic, float32"].fails_at < 1e5
    assert 200.0 < verdicts("Distance of the ray's origin")["pbrt's quadratic, float32"].fails_at < 3e3


def test_the_school_formula_is_lost_on_flat_conics_where_the_closed_form_holds():
    assert verdicts("Radius of a paraboloid")["school formula, float32"].fails_at < 1e3
    assert verdicts("Radius of a paraboloid")["school formula, float64"].fails_at < 1e12
    for title in ("Oblate conics", "Hyperbolic conics"):
        verdict = verdicts(title)
        assert verdict["closed form, float64"].fails_at is None
        in_blocks, school = verdict["closed form in blocks, float32"], verdict["school formula, float32"]
        assert in_blocks.safe_up_to > 1e4 * school.safe_up_to


def test_in_double_the_foot_form_holds_from_a_ray_of_10_km_to_the_edge_of_a_hemisphere():
    for title in ("Distance of the ray's origin", "Grazing incidence on a sphere", "Edge of a hemisphere"):
        for name, verdict in verdicts(title).items():
            assert verdict.fails_at is None or "float32" in name


@pytest.mark.slow
def test_full_newton_steps_land_on_the_wrong_crossing_where_halved_ones_do_not():
    verdict = verdicts("Oblique rays on a strong asphere")
    assert verdict["Newton to 1e-6 mm, float64"].returns.startswith("place of the hit off by")
    assert verdict["Newton, halved steps, float64"].fails_at is None
    assert verdict["Newton, halved steps, float32"].fails_at is None
    for real in ("float32", "float64"):                                         # it may be blocked, never wrong
        blocks = verdict[f"Newton in blocks, {real}"]
        assert blocks.fails_at is None or blocks.returns == LOST and blocks.fails_at > 65.0
    assert verdicts("Strong aspheres")["Newton in blocks, float32"].fails_at is None


# Refraction


def test_beyond_the_critical_angle_there_is_a_fate_and_the_school_form_has_no_number():
    verdict = verdicts("Incidence")
    for name in ("vector form, float32", "vector form, float64", "vector form in blocks, float32"):
        assert verdict[name].fails_at is None and verdict[name].returns == "TOTAL_REFLECTION"
    assert verdict["by the angle, float32"].returns == "NaN"
    assert 34.0 < verdict["by the angle, float32"].fails_at < 36.0                # asin(1 / 1.75) is 34.85°
    assert verdicts("Just below the critical angle")["vector form, float64"].fails_at is None


# Closed forms


@pytest.mark.parametrize("title", ["Thin lens as the focus comes to f", "Blur next to the plane in focus",
                                   "Depth of field at the hyperfocal", "Depth of field of a far focus"])
def test_the_closed_forms_keep_their_digits_up_to_their_edges(title):
    """Thirteen digits: a few roundings of exact numbers."""
    verdict = verdicts(title)["the program's, float64"]
    assert verdict.fails_at is None and verdict.worst < 1e-11            # percent


def test_at_its_edges_a_closed_form_is_infinite_or_an_error():
    with pytest.raises(lb.FocusError, match="focal length"):
        lb.circle_of_confusion(50.0, 2.0, 50.0, 1000.0)
    whole = lb.hyperfocal(50.0, 2.0, 0.03125)
    assert lb.depth_of_field(50.0, 2.0, whole, 0.03125) == (whole / 2.0, np.inf)
    assert lb.depth_of_field(50.0, 2.0, np.inf, 0.03125) == (whole - 50.0, np.inf)
    assert lb.circle_of_confusion(50.0, 2.0, np.inf, np.inf) == 0.0
    assert lb.circle_of_confusion(50.0, 2.0, np.inf, 1000.0) == 50.0 * 50.0 / 2.0 / 1000.0
    assert lb.circle_of_confusion(50.0, 2.0, 1050.0, np.inf) == 50.0 * 50.0 / 2.0 / 1000.0


def test_a_distance_along_the_ray_keeps_in_float32_what_a_perspective_z_loses():
    verdict = verdicts("Depth kept in a number")
    assert verdict["screen z, float32"].fails_at < 1e6
    assert verdict["distance along the ray, float32"].fails_at is None
    assert verdict["distance along the ray, float32"].worst < 1e-4                # percent: a few roundings


def test_the_weight_by_the_tangent_keeps_its_digits_where_the_ray_lies_along_the_film():
    verdict = verdicts("cos⁴ near 90°")
    assert verdict["by the tangent, float32"].fails_at is None and verdict["by the tangent, float32"].worst < 1e-4
    assert verdict["1 − sin², float32"].fails_at > 0.1


# Orientation


@pytest.mark.parametrize("title", ["Keyframes half a turn apart", "Keyframes nearly equal"])
def test_keyframes_turn_smoothly_from_no_turn_to_half_a_turn(title):
    verdict = verdicts(title)
    for name in ("part of the turn, float32", "part of the turn, float64"):
        assert verdict[name].fails_at is None and verdict[name].worst < (1e-4 if "32" in name else 1e-12)
    assert verdict["quaternion by the trace, float64"].fails_at is not None


def test_slerp_by_the_arc_cosine_divides_by_nothing_between_equal_keyframes():
    assert verdicts("Keyframes nearly equal")["slerp by the arc cosine, float64"].returns == "NaN"


def test_the_poles_of_the_panorama_are_pixels_like_any_other_there_and_back():
    assert verdicts("Poles of the panorama")["by the half angle, float32"].worst < 1.0                  # µrad
    assert verdicts("Back from the pole to the film")["arc tangent, float64"].worst < 1e-9             # px
    assert verdicts("Back from the pole to the film")["arc cosine, float32"].fails_at > 1e-3


# What the program relies on


@pytest.mark.slow
@pytest.mark.parametrize("distance", [1e5, 1e7])
def test_the_image_of_a_far_light_is_in_float32_where_it_is_in_float64(distance):
    """The rays begin just in front of the lens; a float32 ray from 10 km is exact to 0.2 mm only."""
    lens, film = lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 240, 160)
    camera = lb.LensCamera(lens, film, focus_distance=distance, f_number=2.8)
    shining = lb.Material(colour=(1e6,) * 3, kind="light")
    light = lb.Sphere((0.2 * distance, 0.1 * distance, -distance), 1e-4 * distance, shining)
    scene = lb.Scene("far", sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3), spheres=(light,))
    single, double = (Rendering(camera, scene, real=real) for real in (np.float32, np.float64))
    for rendering in (single, double):
        rendering.add(1, threads=1)
        assert len(rendering.light_traced) == 1
    assert double.image().sum() > 0.0
    np.testing.assert_allclose(single.image(), double.image(), rtol=0.0, atol=1e-3 * double.image().max())


@pytest.mark.parametrize("name", ["lentil-minolta-fisheye-1978", "lentil-meyer-primoplan-1936",
                                  "lenshh-laikin-fisheye160-f2", "pbrt-dgauss-50mm"])
def test_no_ray_that_passes_a_lens_of_the_library_runs_so_flat_that_float32_loses_it(name):
    """The flattest rays of the library but for light from behind, which may graze the front of a fisheye.

    Single precision is safe down to 0.1°, and to a hundred-thousandth.
    """
    lens = lenses.load(name)
    rng, back = np.random.default_rng(1), lens.length + lb.first_order(lens).bfl
    rear = 1.1 * lens.surfaces[-1].semi_diameter
    origins = np.stack([*rng.uniform(-21.6, 21.6, (2, 4000)), np.full(4000, back)], 1)
    targets = np.stack([*rng.uniform(-rear, rear, (2, 4000)), np.full(4000, lens.length)], 1)
    traced = lb.trace(lens, origins, targets - origins, record=True)
    passed = (traced.fate == lb.Fate.PASSED) & (traced.directions[:, 2] < 0.0)
    assert passed.sum() > 100
    points = np.concatenate([traced.paths[passed], (traced.points + traced.directions)[passed, None]], 1)
    ways = np.diff(points, axis=1)
    ways /= np.linalg.norm(ways, axis=2)[..., None]
    for step, surface in enumerate(reversed(lens.surfaces)):
        points_on, c = points[:, step + 1, :2], surface.curvature
        assert np.hypot(*points_on.T).max() * abs(c) < 0.99
        normals = np.concatenate([-c * points_on, np.sqrt(1.0 - c * c * (points_on**2).sum(1))[:, None]], 1)
        for way in (ways[:, step], ways[:, step + 1]):
            assert np.degrees(np.arcsin(np.abs((way * normals).sum(1)).min())) > 10.0
