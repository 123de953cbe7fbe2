"""What the atlas holds: a sweep, and the methods that stand or fall under it.

The values of a sweep run from the easy to the hard, whichever way its axis points. A
method is safe up to the last value before its first failure; what it says beyond is
shown, and not trusted.
"""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import isfinite
from typing import TypeVar

import numpy as np

Value = TypeVar("Value")

LOST = "weight 0"               # what a stage returns for a ray that does not arrive, for whatever reason
PRECISIONS: tuple[tuple[type[np.floating], str], ...] = ((np.float32, "float32"), (np.float64, "float64"))


@dataclass(frozen=True, eq=False)
class Curve:
    """One method under a sweep.

    errors (n,): the worst error at each value, in the unit of the sweep's measure; nan where
    no number was returned, and `returned` then says what was: the name of a fate or of an error.
    own: the program relies on this method; the others stand here to compare. switch: what the program
    does, of its own method, where that leaves its safe domain.
    """

    name: str
    errors: np.ndarray
    returned: tuple[str, ...]
    own: bool = False
    switch: str = ""

    def __post_init__(self):
        for error, returned in zip(self.errors, self.returned, strict=True):
            if isfinite(error) == bool(returned):
                raise ValueError(f"{self.name}: a value has either a finite error or a fate, not {error}, {returned!r}")


@dataclass(frozen=True, eq=False)
class Sweep:
    """Methods against one quantity that grows worse.

    axis, unit: of `values` (n,), which run from easy to hard and are drawn on a logarithmic axis unless `linear`.
    measure, measure_unit: of the errors; above `limit`, for the reason `why`, a method has failed.
    expected (n,): "" where there is an answer, otherwise the right fate there; () where all have one.
    """

    title: str
    axis: str
    unit: str
    values: np.ndarray
    measure: str
    measure_unit: str
    limit: float
    why: str
    curves: tuple[Curve, ...]
    note: str = ""
    linear: bool = False
    expected: tuple[str, ...] = ()

    @property
    def rising(self) -> bool:
        """Whether the sweep grows with its quantity."""
        return bool(self.values[-1] > self.values[0])

    def right(self, curve: Curve) -> np.ndarray:
        """(n,) whether the method gave a good number, or the right fate where there is none."""
        expected = self.expected or ("",) * len(self.values)
        return np.array([error <= self.limit if not wanted and not returned else returned in (wanted, wanted and LOST)
                         for error, returned, wanted in zip(curve.errors, curve.returned, expected, strict=True)])

    def failure(self, curve: Curve) -> int | None:
        """The first value at which the method fails; None where it never does."""
        wrong = np.flatnonzero(~self.right(curve))
        return int(wrong[0]) if wrong.size else None

    def verdict(self, curve: Curve) -> "Verdict":
        """Where the method is safe, where it fails, and what it says there."""
        at = self.failure(curve)
        good = len(self.values) if at is None else at
        known = curve.errors[:good][np.isfinite(curve.errors[:good])]
        if at is not None:
            off = quantity_text(curve.errors[at], self.measure_unit)
            returns = curve.returned[at] or f"{self.measure.lower()} off by {off}"
        else:
            returns = next((fate for fate in self.expected if fate), "")
        return Verdict(safe_up_to=float(self.values[good - 1]) if good else None,
                       fails_at=None if at is None else float(self.values[at]), returns=returns,
                       worst=float(known.max()) if known.size else 0.0)

    def words(self, curve: Curve) -> tuple[str, str, str]:
        """The verdict as a table has it: safe up to, fails at, what it returns there."""
        verdict = self.verdict(curve)
        safe = "nowhere" if verdict.safe_up_to is None else quantity_text(verdict.safe_up_to, self.unit)
        fails = "never" if verdict.fails_at is None else quantity_text(verdict.fails_at, self.unit)
        return safe, fails, verdict.returns


@dataclass(frozen=True)
class Verdict:
    """safe_up_to and fails_at in the unit of the sweep, None for nowhere and never; worst: error in the safe domain.

    returns: what comes at the failure; of a method that does not fail, the fate where there is no answer, or "".
    """

    safe_up_to: float | None
    fails_at: float | None
    returns: str
    worst: float


def curve(name: str, results: Sequence[float | str], own: bool = False, switch: str = "") -> Curve:
    """A curve of what a method gave at each value: its error, or the name of what it returned instead."""
    numbers = np.array([np.nan if isinstance(result, str) else float(result) for result in results])
    return Curve(name, numbers, tuple(result if isinstance(result, str) else "" for result in results), own, switch)


def curves_of(results: Mapping[str, Sequence[float | str]], own: Container[str], switch: str = "") -> tuple[Curve, ...]:
    """Curves of methods whose names end with their precision, as "closed form, float32".

    own: names, without precisions, of the methods that the program relies on; `switch` is theirs.
    """
    return tuple(curve(name, found, name.rpartition(",")[0] in own, switch if name.rpartition(",")[0] in own else "")
                 for name, found in results.items())


def quantity_text(value: float, unit: str) -> str:
    """A number with three digits and its unit."""
    number = f"{value:.3g}" if 1e-4 < abs(value) < 1e5 or value == 0.0 else f"{value:.1e}"
    mantissa, _, power = f"{float(number):g}".partition("e")
    number = f"{mantissa}e{int(power)}" if power else mantissa
    return f"{number}{'' if unit in ('°', '') else ' '}{unit}"


_listener: ContextVar[Callable[[float], None] | None] = ContextVar("listener", default=None)


@contextmanager
def progress_to(listener: Callable[[float], None]) -> Iterator[None]:
    """Whoever goes through `paced` values within this thread tells the listener what part is done; it may raise."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def with_progress(values: Sequence[Value]) -> Iterator[Value]:
    """The values of a sweep one by one, with progress reported to the listener of `progress_to`."""
    listener = _listener.get()
    for done, value in enumerate(values):
        if listener is not None:
            listener(done / len(values))
        yield value
