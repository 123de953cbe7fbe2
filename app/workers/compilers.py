"""Kernels that are compiled ahead, by other processes, so that no picture and no thread of the window compiles any.

Numba compiles one function at a time in a process, and a thread that loads a compiled kernel waits for it meanwhile. So
other processes compile, and leave the kernels in the common cache.

Of a window, as many compile as there are cores. They begin with the kernels of the first picture, which are known
beforehand: a picture asks for one after the other. A thread of the window that needs a kernel waits for it; the thread
that draws does not: `NotCompiledError` ends the drawing of one panel, which shows the progress until the kernel is
there. After the first picture one more process, at the lowest priority, compiles what later first uses need.

Of a command, one process compiles the scene's kernels, the last one first, for the command itself reaches them last:
`python -m lensbench.app.workers.compilers SCENE`.
"""

import gc
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from queue import PriorityQueue
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float32, float64, int64, types, uint32

from lensbench.app.bench.build import bench_of, prescription
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.scenes.scene_file import cached_scene, find_scene
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.kernel import PROCESS, Kernel
from lensbench.app.workers.task import thread_count
from lensbench.core.cameras import pupil_footprint, ray_generation
from lensbench.core.imaging import film
from lensbench.core.kernels import cache, program, sampling
from lensbench.core.kernels.cache import NotCompiledError, is_compiled
from lensbench.core.kernels.program import Code, is_stage_compiled, stage_address, stage_signature
from lensbench.core.optics import axial_bundle, axis_contrast, block_trace, surfaces
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.pupils import irregular_regions, radial_sampler, rim_solver
from lensbench.core.rendering.progressive import Rendering
from lensbench.core.scenery.small_lights import small_lights

TRACED = ("auto", "trace", "polynomial")        # lens models whose first picture needs the pupil of the lens
END, PLANNED, DRAWN, AWAITED = range(4)     # order of the queue; panels get theirs once the first picture has its own
LOWEST = 19                     # the nice value of the process that compiles for later
LATER = "from lensbench.app.workers.shipped_kernels import exercise; exercise(str)"     # small pictures of every kind
TITLES = ("lens", "camera", "scene", "light")      # of the parts of the plan of a start
PARTS = {"optics": "lens", "pupils": "lens", "lens_models": "lens", "analysis": "lens", "scenery": "scene",
         "rendering": "light"}  # what the kernels of a room are for; all others are for the camera


def missing_kernels(settings: Settings) -> list[tuple[Any, Any]]:
    """Kernels and signatures of the first picture that are compiled nowhere; ValueError, OSError."""
    return [(kernel, signature) for kernel, signature in dict.fromkeys(_needed(settings))
            if not is_compiled(kernel, signature)]


def _needed(settings: Settings) -> Iterator[tuple[Any, Any]]:
    """Kernels of a first picture with their signatures: first those that set up the lens, then those of its passes.

    Those of any scene, and of a lens of rotational symmetry, longest compilations first: others ask for theirs.
    """
    single = stage_signature(np.float32)
    line, table, numbers = float64[::1], float64[:, ::1], float32[:, ::1]
    code = _code(float32)
    if settings.has_lens and settings.lens_model in TRACED and (
            lens := prescription(settings)).is_rotationally_symmetric:
        rows = types.NamedTuple((int64[::1], boolean[::1], table), surfaces.SurfaceTable)
        tracer = types.NamedTuple((_tracer(float64), _tracer(float32), float64), block_trace.ClearanceTracer)
        yield axial_bundle.trace_bundles, (rows, line, line, float64[:, :, ::1], *[float64[:, :, :, ::1]] * 2, table)
        yield block_trace.clearances, (line, line, line, line, line, float64, line, tracer, float64)
        yield rim_solver.rim_distances, (*[line] * 6, table, table, table, float64, float64, float64, table, tracer,
                                         float64)
        yield rim_solver._centres, (line, float64, *[line] * 5, tracer)
        yield radial_sampler.aim_radial, single
        yield surfaces._sags, (rows, line, line, line)
        yield radial_sampler.equal_areas, (float64[:, :, ::1], int64)
        yield rim_solver._directions, (line, table, line, line, float64, table, table, table)
        for step in surface_steps(lens, 1.0):
            yield step.kernel, single
            yield step.kernel, stage_signature(np.float64)
        yield rim_solver.project_rear_rim, (line, line, line, float64)
        yield irregular_regions._search_boxes, (line, float64[:, :, ::1], int64)
        yield irregular_regions._contradictions, (table, table, boolean[:, :, ::1], line, float64[:, :, ::1])
        yield rim_solver._centroids, (line, table, line, line)
        yield film.film_from_raster, single
    if settings.has_lens and settings.focus_position == "auto":
        yield axis_contrast._add_modulus, (table, table, line, boolean, float64, float64, line)
    scene = cached_scene(settings.scene)
    for step in reversed(scene.steps()):                # light and shadows, at the end, take longest
        yield step.kernel, single
    if scene.is_patterned or scene.is_rough:
        yield program._run, (numbers, int64[::1], numbers, int64[::1], float32[::1], code)
        yield ray_generation.pixel_spread, single
    if scene.is_rough:
        yield pupil_footprint.pupil_size, single
        yield pupil_footprint.pupil_part, single
    yield sampling.sample_pixels, single
    yield sampling.sample_lights, single
    yield program._expose, (numbers, float32[::1], code, int64, int64, int64[:, ::1], float32[::1], uint32,
                           int64)
    yield sampling._unroll, (numbers, float32[::1], float32[:, :, ::1])


def _code(real: Any) -> Any:
    """Type of a `Code` with parameters of the type `real`."""
    return types.NamedTuple((int64[::1], boolean[::1], boolean[::1], real[::1], int64[::1], int64[:, ::1]), Code)


def _tracer(real: Any) -> Any:
    """Type of the lane buffer, code and key of a `ClearanceTracer`."""
    return types.Tuple((real[::1], _code(real), uint32[::1]))


def prepare(settings: Settings) -> None:
    """Compile what the panels use: compute once what each shows of these settings. The panels show the errors."""
    from lensbench.app.plots.blur import curves, plot_range
    from lensbench.app.plots.exit_pupil import box_samples
    from lensbench.app.plots.pixel_spot import pixel_readings
    from lensbench.app.plots.section import sketch

    with suppress(ValueError, OSError):
        got = readings(settings)
        sketch(settings)
        curves(settings.optics, *plot_range(got)[:2])
        built = bench_of(settings)
        box_samples(built.lens, built.film_distance, 0.0)
        pixel_readings(settings, (0.5 * settings.film.pixels_x, 0.5 * settings.film.pixels_y))


class Part(NamedTuple):
    """What is to be compiled for one purpose."""

    title: str
    done: int
    total: int                  # so far, with all that the first picture is known to need


class Compilers:
    """The processes of one window: `begin` before its first kernel, `stop` at its end, `leave` after its threads."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        self._wake = wake
        self._change = threading.Condition()
        self._wanted: dict[tuple, Kernel] = {}      # by their keys; also those that are done
        self._done: set[tuple] = set()
        self._queue: PriorityQueue[tuple[int, int, tuple]] = PriorityQueue()
        self._processes: list[subprocess.Popen] = []
        self._drawing: int | None = None            # the thread that never waits
        self._threads: list[threading.Thread] = []
        self._stopped = False
        self._inside = threading.local()

    def begin(self) -> None:
        """Compile for this process from now on."""
        cache.missing = self._want

    def draw_here(self) -> None:
        """Never let this thread wait: it draws the window."""
        self._drawing = threading.get_ident()

    def expect(self, settings: Settings) -> bool:
        """Compile what the first picture of the settings needs, before it asks for it; whether anything is missing."""
        try:
            kernels = [Kernel.of(kernel.py_func, signature) for kernel, signature in missing_kernels(settings)]
        except (ValueError, OSError):               # of the lens or the scene: the render reports it
            return False
        with self._change:
            for kernel in kernels:
                self._ask(kernel, PLANNED)
        return bool(kernels)

    def stop(self) -> None:
        """End; threads that wait for a kernel, or need one from now on, get a `NotCompiledError`."""
        with self._change:
            if self._stopped:
                return
            self._stopped = True
            self._change.notify_all()
        for _ in self._threads:
            self._queue.put((END, 0, ()))
        for process in self._processes:
            with suppress(OSError):
                process.kill()
                process.wait()
        for thread in self._threads:
            thread.join(1.0)                        # longer only where it compiles itself
        for process in self._processes:
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with suppress(OSError):
                        pipe.close()
        self._processes = []

    def leave(self) -> None:
        """Let this process compile for itself again, after the threads of the window have ended."""
        if cache.missing == self._want:
            cache.missing = None

    def compile_for_later(self, code: str = LATER) -> None:
        """If a kernel was missing in this session, compile those of all other first uses, at the lowest priority."""
        with self._change:
            if self._stopped or not self._wanted:
                return
            with suppress(OSError):
                self._processes.append(subprocess.Popen(
                    [sys.executable, "-c", f"import os; os.nice({LOWEST}); {code}"] if hasattr(os, "nice")
                    else [sys.executable, "-c", code],
                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

    # Progress

    @property
    def busy(self) -> bool:
        """Whether a kernel is wanted that is not compiled yet."""
        return len(self._done) < len(self._wanted)

    @property
    def progress(self) -> tuple[int, int]:
        """Kernels that are compiled, and wanted so far."""
        return len(self._done), len(self._wanted)

    def plan(self) -> list[Part]:
        """What a first picture needs, part by part; empty where nothing was missing."""
        with self._change:
            needed, done = list(self._wanted), set(self._done)
        if not needed:
            return []
        counts = {title: [0, 0] for title in TITLES}
        for key in needed:
            count = counts[PARTS.get(key[0].split(".")[2], "camera")]
            count[0] += key in done
            count[1] += 1
        return [Part(title, have, asked) for title, (have, asked) in counts.items() if asked]

    # The threads that need a kernel

    def _want(self, function: FunctionType, signature: Any) -> None:
        """Return when a kernel is compiled; at once on a thread that itself compiles where no process can."""
        if getattr(self._inside, "compiles", False):
            return
        kernel = Kernel.of(function, signature)
        key, waits = kernel.key, threading.get_ident() != self._drawing
        with self._change:
            if key in self._done and waits:         # and yet not in the cache: it cannot be kept there
                return
            self._ask(kernel, AWAITED if waits else DRAWN)
            if waits:
                self._change.wait_for(lambda: key in self._done or self._stopped)
            if not waits or self._stopped:
                raise NotCompiledError(f"{kernel.module}.{kernel.name} is being compiled")

    def _ask(self, kernel: Kernel, priority: int) -> None:
        """Queue a kernel unless it is queued or done, and begin to serve the queue."""
        if kernel.key not in self._wanted:
            self._wanted[kernel.key] = kernel
            self._queue.put((priority, len(self._wanted), kernel.key))
            if len(self._threads) < thread_count():
                self._threads.append(threading.Thread(target=self._serve, name="lensbench compiler", daemon=True))
                self._threads[-1].start()

    def _serve(self) -> None:
        """Hand kernels to one process until the end."""
        process: subprocess.Popen | None = None
        while True:
            _, _, key = self._queue.get()
            if self._stopped:
                return
            kernel = self._wanted[key]
            if process is None or process.poll() is not None:
                process = self._started()
            if not (process is not None and _answered(process, kernel)) and not self._stopped:
                self._inside.compiles = True        # no process can: this thread can, though the window stutters
                with suppress(Exception):           # whoever needs the kernel gets the error
                    kernel.compile()
                self._inside.compiles = False
            with self._change:
                self._done.add(key)
                self._change.notify_all()
            self._wake()

    def _started(self) -> subprocess.Popen | None:
        with self._change:
            if self._stopped:
                return None
            try:
                process = subprocess.Popen([sys.executable, "-m", PROCESS], stdin=subprocess.PIPE,
                                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
            except OSError:
                return None
            self._processes.append(process)
            return process


def _answered(process: subprocess.Popen, kernel: Kernel) -> bool:
    """Whether a process has compiled a kernel."""
    assert process.stdin is not None and process.stdout is not None
    try:
        pickle.dump(kernel, process.stdin)
        process.stdin.flush()
        return process.stdout.readline() == b"compiled\n"
    except (OSError, ValueError, pickle.PicklingError):
        return False


@contextmanager
def compiling_ahead(scene: str) -> Iterator[subprocess.Popen | None]:
    """The process that helps a command, started if a kernel of its scene is not compiled; it ends with the block.

    What it has compiled by then is kept. If it fails, this process compiles the kernels itself.
    """
    helper = _helper(scene)
    try:
        yield helper
    finally:
        if helper is not None:
            helper.terminate()
            helper.wait()


def _helper(scene: str) -> subprocess.Popen | None:
    try:
        compiled = all(is_stage_compiled(step.kernel, np.float32) for step in cached_scene(scene).steps())
        return None if compiled else subprocess.Popen(
            [sys.executable, "-m", "lensbench.app.workers.compilers", scene],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (ValueError, OSError):       # of the scene: the worker reports it; of the process: it is not needed
        return None


def trace_lights(scene: Any) -> None:
    """Trace the small lights of a scene in a small picture, and so compile what that needs."""
    if small_lights(scene.objects):
        Rendering(camera(Settings(lens_model="trace", pixels_x=60, pixels_y=40)), scene).add(2, threads=1)


if __name__ == "__main__":
    gc.disable()                                # an eighth of the time
    scene = find_scene(sys.argv[1])
    for step in reversed(scene.steps()):
        stage_address(step.kernel, np.float32)
    trace_lights(scene)
