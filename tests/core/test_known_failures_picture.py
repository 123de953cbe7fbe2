"""Where other systems fail in the picture, each in the very situation: see docs/stability.md.

The ids of the failures are those of app/studies/stability/known_failures.toml, each with the name of its test.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.fisheye import PROJECTIONS
from lensbench.core.cameras.without_lens import LAYOUTS
from tests.library import CLASSICS

DGAUSS = lenses.load("pbrt-dgauss-50mm")
FILM = lb.Film(36.0, 24.0, 90, 60)
WHITE = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
DARK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
ROOT = 0.6180339887498949


def lattice(n: int) -> np.ndarray:
    """(n, 2) places that fill the unit square evenly."""
    return np.column_stack([(np.arange(n) + 0.5) / n, np.arange(n) * ROOT % 1.0])


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_pbrt_v3_162_the_light_has_no_step_where_one_box_of_64_ends_and_the_next_begins(name):
    """64 boxes, each of its own size, and no weight for it: rings. Here the film's halves of every edge agree."""
    camera = lb.LensCamera(lenses.load(name), FILM, 1200.0)
    n, uv = 1 << 11, lattice(1 << 11)

    def light(radius):
        raster = [(0.5 - radius / 36.0) * 90.0, 30.0]
        return camera.generate_rays(np.tile(raster, (n, 1)), uv).weights.mean()

    edges = np.arange(1, 52) / 64.0 * 0.5 * math.hypot(36.0, 24.0)
    edges = edges[edges < min(17.9, 0.95 * camera.pupil.dark_beyond)]
    inner, outer = (np.array([light(edge + step) for edge in edges]) for step in (-1e-4, 1e-4))
    assert len(edges) > 25
    # within the 2 / n of samples that may pass on one side alone
    np.testing.assert_allclose(inner, outer, atol=4.0 / n)
    # The profile is the quadrature of cos⁴θ dA / z² over a grid of rays traced one by one
    lens, z, a = camera.lens, camera.film_distance, 1.1 * camera.lens.surfaces[-1].semi_diameter
    steps = ((np.arange(300) + 0.5) / 150.0 - 1.0) * a
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))

    def quadrature(radius):
        way = np.column_stack([u - radius, v, np.full(u.size, -z)])
        passed = lb.trace(lens, [radius, 0.0, lens.length + z], way).fate == lb.Fate.PASSED
        return (passed * (z * z / (way**2).sum(1)) ** 2).sum()

    axis = quadrature(0.0)
    for k in (5, len(edges) // 2, -1):
        # 300 cells across a region resolve its rim to about a hundredth at the worst
        assert inner[k] == pytest.approx(quadrature(edges[k]) / axis, rel=0.01)


@pytest.mark.parametrize("lens", [
    replace(DGAUSS, blades=5, blade_reach=1.0), lenses.load("pbrt-fisheye-10mm"),
    pytest.param(lenses.load("lentil-schneider-anamorphic-31-2001"), marks=pytest.mark.slow)],
    ids=["blades", "dark corners", "anamorphic"])
def test_pbrt_v4_149_a_sample_that_is_blocked_takes_no_part_in_depth(lens):
    """A wall at one metre is at one metre wherever any light arrives; what is blocked would draw it towards 0."""
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (1e5, 0.0, 0.0), (0.0, 1e5, 0.0), lb.Material((1.0,) * 3, "light"))
    scene, camera = lb.Scene("wall", sky=DARK, plates=(wall,)), lb.LensCamera(lens, FILM, 1500.0, dispersion=False)
    pictures = {}
    for view in ("depth", "weight", "direction", ""):
        rendering = lb.Rendering(camera, scene, view=view)
        rendering.add(16)
        pictures[view] = rendering.image()
    passing = np.mean(camera.generate_rays(np.tile([45.0, 30.0], (500, 1)), lattice(500)).weights > 0.0)
    lit = pictures["weight"][..., 0] > 0.0
    assert lit.mean() > 0.3 and (passing < 0.999 or not lit.all())
    np.testing.assert_allclose(pictures["depth"][lit], 1.0, atol=2e-5)          # 1/m, in float32
    assert not pictures["depth"][~lit].any()
    # Nor in direction: near the axis the mean of unit vectors of a narrow pencil is a unit vector but for its width
    middle = 2.0 * pictures["direction"][30, 45] - 1.0
    assert 0.9 < np.linalg.norm(middle) <= 1.0 + 1e-6 and middle[2] < -0.9
    # In the colour it does: the picture of a white wall is the weight, and falls off
    np.testing.assert_allclose(pictures[""], pictures["weight"], atol=1e-5)


@pytest.mark.parametrize(("blades", "area"), [(3, 1.5 * math.sin(2 * math.pi / 3)), (4, 2.0), (6, 1.5 * math.sqrt(3))])
def test_pbrt_v4_122f079e_a_stop_with_straight_sides_has_the_area_and_the_extent_of_its_polygon(blades, area):
    """On a film that is not square, which is what stretched the other's."""
    lens, n = replace(lb.stopped_down(DGAUSS, 5.6), blades=blades, blade_reach=1.0), 1 << 14
    cameras = [lb.LensCamera(it, FILM, 2000.0, weights="physical") for it in (lens, replace(lens, blades=0))]
    rays = [it.generate_rays(np.tile([45.0, 30.0], (n, 1)), lattice(n)) for it in cameras]
    light = [it.weights.mean() for it in rays]
    assert light[0] / light[1] == pytest.approx(area / math.pi, rel=3e-3)      # but for the pupil's aberration
    lit = rays[0].weights > 0.0
    origin = rays[0].origins[lit] + [0.0, 0.0, lens.length + cameras[0].film_distance]
    back = lb.trace(lens, origin, -rays[0].directions[lit], record=True, clip=False)
    x, y = back.paths[:, 1 + lens.stop_index, :2].T / lens.stop.semi_diameter
    # A corner stands at the top: the polygon's outermost points, which the lattice meets to 3 / √n
    corners = 0.5 * math.pi + 2.0 * math.pi * np.arange(blades) / blades
    for found, true in ((x.max(), np.cos(corners).max()), (y.max(), 1.0), (x.min(), np.cos(corners).min()),
                        (y.min(), np.sin(corners).min())):
        assert found == pytest.approx(true, abs=3.0 / math.sqrt(n))


CAMERAS = {
    "perspective": lb.PerspectiveCamera(FILM), "lens": lb.PerspectiveCamera(FILM, 0.7, 10.0, 900.0),
    "orthographic": lb.OrthographicCamera(FILM, 300.0), "pinhole": lb.PinholeCamera(FILM, 30.0, 0.7),
    "bare": lb.BareSensor(FILM), **{layout: lb.EnvironmentCamera(FILM, layout) for layout in LAYOUTS},
    **{projection: lb.FisheyeCamera(FILM, 3.0, projection) for projection in PROJECTIONS},
    **{model: lb.LensCamera(DGAUSS, FILM, 900.0, model=model)
       for model in ("trace", "polynomial", "thick", "thin", "pinhole")},
}


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=[f"{k} {i}" for i, k in enumerate(CAMERAS)])
def test_pbrt_v4_279_every_camera_knows_the_importance_of_its_own_rays(camera):
    """There a camera without densities ends the program; here every ray that a camera sends has them."""
    random = np.random.default_rng(2)
    raster, uv = random.uniform(0.05, 0.95, (300, 2)) * [90.0, 60.0], random.random((300, 2))
    rays = camera.generate_rays(raster, uv)
    lit = rays.weights > 0.0
    found = camera.importance(rays.origins[lit], rays.directions[lit])
    # rays by a polynomial are the lens's to a few thousandths of a pixel: at the rim some are beyond it
    assert found.visible.mean() > (0.99 if getattr(camera, "model", "") == "polynomial" else 0.9999)
    for values in (found.we, found.position_pdf, found.direction_pdf):
        assert np.isfinite(values).all() and (values[found.visible] > 0.0).all()
    np.testing.assert_allclose(found.raster[found.visible], raster[lit][found.visible], atol=1e-2)


@pytest.mark.parametrize("light_tracing", [True, False])
def test_pbrt_v4_458_half_of_the_lens_covered_is_half_of_the_light(light_tracing):
    """What the scene blocks counts as nothing in the mean over the lens, from the light's side too."""
    light = lb.Sphere((0.0, 0.0, -8000.0), 60.0, lb.Material((50.0,) * 3, "light"))
    cover = lb.Rectangle((-500.0, 0.0, -40.0), (500.0, 0.0, 0.0), (0.0, 900.0, 0.0), lb.Material((0.0,) * 3))
    camera = lb.PerspectiveCamera(FILM, 0.5, 12.0, 1500.0)
    total = []
    for plates in ((), (cover,)):
        scene = lb.Scene("light", sky=DARK, spheres=(light,), plates=plates)
        rendering = lb.Rendering(camera, scene, 3, light_tracing=light_tracing)
        rendering.add(256 if light_tracing else 2048)
        assert bool(rendering.light_traced) == light_tracing
        total.append(rendering.image().astype(float).sum())
    assert total[1] / total[0] == pytest.approx(0.5, rel=0.01)


@pytest.mark.parametrize(("width", "height", "pixels", "efl"), [(22.3, 14.9, (6000, 4000), 35.0),
                                                                (6.17, 4.55, (4000, 3000), 4.5)])
def test_pbrt_v4_147_sensor_pixels_and_focal_length_are_set_together(width, height, pixels, efl):
    lens = DGAUSS.scaled(efl / lb.first_order(DGAUSS).efl)
    film = lb.Film(width, height, *pixels)
    camera = lb.LensCamera(lens, film, math.inf, model="thick")
    corners = np.array([[0.0, 0.5 * pixels[1]], [pixels[0], 0.5 * pixels[1]]])
    left, right = camera.generate_rays(corners, np.full((2, 2), 0.5)).directions
    assert math.acos(left @ right) == pytest.approx(2.0 * math.atan(width / (2.0 * efl)), rel=1e-9)
    assert camera.intrinsics == pytest.approx((efl / (width / pixels[0]), efl / (height / pixels[1]),
                                               pixels[0] / 2, pixels[1] / 2), rel=1e-9)


def test_pbrt_v4_102_points_are_reconstructed_from_two_pictures_by_their_calibration_matrices():
    """A wrong convention of film and field of view skews what is reconstructed; here it is exact."""
    points = np.random.default_rng(3).uniform([-300.0, -200.0, -2500.0], [300.0, 200.0, -1500.0], (40, 3))
    eyes, ways = [], []
    for eye in ((-400.0, 50.0, 100.0), (500.0, -80.0, 0.0)):
        camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 960, 640), 0.9, world_from_camera=lb.look_at(
            eye, (0.0, 0.0, -2000.0)))
        raster, visible = camera.raster_from_point(points)
        assert visible.all()
        rays = np.linalg.solve(camera.intrinsics.matrix, np.column_stack([raster, np.ones(40)]).T).T
        eyes.append(np.asarray(eye))
        ways.append(rays * [1.0, -1.0, -1.0] @ camera.placement()[:3, :3].T)    # y down and z ahead, to the camera's
    for point, a, b in zip(points, *ways, strict=True):
        s, _ = np.linalg.lstsq(np.column_stack([a, -b]), eyes[1] - eyes[0], rcond=None)[0]
        np.testing.assert_allclose(eyes[0] + s * a, point, atol=1e-8)


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow) if "anamorphic" in name else name
                                  for name in CLASSICS])
def test_pbrt_v3_331_and_v4_349_no_weight_is_no_number_and_none_is_a_firefly(name):
    """At every stop, from the axis to beyond the light, at every corner of the unit square."""
    lens = lenses.load(name)
    random = np.random.default_rng(4)
    uv = np.concatenate([random.random((400, 2)), [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.5, 0.5]]])
    raster = np.concatenate([random.random((400, 2)) * [90.0, 60.0],
                             [[45.0, 30.0], [0.0, 0.0], [90.0, 60.0], [45.0, 0.0], [0.0, 30.0]]])
    film = lb.Film(72.0, 48.0, 90, 60)                      # twice the full frame: beyond many circles of light
    for share in (1.0, 0.1, 1e-3):
        camera = lb.LensCamera(lens.with_stop_radius(share * lens.stop.semi_diameter), film, math.inf)
        rays = camera.generate_rays(raster, uv, dtype=np.float32)
        assert np.isfinite(rays.weights).all() and (rays.weights >= 0.0).all()
        lit = rays.weights > 0.0
        assert np.isfinite(rays.origins[lit]).all() and np.isfinite(rays.directions[lit]).all()
        np.testing.assert_allclose(np.linalg.norm(rays.directions[lit], axis=1), 1.0, atol=1e-5)      # float32
        # Near 1, for cos⁴ never exceeds it and nearly all samples pass; only a pinprick of a stop, whose region moves
        # by many times its own size from ring to ring, is found by few, and these count for the others
        assert rays.weights.max() < (4.0 if share >= 0.1 else 40.0)
