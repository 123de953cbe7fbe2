"""The command palette: type a few letters of any action, panel, lens, scene or setting, and press Enter.

A setting takes its value in the same line: “f-number 4”, “iso 800”, “focus 2 m”; a zoom lens its focal length, “zoom
70”. A value that its unit tells needs no name: “f/5.6”, “10 ft”, “1/60”, “+1 EV”; it never loads a lens.
"""

import math
from collections.abc import Callable
from dataclasses import Field, dataclass, fields, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from imgui_bundle import ImVec2, hello_imgui, imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import design, stop_picture_path
from lensbench.app.bench.camera_kinds import unfit
from lensbench.app.bench.constraints import (
    constrained, field_of_view, with_body, with_camera, with_field_of_view, zooms
)
from lensbench.app.bench.framing import framings, with_framing, with_scene
from lensbench.app.bench.lens_choice import FILM, with_lens
from lensbench.app.bench.zoom import asked_zoom, focal_length, is_engraved
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import two_lines
from lensbench.app.panels.controls.controls import scene_title
from lensbench.app.session.lens_shelf import Shelf, ranked, score
from lensbench.app.settings.setting import check, reader, spec, titles, value_text, words
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import (
    format_angle, format_length, format_part, read_angle, read_distance, read_length, read_percent
)
from lensbench.app.window.actions import ACTIONS
from lensbench.app.window.palette_words import ENTRIES, USES, bare_values, begun_value, shelf_of
from lensbench.app.window.state import WindowState
from lensbench.core.kernels.cache import NotCompiledError
from lensbench.core.text import cut, significant, true_minus
from lensbench.lenses.library.search import NOMINAL, filtered
from lensbench.lenses.stop_picture import SUFFIXES

NAME = "Command palette"
ROWS = 11
MOST_PATH = 60          # characters of the folder of a picture
WIDTH = 34.0                    # em
HIDDEN = ("lens", "scene", "film_width", "film_height", "crop", "fov", "fisheye_fov", "pixels_x", "pixels_y", "wipe",
          "zoom", "compare", "overlay", "exposing", "end_position", "end_yaw", "end_pitch")
TITLES = {"fov_axis": "side of the field of view", "bits": "bits of the sensor", "layout": "layout of a panorama",
          "limit": "sharp up to", "degree": "degree of the polynomial", "view": "view of the samples"}
OTHER_NAMES = {"f_number": ("Aperture",), "shutter": ("Exposure time",)}       # on the dial, and of photographers
VIEW = "Field of view"          # of whatever camera it is: not one field
ZOOM = ("Zoom", "Focal length")         # of a zoom lens, whose prescription no dial scales
FIELDS = {field.name: field for field in fields(Settings)}
IDLE: dict[str, tuple[Callable[[Settings], bool], str]] = {     # when a setting changes nothing, and what to do
    "f_number": (lambda settings: not settings.has_f_number, "not of this camera"),
    "focus_distance": (lambda settings: not settings.focuses, "this camera has no focus"),
    "iso": (lambda settings: settings.exposing == "plain" and not settings.noise, "counts in the modes P A S M")}


@dataclass(frozen=True)
class Entry:
    """A row: its text, the note at its right, and what Enter does. fills: text that it puts into the query."""

    text: str
    kind: str
    run: Callable[[WindowState], None] | None = None
    fills: str = ""


class Palette:
    """State of the palette between frames."""

    def __init__(self) -> None:
        self._opens, self._query, self._chosen = False, "", 0
        self._focus, self._at_end = False, True         # of the text that is typed: the caret goes behind it

    def open(self) -> None:
        """Show it from the next `draw` on."""
        self._opens = True

    def draw(self, state: WindowState) -> None:
        """Call it in every frame."""
        if self._opens:
            self._opens, self._query, self._chosen, self._focus = False, "", 0, True
            imgui.open_popup(NAME)
        viewport = imgui.get_main_viewport()
        width = min(theme.em(WIDTH), 0.94 * viewport.work_size.x)
        imgui.set_next_window_pos(ImVec2(viewport.get_center().x, viewport.work_pos.y + theme.em(3.0)),
                                  imgui.Cond_.always, ImVec2(0.5, 0.0))
        imgui.set_next_window_size(ImVec2(width, 0.0))
        if not imgui.begin_popup(NAME, imgui.WindowFlags_.no_nav):
            return
        entry = self._line(state)
        imgui.end_popup()
        if entry is not None and entry.run is not None:
            entry.run(state)

    def _caret(self, data: imgui.InputTextCallbackData) -> int:
        """Put the caret behind a name that the palette has filled in: imgui selects it, and typing would replace it."""
        if not self._at_end and data.buf_text_len == len(self._query.encode()):
            data.clear_selection()
            data.cursor_pos, self._at_end = data.buf_text_len, True
        return 0

    def _line(self, state: WindowState) -> Entry | None:
        """The query and its answers; the entry that is chosen."""
        if self._focus:
            imgui.set_keyboard_focus_here()
            self._focus = False
        imgui.set_next_item_width(-1.0)
        entered, query = imgui.input_text_with_hint(
            "##Query", "f/5.6, 3 m, iso 800, an action, a lens, a scene, a setting", self._query,
            imgui.InputTextFlags_.enter_returns_true | imgui.InputTextFlags_.callback_always, self._caret)
        if query != self._query:
            self._query, self._chosen = query, 0
        if imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
            return None
        entries = answers(self._query, state)
        step = int(imgui.is_key_pressed(imgui.Key.down_arrow)) - int(imgui.is_key_pressed(imgui.Key.up_arrow))
        self._chosen = min(max(self._chosen + step, 0), max(len(entries) - 1, 0))
        if not entries:
            imgui.text_disabled("Nothing has this name")
        taken = None
        for i, entry in enumerate(entries):
            size = imgui.calc_text_size(entry.kind)
            room = imgui.get_content_region_avail().x - (size.x + theme.em(1.2) if entry.kind else 0.0)
            if imgui.selectable("\n".join(two_lines(entry.text, room)) + f"###Row {i}", i == self._chosen,
                                imgui.SelectableFlags_.no_auto_close_popups)[0]:
                taken = entry
            corner = ImVec2(imgui.get_item_rect_max().x - size.x - theme.em(0.4), imgui.get_item_rect_min().y
                            + 0.5 * imgui.get_style().item_spacing.y)
            imgui.get_window_draw_list().add_text(corner, theme.packed(theme.colours().dim), entry.kind)
        if entered and entries:
            taken = entries[self._chosen]
        if taken is not None and taken.fills:
            self._query, self._chosen, self._focus, self._at_end = taken.fills, 0, True, False
            imgui.internal.clear_active_id()        # the text being typed is that of the item until then
            return None
        if taken is None or taken.run is None:
            if entered or taken is not None:            # nothing to do: go on with the text, which Enter has ended
                self._focus, self._at_end = True, False
            return None
        imgui.close_current_popup()
        return taken


def answers(query: str, state: WindowState) -> list[Entry]:
    """The best rows for a query: the settings that a value without a name may be of, else a setting with its typed
    value and then the fuzzy matches.

    Words after the name of a setting are read as its wrong value where nothing else has this name.
    """
    values = _bare(query, state)
    if values:
        return values
    numbers = _given(query, state)
    rows = {entry.text: entry for entry in _entries(state)}
    names: dict[str, str] = {}                  # other words, and panels and scenes without the word for what they are
    if query.strip():
        names = {word: text for word, name in ENTRIES.items() for text in (name, f"{name}: on", f"{name}: off")
                 if text in rows} | {text[7:]: text for text in rows if text.startswith(("Panel: ", "Scene: "))
                                     and text[7:] not in rows}
    texts = [*rows, *names]
    best = dict.fromkeys(names.get(texts[i], texts[i]) for i in ranked(query, texts, 3 * ROWS))
    return [*numbers, *(rows[text] for text in best)][:ROWS] or _given(query, state, wrong=True)


def _bare(query: str, state: WindowState) -> list[Entry]:
    """The rows of a value without a name; of one that is only begun, the setting that asks for it."""
    begun, current, entries = begun_value(query), state.edited, list[Entry]()
    if begun:
        return _of_field(FIELDS[begun], current)[:1]
    for name, text in bare_values(query):
        if name == "focal_length":
            entries += _of_length(text, current)
        elif name == "fov":
            entries += filter(None, [_viewed(text, current, True)])
        else:
            field = FIELDS[name]
            read = reader(field)
            assert read is not None
            entries += filter(None, [_value(field, read, text, current, True)])
    return entries


def _of_length(text: str, current: Settings) -> list[Entry]:
    """What a focal length may mean: a place of the zoom in use, lenses of the library, or the scaling of the lens."""
    length, zoom, entries = read_length(text), _zoom_lens(current), list[Entry]()
    if zoom is not None and is_engraved(zoom):
        entries += filter(None, [_asked(zoom, text, False)])
    if _count(length):
        entries.append(Entry(f"Lenses of {significant(length)} mm", "library", partial(_browse, shelf_of(text))))
    if zoom is None and current.has_lens:
        scaled = _value(FIELDS["focal_length"], read_length, text, current, True)
        if scaled is not None and scaled.run is not None:
            scaled = replace(scaled, text=f"Scale this lens to {format_length(length)}")
        entries += filter(None, [scaled])
    if zoom is not None and len(entries) > 1 and entries[0].run is None:        # beyond its range: lenses first
        entries.reverse()
    return entries


@lru_cache(maxsize=64)
def _count(length: float) -> int:
    """The number of lenses of about this focal length (mm)."""
    return len(filtered(lenses.describe(), focal=(length * (1.0 - NOMINAL), length * (1.0 + NOMINAL))))


def _browse(shelf: Shelf, state: WindowState) -> None:
    state.browsed = shelf


def _entries(state: WindowState) -> list[Entry]:
    current = state.edited
    entries = [Entry(action.name, action.keys, action.run) for action in ACTIONS.values() if action.enabled(state)]
    for panel in hello_imgui.get_runner_params().docking_params.dockable_windows:
        if panel.label != "Render":
            shown = "shown" if panel.is_visible else ""
            entries.append(Entry(f"Panel: {panel.label}", shown, partial(WindowState.show_panel, name=panel.label)))
    for scene in lb.SCENES:
        entries.append(Entry(f"Scene: {scene_title(scene)}", "", _sets(partial(
            with_scene, scene=scene, locked=state.chooser.locked))))
    for path in state.recent:
        entries.append(Entry(f"Open again: {path.name}", "", partial(_reopen, path)))
    zoom = _zoom_lens(current)
    for field in fields(Settings):
        if field.name not in HIDDEN and not (zoom and field.name == "focal_length"):
            entries += _of_field(field, current)
    if zoom is not None:
        entries += [Entry(name, _zoomed(zoom, current.zoom), fills=f"{name} ") for name in ZOOM]
    if current.has_lens or current.kind.has_view:
        entries.append(Entry(VIEW, format_angle(field_of_view(current)), fills=f"{VIEW} "))
    entries += [Entry(name, "library", partial(_browse, shelf)) for name, (shelf, _) in USES.items()]
    for card in lenses.describe():
        entries.append(Entry(f"Lens: {card.title}", "", _sets(
            partial(with_lens, lens=card.name, locked=state.chooser.locked))))
    return entries


def _of_field(field: Field, current: Settings) -> list[Entry]:
    """The rows of a setting: one for each choice, or one that asks for a value."""
    name, value, about = _title(field), getattr(current, field.name), spec(field)
    if field.type is bool:
        return [Entry(f"{name}: {'off' if value else 'on'}", f"now {'on' if value else 'off'}",
                      _sets(_changed(field.name, not value)))]
    if about.choices and about.read is None:
        choose = _sets if field.name != "body" else _owns
        return [Entry(f"{name}: {title}", "now" if key == value else "", choose(_changed(field.name, key)))
                for key, title in titles(field).items() if (field.name != "lens_model" or not unfit(current, key))
                and (field.name != "framing" or key in framings(current.scene))]
    if reader(field) is None:
        return []
    shown = about.none or "open" if value is None else ""
    if isinstance(value, int | float):
        shown = value_text(field, value)
    return [Entry(title, shown, fills=f"{title} ") for title in (name, *OTHER_NAMES.get(field.name, ()))]


def _zoom_lens(settings: Settings) -> lb.Lens | None:
    """The lens before it is zoomed; None for a camera or a lens that does not zoom, or cannot be read."""
    try:
        return design(replace(settings, zoom=0.0)) if zooms(settings) else None
    except (ValueError, OSError):                   # the worker reports it
        return None


def _zoomed(lens: lb.Lens, zoom: float) -> str:
    """A place of the zoom (0 to 1) as its dial shows it."""
    return format_length(focal_length(lens, zoom)) if is_engraved(lens) else format_part(zoom)


def _asked(lens: lb.Lens, text: str, wrong: bool) -> Entry | None:
    """The row for a zoom, typed as at its dial; None for a text that may be part of a name, such as 70-200."""
    try:
        asked = ("length", read_length(text)) if is_engraved(lens) else ("part", read_percent(text))
    except ValueError as error:
        return Entry(f"{ZOOM[0]}: {error}", "") if wrong else None
    try:
        zoom = asked_zoom(lens, asked)
    except lb.LensError as error:
        return Entry(f"{str(error)[0].upper()}{str(error)[1:]}", "")
    assert zoom is not None
    return Entry(f"{ZOOM[0]}: {_zoomed(lens, zoom)}", "Enter", _sets(_changed("zoom", zoom)))


WITH: dict[str, Callable[[Settings, str], Settings]] = {"camera": with_camera, "body": with_body,
                                                        "framing": with_framing}


def _changed(name: str, value: Any) -> Callable[[Settings], Settings]:
    """The change of one field."""
    def change(settings: Settings) -> Settings:
        if name in WITH:
            return WITH[name](settings, value)
        return replace(settings, **{name: value})
    return change


def _title(field: Field) -> str:
    text = TITLES.get(field.name) or words(field)
    return text if text[:2].isupper() else text[0].upper() + text[1:]


def _given(query: str, state: WindowState, wrong: bool = False) -> list[Entry]:
    """A row for a setting whose value is typed after its name, or for what is wrong with it; at most one.

    wrong: take words for a wrong value too, after a part of a name as it is written.
    """
    parts, zoom = query.split(), _zoom_lens(state.edited)
    best: tuple[float, Entry] | None = None
    for k in range(1, len(parts)):
        head, tail = " ".join(parts[:k]), " ".join(parts[k:])
        for field in fields(Settings):
            read = reader(field)
            if field.name in HIDDEN or read is None or zoom and field.name == "focal_length":
                continue
            if field.name == "stop_image":             # the folder of the lens file, of a path that is relative
                read = partial(stop_picture_path, state.edited)
            names = [title for title in (_title(field), *OTHER_NAMES.get(field.name, ()))
                     if not wrong or head.lower() in title.lower()]
            ranks = [score(head, title) for title in names]
            rank = max((rank for rank in ranks if rank is not None), default=None)
            if rank is not None and (best is None or rank > best[0]):
                entry = _value(field, read, tail, state.edited, wrong)
                best = (rank, entry) if entry is not None else best
        rank = max((rank for rank in map(partial(score, head), ZOOM) if rank is not None), default=None)
        if zoom is not None and rank is not None and (best is None or rank > best[0]):
            entry = _asked(zoom, tail, wrong)
            best = (rank, entry) if entry is not None else best
        rank = score(head, VIEW)
        if rank is not None and (best is None or rank > best[0]):
            entry = _viewed(tail, state.edited, wrong)
            best = (rank, entry) if entry is not None else best
    return [] if best is None else [best[1]]


def _viewed(text: str, current: Settings, wrong: bool) -> Entry | None:
    """The row for a field of view; None for a text that may be part of a name."""
    try:
        angle = read_angle(text)
    except ValueError as error:
        return Entry(f"{VIEW}: {error}", "") if wrong else None
    change = partial(with_field_of_view, fov=angle)
    return Entry(f"{VIEW}: {format_angle(angle)}", _view_note(angle, change, current), _sets(change))


def _value(field: Field, read: Callable[[str], Any], text: str, current: Settings, wrong: bool) -> Entry | None:
    try:
        value = read(text)
        check(field, value, partial(_bound, field))
        _changed(field.name, value)(Settings()).checked()
    except ValueError as error:
        if not (wrong or any(character.isdigit() for character in text) or Path(text).suffix.lower() in SUFFIXES):
            return None                     # a part of a name
        return Entry(f"{_title(field)}: {str(error).removeprefix(f'{words(field)} ')}", "")
    shown = value_text(field, value) if isinstance(value, int | float) and math.isfinite(value) else text
    if field.name == "stop_image":
        shown = f"{Path(value).name} in {cut(str(Path(value).parent), MOST_PATH)}"
    change = _changed(field.name, value)
    return Entry(f"{_title(field)}: {shown}", _enter(field, value, change, current), _sets(change))


def _bound(field: Field, value: float) -> str:
    """A number of a message about a range, in the unit of the dial."""
    in_metres = reader(field) is read_distance
    return true_minus(f"{significant(value / 1000.0)} m" if in_metres else spec(field).shown(value))


def _enter(field: Field, value: Any, change: Callable[[Settings], Settings], current: Settings) -> str:
    """The note of a typed value: that Enter takes it, what it becomes within the range of the camera, or its effect."""
    idle, reason = IDLE.get(field.name, (None, ""))
    if idle is not None and idle(current):
        return f"Enter: {reason}"
    try:
        taken = getattr(constrained(change(current)), field.name)
    except (ValueError, OSError, NotCompiledError):     # said when it is taken
        return "Enter"
    if taken == value:
        return "Enter"
    return f"Enter: {value_text(field, taken) if isinstance(taken, int | float) else spec(field).none or 'open'}"


def _view_note(angle: float, change: Callable[[Settings], Settings], current: Settings) -> str:
    """The note of a typed field of view, as `_enter` writes it."""
    try:
        taken = field_of_view(constrained(change(current)))
    except (ValueError, OSError, NotCompiledError):
        return "Enter"
    return "Enter" if math.isclose(taken, angle, rel_tol=1e-3) else f"Enter: {format_angle(taken)}"


def _sets(change: Callable[[Settings], Settings]) -> Callable[[WindowState], None]:
    """Take the changed settings, within the range of the camera, as one step of undo."""
    def run(state: WindowState) -> None:
        try:
            before, after = state.edited, constrained(change(state.edited).checked())
            if any(getattr(before, name) != getattr(after, name) for name in ("zoom", "crop", "fov", "focal_length")) \
                    and before.position == after.position:
                after = state.chooser.sized(before, after)
            state.say_moved(after)
            state.take(state.showable(after))
        except (ValueError, OSError) as error:
            state.view.say(str(error))
    return run


def _owns(change: Callable[[Settings], Settings]) -> Callable[[WindowState], None]:
    """As `_sets`, of a camera body: another lens leaves the format."""
    def run(state: WindowState) -> None:
        _sets(change)(state)
        state.chooser.locked.add(FILM)
    return run


def _reopen(path: Path, state: WindowState) -> None:
    state.reopened = path
