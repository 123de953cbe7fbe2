"""The thick lens: cardinal points and pupils instead of the traced lens."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.cameras.test_camera_kinds import FILM, film_point, samples
from tests.core.oracles import behind_stop


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-telephoto-250mm"])
@pytest.mark.parametrize("distance", [3000.0, math.inf])
def test_rays_of_a_thick_lens_leave_the_entrance_pupil_and_meet_at_the_conjugate(name, distance):
    camera = lb.LensCamera(lenses.load(name), FILM, distance, model="thick")
    fo, length = camera.first_order, camera.lens.length
    raster = np.repeat([[480.0, 320.0], [30.0, 600.0], [900.0, 100.0]], 60, 0)
    uv = np.random.default_rng(0).random((180, 2))
    rays = camera.generate_rays(raster, uv)
    vertex = -(length + camera.film_distance)
    np.testing.assert_allclose(rays.origins[:, 2], vertex + fo.entrance_pupil.z, atol=1e-11)
    radii = np.hypot(rays.origins[:, 0], rays.origins[:, 1])
    assert 0.9 < radii.max() / fo.entrance_pupil.radius <= 1.0 + 1e-7
    film = film_point(FILM, raster)
    if math.isinf(distance):
        expected = np.column_stack([-film / fo.efl, -np.ones(180)])
        np.testing.assert_allclose(rays.directions / -rays.directions[:, 2:], expected, atol=1e-13)
        return
    behind = camera.film_distance - fo.rear_principal                   # 1/f = 1/s + 1/s'
    ahead = 1.0 / (1.0 / fo.efl - 1.0 / behind)
    plane = vertex + fo.front_principal - ahead
    assert plane == pytest.approx(-distance, abs=1e-8)
    t = (plane - rays.origins[:, 2]) / rays.directions[:, 2]
    met = (rays.origins + t[:, None] * rays.directions)[:, :2]
    assert np.ptp(met.reshape(3, 60, 2), axis=1).max() < 1e-10
    np.testing.assert_allclose(met, -film * ahead / behind, atol=1e-10 * distance / 50.0)


@pytest.mark.parametrize("distance", [900.0, math.inf])
def test_near_the_axis_a_thick_lens_is_the_traced_one(distance):
    """A ray of the ideal lens, traced back through the real one, lands off its film point by h³."""
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, distance, model="thick")
    shift = np.array([0.0, 0.0, camera.lens.length + camera.film_distance])
    rng = np.random.default_rng(1)
    film, place = rng.uniform(-1.0, 1.0, (200, 2)), rng.uniform(-0.5, 0.5, (200, 2))
    errors = []
    for h in (0.8, 0.4, 0.2):
        xy = h * film
        raster = np.column_stack([(0.5 - xy[:, 0] / 36.0) * 960.0, (xy[:, 1] / 24.0 + 0.5) * 640.0])
        rays = camera.generate_rays(raster, 0.5 + h / 8.0 * place)
        back = lb.trace(camera.lens, rays.origins + shift, -rays.directions)
        points = back.points - shift
        landed = points[:, :2] - points[:, 2:] / back.directions[:, 2:] * back.directions[:, :2]
        errors.append(np.hypot(*(landed - xy).T))
    assert errors[0].max() > 1e-7
    for before, after in zip(errors[:-1], errors[1:], strict=True):
        assert np.sqrt((before**2).mean() / (after**2).mean()) == pytest.approx(8.0, rel=0.02)


def before_stop(gap: float) -> lb.Lens:
    """The same lens, its stop this far before its front focus: an image of it stands behind the lens."""
    glass = (lb.Surface(4.0, 8.0, lb.Glass(1.6), curvature=0.02), lb.Surface(0.0, 8.0, curvature=-0.02))
    focus = -lb.first_order(lb.Lens(glass, 0)).ffl
    return lb.Lens((lb.Surface(focus + gap, 2.0, curvature=0.0), *glass), 0)


@pytest.mark.parametrize("gap", [-3.0, 0.0, 3.0])
def test_rays_point_to_a_pupil_at_infinity_in_the_scene_or_behind_the_camera(gap):
    """From the first vertex on; the rays of the pupil's middle cross where the entrance pupil is."""
    camera = lb.LensCamera(behind_stop(gap), FILM, 600.0, model="thick")
    raster, _ = samples(FILM, 50)
    rays = camera.generate_rays(raster, np.full((50, 2), 0.5))
    vertex = -(camera.lens.length + camera.film_distance)
    assert (rays.directions[:, 2] < 0.0).all()
    np.testing.assert_allclose(rays.origins[:, 2], vertex, atol=1e-12)
    pupil = camera.first_order.entrance_pupil.z
    if gap == 0.0:
        assert math.isinf(pupil)
        np.testing.assert_allclose(rays.directions, np.tile([0.0, 0.0, -1.0], (50, 1)), atol=1e-14)
    else:
        t = pupil / rays.directions[:, 2]
        np.testing.assert_allclose((rays.origins + t[:, None] * rays.directions)[:, :2], 0.0, atol=1e-9)
    uv = np.random.default_rng(2).random((50, 2))
    cone = camera.generate_rays(raster, uv)
    t = (-600.0 - cone.origins[:, 2]) / cone.directions[:, 2]
    met = cone.origins + t[:, None] * cone.directions
    np.testing.assert_allclose(camera.raster_from_point(met)[0], raster, atol=1e-9)     # one conjugate for all places


def test_a_lens_that_is_telecentric_towards_the_film_gives_it_even_light():
    """Its cone is the same for every film point: no cos⁴ but that of the cone itself."""
    camera = lb.LensCamera(before_stop(0.0), FILM, math.inf, model="thick")
    assert math.isinf(camera.first_order.exit_pupil.z)
    n = 4096
    uv = np.column_stack([(np.arange(n) + 0.5) / n, np.arange(n) * 0.6180339887498949 % 1.0])
    for place in ([480.0, 320.0], [0.0, 0.0]):
        assert camera.generate_rays(np.tile(place, (n, 1)), uv).weights.mean() == pytest.approx(1.0, rel=1e-3)
    physical = replace(camera, weights="physical")
    sine2 = 1.0 / (1.0 + (camera.first_order.efl / camera.first_order.entrance_pupil.radius) ** 2)
    assert physical.generate_rays(np.tile([480.0, 320.0], (n, 1)), uv).weights.mean() == pytest.approx(
        math.pi * sine2, rel=1e-3)


def test_a_thick_lens_whose_exit_pupil_lies_on_the_film_says_so():
    lens = before_stop(100.0)
    nearest = lb.nearest_focus(lens)                    # where the object touches the stop, and is imaged with it
    with pytest.raises(lb.CameraError, match="exit pupil of this lens lies on the film"):
        lb.LensCamera(lens, FILM, nearest, model="thick")
    lb.LensCamera(lens, FILM, nearest + 1.0, model="thick")
