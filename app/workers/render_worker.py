"""Rendering in the background: settings in, the newest picture out.

A `Task` prepares cameras and scenes (and compiles kernels, the first time), a pool of threads renders. `restart`
returns at once, abandons the current pass within a millisecond and never waits. A picture is only ever replaced by a
later one.
"""

import math
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from lensbench.app.settings.settings import Settings
from lensbench.app.workers.render_job import (
    AutomaticModel, Failure, Finished, PictureBefore, PictureLights, RenderJob, RenderUpdate, prepare
)
from lensbench.app.workers.task import Task, lower_priority, thread_count

FIRST_SECONDS = 0.15        # for a first pass once started, so that pictures appear even during a drag
HOLD_SECONDS = 0.1          # after a restart, that a frame may be held for its first picture
PAUSED_SAMPLES = 4          # that new settings get while the render is paused
REST_SECONDS = 0.05         # without new settings: a rest
REUSED_SAMPLES = 16         # from which on a picture has no samples of the one before
DEPTH_SAMPLES = 4           # after which the depth map is made, unless it is wanted at once


class RenderWorker:
    """Renders the latest settings until their samples are reached; see the module."""

    def __init__(self, settings: Settings, wake: Callable[[], None] = lambda: None, threads: int | None = None,
                 urgent: bool = True, expect: Callable[[Settings], bool] = lambda settings: False):
        """Begin with these settings.

        wake: called from another thread when there is something new to show. urgent: the user waits for its first
        passes; False for a picture next to another one, all of whose threads have a low priority. expect: called with
        the settings before the first picture; True if kernels are compiled for it, by others: then it is rendered
        without light tracing until the kernels of that are compiled too.
        """
        self._wake, self._urgent, self._expect = wake, urgent, expect
        self._threads = threads or thread_count()
        self._change = threading.Condition()
        self._settings = settings
        self._generation = 1
        self._target = settings.samples
        self._paused = self._held = self._depth_wanted = False
        self._update: RenderUpdate | None = None
        self._shown: RenderUpdate | None = None
        self._followed = True                   # all panels show what `_shown` does
        self._failure: Failure | None = None
        self._set_up_for = 0                    # the generation whose picture is set up
        self._started = perf_counter()
        self._first_seconds = math.inf          # from the restart to the first picture, the last time
        self._reloaded = False                  # the automatic model was chosen for an older file
        with self._change:      # runs until it is cancelled; at full priority, for the user waits for the first pass
            self._task: Task[None] = Task("Rendering", self._work, wake, lowered=not urgent)

    # The window's side

    def restart(self, settings: Settings) -> int:
        """Render these settings from now on, or go on where only their samples differ. Returns the generation."""
        with self._change:
            is_new = settings.picture != self._settings.picture
            self._settings, self._target = settings, settings.samples
            if is_new:
                self.again()
            self._change.notify_all()
            return self._generation

    def again(self) -> None:
        """Restart the same picture."""
        with self._change:
            self._generation += 1
            self._started = perf_counter()
            self._change.notify_all()

    def reload(self, settings: Settings) -> None:
        """Render these settings again, because a file that they name has changed."""
        with self._change:
            self._settings, self._target, self._reloaded = settings, settings.samples, True
            self.again()

    def newest(self) -> RenderUpdate | None:
        """The newest picture, perhaps of an older generation; None before the first."""
        return self._update

    @property
    def generation(self) -> int:
        """Counts the restarts; updates of another generation are of older settings."""
        return self._generation

    @property
    def error(self) -> Failure | None:
        """Why the current generation cannot be rendered; None without an error."""
        failure = self._failure
        return failure if failure is not None and failure.generation == self._generation else None

    def await_set_up(self) -> None:
        """Hold the frame until the first pass of the current settings is under way: its set-up needs the GIL."""
        self._await(lambda: self._set_up_for == self._generation)

    def await_first(self) -> None:
        """Hold the frame for the first picture of the current settings, if it is about to come."""
        self._await(lambda: False)

    def _await(self, enough: Callable[[], bool]) -> None:
        """Until `enough` or a picture, up to HOLD_SECONDS after the restart; not where pictures take twice as long."""
        with self._change:
            if self._first_seconds < 2.0 * HOLD_SECONDS:       # frames drawn during a render make it so slow
                self._change.wait_for(lambda: enough() or self.waiting == 0.0 or not self.alive,
                                      max(0.0, self._started + HOLD_SECONDS - perf_counter()))

    def shown(self, update: RenderUpdate | None, followed: bool = True) -> None:
        """Note that an update is on the screen, and if `followed` in all panels too: further passes wait for these."""
        self._note(_shown=update, _followed=followed)

    @property
    def on_screen(self) -> bool:
        """Whether a frame with a picture of the current generation, or with its error, has been shown."""
        shown = self._shown
        return self.error is not None or shown is not None and shown.generation == self._generation

    @property
    def waiting(self) -> float:
        """Seconds since the restart without a picture of the current generation; 0 where there is one."""
        update = self._update
        current = update is not None and update.generation == self._generation
        return 0.0 if current or self.error is not None else perf_counter() - self._started

    @property
    def first_seconds(self) -> float:
        """Seconds from the newest restart that has a picture to its first one; inf before any."""
        return self._first_seconds

    @property
    def paused(self) -> bool:
        """Whether the render is held."""
        return self._paused

    def pause(self) -> None:
        """Hold the render; new settings still get their first samples."""
        self._note(_paused=True)

    def resume(self) -> None:
        """Go on after a pause."""
        self._note(_paused=False)

    def hold(self, is_held: bool) -> None:
        """Leave the processor to other work: new settings get as many samples as in a pause."""
        self._note(_held=is_held)

    def want_depth(self, is_wanted: bool) -> None:
        """Whether the depth map is needed with the first sample, and not a little later."""
        self._note(_depth_wanted=is_wanted)

    @property
    def alive(self) -> bool:
        """Whether it has not been stopped."""
        return not self._task.cancelled

    def stop(self) -> None:
        """End; returns when the threads have ended."""
        self._task.cancel()
        self._note()
        self._task.join()

    def _note(self, **changed: Any) -> None:
        """Change state that the threads wait for, and wake them."""
        with self._change:
            vars(self).update(changed)
            self._change.notify_all()

    # The worker's side

    def _work(self, task: Task[None]) -> None:
        self._traces_lights, self._warming = not self._expect(self._settings), False
        # The user waits for the first pass; the others run behind the window
        with ThreadPoolExecutor(1, "lensbench choice", initializer=lower_priority) as choices, \
                ThreadPoolExecutor(1, "lensbench light", initializer=lower_priority) as lights, \
                ThreadPoolExecutor(4, "lensbench pass") as passes, \
                ThreadPoolExecutor(self._threads, "lensbench first",
                                   initializer=None if self._urgent else lower_priority) as first, \
                ThreadPoolExecutor(self._threads, "lensbench ray", initializer=lower_priority) as pool:
            self._model, self._before = AutomaticModel(choices), PictureBefore()
            self._first_pool, self._pool = first, pool
            self._lights = PictureLights(lights, pool, self._threads, lambda: self.alive, self._is_awaited)
            job: RenderJob | None = None
            while True:
                with self._change:
                    self._change.wait_for(partial(self._due, job))
                    if task.cancelled:
                        return
                    generation, settings = self._generation, self._settings
                    reloaded, self._reloaded = self._reloaded, False
                try:
                    if reloaded:
                        self._model.forget()
                        self._before = PictureBefore()
                    if job is None or job.generation != generation:
                        job = self._begun(generation, settings)
                        self._note(_set_up_for=generation)
                    self._advance(job, passes)
                except Exception as error:              # any error: the window shows it and goes on
                    self._note(_failure=Failure(generation, settings, error))
                    job = None
                    self._wake()

    def _due(self, job: RenderJob | None) -> bool:
        """Whether there is anything to do."""
        if not self.alive or self.error is not None:
            return not self.alive
        return (job is None or job.generation != self._generation or self._depth_due(job)
                or job.rendering.is_borrowing or job.automatic is not None or self._timing_due(job)
                or job.rendering.samples < self._present_target)

    @property
    def _present_target(self) -> int:
        return min(self._target, PAUSED_SAMPLES) if self._paused or self._held else self._target

    def _depth_due(self, job: RenderJob) -> bool:
        return job.depth is None and job.rendering.samples >= (
            1 if self._depth_wanted else min(DEPTH_SAMPLES, self._target))

    def _begun(self, generation: int, settings: Settings) -> RenderJob:
        camera, scene = prepare(settings.checked())
        job = RenderJob(generation, settings, camera, scene, light_tracing=self._traces_lights)
        job.camera, is_provisional = self._model.first_camera(settings, camera)
        job.automatic = camera if is_provisional else None
        job.begin(self._before.layer(job.scene, job.camera))
        return job

    def _compile_light_tracing(self, scene: Any) -> None:
        """Compile its kernels by the lights of a small picture; then begin the picture again with light."""
        from lensbench.core.scenery.small_lights import small_lights

        def begin_again() -> None:
            self._traces_lights = True
            if small_lights(scene.objects) and self.alive:
                self.again()

        self._warming = True
        self._lights.warm_up(scene, begin_again)

    def _is_awaited(self) -> bool:
        """Whether the user waits for a first picture, or for the panels that follow it."""
        follows = not self._followed and perf_counter() < self._started + self._first_seconds + HOLD_SECONDS
        return self.waiting > 0.0 or follows

    def _light(self, job: RenderJob, finished: Finished) -> None:
        """Give the picture its own light."""
        light = self._lights.of(job.rendering, job.scene, self._before, finished)
        if light is None:
            return
        job.rendering.adopt(light)
        self._before.lend(job.scene, job.rendering.layer())
        if job.rendering.samples:
            self._show(job)
        else:                           # the camera's rays saw other light before
            job.before = job.mixed = None

    def _choose(self, job: RenderJob, finished: Finished) -> None:
        """Choose the automatic model; restart with it if it differs from that of the first pass."""
        camera = self._model.chosen_camera(job.settings, job.automatic, job.scene, finished)
        if camera is None:
            return
        job.automatic = None
        if (camera.model, camera.degree) != (job.camera.model, job.camera.degree):
            job.camera = camera
            job.mixed = None
            job.begin(self._before.layer(job.scene, job.camera))
        else:
            self._amend(job, **self._choice_fields(job))

    def _choice_fields(self, job: RenderJob) -> dict[str, Any]:
        return self._model.fields(job.settings, job.camera, job.automatic is not None) | (
            {"is_provisional": True} if job.rendering.is_borrowing else {})

    def _timing_due(self, job: RenderJob) -> bool:
        return (job.automatic is None and job.depth is not None
                and not self._model.is_timed(job.settings, job.camera))

    def _amend(self, job: RenderJob, **changed: Any) -> None:
        """Add to the current update, if it is of this job."""
        if self._update is not None and self._update.generation == job.generation:
            self._update = self._update._replace(**changed)
            self._wake()

    def _advance(self, job: RenderJob, passes: ThreadPoolExecutor) -> None:
        """One pass: the first of one sample, the next of as many as fit between two pictures; or what follows these."""
        start = perf_counter()
        first, rendering = job.rendering.samples == 0, job.rendering
        awaited = first and (self._update is None or self._update.generation != job.generation)     # not a second model
        patience = start + FIRST_SECONDS if awaited else start

        def goes_on() -> bool:
            return self.alive and (job.generation == self._generation or perf_counter() < patience)

        finished = partial(self._finished, goes_on=goes_on)
        if job.rendering.is_borrowing and job.rendering.samples:
            self._light(job, finished)
            return
        if job.automatic is not None and job.rendering.samples:
            self._choose(job, finished)
            return
        if self._timing_due(job):
            if self._model.time(job.settings, job.camera, finished):
                self._amend(job, **self._choice_fields(job))
            return
        if self._depth_due(job):
            import lensbench as lb

            depth = self._pool.submit(lb.depth_map, job.camera, job.scene)
            if not finished(depth):
                return
            job.depth = depth.result()
            self._amend(job, depth=job.depth)
            return

        pool = self._first_pool if first else self._pool
        count = max(1, min(job.pass_samples, self._present_target - rendering.samples))
        added = passes.submit(rendering.add, count, pool, goes_on)
        if first and job.before is None:
            job.before = self._before.samples(job.settings, rendering, pool, self._threads)
        if not finished(added) or not added.result():
            return
        seconds = perf_counter() - start
        job.timed(count, seconds)
        if goes_on() or awaited:
            update = self._show(job)
            if first:                                   # neither the next pass nor the light must slow the frame down
                if not rendering.is_borrowing:
                    self._before.lend(job.scene, rendering.layer())
                at_rest = self._follow(job, update)
                if rendering.is_borrowing:
                    if at_rest or not self._lights.are_recent:
                        self._lights.begin(job.rendering, job.scene, self._before)
                elif not (self._traces_lights or self._warming):
                    self._compile_light_tracing(job.scene)

    def _follow(self, job: RenderJob, update: RenderUpdate) -> bool:
        """Wait until a frame shows the first picture, and its panels the settings, or until there are other settings.

        Returns whether there are none. Traced soon after other lights, those of a drag would slow its pictures down:
        they wait for a rest.
        """
        def is_past() -> bool:                          # a frame with other settings waits for this thread
            return job.generation != self._generation or not self.alive

        with self._change:
            self._change.wait_for(lambda: self._shown is update and self._followed or is_past(), HOLD_SECONDS)
            if job.rendering.is_borrowing and self._lights.are_recent:
                self._change.wait_for(is_past, REST_SECONDS)
            return not is_past()

    def _show(self, job: RenderJob) -> RenderUpdate:
        """Hand the picture so far to the window, its first samples with those of the picture before."""
        rendering, plain = job.rendering, None
        camera_image, light = rendering.camera_image(), rendering.light()
        image = (camera_image if light is None else camera_image + light).astype(np.float32, copy=False)
        job.mixed = None
        if job.before is not None and rendering.samples < min(REUSED_SAMPLES, self._present_target):
            job.mixed = job.before.mixed(camera_image, rendering.samples, self._first_pool, self._threads)
            plain, image = image, job.mixed.image if light is None else job.mixed.image + light
        self._before.keep(job.settings, rendering, job.mixed, camera_image, job.depth)
        update = RenderUpdate(job.generation, image, rendering.samples, job.seconds, job.settings, job.rate, job.depth,
                              plain=plain, findings=rendering.findings, **self._choice_fields(job))
        with self._change:
            if self.waiting and job.generation == self._generation:
                self._first_seconds = perf_counter() - self._started
            self._update = update
            self._change.notify_all()
        self._wake()
        return update

    def _finished(self, work: Future, goes_on: Callable[[], bool]) -> bool:
        """Wait for work while it is wanted, for its threads may be slow to stop; cancel it if it has not begun."""
        def tell(_: Future) -> None:
            with self._change:
                self._change.notify_all()

        work.add_done_callback(tell)
        with self._change:
            while not work.done() and goes_on():
                self._change.wait(FIRST_SECONDS)
        work.cancel()                                   # has no effect on work that has begun
        return work.done() and not work.cancelled() and self.alive
