"""Every public function that takes a lens, a scene or a camera takes its name, or refuses it with what to do."""

import inspect
import pickle
import re
from pathlib import Path

import pytest

import lensbench as lb
from lensbench import lenses

MEANT = re.compile(r"\b(Lens|Scene|Camera|LensCamera|PerspectiveCamera)\b")
REMEDIES = ("lensbench.lenses.load('still-life')", "lb.load_scene('still-life')", "lb.PerspectiveCamera(lb.Film())")
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
@pytest.mark.parametrize("given", ["still-life", Path("still-life")])
def test_a_name_is_refused_in_one_sentence_with_the_remedy(function, parameter, given):
    parameters = inspect.signature(function).parameters
    others = {name: None for name, each in parameters.items()
              if each.default is each.empty and each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)}
    with pytest.raises(TypeError, match="and not its name or path") as told:
        function(**{**others, parameter: given})
    assert any(remedy in str(told.value) for remedy in REMEDIES) and "\n" not in str(told.value)
    if list(parameters)[0] == parameter:
        with pytest.raises(TypeError, match="and not its name or path"):
            function(given, *[None] * (len(others) - 1))


def test_there_are_such_functions_of_each_kind():
    assert len(list(takers())) > 50


def test_a_public_function_can_be_sent_to_another_process():
    assert pickle.loads(pickle.dumps(lb.first_order)) is lb.first_order
    assert pickle.loads(pickle.dumps(lenses.check)) is lenses.check
