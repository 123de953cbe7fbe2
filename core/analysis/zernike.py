"""Zernike polynomials on the unit disk: indices, names and values.

Coordinates x (sagittal) and y (tangential) in radii of the disk; the azimuth runs from +x towards +y. All are of unit
rms over the disk, as Noll has them. Fringe polynomials are named by the same order and azimuth, and are scaled to 1 at
the rim of the disk.

References
----------
R. J. Noll, "Zernike polynomials and atmospheric turbulence", J. Opt. Soc. Am. 66 (1976).
"""

from functools import lru_cache
from math import factorial, sqrt

import numpy as np

from lensbench.kernels.cache import njit

NAMES = {(0, 0): "piston", (1, 1): "tilt", (2, 0): "defocus", (2, 2): "astigmatism", (3, 1): "coma",
         (3, 3): "trefoil", (4, 0): "spherical aberration", (4, 2): "secondary astigmatism", (4, 4): "tetrafoil",
         (5, 1): "secondary coma", (5, 3): "secondary trefoil", (5, 5): "pentafoil",
         (6, 0): "secondary spherical aberration", (6, 2): "tertiary astigmatism", (6, 4): "secondary tetrafoil",
         (6, 6): "hexafoil", (8, 0): "tertiary spherical aberration"}


def noll_indices(j: int) -> tuple[int, int]:
    """Order and frequency of a Zernike polynomial in Noll's order (J. Opt. Soc. Am. 66, 1976).

    Parameters
    ----------
    j : int
        Noll's index, from 1.

    Returns
    -------
    n, m : int
        Radial order and azimuthal frequency; m < 0 for a sine.
    """
    n = int((sqrt(8 * j - 7) - 1) // 2)
    k = j - n * (n + 1) // 2 - 1
    m = 2 * ((k + 1) // 2) if n % 2 == 0 else 2 * (k // 2) + 1
    return n, m if j % 2 == 0 or m == 0 else -m


def fringe_index(n: int, m: int) -> int:
    """Index of a Zernike polynomial in the fringe order.

    Parameters
    ----------
    n : int
        Radial order.
    m : int
        Azimuthal frequency; negative for a sine.

    Returns
    -------
    int, from 1
    """
    a = abs(m)
    return (1 + (n + a) // 2) ** 2 - 2 * a + (1 if m < 0 else 0)


def zernike_name(n: int, m: int) -> str:
    """The aberration of a Zernike polynomial in words.

    Parameters
    ----------
    n : int
        Radial order.
    m : int
        Azimuthal frequency; negative for a sine.

    Returns
    -------
    str
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


def zernikes(count: int, x, y) -> np.ndarray:
    """Zernike polynomials in Noll's order and normalisation.

    Parameters
    ----------
    count : int
        How many, from piston on.
    x, y : float or array
        Points of any shape, in radii of the disk.

    Returns
    -------
    (count, …) array
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
        row, part = out[j], powers[1 if orders[j, 1] < 0 else 0, m]
        row[:] = 0.0
        for k in range((orders[j, 0] - m) // 2 + 1):
            factor = coefficients[j, k]
            for i in range(n):
                row[i] = row[i] * r2[i] + factor
        for i in range(n):
            row[i] *= part[i]
