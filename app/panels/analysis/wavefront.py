"""The panel *Wavefront*: the path difference over the exit pupil of one field, and its Zernike coefficients."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.wavefront_figure import wavefront_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.toggles import toggles

NAME = "Wavefront"
FIELDS = {"axis": "Axis", "middle": "0.7", "full": "Full"}
TIPS = {"axis": "On the axis", "middle": "At 0.7 of the largest image height", "full": "At the largest image height"}

ORDERS = {"noll": "Noll", "fringe": "Fringe"}
ORDER_TIPS = {"noll": "Zernike polynomials in Noll's order, each with an rms of 1",
              "fringe": "Zernike polynomials in the fringe order, each 1 at the rim of the pupil"}


def wavefront_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw map and bars in the rest of the window."""
    state.choices["field"] = toggles("Field", FIELDS, state.choices.get("field", "axis"), TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    state.choices["order"] = toggles("Order", ORDERS, state.choices.get("order", "noll"), ORDER_TIPS, 0.0)
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, wavefront_figure, (state.choices["field"], state.choices["order"]), (24, 64))
