"""Stresses measured beside the window, in a thread of their own, one at a time, each once."""

import threading
from collections.abc import Callable

from lensbench.app.studies.stability.families import FAMILIES
from lensbench.app.studies.stability.sweep import Sweep, progress_to

Key = tuple[str, str]           # family, sweep: as FAMILIES names them


class StabilityWorker:
    """What has been measured, and the sweep that is being measured."""

    def __init__(self, wake: Callable[[], None]):
        self.found: dict[Key, Sweep] = {}
        self.problems: dict[Key, str] = {}
        self.declined: Key | None = None            # cancelled: it waits to be asked for by hand
        self.key: Key | None = None                 # under way
        self.share = 0.0
        self._wake = wake
        self._cancelled = threading.Event()
        self._thread: threading.Thread | None = None

    def want(self, key: Key) -> None:
        """Measure this one next, unless it is known or was declined; another one under way is given up."""
        if key in self.found or key in self.problems or key in (self.key, self.declined):
            return
        if self._thread is not None and self._thread.is_alive():
            self._cancelled.set()
            return
        self.key, self.share, self.declined = key, 0.0, None
        self._cancelled.clear()
        self._thread = threading.Thread(target=self._measure, args=(key,), name="lensbench atlas", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Give up what is under way, and leave it until it is wanted again by `again`."""
        self.declined = self.key
        self._cancelled.set()

    def again(self, key: Key) -> None:
        """Measure what was declined after all."""
        self.declined = None
        self.want(key)

    def _progress(self, share: float) -> None:
        if self._cancelled.is_set():
            raise _GivenUpError
        if share - self.share > 0.02:
            self.share = share
            self._wake()

    def _measure(self, key: Key) -> None:
        family, title = key
        try:
            with progress_to(self._progress):
                sweep = FAMILIES[family][title]()
            if not self._cancelled.is_set():
                self.found[key] = sweep
        except _GivenUpError:
            pass
        except Exception as error:                      # said in the panel, where it is looked at
            self.problems[key] = f"{type(error).__name__}: {error}"
        finally:
            self.key = None
            self._wake()


class _GivenUpError(Exception):
    """Nobody waits for this any more."""
