"""The panel *On the axis*: longitudinal aberration over the stop, and the paraxial focus over the wavelength."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.axial_figures import axial_figure
from lensbench.app.state.settings import Settings

NAME = "On the axis"


def axial_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw both plots in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Spherical aberration and colour")
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, axial_figure)
