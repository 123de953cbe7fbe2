"""Falloff and distortion of the real lens at its present focus and stop, over the film radius.

Above, how much light of the axis reaches the film: the natural falloff, cos⁴ over the
pupil, and the vignetting of the rims, whose product is the total. Below, by how much images are too small or too large,
as a curve or as the grid that a square one becomes.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

import lensbench as lb
from lensbench.app.bench.build import Setup, setup
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.tone import round_above
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, pieces, polyline, text
from lensbench.app.panels.analysis.plot_painter import Drawn, draw_figure
from lensbench.app.plots.plot import Figure, Table, light_limit
from lensbench.app.plots.ray_plots import distortion_words, film_distortion, grid_plot
from lensbench.app.plots.reference_plot import with_ghost
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.distortion import Distortion
from lensbench.core.analysis.vignetting import Falloff
from lensbench.core.text import fixed, significant, true_minus

RADII = 49
ACROSS = 16                                     # points across the pupil of a camera without a lens
SLIGHT = 0.01                                   # of the light: a smaller loss is none
SHOWN = {"curve": "Curve", "grid": "Grid"}
TIPS = {"curve": "Distortion in percent of the ideal radius, over the film's radius",
        "grid": "The image of a square grid; the ideal one is faint"}
NATURAL, RIMS = (6.0, 3.0), (1.5, 3.0)          # dashes and gaps, pixels


@dataclass
class FalloffState:
    """Choice of the lower plot, and the state of its grid; not part of the settings."""

    shown: str = "curve"
    grid: Drawn = field(default_factory=Drawn)


EVERY_WAY = "These plots depend on the distance from the film's centre alone. This lens has a cylinder, a toroid " \
            "or surfaces out of line: its falloff and its distortion depend on the direction as well. The panel " \
            "Field curves shows its distortion along both sides of the film, and as a grid"


@dataclass(frozen=True, eq=False)
class Falling:
    """Falloff and distortion of one lens on one film, for radii up to the film's corner."""

    light: Falloff
    shape: Distortion
    grid: Figure


@lru_cache(maxsize=8)
def falling(lens_setup: Setup) -> Falling:
    """Falloff, distortion and grid of a lens; LensError if it has none."""
    radii = np.linspace(0.0, 0.5 * lens_setup.film.diagonal, RADII)
    light = lb.falloff(lens_setup.lens, lens_setup.film_distance, radii)
    plot, *_ = grid_plot(lens_setup)
    grid = Figure("Distortion grid", ((replace(plot, title=""),),), Table((), ()))      # the words above say it
    return Falling(light, film_distortion(lens_setup), grid)


def falloff_panel(settings: Settings, state: FalloffState, other: Settings | None = None) -> None:
    """Draw both plots in the rest of the window.

    other: the settings A, while they are compared: their light and their distortion are drawn too.
    """
    size = imgui.get_content_region_avail()
    if size.x < 60.0 or size.y < 60.0:
        return
    if not settings.has_lens:
        paragraph(without_lens(settings.picture))
        return
    try:
        lens_setup = setup(settings)
        if not lens_setup.lens.is_rotationally_symmetric:
            paragraph(EVERY_WAY)
            return
        found = falling(lens_setup)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return
    theme.small()
    _words(found)
    room = imgui.get_content_region_avail()
    below = imgui.get_frame_height_with_spacing()
    ghost = _ghost(other)
    _light_plot(found.light, ghost, ImVec2(room.x, 0.52 * (room.y - below)))
    state.shown = toggles("Distortion", SHOWN, state.shown, TIPS, 5.6)
    room = imgui.get_content_region_avail()
    if state.shown == "curve":
        _shape_plot(found, ghost, room)
    else:
        draw_figure("Falloff grid", found.grid if ghost is None else _both_grids(found, ghost), room, state.grid,
                    named=False)
    imgui.pop_font()


@lru_cache(maxsize=4)
def _both_grids(found: Falling, ghost: Falling) -> Figure:
    """The grid of B with that of A behind it."""
    return with_ghost(found.grid, ghost.grid, "A")


@lru_cache(maxsize=8)
def without_lens(settings: Settings) -> str:
    """The falloff of a camera without a lens in a sentence, from the weights of its rays."""
    try:
        of = camera(settings).with_open_stop
    except (ValueError, OSError) as error:
        return str(error)
    grid = (np.arange(ACROSS) + 0.5) / ACROSS
    pupil = np.stack(np.meshgrid(grid, grid), -1).reshape(-1, 2)
    middle, corner = (float(of.generate_rays([at] * len(pupil), pupil).weights.mean())
                      for at in ((0.5 * of.film.pixels_x, 0.5 * of.film.pixels_y), (0.0, 0.0)))
    if not 0.0 < corner < (1.0 - SLIGHT) * middle:
        return "This camera has no lens and no falloff: it weighs the light of all its rays alike"
    return f"This camera has no lens: no vignetting and no distortion. Its natural falloff, cos⁴ of the angle to the " \
           f"axis, leaves {_stops(corner / middle)} in the corner"


def _ghost(other: Settings | None) -> Falling | None:
    """Falloff and distortion of the settings A; None where they have none."""
    if other is None or not other.has_lens:
        return None
    try:
        built = setup(other)
        return falling(built) if built.lens.is_rotationally_symmetric else None
    except (ValueError, OSError):               # A has nothing to compare with
        return None


def _stops(part: float) -> str:
    """A part of the light in stops."""
    return "dark" if part <= 0.0 else true_minus(f"{fixed(math.log2(part), 1, signed=True)} EV")


def _words(found: Falling) -> None:
    light, shape = found.light, found.shape
    paragraph("The corner of the film is dark" if light.total[-1] <= 0.0 else
              f"Corner {_stops(float(light.total[-1]))}: natural {_stops(float(light.natural[-1]))}, "
              f"vignetting {_stops(float(light.vignetting[-1]))}", True)
    imgui.set_item_tooltip("Against the axis, of the real lens at the present stop and focus. Natural: cos⁴ of the "
                           "angle at the film,\nover the pupil; vignetting: the pupil's area, as the rims leave it")
    imgui.text_disabled(distortion_words(shape))
    imgui.set_item_tooltip("The largest distortion on this film: chief rays followed to the plane in focus, against\n"
                           "the picture that keeps lines straight, or of a fisheye the rule that it follows best")


def _light_plot(light: Falloff, ghost: Falling | None, size: ImVec2) -> None:
    """Percent of the axis over the radius: the total, and its two parts; and the total of A."""
    if not _begin("Falloff plot", size, "Light (%)", (0.0, float(light.radii[-1])), (0.0, light_limit(light)), 25.0):
        return
    colour, plot, draw = theme.colours(), PlotMap.current(log=False), implot.get_plot_draw_list()
    pixel = theme.scale()
    implot.push_plot_clip_rect()
    for part, (on, off), tint in ((light.natural, NATURAL, colour.text), (light.vignetting, RIMS, colour.text)):
        for piece in pieces(plot.pixels(light.radii, 100.0 * part), on * pixel, off * pixel):
            draw.add_polyline(piece, theme.packed(tint), pixel, imgui.ImDrawFlags_.none)
    polyline(draw, plot.pixels(light.radii, 100.0 * light.total), theme.packed(colour.strong), 2.0)
    if ghost is not None:
        _draw_ghost(draw, plot, plot.pixels(ghost.light.radii, 100.0 * ghost.light.total))
    line, x = imgui.get_text_line_height(), plot.left + 6.0 * pixel
    y = plot.bottom - 3.4 * line
    for name, (on, off), tint in (("natural", NATURAL, colour.text), ("vignetting", RIMS, colour.text),
                                  ("total", (0.0, 0.0), colour.strong)):
        middle = np.array([[x, y + 0.5 * line], [x + 18.0 * pixel, y + 0.5 * line]])
        for piece in pieces(middle, on * pixel, off * pixel):
            draw.add_polyline(piece, theme.packed(tint), (2.0 if on == 0.0 else 1.0) * pixel, imgui.ImDrawFlags_.none)
        text(draw, ImVec2(x + 23.0 * pixel, y), colour.dim, name, plate=True)
        y += line
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered():
        radius = min(max(plot.x_at(imgui.get_mouse_pos().x), 0.0), float(light.radii[-1]))
        total, natural, rims = (float(np.interp(radius, light.radii, part))
                                for part in (light.total, light.natural, light.vignetting))
        if imgui.begin_tooltip():
            imgui.text_unformatted(f"{fixed(radius, 1)} mm off the axis: {fixed(100.0 * total, 0)} %, {_stops(total)}")
            if not math.isnan(natural):
                imgui.text_disabled(f"natural {fixed(100.0 * natural, 0)} %, vignetting {fixed(100.0 * rims, 0)} %")
            imgui.end_tooltip()
    implot.end_plot()


def _draw_ghost(draw: imgui.ImDrawList, plot: PlotMap, points: np.ndarray) -> None:
    """A curve of A through pixels (n, 2), with its name at its end."""
    polyline(draw, points, theme.packed(theme.compared()), 1.5)
    extent = imgui.calc_text_size("A")
    if (at := name_corner(points, plot, (extent.x, extent.y), 3.0 * theme.scale())) is not None:
        text(draw, ImVec2(*at), theme.compared(), "A")


def name_corner(points: np.ndarray, plot: PlotMap, extent: tuple[float, float],
                gap: float) -> tuple[float, float] | None:
    """Upper left corner of a name at the end of a curve through pixels (n, 2); None without a curve.

    Right of the end where the plot has room there, else above the curve, or below it at the top of the plot.
    """
    good = points[np.isfinite(points).all(1)]
    if not len(good):
        return None
    (width, height), (x, y) = extent, good[-1].tolist()
    if x + gap + width <= plot.right:
        return x + gap, min(max(y - 0.5 * height, plot.top), plot.bottom - height)
    left = min(x, plot.right) - gap - width
    beside = np.append(good[good[:, 0] >= left - gap, 1], np.interp(left - gap, good[:, 0], good[:, 1]))
    above = float(beside.min()) - gap - height
    return left, above if above >= plot.top else float(beside.max()) + gap


def _shape_plot(found: Falling, ghost: Falling | None, size: ImVec2) -> None:
    shape = found.shape
    percent = np.where(np.isfinite(shape.percent), shape.percent, np.nan)
    most = max(0.5, 1.15 * float(np.nanmax(np.abs(percent))))
    if not _begin("Distortion plot", size, "Distortion (%)", (0.0, float(shape.radii[-1])), (-most, most),
                  round_above(most / 3.0)):
        return
    colour, plot, draw = theme.colours(), PlotMap.current(log=False), implot.get_plot_draw_list()
    implot.push_plot_clip_rect()
    polyline(draw, plot.pixels(shape.radii, percent), theme.packed(colour.strong), 2.0)
    if ghost is not None:
        _draw_ghost(draw, plot, plot.pixels(ghost.shape.radii, ghost.shape.percent))
    zero = plot.at(0.0, 0.0).y
    draw.add_line(ImVec2(plot.left, zero), ImVec2(plot.right, zero), theme.packed(colour.faint), theme.scale())
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered():
        radius = min(max(plot.x_at(imgui.get_mouse_pos().x), 0.0), float(shape.radii[-1]))
        here, angle = (float(np.interp(radius, shape.radii, values)) for values in (percent, shape.angles))
        if imgui.begin_tooltip():
            imgui.text_unformatted(f"{fixed(radius, 1)} mm off the axis: {true_minus(fixed(here, 2, signed=True))} %")
            imgui.text_disabled(f"seen {fixed(math.degrees(angle), 1)}° off the axis")
            imgui.end_tooltip()
    implot.end_plot()


def _begin(name: str, size: ImVec2, label: str, x: tuple[float, float], y: tuple[float, float], step: float) -> bool:
    """Begin a plot over the film's radius, its ticks `step` apart."""
    if size.y < 40.0 or not implot.begin_plot(name, size, PLOT_FLAGS):
        return False
    roomy = size.x > theme.em(13) and size.y > theme.em(7)
    implot.setup_axis(implot.ImAxis_.x1, "Film radius (mm)" if roomy else None, AXIS_FLAGS | implot.AxisFlags_.lock)
    implot.setup_axis(implot.ImAxis_.y1, label if roomy else None, AXIS_FLAGS | implot.AxisFlags_.lock)
    implot.setup_axis_limits(implot.ImAxis_.x1, *x, implot.Cond_.always)
    implot.setup_axis_limits(implot.ImAxis_.y1, *y, implot.Cond_.always)
    values = [i * step for i in range(math.ceil(y[0] / step), math.floor(y[1] / step) + 1)]
    implot.setup_axis_ticks(implot.ImAxis_.y1, values, list(map(true_minus, map(significant, values))), False)
    return True
