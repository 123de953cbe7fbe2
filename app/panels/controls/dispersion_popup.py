"""Popup “Colour” of the left column: the dispersion of the glasses, on or off."""

from dataclasses import replace

from lensbench.app.state.figures import colours
from lensbench.app.state.setting_table import DISPERSIONS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.marked import one_of
from lensbench.app.widgets.paragraph import small_note

TIPS = {
    "auto": "With dispersion where the glasses of the lens are known, otherwise at the d line",
    "on": "With dispersion. A lens with unknown glasses sets this back to automatic",
    "off": "Everything at the d line: no colour errors, and three times as fast",
}


def can_disperse(settings: Settings) -> bool:
    """Whether dispersion is possible: a real lens whose glasses are known."""
    try:
        return colours(settings).possible
    except (ValueError, OSError):
        return False


def dispersion_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    settings = replace(settings, dispersion=one_of("Dispersion", DISPERSIONS, TIPS, settings.dispersion))
    small_note(colours(settings).why)
    return settings
