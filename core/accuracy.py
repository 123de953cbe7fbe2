"""How far a camera model is from the traced lens, in the picture; and the simplest model that will do.

A point of the scene is imaged as a blur: where its middle lies, how wide it is along the radius and across it, and
how bright it is are what a model can get wrong. For some film radii and distances of the scene, rays of the model
and of the lens through the solved exit-pupil regions (with Gauss's nodes along the radius of a region and even steps
around it) say where both see the scene; the difference, by the lens's own derivative with respect to the film point,
is in pixels of the film.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lensbench.blocktracer import tracer
from lensbench.cameras.camera import CameraError
from lensbench.cameras.gaussian import Gaussian
from lensbench.cameras.lens import LensCamera
from lensbench.driver import Program
from lensbench.glass import D_LINE
from lensbench.lanes import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.polynomial import DEGREES, Polynomial
from lensbench.prescription import LensError
from lensbench.pupil_table import PupilTable
from lensbench.scene import Scene

FIELDS = (0.0, 0.4, 0.7, 0.9, 1.0)          # film radii, of half the diagonal
TURNS, REACHES = 12, 4                      # rays of one region: around it, and from its centre to its rim
STEP = 1e-4                                 # of half the diagonal: for the derivative along the film
KEEP = 0.8                                  # of a tolerance: a simpler model must be this good to take over
STEEPEST = 0.2                              # cosine: beyond it a depth along the axis counts as a distance

NAMES = {"pinhole": "pinhole", "thin": "thin lens", "thick": "thick lens", "trace": "full trace"}


class Rung(NamedTuple):
    """One model of the ladder: its errors in pixels and stops, and which of them is the worst and where."""

    model: str
    degree: int                             # of the polynomial, otherwise 0
    error_px: float
    error_stops: float
    worst: str

    @property
    def name(self) -> str:
        """In words."""
        return f"polynomial of degree {self.degree}" if self.degree else NAMES[self.model]


class Choice(NamedTuple):
    """The simplest model within the tolerances, and what was looked at on the way: the ladder's rungs in order."""

    model: str
    degree: int
    error_px: float
    error_stops: float
    table: tuple[Rung, ...]

    @property
    def reason(self) -> str:
        """Why the next simpler model was refused; "" where there is none."""
        before = [rung for rung in self.table if (rung.model, rung.degree) != (self.model, self.degree)]
        return f"{before[-1].name}: {before[-1].worst}" if before else ""

    def applied(self, camera: LensCamera) -> LensCamera:
        """The camera with this model."""
        return replace(camera, model=self.model, degree=self.degree or camera.degree)


LADDER = (("pinhole", 0), ("thin", 0), ("thick", 0), *(("polynomial", degree) for degree in DEGREES), ("trace", 0))


def choose_model(camera: LensCamera, scene: Scene, tolerance_px: float = 0.5, tolerance_stops: float = 0.05,
                 previous: Choice | None = None) -> Choice:
    """The first model of the ladder whose picture of this scene is within the tolerances of the traced lens.

    For the camera's film, focus and aperture, and for the depths of the scene (`depth_range`). previous: the choice for
    settings just before; where it is still good, a simpler model takes over only when it is well within the tolerances,
    so that the choice does not flicker. A lens without rotational symmetry, or with blades, is traced. CameraError for
    tolerances that are not positive.
    """
    if not (tolerance_px > 0.0 and tolerance_stops > 0.0):
        raise CameraError("tolerances must be positive: pixels, and stops")
    judge = Judge(camera, scene.depth_range)
    held = -1 if previous is None else LADDER.index((previous.model, previous.degree))
    table = []
    for place, (model, degree) in enumerate(LADDER):
        rung = judge.rung(model, degree)
        table.append(rung)
        share = KEEP if place < held else 1.0
        if rung.error_px <= share * tolerance_px and rung.error_stops <= share * tolerance_stops:
            break
    return Choice(rung.model, rung.degree, rung.error_px, rung.error_stops, tuple(table))


@dataclass(frozen=True, eq=False)
class Judge:
    """The traced lens's blurs, against which models are held.

    camera: a LensCamera of any model; depths: nearest and farthest of the scene, mm from the film along the axis.
    """

    camera: LensCamera
    depths: tuple[float, float]

    def rung(self, model: str, degree: int = 0) -> Rung:
        """The errors of a model."""
        if model == "trace":
            return Rung(model, 0, 0.0, 0.0, "")
        if not self.camera.lens.is_rotationally_symmetric or not self.camera.lens.iris.is_round:
            return Rung(model, degree, math.inf, math.inf, "the lens has a cylinder, or its stop has blades")
        try:
            if model == "polynomial":
                fit = Polynomial.fit(self.camera.lens, self.camera.film_distance, self.table, degree,
                                     distance=self.camera.focus_distance)
                lines = Program([fit.step], np.float64).run(self._given, [X, Y, Z, L, M, N], self._aims.shape[1])
                weights = self._weights
            else:
                lines, weights = self._ideal(replace(self.camera, model=model).gaussian)
        except (CameraError, LensError) as error:
            return Rung(model, degree, math.inf, math.inf, str(error))
        return self._compared(model, degree, lines, weights)

    @cached_property
    def table(self) -> PupilTable:
        """The exit-pupil regions, of their own size."""
        return PupilTable.of(self.camera.lens, self.camera.film_distance, self.camera.film.diagonal / 2.0, D_LINE,
                             widened=False)

    @cached_property
    def _radii(self) -> np.ndarray:
        """Of the film points that are judged, mm; only those that the lens lights."""
        radii = np.array(FIELDS) * self.camera.film.diagonal / 2.0
        return radii[radii <= min(self.table.radius, self.table.dark_beyond)]

    @property
    def _is_dark(self) -> bool:
        """Whether the film's corners are beyond what the lens lights."""
        return len(self._radii) < len(FIELDS)

    @cached_property
    def _nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of one region: turn 0 … 1 around the upper half, the share of the area within, and weights of the rays."""
        node, weight = np.polynomial.legendre.leggauss(REACHES)
        turn, area = np.meshgrid((np.arange(TURNS) + 0.5) / TURNS, 0.5 * (node + 1.0), indexing="ij")
        return turn.ravel(), area.ravel(), np.tile(0.5 * weight / TURNS, TURNS)

    @cached_property
    def _film(self) -> np.ndarray:
        """(fields, 3) x of the film points: each, a little outwards and a little inwards, for the derivative."""
        step = STEP * self.camera.film.diagonal / 2.0
        return self._radii[:, None] + [0.0, step, -step]

    @cached_property
    def _aims(self) -> np.ndarray:
        """(5, rays) film x, direction and weight of every ray of the lens: those of the regions, then the middles."""
        turn, area, _ = self._nodes
        rays = len(turn)
        film = np.concatenate([np.repeat(self._radii, rays), self._film.ravel()])
        u = np.concatenate([np.tile(turn * 0.5, len(self._radii)), np.zeros(self._film.size)])
        v = np.concatenate([np.tile(area, len(self._radii)), np.zeros(self._film.size)])
        given = {X: np.abs(film), U0: u, U1: v}
        out = Program([self.table.step(1.0)], np.float64).run(given, [L, M, N, WEIGHT], len(film))
        out[0] *= np.where(film < 0.0, -1.0, 1.0)
        return np.stack([film, *out])

    @property
    def _given(self) -> dict[int, np.ndarray]:
        film, l, m, n, weight = self._aims
        return {X: film, L: l, M: m, N: n, WEIGHT: weight}

    @cached_property
    def _lines(self) -> np.ndarray:
        """(6, rays) the rays of the lens in front of it, camera frame."""
        lens = tracer(self.camera.lens, self.camera.film_distance)
        return Program([lens], np.float64).run(self._given, [X, Y, Z, L, M, N], self._aims.shape[1])

    @cached_property
    def _weights(self) -> np.ndarray:
        """(fields, rays) of the lens's light."""
        _, _, share = self._nodes
        return self._aims[4, :len(self._radii) * len(share)].reshape(len(self._radii), -1) * share

    def _ideal(self, lens: Gaussian) -> tuple[np.ndarray, np.ndarray]:
        """Rays of an ideal lens by like nodes of its disk, and its middles, and their weights."""
        turn, area, share = self._nodes
        a = np.sqrt(area) * np.cos(math.pi * turn)
        b = np.sqrt(area) * np.sin(math.pi * turn)
        fields = len(self._radii)
        film = np.concatenate([np.repeat(self._radii, len(turn)), self._film.ravel()])
        a, b = (np.concatenate([np.tile(q, fields), np.zeros(self._film.size)]) for q in (a, b))
        dx, dy = film * lens.slope_film + a * lens.slope_pupil, b * lens.slope_pupil
        size = 1.0 / np.sqrt(dx * dx + dy * dy + 1.0)
        lines = np.stack([film * lens.origin_film + a * lens.origin_pupil, b * lens.origin_pupil,
                          np.full(len(film), lens.z), dx * size, dy * size, -size])
        ex, ey = film * lens.approach_film + a * lens.approach_pupil, b * lens.approach_pupil
        cos4 = 1.0 / (ex * ex + ey * ey + 1.0) ** 2
        return lines, cos4[:fields * len(turn)].reshape(fields, -1) * share

    def _seen(self, lines: np.ndarray, distance: np.ndarray) -> np.ndarray:
        """(3, …) where rays lead at distances from the entrance pupil, as directions from there."""
        eye = self._eye
        away = lines[:3] - np.array([0.0, 0.0, eye])[:, None]
        foot = away - (away * lines[3:]).sum(0) * lines[3:]
        return lines[3:] + foot / distance

    @cached_property
    def _eye(self) -> float:
        """Z of the entrance pupil in the camera frame, or of the first vertex where that lies far away."""
        camera, z = self.camera, self.camera.first_order.entrance_pupil.z
        return (z if abs(z) < 20.0 * camera.lens.length else 0.0) - camera.lens.length - camera.film_distance

    def _compared(self, model: str, degree: int, lines: np.ndarray, weights: np.ndarray) -> Rung:
        fields, rays = self._weights.shape
        many = fields * rays
        radii, pitch = self._radii, self.camera.film.pitch
        worst_px, worst_stops, said, said_stops = 0.0, 0.0, "", ""
        middles = self._lines[:, many:].reshape(6, fields, 3)
        for depth in self._depths:
            # The distance along each field's middle ray to the plane of this depth
            cosine = np.maximum(-middles[5, :, 0], STEEPEST)
            away = (depth + self._eye) / cosine
            true, seen = (self._seen(each[:, :many], np.repeat(away, rays)).reshape(3, fields, rays)
                          for each in (self._lines, lines))
            middle = self._seen(self._lines[:, many:], np.repeat(away, 3)).reshape(3, fields, 3)
            # What a pixel is there: along the radius by the derivative, across it by the turn about the axis
            along = (middle[:, :, 1] - middle[:, :, 2]) / (2.0 * STEP * self.camera.film.diagonal / 2.0)
            per_mm = np.sqrt((along**2).sum(0))
            across = np.where(radii > 0.0, np.abs(middle[0, :, 0]) / np.maximum(radii, 1e-30), per_mm)
            place = [((each * along[:, :, None]).sum(0) / (per_mm**2)[:, None], each[1] / across[:, None])
                     for each in (true, seen)]
            (true_mean, true_size), (mean, size) = (
                _moments(*at, weight) for at, weight in zip(place, (self._weights, weights), strict=True))
            shift = np.abs(mean - true_mean) / pitch
            spread = np.sqrt(((size - true_size) ** 2).sum(0)) / pitch
            for what, error in (("distortion", shift), ("blur off by", spread)):
                i = int(np.argmax(error))
                if not error[i] <= worst_px:
                    worst_px = float(error[i])
                    said = f"{what} {error[i]:.2g} px {_place(radii[i], self.camera)}"
        light, true_light = weights.sum(1), self._weights.sum(1)
        stops = np.abs(np.log2(light / light[0] * true_light[0] / true_light))
        worst_stops = float(stops.max())
        said_stops = f"brightness off by {worst_stops:.2g} stops {_place(radii[int(np.argmax(stops))], self.camera)}"
        if self._is_dark and model != "polynomial":
            worst_stops, said_stops = math.inf, "the film's corners are dark, and this model lights them"
        if math.isnan(worst_px):
            worst_px, said = math.inf, "some rays are lost"
        return Rung(model, degree, worst_px, worst_stops, said if worst_px > 10.0 * worst_stops else said_stops)

    @cached_property
    def _depths(self) -> tuple[float, ...]:
        """Nearest and farthest of the scene, and the plane in focus where it lies between."""
        near, far = max(self.depths[0], 1.01 * -self._eye), self.depths[1]
        focus = self.camera.focus_distance
        return (near, focus, far) if near < focus < far else (near, far)


def _moments(x: np.ndarray, y: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of blurs (fields, rays), symmetric across the radius: middles along it (fields,), 2 σ of both (2, fields)."""
    total = weights.sum(1)
    middle = (x * weights).sum(1) / total
    along = ((x - middle[:, None]) ** 2 * weights).sum(1) / total
    return middle, 2.0 * np.sqrt(np.stack([along, (y**2 * weights).sum(1) / total]))


def _place(radius: float, camera: LensCamera) -> str:
    part = radius / (camera.film.diagonal / 2.0)
    return "on the axis" if part == 0.0 else "at the corner" if part > 0.99 else f"at {part:.1f} of the field"
