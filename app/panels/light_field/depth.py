"""The depth of a light field in the panel *Light field*: estimated, shown and read."""

import math
from dataclasses import replace

import numpy as np
from imgui_bundle import ImVec2, icons_fontawesome_6, imgui

import lensbench as lb
from lensbench.app.panels.light_field.capture_settings import Form
from lensbench.app.panels.light_field.pupil_pad import figures
from lensbench.app.state.constraints import MARGIN
from lensbench.app.state.light_field_query import DEEP, Look, Recording
from lensbench.app.state.picture.false_colours import colour, ends
from lensbench.app.state.request import Request
from lensbench.app.state.text_values import format_distance
from lensbench.app.widgets import theme
from lensbench.app.widgets.paragraph import paragraph
from lensbench.app.widgets.toggles import toggles
from lensbench.app.workers.light_field_worker import LightFieldWorker
from lensbench.kernels.figures import fixed

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
    found = worker.found
    if found is None:
        paragraph("Nearer objects shift more between the views. From this parallax the depth follows.")
        imgui.begin_disabled(worker.task is not None)
        if imgui.button(fa.ICON_FA_MAGNIFYING_GLASS + "  Find the depth###Find the depth"):
            form.requests.add(Request.FIND_DEPTH)
        imgui.end_disabled()
        return look
    look = replace(look, deep=toggles("Depth picture", DEEP, look.deep, DEEP_TIPS, 0.0))
    _scale(found)
    x, y = look.pixel
    distance, sure = float(found.distance[y, x]), float(found.confidence[y, x])
    figures((
        ("Pixel", f"{x}, {y}", "Click in the picture to choose another, across and down"),
        ("Depth", format_distance(distance), "Distance of the object in this pixel, measured as the focus distance is"),
        ("Error", f"± {format_distance(float(found.error[y, x]))}",
         "Of this depth, for most sure pixels: 0.3 of a pixel of the outermost views"),
        ("Sure", f"{fixed(100.0 * sure, 0)} %", "0 %: the views agree at any distance; 100 %: only at this one")))
    if imgui.button("Focus there"):
        look = replace(look, show="focus", distance=max(distance, recording.nearest * MARGIN))
    imgui.set_item_tooltip("Focus the light field at this pixel's depth")
    return look


def _scale(found: lb.Depth) -> None:
    """The scale of the colours, linear in the reciprocal distance, which is the parallax."""
    far, near = ends(found)
    corner, pixel = imgui.get_cursor_screen_pos(), theme.scale()
    width, bar = imgui.get_content_region_avail().x, round(theme.em(0.7))
    draw = imgui.get_window_draw_list()
    edges = [round(corner.x + i * width / STEPS) for i in range(STEPS + 1)]
    for i, code in enumerate(colour(1.0 - (np.arange(STEPS) + 0.5) / STEPS).tolist()):
        draw.add_rect_filled(ImVec2(edges[i], corner.y), ImVec2(edges[i + 1], corner.y + bar),
                             theme.packed((*code, 1.0)))
    theme.small()
    line = imgui.get_text_line_height()
    for part in (0.0, 0.25, 0.5, 0.75, 1.0):
        reciprocal = (1.0 - part) / near + part / far
        text = format_distance(1.0 / reciprocal if reciprocal > 0.0 else math.inf)
        extent = imgui.calc_text_size(text).x
        x = min(max(corner.x + part * width - 0.5 * extent, corner.x), corner.x + width - extent)
        draw.add_text(ImVec2(round(x), corner.y + bar + 2.0 * pixel), theme.packed(theme.colours().dim), text)
    imgui.dummy(ImVec2(width, bar + line + 4.0 * pixel))
    imgui.pop_font()
