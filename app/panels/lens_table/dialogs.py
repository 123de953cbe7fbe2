"""Popups and dialogs of the surface table: improvement, another lens attached, a pasted table, tilt and decentre."""

import math
from dataclasses import replace
from functools import cache, lru_cache, partial

from imgui_bundle import ImVec2, icons_fontawesome_6 as fa, imgui

from lensbench import lenses
from lensbench.app.bench.lens_choice import image_circle
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import applies, begin_fitted_dialog, cancels, check_box, radio, toggles, warning
from lensbench.app.panels.lens_table.cell import LensTableState, cell_item, number_cell
from lensbench.app.session import edited_lens, lens_cells
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.glass import D_LINE
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

IMPROVE_TITLE = "Improve the lens"


def improve_button(settings: Settings, document: LensDocument, state: LensTableState) -> None:
    """The button, which stops an improvement that is under way; and its popup."""
    asks, state.asks = state.asks == 1, max(state.asks - 1, 0)
    if state.worker.running:
        if imgui.button(f"{fa.ICON_FA_STOP}###Improve"):
            state.worker.stop()
        imgui.set_item_tooltip("Stop; the lens stays as it is now")
    else:
        if imgui.button(f"{fa.ICON_FA_WAND_MAGIC_SPARKLES}###Improve") or asks:
            imgui.open_popup(IMPROVE_TITLE)
        imgui.set_item_tooltip("Improve: smaller spots over the field by least squares")
    imgui.same_line(0.0, theme.em(0.13))
    if not imgui.begin_popup(IMPROVE_TITLE):
        return
    cells = free_cells(document, state)
    what = f"{len(cells)} ticked numbers" if state.ticked else f"all {len(cells)} radii (right click ticks others)"
    imgui.text_unformatted(f"May change: {what}")
    state.aim = toggles("Aim", {"spot": "Spots", "wavefront": "Wavefront"}, state.aim, {
        "spot": "The rms radius of the spots: for contrast at coarse detail and lenses that are far from perfect",
        "wavefront": "The rms wave error: for lenses whose sharpness diffraction limits"})
    height = _image_height(settings, document)
    for remark in _remarks(document, height):
        imgui.text_disabled(remark)
    state.hold_back_focus = check_box("Hold the back focus", state.hold_back_focus)
    state.try_glasses = check_box("Try other glasses", state.try_glasses)
    imgui.set_item_tooltip("Then also puts glasses of the catalogues instead of those of the lens, one after the\n"
                           "other, and keeps those that make the spots smaller. The stop button ends it")
    if imgui.button("Improve###Start improving"):
        state.worker.start(document, cells, height, state.hold_back_focus, state.try_glasses, state.aim)
        state.expected, state.begun = settings.edited, True
        imgui.close_current_popup()
    if state.ticked:
        imgui.same_line()
        if imgui.button("Untick all"):
            state.ticked.clear()
    imgui.end_popup()


def _image_height(settings: Settings, document: LensDocument) -> float | None:
    """Largest image height (mm) that is judged; None where the lens states its fields."""
    if document.lens.system.fields:
        return None
    circle = image_circle(settings.lens, document.lens) or math.inf
    return 0.5 * min(circle, settings.film.diagonal / settings.crop)


@lru_cache(maxsize=4)
def _remarks(document: LensDocument, image_height: float | None) -> tuple[str, ...]:
    """What an improvement judges, holds and leaves out; nothing where it cannot begin at all."""
    from lensbench.core.design.standard_goal import goal_of

    try:
        goal = goal_of(document.lens, image_height)
    except ValueError:                      # the start says why
        return ()
    return (*(f"Judged: {quantity}" for quantity in goal.judged), *goal.left_out,
            "Focal length, f-number, solves and thinnest edges are held.")


def free_cells(document: LensDocument, state: LensTableState) -> tuple[tuple[int, str], ...]:
    """The numbers that may change: those that are ticked, or all radii."""
    count = len(document.surfaces)
    ticked = tuple(sorted(cell for cell in state.ticked if cell[0] < count and document.rule(*cell) is None))
    return ticked or edited_lens.free_cells(document, "radii")


def progress(settings: Settings, state: LensTableState) -> str:
    """The spots of an improvement in a few words; "" before the first, and where the settings are no longer its own."""
    worker = state.worker
    if not worker.running and settings.edited != state.expected:
        return ""
    if worker.message:
        return worker.message
    if worker.first is None or worker.last is None:
        return ""
    name, unit, words = ("Wave error", D_LINE, "waves") if worker.aim == "wavefront" else ("Spot", 1.0, "µm")
    first, last = (significant(1000.0 * value / unit, 3) for value in (worker.first, worker.last))
    end = " …" if worker.running else f": {worker.ended}" if worker.ended else ""
    return f"{name} {first} → {last} {words} rms, step {worker.number}{end}"


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
    cards = searched(_cards(), choice.search)
    if imgui.begin_child("Lenses", ImVec2(theme.em(WIDTH), theme.em(HEIGHT))):
        if not cards:
            imgui.text_disabled("No lens matches")
        clipper = imgui.ListClipper()
        clipper.begin(len(cards))
        while clipper.step():
            for card in cards[clipper.display_start:clipper.display_end]:
                if imgui.selectable(f"{card.title}###{card.name}", card.name == choice.lens,
                                    imgui.SelectableFlags_.no_auto_close_popups)[0]:
                    choice.lens = card.name
    imgui.end_child()
    choice.side = toggles("Side", SIDES, choice.side, TIPS, 0.0)
    imgui.same_line(0.0, theme.em(1.0))
    choice.is_reversed = check_box("Reversed", choice.is_reversed)
    imgui.set_item_tooltip("Reversed, as with a reversing ring")
    if state.problem:
        warning(state.problem, WIDTH)
    imgui.begin_disabled(all(card.name != choice.lens for card in cards))       # else it would attach one out of sight
    if applies("Attach###Attach lens"):
        settings = state.apply(settings, partial(with_lens, name=choice.lens, side=choice.side,
                                                 is_reversed=choice.is_reversed))
        if not state.problem:
            state.attaching = None
    imgui.end_disabled()
    imgui.same_line()
    if cancels("Cancel###Cancel attaching"):
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
    pasted = read(state.pasting)
    colour = theme.colours()
    imgui.push_text_wrap_pos(width)
    if isinstance(pasted, str):
        imgui.text_colored(imgui.ImVec4(*colour.warning), pasted)
    else:
        length = true_minus(significant(focal_length(pasted.surfaces), 4))
        imgui.text_unformatted(f"{len(pasted.surfaces)} surfaces, focal length {length} mm, "
                               f"stop at surface {pasted.lens.stop_index}")
        for finding in pasted.findings:
            imgui.text_disabled(str(finding))
    imgui.pop_text_wrap_pos()
    imgui.begin_disabled(isinstance(pasted, str))
    if imgui.button("Replace the lens") and isinstance(pasted, LensDocument):
        table = pasted
        settings = state.apply(settings, lambda d: replace(table, lens=replace(
            table.lens, name=table.lens.name or "Pasted table", film_size=d.lens.film_size)))
        state.pasting = None
    imgui.same_line()
    if imgui.button(f"Insert before surface {state.first}###Insert table") and isinstance(pasted, LensDocument):
        rows, comments = pasted.surfaces, pasted.comments
        settings = state.apply(settings, lambda d: inserted(d, min(state.first, len(d.surfaces)), rows, comments))
        state.pasting = None
    imgui.end_disabled()
    imgui.same_line()
    if cancels("Cancel###Cancel paste"):
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
