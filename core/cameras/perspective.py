"""A camera without a prescription: a field of view, and a thin lens or a pinhole."""

import math
from dataclasses import dataclass

from lensbench.cameras.base import Camera
from lensbench.cameras.film_landing import FilmLanding, ideal_film_landing
from lensbench.cameras.ideal_lens import Gaussian, thin
from lensbench.cameras.rays import CameraError
from lensbench.imaging.coordinate_spaces import Window, film_window, window_step
from lensbench.imaging.film import AXES, Film
from lensbench.kernels.block import Step
from lensbench.optics.glass import D_LINE
from lensbench.optics.iris import Iris, IrisError


@dataclass(frozen=True, eq=False)
class PerspectiveCamera(Camera):
    """Looks from its lens at the camera's origin along −z.

    fov: along the shorter side (radians), or along what fov_axis says: "shorter", "longer", "horizontal", "vertical",
    "diagonal". lens_radius: mm, 0 is a pinhole; focus_distance: from the lens (mm), math.inf allowed. window: what
    of the screen falls on the film, (left, right, bottom, top) with 1 half the shorter side; None: all of it. A window
    crops, extends or shifts the view (a shifted one is a view camera's rise); fov stays that of the whole screen.
    blades (0: a circle), blade_rotation (radians), roundness: the shape of the lens's edge, as an `Iris` has it.
    CameraError for what cannot be.
    """

    film: Film
    fov: float = 0.8
    lens_radius: float = 0.0
    focus_distance: float = math.inf
    fov_axis: str = "shorter"
    window: Window | None = None
    blades: int = 0
    blade_rotation: float = 0.0
    roundness: float = 0.0

    def __post_init__(self):
        super().__post_init__()
        if not 0.0 < self.fov < math.pi:
            raise CameraError(f"field of view {math.degrees(self.fov):g}°: it must lie between 0° and 180°")
        if self.fov_axis not in AXES:
            raise CameraError(f"field of view along {self.fov_axis!r}: choose one of {', '.join(AXES)}")
        check_lens(self.lens_radius, self.focus_distance)
        checked_iris(self.blades, self.blade_rotation, self.roundness)
        if self.lens_radius == 0.0 and self.weights == "physical":
            raise CameraError("a pinhole has no area for light to pass: give a lens radius, or choose relative weights")
        object.__setattr__(self, "window", checked_window(self.window))

    @property
    def iris(self) -> Iris:
        """The shape of the lens's edge, for a radius of 1."""
        return Iris(self.blades, self.blade_rotation, self.roundness)

    @property
    def film_distance(self) -> float:
        """From the lens to its film (mm), as the field of view has it: the film may be imagined anywhere."""
        half = self.film.extent(self.fov_axis) / 2.0
        return half / math.tan(self.fov / 2.0)

    @property
    def film_step(self) -> Step:
        """From raster to the film, of which the window is imagined as a part."""
        return self.film.step if self.window is None else window_step(self.film, self.window)

    @property
    def gaussian(self) -> Gaussian:
        """Its rays."""
        return thin(0.0, self.lens_radius, self.film_distance, self.focus_distance, self.iris)

    @property
    def image_plane_area(self) -> float:
        """Of the part of the plane at distance 1 from the lens that the film sees: mm² on a plane at 1 mm."""
        left, right, bottom, top = self.window or film_window(self.film)
        half = min(self.film.width, self.film.height) / 2.0 / self.film_distance
        return (right - left) * (top - bottom) * half * half

    def way_back(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """In closed form, for every wavelength alike."""
        return ideal_film_landing(self.gaussian, self.film_step, self.gain)

    @property
    def gain(self) -> float:
        """Weight of the ray along the axis."""
        lens = self.gaussian
        return 1.0 if self.lens_radius == 0.0 else lens.cone / self._normaliser(lens.axis_irradiance, 1.0)


def check_lens(radius: float, focus_distance: float) -> None:
    """CameraError where no thin lens can have this radius and focus (mm)."""
    if not (math.isfinite(radius) and radius >= 0.0):
        raise CameraError(f"lens radius {radius:g} mm: it must be 0 (a pinhole) or positive")
    if not focus_distance > 0.0:
        raise CameraError(f"focus distance {focus_distance:g} mm: it must be positive")


def checked_iris(blades: int, rotation: float, roundness: float) -> Iris:
    """The shape of a lens's edge; CameraError where it can have no such one."""
    try:
        return Iris(blades, rotation, roundness)
    except IrisError as error:
        raise CameraError(str(error)) from None


def checked_window(window) -> Window | None:
    """The window as four floats; CameraError where it is none."""
    if window is None:
        return None
    sides = tuple(float(side) for side in window)
    if len(sides) != 4 or not all(map(math.isfinite, sides)) or not (sides[0] < sides[1] and sides[2] < sides[3]):
        raise CameraError("a screen window is four finite numbers: left < right, then bottom < top")
    return sides
