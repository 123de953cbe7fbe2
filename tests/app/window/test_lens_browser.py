"""The lens browser, with a real mouse and keyboard: search, try, keep and return."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.drawing.controls import chord
from lensbench.app.session.notices import Request
from lensbench.app.window import lens_browsing
from tests.app.conftest import SMALL

Key = imgui.Key
TESSAR, BIOGON = "lv-czj-tessar-50-f28", "lv-zeiss-biogon-21-f45"
BROWSER = "//Lens browser"


def opened(hand) -> None:
    hand.picture()
    hand.ctx.item_click("//Controls/###Lens")
    hand.ctx.yield_(4)
    assert hand.session.browsing.is_open


def typed(hand, text: str) -> None:
    hand.ctx.key_chars(text)
    hand.ctx.yield_(4)


@pytest.mark.slow
def test_a_lens_is_searched_tried_and_kept_as_one_step_of_undo(drive):
    def use(hand):
        opened(hand)
        typed(hand, "tessar 2.8")
        hand.ctx.item_click(f"{BROWSER}/**/{TESSAR}")
        hand.picture()
        assert hand.settings == with_lens(SMALL, TESSAR) and hand.session.browsing.is_open
        hand.ctx.item_click(f"{BROWSER}/**/##Search lenses")
        hand.press(chord(Key.mod_ctrl, Key.a))
        typed(hand, "biogon")
        hand.press(Key.enter)
        assert hand.settings == with_lens(SMALL, BIOGON) and not hand.session.browsing.is_open
        assert hand.session.browsing.state.recent[0] == BIOGON
        hand.press(chord(Key.mod_ctrl, Key.z))
        assert hand.settings == SMALL

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_escape_returns_to_the_lens_before_and_arrows_try(drive):
    def use(hand):
        opened(hand)
        hand.press(Key.down_arrow)
        first = hand.settings
        assert first.lens != SMALL.lens and first == with_lens(SMALL, first.lens)
        hand.press(Key.right_arrow)
        assert hand.settings.lens not in (first.lens, SMALL.lens)
        hand.press(Key.escape)
        assert hand.settings == SMALL and not hand.session.browsing.is_open
        assert not hand.session.history.can_undo

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_what_is_typed_is_searched_after_a_click_and_after_enter_without_a_match(drive):
    def use(hand):
        opened(hand)
        typed(hand, "tessar 2.8")
        hand.ctx.item_click(f"{BROWSER}/**/{TESSAR}")
        hand.picture()
        typed(hand, "biogon")
        state = hand.session.browsing.state
        assert state.shelf.search == "biogon" and state.selected == BIOGON and hand.settings.lens == TESSAR
        hand.press(chord(Key.mod_ctrl, Key.a))
        typed(hand, "qqqq")
        hand.press(Key.enter)
        hand.ctx.yield_(2)
        assert hand.session.browsing.is_open and hand.settings.lens == TESSAR
        typed(hand, "biogon")
        assert state.shelf.search == "biogon"
        hand.ctx.item_click(f"{BROWSER}/Zoom")              # what was typed does not take the click from a button
        assert state.shelf.zooms

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_escape_closes_the_list_of_a_filter_and_not_the_browser(drive):
    def use(hand):
        opened(hand)
        hand.press(Key.down_arrow)
        tried = hand.settings
        hand.ctx.item_click(f"{BROWSER}/##Kind")
        hand.ctx.yield_(3)
        hand.press(Key.escape)
        assert hand.session.browsing.is_open and hand.settings == tried != SMALL
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level)
        hand.press(Key.escape)
        assert not hand.session.browsing.is_open and hand.settings == SMALL

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("close", ["escape", "enter", "button", "other lens"])
def test_the_render_goes_on_after_the_grid_has_scrolled_however_the_browser_is_closed(drive, monkeypatch, close):
    """The grid counts as scrolling for ever here: the render, which is held meanwhile, goes on by the closing alone."""
    def use(hand):
        opened(hand)
        browsing, worker = hand.session.browsing, hand.session.worker
        if close == "other lens":
            hand.press(Key.down_arrow)
        hand.wait(lambda: browsing._picture_is_ready, "a picture")
        monkeypatch.setattr(lens_browsing, "REST", 1e9)
        browsing._scrolled = lens_browsing.perf_counter()
        hand.ctx.yield_(3)
        assert browsing.occupies_processor and worker._held
        if close == "button":
            hand.session.requests.add(Request.BROWSE_LENSES)
        else:
            hand.press(Key.enter if close == "enter" else Key.escape)
        hand.ctx.yield_(3)
        assert not browsing.is_open and not worker._held
        hand.session.take(replace(hand.settings, f_number=8.0))
        hand.picture()
        assert hand.session.presenter.update.samples == SMALL.samples

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_filters_stars_and_thumbnails(drive):
    def use(hand):
        opened(hand)
        state = hand.session.browsing.state
        hand.ctx.item_click(f"{BROWSER}/##Kind")
        hand.ctx.item_click("//##Combo_00/fisheye")
        hand.ctx.yield_(3)
        assert state.shelf.kind == "fisheye" and "pbrt-fisheye-10mm" in state.in_sight
        hand.wait(lambda: "pbrt-fisheye-10mm" in hand.session.browsing._thumbnails.found, "a thumbnail")
        hand.ctx.item_click(f"{BROWSER}/**/Star pbrt-fisheye-10mm")
        assert state.favourites == ["pbrt-fisheye-10mm"]
        hand.ctx.item_click(f"{BROWSER}/Clear")
        hand.ctx.item_click(f"{BROWSER}/###Lenses favourites")
        hand.ctx.yield_(3)
        assert state.in_sight == ("pbrt-fisheye-10mm",)
        hand.ctx.item_double_click(f"{BROWSER}/**/pbrt-fisheye-10mm")
        hand.ctx.yield_(3)
        assert not hand.session.browsing.is_open and hand.settings.lens == "pbrt-fisheye-10mm"

    assert drive(use).view.messages == ["Camera moved forward 0.82 m"]


@pytest.mark.slow
def test_a_panel_whose_tabs_lie_beneath_the_browser_is_named(drive, monkeypatch):
    """The row of tabs of the dock below the picture was blank beside the browser."""
    texts, add = [], imgui.ImDrawList.add_text
    monkeypatch.setattr(imgui.ImDrawList, "add_text", lambda *a: texts.append(a[-1]) or add(*a))

    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Section")
        hand.ctx.yield_(3)
        assert "Section" not in texts                               # its tab is in sight
        hand.press(imgui.Key.l)
        hand.ctx.yield_(3)
        texts.clear()
        hand.ctx.yield_(2)
        assert "Section" in texts and "Render" not in texts and "Exit pupil" not in texts

    drive(use)


@pytest.mark.slow
def test_a_camera_without_a_lens_gets_one(drive):
    def use(hand):
        opened(hand)
        typed(hand, "tessar 2.8")
        hand.ctx.item_click(f"{BROWSER}/**/{TESSAR}")
        hand.picture()
        assert hand.settings.camera == "lens" and hand.settings.lens == TESSAR

    assert drive(use, replace(SMALL, camera="perspective")).view.messages == []


def test_parts_outside_of_holes_do_not_overlap_and_leave_nothing_out():
    random = np.random.default_rng(3)
    for count in range(6):
        holes = [(*corner, *(corner + size)) for corner, size in
                 zip(random.integers(-4, 20, (count, 2)), random.integers(0, 14, (count, 2)), strict=True)]
        filled, expected = np.zeros((24, 24), int), np.ones((24, 24), int)
        for left, top, right, bottom in holes:
            expected[max(top, 0):max(bottom, 0), max(left, 0):max(right, 0)] = 0
        expected[:, :2] = expected[:, 20:] = expected[:3] = expected[22:] = 0
        for left, top, right, bottom in lens_browsing.outside((2, 3, 20, 22), holes):
            filled[top:bottom, left:right] += 1
        assert np.array_equal(filled, expected)


@pytest.mark.slow
def test_nothing_beneath_the_browser_shows_through(drive, monkeypatch, tmp_path):
    """Its ground is filled only where something is drawn beneath: the picture is that of a ground filled whole."""
    def pictured(hand, name):
        hand.photograph(tmp_path / name)
        return np.asarray(Image.open(tmp_path / name))[:, :int(hand.session.browsing.covers)]

    def use(hand):
        imgui.get_io().config_input_text_cursor_blink = False
        opened(hand)
        typed(hand, "no such lens")             # no thumbnail arrives between the two screenshots
        hand.ctx.mouse_move_to_pos((300.0, 400.0))          # and no tooltip
        sparse = pictured(hand, "sparse.png")
        monkeypatch.setattr(lens_browsing, "outside", lambda box, holes: [box])
        hand.ctx.yield_(2)
        whole = pictured(hand, "whole.png")
        status = round(1.4 * imgui.get_frame_height()) + 1      # it says how many frames are drawn
        assert np.array_equal(sparse[:-status], whole[:-status])

    drive(use)


def test_favourites_and_recent_lenses_outlive_the_session(monkeypatch):
    kept = {}
    monkeypatch.setattr(lens_browsing.hello_imgui, "load_lasting_pref", lambda name: kept.get(name, ""))
    monkeypatch.setattr(lens_browsing.hello_imgui, "save_lasting_pref", kept.__setitem__)
    window = SimpleNamespace(remember=True)
    first = lens_browsing.LensBrowsing(window)
    first.load()
    assert (first.state.favourites, first.state.recent) == ([], [])
    first.state.favourites, first.state.recent = [TESSAR], [BIOGON, TESSAR]
    first._answer()
    second = lens_browsing.LensBrowsing(window)
    second.load()
    assert (second.state.favourites, second.state.recent) == ([TESSAR], [BIOGON, TESSAR])

    # A lens that left the library is forgotten; preferences that are damaged, or of no other session, are no error
    kept["lenses"] = kept["lenses"].replace(TESSAR, "no-such-lens")
    third = lens_browsing.LensBrowsing(window)
    third.load()
    assert (third.state.favourites, third.state.recent) == ([], [BIOGON])
    for damaged in ("{", "[]", '{"favourites": 3}'):
        kept["lenses"] = damaged
        lens_browsing.LensBrowsing(window).load()

    # Another session does not write where it is not to remember
    before = dict(kept)
    silent = lens_browsing.LensBrowsing(SimpleNamespace(remember=False))
    silent.state.favourites = [BIOGON]
    silent._answer()
    assert kept == before


def test_a_chip_shows_the_lenses_of_a_use_from_the_first_by_their_names_as_sold(drive):
    def use(hand):
        opened(hand)
        state = hand.session.browsing.state
        hand.ctx.item_click(f"{BROWSER}/Portrait")
        hand.ctx.yield_(4)
        cards = {card.name: card for card in lens_browsing._cards()}
        assert state.shelf.use == "portrait" and len(state.in_sight) == sum("portrait" in card.uses
                                                                            for card in cards.values())
        assert all("portrait" in cards[name].uses for name in state.in_sight) and state.top == 0.0
        hand.ctx.item_click(f"{BROWSER}/Macro")             # another one takes its place
        hand.ctx.yield_(4)
        assert state.shelf.use == "macro"
        hand.ctx.item_click(f"{BROWSER}/Macro")
        hand.ctx.yield_(4)
        assert state.shelf.use == "" and len(state.in_sight) == len(cards)

    assert drive(use).view.messages == []
