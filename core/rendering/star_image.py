"""The stars of a picture: light of its lights that the edges of the open pupil diffract about their images.

The image of the lights alone, of the sun and of small lights in and beside the picture, comes from their direct rays
(`GhostImage` of DIRECT). Its convolution with the star of the pupil (`star_kernel`) is added to the picture, and what
the stars have is taken from the lights, so that light is kept. The pupil is that of the lens's axis, at the stop's
blades; a light out of focus has the star about each point of its blur. The stars of a picture of more than LARGEST
pixels are made with fewer.

The pupil is a polygon in direction cosines from the film point, of area A. Far from the core, the fringes between
edges average out over a pixel and the wavelengths of a channel; the squared amplitude of each edge is left. An edge of
length ℓ sends ℓ λ / (4 π² A q²) of the light per mm to either side across itself, q the distance from the image, and
spreads it along itself as sinc²(ℓ u / λ), of width λ / ℓ. Edges that follow each other with a small turn are a curve of
the length ℓ: each of them sends its light into the angle by which it turns. All edges together send P λ / (2 π² A q), P
the perimeter, beyond q: for a circle of radius a this is λ / (π² a q), as of the Airy pattern.

References:
    Keller, J. Opt. Soc. Am. 52 (1962): geometrical theory of diffraction. Born and Wolf, "Principles of Optics",
    § 8.5.2.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property

import numpy as np

from lensbench.core.analysis.blade_star import open_pupil
from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.real_lens import LensCamera
from lensbench.core.imaging.film import Film
from lensbench.core.imaging.spectrum import WAVELENGTHS
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.ghost_path import DIRECT
from lensbench.core.optics.ghost_trace import Visible
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.rendering.ghost_image import MOST as PASSES, Flare, GhostImage
from lensbench.core.scenery.scene import Scene

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


STAR_KERNEL_LINES = mean_lines(tuple(WAVELENGTHS.values()))


def star_kernel(pupil: np.ndarray, film: Film, reach: tuple[int, int], lines: np.ndarray = STAR_KERNEL_LINES
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


MOST = 4.0              # of a pixel: first passes show a large light at some of its points alone
GRIDS = 600             # of rays, that the first sample traces where one pass has fewer
BLUR = 4.0              # pixels, over the root of the passes: how far about the points of lights their part is taken
LARGEST = 2_100_000     # pixels
LINES = 64              # of a picture that get their stars at once
CHANNELS = tuple(WAVELENGTHS.values())
MARGIN = 0.25           # of the film's sides, beside it: lights whose image falls there have their stars in the picture


class StarImage:
    """Stars of a picture, after the passes so far; none where there is a `reason`.

    Parameters: the camera, whose model is resolved; the scene; the factor on their light; the wavelengths (µm) of red,
    green and blue.
    """

    def __init__(self, camera: Camera, scene: Scene, strength: float, channels: Visible = CHANNELS):
        self._film = camera.film.pixels_y, camera.film.pixels_x
        if isinstance(camera, LensCamera):
            camera = replace(camera, film=_of_fewer_pixels(camera.film))
        film = camera.film
        self._margin = int(MARGIN * film.pixels_x), int(MARGIN * film.pixels_y)
        self._lights = GhostImage(camera, scene, Flare(pairs=(DIRECT,)), self._margin)
        self.reason = self._lights.reason.replace("ghosts", "stars")
        self._camera, self._strength, self._channels = camera, strength, channels
        self._shape = film.pixels_y, film.pixels_x
        self._stars, self._taken = np.zeros((2, 0 if self.reason else film.pixels_y, film.pixels_x, 3), np.float32)
        self._at = 0                # passes of the lights that the stars are made of

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Why there are no stars; what follows from the lights is known after the first sample."""
        dark = "no stars: no light lies in the picture or beside it" if self._at and self._lights.is_dark else ""
        return (note(Kind.NO_GHOSTS, self.reason or dark),) if self.reason or dark else ()

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name, for `restore`."""
        return {name.replace("ghost", "star"): sums for name, sums in self._lights.state.items()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from such sums."""
        self._lights.restore({name: state[name.replace("ghost", "star")] for name in self._lights.state})
        if not self.reason:
            self._make()

    def add(self, samples: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Add the lights of so many samples; False when `wanted` cancelled on the way."""
        if self.reason:
            return True
        if not self._lights.add(samples, pool, threads, wanted):
            return False
        if self._lights.reason:
            self.reason = self._lights.reason.replace("ghosts", "stars")
            return True
        # A pass shows a large light at one of its points: few lights have many passes at once
        if not self._lights.go_on_to(GRIDS // max(self._lights.light_count, 1), pool, threads, wanted):
            return False
        if self._lights.passes >= 2 * self._at:         # the stars of more passes differ less and less
            self._make()
        return True

    def add_to(self, picture: np.ndarray, top: int = 0) -> None:
        """Add the stars to lines of a picture (lines, w, 3), of which `top` is the first.

        Their light is taken from it: at most MOST of the part of a light.
        """
        if not self.reason:
            darkening = np.minimum(MOST * self._strength * self._transform[1], 1.0).astype(np.float32)
            for first in range(0, len(picture), LINES):
                lines = picture[first:first + LINES]
                pixels = range(top + first, top + first + len(lines))
                lines -= np.minimum(_enlarged(self._taken, self._film, pixels), darkening * lines)
                lines += _enlarged(self._stars, self._film, pixels)

    def _make(self) -> None:
        """Make the stars of the lights so far, and what they take from these; a dark axis is the `reason` for none."""
        try:
            transform, parts = self._transform
        except LensError as error:
            self.reason = f"no stars: {error}"
            return
        (down, across), (beside, above) = self._shape, self._margin
        lights = np.zeros((down + 2 * above, across + 2 * beside, 3), np.float32)
        self._lights.add_to(lights)
        self._at = self._lights.passes
        size, film = (2 * (down + above), 2 * (across + beside)), np.s_[above:above + down, beside:beside + across]
        blur = BLUR / math.sqrt(self._at) if 0 < self._at < PASSES else 0.0
        blurs = [np.exp(-2.0 * (math.pi * blur * frequency(n)) ** 2)
                 for frequency, n in zip((np.fft.fftfreq, np.fft.rfftfreq), size, strict=True)]
        for channel in range(3):
            spectrum = np.fft.rfft2(lights[..., channel], size)
            gain = self._strength * parts[channel]
            for layer, kernel in ((self._stars, transform), (self._taken, np.multiply.outer(*blurs))):
                layer[..., channel] = gain * np.maximum(np.fft.irfft2(spectrum * kernel, size)[film], 0.0)   # it rounds

    @cached_property
    def _transform(self) -> tuple[np.ndarray, np.ndarray]:
        """Transform of the star of 1, and the parts of a light that the star has, (3,)."""
        assert isinstance(self._camera, LensCamera)
        (down, across), (beside, above) = self._shape, self._margin
        pupil = open_pupil(self._camera.lens, self._camera.film_distance, (0.0, 0.0))
        kernel, parts = star_kernel(pupil, self._camera.film, (across + beside - 1, down + above - 1),
                                    mean_lines(self._channels))
        padded = np.zeros((2 * (down + above), 2 * (across + beside)))
        padded[:kernel.shape[0], :kernel.shape[1]] = kernel
        return np.fft.rfft2(np.roll(padded, (1 - down - above, 1 - across - beside), (0, 1))), parts


def _of_fewer_pixels(film: Film) -> Film:
    """The film with at most LARGEST pixels, of the same shape each: one for so many of its own on a side."""
    side = max(1, math.ceil(math.sqrt(film.pixels_x * film.pixels_y / LARGEST)))
    return film if side == 1 else replace(film, pixels_x=-(-film.pixels_x // side), pixels_y=-(-film.pixels_y // side))


def _enlarged(image: np.ndarray, film: tuple[int, int], lines: range) -> np.ndarray:
    """Lines (lines, w, 3) of an image (h, w, 3) with the pixels (down, across) of a film, linear between its own."""
    for axis, pixels in enumerate((lines, range(film[1]))):
        count, own = film[axis], image.shape[axis]
        if count == own:
            image = image[lines.start:lines.stop] if axis == 0 else image
        else:
            position = np.clip((np.array(pixels) + 0.5) * (own / count) - 0.5, 0.0, own - 1.0)
            low = np.minimum(position.astype(int), max(own - 2, 0))
            share = (position - low).astype(np.float32).reshape(-1, *[1] * (2 - axis))
            image = np.take(image, low, axis) * (1 - share) + np.take(image, np.minimum(low + 1, own - 1), axis) * share
    return image


class FlareImage:
    """Ghosts and stars of a picture, after the samples so far; what has the strength 0 is not made.

    Parameters: the camera, whose model is resolved; the scene; what is shown.
    """

    def __init__(self, camera: Camera, scene: Scene, flare: Flare):
        self._parts: list[GhostImage | StarImage] = []
        if flare.strength > 0.0:
            self._parts.append(GhostImage(camera, scene, flare))
        if flare.stars > 0.0:
            self._parts.append(StarImage(camera, scene, flare.stars, flare.channels))

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to add."""
        return all(effect.reason for effect in self._parts)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Why there are no ghosts or stars, or which lights have none; the latter is known after the first sample."""
        return tuple(finding for effect in self._parts for finding in effect.findings)

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name, for `restore`."""
        return {name: sums for effect in self._parts for name, sums in effect.state.items()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from such sums."""
        for effect in self._parts:
            effect.restore(state)

    def add(self, samples: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Add the light of so many samples; False when `wanted` cancelled on the way."""
        return all(part.add(samples, pool, threads, wanted) for part in self._parts)

    def add_to(self, picture: np.ndarray, top: int = 0) -> None:
        """Add the light so far to lines of a picture (lines, w, 3), the first of which is `top`."""
        for darkening in self._parts:
            darkening.add_to(picture, top)
