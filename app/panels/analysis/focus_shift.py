"""The panel *Focus shift*: where axial points are sharpest as the lens is stopped down; and focus breathing."""

from dataclasses import replace

from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.aperture_figures import breathing_figure, focus_shift_figure
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.settings import Settings
from lensbench.app.widgets.toggles import toggles

NAME = "Focus shift"
KINDS = {"shift": "Focus shift", "breathing": "Breathing"}
TIPS = {"shift": "The best focus over the f-number; the film is as the lens is focused wide open",
        "breathing": "How much wider the picture gets as the lens is focused nearer"}


def focus_shift_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> None:
    """Draw the best focus against the aperture, or the field of view against the focus, in the rest of the window."""
    state.choices["kind"] = toggles("Kind", KINDS, state.choices.get("kind", "shift"), TIPS, 0.0)
    tools(NAME, state)
    if state.choices["kind"] == "breathing":
        analysis(NAME, settings, state, sheet, breathing_figure)
        return
    number = readings(settings).f_number if settings.has_lens else None
    analysis(NAME, settings, state, sheet, focus_shift_figure, (number,),
             adapted=lambda settings: replace(settings, f_number=None))
