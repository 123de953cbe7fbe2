"""The image of a point: its picture, line spread and encircled energy; and the MTF over frequency, field and focus."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from lensbench.app.plots.plot import DASHED, DOTTED, SOLID, Axis, Curve, Figure, Map, Plot, Table, reach
from lensbench.app.plots.query import OWN, Query, ended_marks, ends_within_stop, with_rims, with_shares
from lensbench.app.plots.spots import field_label, field_tint
from lensbench.core.analysis.focus_map import MtfMap, mtf_map
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.point_spread import PointSpread, encircled_energy, psf
from lensbench.core.analysis.spot_diagram import light_shares, spots
from lensbench.core.analysis.transfer_function import Mtf, mtf
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.text import significant

FIELDS = {"axis": 0.0, "middle": 0.7, "full": 1.0}
DECADES = 4.0                   # of the logarithmic view
SAMPLES = 128                   # of the picture and of the curves, with few points across the pupil; else twice as many
FINE = 64                       # points across the pupil that are not few
FIRST_ZERO = 3.8317059702075    # of J₁
TURNS = 600                     # points of Bessel's integrals: more than the largest argument
RADII = 61                      # of the encircled energy
MOST = 0.98                     # share of the light at which the curves may end


def psf_figure(query: Query, points: int, field: str = "axis", view: str = "log", pixel: bool = False) -> Figure:
    """Picture of a point of light in all wavelengths, scaled to its brightest place.

    points: of the grid across the pupil. field: a name of FIELDS; a field that the query chooses comes before it. view:
    "linear", or "log" over four decades. pixel: average over a pixel of the film. LensError where no light reaches the
    film.
    """
    rays = query.grid(points, query.few(FIELDS[field])[:1])
    spread = psf(rays, _samples(points), pixel=query.bench.film.pitch if pixel else 0.0)
    light, half = spread.white[0], 500.0 * spread.pitch[0] * spread.density.shape[-1]
    words = _words(query, spread, "log, 4 decades" if view == "log" else "linear",
                   *(("averaged over a pixel",) if pixel else ()))
    offsets = 1000.0 * spread.offsets[0]
    head = ("sagittal (um)", "tangential (um)", "light (1/mm2)")
    step = max(1, len(offsets) // SAMPLES)
    if not rays.lit[0]:
        plot = Plot(Axis(None, -1.0, 1.0), Axis(None, -1.0, 1.0), (), "No light reaches this field", equal=True)
        return Figure("Point spread", ((plot,),), Table(head, ()), words, query.remarks(rays))
    shades = Map("of the brightest place", light / max(float(light.max()), 1e-30), (-half, half), (-half, half),
                 decades=DECADES if view == "log" else 0.0)
    c, (s, t) = rays.conditions.primary, spread.centres[0]
    marks = ended_marks(1000.0 * (rays.offset_s[0, c] - s), 1000.0 * (rays.offset_t[0, c] - t),
                        ends_within_stop(rays, 0, c))
    plot = Plot(Axis("Sagittal (µm)", -half, half), Axis("Tangential (µm)", -half, half), (shades, *marks),
                field_label(rays, 0), equal=True)
    table = Table(head, lambda: ((x, y, light[i, j]) for i, y in list(enumerate(offsets))[::step]
                                 for j, x in list(enumerate(offsets))[::step]))
    return Figure("Point spread", ((plot,),), table, words, query.remarks(spread.rays, spread.findings))


def seen_point_figure(query: Query, points: int, film_xy: tuple[float, float], ahead: float, view: str = "log",
                      pixel: bool = False) -> Figure:
    """The picture of what a pixel shows, as `psf_figure`.

    film_xy: the point (x, y) of the film, mm. ahead: the distance of what it shows, from the film along the axis, mm or
    inf.
    """
    away = ahead - query.bench.film_z
    if not away > 0.0:
        raise LensError("what this pixel shows touches the lens")
    of_pixel = replace(query, heights=(film_xy,), object_distance=away, focus_distance=ahead)
    return psf_figure(of_pixel, points, view=view, pixel=pixel)


def encircled_figure(query: Query, points: int) -> Figure:
    """The part of the light within a circle about the centroid, over its radius: three fields, and a perfect lens.

    LensError where no light reaches the film.
    """
    rays = query.grid(points, query.few(*FIELDS.values()))
    spread = psf(rays, _samples(points))
    end = 0.5 * spread.pitch * spread.density.shape[-1]
    radii = np.linspace(0.0, float(np.nanmax(end)), 2 * RADII)
    shares = _white(spread, encircled_energy(spread, radii))
    best = _perfect(rays, radii)
    reached = [radii[int(np.argmax(curve > MOST))] for curve in shares if (curve > MOST).any()]
    limit = 1000.0 * min(max(reached, default=radii[-1]), radii[-1])
    axis = 1000.0 * radii
    curves = [Curve(field_label(rays, f), axis, shares[f], field_tint(f, len(rays.images)))
              for f in np.flatnonzero(rays.lit).tolist()]
    curves.append(Curve(f"perfect lens, {field_label(rays, 0)}", axis, best, "dim", DOTTED, 1.2))
    plot = Plot(Axis("Radius (µm)", 0.0, reach([limit])), Axis("Part of the light", 0.0, 1.0), tuple(curves))
    head = ("field (mm)", "radius (um)", "part of the light")
    table = Table(head, lambda: ((rays.image_heights[f], r, value) for f in range(len(shares))
                                 for r, value in zip(axis, shares[f], strict=True)))
    return Figure("Encircled energy", ((with_shares(rays, plot),),), table, _words(query, spread, "about the centroid"),
                  query.remarks(spread.rays, spread.findings))


def line_spread_figure(query: Query, points: int) -> Figure:
    """Light across the image of a line, at three fields: across sagittal lines solid, across tangential ones dashed.

    LensError where no light reaches the film.
    """
    rays = query.grid(points, query.few(*FIELDS.values()))
    spread = psf(rays, _samples(points))
    lines = np.einsum("fcam,fc->fam", np.nan_to_num(spread.line_spread), light_shares(rays))
    curves: list[Curve] = []
    lit = np.flatnonzero(rays.lit).tolist()
    for f in lit:
        offsets = 1000.0 * spread.offsets[f]
        for a, (way, dash) in enumerate((("S", SOLID), ("T", DASHED))):
            curves.append(Curve(f"{field_label(rays, f)} {way}", offsets, 0.1 * lines[f, a],
                                field_tint(f, len(rays.images)), dash))
    wide = max((float(np.abs(curve.x[curve.y > 0.02 * curve.y.max()]).max()) for curve in curves), default=1.0)
    top = max((float(curve.y.max()) for curve in curves), default=1.0)
    plot = Plot(Axis("Distance from the centroid (µm)", -reach([wide]), reach([wide])),
                Axis("Light (% per µm)", 0.0, 1.05 * top), tuple(curves))
    head = ("field (mm)", "distance (um)", "sagittal (% a um)", "tangential (% a um)")
    table = Table(head, lambda: ((rays.image_heights[f], 1000.0 * x, *(0.1 * lines[f, :, m])) for f in lit
                                 for m, x in enumerate(spread.offsets[f])))
    return Figure("Line spread", ((with_shares(rays, plot),),), table,
                  _words(query, spread, "S: along the sagittal axis, T: along the tangential"),
                  query.remarks(spread.rays, spread.findings))


def _perfect(rays: RayGrid, radii: np.ndarray) -> np.ndarray:
    """(K,) encircled energy of a perfect lens with a round pupil, that of the first field: 1 − J₀² − J₁², white."""
    turn = (np.arange(TURNS) + 0.5) * np.pi / TURNS
    shares, total = light_shares(rays)[0], np.zeros(len(radii))
    for c, airy in enumerate(spots(rays).airy_radius[0].mean(-1)):
        x = FIRST_ZERO * radii[:, None] / airy
        j0, j1 = np.cos(x * np.sin(turn)).mean(1), np.cos(turn - x * np.sin(turn)).mean(1)      # Bessel's integrals
        total += shares[c] * (1.0 - j0 * j0 - j1 * j1)
    return total


def _samples(points: int) -> int:
    return SAMPLES if points < FINE else 2 * SAMPLES


def _white(spread: PointSpread, encircled: np.ndarray) -> np.ndarray:
    """(F, K) of the encircled energy (F, C, K) in all wavelengths; NaN beyond the window."""
    rays = spread.rays
    shares = np.where(rays.coverage.any((2, 3)), light_shares(rays), 0.0)
    mean = np.einsum("fck,fc->fk", np.nan_to_num(encircled), shares)
    return np.asarray(np.where(np.isnan(encircled).all(1), np.nan, mean))


def _words(query: Query, spread: PointSpread, *more: str) -> str:
    rays: RayGrid = spread.rays
    share = spread.diffraction[rays.lit]
    method = "diffraction" if np.nanmin(share, initial=1.0) == 1.0 else "rays" if np.nanmax(share, initial=0.0) == 0.0 \
        else "diffraction and rays"
    colours = ("white",) if len(rays.conditions.wavelengths) > 1 else ()
    return query.words(rays, method, *colours, *more)


FINEST = 100.0                  # cycles/mm, of the curves against frequency
STEPS = 51
FIELD_POINTS = 25               # of the curves against the field
PRINTED = (10.0, 20.0, 30.0, 40.0)      # lp/mm, of the table
DRAWN = 10.0, 30.0                      # lp/mm: those that most makers print; more curves could not be told apart
PARTS = (0.0, 0.7, 1.0)
METHODS = {"diffraction": "diffraction", "geometric": "rays alone"}
WAYS = ("sagittal", "tangential")
DEPTHS = 8.0                    # × λN² and more: half the range of focus of the map, or as far as
FARTHEST = 3.0                  # × that, where the beams of some fields are narrowest so far from the film
LEVELS = (0.2, 0.4, 0.6, 0.8)
COARSE = 16                     # rays across the pupil, which other figures have already
VALLEY = 0.01                   # contrast by which it falls between two separate maxima
HALF = 0.5                      # of the greatest contrast, below which nothing joins two maxima
RESOLVED = 0.1                  # contrast, below which there is no best focus


def mtf_frequency_figure(query: Query, points: int, method: str = "diffraction", finest: float = FINEST) -> Figure:
    """MTF of three fields up to the frequency `finest`, sagittal and tangential.

    The fields are those that the query chooses, if it does. The diffraction limit is that of the first.
    """
    rays = query.grid(points, query.few(*PARTS))
    frequencies = np.linspace(0.0, finest, STEPS)
    contrast = mtf(rays, frequencies, method)
    curves = []
    for f in range(len(rays.images)):
        for a, dash in ((0, SOLID), (1, DASHED)):
            name = f"{field_label(rays, f)} {WAYS[a][0].upper()}"
            curves.append(Curve(name, frequencies, contrast.white_modulus[f, a],
                                field_tint(f, len(rays.images)), dash))
    of_field = "" if rays.image_heights[0] == 0.0 else f", {field_label(rays, 0)} S"
    curves.append(Curve(f"diffraction limit{of_field}", frequencies, contrast.white_limit[0, 0], "dim", DOTTED, 1.2))
    plot = Plot(Axis("Frequency (lp/mm)", 0.0, finest), Axis("Contrast", 0.0, 1.0), tuple(curves))
    return Figure("MTF against frequency", ((with_shares(rays, plot),),), _table(contrast),
                  _contrast_words(query, contrast), query.remarks(contrast.rays, contrast.findings))


def mtf_field_figure(query: Query, points: int, method: str = "diffraction",
                     frequencies: tuple[float, ...] = PRINTED) -> Figure:
    """MTF at up to four frequencies (lp/mm) against the image height: S solid, T dashed, as makers print it.

    The table holds all of PRINTED, of which only those of DRAWN get curves.
    """
    shown = DRAWN if frequencies == PRINTED else frequencies
    rays = query.grid(points, query.parts(*np.linspace(0.0, 1.0, FIELD_POINTS).tolist()))
    contrast = mtf(rays, frequencies, method)
    heights, curves = rays.image_heights, []
    for k, frequency in enumerate(frequencies):
        for a, dash in ((0, SOLID), (1, DASHED)) if frequency in shown else ():
            name = f"{significant(frequency)} lp/mm {WAYS[a][0].upper()}"
            curves.append(Curve(name, heights, contrast.white_modulus[:, a, k], f"chart{(2, 3, 0, 1)[k]}", dash,
                                1.9 - 0.2 * k))
    plot = Plot(Axis("Image height (mm)", 0.0, float(np.nanmax(heights))), Axis("Contrast", 0.0, 1.0), tuple(curves))
    words = _contrast_words(query, contrast, ", ".join(map(significant, shown)) + " lp/mm")
    return with_rims(query, Figure("MTF against the field", ((plot,),), _table(contrast), words,
                                   query.remarks(contrast.rays, contrast.findings)))


def mtf_map_figure(query: Query, points: int, frequency: float = 30.0, way: str = "both",
                   line: float | None = None) -> Figure:
    """The map of the MTF over focus and field at one frequency (lp/mm), and the surfaces of best focus.

    way: "sagittal", "tangential", or "both" for their mean. line: one wavelength (µm) alone; None for all of the query.
    The film lies at 0.
    """
    reachable = focus_range(query)
    query = query if line is None else replace(query, wavelengths=((line, 1.0),), white=OWN)
    shifts = np.linspace(-reachable, reachable, 2 * points + 1)
    map_ = mtf_map(query.lens, query.bench.film_distance, query.conditions(), frequency, shifts, points + 1,
                    min(points, 32))
    white = map_.white.mean(1) if way == "both" else map_.white[:, WAYS.index(way)]
    heights = map_.heights
    top, half = float(np.nanmax(heights)), 0.5 * (shifts[1] - shifts[0])
    rise = 0.5 * top / max(len(heights) - 1, 1)
    # Where nothing is resolved, the highest of the side maxima says nothing
    blurred = np.nan_to_num(map_.white.max(2), nan=1.0) < RESOLVED
    best = np.where(blurred, np.nan, map_.best_shifts)
    layers: list = [Map(f"MTF at {significant(frequency)} lp/mm", white, (shifts[0] - half, shifts[-1] + half),
                        (-rise, top + rise), 0.0, 1.0, LEVELS)]
    layers += [Curve(f"best {name}", *of_one_maximum(best[:, a], heights, shifts, map_.white[:, a]), "field2", dash)
               for a, (name, dash) in enumerate(zip(WAYS, (SOLID, DASHED), strict=True)) if way in ("both", name)]
    plot = Plot(Axis("Film shift (mm)", -reachable, reachable), Axis("Image height (mm)", 0.0, top), tuple(layers),
                across=True)
    rays = map_.rays
    words = query.words(rays, "diffraction, white" if len(rays.conditions.wavelengths) > 1 else "diffraction",
                        "sagittal and tangential mean" if way == "both" else way)
    left_out = f"no best focus is drawn where the contrast stays below {significant(RESOLVED)}"
    beyond = f"no best focus is drawn where it lies more than {significant(reachable)} mm from the film"
    outside = ~blurred & np.isnan(map_.best_shifts) & (map_.white.max(2) > 0.0)
    drawn = [way in ("both", name) for name in WAYS]
    remarks = (*([left_out] if blurred[:, drawn].any() else []), *([beyond] if outside[:, drawn].any() else []),
               *query.remarks(rays))
    return with_rims(query, Figure("MTF map", ((plot,),), _map_table(map_), words, remarks))


def of_one_maximum(best: np.ndarray, heights: np.ndarray, shifts: np.ndarray,
                    values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The line through the best shifts (F,) of fields, with a gap wherever two neighbours are maxima of their own.

    They are where the contrast (F, K) of one of both fields falls and rises again on the way from the one shift to the
    other, or falls below HALF.
    """
    gaps = []
    for f in range(len(best) - 1):
        low, high = sorted((best[f], best[f + 1]))
        between = values[f:f + 2, (shifts >= low) & (shifts <= high)]       # none where a field has no best shift
        if between.shape[1] > 2:
            least = between.min(1)
            if (least < np.maximum(between[:, [0, -1]].min(1) - VALLEY, HALF * between.max(1))).any():
                gaps.append(f + 1)
    return np.insert(best, gaps, np.nan), np.insert(heights, gaps, np.nan)


def focus_range(query: Query) -> float:
    """Half the range of focus of the map (mm): several depths of focus, and where the fields are sharp, if not far off.

    The depths are those of a perfect lens, and what the film's grid resolves.
    """
    n = query.bench.f_number
    near = reach([DEPTHS * 2.0 * 0.00055 * n * n, 0.03 * n])
    foci = spots(query.grid(COARSE)).line_foci
    return min(reach(foci, near), reach([FARTHEST * near]))


def _contrast_words(query: Query, contrast: Mtf, *more: str) -> str:
    colours = ("white",) if len(contrast.rays.conditions.wavelengths) > 1 else ()
    return query.words(contrast.rays, METHODS[contrast.method], *colours, "S solid, T dashed", *more)


def _table(contrast: Mtf) -> Table:
    head = ("field (mm)", "field (deg)", "frequency (lp/mm)", "sagittal", "tangential", "limit sagittal",
            "limit tangential")

    def rows() -> Iterator[tuple]:
        degrees, modulus, limit = np.degrees(contrast.rays.field_angles), contrast.white_modulus, contrast.white_limit
        for f, height in enumerate(contrast.rays.image_heights):
            for k, frequency in enumerate(contrast.frequencies):
                yield height, degrees[f], frequency, *modulus[f, :, k], *limit[f, :, k]

    return Table(head, rows)


def _map_table(map_: MtfMap) -> Table:
    head = ("field (mm)", "film shift (mm)", "frequency (lp/mm)", "sagittal", "tangential")
    white = map_.white
    return Table(head, lambda: ((height, shift, map_.frequency, *white[f, :, k])
                                for f, height in enumerate(map_.heights) for k, shift in enumerate(map_.shifts)))
