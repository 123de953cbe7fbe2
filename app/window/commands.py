"""Every action of the window by its name: for the keys, the command palette and the sheet of keys.

A row holds the name, the keys as people read them, the chord that starts it, and what it does.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from imgui_bundle import hello_imgui, imgui

from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.exposure import METERED, MODES, with_mode
from lensbench.app.bench.lens_choice import FOCUS, TRIALS, Trial, tried, with_scene
from lensbench.app.bench.pose import LookAround
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.image.overlays import toggle_magnifier
from lensbench.app.session.edited_lens import reverted
from lensbench.app.session.notices import Request
from lensbench.app.settings.setting_table import VIEWS
from lensbench.app.settings.settings import Settings
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import WindowState

NOTHING_PINNED = "Nothing to compare with yet: pin a picture as A first (A)"
KEY, CTRL, SHIFT = imgui.Key, imgui.Key.mod_ctrl, imgui.Key.mod_shift


@dataclass(frozen=True)
class Command:
    """One action. chords: of imgui keys. group: its heading in the sheet of keys; "" for none."""

    name: str
    run: Callable[[WindowState], None]
    keys: str = ""
    chords: tuple[int, ...] = ()
    group: str = ""


def _asks(request: Request) -> Callable[[WindowState], None]:
    return lambda state: state.requests.add(request)


def undo(state: WindowState) -> None:
    """Take back the latest change, unless a mouse button is held."""
    if not any(imgui.is_mouse_down(button) for button in range(3)) or imgui.is_popup_open(
            "", imgui.PopupFlags_.any_popup_id):
        state.edited = state.history.undo()


def redo(state: WindowState) -> None:
    """Bring back the change that `undo` took back."""
    if not any(imgui.is_mouse_down(button) for button in range(3)):
        state.edited = state.history.redo()


def reset_all(state: WindowState) -> None:
    """All settings at their defaults, but lens and scene, which is seen as it opens."""
    present = state.history.present
    try:
        plain = constrained(replace(Settings(), lens=present.lens, edited=present.edited))
        state.edited = with_scene(plain, present.scene)
    except (ValueError, OSError):
        state.edited = Settings()
    state.history.edit(state.edited, False, 0.0)


def toggle_pin(state: WindowState) -> None:
    """Unpin the pinned pixel, or pin the one under the mouse, or the one that the mouse was on last."""
    at, film = state.view.links.hover or state.view.pointed, state.history.present.film
    if state.view.links.pinned is not None or at is not None:
        state.view.links.toggle_pin((at[0] / film.pixels_x, at[1] / film.pixels_y) if at is not None else (0.0, 0.0))


def try_this(state: WindowState, trial: Trial) -> None:
    """Take the settings of a trial, and say what there is to see."""
    state.edited = tried(state.edited, trial)
    state.view.say(trial.about, lens=trial.lens, change=True)


def quit_window(state: WindowState) -> None:
    """Close the window."""
    hello_imgui.get_runner_params().app_shall_exit = True


def _fit(state: WindowState) -> None:
    state.view.zoom, state.view.centre = None, (0.5, 0.5)


def _whole_pixels(state: WindowState) -> None:
    state.view.zoom = 1.0


def reset_camera(state: WindowState) -> None:
    """Put the camera where the present scene opens; with the padlock of the focus closed, the focus stays as it is."""
    before = state.edited
    home = with_scene(before, before.scene, state.chooser.locked - {FOCUS})
    state.edited = constrained(replace(home, focus_distance=before.focus_distance)) if FOCUS in state.chooser.locked \
        else home


def _histogram(state: WindowState) -> None:
    state.view.histogram = not state.view.histogram


def _overlay(overlay: str) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        state.edited = replace(state.edited, overlay="none" if state.edited.overlay == overlay else overlay)
    return run


def _compare(comparison: str) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        if state.view.pinned is None:
            state.view.say(NOTHING_PINNED, note=True)
        else:
            now = "off" if state.edited.compare == comparison else comparison
            state.edited = replace(state.edited, compare=now)
    return run


def _lock(state: WindowState) -> None:
    if state.view.pinned is None:
        state.view.say(NOTHING_PINNED, note=True)
    else:
        state.view.locked = not state.view.locked


def _next_view(state: WindowState) -> None:
    views = list(VIEWS)
    state.edited = replace(state.edited, view=views[(views.index(state.edited.view) + 1) % len(views)])


def _mode(mode: str) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        state.view.program = mode if mode in METERED else ""
        state.edited = with_mode(state.edited, mode)
    return run


def _revert(state: WindowState) -> None:
    state.edited = reverted(state.edited)


def _tries(trial: Trial) -> Callable[[WindowState], None]:
    return lambda state: try_this(state, trial)


def _theme(dark: bool) -> Callable[[WindowState], None]:
    return lambda state: state.choose_theme(dark)


def _layout(name: str) -> Callable[[WindowState], None]:
    return lambda state: state.choose_layout(name)


def _look_around(state: WindowState) -> None:
    if not state.edited.kind.panorama:
        state.view.say("Only a panorama can be looked around in: choose the camera Panorama first", note=True)
    else:
        state.view.look = None if state.view.look is not None else LookAround()


LOOK, RENDER, FILES, COMPARE = "The picture", "The render", "Files and window", "Comparison"
COMMANDS: tuple[Command, ...] = (
    Command("Show the whole picture", _fit, "F", (KEY.f,), LOOK),
    Command("Show the picture at 100 %", _whole_pixels, "1", (KEY._1,), LOOK),
    Command("Focus peaking", _overlay("peaking"), "P", (KEY.p,), LOOK),
    Command("Circles of confusion as colours", _overlay("coc"), "C", (KEY.c,), LOOK),
    Command("Clipping", _overlay("clipping"), "Z", (KEY.z,), LOOK),
    Command("Histogram", _histogram, "H", (KEY.h,), LOOK),
    Command("Next view of the samples", _next_view, "V", (KEY.v,), LOOK),
    Command("Magnifier with pixel values", lambda state: toggle_magnifier(state.view), "M", (KEY.m,), LOOK),
    Command("Pin or unpin the pixel under the mouse", toggle_pin, "I", (KEY.i,), LOOK),
    Command("Look around in the panorama", _look_around),
    Command("Camera back to its start", reset_camera, "Home", (KEY.home,), LOOK),
    Command("Pin the picture as A", _asks(Request.PIN), "A", (KEY.a,), COMPARE),
    Command("Compare A and B side by side", _compare("side"), "S", (KEY.s,), COMPARE),
    Command("Compare A and B by a wipe", _compare("wipe"), "W", (KEY.w,), COMPARE),
    Command("Difference of A and B", _compare("difference"), "D", (KEY.d,), COMPARE),
    Command("Lock the dials of A to those of B", _lock, "K", (KEY.k,), COMPARE),
    Command("Pause or go on rendering", _asks(Request.PAUSE), "Space", (KEY.space,), RENDER),
    Command("Restart the render", _asks(Request.RESTART), "R", (KEY.r,), RENDER),
    Command("Undo", undo, "Ctrl + Z", (chord(CTRL, KEY.z),), RENDER),
    Command("Redo", redo, "Ctrl + Shift + Z", (chord(CTRL, SHIFT, KEY.z), chord(CTRL, KEY.y)), RENDER),
    Command("Command palette", _asks(Request.SHOW_PALETTE), "Ctrl + K", (chord(CTRL, KEY.k),), FILES),
    Command("Keys and mouse", _asks(Request.SHOW_HELP), "F1 · ?", (KEY.f1,), FILES),
    Command("What the terms mean", _asks(Request.SHOW_TERMS)),
    *(Command(f"Try this: {trial.title}", _tries(trial)) for trial in TRIALS),
    Command("Lens browser", _asks(Request.BROWSE_LENSES), "L", (KEY.l,), FILES),
    Command("Open a lens", _asks(Request.OPEN_LENS), "Ctrl + O", (chord(CTRL, KEY.o),), FILES),
    Command("Save the edits of the lens", _asks(Request.SAVE_EDITED), "Ctrl + Shift + S", (chord(CTRL, SHIFT, KEY.s),),
            FILES),
    Command("Export", _asks(Request.EXPORT), "Ctrl + E", (chord(CTRL, KEY.e),), FILES),
    Command("Save the picture as it is now", _asks(Request.SAVE_RENDER), "Ctrl + S", (chord(CTRL, KEY.s),), FILES),
    Command("Keep this moment", _asks(Request.KEEP_MOMENT), "B", (KEY.b,), FILES),
    Command("Copy the picture", _asks(Request.COPY_PICTURE), "Ctrl + C", (chord(CTRL, KEY.c),), FILES),
    Command("Copy the state as text", _asks(Request.COPY_STATE), "Ctrl + Shift + C", (chord(CTRL, SHIFT, KEY.c),),
            FILES),
    Command("Paste the state of a text", _asks(Request.PASTE), "Ctrl + V", (chord(CTRL, KEY.v),), FILES),
    Command("Quit", quit_window, "Ctrl + Q", (chord(CTRL, KEY.q),), FILES),
    Command("Open a scene", _asks(Request.OPEN_SCENE)),
    Command("Open the settings of a picture", _asks(Request.OPEN_PICTURE)),
    Command("Open settings", _asks(Request.OPEN_SETTINGS)),
    Command("Open a light field", _asks(Request.OPEN_LIGHT_FIELD)),
    Command("Save the lens", _asks(Request.SAVE_LENS)),
    Command("Save the settings", _asks(Request.SAVE_SETTINGS)),
    Command("Save a picture of the window", _asks(Request.SAVE_WINDOW)),
    Command("Save the camera's intrinsics", _asks(Request.SAVE_INTRINSICS)),
    Command("Revert the edits of the lens", _revert),
    Command("Reset all settings", reset_all),
    *(Command(f"Exposure mode: {title if letter in ('off', 'I') else f'{letter}, {title}'}", _mode(letter))
      for letter, (title, _) in MODES.items()),
    Command("Dark theme", _theme(True)),
    Command("Light theme", _theme(False)),
    *(Command(f"Layout: {name}", _layout(name)) for name in LAYOUTS),
    Command("Reset layout", _asks(Request.RESET_LAYOUT)),
    Command("Dismiss all notices", lambda state: state.view.notices.forget()),
)
GESTURES = (                    # of the mouse, for the sheet of keys
    ("Click in the picture", "focus there"),
    ("Drag · wheel", "orbit about the point in focus · dolly"),
    ("Shift + drag, right drag", "pan"),
    ("Ctrl + wheel · Ctrl + drag", "zoom the picture · move it"),
    ("Alt + click · Escape", "pin a pixel, to follow its rays · unpin it"),
    ("Alt + wheel", "magnification of the magnifier"),
    ("On a dial", "drag, click, wheel; Ctrl + click types, double click resets"),
    ("In a plot", "drag to pan, wheel to zoom, double click to fit"),
    ("In the table of surfaces", "drag, click or Enter, Ctrl + arrows; Insert, Delete, Alt + arrows; right click"),
    ("In the lens browser", "click or arrows try, Enter keeps, Escape returns"),
)


class Keyboard:
    """The keys pressed in a frame, with the modifiers that were held at any time since the frame before.

    On slow frames Ctrl may be released in the frame in which Z is pressed: imgui then reports Z alone.
    """

    MODIFIERS = int(imgui.Key.mod_mask_)

    def __init__(self) -> None:
        self._before = self._held = 0

    def advance(self) -> None:
        """Call it once a frame."""
        now = int(imgui.get_io().key_mods)
        self._held, self._before = now | self._before, now

    def pressed(self, chord: int) -> bool:
        """Whether this key was pressed with exactly these modifiers."""
        modifiers = int(chord) & self.MODIFIERS
        return modifiers == self._held and imgui.is_key_pressed(KEY(int(chord) & ~self.MODIFIERS), False)


def shortcuts(state: WindowState, keyboard: Keyboard) -> None:
    """Run the commands whose keys are pressed, unless text is being typed or a popup is open."""
    keyboard.advance()
    if imgui.is_key_pressed(KEY.escape) and imgui.internal.get_top_most_popup_modal() is None:
        imgui.internal.close_popups_except_modals()
    if imgui.get_io().want_text_input or imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id):
        return
    if ord("?") in list(imgui.get_io().input_queue_characters):
        state.requests.add(Request.SHOW_HELP)
    for command in COMMANDS:
        if any(keyboard.pressed(chord) for chord in command.chords):
            command.run(state)
