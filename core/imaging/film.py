"""The film: its size, pixels, common formats, pose and curvature behind a lens, and the fields of view that it takes.

Lengths in mm. Raster (x, y) are pixels with the origin at the top left corner of the picture and pixel centres at +0.5.
A raster point lies at ((0.5 − x/w) width, (y/h − 0.5) height) on the film, in the camera frame: the image is inverted.

The pose is that of a view camera's back: tilt, swing, rise and shift; the lens stays. Film points (x, y) are those of
the film's own frame, which the pose places in the camera frame. A curved film is a sphere that touches the plane of x
and y at its middle; its points have the x and y of that plane.

A field of view is that of a lens without distortion focused at infinity, 2 atan(h / 2f), in radians.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from math import degrees, hypot, inf, isfinite, nan, radians
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.block import B, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.numeric import rotation_matrix
from lensbench.core.text import significant

AXES = ("shorter", "longer", "horizontal", "vertical", "diagonal")      # of a field of view
MAX_PIXELS = 200_000_000
MAX_SIDE = 2**24                            # pixels; float32 counts no further

PITCH_X, EDGE_X, PITCH_Y, EDGE_Y = range(4)        # parameters of `film_from_raster`, mm

FORMATS: dict[str, tuple[float, float]] = {     # width, height in mm
    "Full frame 36 × 24": (36.0, 24.0),
    "APS-C 23.5 × 15.6": (23.5, 15.6),
    "Micro Four Thirds 17.3 × 13": (17.3, 13.0),
    "1 inch 13.2 × 8.8": (13.2, 8.8),
    "1/1.7 inch 7.6 × 5.7": (7.6, 5.7),
    "1/2.55 inch 5.6 × 4.2": (5.6, 4.2),
    "Super 35 24.9 × 18.7": (24.89, 18.66),
    "Super 16 12.5 × 7.4": (12.52, 7.41),
    "Medium 44 × 33": (43.8, 32.9),
    "6 × 6 cm 56 × 56": (56.0, 56.0),
    "6 × 7 cm 70 × 56": (70.0, 56.0),
    "Large 4 × 5 inch": (127.0, 101.6),
    "Large 8 × 10 inch": (254.0, 203.2),
}


class FilmError(ValueError):
    """Invalid size, pixels or field of view of a film; the message says what to do."""


@dataclass(frozen=True)
class Film:
    """A film or sensor: its size and its pixels, which need not be square.

    Args:
        width, height: Size in mm, across and down.
        pixels_x, pixels_y: Number of pixels across and down.
    Raises:
        FilmError: For a side that is not positive, or a number of pixels outside the limits.
    """

    width: float = 36.0
    height: float = 24.0
    pixels_x: int = 960
    pixels_y: int = 640

    def __post_init__(self) -> None:
        for side, size in (("width", self.width), ("height", self.height)):
            if not (isfinite(size) and size > 0.0):
                raise FilmError(f"film {side} {significant(size)} mm: it must be a positive number")
        for side, pixels in (("across", self.pixels_x), ("down", self.pixels_y)):
            if not (isfinite(pixels) and int(pixels) == pixels and 1 <= pixels <= MAX_SIDE):
                raise FilmError(f"{pixels} pixels {side}: it must be a whole number from 1 to {MAX_SIDE}")
        object.__setattr__(self, "pixels_x", int(self.pixels_x))
        object.__setattr__(self, "pixels_y", int(self.pixels_y))
        if self.pixels_x * self.pixels_y > MAX_PIXELS:
            raise FilmError(f"{self.pixels_x} × {self.pixels_y} pixels: "
                            f"at most {MAX_PIXELS // 10**6} million are possible")

    @property
    def diagonal(self) -> float:
        """The diagonal (mm)."""
        return hypot(self.width, self.height)

    def extent(self, axis: str) -> float:
        """Size (mm) of the film along an axis: shorter, longer, horizontal, vertical or diagonal; FilmError for
        another.
        """
        w, h = self.width, self.height
        sizes = {"shorter": min(w, h), "longer": max(w, h), "horizontal": w, "vertical": h, "diagonal": self.diagonal}
        if axis not in sizes:
            raise FilmError(f"film along {axis!r}: choose one of {', '.join(AXES)}")
        return sizes[axis]

    @property
    def pitch(self) -> float:
        """Size of a pixel (mm): the geometric mean of its sides."""
        return (self.width / self.pixels_x * self.height / self.pixels_y) ** 0.5

    @property
    def step(self) -> Step:
        """The step from raster pixels to the camera frame."""
        return Step(film_from_raster, [self.width / self.pixels_x, self.width / 2.0,
                                       self.height / self.pixels_y, self.height / 2.0])


@stage
def film_from_raster(lanes, p, ints, key):
    """Raster X, Y become the point of the film in the camera frame: X, Y in mm, Z = 0. p: PITCH_X … EDGE_Y."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z = row[X], row[Y], row[Z]
    pitch_x, edge_x, pitch_y, edge_y = p[PITCH_X], p[EDGE_X], p[PITCH_Y], p[EDGE_Y]
    for i in range(B):
        x[i] = edge_x - x[i] * pitch_x
        y[i] = y[i] * pitch_y - edge_y
        z[i] = real(0)


STEEPEST = radians(60.0)        # of tilt and swing
FARTHEST = 1e4                  # mm: of rise and shift
NUMBERS = 12                    # of a pose in the parameters of a stage
STEEPEST_SIDE = 0.9             # of the radius of a curved film, that its corners may lie from the middle
ACROSS = 17                     # points along each side, where the extent of a curved film is found


def least_radius(width: float, height: float) -> float:
    """The smallest radius (mm) to which a film of this width and height (mm) can be curved."""
    return 0.5 * float(np.hypot(width, height)) / STEEPEST_SIDE


@dataclass(frozen=True)
class FilmPose:
    """Where a film lies behind a lens.

    Args:
        tilt: Radians about the film's horizontal middle line; positive tips the top of the film back, away from the
            lens. The image is inverted, so that the ground in front of the camera comes into focus, as with a lens that
            is tilted down.
        swing: Radians about the vertical; positive turns the film's right side, seen from behind, back. The left of the
            picture's scene is then in focus nearer.
        rise, shift: Millimetres by which the lens stands above, and to the right of, the film's centre: the picture
            shows what is higher, or further to the right.
        radius: Millimetres, of a film that is curved as a sphere: positive where the centre of curvature lies behind
            the film, negative where it lies before it, so that the sides come nearer to the lens, as the Petzval
            surface of most lenses does (`FirstOrder.petzval_radius`). inf for a flat film.
    Raises:
        FilmError: For angles beyond 60°, lengths beyond 10 m, or a radius of 0 or nan.
    """

    tilt: float = 0.0
    swing: float = 0.0
    rise: float = 0.0
    shift: float = 0.0
    radius: float = inf

    def __post_init__(self) -> None:
        for name in ("tilt", "swing"):
            angle = getattr(self, name)
            if not (isfinite(angle) and abs(angle) <= STEEPEST * (1.0 + 1e-9)):
                raise FilmError(f"{name} {significant(degrees(angle))}° of the film: it must lie from −60° to 60°")
        for name in ("rise", "shift"):
            if not abs(getattr(self, name)) <= FARTHEST:
                raise FilmError(f"{name} {significant(getattr(self, name))} mm of the film: it must lie from −10 m to "
                                "10 m")
        if not abs(self.radius) > 0.0:
            raise FilmError(f"radius {significant(self.radius)} mm of the film: it must be a length, with its sign, or "
                            "infinite for a flat film")
        if abs(self.radius) == inf:
            object.__setattr__(self, "radius", inf)

    @property
    def is_upright(self) -> bool:
        """Whether the film is flat, centred, and perpendicular to its axis."""
        return self == UPRIGHT

    @property
    def is_tilted(self) -> bool:
        """Whether the middle of the film is not perpendicular to the axis of the lens."""
        return self.tilt != 0.0 or self.swing != 0.0

    @property
    def is_curved(self) -> bool:
        """Whether the film is curved."""
        return self.radius != inf

    @property
    def curvature(self) -> float:
        """1 / radius (1/mm), 0 for a flat film."""
        return 1.0 / self.radius

    @cached_property
    def axes(self) -> np.ndarray:
        """Unit vectors (3, 3), a row each: along the film's x and y, and its normal away from the lens."""
        return rotation_matrix(self.tilt, -self.swing).T

    @cached_property
    def centre(self) -> np.ndarray:
        """The film's centre (3,), camera frame (mm)."""
        return np.array([-self.shift, -self.rise, 0.0])

    def points(self, film_xy: np.ndarray) -> np.ndarray:
        """Points (n, 3), camera frame (mm), of film_xy (n, 2), mm from the centre in the plane of the film's middle.

        NaN beyond the sphere of a curved film.
        """
        film_xy, c = np.asarray(film_xy, float), self.curvature
        with np.errstate(invalid="ignore"):
            r2 = (film_xy * film_xy).sum(-1)
            sag = c * r2 / (1.0 + np.sqrt(1.0 - c * c * r2))
        return self.centre + film_xy @ self.axes[:2] + sag[..., None] * self.axes[2]

    def normals(self, points: np.ndarray) -> np.ndarray:
        """Unit normals (n, 3) away from the lens at points (n, 3) of the film, camera frame, mm."""
        return self.axes[2] - self.curvature * (points - self.centre)

    def film_points(self, points: np.ndarray, slopes: np.ndarray) -> np.ndarray:
        """Film points (n, 2), mm, where lines meet the film that cross z = 0 at points (n, 2), mm, with slopes (n, 2).

        slopes: how far the lines move sideways per mm of z, camera frame. NaN for a line that misses a curved film.
        """
        x, y, normal = self.axes
        start = np.column_stack([points, np.zeros(len(points))]) - self.centre
        along = np.column_stack([slopes, np.ones(len(slopes))])
        with np.errstate(divide="ignore", invalid="ignore"):
            if not self.is_curved:
                met = start - (start @ normal / (along @ normal))[:, None] * along
                return np.column_stack([met @ x, met @ y])
            # c |start + t along|² = 2 normal · (start + t along), where the line meets the side that faces the lens
            c = self.curvature
            facing = along @ normal - c * (start * along).sum(1)
            beyond = c * (start * start).sum(1) - 2.0 * (start @ normal)
            root = np.sqrt(facing**2 - c * (along * along).sum(1) * beyond)
            met = start + (beyond / (facing + root))[:, None] * along
            met[1.0 - c * (met @ normal) <= 0.0] = nan          # on the far half of the sphere
        return np.column_stack([met @ x, met @ y])

    def mirrored(self, across: bool, up: bool) -> "FilmPose":
        """The pose behind a lens mirrored across (along x), up (along y), or both; film points are mirrored too."""
        x, y = -1.0 if across else 1.0, -1.0 if up else 1.0
        return FilmPose(y * self.tilt, x * self.swing, y * self.rise, x * self.shift, self.radius)

    def corners(self, width: float, height: float) -> np.ndarray:
        """Corners (4, 3), camera frame (mm), of a film of this width and height (mm): around it from (−x, −y) over (+x,
        −y).
        """
        half = 0.5 * np.array([width, height])
        return self.points(np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * half)

    def extent(self, width: float, height: float) -> np.ndarray:
        """Points (n, 3), camera frame (mm), all over a film of this width and height (mm), its corners first.

        What bounds them bounds the film; of a flat one the corners alone. FilmError for a film too large for its
        curvature.
        """
        corners = self.corners(width, height)
        if not self.is_curved:
            return corners
        least = least_radius(width, height)
        if abs(self.radius) < least:
            raise FilmError(f"radius {significant(self.radius)} mm of the film: the corners lie "
                            f"{significant(STEEPEST_SIDE * least, 3)} mm from its middle, which needs at least "
                            f"{significant(least, 3)} mm")
        fractions = np.linspace(-0.5, 0.5, ACROSS)
        over = np.stack(np.meshgrid(fractions * width, fractions * height), -1).reshape(-1, 2)
        return np.concatenate([corners, self.points(over)])

    @property
    def numbers(self) -> np.ndarray:
        """The pose in the parameters of a stage, (NUMBERS,): the centre's x and y, the axes, and the curvature."""
        return np.concatenate([self.centre[:2], self.axes.ravel(), [self.curvature]])

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
    for i in range(B):
        x[i], y[i], z[i] = place_on_film(p, x[i], y[i])


@stage(inlined=True)
def place_on_film(p, u, v):
    """Point (x, y, z) of the camera frame for the film point (u, v), mm; p begins with `FilmPose.numbers`."""
    real = p.dtype.type
    c, r2 = p[11], u * u + v * v
    left = real(1) - c * c * r2
    sag = c * r2 / (real(1) + math.sqrt(left if left > real(0) else real(0)))
    return (p[0] + u * p[2] + v * p[5] + sag * p[8], p[1] + u * p[3] + v * p[6] + sag * p[9],
            u * p[4] + v * p[7] + sag * p[10])


@stage(inlined=True)
def film_normal(p, x, y, z):
    """Unit normal (x, y, z) of the film away from the lens at its point (x, y, z), camera frame."""
    c = p[11]
    return p[8] - c * (x - p[0]), p[9] - c * (y - p[1]), p[10] - c * z


FULL_FRAME = Film(36.0, 24.0)


class Equivalent(NamedTuple):
    """The lens that takes the same picture on another film.

    The field along the diagonal and the diameter of the aperture are the same, hence also the depth of field, the blur
    as a part of the picture, the diffraction and the light of the whole picture. For a point at infinity this is exact
    at any focus distance that is measured from the front focal point.

    Attributes:
        crop: Crop factor: the other film's diagonal over this one's.
        focal_length: mm.
        f_number: None if none was given.
        iso: Factor of the sensitivity for the same brightness at the same shutter time.
    """

    crop: float
    focal_length: float
    f_number: float | None
    iso: float


def field_of_view(focal_length: float, film: Film, axis: str = "diagonal") -> float:
    """Field of view of a lens without distortion, focused at infinity.

    Args:
        focal_length: mm; math.inf is allowed.
        film: The film.
        axis: {"shorter", "longer", "horizontal", "vertical", "diagonal"}. Along which side of the film.
    Returns:
        Radians.
    Raises:
        FilmError: For a focal length that is not positive, or another axis.
    """
    if not focal_length > 0.0:
        raise FilmError(f"focal length {significant(focal_length)}: it must be positive")
    return 2.0 * math.atan(film.extent(axis) / (2.0 * focal_length))


def focal_length(fov: float, film: Film, axis: str = "diagonal") -> float:
    """Focal length for a field of view.

    Args:
        fov: Radians, between 0 and π.
        film: The film.
        axis: {"shorter", "longer", "horizontal", "vertical", "diagonal"}. Along which side of the film.
    Returns:
        mm.
    Raises:
        FilmError: For another field of view or axis.
    """
    return film.extent(axis) / (2.0 * math.tan(_checked_fov(fov) / 2.0))


def film_extent(fov: float, focal_length: float) -> float:
    """Extent of a film for a field of view.

    Args:
        fov: Radians along this extent, between 0 and π.
        focal_length: mm.
    Returns:
        mm.
    Raises:
        FilmError: For another field of view, or a focal length that is not positive.
    """
    _check("focal length", focal_length)
    return 2.0 * focal_length * math.tan(_checked_fov(fov) / 2.0)


def equivalent(focal_length: float, film: Film, f_number: float | None = None, to: Film = FULL_FRAME) -> Equivalent:
    """Equivalent focal length and f-number on another film.

    Args:
        focal_length: mm, on `film`.
        film: The film.
        f_number: On `film`.
        to: The other film; by default 36 × 24 mm.
    Raises:
        FilmError: For a focal length or f-number that is not positive.
    """
    _check("focal length", focal_length)
    if f_number is not None:
        _check("f-number", f_number)
    crop = to.diagonal / film.diagonal
    return Equivalent(crop, focal_length * crop, None if f_number is None else f_number * crop, crop * crop)


def _check(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise FilmError(f"{name} {significant(value)}: it must be a positive finite number")


def _checked_fov(fov: float) -> float:
    if not 0.0 < fov < math.pi:
        raise FilmError(f"field of view {significant(math.degrees(fov))}°: it must lie between 0° and 180°")
    return fov
