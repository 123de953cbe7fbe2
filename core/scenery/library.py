"""The built-in scenes, by name."""

from functools import cache

from lensbench.scene import Scene, SceneError
from lensbench.scenery.benchmark import benchmark_scene
from lensbench.scenery.still_life import still_life

_MAKERS = {"still-life": still_life}
SCENES = tuple(_MAKERS)


@cache
def builtin_scene(name: str) -> Scene:
    """The scene of that name: one of SCENES, or "benchmark"; SceneError where there is none."""
    if name == "benchmark":
        return benchmark_scene()
    if name not in _MAKERS:
        raise SceneError(f"no scene is called {name!r}: choose one of {', '.join(SCENES)}")
    return _MAKERS[name]()
