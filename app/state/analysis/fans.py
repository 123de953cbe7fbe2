"""Ray fans and OPD fans of the fields: across the whole stop, the part that other rims end in grey."""

from collections.abc import Iterator

import numpy as np

from lensbench.analysis.fans import Fans, ray_fans
from lensbench.app.state.analysis.figure import SOLID, Axis, Curve, Figure, Plot, Table, dash_of, reach, wavelength_name
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.analysis.spots import chosen_fields, field_label

KINDS = {"ray": "Transverse (µm)", "opd": "Path difference (waves)"}
DIRECTIONS = ("sagittal", "tangential")         # the second axis of `Fans`


def fans_figure(query: Query, points: int, kind: str = "ray", rows: int = 3) -> Figure:
    """Fans of `rows` fields, tangential at the left and sagittal at the right; kind: a key of KINDS.

    The fields are those that the query chooses, if it does. All plots have one scale. LensError as `Query.grid`.
    """
    query = query.lines
    rays = query.grid(16, query.heights or None)
    fans = ray_fans(rays, 2 * points + 1)
    values = 1000.0 * fans.transverse if kind == "ray" else fans.waves
    fields = chosen_fields(len(rays.images), len(query.heights) or rows)
    seen = np.where(fans.passed, values, np.nan)[fields]
    limit = reach(seen[np.isfinite(seen)], 1.0 if kind == "ray" else 0.05)
    plots = tuple((_plot(fans, values, f, 1, limit, kind), _plot(fans, values, f, 0, limit, kind)) for f in fields)
    words = query.words(None, "from the chief ray of the primary wavelength", f"{len(fans.heights)} rays a fan",
                        "x: height in the stop over its radius")
    return Figure("Ray fans" if kind == "ray" else "OPD fans", plots, _table(fans), words,
                  (*query.remarks(rays), *query.open_stop), points=rays.opd.shape[-1])


def _plot(fans: Fans, values: np.ndarray, f: int, fan: int, limit: float, kind: str) -> Plot:
    given, rays = fans.rays.conditions, fans.rays
    layers = [Curve("", np.array([-1.0, 1.0]), np.zeros(2), "faint", weight=1.0),
              Curve("", np.zeros(2), np.array([-limit, limit]), "faint", weight=1.0)]
    lost = fans.victim[f, fan] >= 0

    def which(c: int) -> np.ndarray:
        """(K, 4) the rays of a wavelength, as of Curve."""
        return np.column_stack([np.full((len(fans.heights), 2), (f, given.wavelengths[c])), fans.pupil[f, fan]])

    for c in range(len(given.wavelengths)):
        beyond = lost[c] | np.roll(lost[c], 1) | np.roll(lost[c], -1)       # one ray more, so that the parts meet
        layers.append(Curve("vignetted" if beyond.any() else "", fans.heights,
                            np.where(beyond, values[f, fan, c], np.nan), "faint", SOLID, 1.0, rays=which(c)))
    for c, line in enumerate(given.wavelengths):
        layers.append(Curve(wavelength_name(line), fans.heights,
                            np.where(fans.passed[f, fan, c], values[f, fan, c], np.nan), line,
                            dash_of(c, given.primary), rays=which(c)))
    ends = fans.victim[f, fan, given.primary]
    for surface in np.unique(ends[ends >= 0]).tolist():
        here = np.where(ends == surface, values[f, fan, given.primary], np.nan)
        layers.append(Curve("", fans.heights, here, "dead", SOLID, 3.0, surface=surface))
    unit = "µm" if kind == "ray" else "waves"
    title = f"{field_label(rays, f)} {DIRECTIONS[fan][0].upper()}" + (f", {unit}" if rays.lit[f] else ": dark")
    ended = int((lost[given.primary] & (fans.victim[f, fan, given.primary] != rays.lens.stop_index)).sum())
    if ended and rays.lit[f]:
        title += f"  {ended} lost"
    return Plot(Axis("Height in the stop", -1.0, 1.0), Axis(KINDS[kind], -limit, limit), tuple(layers), title)


def _table(fans: Fans) -> Table:
    head = ("field (mm)", "field (deg)", "fan", "wavelength (um)", "height in the stop", "transverse (um)",
            "path difference (waves)", "ended by surface")

    def rows() -> Iterator[tuple]:
        rays, transverse, waves = fans.rays, 1000.0 * fans.transverse, fans.waves
        degrees = np.degrees(rays.field_angles)
        for f, height in enumerate(rays.image_heights):
            for fan, name in enumerate(DIRECTIONS):
                for c, line in enumerate(rays.conditions.wavelengths):
                    for k, at in enumerate(fans.heights):
                        victim = int(fans.victim[f, fan, c, k])
                        yield (height, degrees[f], name, line, at, transverse[f, fan, c, k], waves[f, fan, c, k],
                               str(victim) if victim >= 0 else "")

    return Table(head, rows)
