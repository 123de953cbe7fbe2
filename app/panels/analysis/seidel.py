"""The panel *Seidel*: third-order aberrations of each surface; the surface under the mouse is lit in the section."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.figure import Bars
from lensbench.app.state.analysis.seidel_figure import seidel_figure
from lensbench.app.state.settings import Settings

NAME = "Seidel"


def seidel_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the bars in the rest of the window."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Share of each surface")
    tools(NAME, state)
    under = analysis(NAME, settings, state, sheet, seidel_figure)
    if under is None or state.figure is None:
        return
    surface, count = round(under.x), sum(isinstance(each, Bars) and each.surface is not None
                                         for each in under.plot.layers)
    if 0 <= surface < count and abs(under.x - surface) < 0.5:
        sheet.links.point_at_surfaces((surface,))
