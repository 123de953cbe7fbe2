"""Docstrings of all that `lb` and `lenses` offer: arguments, returns, raises; in sections, of methods also in prose."""

import ast
import enum
import inspect
import re
import textwrap

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.base import Camera
from lensbench.core.scenery.objects.shape import Shape

# Classes that document members of others, by the modules of the others
CONTRACTS = {"lensbench.core.scenery.objects": Shape, **dict.fromkeys((
    f"lensbench.core.cameras.{part}" for part in ("camera_stages", "ray_generation")), Camera)}


TITLE = re.compile("(Args|Attributes|Returns|Yields|Raises|References|Examples|Notes):")


def sections(text):
    """Lines of each section by its title; "" for the text before the first."""
    found, title = {"": []}, ""
    for line in inspect.cleandoc(text or "").splitlines():
        if begins := TITLE.fullmatch(line):
            found[title := begins[1]] = []
        else:
            found[title].append(line)
    return found


def described(found):
    """Names that have a description behind them, of arguments and attributes."""
    lines = found.get("Args", []) + found.get("Attributes", [])
    entries = [re.match(r" {4}(\S[^:]*): +\S", line) for line in lines]
    return {name.strip(" *") for entry in entries if entry for name in entry[1].split(",")}


def raises(function):
    """Whether the function itself raises an error that it names."""
    body = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    inner = {below for each in ast.walk(body) if isinstance(each, ast.FunctionDef) and each is not body
             for below in ast.walk(each)}
    return any(isinstance(each, ast.Raise) and each.exc is not None and each not in inner for each in ast.walk(body))


def says_all(annotation):
    """Whether the annotation of a result leaves nothing to describe: a class, which has its own page, a bool or a str.

    Numbers and arrays need their unit, shape and frame.
    """
    name = annotation.__name__ if inspect.isclass(annotation) else str(annotation)
    return annotation in (None, inspect.Signature.empty) or bool(
        re.fullmatch(r"(list\[)?(None|bool|str|([a-z_]+\.)*[A-Z]\w*)\]?( \| None)?", name.strip("'\"")))


def function_faults(function, texts):
    """What the docstrings (of the function, and of those that it overrides) leave out."""
    found = [sections(text) for text in texts]
    known = set().union(*map(described, found)) if found else set()
    signature = inspect.signature(function)
    faults = [f"no description of {name}" for name in signature.parameters if name not in known | {"self", "cls"}]
    returns = not says_all(signature.return_annotation)
    for title, needed in (("Returns", returns), ("Raises", raises(function))):
        if needed and not any({title, title.replace("Returns", "Yields")} & each.keys() for each in found):
            faults.append(f"no section {title}")
    return faults if texts else ["no docstring"]


UNITS = re.compile(r"\b(mm²?|µm|rad(ians)?|seconds|pixels|electrons|stops|lux|0 to 1|units of|ratio|ind(ex|ices))\b"
                   r"|\(s[,)]|\((\w+, ?)+(\w+)?\)", re.IGNORECASE)                # or a shape, such as (n, 2)


def prose_faults(function, texts):
    """What docstrings leave out that describe in running text: the arguments by name, units or shapes, the errors."""
    text = "\n".join(texts)
    words = set(re.findall(r"\w+", text.lower()))
    signature = inspect.signature(function)
    faults = [f"{name} is not named" for name in signature.parameters if name not in words | {"self", "cls"}]
    if not (says_all(signature.return_annotation) or UNITS.search(text)):
        faults.append("neither unit nor shape")
    if raises(function) and not re.search(r"\w+Error\b", text):
        faults.append("no error")
    return faults if texts else ["no docstring"]


def class_faults(cls):
    """(name, fault) of a class and of its own methods and properties."""
    name = cls.__name__
    contract = [base for room, each in CONTRACTS.items() if cls.__module__.startswith(room) for base in each.__mro__]
    fields = set().union(*(described(sections(each.__doc__)) for each in contract))
    if not inspect.getdoc(cls):
        yield name, "no docstring"
    if not issubclass(cls, enum.Enum | BaseException):
        found = [sections(each.__doc__) for each in [*cls.__mro__, *contract] if each.__doc__ and each is not object]
        known = set().union(*map(described, found))
        for argument in inspect.signature(cls).parameters:
            if argument not in known:
                yield name, f"no description of {argument}"
        made = inspect.unwrap(vars(cls).get("__post_init__") or vars(cls).get("__init__"))
        own = made is not None and made.__code__.co_filename != "<string>"
        if own and raises(made) and not any("Raises" in each for each in found):
            yield name, "no section Raises"
    for member, value in vars(cls).items():
        if member.startswith("_"):
            continue
        above = [vars(each)[member] for each in [*cls.__mro__, *contract] if member in vars(each)]
        texts = [each.__doc__ for each in above if each.__doc__]
        if isinstance(value, property) or type(value).__name__ in ("cached_property", "kept_property"):
            if not texts and member not in fields:
                yield f"{name}.{member}", "no docstring"
            continue
        function = getattr(value, "__func__", value)
        if inspect.isfunction(function) and function.__name__ != "<lambda>" \
                and inspect.unwrap(function).__code__.co_filename != "<string>":
            plain = inspect.unwrap(function)
            if prose_faults(plain, texts):                      # a short method may do without sections
                yield from ((f"{name}.{member}", fault) for fault in function_faults(plain, texts))


def faults():
    """Every (name, fault) of the public functions and classes."""
    offered = {name: getattr(lb, name) for name in lb.__all__} | {
        f"analysis.{name}": getattr(lb.analysis, name) for name in dir(lb.analysis) if not name.startswith("_")} | {
        f"tolerances.{name}": value for name, value in vars(lb.tolerances).items()
        if not name.startswith("_") and getattr(value, "__module__", None) == lb.tolerances.__name__} | {
        f"lenses.{name}": getattr(lenses, name) for name in lenses.__all__}
    for base in {base for value in offered.values() if inspect.isclass(value) for base in value.__mro__[1:]}:
        if base.__module__.startswith("lensbench") and base not in offered.values():
            offered[f"{base.__module__}.{base.__name__}"] = base        # its members are members of what is offered
    for name, value in offered.items():
        if inspect.isclass(value):
            yield from class_faults(value)
        elif inspect.isfunction(value) and value.__module__.startswith("lensbench") and name != "analysis.lazy_names":
            plain = inspect.unwrap(value)
            yield from ((name, fault) for fault in function_faults(plain, [plain.__doc__] if plain.__doc__ else []))


def test_every_public_function_and_method_says_what_it_takes_returns_and_raises():
    assert sorted({f"{name}: {fault}" for name, fault in faults()}) == []


GIVEN = "Sum.\n\n    Args:\n        a"


@pytest.mark.parametrize(("text", "left"), [
    (f"{GIVEN}, b: mm.\n    Returns:\n        mm.\n", []),
    (f"{GIVEN}: mm.\n        b:\n", ["no description of b", "no section Returns"]),
    ("Sum of a and b.", ["no description of a", "no description of b", "no section Returns"])])
def test_the_check_of_docstrings_finds_what_is_left_out(text, left):
    def add(a, b) -> float:
        return a + b
    assert function_faults(add, [text]) == left


@pytest.mark.parametrize(("text", "left"), [
    ("Sum of a and b in mm; ValueError for another.", []),
    ("Sum of a and others in mm; ValueError for another.", ["b is not named"]),
    ("Sum of a and b.", ["neither unit nor shape", "no error"])])
def test_the_check_of_prose_finds_what_is_left_out(text, left):
    def add(a, b) -> float:
        if not a:
            raise ValueError("a")
        return a + b
    assert prose_faults(add, [text]) == left
