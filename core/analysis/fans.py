"""Ray fans and fans of the optical path difference: rays across the whole stop, sagittal and tangential.

Lengths in mm; frame, axes and sign of the path difference are those of the ray grid. A fan crosses the pupil on the
chief ray. Its rays are named by their height in the stop over the stop's radius, from −1 to 1, so that the part that
other rims end is seen as such.
"""

from dataclasses import dataclass

import numpy as np

from lensbench.analysis.grids.field_beams import OFFSET_S, OFFSET_T, OPD, SLOPE_S, SLOPE_T, FieldBeams
from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.optics.lens_surface import LensError

SEARCH = 49             # rays that find the heights in the stop
REACH = 1.4             # × the stop's radius to first order, that they cover


@dataclass(frozen=True, eq=False)
class Fans:
    """Fans of F fields, C wavelengths and K heights, from `ray_fans`; NaN for a lost ray.

    Parameters
    ----------
    rays
        The ray grid that the fans belong to.
    heights
        (K,) heights in the stop over its radius, −1 to 1, along the axis of the fan; of rays that would meet the
        reference point.
    offset
        (F, 2, C, K, 2) where a ray meets the film, sagittal and tangential, from the reference point, mm. The second
        axis is the fan: 0 the sagittal and 1 the tangential one.
    slope
        (F, 2, C, K, 2) change of the offset with the film's place, mm per mm along +z.
    opd
        (F, 2, C, K) optical path difference, mm.
    victim
        (F, 2, C, K) index of the surface that ends the ray, −1 for a ray that passes. Others are traced on as if no
        rim were there, so that a plot can show them greyed.
    pupil
        (F, 2, K, 2) sagittal and tangential pupil coordinate of the rays in the primary wavelength, from the reference
        point; NaN where the stop has no such height.
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

    Parameters
    ----------
    rays : RayGrid
        From `ray_grid`.
    points : int
        Rays of each fan, at least 3; an odd number has the chief ray among them.

    Returns
    -------
    Fans

    Raises
    ------
    LensError
        For fewer than 3 rays.
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
    """(F, K) pupil coordinates along an axis of rays from the reference points that meet the stop at these heights.

    heights: (K,) over the stop's radius. The other coordinate is that of the chief ray. NaN where the stop has no such
    height.
    """
    slope = beams.stop_slopes[:, :, axis]
    with np.errstate(divide="ignore", invalid="ignore"):
        extent = 1.0 / np.hypot(slope[:, 0], slope[:, 1])
    line = beams.chief_pupil[:, axis, None] + extent[:, None] * REACH * np.linspace(-1.0, 1.0, SEARCH)
    other = np.broadcast_to(beams.chief_pupil[:, 1 - axis, None], line.shape)
    at = np.einsum("kfq,fk->fq", beams.on_stop(*((line, other) if axis == 0 else (other, line))), beams.axes[:, axis])
    found = np.full((len(line), len(heights)), np.nan)
    for f in range(len(line)):
        good = _rising(at[f])
        if good.stop - good.start > 3:
            found[f] = np.interp(heights, *_upwards(at[f, good], line[f, good]), np.nan, np.nan)
    return found


def _rising(at: np.ndarray) -> slice:
    """The part about the middle of an odd number of heights (n,) in which they only rise, or only fall.

    Beyond, rays outside the rim cross those within: their heights would be taken for others.
    """
    steps, middle = np.diff(at), len(at) // 2
    same = steps[middle] * steps > 0.0
    low = middle - int(np.argmin(np.append(same[:middle][::-1], False)))
    return slice(low, middle + 1 + int(np.argmin(np.append(same[middle:], False))))


def _upwards(at: np.ndarray, line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return (at, line) if at[-1] > at[0] else (at[::-1], line[::-1])
