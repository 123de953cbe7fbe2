"""The section: the lens to scale with its rays; its stop and its film can be dragged.

Wheel and drag zoom and pan, a double click fits. Dragging the edge of the stop
changes the f-number, dragging the film the focus; with Shift at a tenth of the
speed.
"""

import math
from dataclasses import dataclass, field, replace

from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench.app.bench.build import bench_of, design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.focus_plane import film_z, focus_at, in_section as in_section_of_film
from lensbench.app.bench.ray_fans import Fan
from lensbench.app.drawing import theme
from lensbench.app.drawing.recorded import FrameMemo
from lensbench.app.panels.lens_section import draw as drawing, links as marks
from lensbench.app.panels.lens_section.draw import Canvas, View, fitted
from lensbench.app.panels.lens_section.handles import (
    Ghost, HandleState, blocked_ray_switch, draw_body, draw_ghost, draw_handle, edit_by_handles, edit_switch, front_of,
    ghost_of, place_of_text, pose_boxes, view_switch, view_text
)
from lensbench.app.panels.lens_section.links import (
    FADED, draw_faults, draw_lit_surfaces, draw_pixel_fan, draw_posed, draw_ray, surfaces_at
)
from lensbench.app.plots.exit_pupil import region
from lensbench.app.plots.pixel_rays import Pointed, in_section, pixel_fan
from lensbench.app.plots.section import Sketch, elements, has_two_sections, sketch
from lensbench.app.session.edited_lens import lens_faults
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number
from lensbench.core.optics.finding import Finding
from lensbench.core.text import fixed, significant, true_minus
from lensbench.lenses.tables.paraxial import index_of, is_d_line

SMALLEST_STOP = 1.0 / 64.0      # of the open stop: six stops down
FINE = 0.1
WIDE = 24.0                     # em: a narrower section has no switch between side and top
NEAR = 4.0                      # pixels from the mouse to a surface that it points at


@dataclass
class SectionState:
    """State of the panel between frames: its view, and the dragged handle."""

    view: View | None = None
    fitted_to: tuple = ()
    film_z: float = 0.0             # of the previous frame
    blocked_rays: bool = True
    dragged: float = 0.0            # stop radius or film z (mm) under the mouse while a handle is dragged
    mouse: float = 0.0
    memo: FrameMemo = field(default_factory=FrameMemo)     # glass, surfaces and rays in pixels
    pixel_rays: int = 0             # rays of the pointed pixel that are drawn
    edit: HandleState = field(default_factory=HandleState)
    above: bool = False             # the section x–z, and not y–z


def lens_section_panel(settings: Settings, state: SectionState, film_radius: float | None = None,
                       links: Pointed | None = None, other: Settings | None = None) -> Settings:
    """Draw the section in the rest of the window; returns the settings, changed by a drag of the stop or the film.

    film_radius: of the film point (mm) whose exit-pupil region is marked on the rear plane. links: what the mouse
    points at in all panels; the surfaces under the mouse are set there. other: the settings A, while they are compared.
    """
    size = imgui.get_content_region_avail()
    if size.x < 24.0 or size.y < 24.0:
        return settings
    corner = imgui.get_cursor_screen_pos()
    draw, colour = imgui.get_window_draw_list(), theme.colours()
    draw.add_rect_filled(corner, ImVec2(corner.x + size.x, corner.y + size.y), theme.packed(colour.well))
    try:
        shown = sketch(settings, state.above)
    except (ValueError, OSError) as error:
        imgui.dummy(size)
        _reason(draw, corner, size, str(error))
        if state.above:                                 # a lens that cannot be turned: back to its side
            state.above, _ = view_switch(corner, size.x, True)
        return settings

    links = links if links is not None else Pointed()
    ghost = ghost_of(other, settings, shown)
    state.memo.begin_frame()
    canvas = _canvas(settings, shown, ghost, corner, size, state)
    stop_handle, film_handle = _handles(shown, canvas)
    imgui.set_next_item_allow_overlap()
    imgui.invisible_button("Section canvas", size, imgui.ButtonFlags_.mouse_button_left
                           | imgui.ButtonFlags_.mouse_button_middle)
    hovered, is_held = imgui.is_item_hovered(), imgui.is_item_active()
    edited = edit_by_handles(settings, shown, canvas, state.edit, hovered, is_held and imgui.is_mouse_down(0))
    canvas = _looked_around(canvas, state)

    # The handles, over the canvas; then the drawing, which shows their effect in the next frame
    changed, stop_lit, film_lit = edited, False, False
    if stop_handle is not None:
        for name, point in (("Stop edge", stop_handle), ("Stop edge, lower", ImVec2(
                stop_handle.x, 2.0 * canvas.at(0.0, 0.0).y - stop_handle.y))):
            half = 7.0 * theme.scale()
            imgui.set_cursor_screen_pos(ImVec2(point.x - half, point.y - half))
            imgui.invisible_button(name, ImVec2(2.0 * half, 2.0 * half))
            changed = _dragged_stop(changed, shown, canvas, 1.0 if point is stop_handle else -1.0, state)
            stop_lit = stop_lit or imgui.is_item_hovered() or imgui.is_item_active()
    if film_handle is not None:
        pad = 3.0 * theme.scale()
        imgui.set_cursor_screen_pos(ImVec2(film_handle[0].x - pad, film_handle[0].y - pad))
        imgui.invisible_button("Film plane", ImVec2(film_handle[1].x + 2.0 * pad, film_handle[1].y + 2.0 * pad))
        changed = _dragged_film(changed, shown, canvas, state)
        film_lit = imgui.is_item_hovered() or imgui.is_item_active()

    draw.push_clip_rect(corner, ImVec2(corner.x + size.x, corner.y + size.y), True)
    theme.small()
    try:
        if ghost is not None:
            draw_ghost(draw, ghost, canvas)
        _draw(draw, settings, shown, canvas, film_radius, stop_lit, film_lit, film_handle is not None, links, state)
        over_switch = _switches(settings, shown, corner, size, state)
    finally:                                    # a kernel may have to be compiled first
        imgui.pop_font()
        draw.pop_clip_rect()
    if hovered and not (film_lit or over_switch) and not imgui.is_mouse_down(imgui.MouseButton_.left):
        lit = (shown.lens.stop_index,) if stop_lit and shown.lens is not None else \
            surfaces_at(shown, canvas, imgui.get_mouse_pos(), NEAR * theme.scale())
        links.point_at_surfaces(lit)
        if not stop_lit and state.edit.handle is None:
            _explain(shown, canvas, lit, state)
    draw_body(draw, shown, canvas, state.edit)
    if not (stop_lit or film_lit or over_switch):
        draw_handle(draw, settings, canvas, state.edit)
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    return changed


def _switches(settings: Settings, shown: Sketch, corner: ImVec2, size: ImVec2, state: SectionState) -> bool:
    """The switches that have room; whether the mouse is over one."""
    over = False
    if not shown.ideal:
        state.blocked_rays, over = blocked_ray_switch(corner, size.x, state.blocked_rays)
        if shown.lens is not None and size.x > theme.em(17.0):
            over = edit_switch(corner, theme.em(8.6), state.edit) or over
    if not _has_view(settings, shown, state):
        state.above = False
    elif size.x > theme.em(WIDE):
        state.above, over_view = view_switch(corner, size.x, state.above)
        over = over or over_view
    return over


def _has_view(settings: Settings, shown: Sketch, state: SectionState) -> bool:
    """Whether the section can be looked at from above as well."""
    return has_two_sections(settings, shown.lens) or shown.lens is not None and state.edit.active


def _draw(draw: imgui.ImDrawList, settings: Settings, shown: Sketch, canvas: Canvas, film_radius: float | None,
          stop_lit: bool, film_lit: bool, movable: bool, links: Pointed, state: SectionState) -> None:
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    fan = _pixel_fan(settings, links, shown.above)
    drawing.draw_axis(draw, canvas)
    drawing.draw_glass(draw, shown, canvas)
    drawing.draw_rays(draw, shown, canvas, state.blocked_rays, 1.0 if fan is None else FADED)
    drawing.draw_outlines(draw, shown, canvas)
    state.pixel_rays = 0 if fan is None else draw_pixel_fan(draw, fan, canvas, state.blocked_rays, shown.ideal)
    draw_faults(draw, shown, canvas, _faults(settings))
    draw_lit_surfaces(draw, shown, canvas, links.surfaces, fan)
    if links.ray is not None and shown.lens is not None and not shown.ideal:
        draw_ray(draw, in_section(settings, raster, links.ray, shown.above), links.ray.surface >= 0, canvas)
    if fan is not None:
        draw.add_circle_filled(canvas.at(shown.film_z, fan.height), 3.0 * theme.scale(),
                               theme.packed(theme.colours().strong))
    elif film_radius is not None and shown.lens is not None and not shown.ideal:
        bounds = _region_bounds(shown.lens, shown.film_z - shown.rear_z, film_radius)
        if bounds is not None:
            drawing.draw_region(draw, shown, canvas, *bounds, film_radius)
    signs = marks.draw_marks(draw, shown, canvas)
    turns = canvas.width > theme.em(WIDE) and _has_view(settings, shown, state)
    switch = imgui.calc_text_size(view_text(shown.above)).x + theme.em(1.6) if turns else 0.0
    corner = canvas.x + canvas.width - switch, canvas.y, canvas.x + canvas.width, canvas.y + theme.em(
        drawing.SWITCHES[1])
    drawing.draw_stop(draw, shown, canvas, signs, [corner, *pose_boxes(shown, canvas, state.edit)])
    drawing.draw_stop_handles(draw, shown, canvas, stop_lit)
    posed = in_section_of_film(settings, shown.above) if shown.lens is not None else None
    drawing.draw_film(draw, shown, canvas, film_lit, movable, posed is None, switch)
    if posed is not None:
        draw_posed(draw, posed, canvas)
    if shown.unmarked:
        extent, pad = imgui.calc_text_size(shown.unmarked), theme.em(0.4)
        above = extent.y + 2.0 * pad if extent.x + theme.em(9.0) > canvas.width else 0.0       # of the scale bar
        corner = ImVec2(canvas.x + 2.0 * pad, canvas.y + canvas.height - extent.y - pad - above)
        draw.add_rect_filled(ImVec2(corner.x - pad, corner.y), ImVec2(corner.x + extent.x + pad, corner.y + extent.y),
                             theme.packed(theme.colours().well, 0.8), 2.0 * theme.scale())
        draw.add_text(corner, theme.packed(theme.colours().dim), shown.unmarked)
    drawing.draw_scale_bar(draw, shown, canvas, signs)
    if shown.reason:
        has_view = _has_view(settings, shown, state)
        room = place_of_text(shown.reason, canvas.corner, canvas.width, not shown.ideal, has_view)
        _reason(draw, *room, shown.reason)


def _faults(settings: Settings) -> tuple[Finding, ...]:
    """What cannot be of an edited lens; nothing where the sketch already says why there is no lens."""
    try:
        return lens_faults(settings)
    except (ValueError, OSError):
        return ()


def _pixel_fan(settings: Settings, links: Pointed, above: bool) -> Fan | None:
    """The rays of the pointed pixel; None without such a pixel, or where they cannot be traced."""
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is None:
        return None
    try:
        return pixel_fan(settings, raster, above)
    except (ValueError, OSError):           # the panel “Pixel” says why
        return None


def _reason(draw: imgui.ImDrawList, corner: ImVec2, size: ImVec2, text: str) -> None:
    """The reason why there is nothing to draw, or why it differs from the settings."""
    wrap, pad = max(size.x - theme.em(1.5), 1.0), theme.em(0.3)
    extent = imgui.calc_text_size(text, False, wrap)
    origin = ImVec2(corner.x + 0.5 * (size.x - extent.x), corner.y + 0.5 * (size.y - extent.y))
    draw.add_rect_filled(ImVec2(origin.x - pad, origin.y), ImVec2(origin.x + extent.x + pad, origin.y + extent.y),
                         theme.packed(theme.colours().well, 0.8), 2.0 * theme.scale())
    draw.add_text(imgui.get_font(), imgui.get_font_size(), origin, theme.packed(theme.colours().dim), text, wrap)


def _canvas(settings: Settings, shown: Sketch, ghost: Ghost | None, corner: ImVec2, size: ImVec2,
            state: SectionState) -> Canvas:
    """The kept view; fitted again if lens, film or panel has changed, or if focusing has moved the film out of view."""
    line = imgui.get_text_line_height()
    key = (settings.lens, settings.focal_length, settings.camera, settings.film_width,
           settings.film_height, size.x, size.y,
           None if ghost is None else (round(ghost.shift, 3), ghost.sketch.film_height, ghost.sketch.glass_radius))
    if state.film_z != shown.film_z and state.view is not None and not imgui.is_mouse_down(0):
        if not 0.0 < state.view.to_screen(ImVec2(0.0, 0.0), shown.film_z, 0.0).x < size.x:
            state.fitted_to = ()
        state.film_z = shown.film_z
    if state.view is None or state.fitted_to != key:
        front = min([0.0, *(float(ray.path[1][0]) for fan in shown.fans for ray in fan.rays)])
        half = max(shown.film_height / settings.crop, 1.1 * shown.glass_radius)
        if ghost is not None:
            front = min(front, front_of(ghost))
            half = max(half, ghost.sketch.film_height, 1.1 * ghost.sketch.glass_radius)
        names = max(imgui.calc_text_size(name).x
                    for name in drawing.field_names(shown, size.x < theme.em(drawing.NARROW)))
        state.view = fitted(size.x, size.y, front, shown.film_z, half, 0.8 * line,
                            names + drawing.BESIDE * theme.scale())
        state.fitted_to = key
    return Canvas(corner.x, corner.y, size.x, size.y, state.view, state.memo)


def _looked_around(canvas: Canvas, state: SectionState) -> Canvas:
    """The canvas after wheel, drag and double click on its item."""
    io, mouse = imgui.get_io(), imgui.get_mouse_pos()
    assert state.view is not None
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel:
            state.view = state.view.zoomed(io.mouse_wheel, mouse.x - canvas.x, mouse.y - canvas.y)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            state.fitted_to = ()
    if imgui.is_item_active() and not state.edit.dragging and (io.mouse_delta.x or io.mouse_delta.y):
        state.view = state.view.moved(io.mouse_delta.x, io.mouse_delta.y)
    return replace(canvas, view=state.view)


def _handles(shown: Sketch, canvas: Canvas) -> tuple[ImVec2 | None, tuple[ImVec2, ImVec2] | None]:
    """Screen positions of the handles of the stop's upper edge and of the film; None if it cannot be dragged."""
    stop = canvas.at(*shown.on_stop(shown.stop_radius, shown.stop_radius)) if shown.stop_radius else None
    if shown.lens is None or not math.isfinite(lb.first_order(shown.lens).efl):
        return stop, None
    return stop, drawing.film_handle(shown, canvas)


def _pull(value: float, along: float, scale: float, state: SectionState) -> float:
    """The dragged value (mm) after the mouse has moved to `along` on an axis (pixels); scale: pixels per mm."""
    if imgui.is_item_activated():
        state.dragged, state.mouse = value, along
    step = (along - state.mouse) / scale * (FINE if imgui.get_io().key_shift else 1.0)
    state.dragged += step
    state.mouse = along
    return state.dragged


def _dragged_stop(settings: Settings, shown: Sketch, canvas: Canvas, side: float, state: SectionState) -> Settings:
    """Settings after a drag of the item just submitted, an edge of the stop. side: 1 upper edge, −1 lower edge."""
    assert shown.stop_radius is not None
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ns)
        _tooltip("Aperture stop: drag to change the f-number", format_f_number(readings(settings).f_number or 0.0))
    if not imgui.is_item_active():
        return settings
    if shown.lens is None or shown.open_radius is None:     # perspective camera: opens to f/0.5
        open_radius, widest = shown.film_z, 0.5
    else:
        open_radius, widest = shown.open_radius, lb.f_number_at_infinity(design(settings))
    before = state.mouse
    now = widest * open_radius / (readings(settings).f_number or widest)    # of a circle of as much area as the blades
    radius = _pull(now, -side * imgui.get_mouse_pos().y, canvas.view.scale, state)
    if imgui.is_item_activated() or state.mouse == before:
        return settings
    radius = min(max(radius, SMALLEST_STOP * open_radius), open_radius)
    return replace(settings, f_number=widest * open_radius / radius)


def _dragged_film(settings: Settings, shown: Sketch, canvas: Canvas, state: SectionState) -> Settings:
    """Settings after a drag of the item just submitted, the film: its position determines the focus distance."""
    assert shown.lens is not None
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        _tooltip("Film plane: drag to focus", f"{format_distance(settings.focus_distance)} in focus, "
                                           f"film {fixed(shown.film_z - shown.rear_z, 2)} mm behind the lens")
    if not imgui.is_item_active():
        return settings
    before = state.mouse
    try:
        built = bench_of(settings)
        now = film_z(built)
        pulled = _pull(now, imgui.get_mouse_pos().x, canvas.view.scale, state)
        if imgui.is_item_activated() or state.mouse == before:
            return settings
    except lb.LensError:
        return settings
    return replace(settings, focus_distance=focus_at(built, pulled - now))


def _tooltip(what: str, value: str) -> None:
    if imgui.begin_tooltip():
        imgui.text_unformatted(what)
        imgui.text_disabled(value)
        imgui.end_tooltip()


def _explain(shown: Sketch, canvas: Canvas, lit: tuple[int, ...], state: SectionState) -> None:
    """A tooltip for the cardinal point, the ray, the surface or the element under the mouse. lit: its surfaces."""
    mouse, pixel = imgui.get_mouse_pos(), theme.scale()
    z, y = canvas.view.to_lens(canvas.corner, mouse)
    for mark in shown.marks:
        point = canvas.at(mark.z, 0.0)
        if abs(point.x - mouse.x) < 4.0 * pixel and abs(point.y - mouse.y) < 7.0 * pixel:
            _tooltip(f"{mark.sign}  {mark.meaning}", f"z = {fixed(mark.z, 2)} mm from the first vertex")
            return
    nearest = marks.nearest_ray(shown, canvas, mouse, 4.0 * pixel, state.blocked_rays)
    if nearest is not None:
        fan, i = nearest
        ray = fan.rays[i]
        name = fan.name[0].upper() + fan.name[1:]
        if ray.kind == "dead":
            _tooltip(f"{name}: this ray {ray.end}", "It never reaches the film")
        else:
            _tooltip(f"{name}, {ray.end}", f"Lands {fixed(ray.path[-1][1], 3)} mm off the axis")
        return
    if len(lit) == 1 and shown.lens is not None:
        _tooltip(*_surface_words(shown, lit[0]))
        return
    if shown.lens is None:
        return
    for number, element in enumerate(elements(shown.lens), start=1):
        if element.holds(z, y):
            glass = shown.glasses[element.front]
            wavelength = shown.lens.reference_wavelength
            line = "the d line" if is_d_line(wavelength) else f"{significant(1000.0 * wavelength)} nm"
            abbe = f", V = {fixed(glass.v_d, 1)}" if glass.v_d is not None else ""
            _tooltip(f"Element {number}  {glass.name}".rstrip(),
                     f"n = {fixed(index_of(glass, wavelength), 4)} at {line}{abbe}")
            return


def _surface_words(shown: Sketch, index: int) -> tuple[str, str]:
    """A surface in two lines: its shape, and how many of the drawn rays it ends."""
    assert shown.lens is not None
    surface = shown.lens.surfaces[index]
    name = "Stop" if index == shown.lens.stop_index else f"Surface {index}"
    radius = f"R {significant(1.0 / surface.curvature, 4)} mm" if surface.curvature else "plane"
    ended = sum(ray.surface == index for fan in shown.fans for ray in fan.rays)
    return (f"{name}: {true_minus(radius)}, semi-diameter {fixed(surface.semi_diameter, 2)} mm",
            f"Ends {ended} of the rays drawn here" if ended else "Blocks none of the rays drawn here")


def _region_bounds(lens: lb.Lens, film_distance: float, film_radius: float) -> tuple[float, float] | None:
    """Lowest and highest y (mm) of the exit-pupil region of a film point; None for a dark point."""
    try:
        pupil = region(lens, film_distance, film_radius)
    except lb.LensError:
        return None
    return (pupil.box[1], pupil.box[3]) if pupil.area > 0.0 else None
