"""Files in the window: what is dropped, opened, saved and exported by hand."""

import json
from dataclasses import replace

import pytest
from imgui_bundle import imgui
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from lensbench import lenses
from lensbench.app.bench.build import design
from lensbench.app.drawing.controls import chord
from lensbench.app.session.export import read_settings
from lensbench.app.session.notices import Request
from lensbench.app.session.states import save_settings, state_text
from lensbench.app.window import dialogs
from lensbench.app.window.file_actions import QUESTIONS
from lensbench.lenses.stop_picture import read_picture
from tests.app.conftest import SMALL

CTRL = imgui.Key.mod_ctrl


@pytest.mark.slow
def test_a_dropped_lens_is_opened_and_a_broken_one_is_said_and_changes_nothing(drive, tmp_path):
    good, bad, empty = tmp_path / "mine.toml", tmp_path / "broken.dat", tmp_path / "empty.toml"
    lenses.save(lenses.load("lv-czj-tessar-50-f28"), good)
    bad.write_bytes(b"\x00\x01\xff not a lens\n")
    empty.write_text("")
    newer = tmp_path / "newer.png"
    text = PngInfo()
    text.add_itxt("lensbench", '{"version": 999}')
    Image.new("RGB", (8, 8)).save(newer, pnginfo=text)

    def use(hand):
        hand.picture()
        hand.session.dropped(None, [str(good)])
        hand.picture()
        assert hand.settings.lens == str(good) and not hand.session.view.messages
        assert hand.session.recent == [good]
        for path in (bad, empty, tmp_path / "missing.toml", newer):
            before = hand.settings
            hand.session.dropped(None, [str(path)])
            hand.wait(lambda: hand.session.opening is None, "the file")
            hand.ctx.yield_(2)
            assert hand.settings == before
            assert len(hand.session.view.messages) == 1 and path.name in hand.session.view.messages[0]
            hand.ctx.item_click("**/Dismiss")
            hand.ctx.yield_(2)
            assert hand.session.view.messages == []
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == SMALL

    drive(use)


@pytest.mark.slow
def test_what_a_reader_had_to_assume_is_said(drive, tmp_path):
    older = tmp_path / "older.dat"
    older.write_text("# pbrt, old\n# thickness before the surface\n40 0 1.6 24\n-40 5 1 24\n0 4 1 12\n60 4 1.6 22\n"
                     "-45 6 1 20\n")

    def use(hand):
        hand.picture()
        hand.session.dropped(None, [str(older)])
        hand.picture()
        assert hand.settings.lens == str(older)
        findings = lenses.load(older).findings
        assert findings and hand.session.view.messages == [f"older.dat: {finding}" for finding in findings]

    drive(use)


@pytest.mark.slow
def test_a_picture_larger_than_a_window_can_show_is_opened_smaller_and_said(drive, tmp_path):
    path = tmp_path / "wide.png"
    text = PngInfo()
    text.add_itxt("lensbench", json.dumps(replace(SMALL, pixels_x=1_000_000, pixels_y=10).to_dict()))
    Image.new("RGB", (8, 8)).save(path, pnginfo=text)

    def use(hand):
        hand.picture()
        hand.session.dropped(None, [str(path)])
        hand.picture()
        assert (hand.settings.pixels_x, hand.settings.pixels_y) == (8192, 1)
        assert "1000000 × 10 pixels" in hand.session.view.messages[0]

    drive(use)


@pytest.mark.slow
def test_a_film_that_cannot_be_is_not_taken(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Film")
        hand.ctx.item_input_value("//##Combo_00/×##Film width", 0.0)
        hand.ctx.yield_(2)
        hand.ctx.item_click("//##Combo_00/Set")
        hand.ctx.yield_(2)
        assert hand.settings == SMALL
        hand.ctx.item_input_value("//##Combo_00/×##Film width", 30.0)
        hand.ctx.yield_(2)
        hand.ctx.item_click("//##Combo_00/Set")
        hand.picture()
        assert (hand.settings.film_width, hand.settings.film_height) == (30.0, 24.0)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_the_picture_is_saved_and_opened_again_with_its_settings(drive, tmp_path):
    changed = replace(SMALL, f_number=4.0, exposure=1.0, samples=4)
    path = tmp_path / "shot.png"

    def use(hand):
        hand.picture()
        hand.press(chord(CTRL, imgui.Key.s))
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(path))
        hand.wait(path.exists, "the saved picture")
        hand.session.dropped(None, [str(path)])
        hand.ctx.yield_(2)
        assert hand.settings == changed

    assert drive(use, changed).view.messages == ["Picture saved as shot.png"]
    with Image.open(path) as saved:
        assert saved.size == (120, 80)


@pytest.mark.slow
def test_a_lens_is_saved_in_the_format_of_its_suffix_and_opened_again(drive, tmp_path):
    path = tmp_path / "mine.zmx"
    scaled = replace(SMALL, lens="lv-czj-tessar-50-f28", focal_length=80.0)

    def use(hand):
        hand.ctx.menu_click("//##MainMenuBar/File/Save lens…")
        hand.ctx.yield_(2)
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(path))
        hand.wait(path.exists, "the file")
        hand.ctx.yield_(2)
        assert lenses.load(path).surfaces == design(scaled).surfaces
        saved, fields, lost = hand.session.view.messages
        assert "saved as mine.zmx" in saved and "states no fields" in fields and "left out" in lost
        hand.session.dropped(None, [str(path)])
        hand.ctx.yield_(2)
        assert hand.settings.lens == str(path) and hand.settings.focal_length is None

    drive(use, scaled)
    assert set(lenses.READERS) <= set(QUESTIONS[Request.OPEN].suffixes)       # what can be read can be chosen


@pytest.mark.slow
def test_settings_are_saved_and_opened_by_the_menu(drive, tmp_path):
    path = tmp_path / "mine.toml"

    def use(hand):
        hand.ctx.menu_click("//##MainMenuBar/File/Save settings…")
        hand.ctx.yield_(2)
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(path))
        hand.wait(path.exists, "the file")
        hand.session.edited = replace(SMALL, f_number=8.0)
        hand.session.history.edit(hand.session.edited, False, 0.0)
        hand.session.dropped(None, [str(path)])
        hand.ctx.yield_(2)
        assert hand.settings == SMALL
        path.write_text("version = 1\ncrop = 7.0\n")
        hand.session.dropped(None, [str(path)])
        hand.ctx.yield_(2)
        said = hand.session.view.messages
        assert hand.settings == SMALL and len(said) == 2
        assert said[0] == "Settings saved as mine.toml" and ":2: crop:" in said[1]

    drive(use)


def open_export(hand, path, samples):
    """Open the export of the picture to this file, with so many samples a pixel."""
    hand.picture()
    hand.session.export.path = path
    hand.ctx.item_click("**/Export")
    hand.ctx.yield_(2)
    hand.ctx.item_input_value("//Export/##Samples a pixel", samples)


@pytest.mark.slow
def test_an_export_can_be_cancelled_and_finished(drive, tmp_path):
    path = tmp_path / "large.png"

    def use(hand):
        open_export(hand, path, 1_000_000)
        hand.ctx.item_click("//Export/Render")
        hand.ctx.yield_(3)
        hand.drag(hand.at("**/Exposure", 0.5, 0.5), hand.at("**/Exposure", 0.7, 0.5))     # it renders beside the work
        assert hand.settings.exposure > 0.0 and hand.session.export.busy
        hand.ctx.item_click("**/###Cancel task")
        hand.wait(lambda: not hand.session.export.busy, "the end of the export")
        hand.ctx.yield_(2)
        assert list(tmp_path.iterdir()) == []
        hand.ctx.item_click("**/Export")
        hand.ctx.yield_(2)
        hand.ctx.item_input_value("//Export/##Samples a pixel", 2)
        hand.ctx.item_click("//Export/Render")
        hand.wait(path.exists, "the exported picture")
        hand.wait(lambda: hand.session.view.messages, "word of it")
        assert hand.session.view.messages == [f"Exported {path.name} to {path.parent}"]      # the name is in sight

    drive(use)


@pytest.mark.slow
def test_the_export_saves_the_picture_as_it_stands_at_once(drive, tmp_path):
    path = tmp_path / "now.png"

    def use(hand):
        open_export(hand, path, 1_000_000)
        hand.ctx.item_click("//Export/Save as it is now")
        hand.ctx.yield_(3)
        assert not hand.session.export.busy
        assert read_settings(path).samples == SMALL.samples

    assert drive(use).view.messages == ["Picture saved as now.png"]


@pytest.mark.slow
def test_an_export_that_cannot_be_written_says_why(drive, tmp_path):
    path = tmp_path / "no" / "large.png"

    def use(hand):
        hand.picture()
        hand.session.export.path = path
        hand.ctx.item_click("**/Export")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//Export/Render")
        hand.wait(lambda: hand.session.view.messages, "word of it")
        assert "there is no folder" in hand.session.view.messages[0]
        hand.ctx.yield_(5)
        assert len(hand.session.view.messages) == 1 and hand.settings == SMALL

    drive(use)


@pytest.mark.slow
def test_saved_settings_and_intrinsics_are_confirmed_as_other_files_are(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.session.files.save_settings(tmp_path / "mine.toml")
        hand.session.files.save_intrinsics(tmp_path / "camera.json")
        assert hand.session.view.messages == ["Settings saved as mine.toml",
                                              "Intrinsics saved as camera.json"]
        assert (tmp_path / "mine.toml").is_file() and (tmp_path / "camera.json").is_file()

    drive(use)


@pytest.mark.slow
def test_the_dialogs_show_long_folders_whole_and_that_a_file_of_a_long_name_is_replaced(drive, tmp_path, monkeypatch):
    """The sentence was cut before “will be replaced”, and the folder before its own name."""
    folder = tmp_path / ("a long name of a folder " * 3).strip() / "here"
    folder.mkdir(parents=True)
    path = folder / f"{'a long name ' * 7}.png"
    path.touch()
    ends = {}

    def noted(plain):
        def draw(*arguments):
            plain(*arguments)
            ends[arguments[-1]] = imgui.get_item_rect_max().x - imgui.get_window_pos().x - imgui.get_window_width()
        return draw

    monkeypatch.setattr(imgui, "text_colored", noted(imgui.text_colored))
    monkeypatch.setattr(imgui, "text_disabled", noted(imgui.text_disabled))

    def use(hand):
        hand.picture()
        hand.session.export.path = path
        hand.ctx.item_click("**/Export")
        hand.ctx.yield_(3)
        hand.press(imgui.Key.escape)
        assert ends.pop(dialogs.replaced(path)) < 0.0
        hand.session.files.prompt.folder = folder
        hand.session.files.ask(Request.SAVE_RENDER)
        hand.ctx.yield_(3)
        hand.press(imgui.Key.escape)
        assert ends[str(folder)] < 0.0

    drive(use)


@pytest.mark.slow
def test_the_file_dialog_says_that_there_is_no_file_until_another_folder_is_shown(drive, tmp_path):
    def use(hand):
        hand.picture()
        prompt = hand.session.files.prompt
        prompt.folder = tmp_path
        hand.session.files.ask(Request.OPEN)
        hand.ctx.yield_(3)
        hand.ctx.item_input_value("//###File/##Name", 300 * "x")        # longer than a name may be
        hand.ctx.yield_(2)
        assert "There is no file xxx" in prompt._problem
        hand.ctx.item_click("//###File/###Up")
        hand.ctx.yield_(2)
        assert prompt.folder == tmp_path.parent and not prompt._problem
        hand.press(imgui.Key.escape)
        hand.session.files.ask(Request.SAVE_LENS)
        hand.ctx.yield_(3)
        assert prompt._text == "Double Gauss 50 mm f2.toml"             # the lens's own name, as files may have it
        hand.ctx.item_input_value("//###File/##Name", str(tmp_path / "gone" / "a.toml"))
        hand.ctx.item_click("//###File/Save")
        hand.ctx.yield_(2)
        assert prompt.asks is Request.SAVE_LENS and prompt._problem == f"There is no folder {tmp_path / 'gone'}"
        hand.press(imgui.Key.escape)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_the_export_stays_as_it_is_where_no_other_file_is_chosen(drive, tmp_path):
    def use(hand):
        open_export(hand, tmp_path / "kept.png", 3)
        hand.ctx.item_click("//Export/Browse…")
        hand.ctx.yield_(3)
        hand.ctx.item_click("//###File/Cancel")
        hand.ctx.yield_(3)
        hand.ctx.item_click("//Export/Render")
        hand.wait(lambda: hand.session.view.messages, "the exported picture")
        assert read_settings(tmp_path / "kept.png").samples == 3

    drive(use)


@pytest.mark.slow
def test_a_file_that_is_replaced_is_named_before_it_is(drive, tmp_path, monkeypatch):
    path, words, colour = tmp_path / "kept.png", [], imgui.text_colored
    path.write_bytes(b"")
    monkeypatch.setattr(imgui, "text_colored", lambda tint, text: words.append(text) or colour(tint, text))
    named = "There is a file kept.png: it will be replaced"

    def use(hand):
        open_export(hand, path, 1)
        assert named in words
        hand.ctx.item_input_value("//Export/##File", str(tmp_path / "new.png"))
        words.clear()
        hand.ctx.yield_(2)
        assert named not in words
        hand.press(imgui.Key.escape)
        hand.session.files.prompt.folder = tmp_path
        hand.session.files.ask(Request.SAVE_RENDER)
        hand.ctx.yield_(3)
        assert named not in words
        hand.ctx.item_input("//###File/##Name")
        hand.ctx.key_chars_replace("kept")
        hand.ctx.yield_(2)
        assert named in words and not path.stat().st_size
        hand.press(imgui.Key.escape)
        hand.press(imgui.Key.escape)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_an_export_asks_for_a_name_and_keeps_a_dot_of_it(drive, tmp_path):
    def use(hand):
        open_export(hand, tmp_path / "lensbench.png", 1)
        hand.ctx.item_input_value("//Export/##File", "")
        hand.ctx.item_click("//Export/EXR, linear")
        hand.ctx.item_click("//Export/PNG, 8 bits")
        for name in ("", "/", str(tmp_path)):
            hand.ctx.item_input_value("//Export/##File", name)
            hand.ctx.yield_(2)
            for button in ("Render", "Save as it is now"):
                assert hand.ctx.item_info(f"//Export/{button}").item_flags & imgui.ItemFlags_.disabled
        hand.ctx.item_input_value("//Export/##File", str(tmp_path / "2026.11"))
        hand.ctx.item_click("//Export/Save as it is now")
        hand.ctx.yield_(3)
        assert [path.name for path in tmp_path.iterdir()] == ["2026.11.png"]

    assert drive(use).view.messages == ["Picture saved as 2026.11.png"]


@pytest.mark.slow
def test_settings_and_states_open_without_a_picture_in_the_stop_that_is_gone(drive, tmp_path):
    gone = replace(SMALL, f_number=4.0, stop_image=str(tmp_path / "gone.png"))
    save_settings(tmp_path / "gone.toml", gone)

    def use(hand):
        hand.picture()
        for f_number, take in ((4.0, lambda: hand.session.files.open(tmp_path / "gone.toml")),
                               (8.0, lambda: hand.session.snapshots.paste(state_text(replace(gone, f_number=8.0))))):
            hand.session.view.notices.forget()
            take()
            hand.picture()
            assert (hand.settings.f_number, hand.settings.stop_image) == (f_number, "")
            assert len(hand.session.view.messages) == 1 and "gone.png" in hand.session.view.messages[0]

    drive(use)


@pytest.mark.slow
def test_a_picture_is_put_into_the_stop_and_taken_out(drive, tmp_path):
    heart, black = tmp_path / "half.png", tmp_path / "black.png"
    half = Image.new("L", (40, 40))
    half.paste(255, (0, 0, 40, 20))
    half.save(heart)
    Image.new("L", (40, 40)).save(black)

    def use(hand):
        hand.picture()
        for path in (black, heart):
            hand.ctx.item_click("**/###Drawer Flare")
            if path == black:
                hand.ctx.item_click("//$FOCUSED/Blades & coating")
                hand.ctx.yield_(2)
            hand.ctx.item_click("//$FOCUSED/Picture")
            hand.ctx.item_input_value("//###File/##Name", str(path))
            hand.ctx.yield_(3)
            assert hand.settings.stop_image == ("" if path == black else str(heart))
        assert any("passes no light" in message for message in hand.session.view.messages)
        hand.picture()
        hand.ctx.item_click("**/###Drawer Flare")
        hand.ctx.yield_(3)
        hand.photograph(tmp_path / "popup.png")
        hand.ctx.item_click("//$FOCUSED/Clear")
        hand.ctx.yield_(2)
        assert hand.settings == SMALL

    drive(use)


@pytest.mark.slow
def test_the_picture_of_the_lens_is_taken_out_of_its_stop_and_put_back(drive, tmp_path):
    half = Image.new("L", (40, 40))
    half.paste(255, (0, 0, 40, 20))
    half.save(tmp_path / "half.png")
    pictured = replace(lenses.load(SMALL.lens), stop_image=read_picture(tmp_path / "half.png"))
    lenses.save(pictured, tmp_path / "lens.toml")
    own = replace(SMALL, lens=str(tmp_path / "lens.toml"))

    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/###Drawer Flare")
        hand.ctx.item_click("//$FOCUSED/Blades & coating")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/Clear")
        hand.ctx.yield_(2)
        assert hand.settings == replace(own, blades=0)
        hand.ctx.item_click("//$FOCUSED/That of the lens")
        hand.ctx.yield_(2)
        assert hand.settings == own

    assert drive(use, own).view.messages == []
