"""Values without a name and other words for the entries of the command palette."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.command.main import COMMANDS
from lensbench.app.window import palette
from lensbench.app.window.actions import ACTIONS
from lensbench.app.window.palette_words import ENTRIES, USES, bare_values, begun_value, shelf_of
from tests.app.conftest import SMALL
from tests.app.window.test_palette import ask

VALUES = {                      # what is typed: the first answer
    "f/5.6": "F-number: f/5.6", "f5.6": "F-number: f/5.6", "F 8": "F-number: f/8", "5.6": "F-number: f/5.6",
    "3 m": "Focus distance: 3.00 m", "10 ft": "Focus distance: 3.05 m", "120cm": "Focus distance: 1.20 m",
    "inf": "Focus distance: inf", "1/60": "Shutter: 1/60 s", "1/60 s": "Shutter: 1/60 s", "2 s": "Shutter: 2 s",
    "20 ms": "Shutter: 1/50 s", "iso 800": "ISO: 800", "iso800": "ISO: 800", "800 ISO": "ISO: 800",
    "+1 EV": "Exposure: +1 EV", "-0.7 ev": "Exposure: −0.7 EV", "+1": "Exposure: +1 EV",
    "tilt 5": "Tilt of the film: 5.00°",
    "85mm": "Lenses of 85 mm", "85 mm": "Lenses of 85 mm", "85": "Lenses of 85 mm", "47°": "Field of view: 47.0°",
    "f/": "F-number", "1/": "Shutter", "-": "Exposure"}
VERBS = {
    "improve": "Improve lens…", "bokeh": "Panel: Bokeh", "sharpness": "Panel: MTF", "vignette": "Panel: Illumination",
    "portrait lens": "Portrait lenses", "depth of field": "Panel: Depth of field", "dof": "Panel: Depth of field",
    "blur": "Panel: Circle of confusion", "flare": "Panel: Ghosts", "help": "Keys and mouse", "grain": "Noise: on",
    "tolerances": "Panel: Tolerances", "lightfield": "Panel: Light field", "render": "Export…",
    "distort": "Panel: Field curves"}


def test_a_value_is_of_the_setting_that_its_unit_tells():
    for text in ("f/5.6", "iso 800", "1/60", "3 m", "10 ft", "-0.7 ev", "47°", "85mm"):
        assert len(bare_values(text)) == 1
    assert [name for name, _ in bare_values("100")] == ["focal_length", "iso", "focus_distance"]
    for text in ("portrait", "tessar 50 2.8", "70-200", "f", "", "zoom 85", "50 mm f/2"):
        assert bare_values(text) == [] and not begun_value(text)


@pytest.mark.slow
def test_values_and_verbs_find_their_entries_first_and_no_value_loads_a_lens(drive):
    def use(hand):
        hand.picture()
        for query, text in (VALUES | VERBS).items():
            entries = palette.answers(query, hand.session)
            assert entries[0].text == text, query
            if query in VALUES.keys() - {"tilt 5"}:             # whose name may be that of a lens too
                assert not any(entry.text.startswith("Lens: ") for entry in entries), query
        names = {entry.text for entry in palette._entries(hand.session)}
        for word, name in ENTRIES.items():
            assert palette.answers(word, hand.session)[0].text in (name, f"{name}: on", f"{name}: off"), word
        assert USES.keys() <= names
        for action in ACTIONS.values():
            if action.enabled(hand.session):
                assert palette.answers(action.name, hand.session)[0].text == action.name
        for name in names:
            if name.startswith("Panel: "):
                assert palette.answers(name[7:], hand.session)[0].text in (name, name[7:])      # or its overlay
        for verb in COMMANDS:
            assert not palette.answers(verb, hand.session)[0].text.startswith("Lens: "), verb

    drive(use)


@pytest.mark.slow
def test_typed_values_are_set_and_a_focal_length_opens_the_lenses_that_have_it(drive):
    """“f/5.6” loaded another lens."""
    def use(hand):
        hand.picture()
        for text, name, value in (("f/5.6", "f_number", 5.6), ("10 ft", "focus_distance", 3048.0),
                                  ("1/60", "shutter", 1.0 / 60.0), ("iso 800", "iso", 800.0),
                                  ("-0.7 ev", "exposure", -0.7)):
            ask(hand, text)
            assert getattr(hand.settings, name) == pytest.approx(value) and hand.settings.lens == SMALL.lens
        rows = palette.answers("85mm", hand.session)
        assert [row.text for row in rows] == ["Lenses of 85 mm", "Scale this lens to 85.0 mm"]
        ask(hand, "85mm")
        assert hand.session.browsing.is_open and hand.session.browsing.state.shelf == shelf_of("85mm")
        hand.press(imgui.Key.escape)
        ask(hand, "portrait lens")
        assert hand.session.browsing.state.shelf == USES["Portrait lenses"][0]
        hand.press(imgui.Key.escape)
        assert not hand.session.browsing.is_open and hand.settings.lens == SMALL.lens
        ask(hand, "improve")
        hand.ctx.yield_(8)
        assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_focal_length_turns_a_zoom_and_says_what_a_setting_without_effect_needs(drive):
    def use(hand):
        hand.picture()
        rows = palette.answers("85mm", hand.session)
        assert [row.text for row in rows] == ["Zoom: 85.0 mm", "Lenses of 85 mm"]
        assert palette.answers("35 mm", hand.session)[0].text == "Lenses of 35 mm"
        assert palette.answers("iso 800", hand.session)[0].kind == "Enter: counts in the modes P A S M"
        ask(hand, "mode manual")
        assert palette.answers("iso 800", hand.session)[0].kind == "Enter"

    drive(use, replace(SMALL, lens="lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", f_number=None, focus_distance=3e3))
