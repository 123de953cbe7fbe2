"""Image circle: the end of the light on the film, for lenses of any symmetry. Lengths in mm, lens frame, float64."""

import math
from collections.abc import Callable

import numpy as np

from lensbench.imaging.film_pose import UPRIGHT
from lensbench.pupils.ray_aiming import Aim

PLACES = 16             # multiples of each direction, to find the last one with light
FINER = 3               # times that the first multiple is divided alike where it is dark: films of 65 000 image circles
ITERATIONS = 4          # of false position between two multiples: within 2e-4 of the film, mostly 1e-5
Placement = Callable[[np.ndarray], np.ndarray]
NO_LIGHT = 2.0          # largest clearance that the iteration uses; beyond it, it may be infinite


def edge_of_light(aim: Aim, directions: np.ndarray, furthest: float,
                  place: Placement = UPRIGHT.points) -> tuple[np.ndarray, bool]:
    """Multiples (n,) of vectors (n, 2) mm from the film's centre up to which light falls, and whether any light ends.

    `furthest` where light reaches that multiple, or where no multiple has light. place: camera-frame points (n, 3) of
    film points (n, 2).
    """
    edge, beyond = np.full(len(directions), furthest), np.full(len(directions), math.inf)
    which, reach = np.arange(len(directions)), furthest
    for _ in range(1 + FINER):
        multiples = reach * np.arange(1, PLACES + 1) / PLACES
        film = place((multiples[:, None, None] * directions[which]).reshape(-1, 2))
        lit = aim.find_light(film)[1].reshape(PLACES, len(which)) < 1.0
        last, any_light = PLACES - 1 - np.argmax(lit[::-1], 0), lit.any(0)
        edge[which[any_light]] = multiples[last[any_light]]
        ends = any_light & (last < PLACES - 1)
        beyond[which[ends]] = multiples[last[ends] + 1]
        which, reach = which[~any_light], multiples[0]
        if not which.size:
            break
    which = np.flatnonzero(beyond < math.inf)
    if not which.size:
        return edge, False

    # The least clearance is 1 at the end of the light: false position, Illinois form
    def level(multiple: np.ndarray, near: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Least clearance − 1 of the rays of film points at these multiples, and the stop's centres (n, 2) seen there.

        near: rear points near those centres, None where none are known.
        """
        film = place(multiple[:, None] * directions[which])
        centre, window = (aim.stop_centres(film, aim.paraxial_centres(film)) if near is None else
                          aim.stop_centres_near(film, near))
        return np.minimum(aim.scan(film, centre, window, 0.0)[1], NO_LIGHT) - 1.0, centre

    low, high = edge[which], beyond[which]
    at_low, centre = level(low)
    at_high, centre = level(high, centre)
    at_low, at_high, side = np.minimum(at_low, -1e-9), np.maximum(at_high, 1e-9), np.zeros(which.size)
    for _ in range(ITERATIONS):
        multiple = np.clip(high - at_high * (high - low) / (at_high - at_low), low, high)
        here, centre = level(multiple, centre)
        dark = ~(here < 0.0)
        at_low = np.where(dark, np.where(side > 0.0, 0.5 * at_low, at_low), here)
        at_high = np.where(dark, here, np.where(side < 0.0, 0.5 * at_high, at_high))
        low, high, side = np.where(dark, low, multiple), np.where(dark, multiple, high), np.where(dark, 1.0, -1.0)
    edge[which] = low
    return edge, True
