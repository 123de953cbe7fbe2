"""Editing in the section: a press on a vertex, a rim, a surface, a gap or an element drags it, with its value beside.

Ctrl bends an element at constant power; Shift moves at a tenth of the speed.
"""

from dataclasses import dataclass

from imgui_bundle import imgui

from lensbench.app.panels.lens_section.draw import Canvas
from lensbench.app.state.geometry.section import Sketch
from lensbench.app.state.lens_edit.editing import document_of, with_document
from lensbench.app.state.lens_edit.handles import Handle, HandleKind, dragged, handle_at, label
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.lenses.editing.document import EditError, LensDocument

REACH = 6.0                     # pixels from the mouse to a handle
FINE = 0.1


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
        state.handle = state.start = None
        return settings
    mouse, io = imgui.get_mouse_pos(), imgui.get_io()
    if not pressed:
        state.start, state.problem = None, ""
        reach = REACH * theme.scale() / canvas.view.scale
        state.handle = handle_at(shown.lens, *canvas.view.to_lens(canvas.corner, mouse), reach, state.selected,
                                 io.key_ctrl) if hovered else None
        return settings
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
    if handle.kind not in (HandleKind.GROUP, HandleKind.BEND):
        draw.add_circle_filled(at, 4.0 * pixel, theme.packed(colour.strong if state.dragging else colour.well))
        draw.add_circle(at, 4.0 * pixel, theme.packed(colour.strong), 0, 1.6 * pixel)
    cursor = imgui.MouseCursor_.resize_ns if handle.kind is HandleKind.RIM else imgui.MouseCursor_.resize_ew
    imgui.set_mouse_cursor(cursor)
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
