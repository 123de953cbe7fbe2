"""The status bar: camera model, samples, speed, and the pixel under the mouse."""

import math

from imgui_bundle import ImVec2, hello_imgui, imgui

from lensbench.app.bench.auto_model import choice_details, choice_summary
from lensbench.app.bench.build import design
from lensbench.app.display.frame import View
from lensbench.app.drawing import theme
from lensbench.app.panels.controls.controls import lens_name
from lensbench.app.panels.snapshots import task_progress
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.app.workers.task import Task
from lensbench.core.text import fixed, significant


def status_bar(settings: Settings, update: RenderUpdate | None, view: View, drawn_by: str = "",
               exporting: Task | None = None) -> None:
    """Draw into the bar that hello_imgui has begun.

    drawn_by: the software renderer; "": a graphics card draws. exporting: the export under way.
    """
    colour, dot = theme.colours(), theme.em(0.9)
    theme.small()
    corner = imgui.get_cursor_screen_pos()
    width = imgui.get_window_width()
    window = imgui.get_window_pos()
    y = window.y + round(0.5 * (imgui.get_window_height() - imgui.get_text_line_height()))
    draw = imgui.get_window_draw_list()

    # From the right: the lens, and the pixel under the mouse
    left, right = window.x + theme.em(0.78), window.x + width - theme.em(0.9)
    if exporting is not None:
        imgui.set_cursor_screen_pos(ImVec2(left, y - imgui.get_style().frame_padding.y))
        task_progress(exporting, min(theme.em(26.0), 0.5 * width))
        left += min(theme.em(26.0), 0.5 * width) + dot
    summary = choice_summary(update.choice, update.speeds) if update is not None and update.choice is not None else []
    parts = [summary[0] if summary else settings.camera_title, *_progress(update, drawn_by)]
    separator = 2.0 * dot + imgui.calc_text_size("·").x
    needed = sum(imgui.calc_text_size(text).x for text in parts) + separator * len(parts)
    texts = [_lens(settings)]
    raster = view.links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is not None and update is not None and update.depth is not None:
        texts.append(_pointed(settings, raster, update, view.links.pinned is not None))
    for text in filter(None, texts):
        extent = imgui.calc_text_size(text).x
        if right - extent < left + needed:
            break
        right -= extent
        draw.add_text(ImVec2(round(right), y), theme.packed(colour.dim), text)
        right -= 3.0 * dot

    # From the left: model, samples, speed; of an automatic model also its error, its gain and the refused models
    x = left
    for i, text in enumerate([*parts, *summary[1:]]):
        if i:
            if right - x < separator + theme.em(3.0):
                break
            draw.add_text(ImVec2(round(x + dot), y), theme.packed(colour.faint), "·")
            x += separator
        text = theme.shortened(text, right - x)
        draw.add_text(ImVec2(round(x), y), theme.packed(colour.strong if i == 0 else colour.dim), text)
        x += imgui.calc_text_size(text).x
    if summary:
        imgui.set_cursor_screen_pos(ImVec2(left, y))
        imgui.invisible_button("Automatic model", ImVec2(x - left, imgui.get_text_line_height()))
        assert update is not None
        imgui.set_item_tooltip(choice_details(update.choice, update.speeds))
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(ImVec2(1.0, imgui.get_text_line_height()))
    imgui.pop_font()


def _progress(update: RenderUpdate | None, drawn_by: str) -> list[str]:
    """Samples and speeds."""
    frames = f"{fixed(hello_imgui.frame_rate(), 0)} fps" + (f" by {drawn_by}" if drawn_by else "")
    if update is None:
        return [frames]
    samples = f"{update.samples} sample{'s' if update.samples > 1 else ''}"
    return [samples, *([speed_text(update.rate)] if update.rate > 0.0 else []), frames]


def speed_text(rate: float) -> str:
    """A rate of samples a second: 0.043, 4.2 or 134 Msamples/s."""
    millions = rate / 1e6
    return f"{fixed(millions, 0) if millions >= 9.95 else significant(millions, 2)} Msamples/s"


def _lens(settings: Settings) -> str:
    if not settings.has_lens:
        return ""
    try:
        surfaces = len(design(settings).surfaces)
    except (ValueError, OSError):
        return lens_name(settings)
    return f"{lens_name(settings)}: {surfaces} surfaces"


def _pointed(settings: Settings, raster: tuple[float, float], update: RenderUpdate, pinned: bool) -> str:
    """The pixel under the mouse, or the pinned one: the distance and the blur of what it shows."""
    assert update.depth is not None
    x, y = int(raster[0]), int(raster[1])
    rows, columns = update.depth.shape
    if (columns, rows) != (settings.pixels_x, settings.pixels_y):       # a coarse picture of a drag
        return ""
    if not (0 <= y < rows and 0 <= x < columns):
        return ""
    depth = float(update.depth[y, x])
    where = f"{'Pinned ' if pinned else ''}({x}, {y})  {'no light' if math.isnan(depth) else format_distance(depth)}"
    try:
        blur = pixel_readings(settings, raster).pixels
    except (ValueError, OSError):               # the panel “Pixel” says why
        return where
    return where if blur is None else f"{where}  CoC {significant(blur, 2)} px"
