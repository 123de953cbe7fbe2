"""Ray-surface intersection: the program's methods against pbrt's quadratic and textbook forms.

Each rival takes origins and unit directions (n, 3) in float32 or float64, light towards +z, vertex at the origin, and
returns hits (n, 3) in the same precision; NaN where it finds none. The exact hits have sixty digits.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.studies.stability.refraction import by_blocks, by_scalars, distance, exact, exactly, floats, root
from lensbench.app.studies.stability.sweep import PRECISIONS, Curve, Sweep, curves_of, with_progress
from lensbench.core.optics.lens_surface import Surface


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
        points = origins - (origins[:, 2] / r)[:, None] * directions
        f = c * (points[:, 0] ** 2 + points[:, 1] ** 2)
        g = r - c * (p * points[:, 0] + q * points[:, 1])
        t = f / (g + np.sqrt(g * g - c * f))
    return points + t[:, None] * directions


def newton_to_a_millionth(origins: np.ndarray, directions: np.ndarray, surface: Surface) -> np.ndarray:
    """Full Newton steps from the vertex plane, at most ten, to a residual of 1e-6 mm; even aspheres."""
    real = origins.dtype.type
    c, one = real(surface.curvature), real(1)
    curl = real((1.0 + surface.conic) * surface.curvature**2)

    def residual_and_slope(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Height above the surface (mm), and the slope of the surface by r over r."""
        r2 = points[:, 0] ** 2 + points[:, 1] ** 2
        wide = np.sqrt(one - curl * r2)
        terms = [(power // 2, real(a)) for power, a in surface.aspheric]
        return (points[:, 2] - c * r2 / (one + wide) - sum(a * r2**half for half, a in terms),
                c / wide + sum(real(2 * half) * a * r2 ** (half - 1) for half, a in terms))

    with np.errstate(all="ignore"):
        t = -origins[:, 2] / directions[:, 2]
        for _ in range(10):
            points = origins + t[:, None] * directions
            residual, slope = residual_and_slope(points)
            step = residual / (directions[:, 2] - slope * (points[:, :2] * directions[:, :2]).sum(1))
            t = np.where(np.abs(residual) < real(1e-6), t, t - step)
        return origins + t[:, None] * directions


Rays = tuple[np.ndarray, np.ndarray]            # origins, unit directions (n, 3), mm
Found = tuple[np.ndarray, list[str]]            # hits (n, 3), and for each ray its fate, "" if it hits
Method = Callable[[np.ndarray, np.ndarray, lb.Surface], Found]
Exact = Callable[[np.ndarray, np.ndarray, lb.Surface], np.ndarray]

RAYS = 24                       # rays for each value, over the whole aperture and from all sides
LIMIT = 1e-3                    # mm
WHY = "a quarter of a pixel of 4 µm"
GLASS = lb.Surface(0.0, 20.0, radius=50.0)
TILT = math.radians(20.0)
AWAY = 50.0                     # mm from the surface to the origin of a ray


def aimed(surface: lb.Surface, tilt: float = TILT, away: float = AWAY) -> Rays:
    """Rays that begin `away` mm before points all over the surface, tilted by up to `tilt` from the axis."""
    share = (np.arange(RAYS) + 0.5) / RAYS
    turn = math.pi * (3.0 - math.sqrt(5.0)) * np.arange(RAYS)           # golden angle, as in a sunflower
    x, y = (surface.semi_diameter * np.sqrt(share) * way for way in (np.cos(turn), np.sin(turn)))
    targets = np.stack([x, y, surface.sag(x, y)], 1)
    lean = tilt * np.sqrt(share[7 * np.arange(RAYS) % RAYS])         # even over the area
    directions = np.stack([np.sin(lean) * np.cos(2.0 * turn), np.sin(lean) * np.sin(2.0 * turn), np.cos(lean)], 1)
    return targets - away * directions, directions


def hits_of_a_conic(origins: np.ndarray, directions: np.ndarray, surface: lb.Surface) -> np.ndarray:
    """Exact points where rays (n, 3) cross a conic towards +z; NaN where they miss or lie beyond its equator."""
    o, d, (c, k) = exact(origins), exact(directions), exact([surface.curvature, surface.conic])
    a = c * ((d * d).sum(1) + k * d[:, 2] ** 2)
    b = c * ((o * d).sum(1) + k * o[:, 2] * d[:, 2]) - d[:, 2]
    e = c * ((o * o).sum(1) + k * o[:, 2] ** 2) - 2 * o[:, 2]
    wide = root(b * b - a * e)
    t = np.array([e_ / (w - b_) if b_ <= 0 else (-b_ - w) / a_ for a_, b_, e_, w in zip(a, b, e, wide, strict=True)])
    points = o + t[:, None] * d
    there = np.array([not z.is_nan() and (1 + k) * c * z < 1 for z in points[:, 2]])
    return np.where(there[:, None], points, exact(math.nan))


def reference(origins: np.ndarray, directions: np.ndarray, surface: lb.Surface) -> Found:
    """Hits by the scalar tracer."""
    points, _, fates = by_scalars(lb.Lens((surface,), stop_index=0), origins, directions)
    return points, fates


def block(origins: np.ndarray, directions: np.ndarray, surface: lb.Surface) -> Found:
    """Hits by the block tracer, with the surface instead of the film."""
    points, _, fates = by_blocks(lb.Lens((surface,), stop_index=0), origins, directions)
    return points, fates


def rival(hits: np.ndarray) -> Found:
    """Wraps a method whose only sign of a miss is NaN."""
    return hits, ["" if good else "NaN" for good in np.isfinite(hits).all(1)]


def worst(hits_and_fates: Found, truth: np.ndarray, meant: np.ndarray) -> float | str:
    """Largest distance (mm) of hits from the exact ones, or the fate; a ray off by its own rounding may do either."""
    hits, fates = hits_and_fates
    there = np.isfinite(floats(truth)).all(1)
    lost = [fate for fate, known in zip(fates, there, strict=True) if known and fate]
    if lost:
        return lost[0]
    claimed = np.array([not fate for fate in fates])
    return float(distance(hits, np.where(there[:, None], truth, meant))[claimed].max(initial=0.0))


def measured(surfaces: Sequence[lb.Surface], rays: Sequence[Rays], methods: dict[str, Method], own: dict[str, Method],
             truth: Exact = hits_of_a_conic, switch: str = "") -> tuple[Curve, ...]:
    """Curves of all methods in both precisions, to which rays are rounded first; switch: of the program's own."""
    results: dict[str, list[float | str]] = {}
    with exactly():
        for surface, ray in with_progress(list(zip(surfaces, rays, strict=True))):
            meant = truth(*ray, surface)
            for real, precision in PRECISIONS:
                origins, directions = (np.ascontiguousarray(half, real) for half in ray)
                right = meant if real is np.float64 else truth(origins, directions, surface)
                for name, method in {**methods, **own}.items():
                    hits = method(origins, directions, surface)
                    results.setdefault(f"{name}, {precision}", []).append(worst(hits, right, meant))
    return curves_of(results, own, switch)


def _pbrt(origins, directions, surface):
    return rival(sphere_about_its_centre(origins, directions, surface.curvature))


def _school(origins, directions, surface):
    return rival(conic_by_the_school_formula(origins, directions, surface.curvature, surface.conic))


def _vertex_plane(origins, directions, surface):
    return rival(sphere_from_the_vertex_plane(origins, directions, surface.curvature))


SPHERES: dict[str, Method] = {"pbrt's quadratic": _pbrt, "from the vertex's plane": _vertex_plane}
OWN: dict[str, Method] = {"foot form": reference, "foot form in blocks": block}
CONICS: dict[str, Method] = {"school formula": _school}
OWN_CONICS: dict[str, Method] = {"closed form": reference, "closed form in blocks": block}
RADII = np.logspace(0.0, 12.0, 49)


def _sweep(title: str, axis: str, unit: str, values: np.ndarray, curves: tuple[Curve, ...], note: str) -> Sweep:
    return Sweep(title, axis, unit, values, "Place of the hit", "mm", LIMIT, WHY, curves, note)


def radius() -> Sweep:
    """Spheres from a bead of 1 mm to a plane."""
    spheres = [replace(GLASS, curvature=1.0 / r, semi_diameter=min(0.6 * r, GLASS.semi_diameter)) for r in RADII]
    return _sweep("Radius of a sphere", "Radius", "mm", RADII,
                   measured(spheres, [aimed(sphere) for sphere in spheres], SPHERES, OWN),
                   "For a flat sphere, a quadratic about the centre subtracts the squares of two large numbers. From "
                   "the foot of the perpendicular nothing cancels, and a plane is no special case.")


def paraboloid() -> Sweep:
    """Paraboloids from a bead of 1 mm to a plane."""
    conics = [replace(GLASS, curvature=1.0 / r, conic=-1.0, semi_diameter=min(0.6 * r, GLASS.semi_diameter))
              for r in RADII]
    return _sweep("Radius of a paraboloid", "Radius", "mm", RADII,
                   measured(conics, [aimed(conic) for conic in conics], CONICS, OWN_CONICS),
                   "For a flat surface the textbook formula divides a vanishing difference by a vanishing coefficient.")


def ray_distance() -> Sweep:
    """A ray from far away."""
    values = np.logspace(0.0, 7.0, 43)
    return _sweep("Distance of the ray's origin", "Distance", "mm", values,
                   measured([GLASS] * len(values), [aimed(GLASS, away=away) for away in values], SPHERES, OWN,
                            switch="no ray of a picture begins there: camera rays begin on the film, light rays on a "
                                   "plane just in front of the lens"),
                   "A float32 ray of 10 km is itself exact to a millimetre only; any larger error comes from the "
                   "method.")


def grazing() -> Sweep:
    """A sphere nearly parallel to the ray, 15 mm from its axis."""
    values = np.logspace(math.log10(45.0), -6.0, 45)
    turn = 2.0 * math.pi * np.arange(RAYS) / RAYS
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(RAYS)], 1)
    axis, lean = np.array([0.0, 0.0, 1.0]), math.asin(15.0 / 50.0)
    targets = 15.0 * out + float(GLASS.sag(15.0)) * axis
    along, across = math.cos(lean) * out + math.sin(lean) * axis, math.cos(lean) * axis - math.sin(lean) * out
    directions = [math.cos(angle) * along + math.sin(angle) * across for angle in np.radians(values)]
    return _sweep("Grazing incidence on a sphere", "Angle between ray and surface", "°", values,
                   measured([GLASS] * len(values), [(targets - AWAY * way, way) for way in directions], SPHERES, OWN,
                            switch="no ray through a lens of the library runs flatter than 10°; where light ends "
                                   "is found in float64"),
                   "The error grows as one over the angle with every method, because the ray itself is rounded. Below "
                   "that angle a ray may be reported as a miss.")


def hemisphere() -> Sweep:
    """Rays parallel to the axis near the equator of a sphere."""
    values = np.logspace(0.0, -15.0, 46)
    sphere = replace(GLASS, semi_diameter=50.0)
    turn = 2.0 * math.pi * np.arange(RAYS) / RAYS
    rays = [(np.stack([50.0 * (1.0 - gap) * np.cos(turn), 50.0 * (1.0 - gap) * np.sin(turn), np.full(RAYS, -AWAY)],
                      1), np.tile([0.0, 0.0, 1.0], (RAYS, 1))) for gap in values]
    return _sweep("Edge of a hemisphere", "Part of the radius left to the equator", "", values,
                   measured([sphere] * len(values), rays, SPHERES, OWN,
                            switch="no ray through a lens of the library comes nearer than a hundredth; where light "
                                   "ends is found in float64"),
                   "The surface is parallel to the ray there; beyond the equator the ray misses.")


def _conics(title: str, axis: str, values: np.ndarray, ks: np.ndarray, note: str) -> Sweep:
    """Conic constants k, on the part of the surface within 0.6 of its equator."""
    reach = [min(0.6 * 50.0 / math.sqrt(1.0 + k), 20.0) if k > -1.0 else 20.0 for k in ks]
    conics = [replace(GLASS, conic=float(k), semi_diameter=edge) for k, edge in zip(ks, reach, strict=True)]
    return _sweep(title, axis, "", values, measured(
        conics, [aimed(conic) for conic in conics], CONICS, OWN_CONICS,
        switch="a conic constant of a lens is a million times smaller"), note)


def oblate() -> Sweep:
    """Conics flatter than a sphere."""
    values = np.logspace(-2.0, 8.0, 41)
    return _conics("Oblate conics", "Conic constant k", values, values,
                   "The larger k, the smaller the whole ellipsoid: its equator approaches the vertex.")


def hyperbolic() -> Sweep:
    """Hyperboloids, whose second sheet is no hit."""
    values = np.logspace(0.0, 8.0, 41)
    return _conics("Hyperbolic conics", "Minus the conic constant", values, -values,
                   "A hyperboloid has a second sheet, which a wrong root would hit.")


def first_hits(origins: np.ndarray, directions: np.ndarray, surface: lb.Surface) -> np.ndarray:
    """Exact points where rays first cross an even asphere: bisection of the first change of sign."""
    o, d = exact(origins), exact(directions)
    (c, k), terms = exact([surface.curvature, surface.conic]), [(power, exact([a])[0]) for power, a in surface.aspheric]

    def height(t):
        points = o + t[:, None] * d
        r2 = points[:, 0] ** 2 + points[:, 1] ** 2
        sag = c * r2 / (1 + root(1 - (1 + k) * c * c * r2))
        return points[:, 2] - sag - sum(a * r2 ** (power // 2) for power, a in terms)

    along = np.linspace(AWAY - 40.0, AWAY + 5.0, 2001)
    points = origins.astype(float)[:, None, :] + along[:, None] * directions.astype(float)[:, None, :]
    over = points[..., 2] - surface.sag(points[..., 0], points[..., 1])
    first = np.argmax((over[:, :-1] < 0.0) & (over[:, 1:] >= 0.0), 1)
    low, high = exact(along[first]), exact(along[first + 1])
    for _ in range(64):                                 # 0.0225 mm / 2^64
        middle = (low + high) / 2
        through = height(middle) > 0
        low, high = np.where(through, low, middle), np.where(through, middle, high)
    return o + low[:, None] * d


def _newton(origins, directions, surface):
    return rival(newton_to_a_millionth(origins, directions, surface))


def asphere() -> Sweep:
    """Slope of the r^10 term of an asphere 15 mm off the axis; the rays are as oblique as that slope allows."""
    values = np.logspace(-2.0, 1.0, 25)
    surfaces = [replace(GLASS, semi_diameter=15.0, aspheric=((10, slope / (10.0 * 15.0**9)),)) for slope in values]
    tilts = np.arctan(0.85 / (values + 0.35))           # no ray meets the surface twice
    rays = [aimed(surface, min(tilt, math.radians(40.0))) for surface, tilt in zip(surfaces, tilts, strict=True)]
    return _sweep("Strong aspheres", "Slope of the r^10 term at the rim", "", values,
                   measured(surfaces, rays, {"Newton to 1e-6 mm": _newton},
                            {"Newton, halved steps": reference, "Newton in blocks": block}, first_hits),
                   "Full steps overshoot where the surface is steeper than the ray.")


def oblique() -> Sweep:
    """A surface that turns back at its rim, with ever more oblique rays."""
    values = np.linspace(5.0, 75.0, 22)
    surface = replace(GLASS, semi_diameter=15.0, aspheric=((10, -2.0 / (10.0 * 15.0**9)),))
    curves = measured([surface] * len(values), [aimed(surface, math.radians(tilt)) for tilt in values],
                      {"Newton to 1e-6 mm": _newton},
                      {"Newton, halved steps": reference, "Newton in blocks": block}, first_hits,
                      switch="the ray is blocked, and the reference tracer finds it")
    return replace(_sweep("Oblique rays on a strong asphere", "Tilt of the rays", "°", values, curves,
                           "The r^10 term falls by 2 mm a mm at the rim. Full steps arrive at a second crossing, or at"
                           " none; the blocks iterate while one of their rays moves, up to a few steps more, and then "
                           "block a ray that has not converged."), linear=True)


SWEEPS: dict[str, Callable[[], Sweep]] = {
    "Radius of a sphere": radius, "Radius of a paraboloid": paraboloid, "Distance of the ray's origin": ray_distance,
    "Grazing incidence on a sphere": grazing, "Edge of a hemisphere": hemisphere, "Oblate conics": oblate,
    "Hyperbolic conics": hyperbolic, "Strong aspheres": asphere, "Oblique rays on a strong asphere": oblique}
