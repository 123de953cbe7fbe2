"""The panel *Sensor stack*: what the glass before a sensor and the error of an adapter do to the lens."""

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.stack_figure import Stack, stack_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.number import number
from lensbench.app.widgets.row import beside

NAME = "Sensor stack"


def sensor_stack_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw three numbers and the curves in the rest of the window."""
    held: Stack = state.choices.get("stack", Stack())
    thickness = number("Glass", held.thickness, (0.0, 10.0), 0.02, "%.2f mm",
                       "Thickness of the glass before the sensor")
    beside(7.0)
    index = number("Index", held.refractive_index, (1.0, 2.2), 0.002, "%.3f", "Index of this glass")
    beside(9.5)
    error = number("Adapter", held.adapter_error, (-1.0, 1.0), 0.002, "%+.3f mm",
                   "By which an adapter is too long (+) or too short (−)", 5.6)
    state.choices["stack"] = Stack(round(thickness, 4), round(index, 5), round(error, 5))
    tools(NAME, state)
    analysis(NAME, settings, state, sheet, stack_figure, (state.choices["stack"],))
