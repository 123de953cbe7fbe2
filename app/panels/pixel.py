"""The pixel under the mouse, or the pinned one: the spot of what it shows, on the film, and its values in words.

The spot is drawn upright, as the picture shows it, in µm from the middle of the pixel. The square is the pixel, the
circle the circle of confusion. A point under the mouse is a ray, which the section and the exit pupil show.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from lensbench.app.bench import tone
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_painter import Drawn, draw_plot, drawn_map
from lensbench.app.plots.pixel_rays import Place, Pointed, PointedRay, film_place, landing
from lensbench.app.plots.pixel_spot import PixelReadings, Spot, colour_of, pixel_readings, spot
from lensbench.app.plots.plot import Axis, Curve, Plot, Points, reach
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.text import fixed, significant, true_minus

NOTHING = "Point at the picture: this panel shows how the pixel under the mouse comes about. " \
          "I, or Alt+click, pins the pixel; Escape unpins it"
NAME = "Spot plot"
NEAR = 7.0                      # screen pixels from the mouse to a point of the spot
LABEL = 4.4                     # em, the column of names


@dataclass
class PixelState:
    """State of the panel between frames."""

    drawn: Drawn = field(default_factory=Drawn)
    hovered: bool = False                                   # the plot, in the frame before
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
    beam = None
    if room.y > theme.em(5.2):
        try:
            beam = spot(settings, raster)
        except (ValueError, OSError) as error:
            paragraph(str(error))
    if beam is not None:
        chosen = _plot(settings, got, film_place(settings, raster), beam, room, links.surfaces, state)
        if chosen is not None:
            links.point_at_ray(_ray(settings, beam, chosen))
    _table(table)
    imgui.pop_font()


def _ray(settings: Settings, beam: Spot, i: int) -> PointedRay:
    """A ray of the spot, and where it comes from."""
    end = landing(settings, beam.paths[i])
    return PointedRay(beam.paths[i], -1, end.text, end.point, end.raster)


# The spot


def _plot(settings: Settings, got: PixelReadings, middle: Place, beam: Spot, size: ImVec2, lit: tuple[int, ...],
          state: PixelState) -> int | None:
    """Draw the spot; returns the index of the ray under the mouse.

    middle: of the pixel on the film (mm). lit: surfaces whose lost rays are counted.
    """
    film, chosen = settings.film, None
    pitch = film.width / film.pixels_x, film.height / film.pixels_y
    away = 1000.0 * (np.asarray(middle) - beam.landings)              # the picture is the film turned by 180°
    _count(beam, lit, size.x)
    size = ImVec2(size.x, size.y - imgui.get_text_line_height_with_spacing())
    before = drawn_map(NAME, state.drawn)
    over: tuple[Points, ...] = ()
    if before is not None and state.hovered and len(away):
        mouse, points = imgui.get_mouse_pos(), before.pixels(away[:, 0], away[:, 1])
        distance = np.hypot(*(points - [mouse.x, mouse.y]).T)
        if distance.min() < NEAR * theme.scale():
            chosen = int(distance.argmin())
            over = (Points("", away[[chosen], 0], away[[chosen], 1], "chart1", "ring", size=4.0),)
    under = draw_plot(NAME, spot_plot(beam, middle, pitch, got.diameter), size, state.drawn, over=over)
    state.hovered, shown = under is not None, drawn_map(NAME, state.drawn)
    if shown is not None:
        state.places = shown.pixels(away[:, 0], away[:, 1])
    if chosen is not None and imgui.begin_tooltip():
        x, y = away[chosen]
        imgui.text_unformatted(true_minus(f"x {fixed(x, 1)}, y {fixed(y, 1)} µm from the middle of the pixel"))
        imgui.text_disabled("The section and the exit pupil show this ray")
        imgui.end_tooltip()
    return chosen


@lru_cache(maxsize=4)
def spot_plot(beam: Spot, middle: Place, pitch: tuple[float, float], diameter: float | None) -> Plot:
    """The spot in µm about the middle of the pixel, the pixel, and the circle of confusion.

    middle: of the pixel on the film; pitch: its sides; diameter: of the circle (all mm), or None.
    """
    away = 1000.0 * (np.asarray(middle) - beam.landings)
    half = reach([*np.abs(1.05 * away).ravel(), 550.0 * (diameter or 0.0), 1000.0 * max(pitch)])
    x, y = 500.0 * pitch[0], 500.0 * pitch[1]
    layers: list = [Curve("", np.array([-x, x, x, -x, -x]), np.array([-y, -y, y, y, -y]), "text", weight=1.5),
                    Points("", away[:, 0], away[:, 1], "field0", size=1.1)]
    if diameter is not None:
        turn, centre = np.linspace(0.0, 2.0 * math.pi, 97), 1000.0 * (np.asarray(middle) - beam.centroid)
        layers.append(Curve("", centre[0] + 500.0 * diameter * np.cos(turn),
                            centre[1] + 500.0 * diameter * np.sin(turn), "amber", weight=1.5))
    return Plot(Axis("µm", -half, half), Axis("µm", -half, half), tuple(layers), equal=True)


def _count(beam: Spot, lit: tuple[int, ...], width: float) -> None:
    """How many rays land, above the plot; with surfaces that are lit, how many rays these block."""
    aimed = len(beam.landings) + sum(beam.lost.values())
    words, blocked = f"{len(beam.landings)} of {aimed} rays", sum(beam.lost.get(surface, 0) for surface in lit)
    if lit:
        words = f"Surface{'s' if len(lit) > 1 else ''} {' and '.join(map(str, lit))}: {blocked} of {aimed} rays blocked"
    colour = theme.colours()
    imgui.text_colored(imgui.ImVec4(*(colour.warning if blocked else colour.dim)), theme.shortened(words, width))


# The numbers


def rows(got: PixelReadings, light: tuple[float, float, float] | None, pinned: bool) -> list[tuple[str, str, str]]:
    """Name, value and meaning of each value of a pixel."""
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
            light = [float(number.replace("−", "-")) for number in value.split()]
            red, green, blue = (float(code) for code in tone.srgb(np.clip(light, 0.0, 1.0)))
            draw.add_rect_filled(ImVec2(x, y + 2.0 * theme.scale()), ImVec2(x + line, y + line),
                                 theme.packed((red, green, blue, 1.0)), 2.0 * theme.scale())
            x += 1.4 * line
        draw.add_text(ImVec2(x, y), theme.packed(colour.strong), theme.shortened(value, corner.x + width - x))
    imgui.pop_style_var()
