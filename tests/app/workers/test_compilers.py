"""Compilers of the window: the drawing thread never waits, others wait for the kernel, all end with the window."""

import threading
from time import monotonic, sleep
from types import SimpleNamespace

import numpy as np
import pytest

from lensbench.app.workers import compilers as module
from lensbench.app.workers.compilers import Compilers
from lensbench.core.kernels import cache
from lensbench.core.kernels.cache import NotCompiledError, resumable
from lensbench.core.kernels.program import stage_signature
from lensbench.core.kernels.sampling import sobol_net
from lensbench.core.rendering.light_rays import reverse_ray

SIGNATURE = stage_signature(np.float32)


@pytest.fixture
def gate(monkeypatch):
    """Compilers whose process answers when the gate is opened."""
    opened, asked, woken = threading.Event(), [], []

    def answered(process, kernel):
        asked.append(kernel.name)
        return opened.wait(20.0)

    monkeypatch.setattr(Compilers, "_started",
                        lambda self: self._processes.append(SimpleNamespace(
                            poll=lambda: None, kill=opened.set, wait=lambda: 0, stdin=None, stdout=None))
                        or self._processes[-1])
    monkeypatch.setattr(module, "_answered", answered)
    compilers = Compilers(lambda: woken.append(1))
    compilers.begin()
    yield SimpleNamespace(compilers=compilers, opened=opened, asked=asked, woken=woken)
    opened.set()
    compilers.stop()
    compilers.leave()
    assert cache.missing is None


def wait(what):
    end = monotonic() + 120.0
    while not what():
        assert monotonic() < end
        sleep(0.002)


def test_the_thread_that_draws_is_refused_at_once_and_others_wait(gate):
    gate.compilers.draw_here()
    ended = []
    other = threading.Thread(target=lambda: ended.append(gate.compilers._want(sobol_net.py_func, SIGNATURE)))
    other.start()
    wait(lambda: gate.asked)
    with pytest.raises(NotCompiledError):
        gate.compilers._want(sobol_net.py_func, SIGNATURE)
    with pytest.raises(NotCompiledError):
        gate.compilers._want(reverse_ray.py_func, SIGNATURE)
    assert not ended and gate.compilers.busy and gate.compilers.progress == (0, 2)
    assert gate.compilers.plan() == [("camera", 0, 1), ("light", 0, 1)]
    gate.opened.set()
    other.join(20.0)
    wait(lambda: not gate.compilers.busy)
    assert ended == [None] and gate.woken and sorted(gate.asked) == ["reverse_ray", "sobol_net"]    # each once


def test_a_thread_that_waits_ends_with_the_window(gate):
    ended = []

    def need():
        with pytest.raises(NotCompiledError):
            gate.compilers._want(sobol_net.py_func, SIGNATURE)
        ended.append(True)

    other = threading.Thread(target=need)
    other.start()
    wait(lambda: gate.asked)
    gate.compilers.stop()
    other.join(20.0)
    assert ended
    with pytest.raises(NotCompiledError):               # and none compiles while the window closes
        cache.missing(reverse_ray.py_func, SIGNATURE)


def test_what_is_compiled_for_later_begins_only_where_a_kernel_was_missing_and_ends_with_the_window():
    compilers = Compilers()
    compilers.compile_for_later("import time; time.sleep(60)")
    assert not compilers._processes
    compilers._wanted[("lensbench.core.optics.focus", "f", "()")] = None
    compilers.compile_for_later("import time; time.sleep(60)")
    process, = compilers._processes
    assert process.poll() is None
    compilers.stop()
    assert process.returncode is not None
    compile(module.LATER, "later", "exec")


def test_a_change_that_needs_a_kernel_can_be_done_again():
    ready = []

    @resumable
    def double(value, *, times=2):
        if not ready:
            raise NotCompiledError
        return value * times

    with pytest.raises(NotCompiledError) as refused:
        double(4, times=3)
    with pytest.raises(NotCompiledError) as again:
        refused.value.resume()
    ready.append(True)
    assert again.value.resume() == 12


@pytest.mark.slow
def test_a_process_compiles_a_kernel_into_the_cache(monkeypatch, tmp_path):
    compilers = Compilers()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))        # of the process
    compilers.begin()
    try:
        compilers._want(sobol_net.py_func, SIGNATURE)
        assert list((tmp_path / "lensbench" / "kernels").glob("core.kernels.sampling.sobol_net-*.kernel"))
    finally:
        compilers.stop()
        compilers.leave()
