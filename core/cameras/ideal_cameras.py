"""Cameras of an ideal lens without a prescription: perspective, orthographic, and a pinhole of finite size."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_lens import Gaussian, telecentric, thin
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.coordinate_spaces import Window, film_window
from lensbench.core.imaging.film import AXES, Film
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.iris import Iris, IrisError
from lensbench.core.optics.stop_image import StopImage
from lensbench.core.text import significant


class IdealLensCamera(Camera):
    """A camera of an ideal lens, whose kinds have the fields of `PerspectiveCamera` from lens_radius on."""

    lens_radius: float
    focus_distance: float
    window: Window | None
    blades: int
    blade_rotation: float
    roundness: float
    stop_image: StopImage | None

    def _check_lens(self) -> None:
        """CameraError for an invalid lens radius, focus distance (mm), window or iris; the window becomes floats."""
        if not (math.isfinite(self.lens_radius) and self.lens_radius >= 0.0):
            raise CameraError(f"lens radius {significant(self.lens_radius)} mm: it must be 0 (a pinhole) or positive")
        if not self.focus_distance > 0.0:
            raise CameraError(f"focus distance {significant(self.focus_distance)} mm: it must be positive")
        try:
            _ = self.iris
        except IrisError as error:
            raise CameraError(str(error)) from None
        if self.window is None:
            return
        sides = tuple(float(side) for side in self.window)
        if len(sides) != 4 or not all(map(math.isfinite, sides)) or not (sides[0] < sides[1] and sides[2] < sides[3]):
            raise CameraError("a screen window is four finite numbers: left < right, then bottom < top")
        object.__setattr__(self, "window", sides)

    @property
    def iris(self) -> Iris:
        """Shape of the lens's edge, for a radius of 1."""
        return Iris(self.blades, self.blade_rotation, self.roundness, self.stop_image)

    @cached_property
    def with_open_stop(self) -> Self:
        """The camera without a picture in its lens; see `Camera.with_open_stop`."""
        return self if self.stop_image is None else replace(self, stop_image=None)     # type: ignore[call-arg]


@dataclass(frozen=True, eq=False)
class PerspectiveCamera(IdealLensCamera):
    """Perspective camera with a thin lens or a pinhole at the camera's origin, looking along −z.

    Args:
        film: Size (mm) and pixels.
        fov: Full field of view (radians) of the whole screen along fov_axis.
        lens_radius: Radius (mm) of the thin lens; 0 is a pinhole.
        focus_distance: Distance (mm) from the lens to the plane in focus; math.inf is allowed.
        fov_axis: Length of the film that fov spans: "shorter", "longer", "horizontal", "vertical" or "diagonal".
        window: Part of the screen that falls on the film: left, right, bottom, top, where 1 is half the shorter side.
            It crops, extends or shifts the view, as the rise of a view camera does. None is the whole screen.
        blades: Number of blades of the lens's edge; 0 is a circle.
        blade_rotation: Rotation (radians) of the blades; see `Iris`.
        roundness: 0 for straight blades to 1 for a circle; see `Iris`.
        stop_image: A picture in the lens, instead of blades.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: A field of view, lens, window or iris that is not valid, or physical weights with a pinhole.
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
    stop_image: StopImage | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.fov < math.pi:
            raise CameraError(f"field of view {significant(math.degrees(self.fov))}°: it must lie between 0° and 180°")
        if self.fov_axis not in AXES:
            raise CameraError(f"field of view along {self.fov_axis!r}: choose one of {', '.join(AXES)}")
        self._check_lens()
        if self.lens_radius == 0.0 and self.weights == "physical":
            raise CameraError("a pinhole has no area for light to pass: give a lens radius, or choose relative weights")

    @property
    def film_distance(self) -> float:
        """Distance (mm) from the lens to the film that gives this field of view."""
        half = self.film.extent(self.fov_axis) / 2.0
        return half / math.tan(self.fov / 2.0)

    @property
    def gaussian(self) -> Gaussian:
        """First-order map of the thin lens or pinhole."""
        return thin(0.0, self.lens_radius, self.film_distance, self.focus_distance, self.iris)

    @property
    def image_plane_area(self) -> float:
        """Area (mm²) that the film sees of a plane at a distance of 1 mm from the lens."""
        left, right, bottom, top = self.window or film_window(self.film)
        half = min(self.film.width, self.film.height) / 2.0 / self.film_distance
        return (right - left) * (top - bottom) * half * half


@dataclass(frozen=True, eq=False)
class OrthographicCamera(IdealLensCamera):
    """Orthographic camera that looks along −z from the plane z = 0 of the camera frame.

    Args:
        film: Size (mm) and pixels.
        width: Width (mm) of the scene that falls on the film's width.
        lens_radius: Radius (mm) of a telecentric lens at z = 0, from which each film point's cone of rays has its apex
            on the plane in focus: objects out of focus blur and still keep their size. 0 gives each film point a single
            ray.
        focus_distance: Distance (mm) from the camera to the plane in focus; math.inf blurs nothing.
        window: Part of the screen that falls on the film; see `PerspectiveCamera`.
        blades, blade_rotation, roundness, stop_image: Shape of the lens's edge; see `PerspectiveCamera`.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: A size that is not positive, an invalid window or iris, or physical weights without a cone of rays.
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

    def __post_init__(self) -> None:
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


RAYLEIGH = 1.9          # diameter of the sharpest hole over √(wavelength · distance)
AIRY = 2.44             # diameter of Airy's disk, to its first dark ring, over wavelength · distance / hole diameter


@dataclass(frozen=True, eq=False)
class PinholeCamera(Camera):
    """Round hole of finite size at the camera's origin, looking along −z.

    Rays run straight through every point of the hole, without diffraction: `diffraction` gives the diameter of its
    disk, and `best_pinhole` the hole for which both together blur least.

    Args:
        film: Size (mm) and pixels.
        distance: Distance (mm) from the hole to the film.
        radius: Radius (mm) of the hole.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: A distance or radius that is not positive and finite.
    """

    film: Film
    distance: float = 50.0
    radius: float = 0.15

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in (("film distance", self.distance), ("hole radius", self.radius)):
            if not (math.isfinite(value) and value > 0.0):
                raise CameraError(f"{name} {significant(value)} mm: it must be a positive number")

    @property
    def gaussian(self) -> Gaussian:
        """First-order map of a lens without power."""
        per = 1.0 / self.distance
        return Gaussian(0.0, 0.0, self.radius, -per, self.radius * per, -per, self.radius * per)

    @property
    def fov(self) -> float:
        """Field of view (radians) along the shorter side of the film."""
        return 2.0 * math.atan(min(self.film.width, self.film.height) / (2.0 * self.distance))

    @property
    def f_number(self) -> float:
        """Ratio of film distance to hole diameter."""
        return self.distance / (2.0 * self.radius)

    def blur(self, object_distance: float = math.inf) -> float:
        """Diameter (mm) of the disk of light on the film from a point at object_distance (mm, also math.inf) before the
        hole.

        CameraError for a distance that is not positive.
        """
        if not object_distance > 0.0:
            raise CameraError(f"object distance {significant(object_distance)} mm: it must be positive")
        return 2.0 * self.radius * (1.0 + self.distance / object_distance)

    def diffraction(self, wavelength: float = D_LINE) -> float:
        """Diameter (mm) of Airy's disk on the film at a wavelength (µm), to its first dark ring."""
        return AIRY * wavelength * 1e-3 * self.distance / (2.0 * self.radius)


def best_pinhole(distance: float, object_distance: float = math.inf, wavelength: float = D_LINE) -> float:
    """Diameter of the sharpest pinhole: 1.9 √(λ b), with 1 / b = 1 / distance + 1 / object_distance.

    Source: Rayleigh 1891, On pin-hole photography.

    The sharpest hole passes 0.9 of the first Fresnel zone.

    Args:
        distance: Distance (mm) from the hole to the film.
        object_distance: Distance (mm) from the hole to the object; math.inf is allowed.
        wavelength: Wavelength of the light (µm).
    Returns:
        Diameter (mm).
    Raises:
        CameraError: A distance or wavelength that is not positive.
    """
    if not (distance > 0.0 and object_distance > 0.0 and wavelength > 0.0):
        raise CameraError("the sharpest pinhole needs positive distances and a positive wavelength")
    return RAYLEIGH * math.sqrt(wavelength * 1e-3 / (1.0 / distance + 1.0 / object_distance))
