"""The picture with its tools: focus by a click, orbit, pan and dolly by the mouse, and the overlays.

The panel gets the picture as the name of a texture and returns the settings
after the user's changes. A raster point (x, y) is in pixels of the picture, (0, 0)
its top left corner.
"""

import math
from dataclasses import replace

import numpy as np
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.focus_plane import focused_at
from lensbench.app.bench.pose import dollied, orbited, panned, pivot_distance
from lensbench.app.bench.readouts import dark_corners
from lensbench.app.bench.sharp_points import made_sharp, picked_point
from lensbench.app.bench.tone import aov_note
from lensbench.app.display.frame import Box, Click, Mark, Picture, SharpPicks, View
from lensbench.app.drawing import theme
from lensbench.app.panels.image.camera_strip import camera_strip
from lensbench.app.panels.image.compare import draw_pinned, draw_plate, draw_scale, wiped
from lensbench.app.panels.image.notices import draw_notices, draw_trials, look_around
from lensbench.app.panels.image.overlays import (
    STEPS, above_plates, draw_cross, draw_fates, draw_histogram, draw_legend, draw_magnifier, draw_mark, draw_note,
    draw_pointed
)
from lensbench.app.panels.image.toolbar import picture_tools
from lensbench.app.plots.blur import focus_words
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.cache import NotCompiledError
from lensbench.core.text import fixed

CLICK = 4.0                     # pixels at a scale of 1: a press that moves farther is a drag
TURN = math.radians(0.25)       # of an orbit, per such pixel
DOLLY = 0.06                    # of the distance to the pivot, per click of the wheel
ZOOMS = (0.1, 16.0)
MOST_PICKS = 3                  # points to be made sharp: a plane has no more
MARGIN = 6.0                    # pixels at a scale of 1, about a picture that fits
DIM_AFTER, DIMMED = 0.2, 0.5    # seconds of waiting for another lens or scene, and by how much its picture is dimmed
SLOW = 0.5                      # seconds without a picture, after which a note appears


def image_panel(settings: Settings, picture: Picture, view: View) -> Settings:
    """Draw the tools and the picture into the current window; returns the settings after the mouse's changes."""
    draw = imgui.get_window_draw_list()
    view.covered = None
    draw.channels_split(2)
    draw.channels_set_current(1)
    try:
        return _over_ground(settings, picture, view)
    finally:
        draw.channels_set_current(0)
        _ground(draw, view.covered)
        draw.channels_merge()


def _ground(draw: imgui.ImDrawList, covered: Box | None) -> None:
    """Fill the window only around the picture: software rendering would waste time on the covered part."""
    corner, size = imgui.get_window_pos(), imgui.get_window_size()
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    left, top, right, bottom = covered if covered is not None else (end.x, end.y, end.x, end.y)
    draw.push_clip_rect(corner, end, True)
    for x0, y0, x1, y1 in ((corner.x, corner.y, end.x, top), (corner.x, top, left, bottom),
                           (right, top, end.x, bottom), (corner.x, bottom, end.x, end.y)):
        if x1 > x0 and y1 > y0:
            draw.add_rect_filled(ImVec2(x0, y0), ImVec2(x1, y1), theme.packed(theme.colours().ground))
    draw.pop_clip_rect()


def _over_ground(settings: Settings, picture: Picture, view: View) -> Settings:
    settings = picture_tools(settings, picture, view)
    waits: NotCompiledError | None = None
    try:
        settings = camera_strip(settings, view, picture.applied, picture.off_meter)
    except NotCompiledError as error:       # the picture, or its progress, is drawn all the same
        waits = error
    corner, room = imgui.get_cursor_screen_pos(), imgui.get_content_region_avail()
    view.links.hover, view.plates = None, []
    view.room = _room(room)
    if room.x < theme.em(2.0) or room.y < theme.em(2.0):
        return settings
    if picture.pinned is not None and settings.compare == "side":
        half = ImVec2(round(0.5 * room.x), room.y)
        _pinned_alone(picture, settings, view, corner, half)
        settings = _picture(settings, picture, view, ImVec2(corner.x + half.x, corner.y), half)
    else:
        settings = _picture(settings, picture, view, corner, room)
    draw_notices(view, corner, room)
    settings = draw_trials(settings, view, corner, room)
    if waits is not None:
        raise waits
    return settings


# The picture


def _room(room: ImVec2) -> tuple[float, float]:
    """Pixels of the screen across and down for a picture in this room."""
    density, margin = max(imgui.get_io().display_framebuffer_scale.x, 1.0), 2.0 * MARGIN * theme.scale()
    return max(room.x - margin, 0.0) * density, max(room.y - margin, 0.0) * density


def _frame(size: tuple[int, int], view: View, corner: ImVec2, room: ImVec2) -> tuple[float, ImVec2, ImVec2]:
    """The scale of a picture of this size in pixels, and its corners on the screen."""
    width, height = size
    margin = MARGIN * theme.scale()
    fit = max(min((room.x - 2.0 * margin) / width, (room.y - 2.0 * margin) / height), 1e-3)
    density = max(imgui.get_io().display_framebuffer_scale.x, 1.0)
    scale = fit if view.zoom is None else view.zoom / density
    x0 = round(corner.x + 0.5 * room.x - view.centre[0] * scale * width)
    y0 = round(corner.y + 0.5 * room.y - view.centre[1] * scale * height)
    return scale * density, ImVec2(x0, y0), ImVec2(x0 + round(scale * width), y0 + round(scale * height))


def _shown_size(settings: Settings, picture: Picture) -> tuple[int, int]:
    """Pixels across and down of the settings: a coarse picture during a drag takes the same place as the full one."""
    size = settings.pixels_x, settings.pixels_y
    same_shape = abs(size[0] * picture.size[1] - size[1] * picture.size[0]) <= 0.02 * size[0] * picture.size[1]
    return size if picture.recorded is None and same_shape else picture.size


def _pinned_alone(picture: Picture, settings: Settings, view: View, corner: ImVec2, room: ImVec2) -> None:
    """The pinned picture A, to the left of the current picture."""
    assert picture.pinned is not None
    pixel, draw = theme.scale(), imgui.get_window_draw_list()
    _, upper, lower = _frame(picture.pinned.size, view, corner, room)
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    draw_pinned(draw, picture.pinned, upper, lower, (corner, end))
    left, right = max(upper.x, corner.x), min(lower.x, end.x)
    draw.push_clip_rect(corner, end, True)
    draw_plate(draw, "A, locked" if view.locked else "A", picture.pinned.settings, settings, picture.pinned.samples,
               ImVec2(left + 14.0 * pixel, max(upper.y, corner.y) + 10.0 * pixel), right - left - 28.0 * pixel)
    draw.pop_clip_rect()


def _picture(settings: Settings, picture: Picture, view: View, corner: ImVec2, room: ImVec2) -> Settings:
    draw = imgui.get_window_draw_list()
    imgui.set_cursor_screen_pos(corner)
    if picture.pinned is not None and settings.compare == "wipe":      # an item under others needs a frame of hovering
        imgui.set_next_item_allow_overlap()                             # before a click: slow frames would lose clicks
    imgui.invisible_button("Picture", room, imgui.ButtonFlags_.mouse_button_left | imgui.ButtonFlags_.mouse_button_right
                           | imgui.ButtonFlags_.mouse_button_middle)
    if not picture.texture:
        _progress(picture, view, corner, room)
        return settings

    if picture.around and view.look is not None:
        look_around(settings, picture, view, corner, room)
        return settings

    # Position of the picture
    width, height = size = _shown_size(settings, picture)
    view.scale, upper, lower = _frame(size, view, corner, room)
    extent = ImVec2(max(lower.x - upper.x, 1.0), max(lower.y - upper.y, 1.0))
    x0, y0 = upper.x, upper.y
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    draw.push_clip_rect(corner, end, True)
    draw.add_image(imgui.ImTextureRef(picture.texture), upper, lower)
    view.covered = (max(upper.x, corner.x), max(upper.y, corner.y), max(min(lower.x, end.x), corner.x),
                    max(min(lower.y, end.y), corner.y))
    dim = min(max((picture.waiting - DIM_AFTER) / DIM_AFTER, 0.0), 1.0) if picture.other else 0.0
    if dim:
        draw.add_rect_filled(upper, lower, theme.packed(theme.colours().ground, DIMMED * dim))

    # The mouse
    mouse = imgui.get_mouse_pos()
    position = ((mouse.x - x0) / max(extent.x, 1.0), (mouse.y - y0) / max(extent.y, 1.0))
    inside = 0.0 <= position[0] < 1.0 and 0.0 <= position[1] < 1.0
    if imgui.is_item_hovered() and inside and picture.recorded is None:
        view.links.hover = view.pointed = (position[0] * width, position[1] * height)
    settings = _handled(settings, picture, view, position, inside, extent)
    settings = focused_by_click(settings, picture, view)

    # The overlays
    if picture.recorded is None:
        draw_pointed(draw, view.links, (x0, y0, extent.x / width, extent.y / height), size)
    marks = view.picks.marks if view.sharp_pick and view.picks is not None and view.picks.holds(settings) else \
        (view.mark,) if view.mark is not None and view.mark.holds(settings) and not picture.recorded else ()
    for mark in marks:
        view.plates.append(draw_mark(draw, mark, ImVec2(x0 + mark.x * extent.x, y0 + mark.y * extent.y)))
    if picture.recorded is not None and view.cross is not None:
        at_x, at_y = ((index + 0.5) / size for index, size in zip(view.cross, picture.size, strict=True))
        draw_cross(draw, ImVec2(x0 + at_x * extent.x, y0 + at_y * extent.y), (upper.x, lower.x) if view.line else None)
    if view.histogram and picture.histogram is not None:
        view.plates.append(draw_histogram(draw, picture.histogram, ImVec2(min(lower.x, end.x), min(lower.y, end.y))))
    _below(draw, settings, picture, view, ImVec2(max(upper.x, corner.x), min(lower.y, end.y)))
    if picture.pinned is not None:
        settings = _compared(settings, picture, view, upper, lower, (corner, room))
    if view.magnifier and inside and imgui.is_mouse_hovering_rect(corner, end):
        over_a = picture.pinned is not None and settings.compare == "wipe" and position[0] < settings.wipe
        light = picture.pinned.light if over_a and picture.pinned is not None else picture.light
        if light is not None:
            draw_magnifier(draw, light, position, view.magnifier, (corner, end))
    draw.pop_clip_rect()
    if picture.paused or picture.held:
        _say_below(draw, view, ImVec2(max(upper.x, corner.x), min(lower.y, end.y)),
                   f"Paused: {picture.held}" if picture.held else "Paused")
    elif picture.waiting > SLOW:
        view.plates.append(_progress(picture, view, corner, room))
    return settings


def _below(draw: imgui.ImDrawList, settings: Settings, picture: Picture, view: View, corner: ImVec2) -> None:
    """The note or the legend above the picture's lower left corner."""
    if picture.difference is not None:
        view.plates.append(draw_scale(draw, picture.difference, corner))
    elif picture.recorded is not None:
        _say_below(draw, view, corner, picture.note)
    elif view.sharp_pick:
        _say_below(draw, view, corner, "Click two or three things to make them sharp")
    elif settings.sample_view:
        if settings.view == "fate":
            fates = draw_fates(draw, settings, ImVec2(corner.x, corner.y - theme.em(1.3)), view.links.surfaces)
            view.plates += [fates] if fates is not None else []
        _say_below(draw, view, corner, aov_note(settings))
    elif settings.overlay == "coc":
        view.plates.append(draw_legend(draw, corner))
    elif settings.overlay == "plane":
        _say_below(draw, view, corner, focus_words(settings))
    else:
        _say_below(draw, view, corner, dark_corners(settings))


def _say_below(draw: imgui.ImDrawList, view: View, corner: ImVec2, text: str) -> None:
    """A note above the picture's lower left corner, and above those that are there."""
    if text:
        theme.small()
        size, left, pad = imgui.calc_text_size(text), corner.x + 14.0 * theme.scale(), 6.0 * theme.scale()
        bottom = above_plates(view.plates, left - pad, left + size.x + pad, corner.y - 9.0 * theme.scale(),
                              size.y + pad)
        view.plates.append(draw_note(draw, ImVec2(left, bottom - 0.5 * pad - size.y), text))
        imgui.pop_font()


def _compared(settings: Settings, picture: Picture, view: View, upper: ImVec2, lower: ImVec2,
              panel: tuple[ImVec2, ImVec2]) -> Settings:
    """Draw the comparison with the pinned picture A: the wiped part, or a note; and the plates of both."""
    pinned, (corner, room), pixel = picture.pinned, panel, theme.scale()
    own = picture.recorded or settings
    assert pinned is not None
    draw, comparison = imgui.get_window_draw_list(), settings.compare
    end = ImVec2(corner.x + room.x, corner.y + room.y)
    if comparison == "wipe":
        _, left, right = _frame(pinned.size, view, corner, room)
        line = upper.x + settings.wipe * (lower.x - upper.x)
        draw.add_rect_filled(corner, ImVec2(line, end.y), theme.packed(theme.colours().ground))
        draw_pinned(draw, pinned, left, right, (corner, ImVec2(line, end.y)))
        settings = wiped(settings, upper, lower, corner, room)
    elif comparison == "difference" and picture.difference is None:
        _say_below(draw, view, ImVec2(max(upper.x, corner.x), min(lower.y, end.y)),
                   f"A has {pinned.size[0]} × {pinned.size[1]} pixels: a difference needs the same number")
    top = max(upper.y, corner.y) + 10.0 * pixel
    a = ImVec2(max(upper.x, corner.x) + 14.0 * pixel, top)
    b = ImVec2(min(lower.x, end.x) - 14.0 * pixel, top)
    if comparison == "side":
        draw_plate(draw, "B", own, pinned.settings, picture.samples, a, b.x - a.x)
    else:
        half = 0.5 * (b.x - a.x) - 14.0 * pixel
        draw_plate(draw, "A, locked" if view.locked else "A", pinned.settings, own, pinned.samples, a, half)
        draw_plate(draw, "B", own, pinned.settings, picture.samples, b, half, right=True)
    return settings


def _handled(settings: Settings, picture: Picture, view: View, position: tuple[float, float], inside: bool,
             extent: ImVec2) -> Settings:
    """The settings and the view after this frame's mouse on the item just submitted."""
    io, pixel = imgui.get_io(), theme.scale()
    button = imgui.MouseButton_
    if imgui.is_item_activated():
        view.dragged = False

    # Drags
    if imgui.is_item_active() and (io.mouse_delta.x or io.mouse_delta.y):
        pressed = next((b for b in (button.left, button.right, button.middle) if imgui.is_mouse_down(b)), button.left)
        was_dragged = view.dragged
        view.dragged = was_dragged or imgui.is_mouse_dragging(pressed, CLICK * pixel)
        moved = imgui.get_mouse_drag_delta(pressed, 0.0) if view.dragged and not was_dragged else io.mouse_delta
        if view.dragged and io.key_ctrl:
            view.zoom = view.zoom or view.scale
            view.centre = (_unit(view.centre[0] - moved.x / extent.x), _unit(view.centre[1] - moved.y / extent.y))
        elif view.dragged and (pressed != button.left or io.key_shift):
            length = _length_per_pixel(settings, extent)
            settings = panned(settings, -moved.x * length, moved.y * length)
        elif view.dragged:
            settings = orbited(settings, moved.x / pixel * TURN, moved.y / pixel * TURN)

    # A click: pin or unpin a pixel, or focus
    if imgui.is_item_deactivated() and not view.dragged and inside and not io.key_ctrl \
            and imgui.is_mouse_released(button.left):
        if picture.recorded is None and (view.pin_pick or io.key_alt):
            view.links.toggle_pin(position)
        elif view.focus_pick or view.sharp_pick:
            view.pending = Click(*position, settings.aim)

    # The wheel
    if imgui.is_item_hovered():
        imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
        if io.mouse_wheel and io.key_alt and view.magnifier:
            view.magnifier = min(max(view.magnifier + int(math.copysign(1, io.mouse_wheel)), 1), len(STEPS))
        elif io.mouse_wheel and io.key_ctrl:
            _zoom(view, position, 2.0 ** (0.5 * io.mouse_wheel))
        elif io.mouse_wheel:
            settings = dollied(settings, io.mouse_wheel * DOLLY * pivot_distance(settings))
    return settings


def _unit(value: float) -> float:
    return min(max(value, 0.0), 1.0)


def _zoom(view: View, mouse: tuple[float, float], factor: float) -> None:
    """Zoom about a fixed point of the picture."""
    before = view.zoom or view.scale
    view.zoom = min(max(before * factor, ZOOMS[0]), ZOOMS[1])
    ratio = before / view.zoom
    x, y = (_unit(m + (c - m) * ratio) for m, c in zip(mouse, view.centre, strict=True))
    view.centre = x, y


def _length_per_pixel(settings: Settings, extent: ImVec2) -> float:
    """Length (mm) in the plane of the pivot per pixel of the screen."""
    view = readings(settings).fov_horizontal or 0.7
    return 2.0 * pivot_distance(settings) * math.tan(0.5 * view) / max(extent.x, 1.0)


def focused_by_click(settings: Settings, picture: Picture, view: View) -> Settings:
    """The settings focused at the depth under a click, once it is known; a click in a picture that is gone is void."""
    if view.pending is not None and picture.recorded is not None:
        width, height = picture.size
        view.picked, view.pending = (int(view.pending.x * width), int(view.pending.y * height)), None
    if view.pending is not None and not view.pending.holds(settings):
        view.pending = None
    if view.pending is None or picture.depth is None:
        return settings
    x, y = view.pending.x, view.pending.y
    view.pending = None
    rows, columns = picture.depth.shape
    depth = float(picture.depth[min(int(y * rows), rows - 1), min(int(x * columns), columns - 1)])
    if view.sharp_pick:
        return _sharpened(settings, view, (x, y), depth)
    if math.isnan(depth) or depth <= 0.0 or not settings.focuses:
        return settings
    nearest = readings(settings).nearest_focus or 0.0
    focus = focused_at(settings, (x, y), depth)
    distance = max(focus.distance, nearest * (1.0 + 1e-6))
    view.mark = Mark(x, y, distance, settings.aim, focus.remark)
    return replace(settings, focus_distance=distance)


def _sharpened(settings: Settings, view: View, share: tuple[float, float], depth: float) -> Settings:
    """The settings that make the point under a click sharp, with up to two that were picked before."""
    if math.isnan(depth) or depth <= 0.0:
        return settings
    picks = view.picks
    if picks is None or len(picks.points) == MOST_PICKS or not picks.holds(settings):
        picks = SharpPicks((), (), settings)
    try:
        points = (*picks.points, picked_point(settings, share, depth))
        marks = (*picks.marks, Mark(*share, depth, settings.aim))
        if len(points) > 1:
            settings, shares = made_sharp(settings, np.array(points))
            marks = tuple(replace(mark, x=float(x), y=float(y)) for mark, (x, y) in zip(marks, shares, strict=True))
        view.picks = SharpPicks(points, marks, settings)
    except (ValueError, OSError) as error:
        view.say(str(error))
    return settings


# Progress over the picture


def _progress(picture: Picture, view: View, corner: ImVec2, room: ImVec2) -> Box:
    """A note that a picture is being prepared, after a short wait, where no other words stand; its box."""
    if picture.waiting < (0.15 if picture.first else SLOW):
        return 0.0, 0.0, 0.0, 0.0
    pixel, colour, draw = theme.scale(), theme.colours(), imgui.get_window_draw_list()
    text, done, count = "Preparing the picture", 0, 0
    if picture.plan:
        done, count = sum(task.done for task in picture.plan), sum(task.total for task in picture.plan)
        parts = " · ".join(f"{task.title} {task.done} of {task.total}" for task in picture.plan)
        text = f"Compiling the kernels, once for this version · {fixed(picture.waiting, 0)} s\n{parts}"
    size = imgui.calc_text_size(text)
    width = max(size.x, theme.em(14.0))
    pad = round(theme.em(0.9))
    left, top = round(corner.x + 0.5 * (room.x - width)), round(corner.y + 0.5 * room.y - size.y)
    high = size.y + theme.em(0.9) + 2.0 * pad
    if picture.first:                   # below the notices
        top = max(top, round(corner.y + theme.em(3.4) + pad)) if len(view.notices) else top
    else:                               # the picture before is in sight: off its subject, at the lower edge
        bottom = corner.y + room.y - theme.em(1.2)
        top = round(above_plates(view.plates, left - pad, left + width + pad, bottom, high) - high + pad)
    box = left - pad, top - pad, left + width + pad, top - pad + high
    draw.add_rect_filled(ImVec2(*box[:2]), ImVec2(*box[2:]), theme.packed(colour.popup, 0.92), 4.0 * pixel)
    draw.add_text(ImVec2(round(left + 0.5 * (width - size.x)), top), theme.packed(colour.text), text)
    y, thick = top + size.y + round(theme.em(0.55)), round(3.0 * pixel)
    draw.add_rect_filled(ImVec2(left, y), ImVec2(left + width, y + thick), theme.packed(colour.frame), 1.5 * pixel)
    begin, task = left + 0.75 * width * (0.5 - 0.5 * math.cos(2.0 * picture.waiting)), 0.25
    if picture.plan:
        begin, task = left, done / count
    draw.add_rect_filled(ImVec2(begin, y), ImVec2(begin + task * width, y + thick), theme.packed(colour.text),
                         1.5 * pixel)
    return box
