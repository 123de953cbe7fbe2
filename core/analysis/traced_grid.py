"""The ray grid: every ray of an analysis, traced once for fields × wavelengths × points of the exit pupil.

Lengths in mm, lens frame; light runs from the scene to the film. Each field has a *reference point*: where the chief
ray of the primary wavelength meets the film. Places on the film are given from there along two axes: *tangential*, away
from the film's centre, and *sagittal*, across it (of a field above the centre: +y and +x).

The pupil coordinates of a ray are the direction cosines from its point on the reference sphere to the reference point,
sagittal and tangential. The reference sphere is centred on the reference point and passes the exit pupil on the chief
ray; it is a plane for an exit pupil at infinity. In these coordinates a diffraction pattern is a plain Fourier
transform, and an area is the light that the film receives.

The optical path difference W is positive where the ray's path to the reference sphere is shorter than the chief ray's,
as Welford has it. A ray lands at ∂W / ∂p from the reference point, p its pupil coordinates.

The grid of each field covers the region that the rims leave open, found by rays from the reference point back to
the scene. These rays also say where the rays of the object must start, so that the latter, traced forward in
every wavelength, fill the exit pupil evenly.

References
----------
Welford, "Aberrations of Optical Systems", ch. 7: reference sphere and wavefront aberration.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, isinf, nan, sqrt

import numpy as np

from lensbench.analysis.chief_rays import ChiefRays, find_chief_rays
from lensbench.analysis.field_conditions import Conditions, wanted_chief_rays
from lensbench.kernels.block import CLEARANCE, WEIGHT, L, M, N, X, Y, Z
from lensbench.kernels.cache import njit
from lensbench.kernels.figures import significant
from lensbench.kernels.program import Program
from lensbench.optics.block_trace import surface_steps, trace_steps
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.paraxial import first_order
from lensbench.optics.path_trace import PATH, STOP_SHARE, VICTIM, path_steps
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.system import FieldKind

PUPIL = 32              # grid points across the pupil of a field: about 800 rays
COARSE = 20             # points across the scan that finds the open region
MARGIN = 1.25           # × the image of the stop, that the first scan covers
WIDER = 1.6             # × its extent, where the region reaches its edge
SCANS = 4
BEYOND = 4.0            # cells beyond the rims, of which rays are traced too: half of them
SLOPE_STEP = 1e-5       # direction cosine, for the image of the stop
THREADS = 2


@dataclass(frozen=True, eq=False)
class RayGrid:
    """Rays of one lens state, from `ray_grid`. F fields, C wavelengths, N × N points of the exit pupil.

    In arrays (F, C, N, N) the last axis is sagittal and the one before it tangential. They are NaN where no ray comes
    through, and filled for rays just beyond a rim, which `coverage` excludes.

    Parameters
    ----------
    lens, film_distance, conditions
        As given; film_distance in mm from the last vertex.
    angles
        (F, 2) angle from the axis of the chief ray's light in the scene, as a vector (rad).
    images
        (F, 2) reference points, x and y on the film, mm; NaN for a field without a chief ray.
    axes
        (F, 2, 2) unit vectors (x, y): the sagittal and the tangential axis.
    chief
        (F, C, 2) where the chief ray of each wavelength meets the film, sagittal and tangential, mm from the reference
        point.
    chief_pupil
        (F, 2) pupil coordinates of the primary chief ray.
    pupil
        (F, 2, N) pupil coordinates of the grid's columns (sagittal) and rows (tangential), evenly spaced.
    offset_s, offset_t
        (F, C, N, N) where each ray meets the film, mm from the reference point.
    slope_s, slope_t
        (F, C, N, N) change of these with the film's place, mm per mm along +z.
    pupil_s, pupil_t
        (F, C, N, N) pupil coordinates of each ray; close to those of its column and row.
    opd
        (F, C, N, N) optical path difference W, mm.
    weight
        (F, C, N, N) light of each ray, of mean 1 over the rays of a field that carry some: the part of its cell of the
        beam that the rims leave open, times the cell's area.
    open_centre
        (2, F, C, N, N) centroid of the open part of each ray's cell, from its middle, in cells: sagittal, tangential.
    coverage
        (F, C, N, N) the part of each cell of the exit pupil that the rims leave open, 0 to 1.
    intensity
        (F, N, N) light of an evenly lit beam per area of the exit pupil, of mean 1 over the open cells.
    victim
        (F, C, N, N) index of the surface that ends the ray, −1 for a ray that passes, −2 for one that is not traced:
        it lies far outside the rims.
    stop_share
        (F, C, N, N) squared distance from the axis in the stop over that of the stop's rim; NaN as the others.
    open_area
        (F,) area of the open region that the reference point sees, in pupil coordinates: the irradiance of the film
        under a scene of radiance 1; 0 for a dark field.
    sphere_curvatures
        (F,) 1 / radius of the reference spheres, 1/mm; 0 for a plane.
    launched, lost
        (F, C) rays of the grid that meet the stop within its rim, and those of them that other surfaces end.
    findings
        Those of the conditions, and what the grid cannot show: dark fields and their reason.
    """

    lens: Lens
    film_distance: float
    conditions: Conditions
    angles: np.ndarray
    images: np.ndarray
    axes: np.ndarray
    chief: np.ndarray
    chief_pupil: np.ndarray
    pupil: np.ndarray
    offset_s: np.ndarray
    offset_t: np.ndarray
    slope_s: np.ndarray
    slope_t: np.ndarray
    pupil_s: np.ndarray
    pupil_t: np.ndarray
    opd: np.ndarray
    weight: np.ndarray
    open_centre: np.ndarray
    coverage: np.ndarray
    intensity: np.ndarray
    victim: np.ndarray
    stop_share: np.ndarray
    open_area: np.ndarray
    sphere_curvatures: np.ndarray
    launched: np.ndarray
    lost: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> np.ndarray:
        """(F, C, N, N) whether a ray passes all rims."""
        return self.victim == -1

    @property
    def lit(self) -> np.ndarray:
        """(F,) whether any light reaches a field in the primary wavelength."""
        return self.coverage[:, self.conditions.primary].any((1, 2))

    @cached_property
    def light(self) -> np.ndarray:
        """(4, F, C, N, N) offset_s, offset_t, slope_s and slope_t, for sums over the rays with `weight`.

        In a cell at a rim they are taken halfway from the ray to the centroid of the cell's open part. A sum then
        misses the integral by a term of the fourth order in the size of a cell: of the second order, the error of the
        rims, 1/24 of the integrand's slope across them, cancels that of the midpoint rule in all other cells.
        """
        arrays = (self.offset_s, self.offset_t, self.slope_s, self.slope_t)
        made = np.empty((4, *self.opd.shape))
        shape = (-1, *self.opd.shape[2:])
        for array, out in zip(arrays, made, strict=True):
            _towards_centroids(array.reshape(shape), self.weight.reshape(shape), self.open_centre.reshape(2, *shape),
                          out.reshape(shape))
        return made

    @property
    def steps(self) -> np.ndarray:
        """(F, 2) spacing of the grid in pupil coordinates, sagittal and tangential; NaN for a dark field."""
        return self.pupil[:, :, 1] - self.pupil[:, :, 0]

    @property
    def image_heights(self) -> np.ndarray:
        """(F,) distance of the reference points from the film's centre, mm."""
        return np.hypot(self.images[:, 0], self.images[:, 1])

    @property
    def field_angles(self) -> np.ndarray:
        """(F,) angle of the fields from the axis in the scene, rad."""
        return np.hypot(self.angles[:, 0], self.angles[:, 1])

    @cached_property
    def grid_opd(self) -> np.ndarray:
        """(F, C, N, N) W at the exact points of the grid, mm.

        A ray's own pupil coordinates differ a little from its cell's; its offset is the slope of W between them.
        """
        return (self.opd + self.offset_s * (self.pupil[:, 0][:, None, None, :] - self.pupil_s)
                + self.offset_t * (self.pupil[:, 1][:, None, :, None] - self.pupil_t))


@lru_cache(maxsize=16)
def ray_grid(lens: Lens, film_distance: float, conditions: Conditions, pupil: int = PUPIL) -> RayGrid:
    """The rays of an analysis; kept for the last sixteen lens states.

    Parameters
    ----------
    lens : Lens
        The lens, stopped down and focused.
    film_distance : float
        Last vertex → film, mm.
    conditions : Conditions
        Fields, wavelengths and object distance.
    pupil : int
        Points of the grid across the pupil of each field, at least 8. 32 suits spots and a picture that moves; 64
        and 128 suit fine diffraction figures.

    Returns
    -------
    RayGrid

    Raises
    ------
    LensError
        For a film that is not behind the lens or not in air, for an afocal lens, for fewer than 8 points, and where
        no light of any field reaches the film.
    """
    if not 0.0 < film_distance < inf:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    if pupil < 8:
        raise LensError(f"{pupil} points across the pupil: at least 8 are needed")
    if lens.indices()[-1] != 1.0:
        raise LensError("this lens ends in glass: its film must be in air")
    line = conditions.primary_wavelength
    if isinf(first_order(lens, line).efl) and isinf(conditions.object_distance):
        raise LensError("an afocal lens forms no image of a far object: give the object a finite distance, or add a "
                        "lens that focuses")

    # The chief rays, and from them the axes of each field
    wanted, by_image = wanted_chief_rays(lens, conditions)
    distance = conditions.object_distance
    chief = find_chief_rays(lens, film_distance, wanted, distance, by_image, line)
    fields = _Fields.of(lens, film_distance, chief, distance, line)

    # The open region of the exit pupil, and where its rays leave for the scene
    boxes, findings = fields.open_boxes(conditions)
    share = (np.arange(pupil) + 0.5) / pupil
    grid = boxes[..., :1] + share * (boxes[..., 1:] - boxes[..., :1])
    s, t = (np.ascontiguousarray(np.broadcast_to(each, (len(grid), pupil, pupil)))
            for each in (grid[:, 0, None, :], grid[:, 1, :, None]))
    places, level = fields.towards_scene(s, t)
    open_cells = np.zeros(level.shape)
    unused = np.empty((2, *level.shape))
    _cover(level, s, t, grid, open_cells, unused)
    beam = fields.beam_areas(places)
    near = (level <= 1.0 + BEYOND / pupil) | (fields.linear_stop_share(s, t) <= 1.0)
    keep = np.flatnonzero((near & np.isfinite(places).all(-1)).ravel())
    of_field = keep // pupil**2
    starts = fields.starts(of_field, places.reshape(-1, 2)[keep])

    # The rays of the object, forward in each wavelength; the last F of them are its chief rays
    count, colours = len(grid), conditions.wavelengths
    values = np.full((len(colours), _VALUES, count, pupil, pupil), nan)
    victim, coverage = np.full(values.shape[:1] + values.shape[2:], -2, np.int16), np.zeros_like(values[:, 0])
    weight, centre = np.zeros_like(coverage), np.zeros((2, *coverage.shape))
    chiefs = np.zeros((len(colours), count, 2))

    def trace_colour(c: int) -> None:
        """Fill the arrays of one wavelength."""
        own = chief if c == conditions.primary else find_chief_rays(
            lens, film_distance, fields.sources, distance, False, colours[c], near=chief.at_stop)
        chiefs[c] = fields.on_axes(own.images - chief.images)
        rays = [np.concatenate(pair) for pair in
                zip(starts, fields.starts(np.arange(count), fields.across(own.points, own.directions)), strict=True)]
        rays = [np.where(np.isfinite(rays[0]), each, 0.0) for each in rays]
        out = Program(path_steps(lens, film_distance, colours[c]), np.float64).run(
            dict(zip(_GIVEN, rays, strict=True)), _WANTED, keep.size + count)
        _finish(out, keep, of_field, chief.images, fields.axes, fields.sphere_curvatures,
                values[c].reshape(_VALUES, -1), victim[c].reshape(-1))
        _cover(values[c, _LEVEL], values[c, 4], values[c, 5], grid, coverage[c], unused)
        _cover(values[c, _LEVEL], s, t, grid, weight[c], centre[:, c])

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(trace_colour, range(len(colours))))
    weight = _of_mean_1(weight * beam, weight > 0.0)
    centre = np.ascontiguousarray(centre.transpose(0, 2, 1, 3, 4))
    victim, weight, coverage, chiefs = (np.ascontiguousarray(np.swapaxes(each, 0, 1))
                                        for each in (victim, weight, coverage, chiefs))
    arrays = np.ascontiguousarray(values.transpose(1, 2, 0, 3, 4))
    within = arrays[_SHARE] <= 1.0
    made = RayGrid(lens, film_distance, conditions, chief.angles, chief.images, fields.axes, chiefs, fields.chief_pupil,
                   grid, *arrays[:_SHARE], weight, centre, coverage,
                   _of_mean_1(beam, coverage[:, conditions.primary] > 0.0),
                   victim, arrays[_SHARE], _open_areas(open_cells, grid),
                   fields.sphere_curvatures, within.sum((2, 3)), (within & (victim >= 0)).sum((2, 3)),
                   (*conditions.findings, *findings))
    if not made.lit.any():
        raise LensError("no light of these fields reaches the film" + (f": {findings[-1]}" if findings else ""))
    return made


def _open_areas(open_cells: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """(F,) areas in pupil coordinates of the covered parts of the cells."""
    return open_cells.sum((1, 2)) * np.nan_to_num((grid[:, :, 1] - grid[:, :, 0]).prod(1))


@dataclass(frozen=True, eq=False)
class _Fields:
    """The fields of a grid: their chief rays in the primary wavelength, and the frames that rays are given in.

    A ray of the object is given by its place: two coordinates (mm) across the beam, on the plane through the chief
    ray's point on the first surface and perpendicular to the chief ray. sources: (F, 2) as `find_chief_rays` takes
    them, angle vectors or points of the object.
    """

    lens: Lens
    film_distance: float
    chief: ChiefRays
    object_distance: float
    wavelength: float
    axes: np.ndarray
    frames: np.ndarray          # (F, 2, 3) axes of the places
    sources: np.ndarray
    chief_pupil: np.ndarray     # (F, 2)
    stop_slopes: np.ndarray     # (F, 2, 2) of the point on the stop, in its radii, by pupil coordinates
    backward: Program           # from the film to the scene
    sphere_curvatures: np.ndarray       # (F,) 1 / radius of the reference sphere, 1/mm

    @classmethod
    def of(cls, lens: Lens, film_distance: float, chief: ChiefRays, object_distance: float,
           wavelength: float) -> "_Fields":
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
        backward = Program(trace_steps(lens, film_distance, wavelength, "scene"), np.float64)
        made = cls(lens, film_distance, chief, object_distance, wavelength, axes, frames, sources, chief_pupil,
                   np.zeros((len(axes), 2, 2)), backward, np.nan_to_num(curvatures))
        object.__setattr__(made, "stop_slopes", made._stop_slopes())
        return made

    def on_axes(self, vectors: np.ndarray) -> np.ndarray:
        """Components (F, 2) of film vectors (F, 2) along the sagittal and the tangential axis."""
        return np.einsum("fk,fak->fa", vectors, self.axes)

    def across(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Places (F, …, 2) of rays given by points and directions (F, …, 3) in the lens frame."""
        shape = (len(self.axes),) + (1,) * (points.ndim - 2)
        u = self.chief.directions.reshape(*shape, 3)
        offset = points - self.chief.points.reshape(*shape, 3)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = -(offset * u).sum(-1) / (directions * u).sum(-1)
        return np.einsum("f...k,fak->f...a", offset + away[..., None] * directions, self.frames)

    def starts(self, of_field: np.ndarray, places: np.ndarray) -> list[np.ndarray]:
        """Rows of `_GIVEN` of the object's rays of fields (n,) at places (n, 2)."""
        offset = (places[:, :, None] * self.frames[of_field]).sum(1)
        x, y, z = (self.chief.points[of_field] + offset).T
        u = self.chief.directions[of_field]
        path = np.zeros(len(places))
        if not isinf(self.object_distance):
            point = np.column_stack([self.sources, np.full(len(self.sources), -self.object_distance)])
            reach = np.linalg.norm(self.chief.points - point, axis=1)[of_field]
            across2 = (places**2).sum(1)
            far = np.sqrt(reach**2 + across2)
            u = (offset + reach[:, None] * u) / far[:, None]
            path = self.lens.front_index * across2 / (far + reach)
        return [x, y, z - self.lens.length - self.film_distance, *u.T, np.ones(len(places)), path]

    def towards_scene(self, s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rays from the reference points with pupil coordinates s and t (F, …), backwards to the scene.

        Returns their places (F, …, 2), and the greatest share (F, …) of a rim at which they meet a surface; inf for
        rays that do not come through.
        """
        given, dark = self._from_film(s, t)
        x, y, z, l, m, n, clearance = self.backward.run(given, [X, Y, Z, L, M, N, CLEARANCE], s.size).reshape(
            7, *s.shape)
        points = np.stack([x, y, z + self.lens.length + self.film_distance], -1)
        places = self.across(points, np.stack([l, m, n], -1))
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
        x, y = (np.broadcast_to(each.reshape(shape), s.shape) for each in self.chief.images.T)
        rows = {X: x, Y: y, L: -l, M: -m, N: -np.sqrt(np.where(dark, 1.0, square)), WEIGHT: np.ones(s.shape)}
        return {row: np.where(dark, 0.0 if row != N else -1.0, each).ravel() for row, each in rows.items()}, dark

    def _stop_slopes(self) -> np.ndarray:
        """(F, 2, 2) the derivative of the point on the stop, in its radii, by the pupil coordinates."""
        behind = slice(0, len(self.lens.surfaces) - self.lens.stop_index)
        to_stop = Program(surface_steps(self.lens, self.film_distance, self.wavelength, part=behind), np.float64)
        s = self.chief_pupil[:, :1] + [SLOPE_STEP, -SLOPE_STEP, 0.0, 0.0]
        t = self.chief_pupil[:, 1:] + [0.0, 0.0, SLOPE_STEP, -SLOPE_STEP]
        given, _ = self._from_film(s, t)
        at = to_stop.run(given, [X, Y], s.size).reshape(2, *s.shape) / self.lens.stop.semi_diameter
        return np.stack([at[..., 0] - at[..., 1], at[..., 2] - at[..., 3]], -1).transpose(1, 0, 2) / (2.0 * SLOPE_STEP)

    def linear_stop_share(self, s: np.ndarray, t: np.ndarray) -> np.ndarray:
        """(F, …) distance from the stop's centre over its radius, to first order about the chief ray."""
        shape = (len(self.axes),) + (1,) * (s.ndim - 1)
        ds, dt = (each - middle.reshape(shape) for each, middle in zip((s, t), self.chief_pupil.T, strict=True))
        (a, b), (c, d) = (self.stop_slopes[:, i].T.reshape(2, *shape) for i in (0, 1))
        return np.hypot(a * ds + b * dt, c * ds + d * dt)

    def open_boxes(self, conditions: Conditions) -> tuple[np.ndarray, list[Finding]]:
        """(F, 2, 2) low and high pupil coordinate, sagittal and tangential, of the open region; NaN where dark."""
        determinant = np.linalg.det(self.stop_slopes)
        with np.errstate(divide="ignore", invalid="ignore"):
            a, b, c, d = self.stop_slopes.reshape(-1, 4).T
            half = MARGIN * np.column_stack([np.hypot(d, b), np.hypot(c, a)]) / np.abs(determinant)[:, None]
        low, high = self.chief_pupil - half, self.chief_pupil + half
        boxes = np.full((len(low), 2, 2), nan)
        left = np.flatnonzero(np.isfinite(half).all(1))
        cell = (np.arange(COARSE) + 0.5) / COARSE
        for _ in range(SCANS):
            if not left.size:
                break
            some = self._only(left)
            size = high[left] - low[left]
            s, t = (low[left, k, None] + cell * size[:, k, None] for k in (0, 1))
            s, t = (np.ascontiguousarray(np.broadcast_to(each, (left.size, COARSE, COARSE)))
                    for each in (s[:, None, :], t[:, :, None]))
            level = some.towards_scene(s, t)[1]
            bounds = np.empty((left.size, 4))
            _bounds(level, bounds)                      # in cells, s low, s high, t low, t high; NaN for a dark field
            lit, wide = np.isfinite(bounds[:, 0]), bounds
            touches = np.column_stack([wide[:, 0] < 0.5, wide[:, 1] > COARSE - 0.5, wide[:, 2] < 0.5,
                                       wide[:, 3] > COARSE - 0.5]) & lit[:, None]
            done = lit & ~touches.any(1)
            places = bounds.reshape(-1, 2, 2) / COARSE
            boxes[left[lit]] = low[left[lit], :, None] + places[lit] * size[lit][:, :, None]
            # Widen the scan where the region reaches its edge, everywhere where nothing was found
            grow = np.where(touches | ~lit[:, None], 0.5 * (WIDER - 1.0), 0.0)
            low[left] -= grow[:, ::2] * size
            high[left] += grow[:, 1::2] * size
            left = left[~done]
        findings = []
        dark = np.flatnonzero(~np.isfinite(boxes).all((1, 2)))
        if dark.size:
            names = ", ".join(field_name(conditions, i) for i in dark)
            findings.append(Finding(
                Kind.DARK, None, f"no light reaches {'these fields' if dark.size > 1 else 'the field'} {names}: beyond "
                "what the lens sees, or beyond its image circle", figures={"fields": float(dark.size)}))
        return boxes, findings

    def _only(self, which: np.ndarray) -> "_Fields":
        """These fields alone."""
        chief = ChiefRays(*(getattr(self.chief, name)[which] for name in
                            ("at_stop", "points", "directions", "images", "image_directions")))
        return _Fields(self.lens, self.film_distance, chief, self.object_distance, self.wavelength, self.axes[which],
                       self.frames[which], self.sources[which], self.chief_pupil[which], self.stop_slopes[which],
                       self.backward, self.sphere_curvatures[which])

    def beam_areas(self, places: np.ndarray) -> np.ndarray:
        """(F, N, N) light of an evenly lit beam per cell of the grid, from places (F, N, N, 2).

        An object at infinity lights the beam's area evenly, one nearby by Lambert's law.
        """
        out = np.zeros(places.shape[:3])
        _areas(places, out)
        if not isinf(self.object_distance):
            point = np.column_stack([self.sources, np.full(len(self.sources), -self.object_distance)])
            reach = np.linalg.norm(self.chief.points - point, axis=1)[:, None, None]
            far = np.sqrt(reach**2 + np.where(np.isfinite(places), places, 0.0)**2 @ np.ones(2))
            along = (np.einsum("fija,fa->fij", np.nan_to_num(places), self.frames[:, :, 2])
                     + reach * self.chief.directions[:, 2, None, None])
            out *= np.nan_to_num((reach / far) ** 3 * np.abs(along / far))
        return out


def _of_mean_1(values: np.ndarray, where: np.ndarray) -> np.ndarray:
    """The values (…, N, N), scaled to a mean of 1 over the chosen cells of each N × N."""
    count, total = where.sum((-2, -1), keepdims=True), (values * where).sum((-2, -1), keepdims=True)
    return np.where(total > 0.0, values * (count / np.where(total > 0.0, total, 1.0)), 0.0)


def field_name(conditions: Conditions, i: int) -> str:
    """A field in words, such as "12.4 mm" or "14°"."""
    x, y = conditions.fields[i]
    unit = "°" if conditions.field_kind is FieldKind.ANGLE else " mm"
    return f"{significant(y, 4)}{unit}" if x == 0.0 else f"({significant(x, 4)}, {significant(y, 4)}){unit}"


_GIVEN = (X, Y, Z, L, M, N, WEIGHT, PATH)
_WANTED = (X, Y, Z, L, M, N, CLEARANCE, PATH, VICTIM, STOP_SHARE)
_LEVEL, _SHARE, _VALUES = 8, 7, 9       # of the arrays that `_finish` fills, in the order of RayGrid, with the level


@njit(cache=True, nogil=True, error_model="numpy")
def _finish(out, keep, of_field, images, axes, curvatures, values, victim):
    """Rays behind the last surface, rows of `_WANTED`, to the film and the reference sphere.

    The first keep.size of them are cells `keep` of the arrays values (9, F N N) and victim (F N N); then follow the
    chief rays of the fields.
    """
    n, fields = keep.size, images.shape[0]
    reference = np.empty(fields)
    for i in range(n + fields):
        j = n + (i if i < fields else 0)                # the chief rays first
        lane = j if i < fields else i - fields
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
        cell = keep[lane]
        sx, sy, tx, ty = axes[f, 0, 0], axes[f, 0, 1], axes[f, 1, 0], axes[f, 1, 1]
        px, py = l * (1.0 + kappa * back) - ex * kappa, m * (1.0 + kappa * back) - ey * kappa
        values[0, cell], values[1, cell] = ex * sx + ey * sy, ex * tx + ey * ty
        values[2, cell], values[3, cell] = (l * sx + m * sy) / cosine, (l * tx + m * ty) / cosine
        values[4, cell], values[5, cell] = px * sx + py * sy, px * tx + py * ty
        values[6, cell] = reference[f] - path
        values[7, cell] = out[9, lane]
        values[8, cell] = sqrt(out[6, lane])
        victim[cell] = np.int16(out[8, lane])


@njit(cache=True, nogil=True, error_model="numpy")
def _cover(level, s, t, grid, out, centre):
    """The part (F, N, N) of each cell where a level (F, N, N) is below 1, from its value and slopes.

    s, t: (F, N, N) pupil coordinates at which the level is known, near the cells' centres grid (F, 2, N). centre
    (2, F, N, N) receives the centroid of the open part from the middle of the cell, in cells.
    """
    fields, rows, columns = level.shape
    for f in range(fields):
        per_s, per_t = 1.0 / (grid[f, 0, 1] - grid[f, 0, 0]), 1.0 / (grid[f, 1, 1] - grid[f, 1, 0])
        for i in range(rows):
            for j in range(columns):
                here = level[f, i, j]
                centre[0, f, i, j], centre[1, f, i, j] = 0.0, 0.0
                if not here < np.inf:
                    out[f, i, j] = 0.0
                    continue
                a, b = _slope(level[f], i, j, 0), _slope(level[f], i, j, 1)
                here += a * (grid[f, 1, i] - t[f, i, j]) * per_t + b * (grid[f, 0, j] - s[f, i, j]) * per_s
                up, right = a, b
                a, b = max(abs(a), abs(b)), min(abs(a), abs(b))
                d = 1.0 - here                          # a half-plane: d + slopes · offset > 0
                half, flat = 0.5 * (a + b), 0.5 * (a - b)
                if abs(d) >= half or a == 0.0:
                    part = 1.0 if d >= 0.0 else 0.0
                elif abs(d) <= flat:
                    part = 0.5 + d / a
                else:
                    corner = (half - abs(d)) ** 2 / (2.0 * a * b)
                    part = 1.0 - corner if d > 0.0 else corner
                out[f, i, j] = part
                if part < 1.0 and a > 0.0:
                    centre[0, f, i, j] = -0.5 * (1.0 - part) * right / a
                    centre[1, f, i, j] = -0.5 * (1.0 - part) * up / a


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(level, i, j, axis):
    """Change of a level per cell along an axis, from the neighbours that are finite; 0 where there is none."""
    di, dj = (1, 0) if axis == 0 else (0, 1)
    rows, columns = level.shape
    here = level[i, j]
    after = level[i + di, j + dj] if i + di < rows and j + dj < columns else np.nan
    before = level[i - di, j - dj] if i >= di and j >= dj else np.nan
    has_after, has_before = abs(after) < np.inf, abs(before) < np.inf
    if has_after and has_before:
        return 0.5 * (after - before)
    if has_after:
        return after - here
    return here - before if has_before else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _towards_centroids(values, weight, centre, out):
    """Values (n, N, N) halfway to the centroids (2, n, N, N) of the cells' open parts; 0 where the weight is 0."""
    for f in range(values.shape[0]):
        for i in range(values.shape[1]):
            for j in range(values.shape[2]):
                ds, dt = centre[0, f, i, j], centre[1, f, i, j]
                here = values[f, i, j]
                if ds != 0.0 or dt != 0.0:
                    here += 0.5 * (ds * _slope(values[f], i, j, 1) + dt * _slope(values[f], i, j, 0))
                out[f, i, j] = here if weight[f, i, j] > 0.0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(level, out):
    """Extents of level < 1 in cells of (F, N, N): out (F, 4) low and high column, low and high row; NaN where none is.

    A rim between two cells is where the level, linear between them, is 1; the extents get half a cell more.
    """
    fields, rows, columns = level.shape
    for f in range(fields):
        low_s, high_s, low_t, high_t = np.inf, -np.inf, np.inf, -np.inf
        for i in range(rows):
            for j in range(columns):
                here = level[f, i, j]
                if not here < 1.0:
                    continue
                s, t = j + 0.5, i + 0.5
                low_s = min(low_s, s - (_part(here, level[f, i, j - 1]) if j > 0 else 0.5))
                high_s = max(high_s, s + (_part(here, level[f, i, j + 1]) if j < columns - 1 else 0.5))
                low_t = min(low_t, t - (_part(here, level[f, i - 1, j]) if i > 0 else 0.5))
                high_t = max(high_t, t + (_part(here, level[f, i + 1, j]) if i < rows - 1 else 0.5))
        found = high_s > low_s
        out[f, 0], out[f, 1] = (low_s - 0.5, high_s + 0.5) if found else (np.nan, np.nan)
        out[f, 2], out[f, 3] = (low_t - 0.5, high_t + 0.5) if found else (np.nan, np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _part(here, there):
    """Place of the level 1 between a cell inside and its neighbour, in cells: at most 1."""
    if not there < np.inf:
        return 1.0
    return 1.0 if there <= 1.0 else (1.0 - here) / (there - here)


@njit(cache=True, nogil=True, error_model="numpy")
def _areas(places, out):
    """Area of the beam per cell of the exit pupil (F, N, N), from places (F, N, N, 2); 0 where they are unknown."""
    fields, rows, columns, _ = places.shape
    for f in range(fields):
        for i in range(rows):
            for j in range(columns):
                a, b = _slope(places[f, :, :, 0], i, j, 0), _slope(places[f, :, :, 0], i, j, 1)
                c, d = _slope(places[f, :, :, 1], i, j, 0), _slope(places[f, :, :, 1], i, j, 1)
                area = abs(a * d - b * c)
                out[f, i, j] = area if area < np.inf else 0.0
