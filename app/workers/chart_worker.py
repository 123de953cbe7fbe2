"""The chart of the present lens's models, measured in the background once the settings have stopped changing."""

from collections.abc import Callable
from dataclasses import replace
from time import monotonic

from lensbench.app.state.settings import Settings
from lensbench.app.studies.charts.values import Chart
from lensbench.app.workers.measurements import Measurements
from lensbench.app.workers.task import Task

STILL = 0.5                     # seconds without a change before a measurement begins
SECONDS = 0.04                  # for the timings of each model


def charted(settings: Settings) -> Settings:
    """The settings on which a chart depends; all others at their defaults."""
    return settings.optics.plain("lens_model", "degree", "medium", "limit")


class ChartWorker(Measurements[Settings, Chart]):
    """The newest chart; it stays until the next one is measured."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        # At full priority: the timings of the models must not wait for the threads of the renderer
        super().__init__(_measured, wake, keep_all=False, lowered=False)
        self._asked: Settings | None = None
        self._since = 0.0

    @property
    def chart(self) -> Chart | None:
        """The newest chart; None before the first, and after an error."""
        return next(iter(self.found.values()), None)

    @property
    def of(self) -> Settings | None:
        """The settings of the chart or of the problem."""
        return next(iter([*self.found, *self.problems]), None)

    @property
    def problem(self) -> str:
        """Why there is no chart of these settings."""
        return next(iter(self.problems.values()), "")

    def want(self, settings: Settings) -> None:
        """Measure the chart of these settings once they have not changed for STILL seconds."""
        key = charted(settings)
        if key != self._asked:
            self._asked, self._since = key, monotonic()
        if key != self.key:
            self.give_way()
        if monotonic() - self._since > STILL:
            super().want(key)
        else:
            self.collect()


def _measured(key: Settings, task: Task[Chart]) -> Chart:
    import lensbench as lb
    from lensbench.app.state.camera_kinds import camera
    from lensbench.app.studies.charts.models import chart
    from lensbench.app.studies.charts.subjects import Subject

    camera_ = camera(replace(key, lens_model="trace"))
    assert isinstance(camera_, lb.LensCamera)
    return chart(Subject(key.lens, camera_.lens.name, camera_), task.report, SECONDS, in_the_renderer=False)
