"""Beams of fields: chief rays, the frames that rays are given in, and their traces to the scene and to the film.

Lengths in mm, lens frame. See `traced_grid` for the reference point, the axes and the pupil coordinates of a field.
"""

from dataclasses import dataclass, field
from math import inf, isinf, nan, sqrt

import numpy as np

from lensbench.core.analysis.grids.chief_rays import ChiefRays, find_chief_rays, pupil_distances
from lensbench.core.kernels.block import CLEARANCE, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import PATH, STOP_SHARE, VICTIM, path_steps, surface_steps, trace_steps
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens

SLOPE_STEP = 1e-5       # direction cosine, for the image of the stop

_GIVEN = (X, Y, Z, L, M, N, WEIGHT, PATH)
_WANTED = (X, Y, Z, L, M, N, CLEARANCE, PATH, VICTIM, STOP_SHARE)
(OFFSET_S, OFFSET_T, SLOPE_S, SLOPE_T, PUPIL_S, PUPIL_T, OPD,     # as in RayGrid
 SHARE,                                 # squared distance from the axis in the stop over that of its rim
 LEVEL,                                 # greatest share of a rim at which the ray meets a surface; NaN for a lost ray
 ) = range(9)
LANDED = 9


@dataclass(frozen=True, eq=False)
class FieldBeams:
    """The fields of a grid: their chief rays in the primary wavelength, and the frames that rays are given in.

    A ray of the object is given by its place: two coordinates (mm) across the beam, on the plane through `middles` and
    perpendicular to the chief ray. The plane lies in the entrance pupil of the field. A ray from the reference point
    that aberrations turn away from the chief ray's direction has its place in the pupil there, and not far before it.
    sources: (F, 2) as `find_chief_rays` takes them, angle vectors or points of the object.
    """

    lens: Lens
    film_distance: float
    chief: ChiefRays
    object_distance: float
    wavelength: float
    axes: np.ndarray
    middles: np.ndarray         # (F, 3) points of the chief rays, from which the places count
    frames: np.ndarray          # (F, 2, 3) axes of the places
    sources: np.ndarray
    chief_pupil: np.ndarray     # (F, 2)
    stop_slopes: np.ndarray     # (F, 2, 2) of the point on the stop, in its radii, by pupil coordinates
    backward: Program           # from the film to the scene
    to_stop: Program            # from the film to the stop
    sphere_curvatures: np.ndarray       # (F,) 1 / radius of the reference sphere, 1/mm
    colours: dict[float, ChiefRays] = field(default_factory=dict)       # chief rays of other wavelengths
    programs: dict[float, Program] = field(default_factory=dict)        # of the wavelengths, from the scene to the film

    @classmethod
    def of(cls, lens: Lens, film_distance: float, chief: ChiefRays, object_distance: float,
           wavelength: float) -> "FieldBeams":
        """The frames of these chief rays."""
        radius = np.hypot(chief.images[:, 0], chief.images[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            outward = np.where((radius > 1e-12)[:, None], chief.images / radius[:, None], [0.0, 1.0])
        axes = np.stack([np.column_stack([outward[:, 1], -outward[:, 0]]), outward], 1)

        # The rotation that takes +z to the chief ray takes x and y to the frame
        l, m, n = chief.directions.T
        with np.errstate(divide="ignore", invalid="ignore"):
            turn = np.where(1.0 + n > 1e-9, 1.0 / (1.0 + n), 0.0)
        frames = np.stack([np.stack([1.0 - l * l * turn, -l * m * turn, -l], 1),
                           np.stack([-l * m * turn, 1.0 - m * m * turn, -m], 1)], 1)
        if isinf(object_distance):
            sources = chief.angles
        else:
            away = (-object_distance - chief.points[:, 2]) / chief.directions[:, 2]
            sources = chief.points[:, :2] + away[:, None] * chief.directions[:, :2]
        chief_pupil = np.einsum("fk,fak->fa", chief.image_directions[:, :2], axes)
        pupil_z, film_z = first_order(lens, wavelength).exit_pupil.z, lens.length + film_distance
        gap = film_z - pupil_z
        curvatures = chief.image_directions[:, 2] * (1.0 / gap if gap and not isinf(gap) else 0.0)
        backward = Program(trace_steps(lens, film_distance, wavelength), np.float64)
        behind = slice(0, len(lens.surfaces) - lens.stop_index)
        to_stop = Program(surface_steps(lens, film_distance, wavelength, which=behind), np.float64)
        middles = chief.points + pupil_distances(lens, film_distance, chief, wavelength)[:, None] * chief.directions
        if not isinf(object_distance):          # at least half-way from the object to the first surface
            point = np.column_stack([sources, np.full(len(sources), -object_distance)])
            first, far = chief.points - point, middles - point
            near = (far * chief.directions).sum(1) < 0.5 * (first * chief.directions).sum(1)
            middles = np.where(near[:, None], chief.points, middles)
        made = cls(lens, film_distance, chief, object_distance, wavelength, axes, middles, frames, sources, chief_pupil,
                   np.zeros((len(axes), 2, 2)), backward, to_stop, np.nan_to_num(curvatures))
        object.__setattr__(made, "stop_slopes", made._stop_slopes())
        return made

    def forward(self, wavelength: float, of_field: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rays of the object in one wavelength (µm), of fields (n,); starts: (8, n), from the method of that name.

        Returns the rows (9, n) of LANDED, and the surface (n,) that ends each, −1 for one that passes. The chief rays
        of this wavelength have the path difference 0.
        """
        count, n = len(self.axes), len(of_field)
        own = self.chief_of(wavelength)
        places = self.across(own.points.T[:, :, None], own.directions.T[:, :, None])[:, 0]
        rays = np.concatenate([starts, self.starts(np.arange(count), places)], 1)
        out = self.forward_program(wavelength).run(dict(zip(_GIVEN, rays, strict=True)), _WANTED, n + count)
        values, victim = np.empty((LANDED, n)), np.empty(n, np.int16)
        _finish(out, of_field, self.chief.images, self.axes, self.sphere_curvatures, values, victim)
        return values, victim

    def forward_program(self, wavelength: float) -> Program:
        """The steps of `forward` for a wavelength (µm)."""
        if wavelength not in self.programs:
            self.programs[wavelength] = Program(path_steps(self.lens, self.film_distance, wavelength), np.float64)
        return self.programs[wavelength]

    def chief_of(self, wavelength: float) -> ChiefRays:
        """The chief rays of the same object points in another wavelength (µm)."""
        if wavelength == self.wavelength:
            return self.chief
        if wavelength in self.colours:
            return self.colours[wavelength]
        self.colours[wavelength] = find_chief_rays(self.lens, self.film_distance, self.sources, self.object_distance,
                                                   False, wavelength, near=self.chief.at_stop)
        return self.colours[wavelength]

    @property
    def mirrored(self) -> bool:
        """Whether the sagittal half of each beam is the mirror image of the other.

        So it is in a lens of rotational symmetry, unless the blades of its stop are not symmetrical in the meridian.
        """
        iris = self.lens.iris
        return self.lens.is_rotationally_symmetric and (
            iris.is_round or (iris.is_mirrored and bool((self.axes[:, 1, 0] == 0.0).all())))

    def mirror(self, places: np.ndarray) -> np.ndarray:
        """Places (F, …, 2) on the other side of the meridians."""
        shape = (len(self.axes),) + (1,) * (places.ndim - 2)
        x, y = (self.axes[:, 0, k].reshape(shape) for k in (0, 1))
        twice = 2.0 * (places[..., 0] * x + places[..., 1] * y)
        return np.stack([places[..., 0] - twice * x, places[..., 1] - twice * y], -1)

    def grid_towards_scene(self, s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`towards_scene` of grids (F, N, N) that are symmetrical about the meridian where the beams are."""
        if not self.mirrored:
            return self.towards_scene(s, t)
        columns = s.shape[2]
        half, both = slice(columns // 2, None), slice(columns % 2, None)
        places, level = self.towards_scene(np.ascontiguousarray(s[:, :, half]), np.ascontiguousarray(t[:, :, half]))
        return (np.concatenate([self.mirror(places[:, :, both])[:, :, ::-1], places], 2),
                np.concatenate([level[:, :, both][:, :, ::-1], level], 2))

    @property
    def beyond_the_plane(self) -> np.ndarray:
        """(F,) whether the chief ray comes from 90° or beyond, where a plane at a finite distance has no point."""
        return np.asarray((self.chief.directions[:, 2] <= 0.0) & (not isinf(self.object_distance)))

    @property
    def reaches(self) -> np.ndarray:
        """(F,) distance from the object points to `middles`, mm; inf at infinity."""
        if isinf(self.object_distance):
            return np.full(len(self.axes), inf)
        points = np.column_stack([self.sources, np.full(len(self.sources), -self.object_distance)])
        return np.asarray(np.linalg.norm(self.middles - points, axis=1))

    def on_axes(self, vectors: np.ndarray) -> np.ndarray:
        """Components (F, 2) of film vectors (F, 2) along the sagittal and the tangential axis."""
        return np.einsum("fk,fak->fa", vectors, self.axes)

    def across(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Places (F, n, 2) of rays given by points and directions (3, F, n) in the lens frame."""
        out = np.empty((*points.shape[1:], 2))
        _across(points, directions, self.middles, self.chief.directions, self.frames, out)
        return out

    def starts(self, of_field: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Rows (8, n) of `_GIVEN` of the object's rays of fields (n,) at places (n, 2); 0 for a place that is NaN."""
        out = np.zeros((len(_GIVEN), len(of_field)))
        _start(of_field, places, self.middles, self.chief.directions, self.frames, self.reaches, self.lens.front_index,
               self.lens.length + self.film_distance, out)
        return out

    def towards_scene(self, s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rays from the reference points with pupil coordinates s and t (F, …), backwards to the scene.

        Returns their places (F, …, 2), NaN where s and t are no direction, and the greatest share (F, …) of a rim at
        which they meet a surface; inf for rays that do not come through.
        """
        inputs, dark = self._from_film(s, t)
        x, y, z, l, m, n, clearance = self.backward.run(inputs, [X, Y, Z, L, M, N, CLEARANCE], s.size).reshape(
            7, *s.shape)
        flat = len(self.axes), -1
        points = np.stack([x.reshape(flat), y.reshape(flat), z.reshape(flat) + self.lens.length + self.film_distance])
        places = self.across(points, np.stack([l.reshape(flat), m.reshape(flat), n.reshape(flat)]))
        places = places.reshape(*s.shape, 2)
        places[dark] = nan
        with np.errstate(invalid="ignore"):
            level = np.sqrt(clearance)
        return places, np.where(np.isnan(level) | dark, inf, level)

    def _from_film(self, s: np.ndarray, t: np.ndarray) -> tuple[dict[int, np.ndarray], np.ndarray]:
        """The given rows of rays from the reference points, and (F, …) which of them are none."""
        shape = (len(self.axes),) + (1,) * (s.ndim - 1)
        (sx, sy), (tx, ty) = (self.axes[:, a].T.reshape(2, *shape) for a in (0, 1))
        l, m = s * sx + t * tx, s * sy + t * ty
        square = 1.0 - l * l - m * m
        dark = ~(square > 1e-9)
        x, y = (np.broadcast_to(values.reshape(shape), s.shape) for values in self.chief.images.T)
        rows = {X: x, Y: y, L: -l, M: -m, N: -np.sqrt(np.where(dark, 1.0, square)), WEIGHT: np.ones(s.shape)}
        return {row: np.where(dark, 0.0 if row != N else -1.0, values).ravel() for row, values in rows.items()}, dark

    def _stop_slopes(self) -> np.ndarray:
        """(F, 2, 2) the derivative of the point on the stop, in its radii, by the pupil coordinates."""
        s = self.chief_pupil[:, :1] + [SLOPE_STEP, -SLOPE_STEP, 0.0, 0.0]
        t = self.chief_pupil[:, 1:] + [0.0, 0.0, SLOPE_STEP, -SLOPE_STEP]
        points = self.on_stop(s, t)
        change = np.stack([points[..., 0] - points[..., 1], points[..., 2] - points[..., 3]], -1)
        return change.transpose(1, 0, 2) / (2.0 * SLOPE_STEP)

    def on_stop(self, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(2, F, …) x and y on the stop, in its radii, of rays from the reference points; NaN for lost rays."""
        inputs, dark = self._from_film(s, t)
        points = self.to_stop.run(inputs, [X, Y, Z], s.size).T + [0.0, 0.0, self.lens.length + self.film_distance]
        points = self.lens.in_frame_of(self.lens.stop_index, points)[:, :2].T.reshape(2, *s.shape)
        points = points / self.lens.stop.semi_diameter
        return np.where(dark, nan, points)

    def linear_stop_share(self, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(F, …) distance from the stop's centre over its radius, to first order about the chief ray."""
        shape = (len(self.axes),) + (1,) * (s.ndim - 1)
        ds, dt = (pupil - chief.reshape(shape) for pupil, chief in zip((s, t), self.chief_pupil.T, strict=True))
        (a, b), (c, d) = (self.stop_slopes[:, i].T.reshape(2, *shape) for i in (0, 1))
        return np.hypot(a * ds + b * dt, c * ds + d * dt)

    def only(self, which: np.ndarray) -> "FieldBeams":
        """These fields alone."""
        chief = ChiefRays(*(getattr(self.chief, name)[which] for name in
                            ("at_stop", "points", "directions", "images", "image_directions")))
        return FieldBeams(self.lens, self.film_distance, chief, self.object_distance, self.wavelength, self.axes[which],
                          self.middles[which], self.frames[which], self.sources[which], self.chief_pupil[which],
                          self.stop_slopes[which], self.backward, self.to_stop, self.sphere_curvatures[which])


@njit(cache=True, nogil=True, error_model="numpy")
def _across(points, directions, middles, axes, frames, out):
    """Places (F, n, 2) of rays (3, F, n) on the planes through `middles`, perpendicular to `axes`, both (F, 3)."""
    for f in range(points.shape[1]):
        for i in range(points.shape[2]):
            x, y, z = points[0, f, i] - middles[f, 0], points[1, f, i] - middles[f, 1], points[2, f, i] - middles[f, 2]
            l, m, n = directions[0, f, i], directions[1, f, i], directions[2, f, i]
            u, v, w = axes[f, 0], axes[f, 1], axes[f, 2]
            away = -(x * u + y * v + z * w) / (l * u + m * v + n * w)
            x, y, z = x + away * l, y + away * m, z + away * n
            for a in range(2):
                out[f, i, a] = x * frames[f, a, 0] + y * frames[f, a, 1] + z * frames[f, a, 2]


@njit(cache=True, nogil=True, error_model="numpy")
def _start(of_field, places, middles, axes, frames, reach, index, film_z, out):
    """Rows of `_GIVEN` (8, n) of rays of fields (n,) at places (n, 2); reach (F,): `reaches`."""
    for i in range(of_field.size):
        f = of_field[i]
        s, t = places[i, 0], places[i, 1]
        out[6, i] = 1.0
        if not abs(s) + abs(t) < np.inf:
            continue
        x = s * frames[f, 0, 0] + t * frames[f, 1, 0]
        y = s * frames[f, 0, 1] + t * frames[f, 1, 1]
        z = s * frames[f, 0, 2] + t * frames[f, 1, 2]
        out[0, i], out[1, i], out[2, i] = middles[f, 0] + x, middles[f, 1] + y, middles[f, 2] + z - film_z
        if reach[f] == np.inf:
            out[3, i], out[4, i], out[5, i] = axes[f, 0], axes[f, 1], axes[f, 2]
            continue
        across2 = s * s + t * t
        far = sqrt(reach[f] * reach[f] + across2)
        out[3, i] = (x + reach[f] * axes[f, 0]) / far
        out[4, i] = (y + reach[f] * axes[f, 1]) / far
        out[5, i] = (z + reach[f] * axes[f, 2]) / far
        out[7, i] = index * across2 / (far + reach[f])


@njit(cache=True, nogil=True, error_model="numpy")
def _finish(out, of_field, images, axes, curvatures, values, victim):
    """Rays behind the last surface, rows of `_WANTED`, to the film and the reference sphere.

    The first n of them give values (9, n) and victim (n,); then follow the chief rays of the fields.
    """
    n, fields = of_field.size, images.shape[0]
    reference = np.empty(fields)
    for i in range(n + fields):
        lane = n + i if i < fields else i - fields      # the chief rays first
        f = i if i < fields else of_field[lane]
        l, m, cosine = out[3, lane], out[4, lane], out[5, lane]
        away = -out[2, lane] / cosine
        ex, ey = out[0, lane] + away * l - images[f, 0], out[1, lane] + away * m - images[f, 1]
        along = ex * l + ey * m
        off2, kappa = ex * ex + ey * ey - along * along, curvatures[f]
        back = along - off2 * kappa / (1.0 + sqrt(1.0 - kappa * kappa * off2))
        path = out[7, lane] + away - back               # to the sphere, plus its radius
        if i < fields:
            reference[f] = path
            continue
        sx, sy, tx, ty = axes[f, 0, 0], axes[f, 0, 1], axes[f, 1, 0], axes[f, 1, 1]
        px, py = l * (1.0 + kappa * back) - ex * kappa, m * (1.0 + kappa * back) - ey * kappa
        values[OFFSET_S, lane], values[OFFSET_T, lane] = ex * sx + ey * sy, ex * tx + ey * ty
        values[SLOPE_S, lane], values[SLOPE_T, lane] = (l * sx + m * sy) / cosine, (l * tx + m * ty) / cosine
        values[PUPIL_S, lane], values[PUPIL_T, lane] = px * sx + py * sy, px * tx + py * ty
        values[OPD, lane] = reference[f] - path
        values[SHARE, lane] = out[9, lane]
        values[LEVEL, lane] = sqrt(out[6, lane])
        victim[lane] = np.int16(out[8, lane])
