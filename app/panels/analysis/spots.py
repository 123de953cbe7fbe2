"""The panel *Spots*: where the rays of points of the object meet the film, to one scale."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, point_at_ray, tools
from lensbench.app.state.analysis.spots import COLUMNS, spots_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.marked import check_box
from lensbench.app.widgets.row import beside
from lensbench.app.widgets.toggles import toggles

NAME = "Spots"
SIDE = {"focus": "Focus", "colour": "Colours"}
SIDE_TIPS = {"focus": "Places of the film side by side: nearer to the lens at the left, farther at the right",
             "colour": "The wavelengths side by side, on the film"}
REFERENCE = {"chief": "Chief ray", "centroid": "Centroid"}
REFERENCE_TIPS = {"chief": "Sizes are measured from the chief ray of the primary wavelength",
                  "centroid": "Sizes are measured from the centroid of the light of all wavelengths"}


def spots_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the spots in the rest of the window."""
    choices = state.choices
    choices["columns"] = toggles("Side", SIDE, choices.get("columns", "focus"), SIDE_TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["reference"] = toggles("Reference", REFERENCE, choices.get("reference", "chief"), REFERENCE_TIPS, 0.0)
    beside(6.0)                             # with room for the menu
    choices["blur"] = check_box("Blur", choices.get("blur", False))
    imgui.set_item_tooltip("Behind the rays: the light as the picture of the point has it, without diffraction.\n"
                           "Each cell is as bright as its brightest place")
    tools(NAME, state)
    room = imgui.get_content_region_avail()
    columns = COLUMNS if choices["columns"] == "focus" else 3
    rows = min(max(round(columns * 0.85 * room.y / max(room.x, 1.0)), 2), 8)
    point_at_ray(settings, state, sheet, analysis(NAME, settings, state, sheet, spots_figure,
                                                  (choices["columns"], choices["reference"], rows, choices["blur"])))
