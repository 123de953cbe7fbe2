"""Lumigraphs: novel views between the pinholes and before them are those of a camera there."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.lightfields.lumigraph import Lumigraph, lumigraph_pinhole

FILM = lb.Film(14.4, 9.6, 240, 160)
STILL = lb.builtin_scene("still-life")
SPACING = 5.0
INSIDE = (slice(8, -8), slice(8, -8))


def pinhole(place=(0.0, 0.0, 0.0), turn=0.0, film=FILM):
    """A camera at a place of the array's frame (mm), turned to the left (radians)."""
    pose = np.eye(4)
    c, s = math.cos(turn), math.sin(turn)
    pose[:3] = [[c, 0.0, s, place[0]], [0.0, 1.0, 0.0, place[1]], [-s, 0.0, c, place[2]]]
    return lb.PerspectiveCamera(film, fov=0.192, focus_distance=1200.0, world_from_camera=pose)


def psnr(view, direct):
    """Decibels of what is covered, linear, clipped to [0, 1], peak 1."""
    a, b = (np.clip(picture, 0.0, 1.0)[view.covered] for picture in (view.picture, direct))
    return -10.0 * math.log10(np.mean((a - b) ** 2))


@pytest.fixture(scope="module")
def still():
    """Recorded with twice the pixels that its views are asked for."""
    return lb.capture_lumigraph(pinhole(film=replace(FILM, pixels_x=480, pixels_y=320)), STILL, (9, 9), SPACING,
                                samples=4)


@pytest.mark.slow
@pytest.mark.parametrize("place, turn", [
    ((2.5, 2.5, 0.0), 0.0), ((-7.3, 4.1, 0.0), 0.0), ((6.0, -3.0, -60.0), 0.0), ((1.0, 2.0, 40.0), 0.01)],
    ids=["between", "aside", "before", "behind and turned"])
def test_between_the_pinholes_and_before_them_it_sees_what_a_camera_there_sees(still, place, turn):
    camera = pinhole(place, turn)
    direct = lb.render(camera, STILL, 128)
    corrected, seen_double = still.seen_by(camera), still.seen_by(camera, None)
    assert corrected.covered.mean() > 0.9
    # What no pinhole saw behind the edges of things is filled: only the array's and the window's ends are not covered
    assert corrected.covered[20:-20, 20:-20].all()
    assert psnr(corrected, direct) > 32.0
    assert psnr(seen_double, direct) < psnr(corrected, direct) - 6.0


@pytest.mark.slow
def test_depths_of_the_middle_alone_correct_too(still):
    camera = pinhole((2.5, 2.5, 0.0))
    direct = lb.render(camera, STILL, 128)
    depths = lb.depth_map(still.camera, STILL)
    # What the middle does not see behind the edges of things is guessed
    assert psnr(still.seen_by(camera, depths), direct) > psnr(still.seen_by(camera, None), direct) + 6.0
    assert psnr(still.seen_by(camera, 1500.0), direct) < psnr(still.seen_by(camera, depths), direct)


@pytest.mark.slow
def test_a_pinhole_of_the_array_sees_what_it_saw(still):
    j, i = 6, 1
    camera = lb.array_camera(still.camera, still.places[j, i], still.distance, still.offsets[j, i])
    view = still.seen_by(camera)
    assert view.covered.all()
    # Its own half floats, but for rounding of the places
    assert np.abs(view.picture - still.pictures[j, i].transpose(1, 2, 0).astype(np.float32)).max() < 2e-3


def wave(depth, x, y):
    """On a wall at a depth, mm: 40 mm long, slanted."""
    return 0.5 + 0.4 * np.cos(2.0 * math.pi * (x / 50.0 + y / 66.0) * 1200.0 / depth)


def waving(depth, views=(3, 3)):
    """A lumigraph of such a wall, by similar triangles."""
    middle = lumigraph_pinhole(pinhole())
    shape = (views[1], views[0], 160, 240)
    made = Lumigraph(middle, SPACING, 1200.0, np.full((*shape, 4), 1e3 / depth, np.float16))
    size = 2.0 * 1200.0 * math.tan(0.096) / 160.0
    y, x = np.mgrid[0:160, 0:240]
    for j, i in np.ndindex(views[1], views[0]):
        right, down = made.offsets[j, i]
        s, t = (x + 0.5 + right - 120.0) * size, (80.0 - y - 0.5 - down) * size
        u, v = SPACING * (i - (views[0] - 1) / 2.0), SPACING * (j - (views[1] - 1) / 2.0)
        made.pictures[j, i] = wave(depth, u + (s - u) * depth / 1200.0, v + (t - v) * depth / 1200.0)
    return made


@pytest.mark.slow
@pytest.mark.parametrize("depth", [700.0, 1200.0, 6000.0])
def test_a_wall_is_where_it_is_by_similar_triangles(depth):
    made, (u, v) = waving(depth), (1.7, -2.4)
    size = 2.0 * math.tan(0.096) / 160.0
    y, x = np.mgrid[0:160, 0:240]
    expected = wave(depth, u + (x + 0.5 - 120.0) * size * depth, v + (80.0 - y - 0.5) * size * depth)
    for surface in ("recorded", depth, np.full((160, 240), depth)):
        view = made.seen_by(pinhole((u, v, 0.0)), surface)
        assert view.covered.mean() > 0.9
        # Half floats of 11 bits; at the border cubics have pixels on one side alone
        assert np.abs(view.picture[..., 0] - expected)[INSIDE].max() < 5e-4
    off = np.abs(made.seen_by(pinhole((u, v, 0.0)), None).picture[..., 0] - expected)[INSIDE]
    assert (off.max() < 5e-4) == (depth == 1200.0)


@pytest.mark.slow
def test_rays_beside_the_array_are_not_covered():
    made = waving(1200.0)
    assert made.seen_by(pinhole((4.9, 0.0, 0.0))).covered.mean() > 0.95
    assert not made.seen_by(pinhole((5.1, 0.0, 0.0))).covered.any()
    assert not made.seen_by(pinhole(turn=math.pi)).covered.any()
    # From z before the array a ray of slope m comes through it at u = m z: 5 mm on either side
    z = 100.0
    covered = made.seen_by(pinhole((0.0, 0.0, -z))).covered
    slope = (np.arange(240) + 0.5 - 120.0) * 2.0 * math.tan(0.096) / 160.0
    assert np.array_equal(covered.any(0), np.abs(slope) * z <= 5.0)
    assert not np.any(made.seen_by(pinhole((0.0, 0.0, -z))).picture[~covered])


def test_the_middle_of_a_lens_is_where_its_entrance_pupil_is():
    lens = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, model="thin")
    middle = lumigraph_pinhole(lens)
    hole = replace(lens, model="pinhole")
    points = np.array([[0.0, 0.0], [200.0, 30.0], [120.0, 80.0]])
    rays = middle.generate_rays(points, np.full((3, 2), 0.5))
    others = hole.generate_rays(points, np.full((3, 2), 0.5))
    assert np.allclose(rays.directions, others.directions, atol=1e-12)
    assert np.allclose(np.cross(rays.origins - others.origins, rays.directions), 0.0, atol=1e-9)


def test_invalid_arguments_are_refused():
    camera = pinhole()
    for arguments, says in (({"views": (0, 3)}, "whole numbers"), ({"spacing": 0.0}, "positive number"),
                            ({"distance": math.inf}, "finite distance"), ({"samples": 0}, "at least 1")):
        with pytest.raises(lb.LightFieldError, match=says):
            lb.capture_lumigraph(camera, STILL, **{"views": (2, 2), **arguments})
    with pytest.raises(lb.LightFieldError, match="GB that are free"):
        lb.capture_lumigraph(replace(camera, film=lb.Film(36.0, 24.0, 9000, 6000)), STILL, (65, 65))
    with pytest.raises(lb.LightFieldError, match="single p"):
        lb.capture_lumigraph(lb.OrthographicCamera(FILM, 300.0), STILL, distance=1000.0)
    with pytest.raises(lb.LightFieldError, match="cancelled"):
        lb.capture_lumigraph(pinhole(film=lb.Film(36.0, 24.0, 12, 8)), STILL, (2, 2), samples=1,
                             progress=lambda share: False)
    for pose in (lb.FilmPose(rise=10.0), lb.FilmPose(tilt=0.1), lb.FilmPose(radius=-90.0)):
        with pytest.raises(lb.LightFieldError, match="flat, centred film"):
            lb.capture_lumigraph(lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, film_pose=pose), STILL)
    made = waving(1200.0)
    for surface, says in ((np.ones((3, 4)), "160 × 240"), (-1.0, "positive"), ("here", "recorded")):
        with pytest.raises(lb.LightFieldError, match=says):
            made.seen_by(camera, surface)


@pytest.mark.slow
def test_what_lies_behind_an_edge_does_not_shine_through_it():
    """A near half of one colour before a far one: between its pixels, too, each place has one of the two colours."""
    middle = lumigraph_pinhole(pinhole())
    made = Lumigraph(middle, SPACING, 1200.0, np.zeros((1, 1, 160, 240, 4), np.float16))
    is_near = np.arange(240) < 120
    made.pictures[:], made.nearness[:] = np.where(is_near, 0.25, 0.75), np.where(is_near, 1e3 / 600.0, 1e3 / 2400.0)
    view = made.seen_by(pinhole(film=replace(FILM, pixels_x=480, pixels_y=320)))
    assert view.covered.all() and set(np.round(view.picture[INSIDE], 3).ravel().tolist()) == {0.25, 0.75}


@pytest.mark.parametrize("views", [(3, 2), (4, 5)])
def test_neighbouring_pinholes_lie_the_spacing_apart_about_the_middle(views):
    places = Lumigraph(lumigraph_pinhole(pinhole()), SPACING, 1200.0, np.zeros((views[1], views[0], 2, 3, 4))).places
    assert places.shape == (views[1], views[0], 2)
    np.testing.assert_allclose(np.diff(places, axis=1), np.broadcast_to([SPACING, 0.0], (views[1], views[0] - 1, 2)))
    np.testing.assert_allclose(np.diff(places, axis=0), np.broadcast_to([0.0, SPACING], (views[1] - 1, views[0], 2)))
    np.testing.assert_allclose(places.mean((0, 1)), 0.0, atol=1e-12)


def test_traced_rays_are_the_same_in_the_arrays_frame_wherever_both_cameras_are_taken():
    film = replace(FILM, pixels_x=6, pixels_y=4)
    motion, pose = (pinhole(place, turn).world_from_camera for place, turn in (
        ((300.0, -20.0, 75.0), 0.4), ((4.0, -3.0, 20.0), 0.1)))
    found = []
    for moved in (np.eye(4), motion):
        array, camera = (replace(pinhole(film=film), world_from_camera=moved @ placed) for placed in (np.eye(4), pose))
        made = Lumigraph(lumigraph_pinhole(array), SPACING, 1200.0, np.zeros((2, 3, 4, 6, 4), np.float16))
        found.append(made._traced(camera, 1))
    assert found[0].shape == (24, 6)
    np.testing.assert_allclose(found[1], found[0], atol=1e-3)
    np.testing.assert_allclose(found[0][:, :3], np.broadcast_to(pose[:3, 3], (24, 3)), atol=1e-3)
    np.testing.assert_allclose(found[0][:, 3:].mean(0) / np.linalg.norm(found[0][:, 3:].mean(0)), -pose[:3, 2],
                               atol=1e-5)


@pytest.mark.parametrize("turn", [0.0, 0.3, -0.2])
@pytest.mark.parametrize("maker", [
    lambda pose: lb.PerspectiveCamera(lb.Film(36.0, 24.0, 60, 40), 0.4, world_from_camera=pose),
    lambda pose: lb.PerspectiveCamera(lb.Film(36.0, 24.0, 60, 40), 0.4, world_from_camera=pose, weights="radiance"),
    lambda pose: lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(18.0, 12.0, 60, 40), 1500.0, 16.0, model="thin",
                               world_from_camera=pose)], ids=["pinhole", "radiance", "lens"])
def test_a_view_falls_off_from_its_own_axis_and_not_from_that_of_the_array(maker, turn):
    """Of a scene of radiance 1 everywhere, as its own picture does."""
    white = lb.Scene("white", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))
    array = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 120, 80), 1.2, focus_distance=1500.0)
    made = lb.capture_lumigraph(array, white, (9, 5), 20.0, samples=4)
    camera = maker(pinhole(turn=turn).world_from_camera)
    view = made.seen_by(camera)
    assert view.covered.all()
    np.testing.assert_allclose(view.picture, lb.render(camera, white, samples=16), atol=0.012)


def test_a_view_by_a_lens_above_the_middle_of_its_film_is_a_part_of_that_of_a_higher_film():
    lens = lenses.load("pbrt-dgauss-50mm")
    made = replace(waving(1200.0), camera=lumigraph_pinhole(pinhole(film=replace(FILM, width=36.0, height=24.0))))
    high = lb.LensCamera(lens, lb.Film(6.0, 8.0, 60, 80), 1200.0, model="thin")
    raised = replace(high, film=lb.Film(6.0, 4.0, 60, 40), film_pose=lb.FilmPose(rise=2.0))
    whole, part = made.seen_by(high), made.seen_by(raised)
    assert part.covered.all() and np.ptp(part.picture) > 0.1
    np.testing.assert_allclose(part.picture, whole.picture[:40], atol=1e-5)
