"""What a chart shows: methods as marks, each with a cost and an error; and which of them no other one beats."""

import math
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Mark:
    """One method at one cost.

    name: in words, as it is written at the mark. kind: its family, a key of `sheet.KINDS`. cost and error are in the
    chart's units; spread: by what percentage the middle run cost more than the least, which is `cost`; worst: the
    largest error. NaN is what was not measured. why: what makes the mark invalid, "" where nothing does. figures:
    everything that was measured, by its name and unit, as "streamed, ns".
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
        """Whether it has a place in the chart."""
        return self.cost > 0.0 and self.error >= 0.0

    @property
    def is_valid(self) -> bool:
        """Whether it has a place, and a right to it."""
        return self.has_place and not self.why


@dataclass(frozen=True)
class Chart:
    """Methods side by side: one lens, or one scene.

    key: a short name; cost and error: what stands at the axes, with units. conditions: what held for all marks; notes:
    what is to be said beside them. also: other costs of the same marks: what stands at the axis, and the figures that
    hold the cost and its spread. floor: an error below it is as good as none.
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
        """The marks than which none is both cheaper and nearer to the truth, by cost (the Pareto front)."""
        found: list[Mark] = []
        for mark in sorted((mark for mark in self.marks if mark.is_valid), key=lambda mark: (mark.cost, mark.error)):
            if not found or max(mark.error, self.floor) < max(found[-1].error, self.floor):
                found.append(mark)
        return tuple(found)

    @property
    def all_costs(self) -> list["Chart"]:
        """Itself, and the same chart over each of its other costs."""
        found = [self]
        for cost, figure, spread in self.also:
            marks = tuple(replace(mark, cost=mark.figures.get(figure, math.nan),
                                  spread=mark.figures.get(spread, math.nan)) for mark in self.marks)
            found.append(replace(self, cost=cost, marks=marks, also=()))
        return found
