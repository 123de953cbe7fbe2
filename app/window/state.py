"""State shared by the panels, the menus and the file actions of one window.

Settings and their history, the picture and its view, the background workers, and the requests of panels. `Session`
adds the life of the window and its frames.

Preferences that are kept as JSON beyond a session, in the file of imgui's own settings.

Notices when a file of the settings changes on disk: the lens, the scene, or the picture in the stop.
"""

import json
import math
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from imgui_bundle import hello_imgui, imgui
from numpy.typing import NDArray

from lensbench import lenses
from lensbench.app.bench.build import own_picture, stop_picture
from lensbench.app.scenes.asset_files import file_stamp
from lensbench.app.scenes.scene_file import find_scene, scene_stamp
from lensbench.app.settings.settings import Settings

import glfw  # isort: skip - after imgui_bundle, so that both share one library
import lensbench as lb
from lensbench.app.bench.build import missing_ghost, published, wavelength_remark
from lensbench.app.bench.constraints import coarser, longer_side_within, showable, with_longer_side
from lensbench.app.bench.framing import in_the_way, moved_text
from lensbench.app.display.frame import View
from lensbench.app.display.presenter import Presenter
from lensbench.app.drawing import theme
from lensbench.app.drawing.dial import DialState
from lensbench.app.panels.controls.controls import Chooser
from lensbench.app.panels.controls.flare_popup import FlareState
from lensbench.app.panels.light_field.controller import LightFieldController
from lensbench.app.session.lens_shelf import Shelf
from lensbench.app.session.notices import Notice, NoticeKind, Request
from lensbench.app.session.states import History
from lensbench.app.settings.setting_table import DEEP
from lensbench.app.settings.settings import RESTARTS_MOTION, RESTARTS_NOTHING
from lensbench.app.window.dialogs import ExportDialog
from lensbench.app.window.layouts import BENCH, LAYOUTS
from lensbench.app.workers.compilers import Compilers
from lensbench.app.workers.flare_worker import FlareWorker
from lensbench.app.workers.render_worker import RenderWorker
from lensbench.app.workers.study_workers import ChartWorker
from lensbench.app.workers.task import Task
from lensbench.core.kernels.cache import NotCompiledError


def preference(name: str, otherwise: Any) -> Any:
    """The kept value; `otherwise` where none was kept, where it is damaged, and where it is of another type."""
    try:
        kept = json.loads(hello_imgui.load_lasting_pref(name) or "null")
    except ValueError:
        return otherwise
    return kept if isinstance(kept, type(otherwise)) else otherwise


def texts(values: Any) -> list[str]:
    """The texts of a list that was kept; what is none is left out, and all of it where it is no list."""
    return [value for value in values if isinstance(value, str)] if isinstance(values, list) else []


SECONDS = 1.0                   # between two looks at the disk


class FileWatch:
    """Compares the stamps of the files with those of the last look."""

    def __init__(self) -> None:
        self._stamps: dict[str, tuple] = {}
        self._next = 0.0

    def note(self, name: str) -> None:
        """The current content of a file is known, such as one that the window has written."""
        self._stamps[name] = file_stamp(name)

    def changed(self, settings: Settings, now: float) -> tuple[list[str], dict[str, str]]:
        """Names of the files that have changed and can be read, and messages by name about those that cannot.

        At most once a second. A file that the settings have not named before counts as unchanged; its stamp is taken
        at once, so that a change within that second is seen.
        """
        files = [file for file in ((settings.lens, file_stamp, lenses.load),
                                   (settings.scene, scene_stamp, find_scene),
                                   (settings.stop_image, file_stamp, stop_picture),
                                   (own_picture(settings), file_stamp, stop_picture)) if file[0]]
        for name, stamp_of, _ in files:
            if name not in self._stamps:
                self._stamps[name] = stamp_of(name)
        if now < self._next:
            return [], {}
        self._next = now + SECONDS
        names, problems = [], dict[str, str]()
        for name, stamp_of, load in files:
            stamp = stamp_of(name)
            if self._stamps[name] == stamp:
                continue
            self._stamps[name] = stamp
            try:
                load(name)
            except (ValueError, OSError) as error:
                problems[name] = (f"{Path(name).name} has changed and cannot be read; its last good content stays in "
                                  f"use: {error}")
            else:
                names.append(name)
        return names, problems


def forget_derived() -> None:
    """Clear the caches that are keyed by settings: their values come from the old content of a file."""
    for name, module in list(sys.modules.items()):
        if name.startswith(("lensbench.app.settings.", "lensbench.app.panels.")):
            for value in list(vars(module).values()):
                if hasattr(value, "cache_clear"):
                    value.cache_clear()


DRAG_SECONDS = 0.1              # that a first pass may take during a drag, if the picture follows the window
SCALES = {0.0: "As the screen asks for", **{percent / 100.0: f"{percent} %" for percent in (100, 125, 150, 175, 200)}}
MOST_AROUND = 4.0               # a panorama in which one looks around has so many times the pixels of the room
STILL_SECONDS = 0.25            # that the room for the picture stays the same before the picture takes its pixels


class WindowState:
    """Lives as long as the window."""

    is_open = False                                     # between its first frame and its end

    def __init__(self, settings: Settings, remember: bool = True, threads: int | None = None):
        self.requests: set[Request] = set()
        self.view, self.dials = View(requests=self.requests), DialState()
        self.chooser = Chooser(requests=self.requests, flare=FlareState(FlareWorker(self.wake)))
        self.compilers = Compilers(self.wake)
        self.compilers.begin()
        settings = self.showable(settings)
        with suppress(ValueError, OSError):             # the worker reports a lens that cannot be read
            self.say_findings(settings)
        self.history = History(settings)
        self.edited = settings                          # the settings on their way through this frame's panels
        self.worker = RenderWorker(settings, self.wake, threads, expect=self.compilers.expect)
        self.presenter = Presenter(self.worker)
        self.charts = ChartWorker(self.wake)
        self.light_field = LightFieldController(self.view, self.presenter, settings, self.requests, self.wake)
        self.watch = FileWatch()
        self._placed: tuple | None = None      # lens, scene and place of the camera,
        self._of_place = ""                             # and the note on them
        self._from: Settings | None = None              # before the drag that is held
        self._of_move = ""                              # the note on how far the camera was moved
        self._shown_ghost: tuple[object, ...] = ()      # lens and ghost of which was last asked whether it exists
        self._of_ghost = ""                             # and the note on it
        self.remember = remember                        # layout, theme and recent files, beyond this session
        self.export = ExportDialog(self.wake)
        self.dark = True
        self.scale = 0.0                                # one of SCALES
        self.keyed = False                              # a panel has the keyboard for Tab and the arrows
        self.panels_hidden = False
        self.full_screen: tuple[int, int, int, int] | None = None       # place and size of the window before it
        self.layout = BENCH                             # the chosen one of LAYOUTS
        self.recent: list[Path] = []                    # files that were opened, the newest first
        self.shelf_path: tuple[Request, Path] | None = None     # where a card or a sheet is to be saved
        self.snapshot_number = 0                        # of the shelf, from 1, that a key asks for
        self.written = "", ""                           # the lens and the edits that the window has saved last
        self.reopened: Path | None = None               # a recent file that is to be opened
        self.browsed: Shelf | None = None               # what the lens browser is to be opened with
        self.opening: Task[str] | None = None           # reads a scene
        self.screenshot: Path | None = None             # where a picture of the window is to be saved
        self._postponed: tuple[Settings, Callable[[], Settings]] | None = None      # current settings, and a change
        self._drags = False                             # the picture changes while a mouse button or an item is held
        self._hurried: Settings | None = None           # of this frame, with which the render has been started
        self._room = (0.0, 0.0), 0.0                    # for the picture, and since when
        self.prepared = False                           # the panels can be drawn without waiting for a compiler

    def wake(self) -> None:
        """From any thread: there is something new to show."""
        if self.is_open:                                # GLFW would complain before and after
            hello_imgui.request_refresh()
            with suppress(glfw.GLFWError):
                glfw.post_empty_event()

    # Settings

    def postpone(self, error: NotCompiledError) -> None:
        """Do again, once its kernels are compiled, what the user has asked for and what this error has ended."""
        if error.resume is not None:
            self._postponed = self.history.present, error.resume

    def resume(self) -> None:
        """Edit the settings as postponed, unless they have changed since."""
        if self._postponed is None:
            return
        (before, change), self._postponed = self._postponed, None
        if before == self.history.present:
            with suppress(ValueError, OSError):         # the lens is gone by now: the user sees no change
                self.edited = self.showable(change())

    def take(self, settings: Settings) -> None:
        """Set other settings at once, as one step of undo, and render them."""
        self.edited = settings
        self.history.edit(settings, False, 0.0)
        self.apply()

    def apply(self) -> None:
        """Let the render worker follow the current settings."""
        settings, self._hurried = self.history.present, None
        self.worker.restart(self._rendered(settings))
        self.worker.want_depth(settings.overlay in DEEP or self.view.pending is not None)

    def lens_written(self, name: str, settings: Settings) -> None:
        """The window itself has written the file of its lens: drop what was computed from the file before."""
        self.written = self.history.present.lens, self.history.present.edited
        self.watch.note(name)
        forget_derived()
        self.charts.forget()
        self.take(settings)
        self.worker.reload(settings)

    def hurry(self) -> None:
        """Start the render as soon as one panel has changed the picture; the others are drawn during its first pass."""
        if self.edited is not self._hurried and self.edited.picture != self.history.present.picture:
            self._hurried = self.edited
            with suppress(ValueError):
                self._drags = self._drags or imgui.is_any_item_active()
                self.worker.restart(self._rendered(self.edited.checked()))
                self.worker.await_set_up()

    def _rendered(self, settings: Settings) -> Settings:
        """The settings as they are rendered now: with fewer pixels during a drag whose pictures would be slow."""
        update = self.worker.newest()
        if not self.view.follows or not self._drags or update is None or not update.rate > 0.0:
            return settings
        return coarser(settings, DRAG_SECONDS * update.rate)

    def picture_now(self) -> tuple[NDArray[np.float32], Settings, lb.Choice | None] | None:
        """The linear picture (h, w, 3) that is shown, its settings and the choice of its model.

        With its current samples; instead of the camera's that of a light field, where this is on the screen.
        """
        update, current = self.worker.newest(), self.history.present
        if self.presenter.field_picture is not None:
            refocused = self.light_field.picture(current)
            return None if refocused is None else (*refocused, None)
        if update is None:
            return None
        later = {name: getattr(current, name) for name in (*RESTARTS_NOTHING, *RESTARTS_MOTION)}
        settings = replace(update.settings, **{**later, "samples": update.samples})
        image = update.image if update.plain is None else update.plain
        return image, settings, None if update.is_provisional else update.choice

    @staticmethod
    def panel_shown(name: str) -> bool:
        """Whether a panel is in front of its dock."""
        window = imgui.internal.find_window_by_name(name)
        return window is not None and (window.active or window.was_active) and not window.hidden

    def show_panel(self, name: str) -> None:
        """Show a panel, in front of its dock; by its name, for laying out makes the list of panels anew."""
        panel = hello_imgui.get_runner_params().docking_params.dockable_window_of_name(name)
        panel.is_visible = panel.focus_window_at_next_frame = True

    def wanted_room(self, settings: Settings) -> tuple[float, float]:
        """Pixels across and down for the picture: more than the screen has, where it shows a part of a panorama."""
        look, room = self.view.look, self.view.room
        if look is None or not settings.kind.panorama:
            return room
        whole = max(room) * min(2.0 * math.pi / look.fov, MOST_AROUND)
        return whole, whole

    def follow_window(self, now: float) -> None:
        """Give the picture as many pixels as the window shows of it, once its room has been the same for a moment."""
        view, current = self.view, self.history.present
        if not view.follows or current.compare != "off" or view.zoom is not None or min(view.room) < 1.0:
            return
        if view.room != self._room[0]:
            self._room = view.room, now
        sized = with_longer_side(current, longer_side_within(current, self.wanted_room(current)))
        same = (sized.pixels_x, sized.pixels_y) == (current.pixels_x, current.pixels_y)
        if not same and not self._drags and (now - self._room[1] >= STILL_SECONDS or self.worker.newest() is None):
            self.history.correct(sized)
            self.edited = sized

    def say_moved(self, settings: Settings, before: Settings | None = None) -> None:
        """Show how far a lens, a format, a field of view or a framing in these settings has moved the camera.

        before: None for the settings before the drag that is held, or the current ones.
        """
        before = before or self._from or self.history.present
        names = ("lens", "film_width", "film_height", "crop", "zoom", "focal_length", "fov", "framing")
        if settings.scene != before.scene or all(getattr(settings, name) == getattr(before, name) for name in names):
            return
        self.view.notices.forget(lambda notice: notice.text == self._of_move)
        self._of_move = moved_text(before, settings)
        if self._of_move:
            self.view.say(self._of_move, note=True, change=True)

    def keep(self, is_held: bool) -> None:
        """Record the changes of this frame's panels in the history. held: a mouse button or an item is held."""
        self._drags = is_held and (self._drags or self.edited.picture != self.history.present.picture)
        self._from = (self._from or self.history.present) if is_held else None
        if self.edited != self.history.present:
            try:
                self.edited = self.edited.checked()
            except ValueError as error:
                self.view.say(str(error))
                self.edited = self.history.present
            self.say_moved(self.edited)
        self.history.edit(self.edited, is_held, monotonic())

    def showable(self, settings: Settings) -> Settings:
        """The settings with as many pixels as a window can show; a message says if that is fewer."""
        shown = showable(settings)
        if shown != settings:
            self.view.say(f"{settings.pixels_x} × {settings.pixels_y} pixels are more than the window can show: "
                          f"it renders {shown.pixels_x} × {shown.pixels_y}; an export can have more", note=True,
                          change=True)
        return shown

    def say_findings(self, settings: Settings) -> None:
        """Show the assumptions of the reader of the lens file, and a wavelength of its own."""
        lens, name = published(settings), Path(settings.lens).name
        for finding in lens.findings:
            self.view.say(f"{name}: {finding}", lens=settings.lens)
        remark = wavelength_remark(settings)
        if remark:
            self.view.say(f"{name}: {remark}", lens=settings.lens)

    def say_of_place(self) -> None:
        """Show what keeps the camera nearer to the subject than its lens would frame it, until it is moved."""
        current = self.history.present
        position = current.lens, current.scene, current.position
        if position == self._placed:
            return
        try:
            obstacle = in_the_way(current)
        except NotCompiledError:                        # asked for again in the next frame
            return
        self.view.notices.forget(lambda notice: notice.text == self._of_place)
        self._placed, self._of_place = position, obstacle
        if obstacle:
            self.view.say(self._of_place, lens=current.lens)

    def say_of_ghost(self) -> None:
        """Show that the lens has no such ghost as is shown alone, after an edit of the lens for one."""
        current = self.history.present
        shown = current.lens, current.edited, current.ghosts, current.ghost_pair, current.has_lens
        if shown == self._shown_ghost:
            return
        self.view.notices.forget(lambda notice: notice.text == self._of_ghost)
        self._shown_ghost, self._of_ghost = shown, missing_ghost(current)
        if self._of_ghost:
            self.view.say(self._of_ghost, lens=current.lens)

    # The window

    def choose_theme(self, dark: bool) -> None:
        """Dark or light, from now on."""
        self.dark = dark
        theme.choose(dark)
        if self.remember:
            hello_imgui.save_lasting_pref("theme", "dark" if dark else "light")

    def choose_scale(self, scale: float) -> None:
        """One of SCALES, from now on; the panels of the layout are laid out anew for it."""
        self.scale = scale
        theme.choose_scale(scale, self.dark)
        self.requests.add(Request.RESET_LAYOUT)
        if self.remember:
            hello_imgui.save_lasting_pref("scale", json.dumps(scale))

    def say_locked(self, file: str, settings: Settings) -> None:
        """Show that a file has set the pixels of the picture, with a button that follows the window again."""
        self.view.notices.say(Notice(
            f"{file} sets {settings.pixels_x} × {settings.pixels_y} pixels: the picture no longer follows the window",
            NoticeKind.NOTE, offer=("Follow window", Request.FOLLOW_WINDOW)))

    def choose_layout(self, name: str) -> None:
        """Lay the panels out as one of LAYOUTS, where they were left in it, with its white light of analyses.

        Now and in later sessions.
        """
        self.layout = name
        self.edited = replace(self.edited, white=LAYOUTS[name].white)
        self.history.edit(self.edited, False, monotonic())
        if self.remember:
            hello_imgui.save_lasting_pref("layout", name)
