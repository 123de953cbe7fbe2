"""Curves over the field: depth of field, field curvature and astigmatism, distortion, lateral colour.

Foci are those of narrow beams about the chief rays. Distortion is that of image heights against f tan θ, with the focal
length f of each section from a field close to the film's centre, and tan θ the slope of the chief ray's light in the
scene, less that of the centre. Curves of a tilted or decentred lens run from edge to edge of the film: its two sides
differ.
"""

import math
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.plots.plot import (
    DASHED, DOTTED, SOLID, Area, Axis, Curve, Figure, Plot, Table, dash_of, reach, wavelength_name
)
from lensbench.app.plots.query import Query, with_rims
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.chief_ray_curves import FieldCurves, field_curves
from lensbench.core.analysis.depth_over_field import FieldDepth, field_depth
from lensbench.core.analysis.grids.traced_grid import RayGrid, close_foci
from lensbench.core.optics.finding import Kind
from lensbench.core.text import fixed, significant

DEPTH_FIELDS = 9
DIAGONALS = 1500.0              # of the film in the blur that counts as sharp by default
LOG = 6.0                       # × the nearest, from which on the axis is logarithmic
ROOM = 0.2                      # of the distances shown, on either side
BEYOND = 1.6                    # × the farthest finite distance, where an infinite one is drawn


def depth_figure(query: Query, points: int, limit: float | None = None) -> Figure:
    """Nearest and farthest sharp distance, and the sharpest one, over the image height.

    limit: blur that counts as sharp (mm); None: diagonal / 1500. LensError where no light reaches the film.
    """
    built = query.bench
    sharp = built.film.diagonal / DIAGONALS if limit is None else limit
    fields = query.conditions(DEPTH_FIELDS if points > 16 else DEPTH_FIELDS // 2 + 1)
    depth = field_depth(query.lens, built.film_distance, fields, sharp, min(points, 24))
    heights = depth.heights
    # Beyond a window into water at their true distances, which grow towards the edge of the field
    port = replace(built.port, index=built.port.stretch(heights / abs(built.first_order.efl)))
    near, far, best = (port.true(values + built.film_z) for values in (depth.near, depth.far, depth.best))
    said = [_said(depth, i, (near[i], far[i], best[i])) for i in range(len(heights))]
    near, far, best = 0.001 * near, 0.001 * far, 0.001 * best
    focus = 0.001 * float(built.port.true(query.focus_distance))
    paraxial = _paraxial(query, sharp)
    every = np.concatenate([near, far, best, [focus], paraxial])
    known, endless = every[np.isfinite(every)], bool(np.isinf(every).any())
    low, high = (float(known.min()), float(known.max())) if known.size else (0.1, 100.0)
    room = max(ROOM * (high - low), 1e-3 * high)
    low, high = max(0.9 * low, low - room), BEYOND * high if endless else min(1.1 * high, high + room)
    shown = [np.where(np.isinf(values), high, values) for values in (near, far, best)]
    ends = np.array([0.0, float(np.nanmax(heights))])
    curves: list = [Curve("nearest sharp", heights, shown[0], "field0"),
                    Curve("farthest sharp", heights, shown[1], "field2"),
                    Curve("sharpest", heights, shown[2], "strong", DASHED)]
    for k, values in enumerate(paraxial):
        curves.append(Curve("" if k else "paraxial", ends, np.full(2, min(values, high)), "dim", DOTTED, 1.2))
    curves.append(Curve("focus", ends, np.full(2, min(focus, high)), "amber", weight=1.0))
    step = 0.5 * (heights[1] - heights[0]) if len(heights) > 1 else 1.0
    curves += [Area((h - step, h + step), (low, high), said[i]) for i, h in enumerate(heights) if math.isfinite(h)]
    plot = Plot(Axis("Image height (mm)", 0.0, ends[1]), Axis("Distance (m)", low, high, log=high > LOG * low),
                tuple(curves), "∞ at the top" if endless else "")
    words = query.words(None, f"sharp: blurred by {significant(1000.0 * sharp, 3)} µm at most",
                        "blur: 2√2 × the rms radius, white", f"{len(heights)} fields")
    remarks = tuple(str(values.message) for values in depth.findings if values.kind is not Kind.ASSUMED)
    head = ("field (mm)", "nearest (m)", "farthest (m)", "sharpest (m)", "least blur (um)")
    rows = tuple(zip(heights, near, far, best, 1000.0 * depth.least, strict=True))
    return with_rims(query, Figure("Depth of field", ((plot,),), Table(head, rows), words, remarks))


def _paraxial(query: Query, sharp: float) -> tuple[float, ...]:
    """Near and far limit (m, from the film) of the thick lens; none where its two foci blur all more than the limit."""
    built = query.bench
    try:
        limits = lb.thick_depth_of_field(built.lens, built.film_distance, query.focus_distance, sharp)
    except lb.LensError:
        return ()
    return tuple(0.001 * float(built.port.true(limit)) for limit in limits if not math.isnan(limit))


def _said(depth: FieldDepth, i: int, distances: tuple[float, float, float]) -> str:
    """The numbers of a field. distances: nearest and farthest sharp one, and the sharpest (mm from the film)."""
    lines = [f"{significant(depth.heights[i], 3)} mm from the centre"]
    if math.isnan(depth.least[i]):
        return f"{lines[0]}: no light reaches this field"
    for name, value in zip(("nearest sharp", "farthest sharp", "sharpest"), distances, strict=True):
        lines.append(f"{name}   {format_distance(value) if not math.isnan(value) else '–'}")
    return "\n".join((*lines, f"least blur   {significant(1000.0 * depth.least[i], 3)} µm"))


CLOSE = 0.01                    # of the half film: the field whose height gives the focal length
MOST = 100.0                    # percent of distortion that an axis shows
SECTION_FIELDS = 13
WAYS = ("width", "height")
TINTS = ("field0", "field2")


def section_figure(query: Query, points: int, shown: tuple[str, ...]) -> Figure:
    """The plots of these names ("curvature", "distortion", "colour") side by side, along both sides of the film."""
    film, count = query.bench.film, SECTION_FIELDS if points > 16 else SECTION_FIELDS // 2 + 1
    shares = np.concatenate([[0.0, CLOSE], np.linspace(0.0, 1.0, count)[1:]])
    if not query.lens.is_centred:
        shares = np.concatenate([-shares[:0:-1], shares])
    sections = [replace(query, heights=tuple((0.5 * share * x, 0.5 * share * y) for share in shares.tolist()))
                for x, y in ((film.width, 0.0), (0.0, film.height))]
    grids = [asked.grid(16, asked.heights) for asked in sections]
    makers = {"curvature": _section_curvature, "distortion": _section_distortion, "colour": _section_colour}
    top, one_sided = 0.5 * film.width, shares[0] == 0.0
    axis = Axis("Image height (mm)" if one_sided else "Place on the film (mm)", 0.0 if one_sided else -top, top)
    plots = tuple(makers[name](grids, axis) for name in shown)
    words = query.words(None, "foci of a narrow beam about the chief ray, from the film",
                        "distortion of chief rays against f tan θ of each section",
                        f"{len(shares)} fields along the width, as many along the height")
    both = [asked.remarks(rays) for asked, rays in zip(sections, grids, strict=True)]
    remarks = dict.fromkeys(said if said in both[1 - a] else f"along the {way}: {said}"
                            for a, way in enumerate(WAYS) for said in both[a])
    return Figure("Field curves of the sections", (plots,), _section_table(grids), words, tuple(remarks))


def _along(rays: RayGrid) -> int:
    """The film's coordinate along which the fields of a section run: 0 or 1."""
    return int(np.nanargmax(np.ptp(np.array(rays.conditions.fields), 0)))


def _places(rays: RayGrid) -> np.ndarray:
    """(F,) coordinates of the reference points along the section, mm; NaN for a dark field."""
    return np.where(rays.lit, rays.images[:, _along(rays)], np.nan)


def _foci(rays: RayGrid) -> np.ndarray:
    """(F, 2) foci of sagittal and tangential rays; in the centre, which has neither, those of the fields next to it."""
    foci, middle = close_foci(rays)[:, rays.conditions.primary].copy(), _middle(rays)
    foci[middle] = foci[_neighbours(middle)].mean(0)
    return foci


def _neighbours(middle: int) -> list[int]:
    """The fields next to the centre, which is the first or has others on both sides."""
    return [middle + 1] if middle == 0 else [middle - 1, middle + 1]


def _middle(rays: RayGrid) -> int:
    """The index of the film's centre among the fields."""
    return int(np.argmin(np.abs(np.array(rays.conditions.fields)).sum(1)))


def _zero(axis: Axis) -> Curve:
    return Curve.straight((axis.low, axis.high), (0.0, 0.0), "faint")


def _section_curvature(grids: list[RayGrid], axis: Axis) -> Plot:
    curves, limits = [_zero(axis)], []
    for rays, way, tint in zip(grids, WAYS, TINTS, strict=True):
        foci, heights = _foci(rays), _places(rays)
        for a, (name, dash) in enumerate((("sagittal", SOLID), ("tangential", DASHED))):
            curves.append(Curve(f"{name}, {way}", heights, foci[:, a], tint, dash))
            limits.append(foci[np.isfinite(heights) & np.isfinite(foci[:, a]), a])
    limit = reach(np.concatenate(limits), 0.01)
    return Plot(axis, Axis("Focus (mm)", -limit, limit), tuple(curves), "Foci behind the film")


def _distortions(rays: RayGrid) -> np.ndarray:
    """(F,) percent of distortion; NaN in the centre."""
    size, a, middle = rays.field_angles, _along(rays), _middle(rays)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.tan(size) * np.where(size > 0.0, rays.angles[:, a] / size, 0.0)
        lengths = _places(rays) / (slopes - slopes[middle])
        lengths[middle] = np.nan
        return np.asarray(100.0 * (lengths / lengths[_neighbours(middle)].mean() - 1.0))


def _section_distortion(grids: list[RayGrid], axis: Axis) -> Plot:
    curves = [_zero(axis), *(Curve(way, _places(rays), _distortions(rays), tint)
                             for rays, way, tint in zip(grids, WAYS, TINTS, strict=True))]
    known = np.concatenate([_distortions(rays) for rays in grids])
    limit = min(reach(known[np.isfinite(known)], 0.1), MOST)
    return Plot(axis, Axis("Distortion (%)", -limit, limit), tuple(curves), "Distortion")


def _section_colour(grids: list[RayGrid], axis: Axis) -> Plot:
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


def _section_table(grids: list[RayGrid]) -> Table:
    head = ("along", "field (deg)", "place on the film (mm)", "sagittal focus (mm)", "tangential focus (mm)",
            "distortion f tan (%)")
    rows: list[tuple] = []
    for rays, way in zip(grids, WAYS, strict=True):
        foci, heights = _foci(rays), _places(rays)
        rows += [(way, math.degrees(rays.field_angles[f]), heights[f], *foci[f], distortion)
                 for f, distortion in enumerate(_distortions(rays))]
    return Table(head, tuple(rows))


SHOWN = ("curvature", "distortion", "colour")
HEIGHT = "Image height (mm)"


def field_figure(query: Query, points: int, shown: tuple[str, ...] = SHOWN) -> Figure:
    """The plots of these names side by side, of a lens with cylinders along both sides of the film.

    LensError for a lens without a focus.
    """
    query = query.lines
    if not query.lens.is_rotationally_symmetric:
        return section_figure(query, points, shown)
    rays = query.grid(16)
    curves = field_curves(query.lens, query.bench.film_distance, query.conditions(), 2 * points + 1)
    dark = rays.image_heights[rays.lit]
    end = float(dark[-1]) if dark.size else math.inf
    makers = {"curvature": _field_curvature, "distortion": _field_distortion, "colour": _field_colour}
    plots = tuple(makers[name](curves, end, rays) for name in shown)
    words = query.words(None, "foci of a narrow beam about the chief ray, from the film",
                        "distortion of chief rays against f tan θ" + (
                            " and f θ" if np.isfinite(curves.ideal_f_theta).any() else ""),
                        f"{len(curves.heights)} fields")
    return with_rims(query, Figure("Field curves", (plots,), _field_table(curves), words, query.remarks(rays)))


def _axis(curves: FieldCurves) -> Axis:
    return Axis(HEIGHT, 0.0, float(np.nanmax(curves.heights)))


def _lit(curves: FieldCurves, values: np.ndarray, end: float) -> np.ndarray:
    """The values of fields that light reaches; NaN beyond."""
    return np.where(curves.heights <= end * 1.0001, values, math.nan)


def _field_curvature(field: FieldCurves, end: float, rays: RayGrid) -> Plot:
    """Tangential and sagittal foci of each wavelength, and the Petzval surface of the primary one."""
    conditions, curves = field.conditions, [_zero(_axis(field))]
    several, inner = len(conditions.wavelengths) > 1, field.heights <= end
    for name, foci, dash in (("sagittal", field.sagittal, SOLID), ("tangential", field.tangential, DASHED)):
        for c, line in enumerate(conditions.wavelengths):
            main = c == conditions.primary
            curves.append(Curve(f"{name} {wavelength_name(line)}" if several else name, field.heights,
                                _lit(field, foci[:, c], end), line if several else "strong", dash,
                                1.8 if main else 1.0))
    start = field.sagittal[0, conditions.primary]
    curves.append(Curve("Petzval", field.heights, _lit(field, start + field.petzval, end), "dim", DOTTED, 1.0))
    foci = np.concatenate([field.sagittal[inner].ravel(), field.tangential[inner].ravel()])
    limit = reach(foci[np.isfinite(foci)], 0.01)
    return Plot(_axis(field), Axis("Focus (mm)", -limit, limit), tuple(curves), "Foci behind the film")


def _field_distortion(field: FieldCurves, end: float, rays: RayGrid) -> Plot:
    tan, theta = _lit(field, field.distortion, end), _lit(field, field.f_theta_distortion, end)
    curves = [_zero(_axis(field)), Curve("against f tan θ", field.heights, tan, "strong", SOLID, 1.8)]
    if np.isfinite(theta[1:]).any():
        curves.append(Curve("against f θ", field.heights, theta, "text", DASHED, 1.2))
    known = tan[np.isfinite(tan)]
    limit = min(reach(known, 0.1), MOST)
    return Plot(_axis(field), Axis("Distortion (%)", -limit, limit), tuple(curves), "Distortion")


def _field_colour(field: FieldCurves, end: float, rays: RayGrid) -> Plot:
    """Heights of the chief rays of other wavelengths, against that of the primary one."""
    conditions, curves = field.conditions, [_zero(_axis(field))]
    shown = 1000.0 * np.column_stack([_lit(field, shift, end) for shift in field.lateral_colour.T])
    for c, line in enumerate(conditions.wavelengths):
        if c != conditions.primary:
            name = f"{wavelength_name(line)} less {wavelength_name(conditions.primary_wavelength)}"
            curves.append(Curve(name, field.heights, shown[:, c], line, dash_of(c, conditions.primary)))
    radius = 1000.0 * np.nanmean(_airy(rays))
    for sign in (-1.0, 1.0):
        curves.append(Curve("Airy radius", np.array([0.0, _axis(field).high]), np.full(2, sign * radius), "dim", DOTTED,
                            1.0))
    limit = reach([*shown[np.isfinite(shown)], 1.2 * radius], 1.0)
    title = "Lateral colour" if len(conditions.wavelengths) > 1 else "Lateral colour: one wavelength"
    return Plot(_axis(field), Axis("Colour (µm)", -limit, limit), tuple(curves), title)


def _airy(rays: RayGrid) -> np.ndarray:
    from lensbench.core.analysis.spot_diagram import spots

    return spots(rays).airy_radius[0, rays.conditions.primary]


def _field_table(curves: FieldCurves) -> Table:
    lines = [f"{fixed(1000.0 * line, 1)} nm" for line in curves.conditions.wavelengths]
    head = ("field (deg)", "image height (mm)", *(f"sagittal focus {line} (mm)" for line in lines),
            *(f"tangential focus {line} (mm)" for line in lines), "Petzval (mm)", "distortion f tan (%)",
            "distortion f theta (%)", *(f"lateral colour {line} (um)" for line in lines))
    return Table(head, lambda: ((math.degrees(curves.angles[i]), curves.heights[i], *curves.sagittal[i],
                                *curves.tangential[i], curves.petzval[i], curves.distortion[i],
                                curves.f_theta_distortion[i], *(1000.0 * curves.lateral_colour[i]))
                               for i in range(len(curves.heights))))
