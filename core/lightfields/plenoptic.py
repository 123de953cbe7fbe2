"""The plenoptic camera: microlenses on the plane of the film, and behind each a small picture of the lens's pupil.

A camera's film is the plane of the microlenses, one for each of its pixels: square ideal lenses without gaps. The
sensor stands behind them at their focal length f, so that all light that comes to a microlens at one slope meets
one point: by the place a in the pupil, light comes to the microlens at c with the slope c s + a t, and meets the sensor
at c (1 − f s) − f t a. The microlenses' pictures lie farther apart than they do, by 1 − f s; a sensor pixel
is this distance over the number of pixels. The picture of a pupil that is met by as many f-numbers as the microlenses
have touches its neighbours: faster lenses overlap, slower ones leave pixels dark. (Ng et al. 2005.)
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import count

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.kernels.block import U0, U1, B, Step, X, Y, rows, stage
from lensbench.lightfields.capture import TOP, Cell, Recorder, cell_steps, checked_views, pupil_reach
from lensbench.lightfields.light_field import LightField, LightFieldError
from lensbench.scenery.scene import Scene

SQUARE = 0.01           # by what part a microlens may be higher than wide, or less high
WHOLE = Cell((0.0, 0.0), (1.0, 1.0), 1.0)


@dataclass(frozen=True, eq=False)
class PlenopticCamera:
    """Microlenses behind a main lens.

    camera: the main one; its film is the plane of the microlenses, one to each pixel, which are square. pixels:
    of the sensor behind each microlens, across and down. f_number: of the microlenses, focal length over side; None:
    the one that matches the main lens on the axis. LightFieldError for what cannot be, and as of `capture_light_field`.
    """

    camera: Camera
    pixels: int = 9
    f_number: float | None = None

    def __post_init__(self):
        film = self.camera.film
        if int(self.pixels) != self.pixels or self.pixels < 1:
            raise LightFieldError(f"{self.pixels:g} pixels behind a microlens: it must be a whole number of at least 1")
        if self.f_number is not None and not (math.isfinite(self.f_number) and self.f_number > 0.0):
            raise LightFieldError(f"f/{self.f_number:g} of the microlenses: it must be a positive number")
        if abs(film.width / film.pixels_x * film.pixels_y / film.height - 1.0) > SQUARE:
            raise LightFieldError("microlenses are square: give the film pixels that are as wide as high")
        _ = self.reach

    @cached_property
    def reach(self) -> float:
        """How far the light of the main lens reaches, in radii of its paraxial exit pupil."""
        return pupil_reach(self.camera)

    @property
    def pitch(self) -> float:
        """Mm from microlens to microlens; of an ideal main lens on the film as it is imagined."""
        return float(self.camera.film_step.parameters[0])

    @property
    def main_f_number(self) -> float:
        """Of the cone of light on the axis as the microlenses see it: the working f-number of small angles."""
        return 0.5 / abs(self.camera.gaussian.approach_pupil)

    @property
    def matched_f_number(self) -> float:
        """Of microlenses whose pictures of the pupil just touch."""
        away = -self.camera.gaussian.approach_film * self.pitch
        # N = ratio · main, ratio = 1 + N pitch · (1 / distance of the pupil)
        return self.main_f_number / (1.0 - self.main_f_number * away)

    @property
    def microlens_f_number(self) -> float:
        """As given, or matched."""
        return self.matched_f_number if self.f_number is None else self.f_number

    @property
    def focal_length(self) -> float:
        """Of the microlenses (mm), and how far before the sensor they stand."""
        return self.microlens_f_number * self.pitch

    @property
    def spread(self) -> float:
        """How far the microlenses' pictures lie from each other, over their pitch: the pupil is not infinitely far."""
        return 1.0 - self.focal_length * self.camera.gaussian.approach_film

    @property
    def fill(self) -> float:
        """The diameter of the pupil's picture over the distance to the next: 1 is matched, more overlaps."""
        return self.microlens_f_number / (self.main_f_number * self.spread)

    @property
    def used(self) -> float:
        """The part of the sensor that pictures of a round pupil cover, on the axis: π/4 where they just touch."""
        return _disk_in_square(0.5 * self.fill)

    @property
    def spilled(self) -> float:
        """The part of the light, on the axis, that falls beside its microlens's own square: where pictures overlap."""
        return 1.0 - self.used / (math.pi * (0.5 * self.fill) ** 2)

    @property
    def sensor(self) -> tuple[int, int]:
        """Pixels of the raw picture, across and down."""
        film = self.camera.film
        return film.pixels_x * self.pixels, film.pixels_y * self.pixels

    def expose(self, scene: Scene, samples: int = 16, seed: int = 0, shadows: bool = True,
               progress: Callable[[float], bool] = lambda share: True) -> "RawPicture":
        """What the sensor sees; samples: for each of its pixels, and each microlens whose light comes to it.

        told: called with the share that is done; given up where it answers False. LightFieldError as of
        `capture_light_field`.
        """
        camera, k = self.camera, self.pixels
        checked_views(camera.film, (k, k), samples, np.float32)
        w, h = self.sensor
        fine = replace(camera, film=replace(camera.film, pixels_x=w, pixels_y=h))       # type: ignore[call-arg]
        recorder = Recorder(fine, scene, shadows, np.uint32(seed & 0xFFFFFFFF))
        out = np.zeros((4, h, w), np.float32)
        lefts, done = range(0, w, recorder.width), count(1)
        cancelled: list[int] = []
        # Pictures reach into those of so many neighbours, but for a seam: half a microlens over the pupil's radius
        over = max(math.ceil(0.5 * self.reach * self.fill - 0.5 - 1e-9), 0)
        near = [(i, j) for j in range(-over, over + 1) for i in range(-over, over + 1)]

        def record(left: int) -> None:
            for n, to in enumerate(near):
                if cancelled:
                    return
                strip = recorder.strip(left, partial(self._aims, to), 1.0, (0.0, 0.0), n * samples, samples)
                out[:, :, left:left + recorder.width] += strip[..., :w - left]
            if not progress(next(done) / len(lefts)):
                cancelled.append(left)

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(record, lefts))
        if cancelled:
            raise LightFieldError("the exposure was cancelled")
        return RawPicture(self, np.ascontiguousarray(out[:3].transpose(1, 2, 0)), out[3])

    def _aims(self, to: tuple[int, int], wavelength: float) -> list[Step]:
        """From the sensor's raster through the microlens so many beside its own to the ray."""
        camera, k, spread = self.camera, self.pixels, self.spread
        across, middle, down, low = camera.film_step.parameters
        lens, film = camera.gaussian, camera.film
        onto = Step(camera.film_step.kernel, np.array([across / k, middle, down / k, low]) * spread)
        through = Step(microlens, [1.0 / spread, across, middle, down, low, *to, film.pixels_x, film.pixels_y,
                                   1.0 / self.focal_length, lens.approach_film, 1.0 / lens.approach_pupil])
        return [onto, through, *cell_steps(camera, WHOLE, wavelength)]


@dataclass(frozen=True, eq=False)
class RawPicture:
    """What the sensor of a plenoptic camera saw.

    picture: float32 (h, w, 3), linear; a pixel that sees the pupil alone shows its radiance, times cos⁴.
    white: (h, w) what it would be were all radiance 1: 0 where no light comes, more than 1 where pictures overlap.
    """

    camera: PlenopticCamera
    picture: np.ndarray
    white: np.ndarray

    def behind(self, across: int, down: int) -> np.ndarray:
        """The picture (pixels, pixels, 3) behind one microlens, counted from the top left: what the pupil sees."""
        k = self.camera.pixels
        return self.picture[down * k:(down + 1) * k, across * k:(across + 1) * k]

    def decoded(self, dtype=np.float16) -> LightField:
        """The light field that the microlenses sorted, to be focused: a view for each pixel behind them.

        Each has a pixel for every microlens; what overlaps cannot be told apart, and stays as it is.
        """
        plenoptic, k = self.camera, self.camera.pixels
        w, h = plenoptic.sensor
        parts = np.concatenate([self.picture, self.white[..., None]], -1).reshape(h // k, k, w // k, k, 4)
        # Pixels behind a microlens run down as the pupil does, whose lowest row is a light field's first
        views = np.minimum(parts[:, ::-1].transpose(1, 3, 4, 0, 2), TOP).astype(dtype)
        return LightField(plenoptic.camera, 1.0 / plenoptic.fill, np.ascontiguousarray(views[:, :, :3]),
                          np.ascontiguousarray(views[:, :, 3]), 1.0, np.zeros((k, k, 2)))


def _disk_in_square(radius: float) -> float:
    """The area that a disk and a square of side 1 about the same middle share."""
    if radius <= 0.5:
        return math.pi * radius**2
    if radius >= math.sqrt(0.5):
        return 1.0
    return math.pi * radius**2 - 4.0 * (radius**2 * math.acos(0.5 / radius) - 0.5 * math.sqrt(radius**2 - 0.25))


@stage
def microlens(lanes, p, key):
    """From the point X, Y of the sensor (mm) through U0, U1 of a microlens to the film point and U0, U1 of the pupil.

    p: 1 / spread, mm of a pixel and where the axis meets it, across and down; how many microlenses beside, and how many
    there are, across and down; 1 / focal length, the slope by the film, 1 / that by the pupil. A microlens that there
    is not passes nothing: its U0 is beyond every pupil.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u, v = row[X], row[Y], row[U0], row[U1]
    inward, across, middle, down, low, right, below = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    columns, lines, per_focus, film, pupil = p[7], p[8], p[9], p[10], p[11]
    for i in range(B):
        column = np.floor((middle - x[i] * inward) / across) + right
        line = np.floor((y[i] * inward + low) / down) + below
        there = (column >= real(0)) & (column < columns) & (line >= real(0)) & (line < lines)
        cx, cy = middle - (column + real(0.5)) * across, (line + real(0.5)) * down - low
        slope_x, slope_y = (cx - x[i]) * per_focus, (cy - y[i]) * per_focus
        at_x, at_y = cx + (u[i] - real(0.5)) * across, cy + (v[i] - real(0.5)) * down
        x[i], y[i] = at_x, at_y
        u[i] = (slope_x - at_x * film) * pupil if there else real(1e9)
        v[i] = (slope_y - at_y * film) * pupil
