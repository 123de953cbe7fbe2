"""The pose of a film out of line: tilt, swing, rise and shift, as the back of a view camera has them.

Camera frame, mm and radians: the lens keeps its place and its axis, and the film moves. Film points (x, y) are those of
the film's own frame, whose axes and centre the pose places in the camera frame.
"""

from dataclasses import dataclass
from functools import cached_property
from math import degrees, isfinite, radians

import numpy as np

from lensbench.imaging.film import FilmError
from lensbench.kernels.block import B, Step, X, Y, Z, rows, stage
from lensbench.kernels.figures import significant
from lensbench.kernels.rotation import rotation_matrix

STEEPEST = radians(60.0)        # of tilt and swing
FARTHEST = 1e4                  # mm: of rise and shift
NUMBERS = 11                    # of a pose in the parameters of a stage


@dataclass(frozen=True)
class FilmPose:
    """Where a film lies behind a lens.

    Parameters
    ----------
    tilt : float
        Radians about the film's horizontal middle line; positive tips the top of the film back, away from the lens. The
        image is inverted, so that the ground in front of the camera comes into focus, as with a lens that is tilted
        down.
    swing : float
        Radians about the vertical; positive turns the film's right side, seen from behind, back. The left of the
        picture's scene is then in focus nearer.
    rise, shift : float
        Millimetres by which the lens stands above, and to the right of, the film's centre: the picture shows what is
        higher, or further to the right.

    Raises
    ------
    FilmError
        For angles beyond 60°, or lengths beyond 10 m.
    """

    tilt: float = 0.0
    swing: float = 0.0
    rise: float = 0.0
    shift: float = 0.0

    def __post_init__(self) -> None:
        for name in ("tilt", "swing"):
            angle = getattr(self, name)
            if not (isfinite(angle) and abs(angle) <= STEEPEST * (1.0 + 1e-9)):
                raise FilmError(f"{name} {significant(degrees(angle))}° of the film: it must lie from −60° to 60°")
        for name in ("rise", "shift"):
            if not abs(getattr(self, name)) <= FARTHEST:
                raise FilmError(f"{name} {significant(getattr(self, name))} mm of the film: it must lie from −10 m to "
                                "10 m")

    @property
    def is_upright(self) -> bool:
        """Whether the film is in line with the lens: centred, and perpendicular to its axis."""
        return self == UPRIGHT

    @property
    def is_tilted(self) -> bool:
        """Whether the film is not perpendicular to the axis of the lens."""
        return self.tilt != 0.0 or self.swing != 0.0

    @cached_property
    def axes(self) -> np.ndarray:
        """Unit vectors (3, 3), a row each: along the film's x and y, and its normal away from the lens."""
        return rotation_matrix(self.tilt, -self.swing).T

    @cached_property
    def centre(self) -> np.ndarray:
        """The film's centre (3,), camera frame (mm)."""
        return np.array([-self.shift, -self.rise, 0.0])

    def points(self, film_xy: np.ndarray) -> np.ndarray:
        """Points of the camera frame for film points.

        Parameters
        ----------
        film_xy : array_like, shape (n, 2)
            In the plane of the film, mm from its centre.

        Returns
        -------
        ndarray, shape (n, 3)
            Camera frame, mm.
        """
        return self.centre + np.asarray(film_xy, float) @ self.axes[:2]

    def film_points(self, points: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Film points where lines meet the film.

        Parameters
        ----------
        points : ndarray, shape (n, 2)
            Where the lines cross z = 0, camera frame, mm.
        slopes : ndarray, shape (n, 2)
            By how much the lines move sideways for each mm of z.

        Returns
        -------
        ndarray, shape (n, 2)
            In the plane of the film, mm from its centre.
        """
        x, y, normal = self.axes
        start = np.column_stack([points, np.zeros(len(points))]) - self.centre
        along = np.column_stack([slopes, np.ones(len(slopes))])
        with np.errstate(divide="ignore", invalid="ignore"):
            met = start - (start @ normal / (along @ normal))[:, None] * along
        return np.column_stack([met @ x, met @ y])

    def corners(self, width: float, height: float) -> np.ndarray:
        """Corners of a film in this pose.

        Parameters
        ----------
        width, height : float
            Size of the film, mm.

        Returns
        -------
        ndarray, shape (4, 3)
            Camera frame, mm; around the film from (−x, −y) over (+x, −y).
        """
        half = 0.5 * np.array([width, height])
        return self.points(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * half)

    @property
    def numbers(self) -> np.ndarray:
        """The pose in the parameters of a stage, (NUMBERS,): the centre's x and y, then the axes."""
        return np.concatenate([self.centre[:2], self.axes.ravel()])

    @property
    def step(self) -> Step:
        """Step from film points X, Y to points X, Y, Z of the camera frame."""
        return Step(place_film_point, self.numbers)


UPRIGHT = FilmPose()


@stage
def place_film_point(lanes, p, ints, key):
    """Film point X, Y to the point X, Y, Z of the camera frame. p: `FilmPose.numbers`."""
    row = rows(lanes)
    x, y, z = row[X], row[Y], row[Z]
    cx, cy, xx, xy, xz, yx, yy, yz = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]
    for i in range(B):
        u, v = x[i], y[i]
        x[i], y[i], z[i] = cx + u * xx + v * yx, cy + u * xy + v * yy, u * xz + v * yz
