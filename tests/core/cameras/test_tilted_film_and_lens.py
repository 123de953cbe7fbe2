"""A tilted film behind a lens with tilted surfaces, against a vector trace with explicit rigid motions."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.focus_wedge import sharp_focus
from lensbench.core.imaging.film import FilmPose
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from tests.core.optics.test_surface_pose import posed

FILM = lb.Film(36.0, 24.0, 360, 240)
TRIPLET = lenses.load("lenshh-cooke-triplet-50")
ELEMENT = {"decentre_x": 0.3, "decentre_y": 0.5, "tilt_x": 0.05, "tilt_y": 0.02}
BENT = posed(TRIPLET, 2, 3, **ELEMENT)
DEGREE = math.radians(1.0)
POSED = FilmPose(8.0 * DEGREE, -5.0 * DEGREE, 4.0, 3.0)
CURVED = FilmPose(3.0 * DEGREE, 2.0 * DEGREE, 1.0, -2.0, radius=-45.0)
RASTERS = ((180.0, 120.0), (30.0, 20.0), (340.0, 30.0), (20.0, 230.0), (330.0, 220.0))

pytestmark = pytest.mark.slow                       # four quadrants of regions a camera: 1 to 2 s each


def turned(about_x: float, about_y: float) -> np.ndarray:
    """R_y · R_x, written out."""
    c, s, d, t = math.cos(about_x), math.sin(about_x), math.cos(about_y), math.sin(about_y)
    return np.array([[d, 0.0, t], [0.0, 1.0, 0.0], [-t, 0.0, d]]) @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s],
                                                                             [0.0, s, c]])


def film_place(pose: FilmPose, x: float, y: float) -> np.ndarray:
    """Camera-frame point of a film point."""
    sag = 0.0 if math.isinf(pose.radius) else pose.radius - math.copysign(math.sqrt(pose.radius**2 - x * x - y * y),
                                                                          pose.radius)
    return np.array([-pose.shift, -pose.rise, 0.0]) + turned(pose.tilt, -pose.swing) @ [x, y, sag]


def film_normal(pose: FilmPose, x: float, y: float) -> np.ndarray:
    """Normal away from the lens there: the cross product of two differences."""
    h = 1e-5
    side = [film_place(pose, x + a, y + b) - film_place(pose, x - a, y - b) for a, b in ((h, 0.0), (0.0, h))]
    normal = np.cross(*side)
    return normal / np.linalg.norm(normal)


def to_scene(lens: lb.Lens, body: tuple[int, int], origins: np.ndarray,
             directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays of the lens frame from the film to the scene through spheres, whose `body` is moved by ELEMENT.

    Points on the first surface, directions, and whether the rays pass all rims.
    """
    o, d = origins.copy(), directions / np.linalg.norm(directions, axis=1)[:, None]
    passes = np.ones(len(o), bool)
    indices = [lens.front_index, *(surface.glass.index() for surface in lens.surfaces)]
    places = np.concatenate([[0.0], np.cumsum([surface.thickness for surface in lens.surfaces])])
    for i in reversed(range(len(lens.surfaces))):
        surface, turn = lens.surfaces[i], np.eye(3)
        vertex = np.array([0.0, 0.0, places[i]])
        if body[0] <= i <= body[1]:
            pivot, turn = np.array([0.0, 0.0, places[body[0]]]), turned(ELEMENT["tilt_x"], ELEMENT["tilt_y"])
            vertex = pivot + [ELEMENT["decentre_x"], ELEMENT["decentre_y"], 0.0] + turn @ (vertex - pivot)
        p, q, c = (o - vertex) @ turn, d @ turn, surface.curvature
        # c |p + t q|² = 2 z
        b, e = c * (p * q).sum(1) - q[:, 2], c * (p * p).sum(1) - 2.0 * p[:, 2]
        with np.errstate(invalid="ignore"):
            t = e / (-b - np.sign(q[:, 2]) * -np.sqrt(b * b - c * e))
        p = p + t[:, None] * q
        passes &= np.hypot(p[:, 0], p[:, 1]) <= surface.semi_diameter
        normal = np.column_stack([c * p[:, 0], c * p[:, 1], c * p[:, 2] - 1.0])         # towards the scene
        ratio, cosine = indices[i + 1] / indices[i], (q * normal).sum(1)
        with np.errstate(invalid="ignore"):
            left = np.sqrt(1.0 - ratio**2 * (1.0 - cosine**2))
        q = ratio * q + (left - ratio * cosine)[:, None] * normal
        o, d = vertex + p @ turn.T, q @ turn.T
        passes &= np.isfinite(d).all(1)
    return o, d, passes


def samples(n: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.random((n, 2)) * [360.0, 240.0], random.random((n, 2))


@pytest.mark.parametrize(("pose", "f_number"), [(POSED, None), (POSED, 11.0), (CURVED, None),
                                               (FilmPose(rise=9.0, shift=-7.0), 5.6)])
def test_rays_and_light_are_those_of_the_vector_trace(pose, f_number):
    cam = lb.LensCamera(BENT, FILM, 2000.0, f_number, film_pose=pose)
    lens, back = cam.lens, np.array([0.0, 0.0, cam.lens.length + cam.film_distance])
    raster, uv = samples(300)
    film = np.column_stack([(0.5 - raster[:, 0] / 360.0) * 36.0, (raster[:, 1] / 240.0 - 0.5) * 24.0])
    rays = cam.generate_rays(raster, uv)
    passed = rays.weights > 0.0
    assert passed.mean() > 0.9
    # The ray before the lens, traced back through the spheres from the line that the sampler aimed along
    stage_uv = cam.stage_uv(film, uv)
    x, y, z, l, m, n = Program(cam.camera_steps()[:1], np.float64).run(
        {X: film[:, 0], Y: film[:, 1], U0: stage_uv[:, 0], U1: stage_uv[:, 1]}, [X, Y, Z, L, M, N], len(film))
    start, way = np.column_stack([x, y, z]), np.column_stack([l, m, n])
    places = np.array([film_place(pose, *point) for point in film])
    aside = np.cross(places - start, way)
    assert np.abs(aside).max() < 1e-11                                          # it begins at the film point
    first, before, passes = to_scene(lens, (2, 3), start + back, way)
    assert (passes == passed).mean() > 0.99                                     # but for rounding at a rim
    both = passes & passed
    assert np.abs(before - rays.directions)[both].max() < 1e-12
    assert np.abs(np.cross(rays.origins + back - first, before))[both].max() < 1e-10
    # Its light: ∫ cos θ cos φ / s² over the rear plane
    for at in RASTERS:
        point = (0.5 - at[0] / 360.0) * 36.0, (at[1] / 240.0 - 0.5) * 24.0
        place, normal = film_place(pose, *point), film_normal(pose, *point)
        count, reach = 60_000, 1.4 * lens.surfaces[-1].semi_diameter
        r, turn = reach * np.sqrt((np.arange(count) + 0.5) / count), math.pi * (3.0 - math.sqrt(5.0)) * np.arange(count)
        towards = np.stack([r * np.cos(turn), r * np.sin(turn), np.full(count, -cam.film_distance)], 1) - place
        distance = np.linalg.norm(towards, axis=1)
        open_ = to_scene(lens, (2, 3), np.tile(place + back, (count, 1)), towards)[2]
        dense = np.where(open_, towards[:, 2] * (towards @ normal) / distance**4, 0.0).mean() * math.pi * reach**2
        weights = cam.generate_rays(np.tile(at, (8192, 1)), samples(8192)[1]).weights
        lit = dense * cam.film_distance**2 / cam.axis_irradiance
        assert weights.mean() == pytest.approx(lit, rel=0.02, abs=1e-3)         # noise of the rims: 1 %
        assert lit < 0.01 or (weights > 0.0).mean() > 0.95                      # hardly a ray is wasted


@pytest.mark.parametrize(("film_tilt", "film_swing", "lens_tilt", "lens_turn"), [
    (0.0, 6.0, 0.0, 4.0), (-5.0, 0.0, 3.0, 0.0), (0.0, 0.0, 5.0, 0.0)])
def test_a_whole_lens_that_is_tilted_is_the_lens_in_line_before_a_film_in_another_pose(film_tilt, film_swing, lens_tilt,
                                                                                      lens_turn):
    """Scheimpflug: only how film and lens lie to each other counts. Angles in degrees."""
    pose = FilmPose(film_tilt * DEGREE, film_swing * DEGREE, 1.0, -2.0)
    last = len(TRIPLET.surfaces) - 1
    bent = lb.LensCamera(posed(TRIPLET, 0, last, tilt_x=lens_tilt * DEGREE, tilt_y=lens_turn * DEGREE), FILM, 2000.0,
                         5.6, film_pose=pose)
    # The film as the lens sees it: about the pivot, the first vertex
    turn, back = turned(lens_tilt * DEGREE, lens_turn * DEGREE), np.array([0.0, 0.0, bent.lens.length
                                                                           + bent.film_distance])
    middle = turn.T @ (film_place(pose, 0.0, 0.0) + back)
    seen = lb.LensCamera(TRIPLET, FILM, f_number=5.6, film_distance=float(middle[2]) - TRIPLET.length,
                         film_pose=FilmPose(pose.tilt - lens_tilt * DEGREE, pose.swing + lens_turn * DEGREE,
                                            rise=-float(middle[1]), shift=-float(middle[0])))
    seen_back = np.array([0.0, 0.0, float(middle[2])])
    raster, uv = samples(200, 3)
    rays = bent.generate_rays(raster, uv)
    passed = rays.weights > 0.0
    origins, directions = ((rays.origins + back) @ turn - seen_back)[passed], rays.directions[passed] @ turn
    found = seen.importance(origins, directions)
    assert passed.mean() > 0.9 and found.visible.mean() > 0.99
    assert np.abs(found.raster - raster[passed])[found.visible].max() < 1e-8
    # The same light: of both on their own axis, times the distances that the weights are relative to
    scale = (seen.film_distance / bent.film_distance) ** 2 * bent.axis_irradiance / seen.axis_irradiance
    for at in RASTERS:
        one, two = (cam.generate_rays(np.tile(at, (8192, 1)), samples(8192)[1]).weights.mean() for cam in (bent, seen))
        assert one * scale == pytest.approx(two, rel=0.01)


def test_the_plane_of_sharp_focus_of_a_tilted_lens_is_that_of_the_closed_form_turned_with_it():
    tilt, turn = 4.0 * DEGREE, -3.0 * DEGREE
    seen = lb.LensCamera(TRIPLET, FILM, 1500.0, 5.6, film_pose=FilmPose(tilt, 0.0))
    # The lens tilted about the film's middle by −tilt before a centred film: decentred, and a little farther away
    back = seen.lens.length + seen.film_distance
    turned_lens, last = turned(-tilt, 0.0), len(TRIPLET.surfaces) - 1
    first = turned_lens @ [0.0, 0.0, -back]                                     # the first vertex, camera frame
    bent = lb.LensCamera(posed(TRIPLET, 0, last, decentre_x=first[0], decentre_y=first[1], tilt_x=-tilt), FILM,
                         film_distance=-first[2] - TRIPLET.length, f_number=5.6)
    wanted, found = sharp_focus(seen, 0.03), sharp_focus(bent, 0.03)
    for name in ("plane", "near", "far"):
        one, two = getattr(wanted, name), getattr(found, name)
        assert two.normal == pytest.approx(turned_lens @ one.normal, abs=0.002 if name != "plane" else 1e-5)
        assert two.offset == pytest.approx(one.offset, rel=0.003 if name != "plane" else 1e-5)
    assert found.scheimpflug is None and found.plane.distance([turned_lens @ wanted.hinge.point])[0] == pytest.approx(
        0.0, abs=0.01)
    # A film that swings with the tilted lens about the other axis
    both = lb.LensCamera(posed(TRIPLET, 0, last, tilt_y=turn), FILM, 1500.0, 5.6, film_pose=FilmPose(tilt))
    one = sharp_focus(both, 0.03).plane
    assert abs(one.normal[0]) > 0.02 and abs(one.normal[1]) > 0.2


@pytest.mark.parametrize("pose", [FilmPose(), FilmPose(-2.0 * DEGREE, 3.0 * DEGREE)])
def test_no_other_plane_is_sharper_behind_a_tilted_element(pose):
    """By the beams of the camera's rays near the axis: every plane turned by 10°, or moved by 1 %, is worse."""
    cam = lb.LensCamera(posed(TRIPLET, 2, 3, tilt_x=0.02, tilt_y=-0.01, decentre_y=0.1), FILM, 1500.0, 22.0,
                        film_pose=pose)
    x, y = np.meshgrid(np.linspace(0.47, 0.53, 5), np.linspace(0.47, 0.53, 5))
    raster = np.repeat(np.stack([360.0 * x.ravel(), 240.0 * y.ravel()], 1), 100, 0)
    rays = cam.generate_rays(raster, np.tile(0.4 + 0.2 * samples(100, 5)[1], (25, 1)))       # narrow
    assert (rays.weights > 0.0).all()
    origins, directions = rays.origins.reshape(25, 100, 3), rays.directions.reshape(25, 100, 3)

    def blur(normal, offset) -> float:
        """Rms over the film points of the width of their beams where they meet a plane, as the lens sees it."""
        along = (offset - origins @ normal) / (directions @ normal)
        met, way = origins + along[..., None] * directions, directions.mean(1, keepdims=True)
        way /= np.linalg.norm(way, axis=2, keepdims=True)
        across = met - (met * way).sum(2, keepdims=True) * way              # as the lens sees them
        return float(np.sqrt((across.var(1).sum(1) / (met - origins)[..., 2].mean(1) ** 2).mean()))

    plane = sharp_focus(cam, 0.03).plane
    least, middle = blur(plane.normal, plane.offset), np.array([0.0, 0.0, plane.offset / plane.normal[2]])
    aside = np.linalg.svd(plane.normal[None])[2][1:]
    for turn in (*aside, *-aside, *(0.7 * aside + 0.7 * aside[::-1])):
        normal = plane.normal + math.tan(10.0 * DEGREE) * turn
        assert blur(normal, normal @ middle) > least
    for nearer in (0.99, 1.01):
        assert blur(plane.normal, nearer * plane.offset) > least
    assert abs(plane.normal[2]) < 0.5 or not pose.is_upright                # far from that of the centred lens


@pytest.mark.parametrize("pose", [POSED, CURVED])
def test_points_project_back_and_traced_light_lands_where_its_ray_comes_from(pose):
    cam = lb.LensCamera(BENT, FILM, 2000.0, 5.6, film_pose=pose)
    raster, uv = samples(100)
    uv = 0.2 + 0.6 * uv
    rays = cam.generate_rays(raster, uv)
    arrived = rays.weights > 0.0
    assert arrived.mean() > 0.9
    points = rays.origins + 1500.0 * rays.directions
    found, seen = cam.raster_from_point(points, uv)
    assert seen[arrived].mean() > 0.97 and np.abs(found - raster)[arrived & seen].max() < 1e-3  # quadrants meet
    importance = cam.importance(rays.origins[arrived], rays.directions[arrived])
    assert np.abs(importance.raster - raster[arrived]).max() < 1e-8
    given = dict(zip((X, Y, Z, L, M, N), (*rays.origins[arrived].T, *-rays.directions[arrived].T), strict=True))
    x, y = Program(cam.film_landing().steps, np.float64).run({**given, WEIGHT: np.ones(arrived.sum())}, [X, Y],
                                                             int(arrived.sum()))
    assert np.abs(np.stack([x, y], 1) - raster[arrived]).max() < 1e-8
    # Behind the lens, W cos θ = density · weight
    film = np.column_stack([(0.5 - raster[:, 0] / 360.0) * 36.0, (raster[:, 1] / 240.0 - 0.5) * 24.0])
    u = cam.stage_uv(film, uv)
    n = Program(cam.camera_steps()[:1], np.float64).run({X: film[:, 0], Y: film[:, 1], U0: u[:, 0], U1: u[:, 1]}, [N],
                                                        len(film))[0]
    assert (importance.we * -n[arrived]) == pytest.approx(
        importance.position_pdf * importance.direction_pdf * rays.weights[arrived], rel=1e-9)


def irradiance(cam: lb.LensCamera, at) -> float:
    """∫ cos θ cos φ / s² over the rear plane by the scalar trace of the lens, over that of the axis."""
    film, lens = cam.film, cam.lens
    point = (0.5 - at[0] / film.pixels_x) * film.width, (at[1] / film.pixels_y - 0.5) * film.height
    place, normal = film_place(cam.film_pose, *point), film_normal(cam.film_pose, *point)
    count, reach = 60_000, 1.4 * lens.surfaces[-1].semi_diameter
    r, turn = reach * np.sqrt((np.arange(count) + 0.5) / count), math.pi * (3.0 - math.sqrt(5.0)) * np.arange(count)
    towards = np.stack([r * np.cos(turn), r * np.sin(turn), np.full(count, -cam.film_distance)], 1) - place
    distance = np.linalg.norm(towards, axis=1)
    open_ = lb.trace(lens, place + [0.0, 0.0, lens.length + cam.film_distance],
                     towards / distance[:, None]).fate == lb.Fate.PASSED
    dense = np.where(open_, towards[:, 2] * (towards @ normal) / distance**4, 0.0).mean() * math.pi * reach**2
    return float(dense * cam.film_distance**2 / cam.axis_irradiance)


def test_a_tilted_film_behind_cylinders_gets_the_light_of_their_trace():
    lens, pose = lenses.load("lentil-schneider-anamorphic-31-2001"), FilmPose(5.0 * DEGREE, 4.0 * DEGREE, 1.0, 2.0)
    cam = lb.LensCamera(lens, lb.Film(24.0, 16.0, 360, 240), 4000.0, film_pose=pose)
    for at in RASTERS:
        weights = cam.generate_rays(np.tile(at, (8192, 1)), samples(8192)[1]).weights
        assert weights.mean() == pytest.approx(irradiance(cam, at), rel=0.02, abs=1e-3)


@pytest.mark.parametrize("zoom", [0.0, 0.5, 1.0])
def test_each_position_of_a_tilted_zoom_lens_has_the_light_of_its_trace(zoom):
    lens = replace(lenses.load("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"), blades=0)
    first, last = lens.positions.gaps[0] + 1, lens.positions.gaps[1]        # the group between two varying gaps
    bent = posed(lens, first, last, decentre_x=0.5, tilt_x=0.02).at(zoom=zoom)
    cam = lb.LensCamera(bent, FILM, 5000.0, 4.0, film_pose=FilmPose(tilt=0.05))
    for at in RASTERS:
        weights = cam.generate_rays(np.tile(at, (8192, 1)), samples(8192)[1]).weights
        assert weights.mean() == pytest.approx(irradiance(cam, at), rel=0.01)
        assert (weights > 0.0).mean() > 0.95


def test_the_model_choice_traces_and_says_why():
    choice = lb.choose_model(lb.LensCamera(BENT, replace(FILM, pixels_x=36, pixels_y=24), 2000.0, 5.6, "auto",
                                           film_pose=POSED), lb.load_scene("still-life"))
    assert choice.model == "trace" and "the lens has a tilted or decentred surface" in choice.reason
    assert "the film is tilted, shifted or curved" in choice.reason
