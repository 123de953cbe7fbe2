"""The kernel of refocusing: adding views, each read between its pixels at a shift and a slightly other scale.

The pixel grids of the views are offset against each other, so that samples fill the pixels of the sum. One short filter
restores the fine detail that linear reading and the shift within a cell of the pupil take. (Scaling the sum instead of
the views costs two decibels.)
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from lensbench.core.kernels.arrays import as_bits, prefetch, scale_of, unscaled
from lensbench.core.kernels.cache import njit

TAPS = 6                # of the sharpening filter, to either side
HIGHEST_GAIN = 2.0      # of the sharpening filter
LOBES = 5               # of Lanczos's kernel
BAND = 32               # rows that a thread takes at a time
CACHE_LINE = 64         # bytes


def shift_and_add(light: np.ndarray, used: np.ndarray, starts: np.ndarray, scale: float, weights: np.ndarray,
                  step: np.ndarray, fill: float = 1.0, gain: float = 1.0) -> np.ndarray:
    """Sum of shifted views: float32 (h, w, 3), gain · Σ weight · view(start + scale · pixel), of filled pixels.

    light: (views down, views across, 3, h, w), float32, or half floats that are never negative; used: (n, 2) row and
    column of the views; starts: (n, 2) across and down, pixels; step: (2,) pixels by which the rays of one view spread;
    fill: side of the part of a pixel that a view's samples fill. Where a view ends, the others count for all; a pixel
    that none reaches is 0. The filter stays within HIGHEST_GAIN of its neighbours' range.
    """
    h, w = light.shape[3:]
    bits, weights = as_bits(light), weights.astype(np.float32)
    across, down = (_sharpening(starts[:, axis] % 1.0 if scale == 1.0 else (np.arange(len(used)) + 0.5) / len(used),
                                weights, abs(step[axis]), fill) for axis in (0, 1))
    sums, out = np.zeros((3, h, w), np.float32), np.empty((h, w, 3), np.float32)
    beside, inside = reached(starts, scale, h, w)
    scaled = weights * scale_of(bits)

    def add(first: int) -> None:
        _add(bits, used, starts, scale, scaled, sums, first, min(first + BAND, h))

    def sharpen(first: int) -> None:
        _sharpen(sums, across, down, np.float32(gain), out, first, min(first + BAND, h))

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        list(pool.map(add, range(0, h, BAND)))
        for rows, columns in _edges(beside, inside):
            share = recorded_share(beside[:, rows], inside[:, columns], weights)
            sums[:, rows, columns] /= np.where(share > 0.0, share, np.float32(1.0))
        list(pool.map(sharpen, range(0, h, BAND)))
    return out


def reached(starts: np.ndarray, scale: float, h: int, w: int) -> tuple[np.ndarray, np.ndarray]:
    """Float32 (n, h) and (n, w): 1 for the rows and columns of a sum that each view, h × w, holds."""
    down, across = (np.array([_reached(start, scale, size) for start in starts[:, axis]])
                    for axis, size in ((1, h), (0, w)))
    x, y = np.arange(w), np.arange(h)
    return (((y >= down[:, :1]) & (y < down[:, 1:])).astype(np.float32),
            ((x >= across[:, :1]) & (x < across[:, 1:])).astype(np.float32))


def recorded_share(beside: np.ndarray, inside: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Float32 (h, w): the part of the weights (n,) whose views hold a pixel; beside, inside: as of `reached`."""
    return ((beside * weights[:, None]).T @ inside / weights.sum()).astype(np.float32)


def _edges(beside: np.ndarray, inside: np.ndarray) -> list[tuple[slice, slice]]:
    """Rows and columns of the parts of a sum about the rectangle that all views hold."""
    (top, bottom), (left, right) = ((int(full.argmax()), len(full) - int(full[::-1].argmax())) if full.any()
                                    else (len(full), len(full)) for full in (beside.min(0) > 0.0, inside.min(0) > 0.0))
    return [(slice(0, top), slice(None)), (slice(bottom, None), slice(None)),
            (slice(top, bottom), slice(0, left)), (slice(top, bottom), slice(right, None))]


@njit(cache=True)
def _reached(start, scale, size):
    """First and past-the-last i whose place start + scale · i lies between the middles of a line's `size` pixels."""
    first, last = math.ceil(-start / scale - 1e-6), math.floor((size - 1 - start) / scale + 1e-6)
    return min(max(first, 0), size), min(max(last + 1, 0), size)


def spectral_gain(f: np.ndarray, step: float, fill: float) -> np.ndarray:
    """Gain at frequencies f (cycles per pixel) that turns views at their exact positions into a picture of filled
    pixels.

    step: pixels by which the rays of one view spread; fill: side of the part of a pixel that its samples fill.
    """
    return 1.0 / np.maximum(np.sinc(f * step) * np.sinc(f * fill) / np.sinc(f), 1.0 / HIGHEST_GAIN)


def _sharpening(fraction: np.ndarray, weights: np.ndarray, step: float, fill: float) -> np.ndarray:
    """The filter (2 TAPS + 1,) that turns views read at these parts of a pixel (n,) into a picture of filled pixels, or
    (1,).
    """
    f = np.fft.rfftfreq(8 * TAPS)
    turns = np.exp(-2j * math.pi * f[:, None] * fraction)
    read = ((1.0 - fraction) * turns + fraction * turns * np.exp(2j * math.pi * f[:, None])) @ weights / weights.sum()
    response = read.real * np.sinc(f * step) * np.sinc(f * fill) / np.sinc(f)
    if np.abs(response - 1.0).max() < 1e-6:
        return np.ones(1, np.float32)
    taps = np.fft.fftshift(np.fft.irfft(1.0 / np.maximum(response, 1.0 / HIGHEST_GAIN)))
    middle = len(taps) // 2
    window = 0.5 + 0.5 * np.cos(math.pi * np.arange(-TAPS, TAPS + 1) / (TAPS + 1))
    taps = taps[middle - TAPS:middle + TAPS + 1] * window
    return (taps / taps.sum()).astype(np.float32)


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _add(light, used, starts, scale, weights, sums, first, last):
    """Add all views to the rows first … last − 1 of the sums (3, h, w), the next view prefetched."""
    h, w = light.shape[3], light.shape[4]
    line, parts, runs = np.zeros(w + 1, np.float32), np.zeros(w, np.float32), np.zeros((w + 1, 2), np.int64)
    one, ahead = np.float32(1), CACHE_LINE // light.itemsize
    for q in range(len(used)):
        following = min(q + 1, len(used) - 1)
        number = _runs(starts[q, 0], scale, parts, runs)
        top_row, end_row = _reached(starts[q, 1], scale, h)
        for channel in range(3):
            view = light[used[q, 0], used[q, 1], channel]
            later = light[used[following, 0], used[following, 1], channel]
            for y in range(first, last):
                soon = later[min(max(int(starts[following, 1] + scale * y), 0), h - 1)]
                for i in range(0, w, ahead):
                    prefetch(soon, i)
                if y < top_row or y >= end_row:
                    continue

                # Interpolate between two rows of the view
                row = starts[q, 1] + scale * y
                top = int(math.floor(row))
                below = np.float32(row - top)
                above, under = view[min(max(top, 0), h - 1)], view[min(max(top + 1, 0), h - 1)]
                b = weights[q] * below
                a = weights[q] - b
                if below == np.float32(0) or below == one:
                    nearest = under if below == one else above
                    for i in range(w):
                        line[i] = weights[q] * unscaled(nearest[i])
                else:
                    for i in range(w):
                        line[i] = a * unscaled(above[i]) + b * unscaled(under[i])
                line[w] = line[w - 1]

                # Interpolate along the row, run by run
                for k in range(number):
                    start, end, shift = runs[k, 0], runs[k + 1, 0], runs[k, 1]
                    near_texels, far_texels = line[start + shift:end + shift], line[start + shift + 1:end + shift + 1]
                    fraction, into = parts[start:end], sums[channel, y, start:end]
                    for i in range(into.size):
                        into[i] += near_texels[i] + fraction[i] * (far_texels[i] - near_texels[i])


@njit(inline="always")
def _runs(start, scale, parts, runs):
    """Weights (w,) of the second of two pixels at start + scale · i, and runs of i with the same whole shift; their
    number.

    A run is its first i and its shift in pixels; the end of what the view holds follows.
    """
    w, number = parts.size, 0
    first, end = _reached(start, scale, w)
    for i in range(first, end):
        position = min(max(start + scale * i, 0.0), float(w - 1))
        whole = int(position)
        parts[i] = np.float32(position - whole)
        if number == 0 or runs[number - 1, 1] != whole - i:
            runs[number, 0], runs[number, 1] = i, whole - i
            number += 1
    runs[number, 0] = end
    return number


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _sharpen(sums, across, down, gain, out, first, last):
    """Set the rows first … last − 1 of the picture (h, w, 3) to gain × the filtered sums (3, h, w)."""
    _, h, w = sums.shape
    reach = len(across) // 2
    line, made = np.zeros(w + 2 * reach, np.float32), np.zeros((3, w), np.float32)
    low, high = np.float32(1.0 / HIGHEST_GAIN), np.float32(HIGHEST_GAIN)
    for y in range(first, last):
        for channel in range(3):
            line[:], made[channel] = np.float32(0), np.float32(0)
            inner, into = line[reach:reach + w], made[channel]
            for k in range(len(down)):
                source, tap = sums[channel, min(max(y + k - len(down) // 2, 0), h - 1)], down[k] * gain
                for i in range(w):
                    inner[i] += tap * source[i]
            above, middle, below = sums[channel, max(y - 1, 0)], sums[channel, y], sums[channel, min(y + 1, h - 1)]
            if len(down) > 1:
                for i in range(w):
                    least, most = min(above[i], middle[i], below[i]), max(above[i], middle[i], below[i])
                    inner[i] = min(max(inner[i], low * gain * least), high * gain * most)
            line[:reach], line[reach + w:] = line[reach], line[reach + w - 1]
            for k in range(len(across)):
                tap, shifted = across[k], line[k:k + w]
                for i in range(w):
                    into[i] += tap * shifted[i]
            if len(across) > 1:
                for i in range(w):
                    a, b, c = inner[max(i - 1, 0)], inner[i], inner[min(i + 1, w - 1)]
                    into[i] = min(max(into[i], low * min(a, b, c)), high * max(a, b, c))
        for i in range(w):
            out[y, i, 0], out[y, i, 1], out[y, i, 2] = made[0, i], made[1, i], made[2, i]


def rescaled(picture: np.ndarray, scale: float, middle: np.ndarray) -> np.ndarray:
    """The picture (3, h, w) whose pixel x is at scale · (x − middle) + middle of another, by Lanczos's kernel; middle:
    (2,).
    """
    for axis, centre in zip((2, 1), middle, strict=True):
        size = picture.shape[axis]
        position = scale * (np.arange(size) + 0.5 - centre) + centre - 0.5
        whole = np.floor(position).astype(int)
        k = np.arange(1 - LOBES, 1 + LOBES)
        off = k - (position - whole)[:, None]
        taps = np.sinc(off) * np.sinc(off / LOBES)
        taps = (taps / taps.sum(1, keepdims=True)).astype(np.float32)
        source = np.clip(whole[:, None] + k, 0, size - 1)
        lines = np.ascontiguousarray(np.moveaxis(picture, axis, 0))
        total = np.zeros_like(lines)
        for j in range(2 * LOBES):
            total += taps[:, j, None, None] * lines[source[:, j]]
        picture = np.ascontiguousarray(np.moveaxis(total, 0, axis))
    return picture
