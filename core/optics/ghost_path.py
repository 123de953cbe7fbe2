"""Ghosts: pairs of surfaces whose reflections make one, their light, and one ray by the reference tracer in float64.

A pair (first, second) has first < second: light is refracted up to `second`, reflected there, goes back to `first`, is
reflected again and leaves the lens towards the film. Light counts as unpolarised at every surface; absorption in glass
is neglected. The normal of a surface of any kind is found from a refraction there into a medium of higher index: the
optical direction changes along the normal, and no ray is totally reflected.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.optics.axial_bundle import surface_coatings
from lensbench.core.optics.coatings import Coating
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import BACKWARD, CLIPPED, PASSED, TOTAL_REFLECTION, surface_table, trace_ray
from lensbench.core.optics.surfaces import AFTER, BEFORE

Pair = tuple[int, int]          # (first, second): indices of surfaces, second the one that is met first by the light

DIRECT: Pair = (-1, -1)         # instead of a pair: the light that no surface reflects


def ghost_pairs(lens: Lens, wavelength: float = D_LINE) -> tuple[Pair, ...]:
    """All pairs of surfaces that reflect, first < second: those with different indices on both sides."""
    n = lens.indices(wavelength)
    reflecting = [i for i in range(len(lens.surfaces)) if n[i] != n[i + 1]]
    return tuple((first, second) for k, second in enumerate(reflecting) for first in reflecting[:k])


def no_such_pair(lens: Lens, pairs: Iterable[Pair]) -> str:
    """Why none of these pairs, if any, makes a ghost in this lens; "" where one does, and for no pairs."""
    asked = tuple(pairs)
    if not asked or set(asked) & {*ghost_pairs(lens), DIRECT}:
        return ""
    first, second = asked[0]
    return (f"no ghost of surfaces {first} and {second}: ghosts need two surfaces of this lens that reflect, from 0 to "
            f"{len(lens.surfaces) - 1}")


def check_pair(lens: Lens, pair: Pair) -> None:
    """LensError for a pair that is neither DIRECT nor of two surfaces of the lens, the first before the second."""
    if pair != DIRECT and not 0 <= pair[0] < pair[1] < len(lens.surfaces):
        raise LensError(no_such_pair(lens, (pair,)))


def ghost_order(count: int, pair: Pair) -> Iterator[tuple[int, bool, bool]]:
    """Surfaces in the order met, of `count`: index, whether the light runs to the film, whether it is reflected."""
    first, second = pair
    if pair == DIRECT:
        yield from ((i, True, False) for i in range(count))
        return
    yield from ((i, True, i == second) for i in range(second + 1))
    yield from ((i, False, i == first) for i in range(second - 1, first - 1, -1))
    yield from ((i, True, False) for i in range(first + 1, count))


def pair_share(lens: Lens, pair: Pair, wavelength: float = D_LINE, coating: str | Coating = "uncoated") -> float:
    """Product of the reflectances of a pair, or of DIRECT, and of all transmittances on its way, on the axis."""
    reflected, passed = _on_axis(lens, wavelength, coating), 1.0
    for i, _, mirror in ghost_order(len(lens.surfaces), pair):
        reflectance = reflected[i]
        passed *= reflectance if mirror else 1.0 - reflectance
    return passed


@lru_cache(maxsize=64)
def _on_axis(lens: Lens, wavelength: float, coating: str | Coating) -> tuple[float, ...]:
    """Reflectance of each surface at normal incidence."""
    n = lens.indices(wavelength)
    return tuple(float(own.reflectance(n[i], n[i + 1], wavelength=wavelength).mean) if n[i] != n[i + 1] else 0.0
                 for i, own in enumerate(surface_coatings(lens, coating)))


DENSER = 1.5                    # index ratio of the refraction that finds the normal


Vector = tuple[float, float, float]


class Meeting(NamedTuple):
    """One ray at one surface; lens frame, mm."""

    point: Vector
    refracted: Vector | None        # unit direction; None: totally reflected
    reflected: Vector
    reflectance: float
    fate: int                                           # PASSED, or why the ray ends here


@dataclass(frozen=True, eq=False)
class GhostPath:
    """One ray of a ghost, in the lens frame."""

    points: np.ndarray
    direction: np.ndarray
    weight: float
    fate: int


class Meetings:
    """Rays at single surfaces of a lens, at a wavelength (µm), by the reference tracer."""

    def __init__(self, lens: Lens, wavelength: float = D_LINE, coating: str | Coating = "uncoated", clip: bool = True
                 ) -> None:
        self._lens, self._wavelength, self._clip = lens, wavelength, clip
        self._table = surface_table(lens, wavelength)
        self._coatings = surface_coatings(lens, coating)

    def meet(self, i: int, forward: bool, point: Vector, direction: Vector) -> Meeting:
        """A ray, in the medium before surface i as the light runs, at this surface."""
        row = self._table.part(i, i + 1)
        order = 1 if forward else -1
        before, after = row.numbers[0, [BEFORE, AFTER] if forward else [AFTER, BEFORE]].tolist()
        *hit, dx, dy, dz, fate, _ = trace_ray(row, self._clip, *point, *direction, None, 0, order)
        blocked = self._clip and i == self._lens.stop_index and fate == PASSED and not self._passes_iris(hit)
        if blocked or fate not in (PASSED, TOTAL_REFLECTION):
            return Meeting(tuple(hit), None, direction, 0.0, CLIPPED if blocked else fate)
        if before == after:
            return Meeting(tuple(hit), (dx, dy, dz), direction, 0.0, PASSED)

        # The normal, by a refraction that always succeeds
        denser = row._replace(numbers=row.numbers.copy())
        denser.numbers[0, AFTER if forward else BEFORE] = DENSER * before
        *_, ex, ey, ez, normal_fate, _ = trace_ray(denser, False, *point, *direction, None, 0, order)
        if normal_fate != PASSED:
            return Meeting(tuple(hit), None, direction, 0.0, normal_fate)
        change = [DENSER * b - a for a, b in zip(direction, (ex, ey, ez), strict=True)]
        length = sqrt(sum(c * c for c in change))
        normal = [c / length for c in change]
        cosine = sum(a * b for a, b in zip(direction, normal, strict=True))
        mirrored = [a - 2.0 * cosine * b for a, b in zip(direction, normal, strict=True)]
        reflectance = float(self._coatings[i].reflectance(before, after, min(cosine, 1.0), self._wavelength).mean)
        total = fate == TOTAL_REFLECTION
        return Meeting(tuple(hit), None if total else (dx, dy, dz), tuple(mirrored), 1.0 if total else reflectance,
                       PASSED)

    def _passes_iris(self, hit: ArrayLike) -> bool:
        lens = self._lens
        if lens.iris.is_round:
            return True
        on_stop = lens.in_frame_of(lens.stop_index, np.array([hit])) / lens.stop.semi_diameter
        return bool(lens.iris.contains(on_stop[:, 0], on_stop[:, 1])[0])


def ghost_path(lens: Lens, pair: Pair, origin: ArrayLike, direction: ArrayLike, wavelength: float = D_LINE,
               coating: str | Coating = "uncoated", clip: bool = True) -> GhostPath:
    """One ray of the ghost of a pair, by the reference tracer: from origin along direction (mm, lens frame, any
    length).

    clip: whether clear apertures, stop and blades block the ray. LensError for a pair that the lens does not have.
    """
    check_pair(lens, pair)
    bench = Meetings(lens, wavelength, coating, clip)
    point = tuple(np.asarray(origin, float).tolist())
    unit = np.asarray(direction, float)
    ray = tuple((unit / np.linalg.norm(unit)).tolist())
    points, weight = [point], 1.0
    for i, forward, mirror in ghost_order(len(lens.surfaces), pair):
        met = bench.meet(i, forward, point, ray)
        point, after = met.point, met.reflected if mirror else met.refracted
        points.append(point)
        if met.fate != PASSED or after is None:
            return GhostPath(np.array(points), np.array(ray), 0.0, TOTAL_REFLECTION if met.fate == PASSED else met.fate)
        weight *= met.reflectance if mirror else 1.0 - met.reflectance
        ray = after
        if (ray[2] > 0.0) != (forward != mirror):       # turned against its travel: it meets no next surface in order
            return GhostPath(np.array(points), np.array(ray), 0.0, BACKWARD)
    return GhostPath(np.array(points), np.array(ray), weight, PASSED)
