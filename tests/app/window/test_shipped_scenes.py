"""Scenes that lensbench ships as files, chosen in the window as the built-in ones are."""

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.framing import with_scene
from lensbench.app.drawing.controls import chord
from tests.app.conftest import SMALL

UNDO = chord(imgui.Key.mod_ctrl, imgui.Key.z)


@pytest.mark.slow
def test_a_shipped_scene_is_chosen_by_its_name_without_a_notice_and_undone(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Scene")
        hand.ctx.item_click("**/Table")
        hand.ctx.yield_(3)
        assert hand.settings == with_scene(SMALL, "table") and hand.settings.scene == "table"
        hand.picture()
        hand.photograph(tmp_path / "table.png")
        assert not hand.session.view.notices.texts
        hand.press(UNDO)
        assert hand.settings == SMALL

    drive(use)
