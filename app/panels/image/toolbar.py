"""The row of tools above the picture: zoom, overlays, views, comparison and the render, with their menus.

Tools that the row has no room for are in the menu “…” at its end; the size of the picture always has its place.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.display.frame import Picture, View
from lensbench.app.panels.image.magnifier import toggle_magnifier
from lensbench.app.panels.image.menu import comparison_menu, picture_menu, view_menu
from lensbench.app.state.picture.look_around import LookAround
from lensbench.app.state.request import Request
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.kernels.figures import fixed

fa = icons_fontawesome_6


BETWEEN, GAP = 2.0, 12.0        # pixels at a scale of 1: between two tools, and before a group of them
MORE = "More tools"


@dataclass(frozen=True)
class Tool:
    """One tool. name: of its item. label: what the row shows; title and key: what the menu “…” shows.

    press: called on a click, with the present settings; returns the changed ones. menu: draws the tool's own menu,
    `width` em wide, into an open popup, instead. gap: the tool begins a group.
    """

    name: str
    label: str
    title: str
    key: str
    tip: str
    on: bool
    press: Callable[[Settings], Settings] | None = None
    menu: Callable[[Settings], Settings] | None = None
    width: float = 0.0
    gap: bool = False


def picture_tools(settings: Settings, picture: Picture, view: View) -> Settings:
    """Draw the row; returns the settings after the changes of its tools."""
    corner, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    height, pixel = round(theme.em(1.9)), theme.scale()
    tools = [*_size_tools(view), *_looking_tools(settings, view), *_render_tools(picture, view)]
    widths = [_width(tool.label) + (GAP if tool.gap else BETWEEN) * pixel for tool in tools]
    room = width - 8.0 * pixel
    size, size_width = _size_text(settings, picture, room - sum(widths))
    shown = len(tools)
    if sum(widths) + size_width > room:
        room -= _width(fa.ICON_FA_ELLIPSIS) + BETWEEN * pixel
        while shown and sum(widths[:shown]) + size_width > room:
            shown -= 1
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 8.0 * pixel, corner.y + round(0.5 * (height - theme.em(1.45)))))
    for tool in tools[:shown]:
        settings = _in_row(tool, settings)
    if shown < len(tools):
        settings = _more(tools[shown:], settings)
    settings = _picture_size(settings, view, size, (corner, width, height))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    imgui.dummy(ImVec2(0.0, 0.0))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    return settings


# The tools


def _size_tools(view: View) -> list[Tool]:
    """The zoom of the picture."""
    def fit(settings: Settings) -> Settings:
        view.zoom, view.centre = None, (0.5, 0.5)
        return settings

    def whole_pixels(settings: Settings) -> Settings:
        view.zoom = 1.0
        return settings

    return [
        Tool("Fit", fa.ICON_FA_EXPAND + "  Fit", "Show the whole picture", "F", "Show the whole picture (F)",
             view.zoom is None, fit),
        Tool("100 %", "100 %", "100 %", "1", "One pixel of the picture for one of the screen (1)\n"
             "Ctrl + wheel zooms, Ctrl + drag moves the picture", view.zoom is not None and abs(view.zoom - 1) < 1e-6,
             whole_pixels)]


def _looking_tools(settings: Settings, view: View) -> list[Tool]:
    """Click to focus, overlays, histogram, magnifier, views, comparison."""
    def focus_pick(given: Settings) -> Settings:
        view.focus_pick, view.pin_pick = not view.focus_pick, False
        return given

    def pin_pick(given: Settings) -> Settings:
        view.pin_pick, view.focus_pick = not view.pin_pick, view.pin_pick
        return given

    def overlay(key: str) -> Callable[[Settings], Settings]:
        return lambda given: replace(given, overlay="none" if given.overlay == key else key)

    def histogram(given: Settings) -> Settings:
        view.histogram = not view.histogram
        return given

    def magnifier(given: Settings) -> Settings:
        toggle_magnifier(view)
        return given

    def look(given: Settings) -> Settings:
        view.look = None if view.look is not None else LookAround()
        return given

    panorama = [Tool("Look around", fa.ICON_FA_STREET_VIEW, "Look around", "", "Look around inside the panorama: drag "
                     "to turn, wheel for the angle of view, double click to look ahead", view.look is not None, look,
                     gap=True)] if settings.kind.panorama else []
    return [
        *panorama,
        Tool("Focus pick", fa.ICON_FA_CROSSHAIRS, "A click focuses", "", "Click in the picture to focus there\n\n"
             "Drag to orbit about the point in focus, Shift or right drag to pan, wheel to dolly", view.focus_pick,
             focus_pick, gap=True),
        Tool("Pin pixel", fa.ICON_FA_THUMBTACK, "A click pins a pixel", "", "Click in the picture to pin a pixel: its "
             "rays stay in the section, the exit pupil,\nthe plan and the panel “Pixel”. Another click or Escape "
             "unpins it\n\nWithout this tool: Alt + click, or I with the mouse on the pixel", view.pin_pick, pin_pick),
        *(Tool(name, icon, name, key, f"{tip} ({key})", settings.overlay == kind, overlay(kind))
          for icon, kind, name, key, tip in (
              (fa.ICON_FA_HIGHLIGHTER, "peaking", "Focus peaking", "P", "Focus peaking: edges in focus are amber"),
              (fa.ICON_FA_BULLSEYE, "coc", "CoC overlay", "C", "Circle of confusion in pixels as false colour: amber "
               "in focus, blue before it, pink behind it"),
              (fa.ICON_FA_CIRCLE_HALF_STROKE, "clipping", "Clipping", "Z",
               "Clipping: stripes where the picture is fully white (orange) or black (blue)"))),
        Tool("Histogram", fa.ICON_FA_CHART_AREA, "Histogram", "H", "Histogram of the tone-mapped picture (H)",
             view.histogram, histogram),
        Tool("Magnifier", fa.ICON_FA_MAGNIFYING_GLASS, "Magnifier", "M", "Magnifier at the mouse, with the values of "
             "the pixels (M)\nAlt + wheel magnifies more or less; the last step writes a grid of numbers",
             view.magnifier > 0, magnifier),
        Tool("Views", fa.ICON_FA_LAYER_GROUP, "Views of the samples", "V",
             "The picture, or another quantity of its samples (V)", settings.view != "picture", menu=view_menu,
             width=12.0),
        Tool("Compare", fa.ICON_FA_CODE_COMPARE, "Compare", "", "Compare two settings: keep the picture as A (A),\n"
             "then side by side (S), by a wipe (W), or their difference (D)", settings.compare != "off",
             menu=lambda given: comparison_menu(given, view.pinned, view), width=15.0)]


def _render_tools(picture: Picture, view: View) -> list[Tool]:
    """Pause, restart, screenshot and export."""
    def asks(request: Request) -> Callable[[Settings], Settings]:
        def press(settings: Settings) -> Settings:
            view.requests.add(request)
            return settings
        return press

    paused = picture.paused
    return [
        Tool("Pause", fa.ICON_FA_PLAY if paused else fa.ICON_FA_PAUSE, "Go on rendering" if paused else "Pause",
             "Space", "Go on rendering (Space)" if paused else "Pause the render (Space)", paused,
             asks(Request.PAUSE), gap=True),
        Tool("Restart", fa.ICON_FA_ROTATE_LEFT, "Restart the render", "R", "Restart the render (R)", False,
             asks(Request.RESTART)),
        Tool("Screenshot", fa.ICON_FA_CAMERA, "Save the picture as it is now", "Ctrl+S",
             "Save the picture as it is now, with its settings (Ctrl + S)", False, asks(Request.SAVE_RENDER)),
        Tool("Export", fa.ICON_FA_FLOPPY_DISK, "Export…", "Ctrl+E",
             "Export at any size and number of samples (Ctrl + E)", False, asks(Request.EXPORT))]


# The row


def _in_row(tool: Tool, settings: Settings) -> Settings:
    """A tool as a flat button; returns the settings after its changes."""
    if tool.gap:
        imgui.same_line(0.0, GAP * theme.scale())
    if _button(f"{tool.label}###{tool.name}", tool.tip, tool.on):
        if tool.menu is not None:
            imgui.open_popup(f"{tool.name} menu")
        elif tool.press is not None:
            settings = tool.press(settings)
    if tool.menu is not None and _below_button(f"{tool.name} menu", tool.width):
        settings = tool.menu(settings)
        imgui.end_popup()
    return settings


def _more(tools: list[Tool], settings: Settings) -> Settings:
    """The menu of the tools without room; returns the settings after their changes."""
    if _button(f"{fa.ICON_FA_ELLIPSIS}###{MORE}", "More tools", any(tool.on for tool in tools)):
        imgui.open_popup(f"{MORE} menu")
    if not _below_button(f"{MORE} menu", 0.0):
        return settings
    for i, tool in enumerate(tools):
        if tool.gap and i:
            imgui.separator()
        text, icon = f"{tool.title}###{tool.name}", tool.label.split()[0] if tool.label != tool.title else ""
        if tool.menu is not None:
            if imgui.internal.begin_menu_ex(text, icon):
                settings = tool.menu(settings)
                imgui.end_menu()
        elif imgui.internal.menu_item_ex(text, icon, tool.key, tool.on) and tool.press is not None:
            settings = tool.press(settings)
        imgui.set_item_tooltip(tool.tip)
    imgui.end_popup()
    return settings


def _size_text(settings: Settings, picture: Picture, room: float) -> tuple[str, float]:
    """Size, samples and time of the picture, as much of it as fits; and the width of its button in pixels."""
    of = picture.recorded or settings
    texts = [f"{of.pixels_x} × {of.pixels_y}"]
    if picture.recorded is None:
        samples = f"{picture.samples} of " if picture.texture else ""
        texts.insert(0, f"{texts[-1]}     {samples}{settings.samples} samples")
        if picture.texture:
            texts.insert(0, f"{texts[0]}     {_seconds(picture.seconds)}")
    texts = [f"{text}  {fa.ICON_FA_ANGLE_DOWN}" for text in texts]
    theme.small()
    widths = [_width(text) + GAP * theme.scale() for text in texts]
    imgui.pop_font()
    chosen = next((i for i, width in enumerate(widths) if width <= room), len(texts) - 1)
    return texts[chosen], widths[chosen]


def _picture_size(settings: Settings, view: View, text: str, row: tuple[ImVec2, float, float]) -> Settings:
    """Size, samples and tone curve at the right, as a list with an angle; a click opens their menu.

    row: upper left corner, width and height of the row of tools.
    """
    (corner, width, height), pixel = row, theme.scale()
    theme.small()
    imgui.set_cursor_screen_pos(ImVec2(max(corner.x + width - _width(text) - 5.0 * pixel, corner.x),
                                       corner.y + round(0.5 * (height - imgui.get_frame_height()))))
    pressed = _button(f"{text}###Picture size", "Pixels, samples a pixel, tone curve", False)
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


def _below_button(popup: str, width: float) -> bool:
    """Begin the popup, `width` em wide or as wide as its text, below the button just drawn, if it is open."""
    lower = imgui.get_item_rect_min().x, imgui.get_item_rect_max().y
    imgui.set_next_window_pos(ImVec2(lower[0], lower[1] + 4.0 * theme.scale()), imgui.Cond_.appearing)
    imgui.set_next_window_size(ImVec2(theme.em(width), 0.0))
    return imgui.begin_popup(popup)


def _button(label: str, tooltip: str, on: bool) -> bool:
    """A flat button of the row; on: it is drawn as switched on."""
    colour = theme.colours()
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame if on else (0.0, 0.0, 0.0, 0.0))))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
    clicked = imgui.button(label)
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tooltip)
    imgui.same_line(0.0, BETWEEN * theme.scale())
    return clicked


def _width(label: str) -> float:
    """Width of a button with this label, in pixels."""
    return imgui.calc_text_size(label).x + 2.0 * imgui.get_style().frame_padding.x


def _seconds(seconds: float) -> str:
    return f"{fixed(seconds, 1)} s" if seconds < 60.0 else f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"
