"""Cost and error of the camera models against the full trace: a part of `lensbench bench`."""

from collections.abc import Iterator
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import LENS, idle, least_times, streamed
from lensbench.kernels import block
from lensbench.kernels.program import Program
from lensbench.lens_models.polynomial import DEGREES, Polynomial
from lensbench.optics.block_trace import surface_steps
from lensbench.pupils.radial_sampler import PupilTable

NAMES = (LENS, "pbrt-fisheye-10mm")
PIXEL = 0.004               # mm


def polynomials() -> Iterator[tuple[str, float, str]]:
    """Fitted polynomials against the full trace, and the time of the fit.

    512 rays in the first-level cache, one thread, float32.
    """
    for name in NAMES:
        lens, distance = lenses.load(name), 1200.0
        film_distance = lb.film_distance(lens, distance)
        table = PupilTable.of(lens, film_distance, 21.6, widened=False)
        given = _aimed(table)
        fits = {degree: Polynomial.fit(lens, film_distance, table, degree, distance=distance) for degree in DEGREES}
        steps = {"idle": [block.Step(idle, [0.0])], "trace": surface_steps(lens, film_distance),
                 **{str(degree): [fit.step] for degree, fit in fits.items()}}
        best = least_times({label: streamed(each, given) for label, each in steps.items()})
        trace = best["trace"] - best["idle"]
        for degree, fit in fits.items():
            ratio = trace / (best[str(degree)] - best["idle"])
            yield f"trace / polynomial of degree {degree}, {name}", ratio, "×"
            yield f"polynomial of degree {degree}, rms error, {name}", fit.rms / PIXEL, "px of 4 µm"
        seconds = least_times({
            "fit": partial(Polynomial.fit, lens, film_distance, table, 9, distance=distance),
            "both": partial(_with_pupil, lens, film_distance)})
        yield f"fit of degree 9, {name}", 1e3 * seconds["fit"], "ms"
        yield f"fit of degree 9 with its pupil, {name}", 1e3 * seconds["both"], "ms"


def _with_pupil(lens: lb.Lens, film_distance: float) -> Polynomial:
    return Polynomial.fit(lens, film_distance, PupilTable.of(lens, film_distance, 21.6, widened=False), 9)


def _aimed(table: PupilTable) -> dict[int, np.ndarray]:
    """Ray rows of one block of rays that leave the film towards their exit-pupil regions."""
    random = np.random.default_rng(1)
    film = random.uniform(-1.0, 1.0, (2, block.B)) * [[18.0], [12.0]]
    rows = [block.X, block.Y, block.Z, block.L, block.M, block.N, block.WEIGHT]
    u0, u1 = random.random((2, block.B))
    given = {block.X: film[0], block.Y: film[1], block.U0: u0, block.U1: u1}
    return dict(zip(rows, Program([table.step(1.0)]).run(given, rows, block.B), strict=True))
