"""The 3-D view: the lens cut in half, its rays, film and focused surface, and the things of the scene, turned by hand.

Drag turns, right drag or Shift+drag moves, the wheel zooms, a double click fits the lens. The panel composes what is
to be seen, and shows the texture that the display makes of it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench import tone
from lensbench.app.display.solid_view import Drawing, Line, Rgba, Solid
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.recorded import FrameMemo
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.plots.section import Sketch, sketch
from lensbench.app.plots.solid_rays import fan_lines, focused_surface, lost_lines, pixel_lines, pointed_line
from lensbench.app.plots.solids import (
    Eye, Part, Strokes, film_outline, film_part, grid_part, lens_outlines, lens_parts, scene_parts, strokes
)
from lensbench.app.settings.settings import Settings

TURN = math.radians(0.35)       # per pixel of a drag at a scale of 1
ZOOM = 1.15                     # per click of the wheel
VIEWS = {"lens": "Lens", "scene": "Scene", "side": "Side"}
TIPS = {"lens": "The lens, its rays and the film",
        "scene": "The camera and what lies before it, obliquely from above",
        "side": "The scene as seen from the side: the camera at the right, what is far at the left"}
SIDE = Eye(yaw=math.radians(-90.0), pitch=math.radians(4.0))
OPAQUE, FADED = 1.0, 0.3         # opacity, also of the fans shown with a pixel's rays


@dataclass
class View3DState:
    """State of the panel between frames."""

    eye: Eye = field(default_factory=Eye)
    shown: str = "lens"                 # the view that was fitted last
    fitted_to: tuple = ()
    drawn: tuple[int, int] = (0, 0)     # parts and lines
    problem: str = ""                   # what is missing, and why
    memo: FrameMemo = field(default_factory=FrameMemo)      # parts, by what they follow from


def view_3d_panel(settings: Settings, links: Pointed, state: View3DState,
                  draw: Callable[[Drawing, tuple[int, int]], int]) -> None:
    """Draw the view in the rest of the window.

    links: what the mouse points at in all panels; its pixel and its ray are drawn. draw: makes a texture of a drawing
    and of a size in pixels, and returns its GL name.
    """
    size, corner = imgui.get_content_region_avail(), imgui.get_cursor_screen_pos()
    if size.x < 24.0 or size.y < 24.0:
        return
    try:
        shown: Sketch | None = sketch(settings)
    except (ValueError, OSError) as error:
        shown = None
        if settings.has_lens:
            paragraph(str(error))
            return
    imgui.set_next_item_allow_overlap()
    imgui.invisible_button("3-D canvas", size, imgui.ButtonFlags_.mouse_button_left
                           | imgui.ButtonFlags_.mouse_button_right | imgui.ButtonFlags_.mouse_button_middle)
    key = (settings.lens, settings.focal_length, settings.camera, size.x, size.y, state.shown)
    if state.fitted_to != key:
        kept = state.eye if state.fitted_to[-1:] == (state.shown,) else None
        state.eye, state.fitted_to = _fitted(settings, shown, state.shown, size, kept), key
    _handled(state, size)

    drawing = composed(settings, shown, links, state)
    density = max(imgui.get_io().display_framebuffer_scale.x, 1.0)
    texture = draw(drawing, (round(size.x * density), round(size.y * density)))
    window = imgui.get_window_draw_list()
    window.add_image(imgui.ImTextureRef(texture), corner, ImVec2(corner.x + size.x, corner.y + size.y),
                     ImVec2(0.0, 1.0), ImVec2(1.0, 0.0))
    theme.small()
    origin = ImVec2(corner.x + theme.em(0.4), corner.y + theme.em(0.3))
    wide = sum(imgui.calc_text_size(name).x + 2.0 * imgui.get_style().frame_padding.x for name in VIEWS.values())
    window.add_rect_filled(origin, ImVec2(origin.x + wide + 4.0 * theme.scale(), origin.y + imgui.get_frame_height()),
                           theme.packed(theme.colours().well, 0.75), 3.0 * theme.scale())
    imgui.set_cursor_screen_pos(origin)
    chosen = toggles("View", VIEWS, state.shown, TIPS, 0.0)
    if chosen != state.shown:
        state.shown, state.fitted_to = chosen, ()
    imgui.pop_font()
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    if state.problem:
        theme.small()
        window.add_text(ImVec2(corner.x + theme.em(0.6), corner.y + size.y - 1.3 * imgui.get_text_line_height()),
                        theme.packed(theme.colours().dim), state.problem)
        imgui.pop_font()


def _handled(state: View3DState, size: ImVec2) -> None:
    """Turn, move and zoom by the mouse on the item just submitted."""
    io, pixel, button = imgui.get_io(), theme.scale(), imgui.MouseButton_
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        if imgui.is_mouse_down(button.left) and not io.key_shift:
            state.eye = state.eye.turned(io.mouse_delta.x / pixel * TURN, io.mouse_delta.y / pixel * TURN)
        else:
            length = 2.0 * math.tan(math.radians(14.0)) * state.eye.distance / min(size.x, size.y)
            state.eye = state.eye.moved(-io.mouse_delta.x * length, io.mouse_delta.y * length)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel:
            state.eye = state.eye.zoomed(ZOOM**io.mouse_wheel)
        if imgui.is_mouse_double_clicked(button.left):
            state.fitted_to = (*state.fitted_to[:-2], 0.0, state.shown)         # fit, in the same direction
        if not imgui.is_item_active():
            imgui.set_item_tooltip("Drag turns, right drag or Shift+drag moves, the wheel zooms, a double click fits")


def _fitted(settings: Settings, shown: Sketch | None, chosen: str, size: ImVec2, eye: Eye | None) -> Eye:
    """The eye for one of the VIEWS; eye: whose direction is kept, or None for the direction of the view."""
    half = 0.5 * settings.film.diagonal
    front, radius = (-60.0, half) if shown is None else (
        min([-shown.film_z, *(float(ray.path[1][0]) - shown.film_z for fan in shown.fans for ray in fan.rays)]),
        max(half, shown.glass_radius))
    if chosen == "lens":
        start = eye or Eye()
        return start.fitted(np.array([0.0, -radius, front - 0.25 * (radius - front)]),
                            np.array([radius, radius, 0.0]), size.x, size.y)
    reach = settings.focus_distance if settings.focuses and math.isfinite(settings.focus_distance) else 3000.0
    reach = min(max(1.35 * reach, 800.0), 12_000.0)
    start = eye or (SIDE if chosen == "side" else Eye(yaw=math.radians(-40.0), pitch=math.radians(28.0)))
    return start.fitted(np.array([-0.30 * reach, -0.18 * reach, -reach]), np.array([0.30 * reach, 0.30 * reach, 0.0]),
                        size.x, size.y)


# What is to be seen


def composed(settings: Settings, shown: Sketch | None, links: Pointed, state: View3DState) -> Drawing:
    """The parts and lines with their colours in the current theme. shown: the section, None without a lens."""
    colour, memo, pixel = theme.colours(), state.memo, theme.scale()
    memo.begin_frame()
    solids: list[Solid] = []
    lines: list[Line] = []
    problems = []
    things, edges = scene_parts(settings)
    solids += [Solid(solid, _thing(solid), of_world=True) for solid in things]
    lines += [Line(line, (*colour.faint[:3], 0.6 if line.kind == "edge" else 0.28), pixel, of_world=True)
              for line in edges]

    # The camera: film, lens, rays
    film, film_pose = settings.film, settings.film_pose
    plate, outline = memo.of(("film", film, film_pose), lambda: (
        film_part(film, film_pose), strokes("film", [film_outline(film, film_pose)])))
    solids.append(Solid(plate, (*colour.dim[:3], 0.55)))
    lines.append(Line(outline, (*colour.strong[:3], 1.0), 2.0 * pixel))
    if shown is None:
        problems.append("This camera has no lens")
    else:
        for solid in memo.of(("lens", shown), lambda: lens_parts(shown)):
            solids.append(_lens_solid(solid, shown.ideal, links.surfaces))
        if shown.lens is not None:
            lines.append(Line(lens_outlines(shown.lens, shown.film_z), (*colour.glass_outline[:3], 0.9), pixel))
        for line in memo.of(("fans", shown, settings.focus_distance),
                            lambda: fan_lines(shown, settings.focus_distance)):
            tint = getattr(colour, line.kind)
            lines.append(Line(line, (*tint[:3], FADED if links.pixel(film.pixels_x, film.pixels_y) else 0.7), pixel))
    lines += _pointed_lines(settings, shown, links, memo, problems, pixel)

    # What is in focus
    try:
        grid = focused_surface(settings)
        surface = memo.of(("focus", id(grid)), lambda: (grid_part("focus", grid), _rim(grid), grid))
        solids.append(Solid(surface[0], (*colour.amber[:3], 0.30)))
        lines.append(Line(surface[1], (*colour.amber[:3], 0.9), 1.5 * pixel))
        if not len(surface[0].points):
            problems.append("What is in focus lies too far off to be drawn")
    except (ValueError, OSError) as error:
        problems.append(str(error)[:1].upper() + str(error)[1:])
    state.problem, state.drawn = ". ".join(problems), (len(solids), len(lines))
    pose = tuple(settings.present_pose.ravel().tolist())
    return Drawing(state.eye, pose, tuple(solids), tuple(lines), (*colour.well[:3], 1.0))


def _pointed_lines(settings: Settings, shown: Sketch | None, links: Pointed, memo: FrameMemo, problems: list[str],
                   pixel: float) -> list[Line]:
    """The beam of the pointed pixel, and the pointed ray."""
    colour, lines = theme.colours(), []
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is not None:
        try:
            segments = memo.of(("pixel", replace(settings, seed=0), raster), lambda: pixel_lines(settings, raster))
            lines.append(Line(segments, (*colour.strong[:3], 0.9), 1.2 * pixel))
        except (ValueError, OSError) as error:
            problems.append(str(error))
    if links.surfaces and shown is not None:
        segments = memo.of(("lost", shown, links.surfaces), lambda: lost_lines(shown, links.surfaces))
        lines.append(Line(segments, (*colour.warning[:3], 1.0), 1.5 * pixel))
    if links.ray is not None and shown is not None and not shown.ideal:
        ray = links.ray
        segments = memo.of(("ray", ray), lambda: pointed_line(ray, shown.film_z))
        tint = colour.warning if ray.surface >= 0 else theme.pointed()
        lines.append(Line(segments, (*tint[:3], 1.0), 2.5 * pixel))
    return lines


def _lens_solid(shape: Part, ideal: bool, lit: tuple[int, ...]) -> Solid:
    """A part of the lens in its colour; lit: surfaces under the mouse in the section, whose glass is opaque."""
    colour = theme.colours()
    if set(lit) & set(shape.surfaces) and (len(lit) < 2 or shape.surfaces == lit):
        return Solid(shape, (*colour.strong[:3], 0.9 if shape.kind == "cut" else 0.35), 0.5)
    if shape.glass is None:
        return Solid(shape, (*colour.strong[:3], OPAQUE))
    red, green, blue = (min(1.15 * c + 0.05, 1.0) for c in colour.glass(*shape.glass)[:3])
    if shape.kind == "cut":
        return Solid(shape, (red, green, blue, 0.4 if ideal else 0.8))
    return Solid(shape, (red, green, blue, 0.22), 0.3 if ideal else 0.7)


def _thing(shape: Part) -> Rgba:
    """The colour of a thing of the scene, or the white of one that shines."""
    if shape.tint is None or shape.kind == "shining":
        return (1.0, 0.97, 0.88, 0.45) if shape.kind == "shining" else (0.6, 0.6, 0.6, OPAQUE)
    red, green, blue = (float(code) for code in tone.srgb(np.clip(np.array(shape.tint), 0.02, 0.9)))
    return red, green, blue, OPAQUE


def _rim(grid: np.ndarray) -> Strokes:
    """The outline of a grid of points and its middle lines, as far as they are finite."""
    rows, columns = grid.shape[:2]
    paths = [grid[0], grid[-1], grid[:, 0], grid[:, -1], grid[rows // 2], grid[:, columns // 2]]
    pieces = np.concatenate([np.stack([path[:-1], path[1:]], 1) for path in paths])
    return Strokes("focus", pieces[np.isfinite(pieces).all((1, 2))])
