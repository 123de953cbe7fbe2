"""Importance and densities of every camera: they integrate to one, and to the pictures that the camera takes."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.fisheye import PROJECTIONS
from lensbench.core.cameras.without_lens import LAYOUTS
from lensbench.core.scenery.objects.material import Material

FILM = lb.Film(36.0, 24.0, 96, 64)
WORLD = lb.look_at((40.0, -30.0, 60.0), (400.0, 100.0, -3000.0))
BLADES = {"blades": 5, "blade_rotation": 0.3}
N = 1 << 16


def dgauss(**more) -> lb.LensCamera:
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 900.0, world_from_camera=WORLD, **more)


# camera, z of a plane (camera frame; None: where its rays start), half of a square on it, half the slopes across, up:
# all its rays are within
WIDE = {
    "thin lens": (lb.PerspectiveCamera(FILM, 0.7, 20.0, 600.0, world_from_camera=WORLD), None, 20.0, (0.6, 0.42)),
    "five blades, window": (lb.PerspectiveCamera(FILM, 0.7, 20.0, 600.0, window=(-0.5, 1.2, -1.0, 0.4), **BLADES), None,
                            20.0, (0.5, 0.42)),
    "physical": (lb.PerspectiveCamera(FILM, 0.7, 20.0, 600.0, weights="physical", shutter_close=0.1, shutter_ramp=0.02),
                 None, 20.0, (0.6, 0.42)),
    "scaled by 3": (lb.PerspectiveCamera(FILM, 0.7, 20.0, 600.0, world_from_camera=lb.AnimatedTransform(
        *[WORLD @ np.diag([3.0, 3.0, 3.0, 1.0])] * 2)), None, 20.0, (0.6, 0.42)),
    "telecentric lens": (lb.OrthographicCamera(FILM, 300.0, 40.0, 500.0, world_from_camera=WORLD), -500.0, 150.0,
                         (0.08, 0.08)),
    "thick lens": (dgauss(model="thick", f_number=2.8), None, 12.0, (0.45, 0.32)),
    "finite pinhole": (lb.PinholeCamera(FILM, 30.0, 0.7, world_from_camera=WORLD), None, 0.7, (0.65, 0.45)),
    "thin model": (dgauss(model="thin", weights="physical"), None, 19.0, (0.45, 0.32)),
}
POINTS = {
    "pinhole": lb.PerspectiveCamera(FILM, 1.1, world_from_camera=WORLD),
    **{layout: lb.EnvironmentCamera(FILM, layout, world_from_camera=WORLD) for layout in LAYOUTS},
    **{f"{name} fisheye": lb.FisheyeCamera(FILM, fov, name, axis, world_from_camera=WORLD)
       for name, fov, axis in zip(PROJECTIONS, (5.5, 3.0, 4.0, math.pi), ("shorter", "diagonal", "longer", "vertical"),
                                  strict=True)},
}
TRACED = {
    "trace": dgauss(),
    "trace, f/8, five blades": lb.LensCamera(replace(lenses.load("pbrt-dgauss-50mm"), **BLADES), FILM,
                                             900.0, 8.0, weights="physical", shutter_close=0.01),
    "wide": lb.LensCamera(lenses.load("pbrt-wide-22mm"), FILM, 900.0, world_from_camera=WORLD),
}


def spread(dimensions: int, n: int = N) -> np.ndarray:
    """(n, dimensions) numbers in [0, 1), evenly, by an additive recurrence (Roberts 2018)."""
    root = 2.0
    for _ in range(50):
        root = (1.0 + root) ** (1.0 / (dimensions + 1))
    return (0.5 + np.arange(n)[:, None] * root ** -np.arange(1.0, dimensions + 1)) % 1.0


def unit(vector) -> np.ndarray:
    """Of length 1."""
    return np.asarray(vector) / np.linalg.norm(vector)


def mean_weight(camera: lb.Camera) -> float:
    """Of rays by even places on the film and in the pupil."""
    u = spread(4)
    return camera.generate_rays(u[:, :2] * [camera.film.pixels_x, camera.film.pixels_y], u[:, 2:]).weights.mean()


def all_rays(camera: lb.Camera, z: float, half: float, slopes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays in the world, even over a square of the plane z and over slopes, and the cos θ dω dA of all over each."""
    u = 2.0 * spread(4) - 1.0
    x, y = half * u[:, :2].T
    way = np.column_stack([slopes[0] * u[:, 2], slopes[1] * u[:, 3], -np.ones(N)])
    cosine = 1.0 / np.linalg.norm(way, axis=1)
    placement = camera.placement()
    scale = np.linalg.norm(placement[0, :3])
    origins = np.column_stack([x, y, np.full(N, z)]) @ placement[:3, :3].T + placement[:3, 3]
    return origins, way @ placement[:3, :3].T, cosine**4 * (2.0 * half * scale) ** 2 * 4.0 * slopes[0] * slopes[1]


@pytest.mark.parametrize("name", WIDE)
def test_importance_integrates_to_the_mean_weight_and_the_densities_to_one(name):
    """Over all positions and directions that there are: 65,536 places leave 1 %, for edges in four dimensions."""
    camera, z, half, slopes = WIDE[name]
    origins, directions, measure = all_rays(camera, camera.gaussian.z if z is None else z, half, slopes)
    found = camera.importance(origins, directions)
    assert 0.02 < found.visible.mean() < 0.9
    assert (found.we * measure).mean() == pytest.approx(mean_weight(camera), rel=0.01)
    axis = unit(camera.placement()[:3, 2])
    cosine = -directions @ axis / np.linalg.norm(directions, axis=1)
    assert (found.position_pdf * found.direction_pdf * measure / cosine).mean() == pytest.approx(1.0, rel=0.01)


@pytest.mark.parametrize("name", POINTS)
def test_the_directions_of_a_camera_that_is_a_point_integrate_to_one(name):
    """Over the sphere, evenly: 65,536 directions leave 0.3 %."""
    camera = POINTS[name]
    u, v = spread(2).T
    y, ring = 2.0 * u - 1.0, np.sqrt(4.0 * u * (1.0 - u))
    d = np.column_stack([ring * np.cos(2.0 * math.pi * v), y, ring * np.sin(2.0 * math.pi * v)])
    found = camera.importance(np.tile(camera.placement()[:3, 3], (N, 1)), d)
    lit = mean_weight(camera)
    cosine = 1.0
    if isinstance(camera, lb.PerspectiveCamera):
        cosine = -d @ unit(camera.placement()[:3, 2])
        assert (found.direction_pdf * 4.0 * math.pi).mean() == pytest.approx(1.0, rel=0.003)
    assert (found.position_pdf[found.visible] == 1.0).all()
    assert (found.we * cosine * 4.0 * math.pi).mean() == pytest.approx(lit, rel=0.003)


@pytest.mark.parametrize("name", TRACED)
def test_the_importance_of_a_real_lens_integrates_to_its_mean_weight(name):
    """Over the plane of the first vertex: what a film emits evenly and what falls on it are one (étendue)."""
    camera = TRACED[name]
    half = 1.3 * camera.lens.surfaces[0].semi_diameter
    slopes = (1.0, 0.75) if name == "wide" else (0.55, 0.4)
    origins, directions, measure = all_rays(camera, -(camera.lens.length + camera.film_distance), half, slopes)
    found = camera.importance(origins, directions)
    assert found.visible.mean() > 0.002
    assert (found.we * measure).mean() == pytest.approx(mean_weight(camera), rel=0.02)
    assert np.ptp(found.we[found.visible]) == 0.0


@pytest.mark.parametrize("camera", [
    *(entry[0] for entry in WIDE.values()), *POINTS.values(), *TRACED.values(),
    lb.OrthographicCamera(FILM, 500.0, world_from_camera=WORLD), dgauss(model="pinhole"),
    lb.BareSensor(FILM, weights="physical", shutter_close=0.2, world_from_camera=WORLD)])
def test_a_rays_weight_times_its_densities_is_its_importance(camera):
    """And its raster point is the one that it was asked for; on the film's side for a real lens."""
    u = spread(4, 2000)
    raster, uv = u[:, :2] * [96.0, 64.0], u[:, 2:] * [0.999, 0.9973]       # off the edges of triangles
    rays = camera.generate_rays(raster, uv)
    lit = rays.weights > 0.0
    if isinstance(camera, (lb.FisheyeCamera, lb.EnvironmentCamera)):        # rays of dark places may run where it sees
        raster, rays = raster[lit], lb.Rays(*(rows[lit] for rows in rays))
        lit = lit[lit]
    along = np.linspace(-20.0, 4000.0, len(lit))[:, None]
    found = camera.importance(rays.origins + along * rays.directions, 3.0 * rays.directions)
    np.testing.assert_array_equal(found.visible, lit)
    np.testing.assert_allclose(found.raster[lit], raster[lit], atol=1e-8)
    cosine = -rays.directions @ unit(camera.placement()[:3, 2])
    if isinstance(camera, (lb.EnvironmentCamera, lb.FisheyeCamera)):
        cosine = np.ones(len(lit))
    elif isinstance(camera, lb.LensCamera) and camera.follows_rays:
        lens, m = camera.lens, np.linalg.inv(camera.placement())
        o = rays.origins @ m[:3, :3].T + m[:3, 3] + [0.0, 0.0, lens.length + camera.film_distance]
        cosine = lb.trace(lens, o, -rays.directions @ m[:3, :3].T).directions[:, 2]
    product = rays.weights * found.position_pdf * found.direction_pdf
    np.testing.assert_allclose((found.we * cosine)[lit], product[lit], rtol=1e-6)      # the disk's map: 3e-8
    assert not found.we[~lit].any() and np.isnan(found.raster[~lit]).all()


@pytest.mark.parametrize("camera", [
    *(entry[0] for entry in WIDE.values()), *POINTS.values(),
    *(pytest.param(camera, marks=pytest.mark.slow) if i else camera for i, camera in enumerate(TRACED.values()))])
def test_a_lamp_gives_the_film_what_its_importance_says(camera):
    """The mean of the picture against ∫ W L cos θ cos θ′ / d² over lamp and lens; 64 samples a pixel leave 1 %."""
    everywhere = isinstance(camera, (lb.EnvironmentCamera, lb.FisheyeCamera))
    centre, radius = camera.placement() @ [60.0, 25.0, -700.0, 1.0], 400.0 if everywhere else 45.0
    lamp = lb.Disk(tuple(centre[:3]), tuple(camera.placement()[:3, :3] @ [0.2, 0.1, 1.0]), radius,
                   Material((1.0, 1.0, 1.0), "lamp"))
    dark = lb.Scene("lamp", sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3), plates=(lamp,))
    picture = lb.render(camera, dark, samples=64)[..., 0].mean(dtype=float)
    u = spread(4)
    r, turn = radius * np.sqrt(u[:, 0]), 2.0 * math.pi * u[:, 1]
    a, b = np.array(lamp.right) / radius, np.array(lamp.up) / radius
    points = centre[:3] + (r * np.cos(turn))[:, None] * a + (r * np.sin(turn))[:, None] * b
    points_in = np.linalg.inv(camera.placement())
    local = points @ points_in[:3, :3].T + points_in[:3, 3]
    # Where each ray leaves the camera: its origin, or a square about all that leaves it
    if isinstance(camera, lb.OrthographicCamera):
        square, z = 40.0, 0.0
        start = np.column_stack([local[:, :2] + square * 2.0 * (2.0 * u[:, 2:] - 1.0), np.full(N, z)])
        area = (4.0 * square) ** 2
    elif everywhere or camera is POINTS["pinhole"]:
        start, area = np.zeros((N, 3)), 1.0
    else:
        z, square = camera.gaussian.z, 1.01 * abs(camera.gaussian.origin_pupil)
        if isinstance(camera, lb.LensCamera) and camera.follows_rays:
            z, square = -(camera.lens.length + camera.film_distance), 1.1 * camera.lens.surfaces[0].semi_diameter
        start, area = np.column_stack([square * (2.0 * u[:, 2:] - 1.0), np.full(N, z)]), (2.0 * square) ** 2
    world = start @ camera.placement()[:3, :3].T + camera.placement()[:3, 3]
    way = points - world
    d = np.linalg.norm(way, axis=1)
    slant = np.abs(way @ unit(lamp.normal)) / d
    cosine = 1.0 if everywhere else -way @ unit(camera.placement()[:3, 2]) / d
    area *= 1.0 if camera is POINTS["pinhole"] or everywhere else np.linalg.det(camera.placement()) ** (2.0 / 3.0)
    we = camera.importance(world, points - world).we
    expected = (we * cosine * slant / d**2).mean() * area * math.pi * radius**2
    assert expected > 0.0
    assert picture == pytest.approx(expected, rel=0.015)


def test_importance_with_a_rolling_shutter_is_that_of_the_open_row():
    way = lb.AnimatedTransform(np.eye(4), lb.look_at((100.0, 20.0, 0.0), (400.0, 0.0, -1000.0)), 0.0, 0.05)
    camera = lb.PerspectiveCamera(FILM, 0.7, 5.0, 900.0, world_from_camera=way, shutter_close=0.02, readout=0.02)
    u = spread(5, 500)
    raster = u[:, :2] * [96.0, 64.0]
    rays = camera.generate_rays(raster, u[:, 2:4], u[:, 4])
    found = camera.importance(rays.origins, rays.directions, u[:, 4])
    assert found.visible.all() and (found.we > 0.0).all()
    np.testing.assert_allclose(found.raster, raster, atol=1e-8)


def test_foreign_rays_have_no_importance_and_invalid_ones_are_refused():
    camera = POINTS["pinhole"]
    place = camera.placement()[:3, 3]
    aside = camera.importance([place + [1.0, 0.0, 0.0], place], [-camera.placement()[:3, 2], camera.placement()[:3, 2]])
    assert not aside.visible.any() and (aside.we == 0.0).all()
    for origins, directions in (([[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]), ([[0.0, math.nan, 0.0]], [[0.0, 0.0, 1.0]]),
                                ([[0.0, 0.0]], [[0.0, 1.0]])):
        with pytest.raises(ValueError, match="finite"):
            camera.importance(origins, directions)
