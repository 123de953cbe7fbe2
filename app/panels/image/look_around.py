"""The panorama from inside: drag to look around, wheel for the angle of view, double click to look ahead."""

import math

from imgui_bundle import ImVec2, imgui

from lensbench.app.display.frame import Picture, View
from lensbench.app.panels.image.overlays import draw_note
from lensbench.app.state.picture.look_around import LookAround
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.kernels.figures import fixed


def look_around(settings: Settings, picture: Picture, view: View, corner: ImVec2, room: ImVec2) -> None:
    """Draw the view into the room of the panel, and turn it by the mouse on the item just submitted."""
    assert view.look is not None
    draw, io, size = imgui.get_window_draw_list(), imgui.get_io(), (room.x, room.y)
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    draw.add_image(imgui.ImTextureRef(picture.around), corner, end)
    view.covered = (corner.x, corner.y, end.x, end.y)
    look = view.look
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        look = look.dragged(io.mouse_delta.x, io.mouse_delta.y, size)
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        look = look.zoomed(io.mouse_wheel)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            look = LookAround()
        mouse = imgui.get_mouse_pos()
        at = (mouse.x - corner.x) / max(room.x, 1.0), (mouse.y - corner.y) / max(room.y, 1.0)
        view.links.hover = view.pointed = view.look.raster(at, size, settings.film, settings.layout)
    view.look = look
    theme.small()
    draw_note(draw, ImVec2(corner.x + 14.0 * theme.scale(),
                           end.y - 12.0 * theme.scale() - imgui.get_text_line_height()),
              f"{_compass(look.yaw)} · {_height(look.pitch)} · {fixed(math.degrees(look.fov), 0)}° wide")
    imgui.pop_font()


def _compass(yaw: float) -> str:
    degrees = round(math.degrees(yaw))
    return "ahead" if not degrees else f"{abs(degrees)}° to the {'left' if degrees > 0 else 'right'}"


def _height(pitch: float) -> str:
    degrees = round(math.degrees(pitch))
    return "level" if not degrees else f"{abs(degrees)}° {'up' if degrees > 0 else 'down'}"
