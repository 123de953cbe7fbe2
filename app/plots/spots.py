"""Spots of the fields through focus or by colour, to one scale; and the ray of a mark of a spot or a fan."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.ray_fans import blockers, end_text
from lensbench.app.plots.pixel_rays import PointedRay, landing, path_before_lens
from lensbench.app.plots.plot import (
    DASHED, Area, Axis, Curve, Figure, Label, Map, Plot, Points, Table, reach, shape_of, wavelength_name
)
from lensbench.app.plots.query import Query, query
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.point_spread import ray_density
from lensbench.core.analysis.spot_diagram import Spots, light_shares, spots
from lensbench.core.text import fixed, significant, true_minus

AXIS = 1e-5                     # mm from the film's centre, to which a field counts as the axis
COLUMNS = 5                     # of a row through focus
DRAWN = 260                     # points of a wavelength in one spot, at most; its size counts all rays
FEW = 40                        # the same over the picture of the point, which they must not hide
CELL = 2.6                      # half a cell is at least so many rms radii of the largest spot in focus
COARSE = 20.0                   # × that: cells grow to hold a pixel of up to this size
BLUR = 25                       # samples of the light across a cell
REFERENCES = {"chief": "chief ray", "centroid": "centroid"}
CIRCLE = np.column_stack([wave(np.linspace(0.0, 2.0 * math.pi, 49)) for wave in (np.cos, np.sin)])


def spots_figure(query: Query, points: int, columns: str = "focus", reference: str = "chief", rows: int = 4,
                 blur: bool = False) -> Figure:
    """Spots of `rows` fields, or of those that the query chooses.

    columns: "focus" puts places of the film side by side, "colour" the wavelengths. reference: "chief" or "centroid".
    blur: shade behind the rays of each cell the picture of the point, as bright as its brightest place.
    LensError where no light reaches the film.
    """
    rays = query.grid(points, query.heights or None)
    fields = chosen_fields(len(rays.images), len(query.heights) or rows)
    still = spots(rays, reference)
    shifts = np.array([0.0])
    if columns == "focus":
        shifts = _step(rays, still) * (np.arange(COLUMNS) - COLUMNS // 2)
    diagram = still if columns != "focus" else spots(rays, reference, shifts)
    size = still.white_rms_radius[fields, 0]
    pitch, airy = query.bench.film.pitch, float(np.nanmax(still.airy_radius[fields], initial=0.0))
    least = CELL * float(np.nanmax(size, initial=0.0))
    half = reach([least], 0.5 * pitch if pitch < COARSE * max(least, airy) else airy)
    plot, beyond = _plot(query, diagram, fields, columns, half, FEW if blur else DRAWN)
    if blur:
        plot = replace(plot, layers=(*_blurs(diagram, fields, columns, half), *plot.layers))
    remarks = query.remarks(rays)
    if beyond:
        remarks = (*remarks, f"{beyond} points lie outside their cells and are not drawn")
    if pitch > 2.01 * half:
        remarks = (*remarks, f"a pixel, {significant(1000.0 * pitch, 3)} µm wide, is larger than the cells: it is not "
                             "drawn")
    words = query.words(rays, REFERENCES[reference], f"cell {significant(2000.0 * half, 3)} µm",
                        *(("blur of the picture behind",) if blur else ()))
    return Figure("Spots", ((plot,),), _table(diagram), words, remarks, points=rays.opd.shape[-1])


def chosen_fields(count: int, rows: int) -> np.ndarray:
    """Indices of so many of the fields, evenly spread with both ends."""
    return np.unique(np.round(np.linspace(0, count - 1, min(rows, count))).astype(int))


def field_tint(f: int, count: int) -> str:
    """The tint of the curves of one of so many fields."""
    return f"field{f}" if count <= 3 else f"chart{f}"


def field_label(rays: RayGrid, f: int) -> str:
    """A field by its image height, such as "axis" or "12.4 mm"."""
    height = float(rays.image_heights[f])
    return "axis" if height < AXIS else f"{significant(height, 3)} mm" if math.isfinite(height) else "dark"


def _step(rays: RayGrid, still: Spots) -> float:
    """The shift of the film (mm) that blurs a perfect spot as far as the spots of the middle fields are wide."""
    lit = np.flatnonzero(rays.lit)
    areas = rays.coverage[:, rays.conditions.primary].sum((1, 2)) * rays.steps.prod(1)
    half = 0.5 * float(np.median(areas[lit])) ** 0.5
    radius = max(float(np.median(still.white_rms_radius[lit, 0])), float(np.nanmin(still.airy_radius)))
    return reach([0.9 * radius / max(half, 1e-6)])


def _plot(query: Query, diagram: Spots, fields: np.ndarray, columns: str, half: float, drawn_rays: int
          ) -> tuple[Plot, int]:
    """The cells, 1 wide and 1 high, from (0, 0) to the right and downward; and how many points lie outside them."""
    rays, conditions, film = diagram.rays, diagram.rays.conditions, query.bench.film
    colours = range(len(conditions.wavelengths))
    across = [[(c, k) for c in colours] for k in range(len(diagram.shifts))] if columns == "focus" else \
        [[(c, 0)] for c in colours]
    clouds: list[list[np.ndarray]] = [[] for _ in colours]
    keys: list[list[np.ndarray]] = [[] for _ in colours]
    ended: dict[int, list[np.ndarray]] = {}             # by surface
    airy, pixel, layers, beyond = [], [], [], 0
    nan = np.full((1, 2), math.nan)
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * 0.25 * np.array(
        [film.width / film.pixels_x, film.height / film.pixels_y]) / half
    stride = max(1, math.ceil((rays.opd.shape[-1] ** 2 * 0.8 / drawn_rays) ** 0.5))
    for row, f in enumerate(fields):
        rays_of = [_thinned(diagram, f, c, stride) for c in colours]
        for column, group in enumerate(across):
            middle = np.array([column, -row])
            for c, k in group:
                landed, cells, victims, surfaces = rays_of[c]
                cloud = landed[k] / (2.0 * half)
                inside = (np.abs(cloud) < 0.5).all(1)
                drawn = inside & (victims == -1)
                beyond += int(np.count_nonzero(~inside & (victims == -1)))
                clouds[c].append(cloud[drawn] + middle)
                keys[c].append(cells[drawn])
                for surface in surfaces:
                    ended.setdefault(surface, []).append(cloud[(victims == surface) & inside] + middle)
            radius = diagram.airy_radius[f, group[len(group) // 2][0]] / (2.0 * half)
            airy += [middle + radius * CIRCLE, nan]
            pixel += [middle + square, nan]
            layers += _words(diagram, f, group, column, row, columns)
    corner = len(across) - 0.5, 0.5 - len(fields)
    grid = [np.array([[x - 0.5, 0.5], [x - 0.5, corner[1]], [math.nan] * 2]) for x in range(len(across) + 1)]
    grid += [np.array([[-0.5, 0.5 - y], [corner[0], 0.5 - y], [math.nan] * 2]) for y in range(len(fields) + 1)]
    lines = [Curve.through("", np.concatenate(grid), "grid", weight=1.0)]
    marks = []
    for c, line in enumerate(conditions.wavelengths):
        x, y = np.concatenate(clouds[c]).T
        marks.append(Points(wavelength_name(line), x, y, line, shape_of(c), np.concatenate(keys[c])))
    for surface, points in ended.items():
        x, y = np.concatenate(points).T
        marks.append(Points("", x, y, "dead", "diamond", surface=surface))
    ends = [Curve.through("Airy", np.concatenate(airy), "strong", DASHED, 1.0)]
    if film.pitch <= 2.01 * half:
        ends.insert(0, Curve.through("pixel", np.concatenate(pixel), "text", weight=1.0))
    heads = [Label(x, 0.5, _head(diagram, group, columns),
                   "amber" if _in_focus(diagram, group, columns) else "dim", "above") for x, group in enumerate(across)]
    return Plot(Axis(None, -0.52, corner[0] + 0.02), Axis(None, corner[1] - 0.02, 0.74),
                (*lines, *marks, *ends, *layers, *heads), equal=True, cell=2.0 * half), beyond


def _blurs(diagram: Spots, fields: np.ndarray, columns: str, half: float) -> list[Map]:
    """The picture of the point in each cell where light falls: all its colours, or one."""
    rays, shares, pitch = diagram.rays, light_shares(diagram.rays), 2.0 * half / BLUR
    colours = range(len(rays.conditions.wavelengths))
    across = [(colours, k) for k in range(len(diagram.shifts))] if columns == "focus" else [((c,), 0) for c in colours]
    maps = []
    for row, f in enumerate(fields):
        for column, (group, k) in enumerate(across):
            lit = [c for c in group if rays.weight[f, c].any()]
            light = np.zeros((BLUR, BLUR), np.float32)
            for c in lit:
                light += np.float32(shares[f, c]) * ray_density(rays, f, c, float(diagram.shifts[k]),
                                                                diagram.references[f, k], pitch, BLUR)
            if light.any():
                maps.append(Map("", light / light.max(), (column - 0.5, column + 0.5), (-row - 0.5, 0.5 - row)))
    return maps


def _thinned(diagram: Spots, f: int, c: int, stride: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[int]]:
    """Every `stride`-th ray in rows and columns of the pupil that lands.

    Returns (K, n, 2) mm from the reference at each place of the film, (n, 4) field, wavelength and pupil coordinates,
    (n,) the surface that ends it, −1 for one that passes, and these surfaces. A ray that a rim ends is where it would
    land without rims, known close to them.
    """
    rays = diagram.rays
    some = (f, c, slice(None, None, stride), slice(None, None, stride))
    victims = rays.victim[some]
    rows, columns = np.nonzero((victims >= -1) & np.isfinite(rays.offset_s[some]))
    landed, cells = np.empty((len(diagram.shifts), len(rows), 2)), np.empty((len(rows), 4))
    for a, (offset, slope) in enumerate(((rays.offset_s, rays.slope_s), (rays.offset_t, rays.slope_t))):
        landed[..., a] = (offset[some][rows, columns] + diagram.shifts[:, None] * slope[some][rows, columns]
                          - diagram.references[f, :, a, None])
    cells[:, :2] = f, rays.conditions.wavelengths[c]
    cells[:, 2], cells[:, 3] = rays.pupil[f, 0, columns * stride], rays.pupil[f, 1, rows * stride]
    ends = victims[rows, columns]
    return landed, cells, ends, np.unique(ends[ends >= 0]).tolist()


def _in_focus(diagram: Spots, group: list, columns: str) -> bool:
    return columns == "focus" and diagram.shifts[group[0][1]] == 0.0


def _head(diagram: Spots, group: list, columns: str) -> str:
    if columns != "focus":
        return wavelength_name(diagram.rays.conditions.wavelengths[group[0][0]])
    shift = diagram.shifts[group[0][1]]
    unit = " µm" if group[0][1] == len(diagram.shifts) - 1 else ""
    return "film" if shift == 0.0 else true_minus(f"{significant(1000.0 * shift, 3, signed=True)}{unit}")


def _words(diagram: Spots, f: int, group: list, column: int, row: int, columns: str) -> list:
    """Labels of one cell, and its words under the cursor."""
    rays, k = diagram.rays, group[0][1]
    cell = (column - 0.5, column + 0.5), (-row - 0.5, 0.5 - row)
    angle = math.degrees(rays.field_angles[f])
    name = field_label(rays, f)
    made: list = [Label(column - 0.48, 0.48 - row, name, "text", "right below")] if column == 0 else []
    if not rays.lit[f]:
        made.append(Label(column, -row, "dark", "dim", "middle"))
        return [*made, Area(*cell, f"{name}: no light reaches this field")]
    rms = 1000.0 * (diagram.white_rms_radius[f, k] if columns == "focus" else diagram.rms_radius[f, group[0][0], k])
    made.append(Label(column + 0.47, -row - 0.48, significant(rms, 2), "dim", "left above"))
    shift = 1000.0 * diagram.shifts[k]
    moved = true_minus(f", film {significant(shift, 3, signed=True)} µm") if shift else ""
    said = [f"{name}, {fixed(angle, 1)}°{moved}"]
    if len(group) > 1:
        geo = significant(1000.0 * diagram.white_geo[f, k], 3)
        said.append(f"all colours   RMS {significant(rms, 3)} µm   GEO {geo} µm")
    for c, _ in group:
        line = wavelength_name(rays.conditions.wavelengths[c])
        said.append(f"{line}   RMS {significant(1000.0 * diagram.rms_radius[f, c, k], 3)} µm   "
                    f"GEO {significant(1000.0 * diagram.geo[f, c, k], 3)} µm   "
                    f"Airy {significant(1000.0 * diagram.airy_radius[f, c].mean(), 3)} µm")
    lost = int(rays.lost[f].sum())
    if lost:
        said.append(f"{lost} of {int(rays.launched[f].sum())} rays vignetted")
    return [*made, Area(*cell, "\n".join(said))]


def _table(diagram: Spots) -> Table:
    head = ("field (mm)", "field (deg)", "film shift (mm)", "wavelength (um)", "rms sagittal (um)",
            "rms tangential (um)", "rms radius (um)", "geo radius (um)", "Airy radius (um)", "rays vignetted", "rays")

    def rows() -> Iterator[tuple]:
        rays = diagram.rays
        for f, height in enumerate(rays.image_heights):
            for k, shift in enumerate(diagram.shifts):
                for c, line in enumerate(rays.conditions.wavelengths):
                    yield (height, math.degrees(rays.field_angles[f]), shift, line, *(1000.0 * diagram.rms[f, c, k]),
                           1000.0 * diagram.rms_radius[f, c, k], 1000.0 * diagram.geo[f, c, k],
                           1000.0 * diagram.airy_radius[f, c].mean(), rays.lost[f, c], rays.launched[f, c])

    return Table(head, rows)


NEAR = 0.03                     # of a cell: greatest distance from the cursor to the mark that it chooses

Key = tuple[int, float, float, float]


def nearest_ray(plot: Plot, x: float, y: float) -> Key | None:
    """Field, wavelength (µm) and two pupil coordinates of the ray at a point (x, y) of a spot diagram or of a ray fan.

    In a spot diagram, the ray of the mark at the point; in a fan, that of the curve nearest to y, at the pupil
    coordinate nearest to x. None where no mark or curve is near.
    """
    best, ray = NEAR, None
    for layer in plot.layers:
        if not isinstance(layer, Points | Curve) or layer.rays is None:
            continue
        if isinstance(layer, Points):
            away = np.hypot(layer.x - x, layer.y - y)
        else:
            nearest = np.abs(layer.x - x) <= np.abs(layer.x - x).min(initial=math.inf)
            away = np.where(nearest & np.isfinite(layer.rays[:, 2:]).all(1) & np.isfinite(layer.y),
                            NEAR * np.abs(layer.y - y) / (plot.y.high - plot.y.low), math.inf)
        i = int(away.argmin()) if away.size else 0
        if away.size and away[i] < best:
            best, ray = float(away[i]), layer.rays[i].tolist()
    return None if ray is None else (int(ray[0]), ray[1], ray[2], ray[3])


@lru_cache(maxsize=8)
def pointed_ray(settings: Settings, points: int, key: Key) -> PointedRay:
    """The ray of a key of `nearest_ray`; points: of the grid across the pupil. ValueError or OSError without rays."""
    asked, (f, line, s, t) = query(settings), key
    if line not in asked.conditions().wavelengths:      # of a figure of single wavelengths
        asked = asked.lines
    rays = asked.grid(points)
    of_fields = np.ones((len(rays.images), 1))
    entrance = rays.beams.towards_scene(s * of_fields, t * of_fields)[0][f]
    start = rays.beams.starts(np.array([f]), entrance)
    lens, away = asked.lens, asked.bench.film_distance
    film_z = lens.length + away
    traced = lb.trace(lens, start[:3].T + [0.0, 0.0, film_z], start[3:6].T, line, record=True, forward=True)
    assert traced.paths is not None
    name = f"{field_label(rays, f)}, {wavelength_name(line)}"
    surface = int(blockers(lens, traced, forward=True)[0])
    if surface >= 0:
        met = traced.paths[0, 1:][np.isfinite(traced.paths[0, 1:, 0])]
        first = met[0] if len(met) else traced.paths[0, 0]
        path = np.vstack([path_before_lens(lens, away, first, start[3:6, 0]), met])
        return PointedRay(path, surface, f"{name}: {end_text(lens, lb.Fate(int(traced.fate[0])), surface)}")
    end, direction = traced.points[0], traced.directions[0]
    film = end + (film_z - end[2]) / direction[2] * direction
    path = np.vstack([path_before_lens(lens, away, traced.paths[0, 1], start[3:6, 0]), traced.paths[0, 1:], film])
    landed = landing(settings, path)
    return PointedRay(path, -1, f"{name}: {landed.text}", landed.point, landed.raster)
