"""Optical transfer function and MTF of a ray grid: by diffraction, by rays alone, and the limit of a perfect lens.

Frequencies in cycles/mm on the film. The *tangential* frequency runs away from the film's centre, the *sagittal* one
across it, as makers print them: sagittal lines point to the centre.

The diffraction OTF is the autocorrelation of the pupil function, shifted by λν, usually a part of a cell; between the
points of the grid W follows from its values and slopes (Hermite's cubic), the slopes being the landing points of the
rays. So the sum passes into that of the rays alone where the shift is small against the structure of W. It fails only
where neighbouring rays land more than half a period apart, which a finding reports, and within a cell of the cutoff.

References:
    H. H. Hopkins, "The numerical evaluation of the frequency response of optical systems", Proc. Phys. Soc. B 70
    (1957).
"""

from dataclasses import dataclass
from functools import cached_property
from math import floor

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import each_of
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.spot_diagram import checked_shifts, light_shares
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.text import significant

METHODS = ("diffraction", "geometric")
PRINTED = (10.0, 20.0, 30.0, 40.0)      # cycles/mm, of makers' charts against the field
HALF_PERIOD, KEPT = 0.5, 0.98           # neighbouring rays land closer, but for a small part
PAD = 2                                 # rows of nothing about a pupil, for the cells beyond its ends

FAST = {"contract", "nsz", "arcp", "reassoc"}   # of sums over arrays without NaN


@dataclass(frozen=True, eq=False)
class Mtf:
    """Transfer functions of F fields, C wavelengths and K frequencies, from `mtf`; NaN where no light falls.

    Args:
        rays: The ray grid.
        method: "diffraction" or "geometric".
        shift: Of the film along +z from that of the grid, mm.
        frequencies: (K,) cycles/mm.
        otf: (F, C, 2, K) complex, of the sagittal and the tangential frequency; its phase counts from the field's
            reference point.
        white: (F, 2, K) complex, of all wavelengths with their light and weights.
        limit: (F, C, 2, K) MTF of a perfect lens with the same open pupil.
        findings: Where the samples do not suffice.
    """

    rays: RayGrid
    method: str
    shift: float
    frequencies: np.ndarray
    otf: np.ndarray
    white: np.ndarray
    limit: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def modulus(self) -> np.ndarray:
        """(F, C, 2, K) MTF of each wavelength."""
        return np.abs(self.otf)

    @property
    def white_modulus(self) -> np.ndarray:
        """(F, 2, K) MTF of all wavelengths together."""
        return np.abs(self.white)

    @cached_property
    def white_limit(self) -> np.ndarray:
        """(F, 2, K) the diffraction limit of all wavelengths together."""
        return _white(self.limit, self.rays)


def mtf(rays: RayGrid, frequencies: ArrayLike = PRINTED, method: str = "diffraction", shift: float = 0.0) -> Mtf:
    """MTF of a ray grid.

    Args:
        rays: From `ray_grid`.
        frequencies: (K,) array_like. Cycles/mm, at least 0.
        method: {"diffraction", "geometric"}. By the pupil function, or by the landing points of the rays alone.
        shift: Of the film along +z, mm.
    Raises:
        LensError: For another method, and for frequencies that are negative, and frequencies and shifts that are not
            finite.
    """
    if method not in METHODS:
        raise LensError(f"MTF method {method!r}: choose one of {', '.join(METHODS)}")
    nu = np.atleast_1d(np.asarray(frequencies, float))
    if not (np.isfinite(nu).all() and (nu >= 0.0).all()):
        raise LensError("MTF frequencies must be finite and not negative")
    checked_shifts(shift)
    fields, colours = rays.opd.shape[:2]
    lines = 1e-3 * np.array(rays.conditions.wavelengths)
    otf = np.full((fields, colours, 2, nu.size), np.nan, complex)
    limit = np.full(otf.shape, np.nan)
    geometric = method == "geometric"
    pupils = pupil_functions(rays, shift)

    def fill(f: int) -> None:
        """The transfer functions of one field."""
        _transfer(pupils[:, f], rays.steps[f], lines, nu, otf[f], limit[f])
        if geometric:
            real, imaginary = np.empty((2, nu.size))
            for c in np.flatnonzero(rays.coverage[f].any((1, 2))):
                share = rays.weight[f, c] / rays.weight[f, c].sum()
                for a in (0, 1):
                    offset = rays.light[a, f, c] + shift * rays.light[2 + a, f, c]
                    _phasors(share.ravel(), offset.ravel(), nu, real, imaginary)
                    otf[f, c, a] = real + 1j * imaginary

    each_of(fill, np.flatnonzero(np.isfinite(rays.steps).all(1)).tolist())
    return Mtf(rays, method, shift, nu, otf, _white(otf, rays), limit, _sampling(rays, nu, shift))


def _white(values: np.ndarray, rays: RayGrid) -> np.ndarray:
    """(F, 2, K) the sum of the wavelengths' values (F, C, 2, K) with their light; NaN for a dark field."""
    made = np.einsum("fcak,fc->fak", np.where(np.isnan(values), 0.0, values), light_shares(rays))
    return np.where(rays.lit[:, None, None], made, np.nan)


def _sampling(rays: RayGrid, nu: np.ndarray, shift: float) -> tuple[Finding, ...]:
    """A finding where rays of neighbouring cells land more than half a period apart at the highest frequency."""
    apart = float(np.nanmax(neighbours_apart(rays, shift), initial=0.0))
    if not apart * float(nu.max(initial=0.0)) > HALF_PERIOD:
        return ()
    reach = HALF_PERIOD / apart
    return (Finding(Kind.SAMPLING, None, f"beyond {significant(reach, 2)} lp/mm neighbouring rays of some field land "
                                         "more than half a period apart: take more points across the pupil",
                    figures={"frequency": reach}),)


def neighbours_apart(rays: RayGrid, shift: float = 0.0) -> np.ndarray:
    """(F,) distance (mm) on the film between rays of neighbouring cells, which 98 % keep; NaN for a dark field."""
    far, gaps = np.zeros(len(rays.opd)), np.empty(rays.opd[0].size)
    for f in np.flatnonzero(rays.lit).tolist():
        for axis, (offset, slope) in enumerate(((rays.offset_t, rays.slope_t), (rays.offset_s, rays.slope_s))):
            known = gaps[:_gaps(offset[f], slope[f], shift, rays.victim[f], axis, gaps)]
            if known.size:
                # The quantile by a straight line between the two nearest
                position = KEPT * (known.size - 1)
                low = min(int(position), known.size - 2) if known.size > 1 else 0
                known.partition((low, min(low + 1, known.size - 1)))
                near, next_ = known[low], known[min(low + 1, known.size - 1)]
                far[f] = max(far[f], near + (position - low) * (next_ - near))
    return np.where(rays.lit, far, np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _gaps(offset, slope, shift, victim, axis, out):
    """Distances on the film between rays (C, N, N) of neighbouring cells along an axis into out; their number."""
    colours, rows, columns = offset.shape
    di, dj = (1, 0) if axis == 0 else (0, 1)
    count = 0
    for c in range(colours):
        for i in range(rows - di):
            for j in range(columns - dj):
                if victim[c, i, j] == -1 and victim[c, i + di, j + dj] == -1:
                    gap = abs(offset[c, i + di, j + dj] - offset[c, i, j]
                              + shift * (slope[c, i + di, j + dj] - slope[c, i, j]))
                    if gap < np.inf:
                        out[count] = gap
                        count += 1
    return count


def pupil_functions(rays: RayGrid, shift: float = 0.0) -> np.ndarray:
    """(2, F, C, 4, N + 2 PAD, N) pupil functions of a ray grid for a film shifted along +z (mm), without NaN.

    First axis: for shifts along the sagittal and the tangential axis, along its rows. Fourth axis: W in wavelengths,
    its change per cell along the rows, the open part of the cell, the square root of its light.
    """
    n = rays.opd.shape[-1]
    chief_z = np.sqrt(1.0 - (rays.chief_pupil**2).sum(1))
    waves = 1e3 / np.array(rays.conditions.wavelengths)
    root = np.sqrt(rays.intensity)
    made = np.zeros((2, *rays.opd.shape[:2], 4, n + 2 * PAD, n))
    opd = rays.grid_opd

    def fill(f: int) -> None:
        """The functions of one field."""
        _pupil_function(opd[f], rays.offset_s[f], rays.offset_t[f], rays.pupil[f], rays.steps[f], rays.coverage[f],
                        root[f], chief_z[f], waves, shift, made[0, f], made[1, f])

    each_of(fill, range(len(opd)))
    return made


@njit(cache=True, nogil=True, error_model="numpy")
def _pupil_function(opd, offset_s, offset_t, grid, steps, coverage, root, chief_z, waves, shift, along_s, along_t):
    """The functions of one field (C, 4, N + 2 PAD, N) for shifts along either axis, from its rays (C, N, N).

    grid: (2, N) pupil coordinates; steps: (2,) their spacing; root: (N, N) square root of the light; chief_z: of the
    chief ray; waves: (C,) wavelengths a mm. Unknown cells continue a neighbour's slope.
    """
    colours, rows, columns = opd.shape
    w, slope_s, slope_t = np.empty((rows, columns)), np.empty((rows, columns)), np.empty((rows, columns))
    for c in range(colours):
        for i in range(rows):
            for j in range(columns):
                s, t = grid[0, j], grid[1, i]
                z = np.sqrt(1.0 - s * s - t * t)
                w[i, j] = (opd[c, i, j] + shift * (chief_z - z)) * waves[c]
                slope_s[i, j] = (offset_s[c, i, j] + shift * s / z) * steps[0] * waves[c]
                slope_t[i, j] = (offset_t[c, i, j] + shift * t / z) * steps[1] * waves[c]
        for i in range(rows):
            for j in range(columns):
                value, s, t = w[i, j], slope_s[i, j], slope_t[i, j]
                if not value == value:
                    value, s, t = 0.0, 0.0, 0.0
                    for di, dj in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                        a, b = i + di, j + dj
                        if 0 <= a < rows and 0 <= b < columns and w[a, b] == w[a, b]:
                            s, t = slope_s[a, b], slope_t[a, b]
                            value = w[a, b] - dj * s - di * t
                share, light = coverage[c, i, j], root[i, j]
                for row, column, slope, out in ((j, i, s, along_s), (i, j, t, along_t)):
                    out[c, 0, PAD + row, column], out[c, 1, PAD + row, column] = value, slope
                    out[c, 2, PAD + row, column], out[c, 3, PAD + row, column] = share, light


@njit(cache=True, nogil=True, error_model="numpy")
def _transfer(pupils, steps, lines, nu, otf, limit):
    """OTF and limit (C, 2, K) of the pupil functions (2, C, 4, N + 2 PAD, N) of one field; NaN stays without light.

    steps: (2,) of the pupil coordinates. lines: (C,) wavelengths, mm. nu: (K,) cycles/mm.
    """
    real, imaginary = np.empty(nu.size), np.empty(nu.size)
    for c in range(lines.size):
        if pupils[0, c, 2].any():
            for a in range(2):
                autocorrelate(pupils[a, c], lines[c] / steps[a] * nu, real, imaginary, limit[c, a])
                for k in range(nu.size):
                    otf[c, a, k] = complex(real[k], imaginary[k])


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def autocorrelate(pupil, shifts, real, imaginary, ideal):
    """Autocorrelation of a pupil function (4, N + 2 PAD, N) at shifts (K,) in cells along its rows, over its light.

    Into real and imaginary (K,) the OTF, into ideal (K,) the MTF without W.
    """
    w, slope, cover, root = pupil[0], pupil[1], pupil[2], pupil[3]
    rows, columns = w.shape
    light = 0.0
    for i in range(rows):
        for j in range(columns):
            light += cover[i, j] * root[i, j] * root[i, j]
    for q in range(shifts.size):
        whole = int(floor(0.5 * shifts[q]))
        share = 0.5 * shifts[q] - whole
        # Hermite's cubic from the rows a = i + whole and a + 1 at `part`, mirrored for the other side
        rest = 1.0 - share
        h0, h1 = (1.0 + 2.0 * share) * rest * rest, share * share * (3.0 - 2.0 * share)
        g0, g1 = share * rest * rest, -share * share * rest
        re, im, overlap = 0.0, 0.0, 0.0
        for i in range(whole + 1, rows - whole - 1):
            # Rows about the two points: one compiled loop over each, without a look at the sign of an index
            a, b = i + whole, i - whole
            wa, wa1, wb, wb1 = w[a], w[a + 1], w[b], w[b - 1]
            sa, sa1, sb, sb1 = slope[a], slope[a + 1], slope[b], slope[b - 1]
            ca, ca1, cb, cb1 = cover[a], cover[a + 1], cover[b], cover[b - 1]
            ra, ra1, rb, rb1 = root[a], root[a + 1], root[b], root[b - 1]
            for j in range(columns):
                over = min(rest * ca[j] + share * ca1[j], rest * cb[j] + share * cb1[j])
                light_there = over * (rest * ra[j] + share * ra1[j]) * (rest * rb[j] + share * rb1[j])
                x = (h0 * (wa[j] - wb[j]) + h1 * (wa1[j] - wb1[j])
                     + g0 * (sa[j] + sb[j]) + g1 * (sa1[j] + sb1[j]))
                x = x - np.floor(x + 0.5)
                u = x * x
                cosine, sine = cosine_of_turns(u), x * sine_of_turns(u)
                re += light_there * cosine
                im += light_there * sine
                overlap += light_there
        real[q], imaginary[q], ideal[q] = re / light, im / light, overlap / light


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def _phasors(share, offset, nu, real, imaginary):
    """Σ share exp(2πi ν offset) over rays (n,) for frequencies nu (K,)."""
    for q in range(nu.size):
        re, im = 0.0, 0.0
        for i in range(share.size):
            x = nu[q] * offset[i]
            x = x - np.floor(x + 0.5)
            u = x * x
            re += share[i] * cosine_of_turns(u)
            im += share[i] * x * sine_of_turns(u)
        real[q], imaginary[q] = re, im


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def cosine_of_turns(u):
    """Cosine of 2πx for u = x², |x| ≤ 1/2, by its series: to 4e-9. The compiler vectorises it, unlike the library's."""
    return 1.0 + u * (-19.739208802178716 + u * (64.93939402266829 + u * (-85.45681720669373 + u * (
        60.24464137187666 + u * (-26.42625678337438 + u * (7.903536371318467 + u * (-1.7143907110886722 + u * (
            0.28200596845579096 - u * 0.03638284106432425))))))))


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def sine_of_turns(u):
    """Sine of 2πx over x for u = x², |x| ≤ 1/2, as `cosine_of_turns`."""
    return 6.283185307179586 + u * (-41.34170224039976 + u * (81.60524927607506 + u * (-76.70585975306139 + u * (
        42.058693944897634 + u * (-15.094642576822984 + u * (3.8199525848482803 + u * (-0.7181223017785002 + u * (
            0.10422916220813986 - u * 0.012031585942120627))))))))
