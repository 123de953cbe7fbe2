"""Public functions that take a lens, a scene or a camera, and are given its name or the path of its file."""

import inspect
from collections.abc import Callable
from functools import wraps
from os import PathLike
from types import FunctionType
from typing import Any

_LENS = "lens", "lensbench.lenses.load({})"
REMEDIES = {            # kind of the object and what makes one of a name, by the names of parameters
    "lens": _LENS, "focusing": _LENS,
    "scene": ("scene", "lb.load_scene({})"),
    "camera": ("camera", "lb.LensCamera(lensbench.lenses.load({}), lb.Film())"),
    "middle": ("camera", "lb.PerspectiveCamera(lb.Film())"),
}


def refusing_names(value: Any, package: str | None = None) -> Any:
    """The same function, or class with its methods, which refuses a name or path with a remedy (TypeError).

    A parameter whose type includes str takes names itself. package: where pickle finds a function; None: its module.
    """
    if isinstance(value, type):
        for name, method in list(vars(value).items()):
            if isinstance(method, FunctionType) and (name == "__init__" or not name.startswith("_")):
                checked = _checked(method, method.__module__, value.__name__ if name == "__init__" else name)
                if checked is not method:
                    setattr(value, name, checked)
    return _checked(value, package or value.__module__, value.__name__) if isinstance(value, FunctionType) else value


def _checked(function: FunctionType, module: str, name: str) -> Callable[..., Any]:
    if REMEDIES.keys().isdisjoint(inspect.unwrap(function).__code__.co_varnames) or hasattr(function, "refuses_names"):
        return function                                     # signatures of all functions would delay the start by 10 ms
    places = [(i, parameter.name) for i, parameter in enumerate(inspect.signature(function).parameters.values())
              if parameter.name in REMEDIES and "str" not in str(parameter.annotation)]
    if not places:
        return function

    @wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        for i, parameter in places:
            argument = arguments[i] if i < len(arguments) else named.get(parameter)
            if isinstance(argument, str | PathLike):
                kind, remedy = REMEDIES[parameter]
                raise TypeError(f"{name} takes a {kind} and not its name or path: give "
                                f"{remedy.format(repr(str(argument)))}")
        return function(*arguments, **named)

    checked.__module__, checked.refuses_names = module, True    # type: ignore[attr-defined]
    return checked
