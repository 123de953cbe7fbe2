"""Plan, spaces and falloff: what the panels draw is what the camera's own rays say."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.readouts import intrinsics
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.falloff import falling
from lensbench.app.panels.spaces import along, rows
from lensbench.app.plots.pixel_rays import thing_at
from lensbench.app.plots.plan import extent, plan, things
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

PERSPECTIVE = replace(Settings(), camera="perspective", f_number=4.0)


@pytest.mark.parametrize("yaw", [0.0, 0.4, -2.0])
def test_the_view_from_above_opens_by_the_field_of_view_about_the_cameras_way(yaw):
    settings = replace(PERSPECTIVE, yaw=yaw, position=(300.0, 100.0, -200.0))
    shown = plan(settings)
    np.testing.assert_allclose(shown.place, [0.3, 0.2], atol=1e-12)
    np.testing.assert_allclose(shown.ahead, [-math.sin(yaw), math.cos(yaw)], atol=1e-12)
    left, right = shown.view[:, 1] - shown.view[:, 0]
    turn = math.atan2(left[0] * right[1] - left[1] * right[0], left @ right)
    assert -turn == pytest.approx(readings(settings).fov_horizontal, rel=1e-9)      # clockwise, from left to right


@pytest.mark.parametrize("pitch", [0.0, 0.5])
def test_the_plane_in_focus_and_its_band_stand_at_their_distances(pitch):
    settings = replace(PERSPECTIVE, pitch=pitch, focus_distance=2000.0)
    shown, got = plan(settings), readings(settings)
    # At the camera's height a plane across a pitched axis lies farther off; the rays of the middle line are pitched too
    away = math.cos(pitch)
    assert shown.focus[:, 1] == pytest.approx([2.0 * away] * 2, rel=1e-9)
    near, far = shown.band[0, 1], shown.band[3, 1]
    assert (near, far) == (pytest.approx(got.near_limit / 1000.0 * away), pytest.approx(got.far_limit / 1000.0 * away))
    assert plan(replace(settings, f_number=None)).focus is None         # a pinhole focuses nowhere
    assert plan(replace(settings, camera="environment")).view is None


def test_things_stand_where_the_scene_has_them_and_where_their_motion_brings_them():
    scene = lb.builtin_scene("still-life")
    shown = things("still-life", 0.0)
    assert len(shown) == len(scene.spheres) + len(scene.plates)
    middles = {tuple(np.round(thing.outline.mean(0), 6)) for thing in shown}
    assert {(round(s.centre[0] / 1000, 6), round(-s.centre[2] / 1000, 6)) for s in scene.spheres} <= middles
    assert things("no-such-scene", 0.0) == ()
    later = things("fairground", 2.0)
    assert any(not np.allclose(a.outline, b.outline) for a, b in zip(things("fairground", 0.0), later, strict=True))


def test_the_plan_fits_the_camera_and_its_focus():
    settings = replace(PERSPECTIVE, focus_distance=3000.0)
    x0, x1, y0, y1 = extent(plan(settings), things("still-life", 0.0), 4000.0)
    assert x0 < 0.0 < x1 and y0 < 0.0 and y1 > 3.0


def test_the_spaces_of_the_middle_of_a_picture():
    of = camera(replace(PERSPECTIVE, pixels_x=60, pixels_y=40))
    depth = np.full((40, 60), 1500.0, np.float32)
    table = {name: numbers for name, numbers, *_ in rows(of, (30.0, 20.0), depth)}
    assert table == {"Raster": ("30.0", "20.0"), "NDC": ("0.5000", "0.5000"), "Screen": ("0.000", "0.000"),
                     "Film": ("0.000", "0.000"), "Camera": ("0.000", "0.000", "−1.500"),
                     "World": ("0.000", "0.000", "−1.500"), "Screen z": table["Screen z"], "Distance": ("1.500",)}
    # of the matrix's own z; the step is that of float32, whose unit between 1/2 and 1 is 2⁻²⁴
    z, step = table["Screen z"]
    matrix = of.spaces(100.0, 1e5).screen_from_camera
    assert float(z) == pytest.approx((matrix @ [0, 0, -1500, 1])[2] / 1500.0, abs=1e-5)
    assert float(step) == pytest.approx(1000.0 * 2.0**-24 * 1500.0**2 / 100.0, rel=0.05)
    sky = {name: numbers for name, numbers, *_ in rows(of, (3.0, 2.0), np.full((40, 60), np.inf, np.float32))}
    assert sky["World"] == sky["Distance"] == sky["Screen z"] == ("–",) and sky["Screen"] == ("−1.350", "0.900")


@pytest.mark.parametrize("model", ["trace", "thin", "perspective", "fisheye"])
def test_a_point_pointed_at_is_seen_at_that_point(model):
    settings = replace(of_kind(SMALL, model), yaw=0.2, pitch=-0.1, position=(10.0, 20.0, 30.0), fisheye_fov=2.0)
    of, position = camera(settings), (33.0, 61.0)
    depth = np.full((settings.pixels_y, settings.pixels_x), 900.0, np.float32)
    ray = of.generate_rays([position], [of.pupil_centre])
    point = ray.origins + along(of, position, depth) * ray.directions
    assert (np.linalg.inv(settings.world_from_camera) @ [*point[0], 1.0])[2] == pytest.approx(-900.0, abs=1e-6)
    raster, visible = of.raster_from_point(point)
    assert visible[0]
    np.testing.assert_allclose(raster[0], position, atol=1e-6)


def test_a_point_of_a_thing_is_told_in_the_frame_of_the_thing():
    ball = lb.Sphere((100.0, 0.0, -900.0), 50.0)
    wall = lb.Rectangle((0.0, 0.0, -2000.0), (0.0, 300.0, 0.0), (-400.0, 0.0, 0.0))
    scene = lb.Scene("two", spheres=(ball,), plates=(wall,))
    name, point = thing_at(scene.objects, np.array([100.0, 50.0, -900.0]), 0.0)
    assert name.startswith("sphere") and point.tolist() == [0.0, 50.0, 0.0]
    name, point = thing_at(scene.objects, np.array([200.0, 120.0, -2000.0]), 0.0)
    assert name == "rectangle" and np.allclose(point, [120.0, -200.0, 0.0])
    assert thing_at(scene.objects, np.array([0.0, 0.0, -1500.0]), 0.0) is None
    moving = replace(scene, spheres=(replace(ball, velocity=(0.0, 10.0, 0.0)),))
    assert thing_at(moving.objects, np.array([100.0, 70.0, -900.0]), 2.0)[1].tolist() == [0.0, 50.0, 0.0]


def test_intrinsics_are_the_focal_length_in_pixels():
    settings = replace(PERSPECTIVE, position=(1.0, 2.0, 3.0))
    document = json.loads(intrinsics(camera(settings)))
    got = readings(settings)
    assert document["fx"] == pytest.approx(got.efl / settings.film_width * settings.pixels_x, rel=1e-12)
    assert (document["cx"], document["cy"]) == (480.0, 320.0)
    assert np.array(document["world_from_camera"])[:3, 3].tolist() == [1.0, 2.0, 3.0]
    assert document["units"] == "pixels, mm"
    parallel = json.loads(intrinsics(camera(replace(settings, camera="orthographic"))))
    assert parallel["units"] == "pixels per mm, mm"
    assert intrinsics(camera(replace(settings, camera="environment"))) is None


def test_falloff_and_distortion_reach_to_the_corner_and_a_fisheye_is_measured_as_one():
    settings = Settings()
    analysis = falling(bench_of(settings))
    assert analysis.light.radii[-1] == pytest.approx(settings.film.diagonal / 2.0)
    assert analysis.light.total[-1] == pytest.approx(analysis.light.natural[-1] * analysis.light.vignetting[-1])
    assert analysis.shape.projection == "rectilinear" and analysis.shape.kind == "barrel"
    wide = next(card.name for card in lenses.describe() if "isheye" in card.title)
    assert falling(bench_of(replace(settings, lens=wide))).shape.projection != "rectilinear"


@pytest.mark.slow
def test_the_panels_are_opened_and_the_focus_is_dragged_in_the_plan(drive, tmp_path):
    path = tmp_path / "camera.json"

    def use(hand):
        hand.picture()
        for tab in ("Plan", "Spaces", "Falloff"):
            hand.ctx.window_focus(f"//{tab}")
        hand.ctx.yield_(4)
        start = hand.at("**/Plane in focus", 0.5, 0.5)
        hand.drag(start, ImVec2(start.x, start.y - 25.0))
        assert hand.settings == replace(SMALL, focus_distance=hand.settings.focus_distance)
        assert hand.settings.focus_distance > SMALL.focus_distance + 100.0
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings == SMALL
        hand.ctx.item_click("**/Distortion grid")
        hand.ctx.item_click("**/Save intrinsics")
        hand.ctx.yield_(2)
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(path))
        hand.wait(path.exists, "the file")
        assert json.loads(path.read_text())["width"] == SMALL.pixels_x
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.3, 0.4))
        hand.ctx.yield_(2)
        assert hand.session.view.pointed == hand.session.view.links.hover

    assert drive(use).view.messages == ["Intrinsics saved as camera.json"]
