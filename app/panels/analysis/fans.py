"""The panel *Ray fans*: transverse aberration, or path difference, across the whole stop."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, point_at_ray, tools
from lensbench.app.state.analysis.fans import fans_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets import theme
from lensbench.app.widgets.toggles import toggles

NAME = "Ray fans"
KINDS = {"ray": "Rays", "opd": "Path difference"}
TIPS = {"ray": "Where rays meet the film against their heights in the stop, from the primary chief ray",
        "opd": "Optical path difference (OPD) on the reference sphere against the height in the stop, in wavelengths"}


def fans_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the fans in the rest of the window."""
    state.choices["kind"] = toggles("Kind", KINDS, state.choices.get("kind", "ray"), TIPS, 0.0)
    tools(NAME, state)
    rows = min(max(round(imgui.get_content_region_avail().y / theme.em(7.0)), 2), 6)
    point_at_ray(settings, state, sheet, analysis(NAME, settings, state, sheet, fans_figure,
                                                  (state.choices["kind"], rows)))
