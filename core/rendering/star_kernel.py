"""The star about a small light on the raster: light that the edges of the open pupil diffract across themselves.

The pupil is a polygon in direction cosines from the film point, of area A. Far from the core, the fringes between
edges average out over a pixel and the wavelengths of a channel; the squared amplitude of each edge is left. An edge of
length ℓ sends ℓ λ / (4 π² A q²) of the light per mm to either side across itself, q the distance from the image, and
spreads it along itself as sinc²(ℓ u / λ), of width λ / ℓ. Edges that follow each other with a small turn are a curve of
the length ℓ: each of them sends its light into the angle by which it turns. All edges together send P λ / (2 π² A q), P
the perimeter, beyond q: for a circle of radius a this is λ / (π² a q), as of the Airy pattern.

References
----------
Keller, J. Opt. Soc. Am. 52 (1962): geometrical theory of diffraction. Born and Wolf, "Principles of Optics", § 8.5.2.
"""

import math
from collections.abc import Sequence

import numpy as np

from lensbench.imaging.film import Film
from lensbench.imaging.spectrum import WAVELENGTHS
from lensbench.kernels.cache import njit

LEAST = 2.0             # Airy radii, and
NEAREST = 0.5           # pixels, from which on light counts to the star: nearer to the image it is that of the core
FINEST = 0.25           # pixels between places along a ray; farther out a tenth of the distance, but at most one pixel
PLACES = 16             # along a straight edge, at even shares of sinc²
FEWEST = 4              # along an edge of a curve; more where it turns over several pixels
CURVED = 0.2            # radians: a smaller turn from edge to edge is that of a curve
SHORT = 0.1             # of the longest curve: a shorter one rounds a corner off, and sends next to no light
GOLDEN = 0.6180339887498949     # whose multiples modulo 1 are even


def mean_lines(channels: Sequence[Sequence[float]]) -> np.ndarray:
    """The mean wavelengths (3,) in mm of the wavelengths (µm) of red, green and blue."""
    return np.array([1e-3 * sum(row) / len(row) for row in channels])


LINES = mean_lines(tuple(WAVELENGTHS.values()))


def star_kernel(pupil: np.ndarray, film: Film, reach: tuple[int, int], lines: np.ndarray = LINES
                ) -> tuple[np.ndarray, np.ndarray]:
    """The star on the raster, and the part of the light of red, green and blue that it takes from the image, (3,).

    pupil: corners (m, 2) in order, direction cosines. reach: greatest distances in pixels, across and down. lines (3,):
    wavelengths of red, green and blue (mm). The star is (2 down + 1, 2 across + 1), its middle the image, for a part of
    1; it has less than 1: the rest falls beyond it. A ray has the width of green: those of red and blue differ by a
    sixth, below a pixel but for small stops.
    """
    edges = np.roll(pupil, -1, 0) - pupil
    lengths = np.hypot(*edges.T)
    area = abs(0.5 * float((pupil[:, 0] * np.roll(pupil[:, 1], -1) - pupil[:, 1] * np.roll(pupil[:, 0], -1)).sum()))
    pixel = np.array([film.width / film.pixels_x, film.height / film.pixels_y])
    size = float(pixel.mean())
    airy = 0.61 * lines.max() / math.sqrt(area / math.pi)
    nearest = max(NEAREST * size, LEAST * airy)
    farthest = math.hypot(reach[0] * pixel[0], reach[1] * pixel[1])
    distances = [nearest]
    while distances[-1] < farthest:
        distances.append(distances[-1] + min(max(FINEST * size, 0.1 * distances[-1]), size))
    kernel = np.zeros((2 * reach[1] + 1, 2 * reach[0] + 1))
    turns, curves = _curves(edges, lengths)
    keep = curves > SHORT * curves.max()
    edges, lengths, turns, curves = edges[keep], lengths[keep], turns[keep], curves[keep]
    units = edges / lengths[:, None]
    # x of the raster runs against x of the film: an edge (a, b) is (−a, b) there, and its normal (−b, a) is (b, a)
    _add_edges(kernel, units / pixel * [-1.0, 1.0], units[:, ::-1] / pixel, lengths, turns, lines[1] / curves,
               np.array(distances), 1.0 / size, 0.5 * nearest / lengths.sum(), _even_shares())
    return kernel, lengths.sum() * lines / (2.0 * math.pi**2 * area * nearest)


def _curves(edges: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angle by which each edge (m, 2) turns, 0 for a straight one, and the length of its curve."""
    before = np.roll(edges, 1, 0)
    turn = np.arctan2(before[:, 0] * edges[:, 1] - before[:, 1] * edges[:, 0], (before * edges).sum(1))
    corner = np.abs(turn) >= CURVED                         # at the beginning of each edge
    half = np.where(corner, 0.0, 0.5 * np.abs(turn))
    curve = np.cumsum(corner)
    curve[curve == curve[-1]] = curve[0] if not corner[0] else curve[-1]        # over the end of the list
    return half + np.roll(half, -1), np.bincount(curve, lengths)[curve]


def _even_shares() -> np.ndarray:
    """Places (PLACES,) that have even shares of sinc²(x) = (sin πx / πx)², symmetric about 0."""
    x = np.linspace(0.0, 40.0, 40001)
    ends = np.concatenate([[0.0], np.cumsum(0.5 * (np.sinc(x[1:])**2 + np.sinc(x[:-1])**2) * np.diff(x))])
    half = np.interp((np.arange(PLACES // 2) + 0.5) / PLACES, ends, x)      # the whole integral over x ≥ 0 is 1/2
    return np.concatenate([-half[::-1], half])


@njit(cache=True, nogil=True, error_model="numpy")
def _add_edges(kernel, along, across, lengths, turns, spreads, distances, per_mm, scale, shares):
    """Add the light of each edge, whose directions along and across itself are in pixels per mm.

    spreads: λ over the length of the curve of each edge (mm). distances: ends of the parts of a ray (mm). per_mm:
    pixels.
    """
    middle_x, middle_y = kernel.shape[1] // 2, kernel.shape[0] // 2
    for e in range(lengths.size):
        for k in range(distances.size - 1):
            near, far = distances[k], distances[k + 1]
            between = 1.0 / near - 1.0 / far
            q = math.log(far / near) / between                          # where the mean light of this part falls
            places = shares.size if turns[e] == 0.0 else FEWEST + int(2.0 * q * turns[e] * per_mm)
            light = scale * lengths[e] * between / places
            for n in range(places):
                share = shares[n if turns[e] == 0.0 else (5 * n + k) % shares.size]
                u = share * spreads[e] + q * turns[e] * ((n + k * GOLDEN % 1.0) / places - 0.5)
                x, y = q * across[e, 0] + u * along[e, 0], q * across[e, 1] + u * along[e, 1]
                _add_light(kernel, middle_x + x, middle_y + y, light)
                _add_light(kernel, middle_x - x, middle_y - y, light)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_light(kernel, x, y, light):
    """Share light between the four pixels around a place."""
    i, j = int(math.floor(x)), int(math.floor(y))
    f, g = x - i, y - j
    for down in range(2):
        for right in range(2):
            if 0 <= i + right < kernel.shape[1] and 0 <= j + down < kernel.shape[0]:
                share = (f if right else 1.0 - f) * (g if down else 1.0 - g)
                kernel[j + down, i + right] += share * light
