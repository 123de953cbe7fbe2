"""Looking around in a panorama by mouse."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.constraints import with_camera
from lensbench.app.drawing.controls import chord
from tests.app.conftest import SMALL


@pytest.mark.slow
def test_a_drag_turns_inside_the_panorama_and_leaves_its_camera(drive):
    def use(hand):
        view = hand.session.view
        hand.picture()
        assert not hand.ctx.item_exists("//Render/Look around")     # a lens has no panorama
        hand.session.take(replace(with_camera(hand.settings, "environment"), samples=2))
        hand.picture()
        before = hand.settings
        hand.ctx.item_click("**/Look around")
        hand.ctx.yield_(3)
        hand.drag(hand.at("**/Picture", 0.5, 0.5), hand.at("**/Picture", 0.7, 0.5))
        assert view.look.yaw > 0.1 and view.look.pitch == 0.0
        assert view.links.hover[0] == pytest.approx(0.5 * before.pixels_x, abs=2.0)     # what was grabbed in the middle
        assert hand.settings == before
        hand.ctx.mouse_wheel_y(2.0)
        hand.ctx.yield_(3)
        assert view.look.fov < 1.5 and hand.settings == before
        hand.ctx.mouse_double_click(0)
        hand.ctx.yield_(3)
        assert view.look.yaw == 0.0
        hand.ctx.item_click("**/Look around")
        hand.ctx.yield_(3)
        assert view.look is None
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings.camera == "lens"

    assert drive(use, replace(SMALL, samples=1)).view.messages == []
