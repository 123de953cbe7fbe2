"""The cardinal points of the section with their names, and the ray under the mouse."""

from math import floor

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_section.draw import OPEN, Canvas
from lensbench.app.state.geometry.ray_fans import Fan
from lensbench.app.state.geometry.section import Sketch
from lensbench.app.widgets import theme


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
    """The fan and number of the ray nearest to the mouse within reach (pixels); a dead ray's cross counts first."""
    at = np.array([mouse.x, mouse.y])
    best, found = reach, None
    for fan in sketch.fans:
        for i, ray in enumerate(fan.rays):
            if ray.kind == "dead" and not dead:
                continue
            path = canvas.pixels(ray.path)
            if ray.kind == "dead" and np.hypot(*(path[-1] - at)) < 2.0 * reach:
                distance = 0.25 * float(np.hypot(*(path[-1] - at)))
            else:
                a, step = path[:-1], np.diff(path, axis=0)
                t = np.clip(((at - a) * step).sum(1) / np.maximum((step**2).sum(1), 1e-12), 0.0, 1.0)
                distance = float(np.hypot(*(a + t[:, None] * step - at).T).min())
            if distance < best:
                best, found = distance, (fan, i)
    return found
