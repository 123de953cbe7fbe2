"""The circle of confusion against distance: ideal thin lens, thick lens and the real one, traced.

Distances are measured from the film, those of a camera without a prescription from its ideal lens, and shown in metres;
diameters on the film in micrometres and, on the right axis, in pixels. The amber line is the plane in focus and can be
dragged.
"""

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.readouts import Readings
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_axes import (
    AXIS_FLAGS, PLOT_FLAGS, Paths, PlotMap, crosses, dashed_line, log_ticks, pieces, polyline, simplified, text
)
from lensbench.app.drawing.recorded import Memo, Recorded
from lensbench.app.plots.blur import Curves, curves, main_curve, plot_range
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number
from lensbench.core.text import significant

BESIDE = 10.0                   # em beside the plot: figures and titles of its axes
NEAR_END = 0.7                  # of the plot's width: with the focus beyond it, lines have their names at the left
THIN, THICK = (1.5, 3.0), (6.0, 3.0)             # dashes and gaps, pixels


@dataclass
class CocState:
    """State of the panel between frames: limits of its plot, and the dragged line."""

    fitted_to: tuple = ()
    fit: bool = False
    y0: float = 1.0
    y1: float = 1000.0
    grip: float = 0.0           # pixels from the mouse to the line while it is dragged
    paths: Memo = field(default_factory=lambda: Memo(4))   # the curves in pixels
    drawing: Recorded = field(default_factory=Recorded)


def circle_of_confusion_panel(settings: Settings, state: CocState, links: Pointed | None = None,
                              other: Settings | None = None) -> Settings:
    """Draw the plot in the rest of the window; returns the settings with the dragged focus.

    links: what the mouse points at in all panels; distance and blur of its pixel are marked. other: the
    settings A, while they are compared.
    """
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return settings
    got = readings(settings)
    try:
        low, high, bottom, top = plot_range(got)
        shown = curves(settings.optics, low, high)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return settings

    key = (settings.lens, settings.focal_length, settings.has_lens, low, high, top, size.x, size.y)
    refit = state.fit or state.fitted_to != key
    state.fitted_to, state.fit = key, False
    corner = imgui.get_cursor_screen_pos()
    theme.small()
    plot = None
    if implot.begin_plot("Circle of confusion plot", size, PLOT_FLAGS):
        _set_axes(size, (low, high, bottom, top), settings.film.pitch * 1000.0, refit, state)
        plot = PlotMap.current(log=True)
        state.y0, state.y1 = 10.0**plot.y0, 10.0**plot.y1
        implot.push_plot_clip_rect()
        paths = state.paths.of((shown, plot), partial(_paths, shown, plot))
        state.drawing.draw(implot.get_plot_draw_list(), (paths, settings.optics),
                           partial(_draw, plot=plot, settings=settings, got=got, shown=shown, paths=paths))
        if other is not None:
            _draw_other(implot.get_plot_draw_list(), plot, other, low, high)
        if links is not None:
            _draw_pixel(implot.get_plot_draw_list(), plot, settings, links)
        implot.pop_plot_clip_rect()
        if implot.is_plot_hovered():
            state.fit = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
            _tooltip(plot, settings, shown)
        implot.end_plot()
    imgui.pop_font()
    if plot is not None and plot.bottom > plot.top:
        settings = _dragged(settings, got, plot, state)
    imgui.set_cursor_screen_pos(corner)
    imgui.dummy(size)
    return settings


def _set_axes(size: ImVec2, ranges: tuple[float, float, float, float], pitch: float, refit: bool,
              state: CocState) -> None:
    low, high, bottom, top = ranges
    x, y, pixels = implot.ImAxis_.x1, implot.ImAxis_.y1, implot.ImAxis_.y2
    roomy = size.x > theme.em(13) and size.y > theme.em(10)
    implot.setup_axis(x, "Distance (m)" if roomy else None, AXIS_FLAGS)
    implot.setup_axis(y, "Circle of confusion (µm)" if roomy else None, AXIS_FLAGS)
    implot.setup_axis(pixels, "px" if roomy else None, AXIS_FLAGS | implot.AxisFlags_.aux_default
                      | implot.AxisFlags_.lock)
    for axis in (x, y, pixels):
        implot.setup_axis_scale(axis, implot.Scale_.log10)
    condition = implot.Cond_.always if refit else implot.Cond_.once
    implot.setup_axis_limits(x, low, high, condition)
    implot.setup_axis_limits(y, bottom, top, condition)
    if refit:
        state.y0, state.y1 = bottom, top
    implot.setup_axis_limits(pixels, state.y0 / pitch, state.y1 / pitch, implot.Cond_.always)
    implot.setup_axis_limits_constraints(x, 1e-3, 1e5)
    implot.setup_axis_limits_constraints(y, 1e-3, 1e6)
    line = imgui.get_text_line_height()
    across = min(0.75 * size.x, max(size.x - theme.em(BESIDE), 0.4 * size.x))
    for axis, ends, length, room in (
            (x, (1e-3, 1e5), across / math.log10(high / low), 2.3 * line),
            (y, (state.y0, state.y1), (0.75 * size.y) / math.log10(top / bottom), 1.6 * line),
            (pixels, (state.y0 / pitch, state.y1 / pitch), (0.75 * size.y) / math.log10(top / bottom), 3.0 * line)):
        decades = math.log10(ends[1] / ends[0])
        values, labels = log_ticks(*ends, length * decades, room)
        implot.setup_axis_ticks(axis, values, labels, False)


def _draw(draw: imgui.ImDrawList, plot: PlotMap, settings: Settings, got: Readings, shown: Curves,
          paths: Paths) -> None:
    colour, pixel, line = theme.colours(), theme.scale(), imgui.get_text_line_height()
    limit, pitch = 1000.0 * (got.limit or 0.0), 1000.0 * settings.film.pitch
    right = plot.right - 3.0 * pixel

    # Depth of field, in amber
    if got.near_limit is not None and got.far_limit is not None:
        near = max(plot.at(got.near_limit / 1000.0, 1.0).x, plot.left)
        far = min(plot.at(min(got.far_limit, 1e9) / 1000.0, 1.0).x, plot.right)
        draw.add_rect_filled(ImVec2(near, plot.top), ImVec2(max(far, near + pixel), plot.bottom),
                             theme.packed(colour.amber, 0.16))

    # Lines across: limit, pixel, Airy disk; and the hyperfocal distance
    across = [(limit, f"limit {significant(limit, 3)} µm", 5.0, 4.0), (pitch, "pixel", 1.5, 3.0)]
    if abs(math.log(max(limit, 1e-9) / pitch)) < 1e-6:
        across = [(limit, f"limit 1 px, {significant(limit, 3)} µm", 5.0, 4.0)]
    if got.airy is not None:
        across.append((1000.0 * got.airy, "Airy", 1.5, 3.0))
    rows = [math.floor(plot.at(1.0, value).y) + 0.5 for value, *_ in across]
    for y, (_, _, on, off) in zip(rows, across, strict=True):
        dashed_line(draw, ImVec2(plot.left, y), ImVec2(plot.right, y), theme.packed(colour.dim, 0.8), on, off)
    column, focus = _focus_column(settings, plot), format_distance(settings.focus_distance)
    taken: list[tuple[float, float, float]] = []            # top, bottom and right end of each text
    hyperfocal = None
    if got.hyperfocal is not None:
        x = math.floor(plot.at(got.hyperfocal / 1000.0, 1.0).x) + 0.5
        dashed_line(draw, ImVec2(x, plot.bottom), ImVec2(x, plot.top), theme.packed(colour.faint), 1.5, 4.0)
        for name in (f"hyperfocal {format_distance(got.hyperfocal)}", "hyperfocal"):
            left = x - 4.0 * pixel - imgui.calc_text_size(name).x
            if x < plot.right and not left - 8.0 * pixel < column < x and left > plot.left:
                top = _clear_row(plot, paths, left, x)
                if top is not None:
                    hyperfocal = (ImVec2(left, top), name)
                    taken.append((top, top + line, x + 4.0 * pixel))
                    break

    # Curves
    assert got.f_number is not None
    for tone, weight, strokes in _strokes(shown, paths, pixel):
        packed = theme.packed(getattr(colour, tone))
        for stroke in strokes:
            draw.add_polyline(stroke, packed, weight * pixel, imgui.ImDrawFlags_.none)
    if hyperfocal is not None:
        text(draw, hyperfocal[0], colour.dim, hyperfocal[1], plate=True)

    # Names at the ends of the lines away from the focus; the first have priority
    taken += _name_models(draw, plot, shown, column)
    far = column > plot.left + NEAR_END * (plot.right - plot.left)
    if far:
        taken = [(top, bottom, plot.right) for top, bottom, _ in taken]
    labels = [Name(np.array([[plot.left, y], [plot.right, y]]), name, colour.dim, name == "pixel" and pitch > limit)
              for y, (_, name, *_) in zip(rows, across, strict=True)]
    curves_ = [(main_curve(shown), got.f_number, colour.strong)]
    curves_ += [(diameters, f_number, colour.dim) for f_number, diameters in shown.neighbours]
    if far:
        _name_ends(draw, plot, plot.left + 3.0 * pixel, labels, paths, taken, right=False)
        _name_flanks(draw, plot, shown.distances, [(d, format_f_number(n), tint) for d, n, tint in curves_])
    else:
        ends = [paths.pixels[0], *paths.pixels[len(paths.pixels) - len(shown.neighbours):]]
        named = [Name(path, format_f_number(n), tint, path[-1, 1] < ends[0][-1, 1] - 1.0)
                 for path, (_, n, tint) in zip(ends, curves_, strict=True)]
        _name_ends(draw, plot, right, named[:1] + labels + named[1:], paths, taken)

    # The plane in focus
    x = column
    draw.add_rect_filled(ImVec2(x - pixel, plot.top), ImVec2(x + pixel, plot.bottom), theme.packed(colour.amber))
    leftward = x + imgui.calc_text_size(focus).x + 8.0 * pixel > plot.right
    text(draw, ImVec2(x + (-6.0 if leftward else 6.0) * pixel, plot.top + 3.0 * pixel), colour.amber_text, focus,
         right=leftward, plate=True)
    for edge in (got.near_limit, got.far_limit):
        if edge is not None and math.isfinite(edge) and limit > 0.0:
            draw.add_circle_filled(plot.at(edge / 1000.0, limit), 2.5 * pixel, theme.packed(colour.amber))


def _drawn(shown: Curves) -> list[np.ndarray]:
    """All curves, in the order of their paths: the main one first."""
    chief = main_curve(shown)
    others = [curve for curve in (shown.thick, shown.thin) if curve is not None and curve is not chief]
    return [chief, *others, *(diameters for _, diameters in shown.neighbours)]


def _paths(shown: Curves, plot: PlotMap) -> Paths:
    return Paths(plot.pixels(shown.distances, np.array(_drawn(shown))))


@dataclass(frozen=True, eq=False)
class Name:
    """A name at the end of a line: points (n, 2) of the line in pixels, and on which side of it the name is better."""

    path: np.ndarray
    text: str
    colour: theme.Colour
    above: bool


def _clear_row(plot: PlotMap, paths: Paths, left: float, right: float) -> float | None:
    """The upper edge of the first row of text, from the second on, that no curve crosses; None without such a row."""
    line, pixel = imgui.get_text_line_height(), theme.scale()
    crossing = paths.heights(left, right)
    rows = [plot.top + k * line + 3.0 * pixel for k in (1, 2, 3, 4, 5, 6)]
    return next((top for top in rows if not crosses(crossing, top, top + line)), None)


def _strokes(shown: Curves, paths: Paths, pixel: float) -> list[tuple[str, float, list[list[ImVec2]]]]:
    """Colour, weight and pieces of every curve: other stops faint, thin in dots, thick in dashes, the main one full."""
    found = []
    for curve, path in zip(_drawn(shown)[1:], paths.pixels[1:], strict=True):
        if curve is shown.thin or curve is shown.thick:
            on, off = THIN if curve is shown.thin else THICK
            found.append(("text", 1.0, pieces(simplified(path), on * pixel, off * pixel)))
        else:
            found.insert(0, ("faint", 1.0, pieces(simplified(path))))
    found.append(("strong", 2.0, pieces(simplified(paths.pixels[0]))))
    return found


def _name_ends(draw: imgui.ImDrawList, plot: PlotMap, end: float, names: list[Name], paths: Paths,
               taken: list, right: bool = True) -> None:
    """Names at an end of their lines; one that would touch another or lie on a curve of `paths` is left out."""
    line, pixel = imgui.get_text_line_height(), theme.scale()
    for name in names:
        width = imgui.calc_text_size(name.text).x
        left = end - width if right else end
        (least, greatest), = Paths(name.path[None]).heights(left, left + width)
        over, under, crossing = least - line - pixel, greatest + pixel, paths.heights(left, left + width)
        for top in (over, under) if name.above else (under, over):
            clear = all(top + line <= t or top >= b or left >= r for t, b, r in taken)
            if clear and plot.top <= top and top + line <= plot.bottom \
                    and not crosses(crossing, top + 2.0 * pixel, top + line - pixel):
                text(draw, ImVec2(end, top), name.colour, name.text, right=right, plate=True)
                taken = [*taken, (top, top + line, plot.right)]
                break


def _name_flanks(draw: imgui.ImDrawList, plot: PlotMap, distances: np.ndarray, labels: list) -> None:
    """Names (diameters, text, colour) to the right of curves that fall, in one row at a third of the height.

    One that would touch the name before it is left out.
    """
    pixel, line = theme.scale(), imgui.get_text_line_height()
    y = plot.top + 0.36 * (plot.bottom - plot.top)
    value = 10.0 ** (plot.y0 + (plot.bottom - y) / (plot.bottom - plot.top) * (plot.y1 - plot.y0))
    taken: list[tuple[float, float]] = []
    for diameters, name, colour in labels:
        below = np.flatnonzero(diameters < value)
        if not below.size or below[0] == 0:
            continue
        left = plot.at(distances[below[0]], value).x + 3.0 * pixel
        end = left + imgui.calc_text_size(name).x
        if end < plot.right and all(end + 4.0 * pixel < a or left > b + 4.0 * pixel for a, b in taken):
            text(draw, ImVec2(left, y - 0.5 * line), colour, name, plate=True)
            taken.append((left, end))


def _name_models(draw: imgui.ImDrawList, plot: PlotMap, shown: Curves, focus: float) -> list:
    """The legend of the strokes, in the lower corner beside the focus line; returns the space that it takes."""
    pixel, line = theme.scale(), imgui.get_text_line_height()
    if shown.thick is None or plot.bottom - plot.top < 9.0 * line:
        return []
    rows = [("thick", THICK, shown.real is None), ("thin", THIN, False)]
    if shown.real is not None:
        rows.insert(0, ("real", (0.0, 0.0), True))
    colour = theme.colours()
    x = plot.left + 5.0 * pixel if focus - plot.left > 50.0 * pixel else focus + 8.0 * pixel
    y = plot.bottom - (len(rows) + 0.3) * line
    wide = x + 24.0 * pixel + imgui.calc_text_size("thick").x
    draw.add_rect_filled(ImVec2(x - 3.0 * pixel, y), ImVec2(wide, y + len(rows) * line),
                         theme.packed(colour.well, 0.85), 2.0 * pixel)
    for name, (on, off), strong in rows:
        middle = math.floor(y + 0.5 * line) + 0.5
        ends = ImVec2(x, middle), ImVec2(x + 14.0 * pixel, middle)
        if strong:
            draw.add_line(*ends, theme.packed(colour.strong), 2.0 * pixel)
        else:
            dashed_line(draw, *ends, theme.packed(colour.text), on, off)
        text(draw, ImVec2(x + 19.0 * pixel, y), colour.dim, name)
        y += line
    return [(plot.bottom - (len(rows) + 0.1) * line, plot.bottom, wide)]


def _draw_other(draw: imgui.ImDrawList, plot: PlotMap, other: Settings, low: float, high: float) -> None:
    """The curve of the settings A."""
    try:
        shown = curves(other.optics, low, high)
    except (ValueError, OSError):               # A has no circle of confusion
        return
    points = plot.pixels(shown.distances, main_curve(shown))
    polyline(draw, points, theme.packed(theme.compared()), 1.5)
    inside = np.flatnonzero((points[:, 1] > plot.top + theme.em(1.2)) & (points[:, 1] < plot.bottom - theme.em(1.2)))
    if inside.size:
        x, y = points[inside[0]]
        text(draw, ImVec2(x + 3.0 * theme.scale(), y - 0.5 * imgui.get_text_line_height()), theme.compared(), "A",
             plate=True)


def _draw_pixel(draw: imgui.ImDrawList, plot: PlotMap, settings: Settings, links: Pointed) -> None:
    """A ring at the distance and the blur of what the pointed pixel shows."""
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is None:
        return
    try:
        got = pixel_readings(settings, raster)
    except (ValueError, OSError):               # the panel “Pixel” says why
        return
    if got.diameter is None or not got.ahead > 0.0:
        return
    at = plot.at(min(got.ahead, 1e12) / 1000.0, 1000.0 * got.diameter)
    x = min(max(at.x, plot.left + 4.0 * theme.scale()), plot.right - 4.0 * theme.scale())
    draw.add_circle(ImVec2(x, at.y), 5.0 * theme.scale(), theme.packed(theme.colours().strong), 0, 2.0 * theme.scale())


def _focus_column(settings: Settings, plot: PlotMap) -> float:
    """The column of the focus line: at the right edge for infinity."""
    x = plot.at(min(settings.focus_distance, 1e12) / 1000.0, 1.0).x
    return math.floor(min(max(x, plot.left + 1.0), plot.right - 1.0))


def _dragged(settings: Settings, got: Readings, plot: PlotMap, state: CocState) -> Settings:
    """The focus line as an item over the plot; beyond the right edge lies infinity."""
    x, half = _focus_column(settings, plot), 5.0 * theme.scale()
    imgui.set_cursor_screen_pos(ImVec2(x - half, plot.top))
    imgui.invisible_button("Focus line", ImVec2(2.0 * half, plot.bottom - plot.top))
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        if not imgui.is_item_active():
            imgui.set_item_tooltip("Plane in focus: drag to focus")
    mouse = imgui.get_mouse_pos().x
    if imgui.is_item_activated():
        state.grip = x - mouse
    elif imgui.is_item_active() and imgui.get_io().mouse_delta.x != 0.0:
        column = mouse + state.grip
        focus = math.inf if column >= plot.right - 1.0 else 1000.0 * plot.x_at(column)
        nearest = got.nearest_focus if got.nearest_focus is not None else 1.01 * (got.efl or 0.0)
        return replace(settings, focus_distance=max(focus, nearest))
    return settings


def _tooltip(plot: PlotMap, settings: Settings, shown: Curves) -> None:
    """The numbers under the cursor."""
    distance = plot.x_at(imgui.get_mouse_pos().x)
    if not shown.distances[0] <= distance <= shown.distances[-1] or imgui.is_mouse_down(imgui.MouseButton_.left):
        return
    pitch = 1000.0 * settings.film.pitch
    if imgui.begin_tooltip():
        imgui.text_unformatted(f"{format_distance(1000.0 * distance)} from {settings.kind.measured_from}")
        for name, diameters in (("real", shown.real), ("thick", shown.thick), ("thin", shown.thin)):
            if diameters is not None:
                value = float(np.exp(np.interp(math.log(distance), np.log(shown.distances), np.log(diameters))))
                imgui.text_disabled(f"{name} lens  {significant(value, 3)} µm  {significant(value / pitch, 2)} px")
        imgui.end_tooltip()
