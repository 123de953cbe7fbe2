"""What a camera kind defines, and the stages that follow from it: raster point and pupil sample → ray in the world.

A kind gives its own film and either `gaussian`, for a projective camera, or `camera_steps`. Everything else has a
default that a kind may override, here and in `base`. The camera frame has its origin at the camera, x to the
right, y up, and the camera looks along −z; the film lies in the plane z = 0 of a real lens, or is imagined behind an
ideal one.
"""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from lensbench.core.cameras.film_landing import FilmLanding, ideal_film_landing
from lensbench.core.cameras.flat_port import FlatPort, port_step
from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.cameras.shutter import CameraError, PlacedShutter
from lensbench.core.imaging.coordinate_spaces import Window, window_step
from lensbench.core.imaging.film import UPRIGHT, FilmPose
from lensbench.core.kernels.block import Step
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.film_grid_sampler import PupilGrid
from lensbench.core.pupils.posed_sampler import PosedPupil
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.scenery.shading.participating_medium import Medium


@dataclass(frozen=True, eq=False, kw_only=True)
class CameraStages(PlacedShutter):
    """The part of `Camera` that a camera kind may override, and its stages. `Camera` documents the fields."""

    weights: str = "relative"
    medium: Medium | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.weights == "one":
            object.__setattr__(self, "weights", "radiance")
        if self.weights not in ("relative", "physical", "radiance"):
            raise CameraError(f"weights {self.weights!r}: choose relative, physical or radiance")

    # Members that a camera kind may override

    @property
    def pupil_centre(self) -> tuple[float, float]:
        """Pupil sample of the ray through the centre of the pupil: (0.5, 0.5) in every camera."""
        return 0.5, 0.5

    @property
    def with_open_stop(self) -> Self:
        """The camera without a picture in its stop: its central rays pass wherever the picture is opaque."""
        return self

    @property
    def stage_centre(self) -> tuple[float, float]:
        """U0, U1 of the ray through the centre of the pupil, as the camera's stages take them."""
        return 0.5, 0.5

    def stage_uv(self, film_xy: np.ndarray, pupil_uv: np.ndarray) -> np.ndarray:
        """U0, U1 (n, 2), as the camera's stages take them, of pupil_uv (n, 2) in [0, 1]² at film_xy (n, 2), mm."""
        return pupil_uv

    @property
    def gaussian(self) -> Gaussian:
        """First-order map from film and pupil to rays; CameraError for a camera that is not projective."""
        raise CameraError(f"this camera is not projective: {self._not_projective}")

    @property
    def _not_projective(self) -> str:
        """Reason why a camera kind without a `gaussian` has none."""
        return "straight lines are curves in its pictures"

    @property
    def _is_projective(self) -> bool:
        """Whether this camera kind defines its `gaussian`."""
        return type(self).gaussian is not CameraStages.gaussian

    @property
    def window(self) -> Window | None:
        """Part of the screen that falls on the film; None: the whole screen."""
        return None

    @property
    def film_step(self) -> Step:
        """Step from raster pixels to the film point X, Y (mm), scaled so that the window falls on the film."""
        return self.film.step if self.window is None else window_step(self.film, self.window)

    @property
    def disperses(self) -> bool:
        """Whether the rays depend on the wavelength."""
        return False

    @property
    def follows_rays(self) -> bool:
        """Whether the rays follow a real lens with its aberrations rather than `gaussian`."""
        return False

    @property
    def traced_lens(self) -> Lens | None:
        """Lens whose surfaces the rays are traced through one by one; None for every other camera."""
        return None

    @property
    def gain(self) -> float:
        """Weight of the axial ray of a projective camera; the others fall off from it as cos⁴θ."""
        lens = self.gaussian
        return lens.cone / self._normaliser(lens.axis_irradiance, 1.0) if lens.cone else 1.0

    @property
    def geometric_f_number(self) -> float:
        """Ratio of focal length to pupil diameter, or of image distance for an ideal lens; inf for a pinhole.

        The diameter is that of a circle of as much area as blades leave.
        """
        slope = abs(self.gaussian.approach_pupil) * self.gaussian.iris.equivalent_radius
        return 0.5 / slope if slope > 0.0 else math.inf

    @property
    def nearest_focus(self) -> float:
        """Shortest distance (mm) at which this camera can be focused."""
        return 1e-3

    def refocused(self, focus_distance: float) -> Self:
        """The camera at another focus_distance (mm); for a camera kind with such a field."""
        return replace(self, focus_distance=focus_distance)         # type: ignore[call-arg]

    @property
    def front(self) -> float:
        """Coordinate z (mm, camera frame) of the camera's foremost point, the position of a window."""
        return 0.0

    @property
    def dilution(self) -> float:
        """Ratio of the radiance before the front surface to that behind it: the squared index before it."""
        return 1.0

    @property
    def aim_distance(self) -> float | None:
        """Distance (mm) from the film to the plane with the exit-pupil regions that the first camera step aims at.

        These regions rotate with the film point. None: the same U0, U1 are the same pupil point for every film point.
        """
        return None

    @property
    def pupil(self) -> PupilTable | PupilGrid | PosedPupil:
        """Exit-pupil regions that a camera with an aim_distance samples."""
        raise AssertionError("a camera with an aim_distance defines its pupil")

    @property
    def film_pose(self) -> FilmPose:
        """Pose of the film in the camera frame; centred for every camera but one with a lens."""
        return UPRIGHT

    def film_landing(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """Stages that project traced light of a wavelength (µm) onto the raster, or None where the camera has none."""
        if not self._is_projective:
            return None
        return ideal_film_landing(self._weighted_gaussian, self.film_step, self._weighted_gain)

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
        """Derivatives (2, n, 6) of rays by the film point at a fixed pupil sample, or None without a closed form;
        camera frame.

        By what a mm of film in x and in y changes origins (mm) and directions, for film_xy (n, 2) and directions (n,
        3).
        """
        return self.gaussian.film_slopes(directions) if self._is_projective else None

    # Steps

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from the film point X, Y (mm) and pupil sample U0, U1 to a ray in the camera frame with its WEIGHT.

        wavelength: µm; it has no effect on a camera that does not disperse.
        """
        return self._weighted_gaussian.steps(self._weighted_gain)

    @property
    def _weighted_gaussian(self) -> Gaussian:
        """`gaussian` with the slopes whose cos⁴θ weighs the rays: none where all weights are 1."""
        if self.weights == "radiance":
            return self.gaussian._replace(approach_film=0.0, approach_pupil=0.0)
        return self.gaussian

    @property
    def _weighted_gain(self) -> float:
        """`gain`, or 1 where all weights are 1."""
        return 1.0 if self.weights == "radiance" else self.gain

    def lens_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from a ray aimed at an exit-pupil region to the ray before the lens, at a wavelength (µm).

        AssertionError if the camera does not aim: it has no `aim_distance`.
        """
        raise AssertionError("a camera with an aim_distance defines its lens_steps")

    def steps(self, wavelength: float = D_LINE, timed: bool = False) -> list[Step]:
        """Steps from raster X, Y, pupil sample U0, U1 and TIME to a ray in the world with its WEIGHT, at a wavelength
        (µm).

        timed: whether TIME becomes seconds since shutter_open. A camera that moves always converts it.
        """
        clock = [self.clock] if timed or self.moves else []
        return [*clock, self.film_step, *self.aimed(wavelength), *self.carried]

    def aimed(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from the film point and pupil sample to the ray in the scene's medium, camera frame, at a wavelength
        (µm).
        """
        return [*self.camera_steps(wavelength), *self.port]

    @property
    def port(self) -> list[Step]:
        """Step through the window into a medium of another index; empty without a window."""
        if not self.has_port:
            return []
        index = self.flat_port.index
        return [port_step(self.front, index, 1.0 / index**2 if self.weights == "physical" else 1.0)]

    @property
    def flat_port(self) -> FlatPort:
        """The window into a medium of another index, its distance from the camera's origin; index 1 without one."""
        return FlatPort(-self.front, self.medium.index) if self.has_port and self.medium is not None else FlatPort()

    @property
    def has_port(self) -> bool:
        """Whether the camera looks through a window into a medium of another index."""
        return self.medium is not None and self.medium.index != 1.0

    def _normaliser(self, on_axis: float, z: float) -> float:
        """Divisor of cos⁴θ · area; on_axis: ∫ cos⁴θ dA (mm²) seen from the film's centre, z: film distance (mm)."""
        if self.weights != "physical":
            return on_axis
        return z * z * self.dilution / self.effective_time if self.effective_time > 0.0 else math.inf
