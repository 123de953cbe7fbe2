"""The drawer *Flare*: ghosts, stars, and the blades and the coating that shape them."""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.build import bench_of, coating, design, stop_picture
from lensbench.app.bench.lens_choice import with_scene
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import check_box, explain, paragraph, small_note, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.session.notices import Request
from lensbench.app.settings import dial_scales
from lensbench.app.settings.camera_facts import AUTO
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.flare_worker import FlareWorker
from lensbench.core.optics.iris import Iris
from lensbench.core.optics.stop_image import StopImage
from lensbench.core.text import cut, fixed, significant

SHORT = {AUTO: "Year", "uncoated": "None", "single-layer": "Single", "multi-layer": "Multi"}
COATING_TIPS = {AUTO: "By the year of the lens: coated after 1945, with several layers after 1970",
                "uncoated": "Bare glass",
                "single-layer": "A quarter wave of MgF₂: 1.4 % of green light is lost at each surface of\n"
                                "crown glass to air, 0.3 % at one of dense flint",
                "multi-layer": "Three layers: 0.1 % of green light is lost at each surface to air,\n"
                               "0.2 to 0.3 % on average from blue to red"}
PICTURE_TIP = ("A picture as the shape of the stop, instead of blades: white passes the light, black and clear parts\n"
               "are opaque. Its longer side is the diameter of the stop. Lights behind the plane in focus show it\n"
               "upright; the picture keeps its brightness")
MOSAIC = 48             # cells across the sketch of a picture
BLADES = (0, 5, 6, 7, 8, 9, 11)
SHOWING = "low-sun"             # a scene whose lights show ghosts and stars
SWITCHES = {
    "ghosts": "Light of the sun and of small lights that two surfaces of the lens reflect to the film,\ntrue to scale. "
              "The coating below sets how much. Not where anything moves",
    "stars": "Diffraction spikes: light of the sun and of small lights that the edges of the blades diffract:\nn rays "
             "for an even number of blades, 2 n for an odd one, longer with a smaller stop. Not where anything moves"}


@dataclass
class FlareState:
    """What the drawer keeps from frame to frame. blades: their controls are shown though the lens is as designed."""

    worker: FlareWorker = field(default_factory=FlareWorker)
    blades: bool = False


def flare_in_use(settings: Settings) -> bool:
    """Whether flare is shown, or the stop differs from the design."""
    return settings.ghosts or settings.stars or stop_in_use(settings)


def flare_popup(settings: Settings, state: FlareState, requests: set[Request]) -> Settings:
    """Draw the drawer's content; the changed settings. `requests` of the window receives that for a picture's file."""
    reasons = state.worker.reasons(settings)
    for name in SWITCHES:
        settings = _switch(settings, name)
        if reasons.get(name):
            paragraph(reasons[name])
    if any(reasons.values()) and settings.scene != SHOWING and settings.has_lens:
        if imgui.button("Try the scene Low sun"):
            settings = with_scene(settings, SHOWING)
        explain("A low sun and small bright lamps, which show both (undo to go back)")
    shown = state.blades or stop_in_use(settings)
    on = check_box("Blades & coating", shown)
    explain("Another number of blades, a picture as the stop, or another coating; off: as the lens was "
                           "designed")
    if on != shown:
        state.blades = on
        settings = settings if on else settings.plain("blades", "blade_rotation", "roundness", "stop_image", "coating")
    return _stop(settings, requests) if on else settings


def _switch(settings: Settings, name: str) -> Settings:
    """The switch of light that is added to the picture, with its strength where it is on."""
    on, strength = check_box(name.capitalize(), getattr(settings, name)), f"{name[:-1]}_strength"
    explain(SWITCHES[name])
    changes: dict[str, Any] = {} if on == getattr(settings, name) else {name: on}
    if getattr(settings, name):
        imgui.same_line(theme.em(6.2))
        imgui.set_next_item_width(theme.em(7.0))
        changed, value = imgui.slider_float(f"###{name} strength", getattr(settings, strength), 0.1, 100.0, "× %.3g",
                                            imgui.SliderFlags_.logarithmic)
        explain(f"Strength of the {name}; × 1 is true to scale with the direct light")
        if changed:
            changes[strength] = value
    return replace(settings, **changes) if changes else settings


def stop_in_use(settings: Settings) -> bool:
    """Whether the stop differs from the design."""
    return settings.blades is not None or bool(settings.stop_image) or settings.coating != AUTO


def _stop(settings: Settings, requests: set[Request]) -> Settings:
    """The shape of the stop, and the coating."""
    settings = settings if _own_picture(settings) or settings.stop_image else _blades(settings)
    settings = _picture(settings, requests)
    _sketch(*_opening(settings))
    if settings.has_lens:
        settings = replace(settings, coating=toggles("Coating", SHORT, settings.coating, COATING_TIPS, 3.9))
        with suppress(ValueError, OSError):
            of = coating(settings, design(settings))
            small_note(f"For T-stop and ghosts: {of.name}, {of.why}")
    return settings


def _picture(settings: Settings, requests: set[Request]) -> Settings:
    """The picture in the stop: its name, and buttons that choose and clear one."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Picture")
    imgui.same_line(theme.em(3.6) + imgui.get_style().window_padding.x)
    chosen = settings.stop_image or _own_picture(settings)
    if imgui.button(f"{cut(Path(chosen).name, 18) if chosen else 'Choose…'}###Picture"):
        requests.add(Request.OPEN_STOP_IMAGE)
    explain(f"{chosen}\n\n{PICTURE_TIP}".strip())
    if chosen:
        imgui.same_line()
        if imgui.button("Clear"):
            settings = replace(settings, stop_image="") if settings.stop_image else replace(settings, blades=0)
        explain("Take the picture out of the stop; its blades, or the picture of the lens, come back"
                               if settings.stop_image else "Take the picture of the lens out of its stop")
    elif _own_picture(settings.plain("blades")):
        imgui.same_line()
        if imgui.button("That of the lens"):
            settings = settings.plain("blades")
        explain("Put the picture of the lens back into its stop")
    return settings


def _own_picture(settings: Settings) -> str:
    """The file of the picture that the lens itself has in its stop, as its file names it; "" for none."""
    if settings.stop_image or not settings.has_lens:
        return ""
    image = iris(settings).image
    return "" if image is None else image.name or "picture"


def _blades(settings: Settings) -> Settings:
    """Number, rotation and roundness of the blades."""
    current, own = iris(settings), iris(settings.plain("blades"))
    names = {blades: f"{blades}" if blades else "Round" for blades in BLADES}
    tips = {blades: f"An iris of {blades} blades" if blades else "A round stop" for blades in BLADES}
    blades = toggles("Blades", names, current.blades, tips, 3.6)
    if blades != current.blades:
        settings = replace(settings, blades=None if blades == own.blades and own.image is None else blades)
    if settings.blades is not None and current.blades:
        rotation = settings.blade_rotation % (2.0 * math.pi / current.blades)
        turn = dial("Rotation", rotation, dial_scales.turn_scale(current.blades),
                    "Rotation of the iris, counter-clockwise seen from the scene")
        round_ = dial("Roundness", settings.roundness, dial_scales.part_scale(1.0),
                      "0 %: straight blades; 100 %: a circle")
        settings = replace(settings, blade_rotation=turn, roundness=round_)
    return settings


def iris(settings: Settings) -> Iris:
    """The shape of the stop of these settings; a circle where the lens cannot be read."""
    try:
        if settings.has_lens:
            return design(settings).iris
        if settings.stop_image:
            return Iris(image=stop_picture(settings.stop_image))
        return Iris(settings.blades or 0, settings.blade_rotation, settings.roundness)
    except (ValueError, OSError):
        return Iris()


def _opening(settings: Settings) -> tuple[Iris, float, bool]:
    """The opening at this f-number, its radius over that of the open stop, and whether there is an open stop."""
    try:
        if settings.has_lens:
            lens, wide = bench_of(settings).lens, design(settings)
            return lens.iris, lens.stop.semi_diameter / wide.stop.semi_diameter, True
    except (ValueError, OSError):
        pass
    return iris(settings), 1.0, False


def _sketch(current: Iris, size: float, opens: bool) -> None:
    """The opening within the circle of the stop, and the part of its light that passes.

    size: of the opening over the stop wide open. opens: whether the circle is a stop that opens so far.
    """
    pixel, colour = theme.scale(), theme.colours()
    radius, corner, room = theme.em(3.2), imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    imgui.dummy(ImVec2(room.x, 2.0 * radius + theme.em(0.6)))
    centre = ImVec2(corner.x + 0.5 * room.x, corner.y + radius + theme.em(0.3))
    draw = imgui.get_window_draw_list()
    draw.add_circle(centre, radius, theme.packed(colour.faint), 64, pixel)
    if current.image is not None:
        _sketch_picture(current.image, centre, size * radius)
    outline = [ImVec2(centre.x + float(x), centre.y - float(y)) for x, y in size * radius * current.outline(12)]
    draw.add_convex_poly_filled(outline, theme.packed(colour.text, 0.25 if current.image is None else 0.0))
    draw.add_polyline(outline, theme.packed(colour.text), 1.5 * pixel, imgui.ImDrawFlags_.closed)
    if not opens:
        return
    percent = 100.0 * current.area * size**2 / math.pi
    text = f"{fixed(percent, 0) if percent >= 9.5 else significant(percent, 2)} %"
    extent = imgui.calc_text_size(text)
    origin = ImVec2(round(centre.x - 0.5 * extent.x), round(centre.y - 0.5 * extent.y))
    draw.add_text(origin, theme.packed(colour.strong), text)
    explain("The opening at this f-number, and the part of the open stop's light that it passes.\n"
                           "Wide open, the blades lie behind the edge of the stop; the f-number is that of\n"
                           "the circle of equal area")


def _sketch_picture(image: StopImage, centre: ImVec2, radius: float) -> None:
    """The picture in the circle of the stop, as a mosaic."""
    draw, colour = imgui.get_window_draw_list(), theme.colours()
    edge_x, edge_y = (np.round(middle + radius * np.linspace(-1.0, 1.0, MOSAIC + 1)) for middle in (centre.x, centre.y))
    centres = (np.arange(MOSAIC) + 0.5) * (2.0 / MOSAIC) - 1.0
    light = image.at(centres, -centres[:, None])
    for line, column in np.argwhere(light > 0.0).tolist():
        draw.add_rect_filled(ImVec2(float(edge_x[column]), float(edge_y[line])),
                             ImVec2(float(edge_x[column + 1]), float(edge_y[line + 1])),
                             theme.packed(colour.text, 0.5 * float(light[line, column])))
