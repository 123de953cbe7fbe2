"""Depth of field of the thick lens, against traced rays of a small stop, and against its own circles of confusion."""

import math
from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses

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
