"""The analysis panels of a window: their table, what they share, and the saving of their figures."""

from collections.abc import Callable
from pathlib import Path

from lensbench.app.panels.analysis.axial import axial_panel
from lensbench.app.panels.analysis.bokeh import bokeh_panel
from lensbench.app.panels.analysis.depth_of_field import depth_of_field_panel
from lensbench.app.panels.analysis.fans import fans_panel
from lensbench.app.panels.analysis.field_curves import field_curves_panel
from lensbench.app.panels.analysis.focus_shift import focus_shift_panel
from lensbench.app.panels.analysis.frame import AnalysisState, Sheet
from lensbench.app.panels.analysis.ghosts import ghosts_panel
from lensbench.app.panels.analysis.illumination import illumination_panel
from lensbench.app.panels.analysis.mtf import mtf_panel
from lensbench.app.panels.analysis.mtf_map import mtf_map_panel
from lensbench.app.panels.analysis.point_spread import point_spread_panel
from lensbench.app.panels.analysis.seidel import seidel_panel
from lensbench.app.panels.analysis.sensor_stack import sensor_stack_panel
from lensbench.app.panels.analysis.spots import spots_panel
from lensbench.app.panels.analysis.sunstar import sunstar_panel
from lensbench.app.panels.analysis.tolerances import tolerances_panel
from lensbench.app.panels.analysis.wavefront import wavefront_panel
from lensbench.app.state.build import design
from lensbench.app.state.settings import Settings
from lensbench.app.window.state import WindowState
from lensbench.app.workers.analysis_worker import AnalysisWorker
from lensbench.app.workers.task import Task

PANELS: dict[str, Callable[[Settings, AnalysisState, Sheet], Settings | None]] = {
    "Spots": spots_panel,
    "Ray fans": fans_panel,
    "Field curves": field_curves_panel,
    "MTF": mtf_panel,
    "MTF map": mtf_map_panel,
    "Point spread": point_spread_panel,
    "Bokeh": bokeh_panel,
    "Sunstar": sunstar_panel,
    "Ghosts": ghosts_panel,
    "Depth of field": depth_of_field_panel,
    "Wavefront": wavefront_panel,
    "Seidel": seidel_panel,
    "On the axis": axial_panel,
    "Focus shift": focus_shift_panel,
    "Illumination": illumination_panel,
    "Sensor stack": sensor_stack_panel,
    "Tolerances": tolerances_panel,
}


class Analyses:
    """The states of the panels, the worker that computes their figures, and the figure being saved."""

    def __init__(self, window: WindowState):
        self._window = window
        self.worker = AnalysisWorker(window.wake, lambda: window.worker.waiting > 0.0)
        self.sheet = Sheet(self.worker, window.requests, window.view.links)
        self.states = {name: AnalysisState() for name in PANELS}
        self._saving: Task[None] | None = None
        self._path = Path()

    def panel(self, name: str) -> Callable[[Settings], Settings]:
        """Draws the panel of this name: settings to settings."""
        return lambda settings: PANELS[name](settings, self.states[name], self.sheet) or settings

    def begin(self) -> None:
        """Call it at the beginning of each frame."""
        self.worker.advance()
        window = self._window
        self.sheet.other = window.view.pinned if window.history.present.compare != "off" else None
        if self._saving is not None and self._saving.done:
            task, self._saving = self._saving, None
            if task.error is None:
                self._window.view.say(f"The figure was saved as {self._path.name}", done=True)
            else:
                self._window.view.say(task.message)

    def save(self, path: Path) -> None:
        """Write the figure whose saving was asked for, in the format of the suffix."""
        figure, settings = self.sheet.saving, self._window.history.present
        if figure is None:
            return

        def work(_: Task[None]) -> None:
            from lensbench.app.studies.analysis_sheet import write_figure

            write_figure(figure, path, design(settings).name)

        self._path, self._saving = path, Task("Saving the figure", work, self._window.wake)

    def stop(self) -> None:
        """The window is about to close."""
        self.worker.stop()
