"""The menus, and the sheet of keys and gestures."""

from collections.abc import Callable, Sequence
from pathlib import Path

from imgui_bundle import ImVec2, hello_imgui, icons_fontawesome_6, imgui

from lensbench.app.bench.lens_choice import TRIALS
from lensbench.app.drawing import theme
from lensbench.app.panels.action_names import key_of
from lensbench.app.session.notices import Request
from lensbench.app.window.actions import ACTIONS
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import WindowState

SHEET = "Keys and mouse"
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
            if imgui.menu_item(_short(path), "", False)[0]:
                state.reopened = path
            imgui.set_item_tooltip(str(path))
        imgui.end_menu()


def _layouts(state: WindowState) -> None:
    if imgui.begin_menu("Layout"):
        for name in LAYOUTS:
            _item(f"Layout: {name}", state, name)
        imgui.end_menu()


def _panels(state: WindowState) -> None:
    """Show and hide panels, those for analysis in a menu of their own; one that is shown comes to the front."""
    panels = hello_imgui.get_runner_params().docking_params.dockable_windows
    if imgui.begin_menu("Analysis"):
        _switches([panel for panel in panels if panel.label in PANELS])
        imgui.end_menu()
    _switches([panel for panel in panels if panel.label not in (*PANELS, "Render")])


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
MENUS: dict[str, tuple[str | Callable[[WindowState], None], ...]] = {
    "File": ("Lens browser…", "Open lens…", "Open scene…", "Open picture…", "Open settings…", "Open light field…",
             _recent, SEPARATOR, "Save lens…", "Save lens edits", "Revert lens", "Save settings…", "Export…",
             "Save picture…", "Save screenshot…", SEPARATOR, "Quit"),
    "Edit": ("Undo", "Redo", SEPARATOR, "Command palette…", "Reset all"),
    "View": (_layouts, _panels, SEPARATOR, "Pin pixel", "Magnifier", "Reset camera", SEPARATOR, "Dark theme",
             "Light theme", SEPARATOR, "Reset layout"),
    "Help": ("Keys and mouse", "What the terms mean", SEPARATOR, _trials)}


def _short(path: Path) -> str:
    return path.name if len(path.name) <= 40 else f"{path.name[:20]}…{path.name[-18:]}"


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
        names = list(groups)
        columns = ([[("Mouse", list(GESTURES)), *((name, groups[name]) for name in names[1:3])],
                    [(name, groups[name]) for name in names if name not in names[1:3]]] if wide else
                   [[("Mouse", list(GESTURES)), *groups.items()]])
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
        imgui.push_text_wrap_pos(0.0)
        imgui.text_unformatted(what[0].lower() + what[1:] if what[1:2].islower() else what)
        imgui.pop_text_wrap_pos()
    imgui.dummy(ImVec2(0.0, theme.em(0.4)))
