"""The dials of the controls for lenses that an edit has broken."""

import math
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.state.figures import readings
from lensbench.app.state.lens_edit.editing import edited
from lensbench.app.state.settings import Settings
from lensbench.lenses.editing.cells import with_radius
from tests.app.stand import drive


def test_all_of_the_popup_focus_is_seen_in_a_window_of_720_pixels():
    seen = {"shown": Settings()}

    def gui():
        if imgui.begin_child("Column", ImVec2(0.0, 450.0)):
            seen["shown"] = controls_panel(seen["shown"], chooser)
        imgui.end_child()

    def test(ctx):
        ctx.item_click("**/###Focus")
        ctx.yield_(4)
        for name in ("In line", "Petzval"):
            item = ctx.item_info(f"//$FOCUSED/{name}")
            assert item.rect_clipped.min.y == item.rect_full.min.y > 0.0
            assert item.rect_clipped.max.y == item.rect_full.max.y < 720.0
        seen["top"] = ctx.window_info("//$FOCUSED").window.pos.y

    chooser = Chooser()
    drive(gui, test, size=(270, 720))
    assert seen["top"] >= 0.0


def test_the_focus_dial_of_a_lens_that_focuses_on_nothing_turns():
    bent = edited(replace(Settings(), lens="sony-fe-g-20-f18", f_number=None),
                  lambda document: with_radius(document, 2, -0.5))[0]
    assert readings(bent).nearest_focus == math.inf
    seen = {"shown": bent}

    def gui():
        seen["shown"] = controls_panel(seen["shown"], Chooser())

    def test(ctx):
        box = ctx.item_info("**/Focus distance").rect_full
        ctx.mouse_move_to_pos(type(box.min)(box.min.x + 0.8 * (box.max.x - box.min.x), 0.5 * (box.min.y + box.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)

    drive(gui, test, size=(270, 440))
    assert 4000.0 < seen["shown"].focus_distance < 8000.0          # from 1.2 m
