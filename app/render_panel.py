"""The picture with its tools: focus by a click, orbit, pan and dolly by the mouse, what is laid over it.

The panel gets the picture as a texture's name and returns the settings that a
hand has made of it. A raster point (x, y) is in pixels of the picture, (0, 0)
its top left corner.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from imgui_bundle import ImVec2, icons_fontawesome_6, imgui
from numpy.typing import NDArray

from lensbench.app import theme
from lensbench.app.image_circle import dark_corners
from lensbench.app.picture_marks import Mark, draw_histogram, draw_legend, draw_mark, draw_note
from lensbench.app.picture_menu import picture_menu
from lensbench.app.readings import readings
from lensbench.app.settings import Settings
from lensbench.app.viewpoint import dollied, orbited, panned, pivot_distance

fa = icons_fontawesome_6
CLICK = 4.0                     # pixels at a scale of 1: a press that moves farther is a drag
TURN = math.radians(0.25)       # of an orbit, per such pixel
DOLLY = 0.06                    # of the way to the pivot, per click of the wheel
ZOOMS = (0.1, 16.0)
SLOW = 0.5                      # seconds without a picture, before that is said


@dataclass(frozen=True)
class Picture:
    """What there is to be shown in this frame."""

    texture: int = 0                                # GL name, 0: nothing yet
    size: tuple[int, int] = (0, 0)                  # pixels across and down
    samples: int = 0
    seconds: float = 0.0
    paused: bool = False
    waiting: float = 0.0                            # seconds since the settings changed without a picture of them
    first: bool = False                             # the kernels are not known to be compiled yet
    depth: NDArray[np.float32] | None = None        # (h, w) mm from the film along the axis
    histogram: NDArray[np.float64] | None = None    # (4, bins) red, green, blue, luminance


@dataclass
class View:
    """What the panel remembers from frame to frame; no part of the settings."""

    zoom: float | None = None                       # screen pixels for a pixel of the picture; None: all that fits
    centre: tuple[float, float] = (0.5, 0.5)        # the part of the picture in the middle of the panel
    focus_pick: bool = True
    histogram: bool = False
    mark: Mark | None = None
    pending: tuple[float, float] | None = None      # a click that waits for the depth map, parts of the picture
    hover: tuple[float, float] | None = None        # the raster point under the mouse
    scale: float = 1.0                              # screen pixels for a pixel of the picture, as drawn last
    dragged: bool = False
    requests: set[str] = field(default_factory=set)     # asked of the window: pause, restart, screenshot, export
    messages: list[str] = field(default_factory=list)   # what went wrong or was done, until it is dismissed
    done: set[str] = field(default_factory=set)         # those of them that tell of something done

    def say(self, message: str, done: bool = False) -> None:
        """Show a message until it is dismissed; the same one only once. done: nothing went wrong."""
        if message not in self.messages:
            self.messages.append(message)
        (self.done.add if done else self.done.discard)(message)


def render_panel(settings: Settings, picture: Picture, view: View) -> Settings:
    """Draw the tools and the picture into the current window; the settings as the mouse has left them."""
    settings = _tools(settings, picture, view)
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    view.hover = None
    if room.x < theme.em(2.0) or room.y < theme.em(2.0):
        return settings
    settings = _picture(settings, picture, view, corner, room)
    _messages(view, corner, room)
    return settings


# The row of tools


def _tools(settings: Settings, picture: Picture, view: View) -> Settings:
    pixel = theme.scale()
    corner, width = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail().x
    height = round(theme.em(1.9))
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 8.0 * pixel, corner.y + round(0.5 * (height - theme.em(1.45)))))

    # How large
    if _tool(fa.ICON_FA_EXPAND + "  Fit###Fit", "Show the whole picture (F)", view.zoom is None):
        view.zoom, view.centre = None, (0.5, 0.5)
    if _tool("100 %###100 %", "One pixel of the picture for one of the screen (1)\n"
             "Ctrl + wheel zooms, Ctrl + drag moves the picture", view.zoom is not None and abs(view.zoom - 1) < 1e-6):
        view.zoom = 1.0
    _gap()

    # What a click does, and what is laid over the picture
    if _tool(fa.ICON_FA_CROSSHAIRS + "###Focus pick", "Click in the picture to focus there\n\n"
             "Drag to orbit about what is in focus, Shift or right drag to pan, wheel to dolly", view.focus_pick):
        view.focus_pick = not view.focus_pick
    for icon, key, name, tooltip in (
            (fa.ICON_FA_HIGHLIGHTER, "peaking", "Focus peaking", "Focus peaking: edges in focus are amber (P)"),
            (fa.ICON_FA_BULLSEYE, "coc", "CoC overlay",
             "Circle of confusion in pixels as false colour: amber in focus, blue before it, pink behind it (C)"),
            (fa.ICON_FA_CIRCLE_HALF_STROKE, "clipping", "Clipping",
             "Clipping: stripes where the picture is fully white (orange) or black (blue) (Z)")):
        if _tool(f"{icon}###{name}", tooltip, settings.overlay == key):
            settings = replace(settings, overlay="none" if settings.overlay == key else key)
    if _tool(fa.ICON_FA_CHART_AREA + "###Histogram", "Histogram of the developed picture (H)", view.histogram):
        view.histogram = not view.histogram
    _gap()

    # The render
    if _tool((fa.ICON_FA_PLAY if picture.paused else fa.ICON_FA_PAUSE) + "###Pause",
             "Go on rendering (Space)" if picture.paused else "Hold the render (Space)", picture.paused):
        view.requests.add("pause")
    if _tool(fa.ICON_FA_ROTATE_LEFT + "###Restart", "Begin the render anew (R)", False):
        view.requests.add("restart")
    if _tool(fa.ICON_FA_CAMERA + "###Screenshot", "Save the picture as it stands, with its settings (Ctrl + S)", False):
        view.requests.add("screenshot")
    if _tool(fa.ICON_FA_FLOPPY_DISK + "###Export", "Export at any size and number of samples (Ctrl + E)", False):
        view.requests.add("export")
    left = imgui.get_item_rect_max().x + 12.0 * pixel

    # What is shown, from the right as far as there is room; a click opens the menu that sets it
    theme.small()
    samples = f"{picture.samples} of " if picture.texture else ""
    text = f"{settings.pixels_x} × {settings.pixels_y}     {samples}{settings.samples} samples"
    longest = f"{text}     {_seconds(picture.seconds)}" if picture.texture else text
    texts = [longest, text, f"{settings.pixels_x} × {settings.pixels_y}"]
    room = corner.x + width - left - 2.0 * imgui.get_style().frame_padding.x
    text = next((text for text in texts if imgui.calc_text_size(text).x <= room), fa.ICON_FA_ELLIPSIS)
    extent = imgui.calc_text_size(text).x + 2.0 * imgui.get_style().frame_padding.x
    imgui.set_cursor_screen_pos(ImVec2(max(corner.x + width - extent - 5.0 * pixel, left),
                                       corner.y + round(0.5 * (height - imgui.get_frame_height()))))
    pressed = _tool(f"{text}###Picture size", "Pixels, samples a pixel, tone curve", False)
    imgui.pop_font()
    if pressed:
        imgui.open_popup("Picture menu")
    lower = imgui.get_item_rect_max()
    imgui.set_next_window_pos(ImVec2(lower.x, lower.y + 4.0 * pixel), imgui.Cond_.appearing, ImVec2(1.0, 0.0))
    imgui.set_next_window_size(ImVec2(theme.em(24.0), 0.0))
    if imgui.begin_popup("Picture menu"):
        settings = picture_menu(settings)
        imgui.end_popup()
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    imgui.dummy(ImVec2(0.0, 0.0))
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + height))
    return settings


def _seconds(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60.0 else f"{int(seconds) // 60}:{int(seconds) % 60:02d} min"


def _tool(label: str, tooltip: str, on: bool) -> bool:
    """A flat button of the row; `on` as it is switched on."""
    colour = theme.colours()
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(colour.frame if on else (0.0, 0.0, 0.0, 0.0))))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*(colour.strong if on else colour.dim)))
    clicked = imgui.button(label)
    imgui.pop_style_color(2)
    imgui.set_item_tooltip(tooltip)
    imgui.same_line(0.0, 2.0 * theme.scale())
    return clicked


def _gap() -> None:
    imgui.same_line(0.0, 10.0 * theme.scale())


# The picture


def _picture(settings: Settings, picture: Picture, view: View, corner: ImVec2, room: ImVec2) -> Settings:
    pixel = theme.scale()
    draw = imgui.get_window_draw_list()
    imgui.invisible_button("Picture", room, imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
                           | imgui.ButtonFlags_.mouse_button_middle)
    if not picture.texture:
        _progress(picture, corner, room)
        return settings

    # Where it stands
    width, height = picture.size
    margin = 6.0 * pixel
    fit = max(min((room.x - 2.0 * margin) / width, (room.y - 2.0 * margin) / height), 1e-3)
    density = max(imgui.get_io().display_framebuffer_scale.x, 1.0)
    view.scale = fit if view.zoom is None else view.zoom / density
    extent = ImVec2(view.scale * width, view.scale * height)
    x0 = round(corner.x + 0.5 * room.x - view.centre[0] * extent.x)
    y0 = round(corner.y + 0.5 * room.y - view.centre[1] * extent.y)
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    draw.push_clip_rect(corner, end, True)
    upper, lower = ImVec2(x0, y0), ImVec2(x0 + round(extent.x), y0 + round(extent.y))
    draw.add_image(imgui.ImTextureRef(picture.texture), upper, lower)
    view.scale *= density

    # The mouse
    mouse = imgui.get_mouse_pos()
    at = ((mouse.x - x0) / max(extent.x, 1.0), (mouse.y - y0) / max(extent.y, 1.0))
    inside = 0.0 <= at[0] < 1.0 and 0.0 <= at[1] < 1.0
    if imgui.is_item_hovered() and inside:
        view.hover = (at[0] * width, at[1] * height)
    settings = _handled(settings, picture, view, at, inside, extent)
    settings = _focused(settings, picture, view)

    # What is laid over it
    if view.mark is not None and view.mark.holds(settings):
        draw_mark(draw, view.mark, ImVec2(x0 + view.mark.x * extent.x, y0 + view.mark.y * extent.y))
    if view.histogram and picture.histogram is not None:
        draw_histogram(draw, picture.histogram, ImVec2(min(lower.x, end.x), min(lower.y, end.y)))
    if settings.overlay == "coc":
        draw_legend(draw, ImVec2(max(upper.x, corner.x), min(lower.y, end.y)))
    else:
        note = dark_corners(settings)
        if note:
            theme.small()
            draw_note(draw, ImVec2(max(upper.x, corner.x) + 14 * pixel,
                                   min(lower.y, end.y) - 12 * pixel - imgui.get_text_line_height()), note)
            imgui.pop_font()
    draw.pop_clip_rect()
    if picture.waiting > SLOW:
        _progress(picture, corner, room)
    if picture.paused:
        draw_note(draw, ImVec2(max(upper.x, corner.x) + 14 * pixel, max(upper.y, corner.y) + 12 * pixel), "Paused")
    return settings


def _handled(settings: Settings, picture: Picture, view: View, at: tuple[float, float], inside: bool,
             extent: ImVec2) -> Settings:
    """The settings and the view after this frame's mouse on the item just submitted."""
    io, pixel = imgui.get_io(), theme.scale()
    button = imgui.MouseButton_
    if imgui.is_item_activated():
        view.dragged = False

    # Drags
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        held = next((b for b in (button.left, button.right, button.middle) if imgui.is_mouse_down(b)), button.left)
        begun = view.dragged
        view.dragged = begun or imgui.is_mouse_dragging(held, CLICK * pixel)
        moved = imgui.get_mouse_drag_delta(held, 0.0) if view.dragged and not begun else io.mouse_delta
        if view.dragged and io.key_ctrl:
            view.zoom = view.zoom or view.scale
            view.centre = (_unit(view.centre[0] - moved.x / extent.x), _unit(view.centre[1] - moved.y / extent.y))
        elif view.dragged and (held != button.left or io.key_shift):
            length = _length_per_pixel(settings, extent)
            settings = panned(settings, -moved.x * length, moved.y * length)
        elif view.dragged:
            settings = orbited(settings, moved.x / pixel * TURN, moved.y / pixel * TURN)

    # A click: focus
    if imgui.is_item_deactivated() and not view.dragged and inside and view.focus_pick and not io.key_ctrl \
            and imgui.is_mouse_released(button.left):
        view.pending = at

    # The wheel
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel and io.key_ctrl:
            _zoom(view, at, 2.0 ** (0.5 * io.mouse_wheel))
        elif io.mouse_wheel:
            settings = dollied(settings, io.mouse_wheel * DOLLY * pivot_distance(settings))
    return settings


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _zoom(view: View, at: tuple[float, float], factor: float) -> None:
    """Zoom about a point of the picture, which stays where it is."""
    before = view.zoom or view.scale
    view.zoom = min(max(before * factor, ZOOMS[0]), ZOOMS[1])
    part = before / view.zoom
    view.centre = (_unit(at[0] + (view.centre[0] - at[0]) * part), _unit(at[1] + (view.centre[1] - at[1]) * part))


def _length_per_pixel(settings: Settings, extent: ImVec2) -> float:
    """How many mm in the plane of the pivot stand for a pixel of the screen."""
    view = readings(settings).fov_horizontal or 0.7
    return 2.0 * pivot_distance(settings) * math.tan(0.5 * view) / max(extent.x, 1.0)


def _focused(settings: Settings, picture: Picture, view: View) -> Settings:
    """The settings focused at the depth under a click, as soon as the depth is known."""
    if view.pending is None or picture.depth is None:
        return settings
    x, y = view.pending
    view.pending = None
    rows, columns = picture.depth.shape
    depth = float(picture.depth[min(int(y * rows), rows - 1), min(int(x * columns), columns - 1)])
    if math.isnan(depth) or depth <= 0.0:
        return settings
    nearest = readings(settings).nearest_focus or 0.0
    distance = max(depth, nearest * (1.0 + 1e-6))
    view.mark = Mark(x, y, distance, settings.aim)
    return replace(settings, focus_distance=distance)


# What is said over it


def _progress(picture: Picture, corner: ImVec2, room: ImVec2) -> None:
    """Say that a picture is on its way, where it takes longer than a moment."""
    if picture.waiting < (0.15 if picture.first else SLOW):
        return
    pixel, colour, draw = theme.scale(), theme.colours(), imgui.get_window_draw_list()
    text = "Preparing the picture"
    if picture.first and picture.waiting > 2.0:
        text = f"Compiling the render kernels, once for this version · {picture.waiting:.0f} s"
    size = imgui.calc_text_size(text)
    width = max(size.x, theme.em(14.0))
    left, top = round(corner.x + 0.5 * (room.x - width)), round(corner.y + 0.5 * room.y - size.y)
    pad = round(theme.em(0.9))
    draw.add_rect_filled(ImVec2(left - pad, top - pad), ImVec2(left + width + pad, top + size.y + theme.em(0.9) + pad),
                         theme.packed(colour.popup, 0.92), 4.0 * pixel)
    draw.add_text(ImVec2(round(left + 0.5 * (width - size.x)), top), theme.packed(colour.text), text)
    y, thick = top + size.y + round(theme.em(0.55)), round(3.0 * pixel)
    draw.add_rect_filled(ImVec2(left, y), ImVec2(left + width, y + thick), theme.packed(colour.frame), 1.5 * pixel)
    phase = 0.5 - 0.5 * math.cos(2.0 * picture.waiting)
    begin = left + 0.75 * width * phase
    draw.add_rect_filled(ImVec2(begin, y), ImVec2(begin + 0.25 * width, y + thick), theme.packed(colour.text),
                         1.5 * pixel)


def _messages(view: View, corner: ImVec2, room: ImVec2) -> None:
    """What went wrong, over the top of the picture, each until it is dismissed."""
    if not view.messages:
        return
    pixel, colour = theme.scale(), theme.colours()
    imgui.set_cursor_screen_pos(ImVec2(corner.x + 10 * pixel, corner.y + 8 * pixel))
    imgui.push_style_color(imgui.Col_.child_bg, imgui.ImVec4(*colour.popup))
    imgui.push_style_var(imgui.StyleVar_.child_rounding, 4.0 * pixel)
    flags = imgui.ChildFlags_.always_use_window_padding | imgui.ChildFlags_.auto_resize_y
    if imgui.begin_child("Messages", ImVec2(room.x - 20 * pixel, 0.0), flags):
        for i, message in enumerate(list(view.messages)):
            imgui.push_id(i)
            if message in view.done:
                imgui.text_disabled(fa.ICON_FA_CHECK)
            else:
                imgui.text_colored(imgui.ImVec4(*colour.warning), fa.ICON_FA_TRIANGLE_EXCLAMATION)
            imgui.same_line()
            close = theme.em(1.6)
            imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x - close)
            imgui.text_unformatted(message)
            imgui.pop_text_wrap_pos()
            imgui.same_line(imgui.get_window_width() - close - imgui.get_style().window_padding.x)
            imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0, 0, 0, 0))
            if imgui.small_button(fa.ICON_FA_XMARK + "###Dismiss"):
                view.messages.remove(message)
            imgui.pop_style_color()
            imgui.set_item_tooltip("Dismiss")
            imgui.pop_id()
    imgui.end_child()
    imgui.pop_style_var()
    imgui.pop_style_color()
