"""The stage of a fitted lens: from an aimed ray at the film to the ray in front of the lens by six polynomials.

Each is a polynomial of the invariants a, b and c of `polynomial`, summed up by Horner's rule. One kernel serves all
degrees. Camera frame, mm.
"""

from lensbench.kernels.block import A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, B, L, M, N, X, Y, Z, rows, stage
from lensbench.kernels.cache import njit

# Parameters of the stage: −film distance over the reach of the aim, (1 − drift) over that reach (1/mm), 1 / film radius
# (1/mm), z of the centre (mm), 1 / distance from it to objects in focus (1/mm), coefficients of F, G, H, P, Q and R
DISTANCE_SHARE, DRIFT_SHARE, INVERSE_RADIUS, CENTRE_Z, NEARNESS, COEFFICIENTS = range(6)
DIRECTION_DEGREE, POSITION_DEGREE = range(2)        # integers: degrees in a, b and c of F, G, H and of P, Q, R


def monomial_count(n: int) -> int:
    """Number of monomials of three variables up to the total degree n."""
    return (n + 1) * (n + 2) * (n + 3) // 6


def position_degree(n: int) -> int:
    """Degree in a, b and c of the positions."""
    return min(n, max(n - 1, 2))


@njit(inline="always")
def _of_two(q, k, b, c, n, real):
    """Terms of one power of a: all monomials in b and c up to the degree n, by Horner's rule."""
    total = real(0)
    for j in range(n + 1):
        part = q[k]
        k += 1
        for _ in range(j):
            part = part * c + q[k]
            k += 1
        total = total * b + part
    return total


@stage
def polynomial(lanes, p, ints, key):
    """Replace the ray at the film by the ray in front of the lens.

    p: DISTANCE_SHARE and so on. ints: DIRECTION_DEGREE, POSITION_DEGREE.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    a, b, c, total = row[A0], row[A1], row[A2], row[A3]
    f, g, h, pu, pv, pw = row[A4], row[A5], row[A6], row[A7], row[A8], row[A9]
    reach, drift, scale = p[DISTANCE_SHARE], p[DRIFT_SHARE], p[INVERSE_RADIUS]
    centre, near = p[CENTRE_Z], p[NEARNESS]
    # Invariants of the film point u and the aim v
    for i in range(B):
        ux, uy = x[i] * scale, y[i] * scale
        away = reach / n_[i]
        vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
        a[i], b[i], c[i] = ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy
    # Polynomials F, G and H of the direction, then P, Q and R of the position: a loop for each power of a, whose
    # coefficients are so few that they stay in registers
    at = COEFFICIENTS
    for k in range(6):
        n = ints[DIRECTION_DEGREE] if k < 3 else ints[POSITION_DEGREE]
        q = p[at:]
        for i in range(B):
            total[i] = q[0] * a[i] + _of_two(q, 1, b[i], c[i], 1, real)
        if n >= 2:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 4, b[i], c[i], 2, real)
        if n >= 3:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 10, b[i], c[i], 3, real)
        if n >= 4:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 20, b[i], c[i], 4, real)
        if n >= 5:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 35, b[i], c[i], 5, real)
        value = row[A4 + k]
        for i in range(B):
            value[i] = total[i]
        at += (n + 1) * (n + 2) * (n + 3) // 6
    for i in range(B):
        # Position (P u + Q v, R), and direction from there to objects in focus
        ux, uy = x[i] * scale, y[i] * scale
        away = reach / n_[i]
        vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
        px, py, pz = pu[i] * ux + pv[i] * vx, pu[i] * uy + pv[i] * vy, pw[i]
        dx, dy = f[i] * ux + g[i] * vx - near * px, f[i] * uy + g[i] * vy - near * py
        dz = h[i] - near * pz
        # Normalise what is nearly a unit vector: two steps of Newton's method for 1 / √
        square = dx * dx + dy * dy + dz * dz
        size = real(1.5) - real(0.5) * square
        size = size * (real(1.5) - real(0.5) * square * size * size)
        l[i], m[i], n_[i] = dx * size, dy * size, dz * size
        x[i], y[i], z[i] = px, py, pz + centre
