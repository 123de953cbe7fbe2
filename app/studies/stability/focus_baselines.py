"""Rival ways to focus, of pbrt and of textbooks, which the sweeps compare with the program's.

Distances of the object from the film, film distances from the last vertex (mm), in the precision `real`.
"""

import math

import numpy as np

import lensbench as lb
from lensbench.optics.paraxial import first_order

STEPS = 2000            # after which a search is taken to have no end; pbrt's own has no bound
HALVINGS = 20


def school_formula(lens: lb.Lens, distance: float, real: type) -> float:
    """Half of the sum of the conjugates less the root of its square less 4 f: two great numbers, one from the other.

    NaN nearer than four focal lengths.
    """
    fo = first_order(lens)
    front, rear = real(fo.front_principal), real(lens.length + fo.rear_principal)
    efl, apart = real(fo.efl), real(distance) - (rear - front)
    with np.errstate(invalid="ignore"):
        behind = real(0.5) * (apart - np.sqrt(apart * (apart - real(4.0) * efl)))
    return float(behind + real(fo.rear_principal))


def focus_of_one_ray(lens: lb.Lens, film_distance: float, share: float, real: type) -> float | None:
    """The distance at which a ray of the film's centre meets the axis, aimed at `share` × the rear radius.

    math.inf where it does not converge before the lens; None where it is blocked.
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
    """By a ray at 0.15 of the rear radius: out from the closed form by parts of 0.005, and 20 halvings between.

    pbrt-v3's second way; its aim of 0.1 × a pupil box that is 1.5 radii wide. shares: what is tried in turn where
    the ray is blocked. The words "no end" where it goes on and on, and "NaN" where the closed form is none.
    """
    begin = school_formula(lens, distance, real)
    if not math.isfinite(begin):
        return "NaN"

    def seen(film: float) -> float:
        found = (focus_of_one_ray(lens, film, share, real) for share in shares)
        return next((at for at in found if at is not None), math.inf)

    near = far = begin                  # nearer to the lens the plane in focus lies farther out
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
