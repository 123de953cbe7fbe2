"""Plots of aberrations: Seidel sums of each surface, and the wavefront of one field."""

import math
from dataclasses import replace

import numpy as np

from lensbench.app.plots.plot import Area, Axis, Bars, Curve, Figure, Label, Map, Plot, Table, reach
from lensbench.app.plots.query import Query
from lensbench.app.plots.rims import ended_marks, ends_within_stop
from lensbench.app.plots.spots import field_label
from lensbench.core.analysis.aberrations import seidel
from lensbench.core.analysis.wavefront import fringe_index, noll_indices, wavefronts, zernike_name
from lensbench.core.text import fixed, significant, true_minus

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
    angle, given = min(float(lit[-1]), WIDEST), rays.conditions
    pair = (min(given.wavelengths), max(given.wavelengths)) if len(given.wavelengths) > 1 else None
    found = seidel(query.lens, angle, wavelength=given.primary_wavelength, colour=pair)
    columns = [1000.0 * each for each in found.surfaces.T]
    names = list(NAMES)
    if found.axial_colour is not None and found.lateral_colour is not None:
        columns += [1000.0 * found.axial_colour, 1000.0 * found.lateral_colour]
        names += COLOURS
    values = np.column_stack(columns)
    total, count = values.sum(0), len(values)
    shown = np.vstack([values, total])
    places = np.append(np.arange(float(count)), count + 0.6)
    limit = 1.1 * reach(shown)
    layers: list = [Curve("", np.array([-1.0, count + 1.2]), np.zeros(2), "faint", weight=1.0),
                    Curve("", np.full(2, count - 0.2), np.array([-limit, limit]), "faint", weight=1.0)]
    layers += [Bars("", places[[i, i]], np.array([limit, -limit]), 0.96, "grid", surface=i) for i in range(count)]
    middle = 0.5 * (len(names) - 1)
    for k, name in enumerate(names):
        at = places + BAR * (k - middle)
        layers += [Bars(name, at[part], shown[part, k], BAR, TINTS[k]) for part in (slice(count), slice(count, None))]
    for i, row in enumerate(shown):
        title = f"surface {i}" if i < count else "sum of all surfaces"
        lines = (true_minus(f"{name}   {significant(value, 3)} µm") for name, value in zip(names, row, strict=True))
        layers.append(Area((places[i] - 0.5, places[i] + 0.5), (-limit, limit), "\n".join((title, *lines))))
    layers.append(Label(places[-1], limit, "Σ", "text", "below"))
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
    found, f, c = wavefronts(rays), 0 if query.heights else list(FIELDS).index(field), rays.conditions.primary
    line = 1e-3 * rays.conditions.primary_wavelength
    noll = found.noll[f, c] / line
    if rays.lit[f]:
        rms, strehl = found.rms_waves[f, c], found.strehl[f, c]
        title = f"{field_label(rays, f)}   Strehl {fixed(strehl, 3)}   RMS {significant(rms, 3)} waves"
    else:
        title = f"{field_label(rays, f)}: no light reaches this field"
    at = np.linspace(-1.0, 1.0, 2 * points + 1)[1::2]
    marks = ended_marks(*np.meshgrid(at, at), ends_within_stop(rays, f, c))
    map_ = _map(found.waves[f, c], title)
    map_ = replace(map_, layers=(*map_.layers, *marks))
    words = query.words(rays, query.primary_alone,
                        "reference sphere about the primary chief ray", ORDERS[order])
    bars = _bars(noll if order == "noll" else found.fringe[f, c] / line, order)
    remarks = query.remarks(rays)
    if rays.lit[f] and not np.isfinite(noll).any():
        remarks = (*remarks, "too few rays pass for the Zernike coefficients")
    head = ("field (mm)", "Noll index", "fringe index", "n", "m", "aberration", "Noll coefficient (waves)",
            "fringe coefficient (waves)", "Strehl", "rms (waves)")
    table = Table(head, lambda: (
        (rays.image_heights[g], float(j), float(fringe_index(*noll_indices(j))), *map(float, noll_indices(j)),
         zernike_name(*noll_indices(j)), found.noll[g, c, j - 1] / line, found.fringe[g, c, j - 1] / line,
         found.strehl[g, c], found.rms_waves[g, c])
        for g in range(len(heights)) for j in range(1, found.noll.shape[-1] + 1)))
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
    layers: list = [Curve("", np.array([FIRST - 1.0, last + 1.0]), np.zeros(2), "faint", weight=1.0),
                    Bars("", indices.astype(float), values, 0.7, "field0")]
    for k, value in zip(indices.tolist(), values, strict=True):
        said = f"Z{k}, {zernike_name(*noll_indices(terms[k]))}\n" + true_minus(
            f"{significant(value, 3)} waves" if np.isfinite(value) else "unknown")
        layers.append(Area((k - 0.5, k + 0.5), (-limit, limit), said))
    name = "Noll" if order == "noll" else "fringe"
    return Plot(Axis(f"Zernike term ({name})", FIRST - 0.7, last + 0.7, whole=last), Axis("Waves", -limit, limit),
                tuple(layers))
