"""The plenoptic camera: microlenses on the plane of the film, and behind each a small picture of the lens's pupil.

The microlenses, one for each pixel of a camera's film, are square ideal lenses without gaps; the sensor lies behind
them at their focal length f. From the point a in the pupil, light comes to the microlens at c with the slope c s + a t,
and meets the sensor at c (1 − f s) − f t a. The pictures behind the microlenses are wider apart by the factor 1 − f s,
and a sensor pixel is this distance over the number of pixels. With a matched f-number, pictures of the pupil just
touch; a faster lens makes them overlap, a slower lens leaves pixels dark.

References:
    Ng, Levoy, Brédif, Duval, Horowitz and Hanrahan, "Light field photography with a hand-held plenoptic camera", 2005.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.kernels.block import U0, U1, B, Step, X, Y, rows, stage
from lensbench.core.lightfields.capture import HIGHEST, Recorder, checked_views, in_parallel
from lensbench.core.lightfields.light_field import LightField, LightFieldError
from lensbench.core.lightfields.pupil_cells import Cell, cell_steps, pupil_reach
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import significant

SQUARE = 0.01           # by which the height of a microlens over its width may differ from 1
WHOLE = Cell((0.0, 0.0), (1.0, 1.0), 1.0)

# Parameters of `through_microlens`: the sensor's scale; pixel side (mm) and place of the axis (mm), across and
# down; microlenses aside, to the right and down; microlenses across and down; and the slopes s and t
(PER_SPREAD, PITCH_X, AXIS_X, PITCH_Y, AXIS_Y, ASIDE_X, ASIDE_Y, COLUMNS, LINES, PER_FOCAL_LENGTH, SLOPE_FILM,
 PER_SLOPE_PUPIL) = range(12)
BEYOND = 1e9            # pupil coordinate that no pupil contains


@dataclass(frozen=True, eq=False)
class PlenopticCamera:
    """A main lens with microlenses before its sensor.

    Args:
        camera: The main camera, projective with a lens; its film is the plane of the microlenses, one for each pixel.
            Pixels must be square.
        pixels: Sensor pixels behind each microlens, across and down.
        f_number: Of the microlenses, focal length over side; None: matched to the main lens on the axis.
    Raises:
        LightFieldError: For invalid numbers, pixels that are not square, and cameras that `capture_light_field`
            refuses.
    """

    camera: Camera
    pixels: int = 9
    f_number: float | None = None

    def __post_init__(self) -> None:
        film = self.camera.film
        if int(self.pixels) != self.pixels or self.pixels < 1:
            raise LightFieldError(f"{significant(self.pixels)} pixels behind a microlens: it must be a whole number "
                                  f"of at least 1")
        if self.f_number is not None and not (math.isfinite(self.f_number) and self.f_number > 0.0):
            raise LightFieldError(f"f/{significant(self.f_number)} of the microlenses: it must be a positive number")
        if abs(film.width / film.pixels_x * film.pixels_y / film.height - 1.0) > SQUARE:
            raise LightFieldError("microlenses are square: give the film pixels that are as wide as high")
        _ = self.reach

    @cached_property
    def reach(self) -> float:
        """Largest radius in the pupil from which light comes, in radii of the paraxial exit pupil."""
        return pupil_reach(self.camera)

    @property
    def pitch(self) -> float:
        """Distance between neighbouring microlenses, mm; on the virtual film of an ideal main lens."""
        return float(self.camera.film_step.parameters[0])

    @property
    def main_f_number(self) -> float:
        """Working f-number of the main lens on the axis, for small angles."""
        return 0.5 / abs(self.camera.gaussian.approach_pupil)

    @property
    def matched_f_number(self) -> float:
        """F-number of microlenses whose pictures of the pupil just touch."""
        away = -self.camera.gaussian.approach_film * self.pitch
        # N = ratio · main, ratio = 1 + N pitch · (1 / distance of the pupil)
        return self.main_f_number / (1.0 - self.main_f_number * away)

    @property
    def microlens_f_number(self) -> float:
        """F-number of the microlenses, given or matched."""
        return self.matched_f_number if self.f_number is None else self.f_number

    @property
    def focal_length(self) -> float:
        """Focal length of the microlenses and their distance from the sensor, mm."""
        return self.microlens_f_number * self.pitch

    @property
    def spread(self) -> float:
        """Distance between the pictures behind neighbouring microlenses, over the pitch."""
        return 1.0 - self.focal_length * self.camera.gaussian.approach_film

    @property
    def fill(self) -> float:
        """Diameter of the pupil's picture over the distance to the next: 1 is matched, more overlaps."""
        return self.microlens_f_number / (self.main_f_number * self.spread)

    @property
    def used(self) -> float:
        """Share of the sensor that pictures of a round pupil cover, on the axis: π/4 where they just touch."""
        return _disk_in_square(0.5 * self.fill)

    @property
    def spilled(self) -> float:
        """Share of the light, on the axis, that falls beside the square of its own microlens."""
        return 1.0 - self.used / (math.pi * (0.5 * self.fill) ** 2)

    @property
    def sensor(self) -> tuple[int, int]:
        """Pixels of the raw picture across and down."""
        film = self.camera.film
        return film.pixels_x * self.pixels, film.pixels_y * self.pixels

    def expose(self, scene: Scene, samples: int = 16, seed: int = 0,
               progress: Callable[[float], bool] = lambda share: True) -> "RawPicture":
        """The raw picture of a scene.

        Args:
            scene: The scene, world frame, mm.
            samples: Samples per sensor pixel and microlens whose light comes to it.
            seed: Sampler seed.
            progress: Called with the share done, 0 to 1, from any thread; return False to cancel.
        Raises:
            LightFieldError: For too few samples, too little memory, and when `progress` cancels.
        """
        camera, k = self.camera, self.pixels
        checked_views(camera.film, (k, k), samples, np.float32)
        w, h = self.sensor
        fine = replace(camera, film=replace(camera.film, pixels_x=w, pixels_y=h))       # type: ignore[call-arg]
        recorder = Recorder(fine, scene, np.uint32(seed & 0xFFFFFFFF))
        out = np.zeros((4, h, w), np.float32)
        # A picture reaches into those of so many neighbours, but for a seam: half a microlens over the pupil's radius
        over = max(math.ceil(0.5 * self.reach * self.fill - 0.5 - 1e-9), 0)
        near = [(i, j) for j in range(-over, over + 1) for i in range(-over, over + 1)]

        def record(left: int, cancelled: Callable[[], bool]) -> None:
            for n, aside in enumerate(near):
                if cancelled():
                    return
                strip = recorder.strip(left, partial(self._aim, aside), 1.0, (0.0, 0.0), n * samples, samples)
                out[:, :, left:left + recorder.width] += strip[..., :w - left]

        in_parallel(record, range(0, w, recorder.width), progress, "exposure")
        return RawPicture(self, np.ascontiguousarray(out[:3].transpose(1, 2, 0)), out[3])

    def _aim(self, aside: tuple[int, int], wavelength: float) -> list[Step]:
        """The stages from the sensor's raster through the microlens so many aside of its own to the ray."""
        camera, k, spread = self.camera, self.pixels, self.spread
        across, middle, down, low = camera.film_step.parameters
        lens, film = camera.gaussian, camera.film
        onto_sensor = Step(camera.film_step.kernel, np.array([across / k, middle, down / k, low]) * spread)
        through = Step(through_microlens, [1.0 / spread, across, middle, down, low, *aside, film.pixels_x,
                                           film.pixels_y, 1.0 / self.focal_length, lens.approach_film,
                                           1.0 / lens.approach_pupil])
        return [onto_sensor, through, *cell_steps(camera, WHOLE, wavelength)]


@dataclass(frozen=True, eq=False)
class RawPicture:
    """The raw picture of a plenoptic camera, from `PlenopticCamera.expose`.

    Args:
        camera: The plenoptic camera.
        picture: float32 (h, w, 3), linear RGB, the top row first; a pixel that sees nothing but the pupil shows
            radiance × cos⁴.
        white: float32 (h, w): the same where all radiance is 1; 0 where no light comes, above 1 where pictures overlap.
    """

    camera: PlenopticCamera
    picture: np.ndarray
    white: np.ndarray

    def behind(self, across: int, down: int) -> np.ndarray:
        """The picture (pixels, pixels, 3) behind one microlens, across and down from the top left: a view into the raw
        picture.
        """
        k = self.camera.pixels
        return self.picture[down * k:(down + 1) * k, across * k:(across + 1) * k]

    def decoded(self) -> LightField:
        """The light field of the raw picture: a view for each pixel behind a microlens, a pixel for each microlens.

        Where pictures overlap, their light remains mixed.
        """
        plenoptic, k = self.camera, self.camera.pixels
        w, h = plenoptic.sensor
        parts = np.concatenate([self.picture, self.white[..., None]], -1).reshape(h // k, k, w // k, k, 4)
        # Rows behind a microlens run down; the first row of a light field's views is the lowest
        views = np.minimum(parts[:, ::-1].transpose(1, 3, 4, 0, 2), HIGHEST).astype(np.float16)
        return LightField(plenoptic.camera, 1.0 / plenoptic.fill, np.ascontiguousarray(views[:, :, :3]),
                          np.ascontiguousarray(views[:, :, 3]), 1.0, np.zeros((k, k, 2)))


def _disk_in_square(radius: float) -> float:
    """Area that a disk and a concentric square of side 1 share."""
    if radius <= 0.5:
        return math.pi * radius**2
    if radius >= math.sqrt(0.5):
        return 1.0
    return math.pi * radius**2 - 4.0 * (radius**2 * math.acos(0.5 / radius) - 0.5 * math.sqrt(radius**2 - 0.25))


@stage
def through_microlens(lanes, p, ints, key):
    """From the point X, Y of the sensor (mm) through U0, U1 of a microlens to the film point and U0, U1 of the pupil.

    U0 becomes BEYOND for a microlens outside the film. p: PER_SPREAD … PER_SLOPE_PUPIL.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u, v = row[X], row[Y], row[U0], row[U1]
    inward, across, middle, down, low = p[PER_SPREAD], p[PITCH_X], p[AXIS_X], p[PITCH_Y], p[AXIS_Y]
    right, below, columns, lines = p[ASIDE_X], p[ASIDE_Y], p[COLUMNS], p[LINES]
    per_focus, slope_film, per_slope = p[PER_FOCAL_LENGTH], p[SLOPE_FILM], p[PER_SLOPE_PUPIL]
    for i in range(B):
        # Find the microlens, and its centre c
        column = np.floor((middle - x[i] * inward) / across) + right
        line = np.floor((y[i] * inward + low) / down) + below
        exists = (column >= real(0)) & (column < columns) & (line >= real(0)) & (line < lines)
        cx, cy = middle - (column + real(0.5)) * across, (line + real(0.5)) * down - low

        # The slope of all light that it sends to this point, and a place on it
        slope_x, slope_y = (cx - x[i]) * per_focus, (cy - y[i]) * per_focus
        at_x, at_y = cx + (u[i] - real(0.5)) * across, cy + (v[i] - real(0.5)) * down
        x[i], y[i] = at_x, at_y

        # The place in the pupil from which light comes there with this slope
        u[i] = (slope_x - at_x * slope_film) * per_slope if exists else real(BEYOND)
        v[i] = (slope_y - at_y * slope_film) * per_slope
