"""What every camera has: a film, a place in the world, a shutter, weights, rays, and the way back to the film."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from lensbench.cameras.differentials import Differentials, ray_slopes
from lensbench.cameras.film_landing import FilmLanding
from lensbench.cameras.flat_port import port_step
from lensbench.cameras.ideal_lens import Gaussian
from lensbench.cameras.importance import FilmImportance, Importance, gaussian_importance
from lensbench.cameras.project import film_from_point
from lensbench.cameras.rays import CameraError, Rays, checked_times
from lensbench.cameras.rolling_shutter import film_middle, project_onto_open_rows
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.imaging.coordinate_spaces import Intrinsics, Places, Spaces, Window, film_window, transform_points
from lensbench.imaging.film import Film
from lensbench.imaging.shutter import DIRECTIONS, shutter_step
from lensbench.imaging.transform import checked_rigid, transform_steps
from lensbench.kernels.block import TIME, U0, U1, WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import unit_square
from lensbench.optics.glass import D_LINE
from lensbench.scenery.shading.participating_medium import Medium


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera:
    """Fields that all cameras share, beside the film that each of them has.

    world_from_camera: (4, 4) rigid, the identity by default, or an AnimatedTransform, which
    may also scale all directions alike. The shutter is open from shutter_open to
    shutter_close (s); shutter_ramp: the time that it takes to open and to close (s), 0 for a
    box. readout: from the opening of the first line to that of the last (s), 0 for a global
    shutter; shutter_open and shutter_close are those of the first line, and readout_direction
    says where the lines go in the upright picture: "down", "up", "left" or "right".
    weights: "relative" (the unvignetted axis point is 1, whatever the stop) or "physical"
    (cos⁴θ · area / z² · effective time, and radiance falls by the index squared on its way out of a
    medium). medium: what lies between the camera and the scene; None: clear air. Where its index is not that
    of air, a flat window stands before the camera's foremost point; the camera is focused and
    weighted as in air, so that on its scale a thing in water seems nearer by the index.
    """

    if TYPE_CHECKING:                   # each camera's own field, in its own place among them
        @property
        def film(self) -> Film:
            """What the picture falls on."""
    world_from_camera: np.ndarray | AnimatedTransform = field(default_factory=lambda: np.eye(4))
    shutter_open: float = 0.0
    shutter_close: float = 1.0
    shutter_ramp: float = 0.0
    readout: float = 0.0
    readout_direction: str = "down"
    weights: str = "relative"
    medium: Medium | None = None

    def __post_init__(self):
        if isinstance(self.world_from_camera, AnimatedTransform):
            _ = self.world_from_camera.scales                       # one that stretches is refused on the way
        else:
            object.__setattr__(self, "world_from_camera", checked_rigid(self.world_from_camera))
        if self.weights not in ("relative", "physical"):
            raise CameraError(f"weights {self.weights!r}: choose relative or physical")
        if not (math.isfinite(self.shutter_open) and math.isfinite(self.shutter_close)):
            raise CameraError("the shutter's times must be finite numbers of seconds")
        if self.shutter_close < self.shutter_open:
            raise CameraError(f"the shutter closes at {self.shutter_close:g} s, "
                              f"before it opens at {self.shutter_open:g} s")
        if not 0.0 <= self.shutter_ramp <= self.exposure_time / 2.0:
            raise CameraError(f"shutter ramp {self.shutter_ramp:g} s: it must lie between 0 and "
                              f"{self.exposure_time / 2.0:g} s, half of the time that the shutter is open")
        if not (math.isfinite(self.readout) and self.readout >= 0.0):
            raise CameraError(f"readout {self.readout:g} s: it must be 0 (a global shutter) or positive")
        if self.readout_direction not in DIRECTIONS:
            raise CameraError(f"readout direction {self.readout_direction!r}: choose one of {', '.join(DIRECTIONS)}")

    @property
    def exposure_time(self) -> float:
        """From the moment when a line begins to open until it is closed (s)."""
        return self.shutter_close - self.shutter_open

    @property
    def effective_time(self) -> float:
        """How long a shutter without ramps would be open for the same light (s): the trapezoid's area."""
        return self.exposure_time - self.shutter_ramp

    @property
    def shutter_efficiency(self) -> float:
        """effective_time / exposure_time: 1 for a box, down to 1/2 for a shutter that is never quite open."""
        return self.effective_time / self.exposure_time if self.exposure_time > 0.0 else 1.0

    @property
    def moves(self) -> bool:
        """Whether the camera moves while any of its lines is open."""
        place = self.world_from_camera
        return isinstance(place, AnimatedTransform) and place.changes_between(self.shutter_open, self._last_moment)

    @property
    def _last_moment(self) -> float:
        """When the last line is closed (s)."""
        return self.shutter_close + self.readout

    def world_from_camera_at(self, seconds) -> np.ndarray:
        """(4, 4) at a time (s), or (n, 4, 4) at n times."""
        place = self.world_from_camera
        if isinstance(place, AnimatedTransform):
            return place.at(seconds)
        return np.broadcast_to(place, (*np.shape(seconds), 4, 4))

    @property
    def pupil_centre(self) -> tuple[float, float]:
        """The U0, U1 of the ray through the middle of the pupil."""
        return 0.5, 0.5

    @property
    def gaussian(self) -> Gaussian:
        """Its rays as those of a lens without aberrations; CameraError for a camera that is not projective."""
        raise CameraError("this camera is not projective: straight lines are curves in its pictures")

    @property
    def window(self) -> Window | None:
        """What of the screen falls on the film; None: all of it."""
        return None

    @property
    def film_step(self) -> Step:
        """The step from raster pixels to the film."""
        return self.film.step

    @property
    def disperses(self) -> bool:
        """Whether its rays differ with the wavelength."""
        return False

    @property
    def gain(self) -> float:
        """Of a projective camera the weight of the ray along the axis, by which the others fall off as cos⁴."""
        raise AssertionError("each projective camera says how bright it is")

    def camera_steps(self, wavelength: float = D_LINE) -> list[Step]:
        """From the film point X, Y, Z (camera frame, mm) and U0, U1 to a ray of the camera frame, with its WEIGHT."""
        return self.gaussian.steps(self.gain)

    def steps(self, wavelength: float = D_LINE, timed: bool = False) -> list[Step]:
        """From raster X, Y, the place in the pupil U0, U1 and TIME to the ray in the world, with its WEIGHT.

        wavelength: of the light, in µm; all the same to a camera that does not disperse. timed: TIME is wanted in
        seconds since shutter_open; so it is of a camera that moves. Others have no step for the time.
        """
        clock = [self.clock] if timed or self.moves else []
        return [*clock, self.film_step, *self.aimed(wavelength), *self.carried]

    def aimed(self, wavelength: float = D_LINE) -> list[Step]:
        """camera_steps, and the window to a medium: to the ray in the scene, in the camera frame."""
        return [*self.camera_steps(wavelength), *self.port]

    @property
    def port(self) -> list[Step]:
        """The step through the window to a medium of another index; none where there is no window."""
        if not self.has_port:
            return []
        assert self.medium is not None
        index = self.medium.index
        return [port_step(self.front, index, 1.0 / index**2 if self.weights == "physical" else 1.0)]

    @property
    def has_port(self) -> bool:
        """Whether it looks through a window into a medium of another index."""
        return self.medium is not None and self.medium.index != 1.0

    @property
    def front(self) -> float:
        """The z of its foremost point in the camera frame (mm), where a window stands."""
        return 0.0

    @property
    def carried(self) -> list[Step]:
        """From a ray of the camera frame, at its TIME in seconds since shutter_open, to the world."""
        place = self.world_from_camera
        if isinstance(place, AnimatedTransform):
            return place.steps(self.shutter_open, self._last_moment)
        return transform_steps(place)

    @property
    def clock(self) -> Step:
        """The step from TIME in [0, 1) of the shutter, and raster X, Y, to seconds since shutter_open."""
        return shutter_step(self.exposure_time, self.shutter_ramp, self.readout, self.readout_direction,
                          self.film.pixels_x, self.film.pixels_y)

    def way_back(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """What becomes of light that comes to it, for light that is followed from its source; None: it cannot be."""
        return None

    @property
    def dilution(self) -> float:
        """By how much a radiance of the scene is less behind the front surface: the square of the index before it."""
        return 1.0

    def _normaliser(self, on_axis: float, z: float) -> float:
        """What cos⁴θ · area is divided by; on_axis: ∫ cos⁴θ dA (mm²) seen from the film's centre."""
        if self.weights == "relative":
            return on_axis
        return z * z * self.dilution / self.effective_time if self.effective_time > 0.0 else math.inf

    def generate_rays(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE) -> Rays:
        """Rays through raster points (n, 2) in pixels and pupil points (n, 2) in [0, 1]², at time (n,) in [0, 1).

        The very stages that the renderer runs, in float64 unless asked otherwise; wavelength in µm. A time is a part
        of the light that the shutter lets through: 0 as it begins to open, 1 as it has closed. The rays' own are
        seconds, with the delay of their line. ValueError for raster points that are not finite, pupil points outside
        the unit square and times outside [0, 1].
        """
        raster_xy, pupil_uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_square(pupil_uv, dtype)
        if raster_xy.shape[1:] != (2,) or raster_xy.shape != pupil_uv.shape:
            raise CameraError(f"raster points {raster_xy.shape} and pupil points {pupil_uv.shape} must both be (n, 2)")
        if not np.isfinite(raster_xy).all():
            raise CameraError("raster points must be finite numbers")
        n = len(raster_xy)
        times = np.broadcast_to(checked_times(time), (n,))
        given = {X: raster_xy[:, 0], Y: raster_xy[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1], TIME: times}
        out = Program(self.steps(wavelength, timed=True), dtype).run(given, [X, Y, Z, L, M, N, WEIGHT, TIME], n)
        return Rays(out[:3].T, out[3:6].T, out[6], self.shutter_open + out[7].astype(float))

    def generate_ray_differentials(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE
                                   ) -> tuple[Rays, Differentials, Differentials]:
        """The rays of generate_rays, and how they change per pixel to the right and down: derivatives in the world.

        At the same place in the pupil: the point of the unit disk, or of an exit-pupil region, on the plane
        of the last vertex. At the same `time` of the shutter too: a line that is read later sees a camera that
        has moved on. In closed form, or by differences of the camera's own stages, to 1e-7 of their size in double. The
        weights are those of the rays alone: no neighbour that is blocked takes a ray away. NaN where a ray is
        blocked itself. Errors as of generate_rays.
        """
        rays = self.generate_rays(raster_xy, pupil_uv, time, dtype, wavelength)
        raster, uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_square(pupil_uv, dtype)
        given = {X: raster[:, 0], Y: raster[:, 1], U0: uv[:, 0], U1: uv[:, 1],
                 TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        slopes = ray_slopes(self, given, dtype, wavelength, timed=True)
        slopes = np.where(rays.weights[:, None] > 0.0, slopes, math.nan)
        dx, dy = (Differentials(slope[:, :3], slope[:, 3:]) for slope in slopes)
        return rays, dx, dy

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray | None:
        """(2, n, 6): what a mm of film in x and in y adds to origins (mm) and directions of rays; None: no closed form.

        At the same U0, U1, in the camera's frame, of rays with these film points (n, 2) and directions (n, 3).
        """
        return self.gaussian.film_slopes(directions)

    @property
    def aim_distance(self) -> float | None:
        """From the film to a plane (mm) on which its first step aims at regions that turn with the film point.

        None: the same U0, U1 are the same place in the pupil for every film point.
        """
        return None

    def raster_from_point(self, points, pupil_uv=None, time=0.0, wavelength: float = D_LINE):
        """The way back: which raster points (n, 2) see points (n, 3) of the world (mm), and whether they do, (n,) bool.

        By the ray through pupil points (n, 2) in [0, 1]² at time (n,) in [0, 1), as generate_rays takes them; None:
        through the middle of the pupil. wavelength in µm. Not visible: what lies behind the camera, is blocked by the
        lens, or falls beside the film; its raster point may still be told, or is NaN. The scene hides nothing.
        ValueError for points that are not finite, pupil points outside the unit square and times outside [0, 1].
        """
        points = np.atleast_2d(np.asarray(points, float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points of the shape {points.shape}: they must be (n, 3) finite numbers")
        middle = self.pupil_centre if pupil_uv is None else pupil_uv
        pupil_uv = np.broadcast_to(unit_square(middle, np.float64), (len(points), 2))

        def project(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """As the camera stands when these lines of the film are open."""
            there = transform_points(np.linalg.inv(self.placement(time, line)), points)
            if self.has_port:
                program = Program(self.aimed(wavelength), np.float64)
                film, visible = film_from_point(program, there, pupil_uv, self.pupil_centre, self.film.diagonal / 2.0)
            else:
                film, visible = self.film_from_point(there, pupil_uv, wavelength)
            return self.raster_from_film(film), visible

        return project_onto_open_rows(self, project, len(points))

    def importance(self, origins, directions, time=0.0, wavelength: float = D_LINE) -> Importance:
        """Importance and densities of rays (n, 3) of the world, mm, that run from the camera into the scene.

        origins: any points on the rays; directions of any length; time (n,) in [0, 1) of the shutter, wavelength in µm.
        To join a point to the camera: raster_from_point with drawn places in the pupil, then generate_rays there
        tells the ray; per solid angle at the point it is chosen with position_pdf · distance² / cos θ, distance to
        where the ray crosses the entrance pupil. ValueError for rays that are not finite, or have no direction;
        CameraError behind the window to a medium.
        """
        if self.has_port:
            raise CameraError("importance is told in air, and not through the window to a medium of another index")
        origins, directions = (np.atleast_2d(np.asarray(values, float)) for values in (origins, directions))
        length = np.linalg.norm(directions, axis=-1)
        if origins.shape != directions.shape or origins.shape[1:] != (3,) or not (
                np.isfinite(origins).all() and np.isfinite(directions).all() and (length > 0.0).all()):
            raise ValueError("rays need origins and directions of the shape (n, 3), finite, and no direction zero")
        ways = directions / length[:, None]

        def found(line: np.ndarray) -> FilmImportance:
            """As the camera stands when these lines of the film are open."""
            camera_from_world = np.linalg.inv(self.placement(time, line))
            there = transform_points(camera_from_world, origins)
            turned = (camera_from_world[..., :3, :3] @ ways[..., None])[..., 0]
            return self.film_importance(there, turned / np.linalg.norm(turned, axis=1)[:, None], wavelength)

        def project(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            of = found(line)
            return self.raster_from_film(of.film), of.passes

        raster, visible = project_onto_open_rows(self, project, len(ways))
        raster = np.where(np.isfinite(raster), raster, 0.0)
        of = found(raster)
        we, position_pdf, direction_pdf = (np.where(visible, value, 0.0) for value in of[1:4])
        if not of.is_point:                             # per mm² of the world, which may be scaled
            area = np.abs(np.linalg.det(self.placement(time, raster)[..., :3, :3])) ** (2.0 / 3.0)
            we, position_pdf = we / area, position_pdf / area
        return Importance(we, position_pdf, direction_pdf, np.where(visible[:, None], raster, math.nan), visible)

    def film_importance(self, origins: np.ndarray, directions: np.ndarray,
                        wavelength: float = D_LINE) -> FilmImportance:
        """As importance, for rays of the camera's frame, directions of length 1."""
        return gaussian_importance(self.gaussian, self.gain, self._film_area, origins, directions)

    @property
    def _film_area(self) -> float:
        """Mm², of the film as it is imagined."""
        across, _, down, _ = self.film_step.parameters
        return across * self.film.pixels_x * down * self.film.pixels_y

    def placement(self, time=0.0, raster=None) -> np.ndarray:
        """world_from_camera at times (n,) in [0, 1) of the shutter, for raster points (n, 2): (4, 4), or (n, 4, 4).

        raster, which a rolling shutter asks for: the middle of the film by default.
        """
        if not isinstance(self.world_from_camera, AnimatedTransform):
            return self.world_from_camera
        one = raster is None and np.ndim(time) == 0
        raster = film_middle(self.film, max(np.size(time), 1)) if raster is None else raster
        given = {X: raster[:, 0], Y: raster[:, 1], TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        seconds = self.shutter_open + Program([self.clock], np.float64).run(given, [TIME], len(raster))[0]
        return self.world_from_camera_at(seconds[0] if one else seconds)

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray, wavelength: float = D_LINE):
        """As raster_from_point, from points of the camera frame to film points (n, 2) in mm, and which it sees."""
        return self.gaussian.film_points(points, pupil_uv)

    def raster_from_film(self, film_xy: np.ndarray) -> np.ndarray:
        """Raster points (n, 2) of film points (n, 2) in mm: the inverse of the film's step."""
        across, right, down, bottom = self.film_step.parameters
        return np.stack([(right - film_xy[:, 0]) / across, (film_xy[:, 1] + bottom) / down], 1)

    @property
    def intrinsics(self) -> Intrinsics:
        """Focal length and principal point in pixels; CameraError for a camera that is not projective.

        Of a traced lens: those of its first order.
        """
        across, right, down, bottom = self.film_step.parameters
        lens = self.gaussian
        per_slope = -1.0 / (lens.slope_film if lens.slope_film != 0.0 else lens.origin_film)
        return Intrinsics(per_slope / across, per_slope / down, right / across, bottom / down)

    def spaces(self, near: float = 1.0, far: float = math.inf, time=0.0) -> Spaces:
        """The transforms between its spaces, with depth from `near` to `far` (mm); CameraError where it has none.

        An orthographic camera needs a finite far plane.
        """
        film, lens = self.film, self.gaussian
        half = min(film.width, film.height) / 2.0
        perspective = lens.slope_film != 0.0
        per_slope = lens.slope_film if perspective else lens.origin_film
        eye = lens.z + lens.origin_film / lens.slope_film if perspective else lens.z
        return Spaces(film.pixels_x, film.pixels_y, self.window or film_window(film), -1.0 / (per_slope * half),
                      near, far, perspective, eye, self.placement(time))

    def places(self, raster_xy, distance: float, time=0.0, object_from_world=None) -> Places:
        """Raster points (n, 2) in every space, for every kind of camera: what a read-out under the mouse shows.

        distance: along the ray through the middle of the pupil to what is seen there (mm), a number or (n,).
        object_from_world: (4, 4), into the frame of a thing in the scene.
        """
        film = self.film
        raster = np.atleast_2d(np.asarray(raster_xy, float))
        ndc = raster / [film.pixels_x, film.pixels_y]
        left, right, bottom, top = self.window or film_window(film)
        screen = ndc * [right - left, bottom - top] + [left, top]
        across, middle, down, low = self.film_step.parameters
        on_film = np.column_stack([middle - raster[:, 0] * across, raster[:, 1] * down - low, np.zeros(len(raster))])
        rays = self.generate_rays(raster, np.tile(self.pupil_centre, (len(raster), 1)), time)
        seen = rays.weights > 0.0
        world = np.where(seen[:, None], rays.origins + rays.directions * np.broadcast_to(distance, seen.shape)[:, None],
                         math.nan)
        camera = transform_points(np.linalg.inv(self.placement(time, raster)), world)
        return Places(raster, ndc, screen, on_film, camera, world,
                      world if object_from_world is None else transform_points(object_from_world, world))
