"""Stability sweeps: the errors of several methods while one quantity makes their problem harder.

The values of a sweep run from easy to hard, in the direction in which the quantity does. A method is safe up to the
last value before its first failure; what it returns beyond is shown but not trusted.
"""

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import isfinite
from typing import TypeVar

import numpy as np

Value = TypeVar("Value")

LOST = "weight 0"               # result of a stage for a ray that does not arrive, for any reason
PRECISIONS: tuple[tuple[type[np.floating], str], ...] = ((np.float32, "float32"), (np.float64, "float64"))


@dataclass(frozen=True, eq=False)
class Curve:
    """Errors of one method over a sweep.

    errors (n,): worst error at each value, in the unit of the sweep's measure; nan where the method returned no number.
    returned (n,): there, the name of the fate or error; "" elsewhere. own: the program relies on this method; the
    others are there for comparison. switch: what the program does where its own method is not safe.
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
    """Methods under one quantity that makes their problem harder.

    axis, unit: name and unit of `values` (n,), which run from easy to hard; the axis is logarithmic unless `linear`.
    measure, measure_unit: name and unit of the errors; an error above `limit`, for the reason `why`, is a failure.
    expected (n,): "" where an answer exists, otherwise the correct fate; () if an answer exists at every value.
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
        """Whether the quantity increases from easy to hard."""
        return bool(self.values[-1] > self.values[0])

    def right(self, curve: Curve) -> np.ndarray:
        """Whether the method is right at each value (n,): an error within the limit, or the correct fate."""
        expected = self.expected or ("",) * len(self.values)
        return np.array([error <= self.limit if not answer and not returned else returned in (answer, answer and LOST)
                         for error, returned, answer in zip(curve.errors, curve.returned, expected, strict=True)])

    def failure(self, curve: Curve) -> int | None:
        """Index of the first value at which the method fails; None if it never fails."""
        wrong = np.flatnonzero(~self.right(curve))
        return int(wrong[0]) if wrong.size else None

    def verdict(self, curve: Curve) -> "Verdict":
        """Where the method is safe, where it fails, and what it returns there."""
        failure = self.failure(curve)
        good = len(self.values) if failure is None else failure
        known = curve.errors[:good][np.isfinite(curve.errors[:good])]
        if failure is not None:
            off = quantity_text(curve.errors[failure], self.measure_unit)
            returns = curve.returned[failure] or f"{self.measure.lower()} off by {off}"
        else:
            returns = next((fate for fate in self.expected if fate), "")
        return Verdict(safe_up_to=float(self.values[good - 1]) if good else None,
                       fails_at=None if failure is None else float(self.values[failure]), returns=returns,
                       worst=float(known.max()) if known.size else 0.0)

    def words(self, curve: Curve) -> tuple[str, str, str]:
        """The verdict as cells of a table: safe up to, fails at, result there."""
        verdict = self.verdict(curve)
        safe = "nowhere" if verdict.safe_up_to is None else quantity_text(verdict.safe_up_to, self.unit)
        fails = "never" if verdict.fails_at is None else quantity_text(verdict.fails_at, self.unit)
        return safe, fails, verdict.returns


@dataclass(frozen=True)
class Verdict:
    """Where a method is safe and where it fails.

    safe_up_to, fails_at: in the unit of the sweep; None for nowhere and never. worst: largest error where the method is
    safe. returns: the result at the failure; for a method that does not fail, the fate where no answer exists, or "".
    """

    safe_up_to: float | None
    fails_at: float | None
    returns: str
    worst: float


def curve(name: str, results: Sequence[float | str], own: bool = False, switch: str = "") -> Curve:
    """A curve from the results at each value: an error, or the name of the fate or error that was returned."""
    numbers = np.array([np.nan if isinstance(result, str) else float(result) for result in results])
    return Curve(name, numbers, tuple(result if isinstance(result, str) else "" for result in results), own, switch)


def curves_of(results: Mapping[str, Sequence[float | str]], own: Container[str], switch: str = "") -> tuple[Curve, ...]:
    """Curves of methods named with their precision; own: names without it, for which `switch` holds."""
    return tuple(curve(name, runs, name.rpartition(",")[0] in own, switch if name.rpartition(",")[0] in own else "")
                 for name, runs in results.items())


def quantity_text(value: float, unit: str) -> str:
    """A number with three significant digits and its unit."""
    number = f"{value:.3g}" if 1e-4 < abs(value) < 1e5 or value == 0.0 else f"{value:.1e}"
    mantissa, _, power = f"{float(number):g}".partition("e")
    number = f"{mantissa}e{int(power)}" if power else mantissa
    return f"{number}{'' if unit in ('°', '') else ' '}{unit}"


_listener: ContextVar[Callable[[float], object] | None] = ContextVar("listener", default=None)


@contextmanager
def progress_to(listener: Callable[[float], object]) -> Iterator[None]:
    """Context in which `with_progress` reports the finished share (0 to 1) to a listener, which may raise to cancel."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def with_progress(values: Sequence[Value]) -> Iterator[Value]:
    """The values of a sweep one by one; reports progress to the listener of `progress_to`."""
    listener = _listener.get()
    for done, value in enumerate(values):
        if listener is not None:
            listener(done / len(values))
        yield value
