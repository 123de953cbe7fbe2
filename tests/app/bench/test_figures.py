"""The read-outs against closed forms and against each other."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.readouts import Readings, blur_limit
from lensbench.app.plots.blur import Blur
from lensbench.app.settings.settings import Settings
from tests.app.kinds import of_kind

START = Settings(lens="pbrt-dgauss-50mm", focus_position="paraxial")     # the focus of the closed forms
CLOSED = 200.0                  # × the f-number, for the limit of small stops
distances = pytest.mark.parametrize("focus", [250.0, 1200.0, 9000.0, math.inf])


def from_lens(stand, distance: float) -> float:
    """An engraved distance measured from the front principal plane instead."""
    film_z = stand.lens.length + stand.film_distance
    return distance - (film_z - stand.first_order.front_principal)


@distances
def test_principal_planes_carry_the_engraved_distance_to_the_film(focus):
    # 1/s + 1/s′ = 1/f between the principal planes; the film lies s′ behind the rear one
    stand = bench_of(replace(START, focus_distance=focus))
    fo = stand.first_order
    s, image = from_lens(stand, focus), stand.film_distance - fo.rear_principal
    assert 1.0 / s + 1.0 / image == pytest.approx(1.0 / fo.efl, rel=1e-12)


SEEN = {
    "unit focusing": START,
    "internal focusing": replace(START, lens="lv-minolta-af-100mm-f28-macro", f_number=4.0,
                                 focus_distance=400.0),
    "a zoom": replace(START, lens="lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", f_number=4.0,
                      zoom=0.8, focus_distance=1500.0),
    "through a window": replace(START, medium="water", visibility=8000.0),
    "internal focusing through a window": replace(START, medium="water", lens="lv-minolta-af-100mm-f28-macro",
                                                  f_number=4.0, focus_distance=450.0),
    "in the water": replace(START, medium="water", immersed=True),
    "perspective": replace(of_kind(START, "perspective"), f_number=2.8),
    "perspective through a window": replace(of_kind(START, "perspective"), f_number=2.8, medium="water"),
}


def blur_of_point(settings: Settings, distance: float) -> float:
    """Diameter (mm) of the image of a point of the axis, from rays of the camera.

    Film points see the point whose cones of rays hold it. The cone of the film's middle is as wide at this distance as
    its rays say (2√2 × their rms); a film point beside it has its cone as far beside it as the ray through the middle
    of the pupil. The stop is closed to 1/200 and the result scaled back: the limit of small stops, without
    aberrations.
    """
    of = camera(replace(settings, f_number=CLOSED * settings.f_number))
    even, middle = (np.arange(96) + 0.5) / 96.0, [of.film.pixels_x / 2.0, of.film.pixels_y / 2.0]
    samples = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)

    def at_distance(raster, uv):
        rays = of.generate_rays(np.broadcast_to(raster, uv.shape), uv)
        away = (-distance - rays.origins[:, 2]) / rays.directions[:, 2]
        return (rays.origins + away[:, None] * rays.directions)[rays.weights > 0.0, :2]        # past the blades

    cone = at_distance(middle, samples)
    beside = at_distance([middle[0], middle[1] - 0.5], np.array([of.pupil_centre]))
    width = 2.0 * math.sqrt(2.0 * float(((cone - cone.mean(0)) ** 2).sum(1).mean()))
    return CLOSED * 0.5 * of.film.pitch * width / float(np.hypot(*beside[0]))


@pytest.mark.parametrize("name", SEEN)
def test_at_the_limits_of_the_depth_of_field_the_camera_blurs_a_point_as_much_as_the_limit(name):
    settings = SEEN[name]
    got = readings(settings)
    assert got.near_limit < settings.focus_distance < got.far_limit < math.inf
    for edge in (got.near_limit, got.far_limit):
        # A bundle 1/200 as wide has, scaled back, 1/40,000 of the spherical aberration of the whole
        assert blur_of_point(settings, edge) == pytest.approx(got.limit, rel=5e-3)


@pytest.mark.parametrize("name", SEEN)
def test_the_distance_in_focus_is_sharp_and_the_overlay_knows_it(name):
    settings = SEEN[name]
    got, blur = readings(settings), Blur.of(settings)
    assert blur_of_point(settings, settings.focus_distance) < 5e-3 * got.limit
    pitch = settings.film.pitch
    assert blur.pixels(settings.focus_distance, (0.5, 0.5)) < 1e-3 * got.limit / pitch
    for edge in (got.near_limit, got.far_limit):
        assert blur.pixels(edge, (0.5, 0.5)) * pitch == pytest.approx(got.limit, rel=2e-3)


@pytest.mark.parametrize("name", SEEN)
def test_magnification_is_that_of_the_rays_to_the_plane_in_focus(name):
    settings = SEEN[name]
    of = camera(replace(settings, f_number=CLOSED * settings.f_number))
    rays = of.generate_rays([[of.film.pixels_x / 2.0, of.film.pixels_y / 2.0 - 0.5]], [of.pupil_centre])
    away = (-settings.focus_distance - rays.origins[:, 2]) / rays.directions[:, 2]
    there = (rays.origins + away[:, None] * rays.directions)[0, :2]
    assert 0.5 * of.film.pitch / np.hypot(*there) == pytest.approx(readings(settings).magnification, rel=1e-3)


@pytest.mark.parametrize("name", SEEN)
def test_the_field_of_view_is_that_of_the_camera_near_the_axis(name):
    settings = replace(SEEN[name], focus_distance=1e7, crop=0.05)        # the field of a small film, free of distortion
    of, got = camera(settings), readings(settings)
    rays = of.generate_rays([[of.film.pixels_x / 2.0, 0.0]], [of.pupil_centre])
    assert 2.0 * math.acos(-rays.directions[0, 2]) == pytest.approx(got.fov_vertical, rel=2e-3)


def test_the_field_across_of_an_anamorphic_lens_in_water_is_that_of_its_rays():
    settings = replace(START, lens="lentil-schneider-anamorphic-31-2001", medium="water", immersed=True, crop=0.05,
                       film_width=24.0, film_height=18.0, focus_distance=1e7)
    of, got = camera(settings), readings(settings)
    rays = of.generate_rays([[0.0, of.film.pixels_y / 2.0]], [of.pupil_centre])
    # In water its two sections focus 4 mm apart, and the film lies between
    assert 2.0 * math.acos(-rays.directions[0, 2]) == pytest.approx(got.fov_horizontal, rel=0.04)


@pytest.mark.parametrize("name", SEEN)
def test_focused_at_the_hyperfocal_distance_infinity_is_just_sharp(name):
    settings = replace(SEEN[name], f_number=8.0)
    at = readings(settings).hyperfocal
    assert readings(replace(settings, focus_distance=0.5 * at)).hyperfocal == pytest.approx(at, rel=1e-9)
    assert readings(replace(settings, focus_distance=0.999 * at)).far_limit < math.inf
    assert readings(replace(settings, focus_distance=1.001 * at)).far_limit == math.inf


def test_what_a_lens_does_not_focus_on_through_its_window_is_said_in_true_distances():
    settings = replace(START, medium="water", focus_distance=215.0)
    nearest = readings(settings).nearest_focus
    assert 200.0 < nearest < 250.0
    assert f"{nearest / 1000.0:.4g}"[:5] in bench_of(settings).reason and "window" in bench_of(settings).reason
    with pytest.raises(lb.FocusError, match="window"):
        camera(settings)
    assert constrained(settings).focus_distance == pytest.approx(nearest, rel=1e-3)


@distances
def test_magnification_is_image_over_object_distance(focus):
    settings = replace(START, focus_distance=focus)
    stand = bench_of(settings)
    image = stand.film_distance - stand.first_order.rear_principal
    expected = 0.0 if math.isinf(focus) else image / from_lens(stand, focus)
    assert readings(settings).magnification == pytest.approx(expected, rel=1e-10, abs=1e-15)


def test_field_of_view_and_equivalent_follow_the_film_that_is_used():
    ideal = replace(START, lens_model="thick")                          # free of distortion
    whole, half = readings(ideal), readings(replace(ideal, crop=0.5))
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
    assert got.working_f_number == 4.0                              # its film stays at the focal length
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


@pytest.mark.parametrize(("name", "focus"), [
    ("viltrox-af-stm-ed-if-75-f12", 278.25), ("rodenstock-xr-heligon-100-f075", 490.0),
    ("rodenstock-xr-heligon-100-f075", 600.0), ("nikon-fuwatto-soft-90-f48", 600.0)])
def test_a_lens_that_all_its_rays_focus_is_focused_through_a_window_where_it_is_set(name, focus):
    settings = Settings(lens=name, medium="water", f_number=None, focus_distance=focus, lens_model="trace",
                        focus_position="real")
    got, built = readings(settings), bench_of(settings)
    assert got.focusing.method == "real" and not built.refused
    assert built.port.true(built.focus_distance) == pytest.approx(focus, rel=1e-9)
    assert got.near_limit < focus < got.far_limit
    # All rays of the film's middle are narrowest there, but for the aberrations of the window itself
    of = camera(settings)
    even = (np.arange(24) + 0.5) / 24.0
    samples = np.stack(np.meshgrid(even, even), -1).reshape(-1, 2)
    rays = of.generate_rays(np.broadcast_to([of.film.pixels_x / 2.0, of.film.pixels_y / 2.0], samples.shape), samples)
    lit = rays.weights > 0.0
    slopes = (rays.directions[:, :2] / rays.directions[:, 2:])[lit]
    places = rays.origins[lit, :2] - rays.origins[lit, 2:] * slopes
    assert float((slopes * places).sum() / (slopes**2).sum()) == pytest.approx(focus, rel=0.01)


def test_a_focus_that_is_refused_gives_the_figures_of_the_nearest_one():
    settings = Settings(lens="hasselblad-hc-300-f45", medium="water", f_number=None, focus_distance=3000.0)
    got, built = readings(settings), bench_of(settings)
    assert built.refused and "nearest" in got.reason
    assert got.near_limit < got.nearest_focus < got.far_limit
    assert Blur.of(settings).pixels(got.near_limit, (0.5, 0.5)) == pytest.approx(
        got.limit / settings.film.pitch, rel=0.02)
    dark = replace(START, f_number=0.5)                                 # refused as well, but focused as set
    built = bench_of(dark)
    assert not built.refused and built.reason and built.focus_distance == START.focus_distance


@pytest.mark.parametrize("change", [
    {"lens": "lib-miyamoto-fisheye-1964", "f_number": None, "focus_distance": 80.0},
    {"lens": "olympus-zuiko-9-36-f2", "f_number": 200.0},
    {"lens": "nikon-af-s-dx-vr-zoom-nikkor-g-if-ed-18-200-f35", "medium": "water", "immersed": True, "zoom": 1.0,
     "f_number": None, "focus_distance": 260.0}])
def test_a_focus_on_what_touches_the_lens_leaves_the_other_figures(change):
    got = readings(replace(Settings(), **change))
    assert got.efl and got.nearest_focus and got.hyperfocal and got.limit
