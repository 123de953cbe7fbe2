"""Popup “Stop” of the left column: the shape of the iris."""

import math
from contextlib import suppress
from dataclasses import replace

from imgui_bundle import ImVec2, imgui

from lensbench.app.state import dial_scales
from lensbench.app.state.build import design
from lensbench.app.state.coating import coating
from lensbench.app.state.lens_settings import AUTO
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.paragraph import small_note
from lensbench.app.widgets.toggles import toggles
from lensbench.kernels.figures import fixed
from lensbench.optics.iris import Iris

SHORT = {AUTO: "Year", "uncoated": "None", "single-layer": "Single", "multi-layer": "Multi"}
COATING_TIPS = {AUTO: "By the year of the lens: coated after 1945, with several layers after 1970",
                "uncoated": "Bare glass",
                "single-layer": "A quarter wave of MgF₂: about 1.3 % is lost at each surface to air",
                "multi-layer": "Three layers: about 0.3 % is lost at each surface to air"}
BLADES = (0, 5, 6, 7, 8, 9, 11)


def in_use(settings: Settings) -> bool:
    """Whether the stop differs from the design."""
    return settings.blades is not None or settings.coating != AUTO


def stop_popup(settings: Settings) -> Settings:
    """Draw the popup's content; the changed settings."""
    here, own = iris(settings), iris(settings.plain("blades"))
    names = {blades: f"{blades}" if blades else "Round" for blades in BLADES}
    tips = {blades: f"An iris of {blades} blades" if blades else "A round stop" for blades in BLADES}
    blades = toggles("Blades", names, here.blades, tips, 3.6)
    if blades != here.blades:
        settings = replace(settings, blades=None if blades == own.blades else blades)
    if settings.blades is not None and here.blades:
        rotation = settings.blade_rotation % (2.0 * math.pi / here.blades)
        turn = dial("Rotation", rotation, dial_scales.turn_scale(here.blades),
                    "Rotation of the iris, counter-clockwise seen from the scene")
        round_ = dial("Roundness", settings.roundness, dial_scales.part_scale(1.0),
                      "0 %: straight blades; 100 %: a circle")
        settings = replace(settings, blade_rotation=turn, roundness=round_)
    _sketch(here)
    if settings.has_lens:
        settings = replace(settings, coating=toggles("Coating", SHORT, settings.coating, COATING_TIPS, 3.9))
        with suppress(ValueError, OSError):
            of = coating(settings, design(settings))
            small_note(f"For T-stop and ghosts: {of.name}, {of.why}")
    return settings


def iris(settings: Settings) -> Iris:
    """The shape of the stop of these settings; a circle where the lens cannot be read."""
    if not settings.has_lens:
        return Iris(settings.blades or 0, settings.blade_rotation, settings.roundness)
    try:
        return design(settings).iris
    except (ValueError, OSError):
        return Iris()


def _sketch(here: Iris) -> None:
    """The opening within the circle through its corners, and the part of the circle's light that it passes."""
    pixel, colour = theme.scale(), theme.colours()
    radius, corner, room = theme.em(3.2), imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    imgui.dummy(ImVec2(room.x, 2.0 * radius + theme.em(0.6)))
    centre = ImVec2(corner.x + 0.5 * room.x, corner.y + radius + theme.em(0.3))
    draw = imgui.get_window_draw_list()
    draw.add_circle(centre, radius, theme.packed(colour.faint), 64, pixel)
    outline = [ImVec2(centre.x + radius * float(x), centre.y - radius * float(y)) for x, y in here.outline(12)]
    draw.add_convex_poly_filled(outline, theme.packed(colour.text, 0.25))
    draw.add_polyline(outline, theme.packed(colour.text), 1.5 * pixel, imgui.ImDrawFlags_.closed)
    text = f"{fixed(100.0 * here.area / math.pi, 0)} %"
    size = imgui.calc_text_size(text)
    place = ImVec2(round(centre.x - 0.5 * size.x), round(centre.y - 0.5 * size.y))
    draw.add_text(place, theme.packed(colour.strong), text)
    imgui.set_item_tooltip("Part of the light of the circle through its corners that the iris passes;\n"
                           "the f-number is that of the circle")


