"""Focus, a popup of the left column: where the film stands, paraxially or at the least blur."""

from dataclasses import replace

from lensbench.app.state.figures import setup
from lensbench.app.state.focusing import words
from lensbench.app.state.settings import FOCUS_POSITIONS, Settings
from lensbench.app.widgets.radio import one_of, small_note

TIPS = {
    "auto": "Paraxially where that is as good; at the least blur where a point in focus is half a pixel sharper there",
    "paraxial": "The limit of small stops, in closed form: the distance that is engraved on a lens",
    "real": "Where the whole bundle of the aperture in use has its least rms blur on the axis",
}


def focus_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the settings as they have been set."""
    settings = replace(settings, focusing=one_of("Focus", FOCUS_POSITIONS, TIPS, settings.focusing))
    try:
        small_note(words(setup(settings).focusing))
    except (ValueError, OSError) as error:
        small_note(str(error))
    return settings
