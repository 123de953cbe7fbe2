"""Signals that come while a kernel is compiled are handled after it, and none is lost."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from lensbench.core.kernels.compiled_code import signals_held


@pytest.fixture
def handlers():
    former = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in former.items():
        signal.signal(number, handler)


def test_an_interrupt_comes_after_the_work_that_it_interrupts(handlers):
    signal.signal(signal.SIGINT, signal.default_int_handler)
    done = []
    with pytest.raises(KeyboardInterrupt), signals_held():
        with signals_held():
            os.kill(os.getpid(), signal.SIGINT)
            done.append("inner")
        done.append("outer")
    assert done == ["inner", "outer"] and signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_every_signal_gets_its_own_handler_and_an_ignored_one_stays_ignored(handlers):
    got = []
    signal.signal(signal.SIGTERM, lambda number, frame: got.append(number))
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with signals_held():
        os.kill(os.getpid(), signal.SIGTERM)
        os.kill(os.getpid(), signal.SIGINT)
        assert got == []
    assert got == [signal.SIGTERM] and signal.getsignal(signal.SIGINT) == signal.SIG_IGN


def test_other_threads_hold_nothing_back(handlers):
    handler = signal.getsignal(signal.SIGTERM)
    seen = []

    def work():
        with signals_held():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [handler]


COMPILES = """
import os, signal, threading
signal.signal(signal.SIGINT, signal.default_int_handler)
from lensbench.core.kernels.cache import njit

def kernel(k):
    @njit
    def sums(n):
        total = 0.0
        for i in range(n):
            total += i ** 0.5 + (i + 1.0) ** 0.25 + k
        return total
    return sums

for k in range(12):
    sums, stopped = kernel(float(k)), 0
    timer = threading.Timer(0.01 + 0.03 * k, os.kill, (os.getpid(), signal.SIGINT))
    try:
        timer.start()
        sums(3)
        timer.join()
    except KeyboardInterrupt:
        stopped = 1
    timer.join()
    print(sums(3) - 3.0 * k, stopped)
"""


@pytest.mark.slow
def test_a_kernel_is_whole_whenever_its_compilation_is_interrupted():
    done = subprocess.run([sys.executable, "-c", COMPILES], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert len(lines) == 12 and all(stopped == "1" for _, stopped in lines)
    expected = sum(i**0.5 + (i + 1.0) ** 0.25 for i in range(3))
    assert all(float(value) == pytest.approx(expected, rel=1e-12) for value, _ in lines)
