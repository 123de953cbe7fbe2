"""Plots of rays and aberrations: fans, the image of a square grid, Seidel sums of each surface, and the wavefront."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Bench
from lensbench.app.plots.plot import (
    SOLID, Area, Axis, Bars, Curve, Figure, Label, Map, Plot, Table, dash_of, reach, wavelength_name
)
from lensbench.app.plots.query import Query, ended_marks, ends_within_stop, largest_height
from lensbench.app.plots.spots import chosen_fields, field_label
from lensbench.core.analysis.aberrations import seidel
from lensbench.core.analysis.chief_ray_curves import RECTILINEAR, Distortion
from lensbench.core.analysis.spot_diagram import Fans, ray_fans
from lensbench.core.analysis.wavefront import fringe_index, noll_indices, wavefronts, zernike_name
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
    passing = np.where(fans.passed, values, np.nan)[fields]
    limit = reach(passing[np.isfinite(passing)], 1.0 if kind == "ray" else 0.05)
    plots = tuple((_plot(fans, values, f, 1, limit, kind), _plot(fans, values, f, 0, limit, kind)) for f in fields)
    words = query.words(None, "from the chief ray of the primary wavelength", f"{len(fans.heights)} rays a fan",
                        "x: height in the stop over its radius")
    return Figure("Ray fans" if kind == "ray" else "OPD fans", plots, _table(fans), words,
                  (*query.remarks(rays), *query.open_stop), points=rays.opd.shape[-1])


def _plot(fans: Fans, values: np.ndarray, f: int, fan: int, limit: float, kind: str) -> Plot:
    conditions, rays = fans.rays.conditions, fans.rays
    layers = [Curve.straight((-1.0, 1.0), (0.0, 0.0), "faint"),
              Curve.straight((0.0, 0.0), (-limit, limit), "faint")]
    lost = fans.victim[f, fan] >= 0

    def which(c: int) -> np.ndarray:
        """(K, 4) the rays of a wavelength, as of Curve."""
        return np.column_stack([np.full((len(fans.heights), 2), (f, conditions.wavelengths[c])), fans.pupil[f, fan]])

    for c in range(len(conditions.wavelengths)):
        beyond = lost[c] | np.roll(lost[c], 1) | np.roll(lost[c], -1)       # one ray more, so that the parts meet
        layers.append(Curve("vignetted" if beyond.any() else "", fans.heights,
                            np.where(beyond, values[f, fan, c], np.nan), "faint", SOLID, 1.0, rays=which(c)))
    for c, line in enumerate(conditions.wavelengths):
        layers.append(Curve(wavelength_name(line), fans.heights,
                            np.where(fans.passed[f, fan, c], values[f, fan, c], np.nan), line,
                            dash_of(c, conditions.primary), rays=which(c)))
    ends = fans.victim[f, fan, conditions.primary]
    for surface in np.unique(ends[ends >= 0]).tolist():
        blocked = np.where(ends == surface, values[f, fan, conditions.primary], np.nan)
        layers.append(Curve("", fans.heights, blocked, "dead", SOLID, 3.0, surface=surface))
    unit = "µm" if kind == "ray" else "waves"
    title = f"{field_label(rays, f)} {DIRECTIONS[fan][0].upper()}" + (f", {unit}" if rays.lit[f] else ": dark")
    ended = int((lost[conditions.primary] & (fans.victim[f, fan, conditions.primary] != rays.lens.stop_index)).sum())
    if ended and rays.lit[f]:
        title += f"  {ended} blocked"
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
                    for k, pupil_y in enumerate(fans.heights):
                        victim = int(fans.victim[f, fan, c, k])
                        yield (height, degrees[f], name, line, pupil_y, transverse[f, fan, c, k], waves[f, fan, c, k],
                               str(victim) if victim >= 0 else "")

    return Table(head, rows)


LINES = 9                       # along the shorter side of the film
STEPS = 4                       # points from one crossing to the next, between which a line is straight
RADII = 49
DARK = 16                       # points across the pupil that find out whether there is light
TITLE = 0.2                     # of half the height, above the grid
WIDE = math.radians(55.0)       # from the axis: a wider lens is compared with a fisheye projection


def film_distortion(built: Bench, wavelength: float = D_LINE) -> Distortion:
    """Distortion over the radii of the film, of a very wide lens against the fisheye projection that it follows best.

    LensError for a lens without rotational symmetry, and for an afocal one.
    """
    radii = np.linspace(0.0, 0.5 * built.film.diagonal, RADII)
    shape = lb.distortion(built.lens, built.film_distance, radii, RECTILINEAR, wavelength)
    if np.isfinite(shape.angles).any() and np.nanmax(shape.angles) > WIDE:
        return lb.distortion(built.lens, built.film_distance, radii, "best", wavelength)
    return shape


def distortion_words(shape: Distortion) -> str:
    """The kind of the distortion, its largest value, and the projection that it is measured against."""
    percent = shape.percent[np.isfinite(shape.percent)]
    largest = float(percent[np.argmax(np.abs(percent))]) if percent.size else 0.0
    kind = "No distortion" if shape.kind == "none" else true_minus(
        f"{shape.kind.capitalize()} {significant(largest, 2, signed=True)} %")
    against = "f tan θ" if shape.projection == RECTILINEAR else \
        f"{shape.projection}, f {fixed(shape.focal_length, 1)} mm"
    return f"{kind} against {against}"


def grid_plot(built: Bench, wavelength: float = D_LINE) -> tuple[Plot, np.ndarray, np.ndarray]:
    """The plot, and the ideal and the real crossings (rows, columns, 2), mm in the picture: upright, y up.

    The grid has the shape of the film, and fills it or the image circle if that is smaller.

    LensError as `film_distortion`, but for a lens without rotational symmetry.
    """
    projection, title = RECTILINEAR, ""
    if built.lens.is_rotationally_symmetric:
        shape = film_distortion(built, wavelength)
        projection, title = shape.projection, distortion_words(shape)
    share = largest_height(built) / (0.5 * built.film.diagonal)
    film = replace(built.film, width=share * built.film.width, height=share * built.film.height)
    ideal, real = (-values for values in lb.distortion_grid(built.lens, built.film_distance, film, LINES, projection,
                                                        wavelength, STEPS))
    layers: list = [_lines("square grid", ideal, "faint", 1.0), _lines("its image", real, "strong", 1.4)]
    ideal, real = ideal[::STEPS, ::STEPS], real[::STEPS, ::STEPS]
    ends = [np.concatenate([[-math.inf], 0.5 * (x[1:] + x[:-1]), [math.inf]])
            for x in (np.sort(ideal[0, :, 0]), np.sort(ideal[:, 0, 1]))]
    for ideal_xy, real_xy in zip(ideal.reshape(-1, 2), real.reshape(-1, 2), strict=True):
        (x0, x1), (y0, y1) = ((float(values[k]), float(values[k + 1])) for values, k in zip(
            ends, (int(np.searchsorted(values, x)) - 1 for values, x in zip(ends, ideal_xy, strict=True)), strict=True))
        layers.append(Area((x0, x1), (y0, y1), _said(ideal_xy, real_xy)))
    reach = 1.04 * np.nanmax(np.abs(np.concatenate([ideal, real])).reshape(-1, 2), 0)
    across, up = (float(values) for values in reach)
    top = up * (1.0 + (TITLE if title else 0.0))
    return Plot(Axis("x in the picture (mm)", -across, across), Axis("y in the picture (mm)", -up, top),
                tuple(layers), title, equal=True), ideal, real


def grid_figure(query: Query, points: int) -> Figure:
    """The image of a square grid that covers the film, or the image circle.

    LensError for an afocal lens, and where no light reaches the film.
    """
    query = query.lines
    conditions = query.grid(min(points, DARK)).conditions            # LensError without light: chief rays pass all rims
    plot, ideal, real = grid_plot(query.bench, conditions.primary_wavelength)
    every = query.lens.is_rotationally_symmetric
    words = query.words(None, query.primary_alone,
                        "chief rays" if every else "chief rays against f tan θ of each direction",
                        f"{ideal.shape[1]} × {ideal.shape[0]} crossings")
    dark = int(np.isnan(real[..., 0]).sum())
    remarks = []
    if query.largest_height < 0.5 * query.bench.film.diagonal:
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


def _said(ideal: np.ndarray, real: np.ndarray) -> str:
    """A crossing in words."""
    crossing, image = (true_minus(f"({fixed(float(xy[0]), 2)}, {fixed(float(xy[1]), 2)}) mm") for xy in (ideal, real))
    if np.isnan(real).any():
        return f"crossing {crossing}\nno light reaches it"
    moved = real - ideal
    apart = float(np.hypot(*moved))
    radius = float(np.hypot(*ideal))
    share = f", {significant(100.0 * apart / radius, 2)} % of the radius" if radius > 0.0 else ""
    return f"crossing {crossing}\nits image {image}\nmoved by {significant(1000.0 * apart, 3)} µm{share}"


NAMES = ("spherical", "coma", "astigmatism", "Petzval", "distortion")
COLOURS = ("axial colour", "lateral colour")
TINTS = ("chart2", "chart3", "chart0", "chart1", "chart4", "chart5", "chart7")
WIDEST = math.radians(45.0)     # field of the sums: those of the third order grow with its tangent beyond any use
BAR = 0.12                      # wide, of the distance between two surfaces


def seidel_figure(query: Query, points: int) -> Figure:
    """Bars of S_I to S_V, and of the two colours where the dispersion is known, for an object at infinity.

    LensError for a lens that has no Seidel sums.
    """
    query = query.lines
    rays = query.grid(points)
    lit = rays.field_angles[np.isfinite(rays.field_angles)]
    angle, conditions = min(float(lit[-1]), WIDEST), rays.conditions
    pair = (min(conditions.wavelengths), max(conditions.wavelengths)) if len(conditions.wavelengths) > 1 else None
    sums = seidel(query.lens, angle, wavelength=conditions.primary_wavelength, colour=pair)
    columns = [1000.0 * column for column in sums.surfaces.T]
    names = list(NAMES)
    if sums.axial_colour is not None and sums.lateral_colour is not None:
        columns += [1000.0 * sums.axial_colour, 1000.0 * sums.lateral_colour]
        names += COLOURS
    values = np.column_stack(columns)
    total, count = values.sum(0), len(values)
    shown = np.vstack([values, total])
    positions = np.append(np.arange(float(count)), count + 0.6)
    limit = 1.1 * reach(shown)
    layers: list = [Curve.straight((-1.0, count + 1.2), (0.0, 0.0), "faint"),
                    Curve.straight((count - 0.2, count - 0.2), (-limit, limit), "faint")]
    layers += [Bars("", positions[[i, i]], np.array([limit, -limit]), 0.96, "grid", surface=i) for i in range(count)]
    middle = 0.5 * (len(names) - 1)
    for k, name in enumerate(names):
        bars = positions + BAR * (k - middle)
        layers += [Bars(name, bars[group], shown[group, k], BAR, TINTS[k])
                   for group in (slice(count), slice(count, None))]
    for i, row in enumerate(shown):
        title = f"surface {i}" if i < count else "sum of all surfaces"
        lines = (true_minus(f"{name}   {significant(value, 3)} µm") for name, value in zip(names, row, strict=True))
        layers.append(Area((positions[i] - 0.5, positions[i] + 0.5), (-limit, limit), "\n".join((title, *lines))))
    layers.append(Label(positions[-1], limit, "Σ", "text", "below"))
    plot = Plot(Axis("Surface", -0.6, count + 1.2, whole=count - 1), Axis("Seidel sum (µm)", -limit, limit),
                tuple(layers))
    words = replace(query, focus_distance=math.inf).words(None, f"field {significant(math.degrees(angle), 3)}°",
                        "third order, stop as set")
    remarks = () if float(lit[-1]) <= WIDEST else (
        f"the sums are those of a field of 45°: at {significant(math.degrees(lit[-1]), 3)}°, the edge, the "
        "third order says nothing",)
    head = ("surface", *(f"{name} (um)" for name in names))
    rows = (*((str(i), *row) for i, row in enumerate(values)), ("sum", *total))
    return Figure("Seidel sums", ((plot,),), Table(head, rows), words, remarks)


FIELDS = {"axis": 0.0, "middle": 0.7, "full": 1.0}
FIRST, LAST = 4, 22             # Noll's polynomials with bars: without piston and tilt
LAST_FRINGE = 20                # of those in the fringe order, from FIRST on
ORDERS = {"noll": "Noll's Zernike, unit rms", "fringe": "fringe Zernike, unit amplitude"}
LEVELS = 9                      # contours of the map


def wavefront_figure(query: Query, points: int, field: str = "axis", order: str = "noll") -> Figure:
    """Map and coefficients of the primary wavelength, in wavelengths, at a field of FIELDS.

    The field is the first that the query chooses, if it does. order: of the bars, a key of ORDERS.
    """
    query = query.lines
    heights = query.few(*FIELDS.values())
    rays = query.grid(points, heights)
    waves, f, c = wavefronts(rays), 0 if query.heights else list(FIELDS).index(field), rays.conditions.primary
    line = 1e-3 * rays.conditions.primary_wavelength
    noll = waves.noll[f, c] / line
    if rays.lit[f]:
        rms, strehl = waves.rms_waves[f, c], waves.strehl[f, c]
        title = f"{field_label(rays, f)}   Strehl {fixed(strehl, 3)}   RMS {significant(rms, 3)} waves"
    else:
        title = f"{field_label(rays, f)}: no light reaches this field"
    pupil = np.linspace(-1.0, 1.0, 2 * points + 1)[1::2]
    marks = ended_marks(*np.meshgrid(pupil, pupil), ends_within_stop(rays, f, c))
    map_ = _map(waves.waves[f, c], title)
    map_ = replace(map_, layers=(*map_.layers, *marks))
    words = query.words(rays, query.primary_alone,
                        "reference sphere about the primary chief ray", ORDERS[order])
    bars = _bars(noll if order == "noll" else waves.fringe[f, c] / line, order)
    remarks = query.remarks(rays)
    if rays.lit[f] and not np.isfinite(noll).any():
        remarks = (*remarks, "too few rays pass for the Zernike coefficients")
    head = ("field (mm)", "Noll index", "fringe index", "n", "m", "aberration", "Noll coefficient (waves)",
            "fringe coefficient (waves)", "Strehl", "rms (waves)")
    table = Table(head, lambda: (
        (rays.image_heights[g], float(j), float(fringe_index(*noll_indices(j))), *map(float, noll_indices(j)),
         zernike_name(*noll_indices(j)), waves.noll[g, c, j - 1] / line, waves.fringe[g, c, j - 1] / line,
         waves.strehl[g, c], waves.rms_waves[g, c])
        for g in range(len(heights)) for j in range(1, waves.noll.shape[-1] + 1)))
    return Figure("Wavefront", ((map_,), (bars,)), table, words, remarks, (0.62, 0.38))


def _map(waves: np.ndarray, title: str) -> Plot:
    """W over the exit pupil, lowest dark and highest light; contours at round parts of a wave."""
    known = waves[np.isfinite(waves)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    step = reach([max(high - low, 1e-4) / LEVELS])
    levels = tuple(step * k for k in range(int(np.ceil(low / step)), int(np.floor(high / step)) + 1))
    shown = np.where(np.isfinite(waves), waves, np.nan)
    layers = (Map("W in waves", shown, (-1.0, 1.0), (-1.0, 1.0), low, max(high, low + 1e-6), levels[:24]),)
    side = f"Contours {significant(step, 2)} waves apart"
    return Plot(Axis(None, -1.03, 1.03), Axis(None, -1.03, 1.03), layers, f"{title}   {side}", equal=True)


def _bars(coefficients: np.ndarray, order: str) -> Plot:
    """Bars of Noll's polynomials FIRST to LAST, or of those up to LAST_FRINGE, at their index in this order."""
    noll = range(FIRST, LAST + 1)
    terms = {j if order == "noll" else fringe_index(*noll_indices(j)): j for j in noll}
    last = LAST if order == "noll" else LAST_FRINGE
    indices = np.array(sorted(k for k in terms if k <= last))
    values = np.array([coefficients[terms[k] - 1] for k in indices.tolist()])
    limit = 1.1 * reach(values, 0.01)
    layers: list = [Curve.straight((FIRST - 1.0, last + 1.0), (0.0, 0.0), "faint"),
                    Bars("", indices.astype(float), values, 0.7, "field0")]
    for k, value in zip(indices.tolist(), values, strict=True):
        said = f"Z{k}, {zernike_name(*noll_indices(terms[k]))}\n" + true_minus(
            f"{significant(value, 3)} waves" if np.isfinite(value) else "unknown")
        layers.append(Area((k - 0.5, k + 0.5), (-limit, limit), said))
    name = "Noll" if order == "noll" else "fringe"
    return Plot(Axis(f"Zernike term ({name})", FIRST - 0.7, last + 0.7, whole=last), Axis("Waves", -limit, limit),
                tuple(layers))
