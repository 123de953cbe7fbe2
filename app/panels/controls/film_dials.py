"""Tilt, swing, rise, shift and curvature of the film in the popup “Focus”."""

import math
from contextlib import suppress
from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.state import dial_scales
from lensbench.app.state.build import setup
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import sentence
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.paragraph import small_note
from lensbench.imaging.film_pose import least_radius
from lensbench.kernels.figures import significant, true_minus


def in_use(settings: Settings) -> bool:
    """Whether the film is out of line."""
    return not settings.film_pose.is_upright


def film_dials(settings: Settings) -> Settings:
    """Draw the dials, buttons that set them, and what is in focus; the changed settings."""
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
    settings = _curvature(settings)
    imgui.begin_disabled(not in_use(settings))
    if imgui.button("In line"):
        settings = settings.plain("tilt", "swing", "rise", "shift", "film_radius")
    imgui.set_item_tooltip("All four to 0, and a flat film")
    imgui.end_disabled()
    imgui.same_line()
    with suppress(ValueError, OSError):
        petzval = setup(settings).first_order.petzval_radius
        imgui.begin_disabled(not abs(petzval) > _least(settings))
        if imgui.button("Petzval"):
            settings = replace(settings, film_radius=petzval if math.isfinite(petzval) else None)
        imgui.set_item_tooltip("The film takes the Petzval curvature of the lens, on which it is sharp without "
                               "astigmatism:\n" + (f"radius {true_minus(significant(petzval, 3))} mm"
                                                   if math.isfinite(petzval) else "flat"))
        imgui.end_disabled()
    small_note(sentence(settings))
    return settings


def _least(settings: Settings) -> float:
    """The smallest radius (mm) to which this film can be curved."""
    return least_radius(settings.film.width, settings.film.height)


def _curvature(settings: Settings) -> Settings:
    """The dial of the film's curvature."""
    before = settings.film_pose.curvature
    scale = dial_scales.curvature_scale(_least(settings))
    after = dial("Curvature", before, scale, "Radius of a film that is curved as a sphere; with a minus its sides come "
                                             "nearer to the lens,\nas the sharp image of most lenses does")
    return settings if after == before else replace(settings, film_radius=1.0 / after if after else None)
