"""State of the surface table between frames, the way of every edit into the settings, and one cell with a number.

A drag scrubs a cell (Shift: finer), a click or Enter types, Ctrl with an arrow key steps. The cell is one imgui item
named "surface quantity"; arrow keys move from cell to cell.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing import theme
from lensbench.app.session import lens_cells
from lensbench.app.session.edited_lens import edited, with_document
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.study_workers import ImprovementWorker
from lensbench.core.optics.prescription import value_of
from lensbench.lenses.editing.cells import with_value
from lensbench.lenses.editing.document import EditError, LensDocument, Places
from lensbench.lenses.editing.elements import with_pose

Shown = tuple[str, str]         # the setting of the lens, and its edits
Cell = tuple[int, str]          # surface, and quantity or "glass", "comment", "asphere", "pose"


@dataclass
class Entry:
    """The text that a user types into a cell."""

    cell: Cell
    text: str
    fresh: bool = True
    error: str = ""


@dataclass
class Scrub:
    """A press on a cell: the value at its start, the pixels dragged since, and the last x of the mouse."""

    cell: Cell
    value: float
    mouse: float
    pixels: float = 0.0
    dragged: bool = False


@dataclass
class Attachment:
    """What the dialog of another lens shows: its search, the name of the lens, the side "front" or "behind"."""

    search: str = ""
    lens: str = ""
    side: str = "front"
    is_reversed: bool = False


@dataclass
class LensTableState:
    """State of the panel of one window.

    requests: of the window. said: sentences for the user about the latest edits. parted: whether the change of this
    frame begins a step of undo of its own. ghost: whether the original lens lies under the section.
    """

    requests: set[Request] = field(default_factory=set)
    first: int = 0                      # selected surfaces, first and last
    last: int = 0
    entry: Entry | None = None
    scrub: Scrub | None = None
    glass_of: int = -1                  # surface whose glass is chosen
    body: tuple[int, int] | None = None # surfaces that a number of the place moves as one; None: not chosen
    search: str = ""
    maker: str = ""
    pasting: str | None = None          # the text of the paste dialog
    attaching: Attachment | None = None         # the dialog of another lens
    problem: str = ""                   # why the latest edit was refused
    shown: Shown = ("", "")             # as drawn last
    moves: dict[tuple[Shown, Shown], Places] = field(default_factory=dict)      # by edits, and by their undo
    said: list[str] = field(default_factory=list)
    parted: bool = False
    ghost: bool = False
    number: float = 0.0                 # typed in a menu
    worker: ImprovementWorker = field(default_factory=ImprovementWorker)
    ticked: set[Cell] = field(default_factory=set)          # numbers that an improvement may change
    hold_back_focus: bool = False
    try_glasses: bool = False
    asks: int = 0                       # frames until the popup of the improvement opens; 0: it does not
    aim: str = "spot"                       # of an improvement, one of AIMS
    begun: bool = False                 # an improvement begins: its steps are one undo
    stepped: bool = False               # the lens of this frame is a step of an improvement
    expected: str = ""                  # the edited lens of the settings while an improvement runs
    focused: Cell | None = None         # the cell that has the keyboard
    keyed: bool = False                 # the table has the keyboard in this frame
    tabbed: int = 0                     # cells to the right, to which Tab goes from the text that it has ended

    def selected(self, surface: int) -> bool:
        """Whether a row is selected."""
        return self.first <= surface <= self.last

    def select(self, surface: int, extend: bool = False) -> None:
        """Select a row, or the rows up to it."""
        if extend:
            self.first, self.last = min(self.first, surface), max(self.last, surface)
        else:
            self.first = self.last = surface

    def follow(self, settings: Settings) -> None:
        """Before the panels of each frame: after an edit, an undo or a redo, ticks go with their surfaces and gaps."""
        shown = settings.lens, settings.edited
        if shown == self.shown:
            return
        places = self.moves.get((self.shown, shown))
        if places is not None:
            self.ticked = {(row, name) for i, name in self.ticked if (row := places.of(i, name)) is not None}
        self.problem, self.shown = "", shown            # why an edit of another lens was refused

    def improved(self, settings: Settings) -> Settings:
        """The settings with the newest step of an improvement; an edit by hand meanwhile ends the improvement."""
        self.stepped = False
        if self.worker.running and settings.edited != self.expected:
            self.worker.stop()
            self.worker.take()
            return settings
        step = self.worker.take()
        if step is None or settings.edited != self.expected:
            return settings
        changed = with_document(settings, step)
        self.expected, self.stepped = changed.edited, True
        return changed

    def apply(self, settings: Settings, edit: Callable[[LensDocument], LensDocument], step: bool = True) -> Settings:
        """The settings after an edit; the same ones, and a reason in `problem`, where it is refused.

        step: it is a step of undo of its own.
        """
        places: Places | None = None

        def followed(document: LensDocument) -> LensDocument:
            nonlocal places
            made = edit(document)
            places = made.places
            return made

        try:
            changed, findings = edited(settings, followed)
        except EditError as error:
            self.problem = str(error)
            return settings
        self.problem = ""
        if places is not None:
            before, after = (settings.lens, settings.edited), (changed.lens, changed.edited)
            self.moves |= {(before, after): places, (after, before): places.undone()}
        self.said += [str(finding) for finding in findings]
        self.parted = self.parted or step and changed is not settings
        return changed


DRAG_THRESHOLD = 3.0            # pixels at a scale of 1
FINE = 0.1                      # of the mouse's movement, with Shift
KEY_PIXELS = 5.0                # of a drag, that one press of a key is


def number_cell(settings: Settings, document: LensDocument, cell: Cell, state: LensTableState,
                faulty: bool = False, body: tuple[int, int] | None = None) -> Settings:
    """Draw a cell and return the settings, changed or not.

    faulty: it has a part in a fault. body: first and last of the surfaces that a number of the place moves as one.
    """
    surface, quantity = cell
    row = document.surfaces[surface]
    if state.entry is not None and state.entry.cell == cell:
        return _typing(settings, state, cell, body)
    rule = document.rule(surface, quantity)
    pressed, hovered = cell_item(f"{surface} {quantity}", lens_cells.shown(row, quantity), state, cell, faulty=faulty,
                                 mark=lens_cells.rule_mark(document, surface, quantity)
                                 or ("V" if cell in state.ticked else ""))
    activated = imgui.is_item_activated()
    if hovered and state.scrub is None:
        lines = lens_cells.tooltip(document, surface, quantity)
        hint = "" if rule is not None else "Drag to change (Shift: finer), click to type, right click for more"
        imgui.set_item_tooltip("\n".join([*lines, hint]).strip())
    if rule is not None:
        if activated or pressed:
            state.problem = f"This number follows from a rule ({rule}): remove it first, by a right click"
        return settings
    if hovered or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    settings = _scrubbing(settings, document, cell, state, body)
    settings = _keys(settings, document, cell, state, body)
    if pressed and not (state.scrub is not None and state.scrub.dragged):
        state.entry = Entry(cell, lens_cells.whole(row, quantity))
    if state.scrub is not None and state.scrub.cell == cell and not imgui.is_item_active():
        state.scrub = None
    return settings


def cell_item(name: str, text: str, state: LensTableState, cell: Cell, right: bool = True, faulty: bool = False,
              mark: str = "", dim: bool = False) -> tuple[bool, bool]:
    """The item of a cell with its text; returns whether it was clicked (or Enter pressed), and is hovered."""
    colour = theme.colours()
    size = ImVec2(max(imgui.get_content_region_avail().x, 4.0), imgui.get_text_line_height() + theme.em(0.25))
    corner = imgui.get_cursor_screen_pos()
    pressed = imgui.invisible_button(name, size)
    hovered = state.entry is None and imgui.is_item_hovered()      # no tooltip over the text that is typed
    has_keys = state.keyed and state.focused == cell
    if has_keys and imgui.is_key_pressed(imgui.Key.enter, False):
        pressed = True
    if imgui.is_item_activated() or imgui.is_item_clicked(imgui.MouseButton_.right):
        state.focused = cell
        state.select(cell[0], imgui.get_io().key_shift and imgui.is_mouse_down(imgui.MouseButton_.left)
                     and cell[1] == "row")
    draw, end = imgui.get_window_draw_list(), ImVec2(corner.x + size.x, corner.y + size.y)
    if hovered or imgui.is_item_active():
        draw.add_rect_filled(corner, end, theme.packed(colour.frame_hovered), imgui.get_style().frame_rounding)
    if has_keys:
        draw.add_rect(corner, end, theme.packed(colour.dim), imgui.get_style().frame_rounding)
    pad, room = theme.em(0.25), size.x - theme.em(0.5)
    tint = colour.warning if faulty else colour.dim if dim else colour.text
    if mark:
        draw.add_text(ImVec2(end.x - pad - imgui.calc_text_size(mark).x, corner.y + theme.em(0.125)),
                      theme.packed(colour.field0_text), mark)
        room -= imgui.calc_text_size(mark).x + pad
    fitted = theme.shortened(text, room)
    x = corner.x + pad + (room - imgui.calc_text_size(fitted).x if right else 0.0)
    draw.add_text(ImVec2(round(x), corner.y + theme.em(0.125)), theme.packed(tint), fitted)
    return pressed, hovered


def _change(cell: Cell, body: tuple[int, int] | None, value: float) -> Callable[[LensDocument], LensDocument]:
    """The edit that gives a cell, or the cells of a body, this value."""
    if body is not None:
        return partial(with_pose, first=body[0], last=body[1], quantity=cell[1], value=value)
    return partial(with_value, surface=cell[0], quantity=cell[1], value=value)


def _scrubbing(settings: Settings, document: LensDocument, cell: Cell, state: LensTableState,
               body: tuple[int, int] | None) -> Settings:
    """The settings after this frame's mouse on the item just submitted."""
    surface, quantity = cell
    mouse = imgui.get_mouse_pos().x
    if imgui.is_item_activated() and imgui.is_mouse_clicked(imgui.MouseButton_.left):
        state.scrub = Scrub(cell, value_of(document.surfaces[surface], quantity), mouse)
        return settings
    scrub = state.scrub
    if scrub is None or scrub.cell != cell or not imgui.is_item_active():
        return settings
    if not scrub.dragged and abs(mouse - scrub.mouse) < DRAG_THRESHOLD * theme.scale():
        return settings
    if scrub.dragged and mouse == scrub.mouse:
        return settings
    is_first = not scrub.dragged
    scrub.pixels += (mouse - scrub.mouse) / theme.scale() * (FINE if imgui.get_io().key_shift else 1.0)
    scrub.mouse, scrub.dragged = mouse, True
    value = lens_cells.scrubbed(document.surfaces[surface], quantity, scrub.value, scrub.pixels)
    return state.apply(settings, _change(cell, body, value), is_first)


def _keys(settings: Settings, document: LensDocument, cell: Cell, state: LensTableState,
          body: tuple[int, int] | None) -> Settings:
    """The settings after Ctrl with an arrow key, while the cell has the keyboard (with Shift: finer)."""
    if not (state.keyed and state.focused == cell and imgui.get_io().key_ctrl):
        return settings
    surface, quantity = cell
    for key, sign in ((imgui.Key.up_arrow, 1.0), (imgui.Key.down_arrow, -1.0), (imgui.Key.right_arrow, 1.0),
                      (imgui.Key.left_arrow, -1.0)):
        if imgui.is_key_pressed(key):
            pixels = sign * KEY_PIXELS * (FINE if imgui.get_io().key_shift else 1.0)
            row = document.surfaces[surface]
            value = lens_cells.scrubbed(row, quantity, value_of(row, quantity), pixels)
            return state.apply(settings, _change(cell, body, value), False)
    return settings


def tab_step() -> int:
    """Cells to the right that Tab goes: 1, with Shift −1, and 0 where it is not pressed."""
    return (-1 if imgui.get_io().key_shift else 1) if imgui.is_key_pressed(imgui.Key.tab) else 0


def text_entry(state: LensTableState) -> str | None:
    """The entry of a text in the place of its cell; returns the text when Enter or Tab ends it. Escape cancels."""
    entry = state.entry
    assert entry is not None
    imgui.set_next_item_width(-1.0)
    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(theme.em(0.25), theme.em(0.125)))
    if entry.fresh:
        imgui.set_keyboard_focus_here()
    entered, entry.text = imgui.input_text("##entry", entry.text, imgui.InputTextFlags_.enter_returns_true
                                           | imgui.InputTextFlags_.auto_select_all)
    imgui.pop_style_var()
    if entry.error:
        imgui.set_item_tooltip(entry.error)
        corner = imgui.get_item_rect_min()
        imgui.set_next_window_pos(ImVec2(corner.x, corner.y - theme.em(2.2)))
        if imgui.begin_tooltip():
            imgui.text_colored(imgui.ImVec4(*theme.colours().warning), entry.error)
            imgui.end_tooltip()
    in_popup = imgui.is_popup_open("", imgui.PopupFlags_.any_popup)         # of coefficients, outside the table
    state.tabbed = 0 if entry.fresh or in_popup else tab_step()
    if entered or state.tabbed:
        return entry.text
    if imgui.is_key_pressed(imgui.Key.escape) or not entry.fresh and imgui.is_item_deactivated():
        state.entry = None
    entry.fresh = False
    return None


def _typing(settings: Settings, state: LensTableState, cell: Cell, body: tuple[int, int] | None) -> Settings:
    """The settings after this frame of the text entry; a text that is no number stays, with the reason."""
    text = text_entry(state)
    if text is None:
        return settings
    try:
        value = lens_cells.typed(text, cell[1])
    except EditError as error:
        state.entry, state.tabbed = Entry(cell, text, True, str(error)), 0
        return settings
    changed = state.apply(settings, _change(cell, body, value))
    if state.problem:
        state.entry, state.tabbed = Entry(cell, text, True, state.problem), 0
    else:
        state.entry, state.focused = None, cell
    return changed
