"""The plan: the scene from above with the camera, its field of view, the plane in focus and the band of focus.

The line of the plane in focus is dragged along the camera's axis. Axes in metres, alike in both directions.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, dashed_line, linear_ticks, polyline, text
from lensbench.app.plots.pixel_rays import Pointed, beam
from lensbench.app.plots.plan import Plan, Thing, above, extent, plan, things
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import fixed, true_minus

FARTHEST = 1e6                  # mm: the plane in focus is not drawn beyond it


@dataclass
class PlanState:
    """State of the panel between frames: limits of its plot, and the dragged line."""

    fitted_to: tuple = ()
    fit: bool = False
    grip: float = 0.0           # mm from the mouse to the plane in focus while its line is dragged
    pixel_rays: int = 0         # rays of the pointed pixel that are drawn
    shown: tuple[float, float, float, float] = (0.0, 1.0, 0.0, 1.0)     # limits of the frame before, m: x, then y



def plan_panel(settings: Settings, state: PlanState, links: Pointed | None = None) -> Settings:
    """Draw the plan in the rest of the window; returns the settings with the dragged focus.

    links: what the mouse points at in all panels; the rays of its pixel and its ray are drawn.
    """
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return settings
    try:
        shown, around = plan(settings), things(settings.scene, settings.moment)
        depth = cached_scene(settings.scene).depth_range[1]
        if shown.distance < FARTHEST:               # the wheel shows what lies beyond
            depth = min(depth, max(3.0 * shown.distance, 2000.0))
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return settings

    key = (settings.scene, settings.camera, size.x, size.y)
    refit = state.fit or state.fitted_to != key
    state.fitted_to, state.fit = key, False
    corner = imgui.get_cursor_screen_pos()
    theme.small()
    plot = None
    if implot.begin_plot("Plan plot", size, PLOT_FLAGS | implot.Flags_.equal):
        x, y = implot.ImAxis_.x1, implot.ImAxis_.y1
        roomy = size.x > theme.em(13) and size.y > theme.em(10)
        implot.setup_axis(x, "To the right (m)" if roomy else None, AXIS_FLAGS)
        implot.setup_axis(y, "Ahead (m)" if roomy else None, AXIS_FLAGS)
        if refit:
            x0, x1, y0, y1 = extent(shown, around, depth)
            implot.setup_axis_limits(x, x0, x1, implot.Cond_.always)
            implot.setup_axis_limits(y, y0, y1, implot.Cond_.always)
            state.shown = x0, x1, y0, y1
        for axis, (low, high), length in ((x, state.shown[:2], size.x), (y, state.shown[2:], size.y)):
            implot.setup_axis_ticks(axis, *linear_ticks(low, high, length, theme.em(3.5)), False)
        plot = PlotMap.current(log=False)
        state.shown = plot.x0, plot.x1, plot.y0, plot.y1
        implot.push_plot_clip_rect()
        _draw(implot.get_plot_draw_list(), plot, shown, around)
        if links is not None:
            state.pixel_rays = _draw_pointed(implot.get_plot_draw_list(), plot, settings, links, depth)
        implot.pop_plot_clip_rect()
        if implot.is_plot_hovered():
            state.fit = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
            _tooltip(plot, shown)
        implot.end_plot()
    imgui.pop_font()
    if plot is not None and plot.bottom > plot.top:
        settings = _dragged(settings, shown, plot, state)
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    return settings


def _draw(draw: imgui.ImDrawList, plot: PlotMap, shown: Plan, around: tuple[Thing, ...]) -> None:
    colour, pixel = theme.colours(), theme.scale()

    # Depth of field, objects, field of view, plane in focus
    if shown.band is not None:
        band = _within(plot, shown.band)
        if len(band) > 2:
            draw.add_convex_poly_filled(band, theme.packed(colour.amber, 0.16))
    for thing in around:
        outline = plot.pixels(*thing.outline.T)
        if not thing.shines:
            draw.add_convex_poly_filled([ImVec2(x, y) for x, y in outline.tolist()], theme.packed(colour.text, 0.10))
        polyline(draw, outline, theme.packed(colour.dim if thing.shines else colour.text, 0.55), 1.0, closed=True)
    if shown.view is not None:
        for edge in shown.view:
            draw.add_polyline(_within(plot, edge), theme.packed(colour.text), 1.2 * pixel, imgui.ImDrawFlags_.none)
    line = [] if shown.focus is None or shown.distance >= FARTHEST else _within(plot, shown.focus)
    if line:
        draw.add_polyline(line, theme.packed(colour.amber), 2.0 * pixel, imgui.ImDrawFlags_.none)
        right = max(line, key=lambda point: point.x)
        left = right.x + imgui.calc_text_size("00.00 m").x + 6.0 * pixel > plot.right
        text(draw, ImVec2(min(right.x, plot.right) + (-4.0 if left else 4.0) * pixel,
                          right.y - (1.2 if left else 0.5) * imgui.get_text_line_height()),
             colour.amber_text, format_distance(shown.distance), right=left, plate=True)

    # The camera and its keyframes
    if shown.ends is not None:
        first, last = (plot.at(*point) for point in shown.ends)
        dashed_line(draw, first, last, theme.packed(colour.dim))
        for point in (first, last):
            draw.add_circle(point, 3.5 * pixel, theme.packed(colour.dim), 0, 1.5 * pixel)
    _camera(draw, plot, shown)


def _draw_pointed(draw: imgui.ImDrawList, plot: PlotMap, settings: Settings, links: Pointed, depth: float) -> int:
    """The rays of the pointed pixel up to what they meet, and that of a plot; returns how many rays of the pixel.

    depth: how far (mm) rays to the sky are drawn.
    """
    colour, pixel, drawn = theme.colours(), theme.scale(), 0
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is not None:
        try:
            seen = beam(settings, raster)
        except (ValueError, OSError):           # the panel “Pixel” says why
            return 0
        for origin, direction, end in zip(seen.origins, seen.directions, seen.ends, strict=True):
            line = _within(plot, above(np.stack([origin, origin + min(float(end), 2.0 * depth) * direction])))
            if line:
                draw.add_polyline(line, theme.packed(colour.strong, 0.7), pixel, imgui.ImDrawFlags_.none)
                drawn += 1
        if seen.target is not None:
            draw.add_circle_filled(plot.at(*above(seen.target)), 3.5 * pixel, theme.packed(colour.strong))
    if links.ray is not None and links.ray.target is not None:
        draw.add_circle(plot.at(*above(links.ray.target)), 5.0 * pixel, theme.packed(theme.pointed()), 0, 2.0 * pixel)
    return drawn


def _within(plot: PlotMap, points: np.ndarray) -> list[ImVec2]:
    """A convex outline (n, 2) in metres, or a line of two points, cut at the plot's edges: pixels (Sutherland-Hodgman).

    What lies kilometres away would lose its direction in pixels.
    """
    kept = points
    for axis, sign, edge in ((0, 1.0, plot.x0), (0, -1.0, plot.x1), (1, 1.0, plot.y0), (1, -1.0, plot.y1)):
        inside, cut = sign * (kept[:, axis] - edge), []
        for i in range(len(kept)):
            before, here = inside[i - 1], inside[i]
            if before * here < 0.0:
                cut.append(kept[i - 1] + before / (before - here) * (kept[i] - kept[i - 1]))
            if here >= 0.0:
                cut.append(kept[i])
        if not cut:
            return []
        kept = np.array(cut)
    if len(points) == 2:                # the outline of a line runs there and back
        along = kept @ (points[1] - points[0])
        kept = kept[[int(np.argmin(along)), int(np.argmax(along))]]
    return [ImVec2(x, y) for x, y in plot.pixels(*kept.T).tolist()]


def _camera(draw: imgui.ImDrawList, plot: PlotMap, shown: Plan) -> None:
    """A wedge that points where the camera looks; a ring for one that looks everywhere, or straight down."""
    colour, pixel = theme.colours(), theme.scale()
    here = plot.at(*shown.place)
    length = float(np.hypot(*shown.ahead))
    if shown.view is None or length < 0.05:
        draw.add_circle(here, 5.0 * pixel, theme.packed(colour.strong), 0, 2.0 * pixel)
        return
    dx, dy = shown.ahead[0] / length, -shown.ahead[1] / length
    size = 7.0 * pixel
    draw.add_triangle_filled(ImVec2(here.x + size * dx, here.y + size * dy),
                             ImVec2(here.x - size * (dx + 0.75 * dy), here.y - size * (dy - 0.75 * dx)),
                             ImVec2(here.x - size * (dx - 0.75 * dy), here.y - size * (dy + 0.75 * dx)),
                             theme.packed(colour.strong))


def _dragged(settings: Settings, shown: Plan, plot: PlotMap, state: PlanState) -> Settings:
    """A handle on the middle of the line in focus, to be dragged along the camera's axis."""
    length = float(np.hypot(*shown.ahead))
    if shown.focus is None or shown.distance >= FARTHEST or length < 0.05:
        return settings
    a, b = (plot.at(*point) for point in shown.focus)
    a, b = (ImVec2(min(max(p.x, plot.left), plot.right), min(max(p.y, plot.top), plot.bottom)) for p in (a, b))
    pixel, half = theme.scale(), 6.0 * theme.scale()
    middle = ImVec2(0.5 * (a.x + b.x), 0.5 * (a.y + b.y))
    wide = ImVec2(max(abs(b.x - a.x), 2.0 * half), max(abs(b.y - a.y), 2.0 * half))
    imgui.set_cursor_screen_pos(ImVec2(middle.x - 0.5 * wide.x, middle.y - 0.5 * wide.y))
    imgui.invisible_button("Plane in focus", wide)
    hot = imgui.is_item_hovered() or imgui.is_item_active()
    imgui.get_window_draw_list().add_circle_filled(middle, (5.0 if hot else 3.5) * pixel,
                                                   theme.packed(theme.colours().amber))
    if hot:
        imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
        if not imgui.is_item_active():
            imgui.set_item_tooltip("Plane in focus: drag to focus")
    if not (imgui.is_item_activated() or imgui.is_item_active()):
        return settings
    # The distance of the mouse from the camera, along the axis
    mouse = imgui.get_mouse_pos()
    y = plot.y0 + (plot.bottom - mouse.y) / (plot.bottom - plot.top) * (plot.y1 - plot.y0)
    away = np.array([plot.x_at(mouse.x), y]) - shown.place
    along = 1000.0 * float(away @ shown.ahead) / length**2
    if imgui.is_item_activated():
        state.grip = settings.focus_distance - along
        return settings
    delta = imgui.get_io().mouse_delta
    if delta.x == 0.0 and delta.y == 0.0:
        return settings
    got = readings(settings)
    nearest = (got.nearest_focus or 1.01 * abs(got.efl or 10.0)) * (1.0 + 1e-6)
    return replace(settings, focus_distance=max(along + state.grip, nearest))


def _tooltip(plot: PlotMap, shown: Plan) -> None:
    """A tooltip: the point under the cursor, and its distance from the camera."""
    if imgui.is_mouse_down(imgui.MouseButton_.left):
        return
    mouse = imgui.get_mouse_pos()
    point = np.array([plot.x_at(mouse.x),
                      plot.y0 + (plot.bottom - mouse.y) / max(plot.bottom - plot.top, 1e-6) * (plot.y1 - plot.y0)])
    length = float(np.hypot(*shown.ahead))
    if imgui.begin_tooltip():
        imgui.text_unformatted(true_minus(f"x {fixed(point[0], 2)} m, z {fixed(-point[1], 2)} m"))
        if length > 0.05:
            along = float((point - shown.place) @ shown.ahead) / length
            imgui.text_disabled(f"{fixed(along, 2)} m ahead of the camera, "
                                f"{fixed(math.hypot(*(point - shown.place)), 2)} m away"
                                .replace("-", "−"))
        imgui.end_tooltip()
