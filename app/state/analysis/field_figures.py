"""Curves over the field: field curvature and astigmatism, distortion, lateral colour."""

import math

import numpy as np

from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.analysis.meridional_curves import FieldCurves, field_curves
from lensbench.app.state.analysis.figure import (
    DASHED,
    DOTTED,
    SOLID,
    Axis,
    Curve,
    Figure,
    Plot,
    Table,
    dash_of,
    reach,
    wavelength_name,
)
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.analysis.rims import with_rims
from lensbench.app.state.analysis.section_curves import section_figure
from lensbench.kernels.figures import fixed

SHOWN = ("curvature", "distortion", "colour")
HEIGHT = "Image height (mm)"
MOST = 100.0                    # percent of distortion that an axis shows


def field_figure(query: Query, points: int, shown: tuple[str, ...] = SHOWN) -> Figure:
    """The plots of these names side by side, of a lens with cylinders along both sides of the film.

    LensError for a lens without a focus.
    """
    query = query.lines
    if not query.lens.is_rotationally_symmetric:
        return section_figure(query, points, shown)
    rays = query.grid(16)
    found = field_curves(query.lens, query.setup.film_distance, query.conditions(), 2 * points + 1)
    dark = rays.image_heights[rays.lit]
    end = float(dark[-1]) if dark.size else math.inf
    makers = {"curvature": _curvature, "distortion": _distortion, "colour": _colour}
    plots = tuple(makers[name](found, end, rays) for name in shown)
    words = query.words(None, "foci of a narrow beam about the chief ray, from the film",
                        "distortion of chief rays against f tan θ" + (
                            " and f θ" if np.isfinite(found.ideal_f_theta).any() else ""),
                        f"{len(found.heights)} fields")
    return with_rims(query, Figure("Field curves", (plots,), _table(found), words, query.remarks(rays)))


def _axis(found: FieldCurves) -> Axis:
    return Axis(HEIGHT, 0.0, float(np.nanmax(found.heights)))


def _zero(found: FieldCurves) -> Curve:
    return Curve("", np.array([0.0, float(np.nanmax(found.heights))]), np.zeros(2), "faint", weight=1.0)


def _lit(found: FieldCurves, values: np.ndarray, end: float) -> np.ndarray:
    """The values of fields that light reaches; NaN beyond."""
    return np.where(found.heights <= end * 1.0001, values, math.nan)


def _curvature(found: FieldCurves, end: float, rays: RayGrid) -> Plot:
    """Tangential and sagittal foci of each wavelength, and the Petzval surface of the primary one."""
    given, curves = found.conditions, [_zero(found)]
    several, inner = len(given.wavelengths) > 1, found.heights <= end
    for name, foci, dash in (("sagittal", found.sagittal, SOLID), ("tangential", found.tangential, DASHED)):
        for c, line in enumerate(given.wavelengths):
            main = c == given.primary
            curves.append(Curve(f"{name} {wavelength_name(line)}" if several else name, found.heights,
                                _lit(found, foci[:, c], end), line if several else "strong", dash,
                                1.8 if main else 1.0))
    start = found.sagittal[0, given.primary]
    curves.append(Curve("Petzval", found.heights, _lit(found, start + found.petzval, end), "dim", DOTTED, 1.0))
    foci = np.concatenate([found.sagittal[inner].ravel(), found.tangential[inner].ravel()])
    limit = reach(foci[np.isfinite(foci)], 0.01)
    return Plot(_axis(found), Axis("Focus (mm)", -limit, limit), tuple(curves), "Foci behind the film")


def _distortion(found: FieldCurves, end: float, rays: RayGrid) -> Plot:
    tan, theta = _lit(found, found.distortion, end), _lit(found, found.f_theta_distortion, end)
    curves = [_zero(found), Curve("against f tan θ", found.heights, tan, "strong", SOLID, 1.8)]
    if np.isfinite(theta[1:]).any():
        curves.append(Curve("against f θ", found.heights, theta, "text", DASHED, 1.2))
    known = tan[np.isfinite(tan)]
    limit = min(reach(known, 0.1), MOST)
    return Plot(_axis(found), Axis("Distortion (%)", -limit, limit), tuple(curves), "Distortion")


def _colour(found: FieldCurves, end: float, rays: RayGrid) -> Plot:
    """Heights of the chief rays of other wavelengths, against that of the primary one."""
    given, curves = found.conditions, [_zero(found)]
    shown = 1000.0 * np.column_stack([_lit(found, each, end) for each in found.lateral_colour.T])
    for c, line in enumerate(given.wavelengths):
        if c != given.primary:
            name = f"{wavelength_name(line)} less {wavelength_name(given.primary_wavelength)}"
            curves.append(Curve(name, found.heights, shown[:, c], line, dash_of(c, given.primary)))
    radius = 1000.0 * np.nanmean(_airy(rays))
    for sign in (-1.0, 1.0):
        curves.append(Curve("Airy radius", np.array([0.0, _axis(found).high]), np.full(2, sign * radius), "dim", DOTTED,
                            1.0))
    limit = reach([*shown[np.isfinite(shown)], 1.2 * radius], 1.0)
    title = "Lateral colour" if len(given.wavelengths) > 1 else "Lateral colour: one wavelength"
    return Plot(_axis(found), Axis("Colour (µm)", -limit, limit), tuple(curves), title)


def _airy(rays: RayGrid) -> np.ndarray:
    from lensbench.analysis.spot_diagram import spots

    return spots(rays).airy_radius[0, rays.conditions.primary]


def _table(found: FieldCurves) -> Table:
    lines = [f"{fixed(1000.0 * line, 1)} nm" for line in found.conditions.wavelengths]
    head = ("field (deg)", "image height (mm)", *(f"sagittal focus {line} (mm)" for line in lines),
            *(f"tangential focus {line} (mm)" for line in lines), "Petzval (mm)", "distortion f tan (%)",
            "distortion f theta (%)", *(f"lateral colour {line} (um)" for line in lines))
    return Table(head, lambda: ((math.degrees(found.angles[i]), found.heights[i], *found.sagittal[i],
                                *found.tangential[i], found.petzval[i], found.distortion[i],
                                found.f_theta_distortion[i], *(1000.0 * found.lateral_colour[i]))
                               for i in range(len(found.heights))))
