"""The circle of confusion: of every pixel, for the overlays, and as curves against distance.

Pixels: from the depth map by the formula of the thin lens. With s measured from the front principal plane and u = 1/s
the diameter is c = A f |u_focus − u| / (1 − f u_focus), A the diameter of the entrance pupil: linear in u.

Curves: thin lens, thick lens, and the traced real lens. Distances in metres from the film, diameters in micrometres on
the film.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.dial_scales import WHOLE_STOPS
from lensbench.app.state.figures import Readings, blur_limit, readings
from lensbench.app.state.file_cache import Stamp, file_stamp
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import lean_at, leans

NEIGHBOURS = (-1, 2, 5)         # stops from the present f-number, drawn faint
SMALLEST = 1e-4                 # µm: least diameter at the focus, below every plot
ROUND = (1.0, 2.0, 5.0)


@dataclass(frozen=True)
class Blur:
    """CoC in pixels = gain |focus − n + lean · (power − n)|, n = 1/(depth − offset).

    The lean of a point of a film out of line is its distance from the plane of the film's middle, over that plane's
    distance from the rear principal plane: leans[0] + leans[1] · x + leans[2] · y for parts of the picture's width and
    height, and curve[3] times the sag of a curved film, of the curvature curve[0] (1/mm), curve[1] × curve[2] mm large.
    A lens out of line adds to the leans. sharp: the diameter up to which a pixel counts as in focus.
    """

    gain: float = 0.0           # pixels · mm
    focus: float = 0.0          # 1/mm
    offset: float = 0.0         # mm from the film to the front principal plane
    sharp: float = 1.5          # pixels
    power: float = 0.0          # 1/mm, of the lens
    leans: tuple[float, float, float] = (0.0, 0.0, 0.0)
    curve: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def pixels(self, depth: float, part: tuple[float, float]) -> float:
        """The diameter (pixels) of a point at a depth (mm, or inf) that a part of the picture shows."""
        nearness = 0.0 if math.isinf(depth) else 1.0 / max(depth - self.offset, 1e-3)
        c, width, height, per_mm = self.curve
        r2 = ((part[0] - 0.5) * width) ** 2 + ((part[1] - 0.5) * height) ** 2
        lean = self.leans[0] + self.leans[1] * part[0] + self.leans[2] * part[1]
        lean += per_mm * c * r2 / (1.0 + math.sqrt(max(1.0 - c * c * r2, 0.0)))
        return self.gain * abs(self.focus - nearness + lean * (self.power - nearness))

    @classmethod
    def of(cls, settings: Settings) -> "Blur":
        """The blur of these settings; zero where nothing is blurred, or where there is no lens."""
        try:
            return _blur(settings.optics, file_stamp(settings.lens))
        except (ValueError, OSError, ZeroDivisionError):
            return cls()


@lru_cache(maxsize=16)
def _blur(settings: Settings, lens: Stamp) -> Blur:
    if not (settings.has_stop and settings.kind.f_number):
        return Blur()
    pitch, sharp = settings.film.pitch, blur_limit(settings)
    if settings.kind.ideal_lens:
        offset, efl, f_number = 0.0, readings(settings).efl or 50.0, settings.f_number or math.inf
    else:
        lens_setup = setup(settings)
        offset, efl, f_number = lens_setup.principal_offset, lens_setup.first_order.efl, lens_setup.first_order.f_number
    focus = 1.0 / max(settings.focus_distance - offset, 1.01 * abs(efl))
    of_film, curve = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if leans(settings):
        # Linear in the place on the film, but for a lens out of line, where it is so nearly
        parts = np.array([[0.5, 0.5], [1.0, 0.5], [0.0, 0.5], [0.5, 1.0], [0.5, 0.0]])
        start, *sides = lean_at(settings, parts).tolist()
        across, down = sides[0] - sides[1], sides[2] - sides[3]
        of_film = start - 0.5 * (across + down), across, down
    if settings.film_pose.is_curved:
        film, pose = settings.film, settings.film_pose
        behind = lens_setup.film_distance - lens_setup.first_order.rear_principal
        curve = pose.curvature, film.width, film.height, float(pose.axes[2, 2]) / behind
    return Blur(efl * efl / f_number / (1.0 - efl * focus) / pitch, focus, offset, sharp / pitch, 1.0 / efl, of_film,
                curve)


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
        thin = lb.circle_of_confusion(got.efl, got.f_number, focus, distances)
        return Curves(distances / 1000.0, _micrometres(thin), None, None, _neighbours(got, thin))
    lens_setup = setup(settings)
    offset = lens_setup.principal_offset
    from_lens = np.maximum(distances - offset, 1e-3)
    s_f = max(focus, got.nearest_focus or 0.0) - offset
    thin = np.where(distances > offset,
                    lb.circle_of_confusion(got.efl, lens_setup.at_infinity.f_number, s_f, from_lens), np.nan)
    thick = lb.thick_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)
    real = None
    if settings.follows_lens:
        real = _micrometres(lb.real_circle_of_confusion(lens_setup.lens, lens_setup.film_distance, distances)[0])
    return Curves(distances / 1000.0, _micrometres(thin), _micrometres(thick), real, _neighbours(got, thick))


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
