"""The pupil of a light field as a pad: drag an aperture in it, or choose one of its cells.

Seen as the camera looks: u runs to the right and v up, in radii of the paraxial exit pupil.

The light field of an array of pinholes in the panel *Light field*: a viewpoint to drag sideways and forwards.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.light_field_query import (
    ELSEWHERE, SURFACES, ArrayRecording, Look, Recording, radius, with_view
)
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.dial import dial
from lensbench.app.settings import dial_scales, dial_scales as scales, text_values
from lensbench.app.workers.light_field_worker import FieldPicture
from lensbench.core.text import fixed, significant, true_minus

SIDE = 8.6                      # em
REST = 0.06                     # of the pupil's radius: this close to the middle the aperture snaps to it


class Pad(NamedTuple):
    """Screen position and scale of the pupil."""

    centre: ImVec2
    unit: float                 # pixels for a radius of the pupil
    reach: float

    def at(self, u: float, v: float) -> ImVec2:
        """Screen position of a point of the pupil."""
        return ImVec2(self.centre.x + u * self.unit, self.centre.y - v * self.unit)

    def under(self, mouse: ImVec2) -> tuple[float, float]:
        """Point of the pupil under the mouse."""
        return (mouse.x - self.centre.x) / self.unit, (self.centre.y - mouse.y) / self.unit


def pupil_pad(look: Look, recording: Recording) -> Look:
    """The aperture as a circle in the pupil; returns the look with its dragged middle."""
    field, draw = recording.field, imgui.get_window_draw_list()
    pad = _pad("Pupil pad", field)
    tip = ("Drag: the viewpoint, which is the middle of the aperture; a wide aperture is stopped down.\n"
           "Double click: back to the middle. Greys: the light that each cell passes to the clicked pixel")
    if imgui.is_item_hovered() and imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        look = replace(look, view=(0.0, 0.0))
    elif imgui.is_item_active() and imgui.is_mouse_down(imgui.MouseButton_.left):
        u, v = pad.under(imgui.get_mouse_pos())
        drag = imgui.get_mouse_drag_delta(imgui.MouseButton_.left, 0.0)
        if abs(drag.x) + abs(drag.y) > 0.0:
            look = with_view(look, (0.0, 0.0) if u * u + v * v < REST * REST else (u, v), field)
    elif imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(tip)
    _cells(draw, pad, coverage_greys(recording, look.pixel))
    pixel = theme.scale()
    around = max(radius(look, field), 0.02) * pad.unit
    middle = pad.at(*look.view)
    draw.add_circle_filled(middle, around, theme.packed(theme.colours().strong, 0.16), 64)
    draw.add_circle(middle, around, theme.packed(theme.colours().strong), 64, 1.5 * pixel)
    draw.add_circle_filled(middle, 2.0 * pixel, theme.packed(theme.colours().strong))
    imgui.same_line()
    return look


def pupil_grid(look: Look, recording: Recording, colours: NDArray[np.floating]) -> Look:
    """The cells of the pupil in colours (down, across, 3) of the screen; returns the look with the clicked cell."""
    field, draw = recording.field, imgui.get_window_draw_list()
    pad = _pad("Pupil grid", field)
    across, down = field.views
    if imgui.is_item_active():
        u, v = pad.under(imgui.get_mouse_pos())
        i, j = (min(max(int((x / pad.reach + 1.0) / 2.0 * n), 0), n - 1) for x, n in ((u, across), (v, down)))
        look = replace(look, cell=(i, j))
    elif imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Click or drag to choose a cell")
    _cells(draw, pad, colours)
    u, v = field.places[look.cell[1], look.cell[0]]
    half = (pad.reach / across * pad.unit, pad.reach / down * pad.unit)
    middle = pad.at(u, v)
    draw.add_rect(ImVec2(middle.x - half[0], middle.y - half[1]), ImVec2(middle.x + half[0], middle.y + half[1]),
                  theme.packed(theme.colours().strong), 0.0, 1.5 * theme.scale())
    imgui.same_line()
    return look


def pupil_picture(colours: NDArray[np.floating]) -> None:
    """The pixels behind a microlens, (down, across, 3) codes of the screen, the lowest first."""
    side = min(round(theme.em(SIDE)), max(imgui.get_content_region_avail().x, 20.0))
    corner = imgui.get_cursor_screen_pos()
    imgui.dummy(ImVec2(side, side))
    _cells(imgui.get_window_draw_list(), Pad(ImVec2(corner.x + 0.5 * side, corner.y + 0.5 * side), 0.5 * side, 1.0),
           colours, False)
    imgui.same_line()


def coverage_greys(recording: Recording, pixel: tuple[int, int]) -> NDArray[np.floating]:
    """(down, across, 3) greys: how much light each cell passes to a pixel of the views."""
    x, y = pixel
    shares = recording.field.coverage[:, :, y, x].astype(np.float64)
    strength = 0.06 + 0.34 * shares[..., None] / max(float(shares.max()), 1e-9)
    colour = theme.colours()
    return np.array(colour.panel[:3]) * (1.0 - strength) + np.array(colour.text[:3]) * strength


def figures(rows: tuple[tuple[str, str, str], ...]) -> None:
    """Names, values and meanings, in small text to the right of a pad."""
    theme.small()
    imgui.begin_group()
    for name, value, meaning in rows:
        imgui.text_disabled(name)
        imgui.set_item_tooltip(meaning)
        imgui.same_line(theme.em(3.4))
        imgui.text_unformatted(value)
        imgui.set_item_tooltip(meaning)
    imgui.end_group()
    imgui.pop_font()


def millimetres(point: tuple[float, float]) -> str:
    """A point of a plane as text: +4.10, −0.52 mm."""
    return true_minus(f"{fixed(point[0], 2, signed=True)}, {fixed(point[1], 2, signed=True)} mm")


def _pad(label: str, field: lb.LightField) -> Pad:
    """The square with the pupil's circle, as one item; the reach of its cells just fits."""
    side = min(round(theme.em(SIDE)), max(imgui.get_content_region_avail().x, 20.0))
    corner = imgui.get_cursor_screen_pos()
    imgui.invisible_button(label, ImVec2(side, side))
    unit = 0.49 * side / max(field.reach, 1.0)
    return Pad(ImVec2(corner.x + 0.5 * side, corner.y + 0.5 * side), unit, field.reach)


def _cells(draw: imgui.ImDrawList, pad: Pad, colours: NDArray[np.floating], circle: bool = True) -> None:
    """The cells in their colours, and the paraxial pupil's circle."""
    pixel = theme.scale()
    down, across = colours.shape[:2]
    cell_colours = colours.tolist()
    edge = [[round(pad.at(x, 0.0).x) for x in np.linspace(-pad.reach, pad.reach, across + 1).tolist()],
            [round(pad.at(0.0, y).y) for y in np.linspace(-pad.reach, pad.reach, down + 1).tolist()]]
    for j in range(down):
        for i in range(across):
            draw.add_rect_filled(ImVec2(edge[0][i], edge[1][j + 1]), ImVec2(edge[0][i + 1] - pixel, edge[1][j] - pixel),
                                 theme.packed((*cell_colours[j][i], 1.0)))
    if circle:
        draw.add_circle(pad.centre, pad.unit, theme.packed(theme.colours().dim), 64, pixel)


SHOWN_TIPS = {"camera": "The picture is the camera's",
              "novel": "The picture is that of a pinhole at the place below, computed from the array"}
SURFACE_TIPS = {"recorded": "Objects are at their recorded distances",
                "plane": "All objects are assumed to lie on one plane: those on it are sharp, others appear double"}
ROOM = 1.5                      # of the array's half side: the range of the viewpoint from its middle
AHEAD = 500.0                   # mm, forwards and back


def array_body(look: Look, recording: ArrayRecording, field_picture: FieldPicture | None) -> Look:
    """Draw the pad and the dials; returns the look after the user's changes."""
    before = look
    look = replace(look, show=toggles("Show", ELSEWHERE, look.show, SHOWN_TIPS, 0.0))
    look = _camera_array_pad(look, recording)
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

    return scales.Scale(-AHEAD, AHEAD, scales.Warp(_root, _cube), format_offset, text_values.read_length, figures_,
                        minor, reset=0.0, anchor=3)


def _root(mm: float) -> float:
    return math.copysign(abs(mm) ** (1.0 / 3.0), mm)


def _cube(u: float) -> float:
    return u**3


def _camera_array_pad(look: Look, recording: ArrayRecording) -> Look:
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
        mouse, drag = imgui.get_mouse_pos(), imgui.get_mouse_drag_delta(imgui.MouseButton_.left, 0.0)
        if abs(drag.x) + abs(drag.y) > 0.0:
            x, y = ((min(max(offset / unit, -reach), reach)) for offset in (mouse.x - middle.x, middle.y - mouse.y))
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
