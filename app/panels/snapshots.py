"""The panel *Snapshots*: a film strip of kept pictures, each with its settings, to open, compare and share.

A click opens one. The badge A of one and a click on another compare them; marked ones become one sheet or animation.

The progress of a background task, with Cancel: the same in every panel and dialog.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from imgui_bundle import ImVec2, icons_fontawesome_6, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, same_row_if_room, toggles, two_lines
from lensbench.app.panels.action_names import tip_of
from lensbench.app.session.snapshots import Snapshot
from lensbench.app.settings.setting_table import COMPARISONS
from lensbench.app.workers.task import Task
from lensbench.core.text import fixed


def task_progress(task: Task, width: float = 0.0) -> None:
    """Draw a bar with the task's description and progress, and a button that cancels it.

    width: of both in pixels; 0 for the rest of the line.
    """
    width = (width or imgui.get_content_region_avail().x) - theme.em(2.4)
    imgui.push_style_color(imgui.Col_.plot_histogram, imgui.ImVec4(*theme.colours().frame_active))
    imgui.progress_bar(task.progress, ImVec2(width, 0.0),
                       f"{task.description}  "
                       f"{fixed(100.0 * task.progress, 0)} %" if task.progress else task.description)
    imgui.pop_style_color()
    imgui.same_line()
    if imgui.button(icons_fontawesome_6.ICON_FA_XMARK + "###Cancel task"):
        task.cancel()
    imgui.set_item_tooltip("Cancel")


OPEN, COMPARE, TEXT, COPY, CARD, REMOVE, KEEP, PASTE, SHEET = (
    "open", "compare", "text", "copy", "card", "remove", "keep", "paste", "sheet")
MENU = (
    (OPEN, "Open", "Apply its settings (undo to go back)"),
    (COMPARE, "Compare as A", "Show it next to the current picture; then click another snapshot to compare the two"),
    (TEXT, "Copy as text", "A short text for a message: paste it here, or open it by lensbench view TEXT"),
    (COPY, "Copy picture", "Copy it to the clipboard"),
    (CARD, "Card…", "One picture with the section of the lens and the settings"),
)
COMPARE_TIP = "Compare A with the current picture: click another snapshot to make it the current one"


@dataclass
class SnapshotsState:
    """State of the panel between frames: the snapshot that is renamed, its new name, and the chosen action.

    reference: the snapshot that is A. marked: for a sheet or an animation, in the order of the marks.
    """

    renamed: Snapshot | None = None
    text: str = ""
    begins: bool = False
    action: tuple[str, Snapshot | None] | None = None
    new_name: tuple[Snapshot, str] | None = None
    reference: Snapshot | None = None
    marked: list[Snapshot] = field(default_factory=list)

    def mark(self, snapshot: Snapshot) -> None:
        """Mark a snapshot, or take its mark away."""
        self.marked = [one for one in self.marked if one is not snapshot] if snapshot in self.marked else [
            *self.marked, snapshot]

    def replace(self, before: Snapshot, after: Snapshot | None) -> None:
        """A snapshot has another name, or is gone."""
        self.reference = after if self.reference is before else self.reference
        self.marked = [snapshot for one in self.marked if (snapshot := after if one is before else one) is not None]


def snapshots_panel(snapshots: list[Snapshot], state: SnapshotsState, compare: str,
                    texture: Callable[[Snapshot], tuple[int, tuple[int, int]] | None]) -> str:
    """Draw the strip; what the user asks for is left in the state. Returns the chosen comparison.

    compare: of the current picture with A, a key of COMPARISONS. texture: GL name and size of a thumbnail.
    """
    if imgui.button(f"{fa.ICON_FA_PLUS}  Keep snapshot###Keep"):
        state.action = KEEP, None
    imgui.set_item_tooltip(tip_of("Keep snapshot"))
    imgui.same_line()
    if imgui.button("Paste"):
        state.action = PASTE, None
    imgui.set_item_tooltip(tip_of("Paste state"))
    if not snapshots:
        paragraph("No snapshots yet. A snapshot is a picture with its settings, kept for later sessions.")
        return compare
    same_row_if_room(9.0)
    if imgui.button(f"{fa.ICON_FA_TABLE_CELLS}  Save {len(state.marked) or 'all'} together…###Sheet"):
        state.action = SHEET, None
    imgui.set_item_tooltip("Save the marked snapshots, or all, as one picture (PNG, JPEG) or one after the other "
                           "(GIF, WebP).\nCtrl+click marks one")
    if state.reference is not None:
        same_row_if_room(17.0)
        compare = toggles("Compare", COMPARISONS, compare, dict.fromkeys(COMPARISONS, COMPARE_TIP), 0.0)
    imgui.begin_child("Shelf", ImVec2(0.0, 0.0), imgui.ChildFlags_.none, imgui.WindowFlags_.horizontal_scrollbar)
    names = 2.0 * imgui.get_text_line_height() + theme.em(1.2)
    room, x = imgui.get_content_region_avail(), 0.0
    height = min(max(room.y - names, theme.em(3.0)), theme.em(9.0))
    is_strip = room.y < 2.0 * (height + names)                  # one row; a higher panel has several
    if is_strip and imgui.is_window_hovered() and imgui.get_io().mouse_wheel:
        imgui.set_scroll_x(imgui.get_scroll_x() - theme.em(6.0) * imgui.get_io().mouse_wheel)
    for i, snapshot in enumerate(snapshots):
        down, across = snapshot.thumbnail.shape[:2]
        width = height * across / down
        if i and (is_strip or x + width < room.x):
            imgui.same_line()
        else:
            x = 0.0
        x += width + imgui.get_style().item_spacing.x
        _snapshot(snapshot, i + 1, state, texture(snapshot), ImVec2(width, height))
    imgui.end_child()
    return compare


def _badge(name: str, text: str, tip: str, corner: ImVec2, on: bool) -> bool:
    """A small button over a thumbnail; whether it was clicked. corner: the upper left one on the screen."""
    after = imgui.get_cursor_screen_pos()
    imgui.set_cursor_screen_pos(corner)
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0.0, 0.0, 0.0, 0.85 if on else 0.55))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(1.0, 1.0, 1.0, 1.0 if on else 0.75))
    clicked = imgui.button(f"{text}###{name}", ImVec2(theme.em(1.35), theme.em(1.35)))
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tip)
    imgui.set_cursor_screen_pos(after)
    return clicked


def _badges(snapshot: Snapshot, state: SnapshotsState, hovered: bool, corner: ImVec2, width: float) -> None:
    """The badges in the upper right corner: A, and the mark."""
    is_a, is_marked = state.reference is snapshot, snapshot in state.marked
    x = corner.x + width - theme.em(1.5)
    if (hovered or is_a) and _badge(f"A {snapshot.name}", "A", "Make it A: a click on another snapshot then compares "
                                    "the two", ImVec2(x, corner.y + theme.em(0.15)), is_a):
        state.action = COMPARE, snapshot
    if (hovered or is_marked) and _badge(f"Mark {snapshot.name}", fa.ICON_FA_CHECK, "Mark it for a sheet or an "
                                         "animation (Ctrl+click)", ImVec2(x - theme.em(1.5), corner.y + theme.em(0.15)),
                                         is_marked):
        state.mark(snapshot)


def _snapshot(snapshot: Snapshot, number: int, state: SnapshotsState, shown: tuple[int, tuple[int, int]] | None,
              size: ImVec2) -> None:
    """One thumbnail with its number and name; a click opens it, the right button its menu."""
    imgui.push_id(str(snapshot.path))
    imgui.begin_group()
    corner = imgui.get_cursor_screen_pos()
    imgui.set_next_item_allow_overlap()
    if imgui.invisible_button(f"Snapshot {snapshot.name}", size):
        if imgui.get_io().key_ctrl:
            state.mark(snapshot)
        else:
            state.action = OPEN, snapshot
    hovered = imgui.is_mouse_hovering_rect(corner, ImVec2(corner.x + size.x, corner.y + size.y)) \
        and imgui.is_window_hovered(imgui.HoveredFlags_.allow_when_blocked_by_active_item)      # as by a badge
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    if shown is not None:
        draw.add_image(imgui.ImTextureRef(shown[0]), corner, end)
    if hovered:
        draw.add_rect(corner, end, theme.packed(theme.colours().strong), 0.0, theme.scale())
    if snapshot in state.marked:
        draw.add_rect(corner, end, theme.packed(theme.colours().strong), 0.0, 2.5 * theme.scale())
    key = f" (Alt+{number})" if number < 10 else ""
    imgui.set_item_tooltip(f"{snapshot.name}\nClick to open{key}, right click to compare, share, rename or remove")
    if imgui.begin_popup_context_item("Menu"):
        for action, name, tip in MENU:
            if imgui.menu_item(name, "", False)[0]:
                state.action = action, snapshot
            imgui.set_item_tooltip(tip)
        imgui.separator()
        if imgui.menu_item("Rename", "", False)[0]:
            state.renamed, state.text, state.begins = snapshot, snapshot.name, True
        if imgui.menu_item("Remove", "", False)[0]:
            state.action = REMOVE, snapshot
        imgui.set_item_tooltip("Delete the file of this snapshot")
        imgui.end_popup()
    _badges(snapshot, state, hovered, corner, size.x)
    if state.renamed is snapshot:
        _rename(snapshot, state, size.x)
    else:
        theme.small()
        for text in two_lines(f"{number}  {snapshot.name}" if number < 10 else snapshot.name, size.x):
            imgui.text_disabled(text)
        imgui.pop_font()
    imgui.end_group()
    imgui.pop_id()


def _rename(snapshot: Snapshot, state: SnapshotsState, width: float) -> None:
    """The name as a text field: Enter takes it, Escape or a click elsewhere leaves the old one."""
    imgui.set_next_item_width(max(width, theme.em(7.0)))
    if state.begins:
        imgui.set_keyboard_focus_here()
    entered, state.text = imgui.input_text("##New name", state.text, imgui.InputTextFlags_.enter_returns_true)
    if entered:
        state.new_name, state.renamed = (snapshot, state.text), None
    elif not state.begins and imgui.is_item_deactivated():
        state.renamed = None
    state.begins = False
