"""Editing in the section: a press on a vertex, a rim, a surface, a gap or an element drags it, with its value beside.

Ctrl bends an element at constant power; Shift moves at a tenth of the speed. A press also chooses the surface or the
element whose handles of decentre and tilt are shown above it.
"""

from dataclasses import dataclass

from imgui_bundle import ImVec2, icons_fontawesome_6 as fa, imgui

from lensbench.app.drawing import theme
from lensbench.app.panels.lens_section.draw import OPEN, Canvas
from lensbench.app.plots.section import Sketch, surface_curves
from lensbench.app.session.edited_lens import document_of, with_document
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
        lit, at = handle == state.handle, canvas.at(handle.z, handle.y)
        if state.dragging:
            at = (canvas.at(handle.z, handle.y + state.dy) if handle.kind is HandleKind.DECENTRE else
                  canvas.at(handle.z + state.dz, handle.y))
        icon, half = POSED[handle.kind], 1.3 * REACH * pixel
        size = imgui.calc_text_size(icon)
        draw.add_rect_filled(ImVec2(at.x - half, at.y - half), ImVec2(at.x + half, at.y + half),
                             theme.packed(colour.amber if lit else colour.well), 3.0 * pixel)
        draw.add_rect(ImVec2(at.x - half, at.y - half), ImVec2(at.x + half, at.y + half), theme.packed(colour.amber),
                      3.0 * pixel)
        draw.add_text(ImVec2(at.x - 0.5 * size.x, at.y - 0.5 * size.y),
                      theme.packed(colour.well if lit else colour.amber_text), icon)
    imgui.pop_font()
    draw.pop_clip_rect()


def draw_handle(draw: imgui.ImDrawList, settings: Settings, canvas: Canvas, state: HandleState) -> None:
    """The handle under the mouse, and its value."""
    handle = state.handle
    if handle is None:
        return
    colour, pixel = theme.colours(), theme.scale()
    at = canvas.at(handle.z, handle.y)
    if state.dragging and handle.kind is not HandleKind.CURVE:
        at = canvas.at(handle.z + (state.dz if handle.kind is not HandleKind.RIM else 0.0),
                       handle.y + (state.dy if handle.kind is HandleKind.RIM else 0.0))
    elif state.dragging:
        at = canvas.at(handle.z + state.dz, handle.y)
    if handle.kind not in (HandleKind.GROUP, HandleKind.BEND, *POSED):
        draw.add_circle_filled(at, 4.0 * pixel, theme.packed(colour.strong if state.dragging else colour.well))
        draw.add_circle(at, 4.0 * pixel, theme.packed(colour.strong), 0, 1.6 * pixel)
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
            imgui.push_text_wrap_pos(theme.em(24.0))
            imgui.text_colored(imgui.ImVec4(*colour.warning), state.problem)
            imgui.pop_text_wrap_pos()
        imgui.end_tooltip()
