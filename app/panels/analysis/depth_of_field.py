"""The panel *Depth of field*: how near and how far the real lens is sharp, at each place of the film."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.depth_figure import depth_figure
from lensbench.app.state.figures import blur_limit
from lensbench.app.state.settings import Settings

NAME = "Depth of field"


def depth_of_field_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the limits over the field in the rest of the window; sharp is what the read-outs call so."""
    imgui.align_text_to_frame_padding()
    imgui.text_disabled("Sharp over the field")
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, depth_figure, (blur_limit(settings) if settings.has_lens else None,))
