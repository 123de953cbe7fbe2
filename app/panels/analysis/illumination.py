"""The panel *Illumination*: light on the film over its radius, at the widest stop and three more."""

from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.aperture_figures import illumination_figure
from lensbench.app.state.settings import Settings

NAME = "Illumination"


def illumination_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Relative illumination")
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, illumination_figure,
             adapted=lambda settings: replace(settings, f_number=None))
