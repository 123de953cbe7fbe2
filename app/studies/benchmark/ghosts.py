"""Time of the ghosts of one light in a picture, 640 × 360: a part of `lensbench bench`."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from time import process_time

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import least_times
from lensbench.optics.ghost_pairs import ghost_pairs
from lensbench.rendering.ghost_image import MOST, Flare, GhostImage

PAIRS = 66              # of 12 surfaces that reflect
THREADS = 2
SUN = lb.Scene("sun", sun=lb.Sun((0.14, 0.13, -1.0)))


def ghosts() -> Iterator[tuple[str, float, str]]:
    """In one colour, then dispersed: the first pass, which searches where each ghost enters, and a later one."""
    name = next(name for name in lenses.names() if len(ghost_pairs(lenses.load(name))) == PAIRS)
    for colours, said in ((False, ""), (True, ", dispersed")):
        camera = lb.LensCamera(lenses.load(name), lb.Film(36.0, 20.25, 640, 360), dispersion=colours)
        with ThreadPoolExecutor(THREADS) as pool:
            best = least_times({"first": partial(_first, camera, pool)})
            begun = _first(camera, pool)
            start = process_time()
            begun.add(MOST // 2, pool, THREADS, lambda: True)
            later = (process_time() - start) / (begun.state["ghost_passes"][0] - 1)
        yield f"{PAIRS} ghosts of the sun{said}, {name}, first pass, two threads", 1e3 * best["first"], "ms"
        yield f"{PAIRS} ghosts of the sun{said}, {name}, processor time of a later pass", 1e3 * later, "ms"


def _first(camera: lb.LensCamera, pool: ThreadPoolExecutor) -> GhostImage:
    """The ghosts after one pass."""
    image = GhostImage(camera, SUN, Flare())
    image.add(1, pool, THREADS, lambda: True)
    return image
