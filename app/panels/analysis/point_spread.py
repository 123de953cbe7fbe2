"""The panel *Point spread*: the picture of a point, its encircled energy, and the spread of a line."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.bokeh import TIPS as VIEW_TIPS
from lensbench.app.panels.analysis.bokeh import VIEWS
from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.point_figures import encircled_figure, line_spread_figure, psf_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.row import beside
from lensbench.app.widgets.toggles import toggles

NAME = "Point spread"
KINDS = {"picture": "Picture", "energy": "Energy", "line": "Line"}
KIND_TIPS = {"picture": "The image of a point of light, in all wavelengths",
             "energy": "The part of its light within a circle, over the radius of the circle",
             "line": "Light across the image of a thin line"}
FIELDS = {"axis": "Axis", "middle": "0.7", "full": "Edge"}
FIELD_TIPS = {"axis": "The film's centre", "middle": "0.7 of the way to the corner",
              "full": "The film's corner, or the edge of light"}


def point_spread_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the picture or the curves in the rest of the window."""
    choices = state.choices
    choices["kind"] = toggles("Kind", KINDS, choices.get("kind", "picture"), KIND_TIPS, 0.0)
    if choices["kind"] != "picture":
        tools(NAME, state)
        make = encircled_figure if choices["kind"] == "energy" else line_spread_figure
        analysis(NAME, settings, state, sheet, make, (), (24, 96))
        return
    beside(7.5)
    choices["field"] = toggles("Field", FIELDS, choices.get("field", "axis"), FIELD_TIPS, 0.0)
    beside(6.5)
    choices["view"] = toggles("View", VIEWS, choices.get("view", "log"), VIEW_TIPS, 0.0)
    beside(4.5)
    _, choices["pixel"] = imgui.checkbox("Pixel", choices.get("pixel", False))
    imgui.set_item_tooltip("Average the light over a pixel of the film")
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, psf_figure, (choices["field"], choices["view"], choices["pixel"]), (32, 128))
