"""What gives way when the lens, its scale or the film changes."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings as limits, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench import constraints
from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from tests.library import CLASSICS

START = Settings()


@pytest.mark.parametrize("name", CLASSICS)
def test_every_lens_of_the_library_takes_the_settings_of_another(name):
    settings = constraints.constrained(replace(START, lens=name, f_number=0.9, focus_distance=150.0))
    camera(settings)                            # raises where it cannot be
    # the aperture is kept where the lens opens so far, and no nearer focus than the clamped one exists
    opens = lb.first_order(design(settings)).f_number <= 0.9
    assert settings.f_number == (0.9 if opens else None)
    if settings.focus_distance != 150.0:
        assert settings.focus_distance > 150.0
        with pytest.raises(lb.LensError):
            camera(replace(settings, focus_distance=0.999 * settings.focus_distance))
    assert constraints.constrained(settings) == settings


@pytest.mark.parametrize("radius", [-30.0, 30.0])
def test_a_larger_film_is_curved_as_tightly_as_its_corners_allow(radius):
    curved = replace(START, film_radius=radius)
    assert constraints.constrained(curved) == curved
    wanted = constraints.with_film(curved, 56.0, 42.0)
    with pytest.raises(lb.FilmError):
        camera(wanted)
    got = constraints.constrained(wanted)
    camera(got)
    assert got == replace(wanted, film_radius=got.film_radius)
    assert got.film_radius == pytest.approx(math.copysign(35.0 / 0.9, radius), rel=2e-4)   # half the diagonal is 35 mm
    assert constraints.constrained(got) == got


def test_what_the_lens_can_do_is_left_alone():
    assert constraints.constrained(START) == START


@limits(max_examples=40)
@given(st.floats(0.06, 1.0))
def test_field_of_view_and_crop_are_one(crop):
    settings = replace(START, crop=crop)
    fov = constraints.field_of_view(settings)
    efl = lb.first_order(design(settings)).efl
    assert math.isclose(fov, 2.0 * math.atan(0.5 * 24.0 * crop / efl), rel_tol=1e-12)
    assert math.isclose(constraints.with_field_of_view(START, fov).crop, crop, rel_tol=1e-9)


def test_a_lens_in_water_sees_the_field_that_is_asked_of_it():
    wet = Settings(lens="pbrt-dgauss-50mm", focus_position="paraxial", medium="water", immersed=True,
                   focus_distance=1e7)
    settings = constraints.with_field_of_view(wet, math.radians(2.0))       # too small for distortion
    of = camera(settings)
    top = of.generate_rays([[of.film.pixels_x / 2.0, 0.0]], [of.pupil_centre])
    assert 2.0 * math.acos(-top.directions[0, 2]) == pytest.approx(math.radians(2.0), rel=2e-3)
    assert constraints.field_of_view(settings) == pytest.approx(math.radians(2.0), rel=1e-9)


def test_a_lens_that_is_wide_open_becomes_an_ideal_lens_as_wide_and_no_pinhole():
    settings = replace(START, f_number=None)
    widest = readings(settings).widest_f_number
    assert constraints.with_camera(settings, "perspective").f_number == widest > 1.0
    assert camera(constraints.with_camera(settings, "perspective")).lens_radius > 0.0
    assert constraints.with_camera(replace(START, f_number=5.6), "perspective").f_number == 5.6
    away = constraints.with_camera(settings, "environment")
    assert constraints.with_camera(away, "perspective").f_number == widest
    assert constraints.with_camera(replace(settings, lens_model="pinhole"), "perspective").f_number is None


def test_the_perspective_camera_has_a_field_of_view_of_its_own():
    settings = replace(START, camera="perspective")
    assert constraints.with_field_of_view(settings, 1.0) == replace(settings, fov=1.0)


def test_the_perspective_camera_focuses_no_nearer_than_twice_its_focal_length():
    near = constraints.constrained(replace(START, camera="perspective", fov=0.1, focus_distance=1.0))
    got = readings(near)
    assert math.isclose(near.focus_distance, got.nearest_focus, rel_tol=1e-3)
    assert math.isclose(got.magnification, 0.5, rel_tol=1e-3)           # its film stays at the focal length
    camera(near)
    with pytest.raises(SettingsError, match="nearest distance"):
        camera(replace(near, focus_distance=0.9 * near.focus_distance))
    camera(replace(near, focus_distance=1.0, f_number=None))        # a pinhole is sharp everywhere


def test_a_field_beyond_the_film_is_the_whole_film():
    assert constraints.with_field_of_view(replace(START, crop=0.5), 3.0).crop == 1.0


@pytest.mark.parametrize(("width", "height"), lb.FORMATS.values())
def test_another_film_keeps_its_pixels_square_and_as_many_along_the_longer_side(width, height):
    film = constraints.with_film(START, width, height).film
    assert max(film.pixels_x, film.pixels_y) == max(START.pixels_x, START.pixels_y)
    # half a pixel of rounding along the shorter side
    assert math.isclose(film.pixels_x / film.pixels_y, width / height, rel_tol=0.5 / min(film.pixels_x, film.pixels_y))


def test_a_lens_that_is_not_there_is_an_error():
    with pytest.raises(lenses.LensFileError):
        constraints.constrained(replace(START, lens="no-such-lens"))
