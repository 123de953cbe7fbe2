"""Parallel, panoramic, fisheye and thick-lens cameras: each by its law, and projection onto the film."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.fisheye import PROJECTIONS
from lensbench.core.cameras.without_lens import LAYOUTS
from lensbench.core.imaging.transform import transform_steps
from lensbench.core.optics.glass import D_LINE
from tests.core.oracles import biconvex

FILM = lb.Film(36.0, 24.0, 960, 640)
TALL = lb.Film(20.0, 30.0, 300, 600)                    # pixels that are not square
UNIT = st.floats(0.0, 1.0, exclude_max=True)
WORLD = lb.look_at((100.0, 200.0, 300.0), (0.0, 10.0, -500.0), up=(0.1, 1.0, 0.0))
CAMERAS = {
    "perspective": lb.PerspectiveCamera(FILM, fov=1.1, world_from_camera=WORLD),
    "perspective, lens": lb.PerspectiveCamera(TALL, lens_radius=8.0, focus_distance=900.0, world_from_camera=WORLD),
    "perspective, window": lb.PerspectiveCamera(FILM, fov_axis="diagonal", window=(-0.2, 1.4, -1.0, 0.5)),
    "orthographic": lb.OrthographicCamera(FILM, 2000.0, world_from_camera=WORLD),
    "orthographic, lens": lb.OrthographicCamera(TALL, 2000.0, 60.0, 1500.0, world_from_camera=WORLD),
    **{layout: lb.EnvironmentCamera(TALL, layout, world_from_camera=WORLD) for layout in LAYOUTS},
    **{f"{projection} fisheye": lb.FisheyeCamera(FILM, fov, projection, axis, world_from_camera=WORLD)
       for projection, fov, axis in (("equidistant", 6.2, "diagonal"), ("equisolid", 6.2, "shorter"),
                                     ("stereographic", 5.0, "longer"), ("orthographic", math.pi, "vertical"))},
    **{model: lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1500.0, 2.8, model=model, world_from_camera=WORLD)
       for model in ("thick", "thin", "pinhole")},
}


def samples(film: lb.Film, n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Random raster points and places in the pupil."""
    rng = np.random.default_rng(seed)
    return rng.random((n, 2)) * [film.pixels_x, film.pixels_y], rng.random((n, 2))


def film_point(film: lb.Film, raster) -> np.ndarray:
    """The rule of the design page, written out."""
    return np.column_stack([(0.5 - raster[:, 0] / film.pixels_x) * film.width,
                            (raster[:, 1] / film.pixels_y - 0.5) * film.height])


# The way back


@pytest.mark.parametrize("name", CAMERAS)
def test_a_point_on_a_ray_leads_back_to_the_raster_point_of_the_ray(name):
    camera = CAMERAS[name]
    raster, uv = samples(camera.film, 3000)
    rays = camera.generate_rays(raster, uv)
    far = np.random.default_rng(1).uniform(50.0, 8000.0, (3000, 1))
    back, visible = camera.raster_from_point(rays.origins + far * rays.directions, uv)
    lit = rays.weights > 0.0
    assert lit.mean() > 0.3 and visible[lit].all()
    np.testing.assert_allclose(back[lit], raster[lit], rtol=0.0, atol=1e-9)     # 1e-9 of a pixel


@pytest.mark.parametrize("name", CAMERAS)
def test_projection_uses_the_centre_of_the_pupil_by_default(name):
    camera = CAMERAS[name]
    raster, _ = samples(camera.film, 100)
    middle = np.tile(camera.pupil_centre, (100, 1))
    rays = camera.generate_rays(raster, middle)
    points = (rays.origins + 900.0 * rays.directions)[rays.weights > 0.0]
    np.testing.assert_array_equal(camera.raster_from_point(points)[0],
                                  camera.raster_from_point(points, middle[:len(points)])[0])


@pytest.mark.parametrize("direction", ["down", "up", "left", "right"])
@pytest.mark.parametrize("readout", [0.0, 0.03])
def test_projection_places_the_camera_at_the_time_of_the_open_row(direction, readout):
    """A camera that turns by 40° and moves by 300 mm while its lines open one after the other."""
    start, end = (lb.look_at(eye, target) for eye, target in (((0, 0, 0), (0, 0, -1)), ((300, 40, 0), (300, 0, -1))))
    turn = lb.look_at((0, 0, 0), (0.6, 0.2, -1))
    way = lb.AnimatedTransform(start, end @ turn, 0.0, 0.05)
    for plain in (CAMERAS["perspective, lens"], CAMERAS["equirectangular"], CAMERAS["orthographic"]):
        camera = replace(plain, world_from_camera=way, shutter_close=0.02, shutter_ramp=0.004, readout=readout,
                         readout_direction=direction)
        raster, uv = samples(camera.film, 300)
        time = np.random.default_rng(4).random(300)
        rays = camera.generate_rays(raster, uv, time)
        points = rays.origins + 900.0 * rays.directions
        back, visible = camera.raster_from_point(points, uv, time)
        same = (np.abs(back - raster) <= 1e-9).all(1)
        assert same.mean() > 0.9 and (same.all() or readout > 0.0)      # lines that follow a point see it twice,
        assert visible.mean() > 0.9                                     # and a panorama may lose it at its seam
        again = camera.generate_rays(back[visible], uv[visible], time[visible])
        off = np.cross(again.directions, points[visible] - again.origins)
        assert np.abs(off).max() < 1e-9


def test_what_lies_behind_the_camera_or_beside_the_film_is_not_visible():
    camera = lb.PerspectiveCamera(FILM, fov=0.8)
    half = math.tan(0.4)
    points = np.array([[0, 0, -1000], [0, 0, 1000], [0, 0.999e3 * half, -1e3], [0, 1.001e3 * half, -1e3],
                       [1.499e3 * half, 0, -1e3], [-1.501e3 * half, 0, -1e3]])
    assert camera.raster_from_point(points)[1].tolist() == [True, False, True, False, True, False]
    circle = lb.FisheyeCamera(FILM, math.pi)
    assert circle.raster_from_point([[0, 0, -1], [0, 1, -1e-6], [0, 1, 1e-6]])[1].tolist() == [True, True, False]
    seen = lb.EnvironmentCamera(FILM).raster_from_point([[0, 0, 1], [0, 1, 0], [3, -2, 5], [0, 0, 0]])[1]
    assert seen.tolist() == [True, True, True, False]
    for bad in ([[0.0, math.nan, 1.0]], [[1.0, 2.0]]):
        with pytest.raises(ValueError, match="finite"):
            camera.raster_from_point(bad)
    with pytest.raises(ValueError, match="unit square"):
        camera.raster_from_point(points, [[1.5, 0.0]] * 6)


# Parallel rays


def test_all_rays_of_an_orthographic_camera_are_parallel_and_things_keep_their_size():
    camera = lb.OrthographicCamera(TALL, 800.0)
    raster, uv = samples(TALL, 500)
    rays = camera.generate_rays(raster, uv)
    np.testing.assert_array_equal(rays.directions, np.tile([0.0, 0.0, -1.0], (500, 1)))
    np.testing.assert_allclose(rays.origins[:, :2], -film_point(TALL, raster) * 800.0 / 20.0, atol=1e-12)
    assert (rays.weights == 1.0).all()
    corners = camera.generate_rays([[0.0, 0.0], [300.0, 600.0]], [[0.5, 0.5]] * 2).origins
    np.testing.assert_allclose(corners[1] - corners[0], [800.0, -1200.0, 0.0], atol=1e-12)


def test_what_lies_in_the_plane_where_parallel_rays_begin_is_not_in_front():
    lens = lb.OrthographicCamera(FILM, 900.0, 20.0, 1500.0).gaussian
    points = np.array([[30.0, 40.0, 1e-6], [30.0, 40.0, 0.0], [30.0, 40.0, -1e-6]])
    film, ahead = lens.film_points(points, np.full((3, 2), 0.5))
    assert ahead.tolist() == [False, False, True]
    np.testing.assert_allclose(film[1], film[2], atol=1e-6)


@settings(max_examples=30)
@given(st.floats(10.0, 5000.0), st.floats(1.0, 100.0), UNIT, UNIT, UNIT, UNIT)
def test_a_telecentric_cone_has_its_point_on_the_plane_in_focus(focus, radius, x, y, u, v):
    plain, lens = (lb.OrthographicCamera(FILM, 900.0, r, focus) for r in (0.0, radius))
    place = [[x * 960.0, y * 640.0]]
    a, b = plain.generate_rays(place, [[u, v]]), lens.generate_rays(place, [[u, v]])
    met = b.origins - b.directions * focus / b.directions[:, 2:]
    np.testing.assert_allclose(met[0, :2], a.origins[0, :2], atol=1e-10)
    assert math.hypot(*(b.origins - a.origins)[0, :2]) <= radius * (1.0 + 1e-7)
    assert lens.generate_rays(place, [[0.5, 0.5]]).directions[0, 2] == -1.0


def test_a_telecentric_lens_gathers_pi_sin2_of_its_cone_scaled_to_the_film():
    camera = lb.OrthographicCamera(FILM, 72.0, 30.0, 100.0, weights="physical", shutter_close=0.01)
    n = 1 << 14
    uv = np.column_stack([(np.arange(n) + 0.5) / n, np.arange(n) * 0.6180339887498949 % 1.0])
    for place in ([480.0, 320.0], [10.0, 630.0]):
        mean = camera.generate_rays(np.tile(place, (n, 1)), uv).weights.mean()
        assert mean == pytest.approx(math.pi * 900.0 / 10900.0 * 4.0 * 0.01, rel=1e-4)      # lattice of 16384
        mean = replace(camera, weights="relative").generate_rays(np.tile(place, (n, 1)), uv).weights.mean()
        assert mean == pytest.approx(1.0, rel=1e-4)


def test_the_lens_is_filled_as_rejection_from_a_square_fills_it():
    """Moments of the radius and of the direction: each within 5 sigma of 100,000 rejected samples."""
    rng = np.random.default_rng(3)
    n = 100_000
    square = rng.uniform(-1.0, 1.0, (2 * n, 2))
    twin = square[(square**2).sum(1) < 1.0][:n]
    for camera in (lb.PerspectiveCamera(FILM, lens_radius=1.0), lb.OrthographicCamera(FILM, 36.0, 1.0, 50.0)):
        disk = camera.generate_rays(np.tile([480.0, 320.0], (n, 1)), rng.random((n, 2))).origins[:, :2]
        assert np.hypot(*disk.T).max() <= 1.0 + 1e-7
        for power in ((2, 0), (0, 2), (1, 1), (4, 0), (2, 2), (1, 3), (6, 2)):
            a, b = (points[:, 0]**power[0] * points[:, 1]**power[1] for points in (disk, twin))
            assert abs(a.mean() - b.mean()) < 5.0 * math.sqrt((a.var() + b.var()) / n)


# Panoramas


def test_an_equirectangular_panorama_runs_down_theta_and_across_phi():
    raster, uv = samples(TALL, 400)
    d = lb.EnvironmentCamera(TALL).generate_rays(raster, uv).directions
    theta, phi = math.pi * raster[:, 1] / 600.0, 2.0 * math.pi * raster[:, 0] / 300.0 - math.pi
    expected = np.column_stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)])
    np.testing.assert_allclose(d, expected, atol=3e-15)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_directions_of_a_panorama_fill_the_sphere_evenly_by_their_solid_angles(layout):
    """χ² over 288 cells of equal solid angle; the weights by dω / dA, from the direction alone."""
    n = 200_000
    rays = lb.EnvironmentCamera(FILM, layout).generate_rays(*samples(FILM, n, 5))
    x, y, z = rays.directions.T
    density = {"equirectangular": np.hypot(x, z), "equal-area": np.ones(n),
               "cube-map": np.abs(rays.directions).max(1) ** 3}[layout] * rays.weights
    across = np.minimum((np.arctan2(x, -z) / math.pi + 1.0) * 12.0, 23).astype(int)
    cell = np.minimum((y + 1.0) * 6.0, 11).astype(int) * 24 + across
    total, square = (np.bincount(cell, density**k, 288) for k in (1, 2))
    share = total.sum() / 288
    chi2 = ((total - share) ** 2 / np.maximum(square, 1e-30)).sum()
    assert chi2 < 288 + 5.0 * math.sqrt(2.0 * 288)
    assert (rays.weights[:10000] == 1.0).all() if layout != "cube-map" else abs(rays.weights.mean() - 0.5) < 0.01


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_panorama_is_upright_with_right_on_the_right(layout):
    camera = lb.EnvironmentCamera(lb.Film(40.0, 30.0, 400, 300), layout)
    ahead = camera.raster_from_point([[0.0, 0.0, -1.0]])[0][0]
    points, _ = camera.raster_from_point([[0.1, 0.0, -1.0], [0.0, 0.1, -1.0]])
    assert points[0, 0] > ahead[0] and points[0, 1] == pytest.approx(ahead[1])
    assert points[1, 1] < ahead[1] and points[1, 0] == pytest.approx(ahead[0])
    if layout != "cube-map":
        np.testing.assert_allclose(ahead, [200.0, 150.0])
        return
    faces = camera.raster_from_point(np.array([[-1, 0, 0], [0, 0, -1], [1, 0, 0], [0, 0, 1], [0, 1, 0], [0, -1, 0]]))[0]
    np.testing.assert_allclose(faces, [[50, 150], [150, 150], [250, 150], [350, 150], [150, 50], [150, 250]])
    rays = camera.generate_rays([[50, 50], [350, 250], [150, 99.999], [150, 100.001]], [[0.5, 0.5]] * 4)
    assert rays.weights.tolist() == [0.0, 0.0, 1.0, 1.0]
    np.testing.assert_allclose(rays.directions[2], rays.directions[3], atol=1e-4)   # faces join at their edges


# Fisheyes


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_an_ideal_fisheye_draws_an_angle_at_its_height(projection):
    fov = math.pi if projection == "orthographic" else 3.8
    camera = lb.FisheyeCamera(FILM, fov, projection)
    raster, uv = samples(FILM, 2000)
    rays = camera.generate_rays(raster, uv)
    x, y = film_point(FILM, raster).T
    r, d = np.hypot(x, y), rays.directions
    np.testing.assert_array_equal(rays.weights, (r <= 12.0).astype(float))
    lit = r <= 12.0
    theta, f = np.arctan2(np.hypot(d[:, 0], d[:, 1]), -d[:, 2])[lit], camera.focal_length
    law = {"equidistant": theta, "equisolid": 2.0 * np.sin(theta / 2.0), "stereographic": 2.0 * np.tan(theta / 2.0),
           "orthographic": np.sin(theta)}[projection]
    np.testing.assert_allclose(f * law, r[lit], atol=1e-11)
    np.testing.assert_allclose(d[lit, 0] * y[lit], d[lit, 1] * x[lit], atol=1e-13)      # the azimuth is kept
    assert (d[lit, 0] * x[lit] <= 0.0).all()
    edge = camera.generate_rays([[480.0, 1e-9]], [[0.5, 0.5]]).directions[0]
    assert math.acos(-edge[2]) == pytest.approx(fov / 2.0, abs=1e-5)


def test_a_full_fisheye_lights_every_corner():
    for projection in PROJECTIONS:
        camera = lb.FisheyeCamera(FILM, 2.9, projection, "diagonal")
        rays = camera.generate_rays([[1e-9, 1e-9], [960 - 1e-9, 640 - 1e-9]], [[0.5, 0.5]] * 2)
        assert (rays.weights == 1.0).all()
        assert np.arccos(-rays.directions[:, 2]) == pytest.approx(1.45, abs=1e-6)


# Where a camera stands


@settings(max_examples=40)
@given(*[st.tuples(*[st.floats(-1e3, 1e3)] * 3)] * 2, st.tuples(*[st.floats(-1.0, 1.0)] * 3))
def test_look_at_puts_the_target_in_the_middle_and_up_upright(eye, target, up):
    view, length = np.subtract(target, eye), np.linalg.norm(up)
    far = np.linalg.norm(view)
    if far < 1e-3 or length < 1e-3 or np.linalg.norm(np.cross(view / far, up)) < 1e-3 * length:
        return
    m = lb.look_at(eye, target, up)
    np.testing.assert_allclose(m[:3, :3].T @ m[:3, :3], np.eye(3), atol=1e-12)
    assert np.linalg.det(m) == pytest.approx(1.0, abs=1e-12)
    camera = lb.PerspectiveCamera(FILM, world_from_camera=m)
    seen, visible = camera.raster_from_point([target])
    assert visible[0]
    np.testing.assert_allclose(seen[0], [480.0, 320.0], atol=1e-6)
    higher = camera.raster_from_point([np.asarray(target) + 1e-3 * far * np.asarray(up) / length])[0][0]
    assert higher[0] == pytest.approx(480.0, abs=1e-5) and higher[1] < 320.0


@pytest.mark.parametrize("length", [1e-150, 1e-6, 1e6, 1e150])
def test_look_at_takes_an_up_direction_of_any_length(length):
    np.testing.assert_allclose(lb.look_at((1.0, 2.0, 3.0), (40.0, 5.0, -60.0), length * np.array([0.3, 0.9, 0.1])),
                               lb.look_at((1.0, 2.0, 3.0), (40.0, 5.0, -60.0), (0.3, 0.9, 0.1)), rtol=1e-12, atol=1e-12)
    with pytest.raises(lb.TransformError, match="along its up direction"):
        lb.look_at((0.0, 0.0, 0.0), (0.1, 0.7, -0.3), length * np.array([-0.1, -0.7, 0.3]))


# What cannot be


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.look_at((1, 2, 3), (1, 2, 3)), "are the same point"),
    (lambda: lb.look_at((0, 0, 0), (0, 5, 0)), "along its up direction"),
    (lambda: lb.look_at((0, 0, 0), (0, 0, -1), (0, 0, 0)), "up direction is zero"),
    (lambda: lb.look_at((0, 0, math.nan), (0, 0, -1)), "finite"),
    (lambda: lb.look_at((0, 0), (0, 0, -1)), "three points"),
    (lambda: lb.OrthographicCamera(FILM, 0.0), "positive number"),
    (lambda: lb.OrthographicCamera(FILM, math.nan), "positive number"),
    (lambda: lb.OrthographicCamera(FILM, 100.0, -1.0), "lens radius"),
    (lambda: lb.OrthographicCamera(FILM, 100.0, 1.0, 0.0), "focus distance"),
    (lambda: lb.OrthographicCamera(FILM, 100.0, weights="physical"), "parallel rays"),
    (lambda: lb.OrthographicCamera(FILM, 100.0, window=(0, 0, -1, 1)), "left < right"),
    (lambda: lb.PerspectiveCamera(FILM, fov=3.2), "between 0° and 180°"),
    (lambda: lb.PerspectiveCamera(FILM, fov_axis="widest"), "diagonal"),
    (lambda: lb.PerspectiveCamera(FILM, window=(-1, 1, math.nan, 1)), "bottom < top"),
    (lambda: lb.EnvironmentCamera(FILM, "mercator"), "cube-map"),
    (lambda: lb.EnvironmentCamera(FILM, weights="physical"), "no area"),
    (lambda: lb.FisheyeCamera(FILM, 0.0), "0° and 360°"),
    (lambda: lb.FisheyeCamera(FILM, 2.0 * math.pi, "equisolid"), "0° and 360°"),
    (lambda: lb.FisheyeCamera(FILM, 3.2, "orthographic"), "180°"),
    (lambda: lb.FisheyeCamera(FILM, math.nan, "orthographic"), "180°"),
    (lambda: lb.FisheyeCamera(FILM, 1.0, "cylindric"), "stereographic"),
    (lambda: lb.FisheyeCamera(FILM, 1.0, fov_axis="up"), "diagonal"),
    (lambda: lb.FisheyeCamera(FILM, 1.0, weights="physical"), "no area"),
    (lambda: lb.EnvironmentCamera(FILM).intrinsics, "not projective"),
    (lambda: lb.FisheyeCamera(FILM).spaces(), "not projective"),
    (lambda: lb.LensCamera(biconvex(), FILM, model="magic"), "thick"),
])
def test_invalid_settings_are_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)


@dataclass(frozen=True, eq=False)
class Periscope(lb.Camera):
    """A camera kind of its own: a pinhole 50 mm above the camera's origin, given by its steps alone."""

    film: lb.Film

    def camera_steps(self, wavelength=D_LINE):
        above = np.eye(4)
        above[1, 3] = 50.0
        return [*lb.PerspectiveCamera(self.film).camera_steps(wavelength), *transform_steps(above)]


def test_a_new_camera_kind_needs_its_own_class_alone():
    """It renders, shows views, projects and has differentials, as the equivalent perspective camera does."""
    film = lb.Film(36.0, 24.0, 24, 16)
    periscope = Periscope(film, world_from_camera=WORLD)
    above = np.eye(4)
    above[1, 3] = 50.0
    pinhole = lb.PerspectiveCamera(film, world_from_camera=WORLD @ above)
    scene = lb.builtin_scene("still-life")
    for view in ("", "direction", "weight", "fate"):        # the others show the camera's own frame, or time
        pictures = []
        for camera in (periscope, pinhole):
            rendering = lb.Rendering(camera, scene, seed=4, view=view, light_tracing=False, filtered=False)
            rendering.add(2)
            pictures.append(rendering.image())
        np.testing.assert_allclose(*pictures, rtol=0.02, atol=0.02)
    raster, uv = samples(film, 40)
    (rays, *slopes), (expected, *true) = (camera.generate_ray_differentials(raster, uv)
                                          for camera in (periscope, pinhole))
    np.testing.assert_allclose(rays.origins, expected.origins, atol=1e-9)
    for found, wanted in zip(slopes, true, strict=True):
        np.testing.assert_allclose(found.directions, wanted.directions, atol=1e-9)
    points = rays.origins + 800.0 * rays.directions
    found, visible = periscope.raster_from_point(points)
    assert visible.all()
    np.testing.assert_allclose(found, raster, atol=1e-6)


# Weights of 1


@pytest.mark.parametrize("camera", [
    lb.PerspectiveCamera(FILM, 1.2, weights="one"), lb.PerspectiveCamera(FILM, 1.2, 9.0, 800.0, weights="radiance"),
    lb.OrthographicCamera(FILM, 900.0, 20.0, 700.0, weights="one"), lb.PinholeCamera(FILM, 20.0, 2.0, weights="one"),
    lb.FisheyeCamera(FILM, 1.0, fov_axis="diagonal", weights="one"), lb.EnvironmentCamera(FILM, weights="one"),
    *(lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1500.0, 2.8, model=model, weights="one")
      for model in ("thick", "thin", "pinhole"))])
def test_with_weights_of_one_a_pixel_shows_radiance(camera):
    raster, uv = samples(FILM, 200)
    rays = camera.generate_rays(raster, uv)
    np.testing.assert_allclose(rays.weights, 1.0, atol=1e-15)
    found = camera.importance(rays.origins + 3.0 * rays.directions, rays.directions)
    cosine = np.ones(200) if isinstance(camera, lb.FisheyeCamera | lb.EnvironmentCamera) else -rays.directions[:, 2]
    np.testing.assert_allclose(found.we * cosine, found.position_pdf * found.direction_pdf, rtol=1e-6)


def test_weights_of_one_are_for_ideal_cameras():
    lens = lenses.load("pbrt-dgauss-50mm")
    with pytest.raises(lb.CameraError, match="for ideal cameras"):
        lb.LensCamera(lens, FILM, weights="one")
    with pytest.raises(lb.CameraError, match="choose relative, physical or radiance"):
        lb.PerspectiveCamera(FILM, weights="pbrt")
    with pytest.raises(lb.LightFieldError, match="leave out"):
        lb.capture_light_field(lb.PerspectiveCamera(FILM, lens_radius=5.0, weights="one"), lb.builtin_scene("room"))


def test_a_film_distance_takes_the_place_of_the_focus():
    lens = lenses.load("pbrt-dgauss-50mm")
    focused = lb.LensCamera(lens, FILM, 1500.0, 4.0)
    placed = lb.LensCamera(lens, FILM, f_number=4.0, film_distance=focused.film_distance)
    assert placed.focus_distance == pytest.approx(1500.0) and placed.film_distance == focused.film_distance
    raster, uv = samples(FILM, 100)
    for a, b in zip(focused.generate_rays(raster, uv), placed.generate_rays(raster, uv), strict=True):
        np.testing.assert_array_equal(a, b)
    assert replace(placed, model="thin").film_distance == focused.film_distance
    assert lb.LensCamera(lens, FILM, film_distance=20.0).focus_distance == math.inf     # before the rear focus
    for wrong, message in (({"film_distance": -1.0}, "positive"), ({"film_distance": math.nan}, "positive"),
                           ({"film_distance": 40.0, "focus_distance": 900.0}, "give one of the two")):
        with pytest.raises(lb.FocusError, match=message):
            lb.LensCamera(lens, FILM, **wrong)
