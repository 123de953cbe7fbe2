"""The sunstar of the blades: its picture, and its brightness around."""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.analysis.blade_star import Sunstar, sunstar
from lensbench.app.state.analysis.figure import Area, Axis, Curve, Figure, Map, Plot, Table, reach
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.analysis.spots import AXIS
from lensbench.kernels.figures import significant

FIELDS = {"axis": 0.0, "middle": 0.7}
PIXELS = 181
DECADES = 3.5
NO_BLADES = "A round stop draws no star: choose a number of blades in the popup Stop, and stop down"


def star_figure(query: Query, points: int, field: str = "axis") -> Figure:
    """Picture of the star about a small light at a field of FIELDS, and its brightness over the direction.

    LensError for a round stop, and where no light reaches the film.
    """
    lens = query.setup.lens
    if lens.iris.is_round:
        raise lb.LensError(NO_BLADES)
    at = query.parts(FIELDS[field])[0]
    point = (0.0, at) if isinstance(at, float) else at
    height = math.hypot(*point)
    found = _star(lens, query.setup.film_distance, point, points > 16)
    half = 1000.0 * float(found.radii[-1]) / math.sqrt(2.0)
    light = _picture(found, half / 1000.0)
    count, number = len(found.rays), lb.f_number_at_infinity(lens)
    blades = f"{lens.iris.blades} blades, f/{significant(number, 2)}"
    title = f"{count} rays" if count else "no rays"
    picture = Plot(Axis("x (µm)", -half, half), Axis("y (µm)", -half, half), (
        Map("of the brightest shown", light, (-half, half), (-half, half), decades=DECADES),), title, equal=True)
    degrees = np.degrees(np.append(found.azimuths, 2.0 * math.pi))
    around = np.append(found.profile, found.profile[0])
    top = reach([float(around.max())])
    layers: list = [Curve("brightness", degrees, around)]
    layers += [Area((at - 5.0, at + 5.0), (0.1, top), f"ray at {significant(at, 3)}°")
               for at in np.degrees(found.rays).tolist()]
    profile = Plot(Axis("Direction (°)", 0.0, 360.0), Axis("Brightness (× median)", 0.1, top, log=True), tuple(layers))
    words = query.words(None, blades, "a point of light at the " + ("centre" if height < AXIS else
                                                                    f"height {significant(height, 3)} mm"),
                        "white light by diffraction, 0.42 to 0.68 µm", "aberrations left out")
    table = Table(("direction (deg)", "brightness (x median)"), tuple(zip(degrees[:-1], around[:-1], strict=True)))
    return Figure("Sunstar", ((picture,), (profile,)), table, words, (), (0.7, 0.3))


@lru_cache(maxsize=8)
def _star(lens: lb.Lens, film_distance: float, point: tuple[float, float], fine: bool) -> Sunstar:
    """The star of a film point (mm); coarse ones have fewer directions and wavelengths."""
    return sunstar(lens, film_distance, point, azimuths=720 if fine else 360, colours=24 if fine else 10)


def _picture(found: Sunstar, half: float) -> np.ndarray:
    """Light (PIXELS, PIXELS) over x and y from −half to half (mm), 1 at its brightest.

    Within the innermost radius it is that of this radius.
    """
    at = half * (2.0 * (np.arange(PIXELS) + 0.5) / PIXELS - 1.0)
    r = np.log(np.maximum(np.hypot(at, at[:, None]), found.radii[0]))
    steps = np.log(found.radii)
    i = np.clip((r - steps[0]) / (steps[1] - steps[0]), 0.0, len(steps) - 1.001)
    j = (np.arctan2(at[:, None], at) / (2.0 * math.pi) % 1.0) * len(found.azimuths)
    low, left = i.astype(int), j.astype(int) % len(found.azimuths)
    u, v, right = i - low, j - np.floor(j), (left + 1) % len(found.azimuths)
    logs = np.log(np.maximum(found.density, 1e-30))
    light = np.exp((1 - u) * ((1 - v) * logs[low, left] + v * logs[low, right])
                   + u * ((1 - v) * logs[low + 1, left] + v * logs[low + 1, right]))
    return np.asarray(light / light.max())
