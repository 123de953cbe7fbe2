"""What the mouse points at, drawn in the section: the rays of a pixel, one ray of a plot, lit surfaces.

The cardinal points of the section with their names, and the ray under the mouse.

A tilted or shifted film in the section: the film, the plane of sharp focus with its wedge, and its lines.
"""

from collections.abc import Sequence
from functools import partial
from math import floor, hypot

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.focus_plane import InSection
from lensbench.app.bench.ray_fans import Fan
from lensbench.app.drawing import theme
from lensbench.app.panels.lens_section.draw import (
    DEAD_ALPHA, LIVE_ALPHA, OPEN, Canvas, dashed, draw_cross, ray_paths, within
)
from lensbench.app.plots.section import Sketch, elements, surface_curves
from lensbench.core.optics.finding import Finding, Kind


def draw_marks(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas) -> list[tuple[float, float, float]]:
    """Draw strokes on the axis at the cardinal points; those under the glass are named in one row below it.

    Returns left end, right end and lower edge (pixels) of each name in that row.
    """
    colour, pixel = theme.colours(), theme.scale()
    axis = canvas.at(0.0, 0.0).y
    line = imgui.get_text_line_height()
    row = canvas.at(0.0, -max(sketch.glass_radius, 1.12 * (sketch.open_radius or 0.0))).y + 9.0 * pixel
    row = floor(min(row, canvas.y + canvas.height - line - pixel))
    shown = [(mark, canvas.at(mark.z, 0.0).x) for mark in sorted(sketch.marks, key=lambda m: m.z)]
    shown = [(mark, x) for mark, x in shown if canvas.x + 6.0 * pixel < x < canvas.x + canvas.width - 6.0 * pixel]
    first, last = canvas.at(0.0, 0.0).x, canvas.at(sketch.rear_z, 0.0).x
    for _, x in shown:
        draw.add_rect_filled(ImVec2(floor(x) - pixel, axis - 5.0 * pixel), ImVec2(floor(x) + pixel, axis + 5.0 * pixel),
                             theme.packed(colour.strong, 0.9))
    names, film = theme.packed(colour.text), canvas.at(sketch.film_z, 0.0).x
    under = []
    for mark, x in shown:
        if first - line < x < last + line:
            under.append((mark, x))
        else:
            left = x - 0.5 * imgui.calc_text_size(mark.sign).x
            if abs(x - film) < 8.0 * pixel:
                left = min(left, film - 4.0 * pixel - imgui.calc_text_size(mark.sign).x)
            draw.add_text(ImVec2(floor(left), floor(axis + 7.0 * pixel)), names, mark.sign)
    widths = [imgui.calc_text_size(mark.sign).x for mark, _ in under]
    centres = pushed_apart([x for _, x in under], widths, 6.0 * pixel)
    leader = theme.packed(colour.faint, 0.8)
    for (mark, x), centre, width in zip(under, centres, widths, strict=True):
        knee = row - 7.0 * pixel
        if knee > axis + 5.0 * pixel:
            draw.add_polyline([ImVec2(floor(x) + 0.5, axis + 5.0 * pixel), ImVec2(floor(x) + 0.5, knee),
                               ImVec2(centre, row)], leader, pixel, OPEN)
        draw.add_text(ImVec2(floor(centre - 0.5 * width), row), names, mark.sign)
    return [(centre - 0.5 * width, centre + 0.5 * width, row + line)
            for centre, width in zip(centres, widths, strict=True)]


def pushed_apart(centres: list[float], widths: list[float], gap: float) -> list[float]:
    """Centres of labels in rising order, moved as little as needed so that none touch."""
    groups: list[list[int]] = []
    placed: list[float] = list(centres)
    for i in range(len(centres)):
        groups.append([i])
        # Place a group about the mean of its wanted places; join it to its neighbour while the two touch
        while True:
            group = groups[-1]
            steps = [0.0]
            for a, b in zip(group, group[1:], strict=False):
                steps.append(steps[-1] + 0.5 * (widths[a] + widths[b]) + gap)
            start = float(np.mean([centres[k] - s for k, s in zip(group, steps, strict=True)]))
            for k, s in zip(group, steps, strict=True):
                placed[k] = start + s
            if len(groups) < 2:
                break
            a, b = groups[-2][-1], group[0]
            if placed[b] - placed[a] >= 0.5 * (widths[a] + widths[b]) + gap - 1e-9:
                break
            groups[-2:] = [groups[-2] + group]
    return placed


def nearest_ray(sketch: Sketch, canvas: Canvas, mouse: ImVec2, reach: float, dead: bool) -> tuple[Fan, int] | None:
    """The fan and number of the ray nearest to the mouse within reach (pixels); a blocked ray's cross counts first."""
    point = np.array([mouse.x, mouse.y])
    best, nearest = reach, None
    for fan in sketch.fans:
        for i, ray in enumerate(fan.rays):
            if ray.kind == "dead" and not dead:
                continue
            path = canvas.pixels(ray.path)
            if ray.kind == "dead" and np.hypot(*(path[-1] - point)) < 2.0 * reach:
                distance = 0.25 * float(np.hypot(*(path[-1] - point)))
            else:
                a, step = path[:-1], np.diff(path, axis=0)
                t = np.clip(((point - a) * step).sum(1) / np.maximum((step**2).sum(1), 1e-12), 0.0, 1.0)
                distance = float(np.hypot(*(a + t[:, None] * step - point).T).min())
            if distance < best:
                best, nearest = distance, (fan, i)
    return nearest


FADED = 0.25                    # opacity of the section's own rays under those of a pixel


def draw_pixel_fan(draw: imgui.ImDrawList, fan: Fan, canvas: Canvas, dead: bool, ideal: bool) -> int:
    """The rays of a pixel, in the strong colour; returns how many rays are drawn."""
    colour, pixel, drawn = theme.colours(), theme.scale(), 0
    for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
        if ray.kind == "dead":
            if not dead:
                continue
            draw.add_polyline(path, theme.packed(colour.dead, DEAD_ALPHA), pixel, OPEN)
            draw_cross(draw, path[-1], theme.packed(colour.dead, 0.9))
        else:
            weight, alpha = (1.6, 1.0) if ray.kind == "chief" else (1.0, 0.85 if ray.kind else LIVE_ALPHA)
            line = theme.packed(colour.strong, alpha)
            if ideal:                                       # may run back between its principal planes: no joins
                for a, b in zip(path, path[1:], strict=False):
                    draw.add_line(a, b, line, weight * pixel)
            else:
                draw.add_polyline(path, line, weight * pixel, OPEN)
        drawn += 1
    return drawn


def draw_ray(draw: imgui.ImDrawList, path: np.ndarray, lost: bool, canvas: Canvas) -> None:
    """One pointed ray (n, 2) of (z, y); lost: it ends in a cross."""
    colour, pixel = theme.colours(), theme.scale()
    points = canvas.points(within(path, canvas))
    draw.add_polyline(points, theme.packed(colour.well, 0.9), 4.0 * pixel, OPEN)
    draw.add_polyline(points, theme.packed(colour.warning if lost else theme.pointed()), 2.0 * pixel, OPEN)
    if lost:
        draw_cross(draw, points[-1], theme.packed(colour.warning))


def draw_lit_surfaces(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, lit: tuple[int, ...],
                      pixel_fan: Fan | None) -> None:
    """Lit surfaces, and every ray that one of them ends, whether or not lost rays are shown."""
    if sketch.lens is None:
        return
    colour, pixel = theme.colours(), theme.scale()
    for surface, curve in enumerate(surface_curves(sketch.lens)):
        if surface in lit and surface != sketch.lens.stop_index:
            draw.add_polyline(canvas.points(curve), theme.packed(colour.strong), 2.5 * pixel, OPEN)
    for fan in (*sketch.fans, *((pixel_fan,) if pixel_fan is not None else ())):
        for ray, path in zip(fan.rays, ray_paths(fan, canvas), strict=True):
            if ray.kind == "dead" and ray.surface in lit:
                draw.add_polyline(path, theme.packed(colour.warning, 0.9), 1.4 * pixel, OPEN)
                draw_cross(draw, path[-1], theme.packed(colour.warning))


def draw_faults(draw: imgui.ImDrawList, sketch: Sketch, canvas: Canvas, faults: Sequence[Finding]) -> None:
    """The surfaces of an edited lens that cannot be as they are; both of an element or a gap that crosses."""
    if sketch.lens is None or not faults:
        return
    colour, pixel = theme.packed(theme.colours().warning), theme.scale()
    curves = surface_curves(sketch.lens)
    for fault in faults:
        if fault.surface is None:
            continue
        both = fault.kind in (Kind.EDGE, Kind.CROSSING, Kind.THICKNESS)
        for curve in curves[fault.surface:fault.surface + (2 if both else 1)]:
            draw.add_polyline(canvas.points(curve), colour, 2.0 * pixel, OPEN)


def surfaces_at(sketch: Sketch, canvas: Canvas, mouse: ImVec2, reach: float) -> tuple[int, ...]:
    """The surface within reach (pixels) of the mouse, or both of the glass under it; the stop by its blades."""
    if sketch.lens is None:
        return ()
    point, best, nearest = np.array([mouse.x, mouse.y]), reach, -1
    for i, curve in enumerate(surface_curves(sketch.lens)):
        if i == sketch.lens.stop_index and sketch.stop_radius is not None:
            outer = max(sketch.open_radius or sketch.stop_radius, sketch.near_stop)
            height = abs(canvas.view.to_lens(canvas.corner, mouse)[1])
            on_blade = sketch.stop_radius <= height <= 1.12 * outer
            away = abs(canvas.at(sketch.stop_z, 0.0).x - mouse.x) if on_blade else np.inf
        else:
            points = canvas.memo.of(("surface", sketch.lens, i, canvas), partial(canvas.pixels, curve))
            step = np.diff(points, axis=0)
            t = np.clip(((point - points[:-1]) * step).sum(1) / np.maximum((step**2).sum(1), 1e-12), 0.0, 1.0)
            away = float(np.hypot(*(points[:-1] + t[:, None] * step - point).T).min())
        if away < best:
            best, nearest = away, i
    if nearest >= 0:
        return (nearest,)
    z, y = canvas.view.to_lens(canvas.corner, mouse)
    for element in elements(sketch.lens):
        if element.holds(z, y):
            return element.front, element.front + 1
    return ()


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
        position = canvas.at(float(point[0]), float(point[1]))
        if not (canvas.x < position.x < canvas.x + canvas.width and canvas.y < position.y < canvas.y + canvas.height):
            continue
        draw.add_circle_filled(position, 3.0 * pixel, theme.packed(colour.amber))
        size = imgui.calc_text_size(name)
        x = min(position.x + 6.0 * pixel, canvas.x + canvas.width - size.x - 4.0 * pixel)
        y = min(max(position.y - 0.5 * size.y, canvas.y), canvas.y + canvas.height - size.y)
        draw.add_text(ImVec2(x, y), theme.packed(colour.amber_text), name)
    draw.add_polyline(canvas.points(posed.film), theme.packed(colour.strong), 2.5 * pixel, OPEN)


def _across(plane: tuple[np.ndarray, np.ndarray], canvas: Canvas) -> tuple[ImVec2, ImVec2] | None:
    """The part of a line of the section that lies in the panel (Liang-Barsky), in pixels; None for none."""
    (z, y), (dz, dy) = plane
    start, ahead = canvas.at(float(z), float(y)), canvas.at(float(z + dz), float(y + dy))
    dx, dy = ahead.x - start.x, ahead.y - start.y
    low, high = -np.inf, np.inf
    for coordinate, step, first, last in ((start.x, dx, canvas.x, canvas.x + canvas.width),
                                          (start.y, dy, canvas.y, canvas.y + canvas.height)):
        if abs(step) < 1e-12:
            if not first <= coordinate <= last:
                return None
            continue
        near, far = sorted(((first - coordinate) / step, (last - coordinate) / step))
        low, high = max(low, near), min(high, far)
    if not low < high or hypot(dx, dy) == 0.0:
        return None
    return (ImVec2(start.x + low * dx, start.y + low * dy), ImVec2(start.x + high * dx, start.y + high * dy))


def _named(draw: imgui.ImDrawList, line: tuple[ImVec2, ImVec2], name: str, canvas: Canvas) -> None:
    upper = min(line, key=lambda end: end.y)
    size, pixel = imgui.calc_text_size(name), theme.scale()
    x = min(max(upper.x + 5.0 * pixel, canvas.x + 4.0 * pixel), canvas.x + canvas.width - size.x - 4.0 * pixel)
    draw.add_text(ImVec2(x, upper.y + 1.5 * size.y), theme.packed(theme.colours().amber_text), name)
