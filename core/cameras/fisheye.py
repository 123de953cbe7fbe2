"""Ideal fisheyes: four projections from the angle θ off the axis to the image height r on the film.

"equidistant" r = f θ, "equisolid" r = 2 f sin(θ/2), "stereographic" r = 2 f tan(θ/2), "orthographic" r = f sin θ.
Camera frame, mm.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmImportance, point_importance
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.film import AXES, Film
from lensbench.core.kernels.block import WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant

PROJECTIONS = ("equidistant", "equisolid", "stereographic", "orthographic")
INVERSE_F, IMAGE_RADIUS = range(2)      # parameters of every projection: 1 / f (1/mm), and of the image circle (mm)


@dataclass(frozen=True, eq=False)
class FisheyeCamera(Camera):
    """Fisheye without aberrations at the camera's origin, looking along −z; weight 1 within its image circle.

    Args:
        film: Size (mm) and pixels.
        fov: Full field of view (radians) along fov_axis: below 2π, at most π for the orthographic projection. The film
            is dark where it shows angles of more than fov / 2 from the axis.
        projection: "equidistant" r = f θ, "equisolid" r = 2 f sin(θ/2), "stereographic" r = 2 f tan(θ/2) or
            "orthographic" r = f sin θ.
        fov_axis: Length of the film that fov spans: "shorter" (a circular picture with dark corners), "longer",
            "horizontal", "vertical" or "diagonal" (a full-frame picture).
        **placement: Keyword arguments of `Camera`: transform, shutter, weights and medium.
    Raises:
        CameraError: A field of view beyond the projection's; physical weights, for which a point has no area.
    """

    film: Film
    fov: float = math.pi
    projection: str = "equidistant"
    fov_axis: str = "shorter"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.projection not in PROJECTIONS:
            raise CameraError(f"projection {self.projection!r}: choose one of {', '.join(PROJECTIONS)}")
        if self.fov_axis not in AXES:
            raise CameraError(f"field of view along {self.fov_axis!r}: choose one of {', '.join(AXES)}")
        if self.projection == "orthographic" and not 0.0 < self.fov <= math.pi:
            raise CameraError(f"field of view {significant(math.degrees(self.fov))}°: of an orthographic fisheye "
                              f"it must lie between 0° and 180°, which it reaches")
        if not 0.0 < self.fov < 2.0 * math.pi:
            raise CameraError(f"field of view {significant(math.degrees(self.fov))}°: of a fisheye it must lie between "
                              "0° and 360°")
        if self.weights == "physical":
            raise CameraError("an ideal fisheye sees from a point, which has no area for light to pass: "
                              "choose relative weights")

    @property
    def image_radius(self) -> float:
        """Radius (mm) of the image circle."""
        return self.film.extent(self.fov_axis) / 2.0

    @property
    def focal_length(self) -> float:
        """Focal length f (mm): the scale of the picture at its centre."""
        return self.image_radius / float(image_height(self.projection, self.fov / 2.0))

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Step of the projection; see `Camera.camera_steps`."""
        p = np.empty(2)
        p[INVERSE_F], p[IMAGE_RADIUS] = 1.0 / self.focal_length, self.image_radius
        return [Step(_STAGES[self.projection], p)]

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray | None, wavelength: float = D_LINE
                       ) -> tuple[np.ndarray, np.ndarray]:
        """Projection of points in closed form; see `Camera.film_from_point`."""
        across = np.hypot(points[:, 0], points[:, 1])
        theta = np.arctan2(across, -points[:, 2])
        visible = points.any(1) & (theta <= self.fov / 2.0 * (1.0 + 1e-12))
        with np.errstate(divide="ignore", invalid="ignore"):
            r = self.focal_length * image_height(self.projection, theta)
            film = -points[:, :2] * np.where(across > 0.0, r / across, 0.0)[:, None]
        return np.where(visible[:, None], film, math.nan), visible

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Derivatives in closed form: dθ/dr along the radius and sin θ / r across it; see `Camera.film_slopes`."""
        sine, cosine = np.hypot(directions[:, 0], directions[:, 1]), -directions[:, 2]
        theta = np.arctan2(sine, cosine)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = {"equidistant": lambda: np.ones(len(theta)),
                     "equisolid": lambda: 1.0 / np.cos(0.5 * theta),
                     "stereographic": lambda: np.cos(0.5 * theta) ** 2,
                     "orthographic": lambda: 1.0 / cosine}[self.projection]() / self.focal_length
            r = np.hypot(film_xy[:, 0], film_xy[:, 1])
            out = np.where((r > 0.0)[:, None], film_xy / r[:, None], [1.0, 0.0])
            across = np.where(r > 0.0, sine / r, 1.0 / self.focal_length)
        slopes = np.zeros((2, len(theta), 6))
        for axis in range(2):
            meridian = np.stack([-out[:, 0] * cosine, -out[:, 1] * cosine, sine], 1)
            ring = np.stack([out[:, 1], -out[:, 0], np.zeros(len(out))], 1)
            turn = -out[:, 1] if axis == 0 else out[:, 0]
            with np.errstate(invalid="ignore"):         # at the rim of an orthographic one, dθ/dr is infinite
                slopes[axis, :, 3:] = (out[:, axis] * along)[:, None] * meridian + (turn * across)[:, None] * ring
        return slopes

    def film_importance(self, origins: np.ndarray, directions: np.ndarray, wavelength: float = D_LINE
                       ) -> FilmImportance:
        """Importance from the film area per solid angle, r dr / (sin θ dθ); see `Camera.film_importance`."""
        sine = np.hypot(directions[:, 0], directions[:, 1])
        theta = np.arctan2(sine, -directions[:, 2])
        with np.errstate(invalid="ignore"):
            area = {"equidistant": lambda: np.where(sine > 0.0, theta / sine, 1.0),
                    "equisolid": lambda: np.ones(len(theta)),
                    "stereographic": lambda: np.cos(0.5 * theta) ** -4.0,
                    "orthographic": lambda: np.cos(theta)}[self.projection]()
        density = self.focal_length**2 * area / (self.film.width * self.film.height)
        film, visible = self.film_from_point(directions, None)
        return point_importance(film, density, visible, origins, directions)


def image_height(projection: str, theta: ArrayLike) -> np.ndarray:
    """Image height r / f of the angle θ (radians, a number or an array)."""
    if projection == "equidistant":
        return np.asarray(theta) * 1.0
    if projection == "equisolid":
        return 2.0 * np.sin(0.5 * np.asarray(theta))
    if projection == "stereographic":
        return 2.0 * np.tan(0.5 * np.asarray(theta))
    return np.sin(theta)


@stage
def equidistant(lanes, p, ints, key):
    """Turn the film point X, Y into the direction at θ = r / f. p: INVERSE_F, IMAGE_RADIUS."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    per, edge = p[INVERSE_F], p[IMAGE_RADIUS]
    turns = per * real(0.5 / math.pi)
    for i in range(B):
        r = math.sqrt(x[i] * x[i] + y[i] * y[i])
        sine, versine = sine_versine(real, r * turns)
        spread = sine / r if r > real(0) else per
        l[i], m[i], n[i] = -x[i] * spread, -y[i] * spread, versine - real(1)
        weight[i] = real(1) if r <= edge else real(0)
        x[i], y[i], z[i] = real(0), real(0), real(0)


@stage
def equisolid(lanes, p, ints, key):
    """Turn the film point X, Y into the direction at sin(θ/2) = r / 2f. p: INVERSE_F, IMAGE_RADIUS."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    per, edge2 = p[INVERSE_F], p[IMAGE_RADIUS] * p[IMAGE_RADIUS]
    for i in range(B):
        r2 = x[i] * x[i] + y[i] * y[i]
        h2 = real(0.25) * r2 * per * per                    # sin²(θ/2)
        left = real(1) - h2
        spread = per * math.sqrt(left if left > real(0) else real(0))
        l[i], m[i], n[i] = -x[i] * spread, -y[i] * spread, real(2) * h2 - real(1)
        weight[i] = real(1) if r2 <= edge2 else real(0)
        x[i], y[i], z[i] = real(0), real(0), real(0)


@stage
def stereographic(lanes, p, ints, key):
    """Turn the film point X, Y into the direction at tan(θ/2) = r / 2f. p: INVERSE_F, IMAGE_RADIUS."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    per, edge2 = p[INVERSE_F], p[IMAGE_RADIUS] * p[IMAGE_RADIUS]
    for i in range(B):
        r2 = x[i] * x[i] + y[i] * y[i]
        t2 = real(0.25) * r2 * per * per                    # tan²(θ/2)
        share = real(1) / (real(1) + t2)
        spread = per * share
        l[i], m[i], n[i] = -x[i] * spread, -y[i] * spread, (t2 - real(1)) * share
        weight[i] = real(1) if r2 <= edge2 else real(0)
        x[i], y[i], z[i] = real(0), real(0), real(0)


@stage
def orthographic(lanes, p, ints, key):
    """Turn the film point X, Y into the direction at sin θ = r / f. p: INVERSE_F, IMAGE_RADIUS."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    per, edge2 = p[INVERSE_F], p[IMAGE_RADIUS] * p[IMAGE_RADIUS]
    for i in range(B):
        r2 = x[i] * x[i] + y[i] * y[i]
        left = real(1) - r2 * per * per
        l[i], m[i], n[i] = -x[i] * per, -y[i] * per, -math.sqrt(left if left > real(0) else real(0))
        weight[i] = real(1) if r2 <= edge2 else real(0)
        x[i], y[i], z[i] = real(0), real(0), real(0)


_STAGES = {"equidistant": equidistant, "equisolid": equisolid, "stereographic": stereographic,
           "orthographic": orthographic}
