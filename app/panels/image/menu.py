"""The menus of the render's tools: size and look of the picture, its views, and the comparison."""

from dataclasses import replace
from typing import Any

from imgui_bundle import ImVec2, imgui

from lensbench.app.display.frame import View
from lensbench.app.state.constraints import with_longer_side
from lensbench.app.state.request import Request
from lensbench.app.state.setting_table import COMPARISONS, TONES, VIEWS
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.marked import check_box

LONGER_SIDES = (480, 640, 960, 1280, 1920, 2880)
SAMPLES = (16, 64, 256, 1024, 4096)
VIEW_TIPS = {
    "picture": "The light that the camera sees",
    "direction": "The direction d of the rays in the world as a colour, (d + 1) / 2",
    "origin": "Where the rays leave the lens",
    "fate": "Rays from all over the rear opening: white where they arrive in the scene, grey where the stop ends them, "
            "another colour where a rim or total reflection does",
    "time": "When between the opening and the closing of the shutter each sample is taken",
    "depth": "How near each thing is: white for the nearest, black for the sky",
    "weight": "What the camera lets through to each place: cos⁴, vignetting and the pupil's size",
}
COMPARISON_KEYS = {"off": "", "side": "S", "wipe": "W", "difference": "D"}
COMPARISON_TIPS = {
    "off": "The present picture alone",
    "side": "A at the left, the present picture at the right",
    "wipe": "A and the present picture in one place: drag the line between them",
    "difference": "How far the present picture is from A, channel by channel, in linear light",
}
KEEP = imgui.SelectableFlags_.no_auto_close_popups


def picture_menu(settings: Settings, view: View) -> Settings:
    """Draw the menu into the popup that is open; the settings as chosen."""
    chosen = settings
    _label("Pixels", True, 0, 6.0)
    if _choice("As the window shows", view.follows, 12.0):
        view.follows = True
    imgui.set_item_tooltip("One pixel of the picture for each of the screen; fewer while something is dragged,\n"
                           "if a picture would take too long")
    for i, longer in enumerate(LONGER_SIDES):
        _label("", i % 3 == 0, i % 3, 6.0)
        sized = with_longer_side(settings, longer)
        same = (sized.pixels_x, sized.pixels_y) == (settings.pixels_x, settings.pixels_y) and not view.follows
        if _choice(f"{sized.pixels_x} × {sized.pixels_y}", same, 5.6):
            chosen, view.follows = sized, False
    imgui.separator()
    for i, samples in enumerate(SAMPLES):
        _label("Samples", i == 0, i, 3.0)
        if _choice(f"{samples}", samples == settings.samples, 2.6):
            chosen = replace(settings, samples=samples)
    traced = check_box("Light tracing", settings.light_tracing)
    if traced != settings.light_tracing:
        chosen = replace(settings, light_tracing=traced)
    imgui.set_item_tooltip("Trace lamps, lit windows and what mirrors, panes and balls show of them from the light\n"
                           "to the film, so that their blur is smooth in the first frame. Off: the camera's rays\n"
                           "have to find them, which comes to the same picture later")
    chosen = _added(chosen, "ghosts", "ghost_strength", "Add light of the sun and of small lights that two surfaces of "
                    "the lens reflect to the\nfilm, true to scale. The coating is that of the popup “Stop”. Not where "
                    "anything moves")
    chosen = _added(chosen, "stars", "star_strength", "Add light of the sun and of small lights that the edges of the "
                    "blades diffract:\nn rays for an even number of blades, 2 n for an odd one, longer with a "
                    "smaller stop, true\nto scale. Not where anything moves")
    imgui.separator()
    for i, (key, name) in enumerate(TONES.items()):
        _label("Tone", i == 0, i, 4.6)
        if _choice(f"{name}###{key}", key == settings.tone, 4.2):
            chosen = replace(settings, tone=key)
    return chosen


def view_menu(settings: Settings) -> Settings:
    """Draw the menu of the views into the open popup; returns the settings as chosen."""
    for key, name in VIEWS.items():
        if imgui.selectable(f"{name}###{key}", key == settings.view)[0]:
            settings = replace(settings, view=key)
        imgui.set_item_tooltip(VIEW_TIPS[key])
    return settings


def comparison_menu(settings: Settings, pinned: Settings | None, view: View) -> Settings:
    """Draw the menu of the comparison into the open popup; returns the settings as chosen.

    pinned: the settings of the picture A; None if there is none.
    """
    if imgui.menu_item("Pin as A", "A", False)[0]:
        view.requests.add(Request.PIN)
    imgui.set_item_tooltip("Keep the present picture, to compare later ones with it; it goes on refining")
    imgui.separator()
    for key, name in COMPARISONS.items():
        if imgui.menu_item(f"{name}###{key}", COMPARISON_KEYS[key], key == settings.compare, pinned is not None)[0]:
            settings = replace(settings, compare=key)
        imgui.set_item_tooltip(COMPARISON_TIPS[key])
    imgui.separator()
    if imgui.menu_item("Lock A's dials to B", "K", view.locked, pinned is not None)[0]:
        view.locked = not view.locked
    imgui.set_item_tooltip("A follows every dial that is turned in B: focus, aperture, exposure, place, scene…\n"
                           "It keeps its own lens and camera model")
    if imgui.menu_item("Take A's settings", "", False, pinned is not None)[0] and pinned is not None:
        settings = replace(pinned, compare=settings.compare, wipe=settings.wipe, overlay=settings.overlay)
    imgui.set_item_tooltip("Take over all settings of the picture A; undo brings the present ones back")
    return settings


def _added(settings: Settings, field: str, strength: str, tip: str) -> Settings:
    """A switch for light that is added to the picture, with its strength where it is on; the fields of both."""
    on = check_box(field.capitalize(), getattr(settings, field))
    imgui.set_item_tooltip(tip)
    changes: dict[str, Any] = {} if on == getattr(settings, field) else {field: on}
    if getattr(settings, field):
        imgui.same_line()
        imgui.set_next_item_width(theme.em(7.0))
        changed, value = imgui.slider_float(f"###{field} strength", getattr(settings, strength), 0.1, 100.0, "× %.3g",
                                            imgui.SliderFlags_.logarithmic)
        imgui.set_item_tooltip(f"Strength of the {field}; × 1 is true to scale with the direct light")
        if changed:
            changes[strength] = value
    return replace(settings, **changes) if changes else settings


def _label(text: str, first: bool, column: int, width: float) -> None:
    """Begin a row with its label, or go on in its next column."""
    if first:
        imgui.text_disabled(text)
    imgui.same_line(theme.em(5.0 + column * width))


def _choice(label: str, chosen: bool, width: float) -> bool:
    return imgui.selectable(label, chosen, KEEP, ImVec2(theme.em(width), 0.0))[0]
