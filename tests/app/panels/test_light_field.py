"""The panel *Light field* under a real mouse: it records what the library captures, and shows what that focuses."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.light_field_query import (
    Look, Recording, epipolar, radiance, radius, ray, with_aperture, with_view
)
from lensbench.app.bench.tone import decibels, depth_codes, depth_picture, develop, ends
from lensbench.app.drawing.controls import chord
from lensbench.app.session.export import read_settings
from lensbench.app.session.recordings import load_light_field
from lensbench.core.kernels.numeric import linear
from tests.app.conftest import SMALL

pytestmark = pytest.mark.slow

START = replace(SMALL, lens_model="thin")


@pytest.fixture(scope="module")
def field():
    return lb.capture_light_field(camera(START), lb.builtin_scene(START.scene), (3, 3), 1)


def record(hand):
    """Five by five views of 320 pixels, a sample each, by the buttons."""
    hand.picture()
    hand.ctx.item_click("//Light field/**/Views 5")
    hand.ctx.item_click("//Light field/**/Samples 1")
    hand.ctx.item_click("//Light field/**/Pixels 320")
    hand.ctx.item_click("//Light field/**/Record")
    controller = hand.session.light_field
    hand.wait(lambda: controller.worker.recording is not None, "the light field")
    shown(hand)


def shown(hand):
    """Wait until the picture is that of the look, in full."""
    controller = hand.session.light_field
    hand.wait(lambda: controller.field_picture is not None
              and controller.field_picture.look == controller.look.asked and not controller.field_picture.coarse,
              "the picture of the light field")
    hand.ctx.yield_(2)


def open_panel(hand):
    hand.ctx.window_focus("Light field")
    hand.ctx.yield_(3)


def test_a_wide_aperture_gives_way_to_its_place_and_its_place_to_a_wide_aperture(field):
    look = with_view(Look("focus", 1200.0), (0.6, 0.0), field)
    assert look.view == (0.6, 0.0) and radius(look, field) == pytest.approx(0.4)
    field.refocus(look.distance, look.f_number, look.view)
    look = with_aperture(look, field.f_number / 0.7, field)
    assert look.view == pytest.approx((0.3, 0.0))
    assert with_aperture(look, 0.1, field) == Look("focus", 1200.0)
    assert np.hypot(*with_view(look, (30.0, -40.0), field).view) < 1.0


def test_a_pixel_and_a_line_show_what_the_views_see_and_a_ray_meets_both_planes(field):
    recording, pixel, cell = Recording(field, START), (50, 30), (2, 0)
    light, line = radiance(recording, pixel), epipolar(recording, 30, 0)
    for i in range(3):
        assert np.array_equal(light[0, i], field.view(i, 0)[30, 50])
        assert np.array_equal(line[i], field.view(i, 0)[30])
    film, pupil = ray(recording, pixel, cell)
    aside = field.offsets[0, 2]
    expected = field.camera.places([(50.5 + aside[0], 30.5 + aside[1])], 1.0).film[0]
    assert film == pytest.approx(expected[:2], abs=1e-9)
    # The thin lens is its own exit pupil: EFL over twice the f-number, and the cell's middle lies at ⅔ of it
    radius = lb.first_order(field.camera.lens).efl / START.f_number / 2.0
    assert pupil == pytest.approx((2.0 / 3.0 * radius, -2.0 / 3.0 * radius), rel=1e-4)


def test_colours_of_depth_run_from_far_to_near_and_what_is_not_sure_is_dark():
    distance = np.repeat(np.array([[500.0, 1000.0, 2000.0, 1e9]], np.float32), 100, 0)      # a column each
    depth = lb.Depth(distance, np.ones_like(distance), 0.1 * distance, np.zeros((100, 4, 3), np.float32))
    assert ends(depth) == pytest.approx((1e9, 500.0))
    codes = depth_codes(depth)[0]
    light = linear(codes.astype(float)) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) < 0.0).all()                 # the nearer the lighter
    unsure = depth_codes(lb.Depth(distance, np.zeros_like(distance), 0.1 * distance, depth.picture))[0]
    assert np.allclose(unsure, 0.3 * codes)
    assert np.allclose(depth_picture(depth, Path("a.exr"))[0, :, 1], distance[0] / 1000.0)
    again = develop(depth_picture(depth, Path("a.png")), 0.0, "none")       # what a PNG without tone shows
    assert np.abs(again[0] - codes).max() < 1e-3


def test_what_is_recorded_is_what_the_library_captures_and_what_is_shown_what_it_focuses(drive, tmp_path):
    values = {}

    def use(hand):
        controller = hand.session.light_field
        open_panel(hand)
        record(hand)
        values["recorded"] = controller.worker.recording.settings
        hand.drag(hand.at("**/Refocus", 0.5, 0.5), hand.at("**/Refocus", 0.7, 0.5))
        hand.drag(hand.at("**/Pupil pad", 0.5, 0.5), hand.at("**/Pupil pad", 0.7, 0.4))
        shown(hand)
        values["look"], values["image"] = controller.look, controller.field_picture.image
        assert hand.session.presenter.light is controller.field_picture.image
        # Nothing of this is a setting; a setting shows the camera again
        assert hand.settings == START
        hand.drag(hand.at("**/Aperture", 0.5, 0.5), hand.at("**/Aperture", 0.7, 0.5))
        hand.picture()
        assert controller.field_picture is None and hand.settings.f_number != START.f_number
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings == START and controller.worker.recording is not None
        hand.ctx.item_click("//Light field/**/Show view")
        hand.ctx.mouse_move_to_pos(hand.at("**/Pupil grid", 0.5, 0.3))
        hand.ctx.mouse_click(0)
        shown(hand)
        assert controller.look.cell == (2, 3)
        view = controller.worker.recording.field.view(2, 3)
        assert np.array_equal(controller.field_picture.image, view)
        assert np.array_equal(hand.session.picture_now()[0], view)      # for snapshots and the clipboard
        hand.session.files.save_picture(tmp_path / "shown.png")
        assert read_settings(tmp_path / "shown.png").pixels_x == controller.worker.recording.settings.pixels_x
        controller.worker.save(tmp_path / "field.npz")
        hand.wait(lambda: (tmp_path / "field.npz").is_file() and controller.worker.task is None, "the file")
        hand.session.files.drop([str(tmp_path / "field.npz")])
        hand.wait(lambda: controller.look.show == "focus", "the file that was opened")

    session = drive(use, START)
    assert session.view.messages == ["Picture saved as shown.png", "Light field saved as field.npz"]
    settings = replace(with_longer_side(START, 320), samples=1)
    assert values["recorded"] == settings
    direct = lb.capture_light_field(camera(settings), lb.builtin_scene(settings.scene), (5, 5), 1, settings.seed)
    again = load_light_field(tmp_path / "field.npz")
    assert np.array_equal(direct.light, again.field.light) and again.settings == settings
    look = values["look"]
    assert look.distance > START.focus_distance and look.view[0] > 0.2 and look.view[1] > 0.1
    assert np.array_equal(values["image"], direct.refocus(look.distance, look.f_number, look.view))


def test_the_camera_renders_the_same_picture_and_the_difference_is_shown(drive):
    def use(hand):
        controller = hand.session.light_field
        open_panel(hand)
        record(hand)
        hand.ctx.item_click("//Light field/**/Compare with the camera")
        hand.wait(lambda: controller.worker.compared is not None, "the camera's picture")
        hand.ctx.yield_(3)
        assert hand.settings.compare == "difference"
        psnr = controller.worker.psnr(controller.look.asked)
        recorded = controller.field_picture.recording.settings
        direct = lb.render(camera(recorded), lb.builtin_scene(START.scene), 256, START.seed)
        # The same samples, added up in another order
        assert psnr == pytest.approx(decibels(controller.field_picture.image, direct), abs=0.01)
        assert psnr > 23.0                     # the noise of 25 samples a pixel
        # From another place in the pupil too
        hand.drag(hand.at("**/Pupil pad", 0.5, 0.5), hand.at("**/Pupil pad", 0.65, 0.4))
        shown(hand)
        before = controller.worker.compared
        hand.ctx.item_click("//Light field/**/Compare with the camera")
        hand.wait(lambda: controller.worker.compared is not before, "the camera's picture from there")
        assert controller.worker.psnr(controller.look.asked) > 20.0
        assert decibels(controller.field_picture.image, direct) < controller.worker.psnr(controller.look.asked) - 1.0

    assert drive(use, START).view.messages == []


def test_depth_is_found_shown_and_focused_at_and_a_pixel_is_chosen_by_a_click(drive, tmp_path):
    def use(hand):
        controller = hand.session.light_field
        open_panel(hand)
        record(hand)
        hand.ctx.item_click("//Light field/**/Show depth")
        shown(hand)
        words = hand.session.presenter.picture(hand.settings, hand.session.view).note
        assert "not found yet" in words and "all in focus" not in words
        hand.ctx.item_click("//Light field/**/Find the depth")
        hand.wait(lambda: controller.worker.known_depth is not None, "the depth")
        depth = controller.worker.known_depth
        shown(hand)
        hand.wait(lambda: controller.field_picture.image is depth.picture, "the picture in focus everywhere")
        hand.ctx.item_click("//Light field/**/Depth picture depth")
        shown(hand)
        assert np.array_equal(hand.session.presenter.light, depth_codes(depth))
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.45, 0.75))
        hand.ctx.mouse_click(0)
        hand.ctx.yield_(3)
        x, y = controller.look.pixel
        assert (x, y) == pytest.approx((0.45 * 320, 0.75 * 213), abs=25) and hand.settings == START
        hand.ctx.item_click("//Light field/**/Focus there")
        hand.ctx.yield_(2)
        assert controller.look.show == "focus" and controller.look.distance == depth.distance[y, x]
        # Now a click focuses
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.6, 0.35))
        hand.ctx.mouse_click(0)
        hand.ctx.yield_(3)
        x, y = controller.look.pixel
        assert controller.look.distance == depth.distance[y, x] > START.focus_distance
        shown(hand)
        controller.save_picture(tmp_path / "there.exr", hand.settings)
        saved = read_settings(tmp_path / "there.exr")
        assert (saved.focus_distance, saved.pixels_x) == (controller.look.distance, 320)
        # What was recorded of the pixel and its line
        hand.ctx.item_click("//Light field/**/Show rays")
        hand.ctx.mouse_move_to_pos(hand.at("**/Epipolar image", 0.25, 0.5))
        hand.ctx.mouse_click(0)
        hand.ctx.item_click("//Light field/**/Band 1")
        hand.ctx.yield_(2)
        assert controller.look.pixel == (pytest.approx(80, abs=2), y) and controller.look.band == 1
        assert hand.settings == START

    session = drive(use, START)
    assert session.view.messages == ["Picture saved as there.exr"]


def test_a_click_before_the_depth_is_known_says_how_to_focus_by_it(drive):
    """The focus tool is lit, and nothing happened."""
    def use(hand):
        open_panel(hand)
        record(hand)
        before = hand.session.light_field.look.distance
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.6, 0.35))
        hand.ctx.mouse_click(0)
        hand.ctx.yield_(3)
        assert hand.session.light_field.look.distance == before and hand.settings == START
        assert "Find the depth" in hand.session.view.messages[0]

    drive(use, START)


def test_a_plenoptic_camera_is_recorded_by_buttons_and_its_sensor_shown(drive):
    def use(hand):
        controller = hand.session.light_field
        hand.picture()
        open_panel(hand)
        hand.ctx.item_click("//Light field/**/Method microlenses")
        hand.ctx.item_click("//Light field/**/Pixels 5")
        hand.ctx.item_click("//Light field/**/Samples 1")
        hand.ctx.item_click("//Light field/**/Lenses 120")
        matched = controller.form.plenoptic(hand.settings).matched_f_number
        hand.drag(hand.at("**/Microlens f-number", 0.5, 0.5), hand.at("**/Microlens f-number", 0.7, 0.5))
        assert controller.form.f_number > matched and controller.form.plenoptic(hand.settings).spilled > 0.0
        hand.ctx.item_double_click("**/Microlens f-number")
        hand.ctx.yield_(2)
        assert controller.form.f_number is None
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: controller.worker.recording is not None, "the light field")
        shown(hand)
        hand.ctx.item_click("//Light field/**/Show view")
        hand.ctx.item_click("//Light field/**/Show True")
        shown(hand)
        raw = controller.worker.recording.raw
        assert raw.camera.pixels == 5 and hand.session.presenter.light is raw.picture
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.6, 0.6))
        hand.ctx.mouse_click(0)
        hand.ctx.yield_(2)
        assert controller.look.pixel == (pytest.approx(72, abs=12), pytest.approx(48, abs=12))    # a microlens

    assert drive(use, START).view.messages == []


def test_an_array_is_recorded_by_buttons_and_seen_from_elsewhere(drive, tmp_path):
    def use(hand):
        controller = hand.session.light_field
        hand.picture()
        open_panel(hand)
        hand.ctx.item_click("//Light field/**/Method array")
        hand.ctx.item_click("//Light field/**/Views 5")
        hand.ctx.item_click("//Light field/**/Samples 1")
        hand.ctx.item_click("//Light field/**/Pixels 320")
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: controller.worker.recording is not None, "the array")
        shown(hand)
        assert controller.field_picture.covered == 1.0
        hand.drag(hand.at("**/Array pad", 0.5, 0.5), hand.at("**/Array pad", 0.6, 0.45))
        shown(hand)
        x, y, forwards = controller.look.place
        assert x == pytest.approx(3.0, abs=0.5) and y == pytest.approx(1.5, abs=0.5)     # pinholes to 10 mm, room to 15
        array = controller.worker.recording.array
        moved = np.eye(4)
        moved[:2, 3] = x, y
        there = replace(array.camera, world_from_camera=array.camera.placement() @ moved)
        assert np.array_equal(controller.field_picture.image, array.seen_by(there).picture)
        assert controller.field_picture.covered > 0.98
        hand.drag(hand.at("**/Array pad", 0.6, 0.45), hand.at("**/Array pad", 0.98, 0.45))
        shown(hand)
        assert controller.field_picture.covered < 0.5             # beside the array
        hand.drag(hand.at("**/Forwards", 0.5, 0.5), hand.at("**/Forwards", 0.6, 0.5))
        hand.ctx.item_click("//Light field/**/Objects plane")
        shown(hand)
        assert controller.look.place[2] > 0.0 and controller.look.surface == "plane" and hand.settings == START
        controller.worker.save(tmp_path / "array.npz")
        hand.wait(lambda: controller.worker.task is None, "the file")
        before = controller.worker.recording
        controller.worker.open(tmp_path / "array.npz")
        hand.wait(lambda: controller.worker.recording is not before, "the file that was opened")
        shown(hand)
        assert np.array_equal(controller.worker.recording.array.pictures, array.pictures)

    assert drive(use, START).view.messages == ["Light field saved as array.npz"]


def test_what_cannot_be_recorded_is_said_and_a_recording_can_be_given_up(drive):
    def use(hand):
        controller = hand.session.light_field
        hand.picture()
        open_panel(hand)
        controller.form.views, controller.form.samples, controller.form.longer = 17, 64, 960
        hand.ctx.item_click("//Light field/**/Record")
        worker = controller.worker
        hand.wait(lambda: worker.task is not None and worker.task.progress > 0.0, "the first view")
        hand.ctx.item_click("//Light field/**/Cancel task")
        hand.wait(lambda: controller.worker.task is None, "the end")
        hand.ctx.yield_(2)
        assert controller.worker.recording is None and hand.session.view.messages == []
        hand.ctx.item_click("//Controls/##Camera")
        hand.ctx.item_click("//##Combo_00/Pinhole")
        hand.picture()
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: bool(hand.session.view.messages), "the message")
        assert "through a lens" in hand.session.view.messages[0]

    drive(use, START)
