"""The dialog *Contact sheet*: which lenses are rendered in the current framing, and how large."""

import re
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, paragraph, warning
from lensbench.app.panels.controls.controls import lens_title
from lensbench.app.panels.lens_browser import BrowserState
from lensbench.app.session.contact_sheet import MOST, found_lenses
from lensbench.app.session.lens_shelf import film_name
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_f_number
from lensbench.app.window.dialogs import centre_next

TITLE = "Contact sheet"


class ContactSheetDialog:
    """Lives as long as the window. requests: of the window. sheet: settings and lenses that were asked for last."""

    def __init__(self, requests: set[Request]):
        self.sheet: tuple[Settings, list[str]] | None = None
        self._requests, self._opens = requests, False
        self._text = self._problem = ""
        self._names: list[str] = []                     # that can be chosen
        self._chosen: set[str] = set()
        self._side, self._samples = 480, 64

    def open(self, settings: Settings) -> None:
        """Show the dialog, with lenses of the focal length of these settings."""
        length = re.search(r"\d+(?= mm)", lens_title(settings.lens)) if settings.has_lens else None
        self._opens = True
        self._search(f"six {length[0] if length else 50} mm lenses")

    def _search(self, text: str) -> None:
        self._text, self._problem = text, ""
        try:
            self._names, count = found_lenses(text)
        except ValueError as error:
            self._names, count, self._problem = [], 0, str(error)
        self._chosen = set(self._names[:count])

    def _take(self, names: list[str]) -> None:
        """Choose these lenses, of the browser."""
        self._names, self._problem, self._text = names[:MOST], "", ""
        self._chosen = set(self._names[:12])

    def draw(self, settings: Settings, browser: BrowserState) -> None:
        """Call it in every frame."""
        if self._opens:
            imgui.open_popup(TITLE)
            self._opens = False
        centre_next(34.0)
        flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize
        if not imgui.begin_popup_modal(TITLE, None, flags)[0]:
            return
        entered = imgui.is_key_pressed(imgui.Key.enter, False) and not imgui.is_any_item_active()   # not in a field
        self._lenses(browser)
        self._size(settings)
        names = [name for name in self._names if name in self._chosen]
        imgui.begin_disabled(not names)
        if imgui.button("Render…", ImVec2(theme.em(6.0), 0.0)) or entered and names:
            sized = with_longer_side(settings, self._side)
            self.sheet = replace(sized, samples=self._samples), names
            self._requests.add(Request.SAVE_SHEET)
            imgui.close_current_popup()
        imgui.end_disabled()
        imgui.set_item_tooltip("Choose the file; the sheet is rendered in the background, with progress in the status "
                               "bar")
        imgui.same_line()
        if imgui.button("Cancel", ImVec2(theme.em(6.0), 0.0)) or imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()

    def _lenses(self, browser: BrowserState) -> None:
        """What is searched, and the lenses with a box each."""
        imgui.set_next_item_width(-theme.em(13.5))
        changed, text = imgui.input_text_with_hint("##Lenses", "six 50 mm lenses", self._text)
        imgui.set_item_tooltip("How many lenses, and which: six 50 mm lenses, four macro lenses, Zeiss 85 mm")
        if changed:
            self._search(text)
        for title, names, tip in (("Favourites", browser.favourites, "The lenses with a star in the lens browser"),
                                  ("Browser", list(browser.in_sight), "The first lenses that the lens browser shows")):
            imgui.same_line()
            imgui.begin_disabled(not names)
            if imgui.button(title, ImVec2(theme.em(6.3), 0.0)):
                self._take(names)
            imgui.end_disabled()
            imgui.set_item_tooltip(tip)
        if imgui.begin_child("Chosen", ImVec2(0.0, theme.em(13.0)), imgui.ChildFlags_.frame_style):
            for name in self._names:
                if check_box(f"{lens_title(name)}###{name}", name in self._chosen):
                    self._chosen.add(name)
                else:
                    self._chosen.discard(name)
        imgui.end_child()
        if self._problem:
            warning(self._problem)

    def _size(self, settings: Settings) -> None:
        """Pixels and samples of each picture, and what all have in common."""
        for label, name, bounds in (("px along the longer side of each", "_side", (48, 4000)),
                                    ("samples a pixel", "_samples", (1, 100_000))):
            imgui.set_next_item_width(theme.em(5.0))
            _, value = imgui.input_int(f"{label}###{name}", getattr(self, name), 0)
            setattr(self, name, min(max(value, bounds[0]), bounds[1]))
        f_number = settings.f_number
        aperture = "wide open" if f_number is None else f"{format_f_number(f_number)} where it opens so far"
        paragraph(f"{len(self._chosen)} lenses: each on {film_name((settings.film_width, settings.film_height))}, "
                  f"{aperture}, with the subject framed and in focus")
