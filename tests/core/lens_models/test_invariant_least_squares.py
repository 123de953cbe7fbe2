"""Least squares of vector fields, against numpy's own and against fields that are polynomials."""

import numpy as np
import pytest

from lensbench.core.lens_models.invariant_least_squares import evaluate_polynomials, fit_vector_fields, monomial_index
from lensbench.core.lens_models.polynomial import monomial_count

RAYS = 400


def rays():
    """Invariants (3, RAYS) and what they are made of: u along x, and v (2, RAYS), within the unit disk."""
    random = np.random.default_rng(4)
    u, reach, turn = random.random(RAYS), np.sqrt(random.random(RAYS)), np.pi * random.random(RAYS)
    v = reach * np.stack([np.cos(turn), np.sin(turn)])
    return np.stack([u * u, (v**2).sum(0), u * v[0]]), u, v, random


def monomials(abc, n):
    """(RAYS, terms) in the order of `monomial_index`."""
    columns = {monomial_index(i, j, k, n): abc[0]**i * abc[1]**j * abc[2]**k
               for i in range(n + 1) for j in range(n + 1 - i) for k in range(n + 1 - i - j)}
    assert sorted(columns) == list(range(monomial_count(n)))                 # each has a place of its own
    return np.stack([columns[t] for t in range(monomial_count(n))], 1)


def fields(u, v, wanted):
    return [u * wanted[0], v[0] * wanted[0] + v[1] * wanted[1], wanted[2]]


@pytest.mark.slow
@pytest.mark.parametrize(("n", "low"), [(1, 1), (4, 3), (5, 4)])
def test_the_fit_is_the_least_squares_of_the_whole_field(n, low):
    """Orthogonal factors of the rays' own equations, both parts across the axis at once: none is squared there."""
    abc, u, v, random = rays()
    weights, wanted = random.random(RAYS), random.standard_normal((2, 3, RAYS))
    found = fit_vector_fields(abc, weights, np.array([*fields(u, v, wanted[0]), *fields(u, v, wanted[1])]), n, low)
    root = np.sqrt(weights)
    for degree, field, polynomials in zip((n, low), wanted, found, strict=True):
        basis = monomials(abc, degree)
        across = np.concatenate([np.hstack([basis * u[:, None], basis * v[0][:, None]]),
                                 np.hstack([0.0 * basis, basis * v[1][:, None]])])
        both = np.linalg.lstsq(across * np.tile(root, 2)[:, None], field[:2].ravel() * np.tile(root, 2), rcond=None)[0]
        along = np.linalg.lstsq(basis * root[:, None], field[2] * root, rcond=None)[0]
        values = np.concatenate([across @ both, basis @ along]).reshape(3, RAYS)
        f, g, h = (basis @ polynomials.T).T
        mine = np.stack([f * u + g * v[0], g * v[1], h])
        # Squared, the equations keep half the digits: 1e-14 of a condition of 1e9 at degree 5, less below
        np.testing.assert_allclose(mine, values, atol=1e-5)
        np.testing.assert_allclose(evaluate_polynomials(abc, polynomials, degree), [f, g, h], rtol=0.0,
                                   atol=1e-12 * np.abs(polynomials).max())


def test_a_field_that_is_a_polynomial_is_found():
    abc, u, v, random = rays()
    f, g, h = random.standard_normal((3, monomial_count(3))) @ monomials(abc, 3).T
    field = np.stack([f * u + g * v[0], g * v[1], h])
    here, _ = fit_vector_fields(abc, np.ones(RAYS), np.array([*fields(u, v, field), *fields(u, v, field)]), 3, 3)
    np.testing.assert_allclose(evaluate_polynomials(abc, here, 3), [f, g, h], atol=1e-7)          # half of the digits
