"""A calm window: notices go by themselves, words do not lie on words, and a picture that waits is dim."""

from dataclasses import replace
from time import monotonic

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from lensbench.app.session import notices
from lensbench.app.session.notices import Notice, NoticeKind, Notices
from lensbench.app.window.actions import ACTIONS
from lensbench.app.workers.render_worker import RenderWorker
from tests.app.conftest import SMALL
from tests.app.window.test_overlap import front, touching, written

CIRCLE = replace(SMALL, lens="fujifilm-24-f085", f_number=None)         # with a note at the picture's lower edge


def test_a_success_replaces_the_error_about_the_same_work_alone():
    shown = Notices()
    for text, kind, about in (("no folder", NoticeKind.ERROR, "lens"), ("no disk", NoticeKind.ERROR, "picture"),
                              ("plot saved", NoticeKind.DONE, "plot"), ("lens saved", NoticeKind.DONE, "lens")):
        shown.say(Notice(text, kind, about=about))
    assert shown.texts == ["no disk", "plot saved", "lens saved"]


def test_time_takes_successes_then_notes_that_were_in_sight_and_never_an_error():
    shown, hidden = Notices(), Notice("never in sight", NoticeKind.NOTE)
    for text, kind in (("error", NoticeKind.ERROR), ("note", NoticeKind.NOTE), ("done", NoticeKind.DONE)):
        shown.say(Notice(text, kind))
    shown.say(hidden)
    left = []
    for _ in range(40):
        shown.pass_time([*shown.errors(), *(notice for notice in shown.others() if notice.text != hidden.text)], 1.0)
        left.append(len(shown))
    assert left.index(3) + 1 == 5 and left.index(2) + 1 == 7 and shown.texts == ["error", hidden.text]


@pytest.mark.slow
def test_a_success_goes_from_the_picture_and_stays_while_the_mouse_is_on_it(drive, monkeypatch):
    monkeypatch.setitem(notices.SECONDS, NoticeKind.DONE, 0.3)

    def use(hand):
        hand.picture()
        view = hand.session.view
        view.say("Saved")
        hand.ctx.yield_(2)
        hand.ctx.mouse_move("**/###Dismiss")
        view.notices.forget()
        view.say("Saved", done=True)
        end = monotonic() + 1.0
        while monotonic() < end:
            hand.ctx.yield_()
        assert view.messages == ["Saved"]
        hand.ctx.mouse_move("**/Focus distance/Focus distance")
        hand.wait(lambda: not view.messages, "the notice to go")

    drive(use)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(640, 400), (1024, 640), (1280, 720)])
@pytest.mark.parametrize("paused", [False, True])
def test_what_is_said_of_waiting_lies_on_no_other_words(drive, monkeypatch, size, paused):
    def use(hand):
        hand.picture()
        view = hand.session.view
        view.histogram = view.offers_trials = True
        if paused:
            hand.press(int(imgui.Key.space))
            assert hand.session.worker.paused
        monkeypatch.setattr(RenderWorker, "waiting", 5.0)
        hand.ctx.yield_(3)
        panel = imgui.internal.find_window_by_name("Render").rect()
        words = [word for word in written(hand, panel) if word[1][1] > view.covered[1]]
        assert any(text.startswith("Paused" if paused else "Preparing") for text, _ in words)
        assert not touching([(str(i), plate) for i, plate in enumerate(view.plates[1:])])      # without the mark
        assert not touching(words)

    drive(use, CIRCLE, size)


@pytest.mark.slow
@pytest.mark.parametrize("dark", [True, False])
def test_the_picture_of_another_scene_is_dimmed_and_not_black_until_the_new_one_is_there(drive, monkeypatch, tmp_path,
                                                                                         dark):
    shots = []

    def use(hand):
        def shoot():
            x0, y0, x1, y1 = map(int, hand.session.view.covered)
            hand.photograph(tmp_path / "shot.png")
            shots.append(np.asarray(Image.open(tmp_path / "shot.png"), float)[y0:y1, x0:x1].std())

        hand.picture()
        shoot()
        with monkeypatch.context() as waits:
            waits.setattr(RenderWorker, "waiting", 0.45)            # not yet with words
            waits.setattr(hand.session.presenter, "take", lambda view: None)
            hand.session.take(replace(hand.settings, scene="dusk-street"))
            hand.ctx.yield_(3)
            shoot()
        hand.picture()
        shoot()

    drive(use, dark=dark)
    before, during, after = shots
    assert 0.3 * before < during < 0.7 * before and abs(after - before) > 0.02 * before


@pytest.mark.slow
def test_recording_a_light_field_says_that_it_pauses_the_picture(drive):
    def use(hand):
        hand.picture()
        front(hand, "Light field")
        assert any("the picture pauses" in text for text, _ in
                   written(hand, imgui.internal.find_window_by_name("Light field").rect()))
        hand.session.light_field.form.samples, hand.session.light_field.form.views = 64, 17
        hand.ctx.item_click("**/###Record")
        hand.wait(lambda: hand.session.light_field.worker.task is not None, "the recording")
        hand.session.take(replace(hand.settings, samples=10**6))
        hand.ctx.yield_(2)
        words = [text for text, _ in written(hand, imgui.internal.find_window_by_name("Render").rect())]
        assert "Paused: recording the light field" in words
        hand.session.light_field.worker.cancel()
        hand.wait(lambda: hand.session.light_field.worker.task is None, "the end of the recording")
        hand.ctx.yield_(2)
        words = [text for text, _ in written(hand, imgui.internal.find_window_by_name("Render").rect())]
        assert not any(text.startswith("Paused") for text in words)

    drive(use)


@pytest.mark.slow
def test_the_photographer_reads_samples_time_and_model_and_unfolds_the_rest(drive):
    def use(hand):
        hand.picture()
        ACTIONS["Layout: Photographer"].run(hand.session)
        hand.ctx.yield_(6)
        bar = imgui.internal.ImRect(0.0, 699.0, 1280.0, 720.0)
        row = {box[1]: [] for _, box in written(hand, bar)}
        for text, box in written(hand, bar):
            row[box[1]] += [text] if text != "·" else []
        words = next(texts for texts in row.values() if "8 samples" in texts)
        assert words[0] == "8 samples" and words[1].endswith(" s") and words[2].isalpha() and len(words) == 3
        hand.ctx.item_click("**/###More of the render")
        hand.ctx.yield_(2)
        rest = [text for text, _ in written(hand, imgui.get_current_context().nav_window.rect())]
        begin = next(i for i, text in enumerate(rest) if text.startswith("Auto: "))
        assert any("Msamples/s" in text for text in rest[begin:])
        assert "Double Gauss 50 mm f/2: 11 surfaces" in rest[begin:]

    drive(use)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(640, 400), (1024, 640), (1280, 720)])
def test_a_tooltip_stands_next_to_its_control(drive, size):
    def use(hand):
        hand.picture()
        for item in ("**/Focus distance/Focus distance", "**/###Lens", "**/###Strip f-number", "**/###Picture size",
                     "**/Lock focus"):
            hand.ctx.mouse_move(item)
            end = monotonic() + 1.0
            while monotonic() < end:
                hand.ctx.yield_()
            tooltip = next(window for window in imgui.get_current_context().windows
                           if window.name.startswith("##Tooltip") and window.active)
            control, shown = hand.box(item), tooltip.rect()
            assert not touching([(item, (control.min.x, control.min.y, control.max.x, control.max.y)),
                                 ("tooltip", (shown.min.x, shown.min.y, shown.max.x, shown.max.y))])
            assert shown.min.x >= 0.0 and shown.max.x <= size[0] and shown.min.y >= 0.0 and shown.max.y <= size[1]

    drive(use, size=size)


@pytest.mark.slow
def test_the_line_under_a_plot_is_short_at_rest_and_whole_under_the_mouse(drive):
    def use(hand):
        hand.picture()
        ACTIONS["Layout: Photographer"].run(hand.session)
        hand.ctx.yield_(6)
        front(hand, "MTF")
        state = hand.session.analyses.states["MTF"]
        hand.wait(lambda: state.figure is not None, "the MTF")
        panel, parts = imgui.internal.find_window_by_name("MTF").rect(), state.figure.conditions.split(" · ")
        (line, box), = [word for word in written(hand, panel) if word[0].startswith(parts[0])]
        assert line.endswith(" · …") and set(line.split(" · ")[:-1]) <= set(parts) and box[2] <= panel.max.x
        hand.ctx.mouse_move_to_pos(imgui.ImVec2(box[0] + 20.0, 0.5 * (box[1] + box[3])))
        end = monotonic() + 1.0
        while monotonic() < end:
            hand.ctx.yield_()
        screen = imgui.internal.ImRect(0.0, 0.0, 1280.0, 720.0)
        parts = state.figure.conditions.split(" · ")            # its grid of rays has become finer meanwhile
        assert set(parts) <= {text for text, _ in written(hand, screen)}

    drive(use)
