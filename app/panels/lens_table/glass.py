"""The choice of a glass: a search over the catalogues, and a map of n_d over V_d to click."""

import math
from contextlib import suppress
from difflib import get_close_matches
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import warning
from lensbench.app.panels.lens_card import begin_glass_map, end_glass_map, nearest_glasses
from lensbench.app.panels.lens_table.cell import LensTableState
from lensbench.app.session.lens_cells import glass_text
from lensbench.app.settings.settings import Settings
from lensbench.core.optics.glass import Glass
from lensbench.core.text import fixed
from lensbench.lenses.editing.cells import with_glass
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.glass import catalogue
from lensbench.lenses.glass.catalogue import Entry

POPUP = "Glass"
WIDTH, HEIGHT = 30.0, 23.0      # em
MOST = 300                      # rows of the list
OFFERED = 12                    # rows for a text that names no glass


@lru_cache(maxsize=64)
def matches(text: str, maker: str, known: tuple[Entry, ...], current: Glass) -> tuple[Entry, ...]:
    """Glasses whose name or maker holds every word, by `_place` and the current ones first.

    Without a word the nearest to the current glass come first.
    """
    words = [catalogue.key(word) for word in text.split()]
    shown = [entry for entry in known if (not maker or entry.maker == maker)
             and all(word in catalogue.key(entry.name) or entry.maker.startswith(word) for word in words)]
    if words:
        shown.sort(key=lambda e: (_place(e.name, words[0]), e.rank, e.name))
    elif current.n_d > 1.0 and current.v_d:
        shown.sort(key=lambda e: catalogue.distance(e, current.n_d, current.v_d or 50.0))
    return tuple(shown[:MOST])


def _place(name: str, word: str) -> int:
    """Place of a name in the list for a word, first first: the name itself; N-SF1 for SF1; SF10 and N-SF10 for SF1.

    Then names that end with the word, and those that hold it elsewhere: LASF9 for SF.
    """
    whole, parts = catalogue.key(name), [catalogue.key(piece) for piece in name.split("-")]
    if whole == word:
        return 0
    if word in parts:
        return 1
    if any(piece.startswith(word) for piece in (whole, *parts)):
        return 2
    return 3 if whole.endswith(word) else 4


@lru_cache(maxsize=64)
def nearest(text: str, maker: str, known: tuple[Entry, ...]) -> tuple[Entry, ...]:
    """Glasses near to a text that names none: to its n_d and V_d or its code, else to its letters."""
    known = tuple(entry for entry in known if not maker or entry.maker == maker)
    parts = text.replace(",", ".").split()
    numbers = catalogue.code_numbers(text)
    if numbers is None and len(parts) == 2:
        with suppress(ValueError):
            numbers = float(parts[0]), float(parts[1])
    if numbers is not None and all(math.isfinite(number) for number in numbers):
        n_d, v_d = numbers
        measured = [entry for entry in known if entry.n_d and entry.v_d]
        return tuple(sorted(measured, key=lambda e: (catalogue.distance(e, n_d, v_d), e.rank))[:OFFERED])
    names: dict[str, Entry] = {}
    for entry in sorted(known, key=lambda e: e.rank):
        names.setdefault(catalogue.key(entry.name), entry)
    name_key = catalogue.key(text)[:60]
    return tuple(names[name] for name in get_close_matches(name_key, names, n=OFFERED, cutoff=0.5)) if name_key else ()


def glass_popup(settings: Settings, document: LensDocument, state: LensTableState) -> Settings:
    """Draw the popup for the surface `state.glass_of`, opened by `open_popup(POPUP)`; the settings, changed or not."""
    imgui.set_next_window_size(ImVec2(theme.em(WIDTH), 0.0))
    if not imgui.begin_popup(POPUP):
        return settings
    surface = state.glass_of
    if not 0 <= surface < len(document.surfaces):
        imgui.close_current_popup()
        imgui.end_popup()
        return settings
    current = document.surfaces[surface].glass
    imgui.text_disabled(f"Medium behind surface {surface}")
    imgui.same_line()
    imgui.text_unformatted(glass_text(current) or "Air")
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(theme.em(WIDTH) - theme.em(11.0))
    entered, state.search = imgui.input_text_with_hint(
        "##Search glass", "Name, code 517642, or n_d and V_d", state.search, imgui.InputTextFlags_.enter_returns_true)
    imgui.same_line()
    known = catalogue.entries()
    makers = list(dict.fromkeys(entry.maker for entry in known))
    imgui.set_next_item_width(-1.0)
    if imgui.begin_combo("##Maker", state.maker or "All makers"):
        for maker in ("", *makers):
            if imgui.selectable(f"{maker or 'All makers'}###maker {maker or 'all'}", maker == state.maker)[0]:
                state.maker = maker
        imgui.end_combo()
    # Above the list: the popup has its place, and may end at the window's edge
    for problem in filter(None, (state.problem, catalogue.unread_text())):
        warning(problem)
    shown = matches(state.search, state.maker, known, current)
    near = nearest(state.search, state.maker, known) if state.search.strip() and not shown else ()
    chosen: Glass | str | None = None
    if entered:
        chosen = shown[0].make() if shown and state.search.strip() else state.search
    if imgui.begin_child("Glass list", ImVec2(theme.em(13.5), theme.em(HEIGHT - 6.0))):
        if imgui.selectable("Air###no glass", current.n_d == 1.0)[0]:
            chosen = ""
        if near:
            imgui.text_disabled("The nearest glasses")
        listed = shown or near
        clipper = imgui.ListClipper()
        clipper.begin(len(listed))
        while clipper.step():
            for entry in listed[clipper.display_start:clipper.display_end]:
                chosen = _line(entry, current, chosen)
    imgui.end_child()
    imgui.same_line()
    on_map = _map(shown or near if state.search.strip() or state.maker else known, current)
    if on_map is not None:
        chosen = on_map.make()
    if chosen is not None:
        settings = state.apply(settings, partial(with_glass, surface=surface, glass=chosen))
        if not state.problem:
            imgui.close_current_popup()
    imgui.end_popup()
    return settings


def _line(entry: Entry, current: Glass, chosen: Glass | str | None) -> Glass | str | None:
    """One glass of the list; it, where it is clicked."""
    label = f"{entry.name}###{entry.maker} {entry.name}"
    flags = imgui.SelectableFlags_.no_auto_close_popups
    dim = entry.obsolete
    if dim:
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.colours().dim))
    clicked = imgui.selectable(label, entry.name == current.name and entry.n_d == current.n_d, flags)[0]
    if dim:
        imgui.pop_style_color()
    imgui.set_item_tooltip(f"{entry}{', no longer made' if entry.obsolete else ''}")
    if entry.n_d and entry.v_d:
        numbers = f"{fixed(entry.n_d, 3)}  {fixed(entry.v_d, 1)}"
        box = imgui.get_item_rect_max()
        imgui.get_window_draw_list().add_text(
            ImVec2(box.x - imgui.calc_text_size(numbers).x - theme.em(0.6), imgui.get_item_rect_min().y + 1.0),
            theme.packed(theme.colours().dim), numbers)
    return entry.make() if clicked else chosen


def _map(shown: tuple[Entry, ...], current: Glass) -> Entry | None:
    """The map; the glass that is clicked."""
    known = [entry for entry in shown if entry.n_d and entry.v_d]
    v, n = np.array([entry.v_d for entry in known], float), np.array([entry.n_d for entry in known], float)
    points = begin_glass_map("##Glass map", HEIGHT - 6.0, (18.0, 97.0, 1.42, 2.06), v, n, once=True)
    if points is None:
        return None
    colour, pixel, draw = theme.colours(), theme.scale(), implot.get_plot_draw_list()
    for entry, point, abbe, index in zip(known, points, v.tolist(), n.tolist(), strict=True):
        opacity = 0.35 if entry.obsolete else 0.9
        draw.add_circle_filled(point, 2.6 * pixel, theme.packed((*colour.glass(index, abbe)[:3], opacity)))
    if current.v_d:
        draw.add_circle(implot.plot_to_pixels(current.v_d, current.n_d), 5.5 * pixel, theme.packed(colour.strong), 0,
                        2.0 * pixel)
    near = nearest_glasses(points) if implot.is_plot_hovered() else []
    nearest = min(near, key=lambda i: known[i].rank, default=None)
    if nearest is not None:
        draw.add_circle(points[nearest], 4.5 * pixel, theme.packed(colour.text), 0, 1.5 * pixel)
    end_glass_map()
    if nearest is None:
        return None
    imgui.set_tooltip(str(known[nearest]))
    released = imgui.is_mouse_released(imgui.MouseButton_.left)
    return known[nearest] if released and not imgui.is_mouse_drag_past_threshold(imgui.MouseButton_.left) else None
