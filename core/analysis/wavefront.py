"""The wavefront in the exit pupil: maps, Zernike coefficients, rms and Strehl ratio.

Lengths in mm; frame and sign are those of the ray grid. The Zernike disk of a field has the middle of the open pupil's
extents and half the longer of them as its radius, in the primary wavelength. A vignetted pupil is fitted over its open
part, so its coefficients depend on their number. Zernike coordinates x (sagittal) and y (tangential) are in radii of
the disk, the azimuth from +x towards +y. All are of unit rms over the disk, as Noll has them; fringe polynomials are
scaled to 1 at its edge.

References:
    V. N. Mahajan, J. Opt. Soc. Am. 72 (1982), for the Strehl ratio; R. J. Noll, J. Opt. Soc. Am. 66 (1976).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import cos, factorial, pi, sin, sqrt

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import each_of
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.lens_surface import LensError

NAMES = {(0, 0): "piston", (1, 1): "tilt", (2, 0): "defocus", (2, 2): "astigmatism", (3, 1): "coma",
         (3, 3): "trefoil", (4, 0): "spherical aberration", (4, 2): "secondary astigmatism", (4, 4): "tetrafoil",
         (5, 1): "secondary coma", (5, 3): "secondary trefoil", (5, 5): "pentafoil",
         (6, 0): "secondary spherical aberration", (6, 2): "tertiary astigmatism", (6, 4): "secondary tetrafoil",
         (6, 6): "hexafoil", (8, 0): "tertiary spherical aberration"}


def noll_indices(j: int) -> tuple[int, int]:
    """Order and frequency of a Zernike polynomial in Noll's order (J. Opt. Soc. Am. 66, 1976).

    Args:
        j: Noll's index, from 1.
    Returns:
        n, m: Radial order and azimuthal frequency; m < 0 for a sine.
    """
    n = int((sqrt(8 * j - 7) - 1) // 2)
    k = j - n * (n + 1) // 2 - 1
    m = 2 * ((k + 1) // 2) if n % 2 == 0 else 2 * (k // 2) + 1
    return n, m if j % 2 == 0 or m == 0 else -m


def fringe_index(n: int, m: int) -> int:
    """Index of a Zernike polynomial in the fringe order.

    Args:
        n: Radial order.
        m: Azimuthal frequency; negative for a sine.
    Returns:
        int, from 1.
    """
    a = abs(m)
    return (1 + (n + a) // 2) ** 2 - 2 * a + (1 if m < 0 else 0)


def zernike_name(n: int, m: int) -> str:
    """The aberration of a Zernike polynomial in words.

    Args:
        n: Radial order.
        m: Azimuthal frequency; negative for a sine.
    Returns:
        Such as "coma, sine".
    """
    known = NAMES.get((n, abs(m)), f"order {n}, frequency {abs(m)}")
    return known if m == 0 else f"{known}, {'sine' if m < 0 else 'cosine'}"


@lru_cache
def radial_coefficients(n: int, m: int) -> tuple[int, ...]:
    """Coefficients of r^n, r^(n − 2), … of the radial polynomial, which is 1 at r = 1."""
    m = abs(m)
    return tuple((-1)**k * factorial(n - k)
                 // (factorial(k) * factorial((n + m) // 2 - k) * factorial((n - m) // 2 - k))
                 for k in range((n - m) // 2 + 1))


def zernikes(count: int, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """Zernike polynomials in Noll's order and normalisation.

    Args:
        count: How many, from piston on.
        x, y: float or array. Points of any shape, in radii of the disk.
    Returns:
        (count, …) array.
    """
    x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
    out = np.empty((count, x.size))
    _fill(np.ascontiguousarray(x.ravel()), np.ascontiguousarray(y.ravel()), *_table(count), out)
    return out.reshape(count, *x.shape)


@lru_cache
def _table(count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count, 2) n and m, and (count, n / 2 + 1) scaled coefficients of the radial polynomials over r^|m|."""
    orders = np.array([noll_indices(j) for j in range(1, count + 1)], np.int64).reshape(count, 2)
    coefficients = np.zeros((count, noll_indices(count)[0] // 2 + 1))
    for row, (n, m) in zip(coefficients, orders, strict=True):
        radial = radial_coefficients(int(n), int(m))
        row[:len(radial)] = np.array(radial) * (sqrt(n + 1) * (1.0 if m == 0 else sqrt(2.0)))
    return orders, coefficients


@njit(cache=True, nogil=True, error_model="numpy")
def _fill(x, y, orders, coefficients, out):
    """Polynomials (k, n) at points x, y (n,), by Horner's rule in r²: one compiled loop over the points for each."""
    n, highest = x.size, 0
    for j in range(orders.shape[0]):
        highest = max(highest, abs(orders[j, 1]))
    r2, powers = np.empty(n), np.empty((2, highest + 1, n))             # (x + i y)^m, real and imaginary
    for i in range(n):
        r2[i] = x[i] * x[i] + y[i] * y[i]
        powers[0, 0, i], powers[1, 0, i] = 1.0, 0.0
    for m in range(1, highest + 1):
        for i in range(n):
            powers[0, m, i] = powers[0, m - 1, i] * x[i] - powers[1, m - 1, i] * y[i]
            powers[1, m, i] = powers[0, m - 1, i] * y[i] + powers[1, m - 1, i] * x[i]
    for j in range(orders.shape[0]):
        m = abs(orders[j, 1])
        row, azimuthal = out[j], powers[1 if orders[j, 1] < 0 else 0, m]
        row[:] = 0.0
        for k in range((orders[j, 0] - m) // 2 + 1):
            factor = coefficients[j, k]
            for i in range(n):
                row[i] = row[i] * r2[i] + factor
        for i in range(n):
            row[i] *= azimuthal[i]


TERMS = 37              # Noll polynomials, complete to the seventh order with one of the eighth (37: spherical)
ENOUGH = 2.0            # open cells for each term
FAST = {"contract", "nsz", "arcp", "reassoc"}       # of fast arithmetic, what keeps NaN and infinity


@dataclass(frozen=True, eq=False)
class Wavefront:
    """Wavefronts of F fields and C wavelengths, from `wavefronts`; NaN where no light falls.

    Args:
        rays: The ray grid.
        centres: (F, 2) middle of the Zernike disk in pupil coordinates, sagittal and tangential.
        radii: (F,) radius of the disk, in the same.
        noll: (F, C, J) coefficients of Noll's polynomials 1 … J, mm: of unit rms over the whole disk.
        residual: (F, C) rms of what the polynomials leave, mm.
        rms: (F, C) rms of W over the open pupil without piston and tilt, mm: about the best image point.
        peak_to_valley: (F, C) range of W over the open pupil, without piston and tilt, mm.
        strehl: (F, C) Strehl ratio at the best point of the film: |mean of exp(2πi W / λ)|² over the light, W without
            tilt.
    """

    rays: RayGrid
    centres: np.ndarray
    radii: np.ndarray
    noll: np.ndarray
    residual: np.ndarray
    rms: np.ndarray
    peak_to_valley: np.ndarray
    strehl: np.ndarray

    @property
    def fringe(self) -> np.ndarray:
        """(F, C, J) coefficients of the same polynomials scaled to 1 at the rim, in Noll's order, mm.

        `zernike.fringe_index` gives the fringe index of each.
        """
        return self.noll * fringe_scale(self.noll.shape[-1])

    @cached_property
    def waves(self) -> np.ndarray:
        """(F, C, N, N) W on the grid in wavelengths, NaN outside the open pupil."""
        line = 1e-3 * np.array(self.rays.conditions.wavelengths)[:, None, None]
        return np.where(self.rays.coverage > 0.0, self.rays.grid_opd / line, np.nan)

    @property
    def rms_waves(self) -> np.ndarray:
        """(F, C) the rms in wavelengths of each colour."""
        return self.rms / (1e-3 * np.array(self.rays.conditions.wavelengths))


def fringe_scale(count: int) -> np.ndarray:
    """(count,) value at the rim of Noll's polynomials 1 … count, in their order."""
    scale = []
    for j in range(1, count + 1):
        n, m = noll_indices(j)
        assert sum(radial_coefficients(n, m)) == 1
        scale.append(np.sqrt(n + 1) * (1.0 if m == 0 else np.sqrt(2.0)))
    return np.array(scale)


def wavefronts(rays: RayGrid, terms: int = TERMS) -> Wavefront:
    """Wavefronts of a ray grid.

    Args:
        rays: From `ray_grid`.
        terms: Number of Zernike polynomials, from 4.
    Returns:
        Without light enough for the fit (two open cells a term) the coefficients are NaN; the other figures stand.
    Raises:
        LensError: For fewer than 4 terms.
    """
    if terms < 4:
        raise LensError(f"{terms} Zernike terms: at least 4 are needed")
    fields, colours, n, _ = rays.opd.shape
    ends = open_extents(rays)
    centres, radii = ends.mean(2), 0.5 * (ends[:, :, 1] - ends[:, :, 0]).max(1)
    noll = np.full((fields, colours, terms), np.nan)
    residual, rms, range_, strehl = (np.full((fields, colours), np.nan) for _ in range(4))
    opd, light = rays.grid_opd, rays.coverage * rays.intensity[:, None]
    lines = 1e-3 * np.array(rays.conditions.wavelengths)
    waves = 2.0 * pi / lines
    half, edge = _within_cells(rays)
    x, y = ((rays.pupil[:, a] - centres[:, a, None]) / radii[:, None] for a in (0, 1))

    def fill(f: int) -> None:
        """The figures of one field."""
        good = ((rays.coverage[f] > 0.0) & np.isfinite(opd[f])).any(0)
        rows, columns = np.nonzero(good)
        middle, on_rim = half[:, f, rows, columns], edge[:, f, rows, columns]
        basis = zernikes(terms, x[f][columns] + middle[0] / radii[f], y[f][rows] + middle[1] / radii[f])
        _field(basis, opd[f], rays.offset_s[f], rays.offset_t[f], middle, on_rim, 2.0 / radii[f], rays.coverage[f],
               light[f], rows, columns, waves, ENOUGH * terms, noll[f], residual[f], rms[f], range_[f], strehl[f])

    each_of(fill, np.flatnonzero(np.isfinite(radii)).tolist())
    return Wavefront(rays, centres, radii, noll, residual, rms, range_, strehl)


def _within_cells(rays: RayGrid) -> tuple[np.ndarray, np.ndarray]:
    """Points (2, F, N, N) from the middles of cells in pupil coordinates: for sums over the pupil, and for extremes.

    In a vignetted cell halfway to the centroid of its open part, as in `RayGrid.light`, and on the edge.
    """
    centre, share = (values[..., rays.conditions.primary, :, :] for values in (rays.open_centre, rays.coverage))
    size, steps = np.abs(centre).max(0), rays.steps.T[:, :, None, None]
    to_rim = np.divide(0.5 - share, size, out=np.zeros_like(size), where=(size > 0.0) & (share < 1.0))
    return 0.5 * centre * steps, centre * to_rim * steps


def open_extents(rays: RayGrid) -> np.ndarray:
    """(F, 2, 2) low and high end of the open pupil, sagittal and tangential, in the primary wavelength; NaN if dark."""
    coverage = rays.coverage[:, rays.conditions.primary]
    n = coverage.shape[1]
    ends = np.full((len(coverage), 2, 2), np.nan)
    for a in (0, 1):
        widest = coverage.max(1 + a)                    # of each column, or row
        lit = widest > 0.0
        first, last = lit.argmax(1), n - 1 - lit[:, ::-1].argmax(1)
        row = np.arange(len(coverage))
        low, high = first + 1.0 - widest[row, first], last + widest[row, last]
        cells = np.stack([low, high], 1)
        ends[:, a] = rays.pupil[:, a, :1] + (cells - 0.5) * rays.steps[:, a, None]
    return np.where(rays.lit[:, None, None], ends, np.nan)


@njit(fastmath=FAST, error_model="numpy", cache=True, nogil=True)
def _fit(basis, w, share, out):
    """Coefficients of W (n,) by the basis (k, n) into out (k,): the normal equations, by Cholesky's factors.

    BLAS would take longer to wake its threads.
    """
    k, n = basis.shape
    normal, weighted = np.empty((k, k)), np.empty(n)
    for i in range(k):
        right = 0.0
        for q in range(n):
            weighted[q] = basis[i, q] * share[q]
            right += weighted[q] * w[q]
        out[i] = right
        for j in range(i + 1):
            total = 0.0
            for q in range(n):
                total += weighted[q] * basis[j, q]
            normal[i, j] = total
    for i in range(k):
        for j in range(i + 1):
            total = normal[i, j]
            for q in range(j):
                total -= normal[i, q] * normal[j, q]
            normal[i, j] = sqrt(total) if i == j else total / normal[j, j]
        for q in range(i):
            out[i] -= normal[i, q] * out[q]
        out[i] /= normal[i, i]
    for i in range(k - 1, -1, -1):
        for q in range(i + 1, k):
            out[i] -= normal[q, i] * out[q]
        out[i] /= normal[i, i]


@njit(fastmath=FAST, error_model="numpy", cache=True, nogil=True)
def _field(basis, opd, offset_s, offset_t, half, edge, tilt, cover, light, rows, columns, waves, enough, noll, residual,
           rms, range_, strehl):
    """Results of one field in each wavelength, into the last five arguments: (C, k), and (C,) each.

    basis: (k, n) polynomials in the open cells rows, columns (n,), half (2, n) from their middles. opd, offset_s,
    offset_t, cover, light: (C, N, N). edge: (2, n) where W may be extreme; tilt: slope of the second and third
    polynomial. waves: (C,) radians a mm of path. enough: open cells that the fit of all polynomials needs.
    """
    k, n = basis.shape
    w, weights, flat, coefficients = np.empty(n), np.empty(n), np.empty(n), np.empty(k)
    for c in range(opd.shape[0]):
        # The open cells, and their parts
        count, total = 0, 0.0
        for q in range(n):
            i, j = rows[q], columns[q]
            value = opd[c, i, j] + half[0, q] * offset_s[c, i, j] + half[1, q] * offset_t[c, i, j]
            share = cover[c, i, j]
            known = share > 0.0 and value == value
            w[q], weights[q] = (value, share) if known else (0.0, 0.0)
            count += known
            total += weights[q]
        if count < 4:
            continue
        for q in range(n):
            weights[q] /= total

        # Without piston and tilt: rms, range and Strehl ratio
        _fit(basis[:3], w, weights, coefficients[:3])
        square, low, high, real, imaginary, bright = 0.0, np.inf, -np.inf, 0.0, 0.0, 0.0
        for q in range(n):
            flat[q] = (w[q] - coefficients[0] * basis[0, q] - coefficients[1] * basis[1, q]
                       - coefficients[2] * basis[2, q])
            square += weights[q] * flat[q] * flat[q]
            there = light[c, rows[q], columns[q]]
            bright += there
            real += there * cos(waves[c] * flat[q])
            imaginary += there * sin(waves[c] * flat[q])
        for q in range(n):
            if weights[q] > 0.0:
                i, j = rows[q], columns[q]
                there = (flat[q] + (edge[0, q] - half[0, q]) * (offset_s[c, i, j] - coefficients[1] * tilt)
                         + (edge[1, q] - half[1, q]) * (offset_t[c, i, j] - coefficients[2] * tilt))
                low, high = min(low, there), max(high, there)
        rms[c], range_[c] = sqrt(square), high - low
        strehl[c] = (real * real + imaginary * imaginary) / (bright * bright)
        if count < enough:
            continue

        # The coefficients, and what they leave
        _fit(basis, w, weights, coefficients)
        flat[:] = w
        for j in range(k):
            noll[c, j] = coefficients[j]
            for q in range(n):
                flat[q] -= coefficients[j] * basis[j, q]
        square = 0.0
        for q in range(n):
            square += weights[q] * flat[q] * flat[q]
        residual[c] = sqrt(square)
