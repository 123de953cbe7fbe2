"""Transforms in motion and the shutter: quaternions, the polar decomposition, when samples fall, and moved cameras."""

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import lenses
from lensbench.core.imaging.transform import (
    polar_decomposition, quaternion, quaternion_product, rotation_matrix, shortest_arc, slerp
)
from lensbench.core.kernels.block import PITCH, TIME, B, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene

FILM = lb.Film(36.0, 24.0, 120, 80)
DARK = Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)

numbers = st.floats(-1.0, 1.0)
quaternions = st.lists(numbers, min_size=4, max_size=4).map(np.array).filter(
    lambda q: np.linalg.norm(q) > 1e-2).map(lambda q: q / np.linalg.norm(q))
matrices = st.lists(numbers, min_size=9, max_size=9).map(lambda m: np.array(m).reshape(3, 3)).filter(
    lambda m: np.linalg.det(m) > 1e-3)
parts = st.floats(0.0, 1.0)


def turned(axis, angle, place=(0.0, 0.0, 0.0), scale=1.0):
    """Rodrigues' formula: (4, 4)."""
    a = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])
    m = np.eye(4)
    m[:3, :3] = scale * (np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k)
    m[:3, 3] = place
    return m


def angle_of(rotation):
    """Without the arc cosine, which has half of the digits near 0 and π."""
    skew = rotation - np.swapaxes(rotation, -1, -2)
    sine = 0.5 * np.sqrt(skew[..., 2, 1] ** 2 + skew[..., 0, 2] ** 2 + skew[..., 1, 0] ** 2)
    return np.arctan2(sine, 0.5 * (np.trace(rotation, axis1=-2, axis2=-1) - 1.0))


# Quaternions

@settings(max_examples=60)
@given(quaternions)
def test_a_quaternion_and_its_matrix_are_one_rotation(q):
    matrix = rotation_matrix(q)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-14)
    back = quaternion(matrix)
    assert min(np.abs(back - q).max(), np.abs(back + q).max()) < 1e-14
    # q v q* turns v as the matrix does
    v = np.array([0.3, -0.7, 0.2])
    turned_v = quaternion_product(quaternion_product(q, np.array([0.0, *v])), q * (1, -1, -1, -1))
    np.testing.assert_allclose(turned_v, [0.0, *(matrix @ v)], atol=1e-14)


@settings(max_examples=60)
@given(quaternions, quaternions, parts)
def test_slerp_goes_the_shortest_way_at_constant_speed(p, q, part):
    whole = angle_of(rotation_matrix(p).T @ rotation_matrix(q))
    here = slerp(p, q, part)
    assert np.linalg.norm(here) == pytest.approx(1.0, abs=1e-14)
    # the angles gone and to go are parts of the whole, which is at most half a turn; 1e-7: of half a turn, no better
    assert angle_of(rotation_matrix(p).T @ rotation_matrix(here)) == pytest.approx(part * whole, abs=1e-7)
    assert angle_of(rotation_matrix(here).T @ rotation_matrix(q)) == pytest.approx((1.0 - part) * whole, abs=1e-7)
    assert shortest_arc(p, q)[1] <= math.pi + 1e-15
    # Shoemake's own form, where its quotient is well defined; −q is the same rotation
    cosine = p @ q
    omega = math.acos(min(abs(cosine), 1.0))
    if 1e-3 < omega < math.pi / 2 - 1e-6:
        other = (math.sin((1.0 - part) * omega) * p + math.sin(part * omega) * math.copysign(1.0, cosine) * q
                 ) / math.sin(omega)
        np.testing.assert_allclose(here, other, atol=1e-12)


def test_slerp_begins_and_ends_where_it_is_told():
    rng = np.random.default_rng(0)
    p, q = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 4)))
    q = -q if p @ q < 0.0 else q
    np.testing.assert_array_equal(slerp(p, q, 0.0), p)
    np.testing.assert_allclose(slerp(p, q, 1.0), q, atol=1e-15)
    np.testing.assert_array_equal(slerp(p, p, np.linspace(0.0, 1.0, 5)), np.tile(p, (5, 1)))


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-16, 1e-9, 1e-4, 3.0, math.pi - 1e-4, math.pi - 1e-9, math.pi])
def test_slerp_is_stable_near_no_turn_and_near_half_a_turn(angle):
    axis = np.array([2.0, -1.0, 0.5]) / np.linalg.norm([2.0, -1.0, 0.5])
    p = np.array([0.5, 0.5, -0.5, 0.5])
    q = quaternion_product(p, np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)]))
    part = np.linspace(0.0, 1.0, 9)
    wanted = [quaternion_product(p, np.array([math.cos(f * angle / 2), *(math.sin(f * angle / 2) * axis)]))
              for f in part]
    np.testing.assert_allclose(slerp(p, q, part), wanted, atol=2e-15)


@settings(max_examples=60)
@given(matrices)
def test_the_polar_decomposition_is_that_of_the_singular_values(m):
    r, s = polar_decomposition(m)
    u, values, v = np.linalg.svd(m)
    # R is known as well as the smallest two singular values part it from a mirror image
    tolerance = 1e-15 * 30 / (values[1] + values[2])
    np.testing.assert_allclose(r, u @ v, atol=tolerance)
    np.testing.assert_allclose(s, v.T @ np.diag(values) @ v, atol=tolerance)
    np.testing.assert_allclose(r.T @ r, np.eye(3), atol=1e-14)
    np.testing.assert_array_equal(s, s.T)


# Animated transforms

AFFINE = np.array([[1.2, 0.3, 0.0, 5.0], [-0.4, 0.9, 0.1, -7.0], [0.2, 0.0, 1.5, 11.0], [0.0, 0.0, 0.0, 1.0]])


def test_an_animated_transform_is_its_matrices_digit_by_digit_at_their_times_and_beyond():
    way = lb.AnimatedTransform(AFFINE, turned((1, 2, 3), 2.5, (1, 2, 3)), 2.0, 5.0)
    for early in (-1e9, 0.0, 2.0):
        np.testing.assert_array_equal(way.at(early), way.start)
    for late in (5.0, 6.0, math.inf):
        np.testing.assert_array_equal(way.at(late), way.end)
    # and it is continuous there
    np.testing.assert_allclose(way.at(2.0 + 1e-9), way.start, atol=1e-7)
    np.testing.assert_allclose(way.at(5.0 - 1e-9), way.end, atol=1e-7)
    np.testing.assert_array_equal(way.at([2.0, 3.0, 5.0])[1], way.at(3.0))


def test_place_turn_and_stretch_go_each_their_own_way():
    stretch = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 0.5]])
    start, end = turned((0, 1, 0), 0.2, (1, 2, 3)), turned((0, 1, 0), 1.4, (5, 2, -3))
    end[:3, :3] = end[:3, :3] @ stretch
    half = lb.AnimatedTransform(start, end, 1.0, 3.0).at(2.5)
    np.testing.assert_allclose(half[:3, 3], (4.0, 2.0, -1.5), atol=1e-14)
    wanted = turned((0, 1, 0), 0.2 + 0.75 * 1.2)[:3, :3] @ (0.25 * np.eye(3) + 0.75 * stretch)
    np.testing.assert_allclose(half[:3, :3], wanted, atol=1e-14)


@settings(max_examples=40)
@given(matrices, matrices, parts)
def test_on_its_way_an_affine_transform_never_collapses_or_turns_over(a, b, part):
    start, end = np.eye(4), np.eye(4)
    start[:3, :3], end[:3, :3] = a, b
    values = [np.linalg.svd(m)[1] for m in (a, b)]
    here = np.linalg.svd(lb.AnimatedTransform(start, end).at(part)[:3, :3])[1]
    # of positive matrices the least eigenvalue is concave
    assert here[2] >= (1.0 - part) * values[0][2] + part * values[1][2] - 1e-12
    assert np.linalg.det(lb.AnimatedTransform(start, end).at(part)) > 0.0


def test_animated_transforms_are_values():
    a, b = lb.AnimatedTransform(np.eye(4), AFFINE), lb.AnimatedTransform(np.eye(4).tolist(), AFFINE.copy(), 0, 1)
    assert a == b and hash(a) == hash(b)
    assert a != lb.AnimatedTransform(np.eye(4), AFFINE, end_time=2.0) and a != lb.AnimatedTransform(AFFINE, AFFINE)
    with pytest.raises(ValueError, match="read-only"):
        a.start[0, 0] = 2.0


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.AnimatedTransform(np.zeros((4, 4)), np.eye(4)), "last row"),
    (lambda: lb.AnimatedTransform(np.eye(4), np.diag([1.0, 1.0, 0.0, 1.0])), "singular"),
    (lambda: lb.AnimatedTransform(np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])), "mirrors"),
    (lambda: lb.AnimatedTransform(np.eye(4), np.full((4, 4), math.nan)), "finite"),
    (lambda: lb.AnimatedTransform(np.eye(4), np.diag([1.0, 1.0, 1.0, 2.0])), "last row"),
    (lambda: lb.AnimatedTransform(np.eye(3), np.eye(4)), "4 × 4"),
    (lambda: lb.AnimatedTransform(np.eye(4), AFFINE, 1.0, 1.0), "end after it starts"),
    (lambda: lb.AnimatedTransform(np.eye(4), AFFINE, 2.0, 1.0), "end after it starts"),
    (lambda: lb.AnimatedTransform(np.eye(4), AFFINE, 0.0, math.inf), "finite numbers of seconds"),
    (lambda: lb.PerspectiveCamera(FILM, world_from_camera=lb.AnimatedTransform(np.eye(4), AFFINE)), "stretches"),
    (lambda: lb.PerspectiveCamera(FILM, readout=-0.1), "readout"),
    (lambda: lb.PerspectiveCamera(FILM, readout=math.nan), "readout"),
    (lambda: lb.PerspectiveCamera(FILM, readout_direction="sideways"), "down, up, left, right"),
    (lambda: lb.PerspectiveCamera(FILM, shutter_close=0.1, shutter_ramp=0.06), "between 0 and 0.05 s"),
    (lambda: lb.PerspectiveCamera(FILM, shutter_ramp=-0.1), "shutter ramp"),
    (lambda: lb.PerspectiveCamera(FILM, shutter_ramp=math.nan), "shutter ramp"),
    (lambda: lb.PerspectiveCamera(FILM).generate_rays([[0.0, 0.0]], [[0.5, 0.5]], time=1.5), "between 0 and 1"),
    (lambda: lb.PerspectiveCamera(FILM).generate_rays([[0.0, 0.0]], [[0.5, 0.5]], time=math.nan), "between 0 and 1"),
])
def test_what_cannot_move_so_is_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)


# Cameras that move

@pytest.mark.parametrize("camera", [
    lambda **more: lb.PerspectiveCamera(FILM, lens_radius=8.0, focus_distance=900.0, **more),
    lambda **more: lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.0, **more),
    lambda **more: lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, model="pinhole", **more)],
    ids=["thin", "trace", "pinhole"])
@pytest.mark.parametrize("turn", [0.0, 0.3, *(pytest.param(turn, marks=pytest.mark.slow)
                                               for turn in (1e-9, 3.1, math.pi))])
def test_a_ray_of_a_moving_camera_is_that_of_the_camera_that_stands_where_it_is_then(camera, turn):
    way = lb.AnimatedTransform(turned((1, 1, 0), 0.4, (10, -20, 30)),
                               turned((1, 1, 0), 0.4, (-50, 60, 5)) @ turned((0.2, 1, -3), turn), 1.0, 3.0)
    moving = camera(world_from_camera=way, shutter_open=0.5, shutter_close=3.5)
    rng = np.random.default_rng(1)
    raster, uv, when = rng.random((40, 2)) * (120, 80), rng.random((40, 2)), rng.random(40)
    rays = moving.generate_rays(raster, uv, when)
    np.testing.assert_allclose(rays.times, 0.5 + 3.0 * when, rtol=1e-15)
    for k in range(40):
        still = camera(world_from_camera=way.at(rays.times[k])).generate_rays(raster[k:k + 1], uv[k:k + 1])
        np.testing.assert_allclose(rays.origins[k], still.origins[0], atol=1e-12)
        np.testing.assert_allclose(rays.directions[k], still.directions[0], atol=2e-15)
        assert rays.weights[k] == still.weights[0]


def test_a_camera_that_grows_keeps_its_picture_and_sees_from_farther_out():
    way = lb.AnimatedTransform(turned((0, 1, 0), 0.3, (1, 2, 3)), turned((0, 1, 0), 0.3, (1, 2, 3), scale=3.0))
    camera, still = (lb.PerspectiveCamera(FILM, lens_radius=8.0, focus_distance=900.0, world_from_camera=m)
                     for m in (way, way.start))
    raster, uv = np.random.default_rng(2).random((2, 30, 2)) * [[[120, 80]], [[1, 1]]]
    first, later = still.generate_rays(raster, uv), camera.generate_rays(raster, uv, 0.5)
    np.testing.assert_allclose(later.directions, first.directions, atol=1e-14)
    np.testing.assert_allclose(later.origins - (1, 2, 3), 2.0 * (first.origins - (1, 2, 3)), atol=1e-12)
    # so it is where it has stopped
    grown = lb.PerspectiveCamera(FILM, lens_radius=8.0, focus_distance=900.0, shutter_open=2.0, shutter_close=3.0,
                                 world_from_camera=way)
    np.testing.assert_allclose(grown.generate_rays(raster, uv).directions, first.directions, atol=1e-14)


def kernels(steps):
    return [step.kernel.py_func.__name__ for step in steps]


def test_a_pose_that_is_constant_while_the_shutter_is_open_costs_nothing():
    place = turned((0, 1, 0), 0.3, (1, 2, 3))
    still = lb.PerspectiveCamera(FILM, world_from_camera=place)
    way = lb.AnimatedTransform(place, turned((0, 1, 0), 0.5), 2.0, 3.0)
    waiting = lb.PerspectiveCamera(FILM, world_from_camera=way, shutter_close=1.5, readout=0.5, shutter_ramp=0.1)
    lying = lb.PerspectiveCamera(FILM, world_from_camera=lb.AnimatedTransform(place, place), readout=1.0)
    for camera in (waiting, lying):
        assert not camera.moves
        assert kernels(camera.steps()) == kernels(still.steps())
        for a, b in zip(camera.steps(), still.steps(), strict=True):
            np.testing.assert_array_equal(a.parameters, b.parameters)
        rendering = lb.Rendering(camera, Scene("empty"))
        assert "sample_times" not in kernels(rendering._programs.before)
    late = lb.PerspectiveCamera(FILM, world_from_camera=way, shutter_close=1.5, readout=0.6)
    steps = ["shutter_time", *kernels(still.steps())[:-1], "transform_moving_rays"]
    assert late.moves and kernels(late.steps()) == steps


# The shutter

def moments(camera, samples):
    """Seconds since shutter_open at which the samples of every pixel pass: (samples, pixels)."""
    film = camera.film
    program = Program([*sampling_steps(film.pixels_x, film.pixels_y, lit=False, timed=True), camera.clock], np.float64)
    blocks = -(-film.pixels_x * film.pixels_y // B)
    out, lanes = np.empty((samples, blocks * B)), lane_buffer(np.float64)
    for k in range(samples):
        for block in range(blocks):
            program.expose(np.zeros((blocks, 3 * B)), lanes, block, block + 1, k, 1, np.uint32(3))
            out[k, block * B:(block + 1) * B] = lanes[TIME * PITCH:TIME * PITCH + B]
    return out[:, :film.pixels_x * film.pixels_y]


@pytest.mark.parametrize("ramp", [0.0, 0.004, 0.01])
def test_light_passes_as_the_trapezoid_of_the_shutter_opens_and_closes(ramp):
    camera = lb.PerspectiveCamera(lb.Film(pixels_x=64, pixels_y=32), shutter_open=1.0, shutter_close=1.02,
                                  shutter_ramp=ramp)
    t = np.sort(moments(camera, 64).ravel())
    assert t[0] >= 0.0 and t[-1] <= 0.02
    # the trapezoid's own cumulative, by summing it up
    grid = np.linspace(0.0, 0.02, 20001)
    through = np.ones_like(grid) if ramp == 0.0 else np.clip(np.minimum(grid, 0.02 - grid) / ramp, 0.0, 1.0)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (through[1:] + through[:-1]))]) * 1e-6
    assert camera.effective_time == pytest.approx(area[-1], rel=1e-6)
    assert camera.shutter_efficiency == pytest.approx(area[-1] / 0.02, rel=1e-6)
    # 131,072 samples, stratified by 64 in each pixel: white noise would leave 1.4e-3 (Kolmogorov), these a third
    measured = (np.arange(t.size) + 0.5) / t.size
    assert np.abs(np.interp(t, grid, area / area[-1]) - measured).max() < 7e-4


def test_a_pixels_times_are_stratified_and_its_neighbours_have_others():
    camera = lb.PerspectiveCamera(lb.Film(pixels_x=32, pixels_y=16))
    t = moments(camera, 64)
    for k in (0, 77):
        assert (np.histogram(t[:, k], 64, (0.0, 1.0))[0] == 1).all()
    assert abs(np.corrcoef(t[0, :-1], t[0, 1:])[0, 1]) < 0.15       # of 511 pairs: 3 σ


def test_a_trapezoid_weighs_the_exposure_by_its_efficiency():
    box, trapezoid = (lb.PerspectiveCamera(FILM, lens_radius=4.0, weights="physical", shutter_close=0.01,
                                           shutter_ramp=ramp) for ramp in (0.0, 0.004))
    a, b = (camera.generate_rays([[60.0, 40.0]], [[0.5, 0.5]]).weights[0] for camera in (box, trapezoid))
    assert b / a == pytest.approx(trapezoid.shutter_efficiency) == pytest.approx(0.6)
    assert lb.PerspectiveCamera(FILM, shutter_close=0.0).shutter_efficiency == 1.0


@pytest.mark.parametrize(("direction", "axis", "sign"), [("down", 1, 1.0), ("up", 1, -1.0), ("right", 0, 1.0),
                                                         ("left", 0, -1.0)])
def test_lines_open_one_after_the_other(direction, axis, sign):
    camera = lb.PerspectiveCamera(FILM, shutter_open=3.0, shutter_close=3.01, readout=0.02, readout_direction=direction)
    raster = np.array([[0.0, 0.0], [120.0, 80.0], [30.0, 50.0]])
    place = raster[:, axis] / (120.0, 80.0)[axis]
    rays = camera.generate_rays(raster, np.full((3, 2), 0.5), 0.25)
    np.testing.assert_allclose(rays.times, 3.0 + 0.0025 + 0.02 * (place if sign > 0.0 else 1.0 - place), atol=1e-14)
