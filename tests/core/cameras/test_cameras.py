"""Cameras: ideal lenses image points to points, and the trace gives the light that quadrature finds."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import DATA, behind_stop

FILM = lb.Film(36.0, 24.0, 960, 640)
UNIT = st.floats(0.0, 1.0, exclude_max=True)
ACROSS, DOWN = st.floats(0.0, 960.0), st.floats(0.0, 640.0)


def dgauss() -> lb.Lens:
    return lenses.load("pbrt-dgauss-50mm")


def film_point(raster_xy):
    """Where a raster point lies on the film, camera frame: the rule of the design page, written out."""
    x, y = np.asarray(raster_xy, float).T
    return np.column_stack([(0.5 - x / 960) * 36.0, (y / 640 - 0.5) * 24.0, np.zeros(len(x))])


def meet(rays, z):
    """Where rays cross the plane z of the camera frame."""
    t = (z - rays.origins[:, 2]) / rays.directions[:, 2]
    return (rays.origins + t[:, None] * rays.directions)[:, :2]


@settings(max_examples=40)
@given(ACROSS, DOWN, st.lists(st.tuples(UNIT, UNIT), min_size=2, max_size=20), st.floats(400.0, 1e5))
def test_every_ray_of_a_film_point_meets_at_the_focus_plane(x, y, uv, distance):
    film_xy = film_point([[x, y]])[0, :2]
    for camera in (lb.LensCamera(dgauss(), FILM, distance, 2.8, model="thin"),
                   lb.PerspectiveCamera(FILM, fov=0.7, lens_radius=9.0, focus_distance=distance)):
        rays = camera.generate_rays([[x, y]] * len(uv), uv)
        points = meet(rays, -distance)
        if isinstance(camera, lb.LensCamera):
            fo = camera.first_order
            s_p = distance - camera.film_distance - camera.lens.length + fo.front_principal
            m = fo.efl / (s_p - fo.efl)
        else:
            m = camera.film_distance / distance
            if x == 480.0 and y == 320.0:
                assert np.allclose(points, 0.0)
            film_xy = film_point([[x, y]])[0, :2] * (2.0 * camera.film_distance * math.tan(0.35) / 24.0)
        np.testing.assert_allclose(points, np.tile(-film_xy / m, (len(uv), 1)), rtol=1e-9, atol=1e-9 * distance)


def test_at_infinity_all_rays_of_a_film_point_are_parallel():
    uv = np.random.default_rng(0).random((50, 2))
    for camera in (lb.LensCamera(dgauss(), FILM, math.inf, model="thin"), lb.PerspectiveCamera(FILM, lens_radius=5.0)):
        rays = camera.generate_rays(np.tile([100.0, 50.0], (50, 1)), uv)
        assert np.ptp(rays.directions, axis=0).max() < 1e-14
        assert np.ptp(rays.origins[:, 0]) > 4.0


def test_the_picture_is_upright_and_the_right_side_is_right():
    """A point up and to the right in the world is up (small y) and right (large x) in the raster."""
    for model in ("trace", "thick", "thin", "pinhole"):
        camera = lb.LensCamera(dgauss(), FILM, 2000.0, 4.0, model=model)
        ray = camera.generate_rays([[700.0, 100.0]], [camera.pupil_centre])
        assert ray.directions[0, 0] > 0.05 and ray.directions[0, 1] > 0.05 and ray.directions[0, 2] < -0.9
    ray = lb.PerspectiveCamera(FILM).generate_rays([[700.0, 100.0]], [[0.5, 0.5]])
    assert ray.directions[0, 0] > 0.05 and ray.directions[0, 1] > 0.05


def test_the_field_of_view_spans_the_shorter_side():
    for film in (FILM, lb.Film(24.0, 36.0, 640, 960)):
        camera = lb.PerspectiveCamera(film, fov=1.0)
        edge = [[film.pixels_x / 2, 0.0]] if film is FILM else [[film.pixels_x, film.pixels_y / 2]]
        d = camera.generate_rays(edge, [[0.5, 0.5]]).directions[0]
        assert math.acos(-d[2]) == pytest.approx(0.5, abs=1e-14)


def test_a_traced_ray_is_the_reference_ray_through_the_same_two_points():
    camera = lb.LensCamera(dgauss(), FILM, 1500.0, 2.8)
    rng = np.random.default_rng(2)
    raster, uv = rng.random((2000, 2)) * [960, 640], rng.random((2000, 2))
    rays = camera.generate_rays(raster, uv)
    shift = np.array([0.0, 0.0, camera.lens.length + camera.film_distance])
    back = lb.trace(camera.lens, rays.origins + shift, -rays.directions)        # reversibility: back to the film
    lit = rays.weights > 0.0
    assert (back.fate[lit] == lb.Fate.PASSED).all()
    points = back.points[lit] - shift
    landed = points[:, :2] - points[:, 2:] / back.directions[lit, 2:] * back.directions[lit, :2]
    np.testing.assert_allclose(landed, film_point(raster)[lit, :2], atol=1e-9)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_cos4_over_z2_is_pbrts_ray_by_ray(name):
    """pbrt's weight is cos⁴θ · A / z² with A its box's area; its simple weight is cos⁴θ · A / A(axis)."""
    reference = json.loads((DATA / "pbrt_weights.json").read_text())[name]
    lens = lenses.load(name)
    z = reference["film_distance"]
    for film_xy, out_o, out_d, value in reference["rays"]:
        shift = np.array([0.0, 0.0, lens.length + z])
        back = lb.trace(lens, np.array(out_o) + shift, -np.array(out_d), clip=False)
        assert back.fate[0] == lb.Fate.PASSED
        p = back.points[0] - shift
        d = back.directions[0]
        np.testing.assert_allclose(p[:2] - p[2] / d[2] * d[:2], film_xy, atol=2e-7)     # pbrt: the same ray
        assert d[2]**4 / z**2 == pytest.approx(value, rel=1e-6)


def grid_irradiance(camera, film_xy, cells=700):
    """(1/z²) ∫ cos⁴θ dA by a fine grid of reference rays over the rear plane."""
    lens, z = camera.lens, camera.film_distance
    reach = 1.15 * lens.surfaces[-1].semi_diameter
    side = (np.arange(cells) + 0.5) / cells * 2.0 * reach - reach
    px, py = (a.ravel() for a in np.meshgrid(side, side))
    d = np.column_stack([px - film_xy[0], py - film_xy[1], np.full(px.size, -z)])
    passed = lb.trace(lens, [*film_xy, lens.length + z], d).fate == lb.Fate.PASSED
    cos2 = z * z / (d**2).sum(1)
    return (passed * cos2**2).sum() * (side[1] - side[0])**2 / z**2


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", *(pytest.param(name, marks=pytest.mark.slow)
                                                        for name in ("lenshh-cooke-triplet-50", "pbrt-wide-22mm"))])
def test_a_uniform_white_scene_gives_the_falloff_of_quadrature(name):
    """Within 0.1 % of the axis: the grid's edge errs by about 1e-4, the samples' lattice by 5e-4."""
    camera = lb.LensCamera(lenses.load(name), FILM, 2000.0)
    n = 1 << 15
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    axis = grid_irradiance(camera, (0.0, 0.0))
    for raster in ([480.0, 320.0], [600.0, 250.0], [820.0, 500.0], [930.0, 20.0]):
        weights = camera.generate_rays(np.tile(raster, (n, 1)), uv).weights
        relative = grid_irradiance(camera, film_point([raster])[0, :2]) / axis
        assert weights.mean() == pytest.approx(relative, abs=1e-3)


def test_on_the_axis_the_physical_weight_is_pi_sin2_times_the_open_time():
    """E = π L sin²θ′ (mean of cos⁴ A / z² over the pupil), times the shutter's time."""
    n = 4096
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    lens = dgauss()
    camera = lb.LensCamera(lens, FILM, math.inf, 4.0, weights="physical", shutter_open=1.0, shutter_close=1.008)
    mean = camera.generate_rays(np.tile([480.0, 320.0], (n, 1)), uv).weights.mean()
    sine = 1.0 / (2.0 * lb.working_f_number(camera.lens, camera.film_distance))
    assert mean == pytest.approx(math.pi * sine**2 * 0.008, rel=2e-3)
    thin = lb.LensCamera(lens, FILM, math.inf, 4.0, model="thin", weights="physical", shutter_close=0.008)
    fo = thin.first_order
    sine2 = fo.entrance_pupil.radius**2 / (fo.entrance_pupil.radius**2 + fo.efl**2)
    mean = thin.generate_rays(np.tile([480.0, 320.0], (n, 1)), uv).weights.mean()
    assert mean == pytest.approx(math.pi * sine2 * 0.008, rel=1e-3)


@pytest.mark.parametrize("model", ["trace", "thick", "thin", "pinhole"])
def test_the_axis_point_has_weight_one_whatever_the_stop(model):
    n = 4096
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    for f_number in (None, 5.6, 22.0):
        camera = lb.LensCamera(dgauss(), FILM, 1200.0, f_number, model=model)
        assert camera.generate_rays(np.tile([480.0, 320.0], (n, 1)), uv).weights.mean() == pytest.approx(1.0, abs=1e-3)


def test_a_pinhole_passes_the_light_of_the_thin_lens_that_it_stands_for():
    """π r² / z² · open time, where the thin lens collects π r² / (z² + r²)."""
    middle = [[480.0, 320.0]]
    uv = np.random.default_rng(0).random((4000, 2))
    for f_number, seconds in ((2.8, 0.01), (16.0, 0.01), (16.0, 0.5)):
        thin, hole = (lb.LensCamera(dgauss(), FILM, 900.0, f_number, model=model, weights="physical",
                                    shutter_close=seconds) for model in ("thin", "pinhole"))
        expected = thin.generate_rays(np.tile(middle, (4000, 1)), uv).weights.mean()
        weight = hole.generate_rays(middle, [[0.5, 0.5]]).weights[0]
        sine2 = expected / math.pi / seconds
        assert weight == pytest.approx(expected / (1.0 - sine2), rel=1e-3)


@pytest.mark.parametrize("name", ["lib-miyamoto-fisheye-1964", "lenshh-petzval", "lentil-zeiss-flektogon-1954"])
def test_no_weight_is_negative_where_the_region_dies_away(name):
    camera = lb.LensCamera(lenses.load(name), lb.Film(44.0, 30.0))
    end = camera.pupil.dark_beyond
    rng = np.random.default_rng(0)
    x = 480.0 + np.linspace(0.99, 1.001, 40_000) * end / 44.0 * 960.0
    for real in (np.float32, np.float64):
        weights = camera.generate_rays(np.column_stack([x, np.full(x.size, 320.0)]), rng.random((x.size, 2)),
                                       dtype=real).weights
        assert weights.max() > 0.0 and (weights >= 0.0).all()


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("model", ["trace", "thick", "thin", "pinhole"])
def test_the_edges_of_the_unit_square_belong_to_the_pupil_and_nothing_beyond_does(model, real):
    camera = lb.LensCamera(dgauss(), FILM, 2000.0, model=model)
    edges = np.array([[1.0, 1.0], [1.0 - 1e-12, 0.5], [0.0, 1.0], [1.0, 0.0]])
    inside = np.clip(edges, 1e-6, 1.0 - 1e-6)
    a, b = (camera.generate_rays(np.tile([300.0, 200.0], (4, 1)), uv, dtype=real) for uv in (edges, inside))
    assert np.abs(a.directions - b.directions).max() < 1e-3
    for uv in ([[1.01, 0.5]], [[0.5, -0.01]], [[math.nan, 0.5]]):
        with pytest.raises(ValueError, match="unit square"):
            camera.generate_rays([[300.0, 200.0]], uv, dtype=real)
    with pytest.raises(ValueError, match="finite"):
        camera.generate_rays([[300.0, math.nan]], [[0.5, 0.5]], dtype=real)


def test_pinhole_weights_fall_as_the_fourth_power_of_the_cosine():
    camera = lb.PerspectiveCamera(FILM, fov=1.2)
    rays = camera.generate_rays(np.random.default_rng(0).random((300, 2)) * [960, 640], np.full((300, 2), 0.5))
    np.testing.assert_allclose(rays.weights, rays.directions[:, 2]**4, rtol=1e-12)


def test_a_closed_lens_and_a_dark_film_point_give_nothing_and_no_nan():
    lens = lenses.load("pbrt-fisheye-10mm")
    camera = lb.LensCamera(lens, lb.Film(110.0, 72.0, 96, 64), 1000.0)
    y, x = np.mgrid[0:64, 0:96] + 0.5
    rays = camera.generate_rays(np.column_stack([x.ravel(), y.ravel()]), np.full((96 * 64, 2), 0.4))
    assert np.isfinite(rays.weights).all() and (rays.weights >= 0.0).all()
    assert rays.weights.reshape(64, 96)[0, 0] == 0.0 and rays.weights.max() > 0.0
    tiny = lb.LensCamera(lens.with_stop_radius(0.01), FILM, 1000.0)
    w = tiny.generate_rays(np.tile([480.0, 320.0], (500, 1)), np.random.default_rng(0).random((500, 2))).weights
    assert 0.95 < (w > 0.0).mean() <= 1.0


def test_the_camera_is_placed_by_its_transform():
    turn = np.array([[0.0, 0.0, -1.0, 10.0], [0.0, 1.0, 0.0, 20.0], [1.0, 0.0, 0.0, 30.0], [0.0, 0.0, 0.0, 1.0]])
    here, there = (lb.LensCamera(dgauss(), FILM, 2000.0, 4.0, world_from_camera=m) for m in (np.eye(4), turn))
    a, b = (camera.generate_rays([[100.0, 100.0]], [[0.3, 0.4]]) for camera in (here, there))
    np.testing.assert_allclose(b.directions, a.directions @ turn[:3, :3].T, atol=1e-14)
    np.testing.assert_allclose(b.origins, a.origins @ turn[:3, :3].T + turn[:3, 3], atol=1e-11)


def test_single_precision_rays_are_the_double_ones_to_their_digits():
    camera = lb.LensCamera(dgauss(), FILM, 1200.0, 2.0)
    rng = np.random.default_rng(0)
    raster, uv = rng.random((3000, 2)) * [960, 640], rng.random((3000, 2))
    a, b = (camera.generate_rays(raster, uv, dtype=real) for real in (np.float32, np.float64))
    both = (a.weights > 0.0) & (b.weights > 0.0)
    assert (a.weights > 0.0).sum() == pytest.approx((b.weights > 0.0).sum(), abs=3)
    assert np.abs(a.directions - b.directions)[both].max() < 1e-4       # the table's corner may round the other way


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.PerspectiveCamera(FILM, fov=0.0), "between 0° and 180°"),
    (lambda: lb.PerspectiveCamera(FILM, fov=math.pi), "between 0° and 180°"),
    (lambda: lb.PerspectiveCamera(FILM, lens_radius=-1.0), "lens radius"),
    (lambda: lb.PerspectiveCamera(FILM, focus_distance=0.0), "focus distance"),
    (lambda: lb.PerspectiveCamera(FILM, focus_distance=math.nan), "focus distance"),
    (lambda: lb.PerspectiveCamera(FILM, weights="loud"), "relative, physical or radiance"),
    (lambda: lb.PerspectiveCamera(FILM, shutter_open=2.0), "before it opens"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=np.zeros((4, 4))), "last row"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=np.diag([1.0, 1.0, 0.0, 1.0])), "singular"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=np.diag([1.0, 1.0, -1.0, 1.0])), "mirrors"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=np.diag([2.0, 2.0, 2.0, 1.0])), "stretches"),
    (lambda: lb.PerspectiveCamera(FILM, weights="physical"), "no area"),
    (lambda: lb.LensCamera(behind_stop(0.0), FILM, 600.0, model="thin"), "entrance pupil"),
    (lambda: lb.LensCamera(behind_stop(3.0), FILM, 600.0, model="pinhole"), "entrance pupil"),
    (lambda: lb.LensCamera(lb.Lens((lb.Surface(4.0, 8.0, lb.Glass(1.5), curvature=0.05),), 0), FILM), "ends in glass"),
    (lambda: lb.LensCamera(behind_stop(20.0), FILM), "before its last vertex"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=np.full((4, 4), math.nan)), "finite"),
    (lambda: lb.LensCamera(dgauss(), FILM, model="magic"), "trace, polynomial, thick, thin, pinhole"),
    (lambda: lb.LensCamera(dgauss(), FILM, 100.0), "nearest distance of this lens is 0.196 m"),
    (lambda: lb.LensCamera(dgauss(), FILM, f_number=0.7), "f/2"),
    (lambda: lb.LensCamera(dgauss(), FILM, f_number=0.0), "f-number"),
    (lambda: lb.LensCamera(dgauss(), FILM, f_number=-2.0), "f-number"),
    (lambda: lb.LensCamera(dgauss(), FILM, f_number=math.nan), "f-number"),
    (lambda: lb.LensCamera(dgauss(), FILM, math.nan), "focus"),
    (lambda: lb.Film(0.0, 24.0), "film width"),
    (lambda: lb.Film(36.0, 24.0, 0, 640), "pixels"),
    (lambda: lb.Film(36.0, 24.0, 10**6, 640), "million"),
    (lambda: lb.Film(36.0, 24.0, 960, math.nan), "pixels"),
    (lambda: lb.Film(36.0, 24.0, math.inf, 640), "pixels"),
    (lambda: lb.Film(36.0, 24.0, 2**24 + 1, 1), "pixels"),
])
def test_invalid_settings_are_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm"])
def test_the_irradiance_falls_off_over_the_film_as_pbrts_mean_weight_does(name):
    """pbrt's means are of 262,144 Halton points over a box of which the region fills a fifth: 2e-3;
    the sampled region may lose 5e-4 of what the axis gets."""
    reference = json.loads((DATA / "pbrt_weights.json").read_text())[name]
    lens, z = lenses.load(name), reference["film_distance"]
    radii = np.array([r for r, _ in reference["falloff"]])
    expected = np.array([mean for _, mean in reference["falloff"]])
    pupil = lb.exit_pupil(lens, z, [0.0, radii.max()])
    n = 1 << 14
    uv = np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])
    for r, mean in zip(radii, expected, strict=True):
        points, areas = pupil.sample(np.tile([r, 0.0], (n, 1)), uv)
        d = np.column_stack([points - [r, 0.0], np.full(n, -z)])
        passed = lb.trace(lens, [r, 0.0, lens.length + z], d).fate == lb.Fate.PASSED
        cos4 = (z * z / (d**2).sum(1)) ** 2
        assert (cos4 * areas * passed).mean() / z**2 == pytest.approx(mean, abs=2e-3 * mean + 5e-4 * expected[0])


@pytest.mark.parametrize(("focus", "f_number", "limit"), [
    (2000.0, 2.8, 0.03), (900.0, 8.0, 0.02), (30000.0, 4.0, 0.03)])
def test_the_depth_of_field_ends_where_the_traced_blur_crosses_the_limit(focus, f_number, limit):
    lens = lb.Lens((lb.Surface(1e-6, 20.0, lb.Glass(1.5), curvature=0.02), lb.Surface(0.0, 20.0, curvature=-0.02)),
                   0)      # 50 mm, thin
    camera = lb.LensCamera(lens, FILM, focus, f_number, model="thin")
    fo = camera.first_order
    from_lens = focus - camera.film_distance - lens.length      # the formulas measure from the lens

    def blur(distance):
        """Diameter on the film (mm) of a point on the axis: by the film points whose rays meet it through the rim."""
        rims = np.array([[0.5, 0.0], [0.5, 1.0], [0.0, 0.5], [1.0, 0.5]])
        z = -(distance + focus - from_lens)
        raster, _ = camera.raster_from_point(np.tile([0.0, 0.0, z], (4, 1)), rims)
        rays = camera.generate_rays(raster, rims)
        np.testing.assert_allclose(meet(rays, z), 0.0, atol=1e-6)
        film = film_point(raster)[:, :2]
        return np.hypot(*(film[:2] - film[2:]).T).mean() * math.sqrt(2.0)

    near, far = lb.depth_of_field(fo.efl, fo.f_number, from_lens, limit)
    for end, inner, outer in ((near, from_lens, 0.3 * from_lens), (far, from_lens, 50.0 * from_lens)):
        if math.isinf(end):
            assert blur(1e7) < limit
            continue
        for _ in range(60):
            middle = 0.5 * (inner + outer)
            inner, outer = (middle, outer) if blur(middle) < limit else (inner, middle)
        assert end == pytest.approx(inner, rel=0.005)


@pytest.mark.parametrize("name, f_number", [("pbrt-dgauss-50mm", 4.0), ("pbrt-telephoto-250mm", 8.0)])
def test_a_pupil_sample_is_the_same_point_of_the_pupil_in_every_camera(name, f_number):
    """The point of the entrance pupil, for film points near the axis; aberrations of the pupil are a few percent."""
    raster, uv = np.random.default_rng(0).random((2, 500, 2))
    raster = [480.0, 320.0] + (raster - 0.5) * [150.0, 150.0]
    for model in ("trace", "thick", "thin"):
        camera = lb.LensCamera(lenses.load(name), FILM, 5000.0, f_number, model=model)
        pupil, origin = camera.first_order.entrance_pupil, camera.lens.length + camera.film_distance
        points = meet(camera.generate_rays(raster, uv), pupil.z - origin)
        assert np.hypot(*(points / pupil.radius - lb.unit_disk(uv)).T).max() < 0.05
        middle = meet(camera.generate_rays(raster, np.full((500, 2), 0.5)), pupil.z - origin)
        assert np.hypot(*middle.T).max() < 0.05 * pupil.radius


def test_the_foremost_point_of_a_concave_front_is_its_rim():
    """A meniscus, hollow towards the scene: its rim lies before the vertex by the sagitta of the sphere."""
    meniscus = lb.Lens((lb.Surface(4.0, 10.0, lb.Glass(1.6), curvature=-1.0 / 80.0),
                        lb.Surface(0.0, 10.0, curvature=-1.0 / 25.0)), 0)
    camera = lb.LensCamera(meniscus, FILM, 3000.0)
    vertex = -4.0 - camera.film_distance
    assert camera.front == pytest.approx(vertex - (80.0 - math.sqrt(80.0**2 - 10.0**2)), rel=1e-12)
    assert lb.LensCamera(dgauss(), FILM, 3000.0).front == pytest.approx(
        -dgauss().length - lb.film_distance(dgauss(), 3000.0), rel=1e-12)


@pytest.mark.parametrize("method", ["paraxial", "real"])
def test_a_camera_focuses_down_to_its_nearest_focus_and_from_a_placed_film(method):
    lens = lenses.load("lenshh-cooke-triplet-50")
    placed = lb.LensCamera(lens, FILM, film_at=45.0, focus_method=method)
    assert placed.nearest_focus == pytest.approx(lb.nearest_focus(lens, method), rel=1e-12)
    for distance in (placed.nearest_focus, 1500.0):
        camera = placed.refocused(distance)
        assert camera.focus_distance == distance
        assert camera.film_distance == pytest.approx(lb.film_distance(lens, distance, method), rel=1e-9)
    assert lb.nearest_focus(lens, "real") != pytest.approx(lb.nearest_focus(lens), rel=1e-4)
