"""The dialog of a pasted table: the text, what is recognised in it, and where it goes."""

from dataclasses import replace
from functools import lru_cache

from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_table.state import LensTableState
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.fitted_dialog import begin_fitted_dialog
from lensbench.kernels.figures import significant, true_minus
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.editing.pasted_table import pasted
from lensbench.lenses.editing.structure import inserted
from lensbench.lenses.paraxial import focal_length

TITLE = "Paste a table"
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
    if not begin_fitted_dialog(TITLE):
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
