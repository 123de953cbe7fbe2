"""The light field of an array of pinholes in the panel *Light field*: a viewpoint to drag beside and before it."""

import math
from dataclasses import replace
from functools import lru_cache

from imgui_bundle import ImVec2, imgui

from lensbench.app.panels.light_field.pupil_pad import SIDE, figures
from lensbench.app.state import dial_scales, scales, text_values
from lensbench.app.state.light_field_query import ELSEWHERE, SURFACES, ArrayRecording, Look
from lensbench.app.widgets import theme
from lensbench.app.widgets.dial import dial
from lensbench.app.widgets.paragraph import paragraph
from lensbench.app.widgets.toggles import toggles
from lensbench.app.workers.light_field_worker import FieldPicture
from lensbench.kernels.figures import fixed, significant, true_minus

SHOWN_TIPS = {"camera": "The picture is the camera's",
              "novel": "The picture is that of a pinhole at the place below, computed from the array"}
SURFACE_TIPS = {"recorded": "Objects are at their recorded distances",
                "plane": "All objects are assumed to lie on one plane: those on it are sharp, others appear double"}
ROOM = 1.5                      # of the array's half side: the range of the viewpoint beside its middle
AHEAD = 500.0                   # mm, forwards and back


def array_body(look: Look, recording: ArrayRecording, field_picture: FieldPicture | None) -> Look:
    """Draw the pad and the dials; returns the look after the user's changes."""
    before = look
    look = replace(look, show=toggles("Show", ELSEWHERE, look.show, SHOWN_TIPS, 0.0))
    look = _pad(look, recording)
    x, y, forwards = look.place
    covered = field_picture.covered if field_picture is not None and field_picture.look == look.asked else None
    figures((
        ("Right", true_minus(f"{fixed(x, 1, signed=True)} mm"), "From the middle of the array to the right"),
        ("Up", true_minus(f"{fixed(y, 1, signed=True)} mm"), "From the middle of the array upwards"),
        ("Seen", "–" if covered is None else f"{fixed(100.0 * covered, 1)} %",
         "Part of the pixels that some pinholes recorded; the others are black"),
        ("Time", "–" if field_picture is None else f"{fixed(1000.0 * field_picture.seconds, 0)} ms",
         "To compute the picture")))
    forwards = dial("Forwards", forwards, _forwards(), "From the plane of the pinholes towards the scene, in mm")
    look = replace(look, place=(x, y, forwards),
                   surface=toggles("Objects", SURFACES, look.surface, SURFACE_TIPS, 4.8))
    if look.surface == "plane":
        look = replace(look, distance=dial("Plane", look.distance,
                                           dial_scales.focus_scale(100.0, recording.array.distance),
                                           "Distance from the pinholes to the plane of all objects"))
    if covered is not None and covered < 0.9995:
        half = recording.half
        paragraph("The view leaves what was recorded: the pinholes reach "
                  f"{significant(half[0], 3)} mm across and {significant(half[1], 3)} mm up", True)
    if look != before and look.show == before.show == "camera":
        look = replace(look, show="novel")
    return look


@lru_cache(maxsize=1)
def _forwards() -> scales.Scale:
    """The cube root of mm along the dial, fine about the array's plane."""
    figures_ = tuple((float(mm), true_minus(f"{mm}")) for mm in (-500, -200, -50, 0, 50, 200, 500))
    minor = tuple(float(sign * mm) for sign in (-1, 1) for mm in (5, 10, 20, 100, 300, 400))

    def format_offset(mm: float) -> str:
        return true_minus(f"{fixed(mm, 0, signed=True)} mm")

    return scales.Scale(-AHEAD, AHEAD, _root, _cube, format_offset, text_values.read_length, figures_, minor,
                       reset=0.0, anchor=3)


def _root(mm: float) -> float:
    return math.copysign(abs(mm) ** (1.0 / 3.0), mm)


def _cube(u: float) -> float:
    return u**3


def _pad(look: Look, recording: ArrayRecording) -> Look:
    """The pinholes as dots with the viewpoint; returns the look with the dragged viewpoint."""
    side = min(round(theme.em(SIDE)), max(imgui.get_content_region_avail().x, 20.0))
    corner, draw, pixel = imgui.get_cursor_screen_pos(), imgui.get_window_draw_list(), theme.scale()
    imgui.invisible_button("Array pad", ImVec2(side, side))
    reach = ROOM * max(*recording.half, recording.array.spacing)
    middle, unit = ImVec2(corner.x + 0.5 * side, corner.y + 0.5 * side), 0.5 * side / reach
    x, y, forwards = look.place
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        x, y = 0.0, 0.0
    elif imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.left):
        mouse, held = imgui.get_mouse_pos(), imgui.get_mouse_drag_delta(imgui.MouseButton_.left, 0.0)
        if abs(held.x) + abs(held.y) > 0.0:
            x, y = ((min(max(at / unit, -reach), reach)) for at in (mouse.x - middle.x, middle.y - mouse.y))
    elif imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Drag: the viewpoint among the pinholes. Double click: back to the middle")
    colour = theme.colours()
    draw.add_rect_filled(corner, ImVec2(corner.x + side, corner.y + side), theme.packed(colour.well), 3.0 * pixel)
    for u, v in recording.array.places.reshape(-1, 2).tolist():
        draw.add_circle_filled(ImVec2(middle.x + u * unit, middle.y - v * unit), 1.5 * pixel, theme.packed(colour.dim))
    draw.add_circle(ImVec2(middle.x + x * unit, middle.y - y * unit), 5.0 * pixel, theme.packed(colour.strong), 24,
                    1.5 * pixel)
    imgui.same_line()
    return replace(look, place=(x, y, forwards))
