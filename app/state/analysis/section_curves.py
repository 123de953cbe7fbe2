"""Curves over the field of a lens without rotational symmetry: along the width and along the height of the film.

Foci are those of narrow beams about the chief rays. Distortion is that of image heights against f tan θ, with the focal
length f of each section from a field close to the axis, and θ the angle of the chief ray's light in the scene.
"""

import math

import numpy as np

from lensbench.analysis.grids.narrow_beams import close_foci
from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.app.state.analysis.figure import (
    DASHED,
    SOLID,
    Axis,
    Curve,
    Figure,
    Plot,
    Table,
    reach,
    wavelength_name,
)
from lensbench.app.state.analysis.query import Query

CLOSE = 0.01                    # of the half film: the field whose height gives the focal length
MOST = 100.0                    # percent of distortion that an axis shows
FIELDS = 13
WAYS = ("width", "height")
TINTS = ("field0", "field2")


def section_figure(query: Query, points: int, shown: tuple[str, ...]) -> Figure:
    """The plots of these names ("curvature", "distortion", "colour") side by side, along both sides of the film."""
    film, count = query.setup.film, FIELDS if points > 16 else FIELDS // 2 + 1
    parts = np.concatenate([[0.0, CLOSE], np.linspace(0.0, 1.0, count)[1:]])
    grids = [query.grid(16, tuple((0.5 * part * side if a == 0 else 0.0, 0.5 * part * side if a == 1 else 0.0)
                                  for part in parts.tolist()))
             for a, side in enumerate((film.width, film.height))]
    makers = {"curvature": _curvature, "distortion": _distortion, "colour": _colour}
    top = 0.5 * film.width
    plots = tuple(makers[name](grids, top) for name in shown)
    words = query.words(None, "foci of a narrow beam about the chief ray, from the film",
                        "distortion of chief rays against f tan θ of each section",
                        f"{len(parts)} fields along the width, as many along the height")
    both = [query.remarks(rays) for rays in grids]
    remarks = dict.fromkeys(said if said in both[1 - a] else f"along the {way}: {said}"
                            for a, way in enumerate(WAYS) for said in both[a])
    return Figure("Field curves of the sections", (plots,), _table(grids), words, tuple(remarks))


def _heights(rays: RayGrid) -> np.ndarray:
    """(F,) image heights; NaN for a dark field."""
    return np.where(rays.lit, rays.image_heights, np.nan)


def primary_foci(rays: RayGrid) -> np.ndarray:
    """(F, 2) foci of sagittal and tangential rays; on the axis, which has neither, those of the field beside it."""
    foci = close_foci(rays)[:, rays.conditions.primary].copy()
    foci[0] = foci[1]
    return foci


def _zero(top: float) -> Curve:
    return Curve("", np.array([0.0, top]), np.zeros(2), "faint", weight=1.0)


def _curvature(grids: list[RayGrid], top: float) -> Plot:
    curves, limits = [_zero(top)], []
    for rays, way, tint in zip(grids, WAYS, TINTS, strict=True):
        foci, heights = primary_foci(rays), _heights(rays)
        for a, (name, dash) in enumerate((("sagittal", SOLID), ("tangential", DASHED))):
            curves.append(Curve(f"{name}, {way}", heights, foci[:, a], tint, dash))
            limits.append(foci[np.isfinite(heights) & np.isfinite(foci[:, a]), a])
    limit = reach(np.concatenate(limits), 0.01)
    return Plot(Axis("Image height (mm)", 0.0, top), Axis("Focus (mm)", -limit, limit), tuple(curves),
                "Foci behind the film")


def _distortions(rays: RayGrid) -> np.ndarray:
    """(F,) percent of distortion; NaN on the axis."""
    tangents = np.tan(rays.field_angles)
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = rays.image_heights / tangents
        return np.asarray(np.where(rays.lit & (rays.image_heights > 0.0), 100.0 * (lengths / lengths[1] - 1.0), np.nan))


def _distortion(grids: list[RayGrid], top: float) -> Plot:
    curves = [_zero(top), *(Curve(way, _heights(rays), _distortions(rays), tint)
                            for rays, way, tint in zip(grids, WAYS, TINTS, strict=True))]
    known = np.concatenate([_distortions(rays) for rays in grids])
    limit = min(reach(known[np.isfinite(known)], 0.1), MOST)
    return Plot(Axis("Image height (mm)", 0.0, top), Axis("Distortion (%)", -limit, limit), tuple(curves),
                "Distortion")


def _colour(grids: list[RayGrid], top: float) -> Plot:
    """Places of the chief rays of other wavelengths along the field, against that of the primary one."""
    curves, limits = [_zero(top)], []
    for rays, way, dash in zip(grids, WAYS, (SOLID, DASHED), strict=True):
        for c, line in enumerate(rays.conditions.wavelengths):
            if c != rays.conditions.primary:
                shift = 1000.0 * np.where(rays.lit, rays.chief[:, c, 1], np.nan)
                curves.append(Curve(f"{wavelength_name(line)}, {way}", _heights(rays), shift, line, dash))
                limits.append(shift[np.isfinite(shift)])
    limit = reach(np.concatenate(limits) if limits else [], 1.0)
    title = "Lateral colour" if limits else "Lateral colour: one wavelength, hence none"
    return Plot(Axis("Image height (mm)", 0.0, top), Axis("Colour (µm)", -limit, limit), tuple(curves), title)


def _table(grids: list[RayGrid]) -> Table:
    head = ("along", "field (deg)", "image height (mm)", "sagittal focus (mm)", "tangential focus (mm)",
            "distortion f tan (%)")
    rows: list[tuple] = []
    for rays, way in zip(grids, WAYS, strict=True):
        foci = primary_foci(rays)
        rows += [(way, math.degrees(rays.field_angles[f]), rays.image_heights[f], *foci[f], distortion)
                 for f, distortion in enumerate(_distortions(rays))]
    return Table(head, tuple(rows))
