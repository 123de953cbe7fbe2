"""The panel *MTF*: contrast against the field, as makers print it, or against frequency."""

from imgui_bundle import imgui

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.mtf_figures import mtf_field_figure, mtf_frequency_figure
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.toggles import toggles

NAME = "MTF"
KINDS = {"field": "Field", "frequency": "Frequency"}
KIND_TIPS = {"field": "Contrast of 10, 20, 30 and 40 line pairs per mm over the image height",
             "frequency": "Contrast on the axis, at 0.7 and at the full field over the frequency"}
METHODS = {"diffraction": "Waves", "geometric": "Rays"}
METHOD_TIPS = {"diffraction": "With diffraction, from the wavefront in the exit pupil",
               "geometric": "From the rays alone, without diffraction"}


def mtf_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the curves in the rest of the window."""
    choices = state.choices
    choices["kind"] = toggles("Over", KINDS, choices.get("kind", "field"), KIND_TIPS, 0.0)
    imgui.same_line(0.0, 12.0)
    choices["method"] = toggles("By", METHODS, choices.get("method", "diffraction"), METHOD_TIPS, 0.0)
    tools(NAME, state)
    make, points = (mtf_field_figure, (16, 64)) if choices["kind"] == "field" else (mtf_frequency_figure, (32, 128))
    analysis(NAME, settings, state, sheet, make, (choices["method"],), points)
