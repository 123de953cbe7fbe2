"""The spot and the figures of a pixel against closed forms, the axial bundle and the scene itself."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.constraints import with_camera
from lensbench.app.plots.pixel_rays import beam, distances
from lensbench.app.plots.pixel_spot import colour_of, pixel_readings, spot, spot_of
from lensbench.app.scenes.scene_file import scene_stamp
from lensbench.app.settings.settings import Settings

START = Settings()
PERSPECTIVE = replace(with_camera(START, "perspective"), f_number=2.0)


@pytest.mark.parametrize("distance", [600.0, 1000.0, 1500.0, 6000.0, math.inf])
def test_the_blur_of_an_axis_point_is_that_of_the_axial_bundle(distance):
    built = bench_of(START)
    target = None if math.isinf(distance) else (0.0, 0.0, built.film_z - distance)
    found = spot_of(built.lens, built.film_distance, (0.0, 0.0), target)
    expected = lb.real_circle_of_confusion(built.lens, built.film_distance, [distance])[0][0]
    # 400 rays spread evenly: the mean square of their radii is known to about a percent
    assert found.diameter == pytest.approx(expected, rel=0.01)
    assert found.centroid == pytest.approx((0.0, 0.0), abs=0.02 * expected)
    assert found.extent >= found.diameter / math.sqrt(2.0)


def test_every_ray_of_a_spot_goes_from_the_point_to_where_it_lands():
    built = bench_of(START)
    target = np.array([150.0, -80.0, built.film_z - 900.0])
    film = (150.0 * 50.4 / 850.0, -80.0 * 50.4 / 850.0)
    found = spot_of(built.lens, built.film_distance, film, tuple(target))
    start, way = found.paths[:, 0], found.paths[:, 1] - found.paths[:, 0]
    way /= np.linalg.norm(way, axis=1)[:, None]
    miss = (target - start) - ((target - start) * way).sum(1)[:, None] * way
    assert np.abs(miss).max() < 1e-6
    # Traced back from where they land, they run to the point
    ways = np.column_stack([found.rear, np.full(len(found.rear), built.lens.length)]) - found.paths[:, -1]
    back = lb.trace(built.lens, found.paths[:, -1], ways)
    ahead = (target - back.points) / np.linalg.norm(target - back.points, axis=1)[:, None]
    assert np.abs(ahead - back.directions).max() < 1e-8
    assert sum(found.lost.values()) + len(found.landings) == 700


def test_rays_of_an_ideal_camera_meet_in_its_plane_of_focus():
    seen = beam(PERSPECTIVE, (200.5, 500.5))
    assert len(seen.origins) == 9
    ahead = PERSPECTIVE.focus_distance / -seen.directions[:, 2]
    points = seen.origins + ahead[:, None] * seen.directions
    assert np.ptp(points, axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


def test_a_beam_ends_on_what_the_scene_has_there():
    scene = lb.builtin_scene(START.scene)
    seen = beam(START, (480.5, 320.5))
    expected = scene.distance(seen.origins, seen.directions)
    np.testing.assert_allclose(seen.ends, expected, rtol=1e-6)
    assert seen.thing.startswith("sphere") and seen.along < seen.ahead          # measured from the lens, and the film
    moved = replace(START, position=(50.0, 20.0, 300.0), yaw=0.2)
    assert np.linalg.norm(beam(moved, (480.5, 320.5)).origins[0] - [50.0, 20.0, 300.0]) < 150.0
    sky = beam(START, (300.5, 60.5))
    assert sky.target is None and math.isinf(sky.along)


@pytest.mark.slow
def test_a_moving_scene_is_met_where_it_is_at_the_moment():
    scene = lb.builtin_scene("fairground")
    origins = np.zeros((60, 3))
    directions = np.column_stack([np.linspace(-0.3, 0.3, 60), np.full(60, 0.02), -np.ones(60)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    for moment in (0.0, 1.5):
        found = distances("fairground", scene_stamp("fairground"), origins, directions, moment)
        expected = scene.distance(origins, directions, moment)
        agree = np.isclose(found, expected, rtol=1e-5)
        assert agree.mean() > 0.95                  # a ray along an edge may take either side in float32
    assert not np.allclose(scene.distance(origins, directions, 0.0), scene.distance(origins, directions, 1.5))


def test_readings_of_the_middle_and_of_the_corner():
    middle, corner = pixel_readings(START, (480.0, 320.0)), pixel_readings(START, (30.5, 30.5))
    assert middle.light == pytest.approx(1.0, abs=2e-3) and middle.open == pytest.approx(1.0)
    built = bench_of(START)
    radius = math.hypot(*corner.film)
    fall = lb.falloff(built.lens, built.film_distance, [radius])
    assert corner.light == pytest.approx(float(fall.total[0]), abs=3e-3)
    assert corner.open == pytest.approx(float(fall.vignetting[0]), abs=0.02)
    assert middle.traced and middle.pixels == pytest.approx(middle.diameter / START.film.pitch)


def test_the_blur_of_an_ideal_camera_is_that_of_its_ideal_lens():
    got = pixel_readings(PERSPECTIVE, (200.5, 600.5))
    efl = 0.5 * 24.0 / math.tan(0.5 * PERSPECTIVE.fov)
    at, focus = got.ahead, PERSPECTIVE.focus_distance               # the film stays at the focal length
    expected = 0.5 * efl * efl * abs(at - focus) / (at * focus)
    assert not got.traced and got.diameter == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("camera", "why"), [("environment", "no plane in focus"), ("fisheye", "no"),
                                             ("bare-sensor", "no plane in focus")])
def test_what_has_no_blur_says_why(camera, why):
    got = pixel_readings(with_camera(START, camera), (30.5, 30.5))
    assert got.diameter is None and why in got.no_blur and got.open is None
    assert (got.film is None) == (camera == "environment")


def test_a_dark_pixel_and_a_window_into_water_say_so():
    dark = replace(START, lens="pbrt-fisheye-10mm", f_number=None)
    assert "no light" in pixel_readings(dark, (2.5, 2.5)).no_blur
    with pytest.raises(ValueError, match="No light"):
        spot(dark, (2.5, 2.5))
    with pytest.raises(ValueError, match="water"):
        spot(replace(START, medium="water"), (480.5, 320.5))
    with pytest.raises(ValueError, match="ideal lens"):
        spot(replace(START, lens_model="thin"), (480.5, 320.5))


def test_the_colour_is_that_of_the_pixel_and_none_outside():
    image = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
    assert colour_of(image, (2.5, 1.5)) == (15.0, 16.0, 17.0)
    assert colour_of(image, (3.5, 0.5)) is None and colour_of(None, (0.5, 0.5)) is None
