"""A tree of triangles: nodes of eight boxes, leaves of eight triangles, in the layout of `kernels.eights`.

The builder halves the largest box of a node until there are eight, each time where the sum of area times triangles of
both halves is least, among planes through the middles of the triangles (surface area heuristic in bins: Wald 2007).
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.kernels.eights import LEAF_ROWS, LINKS, NODE_ROWS, NUMBERS, WIDTH

BINS = 16
NODE, LEAF = NODE_ROWS * WIDTH, LEAF_ROWS * WIDTH       # numbers of each
DEPTH = 64              # nodes below each other, at the most: deeper ranges are halved by count
MOST_TRIANGLES = 1 << 24    # numbers of triangles and links are floats, exact up to here


class TriangleTree(NamedTuple):
    """Nodes (n, NODE) and leaves (m, LEAF), float32; a link is the number of a node, or −1 − that of a leaf.

    low, high (3,): bounds of all triangles.
    """

    nodes: np.ndarray
    leaves: np.ndarray
    low: np.ndarray
    high: np.ndarray


def triangle_tree(corners: np.ndarray) -> TriangleTree:
    """The tree of n triangles, n > 0, from their corners (n, 3, 3), float32, all finite."""
    corners = np.ascontiguousarray(corners, np.float32)
    n = len(corners)
    boxes = np.concatenate([corners.min(1), corners.max(1)], 1)
    order = np.arange(n, dtype=np.int32)
    nodes = np.empty((n // 2 + 2, NODE), np.float32)
    leaves = np.empty((n // 2 + 2, LEAF), np.float32)
    counts = np.zeros(2, np.int64)
    nodes, leaves = _build(corners, boxes, order, nodes, leaves, counts)
    return TriangleTree(_aligned(nodes[:counts[0]]), _aligned(leaves[:counts[1]]), boxes[:, :3].min(0).astype(float),
                        boxes[:, 3:].max(0).astype(float))


def _aligned(table: np.ndarray) -> np.ndarray:
    """A copy that begins on a cache line."""
    raw = np.empty(table.size + 16, np.float32)
    skip = -raw.ctypes.data % 64 // 4
    found = raw[skip:skip + table.size].reshape(table.shape)
    found[:] = table
    return found


@njit(nogil=True, cache=True)
def _grown(table, count):
    """The table, or a copy of twice the rows if `count` of them are in use."""
    if count < table.shape[0]:
        return table
    larger = np.empty((2 * table.shape[0], table.shape[1]), np.float32)
    for k in range(count):
        for c in range(table.shape[1]):
            larger[k, c] = table[k, c]
    return larger


@njit(nogil=True, cache=True, error_model="numpy")
def _area(box):
    """Half the area of a box."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@njit(nogil=True, cache=True, error_model="numpy")
def _bounds(boxes, order, first, end, out):
    """Bounds of a range of triangles: its box, then that of the middles of their boxes, doubled."""
    for axis in range(3):
        out[axis], out[axis + 6], out[axis + 3], out[axis + 9] = np.inf, np.inf, -np.inf, -np.inf
    for k in range(first, end):
        j = order[k]
        for axis in range(3):
            low, high = boxes[j, axis], boxes[j, axis + 3]
            middle = low + high
            out[axis], out[axis + 3] = min(out[axis], low), max(out[axis + 3], high)
            out[axis + 6], out[axis + 9] = min(out[axis + 6], middle), max(out[axis + 9], middle)


@njit(inline="always")
def _bin(boxes, j, axis, low, per):
    """Bin of the middle of a triangle's box."""
    return min(int((boxes[j, axis] + boxes[j, axis + 3] - low) * per), BINS - 1)


@njit(nogil=True, cache=True, error_model="numpy")
def _split(boxes, order, first, end, bounds, by_count, bins, tallies, right, box):
    """Reorder a range of triangles into two; returns where the second begins."""
    best_cost, best_axis, best_bin = np.inf, -1, 0
    widest = 0
    for axis in range(1, 3):
        if bounds[axis + 9] - bounds[axis + 6] > bounds[widest + 9] - bounds[widest + 6]:
            widest = axis
    if not by_count:
        for axis in range(3):
            low, extent = bounds[axis + 6], bounds[axis + 9] - bounds[axis + 6]
            if not extent > 0.0 or (end - first > 8192 and axis != widest):
                continue
            per = np.float32(BINS * (1.0 - 1e-6) / extent)
            for q in range(BINS):
                tallies[q] = 0
                for c in range(3):
                    bins[q, c], bins[q, c + 3] = np.inf, -np.inf
            for k in range(first, end):
                j = order[k]
                q = _bin(boxes, j, axis, low, per)
                tallies[q] += 1
                for c in range(3):
                    bins[q, c] = min(bins[q, c], boxes[j, c])
                    bins[q, c + 3] = max(bins[q, c + 3], boxes[j, c + 3])
            # Costs of what lies beyond each plane, then of both sides
            many = 0
            for c in range(3):
                box[c], box[c + 3] = np.inf, -np.inf
            for q in range(BINS - 1, 0, -1):
                many += tallies[q]
                for c in range(3):
                    box[c], box[c + 3] = min(box[c], bins[q, c]), max(box[c + 3], bins[q, c + 3])
                right[q] = _area(box) * many if many > 0 else np.inf
            many = 0
            for c in range(3):
                box[c], box[c + 3] = np.inf, -np.inf
            for q in range(1, BINS):
                many += tallies[q - 1]
                for c in range(3):
                    box[c], box[c + 3] = min(box[c], bins[q - 1, c]), max(box[c + 3], bins[q - 1, c + 3])
                cost = _area(box) * many + right[q] if many > 0 else np.inf
                if cost < best_cost:
                    best_cost, best_axis, best_bin = cost, axis, q
    if best_axis < 0:                               # all middles coincide, or the range lies too deep
        return (first + end) // 2
    axis = best_axis
    low = bounds[axis + 6]
    per = np.float32(BINS * (1.0 - 1e-6) / (bounds[axis + 9] - low))
    i, j = first, end - 1
    while True:
        while i <= j and _bin(boxes, order[i], axis, low, per) < best_bin:
            i += 1
        while i <= j and _bin(boxes, order[j], axis, low, per) >= best_bin:
            j -= 1
        if i >= j:
            return i
        order[i], order[j] = order[j], order[i]


@njit(nogil=True, cache=True, error_model="numpy")
def _build(corners, boxes, order, nodes, leaves, counts):
    """Fill nodes and leaves; returns both, grown where needed. counts: how many of each."""
    firsts, ends, bounds = np.zeros(WIDTH, np.int64), np.zeros(WIDTH, np.int64), np.zeros((WIDTH, 12), np.float32)
    bins, tallies = np.zeros((BINS, 6), np.float32), np.zeros(BINS, np.int64)
    right, box = np.zeros(BINS, np.float64), np.zeros(6, np.float32)
    waiting, held = np.zeros((WIDTH * (DEPTH + 32), 4), np.int64), 1    # ranges, nodes that hold them, depths
    waiting[0, 1] = len(order)
    node_count, leaf_count = 1, 0
    while held > 0:
        held -= 1
        first, end, node, deep = waiting[held, 0], waiting[held, 1], waiting[held, 2], waiting[held, 3]

        # Split the largest part until there are eight
        parts = 1
        firsts[0], ends[0] = first, end
        _bounds(boxes, order, first, end, bounds[0])
        while parts < WIDTH:
            largest, area = -1, np.float32(-1.0)
            for k in range(parts):
                if ends[k] - firsts[k] > WIDTH and _area(bounds[k]) > area:
                    largest, area = k, _area(bounds[k])
            if largest < 0:
                break
            begin, stop = firsts[largest], ends[largest]
            middle = _split(boxes, order, begin, stop, bounds[largest], deep > DEPTH - 24, bins, tallies, right,
                            box)
            if middle <= begin or middle >= stop:
                middle = (begin + stop) // 2
            firsts[parts], ends[parts], ends[largest] = middle, stop, middle
            _bounds(boxes, order, begin, middle, bounds[largest])
            _bounds(boxes, order, middle, stop, bounds[parts])
            parts += 1

        # Write the node, and a leaf for each small part
        for k in range(WIDTH):
            link = np.float32(0)
            for axis in range(3):
                low, high = (bounds[k, axis], bounds[k, axis + 3]) if k < parts else (np.float32(np.inf),
                                                                                      np.float32(-np.inf))
                nodes[node, 2 * axis * WIDTH + k], nodes[node, (2 * axis + 1) * WIDTH + k] = low, high
            if k < parts and ends[k] - firsts[k] <= WIDTH:
                leaves = _grown(leaves, leaf_count)
                for c in range(WIDTH):
                    place = firsts[k] + c
                    j = order[min(place, ends[k] - 1)]
                    for corner in range(3):
                        for axis in range(3):
                            # A leaf that is not full repeats one corner: a triangle that nothing meets
                            value = corners[j, corner if place < ends[k] else 0, axis]
                            leaves[leaf_count, (3 * corner + axis) * WIDTH + c] = value
                    leaves[leaf_count, NUMBERS * WIDTH + c] = np.float32(j)
                link = np.float32(-1 - leaf_count)
                leaf_count += 1
            elif k < parts:
                nodes = _grown(nodes, node_count)
                waiting[held, 0], waiting[held, 1] = firsts[k], ends[k]
                waiting[held, 2], waiting[held, 3] = node_count, deep + 1
                held += 1
                link = np.float32(node_count)
                node_count += 1
            nodes[node, LINKS * WIDTH + k], nodes[node, (LINKS + 1) * WIDTH + k] = link, np.float32(0)
    counts[0], counts[1] = node_count, leaf_count
    return nodes, leaves


def depth_of_stack(triangles: int) -> int:
    """Entries that a traversal needs: seven for each level."""
    return (WIDTH - 1) * (DEPTH + 2 + math.ceil(math.log2(max(triangles, 2))))
