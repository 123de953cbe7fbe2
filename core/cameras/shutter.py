"""What every camera begins with: its error, its rays, its position and its shutter with rolling rows. mm and seconds.

The camera frame has its origin at the camera, x to the right, y up, and the camera looks along −z. A moving point is
projected onto the row of the film that is open when it falls there.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.imaging.exposure import DIRECTIONS, shutter_step
from lensbench.core.imaging.film import Film
from lensbench.core.imaging.transform import AnimatedTransform, checked_rigid, transform_steps
from lensbench.core.kernels.block import TIME, Step, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.text import significant


class CameraError(ValueError):
    """Invalid settings of a camera; the message says what to change."""


class Rays(NamedTuple):
    """Rays of a camera in the world frame.

    A ray that the camera blocks has weight 0; its other numbers have no meaning.

    Args:
        origins: (n, 3) array. Points on the rays (mm), world.
        directions: (n, 3) array. Unit directions, world.
        weights: (n,) array. Weights by which the radiance of each ray enters its pixel; see `Camera.weights`.
        times: (n,) array. Times (s) on the clock of `Camera.shutter_open`.
    """

    origins: np.ndarray
    directions: np.ndarray
    weights: np.ndarray
    times: np.ndarray


def checked_times(time: ArrayLike) -> np.ndarray:
    """Shutter samples as an array; CameraError where they do not lie in [0, 1]."""
    times = np.asarray(time, float)
    if not ((times >= 0.0) & (times <= 1.0)).all():
        raise CameraError("times must lie between 0 and 1, parts of what the shutter lets through")
    return times


@dataclass(frozen=True, eq=False, kw_only=True)
class PlacedShutter:
    """Placement and shutter of a camera.

    Args:
        world_from_camera: (4, 4) array or AnimatedTransform. Rigid transform from the camera frame to the world, both
            in mm; the identity by default. An AnimatedTransform may also scale all directions alike.
        shutter_open, shutter_close: Times (s) between which the shutter is open; with a rolling shutter, those of the
            row that opens first.
        shutter_ramp: Time (s) that the shutter takes to open, and again to close; 0 gives a box.
        readout: Time (s) from the opening of the first row to that of the last; 0 is a global shutter.
        readout_direction: Order of the rows in the upright picture: "down", "up", "left" or "right".
    Raises:
        CameraError: Unknown readout direction, or shutter times that contradict each other.
        TransformError: A world_from_camera that is not rigid.
    """

    if TYPE_CHECKING:                   # a field of each camera kind, at that kind's own position in its signature
        @property
        def film(self) -> Film:
            """The film that the picture falls on."""
    world_from_camera: np.ndarray | AnimatedTransform = field(default_factory=lambda: np.eye(4))
    shutter_open: float = 0.0
    shutter_close: float = 1.0
    shutter_ramp: float = 0.0
    readout: float = 0.0
    readout_direction: str = "down"

    def __post_init__(self) -> None:
        if isinstance(self.world_from_camera, AnimatedTransform):
            _ = self.world_from_camera.scales               # raises where the transform does not scale evenly
        else:
            object.__setattr__(self, "world_from_camera", checked_rigid(self.world_from_camera))
        if not (math.isfinite(self.shutter_open) and math.isfinite(self.shutter_close)):
            raise CameraError("the shutter's times must be finite numbers of seconds")
        if self.shutter_close < self.shutter_open:
            raise CameraError(f"the shutter closes at {significant(self.shutter_close)} s, "
                              f"before it opens at {significant(self.shutter_open)} s")
        if not 0.0 <= self.shutter_ramp <= self.exposure_time / 2.0:
            raise CameraError(f"shutter ramp {significant(self.shutter_ramp)} s: it must lie between 0 and "
                              f"{significant(self.exposure_time / 2.0)} s, half of the time that the shutter is open")
        if not (math.isfinite(self.readout) and self.readout >= 0.0):
            raise CameraError(f"readout {significant(self.readout)} s: it must be 0 (a global shutter) or positive")
        if self.readout_direction not in DIRECTIONS:
            raise CameraError(f"readout direction {self.readout_direction!r}: choose one of {', '.join(DIRECTIONS)}")

    @property
    def exposure_time(self) -> float:
        """Time (s) from the moment when a row begins to open until it is closed."""
        return self.shutter_close - self.shutter_open

    @property
    def effective_time(self) -> float:
        """Time (s) for which a shutter without ramps would pass the same light: the area of the trapezoid."""
        return self.exposure_time - self.shutter_ramp

    @property
    def shutter_efficiency(self) -> float:
        """effective_time / exposure_time: 1 for a box, 1/2 for a shutter that is fully open only for an instant."""
        return self.effective_time / self.exposure_time if self.exposure_time > 0.0 else 1.0

    @property
    def moves(self) -> bool:
        """Whether the camera moves while any of its rows is open."""
        pose = self.world_from_camera
        return isinstance(pose, AnimatedTransform) and pose.changes_between(self.shutter_open, self._last_moment)

    @property
    def _last_moment(self) -> float:
        """Time (s) at which the last row is closed."""
        return self.shutter_close + self.readout

    def world_from_camera_at(self, seconds: ArrayLike) -> np.ndarray:
        """Transform (4, 4) from the camera frame to the world at seconds on the clock of shutter_open; (n, 4, 4) for n
        times.
        """
        pose = self.world_from_camera
        if isinstance(pose, AnimatedTransform):
            return pose.at(seconds)
        return np.broadcast_to(pose, (*np.shape(seconds), 4, 4))

    def placement(self, time: ArrayLike = 0.0, raster: np.ndarray | None = None) -> np.ndarray:
        """Transform (4, 4) from the camera frame to the world, at a shutter time in [0, 1) and for raster points (n,
        2), pixels.

        raster, on which the time depends with a rolling shutter, is by default the film's centre. (n, 4, 4) for n times
        or points and an AnimatedTransform.
        """
        if not isinstance(self.world_from_camera, AnimatedTransform):
            return self.world_from_camera
        one = raster is None and np.ndim(time) == 0
        raster = film_centre(self.film, max(np.size(time), 1)) if raster is None else raster
        inputs = {X: raster[:, 0], Y: raster[:, 1], TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        seconds = self.shutter_open + Program([self.clock], np.float64).run(inputs, [TIME], len(raster))[0]
        return self.world_from_camera_at(seconds[0] if one else seconds)

    @property
    def carried(self) -> list[Step]:
        """Steps from a ray in the camera frame, at its TIME in seconds since shutter_open, to the world."""
        pose = self.world_from_camera
        if isinstance(pose, AnimatedTransform):
            return pose.steps(self.shutter_open, self._last_moment)
        return transform_steps(pose)

    @property
    def clock(self) -> Step:
        """Step from the shutter sample TIME in [0, 1) and raster X, Y to TIME in seconds since shutter_open."""
        return shutter_step(self.exposure_time, self.shutter_ramp, self.readout, self.readout_direction,
                            self.film.pixels_x, self.film.pixels_y)


def film_centre(film: Film, n: int) -> np.ndarray:
    """Raster point of the film's centre, n times: (n, 2) pixels."""
    return np.tile([film.pixels_x / 2.0, film.pixels_y / 2.0], (n, 1))


Project = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Raster points (n, 2) → raster points of n objects, with the camera where it is while the rows of the former are open;
and which objects are visible, (n,) bool."""

ITERATIONS = 40         # of the secant rule, at most


def project_onto_open_rows(camera: PlacedShutter, project: Project, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Raster points (n, 2) of n objects, each on the row that is open when it falls there; and which are visible."""
    raster, visible = project(film_centre(camera.film, n))
    if camera.moves and camera.readout > 0.0:
        raster, visible = _solve_rows(camera, project, raster)
    with np.errstate(invalid="ignore"):
        inside = ((raster >= 0.0) & (raster <= [camera.film.pixels_x, camera.film.pixels_y])).all(1)
    return raster, visible & inside


def _solve_rows(camera: PlacedShutter, project: Project, raster: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fixed points of `project` along the readout, by the secant rule for each object on its own."""
    axis = 0 if camera.readout_direction in ("left", "right") else 1
    before, open_at = film_centre(camera.film, len(raster)), raster.copy()
    error_before = raster[:, axis] - before[:, axis]
    for _ in range(ITERATIONS):
        raster, visible = project(open_at)
        error = raster[:, axis] - open_at[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -error * (open_at[:, axis] - before[:, axis]) / (error - error_before)
        step = np.where(np.isfinite(step), step, error)
        before, error_before, open_at = open_at, error, open_at.copy()
        open_at[:, axis] += step
        if not (np.abs(step) > 1e-11).any():
            break
    raster, visible = project(open_at)
    with np.errstate(invalid="ignore"):                 # a fast panorama may miss a point, or see it twice
        return raster, visible & (np.abs(raster[:, axis] - open_at[:, axis]) < 1e-6)
