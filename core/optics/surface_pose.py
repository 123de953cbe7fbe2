"""The pose of a surface out of line: decentre, tilt and roll, as of a view-camera lens or a fault of mounting.

Lens frame, mm and radians. A pose moves one surface and nothing else: the places of the surfaces behind it stay
("decentre and return"). The surfaces of an element or of a group have the same pose about the same pivot, and so move
as one rigid body.
"""

from dataclasses import dataclass, replace
from math import atan2, degrees, hypot, isfinite, pi, radians
from typing import NamedTuple

import numpy as np

from lensbench.kernels.figures import significant
from lensbench.kernels.rotation import rotation_about_z, rotation_matrix

STEEPEST = radians(60.0)        # of a tilt
FARTHEST = 1e4                  # mm: of a decentre


class PoseError(ValueError):
    """An invalid pose of a surface; the message says what to do."""


@dataclass(frozen=True)
class SurfacePose:
    """Where a surface stands that is out of line.

    The surface is rolled about its own axis, tilted about the pivot, first about the axis x, then about y, and then
    moved by the decentre.

    Parameters
    ----------
    decentre_x, decentre_y : float
        Millimetres along x and y of the lens frame.
    tilt_x, tilt_y : float
        Radians about x and about y, right-handed: a positive tilt_x takes the surface's upper rim (+y) back, towards
        the film; a positive tilt_y takes its rim at +x forward, towards the scene.
    pivot : int
        The pivot is the vertex, in line, of the surface that stands so many places before this one; 0: of this one. For
        an element of the surfaces 3 and 4 about its front vertex it is 0 for surface 3, and 1 for surface 4.
    roll : float
        Radians about the own axis of the surface, right-handed about +z: a positive roll takes +x towards +y,
        counterclockwise as the camera looks. It turns cylinders, toroids, blades and a picture in the stop.

    Raises
    ------
    PoseError
        For tilts beyond 60°, a roll beyond 180°, decentres beyond 10 m, or a pivot that is no whole number.
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
    def is_in_line(self) -> bool:
        """Whether the pose moves nothing."""
        return not (self.decentre_x or self.decentre_y or self.tilt_x or self.tilt_y or self.roll)

    def scaled(self, factor: float) -> "SurfacePose":
        """The pose in a scaled lens.

        Parameters
        ----------
        factor : float
            Factor on the decentres.

        Returns
        -------
        SurfacePose
        """
        return replace(self, decentre_x=self.decentre_x * factor, decentre_y=self.decentre_y * factor)

    def turned(self) -> "SurfacePose":
        """The pose in a lens turned round, by half a turn about y.

        Returns
        -------
        SurfacePose
        """
        return SurfacePose(-self.decentre_x or 0.0, self.decentre_y, -self.tilt_x or 0.0, self.tilt_y, -self.pivot,
                           -self.roll or 0.0)

    def mirrored(self, across: bool, up: bool) -> "SurfacePose":
        """The pose in a mirrored lens.

        Parameters
        ----------
        across : bool
            Along x.
        up : bool
            Along y.

        Returns
        -------
        SurfacePose
        """
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


IN_LINE = Frame(np.eye(3), np.zeros(3))


def tilts_of(axes: np.ndarray) -> tuple[float, float, float]:
    """tilt_x, tilt_y and roll (radians) of the pose with these axes (3, 3), in columns; the inverse of `Frame.of`."""
    x, y, z = axes[:, 2].tolist()
    tilt_x, tilt_y = atan2(-y, hypot(x, z)) + 0.0, atan2(x, z) + 0.0            # + 0.0: no −0
    rolled = rotation_matrix(tilt_x, tilt_y).T @ axes
    return tilt_x, tilt_y, atan2(rolled[1, 0], rolled[0, 0]) + 0.0
