"""Film landing of a camera whose rays come from a function, by the way back that its user gives.

The function F takes raster and pupil samples to rays, the function `back` takes rays to raster and pupil samples. The
radiance of a ray adds F's weight times |∂(raster, uv) / ∂(ray)| times the étendue of the ray to a pixel. The étendue of
a ray near another is d²p · d²s: its place p on the plane across that ray, and its direction s. Central differences of F
give the 4 × 4 derivatives, so that the flux is that of the camera's own rays, whatever the function is. Camera frame,
mm.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lensbench.cameras.film_landing import FilmLanding, Triple
from lensbench.cameras.rays import CameraError
from lensbench.imaging.film import Film
from lensbench.kernels.block import CLEARANCE, WEIGHT, L, N, X, Y, Z
from lensbench.kernels.figures import significant
from lensbench.kernels.python_stage import PythonStage

Rays = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
Back = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

STEP = 1e-5             # of the differences, in widths of the film and of the square of pupil samples
GRID = 13               # raster points and pupil samples along each side that find the opening
POINT = 1e-6            # mm: an opening of a smaller radius is one point
MARGIN = 1.02           # of the opening's radius over that of the origins on the grid
BESIDE = 0.25           # of the film's size: how far beside the film light may land, whose image may reach into it
PROBES = 400            # samples on which the way back is tested
RETURN = 1e-4           # of the film's width, or of the square: by how much `back` may miss a probe
ASTRAY = 1e-4           # radians by which a ray of the function may miss the given one,
ASIDE = 1e-3            # in radii of the opening,
ROUNDING = 1e-5         # and in mm, for a millimetre from the camera's origin
SINGULAR = 1e-9         # least 4 × 4 determinant, in radii of the opening, of rays that cross a pupil


class _Measured(NamedTuple):
    """n rays of the function, as it returns them, and what they measure."""

    origins: np.ndarray         # (n, 3) mm
    directions: np.ndarray      # (n, 3) unit
    weight: np.ndarray          # (n,)
    etendue: np.ndarray         # (n,) over d²raster d²uv: mm² sr per pixel; of rays from one point: sr per pixel


class CustomLanding:
    """Way back from rays to the film of a function's camera.

    Parameters: the film; the checked function of raster (n, 2) and uv (n, 2) that returns origins, unit directions and
    weights; the user's function of origins (n, 3) and unit directions (n, 3), towards the scene, that returns raster
    and uv. Raises CameraError where `back` does not invert the function, or where light cannot follow its rays back.
    """

    def __init__(self, film: Film, rays: Rays, back: Back):
        self._rays, self._back = rays, back
        self._size = np.array([film.pixels_x, film.pixels_y], float)
        self._find_opening()
        self._test()
        self._landing, self._bounding = PythonStage(self._land), PythonStage(self._bound)

    @property
    def film_landing(self) -> FilmLanding:
        """The stages; see `FilmLanding`."""
        return FilmLanding([self._landing.step], [self._bounding.step], self._centre, self._radius)

    def _find_opening(self) -> None:
        """The sphere about all origins on a grid of raster and pupil, edges included."""
        side = np.linspace(0.0, 1.0, GRID)
        grid = np.stack(np.meshgrid(side, side, side, side), -1).reshape(-1, 4)
        origins, _, weights = self._rays(grid[:, :2] * self._size, grid[:, 2:])
        origins = origins[weights > 0.0]
        if not origins.size:
            raise CameraError("the camera's function blocks every ray: no light finds a way back")
        centre = 0.5 * (origins.min(0) + origins.max(0))
        radius = float(np.sqrt(((origins - centre) ** 2).sum(1)).max())
        self._centre: Triple = (float(centre[0]), float(centre[1]), float(centre[2]))
        self._radius = MARGIN * radius if radius > POINT else 0.0

    def _test(self) -> None:
        """Refuse a `back` that does not invert the function on PROBES samples, and rays without an étendue."""
        random = np.random.default_rng(0)
        shares, uv = random.random((PROBES, 2)), random.random((PROBES, 2))
        raster = shares * self._size
        origins, directions, weights = self._rays(raster, uv)
        lit = weights > 0.0
        raster, uv, origins, directions = raster[lit], uv[lit], origins[lit], directions[lit]
        etendue = self._measured(raster, uv).etendue
        if not (etendue > (SINGULAR * self._radius**2 if self._radius > 0.0 else 0.0)).all():
            raise CameraError(
                "the rays of the camera's function have no étendue, so that no light finds a way back by chance: they "
                "must start at one point, the same for all, or from all points of a pupil to all directions. "
                "Leave back out")
        # Any point on a ray will do: also one that is not the function's
        for along in (0.0, 700.0):
            there, through = self._returned(origins + along * directions, directions)
            missed = np.abs((there - raster) / self._size).max(1)
            if self._radius > 0.0:
                missed = np.maximum(missed, np.abs(through - uv).max(1))
            if (missed > RETURN).any():
                k = int(np.argmax(missed))
                raise CameraError(f"back does not invert the camera's function: it takes the ray of the raster point "
                                  f"{_text(raster[k])} and the pupil sample {_text(uv[k])} to {_text(there[k])} "
                                  f"and {_text(through[k])}")

    def _returned(self, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Raster and uv (n, 2) that `back` gives for rays; CameraError where they are none. inf is allowed."""
        found = self._back(origins, directions)
        n = len(origins)
        if not isinstance(found, tuple | list) or len(found) != 2:
            raise CameraError("back must return raster points and pupil samples: (n, 2) arrays")
        arrays = []
        for name, value in zip(("raster", "uv"), found, strict=True):
            try:
                arrays.append(np.broadcast_to(np.asarray(value, float), (n, 2)))
            except (TypeError, ValueError):
                raise CameraError(f"back returned {name} of the shape {np.shape(value)} for {n} rays: "
                                  f"it must have the shape {(n, 2)}") from None
            wrong = np.isnan(arrays[-1]).any(1)
            if wrong.any():
                k = int(np.argmax(wrong))
                raise CameraError(f"back returned {name} that is not a number, for the ray from {_text(origins[k])} mm "
                                  f"along {_text(directions[k])}: return inf for a ray that misses the camera")
        return arrays[0], arrays[1]

    def _measured(self, raster: np.ndarray, uv: np.ndarray) -> "_Measured":
        """Rays of the function with their weights and their étendue."""
        n = len(raster)
        # Differences stay on the film and in the square, outside which the function may have no values
        start = np.clip(np.hstack([raster / self._size, uv]), STEP, 1.0 - STEP)
        moves = STEP * np.concatenate([np.eye(4), -np.eye(4)])
        at = (start + moves[:, None]).reshape(-1, 4)
        at = np.concatenate([at, np.hstack([np.clip(raster / self._size, 0.0, 1.0), np.clip(uv, 0.0, 1.0)])])
        origins, directions, weights = self._rays(at[:, :2] * self._size, at[:, 2:])
        lit = (weights.reshape(9, n) > 0.0).all(0)
        origins, directions = origins.reshape(9, n, 3), directions.reshape(9, n, 3)
        # Two axes across each ray
        axis, start_point = directions[8], origins[8]
        aside = np.where(np.abs(axis[:, :1]) < 0.6, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        across = np.cross(axis, aside)
        across /= np.linalg.norm(across, axis=1)[:, None]
        axes = np.stack([across, np.cross(axis, across)], 2)                       # (n, 3, 2)
        # Cross the plane across the ray
        to_plane = (((start_point - origins) * axis).sum(-1) / (directions * axis).sum(-1))[..., None]
        places = np.einsum("kni,nij->nkj", origins + to_plane * directions - start_point, axes)
        slopes = np.einsum("kni,nij->nkj", directions, axes)
        found = np.concatenate([places, slopes], 2)
        slope = (found[:, :4] - found[:, 4:8]) / (2.0 * STEP)
        etendue = np.abs(np.linalg.det(slope) if self._radius > 0.0 else np.linalg.det(slope[:, :2, 2:]))
        weight = np.where(lit, weights[8 * n:], 0.0)
        return _Measured(start_point, axis, weight, etendue / self._size.prod())

    def _bound(self, rows: np.ndarray) -> None:
        """Raster X, Y and CLEARANCE of rays towards the film; WEIGHT: 0 for those that miss pupil or film."""
        self._arrive(rows)

    def _land(self, rows: np.ndarray) -> None:
        """Raster X, Y and WEIGHT of rays towards the film."""
        origins, directions = rows[X:Z + 1].T.astype(float), -rows[L:N + 1].T.astype(float)
        raster, uv = self._arrive(rows)
        lit = np.flatnonzero(rows[WEIGHT] > 0.0)
        if not lit.size:
            return
        raster, uv, origins, directions = raster[lit], uv[lit], origins[lit], directions[lit]
        measured = self._measured(raster, uv)
        self._refuse_other_rays(raster, uv, origins, directions, measured)
        etendue = measured.etendue
        if self._radius == 0.0:
            etendue = etendue * np.maximum(-directions[:, 2], 0.0)      # the given étendue has the cosine of the axis
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            share = measured.weight / etendue
        rows[WEIGHT, lit] *= np.where(np.isfinite(share), share, 0.0)

    def _arrive(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Set X, Y, CLEARANCE and a WEIGHT of 0 for rays that miss; returns raster and uv (n, 2)."""
        origins, directions = rows[X:Z + 1].T.astype(float), -rows[L:N + 1].T.astype(float)
        lit = rows[WEIGHT] > 0.0
        # Lanes without light may hold no ray
        origins, directions = np.where(lit[:, None], origins, self._centre), np.where(lit[:, None], directions,
                                                                                    [0.0, 0.0, -1.0])
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        raster, uv = self._returned(origins, directions)
        clearance = np.zeros(len(uv)) if self._radius == 0.0 else np.abs(2.0 * uv - 1.0).max(1)
        beside = np.abs(raster / self._size - 0.5).max(1) > 0.5 + BESIDE
        rows[X:Y + 1], rows[Z], rows[CLEARANCE] = raster.T, 0.0, clearance
        rows[WEIGHT] = np.where(lit & (clearance <= 1.0) & ~beside, rows[WEIGHT], 0.0)
        return raster, uv

    def _refuse_other_rays(self, raster: np.ndarray, uv: np.ndarray, origins: np.ndarray, directions: np.ndarray,
                           measured: "_Measured") -> None:
        """CameraError where the function does not return the given rays for raster and uv that `back` found."""
        turned = np.abs(measured.directions - directions).max(1)
        aside = measured.origins - origins
        aside = np.abs(aside - (aside * directions).sum(1)[:, None] * directions).max(1)
        inside = (np.abs(raster / self._size - 0.5) <= 0.5).all(1)
        reach = ASIDE * self._radius + ROUNDING * (1.0 + np.abs(origins).max(1))
        astray = inside & (measured.weight > 0.0) & ((turned > ASTRAY) | (aside > reach))
        if astray.any():
            k = int(np.argmax(astray))
            raise CameraError(f"back does not invert the camera's function: it takes the ray from {_text(origins[k])} "
                              f"mm along {_text(directions[k])} to the raster point {_text(raster[k])} and the pupil "
                              f"sample {_text(uv[k])}, for which the function returns another ray")


def _text(values: np.ndarray) -> str:
    return "(" + ", ".join(significant(float(value)) for value in values) + ")"
