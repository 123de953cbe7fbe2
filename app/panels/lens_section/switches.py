"""The switches over the section: dead rays, editing, and the view from the side or from above; a text beside them.

Another lens under the section of the present one, to the same scale.

The lens A of a comparison has its film in the same place. The lens before its edits has its first vertex in the same
place, so that only what an edit has changed parts from it.
"""

from dataclasses import replace
from math import floor
from typing import NamedTuple

from imgui_bundle import ImVec2, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.panels.lens_section.draw import OPEN, Canvas, ray_paths
from lensbench.app.panels.lens_section.handles import HandleState
from lensbench.app.plots.section import Sketch, elements, sketch
from lensbench.app.session.edited_lens import reverted
from lensbench.app.settings.settings import Settings

RAYS, OUTLINES = 0.55, 0.95     # opacity


class Ghost(NamedTuple):
    """A sketch, how far its frame lies behind that of the shown lens (mm), and a short name."""

    sketch: Sketch
    shift: float
    name: str


def ghost_of(other: Settings | None, settings: Settings, shown: Sketch) -> Ghost | None:
    """The ghost of other settings; None without them, or where they have no lens to draw."""
    if other is None:
        return None
    try:
        sketched = sketch(other, shown.above)
    except (ValueError, OSError):
        return None
    if settings.edited and other == reverted(settings):
        return Ghost(sketched, 0.0, "original")
    return Ghost(sketched, shown.film_z - sketched.film_z, "A")


def front_of(ghost: Ghost) -> float:
    """Where the ghost begins (mm) in the frame of the shown lens."""
    return min([0.0, *(float(ray.path[1][0]) for fan in ghost.sketch.fans for ray in fan.rays)]) + ghost.shift


def draw_ghost(draw: imgui.ImDrawList, ghost: Ghost, canvas: Canvas) -> None:
    """Outlines, stop and film of the ghost, its marginal rays of the axis and its other chief rays, in its colour."""
    view, name = canvas.view, ghost.name
    canvas = replace(canvas, view=replace(view, x=view.x + ghost.shift * view.scale))
    ghosted = ghost.sketch
    colour, pixel = theme.colours(), theme.scale()
    tint = theme.packed(theme.compared(), OUTLINES)
    for fan in ghosted.fans:
        for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
            if ray.kind == ("chief" if fan.height else "marginal"):
                draw.add_polyline(path, theme.packed(theme.compared(), RAYS), pixel, OPEN)
    if ghosted.lens is not None:
        for element in elements(ghosted.lens):
            draw.add_polyline(canvas.points(element.outline), tint, 1.2 * pixel, imgui.ImDrawFlags_.closed)
    if ghosted.stop_radius is not None:
        outer = max(1.12 * (ghosted.open_radius or ghosted.stop_radius), 1.08 * ghosted.near_stop)
        for sign in (1.0, -1.0):
            draw.add_line(canvas.at(ghosted.stop_z, sign * ghosted.stop_radius),
                          canvas.at(ghosted.stop_z, sign * outer), tint, 2.0 * pixel)
    film = canvas.at(ghosted.film_z, 0.0)
    for sign in (1.0, -1.0):                            # beside the film of B, where it is longer
        end = canvas.at(ghosted.film_z, sign * ghosted.film_height)
        draw.add_line(ImVec2(film.x - 3.0 * pixel, end.y), ImVec2(film.x + 3.0 * pixel, end.y), tint, 1.5 * pixel)
        draw.add_line(ImVec2(film.x, film.y), end, tint, pixel)
    front = canvas.at(0.0, ghosted.glass_radius)
    size = imgui.calc_text_size(name)
    at = ImVec2(max(floor(front.x - size.x - 4.0 * pixel), canvas.x + 4.0 * pixel),
                max(floor(front.y - 0.5 * size.y), canvas.y + 2.0 * size.y))
    draw.add_rect_filled(ImVec2(at.x - 2.0 * pixel, at.y), ImVec2(at.x + size.x + 2.0 * pixel, at.y + size.y),
                         theme.packed(colour.well, 0.8), 2.0 * pixel)
    draw.add_text(at, theme.packed(theme.compared()), name)


SIDE, TOP = "Side view, y–z", "Top view, x–z"


def blocked_ray_switch(corner: ImVec2, width: float, shown: bool) -> tuple[bool, bool]:
    """The switch of blocked rays, in the upper left corner; whether they are shown, and the mouse over it."""
    text = f"{fa.ICON_FA_EYE if shown else fa.ICON_FA_EYE_SLASH}  Blocked rays"
    pad = theme.em(0.4)
    if width < imgui.calc_text_size(text).x + 4.0 * pad:
        return shown, False
    pressed, hovered = _switch("Blocked rays", text, ImVec2(corner.x + 2.0 * pad, corner.y + pad), shown, False,
                               "Show blocked rays up to the surface that stops them")
    return shown != pressed, hovered


def edit_switch(corner: ImVec2, left: float, state: HandleState) -> bool:
    """The switch of editing, `left` pixels right of the corner of the panel; returns whether the mouse is over it."""
    pressed, hovered = _switch("Edit section", f"{fa.ICON_FA_PEN}  Edit", ImVec2(corner.x + left, corner.y
                                                                                + theme.em(0.4)),
                               state.active, True, "Drag vertices, clear apertures, surfaces, gaps and elements\n"
                               "Ctrl bends an element at constant power, Shift is finer\n"
                               "A click shows the handles of tilt and decentre")
    state.active = state.active != pressed
    return hovered


def view_switch(corner: ImVec2, width: float, above: bool) -> tuple[bool, bool]:
    """The switch between side and top, in the upper right corner; whether it is the top, and the mouse over it."""
    text = f"{fa.ICON_FA_ROTATE}  {TOP if above else SIDE}"
    at = ImVec2(corner.x + width - imgui.calc_text_size(text).x - theme.em(0.8), corner.y + theme.em(0.4))
    pressed, hovered = _switch("Section side", text, at, above, False,
                               "From above: right of the camera is up\nClick: from the side" if above else
                               "From the side: up in the scene is up\nClick: from above")
    return above != pressed, hovered


def place_of_text(text: str, corner: ImVec2, width: float, has_switches: bool, has_view: bool) -> tuple[ImVec2, ImVec2]:
    """Corner and size of the room for a text over the drawing: beside the switches, or below them."""
    height = 2.0 * imgui.get_text_line_height()
    if not has_switches:
        return corner, ImVec2(width, height)
    left = theme.em(12.0)
    room = width - left - (theme.em(9.0) if has_view else 0.0)
    if imgui.calc_text_size(text).x < room - theme.em(1.5):
        return ImVec2(corner.x + left, corner.y), ImVec2(room, height)
    lines = imgui.calc_text_size(text, False, max(width - theme.em(1.5), 1.0)).y
    return ImVec2(corner.x, corner.y + theme.em(1.6)), ImVec2(width, max(height, lines))


def _switch(name: str, text: str, at: ImVec2, is_on: bool, framed: bool, hint: str) -> tuple[bool, bool]:
    """A flat switch with its text at a place; whether it was pressed, and whether the mouse is over it."""
    colour, pad, draw = theme.colours(), theme.em(0.4), imgui.get_window_draw_list()
    extent = imgui.calc_text_size(text)
    low = ImVec2(at.x - pad, at.y - 0.5 * pad)
    imgui.set_cursor_screen_pos(low)
    pressed = imgui.invisible_button(name, ImVec2(extent.x + 2.0 * pad, extent.y + pad))
    hovered = imgui.is_item_hovered()
    imgui.set_item_tooltip(hint)
    lit = is_on != pressed
    if framed and lit:
        draw.add_rect_filled(low, ImVec2(at.x + extent.x + pad, at.y + extent.y + 0.5 * pad),
                             theme.packed(colour.frame_active), imgui.get_style().frame_rounding)
    tint = colour.strong if framed and lit else colour.text if hovered else colour.dim
    draw.add_text(at, theme.packed(tint, 1.0 if lit or hovered else 0.7), text)
    return pressed, hovered
