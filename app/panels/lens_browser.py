"""The panel of the lens browser: a grid of lenses, each with a picture taken through it and its section.

A click tries a lens, a double click or Enter keeps it, Escape returns to the lens before. Only the rows in sight are
drawn.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import picked, toggles
from lensbench.app.drawing.recorded import Memo
from lensbench.app.panels.section_pictures import SectionLook
from lensbench.app.session.lens_shelf import (
    ANY, ERAS, FORMATS, LENGTHS, ORDERS, SPEEDS, Shelf, film_name, film_of, kinds, makers, shelved
)
from lensbench.core.text import fixed, significant
from lensbench.lenses import Card
from lensbench.lenses.library.catalogue import USES

CELL = 8.9                     # em, the least width of a cell
PICTURE, SECTION = 2.0 / 3.0, 0.34      # heights, of the width
TITLE = 2.6                     # heights of a line: two small lines of the title, one of its figures
WIDTH_STEP = 16                 # pixels between two widths of sections, which are kept in files
fa, Key = icons_fontawesome_6, imgui.Key

Picture = tuple[int, tuple[int, int]]           # GL name of a texture, and its size in pixels
Textures = Callable[[str], Picture | None]      # by the name of a lens


@dataclass
class BrowserState:
    """What the browser shows, and what the user asked of the window."""

    shelf: Shelf = Shelf()
    selected: str = ""                          # a name of the library
    favourites: list[str] = field(default_factory=list)
    recent: list[str] = field(default_factory=list)
    in_sight: tuple[str, ...] = ()              # names whose cells were drawn, then the rest of the shelf
    tried: str = ""                             # a lens to be tried; the window takes these three
    kept: bool = False
    returned: bool = False
    opens_file: bool = False
    appearing: bool = True
    popup: bool = False                         # a list of a filter was open at the end of the frame before
    in_grid: bool = False                       # the arrows left and right move in the grid, not in the text
    scroll: bool = False                        # to the selected cell
    top: float = 0.0                            # of the part of the grid in sight (pixels)
    shelves: Memo = field(default_factory=lambda: Memo(4))
    section: SectionLook | None = None          # the look of the sections in cells of this width


def lens_browser_panel(cards: tuple[Card, ...], state: BrowserState, pictures: Textures, sections: Textures,
                       problems: Mapping[str, str], missing: int) -> None:
    """Draw the browser into the current window.

    pictures: the texture of a lens, None until it is there; sections: that of its section, drawn as `state.section`.
    problems: why there is no picture. missing: how many are being made.
    """
    before = state.shelf
    escape, enter = imgui.is_key_pressed(Key.escape, False), (imgui.is_key_pressed(Key.enter, False)
                                                             or imgui.is_key_pressed(Key.keypad_enter, False))
    popup = _popup_is_open() or state.popup         # Escape has closed it, and is spent
    state.shelf = search(state.shelf, state.appearing or (not popup and _is_idle()))
    shown = _shown(cards, state)
    state.shelf = filters(state.shelf, cards, len(shown))
    if state.shelf != before:
        shown = _shown(cards, state)
        state.in_grid, state.scroll = False, True
        if state.shelf.search.strip() and shown:
            state.selected = shown[0].name
    footer = imgui.get_frame_height_with_spacing() + theme.em(0.2)
    if imgui.begin_child("Grid", ImVec2(0.0, -footer)):
        columns = _grid(shown, state, pictures, sections, problems)
    else:
        columns = 1
    imgui.end_child()
    _footer(state, missing)
    if not popup:
        _keys(shown, state, columns)
        if escape:
            state.returned = True
        elif enter and any(card.name == state.selected for card in shown):
            state.tried, state.kept = state.selected, True
    state.appearing, state.popup = False, _popup_is_open()


def _popup_is_open() -> bool:
    return imgui.is_popup_open("", imgui.PopupFlags_.any_popup_id)


def _is_idle() -> bool:
    """Whether the browser has the focus and nothing in it is held: what is typed then belongs to the search."""
    return (imgui.is_window_focused(imgui.FocusedFlags_.child_windows) and not imgui.is_any_item_active()
            and not imgui.is_mouse_down(imgui.MouseButton_.left))


def _shown(cards: tuple[Card, ...], state: BrowserState) -> tuple[Card, ...]:
    key = (cards, state.shelf, tuple(state.favourites), tuple(state.recent))
    return state.shelves.of(key, lambda: shelved(cards, state.shelf, state.favourites, state.recent))


def _keys(shown: tuple[Card, ...], state: BrowserState, columns: int) -> None:
    """Move the selection with the arrows, and try it."""
    pressed = imgui.is_key_pressed
    step = columns * (int(pressed(Key.down_arrow)) - int(pressed(Key.up_arrow)))
    state.in_grid = state.in_grid or bool(step)
    if state.in_grid or not state.shelf.search:
        step += int(pressed(Key.right_arrow)) - int(pressed(Key.left_arrow))
    if not step or not shown:
        return
    names = [card.name for card in shown]
    index = names.index(state.selected) + step if state.selected in names else 0
    if 0 <= index < len(names):
        state.selected, state.tried, state.scroll = names[index], names[index], True


def _grid(shown: tuple[Card, ...], state: BrowserState, pictures: Textures, sections: Textures,
          problems: Mapping[str, str]) -> int:
    """Draw the rows in sight; the number of columns."""
    room, gap = imgui.get_content_region_avail(), theme.em(0.55)
    columns = max(1, int((room.x + gap) / (theme.em(CELL) + gap)))
    width = float(int((room.x - (columns - 1) * gap) / columns))
    size = ImVec2(width, round(width * (PICTURE + SECTION) + TITLE * imgui.get_text_line_height() + theme.em(0.7)))
    if not shown:
        imgui.text_disabled("No lens matches" + (": clear the filters" if state.shelf.is_filtered else ""))
        if state.shelf.part == "favourites" and not state.favourites:
            imgui.text_disabled(f"A click on {fa.ICON_FA_STAR} makes a lens a favourite")
        state.in_sight = ()
        return columns
    rows = -(-len(shown) // columns)
    if state.scroll:
        selected_row = next((i for i, card in enumerate(shown) if card.name == state.selected), 0) // columns
        top, pitch = imgui.get_scroll_y(), size.y + gap
        if not top <= selected_row * pitch <= top + room.y - size.y:
            imgui.set_scroll_y(max(0.0, selected_row * pitch - 0.5 * (room.y - size.y)))
        state.scroll = False
    sight: list[str] = []
    state.section, state.top = _section_look(width), imgui.get_scroll_y()
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(gap, gap))
    clipper = imgui.ListClipper()
    clipper.begin(rows, size.y + gap)
    while clipper.step():
        for row in range(clipper.display_start, clipper.display_end):
            for i in range(row * columns, min((row + 1) * columns, len(shown))):
                card = shown[i]
                if i % columns:
                    imgui.same_line()
                sight.append(card.name)
                _cell(card, state, size, pictures(card.name), sections(card.name), problems.get(card.name, ""))
    clipper.end()
    imgui.pop_style_var()
    drawn = set(sight)
    state.in_sight = (*sight, *(card.name for card in shown if card.name not in drawn))
    return columns


def _section_look(width: float) -> SectionLook:
    """The look of a section in a cell of this width (pixels); the same one for widths that differ little."""
    inset = 2.0 * theme.em(0.35)
    across = max(1, int((width - inset) // WIDTH_STEP) * WIDTH_STEP)
    return SectionLook((across, max(1, round(SECTION * (across + inset) - inset))), theme.colours().dark, theme.scale())


def _cell(card: Card, state: BrowserState, size: ImVec2, picture: Picture | None, section: Picture | None,
          problem: str) -> None:
    """One lens: picture, section, title, and a line of its figures."""
    colour, pixel, draw = theme.colours(), theme.scale(), imgui.get_window_draw_list()
    corner = imgui.get_cursor_screen_pos()
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    imgui.set_next_item_allow_overlap()
    if imgui.invisible_button(card.name, size):
        state.selected = state.tried = card.name
        state.in_grid = True
    hovered, selected = imgui.is_item_hovered(), card.name == state.selected
    if hovered and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        state.tried, state.kept = card.name, True
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        _explain(card, problem)

    ground = colour.frame_active if selected else colour.frame if hovered else colour.well
    below = ImVec2(end.x, round(corner.y + PICTURE * size.x))
    draw.add_rect_filled(ImVec2(corner.x, below.y), end, theme.packed(ground), 3.0 * pixel,
                         imgui.ImDrawFlags_.round_bottom)
    if picture is not None:
        _picture(draw, picture, corner, below)
    else:
        draw.add_rect_filled(corner, below, theme.packed(colour.ground), 3.0 * pixel)
        if problem:
            draw.add_text(ImVec2(corner.x + theme.em(0.5), corner.y + theme.em(0.5)), theme.packed(colour.warning),
                          theme.shortened("No picture", size.x - theme.em(1.0)))
    bottom = round(below.y + SECTION * size.x)
    if section is not None:
        texture, (across, down) = section
        left, top = round(corner.x + 0.5 * (size.x - across)), round(0.5 * (below.y + bottom - down))
        axis = top + down // 2 + 0.5
        draw.add_line(ImVec2(left, axis), ImVec2(left + across, axis), theme.packed(colour.faint, 0.55), pixel)
        draw.add_image(imgui.ImTextureRef(texture), ImVec2(left, top), ImVec2(left + across, top + down))
    if selected:
        draw.add_rect(corner, end, theme.packed(colour.strong), 3.0 * pixel, 1.5 * pixel)
    margin = theme.em(0.5)
    room = size.x - 2.0 * margin
    theme.small()
    inks = *[theme.packed(colour.strong if selected else colour.text)] * 2, theme.packed(colour.dim)
    for i, (text, ink) in enumerate(zip((*_title_lines(card.title, room), _figures(card)), inks, strict=True)):
        place = ImVec2(corner.x + margin, bottom + theme.em(0.15) + i * imgui.get_text_line_height())
        draw.add_text(place, ink, theme.shortened(text, room))
    imgui.pop_font()
    _star(card, state, ImVec2(end.x, corner.y), hovered)
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)                           # the whole cell again, for the place of the next one


def _picture(draw: imgui.ImDrawList, picture: Picture, corner: ImVec2, end: ImVec2) -> None:
    """The picture between two corners, whole and in the middle."""
    texture, (across, down) = picture
    width, height = end.x - corner.x, end.y - corner.y
    scale = min(width / across, height / down)
    x, y = round(corner.x + 0.5 * (width - scale * across)), round(corner.y + 0.5 * (height - scale * down))
    right, bottom = min(round(x + scale * across), end.x), min(round(y + scale * down), end.y)
    black = theme.packed((0.0, 0.0, 0.0, 1.0))
    for upper, lower in (((corner.x, corner.y), (end.x, y)), ((corner.x, bottom), (end.x, end.y)),
                         ((corner.x, y), (x, bottom)), ((right, y), (end.x, bottom))):
        if upper[0] < lower[0] and upper[1] < lower[1]:         # around the picture, so that no pixel is drawn twice
            draw.add_rect_filled(ImVec2(*upper), ImVec2(*lower), black)
    draw.add_image(imgui.ImTextureRef(texture), ImVec2(x, y), ImVec2(right, bottom))


def _star(card: Card, state: BrowserState, corner: ImVec2, hovered: bool) -> None:
    """The star of a favourite; of the lens under the mouse too, to make it one."""
    is_favourite = card.name in state.favourites
    side = theme.em(1.5)
    imgui.set_cursor_screen_pos(ImVec2(corner.x - side, corner.y))
    if imgui.invisible_button(f"Star {card.name}", ImVec2(side, side)):
        if is_favourite:
            state.favourites.remove(card.name)
        else:
            state.favourites.append(card.name)
    over = imgui.is_item_hovered()
    imgui.set_item_tooltip("Remove from the favourites" if is_favourite else "Add to the favourites")
    if not (is_favourite or hovered or over):
        return
    draw, white = imgui.get_window_draw_list(), theme.packed((1.0, 1.0, 1.0, 1.0 if is_favourite or over else 0.55))
    size = imgui.calc_text_size(fa.ICON_FA_STAR)
    icon = ImVec2(corner.x - 0.5 * (side + size.x), corner.y + 0.5 * (side - size.y))
    draw.add_circle_filled(ImVec2(corner.x - 0.5 * side, corner.y + 0.5 * side), 0.46 * side,
                           theme.packed((0.0, 0.0, 0.0, 0.55)))
    if is_favourite:
        draw.add_text(icon, white, fa.ICON_FA_STAR)
    else:
        draw.add_text(icon, white, fa.ICON_FA_PLUS)


def _title_lines(title: str, room: float) -> tuple[str, str]:
    """The title in two lines; the first ends where a word no longer fits into the room (pixels)."""
    words = title.split(" ")
    count = next((i for i in range(2, len(words) + 1) if imgui.calc_text_size(" ".join(words[:i])).x > room),
                 len(words) + 1) - 1
    return " ".join(words[:count]), " ".join(words[count:])


def figures(card: Card) -> tuple[str, str]:
    """Focal length, “82.5 mm” or “71–196 mm”, and f-number of the design as computed; "" for what is not known."""
    digits = 0 if card.tele_efl and card.efl and card.efl >= 9.95 else 1
    lengths = "–".join(fixed(length, digits) for length in (card.efl, card.tele_efl) if length)
    speed = card.computed_f_number
    return f"{lengths} mm" if lengths else "", f"f/{significant(speed, 3)}" if speed else ""


def _figures(card: Card) -> str:
    return "  ".join(text for text in (*figures(card), str(card.year or "")) if text)


def _explain(card: Card, problem: str) -> None:
    if not imgui.begin_tooltip():
        return
    imgui.push_text_wrap_pos(theme.em(24.0))
    imgui.text_unformatted(card.title)
    theme.small()
    film = film_of(card)
    built = f"{card.elements} elements in {card.groups} groups" if card.elements else ""
    for line in (", ".join(str(text) for text in (card.kind, card.maker, card.designer, card.year) if text),
                 card.patent or card.source, built, film_name(film) if film else "",
                 f"Good for {', '.join(card.uses)}" if card.uses else "",
                 f"Estimated: {card.estimates}" if card.estimates else ""):
        if line:
            imgui.text_disabled(line)
    if problem:
        imgui.text_colored(imgui.ImVec4(*theme.colours().warning), f"No picture: {problem}")
    imgui.pop_font()
    imgui.pop_text_wrap_pos()
    imgui.end_tooltip()


def _footer(state: BrowserState, missing: int) -> None:
    """Buttons, what the keys do, and how many pictures are being made."""
    imgui.dummy(ImVec2(0.0, 0.0))
    if imgui.button("Keep"):
        state.kept = True
    imgui.set_item_tooltip("Keep the lens that is tried (Enter, double click)")
    imgui.same_line(0.0, theme.em(0.35))
    if imgui.button("Back"):
        state.returned = True
    imgui.set_item_tooltip("Return to the lens before (Escape)")
    imgui.same_line(0.0, theme.em(0.35))
    if imgui.button("Open…"):
        state.opens_file = True
    imgui.set_item_tooltip("Open a lens file (Ctrl+O)")
    text = f"Taking {missing} pictures" if missing > 1 else "Taking a picture" if missing else \
        "Click to try, Enter keeps, Escape returns"
    theme.small()
    text = theme.shortened(text, imgui.get_window_pos().x + imgui.get_window_width() - imgui.get_item_rect_max().x
                           - theme.em(1.5))
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(text).x)
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(text)
    imgui.pop_font()


fa = icons_fontawesome_6
PARTS = {"all": "All", "favourites": fa.ICON_FA_STAR, "recent": "Recent"}
PART_TIPS = {"all": "The whole library", "favourites": "Favourites: the lenses with a star",
             "recent": "The lenses that were used last, the newest first"}


def search(shelf: Shelf, focus: bool) -> Shelf:
    """Draw the search and the parts; the changed shelf. focus: text is typed there from now on."""
    parts = theme.em(8.4)
    if focus:
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(imgui.get_content_region_avail().x - parts)
    _, text = imgui.input_text_with_hint("##Search lenses", "Search name, use, maker, kind, patent, year", shelf.search,
                                         imgui.InputTextFlags_.auto_select_all)
    imgui.same_line(0.0, theme.em(0.4))
    shelf_part = toggles("Lenses", PARTS, shelf.part, PART_TIPS, indent=0.0)
    return replace(shelf, search=text, part=shelf_part)


def filters(shelf: Shelf, cards: Sequence[Card], shown: int) -> Shelf:
    """Draw the filters, the order and the number of lenses shown."""
    gap = theme.em(0.35)
    width = (imgui.get_content_region_avail().x - 5.0 * gap) / 6.0
    changed: dict[str, Any] = {}
    choices = (("kind", "Kind", kinds(cards), "The kind of design"),
               ("era", "Era", list(ERAS), "The year of the design"),
               ("maker", "Maker", makers(cards), "Who sold the lens, else whose patent it is"),
               ("length", "Length", list(LENGTHS), "Focal length; a zoom where its range meets this one"),
               ("speed", "Speed", list(SPEEDS), "The f-number wide open"),
               ("film", "Format", list(FORMATS), "The film that the lens was made for"))
    for i, (name, label, values, tip) in enumerate(choices):
        if i:
            imgui.same_line(0.0, gap)
        value = getattr(shelf, name)
        changed[name] = picked(label, value, {ANY: "Any"} | {text: text for text in values}, tip, width,
                               text=value or label, colour=theme.colours().strong if value else theme.colours().dim)

    imgui.push_style_var(imgui.StyleVar_.frame_padding, ImVec2(theme.em(0.35), imgui.get_style().frame_padding.y))
    corner, changed["use"] = imgui.get_cursor_screen_pos(), shelf.use
    right = corner.x + imgui.get_content_region_avail().x
    for i, (use, rule) in enumerate(USES.items()):
        if i and imgui.get_item_rect_max().x + 0.5 * gap + imgui.calc_text_size(use).x + theme.em(0.9) < right:
            imgui.same_line(0.0, 0.5 * gap)
        if _toggle(use.capitalize(), use == shelf.use, f"Good for {use}: {rule}") != (use == shelf.use):
            changed["use"] = ANY if use == shelf.use else use
    imgui.pop_style_var()
    if imgui.get_item_rect_min().y > corner.y:          # in a second row, which has room
        imgui.same_line(0.0, gap)
    changed["zooms"] = _toggle("Zoom", shelf.zooms, "Zoom lenses only")
    imgui.same_line(0.0, gap)
    changed["aspheric"] = _toggle("Asphere", shelf.aspheric, "Lenses with an aspheric surface only")
    imgui.same_line(0.0, theme.em(1.0))
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Sort")
    imgui.same_line(0.0, theme.em(0.5))
    names = {key: title for key, (title, _) in ORDERS.items()}
    changed["order"] = picked("Sort", shelf.order, names, "The order; a search sorts by relevance", theme.em(8.0))
    shelf = replace(shelf, **changed)
    if shelf.is_filtered:
        imgui.same_line(0.0, gap)
        if imgui.button("Clear"):
            shelf = shelf.without_filters()
        imgui.set_item_tooltip("Remove all filters")
    count = f"{shown} of {len(cards)}"
    imgui.same_line(imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(count).x)
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(count)
    return shelf


def _toggle(label: str, on: bool, tip: str) -> bool:
    colour = theme.colours()
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame_active if on else colour.frame)))
    clicked = imgui.button(label)
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tip)
    return on != clicked
