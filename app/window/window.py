"""The window, on a display or, for a screenshot, on none."""

from pathlib import Path
from time import monotonic

from imgui_bundle import hello_imgui, immapp

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.drawing import theme
from lensbench.app.settings.settings import Settings
from lensbench.app.window.bars import menus
from lensbench.app.window.session import Session

TITLE = "lensbench"
SIZE = (1280, 720)
OPENGL = 3, 3                       # the least that draws the picture
IDLE_PACE = 2.0                     # frames a second at rest
SCREENSHOT_SAMPLES = 64
SCREENSHOT_SECONDS = 120.0          # after this time the screenshot is taken as the window is


def parameters(session: Session, size: tuple[int, int] = SIZE) -> hello_imgui.RunnerParams:
    """Everything that hello_imgui needs to run the window."""
    runner = hello_imgui.RunnerParams()
    runner.app_window_params.window_title = TITLE
    runner.app_window_params.window_geometry.size = size
    runner.app_window_params.restore_previous_geometry = session.remember
    runner.ini_disable = not session.remember
    runner.ini_folder_type = hello_imgui.IniFolderType.app_user_config_folder
    runner.ini_filename = f"{TITLE}/window.ini"
    runner.ini_filename_use_app_window_title = False
    runner.fps_idling.fps_idle = IDLE_PACE
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

    def end() -> None:
        session.dialogs()
        session.end()

    call, guarded = runner.callbacks, session.panels.docking.guarded
    call.load_additional_fonts = theme.load_font
    call.setup_imgui_style = lambda: theme.style_imgui(session.dark)
    call.post_init = session.opened
    call.before_exit = session.closed
    call.show_menus = guarded("Menus", lambda: menus(session))
    call.show_status = guarded("Status", session.panels.status)
    call.show_gui = guarded("Frame", session.begin)
    call.post_render_dockable_windows = guarded("Dialogs", end)
    call.before_imgui_render = session.presenter.finish
    call.before_swap = guarded("Screenshot", session.drawn)

    session.folding.first(runner, session.panels.windows(), (*size, theme.FONT_SIZE))
    return runner


def without_display() -> None:
    """Create the next window on no display, by GLFW's null platform and EGL; call it before each such window."""
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
    glfw.init()
    glfw.window_hint(glfw.CONTEXT_CREATION_API, glfw.EGL_CONTEXT_API)


def show(runner: hello_imgui.RunnerParams) -> None:
    """Show a window until it is closed; OSError where the driver's OpenGL is too old for it.

    Frame by frame: `immapp.run` of imgui's Python package first looks for the sources of all its callers, which takes
    a quarter of a second.
    """
    try:
        immapp.manual_render.setup_from_runner_params(runner, immapp.AddOnsParams(with_implot=True))
    except RuntimeError as error:                   # an assertion of its C++
        offered = _opengl_version()
        if offered is not None and offered >= OPENGL:
            raise
        has = "none" if offered is None else "{}.{}".format(*offered)
        raise OSError("the window needs OpenGL {}.{}, and this driver offers {}: install a newer one; "
                      "`lensbench render` needs none".format(*OPENGL, has)) from error
    try:
        while not runner.app_shall_exit:
            immapp.manual_render.render()
    finally:
        immapp.manual_render.tear_down()


def _opengl_version() -> tuple[int, int] | None:
    """The OpenGL that the driver offers a window without demands; None where it makes none."""
    if not glfw.init():
        return None
    glfw.default_window_hints()
    glfw.window_hint(glfw.VISIBLE, False)
    if glfw.get_platform() == glfw.PLATFORM_NULL:
        glfw.window_hint(glfw.CONTEXT_CREATION_API, glfw.EGL_CONTEXT_API)
    window = glfw.create_window(16, 16, TITLE, None, None)
    if not window:
        return None
    return (glfw.get_window_attrib(window, glfw.CONTEXT_VERSION_MAJOR),
            glfw.get_window_attrib(window, glfw.CONTEXT_VERSION_MINOR))


def run(settings: Settings, screenshot: Path | str | None = None, follows: bool = False,
        opened: Path | None = None, file: str = "") -> int:
    """Open the window, return when it is closed: 0, or 1 if the picture was not ready in time for the screenshot.

    screenshot: open it on no display, save a picture of it there, and return; OSError if it cannot be written.
    OSError too where the driver's OpenGL is too old.
    follows: the picture has as many pixels as the window shows of it, and not those of the settings. opened: a file
    that is opened in the first frame, as by *Open…*. file: what has set the pixels of a picture that does not follow.
    """
    session = Session(settings, remember=screenshot is None)
    session.view.follows, session.reopened = follows, opened
    if file and screenshot is None:
        session.say_locked(file, settings)
    try:
        runner = parameters(session)
        if screenshot is not None:
            without_display()
            _photograph(session, runner, Path(screenshot))
        show(runner)
    finally:
        session.compilers.stop()
        session.worker.stop()
        session.compilers.leave()
    if screenshot is not None and session.shot_problem:
        raise OSError(session.shot_problem)
    return int(session.shot_is_early)


def _photograph(session: Session, runner: hello_imgui.RunnerParams, path: Path) -> None:
    """Take the screenshot when there are enough samples or time is up, then close the window."""
    runner.fps_idling.enable_idling = False
    runner.fps_idling.fps_max = 30.0
    end = monotonic() + SCREENSHOT_SECONDS

    def watch() -> None:
        if session.shots_taken or session.shot_problem:
            runner.app_shall_exit = True
        elif session.settled(SCREENSHOT_SAMPLES) or monotonic() > end:
            session.shot_is_early = not session.settled(1)
            session.photograph(path)

    runner.callbacks.after_swap = watch
