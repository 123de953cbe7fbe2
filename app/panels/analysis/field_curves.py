"""The panel *Field curves*: field curvature, distortion and lateral colour, one by one or side by side."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.field_figures import SHOWN, field_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.toggles import toggles

NAME = "Field curves"
WIDE = 46.0                     # em, from which on all plots are side by side
NAMES = {"curvature": "Curvature", "distortion": "Distortion", "colour": "Colour"}
TIPS = {"curvature": "Where sagittal and tangential lines are in focus, from the film: field curvature and astigmatism",
        "distortion": "Image heights against an ideal projection",
        "colour": "Image heights of other wavelengths against the primary one"}


def field_curves_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    shown: tuple[str, ...] = SHOWN
    if imgui.get_content_region_avail().x < theme.em(WIDE):
        state.choices["shown"] = toggles("Shown", NAMES, state.choices.get("shown", "curvature"), TIPS, 0.0)
        shown = (state.choices["shown"],)
    else:
        imgui.align_text_to_frame_padding()
        imgui.text_disabled("Over the field")
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, field_figure, (shown,))
