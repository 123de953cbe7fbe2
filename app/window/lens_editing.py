"""The edited lens in the window: autosave, the offer of unsaved edits, files that change meanwhile, and its title."""

from contextlib import suppress
from datetime import datetime
from pathlib import Path
from time import monotonic

from imgui_bundle import imgui
from imgui_bundle.glfw_utils import glfw_window_hello_imgui

import glfw  # isort: skip - after imgui_bundle, so that both share one library

from lensbench.app.drawing import theme
from lensbench.app.panels.controls.controls import lens_name
from lensbench.app.session.edited_lens import reverted
from lensbench.app.session.states import Autosave, Unsaved, left_behind, unsaved_folder
from lensbench.app.settings.settings import Settings
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.state import WindowState

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
            present = window.history.present
            self._keep(present)
            for each in left_behind(self._folder):
                if (each.settings.lens, each.settings.edited) == (present.lens, present.edited):
                    each.remove()               # the last session is open again, with these edits
                else:
                    self._offers.append(each)

    @property
    def offers(self) -> int:
        """How many unsaved edits of earlier windows are still to be answered."""
        return len(self._offers)

    def file_changed(self, name: str) -> None:
        """The file of an edited lens has changed on disk: ask before anything is replaced."""
        self._changed = name

    def advance(self, held: bool) -> None:
        """Once a frame, after the panels: keep the edits on disk, and name the lens in the title of the window."""
        present = self._window.history.present
        title = f"{lens_name(present)} – {NAME}" if present.edited else NAME
        if title != self._title:
            self._title = title
            with suppress(glfw.GLFWError):
                glfw.set_window_title(glfw_window_hello_imgui(), title)
        before, self._before = self._before, present
        if before.lens != present.lens:
            if before.edited:                           # they may be younger than the autosave
                self._keep(before)
            self._keep(present)
        elif not held and monotonic() >= self._next:
            self._next = monotonic() + PAUSE
            self._keep(present)

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
        if imgui.button("Restore"):
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
        if imgui.button("Ask again later") or imgui.is_key_pressed(imgui.Key.escape):
            self._offers.clear()
            imgui.close_current_popup()
        imgui.end_popup()

    def _ask_reload(self, name: str) -> None:
        if not _dialog(CHANGED):
            return
        window = self._window
        imgui.text_wrapped(f"{Path(name).name} has changed on disk, and the lens has edits that are not saved.")
        imgui.dummy(imgui.ImVec2(0.0, theme.em(0.4)))
        if imgui.button("Keep my edits") or imgui.is_key_pressed(imgui.Key.escape):
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
