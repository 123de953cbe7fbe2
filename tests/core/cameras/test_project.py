"""From a point of the scene back through a real lens to the film: the inverse of the very rays that render."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses

FILM = lb.Film(36.0, 24.0, 960, 640)
WORLD = lb.look_at((300.0, -200.0, 100.0), (0.0, 50.0, -4000.0))
LENSES = ["pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-telephoto-250mm", "pbrt-fisheye-10mm",
          "lentil-minolta-fisheye-1978"]


def camera(name: str, **more) -> lb.LensCamera:
    return lb.LensCamera(lenses.load(name), **{"film": FILM, "focus_distance": 3000.0, "world_from_camera": WORLD,
                                               **more})


def lit_rays(taken: lb.Camera, n: int, uv=None, seed: int = 0):
    """Random raster points, places in the pupil and rays, of which light passes."""
    rng = np.random.default_rng(seed)
    raster = rng.random((n, 2)) * [taken.film.pixels_x, taken.film.pixels_y]
    uv = rng.random((n, 2)) if uv is None else np.tile(uv, (n, 1))
    rays = taken.generate_rays(raster, uv)
    lit = rays.weights > 0.0
    return raster[lit], uv[lit], rays.origins[lit], rays.directions[lit]


def passes(taken: lb.Camera, raster, uv, points) -> np.ndarray:
    """The angle (radians) between the rays of raster points and the way to their points."""
    rays = taken.generate_rays(raster, uv)
    way = points - rays.origins
    return np.linalg.norm(rays.directions - way / np.linalg.norm(way, axis=1)[:, None], axis=1)


@pytest.mark.parametrize(("name", "more"), [
    *((name, {}) for name in LENSES),
    ("pbrt-dgauss-50mm", {"f_number": 16.0, "focus_distance": math.inf}),
    pytest.param("pbrt-dgauss-50mm", {"model": "polynomial", "degree": 7}, marks=pytest.mark.slow),
])
def test_a_point_on_a_ray_leads_back_through_the_lens_to_the_raster_point_of_the_ray(name, more):
    """1e-9 px; points not too far out of focus, for those may have several film points (see the next test)."""
    taken = camera(name, **more)
    for uv in (None, taken.pupil_centre):
        raster, places, origins, directions = lit_rays(taken, 1200, uv)
        assert len(raster) > 350
        last = 4000.0 if "telephoto" in name else 20000.0
        far = np.random.default_rng(1).uniform(2500.0, last, (len(raster), 1))
        points = origins + far * directions
        back, visible = taken.raster_from_point(points, None if uv else places)
        assert visible.all()
        np.testing.assert_allclose(back, raster, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "lib-miyamoto-fisheye-1964", "lenshh-petzval"])
def test_the_ray_of_the_film_point_of_a_near_point_meets_it(name):
    """Points just before the lens, and a fisheye that shows the rim of its field twice: one of two film points."""
    taken = camera(name, film=lb.Film(36.0, 36.0, 700, 700)) if "fisheye" in name else camera(name)
    raster, uv, origins, directions = lit_rays(taken, 1500)
    points = origins + directions * 10.0 ** np.random.default_rng(2).uniform(1.5, 3.0, (len(raster), 1))
    back, visible = taken.raster_from_point(points, uv)
    assert visible.mean() > 0.98
    assert passes(taken, back[visible], uv[visible], points[visible]).max() < 1e-13
    assert (np.hypot(*(back - raster)[visible].T) > 1.0).any() == ("fisheye" in name)
    assert (directions[visible, 2] > 0.0).any() == ("fisheye" in name)


@pytest.mark.parametrize("more", [{}, {"model": "polynomial"}, {"film_pose": lb.FilmPose(tilt=0.05)}],
                         ids=["trace", "polynomial", "tilted film"])
def test_points_on_the_axis_out_of_focus_have_their_film_points(more):
    """Their samples lie on the meridian of the film point, where halves of the region meet; most were NaN."""
    taken = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 360, 240), 1000.0, 4.0, **more)
    uv = np.concatenate([np.random.default_rng(4).uniform(0.05, 0.95, (40, 2)),
                         [[0.9, 0.5], [0.7, 0.6], [0.5, 0.9], [0.1, 0.4]]])
    for distance in (200.0, 925.0, 1100.0, 1e5):
        points = np.tile([0.0, 0.0, -distance], (len(uv), 1))
        back, visible = taken.raster_from_point(points, uv)
        assert visible.all()
        assert passes(taken, back, uv, points).max() < 1e-13
        beside, visible = taken.raster_from_point(points + [1e-6, 0.0, 0.0], uv)
        assert visible.all() and np.abs(beside - back).max() < 1e-3


def test_what_the_lens_blocks_or_the_film_does_not_reach_is_not_visible():
    taken = camera("pbrt-dgauss-50mm", world_from_camera=np.eye(4))
    points = np.array([[0.0, 0.0, -5000.0], [0.0, 0.0, 5000.0], [0.0, 4000.0, -5000.0], [0.0, 1e5, -5000.0]])
    back, visible = taken.raster_from_point(points)
    assert visible.tolist() == [True, False, False, False]
    np.testing.assert_allclose(back[0], [480.0, 320.0], atol=5e-3)      # the region's middle is solved to 2e-4
    rng = np.random.default_rng(3)
    raster, uv = rng.random((400, 2)) * [960.0, 640.0], rng.random((400, 2))
    rays = taken.generate_rays(raster, uv)
    dark = rays.weights == 0.0
    assert dark.any()
    _, visible = taken.raster_from_point((rays.origins + 6000.0 * rays.directions)[dark], uv[dark])
    assert not visible.any()


def test_near_the_axis_projection_is_of_first_order():
    """Off by distortion, which falls as the cube of the height."""
    taken = camera("pbrt-dgauss-50mm", world_from_camera=np.eye(4))
    thick = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 3000.0, model="thick")
    off = []
    for height in (200.0, 100.0, 50.0):
        point = [[height, -0.6 * height, -3000.0]]
        off.append(np.hypot(*(taken.raster_from_point(point)[0] - thick.raster_from_point(point)[0])[0]))
    assert off[0] > 1e-4
    assert off[0] / off[1] == pytest.approx(8.0, rel=0.05) and off[1] / off[2] == pytest.approx(8.0, rel=0.05)


def test_each_colour_of_a_lens_that_disperses_finds_its_own_film_point():
    """The spread of C and F on the film is the lateral colour that two chief rays show."""
    taken = lb.LensCamera(lenses.load("lenshh-cooke-triplet-50"), FILM, 3000.0)
    point = [[900.0, 300.0, -3000.0]]
    spots = [taken.raster_from_point(point, wavelength=line)[0][0] for line in (lb.C_LINE, lb.D_LINE, lb.F_LINE)]
    for line, spot in zip((lb.C_LINE, lb.D_LINE, lb.F_LINE), spots, strict=True):
        ray = taken.generate_rays([spot], [taken.pupil_centre], wavelength=line)
        way = point - ray.origins
        np.testing.assert_allclose(ray.directions, way / np.linalg.norm(way), atol=1e-13)
    assert 1e-3 < np.hypot(*(spots[0] - spots[2])) < 2.0
