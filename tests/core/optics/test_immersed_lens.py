"""A lens immersed in water: refraction at its front surface, and its effects."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses

FILM = lb.Film(36.0, 24.0, 96, 64)
WATER = 1.333
SKY = lb.Scene("sky", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))


def wet(name="pbrt-dgauss-50mm"):
    return replace(lenses.load(name), front_index=WATER)


def single(front_index=WATER):
    """One refracting surface: n / s + n′ / s′ = (n′ − n) / R, by hand; and a back that is flat and thin."""
    return lb.Lens((lb.Surface(2.0, 6.0, lb.Glass(1.7), curvature=1.0 / 30.0), lb.Surface(0.0, 6.0, curvature=0.0)), 0,
                   front_index=front_index)


def test_the_first_order_of_a_front_in_water_is_that_of_the_two_surfaces():
    fo = lb.first_order(single())
    power = (1.7 - WATER) / 30.0                # the flat back has none, and the stop is the front surface
    assert fo.efl == pytest.approx(1.0 / power, rel=1e-12)
    assert fo.ffl == pytest.approx(-WATER / power, rel=1e-12)
    assert fo.bfl == pytest.approx((1.7 / power - 2.0) / 1.7, rel=1e-12)
    assert fo.front_principal == pytest.approx(0.0, abs=1e-12) and fo.entrance_pupil.z == 0.0
    # the pupil of a stop inside is its image by the surfaces before it, in water
    lens = wet()
    fo, stop = lb.first_order(lens), lens.vertices[lens.stop_index]
    part = lb.Lens((*lens.surfaces[:lens.stop_index], replace(lens.stop, semi_diameter=50.0)), 0, front_index=WATER)
    up = np.array([0.0, 1e-4, stop])
    ray = lb.trace(part, up, [0.0, 1e-6, -1.0], clip=False)
    image = ray.points[0][2] - (ray.points[0][1] - 1e-4 * fo.entrance_pupil.radius / fo.stop_radius) / (
        ray.directions[0][1] / ray.directions[0][2])
    assert image == pytest.approx(fo.entrance_pupil.z, abs=1e-3)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm", "lenshh-us4338001-tele"])
@pytest.mark.parametrize("distance", [1200.0, 6000.0, math.inf])
def test_real_paraxial_rays_from_the_water_meet_on_the_film(name, distance):
    """A ray 0.01 mm off the axis, traced from the object in water: the film is where it crosses the axis."""
    lens = replace(lb.stopped_down(lenses.load(name), 11.0), front_index=WATER)
    film = lb.film_distance(lens, distance)
    if math.isinf(distance):
        start, way = [0.0, 0.01, -10.0], [0.0, 0.0, 1.0]
    else:
        away = distance - film - lens.length
        start, way = [0.0, 0.0, -away], [0.0, 0.01, away]
    ray = lb.trace(lens, start, way)
    crossing = ray.points[0][2] - ray.points[0][1] * ray.directions[0][2] / ray.directions[0][1] - lens.length
    assert crossing == pytest.approx(film, abs=1e-4)
    assert lb.focused_distance(lens, film) == pytest.approx(distance, rel=1e-9)
    assert lb.film_distance(lens, distance, "real") == pytest.approx(film, abs=2.0)
    if not math.isinf(distance):
        assert film > lb.film_distance(replace(lens, front_index=1.0), distance)
        coc = lb.thick_circle_of_confusion(lens, film, [distance])[0]
        assert coc == pytest.approx(0.0, abs=1e-9)


def test_the_nearest_distance_in_water_is_where_the_conjugates_are_nearest():
    lens = wet()
    nearest = lb.nearest_focus(lens)
    fo = lb.first_order(lens)
    totals = [lb.focused_distance(lens, fo.bfl + e) for e in np.linspace(0.5, 2.0, 4001) * math.sqrt(WATER) * fo.efl]
    assert nearest == pytest.approx(min(totals), rel=1e-6)
    with pytest.raises(lb.FocusError, match="nearest"):
        lb.film_distance(lens, nearest - 0.1)


@pytest.mark.parametrize("blades", [0, 7])
def test_rays_of_the_camera_are_those_of_the_reference_tracer_in_water(blades):
    camera = lb.LensCamera(replace(wet(), blades=blades), FILM, 1500.0, 4.0)
    assert camera.lens.front_index == WATER
    rng = np.random.default_rng(3)
    raster = rng.random((2000, 2)) * [96, 64]
    rays = camera.generate_rays(raster, rng.random((2000, 2)))
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=1), 1.0, atol=1e-12)
    lit = rays.weights > 0.0
    shift = np.array([0.0, 0.0, camera.lens.length + camera.film_distance])
    back = lb.trace(camera.lens, rays.origins + shift, -rays.directions)
    assert (back.fate[lit] == lb.Fate.PASSED).all()
    points, ways = back.points[lit] - shift, back.directions[lit]
    landed = points[:, :2] - points[:, 2:] / ways[:, 2:] * ways[:, :2]
    film = np.column_stack([(0.5 - raster[:, 0] / 96.0) * 36.0, (raster[:, 1] / 64.0 - 0.5) * 24.0])
    np.testing.assert_allclose(landed, film[lit], atol=1e-9)


@pytest.mark.parametrize("model", ["trace", "polynomial", "thick", "thin", "pinhole"])
def test_projection_leads_through_water_and_the_ideal_models_follow_the_trace(model):
    """A point's image by every model: the ideal ones within the aberrations of the field's middle."""
    camera = lb.LensCamera(wet(), FILM, 2000.0, 8.0, model=model, medium=lb.Medium(WATER))
    traced = replace(camera, model="trace")
    points = np.array([[0.0, 0.0, -2000.0], [150.0, 80.0, -2000.0], [-200.0, 20.0, -2000.0]])
    raster, visible = camera.raster_from_point(points)
    assert visible.all()
    np.testing.assert_allclose(raster, traced.raster_from_point(points)[0], atol=0.15)
    rays = camera.generate_rays(raster, np.tile(camera.pupil_centre, (3, 1)))
    t = (points[:, 2] - rays.origins[:, 2]) / rays.directions[:, 2]
    np.testing.assert_allclose(rays.origins + t[:, None] * rays.directions, points, atol=1e-5)


def test_the_field_of_view_shrinks_by_the_index_and_by_the_power_that_the_front_loses():
    air, water = (lb.LensCamera(lens, FILM, math.inf, 8.0)
                  for lens in (lenses.load("pbrt-dgauss-50mm"), wet()))
    slopes = [-ray.directions[0, 0] / ray.directions[0, 2]
              for ray in (it.generate_rays([[52.0, 32.0]], [it.pupil_centre]) for it in (air, water))]
    longer = water.first_order.efl / air.first_order.efl
    assert longer > 1.2 and slopes[0] / slopes[1] == pytest.approx(WATER * longer, rel=2e-3)


@pytest.mark.parametrize("model", ["trace", "thick", "thin"])
def test_radiance_over_the_index_squared_is_kept_so_that_water_dims_physical_pictures(model):
    """E = π L sin²θ′ / n²: the light of a scene in water fills less of the angles behind the front. Noise 0.3 %."""
    small = lb.Film(0.2, 0.2, 8, 8)
    camera = lb.LensCamera(wet(), small, math.inf, 5.6, model=model, weights="physical", dispersion=False)
    image = lb.render(camera, SKY, samples=64)
    sine = 1.0 / (2.0 * lb.working_f_number(camera.lens, camera.film_distance))
    assert image.mean() == pytest.approx(math.pi * sine**2 / WATER**2, rel=1e-2 if model != "trace" else 3e-3)
    relative = lb.LensCamera(wet(), small, math.inf, 5.6, model=model, dispersion=False)
    assert lb.render(relative, SKY, samples=64).mean() == pytest.approx(1.0, rel=3e-3)


@pytest.mark.parametrize("weights", ["relative", "physical"])
def test_light_tracing_agrees_in_water(weights):
    """Flux from the light's side against radiance over n² from the camera's: noise 1.5 %."""
    dark = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    lamp = lb.Material(kind="lamp", colour=(4e3, 4e3, 4e3))
    scene = lb.Scene("lamp", sky=dark, spheres=(lb.Sphere((10.0, 0.0, -4000.0), 8.0, lamp),))
    camera = lb.LensCamera(wet(), lb.Film(1.5, 1.5, 32, 32), 1500.0, 4.0, weights=weights, dispersion=False)
    traced, plain = (lb.Rendering(camera, scene, light_tracing=flag) for flag in (True, False))
    assert traced.light_traced
    for rendering, samples in ((traced, 16), (plain, 1024)):
        rendering.add(samples)
    assert traced.image().mean() == pytest.approx(plain.image().mean(), rel=0.015)


@pytest.mark.slow
@pytest.mark.parametrize("weights", ["relative", "physical"])
def test_importance_counts_the_smaller_angles_in_water(weights):
    """∫∫ W L cos θ dω dA over the rays that leave the lens is the film's mean of the picture of a uniform scene.

    Over a plane before the front and the half-space, by 400,000 rays: noise 1 %.
    """
    small = lb.Film(0.4, 0.4, 8, 8)
    camera = lb.LensCamera(wet(), small, 2000.0, 5.6, weights=weights, dispersion=False)
    mean = lb.render(camera, SKY, samples=64).mean()
    rng = np.random.default_rng(6)
    fo, z = camera.first_order, -camera.lens.length - camera.film_distance
    reach, tilt, n = 1.2 * fo.entrance_pupil.radius, 0.008, 400_000
    slopes = (rng.random((n, 2)) * 2.0 - 1.0) * tilt
    at = (rng.random((n, 2)) * 2.0 - 1.0) * reach - slopes * fo.entrance_pupil.z
    origins, ways = np.column_stack([at, np.full(n, z)]), np.column_stack([slopes, -np.ones(n)])
    found = camera.importance(origins, ways)
    cosine4 = (1.0 + (slopes**2).sum(1)) ** -2              # cos θ dω = cos⁴ of slopes
    total = (found.we * cosine4).sum() / n * (2.0 * reach) ** 2 * (2.0 * tilt) ** 2
    assert (np.abs(slopes[found.visible]).max() < 0.9 * tilt)
    assert total == pytest.approx(mean, rel=0.01)


def test_an_invalid_index_is_refused_in_one_line():
    for index in (0.9, 4.0, math.nan):
        with pytest.raises(lb.LensError, match="before the lens"):
            replace(lenses.load("pbrt-dgauss-50mm"), front_index=index)


def test_a_lens_and_its_camera_must_stand_in_the_same_water():
    with pytest.raises(lb.CameraError, match="give both the same"):
        lb.LensCamera(wet(), FILM, medium=lb.Medium(1.5))
    assert not lb.LensCamera(wet(), FILM, medium=lb.Medium(WATER)).has_port
    assert lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, medium=lb.Medium(WATER)).has_port


@pytest.mark.parametrize("f_number", [2.5, 8.0])
def test_an_f_number_is_that_in_air_and_sets_the_same_stop_in_water(f_number):
    dry = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), f_number)
    assert lb.stopped_down(wet(), f_number) == replace(dry, front_index=WATER)
