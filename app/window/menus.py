"""The menus, the keys, and the help on both."""

from dataclasses import replace
from pathlib import Path

from imgui_bundle import hello_imgui, imgui

from lensbench.app.panels.image.magnifier import toggle_magnifier
from lensbench.app.state.pose import at_home
from lensbench.app.state.request import Request
from lensbench.app.state.settings import VIEWS, Settings
from lensbench.app.widgets import theme
from lensbench.app.window.analyses import PANELS
from lensbench.app.window.dialogs import centre_next
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import WindowState
from lensbench.lenses import WRITERS

KEYS = (
    ("Click in the picture", "focus there"),
    ("Drag · wheel", "orbit about the point in focus · dolly"),
    ("Shift + drag, right drag", "pan"),
    ("Ctrl + wheel · Ctrl + drag", "zoom the picture · move it"),
    ("F · 1 · Home", "whole picture · 100 % · camera back to its start"),
    ("I · Alt + click · Escape", "pin the pixel under the mouse, to follow its rays · unpin it"),
    ("M · Alt + wheel", "magnifier with pixel values · its magnification"),
    ("P · C · Z · H · V", "peaking · circles of confusion · clipping · histogram · next view"),
    ("A · S · W · D", "pin the picture as A · compare side by side · by a wipe · their difference"),
    ("K", "lock the dials of A to those of B"),
    ("Space · R", "pause · restart the render"),
    ("Ctrl + Z · Ctrl + Shift + Z", "undo · redo"),
    ("L", "lens browser: click or arrows try, Enter keeps, Escape returns"),
    ("Ctrl + O · Ctrl + E · Ctrl + S", "open a lens · export · save the picture"),
    ("On a dial", "drag, click, wheel; Ctrl + click types, double click resets"),
    ("In a plot", "drag to pan, wheel to zoom, double click to fit"),
)
NOTHING_PINNED = "Nothing to compare with yet: pin a picture as A first (A)"
CTRL, SHIFT, KEY = imgui.Key.mod_ctrl, imgui.Key.mod_shift, imgui.Key
MODIFIERS = int(imgui.Key.mod_mask_)


def menus(state: WindowState) -> None:
    """File, Edit, View and Help in the menu bar."""
    for name, content in (("File", _file_menu), ("Edit", _edit_menu), ("View", _view_menu), ("Help", _help_menu)):
        if imgui.begin_menu(name):
            content(state)
            imgui.end_menu()


def _file_menu(state: WindowState) -> None:
    history = state.history
    if _item("Lens browser…", "L"):
        state.requests.add(Request.BROWSE_LENSES)
    for name, request, key in (("Open lens…", Request.OPEN_LENS, "Ctrl+O"), ("Open scene…", Request.OPEN_SCENE, ""),
                               ("Open picture…", Request.OPEN_PICTURE, ""),
                               ("Open settings…", Request.OPEN_SETTINGS, ""),
                               ("Open light field…", Request.OPEN_LIGHT_FIELD, "")):
        if _item(name, key):
            state.requests.add(request)
    if imgui.begin_menu("Recent", bool(state.recent)):
        for path in list(state.recent):
            if _item(_short(path)):
                state.reopened = path
            imgui.set_item_tooltip(str(path))
        imgui.end_menu()
    imgui.separator()
    if _item("Save lens…", enabled=history.present.has_lens):
        state.requests.add(Request.SAVE_LENS)
    imgui.set_item_tooltip(f"The suffix sets the format: {' '.join(WRITERS)}")
    if _item("Save settings…"):
        state.requests.add(Request.SAVE_SETTINGS)
    if _item("Export…", "Ctrl+E"):
        state.requests.add(Request.EXPORT)
    if _item("Screenshot of render…", "Ctrl+S"):
        state.requests.add(Request.SAVE_RENDER)
    if _item("Screenshot of window…"):
        state.requests.add(Request.SAVE_WINDOW)
    imgui.separator()
    if _item("Quit", "Ctrl+Q"):
        hello_imgui.get_runner_params().app_shall_exit = True


def _edit_menu(state: WindowState) -> None:
    history = state.history
    if _item("Undo", "Ctrl+Z", history.can_undo):
        undo(state)
    if _item("Redo", "Ctrl+Shift+Z", history.can_redo):
        redo(state)
    imgui.separator()
    if _item("Reset all"):
        state.edited = replace(Settings(), lens=history.present.lens, scene=history.present.scene)
        state.edited = _reachable(state.edited)
        state.history.edit(state.edited, False, 0.0)


def _view_menu(state: WindowState) -> None:
    runner = hello_imgui.get_runner_params()
    panels = runner.docking_params.dockable_windows
    if imgui.begin_menu("Layout"):
        for name, layout in LAYOUTS.items():
            if _item(name, "", True, state.layout == name):
                state.choose_layout(name)
            imgui.set_item_tooltip(layout.about)
        imgui.end_menu()
    if imgui.begin_menu("Analysis"):
        _panels([panel for panel in panels if panel.label in PANELS])
        imgui.end_menu()
    _panels([panel for panel in panels if panel.label not in (*PANELS, "Render")])
    imgui.separator()
    if _item("Pin pixel", "I", state.view.links.pinned is not None or state.view.pointed is not None,
             state.view.links.pinned is not None):
        toggle_pin(state)
    imgui.set_item_tooltip("Keep the pixel that the mouse was on last: its rays stay in the section, the exit pupil, "
                           "the plan and the panel “Pixel”")
    if _item("Magnifier", "M", True, state.view.magnifier > 0):
        toggle_magnifier(state.view)
    imgui.set_item_tooltip("Magnify the pixels at the mouse, with their values; Alt + wheel sets the magnification")
    if _item("Reset camera", "Home"):
        state.edited = at_home(state.edited)
    imgui.separator()
    if _item("Dark theme", "", True, state.dark):
        state.choose_theme(True)
    if _item("Light theme", "", True, not state.dark):
        state.choose_theme(False)
    imgui.separator()
    if _item("Reset layout"):
        state.requests.add(Request.RESET_LAYOUT)
    imgui.set_item_tooltip("Every panel of the layout back in its place, for the present size of the window")


def _panels(panels: list[hello_imgui.DockableWindow]) -> None:
    """Show and hide panels; one that is shown comes to the front of its dock."""
    for panel in panels:
        if _item(panel.label, "", True, panel.is_visible):
            panel.is_visible = not panel.is_visible
            panel.focus_window_at_next_frame = panel.is_visible


def _help_menu(state: WindowState) -> None:
    if _item("Keys and mouse", "F1"):
        state.requests.add(Request.SHOW_HELP)


def _item(name: str, key: str = "", enabled: bool = True, checked: bool = False) -> bool:
    return imgui.menu_item(name, key, checked, enabled)[0]


def _short(path: Path) -> str:
    return path.name if len(path.name) <= 40 else f"{path.name[:20]}…{path.name[-18:]}"


def _reachable(settings: Settings) -> Settings:
    from lensbench.app.state.constraints import constrained

    try:
        return constrained(settings)
    except (ValueError, OSError):
        return Settings()


def undo(state: WindowState) -> None:
    """Take back the latest change, unless a mouse button is held."""
    if not any(imgui.is_mouse_down(button) for button in range(3)) or imgui.is_popup_open(
            "", imgui.PopupFlags_.any_popup_id):
        state.edited = state.history.undo()


def redo(state: WindowState) -> None:
    """Bring back the change that `undo` took back."""
    state.edited = state.history.redo()


def toggle_pin(state: WindowState) -> None:
    """Unpin the pinned pixel, or pin the one under the mouse, or the one that the mouse was on last."""
    at, film = state.view.links.hover or state.view.pointed, state.history.present.film
    if state.view.links.pinned is not None or at is not None:
        state.view.links.toggle_pin((at[0] / film.pixels_x, at[1] / film.pixels_y) if at is not None else (0.0, 0.0))


class Keyboard:
    """The keys pressed in a frame, with the modifiers that were held at any time since the frame before.

    On slow frames Ctrl may be released in the frame in which Z is pressed: imgui then reports Z alone.
    """

    def __init__(self) -> None:
        self._before = self._held = 0

    def advance(self) -> None:
        """Call it once a frame."""
        now = int(imgui.get_io().key_mods)
        self._held, self._before = now | self._before, now

    def pressed(self, chord: int) -> bool:
        """Whether this key was pressed with exactly these modifiers."""
        modifiers = int(chord) & MODIFIERS
        return modifiers == self._held and imgui.is_key_pressed(KEY(int(chord) & ~MODIFIERS), False)


def shortcuts(state: WindowState, keyboard: Keyboard) -> None:
    """The keys, unless text is being typed."""
    io = imgui.get_io()
    keyboard.advance()
    if imgui.is_key_pressed(KEY.escape) and imgui.internal.get_top_most_popup_modal() is None:
        imgui.internal.close_popups_except_modals()
    if io.want_text_input or imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id):
        return
    held = any(imgui.is_mouse_down(button) for button in range(3))

    pressed = keyboard.pressed
    if not held and pressed(CTRL | KEY.z):
        undo(state)
    if not held and (pressed(CTRL | SHIFT | KEY.z) or pressed(CTRL | KEY.y)):
        redo(state)
    view = state.view
    for chord, request in ((KEY.space, Request.PAUSE), (KEY.r, Request.RESTART), (CTRL | KEY.s, Request.SAVE_RENDER),
                           (CTRL | KEY.e, Request.EXPORT), (CTRL | KEY.o, Request.OPEN_LENS), (KEY.a, Request.PIN),
                           (KEY.l, Request.BROWSE_LENSES)):
        if pressed(chord):
            state.requests.add(request)
    if pressed(KEY.f):
        view.zoom, view.centre = None, (0.5, 0.5)
    if pressed(KEY._1):
        view.zoom = 1.0
    if pressed(KEY.home):
        state.edited = at_home(state.edited)
    if pressed(KEY.h):
        view.histogram = not view.histogram
    for chord, overlay in ((KEY.p, "peaking"), (KEY.c, "coc"), (KEY.z, "clipping")):
        if pressed(chord):
            state.edited = replace(state.edited, overlay="none" if state.edited.overlay == overlay else overlay)
    for chord, comparison in ((KEY.s, "side"), (KEY.w, "wipe"), (KEY.d, "difference")):
        if pressed(chord) and view.pinned is None:
            view.say(NOTHING_PINNED, note=True)
        elif pressed(chord):
            state.edited = replace(state.edited, compare="off" if state.edited.compare == comparison else comparison)
    if pressed(KEY.v):
        views = list(VIEWS)
        state.edited = replace(state.edited, view=views[(views.index(state.edited.view) + 1) % len(views)])
    if pressed(KEY.k) and view.pinned is None:
        view.say(NOTHING_PINNED, note=True)
    elif pressed(KEY.k):
        view.locked = not view.locked
    if pressed(KEY.m):
        toggle_magnifier(view)
    if pressed(KEY.i):
        toggle_pin(state)
    if pressed(KEY.f1):
        state.requests.add(Request.SHOW_HELP)
    if pressed(CTRL | KEY.q):
        hello_imgui.get_runner_params().app_shall_exit = True


class Help:
    """The dialog of keys and mouse."""

    def __init__(self) -> None:
        self._open = False

    def open(self) -> None:
        """Show the dialog from the next `draw` on."""
        self._open = True

    def draw(self, drawn_by: str = "") -> None:
        """Call it in every frame. drawn_by: a sentence about what draws the window."""
        if self._open:
            imgui.open_popup("Keys and mouse")
            self._open = False
        column = max(imgui.calc_text_size(key).x for key, _ in KEYS) + theme.em(2.0)
        words = max(imgui.calc_text_size(what).x for _, what in KEYS)
        centre_next((column + words) / theme.em(1.0) + 1.5)
        shown, _ = imgui.begin_popup_modal("Keys and mouse", True, imgui.WindowFlags_.no_saved_settings
                                           | imgui.WindowFlags_.no_resize)
        if not shown:
            return
        for key, what in KEYS:
            imgui.text_disabled(key)
            imgui.same_line(column)
            imgui.text_unformatted(what)
        imgui.separator()
        from importlib.metadata import version

        imgui.text_disabled(f"lensbench {version('lensbench')}. Lenses, cameras, their rays and their pictures.")
        if drawn_by:
            imgui.text_disabled(drawn_by)
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()
