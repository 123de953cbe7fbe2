"""The panel *Field curves*: field curvature, distortion (also as a grid) and lateral colour, singly or side by side."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.field_figures import SHOWN, field_figure
from lensbench.app.state.analysis.grid_figure import grid_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.toggles import toggles

NAME = "Field curves"
WIDE = 46.0                     # em, from which on all plots are side by side
NAMES = {"curvature": "Curvature", "distortion": "Distortion", "grid": "Grid", "colour": "Colour"}
BESIDE = {"curves": "Over the field", "grid": "Grid"}
TIPS = {"curvature": "Where sagittal and tangential lines are in focus, from the film: field curvature and astigmatism",
        "distortion": "Image heights against an ideal projection",
        "grid": "Distortion as the image of a square grid; the ideal one is faint",
        "colour": "Image heights of other wavelengths against the primary one",
        "curves": "Field curvature, distortion and lateral colour side by side"}


def field_curves_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    shown = state.choices.get("shown", "curvature")
    if imgui.get_content_region_avail().x < theme.em(WIDE):
        shown = toggles("Shown", NAMES, shown, TIPS, 0.0)
        plots: tuple[str, ...] = (shown,)
    else:
        side = toggles("Shown", BESIDE, shown if shown in BESIDE else "curves", TIPS, 0.0)
        shown = side if side == "grid" else "curvature" if shown == "grid" else shown
        plots = SHOWN
    state.choices["shown"] = shown
    tools(NAME, state)
    if shown == "grid":
        analysis(NAME, settings, state, sheet, grid_figure)
    else:
        analysis(NAME, settings, state, sheet, field_figure, (plots,))
