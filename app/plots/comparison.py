"""The reference A of a comparison: its settings as B changes, differences of numbers, and its figure behind that of B.

Curves, bars and points of A are faint. Points of cells, such as spots, are brought to the scale of B. A plot of maps,
such as a point spread or a bokeh gallery, is drawn to the right of that of B, with the same axes.

Another lens or another camera is chosen for B alone: A keeps its lens, and the film, focus and position that belong to
it. All other dials turn both.
"""

import math
import re
from dataclasses import replace

import numpy as np

from lensbench.app.bench.constraints import constrained
from lensbench.app.plots.plot import Area, Axis, Bars, Curve, Figure, Map, Plot, Points, Table
from lensbench.app.settings.settings import Settings, differences
from lensbench.core.text import fixed, true_minus

LENS = "lens"                               # column of a table of both: "A" or "B"
SKIPPED = ("amber", "faint", "grid")        # tints of what belongs to the axes, or is B's alone


def with_ghost(b: Figure, a: Figure | None, name: str, reason: str = "") -> Figure:
    """B with A behind it.

    a: None where A has no such plot, for a reason. name: of A, for the remarks.
    """
    if a is None:
        return replace(b, remarks=(*b.remarks, f"A ({name}) has no such plot: {reason}"))
    same = [len(row) for row in a.rows] == [len(row) for row in b.rows]
    if not same:
        return replace(b, remarks=(*b.remarks, f"A ({name}) has other plots, which are not shown"))
    rows = tuple(tuple(plot for pair in zip(*pairs, strict=True) for plot in _plots(*pair))
                 for pairs in zip(b.rows, a.rows, strict=True))
    return replace(b, rows=rows, table=_table(b.table, a.table),
                   remarks=(*b.remarks, _where(rows, name),
                            *(f"A: {remark}" for remark in a.remarks if remark not in b.remarks)))


def _where(rows: tuple[tuple[Plot, ...], ...], name: str) -> str:
    """Where A is seen: in the plots and in the numbers, or in these alone."""
    layers = [layer for row in rows for plot in row for layer in plot.layers]
    mapped = any(isinstance(layer, Map) for layer in layers)
    drawn = "faint or at the right" if mapped else "faint"
    if mapped or any(getattr(layer, "ghost", False) for layer in layers):
        return f"{drawn}, and A in the numbers: {name}"
    return f"A in the numbers alone: {name} has nothing to draw here"


def _plots(b: Plot, a: Plot) -> tuple[Plot, ...]:
    """The plot of B with the ghost of A; with maps, that of A next to it."""
    both = _plot(b, a)
    if not any(isinstance(layer, Map) for layer in (*a.layers, *b.layers)):
        return (both,)
    return (replace(both, title=" · ".join(filter(None, ("B", b.title)))),
            replace(a, title=" · ".join(filter(None, ("A", a.title))), x=both.x, y=both.y,
                    layers=tuple(replace(layer, rays=None) if isinstance(layer, Points) else layer
                                 for layer in a.layers)))


def _plot(b: Plot, a: Plot) -> Plot:
    """One plot with its ghost, its axes wide enough for both."""
    ghosts = [ghost for layer in a.layers if (ghost := _ghost(layer, b, a)) is not None]
    words = {layer.text.split("\n")[0]: layer.text for layer in a.layers if isinstance(layer, Area)}
    areas = {(layer.x, layer.y): layer.text for layer in a.layers if isinstance(layer, Area)}
    own = [replace(layer, text=_both(layer.text, areas.get((layer.x, layer.y)) or words.get(
        layer.text.split("\n")[0]))) if isinstance(layer, Area) else layer for layer in b.layers]
    maps = [layer for layer in own if isinstance(layer, Map)]
    rest = [layer for layer in own if not isinstance(layer, Map)]
    legend = [Curve("A", np.zeros(0), np.zeros(0), "dim", weight=1.0)] if any(
        not isinstance(ghost, Map) for ghost in ghosts) else []
    return replace(b, x=_axis(b.x, a.x), y=_axis(b.y, a.y), layers=(*maps, *ghosts, *rest, *legend))


def _ghost(layer, b: Plot, a: Plot):
    """A layer of A as a ghost in the plot of B, or None."""
    if getattr(layer, "surface", None) is not None:
        return None
    if isinstance(layer, Curve):
        shown = layer.name and layer.tint not in SKIPPED and not b.cell
        return replace(layer, ghost=True, weight=1.0, rays=None) if shown else None
    if isinstance(layer, Bars):
        positions = next((bars.x for bars in b.layers if isinstance(bars, Bars) and bars.name == layer.name
                       and bars.x.shape == layer.x.shape), None)
        return None if positions is None else replace(layer, x=positions, ghost=True, name="", width=1.6 * layer.width,
                                                   tint="dim")
    if isinstance(layer, Points):
        if not (a.cell and b.cell):
            return replace(layer, ghost=True, rays=None)
        x, y = np.round(layer.x), np.round(layer.y)
        moved = np.column_stack([layer.x - x, layer.y - y]) * (a.cell / b.cell)
        inside = (np.abs(moved) < 0.5).all(1)
        return replace(layer, x=x[inside] + moved[inside, 0], y=y[inside] + moved[inside, 1], ghost=True, rays=None,
                       tint="dim")
    return replace(layer, ghost=True) if isinstance(layer, Map) and layer.name else None


def _axis(b: Axis, a: Axis) -> Axis:
    return b if b.label is None else replace(b, low=min(a.low, b.low), high=max(a.high, b.high))


def _both(b: str, a: str | None) -> str:
    """The words at a place in B, and those of A below them."""
    return b if a is None else "\n".join((b, *(f"A: {line}" for line in a.split("\n"))))


def rows_of_b(table: Table) -> list[tuple]:
    """The rows of B in a table of one figure or of two, without the column that names the lens."""
    if table.head[0] != LENS:
        return list(table.rows)
    return [row[1:] for row in table.rows if row[0] == "B"]


def _table(b: Table, a: Table) -> Table:
    """The numbers of both, B first, in the columns of both; one that a lens does not have is empty."""
    head = (*b.head, *(name for name in a.head if name not in b.head))

    def rows() -> list[tuple]:
        both = []
        for lens, table in (("B", b), ("A", a)):
            columns = [table.head.index(name) if name in table.head else None for name in head]
            both += [(lens, *(math.nan if i is None else row[i] for i in columns)) for row in table.rows]
        return both

    return Table((LENS, *head), rows)


FIGURE = re.compile(r"(?P<sign>f/|T |ø )?(?P<value>[+−-]?\d+(?:\.\d+)?)(?P<unit>°)?")
STOPS = ("f/", "T ")            # signs of figures whose difference is counted in stops
DIGITS = 3                      # of a number next to one with decimals: 2 is 2.00 there, without its zeros


def difference(a: str, b: str) -> str:
    """B less A of two numbers as texts, else ""; f-numbers and T-stops in stops, positive where B is brighter."""
    first, second = FIGURE.fullmatch(a), FIGURE.fullmatch(b)
    if first is None or second is None or a == b or first["sign"] != second["sign"] or first["unit"] != second["unit"]:
        return ""
    one, other = (float(number["value"].replace("−", "-")) for number in (first, second))
    if first["sign"] in STOPS:
        return true_minus(f"{fixed(2.0 * math.log2(one / other), 1, signed=True)} EV") if one > 0.0 < other else ""
    decimals = min(_decimals(number["value"]) for number in (first, second)) if "." in a + b else 0
    return true_minus(fixed(other - one, decimals, signed=True)) + (first["unit"] or "")


def _decimals(value: str) -> int:
    """Digits behind the point, those of DIGITS in all for a number without a point."""
    whole, point, behind = value.lstrip("+-−").partition(".")
    return len(behind) if point else max(DIGITS - len(whole), 0)


OWN = ("lens", "edited", "camera", "lens_model", "degree", "focal_length")        # a change of these leaves A as it is
NEVER = ("compare", "wipe", "overlay", "limit")                         # these are of the window, not of a picture


def followed(a: Settings, before: Settings, after: Settings) -> Settings:
    """A after B has changed from `before` to `after`, within the range of A's own lens.

    A lens that opens less far opens as far as it can, and one that focuses less near focuses as near as it can. Where A
    cannot take a change at all, it stays as it was.
    """
    changed = {name: value for name, value in differences(after, before).items() if name not in NEVER}
    if not changed or any(name in changed for name in OWN):
        return a
    try:
        return constrained(replace(a, **changed).checked())
    except (ValueError, OSError):
        return a
