"""A camera whose rays are parallel: things keep their size at any distance."""

import math
from dataclasses import dataclass

from lensbench.cameras.base import Camera
from lensbench.cameras.ideal_lens import Gaussian, telecentric
from lensbench.cameras.perspective import check_lens, checked_iris, checked_window
from lensbench.cameras.rays import CameraError
from lensbench.imaging.coordinate_spaces import Window, window_step
from lensbench.imaging.film import Film
from lensbench.kernels.block import Step
from lensbench.optics.iris import Iris


@dataclass(frozen=True, eq=False)
class OrthographicCamera(Camera):
    """Looks along −z from the plane z = 0 of the camera's frame.

    width: mm of scene across the film's width. lens_radius (mm): 0 gives each film point one ray; otherwise a cone
    of rays, this wide at z = 0, with its point on the plane focus_distance before the camera, as a telecentric lens
    does it: things out of focus blur, and still keep their size. With focus_distance=math.inf
    nothing blurs. window and blades: as of a PerspectiveCamera. CameraError for what cannot be.
    """

    film: Film
    width: float
    lens_radius: float = 0.0
    focus_distance: float = math.inf
    window: Window | None = None
    blades: int = 0
    blade_rotation: float = 0.0
    roundness: float = 0.0

    def __post_init__(self):
        super().__post_init__()
        if not (math.isfinite(self.width) and self.width > 0.0):
            raise CameraError(f"width {self.width:g} mm of scene: it must be a positive number")
        check_lens(self.lens_radius, self.focus_distance)
        checked_iris(self.blades, self.blade_rotation, self.roundness)
        if self.weights == "physical" and self.gaussian.cone == 0.0:
            raise CameraError("parallel rays alone carry no light: give a lens radius and a finite focus distance, "
                              "or choose relative weights")
        object.__setattr__(self, "window", checked_window(self.window))

    @property
    def film_step(self) -> Step:
        """From raster to the film, of which the window is imagined as a part."""
        return self.film.step if self.window is None else window_step(self.film, self.window)

    @property
    def scale(self) -> float:
        """How many mm of scene fall on one of film."""
        return self.width / self.film.width

    @property
    def gaussian(self) -> Gaussian:
        """Its rays."""
        return telecentric(self.scale, self.lens_radius, self.focus_distance,
                           Iris(self.blades, self.blade_rotation, self.roundness))

    @property
    def gain(self) -> float:
        """Weight of the ray along the axis: what a cone brings to the plane in focus is scale² as dense on the film."""
        lens = self.gaussian
        return 1.0 if lens.cone == 0.0 else lens.cone / self._normaliser(lens.axis_irradiance, 1.0 / self.scale)
