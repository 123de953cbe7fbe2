"""Undo and redo: a gesture is one step, and every step comes back as it was."""

from dataclasses import replace

from hypothesis import given, settings as limits, strategies as st

from lensbench.app.session.states import History
from lensbench.app.settings.settings import Settings

START = Settings()


def test_a_whole_drag_is_one_step_back():
    history = History(START)
    for i in range(1, 30):
        history.edit(replace(START, focus_distance=1200.0 + i), is_held=True, time=0.016 * i)
    history.edit(history.present, is_held=False, time=1.0)
    assert history.undo() == START and not history.can_undo
    assert history.redo() == replace(START, focus_distance=1229.0)


def test_two_drags_of_one_control_are_two_steps():
    history = History(START)
    history.edit(replace(START, f_number=4.0), is_held=True, time=0.0)
    history.edit(history.present, is_held=False, time=0.5)
    history.edit(replace(START, f_number=8.0), is_held=True, time=2.0)
    assert history.undo().f_number == 4.0
    assert history.undo() == START


def test_clicks_of_the_wheel_that_follow_each_other_are_one_step_and_others_are_not():
    history = History(START)
    history.edit(replace(START, exposure=0.3), is_held=False, time=0.0)
    history.edit(replace(START, exposure=0.6), is_held=False, time=0.2)
    history.edit(replace(START, exposure=0.9), is_held=False, time=5.0)
    assert history.undo().exposure == 0.6
    assert history.undo() == START


def test_another_control_is_another_step_however_soon():
    history = History(START)
    history.edit(replace(START, exposure=0.3), is_held=False, time=0.0)
    history.edit(replace(START, exposure=0.3, f_number=8.0), is_held=False, time=0.1)
    assert history.undo() == replace(START, exposure=0.3)


def test_an_edit_after_an_undo_ends_what_could_be_redone():
    history = History(START)
    history.edit(replace(START, exposure=1.0), is_held=False, time=0.0)
    history.undo()
    history.edit(replace(START, exposure=2.0), is_held=False, time=1.0)
    assert not history.can_redo and history.redo().exposure == 2.0


def test_settings_that_cannot_be_leave_no_step():
    history = History(START)
    history.edit(replace(START, focus_distance=1.0), is_held=False, time=0.0)
    history.correct(START)
    assert history.present == START and not history.can_undo


@limits(max_examples=50)
@given(st.lists(st.floats(-5.0, 5.0), max_size=20))
def test_as_many_undos_as_gestures_lead_to_the_start_and_as_many_redos_to_the_end(exposures):
    history = History(START)
    for i, exposure in enumerate(exposures):
        history.edit(replace(START, exposure=exposure), is_held=False, time=10.0 * i)
    end, steps = history.present, 0
    while history.can_undo:
        history.undo()
        steps += 1
    assert history.present == START
    for _ in range(steps):
        history.redo()
    assert history.present == end and not history.can_redo
