"""Lenses of published tables with an error in them, from the test data."""

import json
from functools import cache
from pathlib import Path

from lensbench import AIR, Glass, Lens, Surface
from lensbench.core.optics.system import FieldPoint, SystemData
from lensbench.core.optics.zoom_positions import Positions
from lensbench.lenses.tables.rows import stop_of

FILES = ("suspect_lenses.json", "suspect_causes.json")
DATA = {name: entry for file in FILES for name, entry in json.loads(
    (Path(__file__).parents[1] / "data" / file).read_text(encoding="utf-8")).items()}


@cache
def published(name):
    """The lens of a table, at its first station."""
    entry = DATA[name]
    surfaces = []
    for radius, gap, n, v, rim, *more in entry["rows"]:
        extra = more[0] if more else {}
        shape = {"conic": extra.get("conic", 0.0), "curvature_x": 0.0 if extra.get("cylinder") else None,
                 "aspheric": tuple((int(power), a) for power, a in extra.get("aspheric", {}).items())}
        glass = Glass(n, v, extra.get("glass", "")) if n > 1.0 else AIR
        surfaces.append(Surface(gap, rim, glass, curvature=1.0 / radius if radius else 0.0, **shape))
    stop, findings = stop_of(tuple(surfaces), [] if entry["stop"] is None else [entry["stop"]])
    fields = (FieldPoint(0.0, entry["half_field"]),) if entry.get("half_field") else ()
    positions = None
    if table := entry.get("gaps"):
        positions = Positions(tuple(table["surfaces"]), tuple((tuple(row),) for row in table["thicknesses"]),
                              tuple(table["stations"]), focal_lengths=tuple(table["focal_lengths"]),
                              f_numbers=tuple(table["f_numbers"] or ()))
    return Lens(tuple(surfaces), stop, year=entry.get("year"), stated_efl=entry["efl"],
                stated_f_number=entry["f_number"], positions=positions, findings=findings,
                system=SystemData(fields=fields), estimates="all rims" if "half_field" in entry else "").at()
