"""Colour, a popup of the left column: whether a picture is traced with the dispersion of the glasses."""

from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app import theme
from lensbench.app.readings import colours
from lensbench.app.settings import DISPERSIONS, Settings

TIPS = {
    "auto": "With dispersion where the glasses of the lens are known, at the d line elsewhere",
    "on": "With dispersion. A lens whose glasses are not known turns this back",
    "off": "Everything at the d line: no colour errors, and three times as fast",
}


def can_disperse(settings: Settings) -> bool:
    """Whether there is anything to choose: a real lens whose glasses are known."""
    try:
        return colours(settings).possible
    except (ValueError, OSError):
        return False


def dispersion_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the settings as they have been set."""
    imgui.text_disabled("Dispersion")
    for key, name in DISPERSIONS.items():
        if imgui.radio_button(name, key == settings.dispersion):
            settings = replace(settings, dispersion=key)
        imgui.set_item_tooltip(TIPS[key])
    imgui.push_text_wrap_pos(0.0)
    theme.small()
    imgui.text_disabled(colours(settings).why)
    imgui.pop_font()
    imgui.pop_text_wrap_pos()
    return settings
