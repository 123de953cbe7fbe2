"""The plan: the scene from above with the camera, its field of view, the plane in focus and the band of focus.

The line of the plane in focus is dragged along the camera's axis. Axes in metres, equal in both directions.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_axes import PlotMap
from lensbench.app.drawing.plot_painter import Drawn, draw_plot, drawn_map
from lensbench.app.plots.pixel_rays import Pointed, beam
from lensbench.app.plots.plan import Plan, Thing, above, extent, plan, things
from lensbench.app.plots.plot import DASHED, Axis, Curve, Label, Patch, Plot, Points
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import fixed, true_minus

NAME = "Plan"
FARTHEST = 1e6                  # mm: the plane in focus is not drawn beyond it
UPRIGHT = 0.05                  # of the camera's direction seen from above: it looks straight up or down


@dataclass
class PlanState:
    """State of the panel between frames."""

    drawn: Drawn = field(default_factory=Drawn)
    of: tuple = ()              # scene and camera whose limits are kept
    limits: tuple[float, float, float, float] = (0.0, 1.0, 0.0, 1.0)    # m: x, then y
    grip: float = 0.0           # mm from the mouse to the plane in focus while its line is dragged
    pixel_rays: int = 0         # rays of the pointed pixel that are drawn


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
    of = settings.scene, settings.camera
    fits = f"{NAME} 0 0" not in state.drawn.fitted          # after a double click
    if state.of != of or fits:
        state.of, state.limits = of, extent(shown, around, depth)
    corner = imgui.get_cursor_screen_pos()
    theme.small()
    over = () if links is None else _pointed(settings, state, links, depth)
    draw_plot(NAME, plan_plot(shown, around, state.limits), size, state.drawn, over=over)
    imgui.pop_font()
    drawn = drawn_map(NAME, state.drawn)
    if drawn is not None and drawn.bottom > drawn.top:
        settings = _dragged(settings, shown, drawn, state)
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    return settings


@lru_cache(maxsize=4)
def plan_plot(shown: Plan, around: tuple[Thing, ...], limits: tuple[float, float, float, float]) -> Plot:
    """Depth of field, objects, field of view, plane in focus, and the camera with its keyframes."""
    layers: list = []
    if shown.band is not None:
        layers.append(Patch(shown.band, "amber"))
    for thing in around:
        if not thing.shines:
            layers.append(Patch(thing.outline, "text", 0.10))
        layers.append(Curve.through("", np.concatenate([thing.outline, thing.outline[:1]]),
                                    "faint" if thing.shines else "dim", weight=1.0))
    layers += [Curve.through("", edge, "text", weight=1.2) for edge in (() if shown.view is None else shown.view)]
    if shown.focus is not None and shown.distance < FARTHEST:
        layers.append(Curve.through("", shown.focus, "amber", weight=2.0))
        right = shown.focus[int(np.argmax(shown.focus[:, 0]))]
        layers.append(Label(float(right[0]), float(right[1]), format_distance(shown.distance), "amber", free=True))
    if shown.ends is not None:
        ends = np.array(shown.ends)
        layers += [Curve.through("", ends, "dim", DASHED, 1.0),
                   Points("", ends[:, 0], ends[:, 1], "dim", "ring", size=3.5)]
    layers.append(_camera(shown))
    x0, x1, y0, y1 = limits
    return Plot(Axis("To the right (m)", x0, x1), Axis("Ahead (m)", y0, y1), tuple(layers), equal=True,
                words=partial(_words, shown))


def _camera(shown: Plan) -> Points:
    """A wedge that points where the camera looks; a ring for one that looks everywhere, or straight down."""
    x, y = shown.place[:1], shown.place[1:]
    if shown.view is None or float(np.hypot(*shown.ahead)) < UPRIGHT:
        return Points("", x, y, shape="ring", size=5.0)
    return Points("", x, y, shape="triangle", size=6.5, turn=math.atan2(*shown.ahead))


def _pointed(settings: Settings, state: PlanState, links: Pointed, depth: float) -> tuple:
    """The rays of the pointed pixel up to what they meet, and where the ray of a plot ends.

    depth: how far (mm) rays to the sky are drawn.
    """
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    layers: list = []
    state.pixel_rays = 0
    if raster is not None:
        try:
            rays = beam(settings, raster)
        except (ValueError, OSError):           # the panel “Pixel” says why
            return ()
        ways = np.minimum(rays.ends, 2.0 * depth)[:, None] * rays.directions
        layers += [Curve.through("", above(np.stack([origin, origin + way])), "text", weight=1.0)
                   for origin, way in zip(rays.origins, ways, strict=True)]
        state.pixel_rays = len(layers)
        if rays.target is not None:
            layers.append(_point(rays.target, "strong", "circle", 3.5))
    if links.ray is not None and links.ray.target is not None:
        layers.append(_point(links.ray.target, "chart1", "ring", 5.0))
    return tuple(layers)


def _point(point: np.ndarray, tint: str, shape: str, size: float) -> Points:
    """A mark at a point of the world (mm)."""
    x, y = above(point)
    return Points("", np.array([x]), np.array([y]), tint, shape, size=size)


def _dragged(settings: Settings, shown: Plan, plot: PlotMap, state: PlanState) -> Settings:
    """A handle on the middle of the line in focus, to be dragged along the camera's axis."""
    length = float(np.hypot(*shown.ahead))
    if shown.focus is None or shown.distance >= FARTHEST or length < UPRIGHT:
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
    away = np.array([plot.x_at(mouse.x), plot.y_at(mouse.y)]) - shown.place
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


def _words(shown: Plan, x: float, y: float) -> str:
    """The point at a place, and its distance from the camera."""
    line, length = f"x {fixed(x, 2)} m, z {fixed(-y, 2)} m", float(np.hypot(*shown.ahead))
    if length > UPRIGHT:
        away = np.array([x, y]) - shown.place
        line += f"\n{fixed(float(away @ shown.ahead) / length, 2)} m ahead of the camera, " \
                f"{fixed(math.hypot(*away), 2)} m away"
    return true_minus(line)
