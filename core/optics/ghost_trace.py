"""Ghost light in blocks of rays: the stages of `block_trace` in the order in which the light of a pair meets surfaces.

`ghost_path` is the reference, with the same assumptions.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, CLEARANCE, H0, H1, H2, KEYS, TB, TG, TR, WEIGHT, B, L, M, N, Step, X, Y, Z, gather, rows
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, call_stage, run_steps, stage_address
from lensbench.core.optics.axial_bundle import surface_coatings
from lensbench.core.optics.block_refraction import SLOWNESS, STEP
from lensbench.core.optics.block_trace import FRAME, change_frame, check_travel, surface_records
from lensbench.core.optics.coatings import Coating
from lensbench.core.optics.ghost_path import DENSER, DIRECT, Pair, check_pair
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens

Visible = tuple[tuple[float, ...], ...]

NODES = 129                     # of a table of reflectance, evenly over the cosine on the side of the smaller index
CHANNELS = 3
FORWARD, BACKWARD = 0, 1


class GhostCode(NamedTuple):
    """A lens as the kernels of ghosts read it; first axis of two: FORWARD, BACKWARD."""

    addresses: np.ndarray       # (surfaces,) of the stage of each surface
    numbers: np.ndarray         # records of the stages, one after the other
    starts: np.ndarray          # (2, surfaces, 2) where each begins: refracting, and finding the normal
    sizes: np.ndarray           # (surfaces,)
    moved: np.ndarray           # (2, surfaces + 1) bool: whether a surface has another frame than the one met before;
                                # the last: whether the last surface has another frame than the lens
    moves: np.ndarray           # (2, surfaces + 1, FRAME) parameters of `change_frame` into its frame
    axes: np.ndarray            # (2, surfaces, 3) parameters of `check_travel` behind a tilted one; NaN for others
    reflects: np.ndarray        # (surfaces,) bool
    indices: np.ndarray         # (surfaces + 1,) of the media
    tables: np.ndarray          # (surfaces, CHANNELS, NODES) reflectance over the cosine
    stop: int                   # surface at which the blades block, or −1
    blade_address: int
    blades: np.ndarray
    end: float                  # z of the last vertex (mm, camera frame)


class GhostTracer:
    """The pairs of a lens before a film, traced in blocks; camera frame, mm.

    wavelength: µm, of the rays. channels: for red, green and blue the wavelengths whose mean reflectance counts; None:
    `wavelength` for all.
    """

    def __init__(self, lens: Lens, film_distance: float, landing: list[Step], wavelength: float = D_LINE,
                 channels: Visible | None = None, coating: str | Coating = "uncoated", real: Any = np.float32
                ) -> None:
        self.real, self.lens = real, lens
        self._landing = Program(landing, real)
        to_film = surface_records(lens, film_distance, wavelength, "film")
        forward = to_film.surfaces
        backward = surface_records(lens, film_distance, wavelength, "scene").surfaces[::-1]
        moved, moves = np.zeros((2, len(forward) + 1), np.bool_), np.zeros((2, len(forward) + 1, FRAME), real)
        axes = np.full((2, len(forward), 3), np.nan, real)
        numbers: list[np.ndarray] = []
        starts = np.empty((2, len(forward), 2), np.int64)
        n_codes = 0
        for way, records in ((FORWARD, forward), (BACKWARD, backward)):
            for i, move in enumerate([*(record.move for record in records), to_film.move]):
                if move is not None:
                    moved[way, i], moves[way, i] = True, move
            for i, record in enumerate(records):
                if record.axis is not None:
                    axes[way, i] = record.axis
                mirror = record.numbers.copy()
                mirror[STEP] = (DENSER * DENSER - 1.0) / mirror[SLOWNESS]
                for k, own in enumerate((record.numbers, mirror)):
                    starts[way, i, k] = n_codes
                    numbers.append(own.astype(real))
                    n_codes += len(own)
        blades = lens.iris.blocking(lens.stop.semi_diameter)
        n = np.array(lens.indices(wavelength))
        self.code = GhostCode(
            np.array([stage_address(record.kernel, real) for record in forward], np.int64), np.concatenate(numbers),
            starts, np.array([len(record.numbers) for record in forward]), moved, moves, axes,
            n[:-1] != n[1:], n.astype(real),
            reflectance_tables(lens, channels or ((wavelength,),) * CHANNELS, coating).astype(real),
            lens.stop_index if blades else -1, stage_address(blades[0].kernel, real) if blades else 0,
            np.asarray(blades[0].parameters if blades else np.zeros(1), real), real(-film_distance))
        self._front = real(lens.front_index)
        self.front_z = -lens.length - film_distance

    def pair_reflectances(self, pairs: Sequence[Pair]) -> np.ndarray:
        """Light of pairs over the direct light, (pairs, CHANNELS), at normal incidence: 1 for DIRECT."""
        reflected = self.code.tables[:, :, -1].astype(float)
        reflectances = [np.ones(CHANNELS) if (first, second) == DIRECT else
                        reflected[first] * reflected[second] * ((1.0 - reflected[first + 1:second]) ** 2).prod(0)
                        for first, second in pairs]
        return np.array(reflectances).reshape(-1, CHANNELS)

    def trace(self, lanes: np.ndarray, pair: Pair, rays: np.ndarray, landed: np.ndarray, reflecting: bool = True
              ) -> None:
        """Trace rays (7, n): X … N unit, and WEIGHT, into found (6, n): raster x, y, light of R, G, B, clearance.

        A blocked ray has no light, but a raster position where it can be traced on. reflecting: whether reflectances
        count; without them a trace takes a quarter of the time. LensError for a pair that the lens does not have.
        """
        check_pair(self.lens, pair)
        _trace_rays(lanes, self.code, self._landing.code, *pair, self._front, rays, landed, reflecting)


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
def _trace_rays(lanes, code, landing, first, second, front, rays, landed, reflecting):
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
        _trace_pair(lanes, code, first, second, reflecting, key)
        z = row[Z]
        for i in range(B):
            z[i] += code.end
        run_steps(lanes, landing, key)
        for i in range(min(B, n - start)):
            k = start + i
            w = weight[i] if clearance[i] <= real(1) else real(0)
            landed[0, k], landed[1, k] = row[X, i], row[Y, i]
            landed[2, k], landed[3, k], landed[4, k] = w * red[i], w * green[i], w * blue[i]
            landed[5, k] = clearance[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _trace_pair(lanes, code, first, second, reflecting, key):
    """A block of rays through all surfaces, reflected at `second` and then at `first`; at none where these are −1."""
    if second < 0:
        for i in range(code.sizes.size):
            _refract(lanes, code, i, FORWARD, reflecting, key)
        _change_frame(lanes, code, code.sizes.size, FORWARD, key)
        return
    for i in range(second):
        _refract(lanes, code, i, FORWARD, reflecting, key)
    _reflect(lanes, code, second, FORWARD, reflecting, key)
    for i in range(second - 1, first, -1):
        _refract(lanes, code, i, BACKWARD, reflecting, key)
    _reflect(lanes, code, first, BACKWARD, reflecting, key)
    for i in range(first + 1, code.sizes.size):
        _refract(lanes, code, i, FORWARD, reflecting, key)
    _change_frame(lanes, code, code.sizes.size, FORWARD, key)


@njit(cache=True, nogil=True, error_model="numpy")
def _change_frame(lanes, code, i, way, key):
    """Into the frame of surface i from that of the surface before it on this way."""
    if code.moved[way, i]:
        change_frame(lanes, code.moves[way, i], code.starts[0, 0, :0], key)


@njit(cache=True, nogil=True, error_model="numpy")
def _stage_of_surface(lanes, code, i, way, mirror, key):
    start = code.starts[way, i, mirror]
    call_stage(code.addresses[i], lanes, code.numbers[start:start + code.sizes[i]], code.starts[0, 0, :0], key)
    if i == code.stop:
        call_stage(code.blade_address, lanes, code.blades, code.starts[0, 0, :0], key)


@njit(cache=True, nogil=True, error_model="numpy")
def _check_travel(lanes, code, s, way, key):
    """Lose the rays that a tilted surface has turned against the light."""
    if not np.isnan(code.axes[way, s, 0]):
        check_travel(lanes, code.axes[way, s], code.starts[0, 0, :0], key)


@njit(cache=True, nogil=True, error_model="numpy")
def _keep_direction(lanes):
    row = rows(lanes)
    l, m, n, l0, m0, n0 = row[L], row[M], row[N], row[H0], row[H1], row[H2]
    for i in range(B):
        l0[i], m0[i], n0[i] = l[i], m[i], n[i]


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "arcp"}, error_model="numpy")
def _refract(lanes, code, s, way, reflecting, key):
    """Refract at surface s; TR, TG, TB: times the transmitted part."""
    real = lanes.dtype.type
    _change_frame(lanes, code, s, way, key)
    if not (reflecting and code.reflects[s]):
        _stage_of_surface(lanes, code, s, way, 0, key)
        _check_travel(lanes, code, s, way, key)
        return
    _keep_direction(lanes)
    _stage_of_surface(lanes, code, s, way, 0, key)
    _check_travel(lanes, code, s, way, key)
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
def _reflect(lanes, code, s, way, reflecting, key):
    """Reflect at surface s, z running with the light before and after; TR, TG, TB: times the reflected part."""
    real = lanes.dtype.type
    _change_frame(lanes, code, s, way, key)
    _keep_direction(lanes)
    _stage_of_surface(lanes, code, s, way, 1, key)
    row = rows(lanes)
    z, l, m, n, l0, m0, n0 = row[Z], row[L], row[M], row[N], row[H0], row[H1], row[H2]
    cosine, clearance = row[H0], row[CLEARANCE]
    before, after = code.indices[s + way], code.indices[s + 1 - way]
    low = min(before, after)
    more, per = low * low - before * before, real(NODES - 1) / low
    upright = np.isnan(code.axes[way, s, 0])
    for i in range(B):
        a, b, c = l[i] - l0[i], m[i] - m0[i], n[i] - n0[i]
        size = real(1) / (a * a + b * b + c * c)
        along = a * l0[i] + b * m0[i] + c * n0[i]
        twice = real(2) * along * size
        l[i], m[i] = l0[i] - twice * a, m0[i] - twice * b
        z[i], n[i] = -z[i], twice * c - n0[i]
        # Along the lens's axis: against the light before, with z turned round
        forth = n[i] if upright else code.axes[way, s, 2] * n[i] - code.axes[way, s, 0] * l[i] - (
            code.axes[way, s, 1] * m[i])
        clearance[i] = clearance[i] if forth > real(0) else real(np.inf)
        # (n cos I)² on the side of the smaller index; below 0 the light is totally reflected
        cosine[i] = sqrt(max(along * along * size + more, real(0))) * per
    if reflecting:
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
