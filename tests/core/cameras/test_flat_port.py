"""A camera in water: Snell's law at its window, the way back through it, and what water leaves of the light."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.flat_port import FlatPort
from tests.core.imaging.test_animated_transform import FILM, kernels

WATER = lb.Medium(index=1.333)


def cameras(**more):
    lens = lenses.load("pbrt-dgauss-50mm")
    return {"perspective": lb.PerspectiveCamera(FILM, lens_radius=6.0, focus_distance=900.0, **more),
            "trace": lb.LensCamera(lens, FILM, 1200.0, 4.0, **more),
            "thin": lb.LensCamera(lens, FILM, 1200.0, 4.0, model="thin", **more),
            "fisheye": lb.LensCamera(lenses.load("pbrt-fisheye-10mm"), FILM, 1200.0, **more),
            "orthographic": lb.OrthographicCamera(FILM, 800.0, **more)}


@pytest.mark.parametrize("name", cameras())
def test_a_camera_in_water_sees_by_snells_law_through_its_window(name):
    dry, wet = cameras()[name], cameras(medium=WATER)[name]
    rng = np.random.default_rng(3)
    raster, uv = rng.uniform(0.2, 0.8, (200, 2)) * (120, 80), rng.random((200, 2))
    a, b = dry.generate_rays(raster, uv), wet.generate_rays(raster, uv)
    through = a.weights > 0.0
    assert through.sum() > 100
    np.testing.assert_array_equal(a.weights[through], b.weights[through])
    a, b = (r._replace(origins=r.origins[through], directions=r.directions[through]) for r in (a, b))
    # on the ray in air, on the window, which lies before every part of the lens
    t = (wet.front - a.origins[:, 2]) / a.directions[:, 2]
    assert (t >= -1e-12).all()
    np.testing.assert_allclose(b.origins, a.origins + t[:, None] * a.directions, atol=1e-11)
    normal = np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(1.333 * np.cross(b.directions, normal), np.cross(a.directions, normal), atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(b.directions, axis=1), 1.0, atol=1e-14)
    assert (b.directions[:, 2] < 0.0).all()


def test_things_in_water_seem_nearer_by_its_index():
    """A thing at n times the distance behind the window is as sharp as the thing in air, near the axis."""
    dry, wet = (lb.PerspectiveCamera(FILM, fov=0.02, lens_radius=1.0, focus_distance=900.0, medium=m)
                for m in (None, WATER))
    uv = np.random.default_rng(1).random((300, 2))
    for camera, distance in ((dry, 900.0), (wet, 1.333 * 900.0)):
        rays = camera.generate_rays(np.tile([60.0, 40.0], (300, 1)), uv)
        where = rays.origins + (-distance - rays.origins[:, 2:]) / rays.directions[:, 2:] * rays.directions
        assert np.hypot(*where[:, :2].T).max() < 1e-5           # (r/s)³ s of a lens of 1 mm at 0.9 m, a millionth


@pytest.mark.parametrize("index", [1.0, 1.333, 1.5])
@pytest.mark.parametrize("slope", [0.0, 0.3, 1.2])
def test_a_beam_aslant_has_two_foci_whose_mean_a_port_stretches_to(slope, index):
    """Rays that meet 1 m beyond the window as seen in air, bent by Snell's law: neighbours in and across the plane."""
    def way(t: float) -> float:
        """Tangent of the angle beyond the window."""
        sine = math.sin(math.atan(t)) / index
        return sine / math.sqrt(1.0 - sine**2)

    step = 1e-5
    before, after = slope - step, slope + step                  # they meet the window at so many metres from the axis
    within = 2.0 * step / (way(after) - way(before))            # central differences: off by step², 1e-10
    across = slope / way(slope) if slope else within            # rays turned about the axis meet on it
    assert FlatPort(40.0, index).stretch(slope) == pytest.approx(0.5 * (within + across), rel=1e-8)
    assert FlatPort(40.0, index).stretch(np.array([slope, 0.0]))[1] == pytest.approx(index, rel=1e-15)


@pytest.mark.parametrize("distance", [30.0, 200.0, 5000.0, math.inf])
def test_what_lies_beyond_a_window_appears_nearer_to_it_by_the_index_and_back(distance):
    port = FlatPort(30.0, 1.333)
    assert port.apparent(distance) == pytest.approx(30.0 + (distance - 30.0) / 1.333)
    assert port.true(port.apparent(distance)) == pytest.approx(distance)
    assert FlatPort().apparent(distance) == FlatPort().true(distance) == distance


def test_what_a_camera_in_air_sees_beside_it_lies_at_the_critical_angle():
    port = FlatPort(30.0, 1.333)
    for angle in (0.5 * math.pi, 1.8, math.pi):
        assert port.seen_angle(angle) == pytest.approx(math.asin(1.0 / 1.333))
    assert port.seen_angle(0.3) == pytest.approx(math.asin(math.sin(0.3) / 1.333)) and FlatPort().seen_angle(1.8) == 1.8


@pytest.mark.parametrize("name", ["perspective", "trace", "orthographic"])
def test_projection_leads_through_the_window(name):
    camera = cameras(medium=WATER)[name]
    rng = np.random.default_rng(5)
    raster, uv = rng.uniform(0.25, 0.75, (30, 2)) * (120, 80), rng.uniform(0.3, 0.7, (30, 2))
    rays = camera.generate_rays(raster, uv)
    points = rays.origins + rng.uniform(500.0, 4000.0, (30, 1)) * rays.directions
    found, visible = camera.raster_from_point(points, uv)
    assert visible.all()
    np.testing.assert_allclose(found, raster, atol=1e-7)


def test_radiance_falls_by_the_index_squared_on_its_way_out_of_water():
    dry, wet = (lb.PerspectiveCamera(FILM, lens_radius=5.0, weights="physical", medium=m) for m in (None, WATER))
    a, b = (camera.generate_rays([[60.0, 40.0]], [[0.5, 0.5]]).weights[0] for camera in (dry, wet))
    assert b / a == pytest.approx(1.333**-2)


def test_water_takes_red_first():
    water = lb.Medium.water(20e3)
    left = water.transmittance(10e3)
    assert left[0] < left[1] < left[2] and left[1] == pytest.approx(math.sqrt(0.02))
    # nothing is left to scatter where one sees the farthest: pure water
    pure = lb.Medium.water(69.2e3)
    assert max(pure.scattering) < 1e-6 and pure.extinction[0] == pytest.approx(0.340e-3, rel=1e-3)


def test_a_window_stands_only_where_the_index_changes():
    plain = lb.PerspectiveCamera(FILM).steps()
    assert kernels(lb.PerspectiveCamera(FILM, medium=lb.Medium.fog(5e3)).steps()) == kernels(plain)
    assert kernels(lb.PerspectiveCamera(FILM, medium=WATER).steps()) == [*kernels(plain), "port"]


@pytest.mark.slow
def test_small_lights_in_water_are_where_the_cameras_rays_find_them():
    scene = lb.builtin_scene("night-lights")
    assert lb.Rendering(lb.PerspectiveCamera(FILM), scene).light_traced
    assert not lb.Rendering(lb.PerspectiveCamera(FILM, medium=WATER), scene).light_traced


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.Medium.water(80e3), "69 m"),
    (lambda: lb.Medium.water(-1.0), "visibility"),
    (lambda: lb.EnvironmentCamera(FILM, medium=WATER), "flat window"),
    (lambda: lb.PerspectiveCamera(FILM, medium=WATER).importance([[0.0, 0.0, 0.0]], [[0.0, 0.0, -1.0]]), "in air"),
])
def test_invalid_settings_are_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)
