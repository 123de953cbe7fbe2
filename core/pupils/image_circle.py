"""Where on the film the light ends, for lenses of any symmetry. Lengths in mm, lens frame, float64."""

import numpy as np

from lensbench.pupils.ray_aiming import Aim

LOOKS = 16              # along each way, for the last place with light
ROUNDS = 7              # to close in on the end between two looks
NO_LIGHT = 2.0          # for a root margin beyond it, which may be infinite


def edge_of_light(aim: Aim, ways: np.ndarray, furthest: float) -> tuple[np.ndarray, bool]:
    """How far along ways (n, 2) from the film's centre light falls, as multiples (n,) of each, and whether it ends.

    The last place with light; `furthest` where it goes on to there, or where there is none at all.
    """
    n = len(ways)
    looks = furthest * np.arange(1, LOOKS + 1) / LOOKS
    lit = aim.find_light((looks[:, None, None] * ways).reshape(-1, 2))[1].reshape(LOOKS, n) < 1.0
    last = np.where(lit.any(0), LOOKS - 1 - np.argmax(lit[::-1], 0), LOOKS - 1)
    edge = looks[last]
    which = np.flatnonzero(last < LOOKS - 1)
    if not which.size:
        return edge, False

    # The least root margin is 1 at the end: false position, Illinois form
    def level(place: np.ndarray) -> np.ndarray:
        film = place[:, None] * ways[which]
        centre, window = aim.stop_centres(film, aim.paraxial_centres(film))
        return np.minimum(aim.scan(film, centre, window, 0.0)[1], NO_LIGHT) - 1.0

    low, high = edge[which], looks[last[which] + 1]
    at_low, at_high, side = np.minimum(level(low), -1e-9), np.maximum(level(high), 1e-9), np.zeros(which.size)
    for _ in range(ROUNDS):
        place = np.clip(high - at_high * (high - low) / (at_high - at_low), low, high)
        here = level(place)
        dark = ~(here < 0.0)
        at_low = np.where(dark, np.where(side > 0.0, 0.5 * at_low, at_low), here)
        at_high = np.where(dark, here, np.where(side < 0.0, 0.5 * at_high, at_high))
        low, high, side = np.where(dark, low, place), np.where(dark, place, high), np.where(dark, 1.0, -1.0)
    edge[which] = low
    return edge, True
