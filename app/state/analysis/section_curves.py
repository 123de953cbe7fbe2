"""Curves over the field of a lens without rotational symmetry: along the width and along the height of the film.

Foci are those of narrow beams about the chief rays. Distortion is that of image heights against f tan θ, with the focal
length f of each section from a field close to the film's centre, and tan θ the slope of the chief ray's light in the
scene, less that of the centre. Curves of a lens out of line run from edge to edge of the film, as it draws otherwise on
either side.
"""

import math
from dataclasses import replace

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
    if not query.lens.is_in_line:
        parts = np.concatenate([-parts[:0:-1], parts])
    sections = [replace(query, heights=tuple((0.5 * part * x, 0.5 * part * y) for part in parts.tolist()))
                for x, y in ((film.width, 0.0), (0.0, film.height))]
    grids = [asked.grid(16, asked.heights) for asked in sections]
    makers = {"curvature": _curvature, "distortion": _distortion, "colour": _colour}
    top, one_sided = 0.5 * film.width, parts[0] == 0.0
    axis = Axis("Image height (mm)" if one_sided else "Place on the film (mm)", 0.0 if one_sided else -top, top)
    plots = tuple(makers[name](grids, axis) for name in shown)
    words = query.words(None, "foci of a narrow beam about the chief ray, from the film",
                        "distortion of chief rays against f tan θ of each section",
                        f"{len(parts)} fields along the width, as many along the height")
    both = [asked.remarks(rays) for asked, rays in zip(sections, grids, strict=True)]
    remarks = dict.fromkeys(said if said in both[1 - a] else f"along the {way}: {said}"
                            for a, way in enumerate(WAYS) for said in both[a])
    return Figure("Field curves of the sections", (plots,), _table(grids), words, tuple(remarks))


def _along(rays: RayGrid) -> int:
    """The film's coordinate along which the fields of a section run: 0 or 1."""
    return int(np.nanargmax(np.ptp(np.array(rays.conditions.fields), 0)))


def _places(rays: RayGrid) -> np.ndarray:
    """(F,) coordinates of the reference points along the section, mm; NaN for a dark field."""
    return np.where(rays.lit, rays.images[:, _along(rays)], np.nan)


def _foci(rays: RayGrid) -> np.ndarray:
    """(F, 2) foci of sagittal and tangential rays; in the centre, which has neither, those of the fields beside it."""
    foci, middle = close_foci(rays)[:, rays.conditions.primary].copy(), _middle(rays)
    foci[middle] = foci[_beside(middle)].mean(0)
    return foci


def _beside(middle: int) -> list[int]:
    """The fields beside the centre, which is the first or has others on both sides."""
    return [middle + 1] if middle == 0 else [middle - 1, middle + 1]


def _middle(rays: RayGrid) -> int:
    """The index of the film's centre among the fields."""
    return int(np.argmin(np.abs(np.array(rays.conditions.fields)).sum(1)))


def _zero(axis: Axis) -> Curve:
    return Curve("", np.array([axis.low, axis.high]), np.zeros(2), "faint", weight=1.0)


def _curvature(grids: list[RayGrid], axis: Axis) -> Plot:
    curves, limits = [_zero(axis)], []
    for rays, way, tint in zip(grids, WAYS, TINTS, strict=True):
        foci, places = _foci(rays), _places(rays)
        for a, (name, dash) in enumerate((("sagittal", SOLID), ("tangential", DASHED))):
            curves.append(Curve(f"{name}, {way}", places, foci[:, a], tint, dash))
            limits.append(foci[np.isfinite(places) & np.isfinite(foci[:, a]), a])
    limit = reach(np.concatenate(limits), 0.01)
    return Plot(axis, Axis("Focus (mm)", -limit, limit), tuple(curves), "Foci behind the film")


def _distortions(rays: RayGrid) -> np.ndarray:
    """(F,) percent of distortion; NaN in the centre."""
    size, a, middle = rays.field_angles, _along(rays), _middle(rays)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.tan(size) * np.where(size > 0.0, rays.angles[:, a] / size, 0.0)
        lengths = _places(rays) / (slopes - slopes[middle])
        lengths[middle] = np.nan
        return np.asarray(100.0 * (lengths / lengths[_beside(middle)].mean() - 1.0))


def _distortion(grids: list[RayGrid], axis: Axis) -> Plot:
    curves = [_zero(axis), *(Curve(way, _places(rays), _distortions(rays), tint)
                             for rays, way, tint in zip(grids, WAYS, TINTS, strict=True))]
    known = np.concatenate([_distortions(rays) for rays in grids])
    limit = min(reach(known[np.isfinite(known)], 0.1), MOST)
    return Plot(axis, Axis("Distortion (%)", -limit, limit), tuple(curves), "Distortion")


def _colour(grids: list[RayGrid], axis: Axis) -> Plot:
    """Places of the chief rays of other wavelengths along the field, against that of the primary one."""
    curves, limits = [_zero(axis)], []
    for rays, way, dash in zip(grids, WAYS, (SOLID, DASHED), strict=True):
        for c, line in enumerate(rays.conditions.wavelengths):
            if c != rays.conditions.primary:
                shift = 1000.0 * np.where(rays.lit, rays.chief[:, c, 1], np.nan)
                curves.append(Curve(f"{wavelength_name(line)}, {way}", _places(rays), shift, line, dash))
                limits.append(shift[np.isfinite(shift)])
    limit = reach(np.concatenate(limits) if limits else [], 1.0)
    title = "Lateral colour" if limits else "Lateral colour: one wavelength"
    return Plot(axis, Axis("Colour (µm)", -limit, limit), tuple(curves), title)


def _table(grids: list[RayGrid]) -> Table:
    head = ("along", "field (deg)", "place on the film (mm)", "sagittal focus (mm)", "tangential focus (mm)",
            "distortion f tan (%)")
    rows: list[tuple] = []
    for rays, way in zip(grids, WAYS, strict=True):
        foci, places = _foci(rays), _places(rays)
        rows += [(way, math.degrees(rays.field_angles[f]), places[f], *foci[f], distortion)
                 for f, distortion in enumerate(_distortions(rays))]
    return Table(head, tuple(rows))
