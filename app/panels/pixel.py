"""The pixel under the mouse, or the pinned one: the spot of what it shows, on the film, and its figures in words.

The spot is drawn upright, as the picture shows it, in µm from the middle of the pixel. The square is the pixel, the
circle the circle of confusion. A point under the mouse is a ray, which the section and the exit pupil show.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from imgui_bundle import ImVec2, imgui, implot
from numpy.typing import NDArray

from lensbench.app.bench import tone
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, linear_ticks, text
from lensbench.app.drawing.recorded import Memo
from lensbench.app.plots.pixel_rays import Place, Pointed, PointedRay, film_place, landing
from lensbench.app.plots.pixel_spot import PixelReadings, Spot, colour_of, pixel_readings, spot
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import fixed, significant, true_minus

NOTHING = "Point at the picture: this panel shows how the pixel under the mouse comes about. " \
          "I, or Alt+click, pins the pixel; Escape unpins it"
STEPS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)    # half the plot is one of these × 10ⁿ µm: it rests as the mouse moves
NEAR = 7.0                      # screen pixels from the mouse to a point of the spot
LABEL = 4.4                     # em, the column of names


@dataclass
class PixelState:
    """State of the panel between frames."""

    memo: Memo = field(default_factory=lambda: Memo(4))    # the spot in screen pixels
    shape: tuple[float, float] = (1.0, 1.0)                 # screen pixels of the plot, across and down
    places: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))    # of the drawn spot on the screen


def pixel_panel(settings: Settings, links: Pointed, image: NDArray[np.float32] | None, state: PixelState) -> None:
    """Draw the panel in the rest of the window; the ray of a point of the spot under the mouse is set in `links`.

    image: (h, w, 3), linear light of the picture.
    """
    size = imgui.get_content_region_avail()
    state.places = np.zeros((0, 2))
    if size.x < 60.0 or size.y < 60.0:
        return
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is None:
        paragraph(NOTHING)
        return
    try:
        got = pixel_readings(settings, raster)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return
    theme.small()
    table = rows(got, colour_of(image, raster), links.pinned is not None)
    below = len(table) * _pitch()
    room = ImVec2(size.x, size.y - below - theme.em(0.6))
    found = None
    if room.y > theme.em(4.0):
        try:
            found = spot(settings, raster)
        except (ValueError, OSError) as error:
            paragraph(str(error))
    if found is not None:
        chosen = _plot(settings, got, film_place(settings, raster), found, room, links.surfaces, state)
        if chosen is not None:
            links.point_at_ray(_ray(settings, found, chosen))
    _table(table)
    imgui.pop_font()


def _ray(settings: Settings, found: Spot, i: int) -> PointedRay:
    """A ray of the spot, and where it comes from."""
    there = landing(settings, found.paths[i])
    return PointedRay(found.paths[i], -1, there.text, there.point, there.raster)


# The spot


def _plot(settings: Settings, got: PixelReadings, at: Place, found: Spot, size: ImVec2, lit: tuple[int, ...],
          state: PixelState) -> int | None:
    """Draw the spot; returns the index of the ray under the mouse.

    at: the middle of the pixel on the film (mm). lit: surfaces whose lost rays are counted.
    """
    film, chosen = settings.film, None
    pitch = 1000.0 * np.array([film.width / film.pixels_x, film.height / film.pixels_y])
    away = 1000.0 * (np.asarray(at) - found.landings)             # the picture is the film turned by 180°
    reach = max(1.05 * float(np.abs(away).max()), 550.0 * (got.diameter or 0.0), float(pitch.max()))
    decade = 10.0 ** math.floor(math.log10(reach))
    half = decade * next(step for step in STEPS if decade * step >= 0.999 * reach)
    if not implot.begin_plot("Spot plot", size, PLOT_FLAGS):
        return None
    roomy = size.x > theme.em(13) and size.y > theme.em(9)
    implot.setup_axes("µm" if roomy else "", "µm" if roomy else "", AXIS_FLAGS | implot.AxisFlags_.lock,
                      AXIS_FLAGS | implot.AxisFlags_.lock)
    wide, high = (half * side / min(state.shape) for side in state.shape)
    implot.setup_axes_limits(-wide, wide, -high, high, implot.Cond_.always)
    for axis, end, side, room in ((implot.ImAxis_.x1, wide, size.x, 3.4), (implot.ImAxis_.y1, high, size.y, 1.4)):
        implot.setup_axis_ticks(axis, *linear_ticks(-end, end, 0.8 * side, room * imgui.get_text_line_height()), False)
    implot.setup_finish()
    plot = PlotMap.current(log=False)
    state.shape = max(plot.right - plot.left, 1.0), max(plot.bottom - plot.top, 1.0)
    draw, colour, pixel = implot.get_plot_draw_list(), theme.colours(), theme.scale()
    implot.push_plot_clip_rect()
    a, b = plot.at(*(-0.5 * pitch)), plot.at(*(0.5 * pitch))
    draw.add_rect(ImVec2(a.x, b.y), ImVec2(b.x, a.y), theme.packed(colour.text), 0.0, 1.5 * pixel)
    points = state.memo.of((found, plot), lambda: plot.pixels(*away.T))
    dot, r = theme.packed(colour.field0, 0.85), 1.1 * pixel
    for x, y in points.tolist():
        draw.add_rect_filled(ImVec2(x - r, y - r), ImVec2(x + r, y + r), dot)
    state.places = points
    if got.diameter is not None:
        centre = 1000.0 * (np.asarray(at) - found.centroid)
        radius = plot.at(500.0 * got.diameter, 0.0).x - plot.at(0.0, 0.0).x
        draw.add_circle(plot.at(*centre), radius, theme.packed(colour.amber), 0, 1.5 * pixel)
    mouse = imgui.get_mouse_pos()
    if implot.is_plot_hovered():
        distance = np.hypot(*(points - [mouse.x, mouse.y]).T)
        if distance.min() < NEAR * pixel:
            chosen = int(distance.argmin())
            x, y = points[chosen]
            draw.add_circle(ImVec2(x, y), 4.0 * pixel, theme.packed(theme.pointed()), 0, 2.0 * pixel)
    aimed = len(points) + sum(found.lost.values())
    words, ended = f"{len(points)} rays, of a box of {aimed}", sum(found.lost.get(surface, 0) for surface in lit)
    if lit:
        names = " and ".join(map(str, lit))
        words = f"Surface{'s' if len(lit) > 1 else ''} {names}: {ended} of {aimed} rays end there"
    text(draw, ImVec2(plot.left + 4.0 * pixel, plot.top + 2.0 * pixel), colour.warning if ended else colour.dim, words,
         plate=True)
    implot.pop_plot_clip_rect()
    implot.end_plot()
    if chosen is not None and imgui.begin_tooltip():
        x, y = away[chosen]
        imgui.text_unformatted(true_minus(f"x {fixed(x, 1)}, y {fixed(y, 1)} µm from the pixel's middle"))
        imgui.text_disabled("The section and the exit pupil show this ray")
        imgui.end_tooltip()
    return chosen


# The figures


def rows(got: PixelReadings, light: tuple[float, float, float] | None, pinned: bool) -> list[tuple[str, str, str]]:
    """Name, value and meaning of each figure of a pixel."""
    x, y = int(got.raster[0]), int(got.raster[1])
    film = "" if got.film is None else f"   film {fixed(got.film[0], 2)}, {fixed(got.film[1], 2)} mm"
    table = [("Pinned" if pinned else "Pixel", true_minus(f"{x}, {y}{film}"),
              "Column and row, and the point on the film, whose image is upside down"),
             ("Shows", got.thing or "no light", "What the ray through the middle of the pupil meets")]
    distance = "–" if math.isnan(got.ahead) else format_distance(got.ahead)
    if math.isfinite(got.along):
        distance += f"   {format_distance(got.along)} by ray"
    table.append(("Distance", distance, "Along the axis, from where the focus distance is measured; and along the ray"))
    if got.diameter is None or got.pixels is None:
        table.append(("Blur", f"– {got.no_blur}", "Circle of confusion (CoC)"))
    else:
        size = f"{significant(got.diameter, 3)} mm" if got.diameter >= 0.1 else \
            f"{significant(1000.0 * got.diameter, 3)} µm"
        table.append(("Blur", f"{size}   {significant(got.pixels, 2)} px",
                      "Diameter of the circle of confusion (CoC) of what the pixel shows: "
                      + ("2√2 × the rms radius of its real rays" if got.traced else "by the formula of an ideal lens")))
    stops = "dark" if got.light <= 0.0 else true_minus(f"{fixed(math.log2(got.light), 1, signed=True)} EV")
    table.append(("Light", f"{fixed(100.0 * got.light, 0)} % of the axis   {stops}",
                  "On the film, against its centre without vignetting"))
    if got.open is not None:
        table.append(("Pupil", f"{fixed(100.0 * got.open, 0)} % of the axis",
                      "Area of the exit-pupil region against that of the axis: vignetting"))
    if light is not None:
        table.append(("Colour", "  ".join(true_minus(significant(value, 3)) for value in light),
                      "Red, green and blue, linear, as rendered; the swatch is without exposure and tone curve"))
    return table


def _pitch() -> float:
    return round(1.2 * imgui.get_text_line_height())


def _table(table: list[tuple[str, str, str]]) -> None:
    width, colour, draw, line = imgui.get_content_region_avail().x, theme.colours(), imgui.get_window_draw_list(), \
        imgui.get_text_line_height()
    imgui.push_style_var(imgui.StyleVar_.item_spacing, ImVec2(0.0, 0.0))
    for name, value, meaning in table:
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(width, _pitch()))
        if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
            imgui.set_item_tooltip(f"{name}: {meaning}\n{value}")
        y, x = corner.y + math.floor(0.5 * (_pitch() - line)), corner.x + theme.em(LABEL)
        draw.add_text(ImVec2(corner.x, y), theme.packed(colour.dim), name)
        if name == "Colour":
            light = [float(part.replace("−", "-")) for part in value.split()]
            red, green, blue = (float(code) for code in tone.srgb(np.clip(light, 0.0, 1.0)))
            draw.add_rect_filled(ImVec2(x, y + 2.0 * theme.scale()), ImVec2(x + line, y + line),
                                 theme.packed((red, green, blue, 1.0)), 2.0 * theme.scale())
            x += 1.4 * line
        draw.add_text(ImVec2(x, y), theme.packed(colour.strong), theme.shortened(value, corner.x + width - x))
    imgui.pop_style_var()
