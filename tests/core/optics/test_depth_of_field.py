"""Circles of confusion and depth of field: thin, thick and traced, and their limits."""

from math import inf, nan, sqrt

import numpy as np
import pytest
from hypothesis import given, strategies as st

import lensbench as lb
from lensbench.core.optics.axial_bundle import marginal_height
from lensbench.core.optics.scalar_trace import surface_table
from tests.core.oracles import LAW, NAMES, REFERENCE, biconvex, lens

FOCAL_LENGTH = st.floats(5.0, 600.0)
F_NUMBER = st.floats(0.7, 64.0)
LIMIT = st.floats(0.002, 0.2)
DISTANCE = st.one_of(st.floats(1.05, 1e6), st.just(inf))       # in focal lengths


# --- The thin lens

@LAW
@given(FOCAL_LENGTH, F_NUMBER, DISTANCE, DISTANCE)
def test_the_thin_lens_blur_is_a_similar_triangle_behind_the_lens(f, n, focus, distance):
    def image(s):
        return f / (1.0 - f / s)                                # Gauss

    film, sharp = image(focus * f), image(distance * f)
    triangle = f / n * abs(film - sharp) / sharp
    assert lb.circle_of_confusion(f, n, focus * f, distance * f) == pytest.approx(triangle, rel=1e-6, abs=1e-12 * f)


@LAW
@given(FOCAL_LENGTH, F_NUMBER, DISTANCE, LIMIT)
def test_at_the_near_and_far_limits_the_blur_is_the_limit(f, n, focus, limit):
    near, far = lb.depth_of_field(f, n, focus * f, limit)
    assert near <= focus * f <= far
    assert lb.circle_of_confusion(f, n, focus * f, near) == pytest.approx(limit, rel=1e-6)
    if far < inf:
        assert lb.circle_of_confusion(f, n, focus * f, far) == pytest.approx(limit, rel=1e-6)
    assert lb.circle_of_confusion(f, n, focus * f, inf) <= limit * (1.0 + 1e-6) or far < inf


@LAW
@given(FOCAL_LENGTH, F_NUMBER, LIMIT)
def test_focused_on_the_hyperfocal_all_from_its_half_to_infinity_is_sharp(f, n, limit):
    hyperfocal = lb.hyperfocal(f, n, limit)
    assert lb.circle_of_confusion(f, n, hyperfocal, inf) == pytest.approx(limit, rel=1e-9)
    near, _ = lb.depth_of_field(f, n, hyperfocal, limit)
    assert near == pytest.approx(hyperfocal / 2.0, rel=1e-9)
    assert lb.depth_of_field(f, n, hyperfocal * 1.000001, limit)[1] == inf
    assert lb.depth_of_field(f, n, hyperfocal * 0.99, limit)[1] < inf
    # a camera at infinity is sharp from the hyperfocal less f on
    assert lb.depth_of_field(f, n, inf, limit)[0] == pytest.approx(hyperfocal - f, rel=1e-9)


def test_a_table_of_depth_of_field_is_reproduced():
    """50 mm at f/8 on 3 m with C = 0.03 mm, by hand: 3 m · 2500 / (2500 ± 0.24 · 2950)."""
    assert lb.hyperfocal(50.0, 8.0, 0.03) == pytest.approx(10466.67, abs=0.01)
    assert lb.depth_of_field(50.0, 8.0, 3000.0, 0.03) == pytest.approx((7.5e6 / 3208.0, 7.5e6 / 1792.0), rel=1e-14)


def test_many_distances_give_many_answers_and_one_gives_a_number():
    coc = lb.circle_of_confusion(50.0, 2.0, 2000.0, [1000.0, 2000.0, inf])
    assert coc == pytest.approx([0.641026, 0.0, 0.641026], abs=1e-6)
    assert isinstance(lb.circle_of_confusion(50.0, 2.0, 2000.0, 1000.0), float)
    near, far = lb.depth_of_field(50.0, 8.0, [3000.0, inf], 0.03)
    assert near.shape == far.shape == (2,) and far[1] == inf
    assert all(isinstance(x, float) for x in lb.depth_of_field(50.0, 8.0, 3000.0, 0.03))


@pytest.mark.parametrize("focus", [50.0, 49.0, 0.0, -2000.0, nan])
def test_a_thin_lens_cannot_focus_within_its_focal_length(focus):
    message = "a thin lens of 50 mm focuses only beyond its focal length, 0.05 m"
    with pytest.raises(lb.FocusError, match=message):
        lb.circle_of_confusion(50.0, 2.0, focus, 1000.0)
    with pytest.raises(lb.FocusError, match=message):
        lb.depth_of_field(50.0, 2.0, focus, 0.03)


@pytest.mark.parametrize(("f", "n", "limit", "message"), [
    (0.0, 2.0, 0.03, "focal length 0 mm"), (nan, 2.0, 0.03, "focal length nan"), (inf, 2.0, 0.03, "focal length ∞"),
    (50.0, 0.0, 0.03, "f-number 0"), (50.0, -2.0, 0.03, "f-number -2"), (50.0, nan, 0.03, "f-number nan"),
    (50.0, 2.0, 0.0, "limit 0 mm"), (50.0, 2.0, nan, "limit nan mm"),
])
def test_impossible_numbers_are_refused_in_one_line(f, n, limit, message):
    with pytest.raises(lb.LensError, match=message):
        lb.hyperfocal(f, n, limit)
    with pytest.raises(lb.LensError, match=message):
        lb.depth_of_field(f, n, 2000.0, limit)


@pytest.mark.parametrize("distance", [0.0, -5.0, nan, [100.0, 0.0]])
def test_a_distance_behind_the_lens_has_no_blur(distance):
    with pytest.raises(lb.FocusError, match="must be positive"):
        lb.circle_of_confusion(50.0, 2.0, 2000.0, distance)


# --- The thick and the real lens

@pytest.mark.parametrize("name", NAMES)
def test_the_plane_in_focus_has_no_paraxial_blur(name):
    for distance in (300.0, 2000.0, 1e7, inf):
        film = lb.film_distance(lens(name), distance)
        assert lb.thick_circle_of_confusion(lens(name), film, distance) == pytest.approx([0.0], abs=1e-12)


@LAW
@given(st.floats(0.45, 1e4), st.floats(0.3, 1e4))
def test_the_thick_lens_blurs_as_a_thin_one_between_its_principal_planes(focus_m, distance_m):
    """With the stop in the front principal plane of a thin element, distances counted from the principal planes."""
    thin = lb.Lens((lb.Surface(1e-9, 5.0, lb.Glass(1.5), curvature=0.01), lb.Surface(0.0, 20.0, curvature=-0.01)), 0)
    fo = lb.first_order(thin)
    film = lb.film_distance(thin, 1000.0 * focus_m)
    from_lens = 1000.0 * focus_m - film
    expected = lb.circle_of_confusion(fo.efl, fo.f_number, from_lens, 1000.0 * distance_m - film)
    found = lb.thick_circle_of_confusion(thin, film, 1000.0 * distance_m)[0]
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("distance", [350.0, 700.0, 20000.0, inf])
def test_the_traced_blur_tends_to_the_thin_lens_formula_as_the_lens_grows_thin_and_its_stop_small(distance):
    errors = []
    for thinness in (1.0, 0.1, 0.01):
        glass = lb.Lens((lb.Surface(4.0 * thinness, 2.0 * sqrt(thinness), lb.Glass(1.5), curvature=0.01),
                         lb.Surface(0.0, 20.0, curvature=-0.01)), 0)
        fo = lb.first_order(glass)
        film = lb.film_distance(glass, 1000.0)
        traced = lb.real_circle_of_confusion(glass, film, distance)[0][0]
        thin = lb.circle_of_confusion(fo.efl, fo.f_number, 1000.0 - film, distance - film)
        errors.append(abs(traced / thin - 1.0))
    # thickness, and the square of the aperture, fall tenfold each time
    assert errors[0] < 0.05
    assert errors[1] < 0.13 * errors[0] and errors[2] < 0.13 * errors[1]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("radius", [0.2, 0.02])
def test_the_traced_blur_of_a_small_stop_is_the_thick_lens_one(name, radius):
    small = lens(name).with_stop_radius(radius)
    film = lb.film_distance(small, 1000.0)
    distances = np.array([150.0, 400.0, 3000.0, 1e7, inf])
    thick = lb.thick_circle_of_confusion(small, film, distances)
    spread, extent = lb.real_circle_of_confusion(small, film, distances)
    # defocus alone makes a uniform disk, so both measures are its diameter; aberrations go as the radius squared
    np.testing.assert_allclose(spread, thick, rtol=0.04 * (radius / 0.2) ** 2 + 1e-9)
    np.testing.assert_allclose(extent, thick, rtol=0.06 * (radius / 0.2) ** 2 + 1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_the_traced_spot_at_infinity_is_the_reference_tracers(name):
    """Its grid of 3,209 rays over the paraxial pupil; ours opens to the real margin: the stop set to match it."""
    reference = REFERENCE[name]
    paraxial = reference["paraxial"]["d"]
    heights = paraxial["enp_radius"] * np.sqrt((np.arange(2000) + 0.5) / 2000)
    t = lb.trace(lens(name), np.column_stack([0 * heights, heights, 0 * heights]), [0.0, 0.0, 1.0], clip=False)
    slopes = t.directions[:, 1] / t.directions[:, 2]
    on_film = t.points[:, 1] + (reference["film_z"] - t.points[:, 2]) * slopes
    # a grid against an even disk: its jagged edge is 1 % of the area, where the aberration is largest
    assert np.sqrt(np.mean(on_film**2)) == pytest.approx(reference["spot_rms_on_axis"], rel=0.03)


@pytest.mark.parametrize("name", ["dgauss", "fisheye"])
@pytest.mark.parametrize("distance", [400.0, 5000.0, inf])
def test_the_traced_blur_is_that_of_a_dense_bundle_through_every_rim(name, distance):
    wide = lens(name)
    film = lb.film_distance(wide, 2000.0)
    before = distance - film - wide.length
    edge = np.linspace(0.0, 1.2 * lb.first_order(wide).entrance_pupil.radius, 40001)[1:]

    def radii(heights):
        t = lb.trace(wide, np.column_stack([0 * heights, heights, 0 * heights]),
                     np.column_stack([0 * heights, heights / before, np.ones_like(heights)]))
        slopes = t.directions[:, 1] / t.directions[:, 2]
        return t.fate, np.abs(t.points[:, 1] + (wide.length + film - t.points[:, 2]) * slopes)

    passed, across = radii(edge)
    margin = edge[passed == lb.Fate.PASSED].max()
    _, even = radii(margin * np.sqrt((np.arange(4000) + 0.5) / 4000))
    spread, extent = lb.real_circle_of_confusion(wide, film, [distance])
    assert spread[0] == pytest.approx(2.0 * np.sqrt(2.0 * np.mean(even**2)), rel=2e-3)
    assert extent[0] == pytest.approx(2.0 * across[passed == lb.Fate.PASSED].max(), rel=5e-3)


def test_the_margin_on_the_axis_is_the_reference_tracers():
    for name in NAMES[:2]:
        found = marginal_height(surface_table(lens(name)), 0.0, True)
        assert found == pytest.approx(REFERENCE[name]["marginal_height_on_axis"], abs=1e-9)
        film = REFERENCE[name]["film_z"] - lens(name).length
        found = marginal_height(surface_table(lens(name)), 1.0 / film, False)
        assert found == pytest.approx(REFERENCE[name]["exit_pupil_on_axis"], abs=1e-9)


@pytest.mark.parametrize("blur", [lb.thick_circle_of_confusion, lambda *args: lb.real_circle_of_confusion(*args)[0]])
def test_points_within_the_lens_have_no_blur_and_the_others_keep_theirs(blur):
    film = lb.film_distance(lens("dgauss"), 1000.0)
    found = blur(lens("dgauss"), film, [-5.0, 0.0, film, film + 30.0, 500.0, inf])
    assert np.isnan(found[:4]).all() and np.isfinite(found[4:]).all()


@pytest.mark.parametrize("name", NAMES)
def test_blur_grows_away_from_the_plane_in_focus(name):
    film = lb.film_distance(lens(name), 2000.0, "real")
    for distances in (np.geomspace(3000.0, 1e6, 20), np.geomspace(1500.0, 300.0, 20)):
        assert (np.diff(lb.real_circle_of_confusion(lens(name), film, distances)[0]) > 0.0).all()
        assert (np.diff(lb.thick_circle_of_confusion(lens(name), film, distances)) != 0.0).all()


def test_a_stop_towards_telecentric_needs_no_case_of_its_own():
    """With the stop in the front focus the blur does not depend on where the exit pupil is said to be."""
    one = biconvex()
    before = -lb.first_order(one).ffl
    telecentric = lb.Lens((lb.Surface(before, 3.0, curvature=0.0), *one.surfaces), 0)
    fo = lb.first_order(telecentric)
    blur = lb.thick_circle_of_confusion(telecentric, fo.bfl + 1.0, [inf])
    assert blur == pytest.approx([1.0 * 2.0 * 3.0 / fo.efl], rel=1e-9)
