"""All families of methods, in the order in which the atlas shows them."""

from collections.abc import Callable

from lensbench.app.studies.stability import (
    closed_forms,
    focusing,
    intersection,
    models,
    orientation,
    pupils,
    refraction,
    sampling,
)
from lensbench.app.studies.stability.sweep import Stress

FAMILIES: dict[str, dict[str, Callable[[], Stress]]] = {
    "Intersection": intersection.STRESSES,
    "Refraction": refraction.STRESSES,
    "Focusing": focusing.STRESSES,
    "Pupil": pupils.STRESSES,
    "Models": models.STRESSES,
    "Sampling": sampling.STRESSES,
    "Closed forms": closed_forms.STRESSES,
    "Orientation": orientation.STRESSES,
}
