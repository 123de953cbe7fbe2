"""The window of the bench: panels around the picture, all of them views of one Settings.

In each frame the newest picture is taken from the worker, the panels are drawn
one after the other, each handing on the settings that a hand has made of it,
and what has changed in the end goes to the history and to the worker.
"""

import json
import math
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, hello_imgui, imgui, immapp, implot

import glfw  # isort: skip - after imgui_bundle, so that both share one library
import moderngl

from lensbench.app import theme
from lensbench.app.dialogs import ExportDialog, FilePrompt
from lensbench.app.files import Files
from lensbench.app.history import History
from lensbench.app.menus import menus, shortcuts
from lensbench.app.render_panel import Mark, Picture, View, render_panel
from lensbench.app.screen import Development, Screen, softening
from lensbench.app.settings import Settings
from lensbench.app.worker import News, Worker

TITLE = "lensbench"
SIZE = (1280, 720)
SCREENSHOT_SAMPLES = 64
SCREENSHOT_SECONDS = 120.0          # after which a screenshot shows what there is
PANELS = ("Controls", "Read-outs", "Render", "Section", "Circle of confusion", "Exit pupil")


class Bench:
    """All that lives as long as the window."""

    def __init__(self, settings: Settings, remember: bool = True, threads: int | None = None):
        from lensbench.app.controls import Chooser

        self.history = History(settings)
        self.edited = settings                          # the settings on their way through this frame's panels
        self.view, self.chooser = View(), Chooser()
        self.prompt, self.export = FilePrompt(), ExportDialog()
        self.files = Files(self)
        self.remember = remember
        self.dark = True
        self.hidden: set[str] = set()
        self.about = False
        self.worker = Worker(settings, self._woken, threads)
        self._good = settings                           # the latest settings of which there is a picture
        self._tried_default = False
        self._news: News | None = None
        self._deep: News | None = None                  # the newest with a depth map
        self._loaded: Any = None                        # what the screen holds of it
        self._shares: tuple[Any, Any] = (None, None)
        self._film_radius = 0.0
        self._broken: set[str] = set()                  # what has been logged
        self._failed: dict[str, Settings] = {}          # panels, and the settings that they broke at
        self._screen: Screen | None = None
        self._prepared = threading.Event()              # the panels' kernels are compiled
        self._shot: Path | None = None                  # a screenshot of the window that is wanted
        self._shots_taken = 0
        self._frames = 0
        self._fresh = False                             # no layout was saved by an earlier session
        self._laid_out_for = (*map(float, SIZE), theme.FONT_SIZE)

    # The life of the window

    def opened(self) -> None:
        """The GL context is there."""
        sys.setswitchinterval(0.001)            # the worker gets its turn soon, also beside a busy window
        moderngl.init_context()
        self._screen = Screen(moderngl.get_context())
        theme.style_implot()
        threading.Thread(target=self._prepare, name="lensbench panels", daemon=True).start()
        if self.remember:
            self.dark = hello_imgui.load_lasting_pref("theme") != "light"
            with suppress(ValueError):
                self.files.recent = [Path(path) for path in json.loads(hello_imgui.load_lasting_pref("recent") or "[]")]
        theme.choose(self.dark)
        imgui.get_io().config_error_recovery_enable_tooltip = False     # a broken panel is said above the picture
        glfw.set_drop_callback(_glfw_window(), self.dropped)
        self._fresh = not hello_imgui.has_ini_settings(hello_imgui.get_runner_params())

    def closed(self) -> None:
        """The window is about to go."""
        self.export.cancel()
        self.worker.stop()

    def _prepare(self) -> None:
        """In a thread of its own: compile what the panels need, after the picture, which comes first."""
        from lensbench.app.panel_kernels import prepare

        try:
            while self.worker.newest() is None and self.worker.error is None and self.worker.alive:
                sleep(0.01)
            prepare(self.history.present)
        finally:
            self._prepared.set()
            self._woken()

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
        if self._fresh and self._frames in (2, 5) and known != self._laid_out_for:
            self._laid_out_for = known
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

    # A frame

    def begin(self) -> None:
        """Before the panels: news from the worker, what the keys and the dialogs say."""
        self.edited = self.history.present
        self._lay_out_once()
        self._take_news()
        shortcuts(self)
        self.files.answer()
        self._requests()

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
        if "screenshot" in wanted:
            self.files.ask_screenshot()
        if "export" in wanted:
            self.export.open(self.history.present)
        for kind in ("lens", "scene", "picture"):
            if f"open {kind}" in wanted:
                self.files.ask(kind)

    def _take_news(self) -> None:
        news, screen = self.worker.newest(), self._screen
        if news is not None and screen is not None and news is not self._news:
            if self._news is None or news.image is not self._news.image:
                screen.load(news.image)
            self._news, self._good = news, news.settings
            if news.depth is not None:
                self._deep = news
            if self.view.mark is None and news.depth is not None:
                self.view.mark = _first_mark(news)
        failure = self.worker.error
        if failure is not None:
            self.view.say(str(failure.error) or type(failure.error).__name__)
            if not isinstance(failure.error, ValueError | OSError):
                traceback.print_exception(failure.error)
            if self._good.picture == failure.settings.picture:
                self._good = Settings()
            self.history.correct(replace(self.history.present, **_difference(self._good, failure.settings)))
            self.edited = self.history.present
            if self.edited.picture != failure.settings.picture:
                self.apply()

    def _woken(self) -> None:
        """From the worker's thread: there is something to show."""
        hello_imgui.request_refresh()
        with suppress(glfw.GLFWError):
            glfw.post_empty_event()

    def picture(self) -> Picture:
        """What the render panel shows in this frame."""
        settings, news, screen = self.edited, self._news, self._screen
        waiting = self.worker.waiting
        if news is None or screen is None:
            return Picture(waiting=waiting, first=True)
        development = self._development(settings, news, screen)
        texture = screen.developed(development)
        screen.enlarge_by_pixels(self.view.scale >= 2.0)
        shares = None
        if self.view.histogram:
            key = (id(news.image), settings.exposure, settings.tone)
            if self._shares[0] != key:
                from lensbench.app.histogram import histogram

                self._shares = (key, histogram(news.image, settings.exposure, settings.tone))
            shares = self._shares[1]
        deep = self._deep
        depth = deep.depth if deep is not None and _aim(deep.settings) == _aim(settings) else None
        return Picture(texture, screen.size, news.samples, news.seconds, self.worker.paused, waiting, False, depth,
                       shares)

    def _development(self, settings: Settings, news: News, screen: Screen) -> Development:
        """What the shaders need for the picture as it is set and for the overlays of the settings it was made with."""
        from lensbench.app.blur import Blur

        blur = Blur.of(news.settings)
        share = softening(news.samples)
        depth = self._deep.depth if self._deep is not None else None
        if depth is not None and (share > 0.0 or settings.overlay in ("coc", "peaking")):
            key = (id(depth), blur.offset)
            if key != self._loaded:
                screen.load_depth(blur.reciprocal(depth))
                self._loaded = key
        amber = theme.DARK.amber
        return Development(settings.exposure, settings.tone, settings.overlay, blur.gain, blur.focus,
                           max(blur.sharp, 1.0), max(6.0 / max(self.view.scale, 0.05), 2.0),
                           (amber[0], amber[1], amber[2]), share=share if self._loaded else 0.0)

    # The panels

    def guarded(self, name: str, draw: Callable[[], None]) -> Callable[[], None]:
        """A callback that cannot end the window: what goes wrong in it is shown, and logged once.

        A panel that broke is left alone until the settings change.
        """
        def call() -> None:
            if name in PANELS and name != "Render" and not self._prepared.is_set():
                return
            if name in self._failed:
                if self._failed[name] == self.edited:
                    imgui.text_disabled("Nothing can be shown for these settings")
                    return
                del self._failed[name]
            drawing = imgui.get_current_context() is not None and imgui.internal.get_current_window_read() is not None
            state = imgui.internal.ErrorRecoveryState()
            if drawing:
                imgui.internal.error_recovery_store_state(state)
            try:
                draw()
            except Exception as error:
                if drawing:
                    _recover(state)
                if name in PANELS:
                    self._failed[name] = self.edited
                message = f"{name}: {type(error).__name__}: {error}"
                if message not in self._broken:
                    self._broken.add(message)
                    self.view.say(message)
                    traceback.print_exc(file=sys.stderr)
            if name in PANELS:
                self._hurry()
        return call

    def _hurry(self) -> None:
        """Send the worker off as soon as one panel has changed the picture: the others take their time to follow."""
        if self.edited.picture != self.history.present.picture:
            with suppress(ValueError):
                self.worker.restart(self.edited.checked())

    def draw_render(self) -> None:
        """The render, in the central node without a tab."""
        one = imgui.WindowClass()
        one.dock_node_flags_override_set = imgui.internal.DockNodeFlagsPrivate_.no_tab_bar
        imgui.set_next_window_class(one)
        imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*theme.colours().ground))
        self._panel("Render", 0.0, self._draw_render)
        imgui.pop_style_color()

    def draw_section(self) -> None:
        """The lens, cut open, with a narrow margin."""
        self._panel("Section", 4.0 * theme.scale(), self._draw_section)

    def _panel(self, name: str, padding: float, draw: Callable[[], None]) -> None:
        """A window of its own margin, that neither scrolls nor folds."""
        imgui.push_style_var(imgui.StyleVar_.window_padding, ImVec2(padding, padding))
        flags = imgui.WindowFlags_
        shown, _ = imgui.begin(name, None, flags.no_scrollbar | flags.no_scroll_with_mouse | flags.no_collapse)
        imgui.pop_style_var()
        if shown:
            self.guarded(name, draw)()
        imgui.end()

    def _draw_render(self) -> None:
        self.edited = render_panel(self.edited, self.picture(), self.view)

    def draw_controls(self) -> None:
        """The left column."""
        from lensbench.app.controls import controls_panel

        self.edited = controls_panel(self.edited, self.chooser)

    def draw_readouts(self) -> None:
        """The figures."""
        from lensbench.app.readouts import Status, readouts_panel

        news = self._news
        readouts_panel(self.edited, Status(news.rate if news else 0.0, hello_imgui.frame_rate(),
                                           news.samples if news else 0))

    def _draw_section(self) -> None:
        from lensbench.app.section import section_panel

        self.edited = section_panel(self.edited, self._film_radius)

    def draw_confusion(self) -> None:
        """The circles of confusion."""
        from lensbench.app.coc_panel import coc_panel

        self.edited = coc_panel(self.edited)

    def draw_pupil(self) -> None:
        """The exit pupil's region."""
        from lensbench.app.pupil_panel import pupil_panel

        hover = None
        if self.view.hover is not None:
            film, (x, y) = self.edited.film, self.view.hover
            hover = math.hypot((0.5 - x / film.pixels_x) * film.width, (y / film.pixels_y - 0.5) * film.height)
        self._film_radius = pupil_panel(self.edited, self._film_radius, hover)

    def draw_dialogs(self) -> None:
        """What stands over the panels."""
        said = self.export.draw()
        if said:
            self.view.say(said)
        if self.export.wants_path:
            self.export.wants_path = False
            self.files.ask_export()
        from lensbench.app.menus import about

        about(self)

    def draw_status(self) -> None:
        """The line at the bottom."""
        from lensbench.app.status import status_bar

        status_bar(self.edited, self._news, self.worker, self.view)

    # Screenshots

    def shoot(self) -> None:
        """Before the frame is swapped to the screen: take the screenshot that is wanted."""
        if self._shot is None:
            return
        path, self._shot = self._shot, None
        width, height = imgui.get_io().display_size
        scale = imgui.get_io().display_framebuffer_scale
        size = (int(width * scale.x), int(height * scale.y))
        try:
            _save_window(path, size)
            self._shots_taken += 1
        except OSError as error:
            self.view.say(f"{path}: {error.strerror or error}")

    @property
    def shots_taken(self) -> int:
        """How many pictures of the window have been saved."""
        return self._shots_taken

    def settled(self, samples: int) -> bool:
        """Whether the present settings are on the screen with so many samples."""
        news = self._news
        if news is None or news.generation != self.worker.generation or news.depth is None:
            return False
        return self._prepared.is_set() and news.samples >= min(samples, news.settings.samples)


def _recover(state: imgui.internal.ErrorRecoveryState) -> None:
    """End what a panel had begun when it broke."""
    if implot.internal.get_current_plot() is not None:
        implot.end_plot()
    io = imgui.get_io()
    asserting, io.config_error_recovery_enable_assert = io.config_error_recovery_enable_assert, False
    imgui.internal.error_recovery_try_to_recover_state(state)
    io.config_error_recovery_enable_assert = asserting


def _glfw_window() -> Any:
    from imgui_bundle.glfw_utils import glfw_window_hello_imgui

    return glfw_window_hello_imgui()


def _aim(settings: Settings) -> Settings:
    """What the depth of a pixel depends on; a little breathing of the lens aside."""
    plain = Settings()
    return replace(settings.picture, focus_distance=plain.focus_distance, f_number=plain.f_number, seed=plain.seed)


def _difference(good: Settings, bad: Settings) -> dict[str, Any]:
    """The fields in which settings that failed differ from those that did not."""
    from dataclasses import fields

    return {f.name: getattr(good, f.name) for f in fields(Settings) if getattr(good, f.name) != getattr(bad, f.name)}


def _first_mark(news: News) -> Mark | None:
    """A place near the middle of the picture that is in focus."""
    focus, depth = news.settings.focus_distance, news.depth
    if depth is None or not math.isfinite(focus):
        return None
    rows, columns = depth.shape
    y, x = np.nonzero(np.abs(depth - focus) < 0.01 * focus)
    off = np.hypot(x / columns - 0.5, y / rows - 0.5)
    if not len(x) or off.min() > 0.35:
        return None
    at = int(np.argmin(off))
    return Mark((x[at] + 0.5) / columns, (y[at] + 0.5) / rows, focus)


def _save_window(path: Path, size: tuple[int, int]) -> None:
    from PIL import Image

    screen = moderngl.get_context().screen
    screen.viewport = (0, 0, *size)
    pixels = np.frombuffer(screen.read(viewport=(0, 0, *size), components=3, alignment=1), np.uint8)
    Image.fromarray(np.ascontiguousarray(pixels.reshape(size[1], size[0], 3)[::-1])).save(path, "PNG")


# Opening it


def layout(width: float, height: float, em: float) -> list[hello_imgui.DockingSplit]:
    """The splits of a window of this size: columns left and right, the section under the render."""
    left = min(max(0.165 * width, 18.0 * em), 22.0 * em)
    right = min(max(0.215 * width, 19.4 * em), 30.0 * em)
    side = imgui.Dir
    return [
        hello_imgui.DockingSplit("MainDockSpace", "Left", side.left, min(left / width, 0.4)),
        hello_imgui.DockingSplit("MainDockSpace", "Right", side.right, min(right / max(width - left, 1.0), 0.45)),
        hello_imgui.DockingSplit("MainDockSpace", "Bottom", side.down, 0.30),
        hello_imgui.DockingSplit("Left", "LeftBottom", side.down, min(max(1.0 - 31.2 * em / height, 0.28), 0.45)),
        hello_imgui.DockingSplit("Right", "RightBottom", side.down, 0.55),
    ]


def parameters(bench: Bench, size: tuple[int, int] = SIZE) -> hello_imgui.RunnerParams:
    """Everything that hello_imgui needs to run the bench."""
    runner = hello_imgui.RunnerParams()
    runner.app_window_params.window_title = TITLE
    runner.app_window_params.window_geometry.size = size
    runner.app_window_params.restore_previous_geometry = bench.remember
    runner.ini_disable = not bench.remember
    runner.ini_folder_type = hello_imgui.IniFolderType.app_user_config_folder
    runner.ini_filename = f"{TITLE}/window.ini"
    runner.ini_filename_use_app_window_title = False
    runner.fps_idling.fps_idle = 2.0
    runner.fps_idling.time_active_after_last_event = 0.5
    runner.fps_idling.fps_max = 120.0
    runner.renderer_backend_options.open_gl_options.anti_aliasing_samples = 0

    window = runner.imgui_window_params
    window.default_imgui_window_type = hello_imgui.DefaultImGuiWindowType.provide_full_screen_dock_space
    window.show_menu_bar = True
    window.show_menu_app = window.show_menu_view = False
    window.show_status_bar, window.show_status_fps, window.remember_status_bar_settings = True, False, False
    window.remember_theme = False
    window.config_windows_move_from_title_bar_only = True

    call = runner.callbacks
    call.load_additional_fonts = theme.load_font
    call.setup_imgui_style = theme.style_imgui
    call.post_init = bench.opened
    call.before_exit = bench.closed
    call.show_menus = bench.guarded("Menus", lambda: menus(bench))
    call.show_status = bench.guarded("Status", bench.draw_status)
    call.show_gui = bench.guarded("Frame", bench.begin)
    call.post_render_dockable_windows = bench.guarded("Dialogs", lambda: (bench.draw_dialogs(), bench.end())[0])
    call.before_swap = bench.guarded("Screenshot", bench.shoot)

    runner.docking_params.docking_splits = layout(*size, theme.FONT_SIZE)
    runner.docking_params.dockable_windows = [
        _panel("Controls", "Left", bench, bench.draw_controls),
        _panel("Read-outs", "LeftBottom", bench, bench.draw_readouts),
        _panel("Section", "Bottom", bench, bench.draw_section, own_begin=True),
        _panel("Circle of confusion", "Right", bench, bench.draw_confusion),
        _panel("Exit pupil", "RightBottom", bench, bench.draw_pupil),
        _panel("Render", "MainDockSpace", bench, bench.draw_render, own_begin=True),
    ]
    return runner


def _panel(label: str, dock: str, bench: Bench, draw: Callable[[], None],
           own_begin: bool = False) -> hello_imgui.DockableWindow:
    panel = hello_imgui.DockableWindow(label, dock, draw if own_begin else bench.guarded(label, draw),
                                       can_be_closed_=False)
    panel.call_begin_end = not own_begin
    panel.remember_is_visible = bench.remember
    panel.imgui_window_flags = imgui.WindowFlags_.no_collapse
    return panel


def without_display() -> None:
    """Have the next window made on no display, by GLFW's null platform and EGL. Call it before every such window."""
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
    glfw.init()
    glfw.window_hint(glfw.CONTEXT_CREATION_API, glfw.EGL_CONTEXT_API)


def run(settings: Settings, screenshot: Path | str | None = None) -> int:
    """Open the bench and return when it is closed; with `screenshot`, on no display, save a picture of it and return.

    OSError where the screenshot cannot be written.
    """
    bench = Bench(settings, remember=screenshot is None)
    runner = parameters(bench)
    add_ons = immapp.AddOnsParams(with_implot=True)
    if screenshot is None:
        immapp.run(runner, add_ons)
        return 0

    # Until there are samples enough, then one frame more
    path, began = Path(screenshot), monotonic()
    without_display()
    runner.fps_idling.enable_idling = False
    runner.fps_idling.fps_max = 30.0

    def watch() -> None:
        if bench.shots_taken or monotonic() - began > 2.0 * SCREENSHOT_SECONDS:
            runner.app_shall_exit = True
        elif bench.settled(SCREENSHOT_SAMPLES) or monotonic() - began > SCREENSHOT_SECONDS:
            bench.photograph(path)

    runner.callbacks.after_swap = watch
    immapp.run(runner, add_ons)
    if not bench.shots_taken:
        raise OSError(f"{path}: {bench.view.messages[-1] if bench.view.messages else 'no screenshot was taken'}")
    return 0
