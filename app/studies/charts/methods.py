"""Charts of methods: focusing, exit-pupil regions, whole pictures and refocused light fields.

*Focusing*. The blur of an axis point is 2√2 × rms over the whole bundle. Its excess is that on the film found by the
method, less that on the best film; root mean square over objects at 0.5 m, 2 m and 10 m.

*Pupils*. The cost includes all work before the first ray of a film: 64 boxes or 64 solved regions. Light is lost where
a region is too small; samples are blocked where it is too large. Both errors are root mean squares over film points
from the centre to 0.95 of the image circle.

*Pictures* of 180 × 120 pixels on all cores; the time includes set-up. After 1, 2, 4, … samples the picture is compared
with a converged one by the full trace. The error is the root mean square of linear light, clipped to [0, 1], in percent
of white. The curve of a model with a systematic error becomes level.

*Light fields*. For even blur, neighbouring views lie at most a pixel apart (`LightField.clear_range`). The chart marks
this range, and draws dots beyond it.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.tone import decibels
from lensbench.app.drawing.sheet import AMBER, COLOURS, DIM, look, plot, save, sheet
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.charts.samplers import white_noise
from lensbench.app.studies.stability.focusing import (
    bracketing_search, closed_form, least_blur, rms_radius, school_formula, three_rays, whole_bundle
)
from lensbench.app.studies.stability.pupils import BUCKETS, FilmPoint, Result, box, paraxial_disk, result, solved
from lensbench.app.studies.timing import Time, report_progress, time_in_turn
from lensbench.core.kernels.block import Step
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.scenery.scene import Scene
from lensbench.core.text import significant

DISTANCES = (500.0, 2000.0, 10_000.0)
LEAST_DRAWN = 0.01              # µm: a smaller excess is drawn here
FOCUSING_SECONDS = 0.1                   # of timing
PIXEL = 4.0                     # µm, marked in the chart
_runs = count(1)                # of all methods and charts

METHODS: dict[str, tuple[Callable[[lb.Lens, float], float | str], str, bool]] = {
    "school formula, float32": (partial(school_formula, real=np.float32), "grey", True),
    "school formula, float64": (partial(school_formula, real=np.float64), "grey", False),
    "closed form (the program's)": (closed_form, "green", False),
    "bracketing search by one ray": (partial(bracketing_search, real=np.float64), "purple", False),
    "bracketing search by three": (three_rays, "purple", True),
    "whole bundle (the program's)": (whole_bundle, "vermilion", False),
    "golden section over 200 rays": (least_blur, "blue", False)}


def focus_panel(key: str, lens: lb.Lens, progress: Callable[[float], bool] = lambda _: True) -> Panel:
    """Time (µs) and excess blur (µm) of every method, for one lens at its f-number."""
    distances = [distance for distance in DISTANCES if distance >= 1.02 * lb.nearest_focus(lens)]
    least = {distance: rms_radius(lens, least_blur(lens, distance), distance) for distance in distances}
    report_progress(progress, 0.3)
    times = time_in_turn({name: partial(_all, method, lens, distances)
                          for name, (method, _, _) in METHODS.items()}, FOCUSING_SECONDS)
    report_progress(progress, 0.8)
    curves = []
    for name, (method, tint, dotted) in METHODS.items():
        blurs = [_excess(method(lens, distance), lens, distance, least[distance]) for distance in distances]
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
    for distance in distances:
        method(lens, distance * farther)


def _excess(film: float | str, lens: lb.Lens, distance: float, least: float) -> float:
    """Blur (µm) on a found film beyond that of the best one, of rms radius `least` (mm); inf where none was found."""
    if isinstance(film, str) or not math.isfinite(film):
        return math.inf
    return max(2e3 * math.sqrt(2.0) * (rms_radius(lens, film, distance) - least), 0.0)


FIELDS = (0.0, 0.35, 0.7, 0.95)         # share of the image-circle radius, or of half the film diagonal
PUPILS_RAYS = tuple(1 << k for k in range(8, 21, 2))
FEW = 1 << 14                           # rays of the boxes that are timed; the time is proportional to the rays
PUPILS_SECONDS = 0.15
KNOWN = 0.3                             # percent: error of the true light
TIME = "Time for all film points (ms)"


def pupil_panels(key: str, camera: lb.LensCamera, progress: Callable[[float], bool] = lambda _: True) -> list[Panel]:
    """Panels of light error and blocked samples (%) over time; StoppedError if `progress` returns False."""
    lens, away, half = camera.lens, camera.film_distance, 0.5 * camera.film.diagonal
    reach = min(half, PupilTable.of(lens, away, half).dark_beyond)
    film_points = [FilmPoint(lens, away, (share * reach, 0.0), half) for share in FIELDS]
    times = _times(film_points[-1])
    points: dict[str, list[tuple[float, Result]]] = {"paraxial disk": [], "boxes, of 256 to a million rays": [],
                                                     "solved regions": []}
    ways = [("paraxial disk", paraxial_disk, times["disk"]), ("solved regions", solved, times["solved"]), *(
        ("boxes, of 256 to a million rays", lambda point, rays=rays: box(point, rays), times["boxes"] * rays / FEW)
        for rays in PUPILS_RAYS)]
    for i, (name, method, seconds) in enumerate(ways):
        results = [result(point, method(point)) for point in film_points]
        points[name].append((1e3 * seconds, Result(*(math.sqrt(sum(x * x for x in values) / len(values))
                                                     for values in zip(*results, strict=True)))))
        report_progress(progress, (i + 1) / len(ways))
    tints = dict(zip(points, ("grey", "purple", "vermilion"), strict=True))
    panels = []
    for measure, words, floor in (("light", "Light off, rms (%)", 0.01), ("waste", "Samples blocked, rms (%)", 0.1)):
        curves = []
        for name, which in points.items():
            line = tuple((cost, max(100.0 * getattr(of, measure), floor)) for cost, of in which)
            figures = {"time, ms": line[-1][0], f"{measure}, %": 100.0 * getattr(which[-1][1], measure)}
            curves.append(Curve(name, tints[name], line, figures))
        levels = ((KNOWN, "error of the reference"),) if measure == "light" else ()
        panels.append(Panel(f"{key}, {measure}", lens.name or key, TIME, words, tuple(curves), levels))
    return panels


def _times(point: FilmPoint) -> dict[str, float]:
    """Seconds for a whole film: paraxial disk, solved regions, and boxes of FEW rays."""
    works: dict[str, Callable[[], object]] = {
        "disk": lambda: paraxial_disk(point), "boxes": lambda: box(point, FEW),
        "solved": lambda: PupilTable.of(point.lens, point.film_distance, point.reach)}
    times: dict[str, Time] = time_in_turn(works, PUPILS_SECONDS)
    return {name: time.least * (BUCKETS if name == "boxes" else 1) for name, time in times.items()}


PIXELS = (180, 120)
GOALS = (1.0, 0.3)              # percent of white
CONVERGED = 8192                # samples of each of the two reference pictures
ROUNDS = 3
LONGEST = 3.0                   # seconds of rendering for one curve
FEWEST = 3                      # points of a curve, however slow


class Variant(NamedTuple):
    """One way to render the picture, and the look of its curve."""

    name: str
    model: str
    tint: str
    white: bool = False         # white noise instead of the default samples
    light_tracing: bool = True  # trace small lights from the light to the film


VARIANTS = (Variant("pinhole", "pinhole", "grey"), Variant("thin lens", "thin", "sky"),
            Variant("thick lens", "thick", "blue"), Variant("polynomial, degree 9", "polynomial", "vermilion"),
            Variant("full trace", "trace", "green"), Variant("full trace, white noise", "trace", "green", white=True),
            Variant("full trace, lights found by the camera", "trace", "purple", light_tracing=False))


def image_panel(key: str, camera: lb.LensCamera, scene: Scene, progress: Callable[[float], bool] = lambda _: True,
                longest: float = LONGEST, converged: int = CONVERGED) -> Panel:
    """Error against seconds for every way to render a scene.

    progress: receives the finished share; False cancels.
    """
    camera = replace(camera, model="trace", film=replace(camera.film, pixels_x=PIXELS[0], pixels_y=PIXELS[1]))
    pair = []
    for seed in (12345, 54321):
        pair.append(lb.render(camera, scene, converged, seed))
        report_progress(progress, 0.2 * len(pair))
    truth = _clipped(np.mean(pair, 0))
    known = 50.0 * math.sqrt(np.mean((_clipped(pair[0]) - _clipped(pair[1])) ** 2))
    runs: dict[Variant, list[list[tuple[float, float]]]] = {variant: [] for variant in VARIANTS}
    for variant in VARIANTS:                            # kernels compile now
        _timed_errors(variant, camera, scene, truth, 0, 0.0)
    for round in range(ROUNDS):
        for i, variant in enumerate(VARIANTS):
            runs[variant].append(_timed_errors(variant, camera, scene, truth, round, longest))
            report_progress(progress, 0.4 + 0.6 * (round + (i + 1) / len(VARIANTS)) / ROUNDS)
    curves = tuple(_curve(variant, runs[variant]) for variant in VARIANTS)
    levels = tuple((goal, f"{significant(goal)} %") for goal in GOALS)
    return Panel(key, scene.name, "Time (s)", "Error, rms (% of white)", curves, levels, conditions=
                 f"{PIXELS[0]} × {PIXELS[1]} pixels, {camera.lens.name}; error of the reference "
                 f"picture {significant(known, 2)} %")


def _clipped(image: np.ndarray) -> np.ndarray:
    return np.clip(image.astype(float), 0.0, 1.0)


def _timed_errors(variant: Variant, camera: lb.LensCamera, scene: Scene, truth: np.ndarray, seed: int,
              longest: float) -> list[tuple[float, float]]:
    """(seconds, mean square error) after 1, 2, 4, … samples, for about `longest` seconds."""
    placing = [Step(white_noise, PIXELS)] if variant.white else None
    start = time.perf_counter()
    rendering = lb.Rendering(replace(camera, model=variant.model), scene, seed, steps=placing,
                             light_tracing=variant.light_tracing)
    spent = time.perf_counter() - start
    errors: list[tuple[float, float]] = []
    while 2.0 * spent < longest or len(errors) < FEWEST:         # the next step takes as long as all before together
        start = time.perf_counter()
        rendering.add(max(rendering.samples, 1))
        spent += time.perf_counter() - start
        errors.append((spent, float(np.mean((_clipped(rendering.image()) - truth) ** 2))))
    return errors


def _curve(variant: Variant, runs: list[list[tuple[float, float]]]) -> Curve:
    """Least time and mean error of the rounds, which differ in their seeds."""
    points = tuple((min(second for second, _ in same), 100.0 * math.sqrt(np.mean([error for _, error in same])))
                   for same in zip(*runs, strict=False))
    figures = {f"to {significant(goal)} %, s": reached(points, goal) for goal in GOALS}
    return Curve(variant.name, variant.tint, points, figures | {"final error, %": points[-1][1]}, variant.white)


def reached(points: tuple[tuple[float, float], ...], goal: float) -> float:
    """Time at which the error reaches the goal for good, by a power law between points; inf if it never does."""
    above = [i for i, (_, error) in enumerate(points) if error > goal]
    if not above:
        return points[0][0]
    last = above[-1]
    if last == len(points) - 1:
        return math.inf
    (t0, e0), (t1, e1) = points[last], points[last + 1]
    share = math.log(e0 / goal) / math.log(e0 / e1)
    return t0 * (t1 / t0) ** share


VIEWS = (3, 5, 9, 17)
NEARER = tuple(0.25 * k for k in range(1, 11))          # recorded focus distance over the distances tried
LIGHT_FIELDS_RAYS = 1445                     # rays of a pixel over the whole pupil: 17 × 17 × 5
TRUTH = 1024                    # samples a pixel of the reference pictures
BORDER = 10                     # of each side: 1 / BORDER is left out, since not every view sees it


class ErrorCurve(NamedTuple):
    """Measured errors of a light field of views × views."""

    views: int
    near: float                 # mm: range in which views lie at most a pixel apart
    far: float
    distances: tuple[float, ...]
    decibels: tuple[float, ...]


def measure(camera: lb.Camera, scene: lb.Scene, views: tuple[int, ...] = VIEWS, seed: int = 0,
            progress: Callable[[float], object] = lambda share: None) -> list[ErrorCurve]:
    """Capture light fields at the focus of the camera, and compare their refocused pictures with the camera's pictures.

    All have the same number of rays a pixel. progress: receives the finished share. Raises FocusError and the other
    errors of `lb.capture_light_field`.
    """
    focus: float = camera.focus_distance                # type: ignore[attr-defined]
    fields = []
    for number in views:
        samples = max(round(LIGHT_FIELDS_RAYS / number**2), 1)
        fields.append(lb.capture_light_field(camera, scene, (number, number), samples, seed))
        progress(0.5 * len(fields) / len(views))
    distances = [focus / ratio for ratio in NEARER if focus / ratio >= fields[0].nearest]
    inner = tuple(slice(size // BORDER, size - size // BORDER) for size in (camera.film.pixels_y, camera.film.pixels_x))
    quality = np.empty((len(views), len(distances)))
    for j, distance in enumerate(distances):
        refocused = camera.refocused(distance)
        direct = lb.render(refocused, scene, TRUTH, seed + 1)[inner]
        quality[:, j] = [decibels(field.refocus(distance)[inner], direct) for field in fields]
        progress(0.5 + 0.5 * (j + 1) / len(distances))
    true = camera.flat_port.true                        # beyond a window into water
    ranges = [field.clear_range for field in fields]
    return [ErrorCurve(number, true(near), true(far), tuple(map(true, distances)), tuple(row))
            for number, (near, far), row in zip(views, ranges, quality.tolist(), strict=True)]


def draw(curves: list[ErrorCurve], focus: float, title: str, conditions: str, path: Path) -> None:
    """Write the chart; ExportError where it cannot be written. focus: focus distance of the capture, mm."""
    colours = [COLOURS[name] for name in ("grey", "sky", "blue", "vermilion", "purple", "green")]
    with look():
        figure = sheet(8.0, 4.8)
        axes = plot(figure.add_subplot(), "Focus distance (m), even in the reciprocal",
                    "Against a camera focused there (dB)", title)
        for k, curve in enumerate(curves):
            colour, x = colours[k % len(colours)], 1e3 / np.array(curve.distances)
            inside = (np.array(curve.distances) >= curve.near) & (np.array(curve.distances) <= curve.far)
            axes.plot(x, curve.decibels, color=colour, linestyle=(0, (1, 2)), linewidth=1.2)
            axes.plot(np.where(inside, x, np.nan), curve.decibels, "o-", color=colour, markersize=3.5,
                      label=f"{curve.views} × {curve.views} views")
            for end in (1e3 / curve.near, 1e3 / curve.far):
                if x.min() < end < x.max():
                    axes.axvline(end, color=colour, linewidth=0.9, linestyle=(0, (4, 3)))
        axes.axvline(1e3 / focus, color=AMBER, linewidth=1.2)
        axes.text(1e3 / focus, 1.0, " recorded", transform=axes.get_xaxis_transform(), color=AMBER, va="top",
                  fontsize=8.5)
        ticks = [d for d in (0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
                 if x.min() <= 1.0 / d <= x.max()]
        axes.set_xticks([1.0 / d for d in ticks], [significant(d) for d in ticks])
        axes.legend(frameon=False, loc="best")
        figure.supxlabel(conditions, color=DIM, fontsize=8.0, x=0.01, ha="left")
        save(figure, path)
