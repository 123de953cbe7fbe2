"""A list that drops down from the value that is chosen."""

from collections.abc import Callable, Mapping

from imgui_bundle import ImVec2, ImVec4, icons_fontawesome_6, imgui

from lensbench.app.widgets import theme
from lensbench.app.widgets.toggles import Key


def drop_list(label: str, text: str, tooltip: str, content: Callable[[], None], width: float = 0.0,
              colour: theme.Colour | None = None) -> None:
    """A closed list that shows `text`, with a small angle in place of a button.

    Parameters
    ----------
    label : str
        Its name, which is not shown.
    text : str
        The value, cut to the width.
    tooltip : str
        Shown while the list is closed.
    content : callable
        Draws the open list.
    width : float
        Pixels; 0 for the rest of the line.
    colour : colour of the theme, optional
        Of the text, where it is not the usual one.
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
        imgui.set_item_tooltip(tooltip)
    angle(corner, width)


def picked(label: str, value: Key, names: Mapping[Key, str], tooltip: str, width: float = 0.0,
           text: str | None = None, colour: theme.Colour | None = None) -> Key:
    """A `drop_list` of names, one for each key; the key that is chosen. text: shown in place of the chosen name."""
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
    """A small angle at the right of a list, in place of a button."""
    colour, icon = theme.colours(), icons_fontawesome_6.ICON_FA_ANGLE_DOWN
    theme.small()
    size = imgui.calc_text_size(icon)
    imgui.get_window_draw_list().add_text(
        ImVec2(corner.x + width - size.x - theme.em(0.6), corner.y + 0.5 * (imgui.get_frame_height() - size.y)),
        theme.packed(colour.dim), icon)
    imgui.pop_font()
