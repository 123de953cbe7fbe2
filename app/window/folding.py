"""The columns of the window: laid out for its size, folded when it becomes small, unfolded when it grows again.

Each way to fold keeps its own arrangement while the window is open: what a user has moved is there again when the
window has the room for it.
"""

import json
from contextlib import suppress

from imgui_bundle import hello_imgui, imgui

from lensbench.app.window.layouts import folds, placed, splits
from lensbench.app.window.state import WindowState

MINIMUM = (640, 400)            # of the window, in pixels at a scale of 1
SETTLED = 5                     # frames until window and font have their size


class Folding:
    """Lays out the panels of a window."""

    def __init__(self, window: WindowState):
        self._window = window
        self._laid_out_for: tuple[float, float, float] = (0.0, 0.0, 0.0)    # width, height, em
        self._folded: dict[str, str] = {}
        self._arranged: dict[str, str] = {}     # arrangements of this session, as imgui writes them
        self._arrangement: str | None = None    # the one that the next frame begins with
        self._fresh = False                     # no layout was saved by an earlier session
        self._frames = 0

    def first(self, runner: hello_imgui.RunnerParams, panels: list[hello_imgui.DockableWindow],
              size: tuple[float, float, float]) -> None:
        """Lay out the window that is about to open. size: its width and height in pixels, and its em."""
        layout = self._window.layout
        self._laid_out_for, self._folded = size, folds(layout, *size)
        runner.docking_params.docking_splits = splits(layout, *size)
        runner.docking_params.dockable_windows = placed(layout, self._folded, panels)
        runner.callbacks.pre_new_frame = self._arrange

    def opened(self) -> None:
        """The window is open; the preferences know how the last session had folded it."""
        self._fresh = not hello_imgui.has_ini_settings(hello_imgui.get_runner_params())
        if self._window.remember and not self._fresh:
            with suppress(ValueError):
                self._folded = dict(json.loads(hello_imgui.load_lasting_pref("folded") or "{}"))

    def closed(self) -> None:
        """The window is about to close."""
        if self._window.remember:
            hello_imgui.save_lasting_pref("folded", json.dumps(self._folded))

    def lay_out(self) -> None:
        """Place the panels as the chosen layout has them, for the present size of the window."""
        self._laid_out_for = width, height, em = _size()
        layout, docking = self._window.layout, hello_imgui.get_runner_params().docking_params
        self._arranged.clear()
        self._folded = folds(layout, width, height, em)
        docking.docking_splits = splits(layout, width, height, em)
        docking.dockable_windows = placed(layout, self._folded, list(docking.dockable_windows))
        docking.layout_reset = True

    def advance(self) -> None:
        """Fold or unfold, if the size of the window asks for it; call it once a frame."""
        self._frames += 1
        style, none = imgui.get_style(), imgui.Dir.none       # a dock of many panels lists them behind a triangle
        style.window_menu_button_position = imgui.Dir.left if self._folded else none
        known = width, height, em = _size()
        if self._fresh and self._frames in (2, SETTLED) and known != self._laid_out_for:
            self.lay_out()              # the first guess was wrong
            return
        if self._frames <= SETTLED or width < 10.0 * em or height < 10.0 * em:      # a minimised window stays
            return
        now = folds(self._window.layout, width, height, em)
        if now == self._folded:
            return
        arranged = self._arranged
        arranged[json.dumps(self._folded)] = imgui.save_ini_settings_to_memory()
        if json.dumps(now) in arranged:
            self._folded, self._arrangement = now, arranged[json.dumps(now)]
            return
        panels = hello_imgui.get_runner_params().docking_params.dockable_windows
        shown = {panel.label: panel.is_visible for panel in panels}
        kept = dict(arranged)
        self.lay_out()
        self._arranged = kept
        for panel in hello_imgui.get_runner_params().docking_params.dockable_windows:
            panel.is_visible = shown[panel.label]

    def _arrange(self) -> None:
        """Before a frame: imgui takes an arrangement between frames only."""
        if self._arrangement is not None:
            imgui.load_ini_settings_from_memory(self._arrangement)
            imgui.set_window_focus(None)     # the focused window would come to the front of its dock
            self._arrangement = None


def _size() -> tuple[float, float, float]:
    size = imgui.get_main_viewport().size
    return max(size.x, 1.0), max(size.y, 1.0), imgui.get_font_size()
