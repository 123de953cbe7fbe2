"""Pairs of surfaces whose reflections make a ghost, the way of its light, and the part of the light that it gets.

A pair (first, second) has first < second: light is refracted up to `second`, reflected there, goes back to `first`, is
reflected again and leaves the lens towards the film.
"""

from collections.abc import Iterable, Iterator
from functools import lru_cache

from lensbench.optics.coatings import Coating
from lensbench.optics.glass import D_LINE
from lensbench.optics.lens_surface import LensError
from lensbench.optics.prescription import Lens
from lensbench.optics.transmission import surface_coatings

Pair = tuple[int, int]          # (first, second): indices of surfaces, second the one that is met first by the light

DIRECT: Pair = (-1, -1)         # in place of a pair: the light that no surface reflects


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
        part = reflected[i]
        passed *= part if mirror else 1.0 - part
    return passed


@lru_cache(maxsize=64)
def _on_axis(lens: Lens, wavelength: float, coating: str | Coating) -> tuple[float, ...]:
    """Reflectance of each surface at normal incidence."""
    n = lens.indices(wavelength)
    return tuple(float(own.reflectance(n[i], n[i + 1], wavelength=wavelength).mean) if n[i] != n[i + 1] else 0.0
                 for i, own in enumerate(surface_coatings(lens, coating)))
