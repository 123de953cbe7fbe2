"""The rays of a ghost: even grids across the beam of a light that enters a lens.

A grid lies in the plane through the first vertex across the direction to the light. Camera frame, mm: the film's centre
is the origin, the scene at −z. A light is (x, y, z, 1), its place, or (x, y, z, 0), the unit direction to it.
"""

import math

import numpy as np

from lensbench.optics.ghost_trace import GhostTracer, Pair

SCAN = 21               # cells along a side of the grid that finds where a ghost enters: its vertices are one block
SCANS = 4               # of a pair at the most, each about what the one before found
TRIES = 6               # places that a scan without a passing ray goes on to search
MOST_SCANS = 16
MARGIN = 1.5            # by how many differences between neighbours a ray between them may pass more nearly
Box = tuple[float, float, float, float]         # u and v from, u and v to (mm)


def pair_box(tracer: GhostTracer, lanes: np.ndarray, light: np.ndarray, pair: Pair) -> Box | None:
    """Where in the grid's plane the light of a pair enters; None where no ray passes, or comes near to passing.

    A ghost that enters between the rays of a scan is searched for about the rays that pass most nearly, unless the
    distances of their neighbours say that none can pass. A ghost narrower than about 1/50 of the front may be missed.
    """
    reach = entrance_reach(tracer)
    boxes: list[tuple[Box, int]] = [((-reach, -reach, reach, reach), 0)]
    for _ in range(MOST_SCANS):
        if not boxes:
            break
        box, depth = boxes.pop(0)
        found = entrance_grid(tracer, lanes, light, pair, box, SCAN)
        distance = np.sqrt(np.where(np.isfinite(found[5]), found[5], np.inf)).reshape(SCAN + 1, SCAN + 1)
        lines, columns = np.nonzero((distance <= 1.0).any(1))[0], np.nonzero((distance <= 1.0).any(0))[0]
        if len(lines):
            inner = _part(box, lines[0] - 1, lines[-1] + 1, columns[0] - 1, columns[-1] + 1)
            if depth == SCANS - 1 or min(len(lines), len(columns)) > SCAN // 3:
                return inner                            # fine enough
            boxes = [(inner, depth + 1)]
        elif depth < SCANS - 1:
            boxes += [(_part(box, j - 1, j + 1, i - 1, i + 1), depth + 1) for j, i in _nearly(distance)]
    return None


def _part(box: Box, top: int, bottom: int, left: int, right: int) -> Box:
    """The part of a box between these lines and columns of its scan."""
    du, dv = (box[2] - box[0]) / SCAN, (box[3] - box[1]) / SCAN
    return box[0] + left * du, box[1] + top * dv, box[0] + right * du, box[1] + bottom * dv


def _nearly(distance: np.ndarray) -> list[tuple[int, int]]:
    """Up to TRIES least of their neighbours, beside which a ray may pass, the most promising first."""
    padded = np.pad(distance, 1, constant_values=np.inf)
    around = np.stack([padded[j:j + SCAN + 1, i:i + SCAN + 1] for j in range(3) for i in range(3)])
    least = around.min(0)
    steep = np.where(np.isfinite(around), around, -np.inf).max(0) - least
    with np.errstate(invalid="ignore"):
        candidates = (distance == least) & (distance < np.inf) & (distance - MARGIN * steep <= 1.0)
    places = np.argwhere(candidates)
    order = np.argsort(distance[candidates] / np.maximum(steep[candidates], 1e-9))[:TRIES]
    return [(int(j), int(i)) for j, i in places[order]]


def entrance_reach(tracer: GhostTracer) -> float:
    """Radius (mm) about the first vertex of the sphere that holds the first surface within its rim."""
    first = tracer.lens.surfaces[0]
    sag = abs(float(first.sag(first.semi_diameter)))
    return math.hypot(first.semi_diameter, sag if math.isfinite(sag) else first.semi_diameter)


def entrance_grid(tracer: GhostTracer, lanes: np.ndarray, light: np.ndarray, pair: Pair, box: Box, cells: int,
                  shift: tuple[float, float] = (0.0, 0.0), radiance: float = 1.0) -> np.ndarray:
    """The rays of a grid (cells + 1)² traced: (6, rays) as of `GhostTracer.trace`, row by row in v.

    shift: of the grid, in cells. The light of a ray is radiance times the area of a cell (mm²), for a near light times
    the cosine at the grid over that on the axis, and times (distance of the vertex / distance)².
    """
    rays = grid_rays(tracer, light, box, cells, shift, radiance)
    found = np.empty((6, rays.shape[1]), tracer.real)
    tracer.trace(lanes, pair, rays, found)
    return found


def grid_rays(tracer: GhostTracer, light: np.ndarray, box: Box, cells: int, shift: tuple[float, float] = (0.0, 0.0),
              radiance: float = 1.0) -> np.ndarray:
    """X … N and WEIGHT (7, rays) of a grid; see `entrance_grid`."""
    vertex = np.array([0.0, 0.0, tracer.front_z])
    towards = light[:3] - vertex if light[3] else light[:3].copy()
    distance = float(np.linalg.norm(towards))
    towards /= distance
    side = np.array([1.0, 0.0, 0.0]) if abs(towards[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    u = side - (side @ towards) * towards
    u /= np.linalg.norm(u)
    v = np.cross(towards, u)
    a = box[0] + (np.arange(cells + 1) + shift[0]) / cells * (box[2] - box[0])
    b = box[1] + (np.arange(cells + 1) + shift[1]) / cells * (box[3] - box[1])
    points = vertex[:, None] + (u[:, None, None] * a + v[:, None, None] * b[:, None]).reshape(3, -1)
    rays = np.empty((7, points.shape[1]), tracer.real)
    rays[:3] = points
    area = radiance * (box[2] - box[0]) * (box[3] - box[1]) / cells**2
    if light[3]:
        away = points - light[:3, None]
        length = np.sqrt((away * away).sum(0))
        rays[3:6] = away / length
        rays[6] = area * (distance / length)**3          # cosine: distance / length
    else:
        rays[3:6] = -towards[:, None]
        rays[6] = area
    return rays
