"""Falloff and distortion of the real lens at its current focus and stop, over the film radius.

Above, how much light of the axis reaches the film: the natural falloff, cos⁴ over the pupil, and the vignetting by the
clear apertures, whose product is the total. Below, by how much images are too small or too large, as a curve or as the
grid that a square one becomes.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import ImVec2, imgui

import lensbench as lb
from lensbench.app.bench.build import Bench, bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph, toggles
from lensbench.app.drawing.plot_painter import Drawn, draw_figure
from lensbench.app.plots.comparison import with_ghost
from lensbench.app.plots.plot import DASHED, DOTTED, Axis, Curve, Figure, Plot, Table, light_limit
from lensbench.app.plots.ray_plots import distortion_words, film_distortion, grid_plot
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.chief_ray_curves import Distortion
from lensbench.core.analysis.vignetting import Falloff
from lensbench.core.text import fixed, true_minus

RADII = 49
ACROSS = 16                                     # points across the pupil of a camera without a lens
SLIGHT = 0.01                                   # of the light: a smaller loss is none
SHOWN = {"curve": "Curve", "grid": "Grid"}
TIPS = {"curve": "Distortion in percent of the ideal radius, over the film's radius",
        "grid": "The image of a square grid; the ideal one is faint"}


@dataclass
class FalloffState:
    """Choice of the lower plot, and the state of its grid; not part of the settings."""

    shown: str = "curve"
    light: Drawn = field(default_factory=Drawn)
    curve: Drawn = field(default_factory=Drawn)
    grid: Drawn = field(default_factory=Drawn)


EVERY_WAY = "These plots need a rotationally symmetric lens. This lens has a cylinder, a toroid, or tilted or " \
            "decentred surfaces: its falloff and distortion also depend on the direction. The panel Field curves " \
            "shows its distortion along both sides of the film, and as a grid"


@dataclass(frozen=True, eq=False)
class Falling:
    """Falloff and distortion of one lens on one film, for radii up to the film's corner, and their plots."""

    light: Falloff
    shape: Distortion
    light_figure: Figure
    curve: Figure
    grid: Figure


@lru_cache(maxsize=8)
def falling(lens_setup: Bench) -> Falling:
    """Falloff, distortion and their plots; LensError for a lens that has none."""
    radii = np.linspace(0.0, 0.5 * lens_setup.film.diagonal, RADII)
    light, shape = lb.falloff(lens_setup.lens, lens_setup.film_distance, radii), film_distortion(lens_setup)
    plot, *_ = grid_plot(lens_setup)
    return Falling(light, shape, _plotted("Falloff", _light_plot(light)), _plotted("Distortion", _shape_plot(shape)),
                   _plotted("Distortion grid", replace(plot, title="")))           # the words above say it


def _plotted(title: str, plot: Plot) -> Figure:
    return Figure(title, ((plot,),), Table((), ()))


def _light_plot(light: Falloff) -> Plot:
    """Percent of the axis over the film radius: the total, and its two parts."""
    x = light.radii
    return Plot(Axis("Film radius (mm)", 0.0, float(x[-1])), Axis("Light (%)", 0.0, light_limit(light)), (
        Curve("natural", x, 100.0 * light.natural, "text", DASHED, 1.0),
        Curve("vignetting", x, 100.0 * light.vignetting, "text", DOTTED, 1.0),
        Curve("total", x, 100.0 * light.total, weight=2.0)), words=partial(_light_words, light))


def _light_words(light: Falloff, x: float, _: float) -> str:
    """The light at a film radius (mm), and its two parts."""
    radius = min(max(x, 0.0), float(light.radii[-1]))
    total, natural, vignetting = (float(np.interp(radius, light.radii, values))
                                  for values in (light.total, light.natural, light.vignetting))
    words = f"{fixed(radius, 1)} mm off the axis: {fixed(100.0 * total, 0)} %, {_stops(total)}"
    return words if math.isnan(natural) else \
        f"{words}\nnatural {fixed(100.0 * natural, 0)} %, vignetting {fixed(100.0 * vignetting, 0)} %"


def _shape_plot(shape: Distortion) -> Plot:
    """Percent of the ideal radius over the film radius."""
    percent, end = np.where(np.isfinite(shape.percent), shape.percent, np.nan), float(shape.radii[-1])
    most = max(0.5, 1.15 * float(np.nanmax(np.abs(percent))))
    return Plot(Axis("Film radius (mm)", 0.0, end), Axis("Distortion (%)", -most, most), (
        Curve("", np.array([0.0, end]), np.zeros(2), "faint", weight=1.0),
        Curve("distortion", shape.radii, percent, weight=2.0)), words=partial(_shape_words, shape))


def _shape_words(shape: Distortion, x: float, _: float) -> str:
    """The distortion at a film radius (mm), and the angle that it is seen at."""
    radius = min(max(x, 0.0), float(shape.radii[-1]))
    percent, angle = (float(np.interp(radius, shape.radii, values)) for values in (
        np.where(np.isfinite(shape.percent), shape.percent, np.nan), shape.angles))
    return f"{fixed(radius, 1)} mm off the axis: {true_minus(fixed(percent, 2, signed=True))} %\n" \
           f"seen {fixed(math.degrees(angle), 1)}° off the axis"


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
        lens_setup = bench_of(settings)
        if not lens_setup.lens.is_rotationally_symmetric:
            paragraph(EVERY_WAY)
            return
        analysis = falling(lens_setup)
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return
    theme.small()
    _words(analysis)
    room, below = imgui.get_content_region_avail(), imgui.get_frame_height_with_spacing()
    ghost = _ghost(other)
    draw_figure("Falloff", _with_a(analysis.light_figure, ghost and ghost.light_figure),
                ImVec2(room.x, 0.52 * (room.y - below)), state.light)
    state.shown = toggles("Distortion", SHOWN, state.shown, TIPS, 5.6)
    figure = analysis.curve if state.shown == "curve" else analysis.grid
    of_a = None if ghost is None else ghost.curve if state.shown == "curve" else ghost.grid
    draw_figure(f"Falloff {state.shown}", _with_a(figure, of_a), imgui.get_content_region_avail(),
                state.curve if state.shown == "curve" else state.grid, named=False)
    imgui.pop_font()


@lru_cache(maxsize=8)
def _with_a(figure: Figure, of_a: Figure | None) -> Figure:
    """The figure of B with that of A behind it, if there is one."""
    return figure if of_a is None else with_ghost(figure, of_a, "A")


@lru_cache(maxsize=8)
def without_lens(settings: Settings) -> str:
    """The falloff of a camera without a lens in a sentence, from the weights of its rays."""
    try:
        of = camera(settings).with_open_stop
    except (ValueError, OSError) as error:
        return str(error)
    grid = (np.arange(ACROSS) + 0.5) / ACROSS
    pupil = np.stack(np.meshgrid(grid, grid), -1).reshape(-1, 2)
    middle, corner = (float(of.generate_rays([raster] * len(pupil), pupil).weights.mean())
                      for raster in ((0.5 * of.film.pixels_x, 0.5 * of.film.pixels_y), (0.0, 0.0)))
    if not 0.0 < corner < (1.0 - SLIGHT) * middle:
        return "This camera has no lens and no falloff: it weights all its rays equally"
    return f"This camera has no lens: no vignetting and no distortion. Its natural falloff, cos⁴ of the angle to the " \
           f"axis, leaves {_stops(corner / middle)} in the corner"


def _ghost(other: Settings | None) -> Falling | None:
    """Falloff and distortion of the settings A; None where they have none."""
    if other is None or not other.has_lens:
        return None
    try:
        built = bench_of(other)
        return falling(built) if built.lens.is_rotationally_symmetric else None
    except (ValueError, OSError):               # A has nothing to compare with
        return None


def _stops(fraction: float) -> str:
    """A part of the light in stops."""
    return "dark" if fraction <= 0.0 else true_minus(f"{fixed(math.log2(fraction), 1, signed=True)} EV")


def _words(analysis: Falling) -> None:
    light, shape = analysis.light, analysis.shape
    paragraph("The corner of the film is dark" if light.total[-1] <= 0.0 else
              f"Corner {_stops(float(light.total[-1]))}: natural {_stops(float(light.natural[-1]))}, "
              f"vignetting {_stops(float(light.vignetting[-1]))}", True)
    imgui.set_item_tooltip("Relative to the axis, for the real lens at the current stop and focus. Natural: cos⁴ of "
                           "the angle at the film,\nover the pupil; vignetting: the area of the exit-pupil region")
    imgui.text_disabled(distortion_words(shape))
    imgui.set_item_tooltip("The largest distortion on this film: chief rays followed to the plane in focus, against\n"
                           "the picture that keeps lines straight, or of a fisheye the rule that it follows best")
