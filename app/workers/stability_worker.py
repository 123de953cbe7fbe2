"""Sweeps of the stability study, measured beside the window."""

from collections.abc import Callable

from lensbench.app.studies.stability.families import FAMILIES
from lensbench.app.studies.stability.sweep import Sweep, progress_to
from lensbench.app.workers.measurements import Measurements
from lensbench.app.workers.task import Task

Key = tuple[str, str]           # family and sweep: the keys of FAMILIES


class StabilityWorker(Measurements[Key, Sweep]):
    """Every sweep that has been looked at, measured once."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        super().__init__(_measured, wake)


def _measured(key: Key, task: Task[Sweep]) -> Sweep:
    family, title = key
    with progress_to(task.check):
        return FAMILIES[family][title]()
