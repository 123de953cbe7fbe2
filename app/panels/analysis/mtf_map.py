"""The panel *MTF map*: contrast over field and focus; the film, in amber, is dragged through it."""

from contextlib import suppress
from dataclasses import replace

from lensbench.app.panels.analysis.drawing import Grip
from lensbench.app.panels.analysis.frame import AnalysisState, Sheet, analysis, tools
from lensbench.app.state.analysis.film_drag import focus_at
from lensbench.app.state.analysis.mtf_figures import mtf_map_figure
from lensbench.app.state.analysis.query import query
from lensbench.app.state.settings import Settings
from lensbench.app.state.text_values import format_distance
from lensbench.app.widgets.row import beside
from lensbench.app.widgets.toggles import toggles
from lensbench.kernels.figures import fixed

NAME = "MTF map"
FREQUENCIES = {10.0: "10", 20.0: "20", 30.0: "30", 40.0: "40"}
WAYS = {"both": "S + T", "sagittal": "S", "tangential": "T"}
WAY_TIPS = {"both": "The mean of the sagittal and the tangential contrast", "sagittal": "Lines towards the centre",
            "tangential": "Lines about the centre"}


def mtf_map_panel(settings: Settings, state: AnalysisState, sheet: Sheet) -> Settings:
    """Draw the map in the rest of the window; returns the settings with the dragged focus.

    While the film is dragged the map stays that of the object at which the drag began.
    """
    choices = state.choices
    choices["frequency"] = toggles("lp/mm", FREQUENCIES, choices.get("frequency", 30.0),
                                   {key: f"{name} line pairs per mm" for key, name in FREQUENCIES.items()}, 3.2)
    beside(7.0)
    choices["way"] = toggles("Way", WAYS, choices.get("way", "both"), WAY_TIPS, 0.0)
    line = _line(settings, choices.get("line"))
    choices["line"] = line
    tools(NAME, state)
    held: Settings | None = choices.get("held")
    shift = choices.get("shift", 0.0) if held is not None else 0.0
    begun = settings if held is None else replace(settings, focus_distance=held.focus_distance)
    grip = Grip(shift, "film", f"{format_distance(settings.focus_distance)}: drag to focus")
    analysis(NAME, begun, state, sheet, mtf_map_figure, (choices["frequency"], choices["way"], line), grip=grip)
    if not grip.held or not settings.focuses:
        choices["held"] = None
        return settings
    if held is None:
        choices["held"] = settings
    if grip.at == shift:
        return settings
    choices["shift"] = grip.at
    return replace(settings, focus_distance=focus_at(query(begun).setup, grip.at))


def _line(settings: Settings, chosen: float | None) -> float | None:
    """The wavelength (µm) that the user chooses among those of the lens; None: all of them, or the only one."""
    lines: tuple[float, ...] = ()
    with suppress(ValueError, OSError):                 # the panel says why there is no map
        lines = query(settings).lines.conditions().wavelengths
    if len(lines) < 2:
        return None
    names: dict[float | None, str] = {None: "White"} | {line: fixed(1000.0 * line, 0) for line in lines}
    tips: dict[float | None, str] = {None: "All wavelengths with their weights"} | {
        line: f"{name} nm alone" for line, name in names.items() if line is not None}
    beside(4.0 + 2.6 * len(lines))
    return toggles("Line", names, chosen if chosen in names else None, tips, 0.0)
