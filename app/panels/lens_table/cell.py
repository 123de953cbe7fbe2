"""One cell with a number: a drag scrubs it (Shift: finer), a click or Enter types, Ctrl with an arrow key steps.

The cell is one imgui item named "surface quantity"; arrow keys move from cell to cell.
"""

from collections.abc import Callable
from functools import partial

from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing import theme
from lensbench.app.panels.lens_table.state import Cell, Entry, LensTableState, Scrub
from lensbench.app.session import lens_cells
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.prescription import value_of
from lensbench.lenses.editing.cells import with_value
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.editing.elements import with_pose

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
    has_keys = state.keyed and state.at == cell
    if has_keys and imgui.is_key_pressed(imgui.Key.enter, False):
        pressed = True
    if imgui.is_item_activated() or imgui.is_item_clicked(imgui.MouseButton_.right):
        state.at = cell
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
    part = not scrub.dragged
    scrub.pixels += (mouse - scrub.mouse) / theme.scale() * (FINE if imgui.get_io().key_shift else 1.0)
    scrub.mouse, scrub.dragged = mouse, True
    value = lens_cells.scrubbed(document.surfaces[surface], quantity, scrub.value, scrub.pixels)
    return state.apply(settings, _change(cell, body, value), part)


def _keys(settings: Settings, document: LensDocument, cell: Cell, state: LensTableState,
          body: tuple[int, int] | None) -> Settings:
    """The settings after Ctrl with an arrow key, while the cell has the keyboard (with Shift: finer)."""
    if not (state.keyed and state.at == cell and imgui.get_io().key_ctrl):
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
    in_popup = imgui.is_popup_open("", imgui.PopupFlags_.any_popup)         # of coefficients, beside the table
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
        state.entry, state.at = None, cell
    return changed
