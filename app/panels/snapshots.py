"""The panel *Snapshots*: a shelf of kept pictures, each with its settings, to open, compare and share.

The progress of a background task, with Cancel: the same in every panel and dialog.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from imgui_bundle import ImVec2, icons_fontawesome_6, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, two_lines
from lensbench.app.panels.action_names import tip_of
from lensbench.app.session.snapshots import Snapshot
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


OPEN, COMPARE, TEXT, COPY, CARD, REMOVE, KEEP, PASTE = (
    "open", "compare", "text", "copy", "card", "remove", "keep", "paste")
MENU = (
    (OPEN, "Open", "Apply its settings (undo to go back)"),
    (COMPARE, "Compare as A", "Show it next to the current picture"),
    (TEXT, "Copy as text", "A short text for a message: paste it here, or open it by lensbench view TEXT"),
    (COPY, "Copy picture", "Copy it to the clipboard"),
    (CARD, "Card…", "One picture with the section of the lens and the settings"),
)


@dataclass
class SnapshotsState:
    """State of the panel between frames: the snapshot that is renamed, its new name, and the chosen action."""

    renamed: Snapshot | None = None
    text: str = ""
    begins: bool = False
    action: tuple[str, Snapshot | None] | None = None
    new_name: tuple[Snapshot, str] | None = None
    sizes: dict[str, tuple[int, int]] = field(default_factory=dict)


def snapshots_panel(snapshots: list[Snapshot], state: SnapshotsState,
                    texture: Callable[[Snapshot], tuple[int, tuple[int, int]] | None]) -> None:
    """Draw the shelf; what the user asks for is left in the state. texture: GL name and size of a thumbnail."""
    if imgui.button(f"{fa.ICON_FA_PLUS}  Keep snapshot###Keep"):
        state.action = KEEP, None
    imgui.set_item_tooltip(tip_of("Keep snapshot"))
    imgui.same_line()
    if imgui.button("Paste"):
        state.action = PASTE, None
    imgui.set_item_tooltip(tip_of("Paste state"))
    if not snapshots:
        paragraph("No snapshots yet. A snapshot is a picture with its settings, kept for later sessions.")
        return
    imgui.begin_child("Shelf", ImVec2(0.0, 0.0), imgui.ChildFlags_.none, imgui.WindowFlags_.horizontal_scrollbar)
    line = imgui.get_text_line_height()
    height = max(imgui.get_content_region_avail().y - 2.0 * line - theme.em(1.2), theme.em(3.0))
    room, x = imgui.get_content_region_avail().x, 0.0
    height = min(height, theme.em(9.0))
    for i, snapshot in enumerate(snapshots):
        down, across = snapshot.thumbnail.shape[:2]
        width = height * across / down
        if i and x + width < room:
            imgui.same_line()
        else:
            x = 0.0
        x += width + imgui.get_style().item_spacing.x
        _snapshot(snapshot, state, texture(snapshot), ImVec2(width, height))
    imgui.end_child()


def _snapshot(snapshot: Snapshot, state: SnapshotsState, shown: tuple[int, tuple[int, int]] | None,
              size: ImVec2) -> None:
    """One thumbnail with its name; a click opens it, the right button its menu."""
    imgui.push_id(str(snapshot.path))
    imgui.begin_group()
    corner = imgui.get_cursor_screen_pos()
    if imgui.invisible_button(f"Snapshot {snapshot.name}", size):
        state.action = OPEN, snapshot
    hovered = imgui.is_item_hovered()
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    if shown is not None:
        draw.add_image(imgui.ImTextureRef(shown[0]), corner, end)
    if hovered:
        draw.add_rect(corner, end, theme.packed(theme.colours().strong), 0.0, theme.scale())
    imgui.set_item_tooltip(f"{snapshot.name}\nClick to open, right click to compare, share, rename or remove")
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
    if state.renamed is snapshot:
        _rename(snapshot, state, size.x)
    else:
        theme.small()
        for text in two_lines(snapshot.name, size.x):
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
