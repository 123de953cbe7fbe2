"""Depth of field of the real lens over the field, beside the paraxial one of the read-outs."""

import math
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.analysis.depth_over_field import FieldDepth, field_depth
from lensbench.app.state.analysis.figure import DASHED, DOTTED, Area, Axis, Curve, Figure, Plot, Table
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.analysis.rims import with_rims
from lensbench.app.state.text_values import format_distance
from lensbench.kernels.figures import significant
from lensbench.optics.finding import Kind

FIELDS = 9
DIAGONALS = 1500.0              # of the film in the blur that counts as sharp by default
LOG = 6.0                       # × the nearest, from which on the axis is logarithmic
ROOM = 0.2                      # of the distances shown, beside them
BEYOND = 1.6                    # × the farthest finite distance, where an infinite one is drawn


def depth_figure(query: Query, points: int, limit: float | None = None) -> Figure:
    """Nearest and farthest sharp distance, and the sharpest one, over the image height.

    limit: blur that counts as sharp (mm); None: diagonal / 1500. LensError where no light reaches the film.
    """
    built = query.setup
    sharp = built.film.diagonal / DIAGONALS if limit is None else limit
    found = field_depth(query.lens, built.film_distance, query.conditions(FIELDS if points > 16 else FIELDS // 2 + 1),
                        sharp, min(points, 24))
    heights = found.heights
    # Beyond a window into water at their true distances, which grow towards the edge of the field
    port = replace(built.port, index=built.port.stretch(heights / abs(built.first_order.efl)))
    near, far, best = (port.true(each + built.film_z) for each in (found.near, found.far, found.best))
    said = [_said(found, i, (near[i], far[i], best[i])) for i in range(len(heights))]
    near, far, best = 0.001 * near, 0.001 * far, 0.001 * best
    focus = 0.001 * float(built.port.true(query.focus_distance))
    paraxial = _paraxial(query, sharp)
    every = np.concatenate([near, far, best, [focus], paraxial])
    known, endless = every[np.isfinite(every)], bool(np.isinf(every).any())
    low, high = (float(known.min()), float(known.max())) if known.size else (0.1, 100.0)
    room = max(ROOM * (high - low), 1e-3 * high)
    low, high = max(0.9 * low, low - room), BEYOND * high if endless else min(1.1 * high, high + room)
    shown = [np.where(np.isinf(each), high, each) for each in (near, far, best)]
    ends = np.array([0.0, float(np.nanmax(heights))])
    curves: list = [Curve("nearest sharp", heights, shown[0], "field0"),
                    Curve("farthest sharp", heights, shown[1], "field2"),
                    Curve("sharpest", heights, shown[2], "strong", DASHED)]
    for k, each in enumerate(paraxial):
        curves.append(Curve("" if k else "paraxial", ends, np.full(2, min(each, high)), "dim", DOTTED, 1.2))
    curves.append(Curve("focus", ends, np.full(2, min(focus, high)), "amber", weight=1.0))
    step = 0.5 * (heights[1] - heights[0]) if len(heights) > 1 else 1.0
    curves += [Area((h - step, h + step), (low, high), said[i]) for i, h in enumerate(heights) if math.isfinite(h)]
    plot = Plot(Axis("Image height (mm)", 0.0, ends[1]), Axis("Distance (m)", low, high, log=high > LOG * low),
                tuple(curves), "∞ at the top" if endless else "")
    words = query.words(None, f"sharp: blurred by {significant(1000.0 * sharp, 3)} µm at most",
                        "blur: 2√2 × the rms radius, white", f"{len(heights)} fields")
    remarks = tuple(str(each.message) for each in found.findings if each.kind is not Kind.ASSUMED)
    head = ("field (mm)", "nearest (m)", "farthest (m)", "sharpest (m)", "least blur (um)")
    rows = tuple(zip(heights, near, far, best, 1000.0 * found.least, strict=True))
    return with_rims(query, Figure("Depth of field", ((plot,),), Table(head, rows), words, remarks))


def _paraxial(query: Query, sharp: float) -> tuple[float, ...]:
    """Near and far limit (m, from the film) of the thick lens; none where its two foci blur all more than the limit."""
    built = query.setup
    try:
        limits = lb.thick_depth_of_field(built.lens, built.film_distance, query.focus_distance, sharp)
    except lb.LensError:
        return ()
    return tuple(0.001 * float(built.port.true(each)) for each in limits if not math.isnan(each))


def _said(found: FieldDepth, i: int, distances: tuple[float, float, float]) -> str:
    """The numbers of a field. distances: nearest and farthest sharp one, and the sharpest (mm from the film)."""
    lines = [f"{significant(found.heights[i], 3)} mm from the centre"]
    if math.isnan(found.least[i]):
        return f"{lines[0]}: no light reaches this field"
    for name, value in zip(("nearest sharp", "farthest sharp", "sharpest"), distances, strict=True):
        lines.append(f"{name}   {format_distance(value) if not math.isnan(value) else '–'}")
    return "\n".join((*lines, f"least blur   {significant(1000.0 * found.least[i], 3)} µm"))
