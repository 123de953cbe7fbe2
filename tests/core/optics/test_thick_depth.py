"""Depth of field of the thick lens, against traced rays of a small stop, and against its own circles of confusion."""

import math
from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import behind_stop, of_one_colour

SMALL = 1000.0                  # × the f-number: a bundle free of aberrations, whose blur is scaled back
CASES = {
    "unit focusing": ("pbrt-dgauss-50mm", 1.0, 1200.0), "near": ("pbrt-dgauss-50mm", 1.0, 250.0),
    "in water": ("pbrt-dgauss-50mm", 1.333, 1200.0),
    "focus groups": ("lv-minolta-af-100mm-f28-macro", 1.0, 400.0),
    "a small exit pupil": ("laowa-2-macro-probe-24-f14", 1.0, 480.0),
}


def stopped(name: str, index: float, distance: float, f_number: float):
    lens = replace(lenses.load(name).at(zoom=0.0, close=0.0), front_index=index)
    lens = lb.stopped_down(lens, f_number)
    return lb.focused(lens, distance), lb.film_distance(lens, distance)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("limit", [0.005, 0.03])
def test_at_the_limits_traced_rays_are_as_wide_as_the_limit(name, limit):
    lens_name, index, distance = CASES[name]
    wide = lb.f_number_at_infinity(lenses.load(lens_name).at(zoom=0.0, close=0.0))
    lens, film = stopped(lens_name, index, distance, wide)
    near, far = lb.thick_depth_of_field(lens, film, distance, limit)
    assert near < distance < far < math.inf
    small, small_film = stopped(lens_name, index, distance, SMALL * wide)
    spread, _ = lb.real_circle_of_confusion(small, small_film, [near, far])
    # Its spherical aberration, scaled back, is a millionth of that of the whole bundle, up to 0.7 mm here
    assert SMALL * spread == pytest.approx(limit, rel=2e-3)
    assert lb.thick_circle_of_confusion(lens, film, [near, far]) == pytest.approx(limit, rel=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_focused_at_the_hyperfocal_distance_infinity_is_as_wide_as_the_limit(name):
    lens_name, index, _ = CASES[name]
    lens, _ = stopped(lens_name, index, math.inf, 22.0)
    at = lb.thick_hyperfocal(lens, 0.03)
    there, film = lb.focused(lens, at), lb.film_distance(lens, at)
    assert lb.thick_circle_of_confusion(there, film, [1e13])[0] == pytest.approx(0.03, rel=1e-6)
    assert lb.thick_depth_of_field(there, film, at * (1.0 + 1e-6), 0.03)[1] == math.inf


def test_far_off_the_thick_lens_is_the_thin_one():
    lens, film = stopped("pbrt-dgauss-50mm", 1.0, 1e5, 2.8)
    fo = lb.first_order(lens)
    offset = lens.length + film - fo.front_principal
    near, far = lb.depth_of_field(fo.efl, fo.f_number, 1e5 - offset, 0.03)
    assert lb.thick_depth_of_field(lens, film, 1e5, 0.03)[0] == pytest.approx(near + offset, rel=2e-4)
    assert math.isinf(far) and math.isinf(lb.thick_depth_of_field(lens, film, 1e5, 0.03)[1])


def test_magnification_is_the_ratio_of_the_image_distances_to_the_principal_planes():
    lens, film = stopped("pbrt-dgauss-50mm", 1.0, 400.0, 2.8)
    fo = lb.first_order(lens)
    behind, before = film - fo.rear_principal, 400.0 - film - lens.length + fo.front_principal
    assert lb.magnification(lens, film, 400.0) == pytest.approx(behind / before, rel=1e-9)
    assert lb.magnification(lens, film, math.inf) == 0.0


def test_the_magnification_of_a_colour_is_that_of_a_lens_of_this_colour():
    lens, film = stopped("lib-tronnier-1953", 1.0, 700.0, 8.0)
    blue = lb.magnification(lens, film, 700.0, 0.4358)
    assert blue == pytest.approx(lb.magnification(of_one_colour(lens, 0.4358), film, 700.0), rel=1e-12)
    assert blue != pytest.approx(lb.magnification(lens, film, 700.0), rel=1e-5)


@pytest.mark.parametrize("away", [math.inf, 1000.0, 90.0])
def test_behind_an_image_within_the_lens_the_limits_blur_by_the_limit(away):
    """A stop behind that image: its entrance pupil is upside down."""
    glass = lb.Glass(1.6)
    lens = lb.Lens((lb.Surface(3.0, 9.0, glass, curvature=1 / 24.0), lb.Surface(50.0, 9.0, curvature=-1 / 24.0),
                    lb.Surface(0.5, 1.5, curvature=0.0),
                    lb.Surface(3.0, 9.0, glass, curvature=1 / 30.0), lb.Surface(0.0, 9.0, curvature=-1 / 30.0)), 2)
    film, _ = lb.section_foci(lens, away + lens.length + 1.0, 1.0)
    focus = away + lens.length + film
    assert film > 0.0 and lb.first_order(lens).efl < 0.0
    near, far = lb.thick_depth_of_field(lens, film, focus, 0.02)
    assert near < focus <= far and (far < math.inf) == (away < math.inf)
    assert lb.thick_circle_of_confusion(lens, film, [near])[0] == pytest.approx(0.02, rel=1e-9)
    if away < math.inf:
        assert lb.thick_circle_of_confusion(lens, film, [far])[0] == pytest.approx(0.02, rel=1e-9)


@pytest.mark.parametrize("film", [60.0, 63.0, 75.0])
def test_the_blur_on_a_film_in_glass_is_that_of_similar_triangles(film):
    """One surface, which is the stop: 1 / before + n / behind = (n - 1) / R, and the cone from it to that image."""
    lens = lb.Lens((lb.Surface(0.0, 3.0, lb.Glass(1.5), curvature=1 / 20.0),), 0)
    for before in (300.0, 1500.0):
        image = 1.5 / (0.5 / 20.0 - 1.0 / before)
        assert lb.thick_circle_of_confusion(lens, film, [before + film])[0] == pytest.approx(
            6.0 * abs(image - film) / image, rel=1e-12)


@pytest.mark.parametrize("before", [-30.0, -200.0, 45.0])
def test_the_focus_of_converging_light_is_before_that_of_parallel_light(before):
    """Gauss's equation of one surface; light that converges has its object behind the first vertex."""
    lens = lb.Lens((lb.Surface(0.0, 3.0, lb.Glass(1.5), curvature=1 / 20.0),), 0)
    expected = 1.5 / (0.5 / 20.0 - 1.0 / before)
    assert lb.section_foci(lens, before + 40.0, 40.0) == pytest.approx((expected, expected), rel=1e-12)


def test_the_hyperfocal_distance_of_a_stop_behind_the_rear_focus_blurs_infinity_by_the_limit():
    lens = behind_stop(6.0)
    film = lb.film_distance(lens, lb.thick_hyperfocal(lens, 0.03))
    assert lb.thick_circle_of_confusion(lens, film, [1e13])[0] == pytest.approx(0.03, rel=1e-6)


def test_blades_of_a_lens_with_cylinders_count_as_the_circle_of_their_area():
    plain = replace(lenses.load("lentil-schneider-anamorphic-31-2001"), blades=5)
    lens = lb.stopped_down(plain, 2.0 * lb.first_order(plain).f_number)
    assert not lens.iris.is_round
    film = lb.film_distance(lens, 3000.0)
    expected = lb.thick_depth_of_field(lens.with_round_stop, film, 3000.0, 0.2)
    assert lb.thick_depth_of_field(lens, film, 3000.0, 0.2) == pytest.approx(expected, rel=1e-9)
    assert math.isfinite(expected[0])


def test_the_hyperfocal_distance_does_not_depend_on_where_the_groups_are():
    lens = stopped("lv-minolta-af-100mm-f28-macro", 1.0, math.inf, 11.0)[0]
    expected = lb.thick_hyperfocal(lens, 0.03)
    for close in (0.3, 1.0):
        assert lb.thick_hyperfocal(lens.at(close=close), 0.03) == pytest.approx(expected, rel=1e-9)


def test_two_foci_that_blur_everything_leave_no_depth_of_field():
    lens = lenses.load("lentil-schneider-anamorphic-31-2001").at(zoom=0.0, close=0.0)
    film = lb.film_distance(lens, 2000.0)
    blur = float(lb.thick_circle_of_confusion(lens, film, [2000.0])[0])
    assert all(math.isnan(each) for each in lb.thick_depth_of_field(lens, film, 2000.0, 0.5 * blur))
    near, far = lb.thick_depth_of_field(lens, film, 2000.0, 3.0 * blur)
    assert near < 2000.0 < far
    found = lb.thick_circle_of_confusion(lens, film, [near, min(far, 1e14)])
    assert found[0] == pytest.approx(3.0 * blur, rel=1e-9)
    assert found[1] <= 3.0 * blur * (1.0 + 1e-9)


def test_what_touches_the_lens_may_be_sharp_and_a_focus_within_it_is_refused():
    lens, film = stopped("pbrt-dgauss-50mm", 1.0, 300.0, 2.8)
    assert lb.thick_depth_of_field(lens, film, 300.0, 500.0)[0] == pytest.approx(film + lens.length)
    with pytest.raises(lb.LensError, match="within the lens"):
        lb.thick_depth_of_field(lens, film, 20.0, 0.03)
    for bad in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(lb.LensError, match="limit"):
            lb.thick_depth_of_field(lens, film, 300.0, bad)
        with pytest.raises(lb.LensError, match="limit"):
            lb.thick_hyperfocal(lens, bad)


@pytest.mark.parametrize("blur", [lb.thick_circle_of_confusion, lb.real_circle_of_confusion])
def test_blur_of_numbers_that_mean_nothing_is_refused(blur):
    lens, film = stopped("pbrt-dgauss-50mm", 1.0, 300.0, 2.8)
    for bad in (math.nan, math.inf, -math.inf):
        with pytest.raises(lb.LensError, match="film distance"):
            blur(lens, bad, [300.0])
    with pytest.raises(lb.LensError, match="distances"):
        blur(lens, film, [300.0, math.nan])


def test_film_distances_that_are_none_are_named():
    """They were an image at infinity, NaN, or a focus within the lens."""
    lens = stopped("pbrt-dgauss-50mm", 1.0, 300.0, 2.8)[0]
    for bad in (math.nan, math.inf, -math.inf):
        for ask in (lb.focused_distance, lambda of, film: lb.section_foci(of, 300.0, film),
                    lambda of, film: lb.magnification(of, film, 300.0),
                    lambda of, film: lb.thick_depth_of_field(of, film, 300.0, 0.03)):
            with pytest.raises(lb.LensError, match="film distance"):
                ask(lens, bad)


def test_foci_of_an_object_on_the_first_vertex_are_refused():
    lens = stopped("pbrt-dgauss-50mm", 1.0, 300.0, 2.8)[0]
    for bad in (300.0, math.nan):
        with pytest.raises(lb.LensError, match="must not touch"):
            lb.section_foci(lens, bad, 300.0 - lens.length)


@pytest.mark.parametrize("limit", [1e9, 1e306])
def test_the_hyperfocal_distance_for_a_blur_without_bound_is_its_film(limit):
    """The plane in focus comes to the front focus, and the film goes to where parallel light is as wide as the blur: N
    times that behind the rear focus. What is left is of the size of the lens."""
    lens = stopped("pbrt-dgauss-50mm", 1.0, math.inf, 2.8)[0]
    assert lb.thick_hyperfocal(lens, limit) == pytest.approx(limit * lb.first_order(lens).f_number, rel=1e-6)
