"""The spaces between object and raster, both routes to a camera ray, fields of view and formats."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.coordinate_spaces import transform_points
from lensbench.core.imaging.film import AXES

WIDE, TALL = lb.Film(36.0, 24.0, 960, 640), lb.Film(24.0, 36.0, 640, 960)
ODD = lb.Film(20.0, 30.0, 300, 600)                     # pixels that are not square
WORLD = lb.look_at((100.0, 200.0, 300.0), (0.0, 10.0, -500.0))
PROJECTIVE = {
    "perspective": lb.PerspectiveCamera(WIDE, fov=0.9, world_from_camera=WORLD),
    "portrait, along the diagonal": lb.PerspectiveCamera(TALL, fov=1.3, fov_axis="diagonal"),
    "odd pixels and window": lb.PerspectiveCamera(ODD, fov=0.5, window=(-0.2, 0.9, -1.7, 0.3), world_from_camera=WORLD),
    "orthographic": lb.OrthographicCamera(ODD, 700.0, world_from_camera=WORLD),
    "orthographic window": lb.OrthographicCamera(WIDE, 700.0, window=(0.1, 2.0, -0.5, 0.6)),
    "thick lens": lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), WIDE, 900.0, model="thick", world_from_camera=WORLD),
    "pinhole of a lens": lb.LensCamera(lenses.load("pbrt-wide-22mm"), WIDE, 900.0, model="pinhole"),
}


def raster_points(film: lb.Film, n: int = 400) -> np.ndarray:
    """Random raster points."""
    return np.random.default_rng(0).random((n, 2)) * [film.pixels_x, film.pixels_y]


def middle_rays(camera: lb.Camera, raster: np.ndarray) -> lb.Rays:
    """Rays through the middle of the pupil."""
    return camera.generate_rays(raster, np.tile(camera.pupil_centre, (len(raster), 1)))


# Transforms


@pytest.mark.parametrize("name", PROJECTIVE)
def test_projective_rays_are_those_of_the_inverse_matrix(name):
    """From the near plane to the far plane of the raster, by the 4 × 4 matrix alone."""
    camera = PROJECTIVE[name]
    spaces = camera.spaces(5.0, 1e4)
    raster = raster_points(camera.film)
    near, far = (transform_points(spaces.world_from_raster, np.column_stack([raster, np.full(len(raster), z)]))
                 for z in (0.0, 1.0))
    way = (far - near) / np.linalg.norm(far - near, axis=1)[:, None]
    rays = middle_rays(camera, raster)
    np.testing.assert_allclose(rays.directions, way, atol=1e-12)            # the far plane comes by 1 − z: 1e4 / 5 ulps
    beside = np.cross(near - rays.origins, rays.directions)
    assert np.abs(beside).max() < 1e-10
    depth = np.linalg.inv(camera.placement()) @ np.column_stack([near, np.ones(len(near))]).T
    np.testing.assert_allclose(depth[2], spaces.eye - 5.0, atol=1e-10)


@pytest.mark.parametrize("name", PROJECTIVE)
def test_each_transform_is_undone_by_its_namesake(name):
    spaces = PROJECTIVE[name].spaces(3.0, 700.0)
    for there, back in (("raster_from_ndc", "ndc_from_raster"), ("ndc_from_screen", "screen_from_ndc"),
                        ("screen_from_camera", "camera_from_screen"), ("raster_from_screen", "screen_from_raster"),
                        ("raster_from_camera", "camera_from_raster"), ("raster_from_world", "world_from_raster"),
                        ("camera_from_world", "world_from_camera")):
        product = getattr(spaces, there) @ getattr(spaces, back)
        product = product / product[3, 3]
        np.testing.assert_allclose(product, np.eye(4), atol=1e-9 * max(1.0, np.abs(product).max()), err_msg=there)


@pytest.mark.parametrize("name", PROJECTIVE)
def test_the_matrix_of_a_point_is_the_way_back_of_the_camera(name):
    camera = PROJECTIVE[name]
    rays = middle_rays(camera, raster_points(camera.film))
    points = rays.origins + rays.directions * np.random.default_rng(1).uniform(100.0, 900.0, (400, 1))
    by_matrix = transform_points(camera.spaces(1.0, 1e5).raster_from_world, points)
    np.testing.assert_allclose(by_matrix[:, :2], camera.raster_from_point(points)[0], atol=1e-9)
    assert ((by_matrix[:, 2] > 0.0) & (by_matrix[:, 2] < 1.0)).all()


@pytest.mark.parametrize("film", [WIDE, TALL, lb.Film(24.0, 24.0, 777, 777)])
@pytest.mark.parametrize("fov", [0.1, 0.8, 2.6])
def test_both_routes_to_a_camera_ray_agree_in_portrait_as_well(film, fov):
    """Raster → NDC → screen → camera, and (x − w/2, h/2 − y, −min(w, h) / (2 tan(fov/2))): 1e-15."""
    camera = lb.PerspectiveCamera(film, fov=fov)
    w, h = film.pixels_x, film.pixels_y
    raster = np.floor(raster_points(film)) + 0.5                            # pixel centres
    direct = np.column_stack([raster[:, 0] - w / 2, h / 2 - raster[:, 1],
                              np.full(len(raster), -min(w, h) / (2.0 * math.tan(fov / 2.0)))])
    spaces = camera.spaces(1.0, math.inf)
    normalised = transform_points(spaces.camera_from_raster, np.column_stack([raster, np.zeros(len(raster))]))
    routes = [direct, normalised, middle_rays(camera, raster).directions]
    a, b, c = (route / np.linalg.norm(route, axis=1)[:, None] for route in routes)
    assert max(np.abs(a - b).max(), np.abs(a - c).max()) <= 1e-15


def test_pixel_centres_and_the_turn_of_y_are_where_the_spaces_say():
    spaces = lb.PerspectiveCamera(ODD).spaces()
    corners = transform_points(spaces.screen_from_raster, [[0, 0, 0], [300, 600, 0], [0.5, 0.5, 0]])
    np.testing.assert_allclose(corners[:2, :2], [[-1.0, 1.5], [1.0, -1.5]], atol=1e-15)
    np.testing.assert_allclose(corners[2, :2], [-1.0 + 1.0 / 300, 1.5 - 1.5 / 600], atol=1e-15)
    np.testing.assert_allclose(transform_points(spaces.ndc_from_raster, [0.5, 0.5, 0.0])[:2], [0.5 / 300, 0.5 / 600])
    np.testing.assert_allclose(transform_points(spaces.screen_from_ndc, [0.0, 0.0, 0.0])[:2], [-1.0, 1.5])


def test_a_window_is_a_part_of_the_whole_picture():
    """The left upper quarter, sampled twice as finely, and the shift of a view camera."""
    whole = lb.PerspectiveCamera(WIDE, fov=0.9)
    part = lb.PerspectiveCamera(WIDE, fov=0.9, window=(-1.5, 0.0, 0.0, 1.0))
    raster = raster_points(WIDE)
    np.testing.assert_allclose(middle_rays(part, raster).directions, middle_rays(whole, raster / 2.0).directions,
                               atol=1e-15)
    rise = lb.PerspectiveCamera(WIDE, fov=0.9, window=(-1.5, 1.5, -0.6, 1.4))
    points = middle_rays(whole, raster)
    seen = rise.raster_from_point(points.origins + 500.0 * points.directions)[0]
    np.testing.assert_allclose(seen, raster + [0.0, 0.4 * 320.0], atol=1e-9)       # verticals stay vertical
    assert part.image_plane_area == pytest.approx(whole.image_plane_area / 4.0)


@pytest.mark.parametrize("far", [2000.0, math.inf])
def test_near_becomes_0_and_far_becomes_1(far):
    spaces = lb.PerspectiveCamera(WIDE).spaces(20.0, far)
    points = [[1.0, 2.0, -20.0], [3.0, 4.0, -min(far, 1e17)], [0.0, 0.0, -40.0]]
    z = transform_points(spaces.screen_from_camera, points)[:, 2]
    np.testing.assert_allclose(z[:2], [0.0, 1.0], atol=1e-15)
    assert z[2] == pytest.approx(0.5 / (1.0 - 20.0 / far))
    level = lb.OrthographicCamera(WIDE, 100.0).spaces(-50.0, 150.0)
    on_screen = transform_points(level.screen_from_camera, [[0, 0, 50], [0, 0, -50], [0, 0, -150]])
    np.testing.assert_allclose(on_screen[:, 2], [0.0, 0.5, 1.0], atol=1e-15)


def test_the_image_plane_at_1_is_as_large_as_its_corners_say():
    for camera in (PROJECTIVE["portrait, along the diagonal"], PROJECTIVE["odd pixels and window"]):
        corners = np.array([[0.0, 0.0], [camera.film.pixels_x, camera.film.pixels_y]])
        rays = middle_rays(replace(camera, world_from_camera=np.eye(4)), corners)
        x, y = (rays.directions[:, :2] / -rays.directions[:, 2:]).T
        assert camera.image_plane_area == pytest.approx((x[1] - x[0]) * (y[0] - y[1]), rel=1e-13)


# Depth


@settings(max_examples=60)
@given(st.floats(0.01, 10.0), st.floats(20.0, 1e6), st.floats(0.001, 0.999))
def test_a_depth_buffer_tells_steps_of_its_resolution_and_no_smaller(near, far, part):
    """Of the depths that a float32 z can hold: by how much the two beside a stored one differ."""
    depth = near + part**2 * (far - near)
    z = np.float32(far / (far - near) * (1.0 - near / depth))
    if not 1e-3 < z < 1.0 - 1e-6:
        return
    beside = np.array([np.nextafter(z, np.float32(0.0)), np.nextafter(z, np.float32(2.0))], float)
    depths = near / (1.0 - beside * (1.0 - near / far))
    step = lb.depth_resolution(depth, near, far)
    if np.diff(np.log2(beside))[0] and depths[1] > 0.0 and step < 0.05 * depth:     # no power of 2 between, near linear
        assert 0.5 * (depths[1] - depths[0]) == pytest.approx(step, rel=0.6)


def test_the_depth_of_far_things_is_lost_with_a_near_plane_that_is_too_near():
    """Near 0.01, far 1000: off by 1 to 3 at 800 in float32, as everybody finds out once."""
    assert 2.0 < lb.depth_resolution(800.0, 0.01, 1000.0) < 6.0             # of which a value is off by up to a half
    z = np.float32(1000.0 / (1000.0 - 0.01) * (1.0 - 0.01 / np.linspace(790.0, 810.0, 200001)))
    steps = 20.0 / (len(np.unique(z)) - 1)
    assert lb.depth_resolution(800.0, 0.01, 1000.0) == pytest.approx(steps, rel=0.2)
    assert lb.depth_resolution(800.0, 0.01, 1000.0, np.float64) < 1e-8
    assert lb.depth_resolution(np.array([10.0, 800.0]), 1.0, math.inf).shape == (2,)


def test_the_step_in_depth_between_planes_that_are_near_each_other():
    """z = 2 (1 − 100 / d) between 100 and 200 mm: 2/3 at 150 mm, where its slope is 200 / d²."""
    step = np.spacing(np.float32(2.0 / 3.0)) * 150.0**2 / 200.0
    assert lb.depth_resolution(150.0, 100.0, 200.0) == pytest.approx(step, rel=1e-12)


# Fields of view and formats


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("film", [WIDE, TALL, ODD])
def test_the_field_of_view_lies_along_the_side_that_it_is_told_for(film, axis):
    camera = lb.PerspectiveCamera(film, fov=1.1, fov_axis=axis)
    w, h = film.pixels_x, film.pixels_y
    side = {"shorter": "horizontal" if film.width < film.height else "vertical",
            "longer": "vertical" if film.width < film.height else "horizontal"}.get(axis, axis)
    edge = {"horizontal": [w, h / 2], "vertical": [w / 2, 0], "diagonal": [0, 0]}[side]
    direction = middle_rays(camera, np.array([edge])).directions[0]
    assert 2.0 * math.atan2(math.hypot(*direction[:2]), -direction[2]) == pytest.approx(1.1, abs=1e-14)
    f = lb.focal_length(1.1, film, axis)
    assert f == pytest.approx(camera.film_distance, rel=1e-14)
    assert lb.field_of_view(f, film, axis) == pytest.approx(1.1, abs=1e-14)
    assert lb.film_extent(1.1, f) == pytest.approx(film.extent(axis), rel=1e-14)


def test_the_engraved_figures_of_photography():
    """50 mm on 36 × 24: 46.8° across the diagonal, 39.6° × 27.0°; APS-C's 1.53 and Micro Four Thirds' 2.0."""
    angles = [math.degrees(lb.field_of_view(50.0, WIDE, axis)) for axis in ("diagonal", "horizontal", "vertical")]
    assert angles == pytest.approx([46.8, 39.6, 27.0], abs=0.05)
    aps, mft = (lb.Film(*lb.FORMATS[name]) for name in ("APS-C 23.5 × 15.6", "Micro Four Thirds 17.3 × 13"))
    assert lb.equivalent(35.0, aps, 1.8) == pytest.approx((1.534, 53.687, 2.761, 2.353), abs=1e-3)
    assert lb.equivalent(25.0, mft, 1.4)[:3] == pytest.approx((2.0, 50.0, 2.8), rel=1e-3)
    back = lb.equivalent(53.69, WIDE, 2.761, to=aps)
    assert back.focal_length == pytest.approx(35.0, abs=0.01) and back.f_number == pytest.approx(1.8, abs=1e-3)


@given(st.floats(5.0, 200.0), st.floats(1.0, 22.0), st.floats(4.0, 80.0))
@settings(max_examples=40)
def test_equivalent_lenses_see_the_same_field_with_the_same_depth_and_blur(f, n, width):
    film = lb.Film(width, width / 1.5)
    same = lb.equivalent(f, film, n)
    assert lb.field_of_view(same.focal_length, WIDE) == pytest.approx(lb.field_of_view(f, film), rel=1e-12)
    assert same.focal_length / same.f_number == pytest.approx(f / n)                    # as wide an aperture
    limit = film.diagonal / 1500.0
    here, there = (lb.hyperfocal(g, k, c) - g for g, k, c in (
        (f, n, limit), (same.focal_length, same.f_number, same.crop * limit)))
    assert here == pytest.approx(there, rel=1e-12)
    blur, other = (lb.circle_of_confusion(g, k, 4000.0 + g, math.inf) for g, k in (
        (f, n), (same.focal_length, same.f_number)))
    assert blur / film.diagonal == pytest.approx(other / WIDE.diagonal, rel=1e-12)


@pytest.mark.parametrize("name", PROJECTIVE)
def test_intrinsics_project_as_the_camera_does(name):
    camera = PROJECTIVE[name]
    fx, fy, cx, cy = camera.intrinsics
    rays = middle_rays(camera, raster_points(camera.film))
    points = transform_points(np.linalg.inv(camera.placement()), rays.origins + 700.0 * rays.directions)
    x, y, z = points[:, 0], -points[:, 1], camera.spaces(1.0, 10.0).eye - points[:, 2]     # y down, z ahead of the eye
    if isinstance(camera, lb.OrthographicCamera):
        z = np.ones(len(z))
    raster = raster_points(camera.film)
    np.testing.assert_allclose(np.column_stack([fx * x / z + cx, fy * y / z + cy]), raster, atol=1e-9)
    np.testing.assert_allclose(camera.intrinsics.matrix @ [x[0] / z[0], y[0] / z[0], 1.0], [*raster[0], 1.0], atol=1e-9)


def test_square_pixels_have_one_focal_length_which_is_in_pixels():
    assert PROJECTIVE["perspective"].intrinsics == pytest.approx((320 / math.tan(0.45),) * 2 + (480, 320))
    traced = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), WIDE)
    assert traced.intrinsics.fx == pytest.approx(traced.first_order.efl * 960 / 36.0)


# The point under the mouse


@pytest.mark.parametrize("camera", [
    *PROJECTIVE.values(), lb.EnvironmentCamera(WIDE, world_from_camera=WORLD), lb.FisheyeCamera(WIDE),
    lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), WIDE, 900.0)])
def test_the_point_under_the_mouse_is_one_point_in_every_space(camera):
    raster = raster_points(camera.film, 60)
    turn = lb.look_at((5.0, 6.0, 7.0), (1.0, 2.0, 3.0))
    places = camera.places(raster, np.linspace(300.0, 900.0, 60), object_from_world=turn)
    seen = np.isfinite(places.world[:, 0])
    assert seen.mean() > 0.3
    back, _ = camera.raster_from_point(places.world[seen])
    np.testing.assert_allclose(back, raster[seen], atol=1e-9)
    np.testing.assert_allclose(transform_points(camera.placement(), places.camera[seen]), places.world[seen], atol=1e-9)
    np.testing.assert_allclose(transform_points(np.linalg.inv(turn), places.object[seen]), places.world[seen],
                               atol=1e-9)
    np.testing.assert_allclose(places.ndc * [camera.film.pixels_x, camera.film.pixels_y], raster, atol=1e-12)
    if not isinstance(camera, (lb.EnvironmentCamera, lb.FisheyeCamera)):
        spaces = camera.spaces(1.0, 1e4)
        on_screen = transform_points(spaces.screen_from_raster, np.column_stack([raster, np.zeros(60)]))[:, :2]
        np.testing.assert_allclose(places.screen, on_screen, atol=1e-13)
    assert (places.film[:, 2] == 0.0).all()


# What cannot be


@pytest.mark.parametrize(("make", "says"), [
    (lambda: PROJECTIVE["perspective"].spaces(0.0, 10.0), "more than 0"),
    (lambda: PROJECTIVE["perspective"].spaces(20.0, 10.0), "nearer"),
    (lambda: PROJECTIVE["orthographic"].spaces(1.0), "finite distance"),
    (lambda: lb.depth_resolution(5.0, 10.0, 100.0), "between them"),
    (lambda: lb.depth_resolution(5.0, 0.0, 100.0), "positive"),
    (lambda: lb.focal_length(math.pi, WIDE), "between 0° and 180°"),
    (lambda: lb.focal_length(1.0, WIDE, "sideways"), "diagonal"),
    (lambda: lb.field_of_view(0.0, WIDE), "focal length"),
    (lambda: lb.film_extent(0.0, 50.0), "between 0° and 180°"),
    (lambda: lb.equivalent(50.0, WIDE, -1.0), "f-number"),
    (lambda: lb.equivalent(math.inf, WIDE), "focal length"),
])
def test_what_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
