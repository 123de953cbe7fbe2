"""The bokeh gallery: images of points of light over field and distance, with the rims that cut them."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.analysis.onion_rings import rippled
from lensbench.analysis.point_spread import PointSpread, psf
from lensbench.analysis.spot_diagram import spots
from lensbench.app.state.analysis.figure import Area, Axis, Curve, Figure, Label, Map, Plot, Table
from lensbench.app.state.analysis.query import Query
from lensbench.app.state.analysis.rims import ended_marks, ends_within_stop
from lensbench.app.state.analysis.spots import field_label
from lensbench.app.state.picture.statistics import round_above
from lensbench.app.state.text_values import format_distance
from lensbench.kernels.figures import significant
from lensbench.optics.adjacent_media import refracts
from lensbench.optics.lens_surface import LensError
from lensbench.optics.prescription import Lens

FIELDS = (0.0, 0.5, 0.8, 1.0)
AWAY = (0.6, 1.0, 1.6, math.inf)        # × the focus distance
SHADE = 0.48                            # half a picture, of its cell
NAMES = 0.7                             # cells left of the pictures, for the names of the fields
SPOT_RADII, AIRY_RADII = 1.15, 2.0      # to the edge of a picture, at the least
STRAY = 3.0                             # rms radii from the centroid, beyond which rays are too few to count
BAR = 0.05                              # of a cell, from the lowest one to the scale bar
DECADES = 4.0                           # of the logarithmic view
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
    built, samples = query.setup, max(points, 32 if ripple is None else RINGS)
    heights = query.few(*FIELDS)
    layers: list = []
    rows: list[tuple] = []
    distances = [query.focus_distance * part for part in AWAY] if math.isfinite(query.focus_distance) else \
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
    remarks = (*(f"{at}: {error}" for at, error in refused.items()),
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
    made: list = [Map("", light, *box, decades=DECADES if view == "log" else 0.0)]
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
    found = np.unique(ends[within & (ends >= 0) & (ends != rays.lens.stop_index)])
    return ", ".join(str(int(each)) for each in found)
