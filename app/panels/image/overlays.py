"""Overlays of the picture: the focused point, the histogram, legends of false colours, and the magnifier.

The magnifier shows the picture as developed, without overlays. The colours of all of them do not follow the theme,
because the picture below does not.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench import tone
from lensbench.app.bench.build import design
from lensbench.app.display.frame import Box, Light, Mark, View
from lensbench.app.drawing import theme
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import significant, true_minus

STEPS = ((23, 15, 0.62), (15, 11, 1.0), (9, 7, 1.7), (5, 5, 3.5))      # pixels across and down, em a pixel
NUMBERED = 3.0                  # em: from this size on a pixel holds its numbers
SCALE_STEPS = 48                # of a scale of colours
USUAL = 2                       # the step that the magnifier begins with
GAP = 1.4                       # em from the mouse
PLATE, WORDS = (0.07, 0.07, 0.07, 0.94), (0.86, 0.86, 0.86, 1.0)
RGB = ((0.98, 0.55, 0.50, 1.0), (0.55, 0.88, 0.55, 1.0), (0.58, 0.72, 1.0, 1.0))
DARK_RGB = ((0.55, 0.0, 0.0, 1.0), (0.0, 0.32, 0.0, 1.0), (0.0, 0.0, 0.60, 1.0))       # on bright pixels


def toggle_magnifier(view: View) -> None:
    """Switch the magnifier on or off."""
    view.magnifier = 0 if view.magnifier else USUAL


def toggle_sharp_pick(view: View) -> None:
    """Switch between clicks that make points sharp and clicks that focus."""
    view.sharp_pick, view.pin_pick, view.picks = not view.sharp_pick, False, None
    view.focus_pick = not view.sharp_pick


def cells(values: NDArray[np.float32], x: int, y: int, across: int, down: int) -> NDArray[np.float64]:
    """Pixels (down, across, 3) of a picture (h, w, 3) about column x and row y; NaN beyond its edges."""
    height, width = values.shape[:2]
    block = np.full((down, across, 3), np.nan)
    rows, columns = y - down // 2 + np.arange(down), x - across // 2 + np.arange(across)
    inside = np.ix_((rows >= 0) & (rows < height), (columns >= 0) & (columns < width))
    block[inside] = values[np.ix_(rows[(rows >= 0) & (rows < height)], columns[(columns >= 0) & (columns < width)])]
    return block


def codes(light: Light, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (..., 3) as the screen shows them: sRGB in [0, 1]."""
    if light.tone == "difference":
        return tone.srgb(np.clip(values / light.scale, 0.0, 1.0))
    return tone.develop(values, light.exposure, light.tone, light.sensor)


def draw_magnifier(draw: imgui.ImDrawList, light: Light, position: tuple[float, float], step: int,
                   panel: tuple[ImVec2, ImVec2]) -> None:
    """Draw it next to the mouse, within the corners of the panel. position: of the mouse, in widths and heights."""
    height, width = light.values.shape[:2]
    x, y = min(int(position[0] * width), width - 1), min(int(position[1] * height), height - 1)
    across, down, size = STEPS[step - 1]
    side = max(round(theme.em(size)), 3)
    values = cells(light.values, x, y, across, down)
    shown = np.nan_to_num(codes(light, np.nan_to_num(values)))

    # Its place: right of the mouse and below, or on the other side where that is beyond the panel
    pixel, mouse = theme.scale(), imgui.get_mouse_pos()
    theme.small()
    line, pad = imgui.get_text_line_height(), round(4.0 * pixel)
    middle = values[down // 2, across // 2]
    texts = _words(x, y, middle, shown[down // 2, across // 2])
    wide = max(across * side, *(imgui.calc_text_size(text).x for text in texts)) + 2 * pad
    high = down * side + len(texts) * line + 3 * pad
    left = _beside(mouse.x, wide, panel[0].x, panel[1].x)
    top = _beside(mouse.y, high, panel[0].y, panel[1].y)
    draw.add_rect_filled(ImVec2(left, top), ImVec2(left + wide, top + high), theme.packed(PLATE), 3.0 * pixel)

    # The pixels
    x0, y0 = left + round(0.5 * (wide - across * side)), top + pad
    inside = np.isfinite(values[..., 0])
    for row in range(down):
        for column in range(across):
            if not inside[row, column]:
                continue
            red, green, blue = (float(code) for code in shown[row, column])
            corner = ImVec2(x0 + column * side, y0 + row * side)
            draw.add_rect_filled(corner, ImVec2(corner.x + side, corner.y + side),
                                 theme.packed((red, green, blue, 1.0)))
            if size >= NUMBERED:
                _numbers(draw, corner, side, values[row, column], bright=0.3 * red + 0.6 * green + 0.1 * blue > 0.5)
    if size >= NUMBERED:
        grid = theme.packed((0.5, 0.5, 0.5, 0.6))
        for column in range(across + 1):
            draw.add_line(ImVec2(x0 + column * side, y0), ImVec2(x0 + column * side, y0 + down * side), grid, pixel)
        for row in range(down + 1):
            draw.add_line(ImVec2(x0, y0 + row * side), ImVec2(x0 + across * side, y0 + row * side), grid, pixel)
    for grow, tint in ((1.0, (0.0, 0.0, 0.0, 0.9)), (0.0, (1.0, 1.0, 1.0, 0.95))):
        a = ImVec2(x0 + across // 2 * side - grow * pixel, y0 + down // 2 * side - grow * pixel)
        b = ImVec2(a.x + side + 2.0 * grow * pixel, a.y + side + 2.0 * grow * pixel)
        draw.add_rect(a, b, theme.packed(tint), 0.0, pixel)

    # The values of the pixel in the middle
    for i, text in enumerate(texts):
        draw.add_text(ImVec2(left + pad, y0 + down * side + pad + i * line), theme.packed(WORDS), text)
    imgui.pop_font()


def _beside(mouse: float, extent: float, low: float, high: float) -> float:
    """Where a plate of this extent begins: after the mouse, before it, or at the edge of a panel that has no room."""
    gap = theme.em(GAP)
    begin = mouse + gap if mouse + gap + extent <= high else mouse - gap - extent
    return round(max(min(begin, high - extent), low))


def _words(x: int, y: int, value: NDArray[np.float64], code: NDArray[np.float64]) -> tuple[str, str]:
    """Place and code on the screen, and linear light of one pixel."""
    numbers = [round(255.0 * float(channel)) for channel in code]
    light = "  ".join(_number(float(channel)) for channel in value)
    return f"{x}, {y}   #{numbers[0]:02x}{numbers[1]:02x}{numbers[2]:02x}", f"linear  {light}"


def _numbers(draw: imgui.ImDrawList, corner: ImVec2, side: int, value: NDArray[np.float64], bright: bool) -> None:
    """Red, green and blue of a pixel, one below the other, in its square."""
    line = imgui.get_text_line_height()
    top = corner.y + 0.5 * (side - 3.0 * line)
    for i, (channel, tint) in enumerate(zip(value, DARK_RGB if bright else RGB, strict=True)):
        text = _number(float(channel))
        x = corner.x + 0.5 * (side - imgui.calc_text_size(text).x)
        draw.add_text(ImVec2(math.floor(x), math.floor(top + i * line)), theme.packed(tint), text)


def _number(value: float) -> str:
    return true_minus(significant(value, 3 if value < 9.995 else 4))


def draw_mark(draw: imgui.ImDrawList, mark: Mark, point: ImVec2) -> Box:
    """Four corners around the focused point, its distance, and why it is not sharp there; the box of all."""
    pixel = theme.scale()
    half, leg = round(16.0 * pixel), round(7.0 * pixel)
    amber, shade = theme.DARK.amber, (0.0, 0.0, 0.0, 0.45)
    x, y = round(point.x), round(point.y)
    for offset, tint in ((1.0, shade), (0.0, amber)):
        for sx in (-1, 1):
            for sy in (-1, 1):
                cx, cy = x + sx * half + offset, y + sy * half + offset
                draw.add_polyline([ImVec2(cx - sx * leg, cy), ImVec2(cx, cy), ImVec2(cx, cy - sy * leg)],
                                  theme.packed(tint), 1.5 * pixel, 0)
    theme.small()
    top = y + half + round(5.0 * pixel)
    for text in filter(None, (format_distance(mark.distance), mark.remark)):
        size = imgui.calc_text_size(text)
        left = x - round(0.5 * size.x)
        draw.add_rect_filled(ImVec2(left - 5 * pixel, top - 1 * pixel),
                             ImVec2(left + size.x + 5 * pixel, top + size.y + 2 * pixel),
                             theme.packed((0.09, 0.075, 0.05, 0.78)), 3.0 * pixel)
        draw.add_text(ImVec2(left, top), theme.packed(theme.DARK.amber_text), text)
        top, half = top + size.y + 3.0 * pixel, max(half, round(0.5 * size.x + 5.0 * pixel))
    imgui.pop_font()
    return x - half, y - round(16.0 * pixel), x + half, top


def draw_cross(draw: imgui.ImDrawList, point: ImVec2, line: tuple[float, float] | None) -> None:
    """A cross about a pixel; line: the ends of its line of pixels."""
    pixel, x, y = theme.scale(), round(point.x), round(point.y)
    for offset, tint in ((pixel, (0.0, 0.0, 0.0, 0.55)), (0.0, (1.0, 1.0, 1.0, 0.9))):
        cx, cy = x + offset, y + offset
        for begin, end in ((4.0 * pixel, 11.0 * pixel), (-11.0 * pixel, -4.0 * pixel)):
            draw.add_line(ImVec2(cx + begin, cy), ImVec2(cx + end, cy), theme.packed(tint), 1.5 * pixel)
            draw.add_line(ImVec2(cx, cy + begin), ImVec2(cx, cy + end), theme.packed(tint), 1.5 * pixel)
        if line is not None:
            for begin, end in ((line[0], x - 14.0 * pixel), (x + 14.0 * pixel, line[1])):
                draw.add_line(ImVec2(begin, cy), ImVec2(max(begin, end), cy), theme.packed(tint, 0.6), pixel)


def draw_pointed(draw: imgui.ImDrawList, links: Pointed, frame: tuple[float, float, float, float],
                 size: tuple[int, int]) -> None:
    """A square around the pinned pixel, and a ring where the pointed ray meets the scene.

    frame: left and top edge of the picture on the screen, and its scale across and down (screen pixels a pixel).
    size: pixels of the picture across and down.
    """
    left, top, across, down = frame
    pixel = theme.scale()
    tints = ((pixel, (0.0, 0.0, 0.0, 0.6)), (0.0, (1.0, 1.0, 1.0, 0.95)))
    raster = links.pixel(*size) if links.pinned is not None else None
    if raster is not None:
        half = max(0.5 * across, 4.0 * pixel), max(0.5 * down, 4.0 * pixel)
        x, y = left + raster[0] * across, top + raster[1] * down
        for offset, tint in tints:
            draw.add_rect(ImVec2(x - half[0] + offset, y - half[1] + offset),
                          ImVec2(x + half[0] + offset, y + half[1] + offset), theme.packed(tint), 0.0, 1.5 * pixel)
            for sign in (-1.0, 1.0):
                draw.add_line(ImVec2(x + sign * half[0] + offset, y + offset),
                              ImVec2(x + sign * (half[0] + 7.0 * pixel) + offset, y + offset), theme.packed(tint),
                              1.5 * pixel)
    if links.ray is not None and links.ray.raster is not None:
        x, y = left + links.ray.raster[0] * across, top + links.ray.raster[1] * down
        for offset, tint in (tints[0], (0.0, theme.pointed())):
            draw.add_circle(ImVec2(x + offset, y + offset), 5.0 * pixel, theme.packed(tint), 0, 1.5 * pixel)


def plate(draw: imgui.ImDrawList, box: Box, ink: tuple[float, ...] = (0.07, 0.07, 0.07, 0.78)) -> Box:
    """A dark plate for words over the picture; its box."""
    draw.add_rect_filled(ImVec2(*box[:2]), ImVec2(*box[2:]), theme.packed(ink), 3.0 * theme.scale())
    return box


def above_plates(plates: Sequence[Box], left: float, right: float, bottom: float, height: float) -> float:
    """The lowest bottom, at most this one, of something so high that touches no plate."""
    for x0, y0, x1, y1 in sorted(plates, key=lambda box: -box[3]):        # the lowest first
        if x0 < right and left < x1 and y0 < bottom and bottom - height < y1:
            bottom = y0 - 6.0 * theme.scale()
    return bottom


def draw_note(draw: imgui.ImDrawList, corner: ImVec2, text: str) -> Box:
    """A few words on a dark plate; the box of the plate."""
    pixel = theme.scale()
    size = imgui.calc_text_size(text)
    box = plate(draw, (corner.x - 6.0 * pixel, corner.y - 3.0 * pixel,
                       corner.x + size.x + 6.0 * pixel, corner.y + size.y + 3.0 * pixel))
    draw.add_text(ImVec2(round(corner.x), round(corner.y)), theme.packed(WORDS), text)
    return box


def draw_histogram(draw: imgui.ImDrawList, shares: NDArray[np.float64], corner: ImVec2) -> Box:
    """The histogram above the picture's lower right corner; the box of its plate."""
    pixel = theme.scale()
    size = ImVec2(theme.em(12.0), theme.em(5.0))
    left, bottom = corner.x - size.x - 10.0 * pixel, corner.y - 10.0 * pixel
    top = bottom - size.y
    pad = 5.0 * pixel
    box = plate(draw, (left - pad, top - pad, left + size.x + pad, bottom + pad), (0.07, 0.07, 0.07, 0.72))
    bins = shares.shape[1]
    across = left + (np.arange(bins) + 0.5) / bins * size.x
    step = size.x / bins
    for x, share in zip(across, shares[3], strict=True):
        draw.add_rect_filled(ImVec2(x - 0.5 * step, bottom - share * size.y), ImVec2(x + 0.5 * step, bottom),
                             theme.packed((0.8, 0.8, 0.8, 0.25)))
    for row, tint in zip(shares, ((0.90, 0.42, 0.36, 0.9), (0.45, 0.78, 0.45, 0.9), (0.45, 0.62, 0.95, 0.9)),
                         strict=False):
        points: list[Any] = [ImVec2(x, bottom - y * size.y) for x, y in zip(across, row, strict=True)]
        draw.add_polyline(points, theme.packed(tint), 1.2 * pixel, 0)
    return box


def draw_legend(draw: imgui.ImDrawList, corner: ImVec2) -> Box:
    """The legend of the circle of confusion, as `draw_colour_scale` draws it."""
    tints = []
    for i in range(SCALE_STEPS):
        # Twice log2 from 64 down to 1 and up again, as in the shader
        share = abs(2.0 * (i + 0.5) / SCALE_STEPS - 1.0)
        side = theme.NEARER[:3] if i < SCALE_STEPS // 2 else theme.FARTHER[:3]
        strength = 0.25 + 0.75 * share
        red, green, blue = ((0.5 * (1 - strength) + strength * c) * (0.55 + 0.45 * share) for c in side)
        tints.append(theme.DARK.amber[:3] if share < 0.1 else (red, green, blue))
    return draw_colour_scale(draw, corner, "Circle of confusion, px", tints, {
        0.0: "64 nearer", 0.333: "4", 0.5: "1", 0.667: "4", 1.0: "64 farther"})


def draw_colour_scale(draw: imgui.ImDrawList, corner: ImVec2, title: str, tints: Sequence[tuple[float, float, float]],
                      names: Mapping[float, str]) -> Box:
    """A scale of colours with its title, above the picture's lower left corner; the box of its plate.

    tints: from left to right. names: below it, by their fraction of its width.
    """
    pixel = theme.scale()
    theme.small()
    line = imgui.get_text_line_height()
    width, bar, pad = theme.em(20.0), round(7.0 * pixel), 8.0 * pixel
    left, top = corner.x + 14.0 * pixel, corner.y - bar - 2.0 * line - 18.0 * pixel
    box = plate(draw, (left - pad, top - 0.6 * pad, left + width + pad, top + bar + 2 * line + pad))
    text = theme.packed(WORDS)
    draw.add_text(ImVec2(left, top), text, title)
    step, y = width / len(tints), top + line + 2.0 * pixel
    for i, tint in enumerate(tints):
        draw.add_rect_filled(ImVec2(left + i * step, y), ImVec2(left + (i + 1) * step, y + bar),
                             theme.packed((*tint, 1.0)))
    for fraction, name in names.items():
        extent = imgui.calc_text_size(name).x
        x = min(max(left + fraction * width - 0.5 * extent, left), left + width - extent)
        draw.add_text(ImVec2(round(x), y + bar + 2.0 * pixel), text, name)
    imgui.pop_font()
    return box


def draw_fates(draw: imgui.ImDrawList, settings: Settings, corner: ImVec2, lit: tuple[int, ...] = ()) -> Box | None:
    """A swatch for each surface that can end a ray, from front to rear, above the picture's lower left corner.

    lit: indices of the surfaces that are framed, because the mouse points at them. Returns the box of the plate; None
    for a camera that has no such surfaces.
    """
    if not settings.has_lens or not LENS_MODELS[settings.lens_model].has_fates:
        return None
    lens, pixel = design(settings), theme.scale()
    theme.small()
    line, side = imgui.get_text_line_height(), theme.em(1.35)
    left, top = corner.x + 14.0 * pixel, corner.y - 2.0 * line - 14.0 * pixel
    names = [str(i) for i in range(len(lens.surfaces))]
    names[lens.stop_index] = "stop"
    widths = [max(side, imgui.calc_text_size(name).x + 6.0 * pixel) for name in names]
    box = plate(draw, (left - 6.0 * pixel, top - 4.0 * pixel,
                       left + sum(widths) + 6.0 * pixel, top + 1.6 * line + 4.0 * pixel))
    for i, (name, width, (red, green, blue)) in enumerate(zip(names, widths, lb.fate_colours(lens), strict=True)):
        draw.add_rect_filled(ImVec2(left, top), ImVec2(left + width - pixel, top + 0.5 * line),
                             theme.packed((float(red), float(green), float(blue), 1.0)))
        if i in lit:
            draw.add_rect(ImVec2(left - pixel, top - pixel), ImVec2(left + width, top + 0.5 * line + pixel),
                          theme.packed((1.0, 1.0, 1.0, 1.0)), 0.0, 2.0 * pixel)
        draw.add_text(ImVec2(round(left + 0.5 * (width - imgui.calc_text_size(name).x)), top + 0.55 * line),
                      theme.packed(WORDS), name)
        left += width
    imgui.pop_font()
    return box
