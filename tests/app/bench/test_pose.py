"""Moving the camera by hand, as motions of a rigid body."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings as limits, strategies as st

from lensbench.app.bench.pose import STEEPEST, dollied, orbited, panned, pivot_distance
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.settings import Settings

FREE = replace(Settings(), scene="room")        # without a floor of the kind that ends a movement
angles, lengths = st.floats(-1.0, 1.0), st.floats(-500.0, 500.0)
poses = st.builds(lambda x, y, z, yaw, pitch, focus: replace(
    FREE, position=(x, y, z), yaw=yaw, pitch=pitch, focus_distance=focus),
    lengths, lengths, lengths, st.floats(-3.0, 3.0), angles, st.floats(100.0, 4000.0))
many = limits(max_examples=50)


def pivot(settings):
    frame = settings.world_from_camera
    return frame[:3, 3] - pivot_distance(settings) * frame[:3, 2]


@many
@given(poses, angles, angles)
def test_an_orbit_keeps_what_is_in_focus_where_it_is(pose, left, up):
    np.testing.assert_allclose(pivot(orbited(pose, left, up)), pivot(pose), atol=1e-8)


@many
@given(poses, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_an_orbit_there_and_back_is_none(pose, left, up):
    back = orbited(orbited(pose, left, up), -left, -up)
    np.testing.assert_allclose(back.world_from_camera, pose.world_from_camera, atol=1e-8)


@many
@given(poses, lengths, lengths)
def test_a_pan_moves_across_the_view_and_a_dolly_along_it(pose, right, up):
    view = pose.world_from_camera
    across = np.subtract(panned(pose, right, up).position, pose.position)
    along = np.subtract(dollied(pose, right).position, pose.position)
    np.testing.assert_allclose(view[:3, :3].T @ across, (right, up, 0.0), atol=1e-9)
    np.testing.assert_allclose(view[:3, :3].T @ along, (0.0, 0.0, -right), atol=1e-9)


def test_no_orbit_goes_over_the_pole():
    assert orbited(FREE, 0.0, 10.0).pitch == -STEEPEST
    assert orbited(FREE, 0.0, -10.0).pitch == STEEPEST


def test_what_is_seen_follows_the_hand():
    # a drag to the right takes the camera to the left of what it looks at, a drag downwards above it
    assert orbited(Settings(), 0.1, 0.0).position[0] < 0.0
    assert orbited(Settings(), 0.0, 0.1).position[1] > 0.0


def test_focus_at_infinity_has_a_pivot_within_reach():
    assert math.isfinite(pivot_distance(replace(Settings(), focus_distance=math.inf)))


def test_the_mouse_leaves_the_camera_above_the_floor():
    start, floor = Settings(), cached_scene(Settings().scene).floor

    def height(settings):
        return np.dot(settings.position, floor.normal) / np.linalg.norm(floor.normal) - floor.height

    for moved in (panned(start, 0.0, -5000.0), orbited(start, 0.3, -2.0),
                  dollied(replace(start, pitch=-0.5), 5000.0)):
        assert 9.9 < height(moved) < 11.0
    np.testing.assert_allclose(pivot(orbited(start, 0.3, -2.0)), pivot(start), atol=1e-8)
    below = replace(start, position=(0.0, floor.height - 100.0, 0.0))       # as a settings file may have it
    assert panned(below, 0.0, -10.0).position[1] == floor.height - 110.0
