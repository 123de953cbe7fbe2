"""The one kind of background work: progress, result, error and cancellation behave the same everywhere."""

import os
import sys
import threading

import pytest

from lensbench.app.workers.task import NICE, Measurements, Task, TaskCancelledError


def ended(task: Task) -> Task:
    task.join(10.0)
    assert task.done
    return task


def test_the_result_is_that_of_the_work_and_the_window_is_woken():
    woken = []
    task = ended(Task("Adding", lambda task: 2 + 2, lambda: woken.append(True)))
    assert (task.result, task.error, task.message, task.cancelled) == (4, None, "", False)
    assert woken == [True]


def test_progress_is_reported_and_wakes_the_window_once_in_a_hundredth():
    woken = []

    def work(task):
        return all(task.report(i / 10_000) for i in range(10_001))

    task = ended(Task("Counting", work, lambda: woken.append(True)))
    assert task.progress == 1.0 and task.result and 90 <= len(woken) <= 102


@pytest.mark.parametrize(("error", "message"), [
    (ValueError("f/0.5 is too fast"), "f/0.5 is too fast"), (OSError("no space"), "no space"),
    (MemoryError(), "Failing: there is not enough memory"), (ZeroDivisionError("zero"), "ZeroDivisionError: zero"),
])
def test_an_error_is_kept_with_words_for_the_user(error, message, capsys):
    def work(task):
        raise error

    task = ended(Task("Failing", work))
    assert (task.result, task.error, task.message) == (None, error, message)
    assert ("Traceback" in capsys.readouterr().err) is isinstance(error, ZeroDivisionError)     # unforeseen


@pytest.mark.parametrize("by", ["report", "check"])
def test_a_cancelled_task_ends_at_its_next_report_without_result_or_error(by):
    started, go = threading.Event(), threading.Event()

    def work(task):
        started.set()
        assert go.wait(10.0)
        if by == "check":
            task.check(0.5)
            raise AssertionError
        assert not task.report(0.5)
        raise ValueError("given up")

    task = Task("Waiting", work)
    assert started.wait(10.0)
    task.cancel()
    go.set()
    ended(task)
    assert (task.result, task.error, task.message, task.cancelled) == (None, None, "", True)
    if by == "check":
        with pytest.raises(TaskCancelledError):
            task.check(1.0)


def priority() -> int:
    """The nice value of the calling thread; only Linux has one for each thread."""
    return os.getpriority(os.PRIO_PROCESS, threading.get_native_id()) if sys.platform == "linux" else 0


@pytest.mark.parametrize("lowered", [True, False])
def test_the_work_runs_behind_the_window_unless_somebody_waits_for_it(lowered):
    usual = priority()
    task = ended(Task("Idling", lambda task: priority(), lowered=lowered))
    assert task.error is None
    assert task.result == (max(usual, NICE) if lowered and sys.platform == "linux" else usual)


def waiting(go):
    def measure(key, task):
        assert go.wait(10.0)
        task.check(1.0)
        return key.upper()
    return measure


def test_the_key_wanted_last_is_measured_and_what_it_replaces_may_be_wanted_again():
    go = threading.Event()
    measurements = Measurements(waiting(go))
    measurements.want("a")
    measurements.want("b")                             # gives way
    first = measurements.task
    measurements.want("a")                             # back again before the end: measured anew
    go.set()
    ended(first)
    measurements.want("a")
    ended(measurements.task)
    measurements.want("a")
    assert measurements.found == {"a": "A"} and measurements.task is None and measurements.declined is None


def test_what_is_cancelled_by_hand_is_left_until_it_is_asked_for():
    go = threading.Event()
    measurements = Measurements(waiting(go))
    measurements.want("a")
    task = measurements.task
    task.cancel()
    go.set()
    ended(task)
    measurements.want("a")
    assert measurements.task is None and measurements.declined == "a" and not measurements.found
    measurements.again("a")
    ended(measurements.task)
    measurements.collect()
    assert measurements.found == {"a": "A"} and measurements.declined is None


def test_a_measurement_repeated_after_an_error_leaves_only_its_result():
    errors = [ValueError("too steep")]

    def measure(key, task):
        if errors:
            raise errors.pop()
        return key.upper()

    measurements = Measurements(measure)
    measurements.want("a")
    ended(measurements.task)
    measurements.want("a")
    assert measurements.problems == {"a": "too steep"} and not measurements.found
    measurements.again("a")
    ended(measurements.task)
    measurements.collect()
    assert measurements.found == {"a": "A"} and not measurements.problems
