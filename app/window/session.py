"""A window from its opening to its close: its life, its frames, its screenshots.

In each frame the newest picture is taken from the render worker, the panels are drawn one after the other, each
handing on the settings with its changes, and the changed settings go to the history and to the worker.
"""

import sys
import traceback
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from imgui_bundle import hello_imgui, imgui
from imgui_bundle.glfw_utils import glfw_window_hello_imgui

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.bench.constraints import constrained, longer_side_within
from lensbench.app.bench.exposure import METERED, Metering
from lensbench.app.bench.lens_choice import LOCKS
from lensbench.app.display.presenter import save_window
from lensbench.app.drawing import theme
from lensbench.app.drawing.dial import use_dials
from lensbench.app.session.notices import Request
from lensbench.app.session.states import save_session, session_path
from lensbench.app.settings.settings import Settings, differences
from lensbench.app.window.actions import NOTHING_PINNED, Keyboard, shortcuts
from lensbench.app.window.analyses import Analyses
from lensbench.app.window.bars import Help
from lensbench.app.window.dialogs import pictures_folder
from lensbench.app.window.docking import FRONT_FRAMES, MINIMUM, Folding
from lensbench.app.window.file_actions import QUESTIONS, Files
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.lens_browsing import LensBrowsing, LensEditing
from lensbench.app.window.palette import Palette
from lensbench.app.window.panels import Panels
from lensbench.app.window.screen import switch_full_screen
from lensbench.app.window.snapshots import Comparing, Snapshots
from lensbench.app.window.state import SCALES, WindowState, forget_derived, preference, texts
from lensbench.app.window.terms import Terms
from lensbench.app.workers.task import Heap, Task
from lensbench.core.kernels.cache import NotCompiledError

COMPILING_FPS = 8.0             # of the window while it waits for its first picture's kernels,
LOADING_FPS = 30.0              # and while these are compiled already


class Session(WindowState):
    """Everything that lives as long as the window."""

    def __init__(self, settings: Settings, remember: bool = True, threads: int | None = None):
        self._heap = Heap()                             # before the threads
        super().__init__(settings, remember, threads)
        self.help, self.palette, self.terms = Help(), Palette(), Terms()
        self.browsing = LensBrowsing(self)
        self.comparing = Comparing(self, threads)
        self.editing = LensEditing(self)
        self.folding = Folding(self)
        self.analyses = Analyses(self)
        self.snapshots = Snapshots(self, self.comparing)
        self.files = Files(self, self.export, self.analyses)
        self.panels = Panels(self, self.browsing, self.analyses, self.snapshots)
        self.shots_taken = 0                            # screenshots of the window that have been saved
        self.shot_is_early = False                      # the screenshot was taken before the picture was ready
        self.shot_problem = ""                          # why the latest of them was not
        self._warm_up: Task[None] | None = None         # compiles the panels' kernels
        self._keyboard = Keyboard()
        self._metering = Metering()
        self._metered: Settings | None = None           # settings with what the meter has chosen
        self._pace: float | None = None                 # frames a second at most, once there is a picture
        self._locked: frozenset[str] = frozenset()      # what the preferences hold
        self._impossible = ""                           # why there is no picture of the edited lens

    # The life of the window

    def opened(self) -> None:
        """The GL context is there."""
        self.is_open = True
        self.compilers.draw_here()
        sys.setswitchinterval(0.001)            # the worker gets its turn soon, even with a busy window
        use_dials(self.dials)
        self.presenter.open()
        theme.style_implot()
        self._warm_up = Task("Panels", self._prepare, self.wake, lowered=False)
        if self.remember:
            self.dark = hello_imgui.load_lasting_pref("theme") != "light"
            self.recent = [Path(path) for path in texts(preference("recent", []))]
            self.files.prompt.folder = Path(hello_imgui.load_lasting_pref("folder") or pictures_folder())
            self.chooser.locked.update(set(hello_imgui.load_lasting_pref("locked").split()) & set(LOCKS))
            self._locked = frozenset(self.chooser.locked)
            self.browsing.load()
            self.view.offers_trials = not session_path().exists()
            layout = hello_imgui.load_lasting_pref("layout")
            if layout in LAYOUTS:
                self.layout = layout
            scale = preference("scale", 0.0)
            self.scale = scale if scale in SCALES else 0.0
        theme.choose(self.dark)
        if self.scale:
            theme.choose_scale(self.scale, self.dark)
        io = imgui.get_io()
        io.config_error_recovery_enable_tooltip = False     # a message above the picture says it
        io.mouse_double_click_time = 0.45       # s, about as usual: 0.3 s pass in one slow frame
        glfw.set_drop_callback(glfw_window_hello_imgui(), self.dropped)
        if glfw.get_platform() != glfw.PLATFORM_NULL:   # which takes the least height for the greatest
            glfw.set_window_size_limits(glfw_window_hello_imgui(), *(
                round(side * hello_imgui.dpi_window_size_factor()) for side in MINIMUM), glfw.DONT_CARE, glfw.DONT_CARE)
        self.folding.opened()

    def closed(self) -> None:
        """The window is about to close."""
        self.is_open = False
        if self.remember:
            with suppress(ValueError, OSError):         # the next session begins anew
                save_session(self.history.present)
        if self.full_screen is not None:
            switch_full_screen(self)            # else the next session opens as large
        self.folding.closed()
        self.compilers.stop()                   # first: threads that wait for a kernel end with it
        self.export.cancel()
        self.snapshots.cancel()
        self.chooser.flare.worker.stop()
        self.browsing.closed()
        self.editing.closed()
        self.analyses.stop()
        self.panels.closed()
        self.light_field.worker.stop()
        self.charts.stop()
        self.comparing.closed()
        self.worker.stop()
        self.compilers.leave()

    def _prepare(self, task: Task[None]) -> None:
        """Compile the kernels of the panels, after those of the picture."""
        from lensbench.app.workers.compilers import prepare

        try:
            while self.worker.newest() is None and self.worker.error is None and self.worker.alive:
                sleep(0.01)
            prepare(self.history.present)
            if self.remember:
                self.compilers.compile_for_later()
        finally:
            self.prepared = True

    def dropped(self, _window: Any, paths: list[str]) -> None:
        """GLFW: files have been dropped on the window."""
        self.files.drop(paths)

    # A frame

    def begin(self) -> None:
        """Before the panels: results of the workers, keys, requests, files."""
        self.edited = self.history.present
        self.resume()
        self._leave_room_to_compile()
        self.folding.advance()
        self.presenter.take(self.view)
        if self.light_field.begin(self.history.present):
            self.edited = replace(self.edited, compare="difference")
        self._reload()
        self._take_failure()
        self._meter()
        self.view.links.advance()
        self.panels.follow_improvement()
        self.analyses.begin(self.panels.behind)
        self._unpin()
        self._steer_lists()
        shortcuts(self, self._keyboard)
        self.keyed = False
        self.files.answer()
        self._answer_requests()

    def dialogs(self) -> None:
        """After the panels, over them: the lens browser, the export and the help."""
        self.browsing.draw()
        message = self.export.draw()
        if message is not None:
            self.view.say(*message, about="export")
        if self.export.wants_current is not None:
            self.files.save_picture(*self.export.wants_current)
            self.export.wants_current = None
        if self.export.wants_path:
            self.export.wants_path = False
            self.requests.add(Request.CHOOSE_EXPORT_PATH)
        self.files.form.draw()
        self.snapshots.dialog.draw(self.history.present, self.browsing.state)
        self.help.draw(self.presenter.drawn_by)
        self.palette.draw(self)
        self.terms.draw()
        self.editing.draw()

    def end(self) -> None:
        """After the panels: the changes go to the history and to the worker."""
        is_held = imgui.is_any_item_active() or any(imgui.is_mouse_down(button) for button in range(3))
        self.keep(is_held or self.panels.improving)
        self.follow_window(monotonic())
        if self.view.follows:
            self.view.notices.forget(lambda notice: notice.offer is not None)
        self._keep_locks()
        busy = self.light_field.occupies_processor or self.export.busy or self.browsing.occupies_processor \
            or self.snapshots.task is not None
        self.worker.hold(busy)
        self.apply()
        self.analyses.follow(self.panels.behind)
        self.comparing.advance(busy)
        self.say_of_place()
        self.say_of_ghost()
        self.editing.advance(is_held)
        self.view.notices.follow(self.history.present.lens, self.history.step)
        self._heap.advance(monotonic())

    def _keep_locks(self) -> None:
        """Remember what another lens leaves as it is, beyond this session."""
        locked = frozenset(self.chooser.locked)
        if self.remember and locked != self._locked:
            hello_imgui.save_lasting_pref("locked", " ".join(sorted(locked)))
        self._locked = locked

    def _unpin(self) -> None:
        """Escape unpins the pixel, unless it closes something first."""
        if imgui.is_key_pressed(imgui.Key.escape) and not self.browsing.is_open and not self.dials.keyed \
                and not imgui.is_popup_open("", imgui.PopupFlags_.any_popup):
            self.view.links.pinned = None

    def _meter(self) -> None:
        """In the modes P, A and S the meter sets f-number and time; setting by hand what it sets leads to mode M."""
        view, current = self.view, self.history.present
        if view.program not in METERED:
            self._metered = None            # else the mode would end at once when it is chosen again
            return
        if current != self._metered:
            self._metering.forget()
        by_hand = {"P": ("f_number", "shutter"), "A": ("shutter",), "S": ("f_number",)}[view.program]
        if current.exposing != "triangle" or self._metered is not None and any(
                getattr(current, name) != getattr(self._metered, name) for name in by_hand) \
                and current.lens == self._metered.lens:
            view.program, self._metered = "", None
            return
        update = self.presenter.update
        if update is not None and not update.raw and update.generation == self.worker.generation \
                and not imgui.is_mouse_down(imgui.MouseButton_.left):
            chosen = self._metering.chosen(current, update.image, update.samples, view.program)
            if chosen != current:
                self.history.correct(chosen)
                self.edited = chosen
        self._metered = self.history.present

    @staticmethod
    def _steer_lists() -> None:
        """Arrows and Enter choose in an open list or menu; elsewhere the keys belong to the picture."""
        io, keys = imgui.get_io(), imgui.ConfigFlags_.nav_enable_keyboard
        opened = imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        io.config_flags = io.config_flags | keys if opened else io.config_flags & ~keys

    def _leave_room_to_compile(self) -> None:
        """Few frames before the first picture: the compiler needs the processor."""
        idling = hello_imgui.get_runner_params().fps_idling
        if self.presenter.update is None:
            if self._pace is None:
                self._pace = idling.fps_max
            idling.fps_max = COMPILING_FPS if self.compilers.busy else LOADING_FPS
        elif self._pace is not None:
            idling.fps_max, self._pace = self._pace, None

    def _answer_requests(self) -> None:
        """Do what panels, menus and keys have asked for."""
        requests = set(self.requests)
        self.requests.clear()
        if Request.PAUSE in requests:
            self.worker.resume() if self.worker.paused else self.worker.pause()
        if Request.RESTART in requests:
            self.worker.again()
        if Request.PIN in requests and self.comparing.pin():
            self.view.notices.forget(lambda notice: notice.text == NOTHING_PINNED)
        if Request.EXPORT in requests:
            self.export.open(self.history.present, self.view.follows, self.files.prompt.folder)
        if Request.BROWSE_LENSES in requests:
            self.browsing.toggle()
        if self.browsed is not None:
            self.browsing.show(self.browsed)
            self.browsed = None
        if Request.RESET_LAYOUT in requests:
            self.folding.lay_out()
        if Request.FOLLOW_WINDOW in requests:
            self.view.follows = not self.view.follows
        if Request.HIDE_PANELS in requests:
            self.folding.hide()
        if Request.FULL_SCREEN in requests:
            switch_full_screen(self)
        if Request.SHOW_HELP in requests:
            self.help.open()
        if Request.SHOW_PALETTE in requests:
            self.palette.open()
        if Request.SHOW_TERMS in requests:
            self.terms.open()
        if Request.IMPROVE_LENS in requests:
            self.show_panel("Surfaces")
            self.panels.kept.table.asks = FRONT_FRAMES + 1       # a panel that comes to the front closes popups
        self.snapshots.answer(requests)
        if self.shelf_path is not None:
            saved, self.shelf_path = self.shelf_path, None
            self.snapshots.save(*saved)
        self.light_field.answer(requests, self.history.present)
        if Request.SAVE_EDITED in requests:
            self.files.save_edited()
        if Request.ADJUST_SCENE in requests:
            self.files.form.visible = True
        for request in requests & set(QUESTIONS):
            self.files.ask(request)
        if self.reopened is not None:
            path, self.reopened = self.reopened, None
            self.files.open(path)

    def _reload(self) -> None:
        """Render again after a change on disk; a file that cannot be read keeps its last good content."""
        current = self.history.present
        changed, problems = self.watch.changed(current, monotonic())
        for name, problem in problems.items():
            self.view.say(problem, file=name)
        if not changed:
            return
        forget_derived()
        if current.edited and current.lens in changed:
            self.editing.file_changed(current.lens)     # the edits stay until the user has answered
        for name in changed:
            self.view.notices.read(name)
            self.view.say(f"Reloaded {Path(name).name}", done=True)
        with suppress(ValueError, OSError, NotCompiledError):
            self.history.correct(constrained(current))
            self.edited = self.history.present
        self.charts.forget()
        self.worker.reload(self.history.present)
        self.comparing.reload()

    def _take_failure(self) -> None:
        """Say why settings cannot be rendered, and take them back."""
        failure = self.worker.error
        update = self.presenter.update
        if failure is None:
            if self._impossible and update is not None and update.generation == self.worker.generation:
                self._forget_impossible()
            return
        message = str(failure.error) or type(failure.error).__name__
        if failure.settings.edited and isinstance(failure.error, ValueError | OSError):
            if message != self._impossible:         # a lens that cannot be stays, to be edited on
                self._forget_impossible()
                self._impossible = message
                self.view.say(message)
            return
        self.view.say(message)
        if not isinstance(failure.error, ValueError | OSError):
            traceback.print_exception(failure.error)
        good = self.presenter.update.settings if self.presenter.update is not None else Settings()
        if good.picture == failure.settings.picture:
            good = Settings()
        self.history.correct(replace(self.history.present, **differences(good, failure.settings)))
        self.edited = self.history.present
        if self.edited.picture != failure.settings.picture:
            self.apply()

    def _forget_impossible(self) -> None:
        """Dismiss the reason why there was no picture of the edited lens."""
        said, self._impossible = self._impossible, ""
        self.view.notices.forget(lambda notice: notice.text == said)

    # Screenshots

    def photograph(self, path: Path) -> None:
        """Save the whole window, as the next frame shows it."""
        self.screenshot = path

    def drawn(self) -> None:
        """Before the frame is swapped to the screen: wait for a slow renderer, take a screenshot if one is wanted.

        A processor that draws would queue frame upon frame, and a new picture would wait behind them all.
        """
        self.analyses.handed_over()
        self.presenter.finish()
        self.worker.shown(self.presenter.update,
                          self.panels.behind is self.history.present and not self.analyses.worker.is_late)
        if self.screenshot is None:
            return
        path, self.screenshot = self.screenshot, None
        width, height = imgui.get_io().display_size
        scale = imgui.get_io().display_framebuffer_scale
        size = (int(width * scale.x), int(height * scale.y))
        try:
            save_window(path, size)
            self.shots_taken += 1
        except OSError as error:
            self.shot_problem = f"{path}: {error.strerror or error}"
            self.view.say(self.shot_problem)

    def _fills(self) -> bool:
        """Whether the picture has the pixels that the window shows of it."""
        current = self.history.present
        if current.compare != "off" or self.view.zoom is not None:
            return True
        return max(current.pixels_x, current.pixels_y) == longer_side_within(current, self.wanted_room(current))

    def settled(self, samples: int) -> bool:
        """Whether the picture of the current settings is on the screen with this many samples."""
        update = self.presenter.update
        if (update is None or update.generation != self.worker.generation or update.depth is None
                or update.is_provisional):
            return False
        if self.opening is not None or self.reopened is not None or self.view.follows and not self._fills():
            return False
        ready = self.prepared and not self.analyses.worker.busy
        return ready and update.samples >= min(samples, update.settings.samples)

