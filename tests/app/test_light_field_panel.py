"""The panel *Light field* under a real mouse: it records what the library captures, and shows what that focuses."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.comparison import decibels
from lensbench.app.light_field_file import load_light_field
from lensbench.app.light_field_look import Look, moved, opened, radius
from lensbench.app.optics import camera
from lensbench.app.reach import with_longer_side

from .conftest import SMALL

START = replace(SMALL, model="thin")


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
    desk = hand.bench.light_field
    hand.wait(lambda: desk.worker.recording is not None, "the light field")
    shown(hand)


def shown(hand):
    """Wait until the picture is that of the look."""
    desk = hand.bench.light_field
    hand.wait(lambda: desk.sight is not None and desk.sight.look == desk.look.asked, "the picture of the light field")
    hand.ctx.yield_(2)


def open_panel(hand):
    hand.ctx.window_focus("Light field")
    hand.ctx.yield_(3)


def test_a_wide_aperture_gives_way_to_its_place_and_its_place_to_a_wide_aperture(field):
    look = moved(Look("focus", 1200.0), (0.6, 0.0), field)
    assert look.view == (0.6, 0.0) and radius(look, field) == pytest.approx(0.4)
    field.refocus(look.distance, look.f_number, look.view)
    look = opened(look, field.f_number / 0.7, field)
    assert look.view == pytest.approx((0.3, 0.0))
    assert opened(look, 0.1, field) == Look("focus", 1200.0)
    assert np.hypot(*moved(look, (30.0, -40.0), field).view) < 1.0


def test_what_is_recorded_is_what_the_library_captures_and_what_is_shown_what_it_focuses(drive, tmp_path):
    seen = {}

    def use(hand):
        desk = hand.bench.light_field
        open_panel(hand)
        record(hand)
        seen["recorded"] = desk.worker.recording.settings
        hand.drag(hand.at("**/Refocus", 0.5, 0.5), hand.at("**/Refocus", 0.7, 0.5))
        hand.drag(hand.at("**/Pupil pad", 0.5, 0.5), hand.at("**/Pupil pad", 0.7, 0.4))
        shown(hand)
        seen["look"], seen["image"] = desk.look, desk.sight.image
        assert hand.bench.easel.light is desk.sight.image
        # Nothing of this is a setting; a setting shows the camera again
        assert hand.settings == START
        hand.drag(hand.at("**/Aperture", 0.5, 0.5), hand.at("**/Aperture", 0.7, 0.5))
        hand.picture()
        assert desk.sight is None and hand.settings.f_number != START.f_number
        hand.press(imgui.Key.mod_ctrl | imgui.Key.z)
        assert hand.settings == START and desk.worker.recording is not None
        hand.ctx.item_click("//Light field/**/Show view")
        hand.ctx.mouse_move_to_pos(hand.at("**/Pupil grid", 0.5, 0.3))
        hand.ctx.mouse_click(0)
        shown(hand)
        assert desk.look.cell == (2, 3)
        assert np.array_equal(desk.sight.image, desk.worker.recording.field.view(2, 3))
        desk.worker.save(tmp_path / "field.npz")
        hand.wait(lambda: (tmp_path / "field.npz").is_file() and desk.worker.task is None, "the file")
        hand.bench.files.drop([str(tmp_path / "field.npz")])
        hand.wait(lambda: desk.look.show == "focus", "the file that was opened")

    bench = drive(use, START)
    assert all("saved as" in message for message in bench.view.messages)
    settings = replace(with_longer_side(START, 320), samples=1)
    assert seen["recorded"] == settings
    direct = lb.capture_light_field(camera(settings), lb.builtin_scene(settings.scene), (5, 5), 1, settings.seed)
    opened_again, same = load_light_field(tmp_path / "field.npz")
    assert np.array_equal(direct.light, opened_again.light) and same == settings
    look = seen["look"]
    assert look.distance > START.focus_distance and look.view[0] > 0.2 and look.view[1] > 0.1
    assert np.array_equal(seen["image"], direct.refocus(look.distance, look.f_number, look.view))


def test_the_camera_renders_the_same_picture_and_the_difference_is_shown(drive):
    def use(hand):
        desk = hand.bench.light_field
        open_panel(hand)
        record(hand)
        hand.ctx.item_click("//Light field/**/Compare with the camera")
        hand.wait(lambda: desk.worker.compared is not None, "the camera's picture")
        hand.ctx.yield_(3)
        assert hand.settings.compare == "difference"
        found = desk.worker.psnr(desk.look.asked)
        direct = lb.render(camera(desk.sight.recording.settings), lb.builtin_scene(START.scene), 256, START.seed)
        # The same samples, added up in another order
        assert found == pytest.approx(decibels(desk.sight.image, direct), abs=0.01)
        assert found > 23.0                     # the noise of 25 samples a pixel

    assert drive(use, START).view.messages == []


def test_what_cannot_be_recorded_is_said_and_a_recording_can_be_given_up(drive):
    def use(hand):
        desk = hand.bench.light_field
        hand.picture()
        open_panel(hand)
        desk.form.views, desk.form.samples, desk.form.longer = 17, 64, 960
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: desk.worker.task is not None and desk.worker.task.share > 0.0, "the first view")
        hand.ctx.item_click("//Light field/**/Cancel task")
        hand.wait(lambda: desk.worker.task is None, "the end")
        hand.ctx.yield_(2)
        assert desk.worker.recording is None and hand.bench.view.messages == []
        hand.ctx.item_click("//Controls/##Model")
        hand.ctx.item_click("//##Combo_00/Pinhole")
        hand.picture()
        hand.ctx.item_click("//Light field/**/Record")
        hand.wait(lambda: bool(hand.bench.view.messages), "the message")
        assert "through a lens" in hand.bench.view.messages[0]

    drive(use, START)
