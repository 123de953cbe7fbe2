"""The picture A beside the present one, B: it refines too, and follows B's dials while the two are locked.

A has a render worker of its own, at low priority. It works while A is shown, and never gets ahead of B in samples, so
that B stays as fast as it can be. A picture of a light field cannot be rendered again: as A it stays as it is.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lensbench.app.plots.comparison import followed
from lensbench.app.settings.settings import Settings
from lensbench.app.window.state import WindowState
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.app.workers.render_worker import RenderWorker


class Comparing:
    """Lives as long as the window."""

    def __init__(self, window: WindowState, threads: int | None = None):
        self._window, self._threads = window, threads
        self._worker: RenderWorker | None = None        # from when A is first shown
        self._kept: RenderUpdate | None = None          # the picture A as pinned, or as shown last
        self._is_pinned = False                         # that picture is the pinned one, and not the worker's
        self._taken: RenderUpdate | None = None         # the worker's newest update that was shown
        self._before: Settings | None = None            # B in the frame before

    def pin(self) -> bool:
        """Make the shown picture A; returns False if there is none yet."""
        window, presenter = self._window, self._window.presenter
        if not presenter.pin(window.history.present) or presenter.pinned is None:
            return False
        window.view.pinned = presenter.pinned.settings
        return True

    def pin_codes(self, codes: NDArray[np.float32], settings: Settings) -> None:
        """Make a saved picture A; while it is shown, it is rendered again. codes: of the screen (h, w, 3), 0 to 1."""
        self._window.presenter.keep_codes(codes, settings)
        self._window.view.pinned = settings

    @property
    def is_live(self) -> bool:
        """Whether A can be rendered, and is shown."""
        pinned = self._window.presenter.pinned
        return pinned is not None and not pinned.field_picture and self._window.history.present.compare != "off"

    def advance(self, held: bool) -> None:
        """Once a frame: let A follow B, and show its newest picture. held: the processor is left to other work."""
        view, present = self._window.view, self._window.history.present
        before, self._before = self._before, present
        pinned = self._window.presenter.pinned
        if pinned is not self._kept:                    # another picture was pinned
            self._kept, self._is_pinned, self._taken = pinned, True, None
        if view.pinned is not None and view.locked and before is not None and pinned and not pinned.field_picture:
            view.pinned = followed(view.pinned, before, present)
        if self.is_live:
            self._render(held)
            self._show()
        elif self._worker is not None:
            self._worker.hold(True)

    def _render(self, held: bool) -> None:
        """Let A's worker render as many samples as B has."""
        window, a, b = self._window, self._window.view.pinned, self._window.presenter.update
        assert a is not None
        if b is None or b.generation != window.worker.generation:
            return                                      # B's first picture comes first
        complete = b.samples >= b.settings.samples
        wanted = replace(a, samples=a.samples if complete else min(b.samples, a.samples))
        if self._worker is None:
            self._worker = RenderWorker(wanted, window.wake, self._threads, urgent=False)
        self._worker.hold(held or window.worker.paused)
        self._worker.restart(wanted)
        failure = self._worker.error
        if failure is not None and self._kept is not None:
            window.view.say(f"A: {failure.error}")
            window.view.pinned = self._kept.settings

    def _show(self) -> None:
        """Show A's newest picture, unless the pinned one has more samples."""
        window, a, kept = self._window, self._window.view.pinned, self._kept
        update = self._worker.newest() if self._worker is not None else None
        if update is None or kept is None or a is None or update.settings.picture != a.picture:
            return
        if self._is_pinned and kept.settings.picture == a.picture and update.samples < kept.samples:
            return
        if update is not self._taken or a != kept.settings:
            self._taken, self._is_pinned = update, False
            window.presenter.repin(update, a)
            self._kept = window.presenter.pinned

    def settled(self, samples: int) -> bool:
        """Whether A is on the screen with this many samples, or is not live."""
        kept, a = self._kept, self._window.view.pinned
        return not self.is_live or kept is not None and a is not None and kept.settings == a \
            and kept.samples >= min(samples, a.samples)

    def reload(self) -> None:
        """Render A again, because a file has changed on disk."""
        if self._worker is not None and self._window.view.pinned is not None:
            self._worker.reload(self._window.view.pinned)

    def closed(self) -> None:
        """The window is about to close."""
        if self._worker is not None:
            self._worker.stop()
