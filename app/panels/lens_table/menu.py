"""The edits of rows and cells: the toolbar above the table, its keys, and the menu of a right click."""

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from imgui_bundle import icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.lens_table.cell import Attachment, LensTableState
from lensbench.app.panels.lens_table.dialogs import improve_button
from lensbench.app.session.edited_lens import can_save_in_place, reverted
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.prescription import value_of
from lensbench.core.text import significant
from lensbench.lenses.editing import attachments, elements, structure
from lensbench.lenses.editing.cells import with_rule, without_rule
from lensbench.lenses.editing.document import SOLVES, TARGETS, LensDocument, Pickup, Solve, words

Edit = Callable[[LensDocument], LensDocument]
SCALE, MORE = "Scale the lens", "More edits of surfaces"
BUTTONS = ("Insert", "Delete", "Split", "Flip", "Move up", "Move down")
CLOSE_UP = (1.0, 2.0, 4.0)      # dioptres
SOLVE_TITLES = {"image": "Ends at the image", "edge": "Edge thickness", "efl": "Focal length",
                "marginal slope": "Slope of the marginal ray", "f-number": "f-number"}


def row_edits(document: LensDocument, first: int, last: int) -> list[tuple[str, str, str, str, Edit | None]]:
    """Icon, title, key, tooltip and edit of each edit of the selected rows; no edit where it does not apply."""
    count, lens = len(document.surfaces), document.lens
    first, last = min(first, count - 1), min(last, count - 1)
    one = first == last
    inside = one and 0 < first and lens.surfaces[first - 1].glass.n_d > 1.0 and lens.surfaces[first].glass.n_d > 1.0
    gap = one and first + 1 < count and 0 < first and lens.surfaces[first].glass.n_d == 1.0 \
        and lens.surfaces[first - 1].glass.n_d > 1.0 and lens.surfaces[first + 1].glass.n_d > 1.0
    group = (first, last) if not one else elements.element_at(lens, first)
    return [
        (fa.ICON_FA_PLUS, "Insert", "Insert", "A plane before the selected surface: it bends no ray",
         lambda d: structure.inserted_plane(d, first)),
        (fa.ICON_FA_TRASH_CAN, "Delete", "Delete", "The selected surfaces, with the gap and the medium behind each",
         (lambda d: structure.deleted(d, range(first, last + 1))) if last - first + 1 < count else None),
        (fa.ICON_FA_SCISSORS, "Split", "Ctrl+D", "Divide the gap behind the surface by a plane",
         (lambda d: structure.split(d, first)) if one else None),
        (fa.ICON_FA_RIGHT_LEFT, "Flip", "Ctrl+F", "Reverse the selected surfaces, or the element, in place",
         (lambda d: elements.flipped(d, *group)) if group[0] < group[1] else None),
        (fa.ICON_FA_ARROW_UP, "Move up", "Alt+Up", "The element, or the selected surfaces, towards the scene",
         (lambda d: structure.moved(d, *group, elements.element_at(lens, group[0] - 1)[0])) if group[0] > 0 else None),
        (fa.ICON_FA_ARROW_DOWN, "Move down", "Alt+Down", "The element, or the selected surfaces, towards the film",
         (lambda d: structure.moved(d, *group, elements.element_at(lens, group[1] + 1)[1] + 1))
         if group[1] + 1 < count else None),
        (fa.ICON_FA_LINK, "Cement", "", "Close the air gap behind the surface",
         (lambda d: elements.cemented(d, first)) if gap else None),
        (fa.ICON_FA_LINK_SLASH, "Separate", "", "Divide a cemented surface by a thin gap of air",
         (lambda d: elements.air_spaced(d, first)) if inside else None),
        (fa.ICON_FA_CIRCLE_STOP, "Stop here", "", "Make this surface the stop",
         (lambda d: structure.with_stop(d, first)) if one and first != lens.stop_index else None),
        (fa.ICON_FA_CIRCLE_HALF_STROKE, "Stop in the gap", "", "A plane stop in the middle of the gap behind the "
         "surface, as wide as the beam there: the f-number stays",
         (lambda d: structure.with_stop_in_gap(d, first, 0.5 * d.surfaces[first].thickness))
         if one and first + 1 < count and lens.surfaces[first].thickness > 0.0 else None),
    ]


def moved_selection(title: str, document: LensDocument, after: LensDocument, state: LensTableState) -> None:
    """Let the selection go with what was moved."""
    if title in ("Move up", "Move down"):
        shift = _shift(document, after, state.first)
        state.first, state.last = state.first + shift, state.last + shift
    last = len(after.surfaces) - 1
    state.first, state.last = min(state.first, last), min(state.last, last)


def _shift(document: LensDocument, after: LensDocument, first: int) -> int:
    group, places = document.surfaces[first], after.surfaces
    return next((i - first for i in range(len(places)) if places[i] is group), 0)


def toolbar(settings: Settings, document: LensDocument, state: LensTableState) -> Settings:
    """The buttons above the table; edits that are used less are in the last one's menu, with all others."""
    padding = imgui.get_style().frame_padding
    imgui.push_style_var(imgui.StyleVar_.frame_padding, imgui.ImVec2(theme.em(0.27), padding.y))
    for icon, title, key, about, edit in row_edits(document, state.first, state.last):
        if title not in BUTTONS:
            continue
        tip = f"{title}{f'  ({key})' if key else ''}\n{about}"
        if _button(icon, title, tip, edit is not None) and edit is not None:
            settings = _do(settings, title, edit, document, state)
    if _button(fa.ICON_FA_UP_RIGHT_AND_DOWN_LEFT_FROM_CENTER, "Scale", "Scale the whole lens"):
        state.number = 2.0
        imgui.open_popup(SCALE)
    settings = _scale_popup(settings, state)
    if _button(fa.ICON_FA_PASTE, "Paste table", "Paste a table of surfaces from a patent or a spreadsheet  (Ctrl+V)"):
        state.pasting = imgui.get_clipboard_text() or ""
    improve_button(settings, document, state)
    imgui.same_line(0.0, theme.em(0.6))
    is_edited, in_place = bool(settings.edited), can_save_in_place(settings)
    about = "Save the edited lens" if in_place else "Save the edited lens as…"
    if _button(fa.ICON_FA_FLOPPY_DISK, "Save lens", f"{about}  (Ctrl+Shift+S)", is_edited):
        state.requests.add(Request.SAVE_EDITED if in_place else Request.SAVE_LENS)
    if _button(fa.ICON_FA_CLOCK_ROTATE_LEFT, "Revert", "Take back all edits since the lens was opened or saved\n"
                                                       "Undo brings them back", is_edited):
        settings, state.parted = reverted(settings), True
    if _button(fa.ICON_FA_GHOST, "Original", "Show the lens before the edits under the section", is_edited,
               state.ghost):
        state.ghost = not state.ghost
    if _button(fa.ICON_FA_ELLIPSIS, "More edits", "All edits of the selected surfaces"):
        imgui.open_popup(MORE)
    imgui.pop_style_var()
    if imgui.begin_popup(MORE):
        settings = row_menu(settings, document, state)
        imgui.end_popup()
    return settings


def _button(icon: str, title: str, about: str, enabled: bool = True, on: bool = False) -> bool:
    """A small button of the toolbar, with the next item in its row."""
    if on:
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*theme.colours().frame_active))
    imgui.begin_disabled(not enabled)
    pressed = imgui.button(f"{icon}###{title}")
    imgui.end_disabled()
    if on:
        imgui.pop_style_color()
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip | imgui.HoveredFlags_.allow_when_disabled):
        imgui.set_tooltip(about)
    imgui.same_line(0.0, theme.em(0.13))
    return pressed


def has_keyboard(state: LensTableState) -> bool:
    """Whether keys belong to the table: it has the focus, and no text is typed and no menu open."""
    return (state.entry is None and not imgui.get_io().want_text_input
            and not imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id)
            and imgui.is_window_focused(imgui.FocusedFlags_.root_and_child_windows))


def keys(settings: Settings, document: LensDocument, state: LensTableState) -> Settings:
    """The keys of the table, while its window has the keyboard and no text is typed."""
    if not state.keyed:
        return settings
    key = imgui.Key
    chords = {"Insert": key.insert, "Delete": key.delete, "Split": chord(key.mod_ctrl, key.d),
              "Flip": chord(key.mod_ctrl, key.f), "Move up": chord(key.mod_alt, key.up_arrow),
              "Move down": chord(key.mod_alt, key.down_arrow)}
    for _, title, _, _, edit in row_edits(document, state.first, state.last):
        if title in chords and edit is not None and imgui.is_key_chord_pressed(chords[title]):
            return _do(settings, title, edit, document, state)
    if imgui.is_key_chord_pressed(chord(key.mod_ctrl, key.v)):
        state.pasting = imgui.get_clipboard_text() or ""
    return settings


def row_menu(settings: Settings, document: LensDocument, state: LensTableState) -> Settings:
    """The items of the menu of a right click, within its popup."""
    for icon, title, key, _, edit in row_edits(document, state.first, state.last):
        if imgui.menu_item(f"{icon}  {title}###menu {title}", key, False, edit is not None)[0] and edit is not None:
            settings = _do(settings, title, edit, document, state)
    if imgui.begin_menu(f"{fa.ICON_FA_CIRCLE_PLUS}  Attach###menu Attach"):
        for title, edit in attachment_edits(document):
            if imgui.menu_item(title, "", False)[0]:
                settings = _do(settings, title, edit, document, state)
        if imgui.menu_item("Another lens…", "", False)[0]:
            state.attaching, state.problem = Attachment(), ""
        imgui.end_menu()
    return settings


def attachment_edits(document: LensDocument) -> list[tuple[str, Edit]]:
    """What can be screwed onto the lens, with its title."""
    width = attachments.front_width(document)
    edits: list[tuple[str, Edit]] = [("Filter in front", lambda d: attachments.attached_in_front(
        d, attachments.plate(attachments.FILTER, width), "filter"))]
    for power in CLOSE_UP:
        edits.append((f"Close-up lens +{significant(power)} in front", partial(_closer, power=power, width=width)))
    rear = document.surfaces[-1].semi_diameter
    edits.append(("Plate behind", lambda d: attachments.attached_behind(
        d, attachments.plate(attachments.FILTER, 1.2 * rear), "plate")))
    return edits


def _closer(document: LensDocument, power: float, width: float) -> LensDocument:
    return attachments.attached_in_front(document, attachments.close_up_lens(power, width),
                                         f"close-up lens +{significant(power)}")


def cell_menu(settings: Settings, document: LensDocument, quantity: str, state: LensTableState) -> Settings:
    """Solves and pickups of the cell, within the popup of a right click."""
    surface = state.first
    rule = document.rule(surface, quantity)
    name = words(quantity)
    if rule is not None:
        if imgui.menu_item(f"Set the {name} free###Free", "", False)[0]:
            settings = state.apply(settings, partial(without_rule, surface=surface, quantity=quantity))
        imgui.set_item_tooltip(f"Now: {rule}")
        return settings
    if imgui.menu_item("May change in Improve###tick", "", (surface, quantity) in state.ticked)[0]:
        state.ticked ^= {(surface, quantity)}
    for kind, of in SOLVES.items():
        if of != quantity or (kind == "f-number" and surface != document.lens.stop_index) \
                or (kind == "edge" and surface == len(document.surfaces) - 1):
            continue
        if imgui.begin_menu(f"Solve: {SOLVE_TITLES[kind]}###solve {kind}"):
            if imgui.is_window_appearing():
                state.number = _present(document, surface, kind)
            zooms = document.lens.zooms and kind != "edge"
            imgui.text_disabled(TARGETS[kind][0].upper() + TARGETS[kind][1:] + (", at the wide end" if zooms else ""))
            imgui.set_next_item_width(theme.em(8.0))
            if kind != "image":
                _, state.number = imgui.input_double("##Target", state.number, 0.0, 0.0, "%.8g")
            if imgui.menu_item("Set###Set solve", "", False)[0]:
                target = 0.0 if kind == "image" else state.number
                settings = state.apply(settings, partial(_ruled, kind=kind, surface=surface, target=target))
            imgui.end_menu()
    if len(document.surfaces) > 1 and imgui.begin_menu(f"Same {name} as…###pickup"):
        for other in range(len(document.surfaces)):
            if other == surface:
                continue
            for sign, mark in ((1.0, ""), (-1.0, "−"))[:1 if quantity != "curvature" else 2]:
                if imgui.menu_item(f"{mark}surface {other}", "", False)[0]:
                    settings = state.apply(settings, partial(with_rule, rule=Pickup(surface, quantity, other, sign)))
        imgui.end_menu()
    return settings


def _ruled(document: LensDocument, surface: int, kind: str, target: float) -> LensDocument:
    return with_rule(document, Solve(surface, kind, target))


def _rounded(value: float, digits: int) -> float:
    """A value with so many significant digits, as a person would type it."""
    return float(np.format_float_positional(value, digits, fractional=False)) if math.isfinite(value) else 0.0


def _present(document: LensDocument, surface: int, kind: str) -> float:
    """The current value of what a solve keeps: its first proposal."""
    from lensbench.lenses.tables.paraxial import f_number, focal_length

    lens = document.lens.at(zoom=0.0, close=0.0)
    if kind == "efl":
        return _rounded(focal_length(lens.surfaces, front_index=lens.front_index), 6)
    if kind == "f-number":
        return _rounded(f_number(lens.surfaces, lens.stop_index, front_index=lens.front_index), 4)
    if kind == "edge":
        solve = Solve(surface, kind, 0.0)
        from lensbench.lenses.editing.solves import solution

        return _rounded(value_of(lens.surfaces[surface], "thickness") - solution(lens, solve), 4)
    return 0.0


def _scale_popup(settings: Settings, state: LensTableState) -> Settings:
    if not imgui.begin_popup(SCALE):
        return settings
    imgui.text_disabled("Factor")
    imgui.set_next_item_width(theme.em(8.0))
    entered, state.number = imgui.input_double("##Factor", state.number, 0.0, 0.0, "%.8g",
                                               imgui.InputTextFlags_.enter_returns_true)
    if imgui.button("Scale###Scale now") or entered:
        factor = state.number
        settings = state.apply(settings, lambda d: structure.scaled(d, factor))
        imgui.close_current_popup()
    imgui.end_popup()
    return settings


def _do(settings: Settings, title: str, edit: Edit, document: LensDocument, state: LensTableState) -> Settings:
    changed = state.apply(settings, edit)
    if changed is not settings:
        moved_selection(title, document, edit(document), state)
    return changed


