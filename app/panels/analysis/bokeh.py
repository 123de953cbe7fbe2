"""The panel *Bokeh*: pictures of points of light over field and distance."""

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.bokeh_figure import bokeh_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.toggles import toggles

NAME = "Bokeh"
VIEWS = {"linear": "Linear", "log": "Log"}
TIPS = {"linear": "Light as the film receives it", "log": "Four decades of light: faint rims and rings show"}


def bokeh_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the gallery in the rest of the window."""
    state.choices["view"] = toggles("View", VIEWS, state.choices.get("view", "linear"), TIPS, 0.0)
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, bokeh_figure, (state.choices["view"],), (16, 48))
