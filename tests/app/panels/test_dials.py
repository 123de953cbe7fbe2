"""The dials of the controls for lenses that an edit has broken."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.panels.controls.controls import Chooser, controls_panel
from lensbench.app.session.edited_lens import edited
from lensbench.app.settings.settings import Settings
from lensbench.lenses.editing.cells import with_radius
from lensbench.lenses.editing.elements import with_pose
from tests.app.stand import drive


def test_all_of_the_popup_focus_is_seen_in_a_window_of_720_pixels():
    values = {"shown": Settings()}

    def gui():
        if imgui.begin_child("Column", ImVec2(0.0, 450.0)):
            values["shown"] = controls_panel(values["shown"], chooser)
        imgui.end_child()

    def test(ctx):
        ctx.item_click("**/###Drawer Tilt")
        ctx.yield_(4)
        for name in ("Centre", "Petzval"):
            item = ctx.item_info(f"//$FOCUSED/{name}")
            assert item.rect_clipped.min.y == item.rect_full.min.y > 0.0
            assert item.rect_clipped.max.y == item.rect_full.max.y < 720.0
        values["top"] = ctx.window_info("//$FOCUSED").window.pos.y

    chooser = Chooser()
    drive(gui, test, size=(270, 720))
    assert values["top"] >= 0.0


@pytest.mark.parametrize("lens", ["decentred", "lentil-schneider-anamorphic-31-2001"])
def test_the_film_behind_a_lens_without_symmetry_is_centred_again(lens):
    """The popup said that it stays centred, and had no dials: an element that was tilted left it tilted."""
    settings = replace(Settings(), lens="lenshh-cooke-triplet-50", f_number=None, tilt=0.09, rise=4.0)
    settings = edited(settings, lambda document: with_pose(document, 2, 3, "tilt_x", 0.05))[0] \
        if lens == "decentred" else replace(settings, lens=lens)
    values = {"shown": settings}

    def gui():
        values["shown"] = controls_panel(values["shown"], chooser)

    def test(ctx):
        ctx.item_click("**/###Drawer Tilt")
        ctx.yield_(4)
        ctx.item_click("//$FOCUSED/Centre")
        ctx.yield_(2)

    chooser = Chooser()
    drive(gui, test, size=(270, 720))
    assert not settings.film_pose.is_upright and values["shown"] == replace(settings, tilt=0.0, rise=0.0)


def test_the_focus_dial_of_a_lens_that_focuses_on_nothing_turns():
    bent = edited(replace(Settings(), lens="sony-fe-g-20-f18", f_number=None),
                  lambda document: with_radius(document, 2, -0.5))[0]
    assert readings(bent).nearest_focus == math.inf
    values = {"shown": bent}

    def gui():
        values["shown"] = controls_panel(values["shown"], Chooser())

    def test(ctx):
        box = ctx.item_info("**/Focus distance").rect_full
        ctx.mouse_move_to_pos(type(box.min)(box.min.x + 0.8 * (box.max.x - box.min.x), 0.5 * (box.min.y + box.max.y)))
        ctx.mouse_click(0)
        ctx.yield_(2)

    drive(gui, test, size=(270, 440))
    assert 4000.0 < values["shown"].focus_distance < 8000.0          # from 1.2 m
