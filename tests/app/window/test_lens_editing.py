"""The surface table with a real mouse and keyboard: every gesture changes its number, is one undo, and can be saved."""

import math
import os
from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import design
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.lens_section.handles import REACH
from lensbench.app.panels.lens_table import dialogs
from lensbench.app.panels.lens_table.cell import Attachment
from lensbench.app.panels.lens_table.dialogs import progress
from lensbench.app.plots.section import sketch, surface_curves
from lensbench.app.session import lens_cells
from lensbench.app.session.edited_lens import document_of, original
from lensbench.app.session.lens_handles import HandleKind, pose_handles
from lensbench.app.session.states import Autosave, left_behind
from lensbench.app.window.lens_browsing import LensEditing
from lensbench.core.design import improve as improvement
from lensbench.lenses.editing.document import Solve
from tests.app.conftest import SMALL

pytestmark = pytest.mark.slow
KEY = imgui.Key
TRIPLET = replace(SMALL, lens="lenshh-cooke-triplet-50", f_number=None)


def table(hand):
    """Bring the table to the front."""
    hand.picture()
    hand.ctx.window_focus("//Surfaces")
    hand.ctx.yield_(3)
    return hand.session.panels.kept.table


def surfaces(hand):
    return document_of(hand.settings).surfaces


def changed(hand, before):
    return [(i, name) for i, (a, b) in enumerate(zip(before, surfaces(hand), strict=True))
            for name in ("curvature", "thickness", "semi_diameter", "conic", "glass", "aspheric")
            if getattr(a, name) != getattr(b, name)]


def scrub(hand, cell, pixels, shift=False):
    start = hand.at(f"**/{cell}", 0.5, 0.5)
    if shift:
        hand.ctx.key_down(KEY.mod_shift)
    hand.drag(start, ImVec2(start.x + pixels, start.y))
    if shift:
        hand.ctx.key_up(KEY.mod_shift)


def enter(hand, text):
    hand.ctx.yield_(2)
    hand.ctx.key_chars_replace_enter(text)
    hand.ctx.yield_(3)


def test_numbers_are_dragged_and_typed_and_each_gesture_is_one_undo(drive):
    def use(hand):
        state = table(hand)
        start, settings = surfaces(hand), hand.settings
        scrub(hand, "0 curvature", 40)
        assert changed(hand, start) == [(0, "curvature")] and 0.0 < surfaces(hand)[0].curvature < start[0].curvature
        coarse = surfaces(hand)[0].curvature
        assert design(hand.settings).surfaces == surfaces(hand)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == settings and surfaces(hand) == start        # to the last bit
        scrub(hand, "0 curvature", 40, shift=True)
        fine = surfaces(hand)[0].curvature
        assert (start[0].curvature - fine) / (start[0].curvature - coarse) == pytest.approx(0.1)
        hand.press(chord(KEY.mod_ctrl, KEY.z))

        hand.ctx.item_click("**/1 thickness")
        enter(hand, "6,5")
        assert surfaces(hand)[1].thickness == 6.5 and changed(hand, start) == [(1, "thickness")]
        hand.ctx.item_click("**/1 curvature")
        enter(hand, "abc")
        assert state.entry is not None and "type a radius" in state.entry.error
        enter(hand, "inf")
        assert state.entry is None and surfaces(hand)[1].curvature == 0.0
        hand.ctx.item_click("**/2 semi_diameter")
        enter(hand, "-3")
        assert state.entry is not None and "must be positive" in state.entry.error
        hand.press(KEY.escape)
        assert changed(hand, start) == [(1, "curvature"), (1, "thickness")]
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert changed(hand, start) == [(1, "thickness")]
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == settings
        hand.press(chord(KEY.mod_ctrl, KEY.z))                                     # past the start
        assert hand.settings == settings
        hand.press(chord(KEY.mod_ctrl, KEY.mod_shift, KEY.z))
        assert changed(hand, start) == [(1, "thickness")]

    assert drive(use, TRIPLET).view.messages == []


def test_no_tooltip_of_the_mouse_lies_over_the_text_that_is_typed(drive, monkeypatch):
    """By the keyboard one typed in the third row, under the tooltip of a mouse at rest in the first."""
    shown, tooltip = [], imgui.set_item_tooltip
    monkeypatch.setattr(imgui, "set_item_tooltip", lambda text: shown.append(text) or tooltip(text))

    def use(hand):
        state = table(hand)
        hand.ctx.item_click("**/0 curvature")
        hand.press(KEY.escape)
        for key in (KEY.right_arrow, KEY.down_arrow, KEY.down_arrow):
            hand.press(key)
        assert any(text.startswith("Radius of surface 0") for text in shown)
        hand.press(KEY.enter)
        assert state.entry is not None and state.entry.cell == (2, "thickness")
        shown.clear()
        hand.ctx.yield_(5)
        assert not any(text.startswith("Radius") for text in shown)

    drive(use, TRIPLET)


def test_tab_takes_the_typed_number_and_goes_to_the_next_cell(drive):
    """It did nothing, so that a row could not be typed as in a spreadsheet."""
    def use(hand):
        state = table(hand)
        start = surfaces(hand)
        hand.ctx.item_click("**/0 curvature")
        hand.ctx.yield_(2)
        hand.ctx.key_chars_replace("23,5")
        hand.press(KEY.tab)
        hand.ctx.yield_(2)
        assert 1.0 / surfaces(hand)[0].curvature == pytest.approx(23.5) and state.focused == (0, "thickness")
        hand.press(KEY.enter)
        hand.ctx.key_chars_replace("abc")
        hand.press(KEY.tab)
        hand.ctx.yield_(2)
        assert state.entry is not None and "type a thickness" in state.entry.error and state.focused == (0, "thickness")
        hand.press(KEY.escape)
        hand.press(chord(KEY.mod_shift, KEY.tab))
        assert state.focused == (0, "curvature") and changed(hand, start) == [(0, "curvature")]
        hand.press(chord(KEY.mod_ctrl, KEY.z))                                     # one step of undo
        assert surfaces(hand) == start

    drive(use, TRIPLET)


def test_an_element_is_decentred_and_tilted_as_one_body_by_its_cell(drive):
    def use(hand):
        table(hand)
        start, settings = surfaces(hand), hand.settings
        hand.ctx.item_click("**/2 pose")
        hand.ctx.yield_(3)
        scrub(hand, "2 decentre_y", 60)
        poses = [surface.pose for surface in surfaces(hand)]
        assert poses[2].decentre_y > 0.0 and poses[3] == replace(poses[2], pivot=1)
        assert poses[:2] + poses[4:] == [None] * (len(poses) - 2)
        hand.press(KEY.escape)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == settings and surfaces(hand) == start
        hand.ctx.item_click("**/2 pose")
        hand.ctx.yield_(3)
        hand.ctx.item_click("**/Surface 2")
        hand.ctx.item_click("**/2 tilt_x")
        enter(hand, "90")
        assert surfaces(hand) == start                                      # refused, with the reason at the cell
        enter(hand, "-3.5")
        poses = [surface.pose for surface in surfaces(hand)]
        assert poses[2].tilt_x == pytest.approx(-0.0610865238) and poses[3] is None
    drive(use, TRIPLET)


def test_a_surface_becomes_a_cylinder_and_is_rolled_by_its_cells(drive):
    def use(hand):
        table(hand)
        start = surfaces(hand)
        hand.ctx.item_click("**/2 asphere")
        hand.ctx.yield_(3)
        hand.ctx.item_click("**/2 curvature_x")
        enter(hand, "inf")
        assert surfaces(hand)[2] == replace(start[2], curvature_x=0.0)
        assert lens_cells.asphere_text(surfaces(hand)[2]) == "cylinder"
        hand.press(KEY.escape)
        hand.ctx.item_click("**/2 pose")
        hand.ctx.yield_(3)
        hand.ctx.item_click("**/2 roll")
        enter(hand, "200")
        assert surfaces(hand)[2].pose is None                               # refused, with the reason at the cell
        enter(hand, "-30°")
        poses = [surface.pose for surface in surfaces(hand)]
        assert poses[2].roll == poses[3].roll == pytest.approx(-math.pi / 6.0) and poses[3].pivot == 1
        assert "roll −30°" in lens_cells.pose_text(surfaces(hand)[2])
        hand.picture()
        assert hand.session.presenter.update.image.max() > 0.1
    drive(use, TRIPLET)


def test_keys_walk_and_step_and_edit_rows(drive):
    def use(hand):
        state = table(hand)
        start = surfaces(hand)
        hand.ctx.item_click("**/2 row")
        assert (state.first, state.last) == (2, 2)
        hand.press(KEY.insert)
        assert len(surfaces(hand)) == 7 and surfaces(hand)[2].curvature == 0.0
        hand.press(KEY.delete)
        assert surfaces(hand) == start
        hand.press(chord(KEY.mod_ctrl, KEY.d))
        assert len(surfaces(hand)) == 7 and surfaces(hand)[2].thickness == 0.5 * start[2].thickness
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        hand.press(chord(KEY.mod_ctrl, KEY.f))
        assert surfaces(hand)[2].curvature == -start[3].curvature
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        hand.press(chord(KEY.mod_alt, KEY.down_arrow))
        assert surfaces(hand)[4:] == start[2:4] and (state.first, state.last) == (4, 4)
        hand.wait(lambda: any("no room for a film" in text for text in hand.session.view.messages), "the reason")
        hand.press(chord(KEY.mod_alt, KEY.up_arrow))
        assert surfaces(hand) == start
        hand.picture()
        assert hand.session.view.messages == []
        hand.ctx.item_click("**/0 conic")
        hand.press(KEY.escape)
        assert state.entry is None
        hand.ctx.item_click("**/0 conic")
        enter(hand, "-0.5")
        hand.press(chord(KEY.mod_ctrl, KEY.up_arrow))
        assert surfaces(hand)[0].conic == pytest.approx(-0.45)
        hand.press(KEY.down_arrow)
        hand.press(chord(KEY.mod_ctrl, KEY.up_arrow))
        assert surfaces(hand)[1].conic == pytest.approx(0.05)

    assert drive(use, TRIPLET).view.messages == []


def test_what_was_said_of_an_edit_goes_with_its_undo(drive):
    def use(hand):
        table(hand)
        stop = original(hand.settings).lens.stop_index
        hand.ctx.item_click(f"**/{stop} row")
        hand.press(KEY.delete)
        assert any("the stop was deleted" in text for text in hand.session.view.messages)
        hand.press(chord(KEY.mod_ctrl, KEY.z))

    session = drive(use, TRIPLET)
    assert session.history.present.edited == "" and session.view.messages == []


def test_numbers_that_may_change_go_with_their_surfaces(drive):
    """A surface inserted before them left the ticks at the numbers of other surfaces."""
    def use(hand):
        state = table(hand)
        state.ticked = {(1, "curvature"), (3, "thickness"), (4, "curvature")}
        start = set(state.ticked)
        hand.ctx.item_click("**/2 row")
        hand.press(KEY.insert)
        hand.ctx.yield_(2)
        assert state.ticked == {(1, "curvature"), (4, "thickness"), (5, "curvature")}
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        hand.ctx.yield_(2)
        assert state.ticked == start
        hand.press(chord(KEY.mod_ctrl, KEY.y))
        hand.ctx.yield_(2)
        assert state.ticked == {(1, "curvature"), (4, "thickness"), (5, "curvature")}
        hand.ctx.item_click("**/1 row")
        hand.press(KEY.delete)
        hand.ctx.yield_(2)
        assert (4, "curvature") in state.ticked and len(state.ticked) == 2

    drive(use, TRIPLET)


def test_a_glass_is_searched_and_clicked(drive):
    def use(hand):
        table(hand)
        hand.ctx.item_click("**/0 glass")
        hand.ctx.yield_(3)
        hand.ctx.item_input_value("**/##Search glass", "lak9")
        hand.ctx.yield_(3)
        assert surfaces(hand)[0].glass.name.endswith("LAK9")
        hand.ctx.item_click("**/2 glass")
        hand.ctx.yield_(3)
        hand.ctx.item_click("**/###no glass")
        assert surfaces(hand)[2].glass == lb.AIR
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert surfaces(hand)[2].glass == original(hand.settings).surfaces[2].glass
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings.edited == ""

    assert drive(use, TRIPLET).view.messages == []


def test_solves_and_pickups_are_set_by_the_menu_of_a_cell(drive):
    def use(hand):
        state = table(hand)
        hand.ctx.mouse_move("**/5 curvature")
        hand.ctx.mouse_click(1)
        hand.ctx.yield_(3)
        hand.ctx.mouse_move("**/###solve efl")
        hand.ctx.yield_(10)
        hand.ctx.item_click("**/###Set solve")
        hand.ctx.yield_(3)
        document = document_of(hand.settings)
        assert document.solves == (Solve(5, "efl", 50.0213),)
        scrub(hand, "0 thickness", 30)
        assert lb.first_order(document_of(hand.settings).lens).efl == pytest.approx(50.0213, rel=1e-12)
        before = hand.settings
        scrub(hand, "5 curvature", 30)
        assert hand.settings == before and "remove it first" in state.problem
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings != before and state.problem == ""              # the line speaks of the lens as it is

    assert drive(use, TRIPLET).view.messages == []


def test_a_lens_that_cannot_be_is_marked_and_edited_on(drive, tmp_path):
    def use(hand):
        state = table(hand)
        hand.ctx.item_click("**/5 curvature")
        enter(hand, "inf")
        hand.ctx.item_click("**/4 curvature")
        enter(hand, "inf")                          # a negative lens alone is left behind the first
        hand.ctx.item_click("**/0 curvature")
        enter(hand, "-30")
        hand.ctx.yield_(30)
        edited = hand.settings
        assert edited.edited and surfaces(hand)[0].curvature == -1.0 / 30.0
        hand.photograph(tmp_path / "fault.png")
        hand.ctx.yield_(30)
        assert hand.settings == edited and state.problem == ""
        for _ in range(3):
            hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == TRIPLET
        hand.picture()

    drive(use, TRIPLET)


def test_a_table_is_pasted_and_a_bad_cell_is_named(drive, monkeypatch):
    written, draw = [], dialogs.imgui.text_colored
    monkeypatch.setattr(dialogs.imgui, "text_colored", lambda colour, text: written.append(text) or draw(colour, text))

    def use(hand):
        state = table(hand)
        state.pasting = "r\td\tnd\tvd\tdia\n50,5\t3\t1,5168\t64,17\t20\n-50,5\tx\t\t\t20\n"
        hand.ctx.yield_(5)
        assert "line 3, column “thickness”: 'x' is no number" in written
        hand.ctx.item_click("**/Cancel###Cancel paste")
        assert hand.settings == TRIPLET
        state.pasting = "r\td\tnd\tvd\tdia\n50,5\t3\t1,5168\t64,17\t20\n-50,5\t48\t\t\t20\n"
        hand.ctx.yield_(5)
        hand.ctx.item_click("**/Replace the lens")
        hand.ctx.yield_(3)
        assert [s.semi_diameter for s in surfaces(hand)] == [10.0, 10.0]
        hand.picture()

    session = drive(use, TRIPLET)
    message, = session.view.messages
    assert message.startswith("no stop is marked")


def test_edits_are_saved_in_their_file_and_in_others_with_what_is_lost(drive, tmp_path):
    path = tmp_path / "mine.toml"
    lenses.save(lenses.load("lenshh-cooke-triplet-50"), path)

    def use(hand):
        session = hand.session
        session.take(replace(TRIPLET, lens=str(path)))
        table(hand)
        hand.ctx.item_click("**/1 thickness")
        enter(hand, "6.5")
        hand.ctx.item_click("**/0 comment")
        enter(hand, "front")
        assert hand.settings.edited
        zemax = tmp_path / "mine.zmx"
        session.files.save_lens(zemax)
        hand.ctx.yield_(3)
        assert hand.settings.edited and hand.settings.lens == str(path)
        assert any("left out: comments" in message for message in session.view.messages)
        assert lenses.load(zemax).surfaces[1].thickness == 6.5
        hand.press(chord(KEY.mod_ctrl, KEY.mod_shift, KEY.s))
        hand.ctx.yield_(3)
        assert hand.settings == replace(TRIPLET, lens=str(path))
        assert document_of(hand.settings).comment(0) == "front" and surfaces(hand)[1].thickness == 6.5
        assert design(hand.settings).surfaces[1].thickness == 6.5
        hand.picture()
        hand.press(chord(KEY.mod_ctrl, KEY.z))                        # the file stays, the edit is marked again
        assert surfaces(hand)[1].thickness == 6.5

    drive(use, TRIPLET)


def test_a_file_that_changes_meanwhile_never_replaces_edits_without_a_question(drive, tmp_path):
    path = tmp_path / "mine.toml"
    lens = lenses.load("lenshh-cooke-triplet-50")
    lenses.save(lens, path)

    def rewrite(factor):
        lenses.save(lens.scaled(factor), path)
        later = path.stat().st_mtime_ns + int(2e9 * factor)
        os.utime(path, ns=(later, later))

    def use(hand):
        hand.session.take(replace(TRIPLET, lens=str(path)))
        table(hand)
        hand.ctx.item_click("**/1 thickness")
        enter(hand, "6.5")
        edited = hand.settings
        rewrite(2.0)
        hand.wait(lambda: imgui.is_popup_open("", imgui.PopupFlags_.any_popup),
                  "the question")
        hand.ctx.item_click("**/Keep my edits")
        assert hand.settings == edited and surfaces(hand)[1].thickness == 6.5
        rewrite(3.0)
        hand.wait(lambda: imgui.is_popup_open("", imgui.PopupFlags_.any_popup),
                  "the question")
        hand.ctx.item_click("**/Load the file")
        hand.ctx.yield_(3)
        assert hand.settings.edited == "" and surfaces(hand)[1].thickness == pytest.approx(3.0 * 6.00755)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert surfaces(hand)[1].thickness == 6.5

    drive(use, TRIPLET)


def test_unsaved_edits_are_offered_at_the_next_start(drive, tmp_path, monkeypatch):
    saved = Autosave(tmp_path)
    spoiled = original(TRIPLET)
    from lensbench.app.session.edited_lens import with_document
    from lensbench.lenses.editing.cells import with_value

    edited = with_document(TRIPLET, with_value(spoiled, 1, "thickness", 6.5))
    saved.keep(edited)
    assert left_behind(tmp_path) == []                          # this process still runs
    monkeypatch.setattr("lensbench.app.session.states.runs", lambda process: False)
    assert [edit.settings for edit in left_behind(tmp_path)] == [edited]

    def use(hand):
        hand.picture()
        hand.session.editing = LensEditing(hand.session, tmp_path)
        hand.ctx.yield_(5)
        assert hand.session.editing.offers == 1
        hand.ctx.item_click("**/Restore")
        hand.ctx.yield_(5)
        assert hand.settings == edited and hand.session.editing.offers == 0
        hand.picture()
        hand.wait(lambda: len(list(tmp_path.glob("*.toml"))) == 1, "the autosave")
        assert LensEditing(hand.session, tmp_path).offers == 0          # edits that are open are not offered
        hand.session.editing = LensEditing(hand.session, tmp_path)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        hand.wait(lambda: not list(tmp_path.glob("*.toml")), "the end of the autosave")

    drive(use, SMALL)


def test_the_file_of_unsaved_edits_stays_where_a_full_disk_takes_no_other(drive, tmp_path, monkeypatch):
    from lensbench.app.session.edited_lens import with_document
    from lensbench.lenses.editing.cells import with_value

    edited = with_document(TRIPLET, with_value(original(TRIPLET), 1, "thickness", 6.5))
    Autosave(tmp_path).keep(edited)
    monkeypatch.setattr("lensbench.app.session.states.runs", lambda process: False)

    def full_disk(path, settings):
        raise OSError("No space left on device")

    def use(hand):
        hand.picture()
        hand.session.editing = LensEditing(hand.session, tmp_path)
        hand.ctx.yield_(5)
        with monkeypatch.context() as full:
            full.setattr("lensbench.app.session.states.save_settings", full_disk)
            hand.ctx.item_click("**/Restore")
            hand.ctx.yield_(5)
        assert hand.settings == edited and any(
            "No space left" in text for text in hand.session.view.messages)
        assert [text.settings for text in left_behind(tmp_path)] == [edited]

    drive(use, SMALL)


@pytest.mark.parametrize("ends", ["saved", "reverted"])
def test_edits_that_another_lens_takes_the_place_of_stay_on_disk(tmp_path, ends):
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.session.edited_lens import reverted, with_document
    from lensbench.lenses.editing.cells import with_value

    kept, edited = Autosave(tmp_path), with_document(TRIPLET, with_value(original(TRIPLET), 1, "thickness", 6.5))
    other = with_lens(edited, "pbrt-dgauss-50mm")
    assert not kept.keep(edited)
    [file] = tmp_path.glob("*.toml")
    assert kept.keep(other) and file.exists()
    further = with_document(other, with_value(original(other), 1, "thickness", 1.0))
    assert not kept.keep(further) and len(list(tmp_path.glob("*.toml"))) == 2
    assert not kept.keep(other) and list(tmp_path.glob("*.toml")) == [file]         # its own edits are undone
    assert not kept.keep(edited) and list(tmp_path.glob("*.toml")) == [file]        # and the other lens
    if ends == "saved":
        assert not kept.keep(replace(edited, lens=str(tmp_path / "mine.toml"), edited=""),
                             saved=(edited.lens, edited.edited))
    else:
        assert not kept.keep(reverted(edited))
    assert not list(tmp_path.glob("*.toml"))


def test_edits_stay_on_disk_where_a_file_that_was_saved_before_comes_back_and_after_a_failure(tmp_path, monkeypatch):
    from lensbench.app.session import states
    from lensbench.app.session.edited_lens import with_document
    from lensbench.lenses.editing.cells import with_value

    kept, edited = Autosave(tmp_path), with_document(TRIPLET, with_value(original(TRIPLET), 1, "thickness", 6.5))
    mine, saved = replace(edited, lens=str(tmp_path / "mine"), edited=""), (edited.lens, edited.edited)
    kept.keep(edited)
    assert not kept.keep(mine, saved) and not list(tmp_path.glob("*.toml"))
    other = with_document(TRIPLET, with_value(original(TRIPLET), 1, "thickness", 7.5))
    kept.keep(other, saved)
    assert kept.keep(mine, saved) and len(list(tmp_path.glob("*.toml"))) == 1

    def full(*_):
        raise OSError("no space left")

    monkeypatch.setattr(states, "save_settings", full)
    for _ in range(3):
        with pytest.raises(OSError, match="no space"):
            kept.keep(edited)
    monkeypatch.undo()
    assert not kept.keep(edited) and len(list(tmp_path.glob("*.toml"))) == 2
    assert not kept.keep(other) and len(list(tmp_path.glob("*.toml"))) == 1         # undone to the edits before


def test_it_is_said_that_edits_are_not_saved_where_another_lens_comes(drive, tmp_path):
    from lensbench.app.bench.lens_choice import with_lens
    from lensbench.app.session.edited_lens import with_document
    from lensbench.lenses.editing.cells import with_value

    def use(hand):
        hand.picture()
        editing = hand.session.editing = LensEditing(hand.session, tmp_path)
        hand.session.take(with_document(hand.settings, with_value(original(TRIPLET), 1, "thickness", 6.5)))
        hand.ctx.yield_(2)                              # sooner than the autosave
        hand.session.take(with_lens(hand.settings, "pbrt-dgauss-50mm"))
        hand.wait(lambda: hand.session.view.messages, "the notice")
        assert "are not saved: Ctrl+Z brings them back" in hand.session.view.messages[-1]
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert surfaces(hand)[1].thickness == 6.5 and editing is hand.session.editing
        hand.ctx.yield_(3)
        assert len(list(tmp_path.glob("*.toml"))) == 1

    drive(use, TRIPLET)


def test_handles_of_the_section_drag_their_numbers_and_undo_restores_the_bits(drive):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Section")
        hand.ctx.item_click("**/Edit section")
        state, start = hand.session.panels.kept.section, surfaces(hand)
        lens, corner = design(hand.settings), hand.box("**/Section canvas").min

        def place(z, y):
            return state.view.to_screen(corner, z, y)

        view = state.view
        curve = lens.vertices[0] + float(lens.surfaces[0].sag(0.0, 5.0))
        end = surface_curves(lens)[4][-1]
        drags = [(place(lens.vertices[4], 0.0), 2, 0, {(3, "thickness"), (4, "thickness")}),
                 (place(*end), 0, -3, {(4, "semi_diameter")}),
                 (place(curve, 5.0), -1, 0, {(0, "curvature")}),
                 (place(lens.vertices[0] + 1.6, 1.5), 2, 0, {(1, "thickness")})]
        for corner, dx, dy, numbers in drags:
            state.view = view                                   # a far film has moved it
            hand.ctx.mouse_move_to_pos(corner)
            hand.ctx.yield_(2)
            hand.drag(corner, ImVec2(corner.x + dx, corner.y + dy))
            assert set(changed(hand, start)) == numbers
            if corner is drags[0][0]:
                assert state.view == view                       # it edits, and does not pan
            hand.press(chord(KEY.mod_ctrl, KEY.z))
            assert hand.settings == TRIPLET and surfaces(hand) == start
        for _ in range(2):                                      # two quick drags are two steps
            hand.drag(drags[0][0], ImVec2(drags[0][0].x + 1, drags[0][0].y))
        once = hand.settings
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings not in (once, TRIPLET)
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == TRIPLET
        hand.ctx.item_click("**/Edit section")
        state.view = view
        hand.drag(drags[2][0], ImVec2(drags[2][0].x - 6, drags[2][0].y))
        assert hand.settings == TRIPLET and state.view.x == pytest.approx(view.x - 6.0)

        # A lens that diverges is drawn, and every panel stays
        hand.session.panels.kept.table.said.clear()
        hand.ctx.window_focus("//Surfaces")
        hand.ctx.item_click("**/0 curvature")
        enter(hand, "-20")
        hand.ctx.yield_(20)
        assert lb.first_order(design(hand.settings)).efl < 0.0 and not hand.session.panels.docking._failed
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        hand.picture()

    assert drive(use, TRIPLET).view.messages == []


@pytest.mark.slow
def test_improve_tries_other_glasses_until_it_is_stopped(drive, monkeypatch):
    monkeypatch.setattr(improvement, "TRIED", 2)

    def use(hand):
        state = table(hand)
        start = surfaces(hand)
        hand.ctx.item_click("**/###Improve")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Try other glasses")
        hand.ctx.item_click("**/###Start improving")
        hand.wait(lambda: any(name == "glass" for _, name in changed(hand, start)), "another glass")
        assert state.worker.running and state.worker.last < state.worker.first
        hand.ctx.item_click("**/###Improve")
        hand.wait(lambda: not state.worker.running, "the stop")
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert surfaces(hand) == start

    assert drive(use, TRIPLET).view.messages == []


def test_improve_runs_step_by_step_is_stopped_and_is_one_undo(drive):
    def use(hand):
        state = table(hand)
        hand.ctx.item_click("**/0 curvature")
        enter(hand, "23")
        spoiled, start = hand.settings, surfaces(hand)
        hand.ctx.item_click("**/###Improve")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/###Start improving")
        hand.wait(lambda: not state.worker.running and state.worker.last is not None, "the improvement")
        hand.ctx.yield_(3)
        assert state.worker.message == "" and state.worker.last < state.worker.first
        # With the radii, the stop that keeps the f-number, and the last gap
        assert {name for _, name in changed(hand, start)} == {"curvature", "semi_diameter", "thickness"}
        said = progress(hand.settings, state)
        assert said.startswith("Spot ") and said.endswith(": converged")
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == spoiled and progress(hand.settings, state) == ""
        state.ticked.add((1, "thickness"))
        hand.ctx.item_click("**/###Improve")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/###Start improving")
        hand.wait(lambda: not state.worker.running, "the improvement")
        hand.ctx.yield_(3)
        assert set(changed(hand, start)) <= {(1, "thickness"), (3, "semi_diameter"), (5, "thickness")}
        hand.ctx.item_click("**/0 curvature")           # an edit by hand is kept
        enter(hand, "-20")
        hand.ctx.item_click("**/###Improve")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/###Start improving")
        hand.wait(lambda: not state.worker.running, "the refusal")
        assert "no image" in state.worker.message and surfaces(hand)[0].curvature == -0.05

    drive(use, TRIPLET)


def test_a_search_for_a_lens_to_attach_says_that_nothing_matches(drive, monkeypatch):
    """The list was empty, and *Attach* attached the lens that was chosen before, which it no longer showed."""
    words, dim = [], imgui.text_disabled
    monkeypatch.setattr(imgui, "text_disabled", lambda text: words.append(text) or dim(text))

    def use(hand):
        state = table(hand)
        state.attaching = Attachment()
        hand.ctx.yield_(3)
        hand.ctx.item_input_value("//Attach a lens/##Search lens", "double gauss 50 1954")
        hand.ctx.item_click("//Attach a lens/**/###pbrt-dgauss-50mm")
        assert "No lens matches" not in words
        hand.ctx.item_input_value("//Attach a lens/##Search lens", "qqqzzz")
        hand.ctx.yield_(2)
        assert "No lens matches" in words
        hand.ctx.item_click("//Attach a lens/###Attach lens")
        hand.ctx.yield_(2)
        assert state.attaching is not None and hand.settings.edited == ""

    drive(use, TRIPLET)


@pytest.mark.slow
def test_a_lens_of_the_library_is_attached_reversed_and_taken_off_again(drive, tmp_path):
    def use(hand):
        state = table(hand)
        start = surfaces(hand)
        hand.ctx.item_click("**/###More edits")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/###menu Attach")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Another lens…")
        hand.ctx.yield_(3)
        hand.ctx.item_input_value("//Attach a lens/##Search lens", "double gauss 50 1954")
        hand.photograph(tmp_path / "attach.png")
        hand.ctx.item_click("//Attach a lens/**/###pbrt-dgauss-50mm")
        hand.ctx.item_click("//Attach a lens/Reversed")
        hand.ctx.item_click("//Attach a lens/###Attach lens")
        hand.ctx.yield_(3)
        assert state.attaching is None and state.problem == ""
        added = lenses.load("pbrt-dgauss-50mm").surfaces
        assert len(surfaces(hand)) == len(start) + len(added)
        assert surfaces(hand)[0].curvature == -added[-1].curvature
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert surfaces(hand) == start

    drive(use, TRIPLET)


def test_handles_of_the_section_decentre_and_tilt_a_body_from_both_sides(drive):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Section")
        hand.ctx.item_click("**/Edit section")
        state, start = hand.session.panels.kept.section, surfaces(hand)
        lens, corner, view = design(hand.settings), hand.box("**/Section canvas").min, state.view

        def press(z, y):
            hand.ctx.mouse_move_to_pos(state.view.to_screen(corner, z, y))
            hand.ctx.yield_(2)
            hand.ctx.mouse_click(0)
            hand.ctx.yield_(2)

        def pull(kind, dx, dy, shift=False):
            """Drag the handle of the chosen body; the poses of all surfaces after it."""
            state.view = view
            press(lens.vertices[0] + 1.6, 1.5)                  # in the glass of the first element
            assert state.edit.body == (0, 1)
            handle = pose_handles(sketch(hand.settings, state.above).lens, (0, 1), REACH / view.scale, 1e3,
                                  state.above)[kind is HandleKind.TILT]
            point = view.to_screen(corner, handle.z, handle.y)
            if shift:
                hand.ctx.key_down(KEY.mod_shift)
            hand.drag(point, ImVec2(point.x + dx, point.y + dy))
            if shift:
                hand.ctx.key_up(KEY.mod_shift)
            assert changed(hand, start) == []                   # nothing but poses
            return [surface.pose for surface in surfaces(hand)]

        for above, decentre, tilt in ((False, "decentre_y", "tilt_x"), (True, "decentre_x", "tilt_y")):
            for kind, quantity, dx, dy in ((HandleKind.DECENTRE, decentre, 0, -12), (HandleKind.TILT, tilt, 12, 0)):
                poses = pull(kind, dx, dy)
                expected = lb.SurfacePose(**{quantity: getattr(poses[0], quantity)})
                assert poses == [expected, replace(expected, pivot=1), *[None] * (len(poses) - 2)]
                hand.press(chord(KEY.mod_ctrl, KEY.z))                # one gesture, one undo
                assert hand.settings == TRIPLET and surfaces(hand) == start
                if not above:
                    fine = pull(kind, dx, dy, shift=True)[0]
                    assert getattr(fine, quantity) == pytest.approx(0.1 * getattr(expected, quantity), rel=1e-6)
                    hand.press(chord(KEY.mod_ctrl, KEY.z))
                if kind is HandleKind.DECENTRE:
                    assert getattr(expected, quantity) == pytest.approx(12.0 / view.scale)
            if not above:
                hand.ctx.item_click("**/Section side")
                assert state.above
        press(-30.0, 12.0)                                      # beside the lens
        assert state.edit.body is None
        hand.ctx.item_click("**/Edit section")
        hand.ctx.yield_(2)
        assert not state.above                                  # a centred lens has one section

    drive(use, TRIPLET)
