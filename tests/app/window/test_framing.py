"""The framing of a scene in the window: a portrait lens and then Portrait, presets, the padlock, and undo."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.framing import frame_height, framed, with_framing, with_scene
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.drawing.controls import chord
from lensbench.app.window.palette import answers
from tests.app.conftest import SMALL

UNDO = chord(imgui.Key.mod_ctrl, imgui.Key.z)
PORTRAIT = with_lens(SMALL, "sony-fe-gm-ii-85-f14")


def messages(hand) -> list[str]:
    return [text for text in hand.session.view.notices.texts if text.startswith("Camera moved")]


@pytest.mark.slow
def test_a_portrait_lens_and_then_the_scene_portrait_its_presets_and_formats(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Scene")
        hand.ctx.item_click("**/Portrait")
        hand.ctx.yield_(3)
        portrait = with_scene(PORTRAIT, "portrait")
        assert hand.settings == portrait and not messages(hand)
        rows = [entry.text for entry in answers("framing", hand.session)]
        assert {"Framing: Half figure", "Framing: Whole scene"} < set(rows) and "Framing: Close" not in rows
        hand.ctx.item_click("//Controls/###Framing")
        hand.ctx.yield_(2)
        assert not hand.ctx.item_exists("**/Subject")       # which is head and shoulders
        hand.photograph(tmp_path / "framings.png")
        hand.ctx.item_click("**/Head")
        hand.ctx.yield_(3)
        head = with_framing(portrait, "head")
        assert hand.settings == head and messages(hand) == ["Camera moved forward 0.58 m"]
        hand.picture()
        hand.photograph(tmp_path / "head.png")
        hand.ctx.item_click("//Controls/##Film")
        hand.ctx.item_click("**/APS-C 23.5 × 15.6")
        hand.ctx.yield_(3)
        assert hand.settings == framed(hand.settings) and hand.settings.framing == "head"
        assert messages(hand)[-1].startswith("Camera moved back")
        hand.press(UNDO)
        assert hand.settings == head
        hand.press(UNDO)
        assert hand.settings == portrait and not messages(hand)
        hand.press(UNDO)
        assert hand.settings == PORTRAIT                    # one step

    drive(use, PORTRAIT)


@pytest.mark.slow
def test_with_the_padlock_of_the_framing_the_subject_keeps_its_size(drive, tmp_path):
    start = replace(PORTRAIT, focus_distance=1400.0)

    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/Lock framing")
        height = frame_height(start)
        view = hand.at("**/Field of view", 0.9, 0.8)
        hand.drag(view, hand.at("**/Field of view", 0.6, 0.8), steps=12)
        assert hand.settings.crop < 0.9 and frame_height(hand.settings) == pytest.approx(height, rel=1e-6)
        moved = hand.settings.position[2] - start.position[2]
        assert moved == pytest.approx(hand.settings.focus_distance - 1400.0) and len(messages(hand)) == 1
        hand.picture()
        hand.photograph(tmp_path / "locked.png")
        hand.press(UNDO)
        assert hand.settings == start and not messages(hand)
        hand.ctx.item_click("**/Lock framing")
        hand.drag(view, hand.at("**/Field of view", 0.6, 0.8))
        assert hand.settings.position == start.position and not messages(hand)

    drive(use, start)
