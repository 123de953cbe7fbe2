"""The window on its screen: full screen, and back to its place."""

from imgui_bundle.glfw_utils import glfw_window_hello_imgui

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.window.state import WindowState


def switch_full_screen(state: WindowState) -> None:
    """Fill the screen that shows most of the window, or give the window its former place and size."""
    window = glfw_window_hello_imgui()
    if state.full_screen is not None:
        glfw.set_window_monitor(window, None, *state.full_screen, glfw.DONT_CARE)
        state.full_screen = None
        return
    left, top = glfw.get_window_pos(window)
    width, height = glfw.get_window_size(window)
    shown = []
    for i, monitor in enumerate(glfw.get_monitors()):
        (x, y), mode = glfw.get_monitor_pos(monitor), glfw.get_video_mode(monitor)
        across = min(left + width, x + mode.size.width) - max(left, x)
        down = min(top + height, y + mode.size.height) - max(top, y)
        shown.append((max(across, 0) * max(down, 0), -i, monitor, mode))
    if not shown:
        state.view.say("The system names no screen to fill", note=True)
        return
    _, _, monitor, mode = max(shown, key=lambda screen: screen[:2])
    state.full_screen = left, top, width, height
    glfw.set_window_monitor(window, monitor, 0, 0, mode.size.width, mode.size.height, mode.refresh_rate)
