"""Small controls: key chords, numbers, toggles, padlocks, lists and paragraphs."""

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import reduce
from operator import or_
from typing import TypeVar

from imgui_bundle import ImVec2, ImVec4, icons_fontawesome_6, imgui

from lensbench.app.drawing import theme


def chord(*keys: imgui.Key) -> int:
    """Keys pressed together, as one number.

    imgui.Key is a flag whose members share bits, and the `|` of Python 3.11.2 (Debian 12) fails on such members.
    """
    return reduce(or_, map(int, keys))


def beside(lines: Iterable[str], wrap: float = 0.0) -> None:
    """Let the next tooltip stand next to the item just drawn and not cover it; at the mouse where it has no room.

    lines: that it will show. wrap: the width in em at which they are broken; 0 for none.
    """
    low, high, style = imgui.get_item_rect_min(), imgui.get_item_rect_max(), imgui.get_style()
    sizes = [imgui.calc_text_size(line, False, theme.em(wrap) if wrap else -1.0) for line in lines]
    wide = max(size.x for size in sizes) + 2.0 * style.window_padding.x
    tall = sum(size.y + style.item_spacing.y for size in sizes) + 2.0 * style.window_padding.y
    gap, screen = theme.em(0.4), imgui.get_main_viewport().size
    level, upright = min(low.y, screen.y - tall - gap), min(low.x, screen.x - wide - gap)
    sides = [(high.x + gap, level), (low.x - gap - wide, level)]
    above = [(upright, high.y + gap), (upright, low.y - gap - tall)]
    for x, y in sides + above if high.x - low.x > 4.0 * (high.y - low.y) else above + sides:
        if min(x, y) >= 0.0 and x + wide <= screen.x and y + tall <= screen.y:
            imgui.set_next_window_pos(ImVec2(x, y))
            return


def explain(text: str) -> None:
    """A tooltip of the item just drawn, next to it."""
    if text and imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        beside(text.split("\n"))
        imgui.set_tooltip(text)


def number(label: str, value: float, bounds: tuple[float, float], step: float, form: str, tip: str,
           width: float = 4.6, indent: float = 0.0) -> float:
    """Draw a field after its dim label; returns the value, within its bounds.

    bounds: least and greatest value. step: change per pixel. form: printf format with the unit. width: in em. indent:
    of the field, in em; 0: it follows the label.
    """
    imgui.align_text_to_frame_padding()
    imgui.text_disabled(label)
    imgui.same_line(theme.em(indent), 0.0 if indent else theme.em(0.4))
    imgui.set_next_item_width(theme.em(width))
    _, value = imgui.drag_float(f"###{label}", value, step, *bounds, form, imgui.SliderFlags_.always_clamp)
    explain(f"{tip}\nDrag sideways, Alt for fine steps; double-click to type")
    return float(value)


GAP = 0.75                      # em between groups
KEPT = 1.9                      # em at the right, for the button of the panel's menu


def same_row_if_room(width: float) -> None:
    """Put the next group into the row of the last item if `width` em of it fit there, else into a new row."""
    right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x - theme.em(KEPT)
    if imgui.get_item_rect_max().x + theme.em(GAP + width) <= right:
        imgui.same_line(0.0, theme.em(GAP))


Key = TypeVar("Key", bound=Hashable)


def toggles(label: str, names: Mapping[Key, str], value: Key, tips: Mapping[Key, str],
            indent: float = 3.2) -> Key:
    """Draw the row after its dim label, `indent` em wide (0: no label); returns the chosen key."""
    colour = theme.colours()
    if indent:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(label)
        imgui.same_line(theme.em(indent))
    for i, (key, name) in enumerate(names.items()):
        on = key == value
        if i:
            imgui.same_line(0.0, 2.0 * theme.scale())
        imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame if on else (0.0, 0.0, 0.0, 0.0))))
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
        if imgui.button(f"{name}###{label} {key}"):
            value = key
        imgui.pop_style_color(2)
        explain(tips[key])
    return value


@contextmanager
def _edged() -> Iterator[None]:
    imgui.push_style_var(imgui.StyleVar_.frame_border_size, max(theme.scale(), 1.0))
    imgui.push_style_color(imgui.Col_.border, ImVec4(*theme.colours().faint))
    yield
    imgui.pop_style_color()
    imgui.pop_style_var()


def radio(name: str, chosen: bool) -> bool:
    """A radio button; returns whether it was clicked."""
    with _edged():
        return imgui.radio_button(name, chosen)


def check_box(name: str, on: bool) -> bool:
    """A check box; returns its value after this frame."""
    with _edged():
        return imgui.checkbox(name, on)[1]


def one_of(title: str, names: dict[str, str], tips: dict[str, str], current: str) -> str:
    """A radio button for each choice, with its tooltip; returns the key of the chosen one."""
    imgui.text_disabled(title)
    for key, name in names.items():
        if radio(name, key == current):
            current = key
        explain(tips[key])
    return current


LEAVES = {"film": "this film", "aperture": "this f-number",
          "focus": "this focus distance and camera position",
          "framing": "the subject's size: the camera moves"}
TAKES = {"film": "switches to the format it was designed for", "aperture": "opens the aperture fully",
         "focus": "moves the camera until the subject is framed and in focus",
         "framing": "frames the subject anew, and another field of view changes its size"}


def padlock(name: str, locked: set[str], corner: ImVec2) -> None:
    """Draw the padlock with its upper left corner there, next to an item that has been drawn; a click changes `locked`.

    name: "film", "aperture", "focus" or "framing".
    """
    colour, is_locked, cursor = theme.colours(), name in locked, imgui.get_cursor_screen_pos()
    line = imgui.get_text_line_height()
    imgui.set_cursor_screen_pos(corner)
    if imgui.invisible_button(f"Lock {name}", ImVec2(theme.em(1.0), line)):
        locked ^= {name}
    ink = colour.text if imgui.is_item_hovered() else colour.strong if is_locked else colour.faint
    explain(f"Locked: another {'lens, format or field of view' if name == 'framing' else 'lens'} keeps {LEAVES[name]}"
            if is_locked else
                           f"Another lens {TAKES[name]}. Click to keep {LEAVES[name]} instead")
    theme.small()
    icon = icons_fontawesome_6.ICON_FA_LOCK if is_locked else icons_fontawesome_6.ICON_FA_LOCK_OPEN
    size = imgui.calc_text_size(icon)
    imgui.get_window_draw_list().add_text(
        ImVec2(round(corner.x + 0.5 * (theme.em(1.0) - size.x)), round(corner.y + 0.5 * (line - size.y))),
        theme.packed(ink), icon)
    imgui.pop_font()
    imgui.set_cursor_screen_pos(cursor)


def paragraph(text: str, strong: bool = False) -> None:
    """Text wrapped at the edge of the window; dim, or strong."""
    imgui.push_text_wrap_pos(0.0)
    (imgui.text_unformatted if strong else imgui.text_disabled)(text)
    imgui.pop_text_wrap_pos()


def warning(text: str, width: float = 0.0) -> None:
    """Text in the colour of warnings, wrapped at the edge of the window or at a width in em."""
    imgui.push_text_wrap_pos(theme.em(width))
    imgui.text_colored(imgui.ImVec4(*theme.colours().warning), text)
    imgui.pop_text_wrap_pos()


def wrapped_tooltip(lines: Iterable[str], width: float = 30.0) -> None:
    """A tooltip whose lines are wrapped at a width in em."""
    lines = list(lines)
    beside(lines, width)
    if imgui.begin_tooltip():
        imgui.push_text_wrap_pos(theme.em(width))
        for line in lines:
            imgui.text_unformatted(line)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def small_note(text: str, strong: bool = False) -> None:
    """A paragraph in small text; dim, or strong."""
    theme.small()
    paragraph(text, strong)
    imgui.pop_font()


def two_lines(text: str, width: float) -> list[str]:
    """The text in at most two lines of this width (pixels), broken at a space if it can be; the second is cut."""
    text = text.replace("\n", " ")
    if imgui.calc_text_size(text).x <= width:
        return [text]
    first = text
    while " " in first and imgui.calc_text_size(first).x > width:
        first = first.rsplit(" ", 1)[0]
    if imgui.calc_text_size(first).x > width:           # a word longer than a line
        first = theme.shortened(first, width)
        return [first]
    return [first, theme.shortened(text[len(first):].strip(), width)]


def applies(label: str, width: float = 0.0) -> bool:
    """The button that applies a dialog, `width` em wide; Enter presses it, unless it ends a text or has an item."""
    pressed = imgui.button(label, ImVec2(theme.em(width), 0.0))
    enter = any(imgui.is_key_pressed(key, False) for key in (imgui.Key.enter, imgui.Key.keypad_enter))
    chosen = imgui.get_io().nav_visible or imgui.get_io().want_text_input
    disabled = imgui.get_style().alpha < 1.0            # of begin_disabled
    return pressed or enter and not chosen and not disabled


def cancels(label: str, width: float = 0.0) -> bool:
    """The button that closes a dialog without an effect, `width` em wide; Escape presses it."""
    return imgui.button(label, ImVec2(theme.em(width), 0.0)) or imgui.is_key_pressed(imgui.Key.escape)


def begin_fitted_dialog(title: str) -> bool:
    """Open and begin the dialog; False while it is not drawn. `imgui.end_popup` ends it after True."""
    if not imgui.is_popup_open(title):
        imgui.open_popup(title)
    imgui.set_next_window_pos(imgui.get_main_viewport().get_center(), imgui.Cond_.always, ImVec2(0.5, 0.5))
    return imgui.begin_popup_modal(title, None, imgui.WindowFlags_.no_saved_settings
                                   | imgui.WindowFlags_.always_auto_resize)[0]


def drop_list(label: str, text: str, tooltip: str, content: Callable[[], None], width: float = 0.0,
              colour: theme.Colour | None = None) -> None:
    """A closed list that shows `text`, with a small angle instead of a button.

    Args:
        label: Its name, which is not shown.
        text: The value, cut to the width.
        tooltip: Shown while the list is closed.
        content: Draws the open list.
        width: Pixels; 0 for the rest of the line.
        colour: Of the text, where it is not the usual one.
    """
    corner = imgui.get_cursor_screen_pos()
    width = width or imgui.get_content_region_avail().x
    imgui.set_next_item_width(width)
    imgui.set_next_window_size_constraints(ImVec2(width, 0.0), ImVec2(theme.em(40.0), theme.em(31.0)))
    imgui.push_style_color(imgui.Col_.text, ImVec4(*(colour or theme.colours().text)))
    opened = imgui.begin_combo(f"##{label}", theme.shortened(text, width - theme.em(2.2)),
                               imgui.ComboFlags_.no_arrow_button | imgui.ComboFlags_.height_largest)
    imgui.pop_style_color()
    if opened:
        content()
        imgui.end_combo()
    else:
        explain(tooltip)
    angle(corner, width)


def picked(label: str, value: Key, names: Mapping[Key, str], tooltip: str, width: float = 0.0,
           text: str | None = None, colour: theme.Colour | None = None) -> Key:
    """A `drop_list` of names, one for each key; the key that is chosen. text: shown instead of the chosen name."""
    chosen = value

    def content() -> None:
        nonlocal chosen
        for key, name in names.items():
            # A popup takes no empty identifier
            if imgui.selectable(f"{name}###{key or name}", key == value)[0]:
                chosen = key

    drop_list(label, names[value] if text is None else text, tooltip, content, width, colour)
    return chosen


def angle(corner: ImVec2, width: float) -> None:
    """A small angle at the right of a list, instead of a button."""
    colour, icon = theme.colours(), icons_fontawesome_6.ICON_FA_ANGLE_DOWN
    theme.small()
    size = imgui.calc_text_size(icon)
    imgui.get_window_draw_list().add_text(
        ImVec2(corner.x + width - size.x - theme.em(0.6), corner.y + 0.5 * (imgui.get_frame_height() - size.y)),
        theme.packed(colour.dim), icon)
    imgui.pop_font()
