"""The chart of the present lens's models, measured in the background for the latest settings that have come to rest."""

import threading
from collections.abc import Callable
from dataclasses import replace
from time import monotonic

from lensbench.app.state.figures import optical
from lensbench.app.state.settings import Settings
from lensbench.app.studies.charts.values import Chart

STILL = 0.5                     # seconds that settings must have stood still
SECONDS = 0.04                  # for the timings of each model


def charted(settings: Settings) -> Settings:
    """What a chart depends on: everything else is set to its default."""
    return optical(settings).plain("model", "degree", "medium", "limit")


class ChartWorker:
    """Measures one chart at a time; the window asks in each frame, and finds the newest in `chart`."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        """`woken` is called from the other thread at every piece of news."""
        self._wake = wake
        self.chart: Chart | None = None
        self.of: Settings | None = None             # what the chart, or the problem, is of
        self.problem = ""                           # why there is no chart of these settings
        self.share: float | None = None             # of the work that is done; None: nothing is under way
        self._asked: tuple[Settings, float] | None = None       # the latest settings, and since when
        self._measuring: Settings | None = None
        self._refused: Settings | None = None       # whose chart was cancelled
        self._stopped = False

    def want(self, settings: Settings) -> None:
        """Measure these settings once they have stood still, unless that has been done; give up what they replace."""
        key = charted(settings)
        if self._asked is None or self._asked[0] != key:
            self._asked = (key, monotonic())
        if self.share is None and key not in (self.of, self._refused) and monotonic() - self._asked[1] > STILL:
            self._begin(key)

    def again(self) -> None:
        """Measure once more."""
        if self.share is None and self._asked is not None:
            self._begin(self._asked[0])

    def cancel(self) -> None:
        """Give up what is under way, and leave it so until the settings change."""
        self._refused = self._measuring

    def stop(self) -> None:
        """End."""
        self._stopped = True

    def _begin(self, key: Settings) -> None:
        self.share, self._measuring, self._refused = 0.0, key, None
        threading.Thread(target=self._measure, args=(key,), name="lensbench chart", daemon=True).start()

    def _progress(self, share: float) -> bool:
        self.share = share
        self._wake()
        current = self._asked is not None and self._asked[0] == self._measuring
        return current and self._refused != self._measuring and not self._stopped

    def _measure(self, key: Settings) -> None:
        import lensbench as lb
        from lensbench.app.state.build import camera
        from lensbench.app.studies.charts.models import chart
        from lensbench.app.studies.charts.subjects import Subject
        from lensbench.app.studies.timing import StoppedError

        try:
            camera_ = camera(replace(key, model="trace"))
            assert isinstance(camera_, lb.LensCamera)
            found = chart(Subject(key.lens, camera_.lens.name, camera_), self._progress, SECONDS, in_the_renderer=False)
            self.chart, self.problem, self.of = found, "", key
        except StoppedError:
            pass
        except (ValueError, OSError) as error:
            self.chart, self.problem, self.of = None, str(error), key
        finally:
            self.share = None
            self._wake()
