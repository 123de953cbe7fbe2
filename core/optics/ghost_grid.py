"""The rays of a ghost: even grids across the beam of a light that enters a lens.

A grid lies in the plane through the untilted first vertex, across the direction to the light. Camera frame, mm: the
film's centre is the origin, the scene at −z. A light is (x, y, z, 1), its position, or (x, y, z, 0), its direction.
"""

import math
from functools import lru_cache
from math import sqrt

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.ghost_path import Pair
from lensbench.core.optics.ghost_trace import GhostTracer
from lensbench.core.optics.prescription import Lens

SCAN = 21               # cells along a side of the grid that finds where a ghost enters: its vertices are one block
CLOSE_SCAN = 3 * SCAN   # cells where few rays of the first scan meet all surfaces
FEW = 0.25              # part of the rays of the first scan below which these are few
SCANS = 4               # of a part of the front at the most, each about what the one before found
TRIES = 24              # rays of a scan, at the most, near which an island may lie between rays
MOST_SCANS = 48
MARGIN = 1.5            # by how many differences between neighbours a ray between them may pass more nearly
Box = tuple[float, float, float, float]         # u and v from, u and v to (mm)


def pair_boxes(tracer: GhostTracer, lanes: np.ndarray, light: np.ndarray, pair: Pair) -> list[Box]:
    """Where in the grid's plane the light of a pair enters: boxes that do not overlap, none where no ray passes.

    The light may enter through several islands of the front; one narrower than about 1/50 of the front may be missed.
    """
    reach = entrance_reach(tracer)
    whole = -reach, -reach, reach, reach
    work: list[tuple[Box, int]] = [(whole, 0)]
    islands: list[Box] = []
    cells = SCAN
    for _ in range(MOST_SCANS):
        if not work:
            break
        box, depth = work.pop(0)
        landed = entrance_grid(tracer, lanes, light, pair, box, cells, reflecting=False)
        distance = np.sqrt(np.where(np.isfinite(landed[5]), landed[5], np.inf)).reshape(cells + 1, cells + 1)
        if depth == 0 and cells == SCAN and np.count_nonzero(np.isfinite(distance)) < FEW * distance.size:
            work, cells = [(whole, 0)], CLOSE_SCAN
            continue
        passing = _islands(_around(distance <= 1.0).max(0))
        for top, bottom, left, right in passing:
            cut = depth and (min(top, left) < 0 or max(bottom, right) > cells)
            if cut:                                     # goes on beyond the scan's border
                top, left = top - cells * (top < 0), left - cells * (left < 0)
                bottom, right = bottom + cells * (bottom > cells), right + cells * (right > cells)
            inner = _part(box, cells, top, bottom, left, right)
            if not cut and (depth == SCANS - 1 or min(bottom - top, right - left) > SCAN // 3 + 1):
                islands.append(inner)                   # fine enough
            else:
                work.append((inner, depth if cut else depth + 1))
        if depth == 0:
            work += [(_part(box, cells, j - 1, j + 1, i - 1, i + 1), 1) for j, i in _nearly(distance)
                     if not any(top <= j <= bottom and left <= i <= right for top, bottom, left, right in passing)]
        cells = SCAN
    return _apart(islands)


def _part(box: Box, cells: int, top: int, bottom: int, left: int, right: int) -> Box:
    """The part of a box between these lines and columns of its scan."""
    du, dv = (box[2] - box[0]) / cells, (box[3] - box[1]) / cells
    return box[0] + left * du, box[1] + top * dv, box[0] + right * du, box[1] + bottom * dv


def _around(values: np.ndarray) -> np.ndarray:
    """(9, h + 2, w + 2) of an array (h, w), padded by one on all sides: the values next to each, and its own."""
    wide = np.pad(values, 2, constant_values=False if values.dtype == bool else np.inf)
    h, w = wide.shape
    return np.stack([wide[j:h - 2 + j, i:w - 2 + i] for j in range(3) for i in range(3)])


def _islands(marked: np.ndarray, top: int = -1, left: int = -1) -> list[tuple[int, int, int, int]]:
    """Boxes of what is marked, cut apart at empty lines and columns: first and last line, first and last column."""
    lines, columns = _runs(marked.max(1, initial=False)), _runs(marked.max(0, initial=False))
    if len(lines) == len(columns) == 1:
        (a, b), (c, d) = lines[0], columns[0]
        return [(top + a, top + b - 1, left + c, left + d - 1)]
    return [island for a, b in lines for c, d in columns for island in _islands(marked[a:b, c:d], top + a, left + c)]


def _runs(marked: np.ndarray) -> list[tuple[int, int]]:
    """Where each run of marks begins, and the place behind its end."""
    edges = np.flatnonzero(np.diff(np.pad(marked.astype(np.int8), 1)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _apart(boxes: list[Box]) -> list[Box]:
    """Boxes, those that overlap united."""
    apart: list[Box] = []
    for box in boxes:
        while True:
            met = [b for b in apart if box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3]]
            if not met:
                break
            apart = [b for b in apart if b not in met]
            low, high = np.min([box, *met], 0).tolist()[:2], np.max([box, *met], 0).tolist()[2:]
            box = *low, *high
        apart.append(box)
    return apart


def _nearly(distance: np.ndarray) -> list[tuple[int, int]]:
    """Up to TRIES least of their neighbours, beside which a ray may pass, the most promising first."""
    around = _around(distance)[:, 1:-1, 1:-1]
    least = around.min(0)
    with np.errstate(invalid="ignore"):
        steep = around.max(0) - least                   # infinite next to a ray that is lost
        candidates = (distance == least) & (distance > 1.0) & (distance < np.inf) & (distance - MARGIN * steep <= 1.0)
    places = np.argwhere(candidates)
    order = np.argsort(distance[candidates], kind="stable")[:TRIES]
    return [(int(j), int(i)) for j, i in places[order]]


def entrance_reach(tracer: GhostTracer) -> float:
    """Radius (mm) of the sphere that holds the clear aperture of the first surface, about its centred vertex."""
    return _reach(tracer.lens)


@lru_cache(maxsize=16)
def _reach(lens: Lens) -> float:
    first = lens.surfaces[0]
    sag = abs(float(first.sag(first.semi_diameter)))
    aside = float(np.linalg.norm(lens.vertex(0)))
    return aside + math.hypot(first.semi_diameter, sag if math.isfinite(sag) else first.semi_diameter)


def entrance_grid(tracer: GhostTracer, lanes: np.ndarray, light: np.ndarray, pair: Pair, box: Box, cells: int,
                  shift: tuple[float, float] = (0.0, 0.0), reflecting: bool = True) -> np.ndarray:
    """The rays of a grid (cells + 1)² traced: (6, rays) as of `GhostTracer.trace`, row by row in v.

    shift: of the grid, in cells. A ray carries the area of a cell (mm²), for a near light times cos³ of its obliquity.
    """
    rays = grid_rays(tracer, light, box, cells, shift)
    landed = np.empty((6, rays.shape[1]), tracer.real)
    tracer.trace(lanes, pair, rays, landed, reflecting)
    return landed


@lru_cache(maxsize=256)
def _axes(front_z: float, x: float, y: float, z: float, near: float
          ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """The first vertex, unit vectors across the beam of a light and towards it (3,), and its distance."""
    vertex, light = np.array([0.0, 0.0, front_z]), np.array([x, y, z])
    towards = light - vertex if near else light
    distance = float(np.linalg.norm(towards))
    towards = towards / distance
    side = np.array([1.0, 0.0, 0.0]) if abs(towards[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    u = side - (side @ towards) * towards
    u /= np.linalg.norm(u)
    return vertex, u, np.cross(towards, u), towards, distance


def grid_rays(tracer: GhostTracer, light: np.ndarray, box: Box, cells: int, shift: tuple[float, float] = (0.0, 0.0)
              ) -> np.ndarray:
    """X … N and WEIGHT (7, rays) of a grid; see `entrance_grid`."""
    vertex, u, v, towards, distance = _axes(tracer.front_z, *light.tolist())
    a = box[0] + (np.arange(cells + 1) + shift[0]) / cells * (box[2] - box[0])
    b = box[1] + (np.arange(cells + 1) + shift[1]) / cells * (box[3] - box[1])
    rays = np.empty((7, a.size * b.size), tracer.real)
    area = (box[2] - box[0]) * (box[3] - box[1]) / cells**2
    _fill(rays, vertex, u, v, a, b, towards, distance, bool(light[3]), area)
    return rays


@njit(cache=True, nogil=True, error_model="numpy")
def _fill(rays, vertex, u, v, a, b, towards, distance, is_near, area):
    """Rays (7, b · a) from vertex + a u + b v, away from the light."""
    x, y, z = vertex + distance * towards
    for j in range(b.size):
        for i in range(a.size):
            k = j * a.size + i
            px, py, pz = (vertex[0] + (u[0] * a[i] + v[0] * b[j]), vertex[1] + (u[1] * a[i] + v[1] * b[j]),
                          vertex[2] + (u[2] * a[i] + v[2] * b[j]))
            rays[0, k], rays[1, k], rays[2, k] = px, py, pz
            if is_near:
                dx, dy, dz = px - x, py - y, pz - z
                length = sqrt(dx * dx + dy * dy + dz * dz)
                rays[3, k], rays[4, k], rays[5, k] = dx / length, dy / length, dz / length
                rays[6, k] = area * (distance / length) ** 3            # cosine: distance / length
            else:
                rays[3, k], rays[4, k], rays[5, k] = -towards[0], -towards[1], -towards[2]
                rays[6, k] = area
