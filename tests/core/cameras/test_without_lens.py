"""Without a lens: a bare sensor sees the mean irradiance of its hemisphere, a pinhole blurs by its size."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb

FILM = lb.Film(36.0, 24.0, 96, 64)
DARK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)


def lattice(n):
    return np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])


def test_a_bare_sensor_under_a_uniform_sky_gets_pi_times_its_radiance():
    scene = lb.Scene("sky", sky=lb.Sky((0.7,) * 3, (0.7,) * 3, (0.7,) * 3))
    np.testing.assert_allclose(lb.render(lb.BareSensor(FILM), scene, samples=2), 0.7, rtol=1e-6)
    camera = lb.BareSensor(FILM, weights="physical", shutter_close=0.02)
    np.testing.assert_allclose(lb.render(camera, scene, samples=2), math.pi * 0.7 * 0.02, rtol=1e-6)


def test_its_directions_follow_the_cosine():
    """The cumulative of sin²θ is even, and so is the azimuth: 64 cells each, 2^16 points of a lattice."""
    n = 1 << 16
    rays = lb.BareSensor(FILM).generate_rays(np.tile([20.0, 30.0], (n, 1)), lattice(n))
    d = rays.directions
    np.testing.assert_allclose((d**2).sum(1), 1.0, atol=1e-12)
    assert (d[:, 2] <= 0.0).all()
    for share in (1.0 - d[:, 2] ** 2, np.arctan2(d[:, 1], d[:, 0]) / (2.0 * math.pi) % 1.0):
        np.testing.assert_allclose(np.histogram(share, 64, (0.0, 1.0))[0], n / 64, rtol=0.06)


def test_a_disk_of_light_gives_the_closed_form_over_the_sensor():
    """E / π = (1 − (d² + h² − R²) / √((d² + h² + R²)² − 4 d² R²)) / 2 at d from the axis of a parallel disk of radius R
    at the height h; 4,096 samples a pixel err by 1 %.
    """
    lamp = lb.Material(kind="lamp", colour=(1.0, 1.0, 1.0))
    scene = lb.Scene("disk", sky=DARK, plates=(lb.Disk((0.0, 0.0, -50.0), (0.0, 0.0, 1.0), 40.0, lamp),))
    camera = lb.BareSensor(lb.Film(200.0, 2.0, 20, 1))
    image = lb.render(camera, scene, samples=4096)[0, :, 0]
    edges = np.linspace(-100.0, 100.0, 20 * 50 + 1)
    d2 = ((edges[1:] + edges[:-1]) / 2.0) ** 2
    form = 0.5 * (1.0 - (d2 + 50.0**2 - 40.0**2) / np.sqrt((d2 + 50.0**2 + 40.0**2) ** 2 - 4.0 * d2 * 40.0**2))
    np.testing.assert_allclose(image, form.reshape(20, 50).mean(1), rtol=0.03, atol=0.003)


def test_light_from_the_right_brightens_the_left_of_a_bare_sensors_picture():
    lamp = lb.Material(kind="lamp", colour=(1.0, 1.0, 1.0))
    scene = lb.Scene("lamp", sky=DARK, spheres=(lb.Sphere((40.0, 0.0, -30.0), 10.0, lamp),))
    image = lb.render(lb.BareSensor(lb.Film(60.0, 40.0, 12, 8)), scene, samples=512)[..., 0]
    assert image[:, :3].mean() > 2.0 * image[:, -3:].mean() > 0.0


def test_a_bare_sensor_leads_back_to_the_film_point_of_a_ray():
    camera = lb.BareSensor(FILM)
    rng = np.random.default_rng(1)
    raster, uv = rng.random((500, 2)) * [96, 64], rng.random((500, 2)) * 0.98 + 0.01
    rays = camera.generate_rays(raster, uv)
    back, visible = camera.raster_from_point(rays.origins + 40.0 * rays.directions, uv)
    assert visible.all()
    np.testing.assert_allclose(back, raster, atol=1e-9)
    assert not camera.raster_from_point([[0.0, 0.0, 5.0]])[1].any()


@settings(max_examples=30)
@given(st.floats(5.0, 200.0), st.floats(0.02, 3.0), st.floats(10.0, 1e5), st.floats(-5.0, 5.0))
def test_a_point_leaves_the_shadow_of_the_hole_on_the_film(distance, radius, away, across):
    """From the point through the hole's edge to the film, by similar triangles: a disk of r (s + d) / s."""
    camera = lb.PinholeCamera(lb.Film(1e4, 1e4, 1000, 1000), distance, radius)
    point = np.array([across, -across / 2.0, -away])
    uv = np.concatenate([lattice(400), [[0.0, 0.5], [1.0, 0.5], [0.5, 0.0], [0.5, 1.0]]])
    raster, visible = camera.raster_from_point(np.tile(point, (len(uv), 1)), uv)
    assert visible.all()
    film = (np.array([500.0, -500.0]) - raster * [1.0, -1.0]) * 10.0
    off = np.hypot(*(film - (-point[:2] * distance / away)).T)
    assert off.max() == pytest.approx(radius * (away + distance) / away, rel=1e-6)
    assert camera.blur(away) == pytest.approx(2.0 * off.max(), rel=1e-6)
    assert camera.blur() == 2.0 * radius
    rays = camera.generate_rays(raster, uv)
    t = -away / rays.directions[:, 2]
    np.testing.assert_allclose((rays.origins + t[:, None] * rays.directions)[:, :2], np.tile(point[:2], (len(uv), 1)),
                               atol=1e-6 * away)


def test_the_picture_of_an_edge_is_a_ramp_as_wide_as_the_blur():
    """A half-plane at 300 mm, 1 mm of hole at 100 mm: a ramp over 4/3 mm, of the disk's cumulative; noise 1 %."""
    half = lb.Rectangle((5000.0, 0.0, -300.0), (5000.0, 0.0, 0.0), (0.0, 5000.0, 0.0),
                        lb.Material(kind="lamp", colour=(1.0, 1.0, 1.0)))
    camera = lb.PinholeCamera(lb.Film(2.0, 0.02, 200, 2), 100.0, 0.5)
    image = lb.render(camera, lb.Scene("edge", sky=DARK, plates=(half,)), samples=1024)[..., 0].mean(0)
    x = np.clip(((np.arange(200) + 0.5) / 100.0 - 1.0) / (camera.blur(300.0) / 2.0), -1.0, 1.0)
    ramp = 0.5 + (x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / math.pi
    np.testing.assert_allclose(image, ramp, atol=0.02)


def test_the_light_of_a_hole_is_pi_l_sin2_on_the_axis_and_quadrature_beside_it():
    camera = lb.PinholeCamera(FILM, 30.0, 4.0, weights="physical", shutter_close=0.5)
    n = 1 << 14
    axis = camera.generate_rays(np.tile([48.0, 32.0], (n, 1)), lattice(n)).weights.mean()
    assert axis == pytest.approx(0.5 * math.pi * 16.0 / (16.0 + 900.0), rel=1e-4)
    corner = camera.generate_rays(np.tile([4.0, 60.0], (n, 1)), lattice(n)).weights.mean()
    r, turn = np.meshgrid(4.0 * np.sqrt((np.arange(300) + 0.5) / 300), 2.0 * math.pi * (np.arange(300) + 0.5) / 300)
    x, y = (0.5 - 4.0 / 96.0) * 36.0, (60.0 / 64.0 - 0.5) * 24.0
    far2 = (x - r * np.cos(turn)) ** 2 + (y - r * np.sin(turn)) ** 2 + 900.0
    assert corner == pytest.approx(0.5 * math.pi * 16.0 * (900.0 / far2**2).mean(), rel=1e-4)
    relative = lb.PinholeCamera(FILM, 30.0, 4.0).generate_rays(np.tile([48.0, 32.0], (n, 1)), lattice(n)).weights
    assert relative.mean() == pytest.approx(1.0, rel=1e-4)


def test_lights_traced_from_their_own_side_find_the_film_through_the_hole():
    """Energy of a small lamp, by both ways: noise of the camera's rays 1.5 %."""
    lamp = lb.Material(kind="lamp", colour=(3e3, 3e3, 3e3))
    scene = lb.Scene("lamp", sky=DARK, spheres=(lb.Sphere((5.0, 0.0, -2000.0), 5.0, lamp),))
    camera = lb.PinholeCamera(lb.Film(4.0, 4.0, 32, 32), 50.0, 0.5)
    traced, plain = (lb.Rendering(camera, scene, light_tracing=flag) for flag in (True, False))
    assert traced.light_traced
    for rendering, samples in ((traced, 16), (plain, 1024)):
        rendering.add(samples)
    assert traced.image().mean() == pytest.approx(plain.image().mean(), rel=0.015)


def test_the_sharpest_hole_is_rayleighs():
    """A tenth of a millimetre of 550 nm at 1.9² · 550e-6 · b: 0.319 mm before a film at 51.2 mm, as tables have it."""
    assert lb.best_pinhole(51.2, wavelength=0.55) == pytest.approx(0.319, abs=5e-4)
    assert lb.best_pinhole(100.0, 100.0) == pytest.approx(lb.best_pinhole(50.0))
    hole = lb.best_pinhole(80.0) / 2.0          # there the two blurs are of a size
    camera = lb.PinholeCamera(FILM, 80.0, hole)
    assert camera.diffraction() / camera.blur() == pytest.approx(2.44 / 1.9**2, rel=1e-9)
    assert camera.f_number == pytest.approx(80.0 / lb.best_pinhole(80.0))
    assert camera.fov == pytest.approx(2.0 * math.atan(12.0 / 80.0))


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.PinholeCamera(FILM, distance=0.0), "film distance 0"),
    (lambda: lb.PinholeCamera(FILM, radius=0.0), "hole radius 0"),
    (lambda: lb.PinholeCamera(FILM, radius=math.nan), "hole radius nan"),
    (lambda: lb.PinholeCamera(FILM).blur(0.0), "object distance"),
    (lambda: lb.best_pinhole(-1.0), "positive distances"),
    (lambda: lb.BareSensor(FILM, weights="heavy"), "relative, physical or radiance"),
])
def test_invalid_settings_are_refused_in_one_line(make, says):
    with pytest.raises(lb.CameraError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
