"""Camera bodies by market name: the size of the sensor (mm) and its pixels, as the maker publishes them.

The facts are those of `bodies.csv`, each with its source. Where a maker publishes pixels and their pitch instead of
the size, the size is their product.
"""

import csv
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from lensbench.core.text import significant


class Body(NamedTuple):
    """A camera body: width and height of its sensor (mm), its name, pixels across and down."""

    width: float
    height: float
    name: str
    across: int
    down: int

    @property
    def size(self) -> tuple[float, float]:
        """Width and height (mm)."""
        return self.width, self.height

    @property
    def pitch(self) -> float:
        """Size of a pixel (mm): the geometric mean of its sides."""
        return (self.width / self.across * self.height / self.down) ** 0.5

    @property
    def facts(self) -> str:
        """The body in words."""
        return (f"{significant(self.width)} × {significant(self.height)} mm, {self.across} × {self.down} pixels of "
                f"{significant(1000.0 * self.pitch, 3)} µm")


def _read() -> dict[str, Body]:
    with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        return {row["name"]: Body(float(row["width"]), float(row["height"]), row["name"], int(row["across"]),
                                  int(row["down"])) for row in csv.DictReader(file)}


BODIES = _read()


@lru_cache(maxsize=64)
def bodies_named(text: str) -> tuple[Body, ...]:
    """The bodies that a text names: the one with this name, else all with each of its words in their names."""
    bare = text.casefold().replace("α", "a")
    if exact := [body for body in BODIES.values() if body.name.casefold() == bare.strip()]:
        return tuple(exact)
    return tuple(body for body in BODIES.values() if all(word in body.name.casefold() for word in bare.split()))
