"""Cost and gain of averaging patterns over the pixel: a part of `lensbench bench`."""

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import FILM, LENS, least_times
from lensbench.cameras.differentials import spread_step

SMALL = lb.Film(36.0, 24.0, 180, 120)


def differentials() -> Iterator[tuple[str, float, str]]:
    """Pictures with and without filter in turn, one thread; their errors at 1 and 1024 samples; set-up of the table."""
    lens = lenses.load(LENS)
    scenes = {name: lb.builtin_scene(name) for name in ("still-life", "grid-wall", "focus-ruler")}
    camera = lb.LensCamera(lens, FILM, 1200.0, dispersion=False)
    for name, scene in scenes.items():
        best = least_times({
            words: partial(lb.Rendering(camera, scene, shadows=False, filtered=words == "filtered").add, 4, threads=1)
            for words in ("plain", "filtered")})
        yield f"filtered / plain, {name} without shadows", best["filtered"] / best["plain"], "×"
    best = least_times({model: partial(spread_step, lb.LensCamera(lens, FILM, 1200.0, model=model), np.float32)
                  for model in ("trace", "thin")})
    for model, seconds in best.items():
        yield f"pixels' spread over the film, {model}", seconds * 1e3, "ms"
    white = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    views: dict[str, tuple[lb.Camera, lb.Scene]] = {"floor to its horizon": (lb.PerspectiveCamera(SMALL), lb.Scene(
        "floor", sky=white, floor=lb.Floor(-100.0, 40.0, (0.9,) * 3, (0.1,) * 3, turn=0.3)))}
    small = lb.LensCamera(lens, SMALL, 1200.0, 8.0, dispersion=False)
    views.update({name: (small, scene) for name, scene in scenes.items()})
    for name, (view, scene) in views.items():
        def taken(samples: int, filtered: bool, seed: int, view=view, scene=scene) -> np.ndarray:
            rendering = lb.Rendering(view, scene, seed, filtered=filtered)
            rendering.add(samples)
            return np.minimum(rendering.image().astype(float), 2.0)

        truth = taken(4096, False, 1)
        for samples in (1, 1024):
            for words, filtered in (("plain", False), ("filtered", True)):
                off = math.sqrt(float(((taken(samples, filtered, 3) - truth) ** 2).mean()))
                yield f"RMSE at {samples}, {words}, {name}", off, ""
