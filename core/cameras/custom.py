"""Camera whose rays come from a Python function of numpy arrays.

The function is one of the camera's stages (`kernels.python_stage`): pictures, AOVs, ray differentials and light fields
use it as they use a compiled camera. It runs for one block of samples at a time on one core. A camera of the same rays
that shall use all cores overrides `Camera.camera_steps` with a compiled stage (docs/own-cameras.md).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from inspect import signature

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.custom_landing import CustomLanding
from lensbench.cameras.film_landing import FilmLanding
from lensbench.cameras.rays import CameraError, checked_times
from lensbench.imaging.film import Film
from lensbench.kernels.block import TIME, U0, U1, WEIGHT, L, N, Step, X, Y, Z
from lensbench.kernels.figures import significant
from lensbench.kernels.program import Program
from lensbench.kernels.python_stage import PythonStage
from lensbench.optics.glass import D_LINE

PROBES = ((0.5, 0.5), (0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75))     # of raster and pupil, as shares
LARGEST = 1e30          # weight and coordinate (mm): a picture in single precision holds sums of such numbers


@dataclass(frozen=True, eq=False)
class CustomCamera(Camera):
    """Camera whose rays come from a function.

    Parameters
    ----------
    film : Film
        Size (mm) and pixels.
    rays : callable
        Function of raster (n, 2), uv (n, 2) and time (n,) that returns origins, directions and, if they are not all 1,
        weights. raster: points of the film in pixels, the origin at the top left. uv: pupil samples in [0, 1]²;
        (0.5, 0.5) is the pupil's centre, and `unit_disk` maps them to a round pupil. time: seconds on the clock of
        `shutter_open`, 0 in a camera with time_dependent=False. origins: (n, 3), mm, camera frame: x to the right, y
        up, the camera looks along −z. directions: (n, 3), camera frame, of any length but 0. weights: (n,), 0 for a
        blocked ray, whose origin and direction have no meaning. Results that numpy broadcasts to these shapes will do.
        The function must depend on nothing but its arguments; n differs from call to call.
    time_dependent : bool
        Whether the function depends on its time. False lets light tracing and the averages over the pupil work as
        behind a camera at rest.
    back : callable or None
        Function of origins (n, 3) and unit directions (n, 3) of rays in the camera frame, towards the scene, that
        returns raster (n, 2) and uv (n, 2): the inverse of `rays`, for any points on the rays as origins. It lets small
        lights be traced to the film. A ray that misses the pupil gets a uv outside [0, 1]², as `unit_square` gives
        it, or inf. Needs time_dependent=False.
    **placement
        Keyword arguments of `Camera`: transform and shutter. Weights are those of the function.

    Raises
    ------
    CameraError
        A function that takes other arguments, or whose results have other shapes, are not finite, or contain a
        direction of length 0 or a negative weight, here or in a picture; a `back` that is not the inverse of `rays`,
        here or in a picture, or whose rays have no étendue; weights="physical"; a medium of an index other than 1.
    """

    film: Film
    rays: Callable = None                       # type: ignore[assignment]
    time_dependent: bool = True
    back: Callable | None = None

    def __post_init__(self):
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

    def at(self, time=0.0) -> "CustomCamera":
        """The same camera with its function held at one time; the movement of the camera as a whole remains.

        Parameters
        ----------
        time : float
            Time (s) on the clock of shutter_open.

        Returns
        -------
        CustomCamera
            One with time_dependent=False.
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

    def _checked_rays(self, raster: np.ndarray, uv: np.ndarray, time: np.ndarray):
        """Origins, unit directions and weights that the function gives; CameraError where they are no rays."""
        found = self.rays(raster, uv, time)
        if not isinstance(found, tuple | list) or len(found) not in (2, 3):
            raise CameraError(f"the camera's function returned {_described(found)}: "
                              "it must return origins, directions and, if they are not all 1, weights")
        n = len(raster)
        shapes = {"origins": (n, 3), "directions": (n, 3), "weights": (n,)}
        arrays = []
        for (name, shape), value in zip(shapes.items(), (*found, 1.0)[:3], strict=True):
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
                at = ", ".join(significant(float(number)) for number in raster[k])
                through = ", ".join(significant(float(number)) for number in uv[k])
                raise CameraError(f"the camera's function returned {what} for the raster point ({at}) "
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

    def raster_from_point(self, points, pupil_uv=None, time=0.0, wavelength: float = D_LINE):
        """Projection by Newton's method on the function; see `Camera.raster_from_point`.

        Raises
        ------
        CameraError
            Several times, or a rolling shutter, with a function that depends on time: project with `at`.
        """
        if not self.time_dependent:
            return super().raster_from_point(points, pupil_uv, time, wavelength)
        if np.ndim(time) > 0 or self.readout > 0.0:
            raise CameraError("points are projected at one time by a camera whose function depends on time: "
                              "choose it with camera.at(seconds)")
        seconds = self.shutter_open + self._seconds_since_open(time)
        return self.at(seconds).raster_from_point(points, pupil_uv, time, wavelength)

    def _seconds_since_open(self, time) -> float:
        """Time (s) since shutter_open of a shutter sample in [0, 1]."""
        return float(Program([self.clock], np.float64).run({TIME: checked_times(time)[None]}, [TIME], 1)[0, 0])


def _check_arguments(function: Callable, name: str, arguments: tuple[str, ...]) -> None:
    """CameraError where a function cannot be called with these arguments."""
    try:
        signature(function).bind(*arguments)
    except TypeError as error:
        raise CameraError(f"{name} is called with {', '.join(arguments[:-1])} and {arguments[-1]}, "
                          f"which the function does not take: {error}") from error
    except ValueError:                          # a compiled function, whose arguments are not known
        return


def _described(value) -> str:
    """What a function returned, in a few words."""
    shape = getattr(value, "shape", None)
    if shape is not None:
        return f"an array of the shape {shape}"
    return f"{len(value)} values" if isinstance(value, tuple | list) else f"{value!r:.40}"
