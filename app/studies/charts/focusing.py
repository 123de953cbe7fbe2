"""Focusing methods: time against the blur in excess of the least possible blur.

The blur of an axis point is 2√2 × rms over the whole bundle. The excess is that on the film found by the method, less
that on the best film; root mean square over objects at 0.5 m, 2 m and 10 m.
"""

import math
from collections.abc import Callable
from functools import partial
from itertools import count

import numpy as np

import lensbench as lb
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.stability.focus_baselines import bracketing_search, school_formula
from lensbench.app.studies.stability.focusing import closed_form, least_blur, rms_radius, three_rays, whole_bundle
from lensbench.app.studies.timing import report_progress, time_in_turn
from lensbench.kernels.figures import significant

DISTANCES = (500.0, 2000.0, 10_000.0)
LEAST_DRAWN = 0.01              # µm: a smaller excess is drawn here
SECONDS = 0.1                   # of timing
PIXEL = 4.0                     # µm, marked in the chart
_runs = count(1)                # of all methods and charts

METHODS: dict[str, tuple[Callable[[lb.Lens, float], float | str], str, bool]] = {
    "school formula, float32": (lambda lens, at: school_formula(lens, at, np.float32), "grey", True),
    "school formula, float64": (lambda lens, at: school_formula(lens, at, np.float64), "grey", False),
    "closed form (the program's)": (closed_form, "green", False),
    "bracketing search by one ray": (lambda lens, at: bracketing_search(lens, at, np.float64), "purple", False),
    "bracketing search by three": (three_rays, "purple", True),
    "whole bundle (the program's)": (whole_bundle, "vermilion", False),
    "golden section over 200 rays": (least_blur, "blue", False)}


def focus_panel(key: str, lens: lb.Lens, progress: Callable[[float], bool] = lambda _: True) -> Panel:
    """Time (µs) and excess blur (µm) of every method, for one lens at its f-number."""
    distances = [at for at in DISTANCES if at >= 1.02 * lb.nearest_focus(lens)]
    least = {at: rms_radius(lens, least_blur(lens, at), at) for at in distances}
    report_progress(progress, 0.3)
    times = time_in_turn({name: partial(_all, method, lens, distances)
                          for name, (method, _, _) in METHODS.items()}, SECONDS)
    report_progress(progress, 0.8)
    curves = []
    for name, (method, tint, dotted) in METHODS.items():
        blurs = [_excess(method(lens, at), lens, at, least[at]) for at in distances]
        blur, cost = math.sqrt(sum(b * b for b in blurs) / len(blurs)), 1e6 * times[name].least / len(distances)
        figures = {"time, µs": cost, "blur, µm": blur}
        points = ((cost, max(blur, LEAST_DRAWN)),) if math.isfinite(blur) else ()
        curves.append(Curve(name, tint, points, figures, dotted))
    report_progress(progress, 1.0)
    f_number, name = lb.first_order(lens).f_number, lens.name or key
    states_f_number = any(f"f/{f_number:.{digits}g}" in name for digits in (2, 3))
    return Panel(key, name if states_f_number else f"{name}, f/{significant(f_number, 3)}", "Time (µs)",
                 "Blur beyond the least (µm)", tuple(curves), ((PIXEL, "a pixel of 4 µm"),))


def _all(method: Callable[[lb.Lens, float], float | str], lens: lb.Lens, distances: list[float]) -> None:
    """Focus at every distance (mm), to be timed: each run a little farther, for the program keeps its results."""
    farther = 1.0 + 1e-9 * next(_runs)
    for at in distances:
        method(lens, at * farther)


def _excess(found: float | str, lens: lb.Lens, at: float, least: float) -> float:
    """Excess blur (µm) on the film that a method found for an object at a distance (mm), over that of the rms radius
    `least` (mm); inf if it found no film distance.
    """
    if isinstance(found, str) or not math.isfinite(found):
        return math.inf
    return max(2e3 * math.sqrt(2.0) * (rms_radius(lens, found, at) - least), 0.0)
