"""Distances of a light field recorded through a window into water: true ones, as those of the camera."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Look, Recording, light_field_picture, picture_settings
from lensbench.app.settings.settings import Settings

WATER = replace(Settings(), medium="water", visibility=60_000.0, pixels_x=60, pixels_y=40, f_number=2.8,
                focus_distance=1500.0, lens_model="thick", scene="room")


@pytest.fixture(scope="module")
def recording():
    return Recording(lb.capture_light_field(camera(WATER), lb.builtin_scene("room"), (7, 7), 4, 1), WATER)


def test_a_camera_and_its_settings_know_the_same_window():
    for settings in (WATER, replace(WATER, lens_model="trace"), replace(WATER, medium="air")):
        of, built = camera(settings).flat_port, bench_of(settings).port
        assert of.index == built.index
        if of.index != 1.0:
            assert of.window == pytest.approx(built.window, rel=1e-12)


def test_a_light_field_in_water_is_refocused_to_true_distances(recording):
    assert recording.clear_range[0] < 1500.0 < recording.clear_range[1]
    for distance in (1500.0, 2100.0):
        look = Look("focus", distance)
        own = lb.render(camera(picture_settings(recording, look)), lb.builtin_scene("room"), 64, 2)
        inner = np.s_[4:-4, 4:-4]
        found = light_field_picture(recording, look, None)
        wrong = recording.field.refocus(distance)                               # as in air
        error, other = (float(np.abs(np.clip(each, 0, 1) - np.clip(own, 0, 1))[inner].mean())
                        for each in (found, wrong))
        assert error < 0.7 * other
    seen = recording.seen(1500.0)
    assert 1130.0 < seen < 1170.0                                               # 1.5 m / 1.333, from the window on
