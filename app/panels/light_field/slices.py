"""Recorded light of one pixel and of one line, in the panel *Light field*: slices of the plenoptic function.

A pixel sees a radiance through every cell of the pupil, in three bands of wavelength, and moment by moment where these
were kept apart; a line of the picture, seen by a row of the pupil's cells, is an epipolar image: in it what is in focus
is an upright line, and everything else slopes according to its depth.

The depth of a light field in the panel *Light field*: estimated, shown and read.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, icons_fontawesome_6, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.constraints import MARGIN
from lensbench.app.bench.light_field_query import (
    DEEP, Look, Recording, epipolar, format_place, radiance, radiance_over_time, ray
)
from lensbench.app.bench.tone import colour, develop, ends
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.panels.light_field.capture_form import Form
from lensbench.app.panels.light_field.pupil_pad import figures, millimetres, pupil_grid
from lensbench.app.session.notices import Request
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.app.workers.light_field_worker import LightFieldWorker
from lensbench.core.text import fixed, significant

fa = icons_fontawesome_6
DEEP_TIPS = {
    "sharp": "Each pixel in focus at its own depth: the views are added up along the slopes that were found",
    "depth": "The distance as a colour; uncertain pixels are dark",
    "sure": "White: the views agree at a single distance. Black: they agree at any distance, because nothing changes "
            "from pixel to pixel",
}
STEPS = 64                      # of the colours of the scale


def depth_body(look: Look, recording: Recording, worker: LightFieldWorker, form: Form) -> Look:
    """Draw the button that starts the search, or the depth found; returns the look after the user's changes."""
    depth = worker.known_depth
    if depth is None:
        paragraph("Nearer objects shift more between the views. From this parallax the depth follows.")
        imgui.begin_disabled(worker.task is not None)
        if imgui.button(fa.ICON_FA_MAGNIFYING_GLASS + "  Find the depth###Find the depth"):
            form.requests.add(Request.FIND_DEPTH)
        imgui.end_disabled()
        return look
    look = replace(look, deep=toggles("Depth picture", DEEP, look.deep, DEEP_TIPS, 0.0))
    _scale(depth)
    x, y = look.pixel
    distance, sure = float(depth.distance[y, x]), float(depth.confidence[y, x])
    figures((
        ("Pixel", f"{x}, {y}", "Click in the picture to choose another, across and down"),
        ("Depth", format_distance(distance), "Distance of the object in this pixel, measured as the focus distance is"),
        ("Error", f"± {format_distance(float(depth.error[y, x]))}",
         "Of this depth, for most sure pixels: 0.3 of a pixel of the outermost views"),
        ("Sure", f"{fixed(100.0 * sure, 0)} %", "0 %: the views agree at any distance; 100 %: only at this one")))
    if imgui.button("Focus there"):
        look = replace(look, show="focus", distance=max(distance, recording.nearest * MARGIN))
    imgui.set_item_tooltip("Focus the light field at this pixel's depth")
    return look


def _scale(depth: lb.Depth) -> None:
    """The scale of the colours, linear in the reciprocal distance, which is the parallax."""
    far, near = ends(depth)
    corner, pixel = imgui.get_cursor_screen_pos(), theme.scale()
    width, bar = imgui.get_content_region_avail().x, round(theme.em(0.7))
    draw = imgui.get_window_draw_list()
    edges = [round(corner.x + i * width / STEPS) for i in range(STEPS + 1)]
    for i, code in enumerate(colour(1.0 - (np.arange(STEPS) + 0.5) / STEPS).tolist()):
        draw.add_rect_filled(ImVec2(edges[i], corner.y), ImVec2(edges[i + 1], corner.y + bar),
                             theme.packed((*code, 1.0)))
    theme.small()
    line = imgui.get_text_line_height()
    for fraction in (0.0, 0.25, 0.5, 0.75, 1.0):
        reciprocal = (1.0 - fraction) / near + fraction / far
        text = format_distance(1.0 / reciprocal if reciprocal > 0.0 else math.inf)
        extent = imgui.calc_text_size(text).x
        x = min(max(corner.x + fraction * width - 0.5 * extent, corner.x), corner.x + width - extent)
        draw.add_text(ImVec2(round(x), corner.y + bar + 2.0 * pixel), theme.packed(theme.colours().dim), text)
    imgui.dummy(ImVec2(width, bar + line + 4.0 * pixel))
    imgui.pop_font()


Strip = Callable[[NDArray[np.float32], Any, Settings], int]
BANDS = {-1: "All", 0: "Red", 1: "Green", 2: "Blue"}
BAND_TIPS = {-1: "The three bands as a colour", 0: "The red band alone", 1: "The green band alone",
             2: "The blue band alone"}
PRIMARIES = ((0.84, 0.33, 0.28), (0.36, 0.67, 0.35), (0.33, 0.52, 0.86))     # red, green and blue, in either theme
LINE = 0.62                     # em of a view's line in the epipolar image


def moment_chooser(look: Look, recording: Recording) -> Look:
    """The choice of the moment, if the exposure was recorded in moments; returns the look with it."""
    moments = recording.field.moments
    if moments is None:
        return look
    choices = {-1: "All", **{k: f"{k + 1}" for k in range(len(moments))}}
    tips = {-1: "The whole exposure", **{k: f"Part {k + 1} of {len(moments)} of the exposure"
                                         for k in range(len(moments))}}
    return replace(look, moment=toggles("Moment", choices, min(look.moment, len(moments) - 1), tips, 4.0))


def rays_body(look: Look, recording: Recording, settings: Settings, strip: Strip) -> Look:
    """Draw both slices; returns the look with the clicked cell and pixel."""
    over_time = radiance_over_time(recording, look.pixel)
    look = replace(look, band=toggles("Band", BANDS, look.band, BAND_TIPS, 4.0))
    look = moment_chooser(look, recording)
    light = radiance(recording, look.pixel) if recording.of_moment(look)[1] == 1 else over_time[look.moment]
    shown = light if look.band < 0 else np.repeat(light[..., look.band:look.band + 1], 3, -1)
    look = pupil_grid(look, recording, develop(shown, settings.exposure, settings.tone))
    i, j = look.cell
    on_film, in_pupil = ray(recording, look.pixel, look.cell)
    x, y = look.pixel
    red, green, blue = light[j, i].tolist()
    covered = float(recording.field.coverage[j, i, y, x])
    u, v = recording.field.places[j, i].tolist()
    figures((
        ("Pixel", f"{x}, {y}", "Click in the picture to choose another, across and down"),
        ("Film", millimetres(on_film), "Where the chosen ray meets the film (s, t): x to the right, y up; the picture "
                                       "on the film is upside down"),
        ("u, v", format_place((u, v)), "The chosen cell of the pupil, in radii of it: click in the map"),
        ("Pupil", millimetres(in_pupil), "Where the chosen ray meets the plane of the paraxial exit pupil (u, v)"),
        ("Light", f"{fixed(red, 2)} {fixed(green, 2)} {fixed(blue, 2)}",
         "Radiance in the three bands, red, green and blue, over the whole exposure, or in the chosen moment"),
        ("Share", f"{fixed(100.0 * covered, 1)} %", "Coverage: the part of a full cell's light that passes")))
    if len(over_time) > 1:
        _over_time(over_time[:, j, i], look.moment)
    return _epipolar(look, recording, settings, strip)


def _over_time(light: NDArray[np.float32], moment: int) -> None:
    """The radiance of the chosen ray in three bands (n, 3) over the moments; the chosen moment is strong."""
    theme.small()
    imgui.text_disabled(f"Radiance of the ray over the exposure, 0 to {significant(light.max(), 3)}")
    imgui.pop_font()
    corner, height = imgui.get_cursor_screen_pos(), round(theme.em(2.6))
    size = ImVec2(imgui.get_content_region_avail().x, height)
    imgui.invisible_button("Over time", size)
    rows = [f"{k + 1}: {significant(red, 3)} {significant(green, 3)} "
            f"{significant(blue, 3)}" for k, (red, green, blue) in enumerate(light.tolist())]
    imgui.set_item_tooltip("From the opening of the shutter at the left to its end: red, green and blue\n"
                           + "\n".join(rows))
    colour, draw, pixel = theme.colours(), imgui.get_window_draw_list(), theme.scale()
    draw.add_rect_filled(corner, ImVec2(corner.x + size.x, corner.y + height), theme.packed(colour.well), 2.0 * pixel)
    pitch, unit = size.x / len(light), (height - 2.0 * pixel) / max(float(light.max()), 1e-9)
    for k, bands in enumerate(light.tolist()):
        alpha = 1.0 if moment in (-1, k) else 0.4
        for band, value in enumerate(bands):
            left = corner.x + (k + 0.15 + 0.7 * band / 3.0) * pitch
            draw.add_rect_filled(ImVec2(left, corner.y + height - max(unit * value, pixel)),
                                 ImVec2(left + 0.7 * pitch / 3.0 - pixel, corner.y + height),
                                 theme.packed((*PRIMARIES[band], 1.0), alpha))


def _epipolar(look: Look, recording: Recording, settings: Settings, strip: Strip) -> Look:
    """The chosen line of the picture in each view of the chosen cell's row, the rightmost view at the top."""
    field = recording.field
    (across, _), (x, y), down = field.views, look.pixel, look.cell[1]
    w = recording.settings.pixels_x
    texture = strip(np.ascontiguousarray(epipolar(recording, y, down)[::-1]), (recording, y, down), settings)
    theme.small()
    imgui.text_disabled(f"Line {y} over the pupil's row {down + 1}")
    imgui.pop_font()
    corner = imgui.get_cursor_screen_pos()
    size = ImVec2(imgui.get_content_region_avail().x, round(across * theme.em(LINE)))
    imgui.invisible_button("Epipolar image", size)
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw, pixel = imgui.get_window_draw_list(), theme.scale()
    draw.add_image(imgui.ImTextureRef(texture), corner, end)
    if imgui.is_item_active():
        column = int((imgui.get_mouse_pos().x - corner.x) / size.x * w)
        look = replace(look, pixel=(min(max(column, 0), w - 1), y))
    elif imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip("Epipolar image: the line as each view of a row of the pupil sees it, the leftmost below.\n"
                          "Lines parallel to the amber line are in focus. Click: another pixel of the line")

    # The slope of a point in focus
    shifts = field.shifts(field.shear(recording.seen(look.distance))[1])[down, :, 0]
    draw.push_clip_rect(corner, end, True)
    points = [ImVec2(corner.x + (x + 0.5 + shift) / w * size.x, end.y - (i + 0.5) / across * size.y)
              for i, shift in enumerate(shifts.tolist())]
    draw.add_polyline(points, theme.packed(theme.colours().amber), 1.5 * pixel, 0)
    draw.pop_clip_rect()
    return look
