"""Cost of the analyses, a part of `lensbench bench`: twelve fields and three colours, as the panels ask for them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.grids.grid_trace import ray_grid
from lensbench.app.studies.timing import least_times

LENS = "lib-tronnier-1953"      # six lenses, glasses with dispersion


def analysis() -> Iterator[tuple[str, float, str]]:
    """The ray grid, each plot from it, all of them, the MTF map and the PSFs; 32 points across the pupil."""
    lens = lenses.load(LENS)
    away = lb.film_distance(lens, math.inf)
    of = lb.analysis
    given, nine = of.conditions(lens, lb.Film()), of.conditions(lens, lb.Film(), 9)
    grid = of.ray_grid(lens, away, given)
    fine = of.ray_grid(lb.stopped_down(lens, 5.6), away, nine, 64)

    def anew(make: Callable[[], object]) -> Callable[[], object]:
        """The work with a grid that is not kept."""
        def work() -> object:
            ray_grid.cache_clear()
            return make()
        return work

    plots: dict[str, Callable[[], object]] = {
        "spots": lambda: of.spots(grid),
        "ray and OPD fans": lambda: of.ray_fans(grid),
        "wavefronts with 37 Zernike terms": lambda: of.wavefronts(grid),
        "field curves": lambda: of.field_curves(lens, away, given),
        "longitudinal aberration": lambda: of.longitudinal_aberration(lens, away, given),
        "chromatic focal shift": lambda: of.chromatic_focal_shift(replace(lens), away, given),  # a lens keeps its own
        "MTF at four frequencies": lambda: of.mtf(grid),
    }
    grids: dict[str, Callable[[], object]] = {
        "ray grid, 12 fields, 3 colours": anew(lambda: of.ray_grid(lens, away, given)),
        "MTF map 64 × 64, 3 colours, with its rays": anew(lambda: of.mtf_map(lens, away, given)),
        "the same coarse, 32 fields, 16 points": anew(lambda: of.mtf_map(lens, away, given, fields=32, pupil=16)),
    }
    rest: dict[str, Callable[[], object]] = {
        "PSF 256², 9 fields, 3 colours": lambda: of.psf(fine),
        "focus shift, 9 apertures": anew(lambda: of.focus_shift(lens, away, given)),
    }
    best = least_times({**plots, **grids, **rest}, 0.2)
    for name, seconds in best.items():
        yield name, 1e3 * seconds, "ms"
    yield "ray grid and the seven plots", 1e3 * (sum(best[name] for name in plots) + best[next(iter(grids))]), "ms"
