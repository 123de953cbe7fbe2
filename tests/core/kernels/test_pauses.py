"""Pauses: a computation waits where its caller says so, and gives the shared threads back meanwhile."""

import threading
from time import monotonic, sleep

import pytest

from lensbench.core.analysis.grids.field_conditions import THREADS, each_of
from lensbench.core.kernels.pauses import due, never, pause, pausing


def until(what):
    end = monotonic() + 60.0
    while not what():
        assert monotonic() < end
        sleep(0.001)


def test_a_pause_is_due_only_where_a_caller_of_this_thread_says_so():
    assert due() is never
    seen = []
    with pausing(lambda: len(seen) < 3 and seen.append("asked") is None):
        outer = due()
        with pytest.raises(KeyError), pausing(never):
            assert due() is never
            raise KeyError
        assert due() is outer
        other = []
        thread = threading.Thread(target=lambda: other.append(due()))
        thread.start()
        thread.join()
        assert other == [never]
        pause()                                 # asks until it may go on
    assert len(seen) == 3 and due() is never


def test_work_on_the_shared_threads_pauses_without_them_and_does_each_item_once():
    held, done = threading.Event(), []
    begun = threading.Event()

    def work(item):
        done.append(item)
        if len(done) == 1:
            held.set()                          # from now on the work shall pause
            begun.set()

    def paused_work():
        with pausing(held.is_set):
            each_of(work, range(40))

    thread = threading.Thread(target=paused_work)
    thread.start()
    assert begun.wait(60.0)
    other = []
    each_of(other.append, range(8))             # another caller has the threads
    assert sorted(other) == list(range(8))
    until(lambda: len(done) >= 1)
    sleep(0.02)
    assert len(done) <= THREADS                 # what had begun on each thread
    held.clear()
    thread.join(60.0)
    assert sorted(done) == list(range(40))
