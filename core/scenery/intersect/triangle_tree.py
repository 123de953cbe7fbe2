"""A tree of triangles: nodes of eight boxes, leaves of eight triangles, in the layout of `kernels.eights`.

The builder halves the largest box of a node until there are eight, each time where the sum of area times triangles of
both halves is least, among planes through the middles of the triangles (surface area heuristic in bins: Wald 2007).

A search finds the nearest triangle that a ray meets, or any. Of the boxes that a ray enters, the nearest is searched
first; the others wait on a stack with the distances at which the ray enters them, and are passed over if a triangle was
found before these. Sixteen rays whose directions have the same signs go down the tree together as long as more than FEW
of them enter the same boxes, then each by itself (as in Benthin, Wald, Woop, Ernst and Mark 2012, "Combining single and
packet-ray tracing").
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.eights import (
    DIRECTION, GROUP, GROUP_ROWS, INVERSE, LEAF_ROWS, LINKS, MOST, NODE_ROWS, NUMBERS, ORIGIN, SECOND, THIRD, WIDTH,
    box_met, boxes_met, count_of_bits, lowest_bit, triangles_met
)

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
    aligned = raw[skip:skip + table.size].reshape(table.shape)
    aligned[:] = table
    return aligned


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
            count = 0
            for c in range(3):
                box[c], box[c + 3] = np.inf, -np.inf
            for q in range(BINS - 1, 0, -1):
                count += tallies[q]
                for c in range(3):
                    box[c], box[c + 3] = min(box[c], bins[q, c]), max(box[c + 3], bins[q, c + 3])
                right[q] = _area(box) * count if count > 0 else np.inf
            count = 0
            for c in range(3):
                box[c], box[c + 3] = np.inf, -np.inf
            for q in range(1, BINS):
                count += tallies[q - 1]
                for c in range(3):
                    box[c], box[c + 3] = min(box[c], bins[q - 1, c]), max(box[c + 3], bins[q - 1, c + 3])
                cost = _area(box) * count + right[q] if count > 0 else np.inf
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
    waiting, top = np.zeros((WIDTH * (DEPTH + 32), 4), np.int64), 1    # ranges, nodes that hold them, depths
    waiting[0, 1] = len(order)
    node_count, leaf_count = 1, 0
    while top > 0:
        top -= 1
        first, end, node, deep = waiting[top, 0], waiting[top, 1], waiting[top, 2], waiting[top, 3]

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
                    index = firsts[k] + c
                    j = order[min(index, ends[k] - 1)]
                    for corner in range(3):
                        for axis in range(3):
                            # A leaf that is not full repeats one corner: a triangle that nothing meets
                            value = corners[j, corner if index < ends[k] else 0, axis]
                            leaves[leaf_count, (3 * corner + axis) * WIDTH + c] = value
                    leaves[leaf_count, NUMBERS * WIDTH + c] = np.float32(j)
                link = np.float32(-1 - leaf_count)
                leaf_count += 1
            elif k < parts:
                nodes = _grown(nodes, node_count)
                waiting[top, 0], waiting[top, 1] = firsts[k], ends[k]
                waiting[top, 2], waiting[top, 3] = node_count, deep + 1
                top += 1
                link = np.float32(node_count)
                node_count += 1
            nodes[node, LINKS * WIDTH + k], nodes[node, (LINKS + 1) * WIDTH + k] = link, np.float32(0)
    counts[0], counts[1] = node_count, leaf_count
    return nodes, leaves


def depth_of_stack(triangles: int) -> int:
    """Entries that a traversal needs: seven for each level."""
    return (WIDTH - 1) * (DEPTH + 2 + math.ceil(math.log2(max(triangles, 2))))


STEEPEST = 1e18         # greatest inverse of a component of a direction
NONE = -1               # number of no triangle
FEW = 3                 # rays of a group that go on one by one: the times of 2 to 6 differ by a fifteenth
ALL = (1 << GROUP) - 1


@njit(inline="always")
def _inverse(real, x):
    """1 / x, finite."""
    least = real(1 / STEEPEST)
    x = x if abs(x) > least else (least if x >= real(0) else -least)
    return real(1) / x


@njit(inline="always")
def inverse_of(real, direction):
    """Inverse components of a direction, finite."""
    return _inverse(real, direction[0]), _inverse(real, direction[1]), _inverse(real, direction[2])


@njit(inline="always")
def _near_side(x):
    """Offset of the side of a box that a ray of this inverse component meets first."""
    return np.intp(0) if x > 0 else np.intp(WIDTH)


@njit(inline="always")
def search(real, nodes, leaves, origin, direction, inverse, most, any_one, links, entries, distances, start=0):
    """Number of the nearest triangle before `most`, or of any; its distance, and weights of two corners; NONE: none.

    nodes, leaves: float32, flat. inverse: `inverse_of` the direction. any_one: true for shadows. links (int32),
    entries, found (24): scratch. start: the node to begin with, or −1 − the leaf.
    """
    near = (_near_side(inverse[0]), _near_side(inverse[1]), _near_side(inverse[2]))
    best, number, second, third = most, np.int32(NONE), real(0), real(0)
    links[0], entries[0], top = np.int32(start), real(0), np.uint64(1)
    one = np.uint64(1)
    while top > np.uint64(0):
        top -= one
        if entries[top] >= best:
            continue
        link = links[top]
        while link >= np.int32(0):
            node = np.intp(link) * NODE
            mask = boxes_met(nodes, node, near, origin, inverse, best, distances)
            if mask == np.int32(0):
                break

            # Go on with the nearest box; the others wait
            which = lowest_bit(mask)
            mask &= mask - np.int32(1)
            first, where = np.uint64(node + LINKS * WIDTH), distances[np.uint64(which)]
            link = np.int32(nodes[first + np.uint64(which)])
            while mask != np.int32(0):
                which = lowest_bit(mask)
                mask &= mask - np.int32(1)
                other, entry = np.int32(nodes[first + np.uint64(which)]), distances[np.uint64(which)]
                nearer = entry < where
                links[top], entries[top] = link if nearer else other, where if nearer else entry
                link, where = other if nearer else link, entry if nearer else where
                top += one
        else:
            leaf = np.intp(-1 - link) * LEAF
            mask = triangles_met(leaves, leaf, origin, direction, real(0), best, distances)
            while mask != np.int32(0):
                which = np.uint64(lowest_bit(mask))
                mask &= mask - np.int32(1)
                if distances[which] < best:
                    best, number = distances[which], np.int32(leaves[np.uint64(leaf + NUMBERS * WIDTH) + which])
                    second, third = distances[which + np.uint64(WIDTH)], distances[which + np.uint64(2 * WIDTH)]
                    if any_one:
                        return number, best, second, third
    return number, best, second, third


class Scratch(NamedTuple):
    """What the search of a group works with: stacks, what was found last, the group itself."""

    links: np.ndarray       # (stack,) int32; of one ray
    entries: np.ndarray     # (stack,)
    distances: np.ndarray   # (24,), as of `triangles_met`
    group_links: np.ndarray     # (stack,) int32
    group_entries: np.ndarray   # (stack,): the least of the rays
    group_masks: np.ndarray     # (stack,) int32: the rays that enter
    group: np.ndarray       # (GROUP_ROWS · GROUP,): rows of `kernels.eights`
    numbers: np.ndarray     # (GROUP,) int32: of the triangles found


@njit(inline="always")
def scratch_of(real, stack):
    """Scratch for a tree whose stack has `stack` entries."""
    return Scratch(np.empty(stack, np.int32), np.empty(stack, real), np.empty(24, real), np.empty(stack, np.int32),
                   np.empty(stack, real), np.empty(stack, np.int32), np.empty(GROUP_ROWS * GROUP, real),
                   np.empty(GROUP, np.int32))


@njit(inline="always")
def place_ray(real, group, j, origin, direction, most):
    """Make a ray the number j of a group; one that is not to be searched has most < 0."""
    j = np.uint64(j)
    for axis in range(3):
        group[np.uint64((ORIGIN + axis) * GROUP) + j] = origin[axis]
        group[np.uint64((DIRECTION + axis) * GROUP) + j] = direction[axis]
    group[np.uint64(MOST * GROUP) + j] = most


@njit(inline="always")
def _three(group, row, j):
    """Three numbers of a ray of a group, from `row` on."""
    return (group[np.uint64(row * GROUP) + j], group[np.uint64((row + 1) * GROUP) + j],
            group[np.uint64((row + 2) * GROUP) + j])


@njit(inline="always")
def search_group(real, nodes, leaves, any_one, scratch):
    """What `search` finds for each of the rays placed in `scratch.group`: numbers, MOST, SECOND and THIRD of the rows.

    nodes, leaves: float32, flat. any_one: true for shadows. Of two triangles at the same distance either is found.
    """
    links, entries, masks = scratch.group_links, scratch.group_entries, scratch.group_masks
    group, numbers, distances = scratch.group, scratch.numbers, scratch.distances
    for k in range(3 * GROUP):
        group[INVERSE * GROUP + k] = _inverse(real, group[DIRECTION * GROUP + k])
    live, x, y, z = np.int32(0), np.int32(0), np.int32(0), np.int32(0)
    for j in range(GROUP):
        lx, ly = group[DIRECTION * GROUP + j], group[(DIRECTION + 1) * GROUP + j]
        lz = group[(DIRECTION + 2) * GROUP + j]
        searched = (group[MOST * GROUP + j] > real(0)) & (lx * lx + ly * ly + lz * lz > real(0.5))
        group[MOST * GROUP + j] = group[MOST * GROUP + j] if searched else real(-1)
        live += np.int32(searched)
        x += np.int32(searched & (group[INVERSE * GROUP + j] > real(0)))
        y += np.int32(searched & (group[(INVERSE + 1) * GROUP + j] > real(0)))
        z += np.int32(searched & (group[(INVERSE + 2) * GROUP + j] > real(0)))
    alike = ((x == 0) | (x == live)) & ((y == 0) | (y == live)) & ((z == 0) | (z == live))
    one_by_one = np.int32(FEW if alike else GROUP)
    near = (_near_side(x), _near_side(y), _near_side(z))
    for j in range(GROUP):
        numbers[j] = np.int32(NONE)
    links[0], entries[0], masks[0], top = np.int32(0), real(0), np.int32(ALL), np.uint64(1)
    one = np.uint64(1)
    while top > np.uint64(0):
        top -= one
        link, mask = links[top], np.int32(0)
        for j in range(GROUP):
            mask |= np.int32(group[MOST * GROUP + j] > entries[top]) << np.int32(j)
        mask &= masks[top]
        if link < np.int32(0) or count_of_bits(mask) <= one_by_one:
            while mask != np.int32(0):
                ray = np.uint64(lowest_bit(mask))
                mask &= mask - np.int32(1)
                number, t, second, third = search(
                    real, nodes, leaves, _three(group, ORIGIN, ray), _three(group, DIRECTION, ray),
                    _three(group, INVERSE, ray), group[np.uint64(MOST * GROUP) + ray], any_one, scratch.links,
                    scratch.entries, distances, link)
                if number >= 0:
                    numbers[ray], group[np.uint64(MOST * GROUP) + ray] = number, real(-1) if any_one else t
                    group[np.uint64(SECOND * GROUP) + ray], group[np.uint64(THIRD * GROUP) + ray] = second, third
            continue
        node, base = np.intp(link) * NODE, top
        for k in range(WIDTH):
            bits, entry = box_met(nodes, node + k, near, group)
            bits &= mask
            if bits == np.int32(0):
                continue
            slot = top                                # the nearest on top
            while slot > base and entries[slot - one] < entry:
                links[slot], entries[slot], masks[slot] = links[slot - one], entries[slot - one], masks[slot - one]
                slot -= one
            links[slot], entries[slot], masks[slot] = np.int32(nodes[node + LINKS * WIDTH + k]), entry, bits
            top += one
