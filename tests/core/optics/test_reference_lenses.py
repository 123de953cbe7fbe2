"""The rest of the 40-digit tracer's figures, and CODE V's listing: spots, exit pupils with what ends them, and rays."""

import json
from math import cos, radians, sin, tan

import numpy as np
import pytest

import lensbench as lb
from tests.core.oracles import DATA, REFERENCE, TRACED, lens

FIELDS = json.loads((DATA / "fields.json").read_text(encoding="utf-8"))
LISTING = FIELDS["code_v"]


def on_plane(t, z):
    """Where rays go through a plane z, (n, 2)."""
    return (t.points + ((z - t.points[:, 2]) / t.directions[:, 2])[:, None] * t.directions)[:, :2]


# --- Spots

@pytest.mark.parametrize("name", TRACED)
def test_spots_agree_with_the_forty_digit_tracer(name):
    pupil, film = REFERENCE[name]["paraxial"]["d"], REFERENCE[name]["film_z"]
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-1.0, 1.0, 65)] * 2))
    inside = x * x + y * y <= 1.0
    origins = np.column_stack([x, y, 0.0 * x])[inside] * pupil["enp_radius"] + [0.0, 0.0, pupil["enp_dist"]]
    for field, expected in FIELDS[name]["spots"].items():
        degrees, line = field.split("/")
        angle = radians(float(degrees))
        for clip, spot in zip((False, True), expected, strict=True):
            t = lb.trace(lens(name, line), origins, [0.0, sin(angle), cos(angle)], clip=clip)
            passed = t.fate == lb.Fate.PASSED
            if spot is None:
                assert not passed.any()
                continue
            points = on_plane(t, film)[passed]
            away = points - points.mean(0)
            assert passed.sum() == spot[0]
            assert points[:, 1].mean() == pytest.approx(spot[1], rel=1e-10, abs=1e-12)
            assert np.sqrt((away**2).sum(1).mean()) == pytest.approx(spot[2], rel=1e-10, abs=1e-12)
            assert np.hypot(*away.T).max() == pytest.approx(spot[3], rel=1e-10, abs=1e-12)


# --- Exit pupils

@pytest.mark.slow
@pytest.mark.parametrize("name", TRACED)
def test_exit_pupils_end_where_the_forty_digit_tracer_ends_them_and_by_the_same_rims(name):
    stack, distance = lens(name), REFERENCE[name]["film_z"] - lens(name).length
    fields = FIELDS[name]["exit_pupils"]
    pupil = lb.exit_pupil(stack, distance, [float(y) for y in fields])
    for bounds, (height, (low, low_surface, high, high_surface)) in zip(pupil.bounds, fields.items(), strict=True):
        assert (bounds[0], bounds[2]) == pytest.approx((low, high), abs=1e-9)
        film = np.array([0.0, float(height), stack.length + distance])
        ways = np.array([[0.0, end, stack.length] for end in (low - 1e-9, low + 1e-9, high - 1e-9, high + 1e-9)]) - film
        t = lb.trace(stack, film, ways)
        assert list(t.fate == lb.Fate.PASSED) == [False, True, True, False]
        assert (t.surface[0], t.surface[3]) == (low_surface, high_surface)


# --- CODE V

def listed(line):
    """The double Gauss with the listing's own indices."""
    stack = lens("codev")
    return lb.Lens(tuple(
        lb.Surface(s.thickness, s.semi_diameter, lb.Glass(n[line]) if n else lb.AIR, curvature=s.curvature)
        for s, n in zip(stack.surfaces, LISTING["indices"], strict=True)), stack.stop_index)


def printed(value, digits):
    """To the last digit that the listing prints."""
    return pytest.approx(value, rel=0.0, abs=0.51 * 10.0**-digits)


def test_the_listings_first_order_is_met_to_its_printed_digits():
    fo, stack = lb.first_order(listed("d")), listed("d")
    assert (fo.efl, fo.bfl, fo.ffl, stack.length) == printed(
        tuple(LISTING[key] for key in ("EFL", "BFL", "FFL", "OAL")), 4)
    assert fo.efl / 50.0 == printed(LISTING["FNO"], 4)
    assert fo.efl * tan(radians(14.0)) == printed(LISTING["paraxial_image_height_14deg"], 4)
    assert fo.entrance_pupil.z == printed(LISTING["entrance_pupil_z_from_first_vertex"], 4)
    assert fo.exit_pupil.z - stack.length == printed(LISTING["exit_pupil_z_from_last_vertex"], 4)
    assert 50.0 * fo.exit_pupil.radius / fo.entrance_pupil.radius == printed(LISTING["exit_pupil_dia"], 4)


def test_the_listings_third_order_is_met_to_its_printed_digits():
    """Transverse, −S / (2 n′ u′); its colour runs from C to F."""
    glasses = tuple(
        lb.Surface(s.thickness, s.semi_diameter, lb.Glass(n["d"], formula="table", coefficients=tuple(
            (wave, n[line]) for wave, line in ((lb.F_LINE, "F"), (lb.D_LINE, "d"), (lb.C_LINE, "C")))) if n else lb.AIR,
            curvature=s.curvature)
        for s, n in zip(lens("codev").surfaces, LISTING["indices"], strict=True))
    stack = lb.Lens(glasses, lens("codev").stop_index)
    sums = lb.seidel(stack, radians(14.0), 25.0, colour=(lb.F_LINE, lb.C_LINE))
    slope = -25.0 / lb.first_order(stack).efl
    s1, s2, s3, s4, s5 = sums.total / (2.0 * slope)
    expected = LISTING["third_order_transverse_sum"]
    found = {"SA": s1, "TCO": 3.0 * s2, "TAS": 3.0 * s3 + s4, "SAS": s3 + s4, "PTB": s4, "DST": s5,
             "AX": sums.axial_colour.sum() / slope, "LAT": sums.lateral_colour.sum() / slope,
             "PTZ": 1.0 / lb.first_order(stack).petzval_radius}
    assert found == printed(expected, 6)


@pytest.mark.parametrize("degrees", ["10", "14"])
def test_the_listings_chief_rays_are_met_to_their_printed_digits(degrees):
    expected, stack = LISTING["chief"][degrees], listed("d")
    film, angle = stack.length + LISTING["film"], radians(float(degrees))
    ray = lb.chief_ray(stack, angle)
    slope = ray.direction[1] / ray.direction[2]
    height = ray.points[-1, 1] + (film - ray.points[-1, 2]) * slope
    assert height == printed(expected["image_y"], 6)
    assert ray.pupil_z == printed(expected["real_EP_dist"], 4)
    # against the ideal point in the paraxial focus, shifted to the film as the chief ray runs
    fo = lb.first_order(stack)
    ideal = fo.efl * tan(angle) + (LISTING["film"] - fo.bfl) * slope
    assert 100.0 * (height / ideal - 1.0) == printed(expected["distortion_percent"], 4)
    tangential, sagittal = np.array(lb.astigmatic_foci(stack, angle)) - film
    assert sagittal == printed(expected["x_focus"], 6)
    # its tangential focus is 2e-5 mm off the 40-digit one of the reference lens, which ours meets to 1e-9
    assert tangential == pytest.approx(expected["y_focus"], abs=3e-5)


def test_the_listings_rays_are_met_to_their_printed_digits():
    stack = listed("d")
    for ray in LISTING["rays"]:
        angle, point = radians(ray["field_deg"]), np.array(ray["surface1_point"])
        t = lb.trace(stack, point, [0.0, sin(angle), cos(angle)], clip=False)
        found = [*t.points[0] - [0.0, 0.0, stack.length], *t.directions[0, :2] / t.directions[0, 2]]
        # the starts are printed to six digits themselves
        np.testing.assert_allclose(found, [*ray["surface11_point"], *ray["exit_tan_xy"]], rtol=0.0, atol=1.5e-6)
