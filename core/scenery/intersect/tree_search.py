"""Search of a tree of triangles for what rays meet: the nearest triangle, or any at all.

Of the boxes that a ray enters, the nearest is searched first; the others wait on a stack with the distances at which
the ray enters them, and are passed over if a triangle was found before these. Sixteen rays whose directions have the
same signs go down the tree together as long as more than FEW of them enter the same boxes, then each by itself (as in
Benthin, Wald, Woop, Ernst and Mark 2012, "Combining single and packet-ray tracing").
"""

from typing import NamedTuple

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.kernels.eights import (
    DIRECTION,
    GROUP,
    GROUP_ROWS,
    INVERSE,
    LINKS,
    MOST,
    NUMBERS,
    ORIGIN,
    SECOND,
    THIRD,
    WIDTH,
    box_met,
    boxes_met,
    count_of_bits,
    lowest_bit,
    triangles_met,
)
from lensbench.scenery.intersect.triangle_tree import LEAF, NODE

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
def search(real, nodes, leaves, origin, direction, inverse, most, any_one, links, entries, found, start=0):
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


class Scratch(NamedTuple):
    """What the search of a group works with: stacks, what was found last, the group itself."""

    links: np.ndarray       # (stack,) int32; of one ray
    entries: np.ndarray     # (stack,)
    found: np.ndarray       # (24,)
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
    group, numbers, found = scratch.group, scratch.numbers, scratch.found
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
                    scratch.entries, found, link)
                if number >= 0:
                    numbers[ray], group[np.uint64(MOST * GROUP) + ray] = number, real(-1) if any_one else t
                    group[np.uint64(SECOND * GROUP) + ray], group[np.uint64(THIRD * GROUP) + ray] = second, third
            continue
        place, base = np.intp(link) * NODE, top
        for k in range(WIDTH):
            bits, entry = box_met(nodes, place + k, near, group)
            bits &= mask
            if bits == np.int32(0):
                continue
            at = top                                # the nearest on top
            while at > base and entries[at - one] < entry:
                links[at], entries[at], masks[at] = links[at - one], entries[at - one], masks[at - one]
                at -= one
            links[at], entries[at], masks[at] = np.int32(nodes[place + LINKS * WIDTH + k]), entry, bits
            top += one
