"""What motion costs: a part of `lensbench bench`. Pairs of pictures, taken in turn."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench import FILM, LENS, least

SAMPLES = 8


def motion() -> Iterator[tuple[str, float, str]]:
    """A camera that pans and turns against the same at rest, and a scene in motion against the same at rest."""
    still, later = np.eye(4), np.eye(4)
    c, s = np.cos(0.05), np.sin(0.05)
    still[:3, :3] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    later[:3, 3] = 40.0, 10.0, -30.0
    way = lb.AnimatedTransform(still, later, 0.0, 1.0)
    scene = lb.builtin_scene("still-life")
    for name, make in (
            ("full trace", lambda **more: lb.LensCamera(lenses.load(LENS), FILM, 1200.0, **more)),
            ("thin lens", lambda **more: lb.LensCamera(lenses.load(LENS), FILM, 1200.0, model="thin", **more)),
            ("perspective", lambda **more: lb.PerspectiveCamera(FILM, fov=0.45, **more))):
        for words, shadows in (("", True), (" without shadows", False)):
            best = least({
                label: partial(lb.Rendering(make(world_from_camera=place), scene, shadows=shadows).add, SAMPLES,
                               threads=1)
                for label, place in (("still", still), ("moving", way))}, 1.0)
            yield f"moving / still, {name}, still-life{words}", best["moving"] / best["still"], "×"
    moving = lb.builtin_scene("fairground")
    rest = replace(moving, spheres=tuple(at_rest(o) for o in moving.spheres),
                   plates=tuple(at_rest(o) for o in moving.plates))
    camera = lb.LensCamera(lenses.load(LENS), FILM, 1200.0, shutter_close=1.0 / 60.0)
    best = least({label: partial(lb.Rendering(camera, shown).add, 2, threads=1)
                  for label, shown in (("still", rest), ("moving", moving))}, 1.0)
    yield "moving / still, fairground, 1/60 s", best["moving"] / best["still"], "×"


def at_rest(thing):
    """The same thing where it stands at 0 s."""
    return replace(thing, velocity=(0.0,) * 3, spin=(0.0,) * 3, pivot=None)
