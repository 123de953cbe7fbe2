"""Search of a tree of triangles for what one ray meets: the nearest triangle, or any at all.

Of the boxes that a ray enters, the nearest is searched first; the others wait on a stack with the distances at which
the ray enters them, and are passed over if a triangle was found before these.
"""

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.kernels.eights import LINKS, NUMBERS, WIDTH, boxes_met, lowest_bit, triangles_met
from lensbench.scenery.intersect.triangle_tree import LEAF, NODE

STEEPEST = 1e18         # greatest inverse of a component of a direction
NONE = -1               # number of no triangle


@njit(inline="always")
def _inverse(real, x):
    """1 / x, finite."""
    least = real(1 / STEEPEST)
    x = x if abs(x) > least else (least if x >= real(0) else -least)
    return real(1) / x


@njit(inline="always")
def _near_side(x):
    """Offset of the side of a box that a ray of this inverse component meets first."""
    return np.intp(0) if x > 0 else np.intp(WIDTH)


@njit(inline="always")
def search(real, nodes, leaves, origin, direction, most, any_one, links, entries, found):
    """Number of the nearest triangle before `most`, or of any; its distance, and weights of two corners; NONE: none.

    nodes, leaves: float32, flat. links (int32), entries, found (24): scratch. any_one: true for shadows.
    """
    inverse = (_inverse(real, direction[0]), _inverse(real, direction[1]), _inverse(real, direction[2]))
    near = (_near_side(inverse[0]), _near_side(inverse[1]), _near_side(inverse[2]))
    best, number, second, third = most, np.int32(NONE), real(0), real(0)
    links[0], entries[0], top = np.int32(0), real(0), np.uint64(1)
    one = np.uint64(1)
    while top > np.uint64(0):
        top -= one
        if entries[top] >= best:
            continue
        link = links[top]
        while link >= np.int32(0):
            place = np.intp(link) * NODE
            mask = boxes_met(nodes, place, near, origin, inverse, best, found)
            if mask == np.int32(0):
                break

            # Go on with the nearest box; the others wait
            which = lowest_bit(mask)
            mask &= mask - np.int32(1)
            first, where = np.uint64(place + LINKS * WIDTH), found[np.uint64(which)]
            link = np.int32(nodes[first + np.uint64(which)])
            while mask != np.int32(0):
                which = lowest_bit(mask)
                mask &= mask - np.int32(1)
                other, entry = np.int32(nodes[first + np.uint64(which)]), found[np.uint64(which)]
                nearer = entry < where
                links[top], entries[top] = link if nearer else other, where if nearer else entry
                link, where = other if nearer else link, entry if nearer else where
                top += one
        else:
            leaf = np.intp(-1 - link) * LEAF
            mask = triangles_met(leaves, leaf, origin, direction, real(0), best, found)
            while mask != np.int32(0):
                which = np.uint64(lowest_bit(mask))
                mask &= mask - np.int32(1)
                if found[which] < best:
                    best, number = found[which], np.int32(leaves[np.uint64(leaf + NUMBERS * WIDTH) + which])
                    second, third = found[which + np.uint64(WIDTH)], found[which + np.uint64(2 * WIDTH)]
                    if any_one:
                        return number, best, second, third
    return number, best, second, third
