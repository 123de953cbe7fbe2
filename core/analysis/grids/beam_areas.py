"""Light of an evenly lit beam in the cells of a pupil grid, by where their rays run in the scene."""

from math import isinf

import numpy as np

from lensbench.analysis.grids.field_beams import FieldBeams
from lensbench.kernels.cache import njit

LARGEST = 20.0          # × the median of the open cells: of lenses in use the light of a cell is at most six times it


def beam_areas(beams: FieldBeams, places: np.ndarray, level: np.ndarray) -> np.ndarray:
    """(F, N, N) light of an evenly lit beam per cell of the grid, from `towards_scene` of its rays.

    An object at infinity lights the beam's area evenly, one nearby by Lambert's law. Cells of rays that do not
    come through have no light, and neither have those beyond a fold, or beside a place where rays part without limit:
    their places belong to other cells too.
    """
    out = np.zeros(places.shape[:3])
    _areas(places, level, out)
    for areas, shares in zip(out, level, strict=True):
        open_ = areas[(shares < 1.0) & (areas > 0.0)]
        if open_.size:
            middle = open_.size // 2
            areas[areas > LARGEST * np.partition(open_, middle)[middle]] = 0.0
    if not isinf(beams.object_distance):
        reach = beams.reaches[:, None, None]
        far = np.sqrt(reach**2 + np.where(np.isfinite(places), places, 0.0)**2 @ np.ones(2))
        along = (np.einsum("fija,fa->fij", np.nan_to_num(places), beams.frames[:, :, 2])
                 + reach * beams.chief.directions[:, 2, None, None])
        out *= np.nan_to_num((reach / far) ** 3 * np.abs(along / far))
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _areas(places, level, out):
    """Area of the beam per cell of the exit pupil (F, N, N), from places (F, N, N, 2) of rays with a finite level.

    A cell has the mean area of the parallelograms at its four corners, each with one neighbour along both axes: of
    those that turn as the field's open ones do, level < 1, and 0 unless most do.
    """
    fields, rows, columns, _ = places.shape
    for f in range(fields):
        turn = 0.0
        for i in range(rows - 1):
            for j in range(columns - 1):
                if level[f, i, j] < 1.0:
                    area = _parallelogram(places, level, f, i, j, 1, 1)
                    turn += area if abs(area) < np.inf else 0.0
        sign = 1.0 if turn >= 0.0 else -1.0
        for i in range(rows):
            for j in range(columns):
                total, alike, known = 0.0, 0, 0
                for di in (-1, 1):
                    for dj in (-1, 1):
                        area = sign * _parallelogram(places, level, f, i, j, di, dj)
                        if abs(area) < np.inf:
                            known += 1
                            if area > 0.0:
                                alike += 1
                                total += area
                out[f, i, j] = total / alike if 2 * alike > known else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _parallelogram(places, level, f, i, j, di, dj):
    """Signed area between a cell and its neighbours along both axes; NaN where one is missing or has a lost ray."""
    if not (0 <= i + di < places.shape[1] and 0 <= j + dj < places.shape[2]):
        return np.nan
    if not (level[f, i, j] < np.inf and level[f, i + di, j] < np.inf and level[f, i, j + dj] < np.inf):
        return np.nan
    s, t = places[f, i, j, 0], places[f, i, j, 1]
    return di * dj * ((places[f, i + di, j, 0] - s) * (places[f, i, j + dj, 1] - t)
                      - (places[f, i + di, j, 1] - t) * (places[f, i, j + dj, 0] - s))
