"""The command palette and the sheet of keys, by a real keyboard."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.build import design
from lensbench.app.bench.constraints import field_of_view
from lensbench.app.bench.zoom import focal_length
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.action_names import ACTION_NAMES
from lensbench.app.settings.text_values import format_angle
from lensbench.app.window import palette
from lensbench.app.window.actions import ACTIONS, CHECKED, ENABLED, RUNS
from lensbench.app.window.bars import MENUS
from tests.app.conftest import SMALL

KEY = imgui.Key


def ask(hand, text):
    hand.press(chord(KEY.mod_ctrl, KEY.k))
    hand.ctx.yield_(2)
    hand.ctx.key_chars(text)
    hand.ctx.yield_(2)
    hand.press(KEY.enter)
    hand.ctx.yield_(2)


def test_each_action_has_one_name_and_keys_of_its_own():
    chords = [chord for action in ACTIONS.values() for chord in action.chords]
    assert len(set(map(int, chords))) == len(chords) and all(ACTIONS[name].name == name for name in ACTIONS)
    assert RUNS.keys() == ACTION_NAMES.keys() and ENABLED.keys() | CHECKED.keys() <= RUNS.keys()
    runs = [action.run for action in ACTIONS.values()]
    assert len({*map(id, runs)}) == len(runs)


def test_every_menu_item_is_an_action_and_is_there_once():
    items = [item for items in MENUS.values() for item in items if isinstance(item, str) and item]
    assert set(items) <= ACTIONS.keys() and len(set(items)) == len(items)


@pytest.mark.slow
def test_the_palette_reaches_actions_lenses_scenes_and_settings(drive):
    def use(hand):
        hand.picture()
        ask(hand, "peak")
        assert hand.settings.overlay == "peaking"
        ask(hand, "tessar 50 2.8")
        assert hand.settings.lens.startswith("lv-czj-tessar-50")
        ask(hand, "scene night")
        assert hand.settings.scene == "night-lights"
        ask(hand, "f-number 8")
        assert hand.settings.f_number == 8.0
        ask(hand, "aperture 5.6")
        assert hand.settings.f_number == 5.6
        ask(hand, "iso 800")
        assert hand.settings.iso == 800.0
        ask(hand, "tone agx")
        assert hand.settings.tone == "agx"
        ask(hand, "mode aper")
        assert hand.session.view.program == "A" and hand.settings.exposing == "triangle"
        ask(hand, "panel falloff")
        hand.ctx.yield_(3)
        assert not imgui.internal.find_window_by_name("Falloff").hidden

    drive(use)


@pytest.mark.slow
def test_a_zoom_lens_is_turned_to_the_focal_length_that_is_typed(drive):
    """“zoom 85” found lenses alone, and “focal length 70” scaled the zoom's whole prescription."""
    def use(hand):
        def length():
            return focal_length(design(replace(hand.settings, zoom=0.0)), hand.settings.zoom)

        hand.picture()
        scaled = hand.settings.focal_length
        for text, expected in (("zoom 85", 85.0), ("zoom 135mm", 135.0), ("focal length 10 cm", 100.0)):
            ask(hand, text)
            assert length() == pytest.approx(expected, rel=1e-9) and hand.settings.focal_length == scaled
        assert palette.answers("zoom", hand.session)[0] == palette.Entry("Zoom", "100 mm", fills="Zoom ")
        beyond = palette.answers("zoom 400", hand.session)[0]
        assert "zooms from" in beyond.text and beyond.run is None
        assert palette.answers("zoom 70-200 nikkor", hand.session)[0].text.startswith("Lens: ")

    drive(use, replace(SMALL, lens="lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", f_number=None, focus_distance=3e3))


@pytest.mark.slow
def test_values_have_the_units_of_their_dials(drive):
    """Distances were in mm and times in decimals: “Focus distance: 2000 mm”, “Shutter: 0.00333 s”."""
    def use(hand):
        hand.picture()
        for query, text in (("focus 2 m", "Focus distance: 2.00 m"), ("focus 30cm", "Focus distance: 0.300 m"),
                            ("shutter 1/30", "Shutter: 1/30 s"), ("hole 0.3", "Hole: 0.3 mm"),
                            ("focal length 85", "Focal length: 85.0 mm"), ("aperture 8", "F-number: f/8"),
                            ("exposure -1", "Exposure: −1 EV"), ("field of view 30", "Field of view: 30.0°")):
            assert palette.answers(query, hand.session)[0].text == text
        assert palette.answers("focus distance", hand.session)[0].kind == "1.20 m"

    drive(use)


@pytest.mark.slow
def test_a_value_beyond_the_camera_says_what_it_becomes_and_a_wrong_one_is_seen_whole(drive, monkeypatch):
    """“f-number 0.1” promised f/0.10, and of the range of a distance only its start was seen."""
    drawn, selectable = [], imgui.selectable
    monkeypatch.setattr(imgui, "selectable", lambda text, *args: drawn.append(text) or selectable(text, *args))

    def use(hand):
        hand.picture()
        assert palette.answers("f-number 8", hand.session)[0].kind == "Enter"
        assert palette.answers("f-number 0.1", hand.session)[0].kind == "Enter: open"
        note = palette.answers("focus 1 mm", hand.session)[0].kind
        ask(hand, "focus 1 mm")
        assert hand.settings.focus_distance > 50.0
        assert note == f"Enter: {hand.settings.focus_distance / 1000.0:.3f} m"
        drawn.clear()
        ask(hand, "focus -1")
        hand.press(KEY.escape)
        assert any("it must lie from" in text and text.count("\n") < 2 and "…" not in text for text in drawn
                   if text.startswith("Focus distance: "))

    drive(use)


@pytest.mark.slow
def test_a_value_of_words_is_said_to_be_wrong_and_ranges_have_the_units_of_the_dials(drive):
    """“iso abc” had no name, a distance had hyphens and mm, and a field of view of 400° promised that."""
    def use(hand):
        hand.picture()
        for query, text in (
                ("iso abc", "ISO: “abc”: type a speed such as ISO 400"),
                ("field of view abc", "Field of view: “abc”: type an angle such as 47.2°"),
                ("focus -1", "Focus distance: −1 m: it must lie from 0.000001 m to 1×10⁹ m, or be infinite"),
                ("exposure -99", "Exposure: −99 stops: it must lie from −60 stops to 60 stops")):
            entry = palette.answers(query, hand.session)[0]
            assert (entry.text, entry.run) == (text, None)
        assert palette.answers("qqq zzz", hand.session) == []
        widest = palette.answers("field of view 400", hand.session)[0].kind
        ask(hand, "field of view 400")
        assert hand.settings.crop == 1.0 and widest == f"Enter: {format_angle(field_of_view(hand.settings))}"

    drive(use, replace(SMALL, crop=0.5))


@pytest.mark.slow
def test_arrows_choose_a_name_is_filled_in_a_wrong_value_is_said_and_escape_changes_nothing(drive):
    def use(hand):
        hand.picture()
        ask(hand, "shutter")                    # asks for its value
        assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        hand.ctx.key_chars("1/30")
        hand.ctx.yield_(2)
        hand.press(KEY.enter)
        assert hand.settings.shutter == pytest.approx(1.0 / 30.0)
        before = hand.settings
        wrong = palette.answers("iso 4e", hand.session)[0]
        assert "ISO" in wrong.text and wrong.run is None
        hand.press(chord(KEY.mod_ctrl, KEY.k))
        hand.ctx.key_chars("theme")
        hand.ctx.yield_(2)
        hand.press(KEY.down_arrow)
        rows = [entry.text for entry in palette.answers("theme", hand.session)[:2]]
        hand.press(KEY.enter)
        assert hand.session.dark is (rows[1] == "Dark theme")
        hand.press(chord(KEY.mod_ctrl, KEY.k))
        hand.ctx.key_chars("reset all")
        hand.ctx.yield_(2)
        hand.press(KEY.escape)
        assert hand.settings == before and not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)

    assert drive(use, SMALL).view.messages == []


@pytest.mark.slow
def test_enter_without_an_answer_or_on_a_wrong_value_lets_one_go_on_typing(drive):
    """It left the line without the keyboard, so that neither letters nor Ctrl+K did anything."""
    def use(hand):
        hand.picture()
        for text, value in (("qqqzzz", "iso 400"), ("iso 4e", "iso 640")):
            ask(hand, text)
            assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
            hand.press(chord(KEY.mod_ctrl, KEY.a))
            hand.ctx.key_chars(value)
            hand.ctx.yield_(2)
            hand.press(KEY.enter)
            hand.ctx.yield_(2)
            assert hand.settings.iso == float(value.split()[1])
        ask(hand, "qqqzzz")
        hand.press(KEY.escape)
        hand.ctx.yield_(2)
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)

    drive(use)


@pytest.mark.slow
def test_f1_and_the_question_mark_show_the_sheet_of_keys(drive):
    def use(hand):
        hand.picture()
        for show in (lambda: hand.press(KEY.f1), lambda: hand.ctx.key_chars("?")):
            show()
            hand.ctx.yield_(3)
            assert imgui.is_popup_open("Keys and mouse", imgui.PopupFlags_.any_popup)
            hand.press(KEY.escape)
            assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)

    drive(use)


@pytest.mark.slow
def test_the_palette_offers_what_can_be_done_alone(drive):
    def use(hand):
        hand.picture()
        for text, is_offered in (("save lens edits", False), ("revert lens", False), ("save settings…", True)):
            entries = [entry.text.lower() for entry in palette.answers(text, hand.session)]
            assert (text in entries) == is_offered

    drive(use)
