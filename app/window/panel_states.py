"""What the panels keep from frame to frame: made, and its panel imported, when that is first drawn."""

from functools import cached_property
from typing import TYPE_CHECKING

from lensbench.app.window.state import WindowState

if TYPE_CHECKING:
    from lensbench.app.panels.circle_of_confusion import CocState
    from lensbench.app.panels.exit_pupil import PupilState
    from lensbench.app.panels.falloff import FalloffState
    from lensbench.app.panels.lens_card import LensCardState
    from lensbench.app.panels.lens_section.panel import SectionState
    from lensbench.app.panels.lens_table.state import LensTableState
    from lensbench.app.panels.models import ModelsState
    from lensbench.app.panels.pixel import PixelState
    from lensbench.app.panels.plan import PlanState
    from lensbench.app.panels.view_3d import View3DState


class PanelStates:
    """The states of the panels of one window, but of those for analysis."""

    def __init__(self, window: WindowState):
        self._window = window

    @cached_property
    def confusion(self) -> "CocState":
        """Of the circles of confusion."""
        from lensbench.app.panels.circle_of_confusion import CocState

        return CocState()

    @cached_property
    def pupil(self) -> "PupilState":
        """Of the exit pupil."""
        from lensbench.app.panels.exit_pupil import PupilState

        return PupilState()

    @cached_property
    def falloff(self) -> "FalloffState":
        """Of the falloff."""
        from lensbench.app.panels.falloff import FalloffState

        return FalloffState()

    @cached_property
    def card(self) -> "LensCardState":
        """Of the lens card."""
        from lensbench.app.panels.lens_card import LensCardState

        return LensCardState(self._window.wake)

    @cached_property
    def section(self) -> "SectionState":
        """Of the section."""
        from lensbench.app.panels.lens_section.panel import SectionState

        return SectionState()

    @cached_property
    def table(self) -> "LensTableState":
        """Of the surface table, with the worker that improves its lens."""
        from lensbench.app.panels.lens_table.state import LensTableState
        from lensbench.app.workers.improvement_worker import ImprovementWorker

        return LensTableState(self._window.requests, worker=ImprovementWorker(self._window.wake))

    @cached_property
    def models(self) -> "ModelsState":
        """Of the models."""
        from lensbench.app.panels.models import ModelsState

        return ModelsState()

    @cached_property
    def pixel(self) -> "PixelState":
        """Of the pixel."""
        from lensbench.app.panels.pixel import PixelState

        return PixelState()

    @cached_property
    def plan(self) -> "PlanState":
        """Of the plan."""
        from lensbench.app.panels.plan import PlanState

        return PlanState()

    @cached_property
    def view_3d(self) -> "View3DState":
        """Of the 3-D view."""
        from lensbench.app.panels.view_3d import View3DState

        return View3DState()

    @property
    def has_table(self) -> bool:
        """Whether something asked for the state of the surface table, so that a lens may be improved."""
        return "table" in vars(self)

    def stop(self) -> None:
        """End the workers of the panels; the window is about to close."""
        if "card" in vars(self):
            self.card.checks.stop()
        if self.has_table:
            self.table.worker.stop()
