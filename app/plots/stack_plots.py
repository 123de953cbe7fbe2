"""What the glass before a sensor and the error of an adapter do to the contrast and to the foci over the field."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.plots.plot import DASHED, SOLID, Axis, Curve, Figure, Plot, Table, reach
from lensbench.app.plots.query import Query
from lensbench.app.plots.rims import with_rims
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.grids.traced_grid import RayGrid, close_foci, ray_grid
from lensbench.core.analysis.meridional_curves import field_curves
from lensbench.core.analysis.sensor_stack import with_sensor_stack
from lensbench.core.analysis.transfer_function import mtf
from lensbench.core.text import significant, true_minus

FREQUENCIES = (10.0, 30.0)      # lp/mm
FIELDS = 13
TINTS = ("chart2", "chart0")
Foci = tuple[np.ndarray, np.ndarray, np.ndarray]        # image heights, sagittal and tangential foci (n,)


class Stack(NamedTuple):
    """Glass before the sensor: thickness (mm) and index; and by how much (mm) an adapter is too long."""

    thickness: float = 2.0
    refractive_index: float = 1.52
    adapter_error: float = 0.0


USUAL = Stack()


def stack_figure(query: Query, points: int, stack: Stack = USUAL) -> Figure:
    """Contrast and foci over the field behind a stack, those of the bare lens dim beside them.

    The lens is focused again paraxially for the stack, not for the adapter. LensError for a stack without room.
    """
    given = query.conditions(FIELDS)
    lens, away = with_sensor_stack(query.lens, query.setup.film_distance, *stack)
    bare = ray_grid(query.lens, query.setup.film_distance, given, points)
    behind = ray_grid(lens, away, given, points)
    contrast = [mtf(rays, FREQUENCIES).white_modulus for rays in (bare, behind)]
    if query.lens.is_rotationally_symmetric:
        curves = [field_curves(each, film, given, 2 * points + 1)
                  for each, film in ((query.lens, query.setup.film_distance), (lens, away))]
        primary = given.primary
        foci = [(each.heights, each.sagittal[:, primary], each.tangential[:, primary]) for each in curves]
    else:
        both = [(rays, close_foci(rays)[:, given.primary]) for rays in (bare, behind)]
        foci = [(rays.image_heights, found[:, 0], found[:, 1]) for rays, found in both]
    plots = (_contrast(bare, *contrast), _foci(foci[0], foci[1], bare))
    words = query.words(behind, f"stack {significant(stack.thickness)} mm, index {significant(stack.refractive_index)}",
                        f"adapter {significant(stack.adapter_error, signed=True)} mm", "dim: without both",
                        "focused again for the stack alone")
    return with_rims(query, Figure("Sensor stack", (plots,), _table(bare, *contrast), true_minus(words),
                                   (*_infinity(query, stack), *query.remarks(behind))))


def _contrast(bare: RayGrid, without: np.ndarray, with_: np.ndarray) -> Plot:
    """The contrast (F, 2, K) without the stack and with it."""
    curves = []
    for k in range(len(FREQUENCIES)):
        curves += [Curve("bare", bare.image_heights, without[:, a, k], "faint", dash, 1.2)
                   for a, dash in ((0, SOLID), (1, DASHED))]
    for k, frequency in enumerate(FREQUENCIES):
        for a, dash in ((0, SOLID), (1, DASHED)):
            curves.append(Curve(f"{significant(frequency)} {'ST'[a]}", bare.image_heights, with_[:, a, k], TINTS[k],
                                dash))
    return Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(bare.image_heights))), Axis("Contrast", 0.0, 1.0),
                tuple(curves), "MTF")


def _foci(bare: Foci, behind: Foci, rays: RayGrid) -> Plot:
    """Image heights with sagittal and tangential foci (n,) without the stack and with it."""
    lit = rays.image_heights[rays.lit]
    end = 1.0001 * float(lit[-1]) if lit.size else math.inf
    curves, seen = [], []
    for (heights, *both), name, tint, weight in ((bare, "bare", "faint", 1.2), (behind, "", "strong", 1.6)):
        for way, foci, dash in zip(("sagittal", "tangential"), both, (SOLID, DASHED), strict=True):
            shown = np.where(heights <= end, foci, np.nan)
            seen.append(shown[np.isfinite(shown)])
            curves.append(Curve(name or way, heights, shown, tint, dash, weight))
    limit = reach(np.concatenate(seen), 0.01)
    return Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(bare[0]))), Axis("Focus (mm)", -limit, limit),
                tuple(curves), "Foci behind the film")


def _infinity(query: Query, stack: Stack) -> tuple[str, ...]:
    """Where the lens is focused at its mark of infinity, on this adapter."""
    if stack.adapter_error == 0.0:
        return ()
    if stack.adapter_error < 0.0:
        return ("with this adapter the lens focuses beyond infinity at its mark: infinity is reached before it",)
    try:
        whole = replace(query.setup.lens.at(close=0.0), positions=None)
        reached = lb.focused_distance(whole, lb.film_distance(whole, math.inf) + stack.adapter_error)
    except lb.LensError:
        return ()
    return (f"with this adapter the lens does not reach infinity: its mark lies at {format_distance(float(reached))}",)


def _table(bare: RayGrid, without: np.ndarray, with_: np.ndarray) -> Table:
    head = ("field (mm)", "frequency (lp/mm)", "sagittal", "tangential", "sagittal bare", "tangential bare")
    return Table(head, lambda: ((height, frequency, *with_[f, :, k], *without[f, :, k])
                                for f, height in enumerate(bare.image_heights)
                                for k, frequency in enumerate(FREQUENCIES)))
