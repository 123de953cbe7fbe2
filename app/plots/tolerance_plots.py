"""Tolerance figures: what each error of manufacture costs, and the contrast and the pictures of a production run.

Errors of manufacture, as people read them.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import published
from lensbench.app.plots.plot import DASHED, DOTTED, SOLID, Area, Axis, Bars, Curve, Figure, Label, Map, Plot, Table
from lensbench.app.plots.query import Query, query
from lensbench.app.settings.settings import Settings
from lensbench.core.design.tolerances import (
    Production, Tolerances, manufactured, production, sensitivities, star_pictures
)
from lensbench.core.text import fixed, significant

KIND_SIGNS = {"radius": "R", "thickness": "t", "index": "n", "decentre": "d", "tilt": "a"}


def amount(kind: str, value: float) -> str:
    """An error in the unit of its kind: 0.1 %, 0.02 mm, 0.0005, 1′."""
    if kind == "radius":
        return f"± {significant(100.0 * value)} %"
    if kind == "tilt":
        return f"± {significant(60.0 * math.degrees(value), 3)}′"
    return f"± {significant(value)}" + ("" if kind == "index" else " mm")


def error_name(kind: str, surface: int) -> str:
    """What an error is of: "radius of surface 3", "index behind surface 0", "tilt of element at 2"."""
    if kind == "index":
        return f"index behind surface {surface}"
    return f"{kind} of {'surface' if kind in ('radius', 'thickness') else 'element at'} {surface}"


SHOWN = 12                      # of the costliest errors
FREQUENCIES = tuple(5.0 * k for k in range(1, 13))      # cycles/mm
PLACES = (0, 1, 3)              # of the fields of a run, and their tints
TINTS = (("sagittal", "field0"), ("tangential", "field2"))
LOW, MIDDLE, HIGH = 5.0, 50.0, 95.0
DRAWN = 200                     # copies from which five are shown
SHARES = {"95 %": 0.95, "75 %": 0.75, "median": 0.5, "25 %": 0.25, "5 %": 0.05}    # of the copies with less contrast
EDGE, GAMMA = 0.47, 2.2         # half a picture, of its cell; of the shades


def cost_figure(query: Query, points: int, within: Tolerances) -> Figure:
    """The costliest errors as bars: growth of the rms spot, and loss of contrast; LensError where there are none."""
    errors = sensitivities(_lens(query), query.bench.film, within, None, query.wavelengths or None)
    shown, positions = errors[:SHOWN], np.arange(min(len(errors), SHOWN), dtype=float)
    spots, losses = (np.array([scale * getattr(error, name) for error in shown])
                     for scale, name in ((1000.0, "spot"), (-100.0, "contrast")))
    names = [f"{KIND_SIGNS[error.kind]}{error.surface}" for error in shown]
    plots = []
    for label, values, tint in (("Spot (µm)", spots, "field0"), ("Loss (% contrast)", losses, "field2")):
        dark, values = np.isnan(values), np.nan_to_num(values)
        top, bottom = max(float(values.max(initial=0.0)), 1e-6), min(float(values.min(initial=0.0)), 0.0)
        room = 0.12 * (top - bottom)
        layers = (Bars("", positions, values, 0.6, tint),
                  *(Label(position, 0.5 * top, "dark", "dim", "above") for position in positions[dark].tolist()),
                  *(Label(position, max(float(value), 0.0), name, "dim", "above")
                    for position, value, name in zip(positions.tolist(), values.tolist(), names, strict=True)))
        plots.append(Plot(Axis(None, -0.7, len(positions) - 0.3), Axis(label, bottom - 0.2 * room, top + 3.0 * room),
                          layers))
    table = Table(("error", "surface", "tolerance", "growth of the spot (mm)", "change of contrast"), tuple(
        (error.kind, float(error.surface), error.tolerance, error.spot, error.contrast) for error in errors))
    words = ("R radius, t thickness, n index, d decentre and a tilt of the element that begins at the surface · "
             "contrast at 30 lp/mm · film at the best focus of each copy, the least rms spot on the axis, object "
             "at infinity")
    first, lost = shown[0], sum(np.isnan(error.spot) for error in errors)
    said = (f"the costliest: {error_name(first.kind, first.surface)}, {amount(first.kind, first.tolerance)}",
            *([f"with {lost} of the errors no light of a field arrives: dark"] if lost else []))
    return Figure("Tolerances", tuple((plot,) for plot in plots), table, words, said)


def copies_figure(query: Query, copies: int, within: Tolerances, seed: int = 0) -> Figure:
    """The contrast of copies against frequency: median, 5th and 95th percentile, and the design."""
    run = production(_lens(query), query.bench.film, within, copies, seed, FREQUENCIES, query.wavelengths or None)
    band, plots = run.band((LOW, MIDDLE, HIGH)), []
    for k in PLACES:
        layers = []
        for j, (way, tint) in enumerate(TINTS):
            if k == 0 and j == 1:
                break                                   # on the axis both are equal but for chance
            layers += [Curve(way, run.frequencies, band[1, k, :, j], tint),
                       *(Curve("5th and 95th percentile" if j == 0 else "", run.frequencies, band[p, k, :, j], tint,
                               DOTTED, 1.2) for p in (0, 2)),
                       Curve("as designed" if j == 0 else "", run.frequencies, run.nominal[k, :, j], "dim",
                             DASHED if j else SOLID, 1.2)]
        plots.append(Plot(Axis("Frequency (lp/mm)", 0.0, run.frequencies[-1]), Axis("Contrast", 0.0, 1.0),
                          tuple(layers), f"{fixed(run.fields[k], 1)} mm"))
    words = (f"{len(run.spots)} copies · normal errors, 2 σ within the tolerance · film at the best focus of each, "
             "the least rms spot on the axis, at infinity · design by diffraction, changes by rays")
    lost = np.isnan(run.spots).mean(0)
    said = tuple(f"no light of the field {fixed(run.fields[k], 1)} mm arrives in {fixed(100.0 * lost[k], 0)} % of the "
                 "copies" for k in PLACES if lost[k] > 0.0)
    return Figure("Copies", (tuple(plots),), _table(run, band), words, said)


def _table(run: Production, band: np.ndarray) -> Table:
    head = ("field (mm)", "frequency (lp/mm)", "direction", "designed", "5 %", "50 %", "95 %")
    return Table(head, tuple((height, frequency, way, run.nominal[f, k, j], *band[:, f, k, j])
                             for f, height in enumerate(run.fields) for k, frequency in enumerate(run.frequencies)
                             for j, (way, _) in enumerate(TINTS)))


def pictures_figure(query: Query, points: int, within: Tolerances) -> Figure:
    """A Siemens star at three image heights (down) through the design and five copies of a run (across)."""
    lens, film, wavelengths = _lens(query), query.bench.film, query.wavelengths or None
    run = five_of(lens, film, within, wavelengths)
    pictures, width = star_pictures(lens, run.production, run.copies, film, wavelengths)
    contrast = [_mean(run.production.nominal), *(_mean(run.production.contrast[copy]) for copy in run.copies)]
    layers: list = []
    for column, (name, mean) in enumerate(zip(("design", *SHARES), contrast, strict=True)):
        layers.append(Label(column, 0.52, name, "amber" if column == 0 else "text", "above"))
        layers.append(Label(column, 0.48 - len(PLACES), f"{fixed(100.0 * mean, 1)} %", "dim", "below"))
        for row, field in enumerate(PLACES):
            box = (column - EDGE, column + EDGE), (-row - EDGE, -row + EDGE)
            height = fixed(run.production.fields[field], 1)
            layers.append(Map("", pictures[column, field] ** (1.0 / GAMMA), *box))
            spot = run.production.nominal_spots[field] if column == 0 else run.production.spots[
                run.copies[column - 1], field]
            layers.append(Area(*box, f"{name}, image height {height} mm\nspot {fixed(1000.0 * spot, 1)} µm rms"))
    plot = Plot(Axis(None, -0.52, len(SHARES) + 0.52), Axis(None, 0.25 - len(PLACES), 0.75), tuple(layers), equal=True)
    middle = fixed(float(run.production.frequencies[len(run.production.frequencies) // 2]), 0)
    heights = ", ".join(fixed(run.production.fields[k], 1) for k in PLACES)
    words = (f"stars {fixed(1000.0 * width, 0)} µm wide, {heights} mm from the axis · five of {DRAWN} copies, by "
             f"percentiles of the mean contrast at {middle} lp/mm (below) · "
             "film at the best focus of each, the least rms spot on the axis, at infinity · rays alone")
    head = ("picture", "copy", "mean contrast", *(f"rms spot at {fixed(run.production.fields[k], 2)} mm (mm)"
                                                  for k in PLACES))
    rows = tuple((name, number, mean, *spots) for name, number, mean, spots in zip(
        ("design", *SHARES), ("", *map(str, run.copies)), contrast,
        (run.production.nominal_spots[list(PLACES)], *run.production.spots[np.ix_(run.copies, PLACES)]), strict=True))
    return Figure("Copies in pictures", ((plot,),), Table(head, rows), words, ())


class Five(NamedTuple):
    """Five copies of a run, by the names of SHARES: their numbers."""

    production: Production
    copies: tuple[int, ...]


@lru_cache(maxsize=4)
def five_of(lens: lb.Lens, film: lb.Film, within: Tolerances,
            wavelengths: tuple[tuple[float, float], ...] | None = None) -> Five:
    """The copies of a run at the quantiles SHARES of the mean contrast."""
    run = production(lens, film, within, DRAWN, 0, None, wavelengths)
    order = np.argsort([_mean(contrast) for contrast in run.contrast])
    return Five(run, tuple(int(order[round(share * (DRAWN - 1))]) for share in SHARES.values()))


def with_copy(settings: Settings, within: Tolerances, number: int) -> Settings:
    """The settings with one of the five copies as an edited lens, which holds its zoom and focal length.

    ValueError or OSError where there is nothing to copy.
    """
    from lensbench.lenses.editing.document import LensDocument, to_text

    asked = query(settings)
    run = five_of(_lens(asked), asked.bench.film, within, asked.wavelengths or None)
    lens = published(settings)
    copy = manufactured(lens.at(close=0.0) if lens.has_focus_groups else lens, run.production, run.copies[number])
    named = replace(copy, name=f"{lens.name}, copy {run.copies[number]}")
    return replace(settings, edited=to_text(LensDocument(named)), zoom=0.0, focal_length=None)


def _mean(contrast: np.ndarray) -> float:
    """Mean over the fields and both directions, at the middle frequency."""
    return float(contrast[:, contrast.shape[1] // 2].mean())


def _lens(query: Query) -> lb.Lens:
    """The lens at infinity, for which errors are judged."""
    return query.lens.at(close=0.0) if query.lens.has_focus_groups else query.lens
