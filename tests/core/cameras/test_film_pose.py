"""A tilted or shifted film: its light, its projection, and the plane in focus, against geometry of their own."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.focus_wedge import sharp_focus
from lensbench.core.cameras.film_landing import FilmImportance
from lensbench.core.imaging.film import UPRIGHT, FilmError, FilmPose
from lensbench.core.kernels.block import WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.scalar_trace import Fate, trace

FILM = lb.Film(36.0, 24.0, 360, 240)
TRIPLET = lenses.load("lenshh-cooke-triplet-50")
DEGREE = math.radians(1.0)
POSED = FilmPose(8.0 * DEGREE, -5.0 * DEGREE, 4.0, 3.0)
CURVED = FilmPose(3.0 * DEGREE, 2.0 * DEGREE, 1.0, -2.0, radius=-45.0)


def camera(pose=POSED, model="trace", f_number=5.6, focus=2000.0, film=FILM, **more) -> lb.LensCamera:
    return lb.LensCamera(TRIPLET, film, focus, f_number, model, film_pose=pose, **more)


def samples(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.random((n, 2)) * [360.0, 240.0], random.random((n, 2))


def test_a_film_in_line_runs_the_same_stages_with_the_same_numbers():
    before, after = lb.LensCamera(TRIPLET, FILM, 2000.0, 5.6), camera(UPRIGHT)
    for model in ("trace", "thin"):
        for one, two in zip(replace(before, model=model).steps(), replace(after, model=model).steps(), strict=True):
            assert one.kernel is two.kernel and np.array_equal(one.parameters, two.parameters)
    assert FilmPose(0.0, 0.0).is_upright and not FilmPose(1e-9).is_upright


def normal(pose: FilmPose, point) -> np.ndarray:
    """Unit normal away from the lens, by the centre of curvature."""
    return pose.axes[2] if not pose.is_curved else (pose.centre + pose.radius * pose.axes[2] - point) / pose.radius


def test_points_of_a_curved_film_lie_on_its_sphere_and_lines_come_back_to_them():
    for pose in (CURVED, FilmPose(radius=60.0)):
        film = np.random.default_rng(2).uniform(-1.0, 1.0, (60, 2)) * [18.0, 12.0]
        points, middle = pose.points(film), pose.centre + pose.radius * pose.axes[2]
        assert np.linalg.norm(points - middle, axis=1) == pytest.approx(abs(pose.radius), rel=1e-14)
        assert (points - pose.centre) @ pose.axes[:2].T == pytest.approx(film, abs=1e-12)
        assert np.sign((points - pose.centre) @ pose.axes[2]) == pytest.approx(np.sign(pose.radius))
        slopes = np.random.default_rng(3).normal(0.0, 0.3, (60, 2))
        assert pose.film_points(points[:, :2] - points[:, 2:] * slopes, slopes) == pytest.approx(film, abs=1e-11)
        assert pose.normals(points) == pytest.approx(np.array([normal(pose, point) for point in points]), abs=1e-14)


def test_a_line_to_a_lit_side_of_a_film_whose_middle_turns_its_back_comes_back_to_it():
    """Tilted and swung by 45° and more, a film can be lit at a curved side and not in its middle."""
    pose, random = FilmPose(tilt=0.84, swing=-0.80, rise=-4.4, shift=10.8, radius=48.7), np.random.default_rng(1)
    film = random.uniform(-1.0, 1.0, (20_000, 2)) * [18.0, 12.0]
    points = pose.points(film)
    ways = points - np.column_stack([random.uniform(-12.0, 12.0, (20_000, 2)), random.uniform(-80.0, -35.0, 20_000)])
    steep = (ways @ pose.axes[2] < 0.0) & ((ways * pose.normals(points)).sum(1) > 1.0) & (ways[:, 2] > 1.0)
    slopes = ways[steep, :2] / ways[steep, 2:]
    assert steep.sum() > 10
    found = pose.film_points(points[steep, :2] - points[steep, 2:] * slopes, slopes)
    assert found == pytest.approx(film[steep], abs=1e-9)


def irradiance(cam: lb.LensCamera, raster, rays: int = 20_000) -> float:
    """∫ L cos θ cos φ dA / s² over the rear opening by rays of the scalar trace, over that of the axis."""
    lens = cam.lens
    film = cam.film_pose.points([[(0.5 - raster[0] / 360.0) * 36.0, (raster[1] / 240.0 - 0.5) * 24.0]])[0]
    reach = 1.3 * lens.surfaces[-1].semi_diameter
    r, turn = reach * np.sqrt((np.arange(rays) + 0.5) / rays), math.pi * (3.0 - math.sqrt(5.0)) * np.arange(rays)
    way = np.stack([r * np.cos(turn), r * np.sin(turn), np.full(rays, -cam.film_distance)], 1) - film
    distance = np.linalg.norm(way, axis=1)
    way /= distance[:, None]
    passed = trace(lens, film + [0.0, 0.0, lens.length + cam.film_distance], way).fate == Fate.PASSED
    dense = np.where(passed, way[:, 2] * (way @ normal(cam.film_pose, film)) / distance**2, 0.0).mean()
    return float(dense * math.pi * reach**2 * cam.film_distance**2 / cam.axis_irradiance)


@pytest.mark.parametrize("pose, f_number", [(POSED, None), (FilmPose(20.0 * DEGREE), 11.0),
                                            (FilmPose(0.0, 0.0, 8.0, -6.0), None), (CURVED, None),
                                            (FilmPose(radius=40.0), 8.0)])
def test_a_film_point_gets_the_light_of_the_measurement_equation(pose, f_number):
    cam = camera(pose, f_number=f_number)
    for raster in ((180.0, 120.0), (30.0, 20.0), (340.0, 30.0), (20.0, 230.0)):
        weights = cam.generate_rays(np.tile(raster, (4096, 1)), samples(4096)[1]).weights
        assert weights.mean() == pytest.approx(irradiance(cam, raster), rel=0.02)      # noise of the rims: 1 %
        assert (weights > 0.0).mean() > 0.98                                            # hardly a ray is wasted


@pytest.mark.parametrize("pose", [FilmPose(12.0 * DEGREE, 7.0 * DEGREE), CURVED])
def test_an_ideal_lens_lights_a_tilted_or_curved_film_by_the_same_equation(pose):
    cam = camera(pose, "thin")
    lens, weights = cam.gaussian, []
    raster, uv = samples(64)[0], samples(2048)[1]
    film = cam.film_pose.points(np.stack([(0.5 - raster[:, 0] / 360.0) * 36.0, (raster[:, 1] / 240.0 - 0.5) * 24.0], 1))
    disk, behind = lb.unit_disk(uv) * lens.origin_pupil, -1.0 / lens.approach_film
    for at in film:
        way = np.column_stack([disk, np.full(len(disk), -behind)]) - at
        distance = np.linalg.norm(way, axis=1)
        dense = way[:, 2] * (way @ normal(pose, at)) / distance**4
        weights.append(dense.mean() * math.pi * lens.origin_pupil**2)
    axis = math.pi * lens.origin_pupil**2 / (behind**2 + lens.origin_pupil**2)      # π sin² of the half angle
    made = cam.generate_rays(np.repeat(raster, len(uv), 0), np.tile(uv, (64, 1))).weights.reshape(64, -1).mean(1)
    assert np.array(weights) / axis == pytest.approx(made, rel=1e-9)


@pytest.mark.parametrize("pose, model", [(POSED, "trace"), (POSED, "polynomial"), (POSED, "thick"), (POSED, "thin"),
                                         (POSED, "pinhole"), (CURVED, "trace"), (CURVED, "polynomial"),
                                         (CURVED, "thin")])
def test_points_of_its_rays_project_back_to_their_raster_points(pose, model):
    cam = camera(pose, model)
    raster, uv = samples(100)
    uv = 0.2 + 0.6 * uv
    rays = cam.generate_rays(raster, uv)
    found, seen = cam.raster_from_point(rays.origins + 1500.0 * rays.directions, uv)
    arrived = rays.weights > 0.0
    assert arrived.mean() > 0.9 and seen[arrived].all()
    assert np.abs(found - raster)[arrived].max() < 1e-6


def test_a_shifted_film_is_a_part_of_a_larger_one_in_line():
    # 10 px of the pitch 0.1 mm: the larger film shows the same points beside its middle
    wide = lb.Film(40.0, 28.0, 400, 280)
    points = np.random.default_rng(3).normal(0.0, 300.0, (50, 3)) - [0.0, 0.0, 2000.0]
    for model, error in (("thick", 1e-9), ("trace", 2e-3)):
        shifted, seen = camera(FilmPose(0.0, 0.0, 2.0, -1.0), model).raster_from_point(points)
        larger, _ = camera(UPRIGHT, model, film=wide).raster_from_point(points)
        assert seen.sum() > 20 and np.abs(larger - shifted - [10.0, 0.0])[seen].max() < error
    shifted, larger = camera(FilmPose(0.0, 0.0, 2.0, -1.0), "thin"), camera(UPRIGHT, "thin", film=wide)
    assert (larger.intrinsics.cx, larger.intrinsics.cy) == pytest.approx(
        (shifted.intrinsics.cx + 10.0, shifted.intrinsics.cy))
    with pytest.raises(lb.CameraError, match="perpendicular"):
        _ = camera(model="thin").intrinsics


@pytest.mark.parametrize("pose", [POSED, CURVED])
def test_light_traced_to_a_tilted_or_curved_film_lands_where_its_ray_comes_from(pose):
    cam = camera(pose)
    raster, uv = samples(400)
    rays = cam.generate_rays(raster, uv)
    arrived = rays.weights > 0.0
    landing = cam.film_landing()
    assert landing is not None
    given = dict(zip((X, Y, Z, L, M, N), (*rays.origins[arrived].T, *-rays.directions[arrived].T), strict=True))
    x, y, weight = Program(landing.steps, np.float64).run({**given, WEIGHT: np.ones(arrived.sum())}, [X, Y, WEIGHT],
                                                          int(arrived.sum()))
    assert np.abs(np.stack([x, y], 1) - raster[arrived]).max() < 1e-9
    film = np.stack([(0.5 - raster[arrived, 0] / 360.0) * 36.0, (raster[arrived, 1] / 240.0 - 0.5) * 24.0], 1)
    larger = np.array([1.0 / (normal(pose, point) @ pose.axes[2]) for point in pose.points(film)])      # pixels
    assert weight * larger == pytest.approx(camera(UPRIGHT).film_landing().steps[-1].parameters[4])     # an étendue
    assert camera(pose, "thin").film_landing() is None


def test_importance_is_what_the_camera_chooses_its_rays_with():
    for pose in (UPRIGHT, POSED, CURVED):
        cam = camera(pose, film=lb.Film(36.0, 24.0, 36, 24))
        raster, uv = samples(300)
        rays = cam.generate_rays(raster / 10.0, uv)
        arrived = rays.weights > 0.0
        found = cam.importance(rays.origins[arrived], rays.directions[arrived])
        assert isinstance(cam.film_importance(rays.origins, rays.directions), FilmImportance)
        assert np.abs(found.raster - raster[arrived] / 10.0).max() < 1e-9
        # Behind the lens, W cos θ = density · weight, θ from the axis of the lens
        film = np.stack([(0.5 - raster[:, 0] / 360.0) * 36.0, (raster[:, 1] / 240.0 - 0.5) * 24.0], 1)
        steps = Program(cam.camera_steps()[:1], np.float64)
        u = cam.stage_uv(film, uv)
        n = steps.run({X: film[:, 0], Y: film[:, 1], 0: u[:, 0], 1: u[:, 1]}, [N], len(film))[0]
        assert (found.we * -n[arrived]) == pytest.approx(
            found.position_pdf * found.direction_pdf * rays.weights[arrived], rel=1e-9)


@pytest.mark.parametrize("angle", [3.0, -10.0, 25.0])
def test_a_film_tilted_behind_a_thin_lens_meets_the_hinge_rule(angle):
    focal, turn = 80.0, math.radians(angle)
    thin = lb.Lens((lb.Surface(1e-9, 5.0, lb.Glass(2.0), curvature=1.0 / focal), lb.Surface(0.0, 5.0, curvature=0.0)),
                   0)
    cam = lb.LensCamera(thin, FILM, 1000.0, model="thin", film_pose=FilmPose(turn))
    found, centre = sharp_focus(cam, 0.03), -cam.film_distance
    assert found.hinge is not None and found.scheimpflug is not None
    # The hinge lies f / sin θ from the lens, along the film's direction, in its front focal plane
    away = found.hinge.point - [0.0, 0.0, centre]
    assert away == pytest.approx([0.0, -focal / math.tan(turn), -focal], rel=1e-6)
    assert np.linalg.norm(away) == pytest.approx(focal / abs(math.sin(turn)), rel=1e-6)
    # Film, lens and plane of sharp focus meet in the Scheimpflug line; wedge and plane meet in the hinge
    assert found.scheimpflug.point == pytest.approx([0.0, -cam.film_distance / math.tan(turn), centre], rel=1e-6)
    assert found.plane.distance([found.scheimpflug.point])[0] == pytest.approx(0.0, abs=1e-3)
    for plane in (found.plane, found.near, found.far):
        assert plane.distance([found.hinge.point])[0] == pytest.approx(0.0, abs=1e-3)
    assert abs(found.plane.distance([[0.0, 0.0, -1000.0]])[0]) < 1e-3


def blur(cam: lb.LensCamera, raster: np.ndarray) -> np.ndarray:
    """Largest distance (px) on the film between points in focus of one film point, by parts of the pupil; NaN: none."""
    plane, parts = sharp_focus(cam, 0.03).plane, []
    for each in samples(16, 5)[1]:
        rays = cam.generate_rays(raster, np.tile(each, (len(raster), 1)))
        along = -plane.distance(rays.origins) / (rays.directions @ plane.normal)
        seen = (rays.weights > 0.0) & (along > 0.0)
        parts.append(np.where(seen[:, None], rays.origins + along[:, None] * rays.directions, math.nan))
    meet = np.stack(parts)                                      # (parts, points, 3), each on the plane
    known = np.isfinite(meet).all((0, 2))
    assert known.sum() > 10
    found, _ = cam.raster_from_point(meet[:, known].reshape(-1, 3))
    return np.linalg.norm(np.ptp(found.reshape(len(parts), -1, 2), axis=0), axis=1)


def grid(part: float) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-part, part, 7), np.linspace(-part, part, 5))
    return np.stack([180.0 + 180.0 * x.ravel(), 120.0 + 120.0 * y.ravel()], 1)


@pytest.mark.parametrize("pose", [FilmPose(6.0 * DEGREE), FilmPose(-3.0 * DEGREE, 9.0 * DEGREE, 2.0, -3.0)])
def test_a_grid_on_the_plane_of_sharp_focus_is_sharp(pose):
    assert blur(camera(pose, "thick", focus=1500.0), grid(0.6)).max() < 1e-6
    # The traced lens within a tenth of a pixel, beyond its own aberrations at the same film points
    there, straight = (blur(camera(each, f_number=16.0, focus=1500.0), grid(0.25)) for each in (pose, UPRIGHT))
    assert there.max() < 0.1 + straight.max()
    # The plane of a centred film is another one
    upright = sharp_focus(camera(UPRIGHT, focus=1500.0), 0.03).plane
    assert abs(sharp_focus(camera(pose, focus=1500.0), 0.03).plane.normal @ upright.normal) < 0.9


def test_what_cannot_be_posed_is_refused():
    with pytest.raises(FilmError, match="from −60° to 60°"):
        FilmPose(math.radians(61.0))
    with pytest.raises(FilmError, match="rise"):
        FilmPose(rise=math.nan)
    with pytest.raises(FilmError, match="radius"):
        FilmPose(radius=0.0)
    with pytest.raises(FilmError, match="needs at least 24 mm"):
        camera(FilmPose(radius=-23.0))
    with pytest.raises(lb.CameraError, match="beyond the last vertex"):
        camera(FilmPose(60.0 * DEGREE), film=lb.Film(120.0, 120.0, 12, 12))
    assert lb.choose_model(camera(model="auto"), lb.load_scene("still-life")).model == "trace"


def ball() -> lb.Lens:
    """A ball of glass with the stop in its middle: alike in every direction, its image is a sphere about the middle."""
    glass = lb.Glass(1.5168)
    return lb.Lens((lb.Surface(20.0, 14.0, glass, curvature=1.0 / 20.0), lb.Surface(20.0, 2.5, glass, curvature=0.0),
                    lb.Surface(0.0, 14.0, curvature=-1.0 / 20.0)), 1)


def test_a_film_of_the_petzval_curvature_is_as_sharp_beside_the_axis_as_on_it():
    """The stop alone knows the axis: at 22° it is narrower by cos 22°, and the blur with it. Against rays of a distant
    point by the scalar trace, which meet the sphere by its equation."""
    lens, first = ball(), lb.first_order(ball())
    bent = FilmPose(radius=first.petzval_radius)
    middle = np.array([0.0, 0.0, 20.0])                         # of the ball, lens frame; the film curves about it
    assert first.petzval_radius == pytest.approx(-(20.0 + first.bfl), rel=1e-12)
    flat_film, bent_film = (lb.LensCamera(lens, lb.Film(24.0, 16.0, 240, 160), film_pose=pose)
                            for pose in (UPRIGHT, bent))
    spots = {}
    for angle in (0.0, 22.0):
        turn = math.radians(angle)
        way, aside = np.array([math.sin(turn), 0.0, math.cos(turn)]), np.array([math.cos(turn), 0.0, -math.sin(turn)])
        a, b = (4.5 * side.ravel() for side in np.meshgrid(np.linspace(-1.0, 1.0, 91), np.linspace(-1.0, 1.0, 91)))
        met = trace(lens, middle - 60.0 * way + a[:, None] * aside + b[:, None] * [0.0, 1.0, 0.0],
                    np.tile(way, (len(a), 1)))
        o, d = met.points[met.fate == Fate.PASSED] - middle, met.directions[met.fate == Fate.PASSED]
        along = (o * d).sum(1)
        on_sphere = o + (np.sqrt(along**2 - (o * o).sum(1) + first.petzval_radius**2) - along)[:, None] * d
        spots[angle] = np.sqrt(on_sphere.var(0).sum())
        # The camera's rays of the film point in the middle of that spot leave in one direction
        at = bent.film_points(on_sphere.mean(0)[None, :2], np.zeros((1, 2)))[0]
        raster = [[(0.5 - at[0] / 24.0) * 240.0, (at[1] / 16.0 + 0.5) * 160.0]]
        spreads = []
        for cam in (bent_film, flat_film):
            rays = cam.generate_rays(np.tile(raster, (2000, 1)), samples(2000)[1])
            lit = rays.weights > 0.0
            spreads.append(np.sqrt(rays.directions[lit].var(0).sum()) * -first.petzval_radius)
        assert spreads[0] == pytest.approx(spots[angle], rel=0.05)              # noise of 2,000 samples
        assert angle == 0.0 or spreads[1] > 5.0 * spreads[0]
    assert 0.8 < spots[22.0] / spots[0.0] < 1.0
