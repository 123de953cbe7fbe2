"""The row of tools above the picture: zoom, overlays, views, comparison and the render, with their menus.

Tools that the row has no room for are in the menu “…” at its end; the size of the picture always has its place.

The menus of the render's tools: size and look of the picture, its views, and the comparison.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.pose import LookAround
from lensbench.app.display.frame import Picture, View
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, explain
from lensbench.app.panels.action_names import ACTION_NAMES, key_of, tip_of
from lensbench.app.panels.image.overlays import toggle_magnifier, toggle_sharp_pick
from lensbench.app.session.notices import Request
from lensbench.app.settings.setting_table import COMPARISONS, TONES, VIEWS
from lensbench.app.settings.settings import Settings
from lensbench.core.text import fixed

LONGER_SIDES = (480, 640, 960, 1280, 1920, 2880)
SAMPLES = (16, 64, 256, 1024, 4096)
VIEW_TIPS = {
    "picture": "The light that the camera sees",
    "direction": "The direction d of the rays in the world as a colour, (d + 1) / 2",
    "origin": "Where the rays leave the lens",
    "fate": "Rays from all over the rear element: white where they arrive in the scene, grey where the stop blocks "
            "them, another colour where another surface or total reflection does",
    "time": "When between the opening and the closing of the shutter each sample is taken",
    "depth": "How near each thing is: white for the nearest, black for the sky",
    "weight": "What the camera lets through to each place: cos⁴, vignetting and the pupil's size",
}
COMPARISON_ACTIONS = {"off": "", "side": "Compare side by side", "wipe": "Compare with a wipe",
                      "difference": "Show difference"}
KEEP = imgui.SelectableFlags_.no_auto_close_popups


def picture_menu(settings: Settings, view: View) -> Settings:
    """Draw the menu into the popup that is open; the settings as chosen."""
    chosen = settings
    _label("Pixels", True, 0, 6.0)
    if _choice("As the window shows", view.follows, 12.0):
        view.follows = True
    imgui.set_item_tooltip("One pixel of the picture for each of the screen; fewer while something is dragged,\n"
                           "if a picture would take too long")
    for i, longer in enumerate(LONGER_SIDES):
        _label("", i % 3 == 0, i % 3, 6.0)
        sized = with_longer_side(settings, longer)
        same = (sized.pixels_x, sized.pixels_y) == (settings.pixels_x, settings.pixels_y) and not view.follows
        if _choice(f"{sized.pixels_x} × {sized.pixels_y}", same, 5.6):
            chosen, view.follows = sized, False
    imgui.separator()
    for i, samples in enumerate(SAMPLES):
        _label("Samples", i == 0, i, 3.0)
        if _choice(f"{samples}", samples == settings.samples, 2.6):
            chosen = replace(settings, samples=samples)
    traced = check_box("Light tracing", settings.light_tracing)
    if traced != settings.light_tracing:
        chosen = replace(settings, light_tracing=traced)
    imgui.set_item_tooltip("Trace lamps, lit windows and what mirrors, panes and balls show of them from the light\n"
                           "to the film, so that their blur is smooth in the first frame. Off: the camera's rays\n"
                           "have to find them, which comes to the same picture later")
    imgui.separator()
    for i, (key, name) in enumerate(TONES.items()):
        _label("Tone", i == 0, i, 4.6)
        if _choice(f"{name}###{key}", key == settings.tone, 4.2):
            chosen = replace(settings, tone=key)
    return chosen


def view_menu(settings: Settings) -> Settings:
    """Draw the menu of the views into the open popup; returns the settings as chosen."""
    for key, name in VIEWS.items():
        if imgui.selectable(f"{name}###{key}", key == settings.view)[0]:
            settings = replace(settings, view=key)
        imgui.set_item_tooltip(VIEW_TIPS[key])
    return settings


def comparison_menu(settings: Settings, pinned: Settings | None, view: View) -> Settings:
    """Draw the menu of the comparison into the open popup; returns the settings as chosen.

    pinned: the settings of the picture A; None if there is none.
    """
    if imgui.menu_item("Pin picture as A", key_of("Pin picture as A"), False)[0]:
        view.requests.add(Request.PIN)
    imgui.set_item_tooltip(ACTION_NAMES["Pin picture as A"].tip)
    imgui.separator()
    for key, action in COMPARISON_ACTIONS.items():
        if imgui.menu_item(f"{action or COMPARISONS[key]}###{key}", key_of(action) if action else "",
                           key == settings.compare, pinned is not None)[0]:
            settings = replace(settings, compare=key)
        imgui.set_item_tooltip(ACTION_NAMES[action].tip if action else "Show the current picture alone")
    imgui.separator()
    lock = "Lock A's dials to B"
    if imgui.menu_item(lock, key_of(lock), view.locked, pinned is not None)[0]:
        view.locked = not view.locked
    imgui.set_item_tooltip(ACTION_NAMES[lock].tip)
    if imgui.menu_item("Apply A's settings", "", False, pinned is not None)[0] and pinned is not None:
        settings = replace(pinned, compare=settings.compare, wipe=settings.wipe, overlay=settings.overlay)
    imgui.set_item_tooltip("Apply all settings of the picture A (undo to go back)")
    return settings


def _label(text: str, first: bool, column: int, width: float) -> None:
    """Begin a row with its label, or go on in its next column."""
    if first:
        imgui.text_disabled(text)
    imgui.same_line(theme.em(5.0 + column * width))


def _choice(label: str, chosen: bool, width: float) -> bool:
    return imgui.selectable(label, chosen, KEEP, ImVec2(theme.em(width), 0.0))[0]


fa = icons_fontawesome_6


BETWEEN, GAP = 0.0, 9.0        # pixels at a scale of 1: between two tools, and before a group of them
MORE = "More tools"


@dataclass(frozen=True)
class Tool:
    """One tool. name: of its item. label: what the row shows; title and key: what the menu “…” shows.

    press: called on a click, with the current settings; returns the changed ones. menu: draws the tool's own menu,
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

    return [_tool("Fit", fa.ICON_FA_EXPAND + "  Fit", "Fit picture", view.zoom is None, fit),
            _tool("100 %", "100 %", "Zoom to 100 %", view.zoom is not None and abs(view.zoom - 1) < 1e-6, whole_pixels)]


def _looking_tools(settings: Settings, view: View) -> list[Tool]:
    """Click to focus, overlays, histogram, magnifier, views, comparison."""
    def focus_pick(current: Settings) -> Settings:
        view.focus_pick, view.pin_pick, view.sharp_pick = not view.focus_pick, False, False
        return current

    def pin_pick(current: Settings) -> Settings:
        view.pin_pick, view.focus_pick, view.sharp_pick = not view.pin_pick, view.pin_pick, False
        return current

    def sharp_pick(current: Settings) -> Settings:
        toggle_sharp_pick(view)
        return current

    def overlay(key: str) -> Callable[[Settings], Settings]:
        return lambda current: replace(current, overlay="none" if current.overlay == key else key)

    def histogram(current: Settings) -> Settings:
        view.histogram = not view.histogram
        return current

    def magnifier(current: Settings) -> Settings:
        toggle_magnifier(view)
        return current

    def look(current: Settings) -> Settings:
        view.look = None if view.look is not None else LookAround()
        return current

    panorama = [replace(_tool("Look around", fa.ICON_FA_STREET_VIEW, "Look around", view.look is not None, look),
                        gap=True)] if settings.kind.panorama else []
    return [
        *panorama,
        Tool("Focus pick", fa.ICON_FA_CROSSHAIRS, "A click focuses", "", "Click in the picture to focus there\n\n"
             "Drag to orbit about the point in focus, Shift or right drag to pan, wheel to dolly", view.focus_pick,
             focus_pick, gap=True),
        _tool("Sharp pick", fa.ICON_FA_DRAW_POLYGON, "Make these sharp", view.sharp_pick, sharp_pick),
        Tool("Pin pixel", fa.ICON_FA_THUMBTACK, "A click pins a pixel", "", "Click in the picture to pin a pixel: its "
             "rays stay in the section, the exit pupil,\nthe plan and the panel “Pixel”. Another click or Escape "
             "unpins it\n\nWithout this tool: Alt+click, or I with the mouse on the pixel", view.pin_pick, pin_pick),
        *(_tool(name, icon, action, settings.overlay == kind, overlay(kind)) for name, icon, action, kind in (
            ("Focus peaking", fa.ICON_FA_HIGHLIGHTER, "Focus peaking", "peaking"),
            ("CoC overlay", fa.ICON_FA_BULLSEYE, "Circle of confusion", "coc"),
            ("Plane of focus", fa.ICON_FA_CLONE, "Plane of focus", "plane"),
            ("Clipping", fa.ICON_FA_CIRCLE_HALF_STROKE, "Clipping", "clipping"))),
        _tool("Histogram", fa.ICON_FA_CHART_AREA, "Histogram", view.histogram, histogram),
        _tool("Magnifier", fa.ICON_FA_MAGNIFYING_GLASS, "Magnifier", view.magnifier > 0, magnifier),
        Tool("Views", fa.ICON_FA_LAYER_GROUP, "Views of the samples", "V",
             "The picture, or another quantity of its samples (V)", settings.view != "picture", menu=view_menu,
             width=12.0),
        Tool("Compare", fa.ICON_FA_CODE_COMPARE, "Compare", "", "Compare two settings: pin the picture as the "
             "reference A (A), then choose\nside by side (S), a wipe (W), or the difference (D)",
             settings.compare != "off",
             menu=lambda current: comparison_menu(current, view.pinned, view), width=16.0)]


def _render_tools(picture: Picture, view: View) -> list[Tool]:
    """Pause, restart, save and export."""
    def request(request: Request) -> Callable[[Settings], Settings]:
        def press(settings: Settings) -> Settings:
            view.requests.add(request)
            return settings
        return press

    pause = _tool("Pause", fa.ICON_FA_PLAY if picture.paused else fa.ICON_FA_PAUSE, "Pause", picture.paused,
                  request(Request.PAUSE))
    return [replace(pause, title="Resume" if picture.paused else "Pause", gap=True),
            _tool("Restart", fa.ICON_FA_ROTATE_LEFT, "Restart render", False, request(Request.RESTART)),
            _tool("Screenshot", fa.ICON_FA_CAMERA, "Save picture…", False, request(Request.SAVE_RENDER)),
            _tool("Export", fa.ICON_FA_FLOPPY_DISK, "Export…", False, request(Request.EXPORT))]


def _tool(name: str, label: str, action: str, on: bool, press: Callable[[Settings], Settings]) -> Tool:
    """The tool of an action, with the name, the key and the tooltip that the menus show."""
    return Tool(name, label, action, key_of(action), tip_of(action), on, press)


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
    explain(tooltip)
    imgui.same_line(0.0, BETWEEN * theme.scale())
    return clicked


def _width(label: str) -> float:
    """Width of a button with this label, in pixels."""
    return imgui.calc_text_size(label).x + 2.0 * imgui.get_style().frame_padding.x


def _seconds(seconds: float) -> str:
    return f"{fixed(seconds, 1)} s" if seconds < 60.0 else f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"
