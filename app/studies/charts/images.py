"""Time to a given error of a whole picture: cost of each camera model together with the quality of its samples.

Every model renders a picture of 180 × 120 pixels on all cores; the time includes set-up. After 1, 2, 4, … samples the
picture is compared with a converged one by the full trace. The error is the root mean square of linear light, clipped
to [0, 1], in percent of white. The curve of a model with a systematic error becomes level.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.charts.samplers import white_noise
from lensbench.app.studies.timing import report_progress
from lensbench.kernels.block import Step
from lensbench.kernels.figures import significant
from lensbench.scenery.scene import Scene

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
    found: list[tuple[float, float]] = []
    while 2.0 * spent < longest or len(found) < FEWEST:         # the next step takes as long as all before together
        start = time.perf_counter()
        rendering.add(max(rendering.samples, 1))
        spent += time.perf_counter() - start
        found.append((spent, float(np.mean((_clipped(rendering.image()) - truth) ** 2))))
    return found


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
