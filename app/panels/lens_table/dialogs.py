"""The cell of a surface's place: decentre, tilt and roll of the surface, of its element, or of the selected group.

The dialog that attaches a lens of the library in front of, or behind, the edited one.

The dialog of a pasted table: the text, what is recognised in it, and where it goes.
"""

from dataclasses import replace
from functools import cache, lru_cache, partial

from imgui_bundle import ImVec2, imgui

from lensbench import lenses
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import begin_fitted_dialog, check_box, radio, toggles
from lensbench.app.panels.lens_table.cell import cell_item, number_cell
from lensbench.app.panels.lens_table.state import LensTableState
from lensbench.app.session import lens_cells
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.prescription import POSE
from lensbench.core.text import significant, true_minus
from lensbench.lenses.editing import attachments
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.editing.elements import body_at, element_at
from lensbench.lenses.editing.pasted_table import pasted
from lensbench.lenses.editing.structure import inserted
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.library.search import searched
from lensbench.lenses.tables.paraxial import focal_length

ATTACH_TITLE = "Attach a lens"
WIDTH, HEIGHT = 24.0, 14.0      # em, of the list
SIDES = {"front": "In front", "behind": "Behind"}
TIPS = {"front": "Between the scene and the lens, as a converter or close-up attachment",
        "behind": "Between the lens and the film, as a teleconverter"}


def attach_dialog(settings: Settings, state: LensTableState) -> Settings:
    """Draw the dialog while `state.attaching`; the settings, changed or not."""
    choice = state.attaching
    if choice is None:
        return settings
    if not begin_fitted_dialog(ATTACH_TITLE):
        return settings
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(theme.em(WIDTH))
    _, choice.search = imgui.input_text_with_hint("##Search lens", "Name, maker, kind or year", choice.search)
    found = searched(_cards(), choice.search)
    if imgui.begin_child("Lenses", ImVec2(theme.em(WIDTH), theme.em(HEIGHT))):
        if not found:
            imgui.text_disabled("No lens matches")
        clipper = imgui.ListClipper()
        clipper.begin(len(found))
        while clipper.step():
            for card in found[clipper.display_start:clipper.display_end]:
                if imgui.selectable(f"{card.title}###{card.name}", card.name == choice.lens,
                                    imgui.SelectableFlags_.no_auto_close_popups)[0]:
                    choice.lens = card.name
    imgui.end_child()
    choice.side = toggles("Side", SIDES, choice.side, TIPS, 0.0)
    imgui.same_line(0.0, theme.em(1.0))
    choice.is_reversed = check_box("Reversed", choice.is_reversed)
    imgui.set_item_tooltip("Reversed, as with a reversing ring")
    if state.problem:
        imgui.push_text_wrap_pos(theme.em(WIDTH))
        imgui.text_colored(imgui.ImVec4(*theme.colours().warning), state.problem)
        imgui.pop_text_wrap_pos()
    imgui.begin_disabled(all(card.name != choice.lens for card in found))       # else it would attach one out of sight
    if imgui.button("Attach###Attach lens"):
        settings = state.apply(settings, partial(with_lens, name=choice.lens, side=choice.side,
                                                 is_reversed=choice.is_reversed))
        if not state.problem:
            state.attaching = None
    imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Cancel###Cancel attaching") or imgui.is_key_pressed(imgui.Key.escape):
        state.attaching, state.problem = None, ""
    if state.attaching is None:
        imgui.close_current_popup()
    imgui.end_popup()
    return settings


@cache
def _cards() -> tuple[lenses.Card, ...]:
    return tuple(sorted(lenses.describe(), key=lambda card: card.title))


def with_lens(document: LensDocument, name: str, side: str, is_reversed: bool) -> LensDocument:
    """The document with a lens of the library in front of it or behind it; EditError where that cannot be."""
    try:
        lens = lenses.load(name).at(zoom=0.0, close=0.0)
    except (LensFileError, OSError) as error:
        raise EditError(str(error)) from None
    title = f"{lens.name or name}{', reversed' if is_reversed else ''}"
    attach = attachments.attached_in_front if side == "front" else attachments.attached_behind
    return attach(document, attachments.surfaces_of(lens, is_reversed), title)


PASTE_TITLE = "Paste a table"
SIZE = 40.0, 14.0               # em, of the text


@lru_cache(maxsize=8)
def read(text: str) -> LensDocument | str:
    """The document of a text, or why there is none."""
    try:
        return pasted(text)
    except EditError as error:
        return str(error)


def paste_dialog(settings: Settings, state: LensTableState) -> Settings:
    """Draw the dialog while there is a text to paste; the settings, changed or not."""
    if state.pasting is None:
        return settings
    if not begin_fitted_dialog(PASTE_TITLE):
        return settings
    imgui.text_disabled("One surface a line: radius, thickness, n_d and V_d or glass, diameter. Headings help.")
    width = min(theme.em(SIZE[0]), 0.9 * imgui.get_main_viewport().work_size.x)
    _, state.pasting = imgui.input_text_multiline("##Table", state.pasting, ImVec2(width, theme.em(SIZE[1])))
    found = read(state.pasting)
    colour = theme.colours()
    imgui.push_text_wrap_pos(width)
    if isinstance(found, str):
        imgui.text_colored(imgui.ImVec4(*colour.warning), found)
    else:
        length = true_minus(significant(focal_length(found.surfaces), 4))
        imgui.text_unformatted(f"{len(found.surfaces)} surfaces, focal length {length} mm, "
                               f"stop at surface {found.lens.stop_index}")
        for finding in found.findings:
            imgui.text_disabled(str(finding))
    imgui.pop_text_wrap_pos()
    imgui.begin_disabled(isinstance(found, str))
    if imgui.button("Replace the lens") and isinstance(found, LensDocument):
        table = found
        settings = state.apply(settings, lambda d: replace(table, lens=replace(
            table.lens, name=table.lens.name or "Pasted table", film_size=d.lens.film_size)))
        state.pasting = None
    imgui.same_line()
    if imgui.button(f"Insert before surface {state.first}###Insert table") and isinstance(found, LensDocument):
        rows, comments = found.surfaces, found.comments
        settings = state.apply(settings, lambda d: inserted(d, min(state.first, len(d.surfaces)), rows, comments))
        state.pasting = None
    imgui.end_disabled()
    imgui.same_line()
    if imgui.button("Cancel###Cancel paste") or imgui.is_key_pressed(imgui.Key.escape):
        state.pasting = None
    if state.pasting is None:
        imgui.close_current_popup()
    imgui.end_popup()
    return settings


POPUP = "Tilt and decentre"
LABELS = {"decentre_x": "Decentre x (mm)", "decentre_y": "Decentre y (mm)", "tilt_x": "Tilt about x (°)",
          "tilt_y": "Tilt about y (°)", "roll": "Roll (°)"}
ABOUT = {"decentre_x": "To the right, as the picture shows it", "decentre_y": "Upwards",
         "tilt_x": "Positive moves the upper edge towards the film",
         "tilt_y": "Positive moves the edge at +x towards the scene",
         "roll": "About its own axis, before the tilts; counterclockwise as the camera looks.\nIt turns cylinders, "
                 "toroids, and blades or a picture in the stop; a round surface stays as it is"}


def pose_cell(settings: Settings, document: LensDocument, i: int, state: LensTableState) -> Settings:
    """Draw the cell; a click opens the five numbers, and what they move."""
    text = lens_cells.pose_text(document.surfaces[i])
    pressed, hovered = cell_item(f"{i} pose", text, state, (i, "pose"), right=False)
    if hovered:
        imgui.set_item_tooltip("Click to decentre, tilt or roll the surface, its element or the selected group")
    name = f"{POPUP} {i}"
    if pressed:
        selected = (state.first, state.last) if state.first < state.last and state.selected(i) else None
        state.body = selected or body_at(document.lens, i)
        imgui.open_popup(name)
    imgui.set_next_window_size(imgui.ImVec2(theme.em(18.0), 0.0))
    if not imgui.begin_popup(name):
        return settings
    body = state.body if state.body is not None and state.body[1] < len(document.surfaces) else (i, i)
    group = [(state.first, state.last)] if state.first < state.last else []
    for choice in dict.fromkeys([(i, i), element_at(document.lens, i), body_at(document.lens, i), *group, body]):
        title = f"Surface {i}" if choice == (i, i) else f"Surfaces {choice[0]} to {choice[1]} as one"
        if radio(title, choice == body):
            state.body = body = choice
        if choice != (i, i):
            imgui.set_item_tooltip(f"They turn about the vertex of surface {choice[0]}; all surfaces behind them stay")
    for quantity in POSE:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(LABELS[quantity])
        imgui.set_item_tooltip(ABOUT[quantity])
        imgui.same_line(theme.em(9.0))
        settings = number_cell(settings, document, (body[0], quantity), state, body=body)
    imgui.end_popup()
    return settings
