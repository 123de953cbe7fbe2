"""The dialog that attaches a lens of the library in front of, or behind, the edited one."""

from functools import cache, partial

from imgui_bundle import ImVec2, imgui

from lensbench import lenses
from lensbench.app.panels.lens_table.state import LensTableState
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.fitted_dialog import begin_fitted_dialog
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.toggles import toggles
from lensbench.lenses.editing import attachments
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.search import searched

TITLE = "Attach a lens"
WIDTH, HEIGHT = 24.0, 14.0      # em, of the list
SIDES = {"front": "In front", "behind": "Behind"}
TIPS = {"front": "Between the scene and the lens, as a converter or close-up attachment",
        "behind": "Between the lens and the film, as a teleconverter"}


def attach_dialog(settings: Settings, state: LensTableState) -> Settings:
    """Draw the dialog while `state.attaching`; the settings, changed or not."""
    choice = state.attaching
    if choice is None:
        return settings
    if not begin_fitted_dialog(TITLE):
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
    imgui.set_item_tooltip("Turned round, as with a reversing ring")
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
