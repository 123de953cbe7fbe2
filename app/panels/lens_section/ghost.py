"""The lens A under the section of the present one: to the same scale, with both films in one place."""

from dataclasses import replace
from math import floor

from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_section.draw import OPEN, Canvas, ray_paths
from lensbench.app.state.geometry.section import Sketch, elements, sketch
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme

RAYS, OUTLINES = 0.55, 0.95     # opacity


def ghost_of(other: Settings | None) -> Sketch | None:
    """The sketch of the settings A; None without A, or where it has no lens to draw."""
    if other is None:
        return None
    try:
        return sketch(other)
    except (ValueError, OSError):
        return None


def front_of(shown: Sketch, ghost: Sketch) -> float:
    """Where the lens A begins (mm) in the frame of the shown one."""
    first = min([0.0, *(float(ray.path[1][0]) for fan in ghost.fans for ray in fan.rays)])
    return first + shown.film_z - ghost.film_z


def draw_ghost(draw: imgui.ImDrawList, shown: Sketch, ghost: Sketch, canvas: Canvas) -> None:
    """Outlines, stop and film of A, its marginal rays of the axis and its other chief rays, in the colour of A."""
    view = canvas.view
    canvas = replace(canvas, view=replace(view, x=view.x + (shown.film_z - ghost.film_z) * view.scale))
    colour, pixel = theme.colours(), theme.scale()
    tint = theme.packed(theme.compared(), OUTLINES)
    for fan in ghost.fans:
        for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
            if ray.kind == ("chief" if fan.height else "marginal"):
                draw.add_polyline(path, theme.packed(theme.compared(), RAYS), pixel, OPEN)
    if ghost.lens is not None:
        for element in elements(ghost.lens):
            draw.add_polyline(canvas.points(element.outline), tint, 1.2 * pixel, imgui.ImDrawFlags_.closed)
    if ghost.stop_radius is not None:
        outer = max(1.12 * (ghost.open_radius or ghost.stop_radius), 1.08 * ghost.near_stop)
        for sign in (1.0, -1.0):
            draw.add_line(canvas.at(ghost.stop_z, sign * ghost.stop_radius), canvas.at(ghost.stop_z, sign * outer),
                          tint, 2.0 * pixel)
    film = canvas.at(ghost.film_z, 0.0)
    for sign in (1.0, -1.0):                            # beside the film of B, where it is longer
        end = canvas.at(ghost.film_z, sign * ghost.film_height)
        draw.add_line(ImVec2(film.x - 3.0 * pixel, end.y), ImVec2(film.x + 3.0 * pixel, end.y), tint, 1.5 * pixel)
        draw.add_line(ImVec2(film.x, film.y), end, tint, pixel)
    front = canvas.at(0.0, ghost.glass_radius)
    size = imgui.calc_text_size("A")
    at = ImVec2(max(floor(front.x - size.x - 4.0 * pixel), canvas.x + 4.0 * pixel),
                max(floor(front.y - 0.5 * size.y), canvas.y + 2.0 * size.y))
    draw.add_rect_filled(ImVec2(at.x - 2.0 * pixel, at.y), ImVec2(at.x + size.x + 2.0 * pixel, at.y + size.y),
                         theme.packed(colour.well, 0.8), 2.0 * pixel)
    draw.add_text(at, theme.packed(theme.compared()), "A")
