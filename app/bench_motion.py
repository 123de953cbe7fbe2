"""What motion costs: a part of `lensbench bench`. The same blocks of two pictures, taken in turn."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lanes, lenses
from lensbench.app.bench import FILM, LENS, least
from lensbench.driver import Program
from lensbench.sampling import sampler

BLOCKS = 48                             # in one piece of work, from the middle of the picture


def motion() -> Iterator[tuple[str, float, str]]:
    """A camera that pans and turns against the same at rest, and a scene in motion against the same at rest."""
    still, later = np.eye(4), np.eye(4)
    c, s = np.cos(0.02), np.sin(0.02)
    still[:3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    later[:3, 3] = 20.0, 5.0, -10.0
    way = lb.AnimatedTransform(still, later)
    scene = lb.builtin_scene("still-life")
    lens = lenses.load(LENS)
    kinds = {"full trace": lambda **more: lb.LensCamera(lens, FILM, 1200.0, **more),
             "thin lens": lambda **more: lb.LensCamera(lens, FILM, 1200.0, model="thin", **more),
             "perspective": lambda **more: lb.PerspectiveCamera(FILM, fov=0.45, **more)}
    for name, make in kinds.items():
        for words, shadows in (("", True), (" without shadows", False)):
            yield f"moving / still camera, {name}, still-life{words}", _ratio(
                [(make(world_from_camera=place), scene) for place in (way, still)], shadows), "×"
    moving = lb.builtin_scene("fairground")
    camera = lb.LensCamera(lens, FILM, 1200.0, shutter_close=1.0 / 60.0)
    rest = replace(moving, spheres=tuple(_at_rest(o) for o in moving.spheres),
                   plates=tuple(_at_rest(o) for o in moving.plates))
    yield "moving / still things, fairground, 1/60 s", _ratio([(camera, moving), (camera, rest)], True), "×"


def _ratio(pair, shadows: bool) -> float:
    """The time of the first picture over that of the second."""
    middle = FILM.pixels_x * FILM.pixels_y // lanes.B // 2
    bench = lanes.bench()
    works: dict[str, Callable[[], object]] = {}
    for name, (camera, scene) in zip(("first", "second"), pair, strict=True):
        timed = camera.moves or scene.moves
        program = Program([*sampler(FILM.pixels_x, FILM.pixels_y, lit=shadows, timed=timed), *camera.steps(timed=timed),
                           *scene.steps(shadows, camera.shutter_open)])
        sums = np.zeros((middle + BLOCKS, 3 * lanes.B), np.float32)
        works[name] = partial(program.expose, sums, bench, middle, middle + BLOCKS, 0, 1, np.uint32(0))
    best = least(works, 1.0)
    return best["first"] / best["second"]


def _at_rest(thing):
    """The same thing where it stands at 0 s."""
    return replace(thing, velocity=(0.0,) * 3, spin=(0.0,) * 3, pivot=None)
