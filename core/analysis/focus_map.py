"""MTF over field and focus: the map on which curvature of field, astigmatism and depth of focus are seen at once.

Frequencies in cycles/mm, lengths in mm; a shift of the film is positive along +z. The map evaluates the diffraction OTF
of `transfer_function`, for which a shift of the film by δ adds δ (cos θ_chief − cos θ) to W: exact at any aperture.
"""

from dataclasses import dataclass
from math import floor, sqrt

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import Conditions, each_of
from lensbench.core.analysis.grids.traced_grid import RayGrid, ray_grid
from lensbench.core.analysis.spot_diagram import light_shares
from lensbench.core.analysis.transfer_function import FAST, PAD, cosine_of_turns, pupil_functions, sine_of_turns
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant

FIELDS = SHIFTS = 64
RANGE = 0.3             # mm to either side of the film
FREQUENCY = 30.0        # cycles/mm


@dataclass(frozen=True, eq=False)
class MtfMap:
    """MTF at one frequency over F fields and K places of the film, from `mtf_map`; NaN where no light falls.

    Args:
        rays: The ray grid of the map's fields.
        frequency: Cycles/mm.
        shifts: (K,) places of the film, mm along +z from the grid's.
        modulus: (F, C, 2, K) MTF of each wavelength, of the sagittal and the tangential frequency.
        white: (F, 2, K) MTF of all wavelengths together.
    """

    rays: RayGrid
    frequency: float
    shifts: np.ndarray
    modulus: np.ndarray
    white: np.ndarray

    @property
    def heights(self) -> np.ndarray:
        """(F,) distance of the fields from the film's centre, mm."""
        return self.rays.image_heights

    @property
    def best_shifts(self) -> np.ndarray:
        """(F, 2) place of the film with the highest white MTF, sagittal and tangential, mm; NaN at an end."""
        return best_places(self.shifts, self.white)

    @property
    def best_mean_shifts(self) -> np.ndarray:
        """(F,) the same for the mean of the sagittal and the tangential MTF, mm."""
        return best_places(self.shifts, self.white.mean(1))


def best_places(shifts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(…) places of the maxima of values (…, K) at even shifts (K,), by a parabola; NaN at the ends and for NaN."""
    known = np.where(np.isnan(values), -1.0, values)
    peak = known.argmax(-1)
    inner = np.clip(peak, 1, len(shifts) - 2)
    before, middle, after = (np.take_along_axis(known, (inner + k)[..., None], -1)[..., 0] for k in (-1, 0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 0.5 * (before - after) / (before - 2.0 * middle + after)
    places = shifts[inner] + np.nan_to_num(share) * (shifts[1] - shifts[0])
    return np.where((peak == inner) & (middle >= 0.0), places, np.nan)


def mtf_map(lens: Lens, film_distance: float, conditions: Conditions, frequency: float = FREQUENCY,
            shifts: ArrayLike | None = None, fields: int = FIELDS, pupil: int = 32) -> MtfMap:
    """The map of the MTF over field and focus.

    Args:
        lens: The lens, stopped down and focused.
        film_distance: Last vertex → film, mm.
        conditions: Wavelengths and object distance; the fields run along the meridian of the largest, from the axis to
            it.
        frequency: Cycles/mm, positive.
        shifts: (K,) array_like or None. Places of the film at even steps, mm along +z, at least 3; None: 64 within 0.3
            mm to either side.
        fields: Field points, at least 2.
        pupil: Points across the pupil, as for `ray_grid`; 16 suits a picture that moves.
    Raises:
        LensError: For a frequency that is not positive, shifts that are not even, fewer than 2 fields, and as
            `ray_grid`.
    """
    places = np.linspace(-RANGE, RANGE, SHIFTS) if shifts is None else np.asarray(shifts, float)
    if not 0.0 < frequency < np.inf:
        raise LensError(f"frequency {significant(frequency)} lp/mm: it must be positive")
    if places.ndim != 1 or len(places) < 3 or places[1] == places[0] or not np.allclose(
            np.diff(places), places[1] - places[0], rtol=1e-6):
        raise LensError("a map needs at least 3 places of the film at even steps")
    if fields < 2:
        raise LensError(f"{fields} fields: a map needs at least 2")
    points = np.array(conditions.fields)
    largest = points[np.hypot(points[:, 0], points[:, 1]).argmax()]
    along = tuple((float(x), float(y)) for x, y in np.linspace(0.0, 1.0, fields)[:, None] * largest)
    rays = ray_grid(lens, film_distance, Conditions(conditions.field_kind, along, conditions.wavelengths,
                                                    conditions.weights, conditions.primary,
                                                    conditions.object_distance, conditions.findings), pupil)
    otf = through_focus(rays, frequency, places)
    shares = light_shares(rays)
    white = np.abs(np.einsum("fcak,fc->fak", np.where(np.isnan(otf), 0.0, otf), shares))
    return MtfMap(rays, frequency, places, np.abs(otf), np.where(rays.lit[:, None, None], white, np.nan))


def through_focus(rays: RayGrid, frequency: float, shifts: np.ndarray) -> np.ndarray:
    """(F, C, 2, K) complex OTF at one frequency (cycles/mm) for a film shifted by even steps (K,), mm along +z."""
    pupils = pupil_functions(rays)
    otf = np.full((*rays.opd.shape[:2], 2, len(shifts)), np.nan, complex)
    lines = 1e-3 * np.array(rays.conditions.wavelengths)

    mirrored = rays.mirrored and rays.opd.shape[-1] % 2 == 0

    def fill(f: int) -> None:
        _through_focus(pupils[:, f], rays.pupil[f], frequency, lines, shifts, mirrored, otf[f])

    each_of(fill, np.flatnonzero(np.isfinite(rays.steps).all(1)).tolist())
    return otf


@njit(cache=True, nogil=True, error_model="numpy")
def _through_focus(pupils, grid, frequency, lines, shifts, mirrored, otf):
    """OTF (C, 2, K) of the pupil functions (2, C, 4, N + 2 PAD, N) of one field; NaN stays where no light falls.

    grid: (2, N) pupil coordinates. lines: (C,) wavelengths, mm. mirrored: whether one half of an even number of
    sagittal columns stands for both.
    """
    real, imaginary = np.empty(shifts.size), np.empty(shifts.size)
    for c in range(lines.size):
        if not pupils[0, c, 2].any():
            continue
        for a in range(2):
            half = grid.shape[1] // 2 if mirrored else 0
            row, column = (half, 0) if a == 0 else (0, half)
            _along(pupils[a, c], grid[a], grid[1 - a], row, column, frequency, lines[c], shifts, real, imaginary)
            for k in range(shifts.size):
                otf[c, a, k] = complex(2.0 * real[k], 0.0) if row else complex(real[k], imaginary[k])


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def _along(pupil, along, across, first_row, first_column, frequency, line, shifts, real, imaginary):
    """OTF (K,) of a pupil function (4, N + 2 PAD, N) at one frequency, for film positions at even steps (K,).

    along, across: (N,) pupil coordinates of its rows and columns. first_row, first_column: where the sum begins. line:
    wavelength, mm. Every cell's phasor turns by the same angle from position to position.
    """
    part_of = pupil[:, :, first_column:]
    w, slope, cover, root = part_of[0], part_of[1], part_of[2], part_of[3]
    across = across[first_column:]
    rows, columns = w.shape
    light = 0.0
    for i in range(rows):
        for j in range(columns):
            light += cover[i, j] * root[i, j] * root[i, j]
    half = 0.5 * line * frequency / (along[1] - along[0])           # cells
    reach = 0.5 * line * frequency                                  # pupil coordinate
    whole = int(floor(half))
    share = half - whole
    rest = 1.0 - share
    h0, h1 = (1.0 + 2.0 * share) * rest * rest, share * share * (3.0 - 2.0 * share)
    g0, g1 = share * rest * rest, -share * share * rest
    first, step = shifts[0] / line, (shifts[1] - shifts[0]) / line
    amplitude, phase, turn = np.empty(columns), np.empty(columns), np.empty(columns)
    buffers = np.empty((4, rows * columns))
    re, im, cosines, sines = buffers[0], buffers[1], buffers[2], buffers[3]
    lit = 0                                                         # cells with light, one after the other
    for i in range(max(whole + 1, PAD + first_row), rows - max(whole + 1, PAD)):
        a, b = i + whole, i - whole
        wa, wa1, wb, wb1 = w[a], w[a + 1], w[b], w[b - 1]
        sa, sa1, sb, sb1 = slope[a], slope[a + 1], slope[b], slope[b - 1]
        ca, ca1, cb, cb1 = cover[a], cover[a + 1], cover[b], cover[b - 1]
        ra, ra1, rb, rb1 = root[a], root[a + 1], root[b], root[b - 1]
        high, low = 1.0 - (along[i - PAD] + reach) ** 2, 1.0 - (along[i - PAD] - reach) ** 2
        for j in range(columns):
            over = min(rest * ca[j] + share * ca1[j], rest * cb[j] + share * cb1[j])
            amplitude[j] = over * (rest * ra[j] + share * ra1[j]) * (rest * rb[j] + share * rb1[j])
            q = across[j] * across[j]
            turn[j] = sqrt(max(low - q, 0.0)) - sqrt(max(high - q, 0.0))        # of W, per mm
            phase[j] = (h0 * (wa[j] - wb[j]) + h1 * (wa1[j] - wb1[j]) + g0 * (sa[j] + sb[j]) + g1 * (sa1[j] + sb1[j])
                        + first * turn[j])
        for j in range(columns):
            re[lit], cosines[lit], sines[lit] = amplitude[j], phase[j], turn[j]
            lit += amplitude[j] > 0.0
    for j in range(lit):
        x = cosines[j]
        x = x - np.floor(x + 0.5)
        u = x * x
        size = re[j]
        re[j], im[j] = size * cosine_of_turns(u), size * x * sine_of_turns(u)
        x = step * sines[j]
        x = x - np.floor(x + 0.5)
        u = x * x
        cosines[j], sines[j] = cosine_of_turns(u), x * sine_of_turns(u)
    for k in range(shifts.size):
        total, other = 0.0, 0.0
        for j in range(lit):
            total += re[j]
            other += im[j]
            turned = re[j] * cosines[j] - im[j] * sines[j]
            im[j] = re[j] * sines[j] + im[j] * cosines[j]
            re[j] = turned
        real[k], imaginary[k] = total / light, other / light
