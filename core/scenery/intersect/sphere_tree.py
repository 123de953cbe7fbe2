"""A tree over spheres, so that what holds for many of them is found once for all.

The tree is a list in preorder: a node comes before the nodes and spheres below it, and an integer says how many of them
follow. A stage that is done with a node goes on behind these. The spheres of a small scene make a plain list.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

CROWD = 8               # a node is halved until it holds no more spheres; a scene of twice as many has a tree


class Entry(NamedTuple):
    """A sphere, or a node with all spheres below it."""

    members: np.ndarray         # indices of the spheres
    below: int                  # entries that follow and belong to it: 0 for a sphere


def sphere_tree(centres: np.ndarray) -> list[Entry]:
    """Entries in preorder for spheres with these centres (n, 3), halved along the widest side of a node."""
    everything = np.arange(len(centres))
    if len(centres) <= 2 * CROWD:
        return [Entry(everything[j:j + 1], 0) for j in everything]
    return _below(np.asarray(centres, np.float64), everything)


def _below(centres: np.ndarray, which: np.ndarray) -> list[Entry]:
    """Entries below a node, without its own."""
    if len(which) <= CROWD:
        return [Entry(which[j:j + 1], 0) for j in range(len(which))]
    order = which[np.argsort(centres[which, np.argmax(np.ptp(centres[which], 0))], kind="stable")]
    entries = []
    for half in (order[:len(order) // 2], order[len(order) // 2:]):
        inner = _below(centres, half)
        entries += [Entry(half, len(inner)), *inner]
    return entries


def counts_below(entries: Sequence[Entry]) -> list[int]:
    """How many entries follow each and belong to it."""
    return [entry.below for entry in entries]


def bounding_sphere(centres: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of a sphere around spheres, larger by what float32 may round."""
    middle = (centres.min(0) + centres.max(0)) / 2
    return middle, float((np.linalg.norm(centres - middle, axis=1) + radii).max()) * (1.0 + 1e-5)
