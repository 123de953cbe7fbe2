"""Cost of capturing and refocusing light fields, and their error: a part of `lensbench bench`."""

from collections.abc import Iterator
from functools import partial
from itertools import count
from time import perf_counter

import lensbench as lb
from lensbench import lenses
from lensbench.app.state.picture.statistics import decibels
from lensbench.app.studies.timing import LENS, least_times
from lensbench.kernels.figures import significant

FILM = lb.Film(36.0, 24.0, 640, 427)
VIEWS, SAMPLES = (9, 9), 16
DISTANCES = (900.0, 1500.0, 2500.0)
EDGE = 40                   # pixels: border that not every view sees


def light_fields() -> Iterator[tuple[str, float, str]]:
    """Still life, 9 × 9 views of 640 × 427 pixels with 16 samples, by a thin lens and by a double Gauss."""
    scene = lb.builtin_scene("still-life")
    for model in ("thin", "trace"):
        def camera(distance: float, model: str = model) -> lb.LensCamera:
            return lb.LensCamera(lenses.load(LENS), FILM, distance, 2.8, model=model)

        lb.capture_light_field(camera(1200.0), scene, (1, 1), 1)            # compiles
        begin = perf_counter()
        field = lb.capture_light_field(camera(1200.0), scene, VIEWS, SAMPLES)
        yield f"light field recorded, {model}", perf_counter() - begin, "s"
        seconds = least_times({"refocus": partial(field.refocus, 1500.0)})["refocus"]
        yield f"light field focused again, {model}", 1e3 * seconds, "ms"
        for distance in DISTANCES:
            direct = lb.render(camera(distance), scene, 1024)
            inner = slice(EDGE, -EDGE), slice(EDGE, -EDGE)
            yield f"focused at {significant(distance / 1000.0)} m against a camera focused there, {model}", decibels(
                field.refocus(distance)[inner], direct[inner]), "dB"


def choices() -> Iterator[tuple[str, float, str]]:
    """Choosing the simplest model within half a pixel of the full trace."""
    film, scene = lb.Film(36.0, 24.0, 960, 640), lb.builtin_scene("still-life")
    for name, f_number in ((LENS, 2.8), (LENS, 16.0), ("pbrt-fisheye-10mm", None)):
        lens = lenses.load(name)
        choice = lb.choose_model(lb.LensCamera(lens, film, 1200.0, f_number), scene)
        moved = count(1)                    # a camera keeps its exit-pupil regions and stages

        def choose(lens=lens, f_number=f_number, moved=moved) -> object:
            return lb.choose_model(lb.LensCamera(lens, film, 1200.0 + 0.01 * next(moved), f_number), scene)

        seconds = least_times({"choose": choose})["choose"]
        yield f"model chosen, {name}, {choice.table[-1].name}", 1e3 * seconds, "ms"
