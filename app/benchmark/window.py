"""Benchmark of the window on a virtual display: start, response to a slider, and frame rate during a render."""

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench import tone
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.bench.light_field_query import Look
from lensbench.app.benchmark.live import SMALL, DrivenSession, focused, run
from lensbench.app.settings.settings import Settings
from lensbench.app.window.window import IDLE_PACE
from lensbench.app.workers.light_field_worker import LightFieldWorker
from lensbench.app.workers.render_job import RenderUpdate

LENSES = tuple(lenses.names()[::17])     # of the library, each opened for the first time
MOVES = 16                      # moves of each dial
REST = 12                       # frames between two moves
DRAGGED = 30                    # pictures of a drag that does not rest
JUDGED = (10, 18, 26)           # those of them whose error is measured
TRUE_SAMPLES = 256              # of the picture that they are compared with
FRAMES = 160                    # frames timed during the render, and of the lens browser
PICTURES = 80                   # pictures timed of a light field
BROWSED = (1920, 1080)          # pixels of the window in which the lens browser is scrolled
START = "lensbench.app.command.start"
START_LIMIT = 300.0             # s

# By name: scene, and the settings after so many moves
DIALS: dict[str, tuple[str, Callable[[Settings, int], Settings]]] = {
    "focus": ("still-life", focused),
    "aperture": ("still-life", lambda settings, turn: replace(settings, f_number=2.0 * 2.0 ** (turn % 13 / 4.0))),
    "field of view": ("still-life", lambda settings, turn: replace(settings, crop=1.0 - 0.02 * turn)),
    "lens": ("still-life", lambda settings, turn: with_lens(settings, LENSES[turn % len(LENSES)])),
    "night-lights": ("night-lights", focused),
}


class Answer(NamedTuple):
    """From a move of a dial to its first picture on the screen."""

    seconds: float
    worked: float               # CPU seconds of all cores, without those of compilers
    compiled: int               # kernels that the picture waited for, or that were compiled meanwhile


def latencies(dial: str = "focus") -> list[Answer]:
    """What each move of a dial takes until its first picture is on the screen."""
    scene, turned = DIALS[dial]
    answers: list[Answer] = []
    rest, kernels = [0], [0]

    def watch(session: DrivenSession) -> bool:
        if session.moved and session.current:
            answers.append(Answer(time.perf_counter() - session.moved, time.process_time() - session.worked,
                                session.compilers.progress[1] - kernels[0]))
            session.moved, rest[0] = 0.0, REST
        elif not session.moved and session.move is None and session.current:
            rest[0] -= 1
            if rest[0] <= 0 and not session.compilers.busy:
                turn, kernels[0] = len(answers), session.compilers.progress[1]
                session.move = lambda settings: turned(settings, turn)
        return len(answers) > MOVES

    run(replace(SMALL, scene=scene), watch)
    return answers[1:]


def dragged_errors() -> tuple[float, float]:
    """Display error of one sample while the focus of still life is dragged, with the samples before and without.

    Root mean square of tone-mapped values (0 to 1, filmic), mean of some frames of a drag that does not rest.
    """
    shown: list[RenderUpdate] = []

    def watch(session: DrivenSession) -> bool:
        update = session.presenter.update
        if session.move is None and update is not None and session.current and (shown or session.settled(64)):
            shown.append(update)
            session.move = partial(focused, turn=len(shown))
        return len(shown) > DRAGGED

    run(SMALL, watch)
    errors = []
    for k in JUDGED:
        update = shown[k]
        settings = update.settings
        truth = lb.render(camera(replace(settings, lens_model="trace")), lb.builtin_scene(settings.scene),
                          TRUE_SAMPLES, seed=settings.seed + 1)
        plain = update.image if update.plain is None else update.plain
        errors.append([_display_error(image, truth) for image in (update.image, plain)])
    mixed, alone = np.mean(errors, 0)
    return float(mixed), float(alone)


def _display_error(image: np.ndarray, truth: np.ndarray) -> float:
    return math.sqrt(float(((tone.develop(image, 0.0, "filmic") - tone.develop(truth, 0.0, "filmic")) ** 2).mean()))


def paces() -> list[float]:
    """Seconds from frame to frame while two threads render."""
    marks: list[float] = []

    def watch(session: DrivenSession) -> bool:
        if session.settled(8):
            marks.append(time.perf_counter())
        return len(marks) > FRAMES

    run(SMALL, watch)
    return list(np.diff(marks[20:]))


def browsed() -> tuple[float, list[float]]:
    """Seconds until all thumbnails of the lens browser are made, and from frame to frame while it is scrolled."""
    from imgui_bundle import imgui

    opened = [0.0]
    made: list[float] = []
    marks: list[float] = []

    def watch(session: DrivenSession) -> bool:
        now = time.perf_counter()
        if not opened[0]:
            if session.settled(8):
                session.browsing.toggle()
                opened[0] = now
            return False
        if not made:
            if session.browsing.complete:
                made.append(now - opened[0])
            else:
                time.sleep(1.0 / IDLE_PACE)             # a window at rest: GLFW does not wait where there is no display
            return False
        io = imgui.get_io()
        io.add_mouse_pos_event(0.2 * BROWSED[0], 0.5 * BROWSED[1])
        io.add_mouse_wheel_event(0.0, -1.0 if len(marks) // 60 % 2 == 0 else 1.0)
        marks.append(now)
        return len(marks) > FRAMES

    run(SMALL, watch, size=BROWSED)
    return made[0], list(np.diff(marks[20:]))


def refocused() -> list[float]:
    """Seconds from picture to picture while the refocus ring of 9 × 9 views of 640 × 427 pixels turns."""
    return _dragged(lambda worker, settings: worker.record(settings, (9, 9)),
                    lambda look, now: replace(look, distance=800.0 + 700.0 * now % 1500.0))


def moved() -> list[float]:
    """Seconds from picture to picture while the viewpoint moves about 9 × 9 pinholes, 5 mm apart, of as many pixels."""
    return _dragged(lambda worker, settings: worker.record_array(settings, (9, 9), 5.0),
                    lambda look, now: replace(look, place=(12.0 * math.sin(now), 8.0 * math.cos(now), 0.0)))


def _dragged(record: Callable[[LightFieldWorker, Settings], None],
             turned: Callable[[Look, float], Look]) -> list[float]:
    """Seconds from picture to picture of a light field under a control that never rests."""
    marks: list[float] = []
    shown: list[object] = [None]

    def watch(session: DrivenSession) -> bool:
        controller = session.light_field
        if controller.worker.recording is None:
            if session.settled(1) and controller.worker.task is None:
                record(controller.worker,
                       replace(Settings(), pixels_x=640, pixels_y=427, lens_model="trace", samples=1))
        elif controller.field_picture is not None:
            if controller.field_picture is not shown[0]:
                shown[0] = controller.field_picture
                marks.append(time.perf_counter())
            controller.look = turned(controller.look, time.perf_counter())
        return len(marks) > PICTURES

    run(SMALL, watch)
    return list(np.diff(marks[20:]))


def start(cached: bool) -> float:
    """Seconds from starting Python to the first picture; cached: with compiled kernels in the cache."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    with tempfile.TemporaryDirectory() as folder:
        if not cached:
            environment["XDG_CACHE_HOME"] = folder
        done = subprocess.run([sys.executable, "-m", START, str(time.time())], env=environment,
                              capture_output=True, text=True, timeout=START_LIMIT, check=True)
    return float(done.stdout.split()[-1])


def drag() -> Iterator[tuple[str, float, str]]:
    """From a dial to its picture of 640 × 360 pixels in a window of 1280 × 720, and the error of a dragged picture.

    Moves that needed kernels which the cache lacked are given apart: one kernel takes longer than a hundred pictures.
    """
    for dial in DIALS:
        moves = latencies(dial)
        ready = [answer for answer in moves if not answer.compiled] or moves
        answers, worked, _ = np.array(ready).T * 1e3
        yield f"dial to picture, {dial}, median", float(np.median(answers)), "ms"
        yield f"dial to picture, {dial}, p95", float(np.percentile(answers, 95)), "ms"
        yield f"dial to picture, {dial}, CPU time of all cores, median", float(np.median(worked)), "ms"
        if len(ready) < len(moves):
            slowest = max(answer.seconds for answer in moves if answer.compiled)
            yield f"dial to picture, {dial}, where kernels were compiled first, longest", 1e3 * slowest, "ms"
    mixed, alone = dragged_errors()
    yield "display error while focus is dragged, 1 sample", 1e3 * mixed, "‰"
    yield "the same without reuse of samples", 1e3 * alone, "‰"


def window() -> Iterator[tuple[str, float, str]]:
    """Frames of the window during a render, and of light fields under a control that never rests."""
    frames = np.array(paces()) * 1e3
    yield "window frame with two rendering threads, median", float(np.median(frames)), "ms"
    yield "window frame with two rendering threads, p95", float(np.percentile(frames, 95)), "ms"
    again = np.array(refocused())
    yield "refocus ring turned: pictures of a light field in the window, median", 1.0 / float(np.median(again)), "/s"
    yield "viewpoint dragged: pictures of an array in the window, median", 1.0 / float(np.median(moved())), "/s"


def browser() -> Iterator[tuple[str, float, str]]:
    """The lens browser in a window of 1920 × 1080: making all thumbnails, and scrolling."""
    made, frames = browsed()
    yield "all thumbnails of the lens browser, first time", made, "s"
    yield "lens browser scrolled at 1920 × 1080: frames, median", 1.0 / float(np.median(frames)), "/s"
    yield "lens browser scrolled: frame time, p95", 1e3 * float(np.percentile(frames, 95)), "ms"


def starts() -> Iterator[tuple[str, float, str]]:
    """From starting Python to the first picture on the screen, with and without compiled kernels."""
    start(cached=True)
    yield "start to first picture, kernels cached", min(start(cached=True) for _ in range(2)), "s"
    yield "start to first picture, empty kernel cache", start(cached=False), "s"
