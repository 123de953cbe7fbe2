"""The circle of confusion against distance: ideal thin lens, thick lens and the real one, traced.

Distances are measured from the film, those of a camera without a prescription from its ideal lens, and shown in metres;
diameters on the film in micrometres and, on the right axis, in pixels. The amber line is the plane in focus and can be
dragged.
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np
from imgui_bundle import imgui

from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.readouts import Readings
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import paragraph
from lensbench.app.drawing.plot_painter import Drawn, Grip, draw_figure
from lensbench.app.plots.blur import Curves, curves, main_curve, plot_range
from lensbench.app.plots.pixel_rays import Pointed
from lensbench.app.plots.pixel_spot import pixel_readings
from lensbench.app.plots.plot import DASHED, DOTTED, Axis, Curve, Figure, Patch, Plot, Points
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number
from lensbench.core.text import significant

LOW = 13.0                      # em: below this height the plot has no legend
FARTHEST = 1e9                  # m and µm: beyond every plot


@dataclass
class CocState:
    """State of the panel between frames."""

    drawn: Drawn = field(default_factory=Drawn)


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
        limits = plot_range(got)
        shown = curves(settings.optics, *limits[:2])
    except (ValueError, OSError) as error:
        paragraph(str(error))
        return settings
    grip = Grip(settings.focus_distance / 1000.0, format_distance(settings.focus_distance),
                "Plane in focus: drag to focus", endless=True)
    theme.small()
    figure = confusion_figure(settings.optics, got, shown, _curves_of(other, *limits[:2]))
    draw_figure("Circle of confusion", figure, size, state.drawn, grip, named=size.y > theme.em(LOW),
                over=() if links is None else _pixel(settings, links))
    imgui.pop_font()
    if not grip.held or grip.at == settings.focus_distance / 1000.0:
        return settings
    nearest = got.nearest_focus if got.nearest_focus is not None else 1.01 * (got.efl or 0.0)
    return replace(settings, focus_distance=max(1000.0 * grip.at, nearest))


@lru_cache(maxsize=4)
def confusion_figure(settings: Settings, got: Readings, shown: Curves, of_a: Curves | None) -> Figure:
    """The plot of these curves. of_a: those of the settings A."""
    low, high, bottom, top = plot_range(got)
    pitch, limit = 1000.0 * settings.pixel_pitch, 1000.0 * (got.limit or 0.0)
    across = low / FARTHEST, FARTHEST
    layers: list = []

    # Depth of field; lines across: limit, pixel, Airy disk; and the hyperfocal distance
    if got.near_limit is not None and got.far_limit is not None:
        near, far = got.near_limit / 1000.0, min(got.far_limit / 1000.0, FARTHEST)
        layers.append(Patch(np.array([[near, 0.0], [near, FARTHEST], [far, FARTHEST], [far, 0.0]]), "amber"))
    if abs(math.log(max(limit, 1e-9) / pitch)) < 1e-6:
        tag = f"limit 1 px, {significant(limit, 3)} µm"
        layers.append(Curve.straight(across, (limit, limit), dash=DASHED, tag=tag))
    else:
        layers += [Curve.straight(across, (limit, limit), dash=DASHED, tag=f"limit {significant(limit, 3)} µm"),
                   Curve.straight(across, (pitch, pitch), dash=DOTTED,
                                  tag="pixel" if settings.sensor is None else "sensor pixel")]
    if got.airy is not None:
        layers.append(Curve.straight(across, (1000.0 * got.airy,) * 2, dash=DOTTED, tag="Airy"))
    if got.hyperfocal is not None:
        layers.append(Curve.straight((got.hyperfocal / 1000.0,) * 2, (bottom / FARTHEST, FARTHEST), "faint", DOTTED,
                                     tag="hyperfocal"))

    # Curves, the main one last
    x, main = shown.distances, main_curve(shown)
    layers += [Curve("", x, diameters, "faint", weight=1.0, tag=format_f_number(f_number))
               for f_number, diameters in shown.neighbours]
    layers += [Curve(name, x, diameters, "text", dash, 1.0)
               for name, diameters, dash in (("thick", shown.thick, DASHED), ("thin", shown.thin, DOTTED))
               if diameters is not None and diameters is not main]
    if of_a is not None:
        layers.append(Curve("", of_a.distances, main_curve(of_a), "chart4", weight=1.5, tag="A"))
    name = "real" if main is shown.real else "thick" if main is shown.thick else "thin"
    layers.append(Curve(name if shown.thick is not None else "", x, main, weight=2.0,
                        tag=format_f_number(got.f_number or 0.0)))
    edges = np.array([edge / 1000.0 for edge in (got.near_limit, got.far_limit)
                      if edge is not None and math.isfinite(edge) and limit > 0.0])
    layers.append(Points("", edges, np.full(len(edges), limit), "amber", "circle", size=3.0))
    axes = Axis("Distance (m)", low, high, log=True), Axis("Circle of confusion (µm)", bottom, top, log=True)
    return Figure("Circle of confusion", ((
        Plot(*axes, tuple(layers), words=partial(_words, settings, shown), right=("px", pitch)),),))


def _curves_of(other: Settings | None, low: float, high: float) -> Curves | None:
    """The curves of the settings A between two distances, if they have any."""
    if other is None:
        return None
    try:
        return curves(other.optics, low, high)
    except (ValueError, OSError):               # A has no circle of confusion
        return None


def _pixel(settings: Settings, links: Pointed) -> tuple[Points, ...]:
    """A ring at the distance and the blur of what the pointed pixel shows."""
    raster = links.pixel(settings.film.pixels_x, settings.film.pixels_y)
    if raster is None:
        return ()
    try:
        got = pixel_readings(settings, raster)
    except (ValueError, OSError):               # the panel “Pixel” says why
        return ()
    if got.diameter is None or not got.ahead > 0.0:
        return ()
    return (Points("", np.array([min(got.ahead / 1000.0, FARTHEST)]), np.array([1000.0 * got.diameter]), shape="ring",
                   size=5.0),)


def _words(settings: Settings, shown: Curves, distance: float, _: float) -> str:
    """The diameters at a distance (m); "" outside the curves."""
    if not shown.distances[0] <= distance <= shown.distances[-1]:
        return ""
    lines = [f"{format_distance(1000.0 * distance)} from {settings.kind.measured_from}"]
    for name, diameters in (("real", shown.real), ("thick", shown.thick), ("thin", shown.thin)):
        if diameters is not None:
            value = float(np.exp(np.interp(math.log(distance), np.log(shown.distances), np.log(diameters))))
            pixels = value / (1000.0 * settings.pixel_pitch)
            lines.append(f"{name} lens   {significant(value, 3)} µm   {significant(pixels, 2)} px")
    return "\n".join(lines)
