"""Light fields in the background: recorded, opened, saved and compared one after the other, looked at meanwhile.

Two threads at most: one for what takes its time, with its progress and Cancel, and one that focuses, for which
the newest look counts alone. The window asks, and finds the answers in `recording`, `sight` and `said`.
"""

import math
import threading
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.light_field_query import (
    ArrayRecording,
    Look,
    Recorded,
    Recording,
    novel,
    picture_settings,
    radius,
    shown,
)
from lensbench.app.state.settings import Settings
from lensbench.app.workers.render_worker import prepare

COMPARED = 256                  # samples a pixel of the camera's own picture
HOLD_SECONDS = 0.1              # that a frame is held at most for the picture of its look


class FieldPicture(NamedTuple):
    """What a look at a recording has shown."""

    recording: Recorded
    look: Look                              # as far as the picture depends on it
    image: NDArray[np.float32]              # (h, w, 3) linear
    seconds: float
    covered: float = 1.0                    # the part of its pixels that was recorded


Wanted = tuple[Recorded, Look, lb.Depth | None]


class Compared(NamedTuple):
    """The camera's own picture, and how near the light field's comes to it."""

    field_picture: FieldPicture
    image: NDArray[np.float32]
    settings: Settings
    psnr: float                             # dB


@dataclass
class Task:
    """Work under way."""

    name: str
    share: float = 0.0
    cancelled: bool = False


class LightFieldWorker:
    """Has one recording at a time; see the module."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        """`woken` is called from other threads at every piece of news."""
        self._wake = wake
        self._change = threading.Condition()
        self.recording: Recorded | None = None
        self.field_picture: FieldPicture | None = None             # the newest
        self.depth: tuple[Recording, lb.Depth] | None = None
        self.compared: Compared | None = None
        self.said: list[tuple[str, bool]] = []      # what is to be told, and whether it tells of something done
        self.task: Task | None = None
        self._wanted: Wanted | None = None
        self._done: Wanted | None = None            # the newest that has come to a picture, or to an error
        self._since = 0.0                           # when the newest was asked for
        self._seconds = math.inf                    # that the picture before took
        self._stopped = False
        self._viewer: threading.Thread | None = None

    # The window's side

    def record(self, settings: Settings, views: tuple[int, int], moments: int = 1) -> None:
        """Record what the settings see, with their pixels and samples; the recording there is stays until then."""
        self._begin("Recording", lambda task: self._record(task, settings, views, moments))

    def expose(self, settings: Settings, pixels: int, f_number: float | None) -> None:
        """Record by a plenoptic camera: its microlenses, of this f-number, stand for the settings' pixels."""
        self._begin("Exposing", lambda task: self._expose(task, settings, pixels, f_number))

    def record_array(self, settings: Settings, views: tuple[int, int], spacing: float) -> None:
        """Record by pinholes, `spacing` mm apart."""
        self._begin("Recording", lambda task: self._record_array(task, settings, views, spacing))

    def open(self, path: Path) -> None:
        """Open a recording."""
        self._begin(f"Opening {path.name}", lambda task: self._open(task, path))

    def save(self, path: Path) -> None:
        """Save the recording."""
        self._begin(f"Saving {path.name}", lambda task: self._save(path))

    def compare(self, field_picture: FieldPicture) -> None:
        """Render with the camera what a look has shown."""
        self._begin("Rendering with the camera", lambda task: self._compare(task, field_picture))

    def want(self, look: Look) -> None:
        """Show the recording so, from now on."""
        if self.recording is None:
            return
        wanted = self.recording, look.asked, self.found if look.show == "depth" else None
        if wanted == self._wanted:
            return
        with self._change:
            self._wanted, self._since = wanted, perf_counter()
            if self._viewer is None:
                self._viewer = threading.Thread(target=self._show, name="lensbench light field", daemon=True)
                self._viewer.start()
            self._change.notify_all()

    def await_field_picture(self) -> None:
        """Hold the frame for the picture of the newest look, where it is about to come.

        Not beyond HOLD_SECONDS after it was asked for, and not at all where pictures take twice as long.
        """
        with self._change:
            if self._seconds < 2.0 * HOLD_SECONDS:       # frames drawn beside a picture make it so slow
                self._change.wait_for(lambda: self._done == self._wanted or self._stopped,
                                      max(0.0, self._since + HOLD_SECONDS - perf_counter()))

    @property
    def found(self) -> lb.Depth | None:
        """The depth of the recording, where it has been looked for."""
        depth = self.depth
        return depth[1] if depth is not None and depth[0] is self.recording else None

    def find_depth(self) -> None:
        """Look for the depth of everything that was recorded."""
        self._begin("Finding the depth", self._find_depth)

    def psnr(self, look: Look) -> float | None:
        """The dB by which the camera's own picture agrees with this look's, where it has been rendered."""
        compared = self.compared
        if compared is None:
            return None
        of = compared.field_picture
        return compared.psnr if of.recording is self.recording and of.look == look else None

    def cancel(self) -> None:
        """Give up what is under way."""
        if self.task is not None:
            self.task.cancelled = True

    def stop(self) -> None:
        """End."""
        self.cancel()
        with self._change:
            self._stopped = True
            self._change.notify_all()
        if self._viewer is not None:
            self._viewer.join()

    # What takes its time

    def _begin(self, name: str, work: Callable[[Task], None]) -> None:
        if self.task is not None:
            self.said.append((f"{self.task.name} is under way: cancel it first, or wait", False))
            return
        self.task = task = Task(name)

        def run() -> None:
            try:
                work(task)
            except (ValueError, OSError, MemoryError) as error:
                if not task.cancelled:
                    self.said.append((str(error) or "there is not enough memory for this light field", False))
            finally:
                self.task = None
                self._wake()

        threading.Thread(target=run, name=f"lensbench {name}", daemon=True).start()

    def _progress(self, task: Task, share: float) -> bool:
        task.share = share
        self._wake()
        return not (task.cancelled or self._stopped)

    def _record(self, task: Task, settings: Settings, views: tuple[int, int], moments: int) -> None:
        settings = settings.checked()
        camera, scene = prepare(settings)
        field = lb.capture_light_field(camera, scene, views, settings.samples, settings.seed,
                                       progress=lambda share: self._progress(task, share), moments=moments)
        self.recording = Recording(field, settings)

    def _expose(self, task: Task, settings: Settings, pixels: int, f_number: float | None) -> None:
        settings = settings.checked()
        camera, scene = prepare(settings)
        raw = lb.PlenopticCamera(camera, pixels, f_number).expose(scene, settings.samples, settings.seed,
                                                                  progress=lambda share: self._progress(task, share))
        self.recording = Recording(raw.decoded(), settings, raw)

    def _record_array(self, task: Task, settings: Settings, views: tuple[int, int], spacing: float) -> None:
        settings = settings.checked()
        camera, scene = prepare(settings)
        array = lb.capture_lumigraph(camera, scene, views, spacing, samples=settings.samples, seed=settings.seed,
                                     progress=lambda share: self._progress(task, share))
        self.recording = ArrayRecording(array, settings)

    def _open(self, task: Task, path: Path) -> None:
        recording = _opened(path)
        if not task.cancelled:
            self.recording = recording

    def _save(self, path: Path) -> None:
        from lensbench.app.files.light_field_file import save_light_field
        from lensbench.app.files.lumigraph_file import save_lumigraph

        recording = self.recording
        if isinstance(recording, ArrayRecording):
            save_lumigraph(path, recording.array, recording.settings)
        elif recording is not None:
            save_light_field(path, recording)
        if recording is not None:
            self.said.append((f"The light field was saved as {path.name}", True))

    def _compare(self, task: Task, field_picture: FieldPicture) -> None:
        from lensbench.app.files.export import render
        from lensbench.app.state.comparison import decibels

        look, recording = field_picture.look, field_picture.recording
        settings = replace(picture_settings(recording, look), samples=COMPARED)
        if isinstance(recording, Recording) and (look.view != (0.0, 0.0) or recording.of_moment(look) != (0, 1)):
            camera, scene = prepare(replace(settings, f_number=recording.settings.f_number))
            image: NDArray[np.float32] | None = lb.picture_through(
                camera, scene, look.view, radius(look, recording.field), COMPARED, settings.seed,
                recording.of_moment(look), lambda share: self._progress(task, share))
        else:
            image = render(settings, lambda share: self._progress(task, share), lambda: task.cancelled or self._stopped)
        if image is not None:
            self.compared = Compared(field_picture, image, settings, decibels(field_picture.image, image))

    def _find_depth(self, task: Task) -> None:
        if isinstance(recording := self.recording, Recording):
            self.depth = recording, lb.find_depth(recording.field, progress=lambda share: self._progress(task, share))

    # What is looked at

    def _show(self) -> None:
        while True:
            with self._change:
                while not self._stopped and self._wanted == self._done:
                    self._change.wait()
                if self._stopped:
                    return
                wanted = self._wanted
            assert wanted is not None
            recording, look, depth = wanted
            begin = perf_counter()
            try:
                covered = 1.0
                if isinstance(recording, ArrayRecording):
                    image, pixels = novel(recording, look)
                    covered = float(pixels.mean())
                else:
                    image = shown(recording, look, depth)
            except (ValueError, MemoryError) as error:
                self.said.append((str(error), False))
            else:
                self.field_picture = FieldPicture(recording, look, image, perf_counter() - begin, covered)
            with self._change:
                self._done, self._seconds = wanted, perf_counter() - begin
                self._change.notify_all()
            self._wake()


def _opened(path: Path) -> Recorded:
    """What the file turns out to hold; what its reader raises where that is nothing."""
    from lensbench.app.files.light_field_file import load_light_field
    from lensbench.app.files.lumigraph_file import load_lumigraph

    with suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(path) as archive:
        if "pictures.npy" in archive.namelist():
            return ArrayRecording(*load_lumigraph(path))
    return load_light_field(path)
