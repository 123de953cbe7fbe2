"""Workers of long studies: charts, stability sweeps and improvements of a lens."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING

from lensbench.app.settings.settings import Settings
from lensbench.app.studies.charts.curves import Chart
from lensbench.app.studies.stability.plots import FAMILIES
from lensbench.app.studies.stability.sweep import Sweep, progress_to
from lensbench.app.workers.task import Measurements, Task
from lensbench.lenses.editing.document import LensDocument

if TYPE_CHECKING:
    from lensbench.core.design.improve import Step


STILL = 0.5                     # seconds without a change before a measurement begins
SECONDS = 0.04                  # for the timings of each model


def charted(settings: Settings) -> Settings:
    """The settings on which a chart depends; all others at their defaults."""
    return settings.optics.plain("lens_model", "degree", "medium", "limit")


class ChartWorker(Measurements[Settings, Chart]):
    """The newest chart; it stays until the next one is measured."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        # At full priority: the timings of the models must not wait for the threads of the renderer
        super().__init__(_chart_worker_measured, wake, keep_all=False, lowered=False)
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


def _chart_worker_measured(key: Settings, task: Task[Chart]) -> Chart:
    import lensbench as lb
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.app.studies.charts.subjects import Subject, chart

    camera_ = camera(replace(key, lens_model="trace"))
    assert isinstance(camera_, lb.LensCamera)
    return chart(Subject(key.lens, camera_.lens.name, camera_), task.report, SECONDS, in_the_renderer=False)


Key = tuple[str, str]           # family and sweep: the keys of FAMILIES


class StabilityWorker(Measurements[Key, Sweep]):
    """Every sweep that has been looked at, measured once."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        super().__init__(_stability_worker_measured, wake)


def _stability_worker_measured(key: Key, task: Task[Sweep]) -> Sweep:
    family, title = key
    with progress_to(task.check):
        return FAMILIES[family][title]()


class ImprovementWorker:
    """One improvement at a time.

    first, last: the rms (mm) of its aim at its start and now; None before the first step. ended: why it ended, "" while
    it runs.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None):
        self.first: float | None = None
        self.last: float | None = None
        self.number = 0
        self.aim, self.ended = "spot", ""
        self._wake = wake
        self._task: Task[None] | None = None
        self._newest: LensDocument | None = None

    @property
    def running(self) -> bool:
        """Whether an improvement is under way."""
        return self._task is not None and not self._task.done

    @property
    def pending(self) -> bool:
        """Whether there is a step that has not been taken."""
        return self._newest is not None

    @property
    def message(self) -> str:
        """Reason for which the latest improvement ended early; "" while it runs, and where it completed."""
        return self._task.message if self._task is not None and self._task.done else ""

    def start(self, document: LensDocument, cells: Sequence[tuple[int, str]], image_height: float | None,
              hold_back_focus: bool = False, glasses: bool = False, aim: str = "spot") -> None:
        """Begin; a running one ends. image_height: as for `goal_of`. glasses: whether they may change too."""
        self.stop()
        self.first = self.last = self._newest = None
        self.number, self.aim, self.ended = 0, aim, ""

        def work(task: Task[None]) -> None:
            from lensbench.app.session.edited_lens import improved
            from lensbench.core.design.improve import ending
            from lensbench.core.design.standard_goal import goal_of
            from lensbench.lenses.glass.catalogue import replacements

            def progress(step: "Step") -> None:
                if task.cancelled:
                    return
                self.first = step.rms if self.first is None else self.first
                self.last, self.number = step.rms, step.number
                if step.number:
                    self._newest = replace(document, lens=step.lens)
                self._wake()

            goal = goal_of(document.lens, image_height, aim, hold_back_focus)
            done = improved(document, cells, goal, replacements() if glasses else None, progress,
                            lambda: task.cancelled)
            if not task.cancelled:
                self.ended = ending(done)

        self._task = Task("Improve", work, self._wake)

    def take(self) -> LensDocument | None:
        """The newest lens, once; None without a new one."""
        newest, self._newest = self._newest, None
        return newest

    def stop(self) -> None:
        """End; the lens stays at its latest step."""
        if self._task is not None:
            self._task.cancel()
