"""The base class of every camera: film, weights, rays and projection. `placed_shutter` has its place and times.

A camera kind gives its own film and either `gaussian` with `gain`, for a projective camera, or `camera_steps`.
Everything else follows from those, or has a default that a kind may override; `film_importance` of a camera that is not
projective has no default. The camera frame has its origin at the camera, x to the right, y up, and the
camera looks along −z; the film lies in the plane z = 0 of a real lens, or is imagined behind an ideal one.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.cameras import camera_spaces
from lensbench.cameras.differentials import Differentials, ray_slopes
from lensbench.cameras.film_landing import FilmLanding
from lensbench.cameras.flat_port import port_step
from lensbench.cameras.ideal_lens import Gaussian
from lensbench.cameras.importance import FilmImportance, Importance, camera_importance, gaussian_importance
from lensbench.cameras.placed_shutter import PlacedShutter
from lensbench.cameras.project import solve_film_points
from lensbench.cameras.rays import CameraError, Rays, checked_times
from lensbench.cameras.rolling_shutter import project_onto_open_rows
from lensbench.imaging.coordinate_spaces import Intrinsics, Places, Spaces, Window, transform_points
from lensbench.imaging.film_pose import UPRIGHT, FilmPose
from lensbench.kernels.block import TIME, U0, U1, WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.kernels.lazy_names import called
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import unit_square
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid_sampler import PupilGrid
from lensbench.pupils.posed_sampler import PosedPupil
from lensbench.pupils.radial_sampler import PupilTable
from lensbench.scenery.shading.participating_medium import Medium


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera(PlacedShutter):
    """Fields and methods that all camera kinds share; each kind adds a field `film`.

    Parameters
    ----------
    weights : str
        "relative": the unvignetted axis point has weight 1 at every stop. "physical": cos⁴θ · area / z² · effective
        time, and radiance falls by the squared index when light leaves a medium. "radiance", or "one": every ray of
        an ideal camera has weight 1, without cos⁴θ, so that a pixel shows the mean radiance that it sees.
    medium : Medium or None
        Medium between the camera and the scene; None is clear air. A flat window at the camera's foremost point
        separates air from a medium of another index. The camera is focused and weighted as in air, so objects in
        water appear nearer by the index on its focus scale.
    **placement
        Keyword arguments of `PlacedShutter`: transform to the world, and shutter.

    Raises
    ------
    CameraError
        Unknown weights; shutter times that contradict each other.
    TransformError
        A world_from_camera that is not rigid.
    """

    weights: str = "relative"
    medium: Medium | None = None

    def __post_init__(self):
        super().__post_init__()
        if self.weights == "one":
            object.__setattr__(self, "weights", "radiance")
        if self.weights not in ("relative", "physical", "radiance"):
            raise CameraError(f"weights {self.weights!r}: choose relative, physical or radiance")

    def _repr_html_(self) -> str:
        """Section and figures, for a notebook."""
        return called("app.notebook.cards", "camera_card", self)

    # What a camera kind may override

    @property
    def pupil_centre(self) -> tuple[float, float]:
        """Pupil sample of the ray through the centre of the pupil: (0.5, 0.5) in every camera."""
        return 0.5, 0.5

    @property
    def with_open_stop(self) -> "Camera":
        """The camera without a picture in its stop: its central rays pass wherever the picture is opaque."""
        return self

    @property
    def stage_centre(self) -> tuple[float, float]:
        """U0, U1 of the ray through the centre of the pupil, as the camera's stages take them."""
        return 0.5, 0.5

    def stage_uv(self, film_xy: np.ndarray, pupil_uv: np.ndarray) -> np.ndarray:
        """U0, U1 of pupil samples, as the camera's stages take them.

        Parameters
        ----------
        film_xy : (n, 2) array
            Film points (mm).
        pupil_uv : (n, 2) array
            Pupil samples in [0, 1]², as `generate_rays` takes them.

        Returns
        -------
        (n, 2) array
        """
        return pupil_uv

    @property
    def gaussian(self) -> Gaussian:
        """First-order map from film and pupil to rays; CameraError for a camera that is not projective."""
        raise CameraError(f"this camera is not projective: {self._not_projective}")

    @property
    def _not_projective(self) -> str:
        """Reason why a camera kind without a `gaussian` has none."""
        return "straight lines are curves in its pictures"

    @property
    def _is_projective(self) -> bool:
        """Whether this camera kind defines its `gaussian`."""
        return type(self).gaussian is not Camera.gaussian

    @property
    def window(self) -> Window | None:
        """Part of the screen that falls on the film; None: the whole screen."""
        return None

    @property
    def film_step(self) -> Step:
        """Step from raster pixels to the film point X, Y (mm)."""
        return self.film.step

    @property
    def disperses(self) -> bool:
        """Whether the rays depend on the wavelength."""
        return False

    @property
    def follows_rays(self) -> bool:
        """Whether the rays follow a real lens with its aberrations rather than `gaussian`."""
        return False

    @property
    def traced_lens(self) -> Lens | None:
        """Lens whose surfaces the rays are traced through one by one; None for every other camera."""
        return None

    @property
    def gain(self) -> float:
        """Weight of the axial ray of a projective camera; the others fall off from it as cos⁴θ."""
        raise AssertionError("each projective camera defines its gain")

    @property
    def geometric_f_number(self) -> float:
        """Ratio of focal length to pupil diameter, or of image distance for an ideal lens; inf for a pinhole."""
        slope = abs(self.gaussian.approach_pupil)
        return 0.5 / slope if slope > 0.0 else math.inf

    @property
    def nearest_focus(self) -> float:
        """Shortest distance (mm) at which this camera can be focused."""
        return 1e-3

    @property
    def front(self) -> float:
        """Coordinate z (mm, camera frame) of the camera's foremost point, the position of a window."""
        return 0.0

    @property
    def dilution(self) -> float:
        """Ratio of the radiance before the front surface to that behind it: the squared index before it."""
        return 1.0

    @property
    def aim_distance(self) -> float | None:
        """Distance (mm) from the film to the plane with the exit-pupil regions that the first camera step aims at.

        These regions rotate with the film point. None: the same U0, U1 are the same pupil point for every film point.
        """
        return None

    @property
    def pupil(self) -> PupilTable | PupilGrid | PosedPupil:
        """Exit-pupil regions that a camera with an aim_distance samples."""
        raise AssertionError("a camera with an aim_distance defines its pupil")

    @property
    def film_pose(self) -> FilmPose:
        """Pose of the film in the camera frame; in line for every camera but one with a lens."""
        return UPRIGHT

    def film_landing(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """Stages that project traced light onto the raster, or None where the camera has none.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        FilmLanding or None
        """
        return None

    # Steps

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from the film point X, Y (mm) and pupil sample U0, U1 to a ray in the camera frame with its WEIGHT.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm); has no effect on a camera that does not disperse.

        Returns
        -------
        list of Step
        """
        return self._weighted_gaussian.steps(self._weighted_gain)

    @property
    def _weighted_gaussian(self) -> Gaussian:
        """`gaussian` with the slopes whose cos⁴θ weighs the rays: none where all weights are 1."""
        if self.weights == "radiance":
            return self.gaussian._replace(approach_film=0.0, approach_pupil=0.0)
        return self.gaussian

    @property
    def _weighted_gain(self) -> float:
        """`gain`, or 1 where all weights are 1."""
        return 1.0 if self.weights == "radiance" else self.gain

    def lens_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from a ray aimed at an exit-pupil region to the ray in front of the lens, for cameras that aim.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        list of Step

        Raises
        ------
        AssertionError
            If the camera does not aim: it has no `aim_distance`.
        """
        raise AssertionError("a camera with an aim_distance defines its lens_steps")

    def steps(self, wavelength: float = D_LINE, timed: bool = False) -> list[Step]:
        """Steps from raster X, Y, pupil sample U0, U1 and TIME to a ray in the world with its WEIGHT.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm); has no effect on a camera that does not disperse.
        timed : bool
            Whether TIME becomes seconds since shutter_open. A camera that moves always converts it.

        Returns
        -------
        list of Step
        """
        clock = [self.clock] if timed or self.moves else []
        return [*clock, self.film_step, *self.aimed(wavelength), *self.carried]

    def aimed(self, wavelength: float = D_LINE) -> list[Step]:
        """Steps from the film point and pupil sample to the ray in the scene's medium, in the camera frame.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        list of Step
        """
        return [*self.camera_steps(wavelength), *self.port]

    @property
    def port(self) -> list[Step]:
        """Step through the window into a medium of another index; empty without a window."""
        if not self.has_port:
            return []
        assert self.medium is not None
        index = self.medium.index
        return [port_step(self.front, index, 1.0 / index**2 if self.weights == "physical" else 1.0)]

    @property
    def has_port(self) -> bool:
        """Whether the camera looks through a window into a medium of another index."""
        return self.medium is not None and self.medium.index != 1.0

    def check_overrides(self) -> None:
        """Refuse a camera kind that overrides a method that pictures do not call.

        Pictures run the camera's stages; `generate_rays` and `generate_ray_differentials` run the same stages and
        return what they computed.

        Raises
        ------
        CameraError
            With what to do instead.
        """
        for name in ("generate_rays", "generate_ray_differentials"):
            if getattr(getattr(self, name), "__func__", None) is not getattr(Camera, name):
                raise CameraError(f"{type(self).__name__} overrides {name}, which pictures do not call: give the "
                                  "function of its rays to lb.CustomCamera(film, rays), or override camera_steps "
                                  "with a stage")

    def _normaliser(self, on_axis: float, z: float) -> float:
        """Divisor of cos⁴θ · area; on_axis: ∫ cos⁴θ dA (mm²) seen from the film's centre, z: film distance (mm)."""
        if self.weights != "physical":
            return on_axis
        return z * z * self.dilution / self.effective_time if self.effective_time > 0.0 else math.inf

    # Rays

    def generate_rays(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE) -> Rays:
        """Rays through raster points and pupil samples, by the same stages that the renderer runs.

        Parameters
        ----------
        raster_xy : (n, 2) array
            Raster points (pixels), the origin at the top left and pixel centres at +0.5.
        pupil_uv : (n, 2) array
            Pupil samples in [0, 1]², by which equal areas of the square have equal areas of the pupil. In every camera
            (0.5, 0.5) is the pupil's centre, and `unit_disk` maps them to the pupil: to a disk, or to the exit-pupil
            region of the film point.
        time : float or (n,) array
            Shutter samples in [0, 1]: the part of the light that the shutter has let through, 0 as it begins to open
            and 1 as it has closed.
        dtype : type
            Precision of the stages, float64 or float32.
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        Rays
            Origins (mm) and unit directions in the world, weights, and times in seconds, which include the delay of
            each ray's row.

        Raises
        ------
        CameraError
            Arrays of other shapes, raster points that are not finite, or times outside [0, 1].
        ValueError
            Pupil samples outside the unit square.
        """
        raster_xy, pupil_uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_square(pupil_uv, dtype)
        if raster_xy.shape[1:] != (2,) or raster_xy.shape != pupil_uv.shape:
            raise CameraError(f"raster points {raster_xy.shape} and pupil points {pupil_uv.shape} must both be (n, 2)")
        if not np.isfinite(raster_xy).all():
            raise CameraError("raster points must be finite numbers")
        n = len(raster_xy)
        times = np.broadcast_to(checked_times(time), (n,))
        pupil_uv = self._stage_uv_of_raster(raster_xy, pupil_uv, dtype)
        given = {X: raster_xy[:, 0], Y: raster_xy[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1], TIME: times}
        out = Program(self.steps(wavelength, timed=True), dtype).run(given, [X, Y, Z, L, M, N, WEIGHT, TIME], n)
        return Rays(out[:3].T, out[3:6].T, out[6], self.shutter_open + out[7].astype(float))

    def _stage_uv_of_raster(self, raster_xy: np.ndarray, pupil_uv: np.ndarray, dtype) -> np.ndarray:
        """`stage_uv` of raster points (n, 2), within the unit square for numbers of this type."""
        film = Program([self.film_step], np.float64).run({X: raster_xy[:, 0], Y: raster_xy[:, 1]}, [X, Y],
                                                         len(raster_xy)).T
        return unit_square(self.stage_uv(film, pupil_uv), dtype)

    def generate_ray_differentials(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE
                                   ) -> tuple[Rays, Differentials, Differentials]:
        """Rays, and their derivatives per pixel to the right and per pixel down.

        The derivatives hold the pupil point fixed: the point of the unit disk, or of an exit-pupil region on the plane
        of the last vertex. They hold the shutter sample `time` fixed too, so with a rolling shutter they include the
        motion of the camera between rows. They have a closed form, or are differences of the camera's own stages with
        a relative error of 1e-7 in double precision.

        Parameters
        ----------
        raster_xy, pupil_uv, time, dtype, wavelength
            As for `generate_rays`.

        Returns
        -------
        rays : Rays
            The rays of `generate_rays`; a blocked neighbour does not change their weights.
        dx, dy : Differentials
            Derivatives in the world per pixel to the right and down; NaN where the ray itself is blocked.

        Raises
        ------
        CameraError, ValueError
            As for `generate_rays`.
        """
        rays = self.generate_rays(raster_xy, pupil_uv, time, dtype, wavelength)
        raster = np.atleast_2d(np.asarray(raster_xy, float))
        uv = self._stage_uv_of_raster(raster, unit_square(pupil_uv, dtype), dtype)
        given = {X: raster[:, 0], Y: raster[:, 1], U0: uv[:, 0], U1: uv[:, 1],
                 TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        slopes = ray_slopes(self, given, dtype, wavelength, timed=True)
        slopes = np.where(rays.weights[:, None] > 0.0, slopes, math.nan)
        dx, dy = (Differentials(slope[:, :3], slope[:, 3:]) for slope in slopes)
        return rays, dx, dy

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
        """Derivatives of rays by the film point at a fixed pupil sample, in the camera frame.

        Parameters
        ----------
        film_xy : (n, 2) array
            Film points (mm) of the rays.
        directions : (n, 3) array
            Unit directions of the rays.

        Returns
        -------
        (2, n, 6) array or None
            What a mm of film in x and in y adds to origins (mm) and directions; None without a closed form.
        """
        return self.gaussian.film_slopes(directions) if self._is_projective else None

    # Projection onto the film

    def raster_from_point(self, points, pupil_uv=None, time=0.0, wavelength: float = D_LINE):
        """Projection of points of the world onto the raster. Other objects of the scene hide nothing.

        Parameters
        ----------
        points : (n, 3) array
            Points in the world (mm).
        pupil_uv : (n, 2) array or None
            Pupil samples in [0, 1]² of the rays that project; None: the centre of the pupil.
        time : float or (n,) array
            Shutter samples in [0, 1), as `generate_rays` takes them.
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        raster : (n, 2) array
            Raster points (pixels); those of points that are not visible are NaN or have no meaning.
        visible : (n,) bool array
            False for points behind the camera, blocked by the lens, or beside the film.

        Raises
        ------
        ValueError
            Points that are not finite, pupil samples outside the unit square, or times outside [0, 1].
        """
        points = np.atleast_2d(np.asarray(points, float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points of the shape {points.shape}: they must be (n, 3) finite numbers")
        if pupil_uv is None and self.with_open_stop is not self:
            return self.with_open_stop.raster_from_point(points, None, time, wavelength)
        centre = self.pupil_centre if pupil_uv is None else pupil_uv
        pupil_uv = np.broadcast_to(unit_square(centre, np.float64), (len(points), 2))

        def project(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Raster points with the camera where it is while these rows of the film are open."""
            there = transform_points(np.linalg.inv(self.placement(time, row)), points)
            if self.has_port:
                film, visible = self._film_by_newton(self.aimed(wavelength), there, pupil_uv)
            else:
                film, visible = self.film_from_point(there, pupil_uv, wavelength)
            return self.raster_from_film(film), visible

        return project_onto_open_rows(self, project, len(points))

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray, wavelength: float = D_LINE):
        """Film points whose rays through given pupil samples meet points of the camera frame.

        Parameters
        ----------
        points : (n, 3) array
            Points in the camera frame (mm).
        pupil_uv : (n, 2) array
            Pupil samples in [0, 1]².
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        film : (n, 2) array
            Film points (mm).
        visible : (n,) bool array
            Whether the camera sees the points.
        """
        if self._is_projective:
            return self.gaussian.film_points(points, pupil_uv)
        return self._film_by_newton(self.camera_steps(wavelength), points, pupil_uv)

    def _film_by_newton(self, steps: list[Step], points: np.ndarray, pupil_uv: np.ndarray):
        """`film_from_point` by Newton's method, with steps from the film to the ray in the camera frame."""
        program = Program(steps, np.float64)
        return solve_film_points(program, points, pupil_uv, self.stage_uv, self.stage_centre,
                                 self.film.diagonal / 2.0, self._newton_start(points))

    def _newton_start(self, points: np.ndarray) -> np.ndarray | None:
        """Film points (n, 2) near those that see points (n, 3) of the camera frame; None where none are needed."""
        return None

    def raster_from_film(self, film_xy: np.ndarray) -> np.ndarray:
        """Raster points of film points: the inverse of `film_step`.

        Parameters
        ----------
        film_xy : (n, 2) array
            Film points (mm).

        Returns
        -------
        (n, 2) array of raster points (pixels).
        """
        across, right, down, bottom = self.film_step.parameters
        return np.stack([(right - film_xy[:, 0]) / across, (film_xy[:, 1] + bottom) / down], 1)

    def importance(self, origins, directions, time=0.0, wavelength: float = D_LINE) -> Importance:
        """Importance and densities of rays that run from the camera into the scene.

        To connect a point of the scene to the camera, pass drawn pupil samples to `raster_from_point` and the raster
        points that it returns to `generate_rays`. Per solid angle at the point, that ray is chosen with the density
        position_pdf · distance² / cos θ, with the distance to the point where the ray crosses the entrance pupil.

        Parameters
        ----------
        origins : (n, 3) array
            Any points on the rays, in the world (mm).
        directions : (n, 3) array
            Directions in the world, of any length.
        time : float or (n,) array
            Shutter samples in [0, 1), as `generate_rays` takes them.
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        Importance

        Raises
        ------
        ValueError
            Rays of other shapes, not finite, or with a zero direction.
        CameraError
            A camera behind a window to a medium.
        """
        return camera_importance(self, origins, directions, time, wavelength)

    def film_importance(self, origins: np.ndarray, directions: np.ndarray,
                        wavelength: float = D_LINE) -> FilmImportance:
        """Importance and densities of rays in the camera frame.

        Parameters
        ----------
        origins, directions : (n, 3) arrays
            Points on the rays (mm) and their unit directions, camera frame.
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        FilmImportance
        """
        return gaussian_importance(self._weighted_gaussian, self._weighted_gain, self._film_area, origins, directions)

    @property
    def _film_area(self) -> float:
        """Area (mm²) of the film, at the scale of `film_step`."""
        across, _, down, _ = self.film_step.parameters
        return across * self.film.pixels_x * down * self.film.pixels_y

    # Spaces

    @property
    def intrinsics(self) -> Intrinsics:
        """Focal lengths and principal point in pixels; a traced lens has those of its first order.

        Raises CameraError for a camera that is not projective.
        """
        return camera_spaces.intrinsics(self)

    def spaces(self, near: float = 1.0, far: float = math.inf, time=0.0) -> Spaces:
        """Transforms between raster, screen, camera and world.

        Parameters
        ----------
        near, far : float
            Distances (mm) of the planes that depth 0 and 1 lie on; an orthographic camera needs a finite far plane.
        time : float
            Shutter sample in [0, 1) at which the camera is placed.

        Returns
        -------
        Spaces

        Raises
        ------
        CameraError
            A camera that is not projective.
        ValueError
            Planes in the wrong order.
        """
        return camera_spaces.spaces(self, near, far, time)

    def places(self, raster_xy, distance: float, time=0.0, object_from_world=None) -> Places:
        """Raster points in every space, for every camera kind: the data of a read-out under the mouse.

        Parameters
        ----------
        raster_xy : (n, 2) array
            Raster points (pixels).
        distance : float or (n,) array
            Distance (mm) to the object, along the ray through the centre of the pupil.
        time : float or (n,) array
            Shutter samples in [0, 1).
        object_from_world : (4, 4) array or None
            Transform from the world into the frame of an object; None: the object frame is the world.

        Returns
        -------
        Places
        """
        return camera_spaces.places(self, raster_xy, distance, time, object_from_world)
