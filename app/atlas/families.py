"""All families of methods, in the order in which the atlas shows them."""

from collections.abc import Callable

from lensbench.app.atlas import closed_forms, intersection, orientation, refraction
from lensbench.app.atlas.stress import Stress

FAMILIES: dict[str, dict[str, Callable[[], Stress]]] = {
    "Intersection": intersection.STRESSES,
    "Refraction": refraction.STRESSES,
    "Closed forms": closed_forms.STRESSES,
    "Orientation": orientation.STRESSES,
}
