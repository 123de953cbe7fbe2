"""Plots of points of light: the bokeh gallery, the sunstar of the blades, and the ghosts of a light in the field."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import coating
from lensbench.app.bench.tone import round_above
from lensbench.app.plots.plot import Area, Axis, Curve, Figure, Label, Map, Plot, Points, Table, reach
from lensbench.app.plots.query import Query, ended_marks, ends_within_stop
from lensbench.app.plots.spots import AXIS, field_label
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.analysis.blade_star import Sunstar, sunstar
from lensbench.core.analysis.ghost_ranking import light_place
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.lens_defects import rippled
from lensbench.core.analysis.point_spread import PointSpread, psf
from lensbench.core.analysis.spot_diagram import spots
from lensbench.core.optics.coatings import COATINGS
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens, refracts
from lensbench.core.text import significant, true_minus

BOKEH_FIELDS = (0.0, 0.5, 0.8, 1.0)
AWAY = (0.6, 1.0, 1.6, math.inf)        # × the focus distance
SHADE = 0.48                            # half a picture, of its cell
NAMES = 0.7                             # cells left of the pictures, for the names of the fields
SPOT_RADII, AIRY_RADII = 1.15, 2.0      # to the edge of a picture, at the least
STRAY = 3.0                             # rms radii from the centroid, beyond which rays are too few to count
BAR = 0.05                              # of a cell, from the lowest one to the scale bar
BOKEH_DECADES = 4.0                           # of the logarithmic view
RINGS = 96                              # samples across a picture with onion rings, at the least


class Ripple(NamedTuple):
    """Rings that the tool left on a surface: its index, the period (mm) and the height from trough to crest (mm)."""

    surface: int
    period: float
    height: float


def bokeh_figure(query: Query, points: int, view: str = "linear", ripple: Ripple | None = None) -> Figure:
    """Pictures of points at four distances (across) and four fields (down), each as bright as its brightest place.

    The fields are those that the query chooses, if it does. A distance that the lens does not image has no pictures.
    view: "linear", or "log" over four decades. ripple: of one surface, whose rings show in the pictures. LensError
    where no light of any distance reaches the film, and for an impossible ripple.
    """
    built, samples = query.bench, max(points, 32 if ripple is None else RINGS)
    heights = query.few(*BOKEH_FIELDS)
    layers: list = []
    rows: list[tuple] = []
    distances = [query.focus_distance * factor for factor in AWAY] if math.isfinite(query.focus_distance) else \
        [20.0 * built.first_order.efl * step for step in (1.0, 3.0, 10.0)] + [math.inf]
    rays, refused = None, dict[str, LensError]()
    for column, distance in enumerate(distances):
        away = distance - built.film_z if math.isfinite(distance) else math.inf
        if not away > 0.0:
            layers.append(Label(column, 0.0, "in the lens", "dim", "middle"))
            continue
        there = replace(query, object_distance=away, focus_distance=distance)
        in_focus = distance == query.focus_distance
        layers.append(Label(column, 0.5, format_distance(distance), "amber" if in_focus else "text", "above"))
        try:
            rays = there.grid(max(points, 24), heights)
        except LensError as error:
            refused[format_distance(distance)] = error
            layers.append(Label(column, 0.0, "no image", "dim", "middle"))
            continue
        rays = rays if ripple is None else rippled(rays, *ripple)
        side = _side(rays)
        spread, width = psf(rays, samples, side), 1000.0 * side
        layers += _scale_bar(column, 0.5 - len(heights), width)
        sizes = _sizes(spread)
        for row in range(len(heights)):
            layers += _cell(spread, sizes[row], row, column, distance, view)
            rows.append((rays.image_heights[row], distance / 1000.0, width, *sizes[row].tolist(), _ended(spread, row)))
    if rays is None and refused:
        raise next(iter(refused.values()))
    edge = len(distances) - 0.5, 0.5 - len(heights)
    plot = Plot(Axis(None, -0.5 - NAMES, edge[0] + 0.02), Axis(None, edge[1] - 0.36, 0.72), tuple(layers), equal=True)
    head = ("field (mm)", "distance (m)", "window (um)", "rms sagittal (um)", "rms tangential (um)", "cut by surface")
    words = query.words(rays, "one scale a column", "log, 4 decades" if view == "log" else "linear",
                        "waves near focus, rays far from it", *(() if ripple is None else (_ripple_words(ripple),)))
    remarks = (*(f"{distance_text}: {error}" for distance_text, error in refused.items()),
               *(query.remarks(rays) if rays is not None else ()))
    return Figure("Bokeh", ((plot,),), Table(head, tuple(rows)), words, remarks)


def _ripple_words(ripple: Ripple) -> str:
    return (f"ripple of surface {ripple.surface}: every {significant(ripple.period)} mm, "
            f"{significant(1e6 * ripple.height)} nm high")


def ripple_surface(lens: Lens) -> int:
    """The surface that a ripple is most likely on: the largest asphere, else the largest surface that refracts."""
    able = [i for i in range(len(lens.surfaces)) if refracts(lens, i)]
    aspheres = [i for i in able if lens.surfaces[i].conic or lens.surfaces[i].aspheric]
    return max(aspheres or able or [0], key=lambda i: lens.surfaces[i].semi_diameter)


def _side(rays: RayGrid) -> float:
    """Side (mm) of a square about each field's centroid that holds the patterns of all fields, but for faint rims."""
    spot = spots(rays, "centroid")
    blur = SPOT_RADII * np.minimum(spot.geo[:, :, 0], STRAY * spot.rms_radius[:, :, 0])
    waves = AIRY_RADII * spot.airy_radius.max(2)
    return 2.0 * float(np.nan_to_num(np.fmax(blur, waves)).max())


def _scale_bar(column: int, below: float, width: float) -> list:
    """A round length for cells `width` µm wide, under the lowest one."""
    length = round_above(0.2 * width)
    half, y = SHADE * length / width, below - BAR
    return [Curve("", np.array([column - half, column + half]), np.array([y, y]), "dim"),
            Label(column, y, f"{significant(length)} µm", "dim", "below")]


def _cell(spread: PointSpread, size: np.ndarray, row: int, column: int, distance: float, view: str) -> list:
    rays = spread.rays
    box = (column - SHADE, column + SHADE), (-row - SHADE, -row + SHADE)
    name = f"{field_label(rays, row)}, {format_distance(distance)}"
    if not rays.lit[row]:
        return [Label(column, -row, "dark", "dim", "middle"), Area(*box, f"{name}: no light reaches this field")]
    light = spread.white[row] / max(float(spread.white[row].max()), 1e-30)
    made: list = [Map("", light, *box, decades=BOKEH_DECADES if view == "log" else 0.0)]
    c, to_cell = rays.conditions.primary, SHADE / (0.5 * spread.pitch[row] * light.shape[-1])
    x, y = ((offset[row, c] - middle) * to_cell for offset, middle in
            zip((rays.offset_s, rays.offset_t), spread.centres[row], strict=True))
    inside = (np.abs(x) < SHADE) & (np.abs(y) < SHADE)
    made += ended_marks(column + x, y - row, np.where(inside, ends_within_stop(rays, row, c), -1))
    if column == 0:
        made.append(Label(column - 0.5, -row, field_label(rays, row), "text", "left middle"))
    said = [name, f"RMS {significant(size[0], 3)} µm sagittal, {significant(size[1], 3)} µm tangential",
            f"open pupil {significant(100.0 * rays.open_area[row] / rays.open_area[0], 2)} % of "
            f"{'the axis' if rays.image_heights[0] == 0.0 else field_label(rays, 0)}"]
    cut = _ended(spread, row)
    if cut:
        said.append(f"cut by the rim of surface {cut}")
    waves = float(np.nanmean(spread.diffraction[row]))
    said.append("by diffraction" if waves == 1.0 else "by rays" if waves == 0.0 else "by rays and diffraction")
    return [*made, Area(*box, "\n".join(said))]


def _sizes(spread: PointSpread) -> np.ndarray:
    """(F, 2) rms widths (µm) of the patterns in all colours, sagittal and tangential."""
    return 1000.0 * spots(spread.rays, "centroid").white_rms[:, 0]


def _ended(spread: PointSpread, row: int) -> str:
    """Numbers of the surfaces, besides the stop, whose rims cut the pattern."""
    rays = spread.rays
    ends = rays.victim[row, rays.conditions.primary]
    within = rays.stop_share[row, rays.conditions.primary] <= 1.0
    surfaces = np.unique(ends[within & (ends >= 0) & (ends != rays.lens.stop_index)])
    return ", ".join(str(int(surface)) for surface in surfaces)


STAR_FIELDS = {"axis": 0.0, "middle": 0.7}
PIXELS = 181
STAR_DECADES = 3.5
NO_BLADES = "A round stop draws no star: choose a number of blades in the popup Stop, and stop down"


def star_figure(query: Query, points: int, field: str = "axis") -> Figure:
    """Picture of the star about a small light at a field of FIELDS, and its brightness over the direction.

    LensError for a round stop, and where no light reaches the film.
    """
    lens = query.bench.lens
    if lens.iris.is_round:
        raise lb.LensError(NO_BLADES)
    on_film = query.parts(STAR_FIELDS[field])[0]
    point = (0.0, on_film) if isinstance(on_film, float) else on_film
    height = math.hypot(*point)
    star = _star(lens, query.bench.film_distance, point, points > 16)
    half = 1000.0 * float(star.radii[-1]) / math.sqrt(2.0)
    light = _picture(star, half / 1000.0)
    count, number = len(star.rays), lb.f_number_at_infinity(lens)
    blades = f"{lens.iris.blades} blades, f/{significant(number, 2)}"
    title = f"{count} rays" if count else "no rays"
    picture = Plot(Axis("x (µm)", -half, half), Axis("y (µm)", -half, half), (
        Map("of the brightest shown", light, (-half, half), (-half, half), decades=STAR_DECADES),), title, equal=True)
    degrees = np.degrees(np.append(star.azimuths, 2.0 * math.pi))
    around = np.append(star.profile, star.profile[0])
    top = reach([float(around.max())])
    layers: list = [Curve("brightness", degrees, around)]
    layers += [Area((angle - 5.0, angle + 5.0), (0.1, top), f"ray at {significant(angle, 3)}°")
               for angle in np.degrees(star.rays).tolist()]
    profile = Plot(Axis("Direction (°)", 0.0, 360.0), Axis("Brightness (× median)", 0.1, top, log=True), tuple(layers))
    words = query.words(None, blades, "a point of light at the " + ("centre" if height < AXIS else
                                                                    f"height {significant(height, 3)} mm"),
                        "white light by diffraction, 0.42 to 0.68 µm", "aberrations left out")
    table = Table(("direction (deg)", "brightness (x median)"), tuple(zip(degrees[:-1], around[:-1], strict=True)))
    return Figure("Sunstar", ((picture,), (profile,)), table, words, (), (0.7, 0.3))


@lru_cache(maxsize=8)
def _star(lens: lb.Lens, film_distance: float, point: tuple[float, float], fine: bool) -> Sunstar:
    """The star of a film point (mm); coarse ones have fewer directions and wavelengths."""
    return sunstar(lens, film_distance, point, azimuths=720 if fine else 360, colours=24 if fine else 10)


def _picture(star: Sunstar, half: float) -> np.ndarray:
    """Light (PIXELS, PIXELS) over x and y from −half to half (mm), 1 at its brightest.

    Within the innermost radius it is that of this radius.
    """
    positions = half * (2.0 * (np.arange(PIXELS) + 0.5) / PIXELS - 1.0)
    r = np.log(np.maximum(np.hypot(positions, positions[:, None]), star.radii[0]))
    steps = np.log(star.radii)
    i = np.clip((r - steps[0]) / (steps[1] - steps[0]), 0.0, len(steps) - 1.001)
    j = (np.arctan2(positions[:, None], positions) / (2.0 * math.pi) % 1.0) * len(star.azimuths)
    low, left = i.astype(int), j.astype(int) % len(star.azimuths)
    u, v, right = i - low, j - np.floor(j), (left + 1) % len(star.azimuths)
    logs = np.log(np.maximum(star.density, 1e-30))
    light = np.exp((1 - u) * ((1 - v) * logs[low, left] + v * logs[low, right])
                   + u * ((1 - v) * logs[low + 1, left] + v * logs[low + 1, right]))
    return np.asarray(light / light.max())


FIELDS = {"axis": 0.0, "middle": 0.7, "corner": 1.0, "outside": 1.3}
SHOWN = 16                      # discs on the film
DECADES = 6
WIDEST = math.radians(89.0)     # of a light from the axis
Key = tuple[int, int]           # surfaces that reflect, the one nearer to the scene first


def ghosts_figure(query: Query, points: int, field: str = "corner", coating: str = "") -> Figure:
    """Discs of the brightest ghosts on the film, and the brightness of all by rank.

    field: a key of FIELDS, a part of the angle to the corner. coating: a key of COATINGS; "": by the lens's year.
    LensError where no light of the field reaches the film.
    """
    query, name = query.lines, coating or usual_coating(query.lens)
    way = field_direction(query, field)
    ghosts = _ghosts(query.lens, query.bench.film_distance, way, query.conditions().primary_wavelength, name,
                    31 if points > 16 else 21)
    if not any(row.share > 0.0 for row in ghosts.rows) and not ghosts.direct > 0.0:
        raise lb.LensError("no light of this field reaches the film, directly or by a ghost" + (
            ": choose one nearer to the centre" if FIELDS[field] else ""))
    film = query.bench.film
    bright = [row for row in ghosts.rows if row.share > 0.0]
    half_x, half_y = 0.5 * film.width, 0.5 * film.height
    layers: list = [Curve.through("", np.array([[-half_x, -half_y], [half_x, -half_y], [half_x, half_y],
                                                [-half_x, half_y], [-half_x, -half_y]]), "dim", weight=1.0)]
    around = np.linspace(0.0, 2.0 * math.pi, 73)
    for rank, row in enumerate(bright[:SHOWN]):
        # As the picture shows it: upright, the film being upside down
        half = 0.5 * row.diameter
        x, y = half * np.cos(around) - row.centre[0], half * np.sin(around) - row.centre[1]
        layers.append(Curve("", x, y, "strong" if rank < 3 else "faint", weight=2.0 if rank < 3 else 1.0))
    discs = Plot(Axis("x in the picture (mm)", -1.1 * half_x, 1.1 * half_x),
                 Axis("y in the picture (mm)", -1.1 * half_y, 1.1 * half_y), tuple(layers), equal=True)
    values = np.array([row.brightness for row in bright])
    known = values[np.isfinite(values) & (values > 0.0)]
    top = math.ceil(math.log10(known.max())) if known.size else 0.0
    low = top - DECADES
    heights = np.log10(np.clip(values, 10.0**low, 10.0**top))
    ranks = np.arange(1.0, len(bright) + 1.0)
    marks: list = [Points("", ranks, heights, "strong", "square")]
    marks += [Area((rank - 0.5, rank + 0.5), (low, top), _words(row)) for rank, row in zip(ranks, bright, strict=True)]
    order = Plot(Axis("Rank", 0.4, max(len(bright), 1) + 0.6, whole=len(bright)),
                 Axis("Brightness (log10 1/mm²)", low, top), tuple(marks))
    angle = math.atan(math.hypot(math.tan(way[0]), math.tan(way[1])))
    where = f"field {significant(math.degrees(angle), 3)}°" + (", towards the lower left corner" if way[0] else "")
    words = query.words(None, where, query.primary_alone, f"coating {name}",
                        "brightness: light per mm² of the film, for 1 of the direct light")
    dark = () if ghosts.direct > 0.0 else ("no light of this field reaches the film directly: shares are not known",)
    total = significant(100.0 * ghosts.total, 3)
    if not query.lens.is_rotationally_symmetric:
        dark = (*dark, f"no paraxial figures: the lens has {query.lens.asymmetry}")
    remarks = (*dark, f"{len(bright)} of {len(ghosts.rows)} pairs reach the plane of the film, with {total} % of the "
                      "direct light")
    head = ("surfaces", "brightness (1/mm2)", "light (of direct)", "size (mm)", "x (mm)", "y (mm)",
            "focus behind film (mm)", "paraxial size on axis (mm)", "paraxial light on axis")
    rows = tuple((f"{row.first}-{row.second}", row.brightness, row.share, row.diameter, -row.centre[0],
                  -row.centre[1], row.focus, row.paraxial_diameter, row.paraxial_share) for row in ghosts.rows)
    return Figure("Ghosts", ((discs, order),), Table(head, rows), words, remarks)


def usual_coating(lens: lb.Lens) -> str:
    """The coating of a lens by its year, a key of COATINGS."""
    return coating(Settings(), lens).name


def field_direction(query: Query, field: str) -> tuple[float, float]:
    """Angles of a distant light from the axis, across to the right and up (radians).

    It lies at a part of the angle to the last field: upward, for a lens without rotational symmetry towards that field,
    the lower left corner of the picture.
    """
    angles = query.grid(8).angles
    known = angles[np.isfinite(angles).all(1)]
    if not known.size:
        raise lb.LensError("no light reaches the film")
    angle = float(np.hypot(*known[-1]))
    away = min(FIELDS[field] * angle, WIDEST)
    if query.lens.is_rotationally_symmetric or angle == 0.0:
        return 0.0, away
    x, y = math.tan(away) * known[-1] / angle
    return -math.atan(x), -math.atan(y)                 # of where the light comes from


@lru_cache(maxsize=32)
def _ghosts(lens: lb.Lens, film_distance: float, way: tuple[float, float], wavelength: float, coating: str,
            cells: int) -> lb.analysis.Ghosts:
    return lb.analysis.ghosts(lens, film_distance, (*way, math.inf), wavelength, COATINGS[coating], cells)


@lru_cache(maxsize=64)
def ghost_ray(query: Query, field: str, pair: Key) -> np.ndarray | None:
    """Path (n, 3) of the ray through the middle of the light of a ghost, to the film; mm, lens frame. None: no ray."""
    from lensbench.core.cameras.film_landing import landing_step
    from lensbench.core.kernels.block import lane_buffer
    from lensbench.core.optics.ghost_grid import SCAN, entrance_grid, grid_rays, pair_boxes
    from lensbench.core.optics.ghost_path import ghost_path
    from lensbench.core.optics.ghost_trace import GhostTracer

    query = query.lines
    lens, distance, wavelength = query.lens, query.bench.film_distance, query.conditions().primary_wavelength
    tracer = GhostTracer(lens, distance, [landing_step(lb.Film(2.0, 2.0, 2, 2), 1.0)], wavelength, real=np.float64)
    light, lanes = light_place(lens, distance, (*field_direction(query, field), math.inf)), lane_buffer(np.float64)
    boxes = pair_boxes(tracer, lanes, light, pair)
    if not boxes:
        return None
    grids = [(entrance_grid(tracer, lanes, light, pair, box, SCAN), grid_rays(tracer, light, box, SCAN))
             for box in boxes]
    cells, rays = max(grids, key=lambda grid: grid[0][2].sum())         # of the island with the most light
    lit = np.nonzero(cells[2] > 0.0)[0]
    if not lit.size:
        return None
    points = rays[:3, lit]
    best = lit[int(((points - points.mean(1, keepdims=True))**2).sum(0).argmin())]
    start = rays[:3, best] - [0.0, 0.0, tracer.front_z] - 0.6 * (lens.length + distance) * rays[3:6, best]
    path = ghost_path(lens, pair, start, rays[3:6, best], wavelength)
    way = (lens.length + distance - path.points[-1, 2]) / path.direction[2]
    return np.vstack([path.points, path.points[-1] + way * path.direction])


def raster_of(settings: Settings, path: np.ndarray) -> tuple[float, float]:
    """Where the picture (pixels) shows the end of a path (n, 3) on the film, which may be tilted or decentred.

    path: to the plane of a centred film; mm, lens frame.
    """
    film, along = settings.film, path[-1] - path[-2]
    x, y = settings.film_pose.film_points(path[-1:, :2], along[None, :2] / along[2])[0].tolist()
    return film.pixels_x * (0.5 - x / film.width), film.pixels_y * (0.5 + y / film.height)


def _words(row: lb.analysis.Ghost) -> str:
    focus = ("not known" if math.isnan(row.focus) else "parallel" if math.isinf(row.focus) else
             f"{significant(abs(row.focus), 3)} mm {'behind' if row.focus > 0.0 else 'before'} the film")
    return "\n".join((f"surfaces {row.first} and {row.second}",
                      f"light   {significant(100.0 * row.share, 3)} % of the direct light",
                      f"size   {significant(row.diameter, 3)} mm",
                      true_minus(f"at   {significant(-row.centre[0], 3)}, {significant(-row.centre[1], 3)} mm"),
                      f"in focus   {focus}"))
