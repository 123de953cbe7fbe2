"""The analysis panels of a window: their table, what they share, and the saving of their figures."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from lensbench.app.bench.build import design
from lensbench.app.settings.settings import Settings
from lensbench.app.window.state import WindowState
from lensbench.app.workers.analysis_worker import NO_JOBS, AnalysisWorker, Job
from lensbench.app.workers.task import Task
from lensbench.core.kernels.cache import NotCompiledError

if TYPE_CHECKING:
    from lensbench.app.panels.analysis.frame import AnalysisState, Draw, Sheet

# Panels by name, and the file in `panels.analysis` that draws each, loaded when one is first shown
PANELS = {
    "Spots": "plots", "Ray fans": "plots", "Field curves": "plots", "MTF": "plots", "MTF map": "plots",
    "Point spread": "points_of_light", "Bokeh": "points_of_light", "Sunstar": "plots", "Ghosts": "points_of_light",
    "Depth of field": "plots", "Wavefront": "plots", "Seidel": "plots", "On the axis": "plots", "Focus shift": "plots",
    "Illumination": "plots", "Sensor stack": "plots", "Tolerances": "plots",
}


@cache
def _drawing(name: str) -> "Draw":
    return import_module(f"lensbench.app.panels.analysis.{PANELS[name]}").DRAW[name]


class Analyses:
    """The states of the panels, the worker that computes their figures, and the figure being saved."""

    def __init__(self, window: WindowState):
        self._window = window
        self._handed = 0                # the generation of the newest picture in a frame that is built
        self.worker = AnalysisWorker(window.wake, self._picture_waits)
        self._saving: Task[None] | None = None
        self._path = Path()
        self._asked_of: Settings | None = None          # the settings of the newest jobs

    @cached_property
    def sheet(self) -> "Sheet":
        """What the panels share, from when the first one is drawn."""
        from lensbench.app.panels.analysis.frame import Sheet

        return Sheet(self.worker, self._window.requests, self._window.view.links)

    @cached_property
    def states(self) -> dict[str, "AnalysisState"]:
        """The state of each panel."""
        from lensbench.app.panels.analysis.frame import AnalysisState

        return {name: AnalysisState() for name in PANELS}

    def panel(self, name: str) -> Callable[[Settings], Settings]:
        """Draws the panel of this name: settings to settings."""
        def draw(settings: Settings) -> Settings:
            self.worker.await_coarse()
            window = self._window
            self.sheet.other = window.view.pinned if window.history.present.compare != "off" else None
            settings = _drawing(name)(settings, self.states[name], self.sheet) or settings
            if self.sheet.white:
                settings, self.sheet.white = replace(settings, white=self.sheet.white), ""
            return settings

        return draw

    def begin(self, settings: Settings) -> None:
        """Call it at the beginning of each frame, with the settings that the panels will show."""
        self.worker.advance(self._changed(settings))
        if self._saving is not None and self._saving.done:
            task, self._saving = self._saving, None
            if task.error is None:
                self._window.view.say(f"Plot saved as {self._path.name}", done=True, about="plot")
            else:
                self._window.view.say(task.message, about="plot")

    def follow(self, settings: Settings) -> None:
        """Call it at the end of each frame, with the settings that the panels will show in the next one.

        The work begins when this frame is handed over.
        """
        changed = self._changed(settings)
        if changed:
            self.worker.follow(changed)

    def _changed(self, settings: Settings) -> Mapping[str, Job]:
        """What the panels drawn last will ask for, where that has changed."""
        if settings is self._asked_of:
            return NO_JOBS
        self._asked_of, jobs = settings, {}
        if "states" not in vars(self):                  # nothing has been drawn
            return NO_JOBS
        for name, state in self.states.items():
            if state.job is None:
                continue
            if not self.worker.wants(name):             # it is computed again when it is shown again
                state.forget()
                continue
            with suppress(ValueError, OSError, NotCompiledError):           # the panel says so
                jobs[name] = state.job(settings)
        self.worker.forget()
        return jobs

    def handed_over(self) -> None:
        """A frame is built, and its drawing need not wait for the interpreter."""
        update = self._window.presenter.update
        if update is not None:
            self._handed = update.generation

    def _picture_waits(self) -> bool:
        """Whether no frame holds a picture of the current settings: it comes before the figures."""
        worker = self._window.worker
        return worker.generation != self._handed and worker.error is None

    def save(self, path: Path) -> None:
        """Write the figure whose saving was asked for, in the format of the suffix."""
        figure, settings = self.sheet.saving, self._window.history.present
        if figure is None:
            return

        def work(_: Task[None]) -> None:
            from lensbench.app.drawing.sheet import write_figure

            write_figure(figure, path, design(settings).name)

        self._path, self._saving = path, Task("Saving the plot", work, self._window.wake)

    def stop(self) -> None:
        """The window is about to close."""
        self.worker.stop()
