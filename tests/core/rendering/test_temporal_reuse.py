"""Samples carried from one picture into the next: where they land, what they count, and that none is left."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.rendering.temporal_reuse import GHOST, GONE, LARGEST, MOST, SHARP, Reusable, _diameter

FILM = lb.Film(32.0, 18.0, 96, 54)


@pytest.fixture(scope="module")
def pool():
    with ThreadPoolExecutor(2) as threads:
        yield threads


def coordinates():
    """A picture whose colours are its raster points."""
    y, x = np.mgrid[0:54, 0:96] + 0.5
    return np.stack([x, y, np.ones_like(x)], 2).astype(np.float32)


def reusable(camera, depth, count=8.0):
    return Reusable(camera, coordinates(), np.full((54, 96), count, np.float32), np.full((54, 96), depth, np.float32))


@pytest.mark.parametrize("turned", [
    lb.PerspectiveCamera(FILM, fov=0.5),
    lb.PerspectiveCamera(FILM, fov=0.6, world_from_camera=lb.look_at((0.0, 0.0, 0.0), (100.0, -60.0, -1000.0))),
    lb.PerspectiveCamera(FILM, fov=0.6, world_from_camera=lb.look_at((30.0, 0.0, 0.0), (30.0, 0.0, -1000.0))),
    lb.PerspectiveCamera(FILM, fov=0.6, window=(-1.5, 1.8, -1.0, 0.9)),
])
def test_a_sample_lands_where_the_projection_puts_its_point(turned, pool):
    before, depth = lb.PerspectiveCamera(FILM, fov=0.6), 1000.0
    found = reusable(before, depth).carried(turned, pool, 2)
    y, x = np.mgrid[4:50:5, 4:92:7]
    rays = turned.generate_rays(np.stack([x.ravel(), y.ravel()], 1) + 0.5, np.full((x.size, 2), 0.5))
    far = (-depth - rays.origins[:, 2]) / rays.directions[:, 2]     # the plane is seen at that depth before the turn
    points = rays.origins + far[:, None] * rays.directions
    there, visible = before.raster_from_point(points)
    inside = visible & (there > 1.0).all(1) & (there < [95.0, 53.0]).all(1)
    assert inside.sum() > 20
    np.testing.assert_allclose(found.image[y, x].reshape(-1, 3)[inside, :2], there[inside], atol=0.35)
    assert (found.counts[y, x].ravel()[inside] == 8.0).all()            # a pinhole blurs nothing
    ahead = -(np.linalg.inv(turned.world_from_camera) @ np.column_stack([points, np.ones(len(points))]).T)[2]
    np.testing.assert_allclose(found.depth[y, x].ravel()[inside], ahead[inside], rtol=2e-3)


def test_an_unchanged_camera_keeps_every_sample(pool):
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8, model="thin")
    found = reusable(camera, 900.0, 64.0).carried(camera, pool, 2)
    np.testing.assert_allclose(found.image, coordinates(), atol=1e-4)
    assert (found.counts == MOST).all() and (found.depth == 900.0).all()


def test_a_sample_counts_the_less_the_more_its_circle_of_confusion_has_changed(pool):
    lens, depth = lenses.load("pbrt-dgauss-50mm"), 2000.0
    before = lb.LensCamera(lens, FILM, 1200.0, 2.8, model="thin")
    for distance in (1200.0, 1250.0, 1500.0, 3000.0):
        after = replace(before, focus_distance=distance)
        widths = []
        for camera in (before, after):
            pupil = camera.first_order.entrance_pupil
            efl, s = camera.first_order.efl, camera.gaussian.z
            circle = lb.circle_of_confusion(efl, 0.5 * efl / pupil.radius, camera.focus_distance + s, depth + s)
            widths.append(circle / (FILM.width / FILM.pixels_x))
        part = abs(widths[1] - widths[0]) / (max(widths) + SHARP)
        found = reusable(before, depth).carried(after, pool, 2)
        assert found.counts[27, 48] == pytest.approx(8.0 / (1.0 + 8.0 * GHOST * part**2), rel=0.02)


def test_what_the_picture_before_does_not_show_gets_no_sample(pool):
    before = lb.PerspectiveCamera(FILM, fov=0.6)
    after = replace(before, world_from_camera=lb.look_at((0.0, 0.0, 0.0), (400.0, 0.0, -1000.0)))
    found = reusable(before, 1000.0).carried(after, pool, 2)
    assert (found.counts[:, 80:] == 0.0).all() and (found.counts[:, :10] > 0.0).all()
    assert reusable(before, 1000.0).carried(lb.FisheyeCamera(FILM), pool, 2) is None


def test_old_samples_are_gone_after_sixteen_new_ones(pool):
    camera = lb.PerspectiveCamera(FILM)
    new = np.random.default_rng(3).random((54, 96, 3), np.float32)
    carried = reusable(camera, 1000.0).carried(camera, pool, 2)
    np.testing.assert_allclose(carried.mixed(new, 1, pool, 2).image, (8.0 * coordinates() + new) / 9.0, rtol=1e-5)
    np.testing.assert_array_equal(carried.mixed(new, GONE, pool, 2).image, new)


def test_new_samples_are_averaged_only_where_the_lens_blurs(pool):
    camera = lb.LensCamera(lenses.load("pbrt-telephoto-250mm"), FILM, 5000.0, model="thin")
    depth = np.full((54, 96), 5000.0, np.float32)
    depth[:, 48:] = 100_000.0
    before = Reusable(camera, coordinates(), np.zeros((54, 96), np.float32), depth)
    new = np.random.default_rng(3).random((54, 96, 3), np.float32)
    found = before.carried(camera, pool, 2).mixed(new, 1, pool, 2)
    np.testing.assert_array_equal(found.image[:, :48], new[:, :48])         # none of the blurred side bleeds over
    assert found.image[4:50, 56:90].std() < 0.4 * new[4:50, 56:90].std()    # nine samples: a third
    assert (found.counts[:, :48] == 1.0).all() and (found.counts[4:50, 56:90] == 9.0).all()


@pytest.mark.parametrize("pupil", [0.0, 3.0])
def test_a_circle_of_confusion_without_bound_is_large_and_its_pixels_stay_numbers(pupil, pool):
    at_the_lens = np.array([0.0, 0.0, pupil, 0.0, 0.0, 0.01, 16.0, 0.01, 9.0], np.float32)     # no scene mm a film mm
    assert _diameter(at_the_lens, np.float32(700.0)) == LARGEST
    lent = reusable(lb.PerspectiveCamera(FILM, fov=0.6), 1000.0)._replace(blur=np.full((54, 96), LARGEST, np.float32))
    for samples in (1, GONE):
        mixed = lent.mixed(coordinates(), samples, pool, 2)
        assert np.isfinite(mixed.image).all() and np.isfinite(mixed.counts).all()
