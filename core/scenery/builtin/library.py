"""The built-in scenes by name, and the scenes of the speed figures."""

import math
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from lensbench.core.lazy import called
from lensbench.core.scenery.builtin.charts import focus_ruler, grid_wall, resolution_chart, white_wall
from lensbench.core.scenery.builtin.indoors import room, still_life
from lensbench.core.scenery.builtin.outdoors import fairground, foliage
from lensbench.core.scenery.builtin.streets import dusk_street, low_sun, night_lights
from lensbench.core.scenery.objects.basic_shapes import Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Floor, Sky, Sun
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import SceneError

# Scene files of the application, which are read when they are first used
SHIPPED = ("portrait", "table", "product-shot", "mirror-balls", "forest", "balloons")
_MAKERS: dict[str, Callable[[], Scene]] = {
    "still-life": still_life, "night-lights": night_lights, "focus-ruler": focus_ruler, "grid-wall": grid_wall,
    "white-wall": white_wall, "room": room, "fairground": fairground, "foliage": foliage, "dusk-street": dusk_street,
    "low-sun": low_sun, "test-chart": resolution_chart,
    **{name: partial(called, "app.scenes.scene_file", "shipped_scene", name) for name in SHIPPED}}
SCENES = tuple(_MAKERS)


@cache
def builtin_scene(name: str) -> Scene:
    """Built-in scene of a name.

    Args:
        name: One of `SCENES`, or "benchmark".
    Returns:
        Laid out in mm for a camera at the world's origin that looks along −z, y up.
    Raises:
        SceneError: If no scene has this name.
    """
    if name == "benchmark":
        return benchmark_scene()
    if name not in _MAKERS:
        raise SceneError(f"no scene is called {name!r}: choose one of {', '.join(SCENES)}")
    return _MAKERS[name]()


def scene_summary(name: str) -> str:
    """What a built-in scene shows, in a line; SceneError as `builtin_scene`."""
    scene = builtin_scene(name)
    return scene.summary or (_MAKERS[name].__doc__ or name).partition("\n")[0].rstrip(".")


def benchmark_scene() -> Scene:
    """Ten matte spheres at 0.7 to 6 m on a checkered floor; render it without shadows."""
    places = [(-420, -60, -1500, 190), (30, -110, -1150, 140), (430, -90, -1600, 160), (-180, -190, -800, 60),
              (190, -195, -760, 55), (-1300, 200, -4200, 450), (500, 150, -5200, 400), (1500, 0, -3600, 250),
              (320, -200, -980, 50), (-60, -215, -650, 35)]
    colours = [(.05, .45, .5), (.8, .12, .08), (.7, .7, .72), (.75, .35, .2), (.8, .65, .2), (.5, .5, .52),
               (.8, .78, .72), (.2, .15, .6), (.3, .55, .15), (.8, .7, .05)]
    balls = tuple(Sphere((float(x), float(y), float(z)), float(r), Material(c))
                  for (x, y, z, r), c in zip(places, colours, strict=True))
    return Scene("benchmark", sun=Sun((0.5, 0.8, 0.45)), floor=Floor(), spheres=balls)


def crowded_scene(count: int) -> Scene:
    """Matte spheres in rows on a checkered floor, from 0.6 m on; render it with shadows."""
    rng, side, balls = np.random.default_rng(2), math.ceil(math.sqrt(count)), []
    for i in range(count):
        radius, (aside, back) = rng.uniform(20.0, 50.0), rng.uniform(-20.0, 20.0, 2)
        centre = (120.0 * (i % side - side / 2) + aside, radius - 300.0, -600.0 - 120.0 * (i // side) + back)
        balls.append(Sphere(centre, radius, Material(tuple(rng.uniform(0.2, 0.9, 3)))))
    return Scene("crowd", sun=Sun((0.4, 0.7, 0.3)), floor=Floor(-300.0), spheres=tuple(balls))


def lamps_scene(count: int) -> Scene:
    """The ten spheres of `benchmark_scene` at night, under small lamps of many colours; render it with shadows."""
    rng, dark, lamps = np.random.default_rng(3), (0.0, 0.0, 0.0), []
    for _ in range(count):
        centre = tuple(rng.uniform((-1800.0, -150.0, -6000.0), (1800.0, 900.0, -600.0)))
        light = rng.uniform(0.3, 1.0, 3) * rng.lognormal(0.0, 0.7) * 4000.0 / count
        lamps.append(Sphere(centre, rng.uniform(5.0, 20.0), Material(tuple(light), "lamp")))
    return Scene("lamps", sky=Sky(dark, dark, dark), floor=Floor(), spheres=(*benchmark_scene().spheres, *lamps))
