"""Focus, a popup of the left column: where the film stands, paraxially or at the least blur."""

from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app import theme
from lensbench.app.focusing import words
from lensbench.app.readings import setup
from lensbench.app.settings import FOCUSINGS, Settings

TIPS = {
    "auto": "Paraxially where that is as good; at the least blur where a point in focus is half a pixel sharper there",
    "paraxial": "The limit of small stops, in closed form: the distance that is engraved on a lens",
    "real": "Where the whole bundle of the aperture in use has its least rms blur on the axis",
}


def focus_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the settings as they have been set."""
    imgui.text_disabled("Focus")
    for key, name in FOCUSINGS.items():
        if imgui.radio_button(name, key == settings.focusing):
            settings = replace(settings, focusing=key)
        imgui.set_item_tooltip(TIPS[key])
    imgui.push_text_wrap_pos(0.0)
    theme.small()
    try:
        imgui.text_disabled(words(setup(settings).focusing))
    except (ValueError, OSError) as error:
        imgui.text_disabled(str(error))
    imgui.pop_font()
    imgui.pop_text_wrap_pos()
    return settings
