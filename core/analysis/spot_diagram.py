"""Spots and fans: where the rays of an object point meet the film, and across the whole stop.

Lengths in mm; coordinates, axes and sign of the path difference are those of the ray grid, from the reference point of
the field. A shift of the film is positive along +z. A fan crosses the pupil on the chief ray; its rays are named by
their height in the stop over its radius, −1 to 1, so that a plot shows what clear apertures block.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_beams import OFFSET_S, OFFSET_T, OPD, SLOPE_S, SLOPE_T, FieldBeams
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.optics.lens_surface import LensError

REFERENCES = ("chief", "centroid")
FIRST_ZERO = 0.6098349          # of the Airy pattern, × wavelength / numerical aperture: 3.8317 / 2π


@dataclass(frozen=True, eq=False)
class Spots:
    """Spots of F fields and C wavelengths at K places of the film, from `spots`; NaN where no light falls.

    Args:
        rays: The ray grid.
        reference: "chief": the primary chief ray, as it meets the film at each place; "centroid": of all wavelengths
            together.
        shifts: (K,) places of the film, mm along +z from the grid's film.
        references: (F, K, 2) the references, sagittal and tangential, mm from the fields' reference points.
        centroids: (F, C, K, 2) centroid of each wavelength, from the same points.
        rms: (F, C, K, 2) root mean square distance from the references, along the sagittal and the tangential axis.
        geo: (F, C, K) greatest distance from the reference of a ray, or of light in a cell at a rim.
    """

    rays: RayGrid
    reference: str
    shifts: np.ndarray
    references: np.ndarray
    centroids: np.ndarray
    rms: np.ndarray
    geo: np.ndarray

    @cached_property
    def rms_radius(self) -> np.ndarray:
        """(F, C, K) root mean square distance from the references, mm."""
        return np.hypot(self.rms[..., 0], self.rms[..., 1])

    @cached_property
    def white_rms(self) -> np.ndarray:
        """(F, K, 2) `rms` of all wavelengths with their weights, mm; NaN where no light falls."""
        white = np.sqrt(np.einsum("fcka,fc->fka", np.nan_to_num(self.rms) ** 2, self._shares))
        return np.where(self.rays.lit[:, None, None], white, np.nan)

    @cached_property
    def white_rms_radius(self) -> np.ndarray:
        """(F, K) `rms_radius` of all wavelengths with their weights, mm; NaN where no light falls."""
        return np.hypot(self.white_rms[..., 0], self.white_rms[..., 1])

    @cached_property
    def white_geo(self) -> np.ndarray:
        """(F, K) greatest distance of a ray of any wavelength, mm; NaN where no light falls."""
        return np.where(self.rays.lit[:, None], np.nan_to_num(self.geo).max(1), np.nan)

    @cached_property
    def airy_radius(self) -> np.ndarray:
        """(F, C, 2) radius of the first dark ring of a perfect lens with this pupil, sagittal and tangential, mm.

        3.83 λ / (2π a), a half the width of the open pupil, exact for a round or elliptic one.
        """
        open_cells = self.rays.coverage
        size = np.stack([open_cells.sum(axis).max(-1) for axis in (3, 2)], -1)          # the longest row, (F, C, 2)
        half = 0.5 * size * self.rays.steps[:, None]
        lines = np.array(self.rays.conditions.wavelengths) * 1e-3
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(half > 0.0, FIRST_ZERO * lines[:, None] / half, np.nan)

    @property
    def best_shifts(self) -> np.ndarray:
        """(F,) place of the film with the least rms radius of all wavelengths about their centroid, mm along +z."""
        return _least_shift(*(variances.sum(1) for variances in _variances(self.rays, self._shares)))

    @property
    def line_foci(self) -> np.ndarray:
        """(F, 2) the same for the least rms width sagittally and tangentially, mm along +z."""
        return _least_shift(*_variances(self.rays, self._shares))

    def points(self, field: int, colour: int, reference: int = 0) -> np.ndarray:
        """Rays that pass: (n, 2) from the reference, sagittal and tangential, mm, by indices of field, colour and
        place.
        """
        rays, shift = self.rays, self.shifts[reference]
        passed = rays.passed[field, colour]
        return np.column_stack([(offset[field, colour] + shift * slope[field, colour])[passed] - middle
                                for offset, slope, middle in zip((rays.offset_s, rays.offset_t),
                                                                 (rays.slope_s, rays.slope_t),
                                                                 self.references[field, reference], strict=True)])

    @property
    def _shares(self) -> np.ndarray:
        return light_shares(self.rays)


def spots(rays: RayGrid, reference: str = "chief", shifts: ArrayLike = (0.0,)) -> Spots:
    """Spots of a ray grid.

    Rays count with the light of their cell of the pupil (`RayGrid.weight`); `rays.lost` counts those that a rim ends.

    Args:
        rays: From `ray_grid`.
        reference: {"chief", "centroid"}. Point that distances are measured from.
        shifts: (K,) array_like. Places of the film, mm along +z; each ray goes on straight.
    Raises:
        LensError: For another reference, and shifts that are not finite.
    """
    if reference not in REFERENCES:
        raise LensError(f"reference {reference!r}: choose one of {', '.join(REFERENCES)}")
    shifts = checked_shifts(shifts)
    means, squares = _moments(rays)
    centroids = means[:, :, None, 0] + shifts[:, None] * means[:, :, None, 1]
    second = (squares[:, :, None, 0] + 2.0 * shifts[:, None] * squares[:, :, None, 1]
              + shifts[:, None] ** 2 * squares[:, :, None, 2])                  # about 0, (F, C, K, 2)
    if reference == "chief":
        p = rays.chief_pupil
        slopes = p / np.sqrt(1.0 - (p**2).sum(1))[:, None]
        references = shifts[:, None] * slopes[:, None]
    else:
        references = np.einsum("fcka,fc->fka", np.nan_to_num(centroids), light_shares(rays))
        references = np.where(rays.lit[:, None, None], references, np.nan)
    middle = references[:, None]
    rms = np.sqrt(np.maximum(second - 2.0 * centroids * middle + middle**2, 0.0))
    passed = rays.passed
    own = rays.offset_s, rays.offset_t, rays.slope_s, rays.slope_t
    offset_s, offset_t, slope_s, slope_t = (np.where(passed, one, other)      # as the rms has them beyond a rim
                                            for one, other in zip(own, rays.light, strict=True))
    lit = passed | (rays.weight > 0.0)
    geo = np.empty(rms.shape[:3])
    for k, shift in enumerate(shifts):
        origins = references[:, k].T[..., None, None, None]
        s, t = (offset + shift * slope - origin for offset, slope, origin in
                zip((offset_s, offset_t), (slope_s, slope_t), origins, strict=True))
        geo[:, :, k] = np.sqrt(np.where(lit, s * s + t * t, -1.0).max((2, 3), initial=-1.0).clip(0.0))
    geo[~lit.any((2, 3))] = np.nan
    return Spots(rays, reference, shifts, references, centroids, rms, geo)


def checked_shifts(shifts: ArrayLike) -> np.ndarray:
    """Shifts of the film (K,), mm; LensError for one that is not finite."""
    made = np.atleast_1d(np.asarray(shifts, float))
    if not np.isfinite(made).all():
        raise LensError("a shift of the film must be a finite length")
    return made


def light_shares(rays: RayGrid) -> np.ndarray:
    """(F, C) the part of the light of each field that each wavelength brings; 0 for a dark field."""
    light = rays.weight.sum((2, 3)) * np.array(rays.conditions.weights)
    total = light.sum(1, keepdims=True)
    return np.where(total > 0.0, light / np.where(total > 0.0, total, 1.0), 0.0)


def _moments(rays: RayGrid) -> tuple[np.ndarray, np.ndarray]:
    """Means over the light, of offset and slope (F, C, 2, 2), and of their squares and product (F, C, 3, 2), or NaN."""
    weight = rays.weight
    total = weight.sum((2, 3))
    share = weight / np.where(total > 0.0, total, np.nan)[:, :, None, None]
    means, squares = np.empty((*total.shape, 2, 2)), np.empty((*total.shape, 3, 2))
    for a in (0, 1):
        o, s = rays.light[a], rays.light[2 + a]
        for k, values in enumerate((o, s)):
            means[:, :, k, a] = np.einsum("fcij,fcij->fc", share, values)
        for k, (one, other) in enumerate(((o, o), (o, s), (s, s))):
            squares[:, :, k, a] = np.einsum("fcij,fcij,fcij->fc", share, one, other)
    return means, squares


def _variances(rays: RayGrid, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of offset and slope, and variance of the slope, (F, 2) each, of all wavelengths together."""
    means, squares = (np.nan_to_num(moments) for moments in _moments(rays))
    mean = np.einsum("fcka,fc->fka", means, shares)
    square = np.einsum("fcka,fc->fka", squares, shares)
    return square[:, 1] - mean[:, 0] * mean[:, 1], square[:, 2] - mean[:, 1] ** 2


def _least_shift(both: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Shift of the least rms about the centroid: −covariance of offset and slope over the slope's variance."""
    return np.where(spread > 0.0, -both / np.where(spread > 0.0, spread, 1.0), np.nan)


SEARCH = 49             # rays that find the heights in the stop
REACH = 1.4             # × the stop's radius to first order, that they cover


@dataclass(frozen=True, eq=False)
class Fans:
    """Fans of F fields, C wavelengths and K heights, from `ray_fans`; NaN for a lost ray.

    Args:
        rays: The ray grid that the fans belong to.
        heights: (K,) heights in the stop over its radius, −1 to 1, along the axis of the fan; of rays that would meet
            the reference point.
        offset: (F, 2, C, K, 2) where a ray meets the film, sagittal and tangential, from the reference point, mm. The
            second axis is the fan: 0 the sagittal and 1 the tangential one.
        slope: (F, 2, C, K, 2) change of the offset with the film's place, mm per mm along +z.
        opd: (F, 2, C, K) optical path difference, mm.
        victim: (F, 2, C, K) index of the surface that ends the ray, −1 for a ray that passes. Others are traced on as
            if no rim were there, so that a plot can show them greyed.
        pupil: (F, 2, K, 2) sagittal and tangential pupil coordinate of the rays in the primary wavelength, from the
            reference point; NaN where the stop has no such height.
    """

    rays: RayGrid
    heights: np.ndarray
    offset: np.ndarray
    slope: np.ndarray
    opd: np.ndarray
    victim: np.ndarray
    pupil: np.ndarray

    @property
    def passed(self) -> np.ndarray:
        """(F, 2, C, K) whether a ray passes all rims."""
        return self.victim == -1

    @property
    def transverse(self) -> np.ndarray:
        """(F, 2, C, K) the offset along the fan, as ray fans are plotted, mm."""
        return np.stack([self.offset[:, a, ..., a] for a in (0, 1)], 1)

    @property
    def waves(self) -> np.ndarray:
        """(F, 2, C, K) optical path difference in wavelengths of each colour."""
        return self.opd / (1e-3 * np.array(self.rays.conditions.wavelengths)[:, None])


def ray_fans(rays: RayGrid, points: int = 65) -> Fans:
    """Ray and OPD fans of the fields of a ray grid.

    Args:
        rays: From `ray_grid`.
        points: Rays of each fan, at least 3; an odd number has the chief ray among them.
    Raises:
        LensError: For fewer than 3 rays.
    """
    if points < 3:
        raise LensError(f"{points} rays in a fan: at least 3 are needed")
    beams, count = rays.beams, len(rays.images)
    heights = np.linspace(-1.0, 1.0, points)
    pupil = np.full((2, count, 2, points), np.nan)              # coordinate, field, fan, ray
    for a in (0, 1):
        pupil[a, :, a] = pupil_by_height(beams, a, heights)
        pupil[1 - a, :, a] = beams.chief_pupil[:, 1 - a, None]
    places, _ = beams.towards_scene(*np.ascontiguousarray(pupil))
    places[beams.beyond_the_plane] = np.nan
    of_field = np.repeat(np.arange(count), 2 * points)
    starts = beams.starts(of_field, places.reshape(-1, 2))
    colours = rays.conditions.wavelengths
    offset, slope = np.full((2, len(colours), count, 2, points, 2), np.nan)
    opd, victim = np.full(offset.shape[:-1], np.nan), np.full(offset.shape[:-1], -2, np.int16)
    for c, colour in enumerate(colours):
        landed, ends = beams.forward(colour, of_field, starts)
        good = np.isfinite(places).all(-1) & np.isfinite(landed[OPD]).reshape(places.shape[:-1])
        offset[c][good] = landed[[OFFSET_S, OFFSET_T]].T.reshape(offset.shape[1:])[good]
        slope[c][good] = landed[[SLOPE_S, SLOPE_T]].T.reshape(offset.shape[1:])[good]
        opd[c][good] = landed[OPD].reshape(opd.shape[1:])[good]
        victim[c] = np.where(np.isfinite(places).all(-1), ends.reshape(victim.shape[1:]), -2)
    return Fans(rays, heights, offset.transpose(1, 2, 0, 3, 4), slope.transpose(1, 2, 0, 3, 4),
                opd.transpose(1, 2, 0, 3), victim.transpose(1, 2, 0, 3), pupil.transpose(1, 2, 3, 0))


def pupil_by_height(beams: FieldBeams, axis: int, heights: np.ndarray) -> np.ndarray:
    """(F, K) pupil coordinates along an axis of rays from the reference points that meet the stop at heights (K,), or
    NaN.

    Heights are over the stop's radius. The other coordinate is that of the chief ray.
    """
    slope = beams.stop_slopes[:, :, axis]
    with np.errstate(divide="ignore", invalid="ignore"):
        extent = 1.0 / np.hypot(slope[:, 0], slope[:, 1])
    line = beams.chief_pupil[:, axis, None] + extent[:, None] * REACH * np.linspace(-1.0, 1.0, SEARCH)
    other = np.broadcast_to(beams.chief_pupil[:, 1 - axis, None], line.shape)
    points = beams.on_stop(line, other) if axis == 0 else beams.on_stop(other, line)
    on_stop = np.einsum("kfq,fk->fq", points, beams.axes[:, axis])
    shares = np.full((len(line), len(heights)), np.nan)
    for f in range(len(line)):
        good = _rising(on_stop[f])
        if good.stop - good.start > 3:
            order = np.argsort(on_stop[f, good])
            shares[f] = np.interp(heights, on_stop[f, good][order], line[f, good][order], np.nan, np.nan)
    return shares


def _rising(values: np.ndarray) -> slice:
    """The part about the middle of an odd number of heights (n,) in which they only rise, or only fall."""
    steps, middle = np.diff(values), len(values) // 2
    same = steps[middle] * steps > 0.0
    low = middle - int(np.argmin(np.append(same[:middle][::-1], False)))
    return slice(low, middle + 1 + int(np.argmin(np.append(same[middle:], False))))
