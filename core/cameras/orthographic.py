"""Orthographic camera: parallel chief rays, so objects keep their size at any distance."""

import math
from dataclasses import dataclass

from lensbench.core.cameras.ideal_lens import Gaussian, telecentric
from lensbench.core.cameras.perspective import IdealLensCamera
from lensbench.core.cameras.rays import CameraError
from lensbench.core.imaging.coordinate_spaces import Window
from lensbench.core.imaging.film import Film
from lensbench.core.optics.stop_image import StopImage
from lensbench.core.text import significant


@dataclass(frozen=True, eq=False)
class OrthographicCamera(IdealLensCamera):
    """Orthographic camera that looks along −z from the plane z = 0 of the camera frame.

    Parameters
    ----------
    film : Film
        Size (mm) and pixels.
    width : float
        Width (mm) of the scene that falls on the film's width.
    lens_radius : float
        Radius (mm) of a telecentric lens at z = 0, from which each film point's cone of rays has its apex on the plane
        in focus: objects out of focus blur and still keep their size. 0 gives each film point a single ray.
    focus_distance : float
        Distance (mm) from the camera to the plane in focus; math.inf blurs nothing.
    window : tuple of four floats or None
        Part of the screen that falls on the film; see `PerspectiveCamera`.
    blades, blade_rotation, roundness, stop_image
        Shape of the lens's edge; see `PerspectiveCamera`.
    **placement
        Keyword arguments of `Camera`: transform, shutter, weights and medium.

    Raises
    ------
    CameraError
        A size that is not positive, an invalid window or iris, or physical weights without a cone of rays.
    """

    film: Film
    width: float
    lens_radius: float = 0.0
    focus_distance: float = math.inf
    window: Window | None = None
    blades: int = 0
    blade_rotation: float = 0.0
    roundness: float = 0.0
    stop_image: StopImage | None = None

    def __post_init__(self):
        super().__post_init__()
        if not (math.isfinite(self.width) and self.width > 0.0):
            raise CameraError(f"width {significant(self.width)} mm of scene: it must be a positive number")
        self._check_lens()
        if self.weights == "physical" and self.gaussian.cone == 0.0:
            raise CameraError("parallel rays alone carry no light: give a lens radius and a finite focus distance, "
                              "or choose relative weights")

    @property
    def scale(self) -> float:
        """Scene size (mm) for each mm of film."""
        return self.width / self.film.width

    @property
    def gaussian(self) -> Gaussian:
        """First-order map of the telecentric lens."""
        return telecentric(self.scale, self.lens_radius, self.focus_distance, self.iris)

    @property
    def gain(self) -> float:
        """Weight of the axial ray; the film receives the light of a cone on an area smaller by scale²."""
        lens = self.gaussian
        return 1.0 if lens.cone == 0.0 else lens.cone / self._normaliser(lens.axis_irradiance, 1.0 / self.scale)
