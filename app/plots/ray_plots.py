"""Plots of rays: ray fans, OPD fans, and distortion as the image of a square grid."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Setup
from lensbench.app.plots.plot import SOLID, Area, Axis, Curve, Figure, Plot, Table, dash_of, reach, wavelength_name
from lensbench.app.plots.query import Query, largest_height
from lensbench.app.plots.spots import chosen_fields, field_label
from lensbench.core.analysis.distortion import RECTILINEAR, Distortion
from lensbench.core.analysis.spot_diagram import Fans, ray_fans
from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import fixed, significant, true_minus

KINDS = {"ray": "Transverse (µm)", "opd": "Path difference (waves)"}
DIRECTIONS = ("sagittal", "tangential")         # the second axis of `Fans`


def fans_figure(query: Query, points: int, kind: str = "ray", rows: int = 3) -> Figure:
    """Fans of `rows` fields, tangential at the left and sagittal at the right; kind: a key of KINDS.

    The fields are those that the query chooses, if it does. All plots have one scale. LensError as `Query.grid`.
    """
    query = query.lines
    rays = query.grid(16, query.heights or None)
    fans = ray_fans(rays, 2 * points + 1)
    values = 1000.0 * fans.transverse if kind == "ray" else fans.waves
    fields = chosen_fields(len(rays.images), len(query.heights) or rows)
    seen = np.where(fans.passed, values, np.nan)[fields]
    limit = reach(seen[np.isfinite(seen)], 1.0 if kind == "ray" else 0.05)
    plots = tuple((_plot(fans, values, f, 1, limit, kind), _plot(fans, values, f, 0, limit, kind)) for f in fields)
    words = query.words(None, "from the chief ray of the primary wavelength", f"{len(fans.heights)} rays a fan",
                        "x: height in the stop over its radius")
    return Figure("Ray fans" if kind == "ray" else "OPD fans", plots, _table(fans), words,
                  (*query.remarks(rays), *query.open_stop), points=rays.opd.shape[-1])


def _plot(fans: Fans, values: np.ndarray, f: int, fan: int, limit: float, kind: str) -> Plot:
    given, rays = fans.rays.conditions, fans.rays
    layers = [Curve("", np.array([-1.0, 1.0]), np.zeros(2), "faint", weight=1.0),
              Curve("", np.zeros(2), np.array([-limit, limit]), "faint", weight=1.0)]
    lost = fans.victim[f, fan] >= 0

    def which(c: int) -> np.ndarray:
        """(K, 4) the rays of a wavelength, as of Curve."""
        return np.column_stack([np.full((len(fans.heights), 2), (f, given.wavelengths[c])), fans.pupil[f, fan]])

    for c in range(len(given.wavelengths)):
        beyond = lost[c] | np.roll(lost[c], 1) | np.roll(lost[c], -1)       # one ray more, so that the parts meet
        layers.append(Curve("vignetted" if beyond.any() else "", fans.heights,
                            np.where(beyond, values[f, fan, c], np.nan), "faint", SOLID, 1.0, rays=which(c)))
    for c, line in enumerate(given.wavelengths):
        layers.append(Curve(wavelength_name(line), fans.heights,
                            np.where(fans.passed[f, fan, c], values[f, fan, c], np.nan), line,
                            dash_of(c, given.primary), rays=which(c)))
    ends = fans.victim[f, fan, given.primary]
    for surface in np.unique(ends[ends >= 0]).tolist():
        here = np.where(ends == surface, values[f, fan, given.primary], np.nan)
        layers.append(Curve("", fans.heights, here, "dead", SOLID, 3.0, surface=surface))
    unit = "µm" if kind == "ray" else "waves"
    title = f"{field_label(rays, f)} {DIRECTIONS[fan][0].upper()}" + (f", {unit}" if rays.lit[f] else ": dark")
    ended = int((lost[given.primary] & (fans.victim[f, fan, given.primary] != rays.lens.stop_index)).sum())
    if ended and rays.lit[f]:
        title += f"  {ended} lost"
    return Plot(Axis("Height in the stop", -1.0, 1.0), Axis(KINDS[kind], -limit, limit), tuple(layers), title)


def _table(fans: Fans) -> Table:
    head = ("field (mm)", "field (deg)", "fan", "wavelength (um)", "height in the stop", "transverse (um)",
            "path difference (waves)", "ended by surface")

    def rows() -> Iterator[tuple]:
        rays, transverse, waves = fans.rays, 1000.0 * fans.transverse, fans.waves
        degrees = np.degrees(rays.field_angles)
        for f, height in enumerate(rays.image_heights):
            for fan, name in enumerate(DIRECTIONS):
                for c, line in enumerate(rays.conditions.wavelengths):
                    for k, at in enumerate(fans.heights):
                        victim = int(fans.victim[f, fan, c, k])
                        yield (height, degrees[f], name, line, at, transverse[f, fan, c, k], waves[f, fan, c, k],
                               str(victim) if victim >= 0 else "")

    return Table(head, rows)


LINES = 9                       # along the shorter side of the film
STEPS = 4                       # points from one crossing to the next, between which a line is straight
RADII = 49
DARK = 16                       # points across the pupil that find out whether there is light
TITLE = 0.2                     # of half the height, above the grid
WIDE = math.radians(55.0)       # from the axis: a wider lens is compared with a fisheye projection


def film_distortion(built: Setup, wavelength: float = D_LINE) -> Distortion:
    """Distortion over the radii of the film, of a very wide lens against the fisheye projection that it follows best.

    LensError for a lens without rotational symmetry, and for an afocal one.
    """
    radii = np.linspace(0.0, 0.5 * built.film.diagonal, RADII)
    found = lb.distortion(built.lens, built.film_distance, radii, RECTILINEAR, wavelength)
    if np.isfinite(found.angles).any() and np.nanmax(found.angles) > WIDE:
        return lb.distortion(built.lens, built.film_distance, radii, "best", wavelength)
    return found


def distortion_words(shape: Distortion) -> str:
    """The kind of the distortion, its largest value, and the projection that it is measured against."""
    percent = shape.percent[np.isfinite(shape.percent)]
    largest = float(percent[np.argmax(np.abs(percent))]) if percent.size else 0.0
    kind = "No distortion" if shape.kind == "none" else true_minus(
        f"{shape.kind.capitalize()} {significant(largest, 2, signed=True)} %")
    against = "f tan θ" if shape.projection == RECTILINEAR else \
        f"{shape.projection}, f {fixed(shape.focal_length, 1)} mm"
    return f"{kind} against {against}"


def grid_plot(built: Setup, wavelength: float = D_LINE) -> tuple[Plot, np.ndarray, np.ndarray]:
    """The plot, and the ideal and the real crossings (rows, columns, 2), mm in the picture: upright, y up.

    The grid has the shape of the film, and fills it or the image circle if that is smaller.

    LensError as `film_distortion`, but for a lens without rotational symmetry.
    """
    projection, title = RECTILINEAR, ""
    if built.lens.is_rotationally_symmetric:
        shape = film_distortion(built, wavelength)
        projection, title = shape.projection, distortion_words(shape)
    part = largest_height(built) / (0.5 * built.film.diagonal)
    film = replace(built.film, width=part * built.film.width, height=part * built.film.height)
    ideal, real = (-each for each in lb.distortion_grid(built.lens, built.film_distance, film, LINES, projection,
                                                        wavelength, STEPS))
    layers: list = [_lines("square grid", ideal, "faint", 1.0), _lines("its image", real, "strong", 1.4)]
    ideal, real = ideal[::STEPS, ::STEPS], real[::STEPS, ::STEPS]
    ends = [np.concatenate([[-math.inf], 0.5 * (at[1:] + at[:-1]), [math.inf]])
            for at in (np.sort(ideal[0, :, 0]), np.sort(ideal[:, 0, 1]))]
    for wanted, found in zip(ideal.reshape(-1, 2), real.reshape(-1, 2), strict=True):
        (x0, x1), (y0, y1) = ((float(each[k]), float(each[k + 1])) for each, k in zip(
            ends, (int(np.searchsorted(each, at)) - 1 for each, at in zip(ends, wanted, strict=True)), strict=True))
        layers.append(Area((x0, x1), (y0, y1), _said(wanted, found)))
    reach = 1.04 * np.nanmax(np.abs(np.concatenate([ideal, real])).reshape(-1, 2), 0)
    across, up = (float(each) for each in reach)
    top = up * (1.0 + (TITLE if title else 0.0))
    return Plot(Axis("x in the picture (mm)", -across, across), Axis("y in the picture (mm)", -up, top),
                tuple(layers), title, equal=True), ideal, real


def grid_figure(query: Query, points: int) -> Figure:
    """The image of a square grid that covers the film, or the image circle.

    LensError for an afocal lens, and where no light reaches the film.
    """
    query = query.lines
    given = query.grid(min(points, DARK)).conditions            # LensError without light: chief rays pass all rims
    plot, ideal, real = grid_plot(query.setup, given.primary_wavelength)
    every = query.lens.is_rotationally_symmetric
    words = query.words(None, query.primary_alone,
                        "chief rays" if every else "chief rays against f tan θ of each direction",
                        f"{ideal.shape[1]} × {ideal.shape[0]} crossings")
    dark = int(np.isnan(real[..., 0]).sum())
    remarks = []
    if query.largest_height < 0.5 * query.setup.film.diagonal:
        remarks.append(f"the grid ends at the edge of light, {significant(query.largest_height, 3)} mm from the centre")
    if dark:
        remarks.append(f"no light reaches {dark} of {real[..., 0].size} crossings: they are left out")
    head = ("ideal x (mm)", "ideal y (mm)", "image x (mm)", "image y (mm)")
    return Figure("Distortion grid", ((plot,),), Table(head, lambda: (
        (*map(float, a), *map(float, b)) for a, b in zip(ideal.reshape(-1, 2), real.reshape(-1, 2), strict=True))),
        words, tuple(remarks))


def _lines(name: str, points: np.ndarray, tint: str, weight: float) -> Curve:
    """The rows and columns of a grid as one curve with gaps."""
    gap = np.full((1, 2), math.nan)
    runs = [run for way in (points[::STEPS], points.transpose(1, 0, 2)[::STEPS]) for line in way for run in (line, gap)]
    return Curve.through(name, np.concatenate(runs), tint, weight=weight)


def _said(wanted: np.ndarray, found: np.ndarray) -> str:
    """A crossing in words."""
    place, image = (true_minus(f"({fixed(float(at[0]), 2)}, {fixed(float(at[1]), 2)}) mm") for at in (wanted, found))
    if np.isnan(found).any():
        return f"crossing {place}\nno light reaches it"
    moved = found - wanted
    apart = float(np.hypot(*moved))
    radius = float(np.hypot(*wanted))
    part = f", {significant(100.0 * apart / radius, 2)} % of the radius" if radius > 0.0 else ""
    return f"crossing {place}\nits image {image}\nmoved by {significant(1000.0 * apart, 3)} µm{part}"
