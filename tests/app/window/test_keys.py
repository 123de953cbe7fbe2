"""Keys that lead back, and marks and tooltips that go when they are no longer true or wanted."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.framing import with_scene
from lensbench.app.display.frame import Mark
from lensbench.app.display.presenter import _first_mark
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.controls.controls import Chooser
from lensbench.app.session.states import History
from lensbench.app.settings.settings import Settings
from lensbench.app.window.actions import reset_all, reset_camera
from lensbench.app.workers.render_job import RenderUpdate
from tests.app.conftest import SMALL


def tooltip() -> bool:
    window = imgui.internal.find_window_by_name("##Tooltip_00")
    return window is not None and window.active


@pytest.mark.slow
def test_escape_closes_what_has_opened(drive):
    def use(hand):
        hand.picture()
        for item in ("//Controls/##Scene", "//Controls/##Film", "**/Picture size"):
            hand.ctx.item_click(item)
            hand.ctx.yield_(2)
            assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
            hand.press(imgui.Key.escape)
            assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        assert hand.settings == SMALL

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_home_brings_the_camera_back_and_leaves_the_rest(drive):
    moved = replace(SMALL, position=(100.0, 50.0, -200.0), yaw=0.3, pitch=-0.1, focus_distance=900.0, f_number=4.0)

    def use(hand):
        hand.picture()
        hand.press(imgui.Key.home)
        assert hand.settings == with_scene(moved, moved.scene)
        assert replace(hand.settings, position=moved.position, yaw=0.3, pitch=-0.1, focus_distance=900.0) == moved
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings == moved

    assert drive(use, moved).view.messages == []


def test_the_camera_goes_back_to_where_a_scene_with_a_stated_subject_opens():
    opened = with_scene(SMALL, "dusk-street")
    moved = replace(opened, position=(100.0, 50.0, -200.0), yaw=0.3, focus_distance=9000.0)
    state = SimpleNamespace(edited=moved, chooser=Chooser())
    reset_camera(state)
    assert state.edited == opened
    locked = SimpleNamespace(edited=moved, chooser=Chooser(locked={"focus"}))
    reset_camera(locked)                                    # the padlock keeps the focus, and not the place
    assert locked.edited == replace(opened, focus_distance=9000.0, position=(0.0, 0.0, 4400.0))
    state.history = History(replace(moved, tilt=0.1, exposure=2.0))
    reset_all(state)
    assert state.edited == with_scene(Settings(), "dusk-street") == state.history.present


@pytest.mark.slow
def test_a_ring_that_has_been_turned_explains_itself_no_more_until_the_mouse_comes_back(drive):
    def use(hand):
        hand.picture()
        ring = hand.at("**/Exposure", 0.6, 0.5)
        hand.ctx.mouse_move_to_pos(ring)
        hand.ctx.sleep_no_skip(1.0, 0.1)
        assert tooltip()
        hand.drag(ring, hand.at("**/Exposure", 0.7, 0.5))
        hand.ctx.sleep_no_skip(1.0, 0.1)
        assert not tooltip()
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.5, 0.5))
        hand.ctx.yield_(3)
        hand.ctx.mouse_move_to_pos(ring)
        hand.ctx.sleep_no_skip(1.0, 0.1)
        assert tooltip()

    assert drive(use).view.messages == []


def test_the_focus_mark_holds_only_while_the_picture_looks_at_the_same():
    mark = Mark(0.5, 0.5, 1200.0, SMALL.aim)
    for kept in (SMALL, replace(SMALL, f_number=8.0), replace(SMALL, exposure=1.0), replace(SMALL, overlay="coc")):
        assert mark.holds(kept)
    for changed in (replace(SMALL, focus_distance=1300.0), replace(SMALL, crop=0.5), replace(SMALL, focal_length=80.0),
                    replace(SMALL, lens="pbrt-wide-22mm"), replace(SMALL, scene="room"), replace(SMALL, yaw=0.1),
                    replace(SMALL, lens_model="thin")):
        assert not mark.holds(changed)


def test_the_first_mark_stands_amid_what_is_in_focus_and_not_on_a_stray_pixel():
    depth = np.full((80, 120), 5000.0, np.float32)
    depth[40, 60] = 1200.0                          # in the very middle, alone
    depth[20:40, 30:50] = 1205.0
    depth[0:12, 0:30] = 1200.0                      # as large, but in the corner
    settings = replace(SMALL, focus_distance=1200.0)
    update = RenderUpdate(1, np.zeros((80, 120, 3), np.float32), 1, 0.0, settings, 0.0, depth)
    mark = _first_mark(update)
    assert mark is not None and mark.distance == 1200.0
    assert 30 / 120 < mark.x < 50 / 120 and 20 / 80 < mark.y < 40 / 80
    nowhere = replace(SMALL, focus_distance=math.inf)
    assert _first_mark(update._replace(settings=nowhere)) is None
    assert _first_mark(update._replace(depth=np.full_like(depth, 5000.0))) is None


@pytest.mark.slow
def test_arrows_and_enter_choose_in_a_list(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Scene")
        hand.ctx.yield_(2)
        hand.press(imgui.Key.down_arrow)
        hand.press(imgui.Key.down_arrow)
        hand.press(imgui.Key.enter)
        assert hand.settings.scene != SMALL.scene and hand.settings.scene in lb.SCENES
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)

    drive(use)
