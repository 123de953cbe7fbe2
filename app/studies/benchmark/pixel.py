"""Cost of following a pixel under the mouse: a part of `lensbench bench`."""

import math
from collections.abc import Iterator
from dataclasses import replace
from resource import RUSAGE_SELF, getrusage

import numpy as np

from lensbench.app.state.build import setup
from lensbench.app.state.geometry.exit_pupil import box_samples
from lensbench.app.state.pixel.lens_rays import film_place, pixel_fan
from lensbench.app.state.pixel.readings import pixel_readings
from lensbench.app.state.settings import Settings

HOVERS = 60
LENSES = ("pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "lentil-schneider-anamorphic-31-2001")


def pixels() -> Iterator[tuple[str, float, str]]:
    """User CPU time of everything that the panels compute for a pixel: fan, region, beam, spot and figures."""
    for name in LENSES:
        settings = replace(Settings(), lens=name, f_number=None)
        built = setup(settings)
        spent = []
        for i in range(HOVERS + 5):
            raster, before = (300.5 + 5 * i, 200.5 + 3 * i), getrusage(RUSAGE_SELF).ru_utime
            pixel_fan(settings, raster)
            pixel_readings(settings, raster)
            x, y = film_place(settings, raster)
            box_samples(built.lens, built.film_distance, math.hypot(x, y), math.atan2(y, x))
            spent.append(getrusage(RUSAGE_SELF).ru_utime - before)
        yield f"pixel under the mouse, user CPU time, {name}", 1e3 * float(np.mean(spent[5:])), "ms"
