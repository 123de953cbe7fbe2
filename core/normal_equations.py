"""Least squares for a vector field that is rotation invariant: the normal equations of three polynomials."""

import math

import numpy as np
from numba import njit

RIDGE = 1e-14               # of the normal equations' diagonal: a pivot is not let below
TOGETHER = 4                # rays whose sums are taken at once


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def solved(basis, weights, u, v, wanted):
    """The polynomials of a vector field (3, rays) along u (rays,), along v (2, rays) and along z: (3, terms).

    The normal equations, of the first two together, by Cholesky's method; a pivot that rounding has
    made nothing is held up. (A thread of its own for the sums would cost more than the sums.)
    """
    rays, k = basis.shape
    across, plain = np.zeros((2 * k, 2 * k + 1)), np.zeros((k, k + 1))      # with the right side as the last column
    x, w, f = np.empty((TOGETHER, k)), np.empty(TOGETHER), np.empty((3, TOGETHER))
    for first in range(0, rays, TOGETHER):
        for q in range(TOGETHER):
            r = min(first + q, rays - 1)
            x[q], w[q] = basis[r], weights[r] if first + q < rays else 0.0
            f[0, q] = u[r] * u[r]
            f[1, q] = v[0, r] * v[0, r] + v[1, r] * v[1, r]
            f[2, q] = u[r] * v[0, r]
            along_u = w[q] * u[r] * wanted[0, r]
            along_v = w[q] * (v[0, r] * wanted[0, r] + v[1, r] * wanted[1, r])
            along_z = w[q] * wanted[2, r]
            for i in range(k):
                across[i, 2 * k] += along_u * x[q, i]
                across[k + i, 2 * k] += along_v * x[q, i]
                plain[i, k] += along_z * x[q, i]
        x0, x1, x2, x3 = x[0], x[1], x[2], x[3]
        for i in range(k):
            w0, w1, w2, w3 = w[0] * x0[i], w[1] * x1[i], w[2] * x2[i], w[3] * x3[i]
            one, upper, lower, mixed = plain[i], across[i], across[k + i, k:], across[k + i]
            for j in range(i + 1):
                y0, y1, y2, y3 = w0 * x0[j], w1 * x1[j], w2 * x2[j], w3 * x3[j]
                one[j] += (y0 + y1) + (y2 + y3)
                upper[j] += (f[0, 0] * y0 + f[0, 1] * y1) + (f[0, 2] * y2 + f[0, 3] * y3)
                lower[j] += (f[1, 0] * y0 + f[1, 1] * y1) + (f[1, 2] * y2 + f[1, 3] * y3)
                mixed[j] += (f[2, 0] * y0 + f[2, 1] * y1) + (f[2, 2] * y2 + f[2, 3] * y3)
    for i in range(k):
        across[k:k + i, i] = across[k + i, :i]              # of a symmetric block, the other half
    found = np.empty((3, k))
    _cholesky(across)
    _cholesky(plain)
    found[0], found[1], found[2] = across[:k, 2 * k], across[k:, 2 * k], plain[:, k]
    return found


@njit(cache=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _cholesky(m):
    """Solve in place: the lower half of m (n, n + 1) is a positive matrix, its last column becomes the solution."""
    n = m.shape[0]
    for i in range(n):
        least = RIDGE * m[i, i]
        for j in range(i + 1):
            total = m[i, j]
            for k in range(j):
                total -= m[i, k] * m[j, k]
            m[i, j] = math.sqrt(max(total, least)) if i == j else total / m[j, j]
        total = m[i, n]
        for k in range(i):
            total -= m[i, k] * m[k, n]
        m[i, n] = total / m[i, i]
    for i in range(n - 1, -1, -1):
        total = m[i, n]
        for k in range(i + 1, n):
            total -= m[k, i] * m[k, n]
        m[i, n] = total / m[i, i]
