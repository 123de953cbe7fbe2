"""Another lens under the section of the present one, to the same scale.

The lens A of a comparison has its film in the same place. The lens before its edits has its first vertex in the same
place, so that only what an edit has changed parts from it.
"""

from dataclasses import replace
from math import floor
from typing import NamedTuple

from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_section.draw import OPEN, Canvas, ray_paths
from lensbench.app.state.geometry.elements import elements
from lensbench.app.state.geometry.section import Sketch, sketch
from lensbench.app.state.lens_edit.editing import reverted
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme

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
