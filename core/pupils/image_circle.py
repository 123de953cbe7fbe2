"""Image circle: the end of the light on the film, for lenses of any symmetry. Lengths in mm, lens frame, float64."""

import numpy as np

from lensbench.pupils.ray_aiming import Aim

PLACES = 16             # multiples of each direction, to find the last one with light
ITERATIONS = 7          # of false position between two multiples
NO_LIGHT = 2.0          # largest clearance that the iteration uses; beyond it, it may be infinite


def edge_of_light(aim: Aim, directions: np.ndarray, furthest: float) -> tuple[np.ndarray, bool]:
    """Multiples (n,) of vectors (n, 2) mm from the film's centre up to which light falls, and whether any light ends.

    `furthest` where light reaches that multiple, or where no multiple has light.
    """
    n = len(directions)
    multiples = furthest * np.arange(1, PLACES + 1) / PLACES
    lit = aim.find_light((multiples[:, None, None] * directions).reshape(-1, 2))[1].reshape(PLACES, n) < 1.0
    last = np.where(lit.any(0), PLACES - 1 - np.argmax(lit[::-1], 0), PLACES - 1)
    edge = multiples[last]
    which = np.flatnonzero(last < PLACES - 1)
    if not which.size:
        return edge, False

    # The least clearance is 1 at the end of the light: false position, Illinois form
    def level(multiple: np.ndarray) -> np.ndarray:
        """Least clearance − 1 of the rays of film points at these multiples."""
        film = multiple[:, None] * directions[which]
        centre, window = aim.stop_centres(film, aim.paraxial_centres(film))
        return np.minimum(aim.scan(film, centre, window, 0.0)[1], NO_LIGHT) - 1.0

    low, high = edge[which], multiples[last[which] + 1]
    at_low, at_high, side = np.minimum(level(low), -1e-9), np.maximum(level(high), 1e-9), np.zeros(which.size)
    for _ in range(ITERATIONS):
        multiple = np.clip(high - at_high * (high - low) / (at_high - at_low), low, high)
        here = level(multiple)
        dark = ~(here < 0.0)
        at_low = np.where(dark, np.where(side > 0.0, 0.5 * at_low, at_low), here)
        at_high = np.where(dark, here, np.where(side < 0.0, 0.5 * at_high, at_high))
        low, high, side = np.where(dark, low, multiple), np.where(dark, multiple, high), np.where(dark, 1.0, -1.0)
    edge[which] = low
    return edge, True
