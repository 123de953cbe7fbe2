"""The read-outs against closed forms and against each other."""

import math
from dataclasses import fields, replace

import pytest

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.figures import Readings, blur_limit, readings
from lensbench.app.state.settings import Settings
from tests.app.kinds import of_kind

START = Settings(lens="pbrt-dgauss-50mm", focus_position="paraxial")     # the focus of the closed forms
distances = pytest.mark.parametrize("focus", [250.0, 1200.0, 9000.0, math.inf])


def from_lens(stand, distance: float) -> float:
    """An engraved distance measured from the front principal plane instead."""
    film_z = stand.lens.length + stand.film_distance
    return distance - (film_z - stand.first_order.front_principal)


@distances
def test_principal_planes_carry_the_engraved_distance_to_the_film(focus):
    # 1/s + 1/s′ = 1/f between the principal planes; the film lies s′ behind the rear one
    stand = setup(replace(START, focus_distance=focus))
    fo = stand.first_order
    s, image = from_lens(stand, focus), stand.film_distance - fo.rear_principal
    assert 1.0 / s + 1.0 / image == pytest.approx(1.0 / fo.efl, rel=1e-12)


@distances
@pytest.mark.parametrize("limit", ["diagonal", "pixel"])
def test_at_the_limits_of_the_depth_of_field_the_circle_of_confusion_is_the_limit(focus, limit):
    settings = replace(START, focus_distance=focus, limit=limit)
    stand, got = setup(settings), readings(settings)
    s_f = from_lens(stand, focus)
    for edge in (got.near_limit, got.far_limit):
        s = from_lens(stand, edge)
        if math.isinf(s_f):
            blur = got.efl**2 / got.f_number / s if math.isfinite(s) else 0.0
        elif math.isinf(s):
            continue
        else:
            blur = got.efl / got.f_number * got.efl * abs(s - s_f) / (s * (s_f - got.efl))
        if blur:
            assert blur == pytest.approx(blur_limit(settings), rel=1e-9)
    assert got.near_limit < focus and got.far_limit >= focus


def test_focused_at_the_hyperfocal_distance_all_is_sharp_from_half_of_it():
    got = readings(START)
    # The film moves a little with the focus, and the engraved distance with it: the second step closes it
    for _ in range(3):
        got = readings(replace(START, focus_distance=got.hyperfocal))
    stand = setup(replace(START, focus_distance=got.hyperfocal))
    nudged = readings(replace(START, focus_distance=got.hyperfocal * 1.001))
    assert nudged.far_limit == math.inf
    assert from_lens(stand, got.near_limit) == pytest.approx(0.5 * from_lens(stand, got.hyperfocal), rel=1e-3)


@distances
def test_magnification_is_image_over_object_distance(focus):
    settings = replace(START, focus_distance=focus)
    stand = setup(settings)
    image = stand.film_distance - stand.first_order.rear_principal
    expected = 0.0 if math.isinf(focus) else image / from_lens(stand, focus)
    assert readings(settings).magnification == pytest.approx(expected, rel=1e-10, abs=1e-15)


def test_field_of_view_and_equivalent_follow_the_film_that_is_used():
    whole, half = readings(START), readings(replace(START, crop=0.5))
    assert math.tan(whole.fov_diagonal / 2.0) == pytest.approx(math.hypot(36.0, 24.0) / 2.0 / whole.efl, rel=1e-12)
    assert math.tan(half.fov_horizontal / 2.0) == pytest.approx(math.tan(whole.fov_horizontal / 2.0) / 2.0, rel=1e-12)
    assert whole.equivalent == pytest.approx(whole.efl, rel=1e-12)
    assert half.equivalent == pytest.approx(2.0 * whole.efl, rel=1e-12)


def test_a_scaled_lens_keeps_its_f_number_and_scales_its_lengths():
    plain, double = readings(START), readings(replace(START, focal_length=2.0 * readings(START).efl))
    assert double.efl == pytest.approx(2.0 * plain.efl, rel=1e-12)
    assert double.bfl == pytest.approx(2.0 * plain.bfl, rel=1e-12)
    assert double.nearest_focus == pytest.approx(2.0 * plain.nearest_focus, rel=1e-12)
    assert double.f_number == pytest.approx(2.8, rel=1e-12)
    assert double.entrance_pupil == pytest.approx(2.0 * plain.entrance_pupil, rel=1e-12)


def test_asked_and_working_f_number_and_t_number():
    far, near = readings(replace(START, focus_distance=math.inf)), readings(replace(START, focus_distance=300.0))
    assert far.f_number == pytest.approx(2.8, rel=1e-12)
    assert far.entrance_pupil == pytest.approx(far.efl / 2.8, rel=1e-12)
    # The double Gauss is nearly free of coma and spherical aberration at f/2.8: a few percent of the sine condition
    assert far.working_f_number == pytest.approx(2.8, rel=0.03)
    assert near.working_f_number == pytest.approx(2.8 * (1.0 + near.magnification), rel=0.08)
    assert far.t_number > far.f_number
    assert far.airy == pytest.approx(2.44 * 0.5875618e-3 * far.working_f_number, rel=1e-12)


def test_limits_are_the_diagonal_over_1500_or_a_pixel():
    assert blur_limit(START) == pytest.approx(math.hypot(36.0, 24.0) / 1500.0, rel=1e-15)
    assert blur_limit(replace(START, limit="pixel", pixels_x=1920, pixels_y=1280)) == pytest.approx(36.0 / 1920)


def test_a_pinhole_has_no_depth_of_field_and_no_f_number():
    got = readings(replace(START, lens_model="pinhole"))
    assert got.f_number is got.working_f_number is got.near_limit is got.hyperfocal is got.t_number is None
    assert got.efl == readings(START).efl


def test_a_perspective_camera_is_an_ideal_lens_of_its_field_of_view():
    got = readings(replace(START, camera="perspective", fov=0.6, f_number=4.0, focus_distance=2000.0))
    assert got.fov_vertical == pytest.approx(0.6, rel=1e-12)        # the shorter side of 36 × 24
    assert got.efl == pytest.approx(12.0 / math.tan(0.3), rel=1e-12)
    assert lb.circle_of_confusion(got.efl, 4.0, 2000.0, got.near_limit) == pytest.approx(got.limit, rel=1e-9)
    assert lb.circle_of_confusion(got.efl, 4.0, 2000.0, got.far_limit) == pytest.approx(got.limit, rel=1e-9)
    assert got.bfl is got.film_distance is got.exit_pupil is None


@pytest.mark.parametrize("change", [
    {"lens": "no-such-lens"}, {"lens": "/no/such/file.toml"}, {"f_number": 0.5}, {"f_number": math.nan},
    {"focus_distance": 5.0}, {"focus_distance": math.nan}, {"film_width": -1.0}, {"focal_length": 0.0},
    {"crop": 0.0}, {"camera": "perspective", "focus_distance": 1.0}, {"camera": "perspective", "f_number": -2.0},
])
def test_a_bad_state_gives_its_reason_and_never_an_exception(change):
    assert readings(replace(START, **change)).reason


def test_what_does_not_touch_the_optics_is_not_computed_again():
    turned = replace(START, yaw=1.0, position=(1.0, 2.0, 3.0), exposure=2.0, scene="room", seed=4)
    assert readings(turned) is readings(START)


def test_every_length_is_finite_or_none_save_the_far_limit():
    for model in ("trace", "thin", "pinhole", "perspective"):
        got = readings(replace(of_kind(START, model), focus_distance=math.inf))
        values = {f.name: getattr(got, f.name) for f in fields(Readings)
                  if f.name not in ("far_limit", "reason", "focusing")}
        values["blur"] = got.focusing.blur
        assert all(value is None or math.isfinite(value) for value in values.values()), values
