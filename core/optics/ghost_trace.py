"""Ghost light: rays that two surfaces of a lens reflect, the second one back towards the film.

A pair (first, second) has first < second: light is refracted up to `second`, reflected there, goes back to `first`, is
reflected again and leaves the lens towards the film. `ghost_path` is the reference, one ray in float64; `GhostTracer`
runs the stages of `block_trace` in that order, a block of rays at a time.

Both find the normal of a surface, of whatever kind, from a refraction there into a medium of higher index: the
optical direction changes along the normal, and no ray is totally reflected.

Light counts as unpolarised at every surface. Absorption in the glass is neglected.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    CLEARANCE,
    H0,
    H1,
    H2,
    KEYS,
    TB,
    TG,
    TR,
    WEIGHT,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    gather,
    rows,
)
from lensbench.kernels.cache import njit
from lensbench.kernels.program import Program, call_stage, run_steps
from lensbench.optics.block_trace import RUNS, SLOWNESS, STEP, surface_steps
from lensbench.optics.coatings import Coating
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.scalar_trace import CLIPPED, PASSED, TOTAL_REFLECTION, surface_table, trace_ray
from lensbench.optics.surfaces import AFTER, BEFORE
from lensbench.optics.transmission import surface_coatings

Pair = tuple[int, int]          # (first, second): indices of surfaces, second the one that is met first by the light
Visible = tuple[tuple[float, ...], ...]

DIRECT: Pair = (-1, -1)         # in place of a pair: the light that no surface reflects
DENSER = 1.5                    # index ratio of the refraction that finds the normal
NODES = 129                     # of a table of reflectance, evenly over the cosine on the side of the smaller index
CHANNELS = 3
FORWARD, BACKWARD = 0, 1


def ghost_pairs(lens: Lens, wavelength: float = D_LINE) -> tuple[Pair, ...]:
    """All pairs of surfaces that reflect, first < second: those with different indices on both sides."""
    n = lens.indices(wavelength)
    reflecting = [i for i in range(len(lens.surfaces)) if n[i] != n[i + 1]]
    return tuple((first, second) for k, second in enumerate(reflecting) for first in reflecting[:k])


def require_in_line(lens: Lens) -> None:
    """LensError for a lens with surfaces out of line: their ghosts are not traced."""
    if not lens.is_in_line:
        raise LensError("ghosts are not traced through surfaces out of line: reset their tilt and decentre")


def ghost_order(count: int, pair: Pair) -> Iterator[tuple[int, bool, bool]]:
    """Surfaces in the order met, of `count`: index, whether the light runs to the film, whether it is reflected."""
    first, second = pair
    if pair == DIRECT:
        yield from ((i, True, False) for i in range(count))
        return
    yield from ((i, True, i == second) for i in range(second + 1))
    yield from ((i, False, i == first) for i in range(second - 1, first - 1, -1))
    yield from ((i, True, False) for i in range(first + 1, count))


def pair_share(lens: Lens, pair: Pair, wavelength: float = D_LINE, coating: str | Coating = "uncoated") -> float:
    """Product of the reflectances of a pair, or of DIRECT, and of all transmittances on its way, on the axis."""
    reflected, passed = _on_axis(lens, wavelength, coating), 1.0
    for i, _, mirror in ghost_order(len(lens.surfaces), pair):
        part = reflected[i]
        passed *= part if mirror else 1.0 - part
    return passed


@lru_cache(maxsize=64)
def _on_axis(lens: Lens, wavelength: float, coating: str | Coating) -> tuple[float, ...]:
    """Reflectance of each surface at normal incidence."""
    n = lens.indices(wavelength)
    return tuple(float(own.reflectance(n[i], n[i + 1], wavelength=wavelength).mean) if n[i] != n[i + 1] else 0.0
                 for i, own in enumerate(surface_coatings(lens, coating)))


# The reference


class Meeting(NamedTuple):
    """One ray at one surface; lens frame, mm."""

    point: tuple[float, float, float]
    refracted: tuple[float, float, float] | None        # unit direction; None: totally reflected
    reflected: tuple[float, float, float]
    reflectance: float
    fate: int                                           # PASSED, or why the ray ends here


@dataclass(frozen=True, eq=False)
class GhostPath:
    """One ray of a ghost.

    Attributes
    ----------
    points : (n, 3) ndarray
        Origin, then the points met in order, the one that ends the ray included (mm, lens frame).
    direction : (3,) ndarray
        Unit direction behind the last point.
    weight : float
        Part of the ray's light that is left: reflectances times transmittances; 0 if the ray ends.
    fate : int
        A value of `Fate`.
    """

    points: np.ndarray
    direction: np.ndarray
    weight: float
    fate: int


class Meetings:
    """Rays at single surfaces of a lens, at a wavelength (µm), by the reference tracer."""

    def __init__(self, lens: Lens, wavelength: float = D_LINE, coating: str | Coating = "uncoated", clip: bool = True):
        require_in_line(lens)
        self._lens, self._wavelength, self._clip = lens, wavelength, clip
        self._table = surface_table(lens, wavelength)
        self._coatings = surface_coatings(lens, coating)

    def meet(self, i: int, forward: bool, point, direction) -> Meeting:
        """A ray, in the medium before surface i as the light runs, at this surface."""
        row = type(self._table)(*(part[i:i + 1] for part in self._table))
        order = 1 if forward else -1
        before, after = row.numbers[0, [BEFORE, AFTER] if forward else [AFTER, BEFORE]].tolist()
        *hit, dx, dy, dz, fate, _ = trace_ray(row, self._clip, *point, *direction, None, 0, order)
        blocked = self._clip and i == self._lens.stop_index and fate == PASSED and not self._passes_iris(hit)
        if blocked or fate not in (PASSED, TOTAL_REFLECTION):
            return Meeting(tuple(hit), None, direction, 0.0, CLIPPED if blocked else fate)
        if before == after:
            return Meeting(tuple(hit), (dx, dy, dz), direction, 0.0, PASSED)

        # The normal, by a refraction that always succeeds
        denser = row._replace(numbers=row.numbers.copy())
        denser.numbers[0, AFTER if forward else BEFORE] = DENSER * before
        *_, ex, ey, ez, normal_fate, _ = trace_ray(denser, False, *point, *direction, None, 0, order)
        if normal_fate != PASSED:
            return Meeting(tuple(hit), None, direction, 0.0, normal_fate)
        change = [DENSER * b - a for a, b in zip(direction, (ex, ey, ez), strict=True)]
        length = sqrt(sum(c * c for c in change))
        normal = [c / length for c in change]
        cosine = sum(a * b for a, b in zip(direction, normal, strict=True))
        mirrored = [a - 2.0 * cosine * b for a, b in zip(direction, normal, strict=True)]
        part = float(self._coatings[i].reflectance(before, after, min(cosine, 1.0), self._wavelength).mean)
        total = fate == TOTAL_REFLECTION
        return Meeting(tuple(hit), None if total else (dx, dy, dz), tuple(mirrored), 1.0 if total else part, PASSED)

    def _passes_iris(self, hit) -> bool:
        iris, radius = self._lens.iris, self._lens.stop.semi_diameter
        return iris.is_round or bool(iris.contains(np.array([hit[0] / radius]), np.array([hit[1] / radius]))[0])


def ghost_path(lens: Lens, pair: Pair, origin, direction, wavelength: float = D_LINE,
               coating: str | Coating = "uncoated", clip: bool = True) -> GhostPath:
    """One ray of the ghost of a pair, by the reference tracer.

    Parameters
    ----------
    lens : Lens
        The lens.
    pair : (int, int)
        Surfaces (first, second), as of `ghost_pairs`.
    origin, direction : (3,) array_like
        The ray towards the lens (mm, lens frame); the direction may have any length.
    wavelength : float
        Micrometres.
    coating : str or Coating
        As of `surface_coatings`.
    clip : bool
        Whether rims, stop and blades end the ray.

    Returns
    -------
    GhostPath
    """
    bench = Meetings(lens, wavelength, coating, clip)
    point = tuple(np.asarray(origin, float).tolist())
    unit = np.asarray(direction, float)
    ray = tuple((unit / np.linalg.norm(unit)).tolist())
    points, weight = [point], 1.0
    for i, forward, mirror in ghost_order(len(lens.surfaces), pair):
        met = bench.meet(i, forward, point, ray)
        point, after = met.point, met.reflected if mirror else met.refracted
        points.append(point)
        if met.fate != PASSED or after is None:
            return GhostPath(np.array(points), np.array(ray), 0.0, TOTAL_REFLECTION if met.fate == PASSED else met.fate)
        weight *= met.reflectance if mirror else 1.0 - met.reflectance
        ray = after
    return GhostPath(np.array(points), np.array(ray), weight, PASSED)


# The block tracer


class GhostCode(NamedTuple):
    """A lens as the kernels of ghosts read it; first axis of two: FORWARD, BACKWARD."""

    addresses: np.ndarray       # (surfaces,) of the stage of each surface
    numbers: np.ndarray         # records of the stages, one after the other
    starts: np.ndarray          # (2, surfaces, 2) where each begins: refracting, and finding the normal
    sizes: np.ndarray           # (surfaces,)
    reflects: np.ndarray        # (surfaces,) bool
    indices: np.ndarray         # (surfaces + 1,) of the media
    tables: np.ndarray          # (surfaces, CHANNELS, NODES) reflectance over the cosine
    stop: int                   # surface at which the blades block, or −1
    blade_address: int
    blades: np.ndarray
    end: float                  # z of the last vertex (mm, camera frame)


class GhostTracer:
    """The pairs of a lens before a film, traced in blocks; camera frame, mm: the film's centre is the origin.

    wavelength: µm, of the rays. channels: for red, green and blue the wavelengths whose mean reflectance counts, or
    None: that of `wavelength` for all. coating: as of `surface_coatings`.
    """

    def __init__(self, lens: Lens, film_distance: float, landing: list[Step], wavelength: float = D_LINE,
                 channels: Visible | None = None, coating: str | Coating = "uncoated", real=np.float32):
        require_in_line(lens)
        self.real, self.lens = real, lens
        self._landing = Program(landing, real)
        forward = _records(lens, film_distance, wavelength, "film")
        backward = _records(lens, film_distance, wavelength, "scene")[::-1]
        numbers: list[np.ndarray] = []
        starts = np.empty((2, len(forward), 2), np.int64)
        at = 0
        for way, steps in ((FORWARD, forward), (BACKWARD, backward)):
            for i, step in enumerate(steps):
                mirror = np.array(step.parameters, float)
                mirror[STEP] = (DENSER * DENSER - 1.0) / mirror[SLOWNESS]
                for k, record in enumerate((step.parameters, mirror)):
                    starts[way, i, k] = at
                    numbers.append(np.asarray(record, real))
                    at += len(record)
        blades = lens.iris.blocking(lens.stop.semi_diameter)
        program, blocking = Program(forward, real), Program(blades, real)
        n = np.array(lens.indices(wavelength))
        self.code = GhostCode(
            program.code.addresses, np.concatenate(numbers), starts, np.array([len(s.parameters) for s in forward]),
            n[:-1] != n[1:], n.astype(real),
            reflectance_tables(lens, channels or ((wavelength,),) * CHANNELS, coating).astype(real),
            lens.stop_index if blades else -1, int(blocking.code.addresses[0]) if blades else 0,
            np.asarray(blades[0].parameters if blades else np.zeros(1), real), real(-film_distance))
        self._front = real(lens.front_index)
        self.front_z = -lens.length - film_distance

    def trace(self, lanes: np.ndarray, pair: Pair, rays: np.ndarray, found: np.ndarray) -> None:
        """Trace rays (7, n): X … N unit, and WEIGHT, into found (6, n): raster x, y, light of R, G, B, clearance.

        A ray that ends has no light. Its place is that of the ray traced on beyond rims, or NaN.
        """
        _trace_rays(lanes, self.code, self._landing.code, *pair, self._front, rays, found)


def _records(lens: Lens, film_distance: float, wavelength: float, towards: str) -> list[Step]:
    """A step for each surface, in the order met."""
    _, *runs, _ = surface_steps(lens, film_distance, wavelength, towards)
    lengths = {id(kernel): length for kernel, length in RUNS.values()}
    return [Step(run.kernel, run.parameters[at:at + lengths[id(run.kernel)]]) for run in runs
            for at in range(0, len(run.parameters), lengths[id(run.kernel)])]


def reflectance_tables(lens: Lens, channels: Visible, coating: str | Coating) -> np.ndarray:
    """Reflectance (surfaces, channels, NODES) over the cosine, 0 to 1, on the side of the smaller index."""
    tables = np.zeros((len(lens.surfaces), len(channels), NODES))
    for i, own in enumerate(surface_coatings(lens, coating)):
        for k, lines in enumerate(channels):
            tables[i, k] = _table(own, lines, tuple(lens.indices(line)[i:i + 2] for line in lines))
    return tables


@lru_cache(maxsize=512)
def _table(own: Coating, lines: tuple[float, ...], indices: tuple[tuple[float, ...], ...]) -> np.ndarray:
    """Mean reflectance (NODES,) of a coating between these indices, at these wavelengths."""
    cosines = np.linspace(0.0, 1.0, NODES)
    return np.mean([own.reflectance(min(n), max(n), cosines, line).mean if n[0] != n[1] else np.zeros(NODES)
                    for line, n in zip(lines, indices, strict=True)], 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _trace_rays(lanes, code, landing, first, second, front, rays, found):
    key = np.zeros(KEYS, np.uint32)
    row = rows(lanes)
    real = lanes.dtype.type
    n = rays.shape[1]
    red, green, blue, clearance, weight = row[TR], row[TG], row[TB], row[CLEARANCE], row[WEIGHT]
    for start in range(0, n, B):
        for i in range(B):
            k = min(start + i, n - 1)
            row[X, i], row[Y, i], row[Z, i] = rays[0, k], rays[1, k], rays[2, k]
            row[L, i], row[M, i], row[N, i] = rays[3, k] * front, rays[4, k] * front, rays[5, k] * front
            weight[i] = rays[6, k]
            red[i], green[i], blue[i], clearance[i] = real(1), real(1), real(1), real(0)
        _trace_pair(lanes, code, first, second, key)
        z = row[Z]
        for i in range(B):
            z[i] += code.end
        run_steps(lanes, landing, key)
        for i in range(min(B, n - start)):
            k = start + i
            w = weight[i] if clearance[i] <= real(1) else real(0)
            found[0, k], found[1, k] = row[X, i], row[Y, i]
            found[2, k], found[3, k], found[4, k] = w * red[i], w * green[i], w * blue[i]
            found[5, k] = clearance[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _trace_pair(lanes, code, first, second, key):
    """A block of rays through all surfaces, reflected at `second` and then at `first`; at none where these are −1."""
    if second < 0:
        for i in range(code.sizes.size):
            _refract(lanes, code, i, FORWARD, key)
        return
    for i in range(second):
        _refract(lanes, code, i, FORWARD, key)
    _reflect(lanes, code, second, FORWARD, key)
    for i in range(second - 1, first, -1):
        _refract(lanes, code, i, BACKWARD, key)
    _reflect(lanes, code, first, BACKWARD, key)
    for i in range(first + 1, code.sizes.size):
        _refract(lanes, code, i, FORWARD, key)


@njit(cache=True, nogil=True, error_model="numpy")
def _stage_of_surface(lanes, code, i, way, mirror, key):
    start = code.starts[way, i, mirror]
    call_stage(code.addresses[i], lanes, code.numbers[start:start + code.sizes[i]], code.starts[0, 0, :0], key)
    if i == code.stop:
        call_stage(code.blade_address, lanes, code.blades, code.starts[0, 0, :0], key)


@njit(cache=True, nogil=True, error_model="numpy")
def _keep_direction(lanes):
    row = rows(lanes)
    l, m, n, l0, m0, n0 = row[L], row[M], row[N], row[H0], row[H1], row[H2]
    for i in range(B):
        l0[i], m0[i], n0[i] = l[i], m[i], n[i]


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "arcp"}, error_model="numpy")
def _refract(lanes, code, s, way, key):
    """Refract at surface s; TR, TG, TB: times the transmitted part."""
    real = lanes.dtype.type
    if not code.reflects[s]:
        _stage_of_surface(lanes, code, s, way, 0, key)
        return
    _keep_direction(lanes)
    _stage_of_surface(lanes, code, s, way, 0, key)
    row = rows(lanes)
    l, m, n, l0, m0, n0 = row[L], row[M], row[N], row[H0], row[H1], row[H2]
    cosine = row[H0]
    before, after = code.indices[s + way], code.indices[s + 1 - way]
    from_low, per = before < after, real(NODES - 1) / min(before, after)
    for i in range(B):
        a, b, c = l[i] - l0[i], m[i] - m0[i], n[i] - n0[i]
        x, y, z = l0[i] if from_low else l[i], m0[i] if from_low else m[i], n0[i] if from_low else n[i]
        cosine[i] = abs(a * x + b * y + c * z) / sqrt(a * a + b * b + c * c) * per
    _apply(lanes, code.tables[s], real(1), real(-1))


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "arcp"}, error_model="numpy")
def _reflect(lanes, code, s, way, key):
    """Reflect at surface s, z running with the light before and after; TR, TG, TB: times the reflected part."""
    real = lanes.dtype.type
    _keep_direction(lanes)
    _stage_of_surface(lanes, code, s, way, 1, key)
    row = rows(lanes)
    z, l, m, n, l0, m0, n0 = row[Z], row[L], row[M], row[N], row[H0], row[H1], row[H2]
    cosine, clearance = row[H0], row[CLEARANCE]
    before, after = code.indices[s + way], code.indices[s + 1 - way]
    low = min(before, after)
    more, per = low * low - before * before, real(NODES - 1) / low
    for i in range(B):
        a, b, c = l[i] - l0[i], m[i] - m0[i], n[i] - n0[i]
        size = real(1) / (a * a + b * b + c * c)
        along = a * l0[i] + b * m0[i] + c * n0[i]
        twice = real(2) * along * size
        l[i], m[i] = l0[i] - twice * a, m0[i] - twice * b
        z[i], n[i] = -z[i], twice * c - n0[i]
        clearance[i] = clearance[i] if n[i] > real(0) else real(np.inf)
        # (n cos I)² on the side of the smaller index; below 0 the light is totally reflected
        cosine[i] = sqrt(max(along * along * size + more, real(0))) * per
    _apply(lanes, code.tables[s], real(0), real(1))


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "arcp"}, error_model="numpy")
def _apply(lanes, tables, least, sign):
    """TR, TG, TB: times least + sign · the reflectance at the node H0, linear between the nodes."""
    row = rows(lanes)
    real = lanes.dtype.type
    x, node, low, high = row[H0], row[A0], row[A1], row[A2]
    for i in range(B):
        x[i] = min(x[i], real(NODES - 1)) if x[i] >= real(0) else real(0)      # 0 also for a lost ray, whose x is NaN
        node[i] = math.floor(min(x[i], real(NODES - 2)))
    for channel in range(CHANNELS):
        table, light = tables[channel], row[TR + channel]
        gather(low, table, node)
        gather(high, table[1:], node)
        for i in range(B):
            light[i] *= least + sign * (low[i] + (x[i] - node[i]) * (high[i] - low[i]))
