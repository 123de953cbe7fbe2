"""The docked windows of the panels: what an error or a missing kernel in one does, and what the lens browser covers.

The columns of the window: laid out for its size, folded when it becomes small, unfolded when it grows again.

Each layout, and each way to fold it, keeps its own arrangement: what a user has moved is there again when the layout is
chosen again, or the window has the room for it. Preferences keep those of the layouts beyond the session.
"""

import json
import math
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

from imgui_bundle import ImVec2, hello_imgui, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.settings.settings import Settings
from lensbench.app.window.layouts import folds, placed, splits
from lensbench.app.window.lens_browsing import LensBrowsing
from lensbench.app.window.state import WindowState, preference
from lensbench.core.kernels.cache import NotCompiledError

FRONT_FRAMES = 3                # a tab of a new dock is in front only after the last panel has come to it
RENDER = "Render"               # the panel in the middle: it needs none of the panels' kernels


class Docking:
    """Windows around the drawings of the panels: an error in one becomes a message, and never ends the window."""

    def __init__(self, window: WindowState, browsing: LensBrowsing):
        self._state, self._browsing = window, browsing
        self._front: dict[str, int] = {}    # panels that come to the front, and in how many frames more
        self._logged: set[str] = set()
        self._failed: dict[str, Settings] = {}          # panels, and the settings at which they failed

    def docked(self, label: str, draw: Callable[[], None], dock: str = "Right",
                padding: float | None = None) -> hello_imgui.DockableWindow:
        """A panel, for hello_imgui. draw: into its window; padding: a margin of its own; it then does not scroll."""
        shown = self.guarded(label, draw, panel=True)
        panel = hello_imgui.DockableWindow(label, dock, lambda: self._window(label, shown, padding),
                                           can_be_closed_=False)
        panel.call_begin_end = False
        panel.remember_is_visible = self._state.remember
        return panel

    def guarded(self, name: str, draw: Callable[[], None], panel: bool = False) -> Callable[[], None]:
        """A callback that cannot end the window: an error is shown, and logged once.

        A panel waits for its kernels, and after an error it is not drawn again until the settings change.
        """
        def call() -> None:
            if panel and name != RENDER and not self._state.prepared:
                self._compiling()
                return
            if name in self._failed:
                if self._failed[name] == self._state.edited:
                    imgui.text_disabled("This panel failed for these settings: change a setting to try again")
                    return
                del self._failed[name]
            drawing = imgui.get_current_context() is not None and imgui.internal.get_current_window_read() is not None
            state = imgui.internal.ErrorRecoveryState()
            if drawing:
                imgui.internal.error_recovery_store_state(state)
            try:
                draw()
            except NotCompiledError as error:
                if drawing:
                    _recover(state)
                self._state.postpone(error)
                if panel and name != RENDER:            # which shows its own progress
                    self._compiling()
            except Exception as error:
                if drawing:
                    _recover(state)
                if panel:
                    self._failed[name] = self._state.edited
                message = f"{name}: {type(error).__name__}: {error}"
                if message not in self._logged:
                    self._logged.add(message)
                    self._state.view.say(message)
                    traceback.print_exc(file=sys.stderr)
            if panel:
                self._state.hurry()
        return call

    def _compiling(self) -> None:
        """The progress of the compilers, instead of a panel that needs a kernel; nothing where none is compiled."""
        if self._state.compilers.busy:
            done, count = self._state.compilers.progress
            imgui.progress_bar(done / count, ImVec2(-1.0, 0.0), f"Compiling  {done} of {count}")
            imgui.set_item_tooltip("The kernels of this panel are compiled once for this version")

    def _window(self, name: str, draw: Callable[[], None], padding: float | None) -> None:
        """A panel in its window. The render lies in the central node and has no tab."""
        panel = hello_imgui.get_runner_params().docking_params.dockable_window_of_name(name)
        if panel is not None and panel.focus_window_at_next_frame:      # hello_imgui does so in windows it begins alone
            panel.focus_window_at_next_frame = False
            self._front[name] = FRONT_FRAMES
        waits = self._front.get(name, 0)
        if waits > 0:
            self._front[name] -= 1
            imgui.set_next_window_focus()
        if name == RENDER:
            one = imgui.WindowClass()
            one.dock_node_flags_override_set = imgui.internal.DockNodeFlagsPrivate_.no_tab_bar
            imgui.set_next_window_class(one)
        c, flags = theme.colours(), imgui.WindowFlags_.no_collapse
        own = name == RENDER or _in_the_dock(name)    # the render fills its background itself
        imgui.push_style_color(imgui.Col_.window_bg, imgui.ImVec4(*c.panel[:3], 0.0 if own else 1.0))
        margin = imgui.get_style().window_padding
        if padding is not None:
            margin = ImVec2(padding * theme.scale(), padding * theme.scale())
            flags = flags | imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse
        imgui.push_style_var(imgui.StyleVar_.window_padding, margin)
        shown, _ = imgui.begin(name, None, flags)
        imgui.pop_style_var()
        imgui.pop_style_color()
        if waits == 1:
            _scroll_to_tab()
        if shown:
            self._uncovered(draw, own)
        imgui.end()

    def _uncovered(self, draw: Callable[[], None], docked: bool) -> None:
        """Draw into the current window what the lens browser leaves in sight of it."""
        corner, size = imgui.get_window_pos(), imgui.get_window_size()
        end, covers = ImVec2(corner.x + size.x, corner.y + size.y), self._browsing.covers
        clips = docked and covers > corner.x
        if covers > corner.x:
            below_tabs = imgui.internal.get_current_window().inner_rect.min.y
            self._browsing.cover((corner.x, below_tabs, end.x, end.y), docked)
        if end.x <= covers:
            return
        if clips:
            if _tabs_end() <= covers:
                _name(ImVec2(covers, corner.y), end)
            imgui.push_clip_rect(ImVec2(covers, corner.y), end, True)
        draw()
        if imgui.internal.get_current_window().dc.is_set_pos:   # else imgui fails outside the guarded panel
            imgui.dummy(ImVec2(0.0, 0.0))
        if clips:
            imgui.pop_clip_rect()


def _scroll_to_tab() -> None:
    """Scroll the tabs of the current window's dock to its own; the focus alone does not."""
    window = imgui.internal.get_current_window()
    tabs = window.dock_node.tab_bar if window.dock_node is not None else None
    tab = imgui.internal.tab_bar_find_tab_by_id(tabs, window.tab_id) if tabs is not None else None
    if tab is not None:
        imgui.internal.tab_bar_queue_focus(tabs, tab)


def _tabs_end() -> float:
    """The right end of the tabs of the current window's dock on the screen (pixels); infinite without tabs."""
    node = imgui.internal.get_current_window().dock_node
    tabs = node.tab_bar if node is not None else None
    return math.inf if tabs is None else tabs.bar_rect.min.x + tabs.width_all_tabs - tabs.scrolling_anim


def _name(corner: ImVec2, end: ImVec2) -> None:
    """Write the name of the current window into the row of its tabs, of which the lens browser leaves none in sight.

    corner, end: upper left and lower right of what it leaves of the window (pixels).
    """
    window, draw, padding = imgui.internal.get_current_window(), imgui.get_window_draw_list(), theme.em(0.8)
    high = window.inner_rect.min.y - corner.y
    draw.push_clip_rect(corner, ImVec2(end.x, corner.y + high), False)
    draw.add_text(ImVec2(round(corner.x + padding), round(corner.y + 0.5 * (high - imgui.get_text_line_height()))),
                  theme.packed(theme.colours().text), window.name.split("###")[0])
    draw.pop_clip_rect()


def _in_the_dock(name: str) -> bool:
    """Whether a panel is docked in the window, and does not float above others."""
    window = imgui.internal.find_window_by_name(name)
    if window is None:
        return True
    return window.dock_node is not None and imgui.internal.dock_node_get_root_node(window.dock_node).is_dock_space()


def _recover(state: imgui.internal.ErrorRecoveryState) -> None:
    """Close the imgui and implot scopes that a panel left open when its error occurred, without a word on stderr."""
    if implot.internal.get_current_plot() is not None:
        implot.end_plot()
    io = imgui.get_io()
    asserting, io.config_error_recovery_enable_assert = io.config_error_recovery_enable_assert, False
    logging, io.config_error_recovery_enable_debug_log = io.config_error_recovery_enable_debug_log, False
    imgui.internal.error_recovery_try_to_recover_state(state)
    io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log = asserting, logging


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
        self._hidden: Arrangement | None = None         # the panels while only the picture is shown
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

    def hide(self) -> None:
        """Hide all panels but the render, or show those again that were hidden."""
        if any(panel.is_visible for panel in _panels() if panel.label != RENDER):
            self._keep()
            self._hidden = self._arranged[_key(self._layout, self._folded)]
            _show([])
        elif self._hidden is not None:
            self._arrangement, self._hidden = self._hidden, None
        else:
            self.lay_out()

    def closed(self) -> None:
        """The window is about to close."""
        if self._window.remember:
            self._keep()
            hello_imgui.save_lasting_pref("folded", json.dumps(self._folded))
            hello_imgui.save_lasting_pref("arrangements", json.dumps(self._arranged))

    def lay_out(self) -> None:
        """Place the panels as the chosen layout has them, for the current size of the window."""
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
        self._window.panels_hidden = not any(panel.is_visible for panel in _panels() if panel.label != RENDER)
        layout = self._window.layout
        if self._window.panels_hidden and layout == self._layout:
            return                              # folded when they are shown again
        now = folds(layout, width, height, em)
        if (layout, now) == (self._layout, self._folded):
            return
        same = layout == self._layout           # folded only: its panels stay shown
        shown = self._keep()
        former = self._arranged.get(_key(layout, now))
        if former is not None:
            self._layout, self._folded = layout, now
            self._arrangement = former._replace(shown=_ordered(shown, former.shown), front=[]) if same else former
            return
        kept = dict(self._arranged)
        self.lay_out()
        self._arranged = kept
        if same:
            _show(shown)

    def _keep(self) -> list[str]:
        """Keep the panels as they lie, or lay before they were hidden; the names of those that are shown."""
        if self._hidden is not None and self._window.panels_hidden:
            self._arranged[_key(self._layout, self._folded)] = self._hidden
            shown, self._hidden = self._hidden.shown, None
            return shown
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
    made_of = {}
    with suppress(ValueError, AttributeError):          # none were kept, or they were damaged: layouts begin anew
        for key, made in json.loads(text or "{}").items():
            with suppress(ValueError, TypeError, KeyError, IndexError):
                layout, folded = json.loads(key)
                made_of[_key(str(layout), dict(folded))] = Arrangement([str(name) for name in made[0]],
                                                               [str(name) for name in made[1]], str(made[2]))
    return made_of


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
    for index, name in enumerate(names):
        window = imgui.internal.find_window_by_name(name)
        bar = window.dock_node.tab_bar if window is not None and window.dock_node is not None else None
        tab = imgui.internal.tab_bar_find_tab_by_id(bar, window.tab_id) if bar is not None else None
        if tab is not None:
            window.dock_order = index
            tab.flags |= UNSORTED


def _show(names: list[str]) -> None:
    """Show these panels, and the render, and no others."""
    for panel in _panels():
        panel.is_visible = panel.label in names or panel.dock_space_name == "MainDockSpace"


def _size() -> tuple[float, float, float]:
    size = imgui.get_main_viewport().size
    return max(size.x, 1.0), max(size.y, 1.0), imgui.get_font_size()
