"""The figures of the analysis panels, computed on a background thread: coarse at once, refined when still.

Panels say in every frame what they show; what no panel shows is not computed. All figures of one lens share its rays.
None begins while the picture waits for its first pass: it has the processors to itself.
"""

import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from time import monotonic, sleep

from lensbench.app.state.analysis.figure import Figure
from lensbench.app.state.analysis.query import Query
from lensbench.app.workers.task import Task, error_text, report_unforeseen

STILL = 0.25                    # seconds without a change before a figure is refined
PATIENCE = 0.5                  # seconds in a row that figures leave to first passes, at the most
LOOK = 0.001                    # seconds between two looks for the picture


@dataclass(frozen=True)
class Job:
    """One figure: make(query, points, *options), with `points` across the pupil, few of them for the coarse one."""

    make: Callable[..., Figure]
    query: Query
    options: tuple[Hashable, ...] = ()
    points: tuple[int, int] = (16, 32)          # coarse, refined


@dataclass(frozen=True, eq=False)
class Answer:
    """The figure of a job, or why there is none."""

    job: Job
    refined: bool
    figure: Figure | None
    message: str = ""


class AnalysisWorker:
    """The newest answer of each panel; it stays until the next one is there.

    wake: called when there is news. waits: whether the picture waits for its first pass.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None, waits: Callable[[], bool] = lambda: False):
        self._wake, self._waits = wake, waits
        self._lock = threading.Lock()
        self._wanted: dict[str, tuple[Job, float]] = {}         # of the panels of the frame before, and of this one
        self._asked: dict[str, tuple[Job, float]] = {}          # of this frame: the job, and since when it is wanted
        self._answers: dict[str, Answer] = {}
        self._task: Task[None] | None = None

    @property
    def busy(self) -> bool:
        """Whether a panel waits for a refined figure."""
        with self._lock:
            return any(not self._is_done(name, job, refined=True)
                       for name, (job, _) in (*self._wanted.items(), *self._asked.items()))

    def advance(self) -> None:
        """Begin a frame: what the panels of the last one did not want is no longer wanted."""
        with self._lock:
            self._wanted, self._asked = self._asked, {}
            idle = self._task is None or self._task.done
            if idle and self._next() is not None:
                self._task = Task("Analysis", self._work, self._wake)

    def want(self, name: str, job: Job) -> Answer | None:
        """The newest answer for the panel of this name, and a request for that of this job. None: there is none yet.

        The work begins with the next frame: at the end of this one the picture has begun.
        """
        with self._lock:
            known = self._wanted.get(name)
            new = known is None or known[0] != job
            self._asked[name] = known if known is not None and not new else (job, monotonic())
            answer = self._answers.get(name)
        if new:
            self._wake()
        return answer

    def stop(self) -> None:
        """Compute nothing more; the figure at work is finished."""
        with self._lock:
            self._wanted, self._asked = {}, {}
        if self._task is not None:
            self._task.cancel()

    def _is_done(self, name: str, job: Job, refined: bool) -> bool:
        answer = self._answers.get(name)
        return answer is not None and answer.job == job and (answer.refined or not refined)

    def _next(self) -> tuple[str, Job, bool] | None:
        """The most urgent figure: a coarse one that is missing, or a refined one whose job has been still.

        Its panel, its job, and whether it is refined.
        """
        now = monotonic()
        for name, (job, _) in self._wanted.items():
            if not self._is_done(name, job, refined=False):
                return name, job, False
        for name, (job, since) in self._wanted.items():
            if now - since > STILL and not self._is_done(name, job, refined=True):
                return name, job, True
        return None

    def _work(self, task: Task[None]) -> None:
        free = monotonic()                      # when a figure could begin the last time
        while not task.cancelled:
            with self._lock:
                found = self._next()
            if found is None:
                return
            name, job, refined = found
            if self._waits() and monotonic() - free < PATIENCE:
                sleep(LOOK)
                continue
            answer = _answer(job, refined)
            free = monotonic()
            with self._lock:
                self._answers[name] = answer
            self._wake()


def _answer(job: Job, refined: bool) -> Answer:
    """The figure of a job. An error is final: finer rays would not help."""
    try:
        return Answer(job, refined, job.make(job.query, job.points[refined], *job.options))
    except Exception as error:                  # the thread has no caller: the panel shows the message
        report_unforeseen(error)
        return Answer(job, True, None, error_text(error, "This analysis"))
