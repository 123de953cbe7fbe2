"""All families of methods, in the order in which the atlas shows them."""

from collections.abc import Callable

from lensbench.app.atlas import intersection, refraction
from lensbench.app.atlas.stress import Stress

FAMILIES: dict[str, dict[str, Callable[[], Stress]]] = {
    "Intersection": intersection.STRESSES,
    "Refraction": refraction.STRESSES,
}
