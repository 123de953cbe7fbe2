"""A camera without a prescription: a field of view, and a thin lens or a pinhole."""

import math
from dataclasses import dataclass

from lensbench.cameras.camera import Camera, CameraError
from lensbench.cameras.thin import axis_irradiance, ideal
from lensbench.film import Film
from lensbench.glass import D_LINE
from lensbench.lanes import Step


@dataclass(frozen=True, eq=False)
class PerspectiveCamera(Camera):
    """Looks from its lens at the camera's origin along −z.

    fov: along the shorter side (radians); lens_radius: mm, 0 is a pinhole;
    focus_distance: from the lens (mm), math.inf allowed.
    """

    film: Film
    fov: float = 0.8
    lens_radius: float = 0.0
    focus_distance: float = math.inf

    def __post_init__(self):
        super().__post_init__()
        if not 0.0 < self.fov < math.pi:
            raise CameraError(f"field of view {math.degrees(self.fov):g}°: it must lie between 0° and 180°")
        if not (math.isfinite(self.lens_radius) and self.lens_radius >= 0.0):
            raise CameraError(f"lens radius {self.lens_radius:g} mm: it must be 0 (a pinhole) or positive")
        if self.lens_radius == 0.0 and self.weights == "physical":
            raise CameraError("a pinhole has no area for light to pass: give a lens radius, or choose relative weights")
        if not self.focus_distance > 0.0:
            raise CameraError(f"focus distance {self.focus_distance:g} mm: it must be positive")

    @property
    def film_distance(self) -> float:
        """From the lens to its film (mm), as the field of view has it: the film may be imagined anywhere."""
        return min(self.film.width, self.film.height) / 2.0 / math.tan(self.fov / 2.0)

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """One step: the thin lens, or the pinhole, for every wavelength alike."""
        z = self.film_distance
        if self.lens_radius == 0.0:
            return [ideal(0.0, 0.0, z, self.focus_distance, 1.0)]
        area = math.pi * self.lens_radius**2
        gain = area / self._normaliser(axis_irradiance(self.lens_radius, z), z)
        return [ideal(0.0, self.lens_radius, z, self.focus_distance, gain)]
