"""Focusing methods of pbrt and of textbooks, for comparison with the program's methods.

Object distances are measured from the film, film distances from the last vertex (mm). Each method computes in the
precision `real`.
"""

import math

import numpy as np

import lensbench as lb
from lensbench.optics.paraxial import first_order

STEPS = 2000            # a search that takes more steps counts as endless; pbrt's search has no bound
HALVINGS = 20


def school_formula(lens: lb.Lens, distance: float, real: type) -> float:
    """Film distance by the textbook formula: half of (sum of the conjugates less √(sum² − 4 f · sum)).

    It subtracts two large numbers. NaN nearer than four focal lengths.
    """
    fo = first_order(lens)
    front, rear = real(fo.front_principal), real(lens.length + fo.rear_principal)
    efl, apart = real(fo.efl), real(distance) - (rear - front)
    with np.errstate(invalid="ignore"):
        behind = real(0.5) * (apart - np.sqrt(apart * (apart - real(4.0) * efl)))
    return float(behind + real(fo.rear_principal))


def focus_of_one_ray(lens: lb.Lens, film_distance: float, share: float, real: type) -> float | None:
    """Distance at which a ray from the centre of the film crosses the axis, aimed at `share` × the rear radius.

    math.inf if the ray does not converge in front of the lens; None if it is blocked.
    """
    height = share * lens.surfaces[-1].semi_diameter
    film = lens.length + film_distance
    t = lb.trace(lens, [0.0, 0.0, film], [0.0, height, -film_distance], dtype=real, forward=False)
    if t.fate[0] != lb.Fate.PASSED:
        return None
    (_, y, z), (_, dy, dz) = t.points[0], t.directions[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = float(z - y / dy * dz)
    return film - meets if meets < z else math.inf


def bracketing_search(lens: lb.Lens, distance: float, real: type, shares: tuple[float, ...] = (0.15,)) -> float | str:
    """Film distance by one ray at 0.15 of the rear radius: bracketed in steps of 0.005, then 20 halvings.

    The second method of pbrt-v3; there the ray aims at 0.1 × a pupil box that is 1.5 radii wide. shares: tried in this
    order where the ray is blocked. Returns "no end" if the search does not end, "NaN" if the closed form has no value.
    """
    begin = school_formula(lens, distance, real)
    if not math.isfinite(begin):
        return "NaN"

    def seen(film: float) -> float:
        found = (focus_of_one_ray(lens, film, share, real) for share in shares)
        return next((at for at in found if at is not None), math.inf)

    near = far = begin                  # a film nearer to the lens puts the plane in focus farther away
    for _ in range(STEPS):
        if seen(far) <= distance:
            break
        far *= 1.005
    else:
        return "no end"
    for _ in range(STEPS):
        if seen(near) >= distance:
            break
        near *= 0.995
    else:
        return "no end"
    for _ in range(HALVINGS):
        middle = float(real(0.5) * (real(near) + real(far)))
        near, far = (middle, far) if seen(middle) >= distance else (near, middle)
    return 0.5 * (near + far)
