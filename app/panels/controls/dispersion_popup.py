"""Colour, a popup of the left column: whether a picture is traced with the dispersion of the glasses."""

from dataclasses import replace

from lensbench.app.state.figures import colours
from lensbench.app.state.settings import DISPERSIONS, Settings
from lensbench.app.widgets.radio import one_of, small_note

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
    settings = replace(settings, dispersion=one_of("Dispersion", DISPERSIONS, TIPS, settings.dispersion))
    small_note(colours(settings).why)
    return settings
