"""A possible cause of what is wrong with a lens, and the lens without it."""

from dataclasses import dataclass, replace
from typing import Any

from lensbench.core.optics.finding import Change, Kind
from lensbench.core.optics.prescription import Lens


@dataclass(frozen=True)
class Hypothesis:
    """One change that may make a lens good.

    kind: of the finding that names it. cause: what went wrong, as the first part of a sentence. words: the change, such
    as "radius of surface 3: 45 instead of −45". lens: with the change. rarity: how much rarer this mistake is than a
    lost sign, or how many such changes are tried; the misfit counts so much more. expects: findings that may be new
    with the change.
    """

    kind: Kind
    change: Change
    cause: str
    words: str
    lens: Lens
    rarity: float = 1.0
    expects: frozenset[Kind] = frozenset()


def with_surface(lens: Lens, i: int, **changes: Any) -> Lens:
    """The lens with one surface changed."""
    surfaces = list(lens.surfaces)
    surfaces[i] = replace(surfaces[i], **changes)
    return replace(lens, surfaces=tuple(surfaces))
