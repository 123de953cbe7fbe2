"""An improvement of the lens in the background; the window takes each step as soon as it is there."""

from collections.abc import Callable, Sequence

from lensbench.app.workers.task import Task
from lensbench.lenses.editing.document import LensDocument


class ImprovementWorker:
    """One improvement at a time.

    first, last: the rms (mm) of its aim at its start and now; None before the first step.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None):
        self.first: float | None = None
        self.last: float | None = None
        self.number = 0
        self.aim = "spot"
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

    def start(self, document: LensDocument, cells: Sequence[tuple[int, str]], image_height: float,
              hold_back_focus: bool = False, glasses: bool = False, aim: str = "spot") -> None:
        """Begin; an improvement that is under way ends. image_height: mm. glasses: whether they may change too."""
        self.stop()
        self.first = self.last = self._newest = None
        self.number, self.aim = 0, aim

        def work(task: Task[None]) -> None:
            from dataclasses import replace

            from lensbench.app.studies.improvement.improve import improved
            from lensbench.app.studies.improvement.merit import back_focus, goal_of
            from lensbench.app.studies.improvement.substitution import substituted

            goal = goal_of(document, image_height, aim)
            if hold_back_focus:
                goal = replace(goal, back_focus=back_focus(document.lens))
            for step in (substituted if glasses else improved)(document, cells, goal):
                if task.cancelled:
                    return
                if step.number == self.number and self.first is not None:
                    continue
                self.first = step.rms if self.first is None else self.first
                self.last, self.number, self._newest = step.rms, step.number, step.document
                self._wake()

        self._task = Task("Improve", work, self._wake)

    def take(self) -> LensDocument | None:
        """The newest lens, once; None without a new one."""
        newest, self._newest = self._newest, None
        return newest

    def stop(self) -> None:
        """End; the lens stays at its latest step."""
        if self._task is not None:
            self._task.cancel()
