"""Radio buttons and check boxes with an edge: on the ground of a popup or panel their fill alone is hardly seen."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import ImVec4, imgui

from lensbench.app.widgets import theme


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


def one_of(title: str, names: dict[str, str], tips: dict[str, str], present: str) -> str:
    """A radio button for each choice, with its tooltip; returns the key of the chosen one."""
    imgui.text_disabled(title)
    for key, name in names.items():
        if radio(name, key == present):
            present = key
        imgui.set_item_tooltip(tips[key])
    return present
