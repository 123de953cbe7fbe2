"""Popup “Focus” of the left column: the film's position, paraxial or of least blur, and its tilt and shift."""

from dataclasses import replace

from lensbench.app.panels.controls.film_dials import film_dials
from lensbench.app.state.build import design, focus_text, setup
from lensbench.app.state.setting_table import FOCUS_POSITIONS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.marked import one_of
from lensbench.app.widgets.paragraph import small_note

TIPS = {
    "auto": "The paraxial focus, or the position of least blur where a point in focus is half a pixel sharper there",
    "paraxial": "The limit of small stops, in closed form: the distance engraved on a lens",
    "real": "The position where all rays of the present aperture have the least rms blur on the axis",
}


def focus_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    if settings.follows_lens:
        settings = replace(settings, focus_position=one_of("Focus", FOCUS_POSITIONS, TIPS, settings.focus_position))
        try:
            small_note(focus_text(setup(settings).focusing))
        except (ValueError, OSError) as error:
            small_note(str(error))
    try:
        design(settings)
    except (ValueError, OSError):               # a notice says why
        return settings
    return film_dials(settings)
