"""What lies over the section: the handles that edit the lens, the switches in its corners, another lens under it.

A press on a vertex, a rim, a surface, a gap or an element drags it, with its value next to it. Ctrl bends an element
at constant power; Shift moves at a tenth of the speed. A press also chooses the surface or the element whose handles
of decentre and tilt are shown above it.

The lens A of a comparison is drawn to the same scale with its film in the same position. The lens before its edits has
its first vertex in the same position, so that the two differ only by what an edit has changed.
"""

from dataclasses import dataclass, replace
from math import floor
from typing import NamedTuple

from imgui_bundle import ImVec2, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import warning
from lensbench.app.panels.lens_section.draw import OPEN, Box, Canvas, ray_paths
from lensbench.app.plots.section import Sketch, elements, sketch, surface_curves
from lensbench.app.session.edited_lens import document_of, reverted, with_document
from lensbench.app.session.lens_handles import Handle, HandleKind, body_of, dragged, handle_at, label, pose_handles
from lensbench.app.settings.settings import Settings
from lensbench.lenses.editing.document import EditError, LensDocument

REACH = 6.0                     # pixels from the mouse to a handle
FINE = 0.1
POSED = {HandleKind.DECENTRE: fa.ICON_FA_ARROWS_UP_DOWN, HandleKind.TILT: fa.ICON_FA_ROTATE}


@dataclass
class HandleState:
    """State of editing in the section. active: whether the switch is on. selected: rows of the table of surfaces."""

    active: bool = False
    handle: Handle | None = None        # under the mouse, or dragged
    start: LensDocument | None = None   # before the drag; None while nothing is dragged
    dz: float = 0.0                     # of the drag (mm)
    dy: float = 0.0
    mouse: tuple[float, float] = (0.0, 0.0)
    problem: str = ""
    begun: bool = False                 # a drag begins in this frame
    selected: tuple[int, int] | None = None
    body: tuple[int, int] | None = None     # of the surfaces whose handles of decentre and tilt are shown

    @property
    def dragging(self) -> bool:
        """Whether a handle is held."""
        return self.start is not None


def edit_by_handles(settings: Settings, shown: Sketch, canvas: Canvas, state: HandleState, hovered: bool,
                    pressed: bool) -> Settings:
    """The settings after this frame's mouse on the canvas.

    hovered: the mouse is on the canvas, and on no other handle. pressed: the canvas is held by the left button.
    """
    state.begun = False
    if not state.active or shown.lens is None or shown.ideal:
        state.handle = state.start = state.body = None
        return settings
    mouse, io = imgui.get_mouse_pos(), imgui.get_io()
    if not pressed:
        state.start, state.problem = None, ""
        state.handle = _under_mouse(shown, canvas, state, io.key_ctrl) if hovered else None
        return settings
    if imgui.is_mouse_clicked(imgui.MouseButton_.left):
        state.body = None if state.handle is None else body_of(shown.lens, state.handle)
    if state.handle is None:
        return settings
    if state.start is None:
        if not imgui.is_mouse_clicked(imgui.MouseButton_.left):
            return settings
        try:
            state.start = document_of(settings)
        except (ValueError, OSError):
            return settings
        state.dz, state.dy, state.begun = 0.0, 0.0, True
        state.mouse = mouse.x, mouse.y
        return settings
    if (mouse.x, mouse.y) == state.mouse:
        return settings
    gain = (FINE if io.key_shift else 1.0) / canvas.view.scale
    state.dz += (mouse.x - state.mouse[0]) * gain
    state.dy -= (mouse.y - state.mouse[1]) * gain
    state.mouse = mouse.x, mouse.y
    try:
        changed = with_document(settings, dragged(state.start, state.handle, state.dz, state.dy))
    except EditError as error:
        state.problem = str(error)
        return settings
    state.problem = ""
    return changed


def _under_mouse(shown: Sketch, canvas: Canvas, state: HandleState, bend: bool) -> Handle | None:
    """The handle under the mouse; those of decentre and tilt come first."""
    assert shown.lens is not None
    reach = REACH * theme.scale() / canvas.view.scale
    z, y = canvas.view.to_lens(canvas.corner, imgui.get_mouse_pos())
    for handle in _pose_handles(shown, canvas, state):
        if max(abs(z - handle.z), abs(y - handle.y)) <= 1.3 * reach:
            return handle
    return handle_at(shown.lens, z, y, reach, state.selected, bend, shown.above)


def _pose_handles(shown: Sketch, canvas: Canvas, state: HandleState) -> tuple[Handle, ...]:
    """Those of the chosen body, below the switches over the drawing; none without a body."""
    if shown.lens is None or state.body is None or state.body[1] >= len(shown.lens.surfaces):
        return ()
    highest = canvas.view.to_lens(canvas.corner, ImVec2(canvas.x, canvas.y + theme.em(2.4)))[1]
    return pose_handles(shown.lens, state.body, REACH * theme.scale() / canvas.view.scale, highest, shown.above)


def pose_boxes(shown: Sketch, canvas: Canvas, state: HandleState) -> list[Box]:
    """The boxes of the handles of decentre and tilt (pixels)."""
    half, points = 1.3 * REACH * theme.scale(), (canvas.at(handle.z, handle.y)
                                                 for handle in _pose_handles(shown, canvas, state))
    return [(point.x - half, point.y - half, point.x + half, point.y + half) for point in points]


def draw_body(draw: imgui.ImDrawList, shown: Sketch, canvas: Canvas, state: HandleState) -> None:
    """The chosen body in amber, with its handles of decentre and tilt; one that is dragged follows the mouse."""
    handles = _pose_handles(shown, canvas, state)
    if not handles or shown.lens is None or state.body is None:
        return
    colour, pixel = theme.colours(), theme.scale()
    draw.push_clip_rect(canvas.corner, ImVec2(canvas.x + canvas.width, canvas.y + canvas.height), True)
    for curve in surface_curves(shown.lens)[state.body[0]:state.body[1] + 1]:
        draw.add_polyline(canvas.points(curve), theme.packed(colour.amber), 1.6 * pixel, OPEN)
    if state.dragging and state.handle is not None:
        handles = (state.handle,) if state.handle.kind in POSED else ()
    theme.small()
    for handle in handles:
        lit, point = handle == state.handle, canvas.at(handle.z, handle.y)
        if state.dragging:
            point = (canvas.at(handle.z, handle.y + state.dy) if handle.kind is HandleKind.DECENTRE else
                     canvas.at(handle.z + state.dz, handle.y))
        icon, half = POSED[handle.kind], 1.3 * REACH * pixel
        size = imgui.calc_text_size(icon)
        box = ImVec2(point.x - half, point.y - half), ImVec2(point.x + half, point.y + half)
        draw.add_rect_filled(*box, theme.packed(colour.amber if lit else colour.well), 3.0 * pixel)
        draw.add_rect(*box, theme.packed(colour.amber), 3.0 * pixel)
        draw.add_text(ImVec2(point.x - 0.5 * size.x, point.y - 0.5 * size.y),
                      theme.packed(colour.well if lit else colour.amber_text), icon)
    imgui.pop_font()
    draw.pop_clip_rect()


def draw_handle(draw: imgui.ImDrawList, settings: Settings, canvas: Canvas, state: HandleState) -> None:
    """The handle under the mouse, and its value."""
    handle = state.handle
    if handle is None:
        return
    colour, pixel = theme.colours(), theme.scale()
    point = canvas.at(handle.z, handle.y)
    if state.dragging and handle.kind is not HandleKind.CURVE:
        point = canvas.at(handle.z + (state.dz if handle.kind is not HandleKind.RIM else 0.0),
                          handle.y + (state.dy if handle.kind is HandleKind.RIM else 0.0))
    elif state.dragging:
        point = canvas.at(handle.z + state.dz, handle.y)
    if handle.kind not in (HandleKind.GROUP, HandleKind.BEND, *POSED):
        draw.add_circle_filled(point, 4.0 * pixel, theme.packed(colour.strong if state.dragging else colour.well))
        draw.add_circle(point, 4.0 * pixel, theme.packed(colour.strong), 0, 1.6 * pixel)
    up = handle.kind in (HandleKind.RIM, HandleKind.DECENTRE)
    imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ns if up else imgui.MouseCursor_.resize_ew)
    try:
        what, value = label(document_of(settings), handle)
    except (ValueError, OSError, IndexError):
        return
    if imgui.begin_tooltip():
        imgui.text_unformatted(what)
        imgui.text_disabled(value)
        if state.problem:
            warning(state.problem, 24.0)
        imgui.end_tooltip()


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
    for sign in (1.0, -1.0):                            # next to the film of B, where it is longer
        end = canvas.at(ghosted.film_z, sign * ghosted.film_height)
        draw.add_line(ImVec2(film.x - 3.0 * pixel, end.y), ImVec2(film.x + 3.0 * pixel, end.y), tint, 1.5 * pixel)
        draw.add_line(ImVec2(film.x, film.y), end, tint, pixel)
    front = canvas.at(0.0, ghosted.glass_radius)
    size = imgui.calc_text_size(name)
    point = ImVec2(max(floor(front.x - size.x - 4.0 * pixel), canvas.x + 4.0 * pixel),
                   max(floor(front.y - 0.5 * size.y), canvas.y + 2.0 * size.y))
    draw.add_rect_filled(ImVec2(point.x - 2.0 * pixel, point.y),
                         ImVec2(point.x + size.x + 2.0 * pixel, point.y + size.y),
                         theme.packed(colour.well, 0.8), 2.0 * pixel)
    draw.add_text(point, theme.packed(theme.compared()), name)


SIDE, TOP = "Side view, y–z", "Top view, x–z"


def blocked_ray_switch(corner: ImVec2, width: float, shown: bool) -> tuple[bool, bool]:
    """The switch of blocked rays, in the upper left corner; whether they are shown, and the mouse over it."""
    text = f"{fa.ICON_FA_EYE if shown else fa.ICON_FA_EYE_SLASH}  Blocked rays"
    pad = theme.em(0.4)
    if width < imgui.calc_text_size(text).x + 4.0 * pad:
        return shown, False
    pressed, hovered = _switch("Blocked rays", text, ImVec2(corner.x + 2.0 * pad, corner.y + pad), shown, False,
                               "Show blocked rays up to the surface that stops them")
    return shown != pressed, hovered


def edit_switch(corner: ImVec2, left: float, state: HandleState) -> bool:
    """The switch of editing, `left` pixels right of the corner of the panel; returns whether the mouse is over it."""
    pressed, hovered = _switch("Edit section", f"{fa.ICON_FA_PEN}  Edit", ImVec2(corner.x + left, corner.y
                                                                                + theme.em(0.4)),
                               state.active, True, "Drag vertices, clear apertures, surfaces, gaps and elements\n"
                               "Ctrl bends an element at constant power, Shift is finer\n"
                               "A click shows the handles of tilt and decentre")
    state.active = state.active != pressed
    return hovered


def view_text(above: bool) -> str:
    """What the switch between side and top reads."""
    return f"{fa.ICON_FA_ROTATE}  {TOP if above else SIDE}"


def view_switch(corner: ImVec2, width: float, above: bool) -> tuple[bool, bool]:
    """The switch between side and top, in the upper right corner; whether it is the top, and the mouse over it."""
    text = view_text(above)
    origin = ImVec2(corner.x + width - imgui.calc_text_size(text).x - theme.em(0.8), corner.y + theme.em(0.4))
    pressed, hovered = _switch("Section side", text, origin, above, False,
                               "From above: right of the camera is up\nClick: from the side" if above else
                               "From the side: up in the scene is up\nClick: from above")
    return above != pressed, hovered


def place_of_text(text: str, corner: ImVec2, width: float, has_switches: bool, has_view: bool) -> tuple[ImVec2, ImVec2]:
    """Corner and size of the room for a text over the drawing: next to the switches, or below them."""
    height = 2.0 * imgui.get_text_line_height()
    if not has_switches:
        return corner, ImVec2(width, height)
    left = theme.em(12.0)
    room = width - left - (theme.em(9.0) if has_view else 0.0)
    if imgui.calc_text_size(text).x < room - theme.em(1.5):
        return ImVec2(corner.x + left, corner.y), ImVec2(room, height)
    lines = imgui.calc_text_size(text, False, max(width - theme.em(1.5), 1.0)).y
    return ImVec2(corner.x, corner.y + theme.em(1.6)), ImVec2(width, max(height, lines))


def _switch(name: str, text: str, corner: ImVec2, is_on: bool, framed: bool, hint: str) -> tuple[bool, bool]:
    """A flat switch with its text at a place; whether it was pressed, and whether the mouse is over it."""
    colour, pad, draw = theme.colours(), theme.em(0.4), imgui.get_window_draw_list()
    extent = imgui.calc_text_size(text)
    low = ImVec2(corner.x - pad, corner.y - 0.5 * pad)
    imgui.set_cursor_screen_pos(low)
    pressed = imgui.invisible_button(name, ImVec2(extent.x + 2.0 * pad, extent.y + pad))
    hovered = imgui.is_item_hovered()
    imgui.set_item_tooltip(hint)
    lit = is_on != pressed
    if framed and lit:
        draw.add_rect_filled(low, ImVec2(corner.x + extent.x + pad, corner.y + extent.y + 0.5 * pad),
                             theme.packed(colour.frame_active), imgui.get_style().frame_rounding)
    tint = colour.strong if framed and lit else colour.text if hovered else colour.dim
    draw.add_text(corner, theme.packed(tint, 1.0 if lit or hovered else 0.7), text)
    return pressed, hovered
