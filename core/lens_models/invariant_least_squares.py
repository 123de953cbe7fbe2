"""Least-squares fit and evaluation of rotation-invariant vector fields: polynomials of three invariants.

A field is F u + G v along the film and H along the axis, with polynomials F, G and H of a = u·u, b = v·v and c = u·v. A
product of monomials is a monomial, so the normal equations consist of the few moments Σ w aⁱ bʲ cᵏ.
"""

import math

import numpy as np

from lensbench.core.kernels.cache import njit

RIDGE = 1e-14               # smallest pivot, relative to the normal equations' diagonal
_FAST = {"contract", "reassoc", "nsz"}


@njit(cache=True, error_model="numpy", nogil=True)
def monomial_index(i, j, k, n):
    """Index of aⁱ bʲ cᵏ among the monomials up to the total degree n, in the order in which the kernels sum them."""
    p, q, r = n - i, n - i - j, n - i - j - k
    return p * (p + 1) * (p + 2) // 6 + q * (q + 1) // 2 + r


@njit(cache=True, error_model="numpy", nogil=True, fastmath=_FAST)
def _moments(abc, weights, fields, n, low):
    """Moments (2 n + 2)³ up to the degree 2 n + 1, and the right sides (3, terms) of both fields.

    abc: (3, rays); weights: (rays,); fields: (6, rays), along u, v and z of a field of degree n, then of one of degree
    low.
    """
    rays, top = weights.size, 2 * n + 2
    moments = np.zeros((top, top, top))
    high_right = np.zeros((3, monomial_index(0, 0, 0, n) + 1))
    low_right = np.zeros((3, monomial_index(0, 0, 0, low) + 1))
    of_a, of_ab, row = weights.copy(), np.empty(rays), np.empty(rays)
    for i in range(top):
        for r in range(rays):
            of_ab[r] = of_a[r]
            of_a[r] *= abc[0, r]
        for j in range(top - i):
            for r in range(rays):
                row[r] = of_ab[r]
                of_ab[r] *= abc[1, r]
            for k in range(top - i - j):
                for of in range(2):
                    degree, right = (n, high_right) if of == 0 else (low, low_right)
                    if i + j + k <= degree:
                        t = monomial_index(i, j, k, degree)
                        x, y, z = 0.0, 0.0, 0.0
                        for r in range(rays):
                            x += row[r] * fields[3 * of, r]
                            y += row[r] * fields[3 * of + 1, r]
                            z += row[r] * fields[3 * of + 2, r]
                        right[0, t], right[1, t], right[2, t] = x, y, z
                total = 0.0
                for r in range(rays):
                    total += row[r]
                    row[r] *= abc[2, r]
                moments[i, j, k] = total
    return moments, high_right, low_right


@njit(cache=True, error_model="numpy", nogil=True)
def _solve_normal_equations(moments, right, n):
    """Polynomials (3, terms) along u, v and z that solve the normal equations of degree n, those of u and v coupled."""
    # Exponents of every monomial
    k = right.shape[1]
    of_a, of_b, of_c = np.empty(k, np.int64), np.empty(k, np.int64), np.empty(k, np.int64)
    for i in range(n + 1):
        for j in range(n + 1 - i):
            for m in range(n + 1 - i - j):
                t = monomial_index(i, j, m, n)
                of_a[t], of_b[t], of_c[t] = i, j, m
    # Normal matrices from the moments, with the right side as the last column
    across, plain = np.zeros((2 * k, 2 * k + 1)), np.zeros((k, k + 1))
    for s in range(k):
        for t in range(k):
            i, j, m = of_a[s] + of_a[t], of_b[s] + of_b[t], of_c[s] + of_c[t]
            plain[s, t] = moments[i, j, m]
            across[s, t] = moments[i + 1, j, m]
            across[s, k + t] = moments[i, j, m + 1]
            across[k + s, k + t] = moments[i, j + 1, m]
        across[s, 2 * k], across[k + s, 2 * k], plain[s, k] = right[0, s], right[1, s], right[2, s]
    _cholesky(across)
    _cholesky(plain)
    coefficients = np.empty((3, k))
    for s in range(k):
        coefficients[0, s], coefficients[1, s], coefficients[2, s] = across[s, 2 * k], across[k + s, 2 * k], plain[s, k]
    return coefficients


@njit(cache=True, error_model="numpy", nogil=True, fastmath=_FAST)
def _cholesky(m):
    """Solve in place: m (n, n + 1) holds the upper half of a positive matrix; its last column becomes the solution."""
    n = m.shape[0]
    least = np.empty(n)
    for i in range(n):
        least[i] = RIDGE * m[i, i]
    for i in range(n):
        row = m[i]
        share = 1.0 / math.sqrt(max(row[i], least[i]))
        for j in range(i, n + 1):
            row[j] *= share
        row[i] = 1.0 / share
        for k in range(i + 1, n):
            other, factor = m[k], row[k]
            for j in range(k, n + 1):
                other[j] -= factor * row[j]
    for i in range(n - 1, -1, -1):
        row = m[i]
        total = row[n]
        for k in range(i + 1, n):
            total -= row[k] * m[k, n]
        row[n] = total / row[i]


def fit_vector_fields(abc: np.ndarray, weights: np.ndarray, fields: np.ndarray, n: int,
                      low: int) -> tuple[np.ndarray, np.ndarray]:
    """Polynomials (3, terms) of degree n of one vector field, and (3, terms) of degree low ≤ n of another.

    abc: (3, rays) invariants, for u along the film's x; weights: (rays,); fields: (6, rays) as for `_moments`.
    """
    moments, high_right, low_right = _moments(abc, weights, fields, n, low)
    return _solve_normal_equations(moments, high_right, n), _solve_normal_equations(moments, low_right, low)


@njit(cache=True, error_model="numpy", nogil=True, fastmath=_FAST)
def evaluate_polynomials(abc, polynomials, n):
    """Values (3, rays) of three polynomials (3, terms) of degree n."""
    rays = abc.shape[1]
    of_a, of_ab, row, out = np.ones(rays), np.empty(rays), np.empty(rays), np.zeros((3, rays))
    for i in range(n + 1):
        for r in range(rays):
            of_ab[r] = of_a[r]
            of_a[r] *= abc[0, r]
        for j in range(n + 1 - i):
            for r in range(rays):
                row[r] = of_ab[r]
                of_ab[r] *= abc[1, r]
            for k in range(n + 1 - i - j):
                t = monomial_index(i, j, k, n)
                for r in range(rays):
                    out[0, r] += polynomials[0, t] * row[r]
                    out[1, r] += polynomials[1, t] * row[r]
                    out[2, r] += polynomials[2, t] * row[r]
                    row[r] *= abc[2, r]
    return out
