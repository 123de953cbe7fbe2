"""The window *What the terms mean*, behind the “?” of the menu bar."""

from imgui_bundle import ImVec2, ImVec4, imgui

from lensbench.app.state.terms import TERMS
from lensbench.app.widgets import theme
from lensbench.app.window.dialogs import centre_next

NAME = "What the terms mean"
WIDTH, HIGHEST = 38.0, 40.0     # em


class Terms:
    """State between frames."""

    def __init__(self) -> None:
        self._opens, self._query = False, ""

    def open(self) -> None:
        """Show it from the next `draw` on."""
        self._opens = True

    def draw(self) -> None:
        """Call it in every frame."""
        begins, self._opens = self._opens, False
        if begins:
            self._query = ""
            imgui.open_popup(NAME)
        centre_next(WIDTH)
        area = imgui.get_main_viewport().work_size
        height = min(theme.em(HIGHEST), 0.9 * area.y)
        imgui.set_next_window_size(ImVec2(min(theme.em(WIDTH), 0.95 * area.x), height))
        shown, _ = imgui.begin_popup_modal(NAME, True, imgui.WindowFlags_.no_saved_settings
                                           | imgui.WindowFlags_.no_resize)
        if not shown:
            return
        if begins:
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1.0)
        _, self._query = imgui.input_text_with_hint("##Term", "A word or a letter, such as CoC", self._query)
        imgui.begin_child("Terms")
        found = sum(_group(title, self._query) for title in TERMS)
        if not found:
            imgui.text_disabled("No such term")
        imgui.end_child()
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()


def _group(title: str, query: str) -> int:
    """Draw the terms of a group that hold the query; returns how many."""
    wanted = query.casefold().strip()
    found = [term for term in TERMS[title] if wanted in f"{term.name} {term.symbol}".casefold()
             or len(wanted) > 2 and wanted in term.meaning.casefold()]
    if not found:
        return 0
    colour = theme.colours()
    imgui.dummy(ImVec2(0.0, theme.em(0.2)))
    imgui.text_disabled(title)
    for term in found:
        imgui.text_colored(ImVec4(*colour.strong), term.name)
        if term.symbol:
            imgui.same_line()
            imgui.text_disabled(term.symbol)
        imgui.push_text_wrap_pos(0.0)
        imgui.text_unformatted(term.meaning)
        imgui.pop_text_wrap_pos()
        imgui.dummy(ImVec2(0.0, theme.em(0.15)))
    return len(found)
