"""The whole bench on no display, driven by a real mouse and keyboard."""

from dataclasses import replace
from pathlib import Path
from time import monotonic

import pytest
from imgui_bundle import ImVec2, imgui, immapp
from imgui_bundle.glfw_utils import glfw_window_hello_imgui
from imgui_bundle.immapp import testing

from lensbench.app.settings.settings import Settings
from lensbench.app.window import window
from lensbench.app.workers import compilers

SMALL = replace(Settings(), pixels_x=120, pixels_y=80, samples=8)
PATIENCE = 300.0            # seconds for a picture: the first one compiles the kernels, on a busy machine slowly


class Hand:
    """The user of the window: clicks, drags and keys, and the picture on the screen."""

    def __init__(self, ctx, session: window.Session):
        self.ctx, self.session = ctx, session

    @property
    def settings(self) -> Settings:
        return self.session.history.present

    def wait(self, what, why: str) -> None:
        end = monotonic() + PATIENCE
        while not what():
            assert monotonic() < end, f"waited in vain for {why}"
            self.ctx.yield_()

    def picture(self) -> None:
        """Wait until the present settings are on the screen, with all their samples and their depth."""
        self.ctx.yield_(3)
        self.wait(lambda: self.session.settled(10**9), "the picture")
        self.ctx.yield_(2)

    def box(self, item: str):
        return self.ctx.item_info(item).rect_full

    def at(self, item: str, x: float, y: float) -> ImVec2:
        """A place in an item, as parts of its width and height."""
        box = self.box(item)
        return ImVec2(box.min.x + x * (box.max.x - box.min.x), box.min.y + y * (box.max.y - box.min.y))

    def drag(self, start: ImVec2, end: ImVec2, button: int = 0, steps: int = 4) -> None:
        ctx = self.ctx
        ctx.mouse_move_to_pos(start)
        ctx.mouse_down(button)
        ctx.yield_()
        for i in range(1, steps + 1):
            ctx.mouse_move_to_pos(ImVec2(start.x + (end.x - start.x) * i / steps,
                                         start.y + (end.y - start.y) * i / steps))
            ctx.yield_()
        ctx.mouse_up(button)
        ctx.yield_(2)

    def press(self, chord: int) -> None:
        self.ctx.key_press(chord)
        self.ctx.yield_(2)

    def photograph(self, path: Path) -> None:
        taken = self.session.shots_taken
        self.session.photograph(path)
        self.wait(lambda: self.session.shots_taken > taken, "the screenshot")


@pytest.fixture(autouse=True)
def no_helper(monkeypatch):
    """No process compiles beside a test: the tests run in as many processes as there are processors."""
    monkeypatch.setattr(compilers, "_helper", lambda scene: None)


@pytest.fixture
def drive():
    """Open the bench with some settings, let a test use it, and close it: drive(test, settings, size) -> the bench."""

    def run(test, settings: Settings = SMALL, size: tuple[int, int] = (1280, 720), dark: bool = True) -> window.Session:
        session = window.Session(settings, remember=False, threads=2)
        session.dark = dark
        window.without_display()
        runner = window.parameters(session, size)
        runner.fps_idling.enable_idling = False
        runner.fps_idling.fps_max = 0.0

        def patient(ctx) -> None:
            ctx.engine_io.config_watchdog_warning = ctx.engine_io.config_watchdog_kill_test = 4.0 * PATIENCE
            test(Hand(ctx, session))

        try:
            testing.run(test_function=patient, runner_params=runner,
                        add_ons_params=immapp.AddOnsParams(with_implot=True))
        finally:
            session.worker.stop()
        return session

    return run


@pytest.fixture
def slow_frames():
    """Open the bench, and put the events of a person between its frames, several into one: slow_frames(script).

    `script(session)` is a generator; it begins after the first picture and goes on once a frame.
    """
    def run(script, settings: Settings = SMALL) -> window.Session:
        session = window.Session(settings, remember=False, threads=2)
        window.without_display()
        runner = window.parameters(session)
        runner.fps_idling.enable_idling = False
        steps, end = script(session), monotonic() + PATIENCE

        def step() -> None:
            assert monotonic() < end, "waited in vain for the picture"
            if session.settled(1) and next(steps, "end") == "end":
                runner.app_shall_exit = True

        runner.callbacks.after_swap = step
        try:
            window.show(runner)
        finally:
            session.worker.stop()
        return session

    return run


def mouse_to(x: float, y: float) -> None:
    """Move the mouse there before the next frame, as an event among others."""
    window.glfw.set_cursor_pos(glfw_window_hello_imgui(), x, y)
    imgui.get_io().add_mouse_pos_event(x, y)
