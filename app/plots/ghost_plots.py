"""Ghosts of a light in the field: their discs on the film, ranked by brightness, and the path of one of them."""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.coating import coating
from lensbench.app.plots.plot import Area, Axis, Curve, Figure, Plot, Points, Table
from lensbench.app.plots.query import Query
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.ghost_ranking import light_place
from lensbench.core.optics.coatings import COATINGS
from lensbench.core.text import significant, true_minus

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
