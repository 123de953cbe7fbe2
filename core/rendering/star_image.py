"""The stars of a picture: light of its lights that the edges of the open pupil diffract about their images.

The image of the lights alone, of the sun and of small lights in and beside the picture, comes from their direct rays
(`GhostImage` of DIRECT). Its convolution with the star of the pupil (`star_kernel`) is added to the picture, and what
the stars have is taken from the lights, so that light is kept. The pupil is that of the lens's axis, at the stop's
blades; a light out of focus has the star about each point of its blur. The stars of a picture of more than LARGEST
pixels are made with fewer.
"""

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property

import numpy as np

from lensbench.analysis.blade_star import open_pupil
from lensbench.cameras.base import Camera
from lensbench.cameras.real_lens import LensCamera
from lensbench.imaging.film import Film
from lensbench.imaging.spectrum import WAVELENGTHS
from lensbench.optics.finding import Finding, Kind, note
from lensbench.optics.ghost_pairs import DIRECT
from lensbench.optics.ghost_trace import Visible
from lensbench.optics.lens_surface import LensError
from lensbench.rendering.ghost_image import MOST as PASSES
from lensbench.rendering.ghost_image import Flare, GhostImage
from lensbench.rendering.star_kernel import mean_lines, star_kernel
from lensbench.scenery.scene import Scene

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
            part = np.minimum(MOST * self._strength * self._transform[1], 1.0).astype(np.float32)
            for first in range(0, len(picture), LINES):
                lines = picture[first:first + LINES]
                place = range(top + first, top + first + len(lines))
                lines -= np.minimum(_enlarged(self._taken, self._film, place), part * lines)
                lines += _enlarged(self._stars, self._film, place)

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
            seen = np.fft.rfft2(lights[..., channel], size)
            gain = self._strength * parts[channel]
            for part, kernel in ((self._stars, transform), (self._taken, np.multiply.outer(*blurs))):
                part[..., channel] = gain * np.maximum(np.fft.irfft2(seen * kernel, size)[film], 0.0)   # it rounds

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
            place = np.clip((np.array(pixels) + 0.5) * (own / count) - 0.5, 0.0, own - 1.0)
            low = np.minimum(place.astype(int), max(own - 2, 0))
            share = (place - low).astype(np.float32).reshape(-1, *[1] * (2 - axis))
            image = np.take(image, low, axis) * (1 - share) + np.take(image, np.minimum(low + 1, own - 1), axis) * share
    return image
