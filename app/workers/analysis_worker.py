"""The plots of the analysis panels, computed on a background thread: coarse at once, refined when still.

Panels say in every frame what they show; what no panel shows is not computed. All plots of one lens share its rays.
While the picture waits for its first pass, it has the processors to itself: no figure begins, and one under way pauses
at the next place where its computation allows it. Then coarse figures are made during the drawing of that frame, and
the next frame is held for them if they are about to come. Coarse figures have the window's priority: with a lower one
their thread would hold the interpreter's lock without getting a processor. Refined ones have a thread of their own,
which ends when its panel shows something else.
"""

import threading
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from time import monotonic, thread_time
from types import MappingProxyType
from typing import TYPE_CHECKING

from lensbench.app.workers.task import Task, error_text, report_unforeseen
from lensbench.core.kernels.pauses import pause, pausing

if TYPE_CHECKING:
    from lensbench.app.plots.plot import Figure
    from lensbench.app.plots.query import Query

STILL = 0.25                    # seconds without a change before a figure is refined
NO_JOBS: Mapping[str, "Job"] = MappingProxyType({})
PATIENCE = 0.5                  # seconds in a row that figures leave to first passes, at the most
HOLD_SECONDS = 0.05             # from its beginning, that a frame may be held for coarse figures
END_SECONDS = 2.0               # that the end of the window waits for a figure under way


class _NoLongerWantedError(Exception):
    """Ends a refined figure whose panel shows something else by now."""


@dataclass(frozen=True)
class Job:
    """One figure: make(query, points, *options), with `points` across the pupil, few of them for the coarse one."""

    make: Callable[..., "Figure"]
    query: "Query"
    options: tuple[Hashable, ...] = ()
    points: tuple[int, int] = (16, 32)          # coarse, refined


@dataclass(frozen=True, eq=False)
class Answer:
    """The figure of a job, or why there is none."""

    job: Job
    refined: bool
    figure: "Figure | None"
    message: str = ""


class AnalysisWorker:
    """The newest answer of each panel. wake: called with news. waits: whether the picture waits for a first pass."""

    def __init__(self, wake: Callable[[], None] = lambda: None, waits: Callable[[], bool] = lambda: False):
        self._wake, self._waits = wake, waits
        self._lock = threading.Condition(threading.Lock())      # told of each answer
        self._wanted: dict[str, tuple[Job, float]] = {}         # of the panels of the frame before, and of this one
        self._asked: dict[str, tuple[Job, float]] = {}          # of this frame: the job, and since when it is wanted
        self._answers: dict[str, Answer] = {}
        self._tasks: dict[bool, Task[None]] = {}                # the newest of coarse figures, and of refined ones
        self._late: set[str] = set()            # panels that got no figure of their job in this frame
        self._begun = 0.0                       # when this frame began
        self._seconds: dict[str, float] = {}    # of a processor, that the latest coarse figure of a panel took
        self._free = 0.0                        # when a figure could go on the last time

    @property
    def busy(self) -> bool:
        """Whether a panel waits for a refined figure."""
        with self._lock:
            return any(not self._is_done(name, job, refined=True)
                       for name, (job, _) in (*self._wanted.items(), *self._asked.items()))

    @property
    def is_late(self) -> bool:
        """Whether a panel of this frame got a figure of former settings, or none."""
        return bool(self._late)

    def advance(self, jobs: Mapping[str, Job] = NO_JOBS) -> None:
        """Begin a frame: what the panels of the last one did not want is no longer wanted. jobs: as of `follow`."""
        with self._lock:
            self._wanted, self._asked = self._asked, {}
            self._late.clear()
            self._begun = monotonic()
        self.follow(jobs)

    def follow(self, jobs: Mapping[str, Job]) -> None:
        """Begin what the panels of this frame or the last will want next; those without a job go on wanting theirs."""
        with self._lock:
            for jobs_of_frame in (self._wanted, self._asked):
                for name, (job, _) in jobs_of_frame.items():
                    if jobs.get(name, job) != job:
                        jobs_of_frame[name] = jobs[name], monotonic()
            self._begin()

    def await_coarse(self) -> None:
        """Hold the frame up to HOLD_SECONDS for coarse plots, which drawing would slow; not where they took longer."""
        with self._lock:
            left = self._begun + HOLD_SECONDS - monotonic()
            if sum(self._seconds.get(name, HOLD_SECONDS) for name in self._missing()) < left:
                self._lock.wait_for(lambda: not (self._missing() and self._is_working(refined=False)) or self._waits(),
                                    left)

    def want(self, name: str, job: Job) -> Answer | None:
        """The newest answer for the panel of this name, and a request for that of this job. None: there is none yet.

        The work begins with the next frame, so that the picture, which begins at the end of this one, comes first.
        """
        with self._lock:
            known = self._wanted.get(name)
            new = known is None or known[0] != job
            self._asked[name] = known if known is not None and not new else (job, monotonic())
            answer = self._answers.get(name)
            if answer is None or answer.job != job:
                self._late.add(name)
        if new:
            self._wake()
        return answer

    def wants(self, name: str) -> bool:
        """Whether the panel of this name wanted a figure in this frame or the one before."""
        with self._lock:
            return name in self._asked or name in self._wanted

    def forget(self) -> None:
        """Drop the answers of panels that are not shown, a refined one of which may hold 40 MB of rays."""
        with self._lock:
            for name in self._answers.keys() - self._wanted.keys() - self._asked.keys():
                del self._answers[name]

    def stop(self) -> None:
        """End: a refined figure at its next pause, a coarse one when it is finished; wait for it up to END_SECONDS."""
        with self._lock:
            self._wanted, self._asked = {}, {}
        for task in self._tasks.values():
            task.cancel()
        for task in self._tasks.values():       # a thread that computes while the interpreter ends may crash it
            task.join(END_SECONDS)

    def _begin(self) -> None:
        """Compute on a thread what is wanted, if anything is, unless one is at work."""
        job = self._next()
        if job is not None and not self._is_working(refined=job[2]):
            self._free = monotonic()
            self._tasks[job[2]] = Task("Analysis", partial(self._work, job[2]), self._wake, lowered=job[2])

    def _is_working(self, refined: bool) -> bool:
        return refined in self._tasks and not self._tasks[refined].done

    def _is_done(self, name: str, job: Job, refined: bool) -> bool:
        answer = self._answers.get(name)
        return answer is not None and answer.job == job and (answer.refined or not refined)

    def _missing(self) -> list[str]:
        """Panels whose coarse figure is wanted and not there."""
        return [name for name, (job, _) in self._wanted.items() if not self._is_done(name, job, refined=False)]

    def _next(self) -> tuple[str, Job, bool] | None:
        """The most urgent plot's panel, job and whether refined: a missing coarse one, else one that is still."""
        now = monotonic()
        for name in self._missing():
            return name, self._wanted[name][0], False
        for name, (job, since) in self._wanted.items():
            if now - since > STILL and not self._is_done(name, job, refined=True):
                return name, job, True
        return None

    def _work(self, refined: bool, task: Task[None]) -> None:
        """Make coarse figures, or refined ones as long as none is coarse; `advance` goes on with the others."""
        while not task.cancelled:
            pause(self._pauses)
            with self._lock:
                urgent = self._next()
            if urgent is None or urgent[2] != refined:
                return
            name, job, _ = urgent
            began = thread_time()
            try:
                with pausing(partial(self._refined_pauses, name, job) if refined else self._pauses):
                    answer = _answer(job, refined)
            except _NoLongerWantedError:
                continue
            with self._lock:
                if not refined:
                    self._seconds[name] = thread_time() - began
                elif self._is_of_another(name, job):
                    continue
                self._answers[name] = answer
                self._lock.notify_all()
            self._wake()

    def _pauses(self) -> bool:
        """Whether figures leave the processors to a first pass."""
        now = monotonic()
        if not self._waits():
            self._free = now
        return now - self._free < PATIENCE and self._waits()

    def _refined_pauses(self, name: str, job: Job) -> bool:
        """The same of a refined figure, which ends where its panel shows another one."""
        with self._lock:
            if self._is_of_another(name, job):
                raise _NoLongerWantedError
        return self._pauses()

    def _is_of_another(self, name: str, job: Job) -> bool:
        """Whether a panel shows something else than this job, or is gone."""
        newest = self._asked.get(name) or self._wanted.get(name)
        return newest is None or newest[0] != job


def _answer(job: Job, refined: bool) -> Answer:
    """The figure of a job. An error is final: finer rays would not help."""
    try:
        return Answer(job, refined, job.make(job.query, job.points[refined], *job.options))
    except _NoLongerWantedError:
        raise
    except Exception as error:                  # the thread has no caller: the panel shows the message
        report_unforeseen(error)
        return Answer(job, True, None, error_text(error, "This analysis"))
