"""Seidel sums of each surface as bars, and those of the whole lens."""

import math
from dataclasses import replace

import numpy as np

from lensbench.analysis.aberrations import seidel
from lensbench.app.state.analysis.figure import Area, Axis, Bars, Curve, Figure, Label, Plot, Table, reach
from lensbench.app.state.analysis.query import Query
from lensbench.kernels.figures import significant, true_minus

NAMES = ("spherical", "coma", "astigmatism", "Petzval", "distortion")
COLOURS = ("axial colour", "lateral colour")
TINTS = ("chart2", "chart3", "chart0", "chart1", "chart4", "chart5", "chart7")
WIDEST = math.radians(45.0)     # field of the sums: those of the third order grow with its tangent beyond any use
BAR = 0.12                      # wide, of the distance between two surfaces


def seidel_figure(query: Query, points: int) -> Figure:
    """Bars of S_I to S_V, and of the two colours where the dispersion is known, for an object at infinity.

    LensError for a lens that has no Seidel sums.
    """
    query = query.lines
    rays = query.grid(points)
    lit = rays.field_angles[np.isfinite(rays.field_angles)]
    angle, given = min(float(lit[-1]), WIDEST), rays.conditions
    pair = (min(given.wavelengths), max(given.wavelengths)) if len(given.wavelengths) > 1 else None
    found = seidel(query.lens, angle, wavelength=given.primary_wavelength, colour=pair)
    columns = [1000.0 * each for each in found.surfaces.T]
    names = list(NAMES)
    if found.axial_colour is not None and found.lateral_colour is not None:
        columns += [1000.0 * found.axial_colour, 1000.0 * found.lateral_colour]
        names += COLOURS
    values = np.column_stack(columns)
    total, count = values.sum(0), len(values)
    shown = np.vstack([values, total])
    places = np.append(np.arange(float(count)), count + 0.6)
    limit = 1.1 * reach(shown)
    layers: list = [Curve("", np.array([-1.0, count + 1.2]), np.zeros(2), "faint", weight=1.0),
                    Curve("", np.full(2, count - 0.2), np.array([-limit, limit]), "faint", weight=1.0)]
    layers += [Bars("", places[[i, i]], np.array([limit, -limit]), 0.96, "grid", surface=i) for i in range(count)]
    middle = 0.5 * (len(names) - 1)
    for k, name in enumerate(names):
        at = places + BAR * (k - middle)
        layers += [Bars(name, at[part], shown[part, k], BAR, TINTS[k]) for part in (slice(count), slice(count, None))]
    for i, row in enumerate(shown):
        title = f"surface {i}" if i < count else "sum of all surfaces"
        lines = (true_minus(f"{name}   {significant(value, 3)} µm") for name, value in zip(names, row, strict=True))
        layers.append(Area((places[i] - 0.5, places[i] + 0.5), (-limit, limit), "\n".join((title, *lines))))
    layers.append(Label(places[-1], limit, "Σ", "text", "below"))
    plot = Plot(Axis("Surface", -0.6, count + 1.2, whole=count - 1), Axis("Seidel sum (µm)", -limit, limit),
                tuple(layers))
    words = replace(query, focus_distance=math.inf).words(None, f"field {significant(math.degrees(angle), 3)}°",
                        "third order, stop as set")
    remarks = () if float(lit[-1]) <= WIDEST else (
        f"the sums are those of a field of 45°: at {significant(math.degrees(lit[-1]), 3)}°, the edge, the "
        "third order says nothing",)
    head = ("surface", *(f"{name} (um)" for name in names))
    rows = (*((str(i), *row) for i, row in enumerate(values)), ("sum", *total))
    return Figure("Seidel sums", ((plot,),), Table(head, rows), words, remarks)
