"""Radio buttons of the popups of the left column."""

from imgui_bundle import imgui


def one_of(title: str, names: dict[str, str], tips: dict[str, str], present: str) -> str:
    """A radio button for each choice, with its tooltip; returns the key of the chosen one."""
    imgui.text_disabled(title)
    for key, name in names.items():
        if imgui.radio_button(name, key == present):
            present = key
        imgui.set_item_tooltip(tips[key])
    return present
