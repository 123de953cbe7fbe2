"""Values of a chart: marks with cost and error, and the Pareto front."""

import math
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Mark:
    """One method at one cost.

    name: the label of the mark. kind: its family, a key of `sheet.KINDS`. cost, error: in the units of the chart.
    spread: excess of the median run over the least run, which is `cost`, in percent. worst: largest error. NaN: not
    measured. why: the reason why the mark is invalid, "" if valid. figures: all measured values by name and unit, such
    as "streamed, ns".
    """

    name: str
    kind: str
    cost: float = math.nan
    error: float = math.nan
    spread: float = math.nan
    worst: float = math.nan
    why: str = ""
    figures: dict[str, float] = field(default_factory=dict)

    @property
    def has_place(self) -> bool:
        """Whether the mark can be drawn in the chart."""
        return self.cost > 0.0 and self.error >= 0.0

    @property
    def is_valid(self) -> bool:
        """Whether the mark can be drawn and is valid."""
        return self.has_place and not self.why


@dataclass(frozen=True)
class Chart:
    """Methods side by side, for one lens or one scene.

    key: short name. cost, error: axis labels with units. conditions: valid for all marks. notes: printed below. also:
    other costs of the same marks: axis label, and the figures that hold the cost and its spread. floor: smaller errors
    count as none.
    """

    key: str
    title: str
    cost: str
    error: str
    marks: tuple[Mark, ...]
    conditions: str = ""
    notes: tuple[str, ...] = ()
    also: tuple[tuple[str, str, str], ...] = ()
    floor: float = 1e-5

    @property
    def front(self) -> tuple[Mark, ...]:
        """The Pareto front by cost: marks that no other mark beats in both cost and error."""
        found: list[Mark] = []
        for mark in sorted((mark for mark in self.marks if mark.is_valid), key=lambda mark: (mark.cost, mark.error)):
            if not found or max(mark.error, self.floor) < max(found[-1].error, self.floor):
                found.append(mark)
        return tuple(found)

    @property
    def all_costs(self) -> list["Chart"]:
        """The same chart for each of its costs, this one first."""
        found = [self]
        for cost, figure, spread in self.also:
            marks = tuple(replace(mark, cost=mark.figures.get(figure, math.nan),
                                  spread=mark.figures.get(spread, math.nan)) for mark in self.marks)
            found.append(replace(self, cost=cost, marks=marks, also=()))
        return found
