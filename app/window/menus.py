"""The menus, and the sheet of keys and gestures."""

from collections.abc import Sequence
from pathlib import Path

from imgui_bundle import ImVec2, hello_imgui, icons_fontawesome_6, imgui

from lensbench.app.bench.lens_choice import TRIALS
from lensbench.app.drawing import theme
from lensbench.app.panels.image.overlays import toggle_magnifier
from lensbench.app.session.edited_lens import reverted
from lensbench.app.session.notices import Request
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.commands import (
    COMMANDS, GESTURES, quit_window, redo, reset_all, reset_camera, toggle_pin, try_this, undo
)
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import WindowState
from lensbench.lenses import WRITERS

SHEET = "Keys and mouse"


def menus(state: WindowState) -> None:
    """File, Edit, View and Help in the menu bar."""
    for name, content in (("File", _file_menu), ("Edit", _edit_menu), ("View", _view_menu), ("Help", _help_menu)):
        if imgui.begin_menu(name):
            content(state)
            imgui.end_menu()
    mark = icons_fontawesome_6.ICON_FA_CIRCLE_QUESTION
    imgui.set_cursor_pos_x(imgui.get_window_width() - imgui.calc_text_size(mark).x
                           - 2.0 * imgui.get_style().item_spacing.x)
    if imgui.menu_item(f"{mark}###Terms", "", False)[0]:
        state.requests.add(Request.SHOW_TERMS)
    imgui.set_item_tooltip("What the terms mean: P, E, T-stop, CoC, …")


def _file_menu(state: WindowState) -> None:
    history = state.history
    if _item("Lens browser…", "L"):
        state.requests.add(Request.BROWSE_LENSES)
    for name, request, key in (("Open lens…", Request.OPEN_LENS, "Ctrl+O"), ("Open scene…", Request.OPEN_SCENE, ""),
                               ("Open picture…", Request.OPEN_PICTURE, ""),
                               ("Open settings…", Request.OPEN_SETTINGS, ""),
                               ("Open light field…", Request.OPEN_LIGHT_FIELD, "")):
        if _item(name, key):
            state.requests.add(request)
    if imgui.begin_menu("Recent", bool(state.recent)):
        for path in list(state.recent):
            if _item(_short(path)):
                state.reopened = path
            imgui.set_item_tooltip(str(path))
        imgui.end_menu()
    imgui.separator()
    if _item("Save lens…", enabled=history.present.has_lens):
        state.requests.add(Request.SAVE_LENS)
    imgui.set_item_tooltip(f"The suffix sets the format: {' '.join(WRITERS)}")
    if _item("Save edits of the lens", "Ctrl+Shift+S", bool(history.present.edited)):
        state.requests.add(Request.SAVE_EDITED)
    imgui.set_item_tooltip("Into the file that the lens was opened from; a lens of the library gets a file of its own")
    if _item("Revert the lens", "", bool(history.present.edited)):
        state.take(reverted(state.edited))
    imgui.set_item_tooltip("Take back all edits of its surfaces; Undo brings them back")
    if _item("Save settings…"):
        state.requests.add(Request.SAVE_SETTINGS)
    if _item("Export…", "Ctrl+E"):
        state.requests.add(Request.EXPORT)
    if _item("Screenshot of render…", "Ctrl+S"):
        state.requests.add(Request.SAVE_RENDER)
    if _item("Screenshot of window…"):
        state.requests.add(Request.SAVE_WINDOW)
    imgui.separator()
    if _item("Quit", "Ctrl+Q"):
        quit_window(state)


def _edit_menu(state: WindowState) -> None:
    history = state.history
    if _item("Undo", "Ctrl+Z", history.can_undo):
        undo(state)
    if _item("Redo", "Ctrl+Shift+Z", history.can_redo):
        redo(state)
    imgui.separator()
    if _item("Command palette…", "Ctrl+K"):
        state.requests.add(Request.SHOW_PALETTE)
    if _item("Reset all"):
        reset_all(state)


def _view_menu(state: WindowState) -> None:
    runner = hello_imgui.get_runner_params()
    panels = runner.docking_params.dockable_windows
    if imgui.begin_menu("Layout"):
        for name, layout in LAYOUTS.items():
            if _item(name, "", True, state.layout == name):
                state.choose_layout(name)
            imgui.set_item_tooltip(layout.about)
        imgui.end_menu()
    if imgui.begin_menu("Analysis"):
        _panels([panel for panel in panels if panel.label in PANELS])
        imgui.end_menu()
    _panels([panel for panel in panels if panel.label not in (*PANELS, "Render")])
    imgui.separator()
    if _item("Pin pixel", "I", state.view.links.pinned is not None or state.view.pointed is not None,
             state.view.links.pinned is not None):
        toggle_pin(state)
    imgui.set_item_tooltip("Keep the pixel that the mouse was on last: its rays stay in the section, the exit pupil, "
                           "the plan and the panel “Pixel”")
    if _item("Magnifier", "M", True, state.view.magnifier > 0):
        toggle_magnifier(state.view)
    imgui.set_item_tooltip("Magnify the pixels at the mouse, with their values; Alt + wheel sets the magnification")
    if _item("Reset camera", "Home"):
        reset_camera(state)
    imgui.set_item_tooltip("To where the scene opens: framed and focused on its subject, where it states one")
    imgui.separator()
    if _item("Dark theme", "", True, state.dark):
        state.choose_theme(True)
    if _item("Light theme", "", True, not state.dark):
        state.choose_theme(False)
    imgui.separator()
    if _item("Reset layout"):
        state.requests.add(Request.RESET_LAYOUT)
    imgui.set_item_tooltip("Every panel of the layout back in its place, for the present size of the window; otherwise "
                           "each layout keeps the places that its panels were given")


def _panels(panels: list[hello_imgui.DockableWindow]) -> None:
    """Show and hide panels; one that is shown comes to the front of its dock."""
    for panel in panels:
        if _item(panel.label, "", True, panel.is_visible):
            panel.is_visible = not panel.is_visible
            panel.focus_window_at_next_frame = panel.is_visible


def _help_menu(state: WindowState) -> None:
    if _item("Keys and mouse", "F1"):
        state.requests.add(Request.SHOW_HELP)
    if _item("What the terms mean"):
        state.requests.add(Request.SHOW_TERMS)
    imgui.separator()
    imgui.text_disabled("Try this")
    for trial in TRIALS:
        if _item(trial.title):
            try_this(state, trial)
        imgui.set_item_tooltip(trial.about)


def _item(name: str, key: str = "", enabled: bool = True, checked: bool = False) -> bool:
    return imgui.menu_item(name, key, checked, enabled)[0]


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
        for command in COMMANDS:
            if command.group:
                groups.setdefault(command.group, []).append((command.keys, command.name))
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
