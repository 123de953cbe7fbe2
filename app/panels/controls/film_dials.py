"""Tilt, swing, rise and shift of the film in the popup “Focus”: the dials of a view camera."""

from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.state import dial_scales
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import sentence
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.paragraph import small_note
from lensbench.kernels.figures import significant


def in_use(settings: Settings) -> bool:
    """Whether the film is out of line."""
    return not settings.film_pose.is_upright


def film_dials(settings: Settings) -> Settings:
    """Draw the four dials, a button that sets them to 0, and what is in focus; the changed settings."""
    most = float(significant(0.5 * max(settings.film_width, settings.film_height), 2))
    lean, move = dial_scales.lean_scale(), dial_scales.move_scale(most)
    settings = replace(
        settings,
        tilt=dial("Tilt", settings.tilt, lean, "The top of the film goes back, so that near ground comes into focus.\n"
                                               "A lens tilted down does the same"),
        swing=dial("Swing", settings.swing, lean, "The right side of the film, seen from behind, goes back,\n"
                                                  "so that what is near at the left comes into focus"),
        rise=dial("Rise", settings.rise, move, "The lens stands higher than the film: the picture shows what is "
                                               "higher,\nand upright lines stay parallel"),
        shift=dial("Shift", settings.shift, move, "The lens stands to the right of the film: the picture shows more of "
                                                  "the right"))
    imgui.begin_disabled(not in_use(settings))
    if imgui.button("In line"):
        settings = settings.plain("tilt", "swing", "rise", "shift")
    imgui.set_item_tooltip("All four to 0")
    imgui.end_disabled()
    small_note(sentence(settings))
    return settings
