"""The image of a point: its picture, line spread and encircled energy, the last beside that of a perfect lens."""

from dataclasses import replace

import numpy as np

from lensbench.app.plots.plot import DASHED, DOTTED, SOLID, Axis, Curve, Figure, Map, Plot, Table, reach
from lensbench.app.plots.query import Query
from lensbench.app.plots.rims import ended_marks, ends_within_stop, with_shares
from lensbench.app.plots.spots import field_label, field_tint
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.point_spread import PointSpread, encircled_energy, psf
from lensbench.core.analysis.spot_diagram import light_shares, spots
from lensbench.core.optics.lens_surface import LensError

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
    spread = psf(rays, _samples(points), pixel=query.setup.film.pitch if pixel else 0.0)
    light, half = spread.white[0], 500.0 * spread.pitch[0] * spread.density.shape[-1]
    words = _words(query, spread, "log, 4 decades" if view == "log" else "linear",
                   *(("averaged over a pixel",) if pixel else ()))
    at = 1000.0 * spread.offsets[0]
    head = ("sagittal (um)", "tangential (um)", "light (1/mm2)")
    step = max(1, len(at) // SAMPLES)
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
    table = Table(head, lambda: ((x, y, light[i, j]) for i, y in list(enumerate(at))[::step]
                                 for j, x in list(enumerate(at))[::step]))
    return Figure("Point spread", ((plot,),), table, words, query.remarks(spread.rays, spread.findings))


def seen_point_figure(query: Query, points: int, at: tuple[float, float], ahead: float, view: str = "log",
                      pixel: bool = False) -> Figure:
    """The picture of what a pixel shows, as `psf_figure`.

    at: the point (x, y) of the film, mm. ahead: the distance of what it shows, from the film along the axis, mm or inf.
    """
    away = ahead - query.setup.film_z
    if not away > 0.0:
        raise LensError("what this pixel shows touches the lens")
    here = replace(query, heights=(at,), object_distance=away, focus_distance=ahead)
    return psf_figure(here, points, view=view, pixel=pixel)


def encircled_figure(query: Query, points: int) -> Figure:
    """The part of the light within a circle about the centroid, over its radius: three fields, and a perfect lens.

    LensError where no light reaches the film.
    """
    rays = query.grid(points, query.few(*FIELDS.values()))
    spread = psf(rays, _samples(points))
    end = 0.5 * spread.pitch * spread.density.shape[-1]
    radii = np.linspace(0.0, float(np.nanmax(end)), 2 * RADII)
    held = _white(spread, encircled_energy(spread, radii))
    best = _perfect(rays, radii)
    reached = [radii[int(np.argmax(each > MOST))] for each in held if (each > MOST).any()]
    limit = 1000.0 * min(max(reached, default=radii[-1]), radii[-1])
    axis = 1000.0 * radii
    curves = [Curve(field_label(rays, f), axis, held[f], field_tint(f, len(rays.images)))
              for f in np.flatnonzero(rays.lit).tolist()]
    curves.append(Curve(f"perfect lens, {field_label(rays, 0)}", axis, best, "dim", DOTTED, 1.2))
    plot = Plot(Axis("Radius (µm)", 0.0, reach([limit])), Axis("Part of the light", 0.0, 1.0), tuple(curves))
    head = ("field (mm)", "radius (um)", "part of the light")
    table = Table(head, lambda: ((rays.image_heights[f], r, value) for f in range(len(held))
                                 for r, value in zip(axis, held[f], strict=True)))
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
        at = 1000.0 * spread.offsets[f]
        for a, (way, dash) in enumerate((("S", SOLID), ("T", DASHED))):
            curves.append(Curve(f"{field_label(rays, f)} {way}", at, 0.1 * lines[f, a],
                                field_tint(f, len(rays.images)), dash))
    wide = max((float(np.abs(each.x[each.y > 0.02 * each.y.max()]).max()) for each in curves), default=1.0)
    top = max((float(each.y.max()) for each in curves), default=1.0)
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


def _white(spread: PointSpread, held: np.ndarray) -> np.ndarray:
    """(F, K) of the encircled energy (F, C, K) in all wavelengths; NaN beyond the window."""
    rays = spread.rays
    shares = np.where(rays.coverage.any((2, 3)), light_shares(rays), 0.0)
    found = np.einsum("fck,fc->fk", np.nan_to_num(held), shares)
    return np.asarray(np.where(np.isnan(held).all(1), np.nan, found))


def _words(query: Query, spread: PointSpread, *more: str) -> str:
    rays: RayGrid = spread.rays
    share = spread.diffraction[rays.lit]
    method = "diffraction" if np.nanmin(share, initial=1.0) == 1.0 else "rays" if np.nanmax(share, initial=0.0) == 0.0 \
        else "diffraction and rays"
    colours = ("white",) if len(rays.conditions.wavelengths) > 1 else ()
    return query.words(rays, method, *colours, *more)
