"""The panel *Sunstar*: the rays that the blades of the stop draw about a small bright light."""

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.star_figure import star_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.toggles import toggles

NAME = "Sunstar"
FIELDS = {"axis": "Centre", "middle": "0.7"}
TIPS = {"axis": "A light in the middle of the picture", "middle": "A light 0.7 of the way to the corner, above the "
                                                                 "centre of the film"}


def sunstar_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the star in the rest of the window."""
    state.choices["field"] = toggles("Field", FIELDS, state.choices.get("field", "axis"), TIPS, 0.0)
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, star_figure, (state.choices["field"],))
