"""The open region of each field: the rectangle of the exit pupil in which rays from the film pass all rims.

Pupil coordinates as in `traced_grid`. A scan begins about the image of the stop, and widens where light reaches its
edge. A region that few points of a scan meet, such as the sliver that rims leave at the edge of light, is scanned again
by itself. Where none was found, scans close in on the ray that comes nearest to passing.

Transmission of the picture in the stop over the cells of the exit pupil.

The rays of the object are traced through the open stop; where they meet it, the picture lets a part of their light
pass. A cell takes its mean, by points on the stop that follow from the one of its middle and the slopes at the chief
ray. Of amplitudes the mean is another: where the picture is black and white, a part of the cell is open; where it is
grey, all of the cell is dimmed.
"""

from math import inf, nan
from typing import NamedTuple

import numpy as np

from lensbench.core.analysis.grids.field_beams import FieldBeams
from lensbench.core.analysis.grids.field_conditions import Conditions, field_names
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.stop_image import StopImage

COARSE = 20             # points across the scan that finds the open region
MARGIN = 1.25           # × the image of the stop, that the first scan covers
WIDER = 1.6             # × its extent, where the region reaches its edge
SCANS = 4
SMALL = 0.5             # of a scan across: a smaller region is scanned again
AGAIN = 2               # times at most
CLOSER, ABOUT = 8, 2.0  # scans that close in on a hole: how many, and to how many cells to either side


def open_boxes(beams: FieldBeams, conditions: Conditions) -> tuple[np.ndarray, list[Finding]]:
    """(F, 2, 2) low and high pupil coordinate, sagittal and tangential, of the open region; NaN where dark."""
    a, b, c, d = beams.stop_slopes.reshape(-1, 4).T
    with np.errstate(divide="ignore", invalid="ignore"):
        half = MARGIN * np.column_stack([np.hypot(d, b), np.hypot(c, a)]) / np.abs(a * d - b * c)[:, None]
    boxes = np.full((len(half), 2, 2), nan)
    known = np.flatnonzero(np.isfinite(half).all(1))
    scans = np.stack([beams.chief_pupil - half, beams.chief_pupil + half], -1)
    _bound(beams, known, scans.copy(), boxes)
    dark = known[np.isnan(boxes[known, 0, 0])]
    narrow = _narrow(beams, dark, scans)
    _bound(beams, narrow, scans, boxes)
    boxes[beams.beyond_the_plane] = nan
    findings = []
    dark, missed = ~np.isfinite(boxes).all((1, 2)), ~np.isfinite(half).all(1)
    dark &= ~beams.beyond_the_plane                     # `ray_grid` says so
    for what, which in (("ray through the middle of the stop", missed), ("light", dark & ~missed)):
        these = np.flatnonzero(which)
        if these.size:
            names = f"{'these fields' if these.size > 1 else 'the field'} {field_names(conditions, these)}"
            findings.append(Finding(Kind.DARK, None, f"no {what} reaches {names}: beyond what the lens sees, or beyond "
                                    "its image circle", figures={"fields": float(these.size)}))
    return boxes, findings


def _levels(beams: FieldBeams, which: np.ndarray, scans: np.ndarray) -> np.ndarray:
    """Levels (n, COARSE, COARSE) of fields (n,) at the middles of the cells of scans (n, 2, 2); see `towards_scene`."""
    cell = (np.arange(COARSE) + 0.5) / COARSE
    s, t = (low[:, None] + cell * (high - low)[:, None] for low, high in scans.transpose(1, 2, 0))
    s, t = (np.ascontiguousarray(np.broadcast_to(coordinate, (len(which), COARSE, COARSE)))
            for coordinate in (s[:, None, :], t[:, :, None]))
    return beams.only(which).grid_towards_scene(s, t)[1]


def _bound(beams: FieldBeams, left: np.ndarray, scans: np.ndarray, boxes: np.ndarray) -> None:
    """Put the boxes (F, 2, 2) of those fields (n,) that light reaches, by scans (F, 2, 2), which are changed.

    Bounds are in cells, sagittal and tangential, low and high; NaN for a dark field.
    """
    for scan in range(SCANS + AGAIN):
        if not left.size:
            break
        size = np.diff(scans[left])[..., 0]
        bounds = np.empty((left.size, 4))
        _bounds(_levels(beams, left, scans[left]), bounds)
        places = bounds.reshape(-1, 2, 2)
        lit = np.isfinite(places[:, 0, 0])
        touches = np.stack([places[..., 0] < 0.5, places[..., 1] > COARSE - 0.5], -1)
        whole = lit & ~touches.any((1, 2))
        boxes[left[lit]] = (scans[left, :, :1] + places / COARSE * size[..., None])[lit]
        small = whole & (np.diff(places)[..., 0] < SMALL * COARSE).any(1)
        # Widen the scan where the region reaches its edge, everywhere where nothing was found
        grow = np.where(touches | ~lit[:, None, None], 0.5 * (WIDER - 1.0), 0.0)
        scans[left] += grow * size[..., None] * [-1.0, 1.0]
        scans[left[small]] = boxes[left[small]]
        left = left[small | (~whole & (scan < SCANS - 1))]


def _narrow(beams: FieldBeams, left: np.ndarray, scans: np.ndarray) -> np.ndarray:
    """Fields of those (n,), dark so far, that an opening narrower than a cell lights; their scans (F, 2, 2) hold it.

    The greatest share of a rim has one least value over the pupil: the scans close in on it.
    """
    lit: list[int] = []
    for _ in range(CLOSER):
        if not left.size:
            break
        level = _levels(beams, left, scans[left]).reshape(left.size, -1)
        best = level.argmin(1)
        least, cell = level[np.arange(left.size), best], np.diff(scans[left])[..., 0] / COARSE
        middle = scans[left, :, 0] + (np.stack([best % COARSE, best // COARSE], 1) + 0.5) * cell
        if beams.mirrored:                              # the least value lies on the meridian
            middle[:, 0] = 0.0
        scans[left] = np.stack([middle - ABOUT * cell, middle + ABOUT * cell], -1)
        lit += left[least < 1.0].tolist()
        left = left[(least >= 1.0) & (least < inf)]
    return np.array(lit, int)


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(level, out):
    """Extents of level < 1 in cells of (F, N, N): out (F, 4) low and high column, low and high row; NaN where none is.

    A rim between two cells is where the level, linear between them, is 1; the extents get half a cell more.
    """
    fields, rows, columns = level.shape
    for f in range(fields):
        low_s, high_s, low_t, high_t = np.inf, -np.inf, np.inf, -np.inf
        for i in range(rows):
            for j in range(columns):
                value = level[f, i, j]
                if not value < 1.0:
                    continue
                s, t = j + 0.5, i + 0.5
                low_s = min(low_s, s - (_part(value, level[f, i, j - 1]) if j > 0 else 0.5))
                high_s = max(high_s, s + (_part(value, level[f, i, j + 1]) if j < columns - 1 else 0.5))
                low_t = min(low_t, t - (_part(value, level[f, i - 1, j]) if i > 0 else 0.5))
                high_t = max(high_t, t + (_part(value, level[f, i + 1, j]) if i < rows - 1 else 0.5))
        lit = high_s > low_s
        out[f, 0], out[f, 1] = (low_s - 0.5, high_s + 0.5) if lit else (np.nan, np.nan)
        out[f, 2], out[f, 3] = (low_t - 0.5, high_t + 0.5) if lit else (np.nan, np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _part(value, there):
    """Place of the level 1 between a cell inside and its neighbour, in cells: at most 1."""
    if not there < np.inf:
        return 1.0
    return 1.0 if there <= 1.0 else (1.0 - value) / (there - value)


ACROSS = 8              # points across a cell


class StopTransmission(NamedTuple):
    """Means (F, N, N) over the cells: of the transmitted light, and of the amplitude, its square root."""

    light: np.ndarray
    amplitude: np.ndarray

    @property
    def open_part(self) -> np.ndarray:
        """(F, N, N) part of each cell that is open; 0 where the picture is opaque."""
        return np.divide(self.amplitude**2, self.light, out=np.zeros_like(self.light), where=self.light > 0.0)

    @property
    def dimming(self) -> np.ndarray:
        """(F, N, N) light that passes the open part of each cell, for light 1 on it."""
        return np.divide(self.light, self.open_part, out=np.zeros_like(self.light), where=self.light > 0.0)


def stop_transmission(beams: FieldBeams, grid: np.ndarray, image: StopImage) -> StopTransmission:
    """Means over the cells of a grid (F, 2, N) of the exit pupil; 0 where no ray meets the stop."""
    fields, _, n = grid.shape
    s, t = (np.ascontiguousarray(np.broadcast_to(coordinate, (fields, n, n)))
            for coordinate in (grid[:, 0, None, :], grid[:, 1, :, None]))
    middle = beams.on_stop(s, t)
    steps = (grid[:, :, 1] - grid[:, :, 0])[:, None, :] * beams.stop_slopes         # (F, 2, 2), in stop radii a cell
    light, amplitude, within = (np.zeros((fields, n, n)) for _ in range(3))
    offsets = (np.arange(ACROSS) + 0.5) / ACROSS - 0.5
    for across in offsets.tolist():
        for up in offsets.tolist():
            moved = (steps @ [across, up]).T[:, :, None, None]
            x, y = middle + moved
            with np.errstate(invalid="ignore"):
                inside = x * x + y * y <= 1.0           # beyond, the rim of the stop has the cell's open part
            share = image.at(x, y)
            light += share
            amplitude += np.sqrt(share)
            within += inside
    # A cell that only touches the stop takes the nearest point of its rim
    x, y = middle / np.maximum(1.0, np.hypot(*middle))
    edge = np.where(within > 0.0, 0.0, image.at(x, y))
    light, amplitude, count = light + edge, amplitude + np.sqrt(edge), np.maximum(within, 1.0)
    return StopTransmission(light / count, amplitude / count)
