"""A film out of line in the section: the film, the plane of sharp focus with its wedge, and its lines."""

from math import hypot

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_section.draw import OPEN, Canvas, dashed
from lensbench.app.state.view_camera import InSection
from lensbench.app.widgets import theme


def draw_posed(draw: imgui.ImDrawList, posed: InSection, canvas: Canvas) -> None:
    """The film as a line, the plane of sharp focus in amber, the ends of its wedge dashed, and the named points."""
    colour, pixel = theme.colours(), theme.scale()
    for name in ("near", "far", "sharp"):
        line = _across(posed.planes[name], canvas) if name in posed.planes else None
        if line is None:
            continue
        if name == "sharp":
            draw.add_line(*line, theme.packed(colour.amber), 1.6 * pixel)
            _named(draw, line, "Sharp", canvas)
        else:
            dashed(draw, *line, theme.packed(colour.amber, 0.7))
    for name, point in posed.points.items():
        at = canvas.at(float(point[0]), float(point[1]))
        if not (canvas.x < at.x < canvas.x + canvas.width and canvas.y < at.y < canvas.y + canvas.height):
            continue
        draw.add_circle_filled(at, 3.0 * pixel, theme.packed(colour.amber))
        size = imgui.calc_text_size(name)
        x = min(at.x + 6.0 * pixel, canvas.x + canvas.width - size.x - 4.0 * pixel)
        y = min(max(at.y - 0.5 * size.y, canvas.y), canvas.y + canvas.height - size.y)
        draw.add_text(ImVec2(x, y), theme.packed(colour.amber_text), name)
    draw.add_polyline(canvas.points(posed.film), theme.packed(colour.strong), 2.5 * pixel, OPEN)


def _across(plane: tuple[np.ndarray, np.ndarray], canvas: Canvas) -> tuple[ImVec2, ImVec2] | None:
    """The part of a line of the section that lies in the panel (Liang-Barsky), in pixels; None for none."""
    (z, y), (dz, dy) = plane
    start, ahead = canvas.at(float(z), float(y)), canvas.at(float(z + dz), float(y + dy))
    dx, dy = ahead.x - start.x, ahead.y - start.y
    low, high = -np.inf, np.inf
    for at, step, first, last in ((start.x, dx, canvas.x, canvas.x + canvas.width),
                                  (start.y, dy, canvas.y, canvas.y + canvas.height)):
        if abs(step) < 1e-12:
            if not first <= at <= last:
                return None
            continue
        near, far = sorted(((first - at) / step, (last - at) / step))
        low, high = max(low, near), min(high, far)
    if not low < high or hypot(dx, dy) == 0.0:
        return None
    return (ImVec2(start.x + low * dx, start.y + low * dy), ImVec2(start.x + high * dx, start.y + high * dy))


def _named(draw: imgui.ImDrawList, line: tuple[ImVec2, ImVec2], name: str, canvas: Canvas) -> None:
    upper = min(line, key=lambda end: end.y)
    size, pixel = imgui.calc_text_size(name), theme.scale()
    x = min(max(upper.x + 5.0 * pixel, canvas.x + 4.0 * pixel), canvas.x + canvas.width - size.x - 4.0 * pixel)
    draw.add_text(ImVec2(x, upper.y + 1.5 * size.y), theme.packed(theme.colours().amber_text), name)
