"""The menu bar, the sheet of keys and gestures, and the status bar."""

import math
from collections.abc import Callable, Sequence

from imgui_bundle import ImVec2, hello_imgui, icons_fontawesome_6, imgui

from lensbench.app.bench.auto_model import choice_details, choice_summary
from lensbench.app.bench.build import design
from lensbench.app.bench.lens_choice import TRIALS
from lensbench.app.display.frame import View
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import explain, paragraph
from lensbench.app.panels.action_names import COMPARISON, DIALS, key_of
from lensbench.app.panels.controls.controls import lens_name
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.app.window.actions import ACTIONS
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import SCALES, WindowState
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.app.workers.task import Task
from lensbench.core.text import fixed, significant

SHEET = "Keys and mouse"
REST = "More of the render popup"
GESTURES = (                    # of the mouse, for the sheet of keys
    ("Click in the picture", "focus there"),
    ("Drag · wheel", "orbit about the point in focus · dolly"),
    ("Shift+drag, right drag", "pan"),
    ("Ctrl+wheel · Ctrl+drag", "zoom the picture · move it"),
    ("Alt+click · Escape", "pin a pixel, to follow its rays · unpin it"),
    ("Alt+wheel", "magnification of the magnifier"),
    ("On a dial", "drag, click, wheel; Ctrl+click types, double click resets"),
    ("In a plot", "drag to pan, wheel to zoom, double click to fit"),
    ("In the table of surfaces", "drag, click or Enter, Ctrl+arrows; Insert, Delete, Alt+arrows; right click"),
    ("Among the snapshots", "click or Alt+1 to Alt+9 open, the badge A and a click compare, Ctrl+click marks"),
    ("In the lens browser", "click or arrows try, Enter keeps, Escape returns"),
)


def menus(state: WindowState) -> None:
    """File, Edit, View and Help in the menu bar."""
    for name, items in MENUS.items():
        if imgui.begin_menu(name):
            for item in items:
                if callable(item):
                    item(state)
                elif item:
                    _item(item, state)
                else:
                    imgui.separator()
            imgui.end_menu()
    mark = icons_fontawesome_6.ICON_FA_CIRCLE_QUESTION
    imgui.set_cursor_pos_x(imgui.get_window_width() - imgui.calc_text_size(mark).x
                           - 2.0 * imgui.get_style().item_spacing.x)
    if imgui.menu_item(f"{mark}###Terms", "", False)[0]:
        state.requests.add(Request.SHOW_TERMS)
    imgui.set_item_tooltip("What the terms mean: P, E, T-stop, CoC, …")


def _item(name: str, state: WindowState, title: str = "") -> None:
    """The menu item of an action. title: shown instead of the name of the action."""
    action = ACTIONS[name]
    if imgui.menu_item(title or name, "" if title else key_of(name), action.checked(state), action.enabled(state))[0]:
        action.run(state)
    if action.tip:
        imgui.set_item_tooltip(action.tip)


def _recent(state: WindowState) -> None:
    if imgui.begin_menu("Recent", bool(state.recent)):
        for path in list(state.recent):
            name = path.name if len(path.name) <= 40 else f"{path.name[:20]}…{path.name[-18:]}"
            if imgui.menu_item(name, "", False)[0]:
                state.reopened = path
            imgui.set_item_tooltip(str(path))
        imgui.end_menu()


def _layouts(state: WindowState) -> None:
    if imgui.begin_menu("Layout"):
        for name in LAYOUTS:
            _item(f"Layout: {name}", state, name)
        imgui.end_menu()


def _scales(state: WindowState) -> None:
    if imgui.begin_menu("Scale"):
        for title in SCALES.values():
            _item(f"Scale: {title}", state, title)
        imgui.end_menu()


def _themes(state: WindowState) -> None:
    if imgui.begin_menu("Theme"):
        _item("Dark theme", state)
        _item("Light theme", state)
        imgui.end_menu()


def _panels(state: WindowState) -> None:
    """Show and hide panels, those for analysis in a menu of their own; one that is shown comes to the front."""
    panels = {panel.label: panel for panel in hello_imgui.get_runner_params().docking_params.dockable_windows}
    grouped = {*PANELS, *(name for group in GROUPS for name in group), "Render"}
    if imgui.begin_menu("Panels"):
        for i, group in enumerate((*GROUPS, [name for name in panels if name not in grouped])):
            if i and group:
                imgui.separator()
            _switches([panels[name] for name in group])
        imgui.end_menu()
    if imgui.begin_menu("Analysis"):
        _switches([panel for name, panel in panels.items() if name in PANELS])
        imgui.end_menu()


def _switches(panels: list[hello_imgui.DockableWindow]) -> None:
    for panel in panels:
        if imgui.menu_item(panel.label, "", panel.is_visible)[0]:
            panel.is_visible = not panel.is_visible
            panel.focus_window_at_next_frame = panel.is_visible


def _trials(state: WindowState) -> None:
    imgui.text_disabled("Try this")
    for trial in TRIALS:
        _item(f"Try this: {trial.title}", state, trial.title)


SEPARATOR = ""
GROUPS = (                      # of panels: lens and camera, drawings, what a point becomes, methods
    ("Controls", "Read-outs", "Lens card", "Surfaces"), ("Section", "Plan", "3-D"),
    ("Circle of confusion", "Exit pupil", "Falloff", "Pixel"), ("Spaces", "Models", "Stability"),
    ("Light field", "Snapshots"))
MENUS: dict[str, tuple[str | Callable[[WindowState], None], ...]] = {
    "File": ("Lens browser…", "Open…", _recent, "Adjust scene…", SEPARATOR, "Save lens…", "Save lens edits",
             "Revert lens", "Save scene as…", "Save settings…", "Export…", "Save picture…", "Save screenshot…",
             "Contact sheet…", SEPARATOR, "Quit"),
    "Edit": ("Undo", "Redo", SEPARATOR, "Command palette…", "Improve lens…", "Reset all"),
    "View": (_layouts, _panels, "Reset layout", SEPARATOR, "Hide panels", "Full screen", _scales, _themes, SEPARATOR,
             "Fit picture", "Zoom to 100 %", "Render follows window", SEPARATOR, "Magnifier", "Pin pixel",
             "Make these sharp", "Reset camera"),
    "Help": ("Keys and mouse", "What the terms mean", SEPARATOR, _trials)}


class Help:
    """The sheet of keys and mouse."""

    def __init__(self) -> None:
        self._open = False

    def open(self) -> None:
        """Show the sheet from the next `draw` on."""
        self._open = True

    def draw(self, drawn_by: str = "") -> None:
        """Call it in every frame. drawn_by: a sentence about what draws the window."""
        if self._open:
            imgui.open_popup(SHEET)
            self._open = False
        viewport = imgui.get_main_viewport()
        wide = viewport.work_size.x > theme.em(62.0)
        centre_next(60.0 if wide else 32.0)
        imgui.set_next_window_size_constraints(ImVec2(0.0, 0.0), ImVec2(viewport.work_size.x, 0.94 * viewport.size.y))
        shown, _ = imgui.begin_popup_modal(SHEET, True, imgui.WindowFlags_.no_saved_settings
                                           | imgui.WindowFlags_.no_resize)
        if not shown:
            return
        groups: dict[str, list[tuple[str, str]]] = {}
        for action in ACTIONS.values():
            if action.group:
                groups.setdefault(action.group, []).append((action.keys, action.name.removesuffix("…")))
        groups = {"Mouse": list(GESTURES), **groups}
        columns = [[group for group in groups.items() if group[0] in ("Mouse", COMPARISON, DIALS)],
                   [group for group in groups.items() if group[0] not in ("Mouse", COMPARISON, DIALS)]]
        columns = columns if wide else [columns[0] + columns[1]]
        if imgui.begin_table("Keys", len(columns)):
            for column in columns:
                imgui.table_next_column()
                for title, rows in column:
                    _keys(title, rows)
            imgui.end_table()
        imgui.separator()
        from importlib.metadata import version

        imgui.text_disabled(f"lensbench {version('lensbench')}. Lenses, cameras, their rays and their pictures.")
        if drawn_by:
            imgui.text_disabled(drawn_by)
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()


def _keys(title: str, rows: Sequence[tuple[str, str]]) -> None:
    """One group of the sheet."""
    imgui.text_colored(imgui.ImVec4(*theme.colours().strong), title)
    for keys, what in rows:
        imgui.text_disabled(keys)
        imgui.same_line(theme.em(11.0))
        paragraph(what[0].lower() + what[1:] if what[1:2].islower() else what, True)
    imgui.dummy(ImVec2(0.0, theme.em(0.4)))


def status_bar(settings: Settings, update: RenderUpdate | None, view: View, drawn_by: str = "",
               background: Task | None = None, brief: bool = False) -> None:
    """Draw into the bar that hello_imgui has begun.

    drawn_by: the software renderer; "": a graphics card draws. background: the export or the opening under way.
    brief: samples, time and model, with the rest in a popup.
    """
    colour, dot = theme.colours(), theme.em(0.9)
    theme.small()
    corner = imgui.get_cursor_screen_pos()
    width = imgui.get_window_width()
    window = imgui.get_window_pos()
    y = window.y + round(0.5 * (imgui.get_window_height() - imgui.get_text_line_height()))
    draw = imgui.get_window_draw_list()

    # From the right: the lens, and the pixel under the mouse
    left, right = window.x + theme.em(0.78), window.x + width - theme.em(0.9)
    if background is not None:
        imgui.set_cursor_screen_pos(ImVec2(left, y - imgui.get_style().frame_padding.y))
        task_progress(background, min(theme.em(26.0), 0.5 * width))
        left += min(theme.em(26.0), 0.5 * width) + dot
    summary = choice_summary(update.choice, update.speeds) if update is not None and update.choice is not None else []
    parts = [summary[0] if summary else settings.camera_title, *_progress(update, drawn_by)]
    rest = [*parts, *summary[1:], _lens(settings)]
    if brief:
        model = update.choice.model if summary and update is not None else settings.camera_title
        parts = [*([parts[1], f"{fixed(update.seconds, 1)} s"] if update is not None else []),
                 "traced" if model == "trace" else model]
    separator = 2.0 * dot + imgui.calc_text_size("·").x
    needed = sum(imgui.calc_text_size(text).x for text in parts) + separator * len(parts)
    texts = [] if brief else [_lens(settings)]
    raster = view.links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is not None and update is not None and update.depth is not None:
        texts.append(_pointed(settings, raster, update, view.links.pinned is not None))
    for text in filter(None, texts):
        extent = imgui.calc_text_size(text).x
        if right - extent < left + needed:
            break
        right -= extent
        draw.add_text(ImVec2(round(right), y), theme.packed(colour.dim), text)
        right -= 3.0 * dot

    # From the left: model, samples, speed; of an automatic model also its error, its gain and the refused models
    x = left
    for i, text in enumerate(parts if brief else [*parts, *summary[1:]]):
        if i:
            if right - x < separator + theme.em(3.0):
                break
            draw.add_text(ImVec2(round(x + dot), y), theme.packed(colour.faint), "·")
            x += separator
        text = theme.shortened(text, right - x)
        draw.add_text(ImVec2(round(x), y), theme.packed(colour.strong if i == 0 else colour.dim), text)
        x += imgui.calc_text_size(text).x
    if brief:
        _rest(ImVec2(x + dot, y), list(filter(None, rest)))
    elif summary:
        imgui.set_cursor_screen_pos(ImVec2(left, y))
        imgui.invisible_button("Automatic model", ImVec2(x - left, imgui.get_text_line_height()))
        assert update is not None
        imgui.set_item_tooltip(choice_details(update.choice, update.speeds))
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(ImVec2(1.0, imgui.get_text_line_height()))
    imgui.pop_font()


def _rest(corner: ImVec2, lines: list[str]) -> None:
    """The button of what a brief bar leaves out, and its popup above it."""
    imgui.set_cursor_screen_pos(corner)
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.0))
    if imgui.small_button(f"{icons_fontawesome_6.ICON_FA_CARET_RIGHT}###More of the render"):
        imgui.open_popup(REST)
    imgui.pop_style_color()
    explain("Model, speed and lens in full")
    imgui.set_next_window_pos(ImVec2(imgui.get_item_rect_min().x, imgui.get_item_rect_min().y - theme.em(0.4)),
                              imgui.Cond_.always, ImVec2(0.0, 1.0))
    if imgui.begin_popup(REST):
        for line in lines:
            imgui.text_unformatted(f"{line[:1].upper()}{line[1:]}")
        imgui.end_popup()


def _progress(update: RenderUpdate | None, drawn_by: str) -> list[str]:
    """Samples and speeds."""
    frames = f"{fixed(hello_imgui.frame_rate(), 0)} fps" + (f" by {drawn_by}" if drawn_by else "")
    if update is None:
        return [frames]
    samples = f"{update.samples} sample{'s' if update.samples > 1 else ''}"
    return [samples, *([speed_text(update.rate)] if update.rate > 0.0 else []), frames]


def speed_text(rate: float) -> str:
    """A rate of samples a second: 0.043, 4.2 or 134 Msamples/s."""
    millions = rate / 1e6
    return f"{fixed(millions, 0) if millions >= 9.95 else significant(millions, 2)} Msamples/s"


def _lens(settings: Settings) -> str:
    if not settings.has_lens:
        return ""
    try:
        surfaces = len(design(settings).surfaces)
    except (ValueError, OSError):
        return lens_name(settings)
    return f"{lens_name(settings)}: {surfaces} surfaces"


def _pointed(settings: Settings, raster: tuple[float, float], update: RenderUpdate, pinned: bool) -> str:
    """The pixel under the mouse, or the pinned one: the distance and the blur of what it shows."""
    assert update.depth is not None
    x, y = int(raster[0]), int(raster[1])
    rows, columns = update.depth.shape
    if (columns, rows) != (settings.pixels_x, settings.pixels_y):       # a coarse picture of a drag
        return ""
    if not (0 <= y < rows and 0 <= x < columns):
        return ""
    depth = float(update.depth[y, x])
    where = f"{'Pinned ' if pinned else ''}({x}, {y})  {'no light' if math.isnan(depth) else format_distance(depth)}"
    try:
        blur = pixel_readings(settings, raster).pixels
    except (ValueError, OSError):               # the panel “Pixel” says why
        return where
    return where if blur is None else f"{where}  CoC {significant(blur, 2)} px"
