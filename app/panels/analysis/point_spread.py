"""The panel *Point spread*: the picture of a point, its encircled energy, and the spread of a line.

The panel *Bokeh*: pictures of points of light over field and distance, with the rings of a ripple if wanted.
"""

import math

from imgui_bundle import imgui

from lensbench.app.bench.build import design
from lensbench.app.drawing.controls import beside, check_box, number, paragraph, toggles
from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet, analysis, tools
from lensbench.app.plots.light_plots import Ripple, bokeh_figure, ripple_surface
from lensbench.app.plots.pixel_rays import Place, beam, film_place
from lensbench.app.plots.point_plots import encircled_figure, line_spread_figure, psf_figure, seen_point_figure
from lensbench.app.settings.settings import Settings

BOKEH_NAME = "Bokeh"
VIEWS = {"linear": "Linear", "log": "Log"}
TIPS = {"linear": "Light as the film receives it", "log": "Four decades of light: faint edges and rings show"}
PERIOD, HEIGHT = 0.8, 100.0     # mm and nm, of a ripple at first


def bokeh_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the gallery in the rest of the window."""
    choices = state.choices
    choices["view"] = toggles("View", VIEWS, choices.get("view", "linear"), TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["rings"] = check_box("Ripple", choices.get("rings", False))
    imgui.set_item_tooltip("Onion rings: a ripple that the tool left on one surface")
    ripple = _ripple(settings, choices) if choices["rings"] and settings.has_lens else None
    tools(BOKEH_NAME, state)
    analysis(BOKEH_NAME, settings, state, sheet, bokeh_figure, (choices["view"], ripple),
             (16, 48) if ripple is None else (64, 160))


def _ripple(settings: Settings, choices: dict) -> Ripple | None:
    """Three numbers that describe the ripple; None where the lens cannot be read."""
    try:
        lens = design(settings)
    except (ValueError, OSError):
        return None
    last = len(lens.surfaces) - 1
    if choices.get("lens") != settings.lens:
        choices["lens"], choices["surface"] = settings.lens, ripple_surface(lens)
    surface = number("Surface", float(choices["surface"]), (0.0, float(last)), 0.05, "%.0f",
                     "Number of the surface, from 0; at first the largest asphere", 3.0)
    beside(7.5)
    choices["period"] = number("Period", choices.get("period", PERIOD), (0.05, 10.0), 0.005, "%.2f mm",
                               "Distance from ring to ring on the surface")
    beside(7.5)
    choices["height"] = number("Height", choices.get("height", HEIGHT), (0.0, 1000.0), 1.0, "%.0f nm",
                               "From trough to crest")
    choices["surface"] = min(round(surface), last)
    return Ripple(choices["surface"], round(choices["period"], 4), round(1e-6 * choices["height"], 12))


NAME = "Point spread"
POINTS = 32, 128                # across the pupil, coarse and refined
KINDS = {"picture": "Picture", "energy": "Energy", "line": "Line"}
KIND_TIPS = {"picture": "The image of a point of light, in all wavelengths",
             "energy": "The part of its light within a circle, over the radius of the circle",
             "line": "Light across the image of a thin line"}
FIELDS = {"axis": "Axis", "middle": "0.7", "full": "Edge", "pixel": "Pixel"}
FIELD_TIPS = {"axis": "The film's centre", "middle": "0.7 of the way to the corner",
              "full": "The film's corner, or the edge of light",
              "pixel": "The pixel that was under the mouse last, or the pinned one: the picture of a point of what it "
                       "shows"}
NO_PIXEL = "Point at the picture: this panel shows how a point of what the pixel shows is drawn. I, or Alt+click, " \
           "pins the pixel"
NO_LIGHT = "No light reaches this pixel"


def point_spread_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the picture or the curves in the rest of the window."""
    choices = state.choices
    choices["kind"] = toggles("Kind", KINDS, choices.get("kind", "picture"), KIND_TIPS, 0.0)
    if choices["kind"] != "picture":
        tools(NAME, state)
        make = encircled_figure if choices["kind"] == "energy" else line_spread_figure
        analysis(NAME, settings, state, sheet, make, (), (24, 96))
        return
    beside(10.5)
    choices["field"] = toggles("Field", FIELDS, choices.get("field", "axis"), FIELD_TIPS, 0.0)
    beside(6.5)
    choices["view"] = toggles("View", VIEWS, choices.get("view", "log"), TIPS, 0.0)
    beside(6.0)
    choices["averaged"] = check_box("Averaged", choices.get("averaged", False))
    imgui.set_item_tooltip("Average the light over a pixel of the film")
    tools(NAME, state)
    shown = choices["view"], choices["averaged"]
    if choices["field"] != "pixel" or not settings.has_lens:
        analysis(NAME, settings, state, sheet, psf_figure, (choices["field"], *shown), POINTS)
        return
    seen, state.reason = _seen(settings, state, sheet)
    if seen is None:
        state.figure = None
        paragraph(state.reason)
    else:
        analysis(NAME, settings, state, sheet, seen_point_figure, (*seen, *shown), POINTS)


def _seen(settings: Settings, state: AnalysisState, sheet: Sheet) -> tuple[tuple[Place, float] | None, str]:
    """The film point (mm) of the pixel that is followed and the distance of what it shows (mm), or why there is none.

    The last pixel stays when the mouse leaves the picture.
    """
    film = settings.film
    raster = sheet.links.pixel(film.pixels_x, film.pixels_y)
    if raster is not None:
        state.choices["at"] = raster[0] / film.pixels_x, raster[1] / film.pixels_y
    at = state.choices.get("at")
    if at is None:
        return None, NO_PIXEL
    raster = at[0] * film.pixels_x, at[1] * film.pixels_y
    try:
        ahead = beam(settings, raster).ahead
    except (ValueError, OSError) as error:
        return None, str(error)
    return (None, NO_LIGHT) if math.isnan(ahead) else ((film_place(settings, raster), ahead), "")


DRAW: dict[str, Draw] = {NAME: point_spread_panel, BOKEH_NAME: bokeh_panel}
