"""Every public function takes the name or path of a lens or a scene, and refuses a camera by name with a remedy."""

import inspect
import pickle
import re
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.scenes.scene_file import SceneFileError
from lensbench.lenses import LensFileError
from lensbench.lenses.library.catalogue import path_of

MEANT = re.compile(r"\b(Lens|Scene|Camera|LensCamera|PerspectiveCamera)\b")
RESULTS = {"ExitPupil", "Places", "LightField", "Lumigraph", "Format"}      # that functions return


def takers():
    """Public functions, classes and methods with the parameters that are objects which have a name."""
    for package in (lb, lb.analysis, lenses):
        for name in package.__all__:
            value = getattr(package, name)
            methods = {f"{name}.{key}": method for key, method in vars(value).items()
                       if inspect.isfunction(method) and not key.startswith("_")} if inspect.isclass(value) else {}
            for key, function in {name: value, **methods}.items():
                if callable(function) and key not in RESULTS:
                    try:
                        parameters = inspect.signature(function).parameters.values()
                    except ValueError:                  # of an enumeration's or a numba function's own
                        continue
                    for parameter in parameters:
                        meant = str(parameter.annotation)
                        if MEANT.search(meant) and "str" not in meant and "Callable" not in meant:
                            yield pytest.param(function, parameter.name, id=f"{key}-{parameter.name}")


@pytest.mark.parametrize("function, parameter", list(takers()))
@pytest.mark.parametrize("name", ["no such name", Path("no such name")])
def test_a_name_is_looked_up_or_refused_with_the_remedy(function, parameter, name):
    parameters = inspect.signature(function).parameters
    others = {key: None for key, other in parameters.items()
              if other.default is other.empty and other.kind in (other.POSITIONAL_OR_KEYWORD, other.KEYWORD_ONLY)}
    errors = {"lens": LensFileError, "focusing": LensFileError, "scene": SceneFileError}
    with pytest.raises(errors.get(parameter, TypeError), match="no such name|lb.PerspectiveCamera") as told:
        function(**{**others, parameter: name})
    assert "\n" not in str(told.value)
    if list(parameters)[0] == parameter:
        with pytest.raises(errors.get(parameter, TypeError), match="no such name|lb.PerspectiveCamera"):
            function(name, *[None] * (len(others) - 1))


def test_a_name_means_what_it_loads():
    lens = lenses.load("pbrt-dgauss-50mm")
    assert lb.first_order("pbrt-dgauss-50mm") == lb.first_order(lens)
    assert lb.first_order(lens=path_of("pbrt-dgauss-50mm")).efl == lb.first_order(lens).efl
    camera = lb.LensCamera("pbrt-dgauss-50mm", lb.Film(36.0, 24.0, 12, 8))
    assert camera.lens == lens
    assert np.array_equal(lb.depth_map(camera, "room"), lb.depth_map(camera, lb.builtin_scene("room")))


def test_a_glass_is_found_by_its_name_and_refused_without_an_index():
    assert abs(lb.glass("nbk7").n_d - 1.5168) < 1e-6 and lb.glass("N-BK7").formula != "model"
    with pytest.raises(lb.GlassError, match="lb.glass"):
        lb.Glass(name="N-BK7")
    with pytest.raises(lb.GlassError, match="no catalogue"):
        lb.glass("N-BK99")


def test_the_version_is_that_of_the_package():
    assert lb.__version__ == version("lensbench")


def test_there_are_such_functions_of_each_kind():
    assert len(list(takers())) > 50


def test_a_public_function_can_be_sent_to_another_process():
    assert pickle.loads(pickle.dumps(lb.first_order)) is lb.first_order
    assert pickle.loads(pickle.dumps(lenses.check)) is lenses.check
