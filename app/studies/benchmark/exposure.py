"""Cost of iris blades, fog and sensor noise, from pairs of pictures taken in turn: a part of `lensbench bench`."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.timing import FILM, LENS, least_times

SAMPLES = 8
EXPOSURE = lb.Exposure(2.8, 1.0 / 60.0, 1600.0)


def exposure() -> Iterator[tuple[str, float, str]]:
    """Seven rounded blades against a circle, fog against clear air, and the sensor noise of a 960 × 640 picture."""
    scene, lens = lb.builtin_scene("still-life"), lenses.load(LENS)
    bladed = replace(lens, blades=7, roundness=0.3)
    for name in ("trace", "thin"):
        cameras = {label: lb.LensCamera(it, FILM, 1200.0, 2.8, model=name, dispersion=False)
                   for label, it in (("round", lens), ("bladed", bladed))}
        best = least_times({label: partial(lb.Rendering(camera, scene, shadows=False).add, SAMPLES, threads=1)
                            for label, camera in cameras.items()}, 0.4)
        yield f"seven blades / a circle, {name}, still-life without shadows", best["bladed"] / best["round"], "×"
    fog = lb.Medium.fog(20_000.0)
    for words, shadows in (("", True), (" without shadows", False)):
        best = least_times({label: partial(lb.Rendering(lb.PerspectiveCamera(FILM, fov=0.45, medium=medium), scene,
                                                  shadows=shadows).add, SAMPLES, threads=1)
                            for label, medium in (("clear", None), ("fog", fog))}, 0.4)
        yield f"fog / clear air, still-life{words}", best["fog"] / best["clear"], "×"
    sensor = lb.Sensor()
    picture = lb.render(lb.PerspectiveCamera(lb.Film(), fov=0.45), scene, samples=4) * EXPOSURE.brightness
    lux_seconds = EXPOSURE.lux_seconds / EXPOSURE.brightness
    best = least_times({"record": partial(sensor.record, picture, EXPOSURE.iso, lux_seconds)})
    yield "a sensor's noise, 960 × 640, all cores", best["record"] * 1e3, "ms"
