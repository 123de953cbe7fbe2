"""Cost of motion, from pairs of pictures with one sample a pixel, taken in turn: a part of `lensbench bench`."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import FILM, LENS, least_times
from lensbench.kernels import block
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps

CRAWL = 1e-4                            # share of the motion: the same picture, so that only the cost of motion differs


def motion() -> Iterator[tuple[str, float, str]]:
    """A camera that pans and rotates, and a scene in motion, each against the same at rest."""
    scene = lb.builtin_scene("still-life")
    lens = lenses.load(LENS)
    kinds = {"full trace": lambda **more: lb.LensCamera(lens, FILM, 1200.0, **more),
             "thin lens": lambda **more: lb.LensCamera(lens, FILM, 1200.0, model="thin", **more),
             "perspective": lambda **more: lb.PerspectiveCamera(FILM, fov=0.45, **more)}
    for name, make in kinds.items():
        for words, shadows in (("", True), (" without shadows", False)):
            for slowly, part in (("", 1.0), (", all but at rest", CRAWL)):
                way = _pan(part)
                yield f"moving / still camera, {name}, still-life{words}{slowly}", _ratio(
                    [(make(world_from_camera=place), scene) for place in (way, way.start)], shadows), "×"
    moving = lb.builtin_scene("fairground")
    camera = lb.LensCamera(lens, FILM, 1200.0, shutter_close=1.0 / 60.0)
    rest = replace(moving, spheres=tuple(_at_rest(o) for o in moving.spheres),
                   plates=tuple(_at_rest(o) for o in moving.plates))
    yield "moving / static objects, fairground, 1/60 s", _ratio([(camera, moving), (camera, rest)], True), "×"


def _pan(part: float) -> lb.AnimatedTransform:
    """A share of a motion of 23 mm and 1.1 degrees."""
    start, end = np.eye(4), np.eye(4)
    c, s = np.cos(0.02 * part), np.sin(0.02 * part)
    start[:3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    end[:3, 3] = 20.0 * part, 5.0 * part, -10.0 * part
    return lb.AnimatedTransform(start, end)


def _ratio(pair, shadows: bool) -> float:
    """Time of the first picture over that of the second."""
    blocks = -(-FILM.pixels_x * FILM.pixels_y // block.B)
    bench = block.lane_buffer()
    works: dict[str, Callable[[], object]] = {}
    for name, (camera, scene) in zip(("first", "second"), pair, strict=True):
        timed = camera.moves or scene.moves
        program = Program([*sampling_steps(FILM.pixels_x, FILM.pixels_y, lit=shadows, timed=timed),
                           *camera.steps(timed=timed),
                           *scene.steps(shadows, camera.shutter_open)])
        sums = np.zeros((blocks, 3 * block.B), np.float32)
        works[name] = partial(program.expose, sums, bench, 0, blocks, 0, 1, np.uint32(0))
    best = least_times(works, 0.4)
    return best["first"] / best["second"]


def _at_rest(thing):
    """The object at rest, at its place at 0 s."""
    return replace(thing, velocity=(0.0,) * 3, spin=(0.0,) * 3, pivot=None)
