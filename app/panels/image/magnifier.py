"""The magnifier: the pixels about the mouse as squares, with their values, and as a grid of numbers.

It shows the picture as developed, without overlays. Its own colours do not follow the theme, because those of the
picture do not.
"""

import math

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from lensbench.app.display.frame import Light, View
from lensbench.app.state.picture import tone
from lensbench.app.widgets import theme
from lensbench.kernels.figures import significant, true_minus

STEPS = ((23, 15, 0.62), (15, 11, 1.0), (9, 7, 1.7), (5, 5, 3.5))      # pixels across and down, em a pixel
NUMBERED = 3.0                  # em: from this size on a pixel holds its numbers
USUAL = 2                       # the step that the magnifier begins with
GAP = 1.4                       # em from the mouse
PLATE, WORDS = (0.07, 0.07, 0.07, 0.94), (0.86, 0.86, 0.86, 1.0)
RGB = ((0.98, 0.55, 0.50, 1.0), (0.55, 0.88, 0.55, 1.0), (0.58, 0.72, 1.0, 1.0))
DARK_RGB = ((0.55, 0.0, 0.0, 1.0), (0.0, 0.32, 0.0, 1.0), (0.0, 0.0, 0.60, 1.0))       # on bright pixels


def toggle_magnifier(view: View) -> None:
    """Switch the magnifier on or off."""
    view.magnifier = 0 if view.magnifier else USUAL


def cells(values: NDArray[np.float32], x: int, y: int, across: int, down: int) -> NDArray[np.float64]:
    """Pixels (down, across, 3) of a picture (h, w, 3) about column x and row y; NaN beyond its edges."""
    height, width = values.shape[:2]
    found = np.full((down, across, 3), np.nan)
    rows, columns = y - down // 2 + np.arange(down), x - across // 2 + np.arange(across)
    inside = np.ix_((rows >= 0) & (rows < height), (columns >= 0) & (columns < width))
    found[inside] = values[np.ix_(rows[(rows >= 0) & (rows < height)], columns[(columns >= 0) & (columns < width)])]
    return found


def codes(light: Light, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (..., 3) as the screen shows them: sRGB in [0, 1]."""
    if light.tone == "difference":
        return tone.srgb(np.clip(values / light.scale, 0.0, 1.0))
    return tone.develop(values, light.exposure, light.tone, light.sensor)


def draw_magnifier(draw: imgui.ImDrawList, light: Light, at: tuple[float, float], step: int,
                   panel: tuple[ImVec2, ImVec2]) -> None:
    """Draw it beside the mouse, within the corners of the panel. at: the mouse, as parts of width and height."""
    height, width = light.values.shape[:2]
    x, y = min(int(at[0] * width), width - 1), min(int(at[1] * height), height - 1)
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
    numbers = [round(255.0 * float(part)) for part in code]
    light = "  ".join(_number(float(part)) for part in value)
    return f"{x}, {y}   #{numbers[0]:02x}{numbers[1]:02x}{numbers[2]:02x}", f"linear  {light}"


def _numbers(draw: imgui.ImDrawList, corner: ImVec2, side: int, value: NDArray[np.float64], bright: bool) -> None:
    """Red, green and blue of a pixel, one below the other, in its square."""
    line = imgui.get_text_line_height()
    top = corner.y + 0.5 * (side - 3.0 * line)
    for i, (part, tint) in enumerate(zip(value, DARK_RGB if bright else RGB, strict=True)):
        text = _number(float(part))
        x = corner.x + 0.5 * (side - imgui.calc_text_size(text).x)
        draw.add_text(ImVec2(math.floor(x), math.floor(top + i * line)), theme.packed(tint), text)


def _number(value: float) -> str:
    return true_minus(significant(value, 3 if value < 9.995 else 4))
