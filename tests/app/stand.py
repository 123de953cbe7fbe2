"""A window on no display in which a test shows one panel and drives it with a real mouse and keyboard."""

from collections.abc import Callable

from imgui_bundle import ImVec2, hello_imgui, imgui, immapp
from imgui_bundle.immapp import testing

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.drawing import theme
from lensbench.app.drawing.dial import DialState, use_dials


def drive(gui: Callable[[], None], test: Callable, size: tuple[int, int] = (400, 300), picture: str | None = None,
          dark: bool = True) -> None:
    """Show `gui` in a bare window of this size, let `test(ctx)` use it, and fail where either fails.

    An error in the panel or in the test is raised here, after the window has closed.
    """
    glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
    glfw.init()
    glfw.window_hint(glfw.CONTEXT_CREATION_API, glfw.EGL_CONTEXT_API)
    errors: list[BaseException] = []
    use_dials(DialState())

    def guarded() -> None:
        if errors:
            return
        try:
            imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*theme.colours().panel))
            gui()
            imgui.pop_style_color()
        except Exception as error:
            errors.append(error)
            raise

    def tested(ctx) -> None:
        try:
            test(ctx)
            if picture is not None:
                testing.capture(ctx, picture)
        except Exception as error:
            errors.append(error)

    def opened() -> None:
        theme.style_implot()
        imgui.get_io().config_flags |= imgui.ConfigFlags_.nav_enable_keyboard

    parameters = hello_imgui.RunnerParams()
    parameters.app_window_params.window_geometry.size = size
    parameters.ini_disable = True
    parameters.fps_idling.enable_idling = False
    parameters.callbacks.show_gui = guarded
    parameters.callbacks.load_additional_fonts = theme.load_font
    parameters.callbacks.setup_imgui_style = lambda: theme.style_imgui(dark)
    parameters.callbacks.post_init = opened
    parameters.imgui_window_params.default_imgui_window_type = (
        hello_imgui.DefaultImGuiWindowType.provide_full_screen_window)
    parameters.imgui_window_params.tweaked_theme = hello_imgui.ImGuiTweakedTheme(hello_imgui.ImGuiTheme_.darcula)
    parameters.app_window_params.window_geometry.window_size_state = hello_imgui.WindowSizeState.standard
    parameters.renderer_backend_options.request_float_buffer = False
    testing.run(test_function=tested, runner_params=parameters, add_ons_params=immapp.AddOnsParams(
        with_implot=True))
    if errors:
        raise errors[0]


def centre(ctx, ref: str) -> ImVec2:
    """Where the middle of an item is on the screen."""
    box = ctx.item_info(ref).rect_full
    return ImVec2(0.5 * (box.min.x + box.max.x), 0.5 * (box.min.y + box.max.y))
