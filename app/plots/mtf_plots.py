"""MTF figures: against frequency, against the field as makers print it, and the map over field and focus."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from lensbench.app.plots.plot import DASHED, DOTTED, SOLID, Axis, Curve, Figure, Map, Plot, Table, reach
from lensbench.app.plots.query import OWN, Query
from lensbench.app.plots.rims import with_rims, with_shares
from lensbench.app.plots.spots import field_label, field_tint
from lensbench.core.analysis.focus_map import MtfMap, mtf_map
from lensbench.core.analysis.spot_diagram import spots
from lensbench.core.analysis.transfer_function import Mtf, mtf
from lensbench.core.text import significant

FINEST = 100.0                  # cycles/mm, of the curves against frequency
STEPS = 51
FIELD_POINTS = 25               # of the curves against the field
PRINTED = (10.0, 20.0, 30.0, 40.0)
PARTS = (0.0, 0.7, 1.0)
METHODS = {"diffraction": "diffraction", "geometric": "rays alone"}
WAYS = ("sagittal", "tangential")
DEPTHS = 8.0                    # × λN² and more: half the range of focus of the map, or as far as
FARTHEST = 3.0                  # × that, where the beams of some fields are narrowest so far from the film
LEVELS = (0.2, 0.4, 0.6, 0.8)
COARSE = 16                     # rays across the pupil, which other figures have already
VALLEY = 0.01                   # contrast by which it falls between two separate maxima
HALF = 0.5                      # of the greatest contrast, below which nothing joins two maxima
RESOLVED = 0.1                  # contrast, below which there is no best focus


def mtf_frequency_figure(query: Query, points: int, method: str = "diffraction", finest: float = FINEST) -> Figure:
    """MTF of three fields up to the frequency `finest`, sagittal and tangential.

    The fields are those that the query chooses, if it does. The diffraction limit is that of the first.
    """
    rays = query.grid(points, query.few(*PARTS))
    frequencies = np.linspace(0.0, finest, STEPS)
    found = mtf(rays, frequencies, method)
    curves = []
    for f in range(len(rays.images)):
        for a, dash in ((0, SOLID), (1, DASHED)):
            name = f"{field_label(rays, f)} {WAYS[a][0].upper()}"
            curves.append(Curve(name, frequencies, found.white_modulus[f, a],
                                field_tint(f, len(rays.images)), dash))
    at = "" if rays.image_heights[0] == 0.0 else f", {field_label(rays, 0)} S"
    curves.append(Curve(f"diffraction limit{at}", frequencies, found.white_limit[0, 0], "dim", DOTTED, 1.2))
    plot = Plot(Axis("Frequency (lp/mm)", 0.0, finest), Axis("Contrast", 0.0, 1.0), tuple(curves))
    return Figure("MTF against frequency", ((with_shares(rays, plot),),), _table(found), _words(query, found),
                  query.remarks(found.rays, found.findings))


def mtf_field_figure(query: Query, points: int, method: str = "diffraction",
                     frequencies: tuple[float, ...] = PRINTED) -> Figure:
    """MTF at up to four frequencies (lp/mm) against the image height: S solid, T dashed, as makers print it."""
    rays = query.grid(points, query.parts(*np.linspace(0.0, 1.0, FIELD_POINTS).tolist()))
    found = mtf(rays, frequencies, method)
    heights, curves = rays.image_heights, []
    for k, frequency in enumerate(frequencies):
        for a, dash in ((0, SOLID), (1, DASHED)):
            name = f"{significant(frequency)}{'' if k else ' lp/mm'} {WAYS[a][0].upper()}"
            curves.append(Curve(name, heights, found.white_modulus[:, a, k], f"chart{(2, 3, 0, 1)[k]}", dash,
                                1.9 - 0.2 * k))
    plot = Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(heights))), Axis("Contrast", 0.0, 1.0), tuple(curves))
    return with_rims(query, Figure("MTF against the field", ((plot,),), _table(found),
                                   _words(query, found, ", ".join(map(significant, frequencies)) + " lp/mm"),
                                   query.remarks(found.rays, found.findings)))


def mtf_map_figure(query: Query, points: int, frequency: float = 30.0, way: str = "both",
                   line: float | None = None) -> Figure:
    """The map of the MTF over focus and field at one frequency (lp/mm), and the surfaces of best focus.

    way: "sagittal", "tangential", or "both" for their mean. line: one wavelength (µm) alone; None for all of the query.
    The film lies at 0.
    """
    reachable = focus_range(query)
    query = query if line is None else replace(query, wavelengths=((line, 1.0),), white=OWN)
    shifts = np.linspace(-reachable, reachable, 2 * points + 1)
    found = mtf_map(query.lens, query.setup.film_distance, query.conditions(), frequency, shifts, points + 1,
                    min(points, 32))
    white = found.white.mean(1) if way == "both" else found.white[:, WAYS.index(way)]
    heights = found.heights
    top, half = float(np.nanmax(heights)), 0.5 * (shifts[1] - shifts[0])
    rise = 0.5 * top / max(len(heights) - 1, 1)
    # Where nothing is resolved, the highest of the side maxima says nothing
    blurred = np.nan_to_num(found.white.max(2), nan=1.0) < RESOLVED
    best = np.where(blurred, np.nan, found.best_shifts)
    layers: list = [Map(f"MTF at {significant(frequency)} lp/mm", white, (shifts[0] - half, shifts[-1] + half),
                        (-rise, top + rise), 0.0, 1.0, LEVELS)]
    layers += [Curve(f"best {name}", *of_one_maximum(best[:, a], heights, shifts, found.white[:, a]), "field2", dash)
               for a, (name, dash) in enumerate(zip(WAYS, (SOLID, DASHED), strict=True)) if way in ("both", name)]
    plot = Plot(Axis("Film shift (mm)", -reachable, reachable), Axis("Image height (mm)", 0.0, top), tuple(layers),
                across=True)
    rays = found.rays
    words = query.words(rays, "diffraction, white" if len(rays.conditions.wavelengths) > 1 else "diffraction",
                        "sagittal and tangential mean" if way == "both" else way)
    left_out = f"no best focus is drawn where the contrast stays below {significant(RESOLVED)}"
    beyond = f"no best focus is drawn where it lies more than {significant(reachable)} mm from the film"
    outside = ~blurred & np.isnan(found.best_shifts) & (found.white.max(2) > 0.0)
    drawn = [way in ("both", name) for name in WAYS]
    remarks = (*([left_out] if blurred[:, drawn].any() else []), *([beyond] if outside[:, drawn].any() else []),
               *query.remarks(rays))
    return with_rims(query, Figure("MTF map", ((plot,),), _map_table(found), words, remarks))


def of_one_maximum(best: np.ndarray, heights: np.ndarray, shifts: np.ndarray,
                    values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The line through the best shifts (F,) of fields, with a gap wherever two neighbours are maxima of their own.

    They are where the contrast (F, K) of one of both fields falls and rises again on the way from the one shift to the
    other, or falls below HALF.
    """
    gaps = []
    for f in range(len(best) - 1):
        low, high = sorted((best[f], best[f + 1]))
        between = values[f:f + 2, (shifts >= low) & (shifts <= high)]       # none where a field has no best shift
        if between.shape[1] > 2:
            least = between.min(1)
            if (least < np.maximum(between[:, [0, -1]].min(1) - VALLEY, HALF * between.max(1))).any():
                gaps.append(f + 1)
    return np.insert(best, gaps, np.nan), np.insert(heights, gaps, np.nan)


def focus_range(query: Query) -> float:
    """Half the range of focus of the map (mm): several depths of focus, and where the fields are sharp, if not far off.

    The depths are those of a perfect lens, and what the film's grid resolves.
    """
    n = query.setup.f_number
    near = reach([DEPTHS * 2.0 * 0.00055 * n * n, 0.03 * n])
    foci = spots(query.grid(COARSE)).line_foci
    return min(reach(foci, near), reach([FARTHEST * near]))


def _words(query: Query, found: Mtf, *more: str) -> str:
    colours = ("white",) if len(found.rays.conditions.wavelengths) > 1 else ()
    return query.words(found.rays, METHODS[found.method], *colours, "S solid, T dashed", *more)


def _table(found: Mtf) -> Table:
    head = ("field (mm)", "field (deg)", "frequency (lp/mm)", "sagittal", "tangential", "limit sagittal",
            "limit tangential")

    def rows() -> Iterator[tuple]:
        degrees, modulus, limit = np.degrees(found.rays.field_angles), found.white_modulus, found.white_limit
        for f, height in enumerate(found.rays.image_heights):
            for k, frequency in enumerate(found.frequencies):
                yield height, degrees[f], frequency, *modulus[f, :, k], *limit[f, :, k]

    return Table(head, rows)


def _map_table(found: MtfMap) -> Table:
    head = ("field (mm)", "film shift (mm)", "frequency (lp/mm)", "sagittal", "tangential")
    white = found.white
    return Table(head, lambda: ((height, shift, found.frequency, *white[f, :, k])
                                for f, height in enumerate(found.heights) for k, shift in enumerate(found.shifts)))
