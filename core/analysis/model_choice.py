"""Model choice: the simplest camera model whose picture errors lie below tolerances, in pixels and stops.

Models are ordered by a fixed ladder, from the pinhole to the full trace, and not by timings, so that the
choice is the same on every machine. `model_error` computes the errors of each rung.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from time import perf_counter

import numpy as np

from lensbench.core.analysis.model_error import ModelErrors, Rung
from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.rays import CameraError
from lensbench.core.cameras.real_lens import LensCamera
from lensbench.core.kernels.block import B, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.lens_models.polynomial import DEGREES
from lensbench.core.scenery.scene import Scene

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
