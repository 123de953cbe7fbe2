"""The built-in scenes, by name."""

from functools import cache

from lensbench.core.scenery.builtin.benchmark import benchmark_scene
from lensbench.core.scenery.builtin.charts import focus_ruler, grid_wall, resolution_chart, white_wall
from lensbench.core.scenery.builtin.dusk_street import dusk_street
from lensbench.core.scenery.builtin.fairground import fairground
from lensbench.core.scenery.builtin.foliage import foliage
from lensbench.core.scenery.builtin.night_lights import night_lights
from lensbench.core.scenery.builtin.portrait import portrait
from lensbench.core.scenery.builtin.room import room
from lensbench.core.scenery.builtin.still_life import still_life
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import SceneError

_MAKERS = {"still-life": still_life, "night-lights": night_lights, "focus-ruler": focus_ruler, "grid-wall": grid_wall,
           "white-wall": white_wall, "room": room, "fairground": fairground, "portrait": portrait, "foliage": foliage,
           "dusk-street": dusk_street, "test-chart": resolution_chart}
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
