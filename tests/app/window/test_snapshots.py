"""Snapshots by a real mouse: kept, opened, named, compared and shared."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from lensbench.app.drawing.controls import chord
from lensbench.app.session.snapshots import WIDTH, words, write_card
from lensbench.app.session.states import settings_of_text, state_text
from lensbench.app.window import snapshots as window_snapshots
from tests.app.conftest import SMALL

KEY = imgui.Key


@pytest.mark.slow
def test_a_snapshot_is_kept_named_opened_compared_and_removed(drive):
    def use(hand):
        shelf = hand.session.snapshots.shelf
        hand.picture()
        hand.press(KEY.b)                           # before the panel has been seen
        hand.wait(lambda: shelf.snapshots, "the snapshot")
        hand.session.view.notices.forget()
        hand.ctx.window_focus("//Snapshots")
        hand.ctx.yield_(6)
        assert len(shelf.snapshots) == 1
        hand.ctx.item_click("**/Snapshot Double Gauss 50 mm f⁄2 at f⁄2.8, Still life", 1)
        hand.ctx.item_click("//$FOCUSED/Remove")
        hand.ctx.yield_(3)
        assert shelf.snapshots == []
        hand.ctx.item_click("//Snapshots/###Keep")
        hand.wait(lambda: shelf.snapshots, "the snapshot")
        snapshot = shelf.snapshots[0]
        assert snapshot.settings == SMALL and "f⁄2.8" in snapshot.name
        hand.session.take(replace(hand.settings, f_number=8.0))
        hand.picture()
        hand.ctx.item_click(f"**/Snapshot {snapshot.name}", 1)
        hand.ctx.item_click("//$FOCUSED/Rename")
        hand.ctx.yield_(3)
        hand.ctx.key_chars_replace_enter("open wide")
        hand.wait(lambda: shelf.snapshots[0].name == "open wide", "the new name")
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/Snapshot open wide", 1)
        hand.ctx.item_click("//$FOCUSED/Compare as A")
        hand.wait(lambda: hand.settings.compare == "side", "the comparison")
        hand.wait(lambda: hand.session.comparing.settled(SMALL.samples), "A, rendered again")
        assert hand.session.presenter.pinned.settings == SMALL and hand.settings.f_number == 8.0
        hand.ctx.item_click("**/Snapshot open wide")
        hand.ctx.yield_(3)
        assert hand.settings == SMALL
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings.f_number == 8.0
        hand.ctx.item_click("**/Snapshot open wide", 1)
        hand.ctx.item_click("//$FOCUSED/Remove")
        hand.ctx.yield_(3)
        assert shelf.snapshots == [] and not list(shelf.folder.glob("*.png"))

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_states_are_copied_and_pasted_as_text_and_other_text_is_no_state(drive):
    other = replace(SMALL, f_number=5.6, scene="room")

    def use(hand):
        hand.picture()
        hand.press(chord(KEY.mod_ctrl, KEY.mod_shift, KEY.c))
        hand.ctx.yield_(2)
        assert settings_of_text(imgui.get_clipboard_text()) == SMALL
        imgui.set_clipboard_text(state_text(other))
        hand.press(chord(KEY.mod_ctrl, KEY.v))
        hand.ctx.yield_(2)
        assert hand.settings == other
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        imgui.set_clipboard_text("hello")
        hand.ctx.window_focus("//Snapshots")
        hand.ctx.yield_(3)
        hand.ctx.item_click("//Snapshots/Paste")
        hand.ctx.yield_(2)
        assert hand.settings == SMALL and "no lensbench state" in hand.session.view.messages[-1]

    drive(use)


@pytest.mark.slow
def test_a_picture_is_copied_or_it_is_said_what_is_missing(drive, monkeypatch):
    copied = []

    def use(hand):
        hand.picture()
        with monkeypatch.context() as patch:
            patch.setattr(window_snapshots, "copy_picture", lambda path: copied.append(path.read_bytes()[:8]))
            hand.press(chord(KEY.mod_ctrl, KEY.c))
            hand.wait(lambda: hand.session.view.messages, "word of it")
        assert hand.session.view.messages == ["Picture copied"] and copied == [b"\x89PNG\r\n\x1a\n"]
        monkeypatch.delenv("DISPLAY", raising=False)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        hand.press(chord(KEY.mod_ctrl, KEY.c))
        hand.wait(lambda: len(hand.session.view.messages) > 1, "what is missing")
        assert "xclip" in hand.session.view.messages[-1]

    drive(use)


@pytest.mark.slow
def test_a_card_has_the_picture_the_section_and_the_settings(tmp_path):
    picture = np.zeros((80, 120, 3), np.float32)
    picture[..., 0] = 1.0
    write_card(tmp_path / "card.png", picture, SMALL, "A red wall", True)
    with Image.open(tmp_path / "card.png") as card:
        pixels = np.asarray(card)
    assert pixels.shape[1] == WIDTH and (pixels[100, WIDTH // 2] == [255, 0, 0]).all()
    foot = pixels[-300:]
    assert (foot[:, :WIDTH // 2].max(axis=2) > 200).any()                  # words at the left
    assert (np.ptp(foot[:, WIDTH // 2:].astype(int), axis=2) > 30).any()   # bluish glass at the right
    assert any("f/2.8" in line and "1/125" in line for line in words(SMALL))


def _keep(hand, *f_numbers):
    """Snapshots of these f-numbers, the last one first; the panel is in front."""
    shelf = hand.session.snapshots.shelf
    hand.picture()
    for i, f_number in enumerate(f_numbers, 1):
        hand.session.take(replace(hand.settings, f_number=f_number))
        hand.picture()
        hand.press(KEY.b)
        hand.wait(lambda: len(shelf.snapshots) == i, "the snapshot")          # noqa: B023 - called at once
    hand.session.view.notices.forget()
    hand.ctx.window_focus("//Snapshots")
    hand.ctx.yield_(4)
    return list(shelf.snapshots)


def _name_file(hand, path):
    """Answer the dialog in the window that asks for a file."""
    hand.ctx.yield_(3)
    hand.ctx.item_input_value("//$FOCUSED/##Name", str(path))
    hand.ctx.yield_(3)


@pytest.mark.slow
def test_two_clicks_compare_any_two_snapshots_in_every_way(drive):
    def use(hand):
        newest, middle, oldest = _keep(hand, 2.8, 4.0, 8.0)
        hand.ctx.mouse_move(f"**/Snapshot {oldest.name}")
        hand.ctx.yield_(3)
        hand.ctx.item_click(f"**/###A {oldest.name}")
        hand.ctx.yield_(3)
        hand.ctx.item_click(f"**/Snapshot {middle.name}")
        hand.picture()
        assert hand.settings.compare == "side" and hand.settings.f_number == 4.0
        assert hand.session.presenter.pinned.settings.f_number == 2.8
        for comparison in ("wipe", "difference"):
            hand.ctx.item_click(f"**/###Compare {comparison}")
            hand.ctx.yield_(3)
            assert hand.settings.compare == comparison
        hand.press(chord(KEY.mod_alt, KEY._1))              # another B by its number
        hand.ctx.yield_(2)
        assert hand.settings.f_number == 8.0 and hand.settings.compare == "difference"
        hand.ctx.item_click(f"**/Snapshot {oldest.name}")   # A itself: no comparison
        hand.ctx.yield_(3)
        assert hand.settings == replace(SMALL, wipe=hand.settings.wipe)
        hand.press(chord(KEY.mod_alt, KEY._9))
        assert hand.session.view.messages == ["There is no snapshot 9: B keeps the picture as one"]

    drive(use)


@pytest.mark.slow
def test_marked_snapshots_become_a_moving_picture(drive, tmp_path):
    def use(hand):
        newest, _, oldest = _keep(hand, 2.8, 4.0, 8.0)
        hand.ctx.key_down(KEY.mod_ctrl)
        for snapshot in (oldest, newest):
            hand.ctx.item_click(f"**/Snapshot {snapshot.name}")
        hand.ctx.key_up(KEY.mod_ctrl)
        assert hand.settings.f_number == 8.0                # marking opens nothing
        hand.ctx.item_click("**/###Sheet")
        _name_file(hand, tmp_path / "compare.gif")
        hand.wait(lambda: hand.session.view.messages, "the file")
        with Image.open(tmp_path / "compare.gif") as moving:
            assert moving.n_frames == 2

    assert drive(use).view.messages == ["Saved compare.gif"]


@pytest.mark.slow
def test_a_contact_sheet_is_rendered_in_the_background_or_cancelled(drive, tmp_path):
    def ask(hand, path):
        hand.ctx.menu_click("//##MainMenuBar/File/Contact sheet…")
        hand.ctx.yield_(3)
        hand.ctx.item_click("//Contact sheet/Render…")
        _name_file(hand, path)

    def use(hand):
        hand.picture()
        dialog = hand.session.snapshots.dialog
        hand.ctx.menu_click("//##MainMenuBar/File/Contact sheet…")
        hand.ctx.yield_(3)
        hand.ctx.item_input_value("//Contact sheet/##Lenses", "two 85 mm lenses")
        for label, value in (("_side", 60), ("_samples", 2)):
            hand.ctx.item_input_value(f"//Contact sheet/###{label}", value)
        hand.press(KEY.escape)
        hand.ctx.yield_(2)
        ask(hand, tmp_path / "sheet.png")
        settings, names = dialog.sheet
        assert len(names) == 6 and settings.samples == 2 and settings.pixels_x == 60
        hand.wait(lambda: hand.session.view.messages, "the sheet")
        with Image.open(tmp_path / "sheet.png") as sheet:
            assert sheet.width > 3 * 60 and sheet.height > 2 * 40
        ask(hand, tmp_path / "none.png")
        hand.session.snapshots.task.cancel()
        hand.wait(lambda: len(hand.session.view.messages) > 1, "the end")

    assert drive(use).view.messages == ["Saved sheet.png", "none.png was cancelled: nothing was written"]
    assert not (tmp_path / "none.png").exists()
