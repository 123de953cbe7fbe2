"""Samples of a picture: the order of its pixels, and their scrambled Sobol points, keyed per pixel by blue noise.

Order: a film is cut into bands of BAND_LINES lines, one below the other, and a band into upright strips of at most
STRIP_WIDTH pixels. The first strip runs down line by line, each line from left to right, the second up, and so on:
successive pixels are neighbours on the film, also where one strip ends and the next begins. So the rays of a block meet
few objects, and few blocks meet mirrors or glass. A band is whole blocks, as many as the film has columns, so that a
picture can be finished band by band. Every pixel occurs once; after the last one the order goes on beyond the right
edge of the film.

Points: point k of dimension d is Sobol's, Owen-scrambled once for the whole picture. The number of a pixel is the point
XORed with a key of the pixel; this preserves the net's properties and costs two operations. The keys of the first four
dimensions come from a 64 × 64 tile in which the errors of neighbouring pixels have opposite signs (the eye, and a
little blur, average them out); those of further dimensions are a hash of the pixel. There is no state: a number depends
on (pixel, sample, dimension, seed) alone, so a picture is the same for any number of threads.

Sources: Joe and Kuo 2008 (direction numbers); Laine and Karras 2011, with the constants of Vegdahl (hashed Owen
scrambling). The tile is the result of a search for this project, which exchanges pixels so that the blurred error over
random half-planes is least.
"""

import math
from pathlib import Path

import numpy as np
from numba import uint32

from lensbench.core.kernels.block import PIXEL, SAMPLE, SEED, TIME, U0, U1, V0, V1, B, Step, X, Y, rows, stage
from lensbench.core.kernels.cache import njit

STRIP_WIDTH = 32                # pixels: two registers of float32; 16 lines of a strip are a block
BAND_LINES = B                  # a power of two; the last band of a film has the rest of the lines
WIDTH, HEIGHT = 0, 1            # parameters of stages that use this order: pixels across and down


def strip_count(w: int) -> int:
    """Number of strips of a film w pixels across; their widths differ by at most one."""
    return -(-w // STRIP_WIDTH)


@njit(inline="always")
def pixel_at(k, w, h):
    """(strip, its first column, its last column + 1, column, line) of pixel k in the order; all int64."""
    top = k // (w * BAND_LINES) * BAND_LINES
    k, h = k - w * top, min(BAND_LINES, h - top)
    n = (w + STRIP_WIDTH - 1) // STRIP_WIDTH
    strip = ((k // h + 1) * n - 1) // w
    left, end = strip * w // n, (strip + 1) * w // n
    rest, wide = k - left * h, end - left
    line = rest // wide
    return strip, left, end, left + rest - line * wide, top + (line if strip % 2 == 0 else h - 1 - line)


@njit(inline="always")
def next_line(strip, left, end, line, w, h):
    """(strip, its first column, its last column + 1, line) of the next line of the block in the order."""
    after = line + 1 - 2 * (strip & 1)
    if (after ^ line) & -BAND_LINES != 0 or after == h:
        return strip + 1, end, (strip + 2) * w // ((w + STRIP_WIDTH - 1) // STRIP_WIDTH), line
    return strip, left, end, after


@stage
def add_corners(lanes, p, ints, key):
    """Raster X, Y: the corner of each lane's pixel added to X, Y within the pixel. p: WIDTH, HEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    w, h = np.int64(p[WIDTH]), np.int64(p[HEIGHT])
    strip, left, end, column, line = pixel_at(np.int64(key[PIXEL]), w, h)
    i = np.uint64(0)
    while i < np.uint64(B):
        run = min(np.uint64(B) - i, np.uint64(end - column))
        x0, y0 = real(np.int32(column)), real(np.int32(line))
        for q in range(run):
            x[i + q] += x0 + real(np.int32(q))
            y[i + q] += y0
        i += run
        strip, left, end, line = next_line(strip, left, end, line, w, h)
        column = left


def raster_image(sums: np.ndarray, w: int, h: int, scale: float | np.ndarray = 1.0) -> np.ndarray:
    """The picture (h, w, c) of c sums a pixel, stored by blocks in this order as (n, c B); each times `scale`.

    scale: a number, or an array (n,) with one for each block. The sums of some successive bands with the lines of these
    bands for h give this part of the film's picture.
    """
    picture = np.empty((h, w, sums.shape[1] // B), sums.dtype)
    scales = np.empty(len(sums), sums.dtype)
    scales[:] = scale
    for top in range(0, h, BAND_LINES):
        _unroll(sums[top * w // B:], scales[top * w // B:], picture[top:top + BAND_LINES])
    return picture


@njit(nogil=True, cache=True, error_model="numpy")
def _unroll(sums, scales, picture):
    """Write the picture of one band."""
    h, w, colours = picture.shape
    strip, left, end, _, line = pixel_at(0, w, h)
    k, column = 0, left
    while k < w * h:
        block, i = k // B, k % B
        run = min(B - i, end - column)
        for colour in range(colours):
            for q in range(run):
                picture[line, column + q, colour] = sums[block, colour * B + i + q] * scales[block]
        k, column = k + run, column + run
        if column == end:
            strip, left, end, line = next_line(strip, left, end, line, w, h)
            column = left


@njit(inline="always")
def concentric_disk(real, u, v):
    """Point (x, y) of the unit disk for (u, v) in [0, 1]², by Shirley and Chiu's concentric map (1997).

    real: type of the numbers. Equal areas stay equal. No branch: the angle within an octant is at most
    π/4, where short polynomials give sine and cosine to 2e-9 and 3e-8.
    """
    a, b = real(2) * u - real(1), real(2) * v - real(1)
    steep = abs(b) > abs(a)
    far, near = (b, a) if steep else (a, b)
    safe = far if far != real(0) else real(1)
    t = near / safe * real(math.pi / 4)
    s = t * t
    sine = t * (real(1) + s * (real(-1 / 6) + s * (real(1 / 120) + s * (real(-1 / 5040) + s * real(1 / 362880)))))
    cosine = real(1) + s * (real(-1 / 2) + s * (real(1 / 24) + s * (real(-1 / 720) + s * real(1 / 40320))))
    x, y = (sine, cosine) if steep else (cosine, sine)
    return far * x, far * y


@njit(inline="always")
def cosine_direction(real, u, v, nx, ny, nz):
    """Unit direction for (u, v) in [0, 1]² about a unit normal, in proportion to the cosine of the angle between both.

    Malley's method: a point of the disk, raised to the hemisphere. The axes across the normal are those of Duff et al.
    (2017), without a branch.
    """
    a, b = concentric_disk(real, u, v)
    rest = real(1) - a * a - b * b
    c = math.sqrt(rest if rest > real(0) else real(0))
    sign = real(1) if nz >= real(0) else real(-1)
    e = real(-1) / (sign + nz)
    f = nx * ny * e
    return (c * nx + a * (real(1) + sign * nx * nx * e) + b * f, c * ny + a * sign * f + b * (sign + ny * ny * e),
            c * nz - a * sign * nx - b * ny)


def unit_disk(uv) -> np.ndarray:
    """Points of the unit disk of pupil samples, by the map of every camera: (0.5, 0.5) is the centre.

    Args:
        uv: (n, 2) array. Pupil samples in [0, 1]².
    Returns:
        (n, 2) array. Points x, y of the unit disk; equal areas of the square have equal areas.

    References:
        Shirley and Chiu 1997, A low distortion map between disk and square.
    """
    u, v = np.asarray(uv, float).T
    a, b = 2.0 * v - 1.0, 2.0 * u - 1.0
    steep = np.abs(b) > np.abs(a)
    far, near = np.where(steep, (b, a), (a, b))
    angle = near / np.where(far != 0.0, far, 1.0) * (math.pi / 4)
    sine, cosine = far * np.sin(angle), far * np.cos(angle)
    return np.where(steep, (sine, cosine), (cosine, sine)).T.copy()


def unit_square(points) -> np.ndarray:
    """Pupil samples of points of a round pupil: the inverse of `unit_disk`.

    Args:
        points: (n, 2) array. Points x, y in radii of the pupil.
    Returns:
        (n, 2) array. Pupil samples uv: in [0, 1]² inside the unit disk, and outside that square for points outside the
            disk.

    References:
        Shirley and Chiu 1997, A low distortion map between disk and square.
    """
    x, y = np.asarray(points, float).T
    steep = np.abs(y) > np.abs(x)
    across, along = np.where(steep, (y, x), (x, y))
    far = np.copysign(np.hypot(x, y), across)
    near = far * np.arctan(along / np.where(across != 0.0, across, 1.0)) * (4 / math.pi)
    a, b = np.where(steep, (near, far), (far, near))
    return np.stack([0.5 * (b + 1.0), 0.5 * (a + 1.0)], 1)


# Primitive polynomials and first direction numbers of dimensions 1 … (dimension 0 is van der Corput's).
_JOE_KUO = [(1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)), (3, 2, (1, 1, 1)), (4, 1, (1, 1, 3, 3)),
            (4, 4, (1, 3, 5, 13)), (5, 2, (1, 1, 5, 5, 17))]
DIMENSIONS = 1 + len(_JOE_KUO)
PUPIL, RASTER, CLOCK, LIGHT, WAVELENGTH = 0, 2, 4, 5, 7     # first dimension; clock and wavelength use one, others two


def _directions() -> np.ndarray:
    """Direction numbers (DIMENSIONS, 32), uint32: entry b is XORed in where bit b of the sample's index is 1."""
    table = np.zeros((DIMENSIONS, 32), np.uint32)
    table[0] = [1 << (31 - b) for b in range(32)]
    for d, (s, a, m) in enumerate(_JOE_KUO, start=1):
        v = [m[b] << (31 - b) for b in range(s)]
        for b in range(s, 32):
            x = v[b - s] ^ (v[b - s] >> s)
            for k in range(1, s):
                if a >> (s - 1 - k) & 1:
                    x ^= v[b - k]
            v.append(x)
        table[d] = v
    return table


_SOBOL = _directions()
CHUNK = 16              # lanes that are written at a time; a row has as many to spare
_TILE = np.load(Path(__file__).parent / "blue_noise_keys_64.npy").transpose(2, 0, 1)
_TILE = np.concatenate([_TILE, _TILE[:, :, :STRIP_WIDTH]], 2)          # a line of a strip may begin at any column
_TILE_PITCH, _TILE_SIZE = np.uint64(_TILE.shape[2]), np.uint64(_TILE[0].size)
_TILE = np.ascontiguousarray(_TILE).reshape(-1)

_u = np.uint32


@njit(inline="always")
def mix(s):
    """Hash of a 32-bit number: a change of one bit changes about half of the result's bits."""
    s = uint32((s ^ (s >> _u(16))) * _u(0x7FEB352D))
    s = uint32((s ^ (s >> _u(15))) * _u(0x846CA68B))
    return uint32(s ^ (s >> _u(16)))


@njit(inline="always")
def _reverse(n):
    """The 32 bits of a number in opposite order."""
    n = uint32((n << _u(16)) | (n >> _u(16)))
    n = uint32(((n & _u(0x00FF00FF)) << _u(8)) | ((n & _u(0xFF00FF00)) >> _u(8)))
    n = uint32(((n & _u(0x0F0F0F0F)) << _u(4)) | ((n & _u(0xF0F0F0F0)) >> _u(4)))
    n = uint32(((n & _u(0x33333333)) << _u(2)) | ((n & _u(0xCCCCCCCC)) >> _u(2)))
    return uint32(((n & _u(0x55555555)) << _u(1)) | ((n & _u(0xAAAAAAAA)) >> _u(1)))


@njit(cache=True)
def sobol(k, d, seed):
    """Point k of dimension d, Owen-scrambled by the seed; all uint32, the result over 2³² in [0, 1)."""
    n = uint32(0)
    for b in range(32):
        if (k >> _u(b)) & _u(1):
            n = uint32(n ^ _SOBOL[d, b])
    s = mix(uint32(seed * _u(0x9E3779B9) + _u(d) * _u(0x85EBCA6B) + _u(1)))
    n = _reverse(n)
    n = uint32(n ^ uint32(n * _u(0x3D20ADEA)))
    n = uint32(n + s)
    n = uint32(n * uint32((s >> _u(16)) | _u(1)))
    n = uint32(n ^ uint32(n * _u(0x05526C56)))
    n = uint32(n ^ uint32(n * _u(0x53A22864)))
    return _reverse(n)


@stage
def sample_pixels(lanes, p, ints, key):
    """One sample in each pixel of the block: raster X, Y and pupil sample U0, U1. p: WIDTH, HEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    u0, u1, x, y = row[U0], row[U1], row[X], row[Y]
    w, h = np.int64(p[WIDTH]), np.int64(p[HEIGHT])
    k, seed = key[SAMPLE], key[SEED]
    # Not as literals, for each of which numba would compile the function once more
    pupil, raster = np.int64(PUPIL), np.int64(RASTER)
    d0, d1 = sobol(k, pupil, seed), sobol(k, pupil + 1, seed)
    d2, d3 = sobol(k, raster, seed), sobol(k, raster + 1, seed)
    unit = real(1 / 16777216)
    strip, left, end, column, line = pixel_at(np.int64(key[PIXEL]), w, h)
    i = np.uint64(0)
    while i < np.uint64(B):             # a line of a strip, in whole registers; the next line overwrites the excess
        run = np.uint64(end - column)
        j = np.uint64(line & 63) * _TILE_PITCH + np.uint64(column & 63)
        for q in range(0, min(run, np.uint64(B) - i), CHUNK):
            lane, tile = i + np.uint64(q), j + np.uint64(q)
            x0, y0 = real(np.int32(column + q)), real(np.int32(line))
            for e in range(CHUNK):
                m = np.uint64(e)
                a, b = _TILE[tile + m], _TILE[tile + m + _TILE_SIZE]
                c, d = _TILE[tile + m + _TILE_SIZE * np.uint64(2)], _TILE[tile + m + _TILE_SIZE * np.uint64(3)]
                u0[lane + m] = real(np.int32(uint32(a ^ d0) >> _u(8))) * unit
                u1[lane + m] = real(np.int32(uint32(b ^ d1) >> _u(8))) * unit
                x[lane + m] = real(np.int32(e)) + real(np.int32(uint32(c ^ d2) >> _u(8))) * unit + x0
                y[lane + m] = real(np.int32(uint32(d ^ d3) >> _u(8))) * unit + y0
        i += run
        strip, left, end, line = next_line(strip, left, end, line, w, h)
        column = left


@stage
def sample_lights(lanes, p, ints, key):
    """Light sample V0, V1, for pictures with soft shadows."""
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1 = row[V0], row[V1]
    k, seed = key[SAMPLE], key[SEED]
    light = np.int64(LIGHT)
    d0, d1 = sobol(k, light, seed), sobol(k, light + 1, seed)
    unit = real(1 / 16777216)
    for i in range(B):
        a = mix(uint32(key[PIXEL] + uint32(i)))
        v0[i] = real(np.int32(uint32(a ^ d0) >> _u(8))) * unit
        v1[i] = real(np.int32(uint32(mix(uint32(a + _u(0x9E3779B9))) ^ d1) >> _u(8))) * unit


@stage
def sample_times(lanes, p, ints, key):
    """TIME in [0, 1) of the shutter, for pictures with motion."""
    real = lanes.dtype.type
    row = rows(lanes)
    time = row[TIME]
    d = sobol(key[SAMPLE], np.int64(CLOCK), key[SEED])
    unit = real(1 / 16777216)
    for i in range(B):
        a = mix(uint32(uint32(key[PIXEL] + uint32(i)) ^ _u(0x68E31DA4)))
        time[i] = real(np.int32(uint32(a ^ d) >> _u(8))) * unit


def _first_points() -> np.ndarray:
    """Points 0 … B − 1 of the first four dimensions, not scrambled: (4 B,) uint32."""
    k = np.arange(B, dtype=np.uint32)[None, :]
    points = np.zeros((4, B), np.uint32)
    for bit in range(32):
        points ^= np.where(k >> np.uint32(bit) & np.uint32(1), _SOBOL[:4, bit:bit + 1], np.uint32(0))
    return points.reshape(-1)


_FIRST = _first_points()


@stage
def sobol_net(lanes, p, ints, key):
    """U0, U1, V0, V1: points B · SAMPLE … of one net per PIXEL, Owen-scrambled in all four dimensions.

    For blocks whose lanes share one net and are no pixels of a film. B is a power of two, so the points of a block
    are those of the first block, each XORed with one number.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    first = uint32(key[SAMPLE] * _u(B))
    seed = mix(uint32(key[SEED] + mix(uint32(key[PIXEL] + _u(1)))))
    unit = real(1 / 16777216)
    for d in range(4):
        out = row[U0 + d]
        start = uint32(0)
        for b in range(32):
            if (first >> _u(b)) & _u(1):
                start = uint32(start ^ _SOBOL[d, b])
        s = mix(uint32(seed + _u(d) * _u(0x85EBCA6B)))
        odd = uint32((s >> _u(16)) | _u(1))
        begin = np.uint64(d) * np.uint64(B)
        for i in range(B):
            n = _reverse(uint32(_FIRST[begin + np.uint64(i)] ^ start))
            n = uint32(n ^ uint32(n * _u(0x3D20ADEA)))
            n = uint32(n + s)
            n = uint32(n * odd)
            n = uint32(n ^ uint32(n * _u(0x05526C56)))
            n = uint32(n ^ uint32(n * _u(0x53A22864)))
            out[i] = real(np.int32(_reverse(n) >> _u(8))) * unit


def unit_table(points, real) -> np.ndarray:
    """Points (n, 2) of the unit square in the type `real`; 1 becomes the greatest number below it.

    ValueError for points outside, which would index beyond a table.
    """
    points = np.atleast_2d(np.asarray(points, real))
    if not ((points >= 0.0) & (points <= 1.0)).all():
        raise ValueError("pupil points must lie in the unit square, from 0 to 1")
    return np.minimum(points, np.nextafter(points.dtype.type(1), points.dtype.type(0)))


@stage
def centre_samples(lanes, p, ints, key):
    """Raster X, Y at the middle of its pixel, pupil sample and TIME. p: U0, U1, TIME."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u0, u1, time = row[X], row[Y], row[U0], row[U1], row[TIME]
    for i in range(B):
        x[i], y[i] = np.floor(x[i]) + real(0.5), np.floor(y[i]) + real(0.5)
        u0[i], u1[i], time[i] = p[0], p[1], p[2]


def centred_steps(w: int, h: int, middle: tuple[float, float]) -> list[Step]:
    """Steps that place one sample in each of w × h pixels: at their middle, in the pupil's (stage u, v), at time ½."""
    return [Step(sample_pixels, [w, h]), Step(centre_samples, [*middle, 0.5])]


def sampling_steps(w: int, h: int, lit: bool, timed: bool = False) -> list[Step]:
    """Steps that draw the samples of w × h pixels; lit: with light samples; timed: with TIME."""
    steps = [Step(sample_pixels, [w, h])]
    steps += [Step(sample_lights)] if lit else []
    return [*steps, Step(sample_times)] if timed else steps
