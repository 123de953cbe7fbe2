"""Refraction out of glass, up to the critical angle and beyond it; and arithmetic with sixty digits, the reference.

Exact numbers are arrays of `decimal` numbers, on which numpy's arithmetic works, within `exactly()`.
"""

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from decimal import Context, Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike

import lensbench as lb
from lensbench.app.studies.stability.sweep import LOST, PRECISIONS, Curve, Sweep, curves_of, with_progress
from lensbench.core.kernels.block import WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.text import fixed

DIGITS = 60


def exactly() -> AbstractContextManager:
    """Context in which this thread computes with DIGITS digits."""
    return localcontext(Context(prec=DIGITS))


def exact(values: ArrayLike) -> np.ndarray:
    """The floats as exact decimal numbers."""
    return np.vectorize(lambda value: Decimal(float(value)), otypes=[object])(np.asarray(values))


def root(values: np.ndarray) -> np.ndarray:
    """Square roots; NaN for negative values."""
    return np.frompyfunc(lambda value: value.sqrt() if value >= 0 else Decimal("NaN"), 1, 1)(values)


def floats(values: np.ndarray) -> np.ndarray:
    """The nearest double-precision numbers."""
    return np.asarray(values, dtype=np.float64)


def distance(points: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distances (n,) from points (n, 3), floats, to exact points; NaN where either is not finite."""
    known = np.isfinite(points).all(-1)
    away = exact(np.where(known[..., None], points, 0.0)) - truth
    return np.where(known, floats(root((away * away).sum(-1))), np.nan)


PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")


def sine_cosine(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of exact angles (radians, a few turns): Taylor series of an eighth, doubled three times."""
    x = angles / 8
    sine, cosine, term = x * 0, x * 0, x * 0 + 1
    for k in range(0, 60, 2):
        cosine, term = cosine + term, term * x / (k + 1)
        sine, term = sine + term, -term * x / (k + 2)
    for _ in range(3):
        sine, cosine = 2 * sine * cosine, 1 - 2 * sine * sine
    return sine, cosine


Found = tuple[np.ndarray, list[str]]            # unit directions (n, 3), and for each its fate, "" if it exists

INDEX = 1.75                    # index of the glass that the light leaves through a plane, into air
CRITICAL = math.degrees(math.asin(1.0 / INDEX))
LIMIT = 20.0                    # µrad
WHY = "1 µm on a film 50 mm behind"
TURNS = 24                      # azimuths of the plane of incidence
TOTAL = lb.Fate.TOTAL_REFLECTION.name
WINDOW = lb.Lens((lb.Surface(0.0, 100.0, curvature=0.0),), stop_index=0, front_index=INDEX)


def snell(directions: np.ndarray) -> np.ndarray:
    """Exact directions in air for float directions in glass; NaN where no refracted ray exists."""
    d = exact(directions)
    index = exact(np.float64(INDEX))[()]
    d = d / root((d * d).sum(1))[:, None]
    across = index * d[:, :2]
    along = root(1 - (across * across).sum(1))
    return np.concatenate([across, along[:, None]], 1)


def by_scalars(lens: lb.Lens, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Last points, directions (n, 3) and fates by the scalar tracer without rims, in the precision of the rays."""
    n, real = len(origins), origins.dtype
    points, after = np.empty((n, 3), real), np.empty((n, 3), real)
    fate, reached = np.empty(n, np.int32), np.empty(n, np.int32)
    trace_rays(surface_table(lens, dtype=real), False, origins, directions, points, after, fate, reached, None, 1)
    return points, after, [lb.Fate(int(end)).name if end != lb.Fate.PASSED else "" for end in fate]


def by_blocks(lens: lb.Lens, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """The same by the block tracer, whose directions have the length of the index."""
    rays = dict(zip([X, Y, Z, L, M, N, WEIGHT], [*origins.T, *directions.T, np.ones(len(origins))], strict=True))
    out = Program(surface_steps(lens, 0.0, towards="film"), origins.dtype.type).run(rays, list(rays), len(origins))
    return out[:3].T, out[3:6].T, ["" if weight > 0.0 else LOST for weight in out[6]]


def reference(directions: np.ndarray) -> Found:
    """Directions by the scalar tracer."""
    return by_scalars(WINDOW, -directions, directions)[1:]


def block(directions: np.ndarray) -> Found:
    """Directions by the block tracer."""
    return by_blocks(WINDOW, -directions, INDEX * directions)[1:]


def by_the_angle(directions: np.ndarray) -> Found:
    """asin(n sin i), the textbook form of Snell's law."""
    real = directions.dtype.type
    across = np.hypot(directions[:, 0], directions[:, 1])
    with np.errstate(all="ignore"):
        angle = np.arcsin(real(INDEX) * np.sin(np.arccos(np.clip(directions[:, 2], real(-1), real(1)))))
        flat = np.sin(angle) / np.where(across > 0.0, across, real(1))
    refracted = np.stack([directions[:, 0] * flat, directions[:, 1] * flat, np.cos(angle)], 1)
    return refracted, ["" if good else "NaN" for good in np.isfinite(refracted).all(1)]


def by_the_cosine(directions: np.ndarray) -> Found:
    """Refract of pbrt: sin² from the cosine, then the refracted cosine; False beyond the critical angle."""
    real = directions.dtype.type
    index, cosine = real(INDEX), directions[:, 2]
    sine2 = index * index * np.maximum(real(0), real(1) - cosine * cosine)
    behind = np.sqrt(np.maximum(real(0), real(1) - sine2))
    refracted = index * directions
    refracted[:, 2] += behind - index * cosine
    return refracted, ["" if good else TOTAL for good in sine2 < 1.0]


METHODS: dict[str, Callable[[np.ndarray], Found]] = {
    "by the angle": by_the_angle, "pbrt's Refract": by_the_cosine, "vector form": reference,
    "vector form in blocks": block}
OWN = ("vector form", "vector form in blocks")


def worst(traced: Found, truth: np.ndarray, directions: np.ndarray) -> float | str:
    """Largest angle (µrad) from the exact directions, or the fate that was returned instead.

    Where no refracted ray exists, a method may return a ray along the surface: its error is the angle to the critical
    ray.
    """
    there = np.isfinite(floats(truth)).all(1)
    lost = [fate for fate, known in zip(traced[1], there, strict=True) if known and fate]
    if lost:
        return lost[0]
    claimed = np.array([not fate for fate in traced[1]])
    if not claimed.any():
        return traced[1][0]
    flat = exact(directions) * [1, 1, 0]
    flat = flat / np.where(there, 1, root((flat * flat).sum(1)))[:, None]      # used only where no ray exists
    off = exact(np.where(claimed[:, None], traced[0], 0.0)) - np.where(there[:, None], truth, flat)
    return 1e6 * float(floats(root((off * off).sum(1)))[claimed].max())


def measured(incidences: np.ndarray) -> tuple[Curve, ...]:
    """Curves of all methods at these angles of incidence (°)."""
    switch = "no ray through a library lens is flatter than 10°; the edge of the light is found in float64"
    turn = 2.0 * math.pi * np.arange(TURNS) / TURNS
    results: dict[str, list[float | str]] = {}
    with exactly():
        for angle in with_progress(np.radians(incidences)):
            tilted = np.stack([math.sin(angle) * np.cos(turn), math.sin(angle) * np.sin(turn),
                               np.full(TURNS, math.cos(angle))], 1)
            for real, precision in PRECISIONS:
                directions = np.ascontiguousarray(tilted, real)
                truth = snell(directions)
                for name, method in METHODS.items():
                    results.setdefault(f"{name}, {precision}", []).append(worst(method(directions), truth, directions))
    return curves_of(results, OWN, switch)


def to_the_critical_angle() -> Sweep:
    """Angles of incidence that approach the critical angle."""
    below = np.logspace(math.log10(CRITICAL - 0.5), -12.0, 46)
    return Sweep("Just below the critical angle", "Below the critical angle", "°", below, "Direction", "µrad", LIMIT,
                  WHY, measured(CRITICAL - below),
                  "The ray leaves along the surface there, and its angle changes with the square root of the remaining"
                  " angle.")


def beyond_it() -> Sweep:
    """All angles of incidence; beyond the critical one the answer is a fate."""
    angles = np.array([*np.arange(0.0, CRITICAL - 0.5, 1.0), *np.arange(math.ceil(CRITICAL), 89.0, 1.0), 89.0, 89.9])
    expected = tuple(TOTAL if angle > CRITICAL else "" for angle in angles)
    return Sweep("Incidence", "Angle of incidence", "°", angles, "Direction", "µrad", LIMIT, WHY, measured(angles),
                  f"Out of glass of index {INDEX}: beyond {fixed(CRITICAL, 2)}° no ray exists, and the "
                  f"result is a fate.",
                  linear=True, expected=expected)


SWEEPS: dict[str, Callable[[], Sweep]] = {"Incidence": beyond_it, "Just below the critical angle":
                                             to_the_critical_angle}
