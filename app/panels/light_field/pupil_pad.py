"""The pupil of a light field as a pad: drag an aperture in it, or choose one of its cells.

Seen as the camera looks: u runs to the right and v up, in radii of the paraxial exit pupil.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.light_field_query import Look, Recording, radius, with_view
from lensbench.app.widgets import theme
from lensbench.kernels.figures import fixed, true_minus

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
        held = imgui.get_mouse_drag_delta(imgui.MouseButton_.left, 0.0)
        if abs(held.x) + abs(held.y) > 0.0:
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
    part = 0.06 + 0.34 * shares[..., None] / max(float(shares.max()), 1e-9)
    colour = theme.colours()
    return np.array(colour.panel[:3]) * (1.0 - part) + np.array(colour.text[:3]) * part


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


def millimetres(place: tuple[float, float]) -> str:
    """A point of a plane as text: +4.10, −0.52 mm."""
    return true_minus(f"{fixed(place[0], 2, signed=True)}, {fixed(place[1], 2, signed=True)} mm")


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
