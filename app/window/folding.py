"""The columns of the window: laid out for its size, folded when it becomes small, unfolded when it grows again.

Each layout, and each way to fold it, keeps its own arrangement: what a user has moved is there again when the layout is
chosen again, or the window has the room for it. Preferences keep those of the layouts beyond the session.
"""

import json
from contextlib import suppress
from typing import NamedTuple

from imgui_bundle import hello_imgui, imgui

from lensbench.app.window.layouts import folds, placed, splits
from lensbench.app.window.preference import preference
from lensbench.app.window.state import WindowState

MINIMUM = (640, 400)            # of the window, in pixels at a scale of 1
UNSORTED = imgui.internal.TabItemFlagsPrivate_.unsorted      # a tab that imgui has to sort
SETTLED = 5                     # frames until window and font have their size


class Arrangement(NamedTuple):
    """Panels as they were left: the names of those shown, in the order of their tabs, of those in front, and all
    places as imgui writes them.
    """

    shown: list[str]
    front: list[str]
    places: str


class Folding:
    """Lays out the panels of a window."""

    def __init__(self, window: WindowState):
        self._window = window
        self._laid_out_for: tuple[float, float, float] = (0.0, 0.0, 0.0)    # width, height, em
        self._folded: dict[str, str] = {}
        self._layout = window.layout            # as the panels lie
        self._arranged: dict[str, Arrangement] = {}     # by layout and folds
        self._arrangement: Arrangement | None = None    # the one that the next frame begins with
        self._order: list[str] = []             # of the tabs of the arrangement that the frame before has begun with
        self._fresh = False                     # no layout was saved by an earlier session
        self._frames = 0

    def first(self, runner: hello_imgui.RunnerParams, panels: list[hello_imgui.DockableWindow],
              size: tuple[float, float, float]) -> None:
        """Lay out the window that is about to open. size: its width and height in pixels, and its em."""
        layout = self._layout = self._window.layout
        self._laid_out_for, self._folded = size, folds(layout, *size)
        runner.docking_params.docking_splits = splits(layout, *size)
        runner.docking_params.dockable_windows = placed(layout, self._folded, panels)
        runner.callbacks.pre_new_frame = self._arrange

    def opened(self) -> None:
        """The window is open; the preferences know how the last session had folded it, and its arrangements."""
        self._fresh = not hello_imgui.has_ini_settings(hello_imgui.get_runner_params())
        self._layout = self._window.layout
        if self._window.remember and not self._fresh:
            folded = preference("folded", {})
            self._folded = {name: dock for name, dock in folded.items() if isinstance(dock, str)}
            self._arranged = arrangements(hello_imgui.load_lasting_pref("arrangements"))
            self._arrangement = self._arranged.get(_key(self._layout, self._folded))

    def closed(self) -> None:
        """The window is about to close."""
        if self._window.remember:
            self._keep()
            hello_imgui.save_lasting_pref("folded", json.dumps(self._folded))
            hello_imgui.save_lasting_pref("arrangements", json.dumps(self._arranged))

    def lay_out(self) -> None:
        """Place the panels as the chosen layout has them, for the present size of the window."""
        self._laid_out_for = width, height, em = _size()
        layout, docking = self._window.layout, hello_imgui.get_runner_params().docking_params
        self._layout = layout
        for key in [key for key in self._arranged if json.loads(key)[0] == layout]:
            del self._arranged[key]
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
        layout = self._window.layout
        now = folds(layout, width, height, em)
        if (layout, now) == (self._layout, self._folded):
            return
        same = layout == self._layout           # folded only: its panels stay shown
        shown = self._keep()
        found = self._arranged.get(_key(layout, now))
        if found is not None:
            self._layout, self._folded = layout, now
            self._arrangement = found._replace(shown=_ordered(shown, found.shown), front=[]) if same else found
            return
        kept = dict(self._arranged)
        self.lay_out()
        self._arranged = kept
        if same:
            _show(shown)

    def _keep(self) -> list[str]:
        """Keep the panels as they lie; the names of those that are shown."""
        shown = sorted((panel.label for panel in _panels() if panel.is_visible), key=_tab)
        front = [name for name in shown if self._window.panel_shown(name)]
        made = Arrangement(shown, front, imgui.save_ini_settings_to_memory())
        self._arranged[_key(self._layout, self._folded)] = made
        return shown

    def _arrange(self) -> None:
        """Before a frame: imgui takes an arrangement between frames only."""
        _order_tabs(self._order)
        self._order = []
        if self._arrangement is not None:
            _show(self._arrangement.shown)
            for panel in _panels():             # one that appears comes to the front of its dock
                panel.focus_window_at_next_frame = panel.label in self._arrangement.front
            imgui.load_ini_settings_from_memory(self._arrangement.places)
            imgui.set_window_focus(None)     # the focused window would come to the front of its dock
            self._order, self._arrangement = self._arrangement.shown, None


def arrangements(text: str) -> dict[str, Arrangement]:
    """The arrangements that a preference holds, by layout and folds; those that cannot be read are left out."""
    found = {}
    with suppress(ValueError, AttributeError):          # none were kept, or they were damaged: layouts begin anew
        for key, made in json.loads(text or "{}").items():
            with suppress(ValueError, TypeError, KeyError, IndexError):
                layout, folded = json.loads(key)
                found[_key(str(layout), dict(folded))] = Arrangement([str(name) for name in made[0]],
                                                               [str(name) for name in made[1]], str(made[2]))
    return found


def _key(layout: str, folded: dict[str, str]) -> str:
    """A layout and the way in which it is folded, in words."""
    return json.dumps([layout, folded])


def _panels() -> list[hello_imgui.DockableWindow]:
    return list(hello_imgui.get_runner_params().docking_params.dockable_windows)


def _tab(name: str) -> int:
    """The place of a panel among the tabs of its dock, from 0; -1 without any."""
    window = imgui.internal.find_window_by_name(name)
    return -1 if window is None else window.dock_order


def _ordered(names: list[str], order: list[str]) -> list[str]:
    """The names in this order, those that it lacks last."""
    return sorted(names, key=lambda name: order.index(name) if name in order else len(order))


def _order_tabs(names: list[str]) -> None:
    """Let imgui sort the tabs of these panels again: it has put those that were shown before the others first."""
    for place, name in enumerate(names):
        window = imgui.internal.find_window_by_name(name)
        bar = window.dock_node.tab_bar if window is not None and window.dock_node is not None else None
        tab = imgui.internal.tab_bar_find_tab_by_id(bar, window.tab_id) if bar is not None else None
        if tab is not None:
            window.dock_order = place
            tab.flags |= UNSORTED


def _show(names: list[str]) -> None:
    """Show these panels, and the render, and no others."""
    for panel in _panels():
        panel.is_visible = panel.label in names or panel.dock_space_name == "MainDockSpace"


def _size() -> tuple[float, float, float]:
    size = imgui.get_main_viewport().size
    return max(size.x, 1.0), max(size.y, 1.0), imgui.get_font_size()
