"""Exit-pupil regions by several methods: cost for a whole film against error.

The cost includes all work before the first ray of a film: 64 boxes or 64 solved regions. Light is lost where a region
is too small; samples are blocked where it is too large. Both errors are root mean squares over film points from the
centre to 0.95 of the image circle.
"""

import math
from collections.abc import Callable

import lensbench as lb
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.stability.pupils import BUCKETS, Place, Result, box, paraxial_disk, result, solved
from lensbench.app.studies.timing import Time, report_progress, time_in_turn
from lensbench.pupils.radial_sampler import PupilTable

FIELDS = (0.0, 0.35, 0.7, 0.95)         # share of the image-circle radius, or of half the film diagonal
RAYS = tuple(1 << k for k in range(8, 21, 2))
FEW = 1 << 14                           # rays of the boxes that are timed; the time is proportional to the rays
SECONDS = 0.15
KNOWN = 0.3                             # percent: error of the true light
TIME = "Time for all film points (ms)"


def pupil_panels(key: str, camera: lb.LensCamera, progress: Callable[[float], bool] = lambda _: True) -> list[Panel]:
    """Two panels of one lens over time: light error and blocked samples, in percent.

    progress: receives the finished share; StoppedError where it returns False.
    """
    lens, away, half = camera.lens, camera.film_distance, 0.5 * camera.film.diagonal
    reach = min(half, PupilTable.of(lens, away, half).dark_beyond)
    places = [Place(lens, away, (part * reach, 0.0), half) for part in FIELDS]
    times = _times(places[-1])
    points: dict[str, list[tuple[float, Result]]] = {"paraxial disk": [], "boxes, of 256 to a million rays": [],
                                                     "solved regions": []}
    ways = [("paraxial disk", paraxial_disk, times["disk"]), ("solved regions", solved, times["solved"]), *(
        ("boxes, of 256 to a million rays", lambda place, rays=rays: box(place, rays), _of_boxes(times, rays))
        for rays in RAYS)]
    for i, (name, method, seconds) in enumerate(ways):
        found = [result(place, method(place)) for place in places]
        points[name].append((1e3 * seconds, Result(*(math.sqrt(sum(x * x for x in values) / len(values))
                                                     for values in zip(*found, strict=True)))))
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


def _times(place: Place) -> dict[str, float]:
    """Seconds for a whole film: paraxial disk, solved regions, and boxes of FEW rays."""
    works: dict[str, Callable[[], object]] = {
        "disk": lambda: paraxial_disk(place), "boxes": lambda: box(place, FEW),
        "solved": lambda: PupilTable.of(place.lens, place.film_distance, place.reach)}
    found: dict[str, Time] = time_in_turn(works, SECONDS)
    return {name: time.least * (BUCKETS if name == "boxes" else 1) for name, time in found.items()}


def _of_boxes(times: dict[str, float], rays: int) -> float:
    return times["boxes"] * rays / FEW
