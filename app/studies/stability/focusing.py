"""Film distance for an object distance: closed form, least blur of the bundle, and methods of pbrt and textbooks.

Object distances are measured from the film, film distances from the last vertex (mm). Each rival method computes in
the precision `real`.
"""

import math
from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability.refraction import exact, exactly
from lensbench.app.studies.stability.sweep import PRECISIONS, Curve, Sweep, curve
from lensbench.core.optics.paraxial import first_order

STEPS = 2000            # a search that takes more steps counts as endless; pbrt's search has no bound
HALVINGS = 20


def school_formula(lens: lb.Lens, distance: float, real: type) -> float:
    """Half of (sum of the conjugates less √(sum² − 4 f · sum)), a difference of large numbers; NaN nearer than 4 f."""
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

    def in_focus(film: float) -> float:
        foci = (focus_of_one_ray(lens, film, share, real) for share in shares)
        return next((focus for focus in foci if focus is not None), math.inf)

    near = far = begin                  # a film nearer to the lens puts the plane in focus farther away
    for _ in range(STEPS):
        if in_focus(far) <= distance:
            break
        far *= 1.005
    else:
        return "no end"
    for _ in range(STEPS):
        if in_focus(near) >= distance:
            break
        near *= 0.995
    else:
        return "no end"
    for _ in range(HALVINGS):
        middle = float(real(0.5) * (real(near) + real(far)))
        near, far = (middle, far) if in_focus(middle) >= distance else (near, middle)
    return 0.5 * (near + far)


Focus = Callable[[lb.Lens, float], float | str]

LENS = "pbrt-wide-22mm"         # pbrt's failures were found on this lens
FAST = "lentil-takumar-1969"    # f/1.25
LIMIT = 1e-3                    # mm
WHY = "a quarter of a pixel of 4 µm"
RAYS = 200                      # rays of the bundle that defines the least blur
PIXEL = 4e-3                    # mm


def conjugate(lens: lb.Lens, distance: float) -> Decimal:
    """Exact paraxial film distance of an object `distance` mm from the film, within `exactly()`; NaN without one."""
    one, zero = Decimal(1), Decimal(0)
    a, b, c, d = one, zero, zero, one
    n = list(exact(lens.indices()))
    curvatures, gaps = (exact([getattr(s, what) for s in lens.surfaces]) for what in ("curvature", "thickness"))
    for i, curvature in enumerate(curvatures):
        power = (n[i + 1] - n[i]) * curvature
        c, d = c - power * a, d - power * b
        if i < len(gaps) - 1:
            gap = gaps[i] / n[i + 1]
            a, b = a + gap * c, b + gap * d
    if math.isinf(distance):
        return -a / c
    # An axis point x before the first vertex and the film f behind the last: (a + f c) x + b + f d = 0
    away = Decimal(distance) - sum(gaps[:-1])
    p, q = c * away - a + d, a * away + b
    inner = p * p + 4 * c * q
    # where p is positive the object would be virtual
    return (p + inner.sqrt()) / (2 * c) if inner >= 0 and p < 0 else Decimal("NaN")


def rms_radius(lens: lb.Lens, film_distance: float, distance: float) -> float:
    """Rms radius (mm) of the spot of an axis point `distance` mm from the film, by the scalar tracer."""
    y, slope = _bundle(lens, lens.length + film_distance - distance)
    return float(np.sqrt(((y + film_distance * slope) ** 2).mean()))


def extent(lens: lb.Lens, film_distance: float, distance: float) -> float:
    """Radius (mm) of the whole spot."""
    y, slope = _bundle(lens, lens.length + film_distance - distance)
    return float(np.abs(y + film_distance * slope).max())


def _bundle(lens: lb.Lens, z: float) -> tuple[np.ndarray, np.ndarray]:
    """Heights behind the last vertex (mm) and slopes of rays from the axis point z, even over the pupil."""
    edge, step = 0.0, lens.surfaces[0].semi_diameter
    for _ in range(8):                                  # search outwards in ever finer steps
        heights = edge + step * np.arange(33) / 32.0
        passed = _traced(lens, z, heights).fate == lb.Fate.PASSED
        last = int(np.argmin(passed)) - 1 if not passed.all() else 32
        edge, step = float(heights[max(last, 0)]), step / 32.0
    heights = edge * np.sqrt((np.arange(RAYS) + 0.5) / RAYS)
    t = _traced(lens, z, heights)
    slope = t.directions[:, 1] / t.directions[:, 2]
    return t.points[:, 1] + (lens.length - t.points[:, 2]) * slope, slope


def _traced(lens: lb.Lens, z: float, heights: np.ndarray) -> lb.Trace:
    """Traced rays from the axis point z through heights on the plane of the first vertex."""
    start = np.stack([0.0 * heights, heights, 0.0 * heights], 1)
    ways = np.stack([0.0 * heights, 0.0 * heights if math.isinf(z) else heights / -z, np.ones(len(heights))], 1)
    return lb.trace(lens, start, ways)


def least_blur(lens: lb.Lens, distance: float, size: Callable[[lb.Lens, float, float], float] = rms_radius) -> float:
    """Film distance (mm) of the smallest spot: golden-section search around the paraxial film."""
    with exactly():
        middle = float(conjugate(lens, distance))
    reach = 0.05 * lb.first_order(lens).efl
    low, high = middle - reach, middle + 0.2 * reach
    golden = 0.5 * (math.sqrt(5.0) - 1.0)
    places = [high - golden * (high - low), low + golden * (high - low)]
    sizes = [size(lens, film, distance) for film in places]
    for _ in range(22):
        if sizes[0] < sizes[1]:
            high, places[1], sizes[1] = places[1], places[0], sizes[0]
            places[0] = high - golden * (high - low)
            sizes[0] = size(lens, places[0], distance)
        else:
            low, places[0], sizes[0] = places[0], places[1], sizes[1]
            places[1] = low + golden * (high - low)
            sizes[1] = size(lens, places[1], distance)
    return 0.5 * (low + high)


def closed_form(lens: lb.Lens, distance: float) -> float | str:
    """The program's paraxial film distance (mm)."""
    try:
        return lb.film_distance(lens, distance)
    except lb.FocusError:
        return "FocusError"


def whole_bundle(lens: lb.Lens, distance: float) -> float | str:
    """The program's film distance (mm) of least rms blur."""
    try:
        return lb.film_distance(lens, distance, "real")
    except lb.FocusError:
        return "FocusError"


def one_ray(lens: lb.Lens, distance: float) -> float | str:
    """Film distance (mm) by the search with one ray, in double precision."""
    return bracketing_search(lens, distance, np.float64)


def three_rays(lens: lb.Lens, distance: float) -> float | str:
    """Film distance (mm) by the search that tries narrower rays where one is blocked, as pbrt does since its fix."""
    return bracketing_search(lens, distance, np.float64, (0.15, 0.015, 0.0015))


def _off(film: float | str, truth: float | Decimal) -> float | str:
    """Error of a film distance (mm), or the text that was returned instead."""
    if isinstance(film, str):
        return film
    if not math.isfinite(film):
        return "NaN"
    if not math.isfinite(truth):
        return "a film distance where none exists"
    return float(abs(Decimal(film) - Decimal(truth)))


def _conjugates(title: str, values: np.ndarray, rivals: dict[str, Focus], note: str) -> Sweep:
    """Film distances of the closed form, the school formula and other rivals, against the exact ones."""
    lens = lenses.load(LENS)
    methods: dict[str, Focus] = {f"school formula, {precision}": partial(school_formula, real=real)
                                 for real, precision in PRECISIONS}
    methods |= {**rivals, "closed form": closed_form}
    with exactly():
        truth = [conjugate(lens, distance) for distance in values]
        curves = [curve(name, [_off(focus(lens, distance), film) for distance, film in zip(values, truth, strict=True)],
                        focus is closed_form)
                  for name, focus in methods.items()]
    expected = tuple("" if film.is_finite() else "FocusError" for film in truth)
    return Sweep(title, "Distance of the object", "mm", values, "Place of the film", "mm", LIMIT, WHY + " at f/1",
                 tuple(curves), note, expected=expected if any(expected) else ())


def far_focus() -> Sweep:
    """Object distances from a metre to ten kilometres and beyond."""
    return _conjugates(
        "Far focus", np.logspace(3.0, 10.0, 29),
        {f"one ray, {precision}": partial(bracketing_search, real=real) for real, precision in PRECISIONS},
        "The extension of the lens is about f² over the distance. As a difference of conjugates it loses one"
        " digit with each digit of the distance; a single ray off the axis also has spherical aberration.")


def near_focus() -> Sweep:
    """Object distances down to magnification one; no film exists for nearer objects."""
    return _conjugates(
        "Near focus", np.concatenate([np.geomspace(1000.0, 99.0, 16), np.geomspace(98.0, 5.0, 13)]),
        {"one ray": one_ray},
        "Object and image are nearest to each other at magnification −1. For nearer objects the formula "
        "takes the root of a negative number; the program reports its nearest distance.")


def _shares(lens: lb.Lens, values: np.ndarray) -> list[lb.Lens]:
    return [lens.with_stop_radius(float(radius)) for radius in values]


def closing_stop() -> Sweep:
    """A stop that closes to a pinhole."""
    lens, distance = lenses.load(LENS), 200.0
    values = np.geomspace(lens.stop.semi_diameter, 0.02, 13)
    closed = _shares(lens, values)
    truth = [least_blur(stopped, distance) for stopped in closed]
    spread = [1.0 / lb.first_order(stopped).f_number for stopped in closed]
    methods: dict[str, tuple[Focus, bool, str]] = {
        "one ray": (one_ray, False, ""), "three rays in turn": (three_rays, False, ""),
        "whole bundle": (whole_bundle, True, "")}

    def blur(film_found: float | str, film: float, wide: float) -> float | str:
        off = _off(film_found, film)
        return off if isinstance(off, str) else off * wide

    curves = [curve(name, [blur(focus(stopped, distance), film, wide)
                           for stopped, film, wide in zip(closed, truth, spread, strict=True)], own, switch)
              for name, (focus, own, switch) in methods.items()]
    return Sweep("Focus as the stop closes", "Radius of the stop", "mm", values, "Blur for the film's place", "mm",
                  5.0 * PIXEL, "five pixels of 4 µm: plainly out of focus", tuple(curves),
                  "An object at 0.2 m. The stop blocks a ray that is aimed at a fixed part of the rear opening; the "
                  "search then never ends.")


def best_focus(name: str) -> Sweep:
    """Film distance of least blur while the aperture opens."""
    lens, distance = lenses.load(name), 2000.0
    values = np.linspace(0.05, 1.0, 14)
    opened = _shares(lens, values * lens.stop.semi_diameter)
    least = [rms_radius(stopped, least_blur(stopped, distance), distance) for stopped in opened]

    def narrow(stopped: lb.Lens, distance: float) -> float | str:
        return whole_bundle(stopped.with_stop_radius(0.2 * stopped.stop.semi_diameter), distance)

    def smallest(stopped: lb.Lens, distance: float) -> float | str:
        return least_blur(stopped, distance, extent)

    methods: dict[str, tuple[Focus, bool, str]] = {
        "closed form": (closed_form, True, "the program moves the film to the least blur, and the read-outs show this"),
        "whole bundle": (whole_bundle, True, ""), "one ray": (one_ray, False, ""),
        "a fifth of the bundle": (narrow, False, ""), "least whole spot": (smallest, False, "")}

    def wider(film: float | str, stopped: lb.Lens, best: float) -> float | str:
        return film if isinstance(film, str) else max(
            2.0 * math.sqrt(2.0) * (rms_radius(stopped, film, distance) - best), 0.0)

    curves: Sequence[Curve] = [
        curve(label, [wider(focus(stopped, distance), stopped, best)
                      for stopped, best in zip(opened, least, strict=True)], own, switch)
        for label, (focus, own, switch) in methods.items()]
    return Sweep(f"Best focus, {lens.name or name}", "Stop, of the full one", "", values,
                  "Blur beyond the least", "mm", PIXEL, "a pixel of 4 µm", tuple(curves),
                  "Diameters 2√2 × rms for the axis point at 2 m. Spherical aberration separates the paraxial focus, "
                  "the least rms blur and the smallest whole spot.", linear=True)


SWEEPS: dict[str, Callable[[], Sweep]] = {
    "Far focus": far_focus, "Near focus": near_focus, "Focus as the stop closes": closing_stop,
    "Best focus, wide angle": lambda: best_focus(LENS), "Best focus, f/1.25": lambda: best_focus(FAST)}
