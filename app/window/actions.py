"""What each action of the window does, and when it is enabled: read by menus, command palette and keys."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from imgui_bundle import hello_imgui, imgui

from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.exposure import METERED, MODES, with_mode
from lensbench.app.bench.framing import with_scene
from lensbench.app.bench.lens_choice import APERTURE, FOCUS, TRIALS, Trial, tried
from lensbench.app.bench.pose import LookAround
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.action_names import ACTION_NAMES, Named
from lensbench.app.panels.image.overlays import toggle_magnifier, toggle_sharp_pick
from lensbench.app.scenes.scene_writer import is_own
from lensbench.app.session.edited_lens import reverted
from lensbench.app.session.notices import Request
from lensbench.app.settings.setting_table import VIEWS
from lensbench.app.settings.settings import Settings
from lensbench.app.window.layouts import LAYOUTS
from lensbench.app.window.state import SCALES, WindowState
from lensbench.lenses import WRITERS

NOTHING_PINNED = "Nothing to compare with yet: pin a picture as A first (A)"
KEY = imgui.Key
KEYS = {"Ctrl": KEY.mod_ctrl, "Shift": KEY.mod_shift, "Alt": KEY.mod_alt,
        **{f"{digit}": getattr(KEY, f"_{digit}") for digit in range(1, 10)},
        **{name: getattr(KEY, name.lower()) for name in ("Space", "Home", "Tab", "F1", "F11",
                                                         *"ABCDEFGHIJKLMNOPQRSTUVWXYZ")}}


def _always(_: WindowState) -> bool:
    return True


def _never(_: WindowState) -> bool:
    return False


@dataclass(frozen=True)
class Action:
    """One action. enabled: whether its menu item can be chosen. checked: whether the item shows a check mark."""

    name: str
    run: Callable[[WindowState], None]
    keys: str = ""
    group: str = ""
    tip: str = ""
    enabled: Callable[[WindowState], bool] = _always
    checked: Callable[[WindowState], bool] = _never

    @property
    def chords(self) -> tuple[int, ...]:
        """The keys as chords of imgui, without `characters`."""
        return tuple(chord(*(KEYS[name] for name in text.split("+")))
                     for text in self.keys.split(" or ") if text and text not in self.characters)

    @property
    def characters(self) -> tuple[str, ...]:
        """The keys that are read as characters, for they lie elsewhere on each keyboard: “?”, “[”, …"""
        return tuple(text for text in self.keys.split(" or ") if len(text) == 1 and not text.isalnum())


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
    """All settings at their defaults, except lens and scene, which is seen as it opens."""
    current = state.history.present
    try:
        plain = constrained(replace(Settings(), lens=current.lens, edited=current.edited))
        state.edited = with_scene(plain, current.scene)
    except (ValueError, OSError):
        state.edited = Settings()
    state.history.edit(state.edited, False, 0.0)


def toggle_pin(state: WindowState) -> None:
    """Unpin the pinned pixel, or pin the one under the mouse, or the one that the mouse was on last."""
    point, film = state.view.links.hover or state.view.pointed, state.history.present.film
    if state.view.links.pinned is not None or point is not None:
        x, y = point or (0.0, 0.0)
        state.view.links.toggle_pin((x / film.pixels_x, y / film.pixels_y))


def reset_camera(state: WindowState) -> None:
    """Put the camera where the scene opens, framed anew; with the padlock of the focus, at this distance."""
    before = state.edited
    state.edited = replace(with_scene(before, before.scene, state.chooser.locked), exposure=before.exposure)


def _fit(state: WindowState) -> None:
    state.view.zoom, state.view.centre = None, (0.5, 0.5)


def _whole_pixels(state: WindowState) -> None:
    state.view.zoom = 1.0


def _histogram(state: WindowState) -> None:
    state.view.histogram = not state.view.histogram


def _look_around(state: WindowState) -> None:
    if not state.edited.kind.panorama:
        state.view.say("Look around works in panoramas: choose the camera Panorama first", note=True)
    else:
        state.view.look = None if state.view.look is not None else LookAround()


def _next_view(state: WindowState) -> None:
    views = list(VIEWS)
    state.edited = replace(state.edited, view=views[(views.index(state.edited.view) + 1) % len(views)])


def _lock(state: WindowState) -> None:
    if state.view.pinned is None:
        state.view.say(NOTHING_PINNED, note=True)
    else:
        state.view.locked = not state.view.locked


def _quit(_: WindowState) -> None:
    hello_imgui.get_runner_params().app_shall_exit = True


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


def _turned(name: str, steps: int) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        from lensbench.app.panels.controls.dials import turned  # not needed for the first picture

        try:
            state.edited = turned(state.edited, name, steps)
        except (ValueError, OSError) as error:
            state.view.say(str(error))
    return run


def _mode(mode: str) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        state.view.program = mode if mode in METERED else ""
        state.edited = with_mode(state.edited, mode)
    return run


def _trial(trial: Trial) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        state.edited = tried(state.edited, trial)
        state.view.say(trial.about, lens=trial.lens, change=True)
    return run


def _snapshot(number: int) -> Callable[[WindowState], None]:
    def run(state: WindowState) -> None:
        state.snapshot_number = number
    return run


def _requested(request: Request) -> Callable[[WindowState], None]:
    return lambda state: state.requests.add(request)


def _is_edited(state: WindowState) -> bool:
    return bool(state.history.present.edited)


RUNS: dict[str, Callable[[WindowState], None] | Request] = {
    "Fit picture": _fit, "Zoom to 100 %": _whole_pixels, "Focus peaking": _overlay("peaking"),
    "Circle of confusion": _overlay("coc"), "Plane of focus": _overlay("plane"), "Clipping": _overlay("clipping"),
    "Histogram": _histogram, "Make these sharp": lambda state: toggle_sharp_pick(state.view),
    "Next view of the samples": _next_view, "Magnifier": lambda state: toggle_magnifier(state.view),
    "Pin pixel": toggle_pin, "Look around": _look_around, "Reset camera": reset_camera,
    "Pin picture as A": Request.PIN, "Compare side by side": _compare("side"), "Compare with a wipe": _compare("wipe"),
    "Show difference": _compare("difference"), "Lock A's dials to B": _lock, "Pause": Request.PAUSE,
    "Restart render": Request.RESTART, "Undo": undo, "Redo": redo, "Command palette…": Request.SHOW_PALETTE,
    "Turn dials by keys": lambda state: state.dials.take_keyboard(),
    "Focus nearer": _turned(FOCUS, -1), "Focus farther": _turned(FOCUS, 1), "Open aperture": _turned(APERTURE, -1),
    "Close aperture": _turned(APERTURE, 1), "Expose less": _turned("exposure", -1),
    "Expose more": _turned("exposure", 1), "Render follows window": Request.FOLLOW_WINDOW,
    "Hide panels": Request.HIDE_PANELS, "Full screen": Request.FULL_SCREEN,
    "Keys and mouse": Request.SHOW_HELP, "What the terms mean": Request.SHOW_TERMS,
    "Lens browser…": Request.BROWSE_LENSES, "Open…": Request.OPEN, "Adjust scene…": Request.ADJUST_SCENE,
    "Save scene as…": Request.SAVE_SCENE, "Save lens…": Request.SAVE_LENS,
    "Save lens edits": Request.SAVE_EDITED, "Revert lens": lambda state: state.take(reverted(state.edited)),
    "Improve lens…": Request.IMPROVE_LENS,
    "Save settings…": Request.SAVE_SETTINGS, "Export…": Request.EXPORT, "Save picture…": Request.SAVE_RENDER,
    "Save screenshot…": Request.SAVE_WINDOW, "Save intrinsics…": Request.SAVE_INTRINSICS,
    "Keep snapshot": Request.KEEP_SNAPSHOT, "Contact sheet…": Request.CONTACT_SHEET,
    **{f"Open snapshot {number}": _snapshot(number) for number in range(1, 10)},
    "Copy picture": Request.COPY_PICTURE,
    "Copy state as text": Request.COPY_STATE, "Paste state": Request.PASTE, "Reset all": reset_all,
    "Dark theme": lambda state: state.choose_theme(True), "Light theme": lambda state: state.choose_theme(False),
    "Reset layout": Request.RESET_LAYOUT, "Dismiss all notices": lambda state: state.view.notices.forget(),
    "Quit": _quit}
ENABLED: dict[str, Callable[[WindowState], bool]] = {
    "Undo": lambda state: state.history.can_undo, "Redo": lambda state: state.history.can_redo,
    "Save lens…": lambda state: state.history.present.has_lens,
    "Improve lens…": lambda state: state.history.present.has_lens,
    "Adjust scene…": lambda state: is_own(state.history.present.scene),
    "Save lens edits": _is_edited, "Revert lens": _is_edited,
    "Pin pixel": lambda state: state.view.links.pinned is not None or state.view.pointed is not None}
CHECKED: dict[str, Callable[[WindowState], bool]] = {
    "Pin pixel": lambda state: state.view.links.pinned is not None,
    "Magnifier": lambda state: state.view.magnifier > 0,
    "Make these sharp": lambda state: state.view.sharp_pick,
    "Render follows window": lambda state: state.view.follows, "Hide panels": lambda state: state.panels_hidden,
    "Full screen": lambda state: state.full_screen is not None,
    "Dark theme": lambda state: state.dark, "Light theme": lambda state: not state.dark}


def _action(name: str, named: Named) -> Action:
    run = RUNS[name]
    tip = f"The suffix sets the format: {' '.join(WRITERS)}" if name == "Save lens…" else named.tip
    return Action(name, _requested(run) if isinstance(run, Request) else run, named.keys, named.group, tip,
                  ENABLED.get(name, _always), CHECKED.get(name, _never))


def _scale(scale: float) -> Action:
    return Action(f"Scale: {SCALES[scale]}", lambda state: state.choose_scale(scale),
                  tip="Size of texts and controls; the panels are laid out anew",
                  checked=lambda state: state.scale == scale)


def _layout(name: str) -> Action:
    return Action(f"Layout: {name}", lambda state: state.choose_layout(name), tip=LAYOUTS[name].about,
                  checked=lambda state: state.layout == name)


ACTIONS: dict[str, Action] = {action.name: action for action in (
    *(_action(name, named) for name, named in ACTION_NAMES.items()),
    *(Action(f"Try this: {trial.title}", _trial(trial), tip=trial.about) for trial in TRIALS),
    *(Action(f"Exposure mode: {title if letter in ('off', 'I') else f'{letter}, {title}'}", _mode(letter))
      for letter, (title, _) in MODES.items()),
    *map(_layout, LAYOUTS), *map(_scale, SCALES))}


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


CHORDS = [(chord, action) for action in ACTIONS.values() for chord in action.chords]
CHARACTERS = {character: action for action in ACTIONS.values() for character in action.characters}


def shortcuts(state: WindowState, keyboard: Keyboard) -> None:
    """Run the actions whose keys are pressed, unless text is being typed or a popup is open."""
    keyboard.advance()
    if imgui.is_key_pressed(KEY.escape) and imgui.internal.get_top_most_popup_modal() is None:
        imgui.internal.close_popups_except_modals()
    keyed = state.dials.steer() or state.keyed          # Tab is theirs
    if imgui.get_io().want_text_input or imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id):
        return
    for code in list(imgui.get_io().input_queue_characters):
        if chr(code) in CHARACTERS:
            CHARACTERS[chr(code)].run(state)
    for pressed, action in CHORDS:
        if keyboard.pressed(pressed) and not (keyed and action.keys == "Tab"):
            action.run(state)
