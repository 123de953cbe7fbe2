"""A run of first uses, as a process of its own where no kernel is loaded yet: `test_first_uses` runs it.

Every kernel counts as missing until a thread of the compilers has loaded or compiled it, as if the cache were empty.
"""

import threading
from dataclasses import replace
from pathlib import Path

import numba.core.event
from imgui_bundle import hello_imgui, imgui

import lensbench as lb
from lensbench.app.bench.constraints import constrained, with_camera
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.window.session import Session
from lensbench.app.workers import compilers
from lensbench.app.workers.shipped_kernels import LENSES
from lensbench.core.kernels import cache
from lensbench.core.kernels.cache import NotCompiledError

SMALL = replace(Settings(), pixels_x=48, pixels_y=32, samples=2)
PANELS = ("Read-outs", "Lens card", "Spaces", "Section", "Stability", "Circle of confusion", "Plan", "Exit pupil",
          "Falloff", "Models", "Light field", "Controls")


class Listener(numba.core.event.Listener):
    """Notes the threads that compile."""

    def __init__(self):
        self.threads = []

    def on_start(self, event):
        self.threads.append((threading.current_thread(), event.data["dispatcher"].py_func.__qualname__))

    def on_end(self, event):
        pass


def test_the_window_never_compiles_and_every_first_use_is_shown_in_the_end(drive, monkeypatch):
    monkeypatch.setattr(cache, "_is_stored", lambda kernel, signature: False)
    monkeypatch.setattr(compilers.Compilers, "_started", lambda self: None)     # its thread loads or compiles
    refused, wanted = [], compilers.Compilers._want

    def noted(self, function, signature):
        try:
            wanted(self, function, signature)
        except NotCompiledError:
            if not self._stopped:
                refused.append(function.__qualname__)
            raise

    monkeypatch.setattr(compilers.Compilers, "_want", noted)
    listener, changes, begin = Listener(), [], Session.begin
    numba.core.event.register("numba:compile", listener)

    def changed(session):
        begin(session)
        if changes:
            session.edited = changes.pop()(session.edited)     # on the thread that draws, as a panel does

    monkeypatch.setattr(Session, "begin", changed)

    def test(hand):
        def use(change, expected):
            changes.append(change)
            hand.wait(lambda: not changes and expected(hand.settings), "the settings")
            hand.wait(lambda: hand.session.settled(1) and not hand.session.compilers.busy, "the picture")
            hand.ctx.yield_(3)

        hand.picture()
        for name in LENSES:
            use(lambda settings, name=name: with_lens(settings, name), lambda now, name=name: now.lens == name)
        for name in CAMERA_KINDS:
            use(lambda settings, name=name: constrained(with_camera(settings, name)),
                lambda now, name=name: now.camera == name)
        for name in LENS_MODELS:
            use(lambda settings, name=name: replace(with_camera(settings, "lens"), lens_model=name),
                lambda now, name=name: now.lens_model == name and now.has_lens)
        for name in lb.SCENES:
            use(lambda settings, name=name: replace(settings, scene=name), lambda now, name=name: now.scene == name)
        for name in lb.VIEWS:
            use(lambda settings, name=name: replace(settings, view=name), lambda now, name=name: now.view == name)
        use(lambda settings: replace(settings, view="picture"), lambda now: now.view == "picture")

        docking = hello_imgui.get_runner_params().docking_params
        for name in PANELS:
            docking.dockable_window_of_name(name).focus_window_at_next_frame = True
            hand.ctx.yield_(3)
            hand.wait(lambda: not hand.session.compilers.busy, name)
            hand.ctx.yield_(3)
        hand.press(imgui.Key.l)                                 # the lens browser
        hand.wait(lambda: hand.session.browsing.is_open and not hand.session.compilers.busy, "the browser")
        hand.press(imgui.Key.escape)
        hand.session.export.open(hand.settings, False, Path())
        hand.ctx.yield_(5)
        hand.press(imgui.Key.escape)
        hand.wait(lambda: not hand.session.compilers.busy, "the dialogs")

    session = drive(test, SMALL)
    assert refused, "no kernel was missing: another test of this process has loaded them"
    assert [name for thread, name in listener.threads if thread is threading.main_thread()] == []
    assert not session.panels.docking._failed and not session.panels.docking._logged
