"""Ray differentials against finer differences of independent rays, and the patterns that are averaged by them."""

import math
import warnings

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.ray_generation import spread_step
from lensbench.core.kernels.block import PIXEL_SPREAD, B, Step, X, Y, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import raster_image, sampling_steps
from lensbench.core.rendering.aovs import show_rows

FILM = lb.Film(36.0, 24.0, 90, 60)
TURN = lb.look_at((30.0, 20.0, 10.0), (-100.0, 50.0, -400.0))
IDEAL = {
    "perspective": lb.PerspectiveCamera(FILM, fov=1.2, world_from_camera=TURN),
    "thin lens, window": lb.PerspectiveCamera(FILM, lens_radius=9.0, focus_distance=700.0,
                                              window=(-0.5, 1.5, -1.0, 0.8)),
    "orthographic": lb.OrthographicCamera(FILM, 800.0, world_from_camera=TURN),
    "telecentric": lb.OrthographicCamera(FILM, 800.0, 20.0, 900.0),
    "pinhole": lb.PinholeCamera(FILM, 40.0, 0.2),
    "bare": lb.BareSensor(FILM),
    "under water": lb.PerspectiveCamera(FILM, lens_radius=9.0, focus_distance=700.0, medium=lb.Medium.water(5000.0)),
    **{layout: lb.EnvironmentCamera(FILM, layout, world_from_camera=TURN)
       for layout in ("equirectangular", "equal-area", "cube-map")},
    **{f"{name} fisheye": lb.FisheyeCamera(FILM, 2.8, name, world_from_camera=TURN)
       for name in ("equidistant", "equisolid", "stereographic", "orthographic")},
    "thick": lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, model="thick"),
}


def richardson(function, h):
    """The derivative of a function at 0 by central differences of h and h / 2, and how far off they may be."""
    wide, narrow = ((function(s) - function(-s)) / (2 * s) for s in (h, h / 2))
    return (4 * narrow - wide) / 3, np.abs(narrow - wide)


def places(camera, seed, n=400):
    random = np.random.default_rng(seed)
    return random.random((n, 2)) * [camera.film.pixels_x, camera.film.pixels_y], random.random((n, 2))


def agree(found, wanted, doubt, rounding):
    """Derivatives within the doubt of the finer differences, plus what is left by rounding."""
    scale = np.abs(wanted).max()
    assert np.isfinite(found).all()
    assert (np.abs(found - wanted) <= doubt + rounding * scale + 1e-13).all()


@pytest.mark.parametrize("camera", IDEAL.values(), ids=IDEAL)
def test_differentials_are_the_slopes_of_the_rays_of_a_place_in_the_pupil(camera):
    raster, uv = places(camera, 3)
    # not across the edges of a cube's faces, nor the fold of an octahedron, where there is no derivative
    cells = raster / [FILM.pixels_x, FILM.pixels_y] * [8.0, 12.0]
    inside = (np.abs(cells - np.round(cells)) > 0.01).all(1)
    folded = np.abs(np.abs(raster / [FILM.pixels_x, FILM.pixels_y] * 2 - 1).sum(1) - 1.0)
    weights = camera.generate_rays(raster, uv).weights
    good = (weights > 0.0) & inside & (folded > 0.01) & (
        np.hypot(*(raster / [FILM.pixels_x, FILM.pixels_y] - 0.5).T) < 0.3 if isinstance(camera, lb.FisheyeCamera)
        else True)
    raster, uv = raster[good], uv[good]
    assert len(raster) > 50
    rays, dx, dy = camera.generate_ray_differentials(raster, uv)
    assert np.array_equal(rays.weights, camera.generate_rays(raster, uv).weights)
    for axis, slope in enumerate((dx, dy)):
        for name in ("origins", "directions"):
            def moved(s, axis=axis, name=name):
                return getattr(camera.generate_rays(raster + s * np.eye(2)[axis], uv), name)
            wanted, doubt = richardson(moved, 0.02)
            # differences of numbers of up to 100 mm in double, over 0.01 px
            agree(getattr(slope, name), wanted, doubt, 1e-9)


@pytest.mark.parametrize(("name", "model", "tolerance"), [
    ("pbrt-dgauss-50mm", "trace", 1e-7), ("pbrt-fisheye-10mm", "trace", 1e-7),
    pytest.param("lentil-schneider-anamorphic-31-2001", "trace", 1e-7, marks=pytest.mark.slow),
    pytest.param("pbrt-dgauss-50mm", "polynomial", 5e-3, marks=pytest.mark.slow)])
def test_differentials_of_a_lens_are_those_of_traced_rays_through_one_point_behind_it(name, model, tolerance):
    camera = lb.LensCamera(lenses.load(name), FILM, 1200.0, model=model, world_from_camera=TURN)
    raster, uv = places(camera, 5, 200)
    rays, dx, dy = camera.generate_ray_differentials(raster, uv)
    good = rays.weights > 0.0
    assert good.sum() > 100
    lens, back = camera.lens, np.linalg.inv(TURN)
    film_z = lens.length + camera.film_distance
    # where each ray crosses the plane of the last vertex: traced back through the lens by the reference
    origins = rays.origins[good] @ back[:3, :3].T + back[:3, 3] + [0.0, 0.0, film_z]
    exact = lb.LensCamera(camera.lens, FILM, 1200.0) if model == "polynomial" else camera
    t = lb.trace(lens, origins,
                 -rays.directions[good] @ back[:3, :3].T, clip=False)
    assert exact.film_distance == camera.film_distance
    rear = t.points + ((lens.length - t.points[:, 2]) / t.directions[:, 2])[:, None] * t.directions
    for axis, slope in enumerate((dx, dy)):
        def moved(s, axis=axis):
            film = (raster[good] + s * np.eye(2)[axis]) / [FILM.pixels_x, FILM.pixels_y]
            points = np.column_stack([(0.5 - film[:, 0]) * FILM.width, (film[:, 1] - 0.5) * FILM.height,
                                      np.full(len(film), film_z)])
            return lb.trace(lens, points, rear - points, clip=False).directions @ TURN[:3, :3].T
        wanted, doubt = richardson(moved, 0.02)
        agree(slope.directions[good], wanted, doubt, tolerance)


def test_no_blocked_neighbour_takes_a_good_sample_away():
    # stopped down to a disk that vignettes hard, samples lie right at the rim of what passes
    camera = lb.LensCamera(lenses.load("pbrt-wide-22mm"), FILM, 1200.0)
    raster, _ = places(camera, 7, 4000)
    uv = np.column_stack([np.random.default_rng(8).random(4000), np.full(4000, 1.0 - 1e-6)])
    rays, dx, dy = camera.generate_ray_differentials(raster, uv)
    good = rays.weights > 0.0
    assert 0 < good.sum() < 4000                                # the rim is among them
    assert np.array_equal(rays.weights, camera.generate_rays(raster, uv).weights)
    for slope in (dx, dy):
        assert np.isfinite(slope.directions[good]).all() and np.isfinite(slope.origins[good]).all()
        across = np.abs((slope.directions[good] * rays.directions[good]).sum(1))
        assert across.max() < 1e-6 * np.abs(slope.directions[good]).max()       # a unit vector turns across itself


def test_a_rotating_camera_with_a_rolling_shutter_adds_its_rotation_per_row():
    rate, readout = 0.7, 0.05                                   # rad/s about the vertical, s for the picture
    c, s = math.cos(rate), math.sin(rate)
    end = np.array([[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]])
    moving = lb.AnimatedTransform(np.eye(4), end, 0.0, 1.0)
    still = lb.PerspectiveCamera(FILM, shutter_close=0.01)
    rolling = lb.PerspectiveCamera(FILM, shutter_close=0.01, readout=readout, world_from_camera=moving)
    raster, uv = [[45.0, 30.5]], [[0.5, 0.5]]                   # on the axis, where the line turns it sideways alone
    _, _, down = rolling.generate_ray_differentials(raster, uv, 0.5)
    _, _, alone = still.generate_ray_differentials(raster, uv, 0.5)
    rays = rolling.generate_rays(raster, uv, 0.5)
    sideways = np.cross([0.0, 1.0, 0.0], rays.directions[0])
    extra = (down.directions[0] - alone.directions[0] @ moving.at(rays.times[0])[:3, :3].T) @ sideways
    assert extra == pytest.approx(rate * readout / FILM.pixels_y, rel=2e-2)     # from the first line to the last


@pytest.mark.parametrize("camera", [IDEAL["perspective"], IDEAL["equirectangular"], lb.LensCamera(
    lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0)], ids=["perspective", "equirectangular", "lens"])
def test_a_sample_knows_the_spread_of_its_pixel(camera):
    raster, _ = places(camera, 9, 500)
    middle = np.tile(camera.pupil_centre, (len(raster), 1))
    rays, dx, dy = camera.generate_ray_differentials(raster, middle)
    wanted = np.sqrt(((dx.directions**2).sum(1) + (dy.directions**2).sum(1)) / 2.0)
    lit = rays.weights > 0.0
    step = spread_step(camera, np.float32)
    found = Program([step]).run({X: raster[:, 0], Y: raster[:, 1]}, [PIXEL_SPREAD], len(raster))[0]
    # a cell is a 32nd of the film, and knows its middle: 1 / 64 of the way of a spread that halves, or doubles, over it
    assert lit.sum() > 400
    assert found[lit] == pytest.approx(wanted[lit], rel=0.04)


def test_the_rim_of_an_orthographic_fisheye_has_no_slope_and_its_samples_a_size():
    of = lb.FisheyeCamera(lb.Film(36.0, 24.0, 32, 32), fov=math.pi, projection="orthographic", fov_axis="longer")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        step = spread_step(of, np.float32)
    assert np.isfinite(step.parameters).all() and (step.parameters[3:] > 0.0).all()


def test_samples_that_share_a_pixel_cover_less_of_it_by_the_power_three_quarters():
    """n samples cover the nth part each; the stage shortens sides by n^¾, so that the first ones are soon forgotten."""
    of = lb.PerspectiveCamera(FILM, fov=0.9)
    steps = [*sampling_steps(FILM.pixels_x, FILM.pixels_y, lit=False), spread_step(of, np.float64), *of.steps(),
             Step(show_rows, [1.0, 0.0], [PIXEL_SPREAD] * 3)]
    sizes = {}
    for sample in (0, 1, 7, 255):
        film = np.zeros((-(-FILM.pixels_x * FILM.pixels_y // B), 3 * B))
        Program(steps, np.float64).expose(film, lane_buffer(np.float64), 0, len(film), sample, 1, np.uint32(1))
        sizes[sample] = raster_image(film, FILM.pixels_x, FILM.pixels_y)[..., 0].mean()
    for sample, size in sizes.items():
        assert size == pytest.approx(sizes[0] * (sample + 1.0) ** -0.75, rel=0.01)
    # The first covers a pixel: its angle in the middle of the picture is the pitch over the focal length
    assert sizes[0] == pytest.approx(0.45 * 2.0 / FILM.pixels_y, rel=0.2)
