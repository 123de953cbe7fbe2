"""Light fields in the background: captured, opened, saved and compared one after the other, refocused meanwhile.

Two threads at most: a `Task` for what takes long, and one that renders pictures from the light field, for which only
the newest look counts: refocused coarsely at once, in full when still. The window asks, and finds the answers in
`recording`, `field_picture` and `messages`.
"""

import math
import threading
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.light_field_query import (
    ArrayRecording, Look, Recorded, Recording, light_field_picture, novel_view, picture_settings, radius
)
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.analysis_worker import STILL
from lensbench.app.workers.render_job import prepare
from lensbench.app.workers.task import Task, error_text, report_unforeseen

COMPARED = 256                  # samples a pixel of the camera's own picture
HOLD_SECONDS = 0.1              # that a frame is held at most for the picture of its look


class FieldPicture(NamedTuple):
    """A picture computed from a light field."""

    recording: Recorded
    look: Look                              # as far as the picture depends on it
    image: NDArray[np.float32]              # (h, w, 3) linear
    seconds: float
    covered: float = 1.0                    # the part of its pixels that was recorded
    number: int = 0                         # counts the pictures of the worker
    has_depth: bool = True                      # the depth that a look at the depth needs
    coarse: bool = False                    # a finer one follows when the look rests

    @property
    def coded(self) -> bool:
        """Whether its colours encode a depth or a confidence."""
        return self.has_depth and self.look.coded


Wanted = tuple[Recorded, Look, lb.Depth | None]
Progress = Callable[[float], bool]


class Compared(NamedTuple):
    """The camera's own picture, and how closely the light field's picture agrees with it."""

    field_picture: FieldPicture
    image: NDArray[np.float32]
    settings: Settings
    psnr: float                             # dB


class LightFieldWorker:
    """Has one recording at a time; see the module."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        """wake: called from other threads when there is something new to show."""
        self._wake = wake
        self._change = threading.Condition()
        self.recording: Recorded | None = None
        self.field_picture: FieldPicture | None = None  # the newest
        self.depth: tuple[Recording, lb.Depth] | None = None
        self.compared: Compared | None = None
        self.messages: list[tuple[str, bool]] = []      # for the user; True: a success
        self.task: Task | None = None                   # what takes long
        self._take: Callable[[Any], None] = lambda result: None     # takes the result of the task
        self._wanted: Wanted | None = None
        self._done: Wanted | None = None            # the newest that has led to a picture or to an error
        self._refines = False                       # whether that picture is coarse
        self._since = 0.0                           # when the newest was asked for
        self._seconds = math.inf                    # that the picture before took
        self._numbered = 0
        self._viewer: Task[None] | None = None      # renders pictures until it is cancelled

    # The window's side

    def record(self, settings: Settings, views: tuple[int, int], moments: int = 1) -> None:
        """Capture views through the lens, with the pixels and samples of the settings."""
        self._record("Recording the light field", settings, lambda camera, scene, settings, progress: Recording(
            lb.capture_light_field(camera, scene, views, settings.samples, settings.seed, progress=progress,
                                   moments=moments), settings))

    def expose(self, settings: Settings, pixels: int, f_number: float | None) -> None:
        """Expose a plenoptic camera; the settings' pixels are its microlenses, of this f-number."""
        def work(camera: Any, scene: lb.Scene, settings: Settings, progress: Progress) -> Recording:
            raw = lb.PlenopticCamera(camera, pixels, f_number).expose(scene, settings.samples, settings.seed,
                                                                      progress=progress)
            return Recording(raw.decoded(), settings, raw)

        self._record("Recording the light field", settings, work)

    def record_array(self, settings: Settings, views: tuple[int, int], spacing: float) -> None:
        """Capture views by an array of pinholes, `spacing` mm apart."""
        self._record("Recording the light field", settings, lambda camera, scene, settings, progress: ArrayRecording(
            lb.capture_lumigraph(camera, scene, views, spacing, samples=settings.samples, seed=settings.seed,
                                 progress=progress), settings))

    def _record(self, description: str, settings: Settings,
                work: Callable[[Any, lb.Scene, Settings, Progress], Recorded]) -> None:
        """Record by the camera and the scene of the settings."""
        def checked(task: Task) -> Recorded:
            valid = settings.checked()
            return work(*prepare(valid), valid, task.report)

        self._begin(description, checked, self._take_recording)

    def open(self, path: Path) -> None:
        """Open a recording."""
        self._begin(f"Opening {path.name}", lambda task: _opened(path), self._take_recording)

    def save(self, path: Path) -> None:
        """Save the recording."""
        recording = self.recording
        if recording is not None:
            self._begin(f"Saving {path.name}", lambda task: _save(path, recording),
                        lambda name: self.messages.append((f"Light field saved as {name}", True)))

    def compare(self, field_picture: FieldPicture) -> None:
        """Render with the camera the same view as a picture of the light field."""
        self._begin("Rendering with the camera", lambda task: _compared(task, field_picture), self._take_compared)

    def find_depth(self) -> None:
        """Estimate the depth of the whole recording."""
        if isinstance(recording := self.recording, Recording):
            self._begin("Finding the depth",
                        lambda task: (recording, recording.find_depth(progress=task.report)),
                        partial(setattr, self, "depth"))

    def want(self, look: Look) -> None:
        """Show the recording with this look from now on."""
        if self.recording is None:
            return
        request = self.recording, look.asked, self.known_depth if look.show == "depth" else None
        if request == self._wanted:
            return
        with self._change:
            self._wanted, self._since = request, perf_counter()
            if self._viewer is None:                # at full priority: the user waits for the picture
                self._viewer = Task("Refocusing", self._show, self._wake, lowered=False)
            self._change.notify_all()

    def await_field_picture(self) -> None:
        """Hold the frame up to HOLD_SECONDS for the newest look's picture, unless pictures take twice as long."""
        with self._change:
            if self._seconds < 2.0 * HOLD_SECONDS:       # frames drawn at the same time make pictures that slow
                self._change.wait_for(lambda: self._done == self._wanted or self._stopped,
                                      max(0.0, self._since + HOLD_SECONDS - perf_counter()))

    def collect(self) -> None:
        """Take the result of a task that is done. Call it in each frame."""
        task = self.task
        if task is None or not task.done:
            return
        self.task = None
        if task.error is not None:
            self.messages.append((task.message, False))
        elif not task.cancelled:
            self._take(task.result)

    def forget(self) -> None:
        """Let go of the recording and of all that was computed from it."""
        with self._change:
            self._wanted = self._done = None
        self.recording = self.field_picture = self.depth = self.compared = None

    @property
    def known_depth(self) -> lb.Depth | None:
        """The depth of the recording; None until it has been estimated."""
        depth = self.depth
        return depth[1] if depth is not None and depth[0] is self.recording else None

    def psnr(self, look: Look) -> float | None:
        """PSNR (dB) of this look's picture against the camera's own; None until that has been rendered."""
        compared = self.compared
        if compared is None:
            return None
        of = compared.field_picture
        return compared.psnr if of.recording is self.recording and of.look == look else None

    def cancel(self) -> None:
        """Cancel the task."""
        if self.task is not None:
            self.task.cancel()

    def stop(self) -> None:
        """End; returns when the thread of the pictures has ended."""
        self.cancel()
        if self._viewer is not None:
            with self._change:
                self._viewer.cancel()
                self._change.notify_all()
            self._viewer.join()

    # What takes long

    def _begin(self, description: str, work: Callable[[Task], Any], take: Callable[[Any], None]) -> None:
        self.collect()
        if self.task is not None:
            self.messages.append((f"{self.task.description} is under way: cancel it first, or wait", False))
            return
        self._take = take
        self.task = Task(description, work, self._wake)

    def _take_recording(self, recording: Recorded) -> None:
        shown = self.field_picture
        self.forget()
        self.recording, self.field_picture = recording, shown       # until there is one of the new recording

    def _take_compared(self, compared: Compared | None) -> None:
        if compared is not None:
            self.compared = compared

    # Pictures of the recording

    @property
    def _stopped(self) -> bool:
        return self._viewer is not None and self._viewer.cancelled

    def _show(self, viewer: Task[None]) -> None:
        while True:
            with self._change:
                while not viewer.cancelled and self._wanted in (None, self._done):
                    rest = self._since + STILL - perf_counter() if self._refines and self._wanted else None
                    if rest is not None and rest <= 0.0:
                        break
                    self._change.wait(rest)
                request, refined = self._wanted, self._wanted == self._done
            if viewer.cancelled or request is None:
                return
            self._answer(viewer, request, refined)
            del request                                  # a recording is large, and this thread waits for long

    def _answer(self, viewer: Task[None], request: Wanted, refined: bool) -> None:
        """Compute the picture that is wanted; nobody sees it if the recording was let go meanwhile."""
        recording, look, depth = request
        coarse = (not refined and look.show == "focus" and isinstance(recording, Recording)
                  and recording.field.wide is not None)
        begin, picture = perf_counter(), None
        try:
            covered = 1.0
            if isinstance(recording, ArrayRecording):
                image, pixels = novel_view(recording, look)
                covered = float(pixels.mean())
            else:
                image = light_field_picture(recording, look, depth, coarse)
                covered = 1.0 - recording.unknown(look) if isinstance(recording, Recording) else 1.0
        except Exception as error:                      # any error: the window shows it, and the next look may do
            self.messages.append((error_text(error, viewer.description), False))
            report_unforeseen(error)
        else:
            self._numbered += 1
            picture = FieldPicture(recording, look, image, perf_counter() - begin, covered, self._numbered,
                                   look.show != "depth" or depth is not None, coarse)
        with self._change:
            if not refined:                             # no frame is held for a refined picture
                self._seconds = perf_counter() - begin
            if self._wanted is not None:
                self._done, self._refines = request, coarse and picture is not None
                self.field_picture = picture or self.field_picture
            self._change.notify_all()
        self._wake()


def _save(path: Path, recording: Recorded) -> str:
    """Write the recording; returns the name of the file."""
    from lensbench.app.session.recordings import save_light_field, save_lumigraph

    if isinstance(recording, ArrayRecording):
        save_lumigraph(path, recording.array, recording.settings)
    else:
        save_light_field(path, recording)
    return path.name


def _compared(task: Task, field_picture: FieldPicture) -> Compared | None:
    """The camera's own picture; None after a cancellation."""
    from lensbench.app.bench.tone import decibels
    from lensbench.app.session.picture_render import render

    look, recording = field_picture.look, field_picture.recording
    settings = replace(picture_settings(recording, look), samples=COMPARED)
    if isinstance(recording, Recording) and (look.view != (0.0, 0.0) or recording.of_moment(look) != (0, 1)):
        camera, scene = prepare(replace(settings, f_number=recording.settings.f_number))
        image: NDArray[np.float32] | None = lb.picture_through(
            camera, scene, look.view, radius(look, recording.field), COMPARED, settings.seed,
            recording.of_moment(look), task.report)
    else:
        rendered = render(settings, task.report, lambda: task.cancelled)
        image = rendered[0] if rendered is not None else None
    return None if image is None else Compared(field_picture, image, settings, decibels(field_picture.image, image))


def _opened(path: Path) -> Recorded:
    """The light field or the array that the file holds; raises what its reader raises."""
    from lensbench.app.session.recordings import load_light_field, load_lumigraph

    with suppress(OSError, zipfile.BadZipFile), zipfile.ZipFile(path) as archive:
        if "pictures.npy" in archive.namelist():
            return ArrayRecording(*load_lumigraph(path))
    return load_light_field(path)
