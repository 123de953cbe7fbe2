"""Declaration of one setting: words, unit, range, choices, command-line option, and what a change restarts.

`setting(…)` makes a field of the dataclass Settings whose metadata holds a Spec. The checks, the command line and the
lists of fields that restart nothing read the Spec; nothing else repeats it. At the end, values in the text of their
dials: lengths in mm or m, angles in degrees, times in s or ms.
"""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import Field, dataclass, field
from types import UnionType
from typing import Any, NamedTuple, get_args, get_origin

from lensbench.app.settings.text_values import (
    format_angle, format_distance, format_duration, format_electrons, format_exposure, format_f_number, format_hole,
    format_length, format_light, format_part, format_signed_length, format_time, read_angle, read_aperture,
    read_distance, read_electrons, read_exposure, read_film_radius, read_length, read_light, read_part,
    read_signed_length, read_time
)
from lensbench.core.text import escaped, excerpt, significant

PICTURE, MOTION, NOTHING = "picture", "moving picture", "nothing"       # what a change restarts


class SettingsError(ValueError):
    """Invalid settings; the message says what to do."""

    def __init__(self, message: str):
        super().__init__(escaped(message))              # it may repeat what is in a file


class Interval(NamedTuple):
    """The numbers from `low` to `high`, both of them included; and infinity if `infinite`."""

    low: float
    high: float
    infinite: bool = False

    def __contains__(self, value: object) -> bool:
        """Whether a number lies in the interval; False for nan."""
        assert isinstance(value, int | float)
        return self.low <= value <= self.high or self.infinite and value == math.inf

    def rule(self, form: Callable[[float], str]) -> str:
        """The interval in words, its ends as `form` writes them."""
        infinite = ", or be infinite" if self.infinite else ""
        return f"it must lie from {form(self.low)} to {form(self.high)}{infinite}"


PART = Interval(0.0, 1.0)
# Beyond what any camera has, and far from where products and powers of these numbers overflow. mm, radians, seconds
LENGTH = Interval(1e-3, 1e6)
DISTANCE = Interval(1e-3, 1e12)
PLACE = Interval(-1e9, 1e9)
ANGLE = Interval(-100.0 * math.pi, 100.0 * math.pi)
SPAN = Interval(1e-9, 1e6)
MOMENT = Interval(-1e6, 1e6)


@dataclass(frozen=True)
class Spec:
    """Declaration of one setting.

    words: its name in messages. unit: "mm", "s", …; "°" for a value in radians that people read in degrees.
    choices: the values that it may have, with their titles where people see them. rule: the range in words, if
    `bounds` or `choices` alone would be unclear. restarts: what a change restarts, PICTURE, MOTION (the picture, where
    anything moves) or NOTHING. figures: whether the read-outs of lens and film depend on it, as on most settings
    that restart the picture. none: the word for None in a settings file. read, metavar, help: of the command-line
    option, which is `option` or the field's own name; a setting without `help` has no option.
    """

    words: str = ""
    unit: str = ""
    bounds: Interval | None = None
    choices: Collection[Any] = ()
    rule: str = ""
    restarts: str = PICTURE
    figures: bool = True
    none: str = ""
    read: Callable[[str], Any] | None = None
    metavar: str = ""
    help: str = ""
    option: str = ""

    def shown(self, value: float) -> str:
        """A number with its unit, as a person reads it."""
        if isinstance(value, int):
            return f"{excerpt(value)} {self.unit}".rstrip()
        if self.unit == "°":
            return f"{significant(math.degrees(value))}°"
        return f"{significant(value)} {self.unit}".rstrip()


def setting(default: Any, words: str = "", unit: str = "", bounds: Interval | None = None, **more: Any) -> Any:
    """A field of Settings with its default and its Spec."""
    more.setdefault("figures", more.get("restarts", PICTURE) == PICTURE)
    return field(default=default, metadata={"spec": Spec(words, unit, bounds, **more)})


def spec(of: Field) -> Spec:
    """The Spec of a field of Settings; the words are the field's name where it has no others."""
    declared: Spec = of.metadata["spec"]
    return declared


def words(of: Field) -> str:
    """The name of a setting in messages."""
    return spec(of).words or of.name.replace("_", " ")


def check(of: Field, value: Any, form: Callable[[float], str] | None = None) -> None:
    """SettingsError, with the range, for a value that the field may not have; form: writes the message's numbers."""
    about = spec(of)
    form = form or about.shown
    if value is None:
        return
    values = value if isinstance(value, tuple) else (value,)
    if about.choices and value not in about.choices:
        rule = about.rule or f"choose one of {', '.join(map(str, about.choices))}"
        raise SettingsError(f"{words(of)} {excerpt(value)}: {rule}")
    if about.bounds is not None and not all(item in about.bounds for item in values):
        shown = ", ".join(form(item) for item in values)
        coordinate = "each coordinate " if len(values) > 1 else ""
        raise SettingsError(f"{words(of)} {shown}: {coordinate}{about.rule or about.bounds.rule(form)}")


def converted(name: str, kind: Any, value: Any) -> Any:
    """A plain value as one of the field's type; SettingsError where it is of another."""
    if isinstance(kind, UnionType):                     # of one kind and None
        return None if value is None else converted(name, get_args(kind)[0], value)
    if get_origin(kind) is tuple:
        kinds = get_args(kind)
        if not isinstance(value, list | tuple) or len(value) != len(kinds):
            raise SettingsError(f"{name} is {excerpt(value)}: it must be {len(kinds)} numbers")
        return tuple(converted(name, kind, item) for kind, item in zip(kinds, value, strict=True))
    if kind is float and value == "inf":
        return math.inf
    if kind is float and isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.inf if value > 0 else -math.inf
    if type(value) is not kind:
        what = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}[kind]
        raise SettingsError(f"{name} is {excerpt(value)}: it must be {what}")
    return value


def titles(of: Field) -> Mapping[Any, str]:
    """The choices of a setting with their titles."""
    choices = spec(of).choices
    return choices if isinstance(choices, Mapping) else {choice: str(choice) for choice in choices}


READERS: dict[str, Callable[[str], Any]] = {"f_number": read_aperture}      # of settings whose option lies elsewhere
FORMS: dict[Callable[[str], Any], Callable[[float], str]] = {               # of the values that these read
    read_angle: format_angle, read_aperture: format_f_number, read_distance: format_distance,
    read_electrons: format_electrons, read_exposure: format_exposure, read_film_radius: format_signed_length,
    read_length: format_length, read_light: format_light, read_part: format_part,
    read_signed_length: format_signed_length, read_time: format_duration}
OWN_FORMS = {"shutter": format_time, "hole_diameter": format_hole}


def reader(of: Field) -> Callable[[str], Any] | None:
    """What reads the text that a user types for this field of Settings; None for one that is not typed."""
    return READERS.get(of.name) or spec(of).read


def value_text(of: Field, value: float) -> str:
    """The text of a value of this field of Settings (mm, radians, seconds or a plain number), as its dial shows it."""
    read = reader(of)
    form = OWN_FORMS.get(of.name) or (FORMS.get(read) if read is not None else None)
    return form(value) if form is not None else spec(of).shown(value)
