"""A row of flat buttons of which one is switched on: a choice among few without a list."""

from collections.abc import Hashable, Mapping
from typing import TypeVar

from imgui_bundle import imgui

from lensbench.app.widgets import theme

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
        imgui.set_item_tooltip(tips[key])
    return value
