"""An improvement of the lens in the background; the window takes each step as soon as it is there."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from lensbench.app.workers.task import Task
from lensbench.lenses.editing.document import LensDocument

if TYPE_CHECKING:
    from lensbench.design.improve import Step


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
        """Begin; an improvement that is running ends.

        image_height: as for `goal_of`. glasses: whether they may change too.
        """
        self.stop()
        self.first = self.last = self._newest = None
        self.number, self.aim, self.ended = 0, aim, ""

        def work(task: Task[None]) -> None:
            from lensbench.app.state.lens_edit.improving import improved
            from lensbench.design.improve import ending
            from lensbench.design.standard_goal import goal_of
            from lensbench.lenses.glass_catalogue import replacements

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
