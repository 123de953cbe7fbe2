"""Tolerance figures: what each error of manufacture costs, and the contrast of a production run as a band."""

import numpy as np

from lensbench.analysis.manufacture import Production, Tolerances, production, sensitivities
from lensbench.app.state.analysis.figure import DASHED, DOTTED, SOLID, Axis, Bars, Curve, Figure, Label, Plot, Table
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.tolerance_text import KIND_SIGNS, amount, error_name
from lensbench.kernels.figures import fixed

SHOWN = 12                      # of the costliest errors
FREQUENCIES = tuple(5.0 * k for k in range(1, 13))      # cycles/mm
PLACES = (0, 1, 3)              # of the fields of a run, and their tints
TINTS = (("sagittal", "field0"), ("meridional", "field2"))
LOW, MIDDLE, HIGH = 5.0, 50.0, 95.0


def cost_figure(query: Query, points: int, within: Tolerances) -> Figure:
    """The costliest errors as bars: growth of the rms spot, and loss of contrast; LensError where there are none."""
    found = sensitivities(query.lens.at(close=0.0) if query.lens.has_focus_groups else query.lens, query.setup.film,
                          within)
    shown, places = found[:SHOWN], np.arange(min(len(found), SHOWN), dtype=float)
    spots, losses = (np.array([scale * getattr(each, name) for each in shown])
                     for scale, name in ((1000.0, "spot"), (-100.0, "contrast")))
    names = [f"{KIND_SIGNS[each.kind]} {each.surface}" for each in shown]
    plots = []
    for label, values, tint in (("Spot (µm)", spots, "field0"), ("Lost contrast (%)", losses, "field2")):
        top, bottom = max(float(values.max(initial=0.0)), 1e-6), min(float(values.min(initial=0.0)), 0.0)
        room = 0.12 * (top - bottom)
        layers = (Bars("", places, values, 0.6, tint),
                  *(Label(place, max(float(value), 0.0), name, "dim", "above")
                    for place, value, name in zip(places.tolist(), values.tolist(), names, strict=True)))
        plots.append(Plot(Axis(None, -0.7, len(places) - 0.3), Axis(label, bottom - 0.2 * room, top + 1.6 * room),
                          layers))
    table = Table(("error", "surface", "tolerance", "growth of the spot (mm)", "change of contrast"), tuple(
        (each.kind, float(each.surface), each.tolerance, each.spot, each.contrast) for each in found))
    words = ("R radius, t thickness, n index, d decentre and a tilt of the element that begins at the surface · "
             "contrast at 30 lp/mm · each copy focused on the axis, object at infinity")
    first = shown[0]
    said = (f"the costliest: {error_name(first.kind, first.surface)}, {amount(first.kind, first.tolerance)}",)
    return Figure("Tolerances", tuple((plot,) for plot in plots), table, words, said)


def copies_figure(query: Query, copies: int, within: Tolerances, seed: int = 0) -> Figure:
    """The contrast of copies against frequency: median, 5th and 95th percentile, and the design."""
    run = production(query.lens.at(close=0.0) if query.lens.has_focus_groups else query.lens, query.setup.film, within,
                     copies, seed, FREQUENCIES)
    band, plots = run.band((LOW, MIDDLE, HIGH)), []
    for k in PLACES:
        layers = []
        for j, (way, tint) in enumerate(TINTS):
            if k == 0 and j == 1:
                break                                   # on the axis both are alike but for chance
            layers += [Curve(way, run.frequencies, band[1, k, :, j], tint),
                       *(Curve("5th and 95th percentile" if j == 0 else "", run.frequencies, band[p, k, :, j], tint,
                               DOTTED, 1.2) for p in (0, 2)),
                       Curve("as designed" if j == 0 else "", run.frequencies, run.nominal[k, :, j], "dim",
                             DASHED if j else SOLID, 1.2)]
        plots.append(Plot(Axis("Frequency (lp/mm)", 0.0, run.frequencies[-1]), Axis("Contrast", 0.0, 1.0),
                          tuple(layers), f"{fixed(run.fields[k], 1)} mm"))
    words = (f"{len(run.spots)} copies · normal errors, 2 σ within the tolerance · each focused on the axis, at "
             "infinity · rays, times the limit of diffraction")
    return Figure("Copies", (tuple(plots),), _table(run, band), words, ())


def _table(run: Production, band: np.ndarray) -> Table:
    head = ("field (mm)", "frequency (lp/mm)", "direction", "designed", "5 %", "50 %", "95 %")
    return Table(head, tuple((height, frequency, way, run.nominal[f, k, j], *band[:, f, k, j])
                             for f, height in enumerate(run.fields) for k, frequency in enumerate(run.frequencies)
                             for j, (way, _) in enumerate(TINTS)))
