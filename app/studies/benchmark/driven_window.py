"""A window without a display whose dials a script moves in place of a hand, for measurements."""

import time
from collections.abc import Callable
from dataclasses import replace

from lensbench.app.state.settings import Settings
from lensbench.app.window.window import Session, parameters, show, without_display

SIZE = (1280, 720)
SMALL = Settings(pixels_x=640, pixels_y=360, film_width=32.0, film_height=18.0, samples=100_000)


class DrivenSession(Session):
    """A session whose dials are moved by a script in place of the panel."""

    move: Callable[[Settings], Settings] | None = None
    moved = worked = 0.0

    def begin(self) -> None:
        """Begin a frame with the scripted settings."""
        super().begin()
        if self.move is not None:
            self.moved, self.worked = time.perf_counter(), time.process_time()
            self.edited, self.move = self.move(self.edited), None
            self.hurry()

    @property
    def current(self) -> bool:
        """Whether the picture on the screen belongs to the present settings."""
        update = self.presenter.update
        return update is not None and update.generation == self.worker.generation


def run(settings: Settings, watch: Callable[[DrivenSession], bool], idle: bool = False,
         size: tuple[int, int] = SIZE, layout: str | None = None) -> None:
    """Show the window until `watch`, called after each frame, returns True; idle: slow down at rest as usual.

    layout: a name of LAYOUTS; None is the usual one.
    """
    without_display()
    session = DrivenSession(settings, remember=False, threads=2)
    if layout is not None:
        session.layout = layout
    runner = parameters(session, size)
    if not idle:
        runner.fps_idling.enable_idling = False
        runner.fps_idling.fps_max = 0.0

    def after() -> None:
        if watch(session):
            runner.app_shall_exit = True

    runner.callbacks.after_swap = after
    show(runner)


def focused(settings: Settings, turn: int) -> Settings:
    """Settings whose focus has been moved `turn` times."""
    return replace(settings, focus_distance=800.0 + 37.0 * turn)
