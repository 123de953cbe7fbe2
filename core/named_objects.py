"""Public functions take the name or path of a lens or a scene too; a camera by its name is refused."""

import inspect
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from os import PathLike, fspath
from types import FunctionType
from typing import Any

ROOT = __name__.split(".")[0]
_LENS, _CAMERA = ("lenses", "load"), "give lb.LensCamera(lensbench.lenses.load({name!r}), lb.Film())"
LOADERS: dict[str, tuple[str, str] | str] = {       # module and function that make the object, or the remedy
    "lens": _LENS, "focusing": _LENS, "scene": ("app.notebook.render", "load_scene"),
    "camera": _CAMERA, "middle": "give lb.PerspectiveCamera(lb.Film())"}        # by the names of parameters


def _loaded(function: str, parameter: str, name: str) -> Any:
    """The lens or scene of a name or path; TypeError with the remedy for a camera, which is more than a name."""
    loader = LOADERS[parameter]
    if isinstance(loader, str):
        raise TypeError(f"{function} takes a camera and not its name or path: {loader.format(name=name)}")
    module, maker = loader
    return getattr(import_module(f"{ROOT}.{module}"), maker)(name)


def accepting_names(value: Any, package: str | None = None) -> Any:
    """The same function, or class with its methods, which takes names and paths of lenses and scenes too.

    A parameter whose type includes str loads them itself. package: where pickle finds a function; None: its module.
    """
    if isinstance(value, type):
        for name, method in list(vars(value).items()):
            if isinstance(method, FunctionType) and (name == "__init__" or not name.startswith("_")):
                checked = _checked(method, method.__module__, value.__name__ if name == "__init__" else name)
                if checked is not method:
                    setattr(value, name, checked)
    return _checked(value, package or value.__module__, value.__name__) if isinstance(value, FunctionType) else value


def _checked(function: FunctionType, module: str, name: str) -> Callable[..., Any]:
    if LOADERS.keys().isdisjoint(inspect.unwrap(function).__code__.co_varnames) or hasattr(function, "accepts_names"):
        return function                                     # signatures of all functions would delay the start by 10 ms
    places = [(i, parameter.name) for i, parameter in enumerate(inspect.signature(function).parameters.values())
              if parameter.name in LOADERS and "str" not in str(parameter.annotation)]
    if not places:
        return function

    @wraps(function)
    def checked(*arguments: Any, **named: Any) -> Any:
        for i, parameter in places:
            argument = arguments[i] if i < len(arguments) else named.get(parameter)
            if isinstance(argument, str | PathLike):
                value = _loaded(name, parameter, fspath(argument))
                if i < len(arguments):
                    arguments = (*arguments[:i], value, *arguments[i + 1:])
                else:
                    named[parameter] = value
        return function(*arguments, **named)

    checked.__module__, checked.accepts_names = module, True    # type: ignore[attr-defined]
    return checked
