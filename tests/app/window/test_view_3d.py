"""The 3-D view turned by a real mouse, with lenses and cameras of every kind."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui
from PIL import Image

from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

ONCE = replace(SMALL, samples=1)


@pytest.mark.slow
def test_the_view_is_turned_moved_zoomed_and_fitted_by_hand(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//3-D")
        hand.ctx.yield_(3)
        state, before = hand.session.panels.kept.view_3d, hand.settings
        fitted = state.eye
        start, end = hand.at("**/3-D canvas", 0.6, 0.6), hand.at("**/3-D canvas", 0.7, 0.7)
        hand.drag(start, end)
        assert state.eye.yaw < fitted.yaw and state.eye.pitch > fitted.pitch and state.eye.target == fitted.target
        turned = state.eye
        hand.drag(start, end, button=1)
        assert state.eye.target != turned.target and state.eye.yaw == turned.yaw
        hand.ctx.mouse_move_to_pos(start)
        hand.ctx.mouse_wheel_y(2.0)
        hand.ctx.yield_(2)
        assert state.eye.distance < turned.distance
        hand.ctx.mouse_double_click(0)
        hand.ctx.yield_(3)
        assert state.eye.yaw == turned.yaw and not np.allclose(state.eye.target, turned.moved(9.0, 9.0).target)
        for name in ("scene", "side", "lens"):
            hand.ctx.item_click(f"**/View {name}")
            hand.ctx.yield_(3)
            assert state.shown == name
        assert hand.settings == before                      # the camera of the picture stays where it is
        solids, lines = state.drawn
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.5, 0.5))
        hand.ctx.yield_(3)
        assert state.drawn == (solids, lines + 1)           # the beam of the pixel under the mouse
        hand.photograph(tmp_path / "window.png")
        box = hand.box("**/3-D canvas")
        view = np.asarray(Image.open(tmp_path / "window.png").convert("RGB"), int)[
            int(box.min.y) + 40:int(box.max.y), int(box.min.x):int(box.max.x)]
        blue = (view[..., 2] > view[..., 0] + 40).mean()    # glass, and the rays of the axis
        assert 0.003 < blue < 0.5

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("settings", [
    replace(ONCE, lens="pbrt-fisheye-10mm", f_number=None, scene="room"),
    replace(ONCE, lens="lentil-schneider-anamorphic-31-2001", f_number=None),
    replace(ONCE, lens="canon-ef-28-105-f4", f_number=None, zoom=0.5, scene="fairground"),
    *(of_kind(ONCE, kind) for kind in ("thin", "pinhole", "perspective", "environment", "bare-sensor")),
], ids=lambda settings: f"{settings.lens}-{settings.camera}-{settings.lens_model}")
def test_every_lens_and_camera_has_a_view_and_says_what_it_lacks(drive, settings):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//3-D")
        hand.ctx.yield_(3)
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.5, 0.5))
        hand.ctx.yield_(3)
        state = hand.session.panels.kept.view_3d
        assert state.drawn[0] >= 1
        lacks = {"environment": "no plane in focus", "bare-sensor": "no plane in focus"}.get(hand.settings.camera, "")
        assert lacks in state.problem and bool(state.problem) == bool(lacks or hand.settings.lens_model == "pinhole")
        hand.session.take(replace(hand.settings, yaw=0.4, position=(200.0, 100.0, 300.0)))
        hand.picture()
        imgui.set_window_focus("3-D")
        hand.drag(hand.at("**/3-D canvas", 0.5, 0.5), ImVec2(700.0, 620.0))

    assert drive(use, settings).view.messages == []
