"""How long a whole picture takes until it is right to a given error: models with what their samples are worth.

A picture of 180 × 120 pixels is taken by every model, from its set-up on, on all cores; after 1, 2, 4, … samples
it is compared with a converged picture by the full trace. The error is the root mean square of linear light, clipped
to [0, 1], in percent of white. A model that is wrong stops getting better: its curve turns level.
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
from lensbench.scenery.scene import Scene

PIXELS = (180, 120)
GOALS = (1.0, 0.3)              # percent of white
CONVERGED = 8192                # samples of each of the two pictures that make the one to compare with
ROUNDS = 3
LONGEST = 3.0                   # seconds that a picture of one model is followed
FEWEST = 3                      # points of a curve, however long they take


class Way(NamedTuple):
    """One way to take the picture, and how its curve looks."""

    name: str
    model: str
    tint: str
    white: bool = False         # by white noise in place of the default samples
    light_tracing: bool = True  # trace small lights from the light to the film


WAYS = (Way("pinhole", "pinhole", "grey"), Way("thin lens", "thin", "sky"), Way("thick lens", "thick", "blue"),
        Way("polynomial, degree 9", "polynomial", "vermilion"), Way("full trace", "trace", "green"),
        Way("full trace, white noise", "trace", "green", white=True),
        Way("full trace, lights found by the camera", "trace", "purple", light_tracing=False))


def image_panel(key: str, camera: lb.LensCamera, scene: Scene, progress: Callable[[float], bool] = lambda _: True,
                longest: float = LONGEST, converged: int = CONVERGED) -> Panel:
    """The curve of error against seconds of every model before a scene.

    progress: receives the part that is done; False cancels.
    """
    camera = replace(camera, model="trace", film=replace(camera.film, pixels_x=PIXELS[0], pixels_y=PIXELS[1]))
    pair = []
    for seed in (12345, 54321):
        pair.append(lb.render(camera, scene, converged, seed))
        report_progress(progress, 0.2 * len(pair))
    truth = _clipped(np.mean(pair, 0))
    known = 50.0 * math.sqrt(np.mean((_clipped(pair[0]) - _clipped(pair[1])) ** 2))
    runs: dict[Way, list[list[tuple[float, float]]]] = {way: [] for way in WAYS}
    for way in WAYS:                                    # kernels compile now
        _followed(way, camera, scene, truth, 0, 0.0)
    for round in range(ROUNDS):
        for i, way in enumerate(WAYS):
            runs[way].append(_followed(way, camera, scene, truth, round, longest))
            report_progress(progress, 0.4 + 0.6 * (round + (i + 1) / len(WAYS)) / ROUNDS)
    curves = tuple(_curve(way, runs[way]) for way in WAYS)
    levels = tuple((goal, f"{goal:g} %") for goal in GOALS)
    return Panel(key, scene.name, "Time (s)", "Error, rms (% of white)", curves, levels, conditions=
                 f"{PIXELS[0]} × {PIXELS[1]} pixels, {camera.lens.name}; the picture to compare with is known "
                 f"to {known:.2g} %")


def _clipped(image: np.ndarray) -> np.ndarray:
    return np.clip(image.astype(float), 0.0, 1.0)


def _followed(way: Way, camera: lb.LensCamera, scene: Scene, truth: np.ndarray, seed: int,
              longest: float) -> list[tuple[float, float]]:
    """(seconds, mean square error) after 1, 2, 4, … samples, until the time is up."""
    placing = [Step(white_noise, PIXELS)] if way.white else None
    start = time.perf_counter()
    rendering = lb.Rendering(replace(camera, model=way.model), scene, seed, steps=placing,
                             light_tracing=way.light_tracing)
    spent = time.perf_counter() - start
    found: list[tuple[float, float]] = []
    while 2.0 * spent < longest or len(found) < FEWEST:         # the next step takes as long as all before
        start = time.perf_counter()
        rendering.add(max(rendering.samples, 1))
        spent += time.perf_counter() - start
        found.append((spent, float(np.mean((_clipped(rendering.image()) - truth) ** 2))))
    return found


def _curve(way: Way, runs: list[list[tuple[float, float]]]) -> Curve:
    """The least time and the mean error of the rounds, which differ in their seeds."""
    points = tuple((min(second for second, _ in same), 100.0 * math.sqrt(np.mean([error for _, error in same])))
                   for same in zip(*runs, strict=False))
    figures = {f"to {goal:g} %, s": reached(points, goal) for goal in GOALS}
    return Curve(way.name, way.tint, points, figures | {"at last, %": points[-1][1]}, way.white)


def reached(points: tuple[tuple[float, float], ...], goal: float) -> float:
    """When the error is down to the goal for good, between points as a power of time; inf where it never is."""
    above = [i for i, (_, error) in enumerate(points) if error > goal]
    if not above:
        return points[0][0]
    last = above[-1]
    if last == len(points) - 1:
        return math.inf
    (t0, e0), (t1, e1) = points[last], points[last + 1]
    share = math.log(e0 / goal) / math.log(e0 / e1)
    return t0 * (t1 / t0) ** share
