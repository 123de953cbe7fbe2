"""Adding pictures up, each read between its pixels, shifted and a little enlarged: what focusing a light field is.

The pictures' grids lie aside from each other by many parts of a pixel, so that the pixels of the sum are filled with
samples as those of a picture are, by taking of each view what lies nearest. Half-way to straight lines between its
pixels is best: it moves no sample far, and does not blur as those do. What this takes from the fine detail, and
the shift within a cell of the pupil does, is known, and one short filter gives it back.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

TAPS = 6                # pixels to either side that the sharpening of a sum sees
GAIN = 2.0              # by which it raises the finest detail, at most
STEEP = 2.0             # how much faster than a straight line the reading between two pixels changes, about its middle
MANY = 16               # views from which on it does: fewer leave gaps in a pixel
LOBES = 5               # of the kernel that changes a picture's scale


def added(light: np.ndarray, used: np.ndarray, begins: np.ndarray, scale: float, weights: np.ndarray,
          step, fill: float = 1.0) -> np.ndarray:
    """(3, h, w) float32 Σ weight · view(begin + scale · pixel), begins (n, 2); beyond a view's edge its last pixel.

    light: (views down, views across, 3, h, w), float32, or half floats as their uint16 bits, never negative; used:
    which views, (n, 2). A view's own rays are spread over `step` (across, down) pixels, and fill this part of a pixel's
    side. The sum is that of pixels that are filled.
    """
    h, w = light.shape[3:]
    out = np.zeros((3, h, w), np.float32)
    weights = weights.astype(np.float32)
    threads = os.cpu_count() or 1
    lines = np.linspace(0, h, threads + 1).astype(int)
    add = _add_halves if light.dtype == np.uint16 else _add_floats
    steep = np.float32(STEEP if len(used) >= MANY else 1.0)
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda k: add(light, used, begins, scale, steep, weights, out, lines[k], lines[k + 1]),
                      range(threads)))
    for axis in (0, 1):
        parts = begins[:, axis] % 1.0 if scale == 1.0 else (np.arange(len(used)) + 0.5) / len(used)
        taps = _sharpening(parts, weights, float(steep), abs(step[axis]), fill)
        if len(taps) > 1:
            out = _filtered(out if axis == 0 else np.ascontiguousarray(out.transpose(0, 2, 1)), taps)
            out = out if axis == 0 else np.ascontiguousarray(out.transpose(0, 2, 1))
    return out


def spectral_gain(f: np.ndarray, step: float, fill: float) -> np.ndarray:
    """By what views at their exact places are multiplied at frequencies f (1 / pixel), to be a picture's filled pixels.

    step: pixels over which a view's rays are spread; fill: the part of a pixel's side that its samples fill.
    """
    return 1.0 / np.maximum(np.sinc(f * step) * np.sinc(f * fill) / np.sinc(f), 1.0 / GAIN)


def _sharpening(part: np.ndarray, weights: np.ndarray, steep: float, step: float, fill: float) -> np.ndarray:
    """(2 TAPS + 1,) what makes of pictures read at these parts of a pixel, on the average, one of filled pixels.

    As far as nothing finer is raised to more than GAIN times; (1,) where there is nothing to undo.
    """
    f = np.fft.rfftfreq(8 * TAPS)
    turns = np.exp(-2j * math.pi * f[:, None] * part)
    beyond = np.clip((part - 0.5) * steep + 0.5, 0.0, 1.0)
    read = ((1.0 - beyond) * turns + beyond * turns * np.exp(2j * math.pi * f[:, None])) @ weights / weights.sum()
    response = read.real * np.sinc(f * step) * np.sinc(f * fill) / np.sinc(f)
    if np.abs(response - 1.0).max() < 1e-6:
        return np.ones(1, np.float32)
    taps = np.fft.fftshift(np.fft.irfft(1.0 / np.maximum(response, 1.0 / GAIN)))
    middle = len(taps) // 2
    window = 0.5 + 0.5 * np.cos(math.pi * np.arange(-TAPS, TAPS + 1) / (TAPS + 1))
    taps = taps[middle - TAPS:middle + TAPS + 1] * window
    return (taps / taps.sum()).astype(np.float32)


@intrinsic
def _number(typing, bits):
    """The float32 that 32 bits spell."""
    def build(context, builder, signature, arguments):
        return builder.bitcast(arguments[0], context.get_value_type(types.float32))

    return types.float32(types.uint32), build


@njit(inline="always")
def half_float(bits):
    """The float32 that the 16 bits of a half float spell which is not negative, and finite."""
    return _number(np.uint32(bits) << np.uint32(13)) * np.float32(2.0**112)         # the exponents' different zero


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _add_halves(light, used, begins, scale, steep, weights, out, first, last):
    """Lines first … last − 1 of `added` from half floats, which are given as their bits and never negative."""
    h, w = light.shape[3], light.shape[4]
    line = np.zeros(w, np.float32)
    unit = np.float32(2.0**112)                             # the exponents' different zero
    for channel in range(3):
        for y in range(first, last):
            for q in range(len(used)):
                view = light[used[q, 0], used[q, 1], channel]
                at = begins[q, 1] + scale * y
                top = math.floor(at)
                above, below = view[min(max(top, 0), h - 1)], view[min(max(top + 1, 0), h - 1)]
                b = _between(np.float32(at - top), steep) * weights[q] * unit
                a = weights[q] * unit - b
                for i in range(w):
                    line[i] = (a * _number(np.uint32(above[i]) << np.uint32(13))
                               + b * _number(np.uint32(below[i]) << np.uint32(13)))
                _spread(line, begins[q, 0], scale, steep, out[channel, y])


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _add_floats(light, used, begins, scale, steep, weights, out, first, last):
    """Lines first … last − 1 of `added`."""
    h, w = light.shape[3], light.shape[4]
    line = np.zeros(w, np.float32)
    for channel in range(3):
        for y in range(first, last):
            for q in range(len(used)):
                view = light[used[q, 0], used[q, 1], channel]
                at = begins[q, 1] + scale * y
                top = math.floor(at)
                above, below = view[min(max(top, 0), h - 1)], view[min(max(top + 1, 0), h - 1)]
                b = _between(np.float32(at - top), steep) * weights[q]
                a = weights[q] - b
                for i in range(w):
                    line[i] = a * above[i] + b * below[i]
                _spread(line, begins[q, 0], scale, steep, out[channel, y])


@njit(inline="always")
def _between(part, steep):
    """How much of the second of two pixels is read at a part of the way to it, float32."""
    f = (part - np.float32(0.5)) * steep + np.float32(0.5)
    f = f if f > np.float32(0) else np.float32(0)
    return f if f < np.float32(1) else np.float32(1)


@njit(inline="always")
def _spread(line, begin, scale, steep, sums):
    """sums[i] += the line at begin + scale · i, read between its numbers; its ends go on for ever.

    Piece by piece, for as long as the whole number of pixels that it is read aside stays the same.
    """
    w = sums.size
    low = min(max(int(math.ceil(-begin / scale)), 0), w)
    high = min(max(int(math.ceil((w - 1 - begin) / scale)), low), w)
    for i in range(low):
        sums[i] += line[0]
    for i in range(high, w):
        sums[i] += line[w - 1]
    drift = scale - 1.0
    i = low
    while i < high:
        aside = int(math.floor(begin + scale * i)) - i
        end = high
        if drift != 0.0:
            end = min(max(int(math.ceil((aside + (1.0 if drift > 0.0 else 0.0) - begin) / drift)), i + 1), high)
        part, grows = np.float32(begin + drift * i - aside), np.float32(drift)
        here, there, into = line[i + aside:end + aside], line[i + aside + 1:end + aside + 1], sums[i:end]
        for k in range(into.size):
            into[k] += here[k] + _between(part + grows * np.float32(k), steep) * (there[k] - here[k])
        i = end


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _filtered(picture, taps):
    """(3, h, w) filtered along its lines, whose last pixels go on."""
    reach, w = len(taps) // 2, picture.shape[2]
    line, out = np.zeros(w + 2 * reach, np.float32), np.zeros_like(picture)
    for channel in range(picture.shape[0]):
        for y in range(picture.shape[1]):
            source, sums = picture[channel, y], out[channel, y]
            line[:reach], line[reach + w:] = source[0], source[w - 1]
            line[reach:reach + w] = source
            for k in range(len(taps)):
                tap = taps[k]
                for i in range(w):
                    sums[i] += tap * line[i + k]
    return out


def magnified(picture: np.ndarray, scale: float, middle) -> np.ndarray:
    """(3, h, w) whose pixel x is taken from scale · (x − middle) + middle of a picture, by Lanczos's kernel.

    middle: across and down, in raster pixels.
    """
    for axis, centre in zip((2, 1), middle, strict=True):
        size = picture.shape[axis]
        place = scale * (np.arange(size) + 0.5 - centre) + centre - 0.5
        whole = np.floor(place).astype(int)
        k = np.arange(1 - LOBES, 1 + LOBES)
        off = k - (place - whole)[:, None]
        taps = np.sinc(off) * np.sinc(off / LOBES)
        taps = (taps / taps.sum(1, keepdims=True)).astype(np.float32)
        source = np.clip(whole[:, None] + k, 0, size - 1)
        lines = np.ascontiguousarray(np.moveaxis(picture, axis, 0))
        total = np.zeros_like(lines)
        for j in range(2 * LOBES):
            total += taps[:, j, None, None] * lines[source[:, j]]
        picture = np.ascontiguousarray(np.moveaxis(total, 0, axis))
    return picture
