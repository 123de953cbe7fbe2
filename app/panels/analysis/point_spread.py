"""The panel *Point spread*: the picture of a point, its encircled energy, and the spread of a line."""

import math

from imgui_bundle import imgui

from lensbench.app.panels.analysis.bokeh import TIPS as VIEW_TIPS
from lensbench.app.panels.analysis.bokeh import VIEWS
from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.point_figures import (
    encircled_figure,
    line_spread_figure,
    psf_figure,
    seen_point_figure,
)
from lensbench.app.state.pixel.beam import beam
from lensbench.app.state.pixel.lens_rays import film_place
from lensbench.app.state.pixel.pointed import Place
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.paragraph import paragraph
from lensbench.app.widgets.row import beside
from lensbench.app.widgets.toggles import toggles

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
NO_PIXEL = "Point at the picture: this panel shows how a point of what the pixel shows is drawn. I, or Alt + click, " \
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
    choices["view"] = toggles("View", VIEWS, choices.get("view", "log"), VIEW_TIPS, 0.0)
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
