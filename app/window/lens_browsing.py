"""The lens browser in the window, and the edited lens: autosave, unsaved edits, files that change meanwhile, its title.

Any number of lenses that are tried one after the other are one step of undo; Escape takes it back.
"""

import json
import math
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from time import monotonic, perf_counter

from imgui_bundle import ImVec2, hello_imgui, imgui
from imgui_bundle.glfw_utils import glfw_window_hello_imgui

from lensbench import lenses
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.display.frame import Box
from lensbench.app.display.small_textures import SmallTextures
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import applies, cancels
from lensbench.app.panels.controls.controls import lens_name
from lensbench.app.panels.lens_browser import BrowserState, lens_browser_panel
from lensbench.app.panels.section_pictures import SectionLook
from lensbench.app.session.edited_lens import reverted
from lensbench.app.session.lens_shelf import Shelf, noted
from lensbench.app.session.notices import Request
from lensbench.app.session.states import Autosave, Unsaved, left_behind, unsaved_folder
from lensbench.app.settings.settings import Settings
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.state import WindowState, preference, texts
from lensbench.app.workers.lens_pictures import LensPictures, Pixels, pictures_folder

import glfw  # isort: skip - after imgui_bundle, so that both share one library

TITLE = "Lens browser"
WIDTH = 0.47                    # of the window
LEAST, MOST = 33.0, 66.0        # em
RECENT = 24                     # lenses that are remembered
ENOUGH = 24                     # samples of the window's picture, after which thumbnails are made
REST = 0.3                      # s that the browser rests: its width, until sections are drawn for it, and its grid
SECTION = "1"                   # version of the look of a section: another one draws all of them again


@lru_cache(maxsize=1)
def _cards() -> tuple[lenses.Card, ...]:
    return tuple(lenses.describe())


def outside(box: Box, holes: Iterable[Box]) -> list[Box]:
    """The part of a box that no hole covers, as boxes that do not overlap."""
    parts = [box]
    for left, top, right, bottom in holes:
        cut: list[Box] = []
        for x0, y0, x1, y1 in parts:
            a, b = min(max(left, x0), x1), min(max(right, x0), x1)
            c, d = min(max(top, y0), y1), min(max(bottom, y0), y1)
            if a >= b or c >= d:
                cut.append((x0, y0, x1, y1))
            else:
                around = (x0, y0, x1, c), (x0, d, x1, y1), (x0, c, a, d), (b, c, x1, d)
                cut += [piece for piece in around if piece[0] < piece[2] and piece[1] < piece[3]]
        parts = cut
    return parts


class _Sections:
    """The sections in the browser, drawn in the background; until they are there, those of the look before."""

    def __init__(self, state: WindowState):
        self._window = state
        self._pictures: LensPictures | None = None
        self._shown: dict[str, Pixels] = {}
        self._textures = SmallTextures(self._shown)
        self._look: SectionLook | None = None           # of `_pictures`
        self._wanted: SectionLook | None = None
        self._since = 0.0                               # when it was first wanted

    def begin_frame(self) -> None:
        """Call before the sections of a frame."""
        self._textures.begin_frame()

    def of(self, name: str) -> tuple[int, tuple[int, int]] | None:
        """The texture of a section and its size in pixels; None until it is there."""
        return self._textures.of(name)

    def want(self, look: SectionLook, names: tuple[str, ...]) -> None:
        """Draw these lenses, the first first."""
        now = perf_counter()
        if look != self._wanted:
            self._wanted, self._since = look, now
        if look != self._look and (self._pictures is None or now - self._since > REST):
            self.stop()
            self._look = look
            self._pictures = LensPictures(pictures_folder() if self._window.remember else None, self._window.wake,
                                          look.command, f"section {SECTION} {look}", 1)
        if self._pictures is not None:
            self._pictures.want(names, True)
            self._shown.update(self._pictures.found)

    def stop(self) -> None:
        """End the process that draws them."""
        if self._pictures is not None:
            self._pictures.stop()


class LensBrowsing:
    """Lives as long as the window."""

    def __init__(self, state: WindowState):
        self.state = BrowserState()
        self.is_open = False
        self._window = state
        self._thumbnails: LensPictures | None = None    # from when the browser is first opened
        self._textures: SmallTextures | None = None
        self._sections = _Sections(state)
        self._before: Settings | None = None            # the settings at the opening
        self._tried: Settings | None = None             # with the lens that is tried
        self._top, self._scrolled = 0.0, -math.inf      # place of the grid, and when it last moved
        self._blank: list[Box] = []                     # docked panels, which draw nothing beneath the browser
        self._over_floating = False                     # a floating panel lies beneath it, or above
        self._saved = ""                                # favourites and recent lenses in the preferences

    def load(self) -> None:
        """Read favourites and recent lenses from the preferences."""
        kept, known = preference("lenses", {}), set(lenses.names())
        self.state.favourites = [name for name in texts(kept.get("favourites")) if name in known]
        self.state.recent = [name for name in texts(kept.get("recent")) if name in known]
        self._saved = self._preferences

    @property
    def _preferences(self) -> str:
        return json.dumps({"favourites": self.state.favourites, "recent": self.state.recent})

    @property
    def covers(self) -> float:
        """The right edge of the browser on the screen (pixels); 0 while it is closed."""
        return imgui.get_main_viewport().pos.x + self._width if self.is_open else 0.0

    def cover(self, box: Box, docked: bool) -> None:
        """Note a panel of this frame that the browser covers in part or whole; docked: it draws nothing beneath."""
        if docked:
            self._blank.append(box)
        else:
            self._over_floating = True

    @property
    def _width(self) -> float:
        width = imgui.get_main_viewport().size.x
        return round(min(max(WIDTH * width, theme.em(LEAST)), theme.em(MOST), 0.8 * width))

    @property
    def occupies_processor(self) -> bool:
        """Whether the render has to leave the processor to the browser; it first gets ENOUGH samples.

        To thumbnails that are being made, and to a grid that scrolls where the processor draws it.
        """
        if not self.is_open or not self._picture_is_ready or self._thumbnails is None:
            return False
        scrolls = self._window.presenter.software and perf_counter() - self._scrolled < REST
        return scrolls or self._thumbnails.missing > 0

    @property
    def complete(self) -> bool:
        """Whether every thumbnail is there that the browser, once drawn, asked for."""
        return bool(self.state.in_sight) and self._thumbnails is not None and self._thumbnails.missing == 0

    @property
    def _picture_is_ready(self) -> bool:
        update, worker = self._window.presenter.update, self._window.worker
        if update is None or update.generation != worker.generation:
            return False
        return worker.paused or update.samples >= min(ENOUGH, update.settings.samples)

    def toggle(self) -> None:
        """Open the browser, or close it and keep the lens."""
        if self.is_open:
            self._close()
            return
        self.is_open = True
        self._before, self._tried = self._window.history.present, None
        state = self.state
        state.appearing = state.scroll = True
        state.in_grid = False
        state.selected = self._window.history.present.lens
        if self._thumbnails is None:
            self._thumbnails = LensPictures(pictures_folder() if self._window.remember else None, self._window.wake)
            self._textures = SmallTextures(self._thumbnails.found)

    def show(self, shelf: Shelf) -> None:
        """Open the browser, if it is closed, on these lenses."""
        if not self.is_open:
            self.toggle()
        self.state.shelf = shelf

    def draw(self) -> None:
        """Draw the browser over the left of the window, and do what the user asked there."""
        if not self.is_open or self._thumbnails is None or self._textures is None:
            return
        viewport, state, thumbnails = imgui.get_main_viewport(), self.state, self._thumbnails
        below, status = imgui.get_frame_height(), 1.4 * imgui.get_frame_height()   # both bars stay in sight
        imgui.set_next_window_pos(ImVec2(viewport.work_pos.x, viewport.pos.y + below))
        imgui.set_next_window_size(ImVec2(self._width, viewport.size.y - below - status))
        flags = imgui.WindowFlags_
        shown, _ = imgui.begin(TITLE, None, flags.no_decoration | flags.no_move | flags.no_saved_settings
                               | flags.no_docking | flags.no_nav_inputs)
        if shown:
            self._fill()
            self._textures.begin_frame()
            self._sections.begin_frame()
            lens_browser_panel(_cards(), state, self._textures.of, self._sections.of, thumbnails.problems,
                               thumbnails.missing)
        imgui.end()
        if state.top != self._top:
            self._top, self._scrolled = state.top, perf_counter()
        in_sight = set(state.in_sight)
        names = *state.in_sight, *(card.name for card in _cards() if card.name not in in_sight)
        thumbnails.want(names, self._picture_is_ready)
        if state.section is not None:
            self._sections.want(state.section, names)
        self._answer()

    def _fill(self) -> None:
        """Fill the window where something is drawn beneath it.

        Elsewhere the screen has the colour of the panels already; to fill it again takes a renderer on the processor
        10 ns a pixel.
        """
        corner, size, draw = imgui.get_window_pos(), imgui.get_window_size(), imgui.get_window_draw_list()
        whole = corner.x, corner.y, corner.x + size.x, corner.y + size.y
        draw.push_clip_rect(ImVec2(*whole[:2]), ImVec2(*whole[2:]))
        for left, top, right, bottom in outside(whole, () if self._over_floating else self._blank):
            draw.add_rect_filled(ImVec2(left, top), ImVec2(right, bottom), theme.packed(theme.colours().panel))
        draw.pop_clip_rect()
        self._blank, self._over_floating = [], False

    def _answer(self) -> None:
        state, window = self.state, self._window
        name, state.tried = state.tried, ""
        if name and name != window.history.present.lens:
            self._try(name)
        if state.opens_file:
            state.opens_file = False
            window.requests.add(Request.OPEN)
            self._close()
        elif state.returned:
            state.returned = state.kept = False
            self._return()
        elif state.kept:
            state.kept = False
            self._close()
        if self._preferences != self._saved:
            self._saved = self._preferences
            if window.remember:
                hello_imgui.save_lasting_pref("lenses", self._saved)

    def _try(self, name: str) -> None:
        """Take a lens instead of the one that was tried before it."""
        window = self._window
        start = window.history.present
        if start == self._tried and self._before is not None:
            start = self._before
        try:
            chosen = window.showable(with_lens(start, name, window.chooser.locked))
        except (ValueError, OSError) as error:
            window.view.say(str(error))
            return
        if window.history.present == self._tried:
            window.history.undo()
        self._before, self._tried = start, chosen
        window.take(chosen)

    def _return(self) -> None:
        """Take the lens before again, and close."""
        window = self._window
        if self._tried is not None and window.history.present == self._tried:
            window.edited = window.history.undo()
            window.apply()
        elif self._tried is not None and self._before is not None:
            window.take(self._before)                   # something else was changed meanwhile
        self.is_open = False

    def _close(self) -> None:
        """Close and keep the lens that is tried."""
        self.is_open = False
        if self._tried is not None:
            self._window.say_moved(self._window.history.present, self._before)
            self.state.recent = noted(self.state.recent, self._window.history.present.lens, RECENT)

    def closed(self) -> None:
        """The window is about to close."""
        if self._thumbnails is not None:
            self._thumbnails.stop()
        self._sections.stop()


PAUSE = 1.0                     # seconds between two autosaves
OFFER, CHANGED = "Unsaved edits", "The lens file has changed"
NAME = "lensbench"


class LensEditing:
    """Lives as long as the window. folder: of unsaved edits; None keeps none."""

    def __init__(self, window: WindowState, folder: Path | None = None):
        self._window = window
        self._folder = folder if folder is not None else unsaved_folder() if window.remember else None
        self._autosave = Autosave(self._folder) if self._folder is not None else None
        self._next = 0.0
        self._offers: list[Unsaved] = []
        self._changed: str | None = None                # the file that has changed on disk
        self._title = ""
        self._problem = ""
        self._before = window.history.present           # in the frame before
        self._edited_name = ""                          # of the lens whose edits are kept
        if self._folder is not None:
            current = window.history.present
            self._keep(current)
            for unsaved in left_behind(self._folder):
                if (unsaved.settings.lens, unsaved.settings.edited) == (current.lens, current.edited):
                    unsaved.remove()               # the last session is open again, with these edits
                else:
                    self._offers.append(unsaved)

    @property
    def offers(self) -> int:
        """How many unsaved edits of earlier windows are still to be answered."""
        return len(self._offers)

    def file_changed(self, name: str) -> None:
        """The file of an edited lens has changed on disk: ask before anything is replaced."""
        self._changed = name

    def advance(self, is_held: bool) -> None:
        """Once a frame, after the panels: keep the edits on disk, and name the lens in the title of the window."""
        current = self._window.history.present
        title = f"{lens_name(current)} – {NAME}" if current.edited else NAME
        if title != self._title:
            self._title = title
            with suppress(glfw.GLFWError):
                glfw.set_window_title(glfw_window_hello_imgui(), title)
        before, self._before = self._before, current
        if before.lens != current.lens:
            if before.edited:                           # they may be younger than the autosave
                self._keep(before)
            self._keep(current)
        elif not is_held and monotonic() >= self._next:
            self._next = monotonic() + PAUSE
            self._keep(current)

    def closed(self) -> None:
        """The window is about to close: what is not saved is offered at the next start."""
        self._keep(self._window.history.present)

    def _keep(self, settings: Settings) -> bool:
        """Keep the edits of these settings on disk; False, with a message, where that cannot be."""
        if self._autosave is None:
            return False
        try:
            if self._autosave.keep(settings, self._window.written):
                self._window.view.say(f"The edits of {self._edited_name} are not saved: Ctrl+Z brings them back, and "
                                      "the next start offers them", note=True, change=True)
            self._edited_name = lens_name(settings).removesuffix(" *") if settings.edited else ""
        except (OSError, ValueError) as error:
            if self._problem != str(error):
                self._problem = str(error)
                self._window.view.say(f"Unsaved edits cannot be kept on disk: {error}")
            return False
        return True

    def draw(self) -> None:
        """The two questions, over the panels."""
        if self._offers:
            self._offer(self._offers[0])
        elif self._changed is not None:
            self._ask_reload(self._changed)

    def _offer(self, unsaved: Unsaved) -> None:
        if not _dialog(OFFER):
            return
        when = datetime.fromtimestamp(unsaved.written).strftime("%d %b, %H:%M")
        imgui.text_wrapped(f"{lens_name(unsaved.settings).removesuffix(' *')} was changed and not saved ({when}).")
        imgui.dummy(imgui.ImVec2(0.0, theme.em(0.4)))
        if applies("Restore"):
            with suppress(ValueError, OSError):
                self._window.take(self._window.showable(unsaved.settings))
                self._before = self._window.history.present
                if self._keep(self._before):            # else the former file is the only one
                    unsaved.remove()
            self._offers.pop(0)
            imgui.close_current_popup()
        imgui.same_line()
        if imgui.button("Discard"):
            unsaved.remove()
            self._offers.pop(0)
            imgui.close_current_popup()
        imgui.set_item_tooltip("These edits are deleted")
        imgui.same_line()
        if cancels("Ask again later"):
            self._offers.clear()
            imgui.close_current_popup()
        imgui.end_popup()

    def _ask_reload(self, name: str) -> None:
        if not _dialog(CHANGED):
            return
        window = self._window
        imgui.text_wrapped(f"{Path(name).name} has changed on disk, and the lens has edits that are not saved.")
        imgui.dummy(imgui.ImVec2(0.0, theme.em(0.4)))
        if applies("Keep my edits") or imgui.is_key_pressed(imgui.Key.escape):
            self._changed = None
            imgui.close_current_popup()
        imgui.set_item_tooltip("The file stays as it is; saving will replace it")
        imgui.same_line()
        if imgui.button("Load the file"):
            self._changed = None
            if window.history.present.lens == name:
                window.take(reverted(window.history.present))
            imgui.close_current_popup()
        imgui.set_item_tooltip("Undo brings the edits back")
        imgui.end_popup()


def _dialog(title: str) -> bool:
    """Begin a small dialog in the middle of the window."""
    if not imgui.is_popup_open(title):
        imgui.open_popup(title)
    centre_next(26.0)
    flags = imgui.WindowFlags_.no_saved_settings | imgui.WindowFlags_.no_resize
    return imgui.begin_popup_modal(title, None, flags)[0]
