"""A camera whose rays come from a Python function of numpy arrays, and the film landing by its inverse `back`.

The function is one of the camera's stages (`kernels.program`), so pictures, AOVs, ray differentials and light fields
use it as they use a compiled camera; it runs for one block of samples at a time on one core (docs/own-cameras.md).

Landing: the radiance of a ray adds the function's weight times |∂(raster, uv) / ∂(ray)| times the étendue of the ray to
a pixel. The étendue of a ray near another is d²p · d²s: its point p on the plane across that ray, and its direction s.
Central differences of the function give the 4 × 4 derivatives. Camera frame, mm.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from inspect import signature
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.film_landing import FilmLanding, Triple
from lensbench.core.cameras.shutter import CameraError, checked_times
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import CLEARANCE, TIME, U0, U1, WEIGHT, L, N, Step, X, Y, Z
from lensbench.core.kernels.program import Program, PythonStage
from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant

Rays = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
Back = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

STEP = 1e-5             # of the differences, in widths of the film and of the square of pupil samples
GRID = 13               # raster points and pupil samples along each side that find the opening
POINT = 1e-6            # mm: an opening of a smaller radius is one point
MARGIN = 1.02           # of the opening's radius over that of the origins on the grid
BESIDE = 0.25           # of the film's size: how far beside the film light may land, whose image may reach into it
LANDING_PROBES = 400            # samples on which the way back is tested
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
    """From rays back to the film of a function's camera; CameraError where `back` does not invert the function.

    rays: the checked function of raster (n, 2) and uv (n, 2) that returns origins, unit directions and weights. back:
    the user's function of origins (n, 3) and unit directions (n, 3), towards the scene, that returns raster and uv.
    """

    def __init__(self, film: Film, rays: Rays, back: Back) -> None:
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
        """Find the sphere about all origins on a grid of raster and pupil, edges included."""
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
        shares, uv = random.random((LANDING_PROBES, 2)), random.random((LANDING_PROBES, 2))
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
        returned = self._back(origins, directions)
        n = len(origins)
        if not isinstance(returned, tuple | list) or len(returned) != 2:
            raise CameraError("back must return raster points and pupil samples: (n, 2) arrays")
        arrays = []
        for name, value in zip(("raster", "uv"), returned, strict=True):
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
        samples = (start + moves[:, None]).reshape(-1, 4)
        samples = np.concatenate([samples, np.hstack([np.clip(raster / self._size, 0.0, 1.0), np.clip(uv, 0.0, 1.0)])])
        origins, directions, weights = self._rays(samples[:, :2] * self._size, samples[:, 2:])
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
        rays = np.concatenate([places, slopes], 2)
        slope = (rays[:, :4] - rays[:, 4:8]) / (2.0 * STEP)
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


PROBES = ((0.5, 0.5), (0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75))     # of raster and pupil, as shares
LARGEST = 1e30          # weight and coordinate (mm): a picture in single precision holds sums of such numbers


@dataclass(frozen=True, eq=False)
class CustomCamera(Camera):
    """Camera whose rays come from a function.

    Args:
        film: Size (mm) and pixels.
        rays: Function of raster (n, 2), uv (n, 2) and time (n,) that returns origins, directions and, if they are not
            all 1, weights. raster: points of the film in pixels, the origin at the top left. uv: pupil samples in [0,
            1]²; (0.5, 0.5) is the pupil's centre, and `unit_disk` maps them to a round pupil. time: seconds on the
            clock of `shutter_open`, 0 in a camera with time_dependent=False. origins: (n, 3), mm, camera frame: x to
            the right, y up, the camera looks along −z. directions: (n, 3), camera frame, of any length but 0. weights:
            (n,), 0 for a blocked ray, whose origin and direction have no meaning. Results that numpy broadcasts to
            these shapes will do. The function must depend on nothing but its arguments; n differs from call to call.
        time_dependent: Whether the function depends on its time. False lets light tracing and the averages over the
            pupil work as behind a camera at rest.
        back: Function of origins (n, 3) and unit directions (n, 3) of rays in the camera frame, towards the scene, that
            returns raster (n, 2) and uv (n, 2): the inverse of `rays`, for any points on the rays as origins. It lets
            small lights be traced to the film. A ray that misses the pupil gets a uv outside [0, 1]², as `unit_square`
            gives it, or inf. Needs time_dependent=False.
        **placement: Keyword arguments of `Camera`: transform and shutter. Weights are those of the function.
    Raises:
        CameraError: A function that takes other arguments, or whose results have other shapes, are not finite, or
            contain a direction of length 0 or a negative weight, here or in a picture; a `back` that is not the inverse
            of `rays`, here or in a picture, or whose rays have no étendue; weights="physical"; a medium of an index
            other than 1.
    """

    film: Film
    rays: Callable[..., Any] = None                       # type: ignore[assignment]
    time_dependent: bool = True
    back: Callable[..., Any] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.film, Film):
            raise CameraError(f"the film of a custom camera is an lb.Film, not {_described(self.film)}")
        super().__post_init__()
        if not callable(self.rays):
            raise CameraError("a custom camera needs a function: CustomCamera(film, rays), with "
                              "rays(raster, uv, time) -> origins, directions, weights")
        _check_arguments(self.rays, "rays", ("raster", "uv", "time"))
        if self.weights != "relative":
            raise CameraError("the weights of a custom camera are those that its function returns: leave weights out")
        if self.has_port:
            raise CameraError("a custom camera has no known front, where a window to a medium could lie: "
                              "choose a medium of index 1")
        shares = np.array(PROBES)
        size = [self.film.pixels_x, self.film.pixels_y]
        self._checked_rays(shares * size, np.roll(shares, 1, 0), np.full(len(shares), self.shutter_open))
        if self.back is not None:
            if not callable(self.back):
                raise CameraError("back is a function of origins and directions that returns raster and uv")
            _check_arguments(self.back, "back", ("origins", "directions"))
            if self.time_dependent:
                raise CameraError("a camera with a way back must not depend on time: add time_dependent=False")
            self._way_back      # noqa: B018  (tested here, not in the first picture)

    @property
    def moves(self) -> bool:
        """Whether rays depend on the time, by the function or by the camera's movement."""
        return self.time_dependent or super().moves

    @property
    def _not_projective(self) -> str:
        return "the rays of a custom camera come from a function, of which no first-order map is known"

    def at(self, time: float = 0.0) -> "CustomCamera":
        """The same camera with its function held at one time (s, on the clock of shutter_open); its own movement
        remains.
        """
        rays = self.rays
        return replace(self, rays=lambda raster, uv, _: rays(raster, uv, np.full(len(raster), float(time))),
                       time_dependent=False)

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Step that calls the function; see `Camera.camera_steps`."""
        return [self._stage.step]

    def film_landing(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """Stages by the user's way back, or None without one; see `Camera.film_landing`."""
        return None if self.back is None else self._way_back.film_landing

    @cached_property
    def _way_back(self) -> CustomLanding:
        assert self.back is not None
        return CustomLanding(self.film, lambda raster, uv: self._checked_rays(raster, uv, np.zeros(len(raster))),
                             self.back)

    @cached_property
    def _stage(self) -> PythonStage:
        return PythonStage(self._fill)

    def _fill(self, rows: np.ndarray) -> None:
        """Turn the film points (mm) of a block into rays."""
        raster = self.raster_from_film(rows[X:Y + 1].T.astype(float))
        uv = rows[U0:U1 + 1].T.astype(float)
        time = self.shutter_open + rows[TIME].astype(float) if self.time_dependent else np.zeros(len(raster))
        origins, directions, weights = self._checked_rays(raster, uv, time)
        rows[X:Z + 1], rows[L:N + 1], rows[WEIGHT] = origins.T, directions.T, weights

    def _checked_rays(self, raster: np.ndarray, uv: np.ndarray, time: np.ndarray
                     ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Origins, unit directions and weights that the function gives; CameraError where they are no rays."""
        returned = self.rays(raster, uv, time)
        if not isinstance(returned, tuple | list) or len(returned) not in (2, 3):
            raise CameraError(f"the camera's function returned {_described(returned)}: "
                              "it must return origins, directions and, if they are not all 1, weights")
        n = len(raster)
        shapes = {"origins": (n, 3), "directions": (n, 3), "weights": (n,)}
        arrays = []
        for (name, shape), value in zip(shapes.items(), (*returned, 1.0)[:3], strict=True):
            try:
                if np.iscomplexobj(value):
                    raise TypeError
                arrays.append(np.broadcast_to(np.asarray(value, float), shape))
            except (TypeError, ValueError):
                raise CameraError(f"the camera's function returned {name} as {_described(value)} for {n} samples: "
                                  f"they must have the shape {shape}") from None
        origins, directions, weights = arrays

        def refuse(wrong: np.ndarray, what: str) -> None:
            if wrong.any():
                k = int(np.argmax(wrong))
                position = ", ".join(significant(float(number)) for number in raster[k])
                through = ", ".join(significant(float(number)) for number in uv[k])
                raise CameraError(f"the camera's function returned {what} for the raster point ({position}) "
                                  f"and the pupil sample ({through})")

        refuse(~(np.abs(weights) <= LARGEST), "a weight that is not a finite number below 1e30")
        refuse(weights < 0.0, "a negative weight")
        lit = weights > 0.0
        refuse(lit & ~(np.abs(origins).max(1) <= LARGEST), "an origin that is not finite and within 1e30 mm")
        refuse(lit & ~np.isfinite(directions).all(1), "a direction that is not finite")
        largest = np.abs(directions).max(1)
        refuse(lit & (largest == 0.0), "a direction of length 0")
        # Blocked rays get some harmless ray; the largest part is taken out first, since its square may overflow
        safe = np.where(lit, largest, 1.0)[:, None]
        scaled = np.where(lit[:, None], directions, [0.0, 0.0, -1.0]) / safe
        return (np.where(lit[:, None], origins, 0.0), scaled / np.sqrt((scaled * scaled).sum(1))[:, None], weights)

    def raster_from_point(self, points: ArrayLike, pupil_uv: ArrayLike | None = None, time: ArrayLike = 0.0,
                          wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
        """Projection by Newton's method on the function; see `Camera.raster_from_point`.

        CameraError for several times, or a rolling shutter, with a function that depends on time: project with `at`.
        """
        if not self.time_dependent:
            return super().raster_from_point(points, pupil_uv, time, wavelength)
        if np.ndim(time) > 0 or self.readout > 0.0:
            raise CameraError("points are projected at one time by a camera whose function depends on time: "
                              "choose it with camera.at(seconds)")
        seconds = self.shutter_open + self._seconds_since_open(time)
        return self.at(seconds).raster_from_point(points, pupil_uv, time, wavelength)

    def _seconds_since_open(self, time: ArrayLike) -> float:
        """Time (s) since shutter_open of a shutter sample in [0, 1]."""
        return float(Program([self.clock], np.float64).run({TIME: checked_times(time)[None]}, [TIME], 1)[0, 0])


def _check_arguments(function: Callable[..., Any], name: str, arguments: tuple[str, ...]) -> None:
    """CameraError where a function cannot be called with these arguments."""
    try:
        signature(function).bind(*arguments)
    except TypeError as error:
        raise CameraError(f"{name} is called with {', '.join(arguments[:-1])} and {arguments[-1]}, "
                          f"which the function does not take: {error}") from error
    except ValueError:                          # a compiled function, whose arguments are not known
        return


def _described(value: object) -> str:
    """What a function returned, in a few words."""
    shape = getattr(value, "shape", None)
    if shape is not None:
        return f"an array of the shape {shape}"
    return f"{len(value)} values" if isinstance(value, tuple | list) else f"{value!r:.40}"
