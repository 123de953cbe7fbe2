"""Cameras without a lens: panoramas in three layouts, which see in every direction from one point, and a bare sensor.

Camera frame. Each layout has a stage from the film to the direction, its inverse and its derivatives. In a panorama x
runs to the right and y down; u and v below are the same from the film's centre, 1 at the film's sides.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmImportance, point_importance
from lensbench.core.cameras.ideal_lens import unit_direction_change
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.optics.glass import D_LINE

LAYOUTS = ("equirectangular", "equal-area", "cube-map")
ACROSS, DOWN = range(2)         # parameters of every layout: 2 / width and 2 / height of the film (1/mm)


@dataclass(frozen=True, eq=False)
class EnvironmentCamera(Camera):
    """Full sphere as seen from the camera's origin; each pixel shows the radiance of its directions with weight 1.

    Args:
        film: Size (mm) and pixels.
        layout: "equirectangular": θ = π y / h from straight up and φ = 2π x / w − π to the right, with the direction
            (sin θ sin φ, cos θ, −sin θ cos φ) and −z in the centre. "equal-area": an octahedron, on which each pixel
            has the same solid angle, with −z in the centre and +z in the corners. "cube-map": six faces in a cross of 4
            × 3 cells, left, front, right and back in the middle row, up and down above and below front; the rest stays
            dark. Square pixels need a film of 2:1, 1:1 and 4:3.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: Another layout; physical weights, for which a point has no area; a medium of another index, which a
            flat window shows only in part.

    References:
        Clarberg 2008, Fast equal-area mapping of the (hemi)sphere using SIMD, for the equal-area layout.
    """

    film: Film
    layout: str = "equirectangular"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.layout not in LAYOUTS:
            raise CameraError(f"layout {self.layout!r}: choose one of {', '.join(LAYOUTS)}")
        if self.weights == "physical":
            raise CameraError("a panorama is seen from a point, which has no area for light to pass: "
                              "choose relative weights")
        if self.has_port:
            raise CameraError("a panorama sees on all sides, and a flat window into a medium only before it: "
                              "choose a medium of index 1")

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Step of the layout; see `Camera.camera_steps`."""
        p = np.empty(2)
        p[ACROSS], p[DOWN] = 2.0 / self.film.width, 2.0 / self.film.height
        return [Step(_STAGES[self.layout], p)]

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray | None, wavelength: float = D_LINE
                       ) -> tuple[np.ndarray, np.ndarray]:
        """Projection of points in closed form, all visible but the origin; see `Camera.film_from_point`."""
        u, v = _BACK[self.layout](points)
        film = np.stack([-u * self.film.width / 2.0, v * self.film.height / 2.0], 1)
        return film, np.asarray(np.isfinite(film).all(1))

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Derivatives in closed form within a face or octant; see `Camera.film_slopes`."""
        size = np.array([2.0 / self.film.width, 2.0 / self.film.height])
        u, v = (film_xy * size * [-1.0, 1.0]).T
        slopes = np.zeros((2, len(directions), 6))
        slopes[..., 3:] = _SLOPES[self.layout](u, v, directions)
        slopes *= (size * [-1.0, 1.0])[:, None, None]
        return slopes

    def film_importance(self, origins: np.ndarray, directions: np.ndarray, wavelength: float = D_LINE
                       ) -> FilmImportance:
        """Importance from the film area per solid angle; see `Camera.film_importance`."""
        x, y, z = directions.T
        with np.errstate(divide="ignore"):
            density = {"equirectangular": lambda: 0.5 / (math.pi**2 * np.hypot(x, z)),
                       "equal-area": lambda: np.full(len(x), 0.25 / math.pi),
                       "cube-map": lambda: np.abs(directions).max(1) ** -3 / 48.0}[self.layout]()
        film, visible = self.film_from_point(directions, None)
        return point_importance(film, density, visible, origins, directions)


@stage
def equirectangular(lanes, p, ints, key):
    """Turn the film point X, Y into the direction at longitude φ and polar angle θ. p: ACROSS, DOWN."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, down = real(-0.5) * p[ACROSS], real(0.25) * p[DOWN]
    for i in range(B):
        sine, versine = sine_versine(real, x[i] * across)
        below, less = sine_versine(real, y[i] * down)           # θ − 90°
        ring = real(1) - less
        l[i], m[i], n[i] = ring * sine, -below, ring * (versine - real(1))
        x[i], y[i], z[i], weight[i] = real(0), real(0), real(0), real(1)


@stage
def equal_area(lanes, p, ints, key):
    """Turn the film point X, Y into the direction on Clarberg's equal-area octahedron. p: ACROSS, DOWN.

    r in [0, 1] is the distance from the nearer pole: 1 − |cos θ| = r².
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, down = -p[ACROSS], -p[DOWN]
    for i in range(B):
        # Distance r from the centre of the octahedron's half, and angle in its octant
        u, v = x[i] * across, y[i] * down
        au, av = abs(u), abs(v)
        front = real(1) - (au + av)
        r = real(1) - abs(front)
        turn = (av - au) / (r if r > real(0) else real(1))
        sine, versine = sine_versine(real, real(0.125) * turn + real(0.125))
        # Direction: |cos θ| = 1 − r²
        ring = r * math.sqrt(real(2) - r * r)
        cosine = ring - ring * versine
        sine = ring * sine
        l[i] = cosine if u >= real(0) else -cosine
        m[i] = sine if v >= real(0) else -sine
        n[i] = r * r - real(1) if front >= real(0) else real(1) - r * r
        x[i], y[i], z[i], weight[i] = real(0), real(0), real(0), real(1)


@stage
def cube_map(lanes, p, ints, key):
    """Turn the film point X, Y into the direction through a face of the cube, dark beside them. p: ACROSS, DOWN."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, down = real(-2) * p[ACROSS], real(1.5) * p[DOWN]
    for i in range(B):
        # Cell of the cross, and the place (a, b) in it from −1 to 1
        u, v = x[i] * across + real(2), y[i] * down + real(1.5)
        column, line = np.floor(u), np.floor(v)
        column = column if column > real(0) else real(0)
        column = column if column < real(3) else real(3)
        line = line if line > real(0) else real(0)
        line = line if line < real(2) else real(2)
        a, b = real(2) * (u - column) - real(1), real(2) * (v - line) - real(1)
        # Direction through the face, k quarter turns to the right of the front, or above or below it
        k = column - real(1)
        cosine, sine = real(1) - abs(k), k if k < real(1.5) else real(0)
        rise = real(1) - line                               # 1 the face above, −1 the one below
        level = rise == real(0)
        dx = sine + a * cosine if level else a
        dy = -b if level else rise
        dz = a * sine - cosine if level else -b * rise
        size = real(1) / math.sqrt(real(1) + a * a + b * b)
        l[i], m[i], n[i] = dx * size, dy * size, dz * size
        weight[i] = real(1) if level | (k == real(0)) else real(0)
        x[i], y[i], z[i] = real(0), real(0), real(0)


def _equirectangular_back(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse of `equirectangular`: u and v of points (n, 3)."""
    x, y, z = points.T
    u = np.arctan2(x, -z) / math.pi
    v = np.arctan2(-y, np.hypot(x, z)) / (math.pi / 2.0)
    return np.where(points.any(1), u, math.nan), v


def _equal_area_back(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse of `equal_area`: u and v of points (n, 3)."""
    with np.errstate(invalid="ignore"):
        x, y, z = (points / np.linalg.norm(points, axis=1)[:, None]).T
    r = np.sqrt((x * x + y * y) / (1.0 + np.abs(z)))
    along = np.arctan2(np.abs(y), np.abs(x)) / (math.pi / 2.0) * r
    across = r - along
    u, v = np.where(z <= 0.0, across, 1.0 - along), np.where(z <= 0.0, along, 1.0 - across)
    return np.copysign(u, x), np.copysign(v, -y)


def _cube_map_back(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse of `cube_map`: u and v of points (n, 3); the greatest coordinate says which face."""
    x, y, z = points.T
    size = np.abs(points).max(1)
    level = np.maximum(np.abs(x), np.abs(z)) >= np.abs(y)
    ahead = np.abs(z) >= np.abs(x)
    k = np.where(level, np.where(ahead, np.where(z <= 0.0, 0.0, 2.0), np.sign(x)), 0.0)
    a = np.where(level, np.where(ahead, np.where(z <= 0.0, x, -x), np.sign(x) * z), x)
    rise = np.where(level, 0.0, np.sign(y))
    b = np.where(level, -y, -rise * z)
    with np.errstate(divide="ignore", invalid="ignore"):
        return (k + 0.5 * (1.0 + a / size) - 1.0) / 2.0, (0.5 * (1.0 + b / size) - rise - 0.5) / 1.5


def _equirectangular_slopes(u: np.ndarray, v: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Derivatives (2, n, 3) of the directions d (n, 3) by u and by v."""
    phi, theta = math.pi * u, 0.5 * math.pi * (1.0 + v)
    to_right = math.pi * np.stack([-d[:, 2], np.zeros(len(d)), d[:, 0]], 1)
    down = np.stack([np.cos(theta) * np.sin(phi), -np.sin(theta), -np.cos(theta) * np.cos(phi)], 1)
    return np.stack([to_right, 0.5 * math.pi * down])


def _equal_area_slopes(u: np.ndarray, v: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Derivatives (2, n, 3) of the directions by u and by v."""
    au, av = np.abs(u), np.abs(v)
    front = 1.0 - au - av
    r, side = 1.0 - np.abs(front), np.where(front >= 0.0, 1.0, -1.0)
    turn = (av - au) / np.where(r > 0.0, r, 1.0)
    angle, root = 0.25 * math.pi * (1.0 + turn), np.sqrt(2.0 - r * r)
    out = np.stack([np.copysign(np.cos(angle), u), np.copysign(np.sin(angle), -v)], 1)
    ring = np.stack([-np.copysign(np.sin(angle), u), np.copysign(np.cos(angle), -v)], 1)
    slopes = []
    for own, sign in ((-1.0, np.copysign(1.0, u)), (1.0, np.copysign(1.0, v))):
        # Derivatives of r, and of r times the angle, by |u| or |v|
        dr, dangle = side, 0.25 * math.pi * (own - turn * side)
        level = (dr * (2.0 - 2.0 * r * r) / root)[:, None] * out + (dangle * root)[:, None] * ring
        slopes.append(np.concatenate([level, (2.0 * r * dr * side)[:, None]], 1) * sign[:, None])
    return np.stack(slopes)


def _cube_map_slopes(u: np.ndarray, v: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Derivatives (2, n, 3) of the directions d (n, 3) by u and by v."""
    column = np.clip(np.floor(2.0 * u + 2.0), 0.0, 3.0)
    rise = 1.0 - np.clip(np.floor(1.5 * v + 1.5), 0.0, 2.0)
    k = column - 1.0
    cosine, sine = 1.0 - np.abs(k), np.where(k < 1.5, k, 0.0)
    level, zero = rise == 0.0, np.zeros(len(u))
    to_right = np.stack([np.where(level, cosine, 1.0), zero, np.where(level, sine, 0.0)], 1)
    down = np.stack([zero, np.where(level, -1.0, 0.0), -rise], 1)
    size = np.abs(d).max(1)
    return np.stack([4.0 * unit_direction_change(to_right, d, size), 3.0 * unit_direction_change(down, d, size)])


_STAGES = {"equirectangular": equirectangular, "equal-area": equal_area, "cube-map": cube_map}
_SLOPES = {"equirectangular": _equirectangular_slopes, "equal-area": _equal_area_slopes, "cube-map": _cube_map_slopes}
_BACK = {"equirectangular": _equirectangular_back, "equal-area": _equal_area_back, "cube-map": _cube_map_back}


@dataclass(frozen=True, eq=False)
class BareSensor(Camera):
    """Film without a lens at the camera's origin, facing −z; each point records the irradiance of its hemisphere.

    Relative weights give E / π, the cosine-weighted mean radiance, which is 1 under a uniform sky of 1. Physical
    weights give E times the open time. The picture is turned upright as behind a lens, so light from the right
    brightens its left side.

    Args:
        film: Size (mm) and pixels.
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: Invalid settings of `Camera`.
    """

    film: Film

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Step to a direction of the hemisphere, drawn in proportion to its cosine; see `Camera.camera_steps`."""
        return [Step(hemisphere, [self.gain])]

    @property
    def _not_projective(self) -> str:
        return "a sensor without a lens forms no picture"

    @property
    def gain(self) -> float:
        """Weight of every ray."""
        return math.pi / self._normaliser(math.pi, 1.0)

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Derivatives in closed form: at a fixed pupil sample the rays of all film points are parallel."""
        slopes = np.zeros((2, len(directions), 6))
        slopes[0, :, 0] = slopes[1, :, 1] = 1.0
        return slopes

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray, wavelength: float = D_LINE
                       ) -> tuple[np.ndarray, np.ndarray]:
        """Film points where the rays with the sampled directions through the points begin; every point is visible."""
        inputs = {U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}
        l, m, n = Program(self.camera_steps(wavelength), np.float64).run(inputs, [L, M, N], len(points))
        before = points[:, 2] < 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            film = points[:, :2] - points[:, 2:] * np.stack([l, m], 1) / n[:, None]
        return np.where(before[:, None], film, math.nan), before & np.isfinite(film).all(1)

    def film_importance(self, origins: np.ndarray, directions: np.ndarray, wavelength: float = D_LINE
                       ) -> FilmImportance:
        """Importance, which is the same for all rays from the film."""
        cosine = -directions[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            film = origins[:, :2] + (origins[:, 2] / cosine)[:, None] * directions[:, :2]
        position_pdf = np.full(len(film), 1.0 / (self.film.width * self.film.height))
        return FilmImportance(film, self.gain / math.pi * position_pdf, position_pdf, cosine / math.pi, cosine > 0.0)


@stage
def hemisphere(lanes, p, ints, key):
    """Choose a direction about −z with U0, U1: a point of the unit disk, projected onto the hemisphere. p: WEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    l, m, n, weight, u, v = row[L], row[M], row[N], row[WEIGHT], row[U0], row[U1]
    gain = p[0]
    for i in range(B):
        a, b = concentric_disk(real, v[i], u[i])
        left = real(1) - a * a - b * b
        l[i], m[i], n[i] = a, b, -math.sqrt(left if left > real(0) else real(0))
        weight[i] = gain
