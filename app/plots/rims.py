"""What the rim of each surface ends, for figures to mark while the surface is under the mouse.

Rays that meet the stop within its rim and that another surface ends are its victims. A layer of a figure that has a
`surface` is drawn only while this surface is lit.
"""

from dataclasses import replace

import numpy as np

from lensbench.app.plots.plot import Curve, Figure, Label, Plot, Points
from lensbench.app.plots.query import Query
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.text import fixed

HEIGHT = "Image height (mm)"    # the axis over which a rim has a line
POINTS = 16                     # across the pupil, of the rays whose ends are counted
WEIGHT = 5.0                    # of the line along the fields that a rim cuts, pixels


def victims(rays: RayGrid) -> dict[int, np.ndarray]:
    """The surfaces that end rays within the stop, and (F,) the part of the rays of each field that they end."""
    c = rays.conditions.primary
    within, ends = rays.stop_share[:, c] <= 1.0, rays.victim[:, c]
    launched = np.maximum(within.sum((1, 2)), 1)
    surfaces = np.unique(ends[within & (ends >= 0)]).tolist()
    return {int(surface): (within & (ends == surface)).sum((1, 2)) / launched for surface in surfaces}


def with_rims(query: Query, figure: Figure) -> Figure:
    """The figure with a line for each surface, in plots over the image height: along the fields whose rays it ends."""
    try:
        rays = query.lines.grid(POINTS)
    except LensError:               # no light: nothing is cut by a rim alone
        return figure
    heights, ended = rays.image_heights, victims(rays)
    ends = np.concatenate([heights[:1], 0.5 * (heights[1:] + heights[:-1]), heights[-1:]])

    def marked(plot: Plot) -> Plot:
        if HEIGHT not in (plot.x.label, plot.y.label):
            return plot
        lines = []
        for surface, shares in ended.items():
            cut = np.flatnonzero(shares > 0.0)
            along = np.stack([ends[cut], ends[cut + 1], np.full(cut.size, np.nan)], 1).ravel()
            across = np.full(along.size, plot.y.low if plot.x.label == HEIGHT else plot.x.low)
            x, y = (along, across) if plot.x.label == HEIGHT else (across, along)
            lines.append(Curve("", x, y, "dead", weight=WEIGHT, surface=surface))
        return replace(plot, layers=(*plot.layers, *lines))

    return replace(figure, rows=tuple(tuple(marked(plot) for plot in row) for row in figure.rows))


def with_shares(rays: RayGrid, plot: Plot) -> Plot:
    """The plot of a few fields with the part of their rays that a surface ends, in words at its lower left."""
    labels = []
    for surface, shares in victims(rays).items():
        percents = " · ".join(fixed(100.0 * share, 0) for share in shares)
        which = "the rays" if len(shares) == 1 else "the rays of each field"
        labels.append(Label(plot.x.low, plot.y.low, f"surface {surface} ends {percents} % of {which}", "dead",
                            "right above", surface))
    return replace(plot, layers=(*plot.layers, *labels))


def ends_within_stop(rays: RayGrid, f: int, c: int) -> np.ndarray:
    """(N, N) the surface that ends each ray of a field and wavelength; −1 where none does, or the stop would anyway."""
    ends = rays.victim[f, c]
    return np.where((rays.stop_share[f, c] <= 1.0) | (ends == rays.lens.stop_index), ends, -1)


def ended_marks(x: np.ndarray, y: np.ndarray, ends: np.ndarray) -> list[Points]:
    """Marks at x and y of rays that surfaces `ends` end, all of one shape; a layer for each surface, none for −1."""
    known = np.isfinite(x) & np.isfinite(y) & (ends >= 0)
    return [Points("", x[known & (ends == surface)], y[known & (ends == surface)], "dead", "diamond",
                   surface=int(surface)) for surface in np.unique(ends[known])]
