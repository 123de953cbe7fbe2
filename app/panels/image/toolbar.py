"""The row of tools above the picture: zoom, overlays, views, comparison and the render, with their menus."""

from dataclasses import replace

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.display.frame import Picture, View
from lensbench.app.panels.image.magnifier import toggle_magnifier
from lensbench.app.panels.image.menu import comparison_menu, picture_menu, view_menu
from lensbench.app.state.request import Request
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.kernels.figures import fixed

fa = icons_fontawesome_6


def picture_tools(settings: Settings, picture: Picture, view: View) -> Settings:
    """Draw the row; returns the settings after the changes of its tools."""
    corner, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    height = round(theme.em(1.9))
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 8.0 * theme.scale(),
                                       corner.y + round(0.5 * (height - theme.em(1.45)))))
    _size_tools(view)
    _gap()
    settings = _looking_tools(settings, view)
    imgui.same_line(0.0, 2.0 * theme.scale())
    _gap()
    _render_tools(picture, view)
    settings = _picture_size(settings, picture, view, (corner, width, height))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    imgui.dummy(ImVec2(0.0, 0.0))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    return settings


def _size_tools(view: View) -> None:
    """The zoom of the picture."""
    if _tool(fa.ICON_FA_EXPAND + "  Fit###Fit", "Show the whole picture (F)", view.zoom is None):
        view.zoom, view.centre = None, (0.5, 0.5)
    if _tool("100 %###100 %", "One pixel of the picture for one of the screen (1)\n"
             "Ctrl + wheel zooms, Ctrl + drag moves the picture", view.zoom is not None and abs(view.zoom - 1) < 1e-6):
        view.zoom = 1.0


def _looking_tools(settings: Settings, view: View) -> Settings:
    """Click to focus, overlays, histogram, views, comparison; returns the settings as chosen."""
    if _tool(fa.ICON_FA_CROSSHAIRS + "###Focus pick", "Click in the picture to focus there\n\n"
             "Drag to orbit about the point in focus, Shift or right drag to pan, wheel to dolly", view.focus_pick):
        view.focus_pick, view.pin_pick = not view.focus_pick, False
    if _tool(fa.ICON_FA_THUMBTACK + "###Pin pixel", "Click in the picture to pin a pixel: its rays stay in the "
             "section, the exit pupil,\nthe plan and the panel “Pixel”. Another click or Escape unpins it\n\n"
             "Without this tool: Alt + click, or I with the mouse on the pixel", view.pin_pick):
        view.pin_pick, view.focus_pick = not view.pin_pick, view.pin_pick
    for icon, key, name, tooltip in (
            (fa.ICON_FA_HIGHLIGHTER, "peaking", "Focus peaking", "Focus peaking: edges in focus are amber (P)"),
            (fa.ICON_FA_BULLSEYE, "coc", "CoC overlay",
             "Circle of confusion in pixels as false colour: amber in focus, blue before it, pink behind it (C)"),
            (fa.ICON_FA_CIRCLE_HALF_STROKE, "clipping", "Clipping",
             "Clipping: stripes where the picture is fully white (orange) or black (blue) (Z)")):
        if _tool(f"{icon}###{name}", tooltip, settings.overlay == key):
            settings = replace(settings, overlay="none" if settings.overlay == key else key)
    if _tool(fa.ICON_FA_CHART_AREA + "###Histogram", "Histogram of the tone-mapped picture (H)", view.histogram):
        view.histogram = not view.histogram
    if _tool(fa.ICON_FA_MAGNIFYING_GLASS + "###Magnifier", "Magnifier at the mouse, with the values of the pixels (M)\n"
             "Alt + wheel magnifies more or less; the last step writes a grid of numbers", view.magnifier > 0):
        toggle_magnifier(view)
    if _tool(fa.ICON_FA_LAYER_GROUP + "###Views", "The picture, or another quantity of its samples (V)",
             settings.view != "picture"):
        imgui.open_popup("View menu")
    if _below_tool("View menu", 12.0):
        settings = view_menu(settings)
        imgui.end_popup()
    if _tool(fa.ICON_FA_CODE_COMPARE + "###Compare", "Compare two settings: keep the picture as A (A),\n"
             "then side by side (S), by a wipe (W), or their difference (D)", settings.compare != "off"):
        imgui.open_popup("Comparison menu")
    if _below_tool("Comparison menu", 15.0):
        settings = comparison_menu(settings, view.pinned, view)
        imgui.end_popup()
    return settings


def _render_tools(picture: Picture, view: View) -> None:
    """Pause, restart, screenshot and export."""
    if _tool((fa.ICON_FA_PLAY if picture.paused else fa.ICON_FA_PAUSE) + "###Pause",
             "Go on rendering (Space)" if picture.paused else "Pause the render (Space)", picture.paused):
        view.requests.add(Request.PAUSE)
    if _tool(fa.ICON_FA_ROTATE_LEFT + "###Restart", "Restart the render (R)", False):
        view.requests.add(Request.RESTART)
    if _tool(fa.ICON_FA_CAMERA + "###Screenshot", "Save the picture as it is now, with its settings (Ctrl + S)", False):
        view.requests.add(Request.SAVE_RENDER)
    if _tool(fa.ICON_FA_FLOPPY_DISK + "###Export", "Export at any size and number of samples (Ctrl + E)", False):
        view.requests.add(Request.EXPORT)


def _picture_size(settings: Settings, picture: Picture, view: View, row: tuple[ImVec2, float, float]) -> Settings:
    """Size, samples and tone curve at the right, as a list with an angle; a click opens their menu.

    row: upper left corner, width and height of the row of tools.
    """
    (corner, width, height), pixel = row, theme.scale()
    left = imgui.get_item_rect_max().x + 12.0 * pixel
    theme.small()
    of = picture.recorded or settings
    texts = [f"{of.pixels_x} × {of.pixels_y}"]
    if picture.recorded is None:
        samples = f"{picture.samples} of " if picture.texture else ""
        texts.insert(0, f"{texts[-1]}     {samples}{settings.samples} samples")
        if picture.texture:
            texts.insert(0, f"{texts[0]}     {_seconds(picture.seconds)}")
    room = corner.x + width - left - 2.0 * imgui.get_style().frame_padding.x
    mark = f"  {fa.ICON_FA_ANGLE_DOWN}"
    text = next((text + mark for text in texts if imgui.calc_text_size(text + mark).x <= room), fa.ICON_FA_ELLIPSIS)
    extent = imgui.calc_text_size(text).x + 2.0 * imgui.get_style().frame_padding.x
    imgui.set_cursor_screen_pos(ImVec2(max(corner.x + width - extent - 5.0 * pixel, left),
                                       corner.y + round(0.5 * (height - imgui.get_frame_height()))))
    pressed = _tool(f"{text}###Picture size", "Pixels, samples a pixel, tone curve", False)
    imgui.pop_font()
    if pressed:
        imgui.open_popup("Picture menu")
    lower = imgui.get_item_rect_max()
    imgui.set_next_window_pos(ImVec2(lower.x, lower.y + 4.0 * pixel), imgui.Cond_.appearing, ImVec2(1.0, 0.0))
    imgui.set_next_window_size(ImVec2(theme.em(24.0), 0.0))
    if imgui.begin_popup("Picture menu"):
        settings = picture_menu(settings, view)
        imgui.end_popup()
    return settings


def _below_tool(popup: str, width: float) -> bool:
    """Begin the popup, `width` em wide, below the tool just drawn, if it is open."""
    lower = imgui.get_item_rect_min().x, imgui.get_item_rect_max().y
    imgui.set_next_window_pos(ImVec2(lower[0], lower[1] + 4.0 * theme.scale()), imgui.Cond_.appearing)
    imgui.set_next_window_size(ImVec2(theme.em(width), 0.0))
    return imgui.begin_popup(popup)


def _seconds(seconds: float) -> str:
    return f"{fixed(seconds, 1)} s" if seconds < 60.0 else f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"


def _tool(label: str, tooltip: str, on: bool) -> bool:
    """A flat button of the row; on: it is drawn as switched on."""
    colour = theme.colours()
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame if on else (0.0, 0.0, 0.0, 0.0))))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
    clicked = imgui.button(label)
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tooltip)
    imgui.same_line(0.0, 2.0 * theme.scale())
    return clicked


def _gap() -> None:
    imgui.same_line(0.0, 10.0 * theme.scale())
