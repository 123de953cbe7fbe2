"""All families of methods, in the order in which they are shown."""

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
from lensbench.app.studies.stability.sweep import Sweep

FAMILIES: dict[str, dict[str, Callable[[], Sweep]]] = {
    "Intersection": intersection.SWEEPS,
    "Refraction": refraction.SWEEPS,
    "Focusing": focusing.SWEEPS,
    "Pupil": pupils.SWEEPS,
    "Models": models.SWEEPS,
    "Sampling": sampling.SWEEPS,
    "Closed forms": closed_forms.SWEEPS,
    "Orientation": orientation.SWEEPS,
}
