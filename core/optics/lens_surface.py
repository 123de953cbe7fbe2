"""One surface of a lens as a frozen value: shape, clear aperture, coating, pose, and the gap and medium behind it.

Lengths in mm, angles in radians. The vertex is the origin, light travels along +z, and a curvature c = 1/R is positive
when the centre of curvature lies at +z of the vertex; `surfaces` has the formula of the sag. A pose (decentre, tilt,
roll) moves one surface and nothing else: those behind it stay ("decentre and return"). The surfaces of an element or
group have one pose about one pivot, and so move as a rigid body.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from math import atan2, cos, degrees, hypot, inf, isfinite, pi, radians, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.numeric import rotation_about_z, rotation_matrix
from lensbench.core.lazy import hashed_once
from lensbench.core.optics.coatings import Coating
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.surfaces import HIGHEST_POWER, sags, shape
from lensbench.core.text import excerpt, significant

STEEPEST = radians(60.0)        # of a tilt
FARTHEST = 1e4                  # mm: of a decentre


class PoseError(ValueError):
    """An invalid pose of a surface; the message says what to do."""


@dataclass(frozen=True)
class SurfacePose:
    """Where a tilted or decentred surface stands.

    The surface is rolled about its own axis, tilted about the pivot, first about the axis x, then about y, and then
    moved by the decentre.

    Args:
        decentre_x, decentre_y: Millimetres along x and y of the lens frame.
        tilt_x, tilt_y: Radians about x and about y, right-handed: a positive tilt_x takes the surface's upper rim (+y)
            back, towards the film; a positive tilt_y takes its rim at +x forward, towards the scene.
        pivot: The pivot is the centred vertex of the surface that stands so many places before this one; 0: of this
            one. For an element of the surfaces 3 and 4 about its front vertex it is 0 for surface 3, and 1 for surface
            4.
        roll: Radians about the own axis of the surface, right-handed about +z: a positive roll takes +x towards +y,
            counterclockwise as the camera looks. It turns cylinders, toroids, blades and a picture in the stop.
    Raises:
        PoseError: For tilts beyond 60°, a roll beyond 180°, decentres beyond 10 m, or a pivot that is no whole number.
    """

    decentre_x: float = 0.0
    decentre_y: float = 0.0
    tilt_x: float = 0.0
    tilt_y: float = 0.0
    pivot: int = 0
    roll: float = 0.0

    def __post_init__(self) -> None:
        for name, most in (("tilt_x", STEEPEST), ("tilt_y", STEEPEST), ("roll", pi)):
            angle = getattr(self, name)
            if not (isfinite(angle) and abs(angle) <= most * (1.0 + 1e-9)):
                raise PoseError(f"{name} {significant(degrees(angle))}° of a surface: it must lie from "
                                f"−{significant(degrees(most))}° to {significant(degrees(most))}°")
        for name in ("decentre_x", "decentre_y"):
            if not abs(getattr(self, name)) <= FARTHEST:
                raise PoseError(f"{name} {significant(getattr(self, name))} mm of a surface: it must lie from −10 m to "
                                "10 m")
        if self.pivot != int(self.pivot):
            raise PoseError(f"pivot {self.pivot} of a surface: it must be a whole number, of surfaces before it")
        object.__setattr__(self, "pivot", int(self.pivot))

    @property
    def is_centred(self) -> bool:
        """Whether the pose moves nothing."""
        return not (self.decentre_x or self.decentre_y or self.tilt_x or self.tilt_y or self.roll)

    def scaled(self, factor: float) -> "SurfacePose":
        """The pose in a lens scaled by a factor, with its decentres."""
        return replace(self, decentre_x=self.decentre_x * factor, decentre_y=self.decentre_y * factor)

    def turned(self) -> "SurfacePose":
        """The pose in a reversed lens, turned by half a turn about y."""
        return SurfacePose(-self.decentre_x or 0.0, self.decentre_y, -self.tilt_x or 0.0, self.tilt_y, -self.pivot,
                           -self.roll or 0.0)

    def mirrored(self, across: bool, up: bool) -> "SurfacePose":
        """The pose in a lens that is mirrored across (along x), up (along y), or both."""
        x, y = -1.0 if across else 1.0, -1.0 if up else 1.0
        return SurfacePose(x * self.decentre_x, y * self.decentre_y, y * self.tilt_x, x * self.tilt_y, self.pivot,
                           x * y * self.roll)


class Frame(NamedTuple):
    """A rigid motion of points of the lens frame: p ↦ rotation · p + shift, mm."""

    rotation: np.ndarray
    shift: np.ndarray

    @classmethod
    def of(cls, pose: SurfacePose, pivot: float) -> "Frame":
        """The motion of a pose about the point of the axis at z = pivot (mm)."""
        rotation = rotation_matrix(pose.tilt_x, pose.tilt_y)
        if pose.roll:
            rotation = rotation @ rotation_about_z(pose.roll)
        return cls(rotation, np.array([pose.decentre_x, pose.decentre_y, pivot]) - pivot * rotation[:, 2])

    def at(self, z: float) -> np.ndarray:
        """Where the point (3,) of the axis at z comes to lie."""
        return self.shift + z * self.rotation[:, 2]

    def into(self, other: "Frame") -> "Frame":
        """The motion from coordinates in this moved frame to those in another one."""
        return Frame(other.rotation.T @ self.rotation, other.rotation.T @ (self.shift - other.shift))


LENS_FRAME = Frame(np.eye(3), np.zeros(3))          # that of centred surfaces


def tilts_of(axes: np.ndarray) -> tuple[float, float, float]:
    """tilt_x, tilt_y and roll (radians) of the pose with these axes (3, 3), in columns; the inverse of `Frame.of`."""
    x, y, z = axes[:, 2].tolist()
    tilt_x, tilt_y = atan2(-y, hypot(x, z)) + 0.0, atan2(x, z) + 0.0            # + 0.0: no −0
    rolled = rotation_matrix(tilt_x, tilt_y).T @ axes
    return tilt_x, tilt_y, atan2(rolled[1, 0], rolled[0, 0]) + 0.0


class Shape(Enum):
    """A kind of surface; the value is its name in a sentence."""

    SPHERE = "a sphere"                             # or a plane
    CONIC = "a conic"
    EVEN_ASPHERE = "an asphere of even powers"      # r⁴, r⁶ …
    ASPHERE = "an asphere with odd powers or r²"
    CYLINDER = "a cylinder"                         # one of its two sections is straight
    TOROID = "a toroid"


class LensError(ValueError):
    """An invalid lens, or a demand that a lens cannot meet; the message says what to do."""


def check_film_distance(film_distance: float) -> None:
    """LensError for a film distance, last vertex → film (mm), that is not finite."""
    if not isfinite(film_distance):
        raise LensError(f"film distance {significant(film_distance)} mm: it must be a finite number")


@hashed_once
@dataclass(frozen=True)
class Surface:
    """One surface of a lens, with the gap and the medium behind it.

    The stop is a surface too, usually a plane with air on both sides.

    Args:
        curvature: Keyword only: c = 1/R in 1/mm, positive if the centre of curvature lies at +z; 0 for a plane. Or give
            `radius`.
        thickness: Gap to the next vertex (mm).
        semi_diameter: Radius of the rim (mm).
        glass: The medium behind the surface.
        conic: k: 0 for a sphere, −1 for a parabola.
        aspheric: tuple of (int, float). Powers from 2 to 20 and their coefficients in mm^(1 − power); stored by rising
            power, without zeros.
        curvature_x: None for rotational symmetry. Otherwise the curvature (1/mm) of the section x–z, and `curvature` is
            that of y–z: a cylinder or toroid, which has neither conic nor aspheric terms.
        coating: None: not known; what asks for it then says which it assumes.
        pose: Decentre, tilt and roll of this surface; None where it is centred.
        radius: Keyword only, instead of the curvature: R in mm, positive if the centre of curvature lies at +z;
            math.inf for a plane.
    Raises:
        LensError: For numbers that are not finite, a rim that is not positive, or invalid terms.
        TypeError: Without curvature and radius, or with both; for a glass that is no `Glass`, such as its name.
    """

    curvature: float
    thickness: float
    semi_diameter: float
    glass: Glass = AIR
    conic: float = 0.0
    aspheric: tuple[tuple[int, float], ...] = ()
    curvature_x: float | None = None
    coating: Coating | None = None
    pose: SurfacePose | None = None

    def __init__(self, thickness: float = 0.0, semi_diameter: float | None = None, glass: Glass = AIR,
                 conic: float = 0.0, aspheric: Iterable[tuple[int, float]] = (), curvature_x: float | None = None,
                 coating: Coating | None = None, pose: SurfacePose | None = None, *, curvature: float | None = None,
                 radius: float | None = None) -> None:
        if (curvature is None) == (radius is None):
            raise TypeError("a surface needs either its curvature or its radius of curvature, by name: radius=50.0 "
                            "(mm) or curvature=0.02 (1/mm)")
        if semi_diameter is None:
            raise TypeError("a surface needs its semi_diameter, the radius of its clear aperture in mm")
        if radius is not None:
            if radius != radius or radius == 0.0:
                raise LensError(f"radius of curvature {radius}: it must be a number of mm, or math.inf for a plane")
            curvature = 1.0 / radius
        values = {"curvature": curvature, "thickness": thickness, "semi_diameter": semi_diameter, "glass": glass,
                  "conic": conic, "aspheric": aspheric, "curvature_x": curvature_x, "coating": coating,
                  "pose": None if pose is None or pose.is_centred else pose}
        for name, value in values.items():
            object.__setattr__(self, name, value)
        self._check()

    def _check(self) -> None:
        for name in ("curvature", "thickness", "semi_diameter", "conic"):
            if not isfinite(getattr(self, name)):
                raise LensError(f"{name} is {getattr(self, name)}: it must be a finite number")
        if not isinstance(self.glass, Glass):
            raise TypeError(f"glass {excerpt(self.glass)}: it must be an lb.Glass; "
                            "lensbench.lenses.glass.catalogue.find(name) looks one up")
        if self.semi_diameter <= 0.0:
            raise LensError(f"semi-diameter is {significant(self.semi_diameter)} mm: it must be positive")
        object.__setattr__(self, "aspheric", _sound_terms(self.aspheric))
        if self.curvature_x is None:
            return
        if not isfinite(self.curvature_x):
            raise LensError(f"curvature_x is {self.curvature_x}: it must be a finite number, or left out")
        if self.conic != 0.0 or self.aspheric:
            raise LensError("a surface with curvature_x can have neither a conic nor aspheric terms")
        if self.curvature_x == self.curvature:
            object.__setattr__(self, "curvature_x", None)       # both sections alike: a sphere

    @property
    def radius(self) -> float:
        """Radius of curvature R = 1/c (mm); inf for a plane."""
        return 1.0 / self.curvature if self.curvature != 0.0 else inf

    @property
    def form(self) -> Shape:
        """The simplest shape that describes the surface; formats of lens files list those that they hold."""
        if self.curvature_x is not None:
            return Shape.TOROID if self.curvature and self.curvature_x else Shape.CYLINDER
        if self.aspheric:
            even = all(power % 2 == 0 and power > 2 for power, _ in self.aspheric)
            return Shape.EVEN_ASPHERE if even else Shape.ASPHERE
        return Shape.CONIC if self.conic else Shape.SPHERE

    @property
    def is_spherical(self) -> bool:
        """Whether the surface is a plane or a sphere."""
        return not self.aspheric and self.is_rotationally_symmetric and (self.conic == 0.0 or self.curvature == 0.0)

    @property
    def is_rotationally_symmetric(self) -> bool:
        """Whether the surface is no cylinder or toroid; its pose does not count."""
        return not self.asymmetry

    @property
    def asymmetry(self) -> str:
        """What keeps the shape from rotational symmetry, in words for a message; "" for nothing."""
        return "" if self.curvature_x is None else "a cylinder or toroid"

    @property
    def is_mirror_symmetric(self) -> bool:
        """Whether the surface is its own mirror image left to right and upside down: every centred shape is."""
        return self.pose is None

    def mirrored(self, across: bool, up: bool) -> "Surface":
        """The surface mirrored across (along x), up (along y), or both: its pose alone changes."""
        return self if self.pose is None else replace(self, pose=self.pose.mirrored(across, up))

    def section(self, axis: str) -> "Surface":
        """The rotationally symmetric surface of the section x–z (axis "x") or y–z ("y"); LensError for another axis.

        This surface itself if it is rotationally symmetric.
        """
        if axis not in ("x", "y"):
            raise LensError(f"section {axis!r}: it is 'x' for x–z or 'y' for y–z")
        if self.curvature_x is None:
            return self
        return replace(self, curvature=self.curvature if axis == "y" else self.curvature_x, curvature_x=None)

    @property
    def centred(self) -> "Surface":
        """The surface without its pose; a rolled cylinder or toroid has the curvatures of its sections x–z and y–z.

        These follow from Euler's theorem: to first order the sections of the rolled surface have them.
        """
        if self.pose is None:
            return self
        if self.curvature_x is None or not self.pose.roll:
            return replace(self, pose=None)
        c2, s2 = cos(self.pose.roll) ** 2, sin(self.pose.roll) ** 2
        return replace(self, pose=None, curvature=c2 * self.curvature + s2 * self.curvature_x,
                       curvature_x=c2 * self.curvature_x + s2 * self.curvature)

    @cached_property
    def vertex_curvature(self) -> float:
        """Curvature at the vertex in the section y–z of the lens (1/mm), including an r² term."""
        return self.centred.curvature + 2.0 * dict(self.aspheric).get(2, 0.0)

    @cached_property
    def shape(self) -> tuple[int, np.ndarray]:
        """The shape as a kind and a row of numbers of the table of `surfaces`."""
        return shape(self.curvature, self.conic, self.aspheric, self.curvature_x, self.semi_diameter)

    def sag(self, x: ArrayLike, y: ArrayLike = 0.0) -> np.ndarray:
        """Height z (mm) above the plane that touches the vertex at points x, y (mm, surface frame, broadcast); NaN
        beyond.
        """
        return sags(*self.shape, x, y)

    def scaled(self, factor: float) -> "Surface":
        """The surface and the gap behind it, all lengths multiplied by a factor; coefficients of r^p by its (1 − p)-th
        power.
        """
        return replace(self, curvature=self.curvature / factor, thickness=self.thickness * factor,
                       semi_diameter=self.semi_diameter * factor,
                       aspheric=tuple((power, a * factor ** (1 - power)) for power, a in self.aspheric),
                       curvature_x=None if self.curvature_x is None else self.curvature_x / factor,
                       pose=self.pose and self.pose.scaled(factor))

    def reversed(self, thickness: float, glass: Glass) -> "Surface":
        """The surface met from behind, turned about y, with another thickness (mm) and glass of the gap behind it."""
        return replace(self, curvature=-self.curvature or 0.0, thickness=thickness, glass=glass,
                       aspheric=tuple((power, -a) for power, a in self.aspheric),
                       curvature_x=None if self.curvature_x is None else -self.curvature_x or 0.0,
                       pose=self.pose and self.pose.turned())


def _sound_terms(terms: Iterable[tuple[int, float]]) -> tuple[tuple[int, float], ...]:
    """Aspheric terms by rising power, without zeros; LensError for an invalid power or coefficient."""
    sound: dict[int, float] = {}
    for power, coefficient in terms:
        if power != int(power) or not 2 <= power <= HIGHEST_POWER:
            raise LensError(f"aspheric power {power}: it must be a whole number from 2 to {HIGHEST_POWER}")
        if power in sound:
            raise LensError(f"the aspheric term r^{power} is given twice")
        if not isfinite(coefficient):
            raise LensError(f"the aspheric coefficient of r^{power} is {coefficient}: it must be a finite number")
        sound[int(power)] = float(coefficient)
    return tuple((power, sound[power]) for power in sorted(sound) if sound[power] != 0.0)
