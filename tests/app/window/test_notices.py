"""Notices over the picture: two lines at most, errors apart from notes, the newest first, gone with their lens."""

from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from imgui_bundle import imgui

from lensbench.app.drawing.controls import chord
from lensbench.app.session.notices import Notice, NoticeKind, Notices
from lensbench.app.session.states import DEPTH, History
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL

KEY = imgui.Key


def test_the_newest_notice_of_each_kind_comes_first_and_the_same_text_stands_once():
    notices = Notices()
    for text, kind in (("a", NoticeKind.ERROR), ("b", NoticeKind.NOTE), ("c", NoticeKind.DONE),
                       ("d", NoticeKind.ERROR), ("a", NoticeKind.ERROR)):
        notices.say(Notice(text, kind))
    assert [notice.text for notice in notices.errors()] == ["a", "d"]
    assert [notice.text for notice in notices.others()] == ["c", "b"]
    assert len(notices) == 4


def test_what_is_about_a_lens_goes_with_it_and_the_rest_stays():
    notices = Notices()
    notices.say(Notice("assumed", NoticeKind.NOTE, "one.dat"))
    notices.say(Notice("not written"))
    notices.follow("one.dat", 0)
    assert len(notices) == 2
    notices.follow("two.dat", 0)
    assert notices.texts == ["not written"]


@given(st.lists(st.sampled_from(["edit", "silent edit", "undo", "redo"]), max_size=30))
def test_what_is_about_a_change_goes_when_undo_takes_the_change_back_and_the_rest_stays(gestures):
    notices, history = Notices(), History(SMALL)
    notices.say(Notice("not written"))
    open_ended: list[tuple[str, Settings]] = []            # what was said, and the settings before
    for i, gesture in enumerate(gestures):
        before = history.present
        if "edit" in gesture:
            history.edit(replace(SMALL, focus_distance=1000.0 + i), is_held=False, time=10.0 * i)
            if gesture == "edit":
                notices.say(Notice(f"change {i}", NoticeKind.NOTE, change=True))
                open_ended.append((f"change {i}", before))
        elif gesture == "undo":
            after = history.undo()
            open_ended = [(text, settings) for text, settings in open_ended if settings != after]
        else:
            history.redo()
        notices.follow(SMALL.lens, history.step)
        assert notices.texts == ["not written", *(text for text, _ in open_ended)]


def test_a_change_beyond_the_depth_of_the_history_is_told_from_a_later_one():
    notices, history = Notices(), History(SMALL)
    for i in range(DEPTH + 2):
        history.edit(replace(SMALL, focus_distance=1000.0 + i), is_held=False, time=10.0 * i)
        if i >= DEPTH:
            notices.say(Notice(f"change {i}", NoticeKind.NOTE, change=True))
        notices.follow(SMALL.lens, history.step)
    history.undo()
    notices.follow(SMALL.lens, history.step)
    assert notices.texts == [f"change {DEPTH}"]


@pytest.mark.slow
def test_many_notices_cover_two_lines_of_the_picture_and_are_dismissed_at_once(drive):
    def use(hand):
        view = hand.session.view
        hand.picture()
        for i in range(6):
            view.say(f"Error {i}: " + "a long sentence about what could not be read and why " * 5)
            view.say(f"Note {i}", note=True, lens=SMALL.lens)
        hand.ctx.yield_(2)
        box = hand.ctx.window_info("//Render/Messages").window
        line = 15.0
        assert box.size.y < 3.0 * line                  # two lines and their margin
        hand.ctx.item_click("**/###All notices")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/###Dismiss Errors 0")
        hand.ctx.yield_(2)
        assert len(view.notices) == 11 and not any(text.startswith("Error 5") for text in view.messages)
        hand.ctx.item_click("//$FOCUSED/Dismiss all")
        hand.ctx.yield_(2)
        assert view.messages == []

    drive(use)


@pytest.mark.slow
def test_the_reason_is_seen_behind_a_long_path(drive):
    """Only the path was seen, of which the user knows already."""
    path, reason, drawn = f"/home/{'a long name ' * 25}.png", "there is no folder /home", []

    def use(hand):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(imgui, "text_unformatted", lambda text, plain=imgui.text_unformatted: drawn.append(text)
                            or plain(text))
            hand.session.view.say(f"{path}: {reason}")
            hand.ctx.yield_(3)
            assert reason in " ".join(drawn[-2:])
            hand.session.view.say("and a note", note=True)
            hand.ctx.yield_(3)
            assert any(text.startswith("/home/a long") and reason in text for text in drawn[-2:])
            drawn.clear()
            hand.session.view.notices.forget()
            hand.session.view.say(f"/home/short.png: {reason}")
            hand.ctx.yield_(3)
            assert f"/home/short.png: {reason}" in drawn

    drive(use, replace(SMALL, samples=1))


@pytest.mark.slow
def test_the_list_of_notices_stays_within_a_small_window(drive):
    def use(hand):
        hand.picture()
        for i in range(6):
            hand.session.view.say(f"Error {i}: " + "a long sentence about what could not be read and why " * 5)
        hand.ctx.yield_(2)
        hand.ctx.item_click("**/###All notices")
        hand.ctx.yield_(3)
        box = imgui.get_current_context().nav_window
        assert 0.0 <= box.pos.y and box.pos.y + box.size.y <= 400.0
        hand.ctx.item_click("//$FOCUSED/Dismiss all")           # after scrolling to it
        hand.ctx.yield_(2)
        assert hand.session.view.messages == []

    drive(use, size=(640, 400))


@pytest.mark.slow
def test_notices_about_a_lens_end_with_the_next_lens(drive):
    def use(hand):
        view = hand.session.view
        view.say("its back focus is estimated", lens=SMALL.lens)
        view.say("the disk is full")
        hand.ctx.yield_(2)
        assert len(view.messages) == 2
        hand.session.take(replace(hand.settings, lens="lv-czj-tessar-50-f28"))
        hand.ctx.yield_(2)
        assert view.messages == ["the disk is full"]

    drive(use)


@pytest.mark.slow
def test_undo_takes_back_what_was_said_of_the_change(drive):
    """It stayed on the picture, and spoke of settings that were gone."""
    def use(hand):
        view = hand.session.view
        hand.picture()
        view.say("the disk is full")
        hand.session.take(hand.session.showable(replace(hand.settings, pixels_x=20000, pixels_y=13333)))
        hand.ctx.yield_(2)
        assert len(view.messages) == 2
        hand.press(chord(KEY.mod_ctrl, KEY.z))
        assert hand.settings == SMALL and view.messages == ["the disk is full"]

    drive(use)
