"""Model error and model choice: how far a camera model is from the traced lens, and the simplest one within tolerances.

A point of the scene is imaged as a blur. A model can displace its middle, change its width along and across the radius,
and its brightness. For some film radii and scene distances, rays of the model and of the lens through the solved
exit-pupil regions are compared where they meet the scene; the lens's own derivative by the film point converts the
difference into pixels. Where pictures are traced in colours, ideal models are compared with red and blue light too.

Models are ordered by a fixed ladder, from the pinhole to the full trace, and not by timings, so that the choice is the
same on every machine.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.cameras.real_lens import LensCamera
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.kernels.block import BLUE, CLEARANCE, RED, U0, U1, WEIGHT, B, L, M, N, X, Y, Z, lane_buffer
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.lens_models.polynomial import DEGREES, Polynomial
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import scene_side_origin
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import fixed, significant

FIELDS = np.array([0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.98])    # film radii, of half the diagonal
AZIMUTHS, RADII = 12, 4                     # rays of one region: around it, and from its centre to its rim
STEP = 1e-4                                 # half diagonals, for the derivative along the film
STEEPEST = 0.2                              # cosine, below which a depth along the axis counts as a distance
RIM = 1.01                                  # (r / semi-diameter)² up to which a ray of a region still passes
BETWEEN = 1.1, 1.1                          # margin on pixels and stops for the fields between FIELDS
COARSE = 0.045                              # region half widths by which tabulated regions may move unseen
LIT = 0.98                                  # of the radius where the light ends, to which errors are computed
HUES = (D_LINE, WAVELENGTHS[RED][4], WAVELENGTHS[BLUE][4])

NAMES = {"pinhole": "pinhole", "thin": "thin lens", "thick": "thick lens", "trace": "full trace"}


class Rung(NamedTuple):
    """One model of the ladder, its errors in pixels and stops, and which error is worst and where."""

    model: str
    degree: int                             # of the polynomial, otherwise 0
    error_px: float
    error_stops: float
    worst: str

    @property
    def name(self) -> str:
        """The model in words."""
        return f"polynomial of degree {self.degree}" if self.degree else NAMES[self.model]


class Moments(NamedTuple):
    """Moments of blurs, (depths, fields) each, mm on the film: middle along the radius, and 2 σ along and across it."""

    middle: np.ndarray
    along: np.ndarray
    across: np.ndarray


@dataclass(frozen=True, eq=False)
class ModelErrors:
    """The errors of models of a LensCamera against the traced lens; depths: nearest and farthest, mm from the film."""

    camera: LensCamera
    depths: tuple[float, float]

    def rung(self, model: str, degree: int = 0, limits: tuple[float, float] = (math.inf, math.inf)) -> Rung:
        """The errors of a model. limits: pixels and stops, beyond which an error may be a lower bound."""
        if model == "trace":
            return Rung(model, 0, 0.0, 0.0, "")
        if why := self._refusal(model):
            return Rung(model, degree, math.inf, math.inf, why)
        try:
            if model != "polynomial":
                ideal = self.camera.ideal(model)
                return self._compared(model, 0, *self._rays_of(ideal), [self._true, *self._hues],
                                      self._offset(model, ideal))
            rung = self._fitted(degree, D_LINE, self._true)
            for wavelength, true in zip(HUES[1:], self._hues if _within(rung, limits) else [], strict=False):
                other = self._fitted(degree, wavelength, true)
                if other.error_px > rung.error_px:
                    rung = other._replace(error_stops=max(rung.error_stops, other.error_stops))
            return rung
        except (CameraError, LensError) as error:
            return Rung(model, degree, math.inf, math.inf, str(error))

    def _fitted(self, degree: int, wavelength: float, true: Moments) -> Rung:
        """The errors of a polynomial for one wavelength."""
        fit = Polynomial.fit(self.camera.lens, self.camera.film_distance, self.table, degree, wavelength,
                             self.camera.focus_distance)
        lines = Program([fit.step], np.float64).run(self._given, [X, Y, Z, L, M, N], self._aims.shape[1])
        rung = self._compared("polynomial", degree, lines, self._weights, [true])
        if wavelength == D_LINE:
            return rung
        return rung._replace(worst=f"in {'red' if wavelength == HUES[1] else 'blue'} light, {rung.worst}")

    def _refusal(self, model: str) -> str:
        """Why the model cannot be used at all; "" where it can."""
        lens = self.camera.lens
        why = [f"the lens has {lens.asymmetry}"] * (not lens.is_rotationally_symmetric)
        why += ["the film is tilted, shifted or curved"] * (not self.camera.film_pose.is_upright)
        if why:
            return ", and ".join(why)
        if model == "polynomial" and not self.camera.lens.iris.is_round:
            shape = "blades need" if self.camera.lens.stop_image is None else "picture needs"
            return f"a polynomial does not give the place at the stop that its {shape}"
        if not self._true_weights[0].sum() > 0.0:
            return "no light comes through this lens"
        if model == "polynomial" and self.table.coarseness > COARSE:
            return "the exit-pupil regions move too far between the film radii of their table"
        if model == "polynomial" and self.table.irregular:
            return "some exit-pupil regions are split or bent, as near the edge of the light"
        if model != "polynomial" and self.table.dark_beyond < self.camera.film.diagonal / 2.0:
            return "the film's corners are dark, and this model lights them"
        return ""

    @cached_property
    def table(self) -> PupilTable:
        """The exit-pupil regions, without the usual widening."""
        return PupilTable.of(self.camera.lens, self.camera.film_distance, self.camera.film.diagonal / 2.0, D_LINE,
                             widened=False)

    @cached_property
    def _radii(self) -> np.ndarray:
        """Film radii at which errors are computed, mm; only as far as the lens lights the film."""
        return FIELDS * min(self.camera.film.diagonal / 2.0, LIT * self.table.dark_beyond)

    @cached_property
    def _film(self) -> np.ndarray:
        """(fields, 3) x of the film points, mm: each, a little outwards and a little inwards, for the derivative."""
        return self._radii[:, None] + self._step * np.array([0.0, 1.0, -1.0])

    @property
    def _step(self) -> float:
        return STEP * self.camera.film.diagonal / 2.0

    @cached_property
    def _aims(self) -> np.ndarray:
        """(5, rays) film x, direction and weight: all rays of the regions, then the middle ray of each film point."""
        turn, area, _ = NODES
        film = np.concatenate([np.repeat(self._radii, len(turn)), self._film.ravel()])
        u = np.concatenate([np.tile(turn * 0.5, len(FIELDS)), np.zeros(self._film.size)])
        v = np.concatenate([np.tile(area, len(FIELDS)), np.zeros(self._film.size)])
        inputs = {X: np.abs(film), U0: u, U1: v}
        out = Program([self.table.step(1.0)], np.float64).run(inputs, [L, M, N, WEIGHT], len(film))
        out[0] *= np.where(film < 0.0, -1.0, 1.0)
        return np.stack([film, *out])

    @cached_property
    def _given(self) -> dict[int, np.ndarray]:
        film, l, m, n, weight = self._aims
        return {X: film, L: l, M: m, N: n, WEIGHT: weight}

    def _lines(self, wavelength: float) -> np.ndarray:
        """(7, rays) the rays of the lens before the lens, camera frame, and their CLEARANCE."""
        steps = trace_steps(self.camera.lens, self.camera.film_distance, wavelength, blades=False)
        return Program(steps, np.float64).run(self._given, [X, Y, Z, L, M, N, CLEARANCE], self._aims.shape[1])

    @cached_property
    def _weights(self) -> np.ndarray:
        """(fields, rays) weights of the rays of the regions."""
        share = NODES[2]
        return self._aims[4, :len(FIELDS) * len(share)].reshape(len(FIELDS), -1) * share

    @cached_property
    def _true_weights(self) -> np.ndarray:
        """(fields, rays) weights of the rays that pass the lens."""
        return np.where(self._true_lines[6, :self._weights.size].reshape(self._weights.shape) <= RIM, self._weights,
                        0.0)

    def _rays_of(self, lens: Gaussian) -> tuple[np.ndarray, np.ndarray]:
        """Rays of an ideal lens through the same nodes of its disk, then the middle rays; and weights."""
        turn, area, share = NODES
        a, b = np.sqrt(area) * np.cos(math.pi * turn), np.sqrt(area) * np.sin(math.pi * turn)
        film = np.concatenate([np.repeat(self._radii, len(turn)), self._film.ravel()])
        a, b = (np.concatenate([np.tile(q, len(FIELDS)), np.zeros(self._film.size)]) for q in (a, b))
        dx, dy = film * lens.slope_film + a * lens.slope_pupil, b * lens.slope_pupil
        size = 1.0 / np.sqrt(dx * dx + dy * dy + 1.0)
        lines = np.stack([film * lens.origin_film + a * lens.origin_pupil, b * lens.origin_pupil,
                          np.full(len(film), lens.z), dx * size, dy * size, -size])
        ex, ey = film * lens.approach_film + a * lens.approach_pupil, b * lens.approach_pupil
        cos4 = 1.0 / (ex * ex + ey * ey + 1.0) ** 2
        return lines, cos4[:len(FIELDS) * len(turn)].reshape(len(FIELDS), -1) * share

    def _offset(self, model: str, lens: Gaussian) -> float:
        """Stops by which an ideal lens is brighter on the axis; 0 with relative weights."""
        camera = self.camera
        if camera.weights == "relative":
            return 0.0
        light = lens.cone if model == "pinhole" else lens.axis_irradiance
        there = 1.0 if model == "thick" else camera.lens.front_index**2
        return math.log2(light * there * camera.film_distance**2 / camera.axis_irradiance)

    @cached_property
    def _eye(self) -> float:
        """Z of the entrance pupil in the camera frame, or of the first vertex where that lies far away."""
        camera = self.camera
        return scene_side_origin(camera.lens) - camera.lens.length - camera.film_distance

    @cached_property
    def _depths(self) -> np.ndarray:
        """Nearest and farthest of the scene, and the plane in focus where it lies between."""
        near, far = max(self.depths[0], 1.01 * -self._eye), max(self.depths[1], 1.01 * -self._eye)
        focus = self.camera.focus_distance
        return np.array([near, focus, far] if near < focus < far else [near, far])

    @cached_property
    def _nearness(self) -> np.ndarray:
        """(depths, fields) 1 / the distance along each field's middle ray to the plane of a depth."""
        middles = self._true_lines[5, -self._film.size:].reshape(-1, 3)[:, 0]
        return np.maximum(-middles, STEEPEST) / (self._depths + self._eye)[:, None]

    @cached_property
    def _true_lines(self) -> np.ndarray:
        return self._lines(D_LINE)

    @cached_property
    def _scales(self) -> tuple[np.ndarray, np.ndarray]:
        """Film and scene: mm along the radius per change of direction (2, depths, fields), change per mm across."""
        x, _, z = self._seen(self._true_lines[:6, -self._film.size:], 3)
        along = np.stack([x[..., 1] - x[..., 2], z[..., 1] - z[..., 2]]) / (2.0 * self._step)
        square, radii = (along**2).sum(0), self._radii
        across = np.where(radii > 0.0, np.abs(x[..., 0]) / np.maximum(radii, 1e-30), np.sqrt(square))
        return along / square, across

    def _seen(self, lines: np.ndarray, rays: int) -> np.ndarray:
        """(3, depths, fields, rays) directions from the entrance pupil to where the rays cross the depths."""
        away = lines[:3] - np.array([0.0, 0.0, self._eye])[:, None]
        foot = away - (away * lines[3:]).sum(0) * lines[3:]
        foot, direction = (vectors.reshape(3, 1, -1, rays) for vectors in (foot, lines[3:]))
        return direction + foot * self._nearness[:, :, None]

    def _moments(self, lines: np.ndarray, weights: np.ndarray) -> Moments:
        """Moments of the blurs of these rays."""
        rays = weights.shape[1]
        x, y, z = self._seen(lines[:6, :weights.size], rays)
        per_mm, across = self._scales
        share = weights / weights.sum(1)[:, None]
        offset = x * per_mm[0][..., None] + z * per_mm[1][..., None]
        middle = (offset * share).sum(-1)
        along = ((offset - middle[..., None]) ** 2 * share).sum(-1)
        return Moments(middle, 2.0 * np.sqrt(along), 2.0 * np.sqrt((y * y * share).sum(-1)) / across)

    @cached_property
    def _true(self) -> Moments:
        return self._moments(self._true_lines, self._true_weights)

    @cached_property
    def _hues(self) -> list[Moments]:
        """Moments in red and blue light, where the camera's pictures are traced in colours."""
        camera = self.camera if self.camera.follows_rays else replace(self.camera, model="trace")
        if not camera.disperses:
            return []
        return [self._moments(self._lines(wavelength), self._true_weights) for wavelength in HUES[1:]]

    def _compared(self, model: str, degree: int, lines: np.ndarray, weights: np.ndarray, truths: list[Moments],
                  offset: float = 0.0) -> Rung:
        """The errors of rays with these weights; the first of the truths is that of the rays' own wavelength."""
        blur = self._moments(lines, weights)
        worst_px, said = 0.0, ""
        for k, true in enumerate(truths):
            shift = np.abs(blur.middle - true.middle)
            spread = np.hypot(blur.along - true.along, blur.across - true.across)
            names = ("lateral colour", "colour blur") if k else ("distortion", "blur off by")
            for what, error in zip(names, (shift, spread), strict=True):
                depth, field = divmod(int(np.argmax(error)), error.shape[1])
                pixels = float(error[depth, field]) / self.camera.film.pitch
                if not pixels <= (2.0 * worst_px if k else worst_px):
                    said = f"{what} {significant(BETWEEN[0] * pixels, 2)} px {self._place(field)}"
                if not pixels <= worst_px:
                    worst_px = pixels
        # Of a wall, which is as bright as the film is lit; and of a light, which is as much brighter as it is larger
        with np.errstate(divide="ignore", invalid="ignore"):
            light = np.log2(weights.sum(1) / self._true_weights.sum(1))
            size = self._stretched(blur.middle - truths[0].middle)
            wall, spot = (np.abs(positions - positions[..., :1] + offset) for positions in (light[None], light - size))
        stops = np.concatenate([wall, spot]).max(0)
        worst_px, worst_stops = BETWEEN[0] * worst_px, BETWEEN[1] * float(stops.max())
        if math.isnan(worst_px) or math.isnan(worst_stops):
            return Rung(model, degree, math.inf, math.inf, "some rays are lost")
        if worst_px <= 10.0 * worst_stops:
            said = f"brightness off by {fixed(worst_stops, 2)} stops {self._place(int(np.argmax(stops)))}"
        return Rung(model, degree, worst_px, worst_stops, said)

    def _stretched(self, shift: np.ndarray) -> np.ndarray:
        """(depths, fields) log2 of image area, lens over model, from the shift of the middles (mm) along and around."""
        r = self._radii
        along = np.gradient(shift, r, axis=1, edge_order=2)
        around = np.concatenate([along[:, :1], shift[:, 1:] / r[1:]], 1)
        return np.log2(np.maximum((1.0 + along) * (1.0 + around), 1e-30))

    def _place(self, field: int) -> str:
        share = self._radii[field] / (self.camera.film.diagonal / 2.0)
        if share == 0.0:
            return "on the axis"
        return "at the corner" if share > 0.95 else f"at {fixed(share, 1)} of the field"


def _within(rung: Rung, limits: tuple[float, float]) -> bool:
    return rung.error_px <= limits[0] and rung.error_stops <= limits[1]


def _nodes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quadrature over one region: turns around its upper half, 0 to 1; share of the area within; weights."""
    nodes, weights = gauss_rule(RADII)
    turn, area = np.meshgrid((np.arange(AZIMUTHS) + 0.5) / AZIMUTHS, nodes, indexing="ij")
    return turn.ravel(), area.ravel(), np.tile(weights / AZIMUTHS, AZIMUTHS)


NODES = _nodes()


TOLERANCE_PX, TOLERANCE_STOPS = 0.5, 0.05    # within which a simpler model may replace the trace
KEEP = 0.8                                  # share of a tolerance in which a simpler model must lie to replace one
LADDER = (("pinhole", 0), ("thin", 0), ("thick", 0), *(("polynomial", degree) for degree in DEGREES), ("trace", 0))
CLOSEST = 0.1                               # share of the nearest depth: the least for a camera off the origin
BLOCKS, TIMES = 4, 7                        # of rays for a timing, and repetitions: the least counts
RESOLVED = 0.02                             # part of a measured time below which a difference is not known


@dataclass(frozen=True)
class Choice:
    """The simplest model within the tolerances, from `choose_model`.

    Args:
        model: "pinhole", "thin", "thick", "polynomial" or "trace".
        degree: Degree of the polynomial, otherwise 0.
        error_px, error_stops: Errors of the model, pixels of the film and stops.
        table: The rungs of the ladder that were tried, in order; the last is the chosen one.
        errors: The errors of all models of this camera, for further rungs.
    """

    model: str
    degree: int
    error_px: float
    error_stops: float
    table: tuple[Rung, ...]
    errors: ModelErrors = field(repr=False, compare=False)

    @property
    def name(self) -> str:
        """The model in words."""
        return self.table[-1].name

    @property
    def reason(self) -> str:
        """Why the next simpler model is refused; "" where there is none."""
        return f"{self.table[-2].name}: {self.table[-2].worst}" if len(self.table) > 1 else ""

    def applied(self, camera: LensCamera) -> LensCamera:
        """The camera, any LensCamera, with this model."""
        return replace(camera, model=self.model, degree=self.degree or camera.degree)

    @property
    def ns_per_ray(self) -> float:
        """Time per ray of this model on this machine, ns, from the film to before the lens; measured when first asked.

        In float32 on one thread, pupil sampling included, as `trace_ns_per_ray`.
        """
        return self._times[0]

    @property
    def trace_ns_per_ray(self) -> float:
        """Time per ray of the full trace, ns, measured in turn with `ns_per_ray`."""
        return self._times[1]

    @cached_property
    def _times(self) -> tuple[float, ...]:
        camera = self.errors.camera
        return ray_times([self.applied(camera), replace(camera, model="trace")])


def choose_model(camera: LensCamera, scene: Scene, tolerance_px: float = TOLERANCE_PX,
                 tolerance_stops: float = TOLERANCE_STOPS, previous: Choice | None = None) -> Choice:
    """The first model of the ladder whose picture of a scene is within tolerances of the traced lens.

    A lens without rotational symmetry is always traced, and no polynomial is fitted to a lens with blades. With a film
    moved (tilt, swing, rise or shift) the lens is traced: errors of the others are known for a centred film.

    Args:
        camera: LensCamera of any model; its film, focus and aperture count.
        scene: Its `depth_range` counts, which is from the world's origin; for a camera elsewhere it is widened by the
            camera's distance from the origin.
        tolerance_px: Tolerance of places and sizes of blurs, pixels of the film.
        tolerance_stops: Tolerance of brightness, stops.
        previous: The choice for the settings just before; a simpler model then replaces it only when well within the
            tolerances, so that the choice does not flicker.
    Raises:
        CameraError: For tolerances that are not positive.
    """
    if not (tolerance_px > 0.0 and tolerance_stops > 0.0):
        raise CameraError("tolerances must be positive: pixels, and stops")
    near, far = scene.depth_range
    away = max(float(np.linalg.norm(camera.world_from_camera_at(time)[:3, 3]))
               for time in (camera.shutter_open, camera.shutter_close))
    errors = ModelErrors(camera, (max(near - away, CLOSEST * near), far + away))
    current = -1 if previous is None else LADDER.index((previous.model, previous.degree))
    table: list[Rung] = []
    for step, (model, degree) in enumerate(LADDER):
        share = KEEP if step < current else 1.0
        limits = share * tolerance_px, share * tolerance_stops
        rung = errors.rung(model, degree, limits)
        table.append(rung)
        if rung.error_px <= limits[0] and rung.error_stops <= limits[1]:
            break
    return Choice(*rung[:4], tuple(table), errors)


def resolved(camera: Camera, scene: Scene) -> Camera:
    """The camera to render a scene with: a LensCamera of the model "auto" gets the chosen one."""
    if isinstance(camera, LensCamera) and camera.model == "auto":
        return choose_model(camera, scene).applied(camera)
    return camera


def ray_times(cameras: list[LensCamera]) -> tuple[float, ...]:
    """Time per ray of each camera, ns: float32, one thread, from raster and pupil to the camera frame, without the
    samples.

    On a busy machine a cheap camera may seem to take less: its time is at least RESOLVED of that with its samples.
    """
    film = cameras[0].film
    before = sampling_steps(film.pixels_x, film.pixels_y, lit=False)
    programs = [Program(before), *(Program([*before, camera.film_step, *camera.camera_steps()]) for camera in cameras)]
    lanes, sums = lane_buffer(), np.zeros((BLOCKS, 3 * B), np.float32)
    least = [math.inf] * len(programs)
    for _ in range(TIMES):
        for i, program in enumerate(programs):
            start = perf_counter()
            program.expose(sums, lanes, 0, BLOCKS, 0, 1, np.uint32(0))
            least[i] = min(least[i], perf_counter() - start)
    return tuple(max(seconds - least[0], RESOLVED * seconds) / (BLOCKS * B) * 1e9 for seconds in least[1:])
