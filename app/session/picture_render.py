"""A picture rendered to a file: its samples, its noise, and what is kept so that a stopped render goes on.

The kept samples are an .npz next to the picture, `kept_path`. It holds the sums of all samples so far and the last
estimate of the noise, so that the finished picture is that of a render without a stop, bit for bit; and a checksum of
the files that the settings name, so that samples of an earlier lens or scene are never mixed with those of the current
ones.

The noise is estimated from the samples alone: those before and after an earlier estimate are two pictures of the same
scene, whose difference gives the noise of their mean. The earlier picture is part of the state, so that a render that
goes on estimates as one without a stop.
"""

import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from threading import Event
from time import perf_counter

import numpy as np

import lensbench as lb
from lensbench.app.bench.auto_model import is_automatic
from lensbench.app.bench.build import flare
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.exposure import exposed
from lensbench.app.scenes.scene_file import cached_scene, scene_files
from lensbench.app.session.export import ExportError, check_writable, checked_place, develop, parts, save_bands
from lensbench.app.session.recordings import TEXTS, load_arrays, save_arrays
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.sampling import centred_steps
from lensbench.core.optics.finding import Finding
from lensbench.lenses.file_error import open_regular

FIRST_LOOK = 8                  # samples at the first estimate of the noise
LOOKED = 1 << 20                # pixels by which the noise is estimated
LEAST_STEP, MOST_STEP = 1.1, 2.0        # growth of the samples between two estimates
NOISE_STATE = ("noise", "noise_samples", "noise_image")      # names of `Noise.state`


class Noise:
    """Noise of a picture while it is rendered: the root mean square error of its sRGB values, black 0 and white 1.

    Samples of a net are spread more evenly all together than in parts, so the estimate tends to be too high. Of a
    picture of more than LOOKED pixels, lines at even distances are examined. settings: for exposure and tone curve; the
    noise of a sensor is left out. goal: noise that is enough.
    """

    def __init__(self, settings: Settings, goal: float):
        self._settings, self._goal = replace(settings, noise=False), goal
        self._earlier: tuple[int, np.ndarray] | None = None
        self.noise: float | None = None

    @property
    def is_enough(self) -> bool:
        """Whether the picture of the last estimate is as good as wanted."""
        return self.noise is not None and self.noise <= self._goal

    @property
    def next_look(self) -> int:
        """Samples at which the noise is to be estimated next."""
        if self._earlier is None:
            return FIRST_LOOK
        samples = self._earlier[0]
        if self.noise is not None:
            grown = min(max((self.noise / self._goal) ** 2, LEAST_STEP), MOST_STEP)
        else:                               # of many samples whose noise was not estimated, few more tell it
            grown = MOST_STEP if samples <= FIRST_LOOK else LEAST_STEP
        return int(np.ceil(grown * samples))

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The last estimate, by name; `restore` goes on with it. Empty before the first look."""
        if self._earlier is None:
            return {}
        noise = np.nan if self.noise is None else self.noise
        values = (np.array(noise), np.array(self._earlier[0], np.int64), self._earlier[1])
        return dict(zip(NOISE_STATE, values, strict=True))

    def restore(self, state: Mapping[str, np.ndarray], rendering: lb.Rendering) -> None:
        """Go on from the `state` of a rendering of the same arguments, whose samples are restored; or ValueError."""
        if state.keys() != set(NOISE_STATE):
            raise ValueError("the estimate of the noise is incomplete")
        noise, samples, image = (state[name] for name in NOISE_STATE)
        current = _looked(rendering)
        if noise.shape or samples.shape or (image.shape, image.dtype) != (current.shape, current.dtype) or not (
                0 < int(samples) <= rendering.samples):
            raise ValueError("this is the noise of another picture")
        self._earlier = int(samples), image
        self.noise = float(noise) if np.isfinite(noise) else None

    def look(self, rendering: lb.Rendering) -> None:
        """Estimate the noise from the samples since the last look."""
        samples, image = rendering.samples, _looked(rendering)
        if self._earlier is not None:
            before, earlier = self._earlier
            later = (samples * image - before * earlier) / np.float32(samples - before)
            apart = self._codes(later) - self._codes(earlier)
            self.noise = float(np.sqrt(np.mean(apart**2, dtype=np.float64) / (
                samples / before + samples / (samples - before))))
        self._earlier = samples, image

    def _codes(self, image: np.ndarray) -> np.ndarray:
        codes = np.empty(image.shape, np.float32)
        for lines, light in zip(parts(codes), parts(exposed(self._settings, image)), strict=True):
            lines[:] = develop(light, self._settings)
        return codes


def _looked(rendering: lb.Rendering) -> np.ndarray:
    """The lines of a picture by which its noise is estimated."""
    h, w = rendering.shape
    every, top, rows = -(-h * w // LOOKED), 0, []
    for band in rendering.bands():
        rows.append(band[-top % every::every].copy())
        top += len(band)
    return np.concatenate(rows)


PASS_SECONDS = 0.2              # of rendering between two steps of the progress
KEEP_SECONDS = 60.0             # between two writings of the kept samples
READ_BYTES = 1 << 20            # of a file whose checksum is taken, at a time


def _never() -> bool:
    return False


@dataclass(frozen=True, eq=False)
class Rendered:
    """A picture that has been rendered, (h, w) pixels, with so many samples per pixel.

    noise: as `Noise` estimates it, if it was asked for. choice: of the automatic model, if that was asked for.
    findings: what the picture leaves out, as `Rendering.findings`.
    """

    shape: tuple[int, int]
    samples: int
    noise: float | None = None
    choice: lb.Choice | None = None
    findings: tuple[Finding, ...] = ()


class _StoppedError(Exception):
    """The render was cancelled or stopped."""


class _Render:
    """The render of some settings, before any ray; whole: all lines are held until the end, and not a band."""

    def __init__(self, settings: Settings, whole: bool):
        self.settings = settings
        view, scene, self.choice = camera(settings), cached_scene(settings.scene), None
        if is_automatic(settings):
            assert isinstance(view, lb.LensCamera)
            self.choice = lb.choose_model(view, scene)
            view = self.choice.applied(view)
        steps = None
        if settings.sample_view and settings.samples == 1:          # of the middle of each pixel, as `lb.depth_map`
            steps = centred_steps(view.film.pixels_x, view.film.pixels_y, view.stage_centre)
        self.rendering = lb.Rendering(view, scene, seed=settings.seed, view=settings.sample_view,
                                      light_tracing=settings.light_tracing, flare=flare(settings), in_bands=not whole,
                                      steps=steps)
        self._whole = whole

    def done(self, meter: Noise | None = None) -> Rendered:
        """What has been rendered."""
        rendering = self.rendering
        return Rendered(rendering.shape, rendering.samples, meter.noise if meter is not None else None, self.choice,
                        rendering.findings)

    def bands(self, progress: Callable[[float], object], cancelled: Callable[[], bool], threads: int | None,
              meter: Noise | None = None, kept: Path | None = None, stopping: Callable[[], bool] = _never,
              ) -> Iterator[np.ndarray]:
        """Render, and give the lines in bands from the top down; `_StoppedError` after a cancellation or a stop.

        As `export_render`; where the samples are kept, and a meter of the noise, need a whole render.
        """
        rendering, settings, (h, _) = self.rendering, self.settings, self.rendering.shape
        made_by = _maker(settings, rendering.camera, self.choice) if kept is not None else np.int64(0)
        if kept is not None and kept.exists():
            _restore(rendering, kept, settings, made_by, meter)
            if meter and rendering.samples >= meter.next_look:
                meter.look(rendering)
        threads = threads or os.cpu_count() or 1
        stopped = Event()
        batch, since = 1, perf_counter()
        with ThreadPoolExecutor(threads) as pool:
            try:
                while True:
                    while rendering.samples < settings.samples and not (meter and meter.is_enough):
                        before, n_lines = rendering.lines.start, len(rendering.lines)
                        progress((before + n_lines * rendering.samples / settings.samples) / h)
                        started = perf_counter()
                        step = min(batch, settings.samples - rendering.samples)
                        if meter and rendering.samples < meter.next_look:
                            step = min(step, meter.next_look - rendering.samples)
                        if not rendering.add(step, pool, lambda: not (stopped.is_set() or cancelled()), threads):
                            raise _StoppedError
                        now = perf_counter()
                        if now - started < 0.5 * PASS_SECONDS:
                            batch = 2 * step
                        if meter and rendering.samples >= meter.next_look:
                            meter.look(rendering)
                        stop = stopping()
                        if kept is not None and (stop or now - since > KEEP_SECONDS):
                            noise = meter.state if meter else {}
                            save_arrays(kept, settings, made_by=made_by, **rendering.state, **noise)
                            since = perf_counter()
                        if stop:
                            raise _StoppedError
                    yield from rendering.bands()
                    if not rendering.next_band():
                        break
            finally:
                stopped.set()               # so that the threads end soon after Ctrl-C
        progress(1.0)


def export_render(settings: Settings, path: str | Path, bits: int = 8,
                  progress: Callable[[float], object] = lambda fraction: None,
                  cancelled: Callable[[], bool] = _never, threads: int | None = None, text: bool = False,
                  noise: float | None = None, resume: bool = False,
                  stopping: Callable[[], bool] = _never) -> Rendered | None:
    """Render the settings and save the picture; None after a cancellation or a stop, where no picture is written.

    The picture is rendered and written band by band, unless noise or resume need all of it at a time. bits, text: as
    for `save_picture`. progress: receives the finished part, 0 to 1. cancelled: called by the rendering threads many
    times a second. threads: None for one a core. noise: stop as soon as the noise (`Noise`) is at most this; the
    samples of the settings are then the most. resume: keep the samples in `kept_path` on the way and when stopped, and
    begin with those that are there. stopping: called after each pass of samples, whether to stop there. ExportError for
    a path that cannot be written, which is tried before the work begins, and for kept samples of other settings or a
    damaged file of them.
    """
    path = Path(path)
    checked_place(path, text)
    check_writable(path)
    settings = settings.checked()
    kept = kept_path(path) if resume else None
    meter = None if noise is None else Noise(settings, noise)
    made = _Render(settings, whole=meter is not None or kept is not None)
    bands = made.bands(progress, cancelled, threads, meter, kept, stopping)
    try:
        first = next(bands)                 # of a whole render, all samples are there with the first band
        rendered = made.done(meter)
        save_bands(path, rendered.shape, chain([first], bands), replace(settings, samples=rendered.samples), bits, text,
                   rendered.choice)
    except _StoppedError:
        return None
    if kept is not None:
        kept.unlink(missing_ok=True)
    return rendered


def render(settings: Settings, progress: Callable[[float], object] = lambda fraction: None,
           cancelled: Callable[[], bool] = _never, threads: int | None = None, noise: float | None = None,
           ) -> tuple[np.ndarray, Rendered] | None:
    """All samples as a linear image (h, w, 3), float32; None after a cancellation. Arguments as of `export_render`."""
    meter = None if noise is None else Noise(settings, noise)
    made = _Render(settings, whole=True)
    try:
        image = np.concatenate([*made.bands(progress, cancelled, threads, meter)])
    except _StoppedError:
        return None
    return image, made.done(meter)


def kept_path(path: Path) -> Path:
    """Where the samples of a picture are kept while it is rendered."""
    return path.with_name(f"{path.name}.part.npz")


def _maker(settings: Settings, view: lb.Camera, choice: lb.Choice | None) -> np.int64:
    """Checksum of what besides the settings the samples depend on.

    It is of the version, the choice of the automatic model, and the contents of the files that the settings name: the
    lens with its glasses, the picture in the stop, the scene with its textures and meshes.
    """
    lens = (view.lens.surfaces, view.lens.stop_index, view.lens.positions) if isinstance(view, lb.LensCamera) else None
    image = view.lens.stop_image if isinstance(view, lb.LensCamera) else getattr(view, "stop_image", None)
    checksum = zlib.crc32(repr((version("lensbench"), choice and (choice.model, choice.degree), lens, image)).encode())
    for path in scene_files(settings.scene):
        with suppress(OSError), open_regular(path) as file:        # the scene itself has been read, or is an error
            while block := file.read(READ_BYTES):
                checksum = zlib.crc32(block, checksum)
    return np.int64(checksum)


def _restore(rendering: lb.Rendering, kept: Path, settings: Settings, made_by: np.int64, meter: Noise | None) -> None:
    """Begin with the kept samples and their noise; ExportError where they are not of this picture."""
    arrays, former = load_arrays(kept, "render that was stopped", "render --resume",
                                 lambda names: names - set(TEXTS) if "made_by" in names else set(),
                                 lambda headers, former: True, light=False, into=rendering.state)
    if replace(former, samples=settings.samples) != settings or int(arrays.pop("made_by")) != made_by:
        raise ExportError(f"{kept}: these are samples of an earlier lens or scene file, of other settings or of "
                          "another version: remove the file, or render without --resume")
    noise = {name: arrays.pop(name) for name in NOISE_STATE if name in arrays}
    try:
        rendering.restore(arrays)
        if meter and noise:
            meter.restore(noise, rendering)
    except ValueError as error:
        raise ExportError(f"{kept}: {error}: remove the file, or render without --resume") from error
