"""The panel *Moments*: a shelf of kept pictures, each with its settings, to open, compare and share.

The progress of a background task, with Cancel: the same in every panel and dialog.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from imgui_bundle import ImVec2, icons_fontawesome_6, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, two_lines
from lensbench.app.session.snapshots import Moment
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
    (OPEN, "Open", "Take its settings; undo brings the present ones back"),
    (COMPARE, "Compare as A", "Show it beside the present picture"),
    (TEXT, "Copy as text", "A short text for a chat message: lensbench view TEXT opens it, or paste it here"),
    (COPY, "Copy the picture", "To the clipboard"),
    (CARD, "Card…", "One picture with the section of the lens and the settings"),
)


@dataclass
class MomentsState:
    """State of the panel between frames: the moment that is renamed, its new name, and the chosen action."""

    renamed: Moment | None = None
    text: str = ""
    begins: bool = False
    action: tuple[str, Moment | None] | None = None
    new_name: tuple[Moment, str] | None = None
    sizes: dict[str, tuple[int, int]] = field(default_factory=dict)


def moments_panel(moments: list[Moment], state: MomentsState,
                  texture: Callable[[Moment], tuple[int, tuple[int, int]] | None]) -> None:
    """Draw the shelf; what the user asks for is left in the state. texture: GL name and size of a thumbnail."""
    if imgui.button(f"{fa.ICON_FA_PLUS}  Keep this moment###Keep"):
        state.action = KEEP, None
    imgui.set_item_tooltip("Keep the picture with its settings (B)")
    imgui.same_line()
    if imgui.button("Paste"):
        state.action = PASTE, None
    imgui.set_item_tooltip("Open the state of a text on the clipboard (Ctrl + V)")
    if not moments:
        paragraph("Nothing is kept yet. A moment is one picture file with its settings; it is here in every session.")
        return
    imgui.begin_child("Shelf", ImVec2(0.0, 0.0), imgui.ChildFlags_.none, imgui.WindowFlags_.horizontal_scrollbar)
    line = imgui.get_text_line_height()
    height = max(imgui.get_content_region_avail().y - 2.0 * line - theme.em(1.2), theme.em(3.0))
    room, x = imgui.get_content_region_avail().x, 0.0
    height = min(height, theme.em(9.0))
    for i, moment in enumerate(moments):
        down, across = moment.thumbnail.shape[:2]
        width = height * across / down
        if i and x + width < room:
            imgui.same_line()
        else:
            x = 0.0
        x += width + imgui.get_style().item_spacing.x
        _moment(moment, state, texture(moment), ImVec2(width, height))
    imgui.end_child()


def _moment(moment: Moment, state: MomentsState, shown: tuple[int, tuple[int, int]] | None, size: ImVec2) -> None:
    """One thumbnail with its name; a click opens it, the right button its menu."""
    imgui.push_id(str(moment.path))
    imgui.begin_group()
    corner = imgui.get_cursor_screen_pos()
    if imgui.invisible_button(f"Moment {moment.name}", size):
        state.action = OPEN, moment
    hovered = imgui.is_item_hovered()
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    if shown is not None:
        draw.add_image(imgui.ImTextureRef(shown[0]), corner, end)
    if hovered:
        draw.add_rect(corner, end, theme.packed(theme.colours().strong), 0.0, theme.scale())
    imgui.set_item_tooltip(f"{moment.name}\nClick to open, right click to compare, share, rename or remove")
    if imgui.begin_popup_context_item("Menu"):
        for action, name, tip in MENU:
            if imgui.menu_item(name, "", False)[0]:
                state.action = action, moment
            imgui.set_item_tooltip(tip)
        imgui.separator()
        if imgui.menu_item("Rename", "", False)[0]:
            state.renamed, state.text, state.begins = moment, moment.name, True
        if imgui.menu_item("Remove", "", False)[0]:
            state.action = REMOVE, moment
        imgui.set_item_tooltip("Delete its file")
        imgui.end_popup()
    if state.renamed is moment:
        _rename(moment, state, size.x)
    else:
        theme.small()
        for text in two_lines(moment.name, size.x):
            imgui.text_disabled(text)
        imgui.pop_font()
    imgui.end_group()
    imgui.pop_id()


def _rename(moment: Moment, state: MomentsState, width: float) -> None:
    """The name as a text field: Enter takes it, Escape or a click elsewhere leaves the old one."""
    imgui.set_next_item_width(max(width, theme.em(7.0)))
    if state.begins:
        imgui.set_keyboard_focus_here()
    entered, state.text = imgui.input_text("##New name", state.text, imgui.InputTextFlags_.enter_returns_true)
    if entered:
        state.new_name, state.renamed = (moment, state.text), None
    elif not state.begins and imgui.is_item_deactivated():
        state.renamed = None
    state.begins = False
