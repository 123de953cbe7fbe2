"""Bare sensor: a film without a lens, every point of which receives light from its whole hemisphere."""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmImportance
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, rows, stage
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.optics.glass import D_LINE


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

    def film_slopes(self, film_xy, directions):
        """Derivatives in closed form: at a fixed pupil sample the rays of all film points are parallel."""
        slopes = np.zeros((2, len(directions), 6))
        slopes[0, :, 0] = slopes[1, :, 1] = 1.0
        return slopes

    def film_from_point(self, points, pupil_uv, wavelength: float = D_LINE):
        """Film points where the rays with the sampled directions through the points begin; every point is visible."""
        inputs = {U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}
        l, m, n = Program(self.camera_steps(wavelength), np.float64).run(inputs, [L, M, N], len(points))
        before = points[:, 2] < 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            film = points[:, :2] - points[:, 2:] * np.stack([l, m], 1) / n[:, None]
        return np.where(before[:, None], film, math.nan), before & np.isfinite(film).all(1)

    def film_importance(self, origins, directions, wavelength: float = D_LINE) -> FilmImportance:
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
