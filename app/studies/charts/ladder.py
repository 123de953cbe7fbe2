"""Camera models of one lens, from the simplest to the full trace: their render steps, or why a model is impossible.

The steps run from the film point X, Y and the pupil sample U0, U1 to the ray in front of the lens; camera frame, mm.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.studies.charts.ray_table import ray_table_step
from lensbench.kernels.block import Step
from lensbench.lens_models.polynomial import DEGREES, Polynomial
from lensbench.pupils.radial_sampler import PupilTable

IDEAL = {"pinhole": "pinhole", "thin": "thin lens", "thick": "thick lens"}


@dataclass(frozen=True, eq=False)
class Model:
    """One model of a lens: steps from the film into the pupil (`aim`, none for an ideal model) and through the lens.

    model, degree: as for a LensCamera; "" and 0 if it has none. why: reason why the model is impossible, "" if it is
    possible.
    """

    name: str
    kind: str
    model: str = ""
    degree: int = 0
    aim: tuple[Step, ...] = ()
    lens: tuple[Step, ...] = ()
    real: Any = np.float32
    why: str = ""

    @property
    def steps(self) -> list[Step]:
        """All steps of the camera after that of the film."""
        return [*self.aim, *self.lens]


def ladder(camera: lb.LensCamera) -> list[Model]:
    """Every model of the lens of a camera with its present settings, the simplest first."""
    found = [_ideal(camera, kind, name) for kind, name in IDEAL.items()]
    try:
        table = _regions(camera)
        aim = (table.step(camera.axis_irradiance),)
        found += [_polynomial(camera, table, aim, degree) for degree in DEGREES]
        through = ray_table_step(camera.lens, camera.film_distance, table, distance=camera.focus_distance)
        found.append(Model("table", "table", aim=aim, lens=(through,)))
    except ValueError as error:
        found += [Model(f"degree {degree}", "polynomial", "polynomial", degree, why=str(error)) for degree in DEGREES]
        found.append(Model("table", "table", why=str(error)))
    aimed, *lens = replace(camera, model="trace").camera_steps()
    found += [Model(f"trace, {name}", "trace", "trace" if real is np.float32 else "", 0, (aimed,), tuple(lens), real)
              for name, real in (("float32", np.float32), ("float64", np.float64))]
    return found


def _ideal(camera: lb.LensCamera, kind: str, name: str) -> Model:
    try:
        return Model(name, kind, kind, lens=tuple(replace(camera, model=kind).camera_steps()))
    except ValueError as error:
        return Model(name, kind, kind, why=str(error))


def _regions(camera: lb.LensCamera) -> PupilTable:
    """Exit-pupil regions of a camera with a polynomial; ValueError if its lens has no polynomial or table."""
    if not camera.lens.iris.is_round:
        raise lb.LensError("the stop has blades; a polynomial or table does not give the place of rays in the stop")
    fitted = replace(camera, model="polynomial")
    return PupilTable.of(fitted.lens, fitted.film_distance, fitted.film.diagonal / 2.0, widened=False)


def _polynomial(camera: lb.LensCamera, table: PupilTable, aim: tuple[Step, ...], degree: int) -> Model:
    name = f"degree {degree}"
    try:
        fit = Polynomial.fit(camera.lens, camera.film_distance, table, degree, distance=camera.focus_distance)
        return Model(name, "polynomial", "polynomial", degree, aim, (fit.step,))
    except ValueError as error:
        return Model(name, "polynomial", "polynomial", degree, why=str(error))
