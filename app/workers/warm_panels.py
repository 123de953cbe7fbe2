"""Cache warm-up of the kernels that the panels use, before the first panel is drawn.

Compiling takes seconds at the very first start: call `prepare` from a thread of its own, and draw the panels when it
is done.
"""

from lensbench.app.state.build import setup
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.geometry.circle_of_confusion import curves, plot_range
from lensbench.app.state.geometry.exit_pupil import box_samples
from lensbench.app.state.geometry.section import sketch
from lensbench.app.state.pixel.readings import pixel_readings
from lensbench.app.state.settings import Settings


def prepare(settings: Settings) -> None:
    """Compute once what every panel shows of these settings; the panels show the errors."""
    try:
        got = readings(settings)
        sketch(settings)
        curves(settings.optics, *plot_range(got)[:2])
        built = setup(settings)
        box_samples(built.lens, built.film_distance, 0.0)
        pixel_readings(settings, (0.5 * settings.film.pixels_x, 0.5 * settings.film.pixels_y))
    except (ValueError, OSError):
        return
