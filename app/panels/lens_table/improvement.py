"""Improve in the table: what may change, start and stop, and the steps on their way into the lens."""

import math
from functools import lru_cache

from imgui_bundle import icons_fontawesome_6 as fa, imgui

from lensbench.app.bench.lens_choice import image_circle
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, toggles
from lensbench.app.panels.lens_table.state import LensTableState
from lensbench.app.session import edited_lens
from lensbench.app.session.edited_lens import with_document
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant
from lensbench.lenses.editing.document import LensDocument

TITLE = "Improve the lens"


def improve_button(settings: Settings, document: LensDocument, state: LensTableState) -> None:
    """The button, which stops an improvement that is under way; and its popup."""
    if state.worker.running:
        if imgui.button(f"{fa.ICON_FA_STOP}###Improve"):
            state.worker.stop()
        imgui.set_item_tooltip("Stop; the lens stays as it is now")
    else:
        if imgui.button(f"{fa.ICON_FA_WAND_MAGIC_SPARKLES}###Improve"):
            imgui.open_popup(TITLE)
        imgui.set_item_tooltip("Improve: smaller spots over the field by least squares")
    imgui.same_line(0.0, theme.em(0.13))
    if not imgui.begin_popup(TITLE):
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
    return (*(f"Judged: {each}" for each in goal.judged), *goal.left_out,
            "Focal length, f-number, solves and thinnest edges are held.")


def free_cells(document: LensDocument, state: LensTableState) -> tuple[tuple[int, str], ...]:
    """The numbers that may change: those that are ticked, or all radii."""
    count = len(document.surfaces)
    ticked = tuple(sorted(cell for cell in state.ticked if cell[0] < count and document.rule(*cell) is None))
    return ticked or edited_lens.free_cells(document, "radii")


def take_step(settings: Settings, state: LensTableState) -> Settings:
    """The settings with the newest step; an edit by hand meanwhile ends the improvement."""
    state.stepped = False
    if state.worker.running and settings.edited != state.expected:
        state.worker.stop()
        state.worker.take()
        return settings
    step = state.worker.take()
    if step is None or settings.edited != state.expected:
        return settings
    changed = with_document(settings, step)
    state.expected, state.stepped = changed.edited, True
    return changed


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
