"""The circle of confusion as curves against distance: of the thin lens, the thick lens and the traced real lens.

Distances in metres from the film, beyond a window into water as well; diameters in micrometres on the film.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.dial_scales import WHOLE_STOPS
from lensbench.app.state.figures import Readings
from lensbench.app.state.file_cache import Stamp, file_stamp
from lensbench.app.state.ideal_cameras import focused_lens
from lensbench.app.state.settings import Settings
from lensbench.app.state.water_window import port_of

NEIGHBOURS = (-1, 2, 5)         # stops from the present f-number, drawn faint
SMALLEST = 1e-4                 # µm: least diameter at the focus, below every plot
ROUND = (1.0, 2.0, 5.0)


@dataclass(frozen=True, eq=False)
class Curves:
    """Diameters (µm) at distances (m) from the film; real is None for a lens model that traces no rays."""

    distances: np.ndarray
    thin: np.ndarray
    thick: np.ndarray | None
    real: np.ndarray | None
    neighbours: tuple[tuple[float, np.ndarray], ...]


def plot_range(got: Readings) -> tuple[float, float, float, float]:
    """Distances (m) and diameters (µm) of the plot of a lens, the same for every stop and focus.

    The diameters get a decade more where a near focus blurs distant objects beyond the plot.
    """
    nearest = (got.nearest_focus or 4.0 * (got.efl or 50.0)) / 1000.0
    widest = got.widest_f_number or min(got.f_number or 2.8, 2.8)
    efl = got.efl or 50.0
    reach = efl * efl / (widest * (got.limit or 0.03)) / 1000.0
    low = _round_down(max(nearest, 0.01))
    high = _round_up(min(max(1.1 * reach, 60.0 * low, 20.0), 1000.0))
    top = _round_up(max(3000.0 * efl * efl / (widest * max(1000.0, 4.0 * efl)), 300.0))
    magnification = got.magnification or 0.0
    if 1000.0 * efl * magnification / (got.f_number or widest) > top:
        top *= 10.0
    return low, high, 2.0, top


def curves(settings: Settings, low: float, high: float) -> Curves:
    """The curves of these settings between two distances (m); ValueError or OSError if there are none."""
    return _curves(settings, low, high, file_stamp(settings.lens))


@lru_cache(maxsize=32)
def _curves(settings: Settings, low: float, high: float, lens: Stamp) -> Curves:
    got = readings(settings)
    if got.efl is None or got.f_number is None:
        raise ValueError(got.reason or "A pinhole has no circle of confusion")
    focus = settings.focus_distance
    distances = np.geomspace(low, high, 72) * 1000.0
    if math.isfinite(focus):
        steps = np.geomspace(1e-3, 0.3, 16)
        distances = np.concatenate([distances, [focus], focus * (1.0 - steps), focus * (1.0 + steps)])
        distances = np.unique(distances[(distances >= 1000.0 * low) & (distances <= 1000.0 * high)])
    if not settings.focuses:
        raise ValueError("A pinhole has no focus: hole and diffraction blur all distances nearly alike")
    if not settings.has_lens:
        port = port_of(settings)
        thin = lb.circle_of_confusion(*focused_lens(settings), port.apparent(focus), port.apparent(distances))
        return Curves(distances / 1000.0, _micrometres(thin), None, None, _neighbours(got, thin))
    lens_setup = setup(settings)
    offset, metres = lens_setup.principal_offset, distances / 1000.0
    distances = lens_setup.port.apparent(distances)
    from_lens = np.maximum(distances - offset, 1e-3)
    s_f = max(lens_setup.focus_distance, lb.nearest_focus(lens_setup.lens)) - offset
    thin = np.where(distances > offset,
                    lb.circle_of_confusion(got.efl, lens_setup.at_infinity.f_number, s_f, from_lens), np.nan)
    thick = lb.thick_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)
    real = None
    if settings.follows_lens:
        real = _micrometres(lb.real_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)[0])
    return Curves(metres, _micrometres(thin), _micrometres(thick), real, _neighbours(got, thick))


def _micrometres(millimetres: np.ndarray) -> np.ndarray:
    return np.maximum(1000.0 * millimetres, SMALLEST)


def _neighbours(got: Readings, coc: np.ndarray) -> tuple[tuple[float, np.ndarray], ...]:
    """The curve at neighbouring whole stops: a diameter is proportional to 1 / f-number."""
    present = got.f_number
    assert present is not None
    here = min(range(len(WHOLE_STOPS)), key=lambda i: abs(math.log(WHOLE_STOPS[i] / present)))
    found = []
    for step in NEIGHBOURS:
        if 0 <= here + step < len(WHOLE_STOPS):
            f_number = WHOLE_STOPS[here + step]
            if 0.98 * (got.widest_f_number or 0.0) <= f_number <= max(32.0, present):
                found.append((f_number, _micrometres(coc * present / f_number)))
    return tuple(found)


def main_curve(shown: Curves) -> np.ndarray:
    """The curve that the rendered picture follows."""
    return shown.real if shown.real is not None else shown.thick if shown.thick is not None else shown.thin


def _round_down(value: float) -> float:
    decade = 10.0 ** math.floor(math.log10(value))
    return max(step * decade for step in ROUND if step * decade <= value * 1.05)


def _round_up(value: float) -> float:
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (*ROUND, 10.0) if step * decade >= value * 0.999)
