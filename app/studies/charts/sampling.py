"""Gain of a sampler: how many samples of white noise give the same error.

Pictures of 180 × 120 pixels; patterns are evaluated at points, because a filter would hide the sampler. The error is
the mean square against a converged picture, with light above 4 clipped to 4, over pictures of three seeds.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.curves import Curve, Panel
from lensbench.app.studies.charts.samplers import WHITE, samplers
from lensbench.app.studies.timing import BLOCKS, report_progress, streamed, time_in_turn
from lensbench.kernels.block import B
from lensbench.scenery.objects import Floor, Material, Sphere, Sun
from lensbench.scenery.scene import Scene

LENS = "pbrt-dgauss-50mm"
FILM = lb.Film(36.0, 24.0, 180, 120)
COUNTS = (4, 16, 64, 256)
SEEDS = 3
BRIGHTEST = 4.0
SHOWN = ("still-life", "night-lights", "focus-ruler", "grid-wall", "room", "fairground")     # scenes of the chart
CONVERGED = 8192                # samples of the reference picture
TINTS = ("vermilion", "blue", "green", "purple", "grey")


def soft_scene() -> tuple[lb.Camera, Scene]:
    """Blur of 5 to 40 pixels, spheres and a coarse checker without its horizon, no small lights."""
    tilt = math.radians(-35.0)
    world = np.eye(4)
    world[1:3, 1:3] = [[math.cos(tilt), -math.sin(tilt)], [math.sin(tilt), math.cos(tilt)]]
    camera = lb.PerspectiveCamera(FILM, fov=0.45, lens_radius=45.0, focus_distance=900.0, world_from_camera=world)
    balls = tuple(Sphere((x, -520.0, z), 80.0, Material(colour)) for x, z, colour in (
        (-160.0, -700.0, (0.8, 0.2, 0.1)), (60.0, -900.0, (0.1, 0.5, 0.5)), (-40.0, -560.0, (0.7, 0.6, 0.2)),
        (220.0, -640.0, (0.3, 0.3, 0.7))))
    return camera, Scene("sampling", sun=Sun((0.4, 0.8, 0.3)), floor=Floor(height=-600.0, tile=160.0),
                         spheres=balls)


def scenes() -> dict[str, tuple[lb.Camera, Scene]]:
    """The soft scene, and built-in ones through a thin lens at f/2."""
    camera = lb.LensCamera(lenses.load(LENS), FILM, 1200.0, 2.0, model="thin")
    return {"soft": soft_scene(), **{name: (camera, lb.builtin_scene(name)) for name in SHOWN}}


def squares(camera: lb.Camera, scene: Scene, counts: tuple[int, ...], steps: dict[str, list],
            converged: int = CONVERGED) -> Iterator[tuple[str, dict[int, float]]]:
    """Mean square error of each sampler after these numbers of samples."""
    truth = np.minimum(lb.render(camera, scene, samples=converged, seed=12345), BRIGHTEST)
    for name, placing in steps.items():
        found: dict[int, list[float]] = {count: [] for count in counts}
        for seed in range(SEEDS):
            rendering = lb.Rendering(camera, scene, seed=seed, steps=placing, filtered=False)
            for count in counts:
                rendering.add(count - rendering.samples)
                error = np.minimum(rendering.image(), BRIGHTEST).astype(float) - truth
                found[count].append(float((error**2).mean()))
        yield name, {count: float(np.mean(values)) for count, values in found.items()}


def gains(found: dict[str, dict[int, float]]) -> dict[str, dict[int, float]]:
    """Ratio of the samples of white noise, whose mean square error falls as 1 / samples, to those of each sampler."""
    last = max(COUNTS)
    white = found[WHITE][last] * last
    return {name: {count: white / (error * count) for count, error in errors.items()}
            for name, errors in found.items()}


def sampling_panels(names: list[str], progress: Callable[[float], bool] = lambda _: True) -> list[Panel]:
    """The panel of each named scene (all of `scenes` if none is named).

    progress: receives the finished share; False cancels.
    """
    costs = {name: time.each(BLOCKS * B).least for name, time in time_in_turn(
        {name: streamed(placing, {}) for name, placing in samplers(FILM).items()}, 0.05).items()}
    wanted = {name: what for name, what in scenes().items() if not names or name in names}
    panels = []
    for i, (key, (camera, scene)) in enumerate(wanted.items()):
        found, steps = {}, samplers(FILM, scene.moves)
        for j, (name, errors) in enumerate(squares(camera, scene, COUNTS, steps)):
            found[name] = errors
            report_progress(progress, (i + (j + 1) / len(steps)) / len(wanted))
        curves = tuple(
            Curve(name, tint, tuple(gain.items()), {f"gain at {count}, ×": value for count, value in gain.items()}
                  | {"cost, ns": costs[name]})
            for tint, (name, gain) in zip(TINTS, gains(found).items(), strict=True))
        panels.append(Panel(key, key, "Samples a pixel", "Gain over white noise (×)", curves, ticks=COUNTS))
    return panels
