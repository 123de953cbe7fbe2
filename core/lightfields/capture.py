"""Capture of a light field: a picture and a coverage through every cell of the pupil, by the stages that take pictures.

A view is sharper than a picture: its samples fill only a part of each pixel. Refocusing adds views whose pixels are
offset against each other, which fills the pixels again; two averages could not be separated any more.
"""

import math
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields, replace
from itertools import count
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import DTypeLike

from lensbench.core.cameras.base import Camera
from lensbench.core.imaging.coordinate_spaces import film_window
from lensbench.core.imaging.film import Film
from lensbench.core.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.core.kernels.block import PIXEL, TIME, WEIGHT, B, Step, X, Y, lane_buffer, rows, stage
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps, strip_count, unit_disk
from lensbench.core.lightfields.light_field import (
    FINER, SPREAD, LightField, LightFieldError, axis_coverage, spread_offsets
)
from lensbench.core.lightfields.pupil_cells import Cell, cell_steps, lit_cell, pupil_reach, sample_disk
from lensbench.core.optics.glass import D_LINE
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import fixed

Item = TypeVar("Item")

# Parameters of `place_samples`: side of the sampled part of a pixel, offset to the right and down; pixels
RECORDER_FILL, OFFSET_X, OFFSET_Y = range(3)
# Parameters of `sample_moment`: length and start, in [0, 1) of the exposure
LENGTH, START = range(2)


class _Counted(NamedTuple):
    """A program and the sums (blocks · B,) of its weights, which its stage `sum_weights` writes."""

    program: Program
    weights: np.ndarray


@dataclass(frozen=True)
class Recorder:
    """Takes pictures strip by strip. camera: its model resolved; seed: sampler seed."""

    camera: Camera
    scene: Scene
    seed: np.uint32

    @property
    def width(self) -> int:
        """Pixels of a strip: the same for all, and none wider than the strips of a film."""
        w = self.camera.film.pixels_x
        return -(-w // strip_count(w))

    def strip(self, left: int, aim: Callable[[float], list[Step]], fill: float, offset: Any, first: int,
              number: int, moment: tuple[int, int] = (0, 1)) -> np.ndarray:
        """Mean light and mean weight of a strip: float32 (4, h, width), the weight last.

        left: raster x of its left edge; aim: the stages from raster X, Y and U0, U1 to the ray, for a wavelength (µm);
        fill: side of the sampled part of each pixel, in pixels; offset: (2,) from the pixel's middle, right and down;
        first, number: the samples; moment: index and number of the equal parts of the exposure.
        """
        h = self.camera.film.pixels_y
        blocks = -(-self.width * h // B)
        lanes, sums = lane_buffer(), np.zeros((blocks, 3 * B), np.float32)
        seed = np.uint32((int(self.seed) + left) % 2**32)
        covered = np.zeros(blocks * B, np.float32)
        counted: dict[int | None, list[_Counted]] = {}
        before = [Step(place_samples, [fill, left + offset[0], offset[1]])]
        if moment[1] > 1:
            before.append(Step(sample_moment, [1.0 / moment[1], moment[0] / moment[1]]))
        for sample, samples, band in self._samples(first, number):
            if band not in counted:
                counted[band] = self._programs(band, before, aim, blocks)
            for program, _ in counted[band]:
                program.expose(sums, lanes, 0, blocks, sample, samples, seed)
        for programs in counted.values():
            for _, weights in programs:
                covered += weights / np.float32(len(programs))
        planes = np.concatenate([sums.reshape(blocks, 3, B).transpose(1, 0, 2).reshape(3, -1), covered[None]])
        planes *= np.float32(1.0 / number)
        return planes[:, :self.width * h].reshape(4, h, self.width)

    def _samples(self, first: int, number: int) -> list[tuple[int, int, int | None]]:
        """First sample, number of samples, and their part of the spectrum or None: the d line."""
        if not self.camera.disperses:
            return [(first, number, None)]
        return [(sample, 1, spectral_part(sample, self.seed)) for sample in range(first, first + number)]

    def _programs(self, band: int | None, before: list[Step], aim: Callable[[float], list[Step]], blocks: int
                  ) -> list[_Counted]:
        """The programs of a part of the spectrum, one for each channel; None: that of the d line."""
        camera, scene = self.camera, self.scene
        timed = camera.moves or scene.moves
        clock = [camera.clock] if timed else []
        after = scene.steps(True, camera.shutter_open, medium=camera.medium)
        lines = [(D_LINE, [])] if band is None else [(row[band], [channel_step(name)])
                                                      for name, row in WAVELENGTHS.items()]
        made = []
        for wavelength, channel in lines:
            to_lens = [*sampling_steps(self.width, camera.film.pixels_y, lit=True, timed=timed), *before,
                       *clock, *aim(wavelength), *camera.port]
            program = Program([*to_lens, Step(sum_weights, np.zeros(blocks * B)), *camera.carried, *after, *channel])
            first, last = program.code.ends[0, len(to_lens):len(to_lens) + 2]
            made.append(_Counted(program, program.code.numbers[first:last]))
        return made


def in_parallel(work: Callable[[Item, Callable[[], bool]], None], items: Sequence[Item],
                progress: Callable[[float], bool], name: str, threads: int | None = None) -> None:
    """Work on all items in threads; LightFieldError "the NAME was cancelled" when `progress` (share done) returns
    False.

    work: takes an item, and a function that returns whether to stop early.
    """
    done, cancelled = count(1), threading.Event()

    def one(item: Item) -> None:
        if not cancelled.is_set():
            work(item, cancelled.is_set)
        if not cancelled.is_set() and not progress(next(done) / len(items)):
            cancelled.set()

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        list(pool.map(one, items))
    if cancelled.is_set():
        raise LightFieldError(f"the {name} was cancelled")


@stage
def place_samples(lanes, p, ints, key):
    """X, Y: samples drawn together about the middle of each pixel, then offset. p: FILL … OFFSET_Y."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    fill, across, down = p[RECORDER_FILL], p[OFFSET_X], p[OFFSET_Y]
    for i in range(B):
        a, b = np.floor(x[i]) + real(0.5), np.floor(y[i]) + real(0.5)
        x[i], y[i] = a + (x[i] - a) * fill + across, b + (y[i] - b) * fill + down


@stage
def sample_moment(lanes, p, ints, key):
    """TIME: within a part of the exposure. p: LENGTH, START."""
    row = rows(lanes)
    time = row[TIME]
    length, start = p[LENGTH], p[START]
    for i in range(B):
        time[i] = start + length * time[i]


@stage
def sum_weights(lanes, p, ints, key):
    """Add the WEIGHT of each lane to the sum of its pixel. p: the sums of all blocks, which this stage writes."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, sums = row[WEIGHT], p[key[PIXEL]:]
    for i in range(B):
        sums[i] += weight[i] if weight[i] > real(0) else real(0)


HIGHEST = 60000.0       # radiance, at the most: half floats end at 65504
FILL = 0.5              # side of the part of a pixel that the samples of a view fill
PUPIL_POINTS = 256      # over which cos⁴θ is averaged where a window puts the film beside the axis
MEMORY_SHARE = 0.9      # of the free memory that a capture may take
WIDEST = 8              # 1 / part of the picture's side that a margin has at the most
TAPS = 4                # recorded pixels outside what a refocused picture reads, for its filter


def _binned(pixels: np.ndarray) -> np.ndarray:
    """Means (…, h, w) of FINER × FINER pixels, float32."""
    *rest, h, w = pixels.shape
    parts = pixels.reshape(*rest, h // FINER, FINER, w // FINER, FINER)
    return np.ascontiguousarray(parts.mean((-3, -1), dtype=np.float32))


def of_wide(camera: Camera, wide: LightField) -> LightField:
    """The light field of a camera from its recording with finer pixels and a margin, by the camera of `widened`."""
    w, h = camera.film.pixels_x, camera.film.pixels_y
    x, y = wide.light.shape[-1] // FINER - w, wide.light.shape[-2] // FINER - h
    margin = x // 2, y // 2

    def coarser(array: np.ndarray) -> np.ndarray:
        out = np.empty((*array.shape[:-2], h + y, w + x), array.dtype)
        for view in np.ndindex(array.shape[:2]):                # one by one: float32 copies are large
            out[view] = _binned(array[view])
        return out

    def middle(array: np.ndarray) -> np.ndarray:
        return array[..., margin[1]:margin[1] + h, margin[0]:margin[0] + w]

    # Of a pixel, samples fill the middles of its parts: their spread is that of a filled square of this side
    fill = math.sqrt(1.0 - (1.0 - wide.fill**2) / FINER**2)
    margined = LightField(widened(camera, margin, 1), wide.reach, coarser(wide.light), coarser(wide.coverage), fill,
                          wide.offsets / FINER,
                          None if wide.moments is None else np.stack([coarser(light) for light in wide.moments]))
    return replace(margined, camera=camera, light=middle(margined.light), coverage=middle(margined.coverage),
                   moments=None if margined.moments is None else middle(margined.moments), wide=wide, margined=margined)


def widened(camera: Camera, margin: tuple[int, int], finer: int = FINER) -> Camera:
    """The camera with a margin of so many of its pixels at each side, across and down, and `finer` times the pixels."""
    film, (mx, my) = camera.film, margin
    w, h = film.pixels_x + 2 * mx, film.pixels_y + 2 * my
    if "window" not in {field.name for field in fields(camera)}:
        wide = Film(film.width * w / film.pixels_x, film.height * h / film.pixels_y, finer * w, finer * h)
        return replace(camera, film=wide)                               # type: ignore[call-arg]
    left, right, bottom, top = camera.window or film_window(film)
    x, y = (right - left) * mx / film.pixels_x, (top - bottom) * my / film.pixels_y
    return replace(camera, film=replace(film, pixels_x=finer * w, pixels_y=finer * h),      # type: ignore[call-arg]
                   window=(left - x, right + x, bottom - y, top + y))


def needed_margin(camera: Camera, views: tuple[int, int], reach: float) -> tuple[int, int]:
    """Pixels at each side, across and down, outside a camera's film that refocusing within the clear range reads.

    At most 1 / WIDEST of the film's pixels.
    """
    one = np.ones((views[1], views[0], 1, 1), np.float32)
    field, film = LightField(camera, reach, one[:, :, None], one), camera.film
    most = np.zeros(2)
    for distance in field.clear_range:
        scale, shear = field.shear(distance)
        sides = np.maximum(field._middle, [film.pixels_x, film.pixels_y] - field._middle)
        aside = np.abs(shear * field.places * field._pixels).max((0, 1))
        most = np.maximum(most, (scale - 1.0) * sides + aside)
    across, down = (min(math.ceil(need + TAPS / FINER), size // WIDEST)
                    for need, size in zip(most, (film.pixels_x, film.pixels_y), strict=True))
    return across, down


def light_field_bytes(film: Film, views: tuple[int, int] = (9, 9), dtype: DTypeLike = np.float16,
                      moments: int = 1) -> int:
    """Size of plain views in memory: three colours and the coverage of every pixel and view.

    Args:
        film: The camera's film.
        views: Views across and down.
        dtype: np.float16 or np.float32.
        moments: Number of moments; above 1 each takes three colours more.
    Returns:
        Bytes.
    """
    numbers = 4 + (3 * moments if moments > 1 else 0)
    return views[0] * views[1] * film.pixels_x * film.pixels_y * numbers * np.dtype(dtype).itemsize


def recording_bytes(camera: Camera, views: tuple[int, int] = (9, 9), moments: int = 1) -> int:
    """Size in memory of what `capture_light_field` records: views with a margin, and the same with finer pixels.

    Args:
        camera: The camera.
        views, moments: As for `capture_light_field`.
    Returns:
        Bytes.
    Raises:
        LightFieldError: For a camera without an aperture.
    """
    margin = needed_margin(camera, views, pupil_reach(camera))
    return sum(light_field_bytes(widened(camera, margin, finer).film, views, moments=moments) for finer in (1, FINER))


def capture_light_field(camera: Camera, scene: Scene, views: tuple[int, int] = (9, 9), samples: int = 16,
                        seed: int = 0, threads: int | None = None,
                        progress: Callable[[float], bool] = lambda share: True, moments: int = 1) -> LightField:
    """A light field: a picture through every cell of a camera's pupil, to be refocused afterwards (Ng and others 2005).

    It is recorded with twice the pixels across and down, and with the margin about the picture that focusing within
    `LightField.clear_range` needs, at most an eighth of each side.

    Args:
        camera: A projective camera with a lens that focuses, traced or ideal; its model resolved.
        scene: The scene, world frame, mm.
        views: Cells of the pupil across and down.
        samples: Samples per pixel of the picture and view, at least one in each of its four parts; a cell that the
            pupil's edge cuts takes fewer, so that the pupil is sampled evenly.
        seed: Sampler seed.
        threads: Number of threads; None: one for each core.
        progress: Called with the share done, 0 to 1, from any thread; return False to cancel.
        moments: Number of equal parts of the exposure to keep apart, beside their mean; each takes its share of the
            samples.
    Raises:
        LightFieldError: For invalid numbers, a camera without an aperture, moments where nothing moves, too little
            memory, and when `progress` cancels.
    """
    across, down = checked_views(camera.film, views, samples, np.float16, moments)
    if moments > 1 and not (camera.moves or scene.moves):
        raise LightFieldError(f"{moments} moments: nothing moves while the shutter is open, so that all are equal; "
                              "record one, or choose a longer time, a camera or a scene that moves")
    picture, samples = camera, math.ceil(samples / FINER**2)
    margin = needed_margin(camera, (across, down), pupil_reach(camera))
    camera = widened(camera, margin)
    require_memory(recording_bytes(picture, (across, down), moments), picture.film, (across, down), moments)
    reach = pupil_reach(camera)
    h, w = camera.film.pixels_y, camera.film.pixels_x
    light = np.zeros((down, across, 3, h, w), np.float16)
    coverage = np.zeros((down, across, h, w), np.float16)
    apart = np.zeros((moments, *light.shape), np.float16) if moments > 1 else None
    offsets = spread_offsets(across, down)
    recorder = Recorder(camera, scene, np.uint32(seed & 0xFFFFFFFF))

    def record(view: tuple[int, int], cancelled: Callable[[], bool]) -> None:
        j, i = view
        cell = lit_cell(reach, (across, down), (i, j))
        number, first = math.ceil(samples * cell.share / moments), (j * across + i) * samples

        def aim(wavelength: float) -> list[Step]:
            return [camera.film_step, *cell_steps(camera, cell, wavelength)]

        for left in range(0, w if number else 0, recorder.width):
            if cancelled():
                return
            columns, mean = slice(left, min(left + recorder.width, w)), np.zeros((4, h, recorder.width), np.float32)
            for moment in range(moments):
                strip = recorder.strip(left, aim, FILL, offsets[j, i], first + moment * number, number,
                                       (moment, moments)) * np.float32(cell.share)
                mean += strip / np.float32(moments)
                if apart is not None:
                    apart[moment, j, i, :, :, columns] = np.minimum(strip[:3], HIGHEST)[..., :w - left]
            light[j, i, :, :, columns] = np.minimum(mean[:3], HIGHEST)[..., :w - left]
            coverage[j, i, :, columns] = mean[3][..., :w - left]

    in_parallel(record, list(np.ndindex(down, across)), progress, "capture", threads)
    return of_wide(picture, LightField(camera, reach, light, coverage, FILL, moments=apart))


def picture_through(camera: Camera, scene: Scene, place: tuple[float, float], radius: float, samples: int = 16,
                    seed: int = 0, moment: tuple[int, int] = (0, 1),
                    progress: Callable[[float], bool] = lambda share: True) -> np.ndarray:
    """The picture that a camera takes through a round part of its pupil: the reference of a refocused light field.

    Args:
        camera: A projective camera with a lens, its model resolved.
        scene: The scene, world frame, mm.
        place: Centre (u, v) of the part, in radii of the paraxial exit pupil, to the right and up.
        radius: Radius of the part, in radii of the paraxial exit pupil.
        samples: Samples per pixel.
        seed: Sampler seed.
        moment: Index and number of the equal parts of the exposure.
        progress: Called with the share done, 0 to 1, from any thread; return False to cancel.
    Returns:
        float32 (h, w, 3), linear RGB, 1 where the axis sees radiance 1.
    Raises:
        LightFieldError: As `capture_light_field`.
    """
    checked_views(camera.film, (1, 1), samples, np.float32)
    pupil_reach(camera)
    w, h = camera.film.pixels_x, camera.film.pixels_y
    recorder = Recorder(camera, scene, np.uint32(seed & 0xFFFFFFFF))
    cell = Cell((place[0] - radius, place[1] - radius), (2.0 * radius, 2.0 * radius), 1.0)
    planes = np.zeros((4, h, w), np.float32)

    def aim(wavelength: float) -> list[Step]:
        return [camera.film_step, Step(sample_disk), *cell_steps(camera, cell, wavelength)]

    def record(left: int, cancelled: Callable[[], bool]) -> None:
        strip = recorder.strip(left, aim, 1.0, (0.0, 0.0), 0, samples, moment)
        planes[:, :, left:left + recorder.width] = strip[..., :w - left]

    in_parallel(record, range(0, w, recorder.width), progress, "picture")
    n = np.arange(PUPIL_POINTS)
    points = unit_disk(np.stack([(n + 0.5) / PUPIL_POINTS, n * SPREAD[0] % 1.0], 1))
    white = float(axis_coverage(camera, planes[3], np.array(place) + radius * points))
    return np.ascontiguousarray(planes[:3].transpose(1, 2, 0) / max(white, 1e-30))


def checked_views(film: Film, views: tuple[int, int], samples: int, dtype: DTypeLike, moments: int = 1
                  ) -> tuple[int, int]:
    """The numbers of views across and down; LightFieldError for numbers that cannot be recorded."""
    across, down = (int(number) for number in views)
    if across < 1 or down < 1 or (across, down) != tuple(views):
        raise LightFieldError(f"{views[0]} × {views[1]} views: both must be whole numbers of at least 1")
    if samples < 1:
        raise LightFieldError(f"{samples} samples a pixel: at least 1 is needed")
    if moments < 1 or int(moments) != moments:
        raise LightFieldError(f"{moments} moments: a whole number of at least 1 is needed")
    require_memory(light_field_bytes(film, (across, down), dtype, moments), film, (across, down), moments)
    return across, down


def require_memory(size: int, film: Film, views: tuple[int, int], moments: int = 1) -> None:
    """LightFieldError for a recording of more bytes than MEMORY_SHARE of what is free."""
    free = free_memory()
    if size > MEMORY_SHARE * free:
        raise LightFieldError(f"{views[0]} × {views[1]} views of {film.pixels_x} × {film.pixels_y} pixels take "
                              f"{fixed(size / 1e9, 1, grouped=True)} GB, more than the "
                              f"{fixed(free / 1e9, 1, grouped=True)} GB that are free: record "
                              f"fewer views{' or moments' if moments > 1 else ''} or pixels")


def free_memory() -> float:
    """Free bytes on this machine; infinite where the system does not report them."""
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf
