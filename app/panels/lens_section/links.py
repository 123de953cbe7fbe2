"""What the mouse points at, drawn in the section: the rays of a pixel, one ray of a plot, lit surfaces."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.lens_section.draw import (
    DEAD_ALPHA,
    LIVE_ALPHA,
    OPEN,
    Canvas,
    draw_cross,
    ray_paths,
    within,
)
from lensbench.app.state.geometry.elements import elements, surface_curves
from lensbench.app.state.geometry.ray_fans import Fan
from lensbench.app.state.geometry.section import Sketch
from lensbench.app.widgets import theme
from lensbench.optics.finding import Finding, Kind

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
    at, best, found = np.array([mouse.x, mouse.y]), reach, -1
    for i, curve in enumerate(surface_curves(sketch.lens)):
        if i == sketch.lens.stop_index and sketch.stop_radius is not None:
            outer = max(sketch.open_radius or sketch.stop_radius, sketch.near_stop)
            height = abs(canvas.view.to_lens(canvas.corner, mouse)[1])
            beside = sketch.stop_radius <= height <= 1.12 * outer
            away = abs(canvas.at(sketch.stop_z, 0.0).x - mouse.x) if beside else np.inf
        else:
            points = canvas.memo.of(("surface", sketch.lens, i, canvas), partial(canvas.pixels, curve))
            step = np.diff(points, axis=0)
            t = np.clip(((at - points[:-1]) * step).sum(1) / np.maximum((step**2).sum(1), 1e-12), 0.0, 1.0)
            away = float(np.hypot(*(points[:-1] + t[:, None] * step - at).T).min())
        if away < best:
            best, found = away, i
    if found >= 0:
        return (found,)
    z, y = canvas.view.to_lens(canvas.corner, mouse)
    for element in elements(sketch.lens):
        if element.holds(z, y):
            return element.front, element.front + 1
    return ()
