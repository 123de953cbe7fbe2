"""The kernels that the panels use, compiled before the first of them is drawn.

Compiling takes seconds on the first start ever: call `prepare` from a thread of
its own, or behind a progress bar, and draw the panels when it is done.
"""

from lensbench.app.coc_curves import curves, plot_range
from lensbench.app.pupil_sketch import box_samples
from lensbench.app.readings import optical, readings, setup
from lensbench.app.section_sketch import sketch
from lensbench.app.settings import Settings


def prepare(settings: Settings) -> None:
    """Compute once what every panel shows of these settings; what cannot be computed the panels explain."""
    try:
        got = readings(settings)
        sketch(settings)
        curves(optical(settings), *plot_range(settings, got)[:2])
        stand = setup(settings)
        box_samples(stand.lens, stand.film_distance, 0.0)
    except (ValueError, OSError):
        return
