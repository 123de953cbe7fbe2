"""Every kind of camera and its motion: in settings, on the command line and by hand."""

import math
import shlex
from dataclasses import fields, replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.build import place_and_shutter
from lensbench.app.bench.camera_kinds import MAKERS, CameraMaker, camera, readings
from lensbench.app.bench.constraints import with_camera, with_equivalent_film, with_layout, with_projection
from lensbench.app.bench.pose import dollied, orbited
from lensbench.app.bench.readouts import Readings
from lensbench.app.drawing.controls import chord
from lensbench.app.settings.camera_facts import CAMERA_KINDS, CAMERAS, CameraKind
from lensbench.app.settings.dial_scales import SHUTTERS, Scale, shutter_scale
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_duration, format_time, read_time
from tests.app.command.test_main import LENS, settings_of, viewed  # noqa: F401 - the fixture
from tests.app.conftest import SMALL
from tests.app.kinds import KINDS, of_kind


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
def test_every_model_makes_a_camera_that_takes_its_picture(model):
    settings = of_kind(SMALL, model)
    of = camera(settings)
    picture = lb.render(of, lb.builtin_scene("grid-wall"), samples=1)
    assert picture.shape == (settings.pixels_y, settings.pixels_x, 3) and picture.max() > 0.0
    assert readings(settings).limit is not None or model == "environment"


def test_a_kind_of_camera_is_a_row_of_facts_and_its_maker(viewed, monkeypatch):  # noqa: F811
    def make(settings):
        return lb.FisheyeCamera(settings.film, 2.0, fov_axis="horizontal", **place_and_shutter(settings))

    row = CameraKind("Round", "")
    monkeypatch.setitem(CAMERA_KINDS, "round", row)
    monkeypatch.setitem(CAMERAS, "round", row.title)
    monkeypatch.setitem(MAKERS, "round", CameraMaker(make, lambda settings: Readings(fov_horizontal=2.0)))
    settings = settings_of(viewed, *shlex.split("--camera round --size 120x80"))
    assert settings.kind is row and isinstance(camera(settings), lb.FisheyeCamera)
    assert readings(settings).fov_horizontal == 2.0 and settings_of(viewed, "--camera", "round").camera == "round"


def test_a_panorama_has_the_shape_of_its_layout_and_gives_the_films_back():
    panorama = with_camera(SMALL, "environment")
    assert (panorama.pixels_x, panorama.pixels_y) == (120, 60)
    assert with_layout(panorama, "equal-area").pixels_y == 120
    assert with_layout(panorama, "cube-map").pixels_y == 90
    assert with_camera(panorama, SMALL.camera) == SMALL


def test_an_orthographic_fisheye_sees_half_of_the_sphere_at_most():
    wide = replace(with_camera(SMALL, "fisheye"), fisheye_fov=math.radians(220.0))
    assert with_projection(wide, "orthographic").fisheye_fov == math.pi
    assert readings(wide).fov_vertical == pytest.approx(math.radians(220.0))
    full = replace(wide, fov_axis="diagonal", fisheye_fov=math.pi)
    got = readings(full)
    # equidistant: angles are as lengths on the film
    assert got.fov_diagonal == pytest.approx(math.pi, abs=1e-6)
    assert got.fov_vertical == pytest.approx(math.pi * 24.0 / math.hypot(36.0, 24.0), rel=1e-9)


def test_the_field_of_view_of_a_perspective_is_along_the_side_that_is_chosen():
    for axis, name in (("horizontal", "fov_horizontal"), ("vertical", "fov_vertical"), ("diagonal", "fov_diagonal")):
        got = readings(replace(Settings(), camera="perspective", fov=0.9, fov_axis=axis))
        assert getattr(got, name) == pytest.approx(0.9, rel=1e-12)


def test_options_arrive_in_the_settings(viewed):  # noqa: F811
    fisheye = settings_of(viewed, LENS, *shlex.split(
        "--camera fisheye --fov 200deg --projection stereographic --fov-axis diagonal --size 300x200"))
    assert fisheye.fisheye_fov == pytest.approx(math.radians(200.0)) and fisheye.projection == "stereographic"
    assert camera(fisheye).fov_axis == "diagonal"
    panorama = settings_of(viewed, LENS, *shlex.split("--camera environment --layout cube-map"))
    assert (panorama.pixels_x, panorama.pixels_y) == (960, 720)
    assert settings_of(viewed, LENS, *shlex.split("--camera environment --size 500x300")).pixels_y == 300
    flat = camera(settings_of(viewed, LENS, *shlex.split("--camera orthographic --scene-width 2m --lens-radius 5mm")))
    assert (flat.width, flat.lens_radius) == (2000.0, 5.0)
    moving = settings_of(viewed, LENS, *shlex.split(
        "--end-position 0,0,-0.5 --end-yaw 10deg --duration 2s --moment 500ms --shutter 1/4 --shutter-ramp 10% "
        "--readout 20ms --readout-direction left"))
    of = camera(moving)
    assert (of.shutter_open, of.shutter_close, of.shutter_ramp) == (0.5, 0.75, pytest.approx(0.025))
    assert (of.readout, of.readout_direction) == (0.02, "left")
    np.testing.assert_allclose(of.world_from_camera_at(1.0)[:3, 3], [0.0, 0.0, -250.0], atol=1e-9)


@pytest.mark.parametrize(("words", "said"), [
    ("--camera environment --fov 90deg", "no field of view"), ("--camera orthographic --fov 90deg", "--scene-width"),
    ("--camera fisheye --fov 400deg", "359.99"), ("--shutter 0", "lie from"), ("--shutter-ramp 60%", "0.5"),
    ("--readout=-1ms", "from 0 s"), ("--duration 0s", "lie from"), ("--scene-width 0m", "lie from"),
])
def test_what_a_camera_cannot_be_is_said_in_one_line(viewed, capsys, words, said):  # noqa: F811
    from lensbench.app.command.main import main

    assert main(["view", LENS, *shlex.split(words)]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


@pytest.mark.parametrize("model", ["trace", "perspective"])
def test_an_equivalent_film_keeps_the_field_and_the_depth_of_field(model):
    full = replace(of_kind(Settings(), model), f_number=8.0, focus_distance=3000.0)
    small = with_equivalent_film(full, 24.0, 16.0)
    assert small.f_number == pytest.approx(8.0 * 24.0 / 36.0)
    a, b = readings(full), readings(small)
    if model == "trace":
        assert b.fov_diagonal == pytest.approx(a.fov_diagonal, rel=1e-9)
    # the limits are alike as far as the focal length is small beside the distance
    assert (b.near_limit, b.far_limit) == (pytest.approx(a.near_limit, rel=0.01), pytest.approx(a.far_limit, rel=0.02))
    # a lens that cannot open so far goes as far as it does
    assert with_equivalent_film(replace(full, f_number=2.0), 24.0, 16.0).f_number is None or model == "perspective"


def test_a_still_camera_renders_the_same_picture_whatever_its_shutter():
    still = replace(SMALL, shutter=2.0, readout=0.01, shutter_ramp=0.2, duration=3.0)
    assert still.picture == SMALL.picture
    moving = replace(SMALL, end_position=(0.0, 0.0, 0.0))
    assert replace(moving, shutter=2.0).picture != moving.picture
    fair = replace(SMALL, scene="fairground")               # where other things move
    assert replace(fair, shutter=2.0, moment=0.5).picture != fair.picture


def test_a_hand_moves_the_nearer_keyframe_and_goes_there():
    moving = replace(SMALL, end_position=(0.0, 0.0, -100.0), moment=0.7)
    late = dollied(moving, 50.0)
    assert late.moment == moving.duration and late.position == SMALL.position
    assert late.end_position == pytest.approx((0.0, 0.0, -150.0))
    early = orbited(replace(moving, moment=0.3), 0.1, 0.0)
    assert early.moment == 0.0 and early.end_position == moving.end_position and early.yaw == pytest.approx(-0.1)
    np.testing.assert_allclose(replace(moving, moment=0.5).present_pose[:3, 3], [0.0, 0.0, -50.0], atol=1e-9)


def test_a_camera_between_two_equal_keyframes_or_past_the_second_stands_still():
    here = replace(SMALL, position=(10.0, 0.0, 50.0), yaw=0.2)
    equal = replace(here, end_position=here.position, end_yaw=here.yaw, end_pitch=here.pitch)
    np.testing.assert_array_equal(equal.placement, here.world_from_camera)
    there = replace(equal, end_yaw=0.3)
    assert isinstance(there.placement, lb.AnimatedTransform)
    np.testing.assert_array_equal(replace(there, moment=there.duration).placement,
                                  replace(here, yaw=0.3).world_from_camera)


def test_times_are_read_as_they_are_written():
    for seconds in SHUTTERS:
        assert read_time(format_time(seconds)) == pytest.approx(seconds, rel=1e-12)
    for seconds in (0.0, 3.5e-4, 2.5e-3, 0.02, 1.25):
        assert read_time(format_duration(seconds)) == pytest.approx(seconds, rel=1e-9)
    with pytest.raises(ValueError, match="1/125"):
        read_time("soon")


def test_third_stops_of_the_shutter_halve_the_time_every_third_click():
    dial: Scale = shutter_scale()
    for k, seconds in enumerate(SHUTTERS):
        # engraved figures are round (30 s means 32 s), but none as far off as half the way to its neighbour
        assert abs(math.log2(seconds) - (5.0 - k / 3.0)) < 1.0 / 6.0
    assert dial.stepped(1 / 125, 3) == 1 / 250 and dial.stepped(1 / 125, -3) == 1 / 60
    assert dial.to_unit(30.0) == 0.0 and dial.to_unit(1 / 8000) == 1.0
    assert dial.from_unit(dial.to_unit(0.01)) == pytest.approx(0.01)
    with pytest.raises(ValueError, match="out of reach"):
        dial.parse("60 s")


def test_a_settings_error_names_a_camera_that_is_none():
    with pytest.raises(SettingsError, match="choose one of"):
        replace(Settings(), projection="flat").checked()


@pytest.mark.slow
def test_the_camera_is_keyframed_scrubbed_and_stilled_by_hand(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/###Drawer Shutter")
        hand.ctx.item_click("//$FOCUSED/Move the camera")
        hand.ctx.yield_(2)
        assert hand.settings.end_position == SMALL.position and hand.settings.moment == SMALL.duration
        hand.press(imgui.Key.escape)
        start = hand.at("**/Picture", 0.5, 0.5)
        hand.drag(start, hand.at("**/Picture", 0.7, 0.5), button=1)
        hand.picture()
        assert hand.settings.end_position[0] < 0.0 and hand.settings.position == SMALL.position
        hand.ctx.item_click("**/###Drawer Shutter")
        hand.drag(hand.at("**/Time", 0.9, 0.5), hand.at("**/Time", 0.5, 0.5))
        assert 0.0 < hand.settings.moment < SMALL.duration
        hand.drag(hand.at("**/Shutter", 0.6, 0.5), hand.at("**/Shutter", 0.3, 0.5))
        assert hand.settings.shutter > SMALL.shutter
        hand.ctx.item_click("//$FOCUSED/Order left")
        hand.picture()
        assert hand.settings.readout_direction == "left"
        hand.ctx.item_click("//$FOCUSED/Remove the motion")
        hand.picture()
        assert not hand.settings.keyframed
        hand.press(imgui.Key.escape)
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings.keyframed

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_panorama_and_fisheye_are_set_by_their_own_lists(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Camera")
        hand.ctx.item_click("//##Combo_00/Panorama")
        hand.picture()
        hand.ctx.item_click("//Controls/##Layout")
        hand.ctx.item_click("//##Combo_00/cube-map")
        hand.picture()
        assert (hand.settings.layout, hand.settings.pixels_y) == ("cube-map", 90)
        hand.ctx.item_click("//Controls/##Camera")
        hand.ctx.item_click("//##Combo_00/Ideal fisheye")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//Controls/##Rule")
        hand.ctx.item_click("//##Combo_00/stereographic")
        hand.picture()
        assert (hand.settings.projection, hand.settings.pixels_y) == ("stereographic", 80)

    assert drive(use).view.messages == []


def test_the_own_settings_of_a_kind_are_settings_with_an_option():
    names = {field.name for field in fields(Settings)}
    for kind in CAMERA_KINDS.values():
        assert set(kind.own) | set(kind.film_lengths) <= names
