"""A figure: plots made of curves, points, patches and labels, the numbers at a place, and a table of all of them.

A value, equal in the window, in SVG and PNG files, and in tables of comma-separated values. The units of all numbers
are those that the labels of the axes name. A tint is the name of a purpose ("strong", "dim", "field1"), or a
wavelength in µm.
"""

import csv
import io
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.core.analysis.vignetting import Falloff
from lensbench.core.text import fixed, significant, true_minus

Tint = str | float
DOT, SIZED = 1.3, 3.0           # half a mark of many points, and the least of a few that are told apart by it, pixels
MOST_LIGHT = 2.0                # of that on the axis, to which falloff is drawn
DIGITS = 7                      # of a number in a table that is copied or saved
SOLID, DASHED, DOTTED = (0.0, 0.0), (6.0, 3.0), (1.5, 3.0)      # dashes and gaps, pixels

# Colours of wavelengths up to each µm, for a dark and for a light ground; none is the amber of what is in focus
_SPECTRUM = ((0.44, "a98bff", "6a3fc8"), (0.50, "6f9dff", "2458c4"), (0.53, "4fc3c9", "0f7f86"),
             (0.59, "5fc46a", "2a7d33"), (0.64, "ef8a62", "b1481b"), (9e9, "f06a6a", "b3261e"))


@dataclass(frozen=True, eq=False)
class Curve:
    """A line through x and y (n,); NaN breaks it. dash: pixels on and off; name "" leaves it out of the legend.

    tag: words next to the line, at the first place from its end that is free; left out where none is. ghost: of the
    figure A that is compared. surface: it is drawn only while this surface of the lens is lit. rays:
    (n, 4) field, wavelength (µm), sagittal and tangential pupil coordinate of the ray of each point, or None.
    """

    name: str
    x: np.ndarray
    y: np.ndarray
    tint: Tint = "strong"
    dash: tuple[float, float] = SOLID
    weight: float = 1.6
    ghost: bool = False
    surface: int | None = None
    rays: np.ndarray | None = None
    tag: str = ""

    @classmethod
    def through(cls, name: str, points: np.ndarray, tint: Tint = "strong", dash: tuple[float, float] = SOLID,
                weight: float = 1.6, tag: str = "") -> "Curve":
        """The line through points (n, 2)."""
        return cls(name, points[:, 0], points[:, 1], tint, dash, weight, tag=tag)

    @classmethod
    def straight(cls, x: tuple[float, float], y: tuple[float, float], tint: Tint = "dim",
                 dash: tuple[float, float] = SOLID, weight: float = 1.0, tag: str = "") -> "Curve":
        """A line from (x[0], y[0]) to (x[1], y[1]), without a name."""
        return cls("", np.array(x), np.array(y), tint, dash, weight, tag=tag)


@dataclass(frozen=True, eq=False)
class Points:
    """Marks at x and y (n,), of one `shape` for each wavelength or field: "triangle", "square" or "diamond".

    size: half of it, pixels; marks from SIZED on may also be a "circle", "ring", "hexagon", "cross" or "plus", and are
    turned clockwise by `turn` (radians). rays, ghost, surface: as of Curve.
    """

    name: str
    x: np.ndarray
    y: np.ndarray
    tint: Tint = "strong"
    shape: str = "square"
    rays: np.ndarray | None = None
    ghost: bool = False
    surface: int | None = None
    size: float = DOT
    turn: float = 0.0


@dataclass(frozen=True, eq=False)
class Patch:
    """A convex area with these corners (n, 2), filled with a tint of this opacity, below all lines."""

    corners: np.ndarray
    tint: Tint = "strong"
    opacity: float = 0.16


@dataclass(frozen=True, eq=False)
class Bars:
    """Upright bars of heights y about places x (n,), `width` wide, from 0. ghost, surface: as of Curve."""

    name: str
    x: np.ndarray
    y: np.ndarray
    width: float
    tint: Tint = "strong"
    ghost: bool = False
    surface: int | None = None


@dataclass(frozen=True, eq=False)
class Map:
    """Values (rows, columns) between low and high as shades, over x0 to x1 and y0 to y1; row 0 lies at y0.

    levels: values at which contours are drawn. name: of the value, for the cursor; "" leaves it out. decades: below
    `high` that the shades span in equal steps of the logarithm, instead of the range from `low`; 0 for none. ghost: of
    the figure A: it is read, and not drawn.
    """

    name: str
    values: np.ndarray
    x: tuple[float, float]
    y: tuple[float, float]
    low: float = 0.0
    high: float = 1.0
    levels: tuple[float, ...] = ()
    decades: float = 0.0
    ghost: bool = False
    surface: None = None

    @cached_property
    def shades(self) -> np.ndarray:
        """The values as parts of the way from black (0) to white (1); NaN where they are unknown."""
        if self.decades:
            shades = 1.0 + np.log10(np.maximum(self.values / self.high, 10.0**-self.decades)) / self.decades
        else:
            shades = (self.values - self.low) / (self.high - self.low)
        return np.clip(shades, 0.0, 1.0)


@dataclass(frozen=True)
class Label:
    """Small text at a place; `side` of the place: "left", "right", "above", "below" or "middle".

    free: it may stand on any side, where it touches nothing, and is left out where it would. surface: as of Curve.
    """

    x: float
    y: float
    text: str
    tint: Tint = "dim"
    side: str = "right"
    surface: int | None = None
    free: bool = False


@dataclass(frozen=True)
class Area:
    """A part of a plot and its words under the cursor."""

    x: tuple[float, float]
    y: tuple[float, float]
    text: str


@dataclass(frozen=True)
class Axis:
    """One axis: its label with the unit (None: no numbers at all), and its range.

    whole: the last number of an axis of numbers that count; None for other axes. falling: values fall to the right.
    """

    label: str | None
    low: float
    high: float
    log: bool = False
    whole: int | None = None
    falling: bool = False


@dataclass(frozen=True, eq=False)
class Plot:
    """One pair of axes. equal: a unit is as long on either axis; across: the curves are read at a y, not at an x.

    words: at a place (x, y) under the cursor, instead of the values of the curves.

    cell: width of a cell in mm on the film, where the plot holds cells 1 wide about whole numbers; else 0.

    right: label of an axis at the right, and its unit in that of the y axis; None without one.
    """

    x: Axis
    y: Axis
    layers: tuple = ()
    title: str = ""
    equal: bool = False
    across: bool = False
    cell: float = 0.0
    words: Callable[[float, float], str] | None = None
    right: tuple[str, float] | None = None

    def named(self) -> list:
        """The curves, points and bars of the legend: one of each name."""
        named: dict[str, Curve | Points | Bars] = {}
        for layer in self.layers:
            if isinstance(layer, Curve | Points | Bars) and layer.name and not layer.ghost and layer.surface is None:
                named.setdefault(layer.name, layer)
        return list(named.values())


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers of a figure: a head with units, and rows of numbers or words.

    numbers: the rows, or what makes them when they are first read: a panel rarely needs those of its figure.
    """

    head: tuple[str, ...]
    numbers: Iterable[tuple] | Callable[[], Iterable[tuple]]

    @cached_property
    def rows(self) -> tuple[tuple, ...]:
        """The rows, as long as the head."""
        return tuple(self.numbers() if callable(self.numbers) else self.numbers)

    def text(self, separator: str = ",") -> str:
        """As comma-separated values, or separated by tabs for a spreadsheet; nan is empty, infinity "inf"."""
        out = io.StringIO()
        writer = csv.writer(out, delimiter=separator, lineterminator="\n")
        writer.writerow(self.head)
        for row in self.rows:
            writer.writerow([_cell(value) for value in row])
        return out.getvalue()


EMPTY = Table((), ())


@dataclass(frozen=True, eq=False)
class Figure:
    """What a panel shows: rows of plots, the line that states their conditions, and the numbers.

    title: for files. conditions: fields, wavelengths, object, rays and reference in one line. remarks: what is missing
    or assumed, each a sentence. heights: of the rows, relative. points: across the pupil, of its rays; 0 for none.
    """

    title: str
    rows: tuple[tuple[Plot, ...], ...]
    table: Table = EMPTY
    conditions: str = ""
    remarks: tuple[str, ...] = ()
    heights: tuple[float, ...] = ()
    points: int = 0


def _cell(value) -> str:
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else f"{float(value):.{DIGITS}g}"


def wavelength_colour(micrometres: float, dark: bool) -> str:
    """Colour of a wavelength as six hexadecimal digits: told apart on a dark or a light ground, not its true colour."""
    return next(night if dark else day for end, night, day in _SPECTRUM if micrometres < end)


def wavelength_name(micrometres: float) -> str:
    """A wavelength in nm."""
    return f"{fixed(1000.0 * micrometres, 0)} nm"


def shape_of(index: int) -> str:
    """The shape of the marks of the wavelength or field with this index."""
    return ("triangle", "square", "diamond")[index % 3]


def dash_of(index: int, primary: int) -> tuple[float, float]:
    """The dash of a wavelength with this index: solid for the primary one, dashed for shorter, dotted for longer."""
    return SOLID if index == primary else DASHED if index < primary else DOTTED


def light_limit(light: Falloff) -> float:
    """The upper end of an axis of light, in percent of the axis: more than 105 where pupil aberrations add light."""
    return 105.0 * min(max(1.0, float(light.vignetting.max()), float(light.total.max())), MOST_LIGHT)


def reach(values: Sequence[float] | np.ndarray, least: float = 0.0) -> float:
    """The next number of the series 1, 1.5, 2, 3, 5, 7 × 10ⁿ beyond all values: limits rest while a lens moves."""
    array = np.abs(np.asarray(values, float))
    array = array[np.isfinite(array)]
    most = max(float(array.max()) if array.size else 0.0, least, 1e-9)
    decade = 10.0 ** np.floor(np.log10(most))
    return float(next(decade * step for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0) if decade * step >= 0.999 * most))


# The numbers at a place


def told(plot: Plot, x: float, y: float) -> str:
    """The numbers at a place: what an area says, or each curve at this x (or this y) and maps; and those of A."""
    if plot.words is not None:
        return plot.words(x, y)
    lines = [layer.text for layer in plot.layers
             if isinstance(layer, Area) and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]]
    if lines:
        return "\n".join(lines)
    other = {layer.name: value for layer in plot.layers if isinstance(layer, Curve | Map) and layer.ghost
             and (value := _value(layer, plot, x, y)) is not None}
    mapped = any(isinstance(layer, Map) for layer in plot.layers)
    read_on = plot.x if plot.across else plot.y         # the axis of the curves' values
    for layer in plot.layers:
        if isinstance(layer, Map | Curve) and layer.name and not layer.ghost and layer.surface is None \
                and (value := _value(layer, plot, x, y)) is not None:
            unit = _unit(read_on.label) if mapped and isinstance(layer, Curve) else ""
            lines.append(f"{layer.name}   {_number(value)}{unit}{_compared(value, other.get(layer.name))}")
    if lines and plot.x.label and plot.y.label:
        names = [label.split(" (")[0] for label in (plot.x.label, plot.y.label)]
        numbers = [f"{name} {_number(coordinate)}{_unit(axis.label)}" for name, axis, coordinate in zip(
            names, (plot.x, plot.y), (x, y), strict=True) if mapped or axis is not read_on]
        lines.insert(0, ", ".join(numbers) if mapped else f"{numbers[0]}: {read_on.label}")
    return "\n".join(lines)


def _value(layer: Curve | Map, plot: Plot, x: float, y: float) -> float | None:
    """The value of a layer at a place; None where it has none."""
    if isinstance(layer, Curve):
        return read(layer, y if plot.across else x, plot.across)
    if not (layer.name and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]):
        return None
    rows, columns = layer.values.shape
    row = int((y - layer.y[0]) / (layer.y[1] - layer.y[0]) * rows)
    column = int((x - layer.x[0]) / (layer.x[1] - layer.x[0]) * columns)
    return float(layer.values[row, column])


def _compared(value: float, other: float | None) -> str:
    """The value of A after that of B, and B − A."""
    if other is None or not (math.isfinite(other) and math.isfinite(value)):
        return ""
    return f"   A {_number(other)}   {true_minus(significant(value - other, 2, signed=True))}"


def read(curve: Curve, key: float, across: bool = False) -> float | None:
    """A curve's value at an x (at a y if `across`), by a straight line between its points; None where it is none."""
    keys, values = (curve.y, curve.x) if across else (curve.x, curve.y)
    if keys.size < 2:
        return None
    a, b = keys[:-1], keys[1:]
    known = np.isfinite(values[:-1] + values[1:])
    around = np.flatnonzero((np.minimum(a, b) <= key) & (key <= np.maximum(a, b)) & known)
    if not around.size:
        return None
    i = int(around[0])
    share = 0.0 if b[i] == a[i] else (key - a[i]) / (b[i] - a[i])
    return float(values[i] + share * (values[i + 1] - values[i]))


def _number(value: float) -> str:
    return true_minus(significant(value, 3)) if math.isfinite(value) else "–"


def unit_of(label: str | None) -> str:
    """The unit of an axis, from the parenthesis of its label; "" for a number."""
    return label.rsplit("(", 1)[1].rstrip(")") if label and "(" in label else ""


def _unit(label: str | None) -> str:
    """The unit of an axis after a number."""
    unit = unit_of(label)
    return unit if unit in ("°", "%", "") else f" {unit}"
