"""The panel *Bokeh*: pictures of points of light over field and distance, with the rings of a ripple if wanted."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.bokeh_figure import Ripple, bokeh_figure, ripple_surface
from lensbench.app.state.build import design
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.number import number
from lensbench.app.widgets.row import beside
from lensbench.app.widgets.toggles import toggles

NAME = "Bokeh"
VIEWS = {"linear": "Linear", "log": "Log"}
TIPS = {"linear": "Light as the film receives it", "log": "Four decades of light: faint rims and rings show"}
PERIOD, HEIGHT = 0.8, 100.0     # mm and nm, of a ripple at first


def bokeh_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the gallery in the rest of the window."""
    choices = state.choices
    choices["view"] = toggles("View", VIEWS, choices.get("view", "linear"), TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["rings"] = check_box("Ripple", choices.get("rings", False))
    imgui.set_item_tooltip("Onion rings: a ripple that the tool left on one surface")
    ripple = _ripple(settings, choices) if choices["rings"] and settings.has_lens else None
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, bokeh_figure, (choices["view"], ripple),
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
