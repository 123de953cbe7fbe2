"""What every camera has: a film, a place in the world, a shutter, weights, and rays."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lensbench.driver import Program
from lensbench.film import Film
from lensbench.glass import D_LINE
from lensbench.lanes import TIME, U0, U1, WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.sampling import unit_square
from lensbench.transform import checked, placed


class CameraError(ValueError):
    """A camera that cannot be; the message says what to do."""


class Rays(NamedTuple):
    """Rays in the world frame (mm); what a camera blocks has weight 0 and numbers without meaning."""

    origins: np.ndarray         # (n, 3)
    directions: np.ndarray      # (n, 3) unit
    weights: np.ndarray         # (n,)
    times: np.ndarray           # (n,) seconds


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera:
    """Fields that all cameras share, beside the film that each of them has.

    world_from_camera: (4, 4), the identity by default. The shutter is open from
    shutter_open to shutter_close, in seconds. weights: "relative" (the
    unvignetted axis point is 1, whatever the stop) or "physical"
    (cos⁴θ · area / z² · open time).
    """

    if TYPE_CHECKING:                   # each camera's own field, in its own place among them
        @property
        def film(self) -> Film:
            """What the picture falls on."""
    world_from_camera: np.ndarray = field(default_factory=lambda: np.eye(4))
    shutter_open: float = 0.0
    shutter_close: float = 1.0
    weights: str = "relative"

    def __post_init__(self):
        object.__setattr__(self, "world_from_camera", checked(self.world_from_camera))
        if self.weights not in ("relative", "physical"):
            raise CameraError(f"weights {self.weights!r}: choose relative or physical")
        if not (math.isfinite(self.shutter_open) and math.isfinite(self.shutter_close)):
            raise CameraError("the shutter's times must be finite numbers of seconds")
        if self.shutter_close < self.shutter_open:
            raise CameraError(f"the shutter closes at {self.shutter_close:g} s, "
                              f"before it opens at {self.shutter_open:g} s")

    @property
    def pupil_centre(self) -> tuple[float, float]:
        """The U0, U1 of the ray through the middle of the pupil."""
        return 0.5, 0.5

    @property
    def disperses(self) -> bool:
        """Whether its rays differ with the wavelength."""
        return False

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """From the film point X, Y, Z (camera frame, mm) and U0, U1 to a ray of the camera frame, with its WEIGHT."""
        raise AssertionError("each camera says how it aims")

    def steps(self, wavelength: float = D_LINE) -> list[Step]:
        """From raster X, Y, the place in the pupil U0, U1 and TIME to the ray in the world, with its WEIGHT.

        wavelength: of the light, in µm; all the same to a camera that does not disperse.
        """
        return [self.film.step, *self.camera_steps(wavelength), *placed(self.world_from_camera)]

    def _normaliser(self, on_axis: float, z: float) -> float:
        """What cos⁴θ · area is divided by; on_axis: ∫ cos⁴θ dA (mm²) seen from the film's centre."""
        if self.weights == "relative":
            return on_axis
        open_time = self.shutter_close - self.shutter_open
        return z * z / open_time if open_time > 0.0 else math.inf

    def generate_rays(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE) -> Rays:
        """Rays through raster points (n, 2) in pixels and pupil points (n, 2) in [0, 1]², at time (n,) in [0, 1).

        The very stages that the renderer runs, in float64 unless asked otherwise; wavelength in µm. ValueError
        for raster points that are not finite and pupil points outside the unit square.
        """
        raster_xy, pupil_uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_square(pupil_uv, dtype)
        if raster_xy.shape[1:] != (2,) or raster_xy.shape != pupil_uv.shape:
            raise CameraError(f"raster points {raster_xy.shape} and pupil points {pupil_uv.shape} must both be (n, 2)")
        if not np.isfinite(raster_xy).all():
            raise CameraError("raster points must be finite numbers")
        n = len(raster_xy)
        times = np.broadcast_to(np.asarray(time, float), (n,))
        given = {X: raster_xy[:, 0], Y: raster_xy[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1], TIME: times}
        out = Program(self.steps(wavelength), dtype).run(given, [X, Y, Z, L, M, N, WEIGHT], n)
        return Rays(out[:3].T, out[3:6].T, out[6], self.shutter_open + times * (self.shutter_close - self.shutter_open))
