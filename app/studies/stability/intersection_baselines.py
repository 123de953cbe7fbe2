"""Ray-surface intersections of textbooks and of pbrt, for comparison with the program's methods.

Each takes origins and unit directions (n, 3) in float32 or float64, light towards +z, vertex at the origin, and returns
hits (n, 3) in the same precision; NaN where it finds none.
"""

import numpy as np

from lensbench.optics.lens_surface import Surface


def sphere_about_its_centre(origins: np.ndarray, directions: np.ndarray, c: float) -> np.ndarray:
    """pbrt-v3's IntersectSphericalElement: a quadratic about the centre, its discriminant in double precision."""
    real = origins.dtype.type
    radius = real(1.0 / c)
    o = origins - np.array([0.0, 0.0, radius], real)
    a, b = (directions**2).sum(1), real(2) * (directions * o).sum(1)
    e = (o * o).sum(1) - radius * radius
    discriminant = b.astype(np.float64) ** 2 - 4.0 * a.astype(np.float64) * e
    with np.errstate(all="ignore"):
        wide = np.sqrt(discriminant)
        q = (-0.5 * np.where(b < 0.0, b - wide, b + wide)).astype(real)
        t0, t1 = q / a, e / q
    t0, t1 = np.minimum(t0, t1), np.maximum(t0, t1)
    t = t0 if radius > 0.0 else t1
    return origins + np.where(t >= 0.0, t, real(np.nan))[:, None] * directions


def conic_by_the_school_formula(origins: np.ndarray, directions: np.ndarray, c: float, k: float) -> np.ndarray:
    """(−B − √(B² − A C)) / A from the origin of the ray, without regard to cancellation."""
    real = origins.dtype.type
    c, k, one = real(c), real(k), real(1)
    squash = np.array([one, one, one + k], real)
    a = c * (directions**2 * squash).sum(1)
    b = c * (directions * origins * squash).sum(1) - directions[:, 2]
    e = c * (origins**2 * squash).sum(1) - real(2) * origins[:, 2]
    with np.errstate(all="ignore"):
        t = (-b - np.sqrt(b * b - a * e)) / a
    return origins + t[:, None] * directions


def sphere_from_the_vertex_plane(origins: np.ndarray, directions: np.ndarray, c: float) -> np.ndarray:
    """Welford's quotient from the intersection of the ray with the vertex plane."""
    real = origins.dtype.type
    c, (p, q, r) = real(c), directions.T
    with np.errstate(all="ignore"):
        at = origins - (origins[:, 2] / r)[:, None] * directions
        f = c * (at[:, 0] ** 2 + at[:, 1] ** 2)
        g = r - c * (p * at[:, 0] + q * at[:, 1])
        t = f / (g + np.sqrt(g * g - c * f))
    return at + t[:, None] * directions


def newton_to_a_millionth(origins: np.ndarray, directions: np.ndarray, surface: Surface) -> np.ndarray:
    """Full Newton steps from the vertex plane, at most ten, to a residual of 1e-6 mm; even aspheres."""
    real = origins.dtype.type
    c, one = real(surface.curvature), real(1)
    curl = real((1.0 + surface.conic) * surface.curvature**2)

    def residual_and_slope(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Height above the surface (mm), and the slope of the surface by r over r."""
        r2 = at[:, 0] ** 2 + at[:, 1] ** 2
        wide = np.sqrt(one - curl * r2)
        terms = [(power // 2, real(a)) for power, a in surface.aspheric]
        return (at[:, 2] - c * r2 / (one + wide) - sum(a * r2**half for half, a in terms),
                c / wide + sum(real(2 * half) * a * r2 ** (half - 1) for half, a in terms))

    with np.errstate(all="ignore"):
        t = -origins[:, 2] / directions[:, 2]
        for _ in range(10):
            at = origins + t[:, None] * directions
            residual, slope = residual_and_slope(at)
            step = residual / (directions[:, 2] - slope * (at[:, :2] * directions[:, :2]).sum(1))
            t = np.where(np.abs(residual) < real(1e-6), t, t - step)
        return origins + t[:, None] * directions
