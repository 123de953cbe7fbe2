"""What the camera models cost beside the full trace, and how far off they are: a part of `lensbench bench`."""

from collections.abc import Iterator
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import LENS, blocks, least
from lensbench.kernels import block
from lensbench.kernels.program import Program, stage_address
from lensbench.lens_models.polynomial import DEGREES, Polynomial
from lensbench.optics.block_trace import trace_step
from lensbench.pupils.radial_sampler import PupilTable

NAMES = (LENS, "pbrt-fisheye-10mm")
TIMES = 60                  # blocks in one piece of work
PIXEL = 0.004               # mm


def polynomials() -> Iterator[tuple[str, float, str]]:
    """Fitted polynomials against the full trace: 512 rays in the first cache, one thread, float32; the fit."""
    for name in NAMES:
        lens, distance = lenses.load(name), 1200.0
        film_distance = lb.film_distance(lens, distance)
        table = PupilTable.of(lens, film_distance, 21.6, widened=False)
        bench, given = _aimed(table)
        fits = {degree: Polynomial.fit(lens, film_distance, table, degree, distance=distance) for degree in DEGREES}
        steps = {"nothing": block.Step(nothing, [0.0]), "trace": trace_step(lens, film_distance),
                 **{str(degree): fit.step for degree, fit in fits.items()}}
        key = np.zeros(block.KEYS, np.uint32)
        best = least({
            label: partial(blocks, bench, given, np.asarray(step.parameters, np.float32), key,
                           stage_address(step.kernel, np.float32), TIMES)
            for label, step in steps.items()})
        trace = best["trace"] - best["nothing"]
        for degree, fit in fits.items():
            ratio = trace / (best[str(degree)] - best["nothing"])
            yield f"trace / polynomial of degree {degree}, {name}", ratio, "×"
            yield f"polynomial of degree {degree}, rms error, {name}", fit.rms / PIXEL, "px of 4 µm"
        seconds = least({
            "fit": partial(Polynomial.fit, lens, film_distance, table, 9, distance=distance),
            "both": partial(_with_pupil, lens, film_distance)})
        yield f"fit of degree 9, {name}", 1e3 * seconds["fit"], "ms"
        yield f"fit of degree 9 with its pupil, {name}", 1e3 * seconds["both"], "ms"


def _with_pupil(lens: lb.Lens, film_distance: float) -> Polynomial:
    return Polynomial.fit(lens, film_distance, PupilTable.of(lens, film_distance, 21.6, widened=False), 9)


@block.stage
def nothing(bench, p, key):
    """A stage that leaves the rays alone: what putting them back costs."""


def _aimed(table: PupilTable) -> tuple[np.ndarray, np.ndarray]:
    """A workbench, and its ray rows with a block of rays that leave the film for their regions."""
    random = np.random.default_rng(1)
    film = random.uniform(-1.0, 1.0, (2, block.B)) * [[18.0], [12.0]]
    rows = [block.X, block.Y, block.Z, block.L, block.M, block.N, block.WEIGHT]
    u0, u1 = random.random((2, block.B))
    given = {block.X: film[0], block.Y: film[1], block.U0: u0, block.U1: u1}
    out = Program([table.step(1.0)]).run(given, rows, block.B)
    bench = block.lane_buffer()
    bench.reshape(block.ROWS, block.PITCH)[rows, :block.B] = out
    return bench, bench[block.X * block.PITCH:block.WEIGHT * block.PITCH + block.B].copy()
