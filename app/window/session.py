"""The bench as long as its window is open: settings and their history, the worker, the picture, what is asked of them.

In each frame the newest picture is taken from the worker, the panels are drawn
one after the other, each handing on the settings that a hand has made of it,
and what has changed in the end goes to the history and to the worker.
"""

import ctypes
import json
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from imgui_bundle import hello_imgui, imgui
from imgui_bundle.glfw_utils import glfw_window_hello_imgui

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.display.frame import View
from lensbench.app.display.presenter import Presenter, save_window
from lensbench.app.panels.controls.controls import Chooser
from lensbench.app.panels.light_field.controller import LightFieldController
from lensbench.app.state.build import design
from lensbench.app.state.constraints import showable
from lensbench.app.state.settings import Settings
from lensbench.app.state.undo import History
from lensbench.app.widgets import theme
from lensbench.app.window.dialogs import ExportDialog, FilePrompt
from lensbench.app.window.docking import Panels, layout
from lensbench.app.window.file_actions import Files
from lensbench.app.window.menus import NOTHING_PINNED, shortcuts
from lensbench.app.workers.chart_worker import ChartWorker
from lensbench.app.workers.render_worker import RenderWorker

COMPILING_FPS = 8.0             # of the window while it waits for its first picture


class Session:
    """All that lives as long as the window."""

    def __init__(self, settings: Settings, remember: bool = True, threads: int | None = None):
        self.view, self.chooser = View(), Chooser()
        settings = self.showable(settings)
        with suppress(ValueError, OSError):             # a lens that cannot be read is the worker's to report
            self.say_findings(settings)
        self.history = History(settings)
        self.edited = settings                          # the settings on their way through this frame's panels
        self.prompt, self.export = FilePrompt(), ExportDialog(self.wake)
        self.files, self.panels = Files(self), Panels(self)
        self.remember = remember                        # layout, theme and recent files, beyond this session
        self.dark = True
        self.about = False                              # Help is asked for
        self.shots_taken = 0                            # pictures of the window that have been saved
        self.shot_problem = ""                          # why the latest of them was not
        self.worker = RenderWorker(settings, self.wake, threads)
        self.presenter = Presenter(self.worker)
        self.light_field = LightFieldController(self)
        self.charts = ChartWorker(self.wake)
        self._prepared = threading.Event()              # the panels' kernels are compiled
        self._shot: Path | None = None                  # a picture of the window is wanted
        self._finish: Callable[[], None] | None = None
        self._frames = 0
        self._pace: float | None = None                 # frames a second at most, once there is a picture
        self._fresh = False                             # no layout was saved by an earlier session
        self.laid_out_for: tuple[float, ...] = ()       # width, height, size of the font

    # The life of the window

    def opened(self) -> None:
        """The GL context is there."""
        sys.setswitchinterval(0.001)            # the worker gets its turn soon, also beside a busy window
        self.presenter.open()
        if self.presenter.software:
            address = ctypes.cast(glfw.get_proc_address("glFinish"), ctypes.c_void_p).value
            self._finish = ctypes.CFUNCTYPE(None)(address) if address else None
        theme.style_implot()
        threading.Thread(target=self._prepare, name="lensbench panels", daemon=True).start()
        if self.remember:
            self.dark = hello_imgui.load_lasting_pref("theme") != "light"
            with suppress(ValueError):
                self.files.recent = [Path(path) for path in json.loads(hello_imgui.load_lasting_pref("recent") or "[]")]
        theme.choose(self.dark)
        imgui.get_io().config_error_recovery_enable_tooltip = False     # a broken panel is said above the picture
        glfw.set_drop_callback(glfw_window_hello_imgui(), self.dropped)
        self._fresh = not hello_imgui.has_ini_settings(hello_imgui.get_runner_params())

    def closed(self) -> None:
        """The window is about to go."""
        self.export.cancel()
        self.panels.closed()
        self.light_field.worker.stop()
        self.charts.stop()
        self.worker.stop()

    def _prepare(self) -> None:
        """In a thread of its own: compile what the panels need, after the picture, which comes first."""
        from lensbench.app.workers.warm_panels import prepare

        try:
            while self.worker.newest() is None and self.worker.error is None and self.worker.alive:
                sleep(0.01)
            prepare(self.history.present)
        finally:
            self._prepared.set()
            self.wake()

    @property
    def prepared(self) -> bool:
        """Whether the panels can be drawn without waiting for a compiler."""
        return self._prepared.is_set()

    def lay_out(self) -> None:
        """Put the panels back where they belong, for the window as large as it is."""
        size = imgui.get_main_viewport().size
        docking = hello_imgui.get_runner_params().docking_params
        docking.docking_splits = layout(max(size.x, 1.0), max(size.y, 1.0), imgui.get_font_size())
        docking.layout_reset = True

    def _lay_out_once(self) -> None:
        """Window and font have their size only after the first frames: where that was guessed wrong, lay out again."""
        self._frames += 1
        size = imgui.get_main_viewport().size
        known = (size.x, size.y, imgui.get_font_size())
        if self._fresh and self._frames in (2, 5) and known != self.laid_out_for:
            self.laid_out_for = known
            self.lay_out()

    def choose_theme(self, dark: bool) -> None:
        """Dark or light, from now on."""
        self.dark = dark
        theme.choose(dark)
        if self.remember:
            hello_imgui.save_lasting_pref("theme", "dark" if dark else "light")

    def dropped(self, _window: Any, paths: list[str]) -> None:
        """GLFW: files have been dropped on the window."""
        self.files.drop(paths)

    def keep_recent(self) -> None:
        """Remember the recent files beyond this session."""
        if self.remember:
            hello_imgui.save_lasting_pref("recent", json.dumps([str(path) for path in self.files.recent]))

    def photograph(self, path: Path) -> None:
        """Save the whole window, as the next frame shows it."""
        self._shot = path

    def showable(self, settings: Settings) -> Settings:
        """The settings with as many pixels as a window can show; where that is fewer, it is said."""
        shown = showable(settings)
        if shown != settings:
            self.view.say(f"{settings.pixels_x} × {settings.pixels_y} pixels are more than the window can show: "
                          f"it renders {shown.pixels_x} × {shown.pixels_y}; an export takes more")
        return shown

    def say_findings(self, settings: Settings) -> None:
        """Say what the reader of the lens's file had to assume."""
        for finding in design(settings).findings:
            self.view.say(f"{Path(settings.lens).name}: {finding}")

    # A frame

    def begin(self) -> None:
        """Before the panels: news from the worker, what the keys and the dialogs say."""
        self.edited = self.history.present
        self._leave_room_to_compile()
        self._lay_out_once()
        self.presenter.take(self.view)
        self.light_field.begin()
        self._take_failure()
        shortcuts(self)
        self.files.answer()
        self._requests()

    def _leave_room_to_compile(self) -> None:
        """Few frames before the first picture: the compiler wants the processor."""
        idling = hello_imgui.get_runner_params().fps_idling
        if self.presenter.update is None:
            if self._pace is None:
                self._pace = idling.fps_max
            idling.fps_max = COMPILING_FPS
        elif self._pace is not None:
            idling.fps_max, self._pace = self._pace, None

    def end(self) -> None:
        """After the panels: what has changed goes to the history and to the worker."""
        held = imgui.is_any_item_active() or any(imgui.is_mouse_down(button) for button in range(3))
        if self.edited != self.history.present:
            try:
                self.edited = self.edited.checked()
            except ValueError as error:
                self.view.say(str(error))
                self.edited = self.history.present
        self.history.edit(self.edited, held, monotonic())
        self.light_field.end()
        self.apply()

    def apply(self) -> None:
        """Let the worker and the screen follow the present settings."""
        settings = self.history.present
        self.worker.restart(settings)
        self.worker.want_depth(settings.overlay in ("coc", "peaking") or self.view.pending is not None)

    def _requests(self) -> None:
        """What the toolbar and the lists have asked for."""
        wanted, self.view.requests = self.view.requests, set()
        wanted |= self.chooser.requests
        self.chooser.requests = set()
        if "pause" in wanted:
            self.worker.resume() if self.worker.paused else self.worker.pause()
        if "restart" in wanted:
            self.worker.again()
        if "pin" in wanted and self.presenter.pin(self.history.present) and self.presenter.pinned is not None:
            self.view.pinned = self.presenter.pinned.settings
            self.view.messages = [message for message in self.view.messages if message != NOTHING_PINNED]
        if "screenshot" in wanted:
            self.files.ask("screenshot")
        if "export" in wanted:
            self.export.open(self.history.present)
        for kind in ("lens", "scene", "picture"):
            if f"open {kind}" in wanted:
                self.files.ask(kind)

    def _take_failure(self) -> None:
        """Settings of which there is no picture are said and taken back."""
        failure = self.worker.error
        if failure is None:
            return
        self.view.say(str(failure.error) or type(failure.error).__name__)
        if not isinstance(failure.error, ValueError | OSError):
            traceback.print_exception(failure.error)
        good = self.presenter.update.settings if self.presenter.update is not None else Settings()
        if good.picture == failure.settings.picture:
            good = Settings()
        self.history.correct(replace(self.history.present, **_difference(good, failure.settings)))
        self.edited = self.history.present
        if self.edited.picture != failure.settings.picture:
            self.apply()

    def wake(self) -> None:
        """From the worker's thread: there is something to show."""
        hello_imgui.request_refresh()
        with suppress(glfw.GLFWError):
            glfw.post_empty_event()

    def hurry(self) -> None:
        """Send the worker off as soon as one panel has changed the picture; the others follow beside its first pass."""
        if self.edited.picture != self.history.present.picture:
            with suppress(ValueError):
                self.worker.restart(self.edited.checked())
                self.worker.await_set_up()

    # Screenshots

    def drawn(self) -> None:
        """Before the frame is swapped to the screen: wait for a slow renderer, take the screenshot that is wanted.

        A processor that draws would queue frame upon frame, and a new picture wait behind them all. Called by ctypes,
        which lets the worker's threads go on meanwhile.
        """
        if self._finish is not None:
            self._finish()
        self.worker.shown(self.presenter.update)
        if self._shot is None:
            return
        path, self._shot = self._shot, None
        width, height = imgui.get_io().display_size
        scale = imgui.get_io().display_framebuffer_scale
        size = (int(width * scale.x), int(height * scale.y))
        try:
            save_window(path, size)
            self.shots_taken += 1
        except OSError as error:
            self.shot_problem = f"{path}: {error.strerror or error}"
            self.view.say(self.shot_problem)

    def settled(self, samples: int) -> bool:
        """Whether the present settings are on the screen with so many samples."""
        update = self.presenter.update
        if (update is None or update.generation != self.worker.generation or update.depth is None
                or update.is_provisional):
            return False
        return self._prepared.is_set() and update.samples >= min(samples, update.settings.samples)


def _difference(good: Settings, bad: Settings) -> dict[str, Any]:
    """The fields in which settings that failed differ from those that did not."""
    return {f.name: getattr(good, f.name) for f in fields(Settings) if getattr(good, f.name) != getattr(bad, f.name)}
