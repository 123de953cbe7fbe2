"""Parts of the popups of the left column: radio buttons, and a small note below them."""

from imgui_bundle import imgui

from lensbench.app.widgets import theme


def one_of(title: str, names: dict[str, str], tips: dict[str, str], present: str) -> str:
    """A radio button for each choice, with its tooltip; returns the key of the chosen one."""
    imgui.text_disabled(title)
    for key, name in names.items():
        if imgui.radio_button(name, key == present):
            present = key
        imgui.set_item_tooltip(tips[key])
    return present


def small_note(text: str) -> None:
    """Dim small text over as many lines as it needs."""
    imgui.push_text_wrap_pos(0.0)
    theme.small()
    imgui.text_disabled(text)
    imgui.pop_font()
    imgui.pop_text_wrap_pos()
