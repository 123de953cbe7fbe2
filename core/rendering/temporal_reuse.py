"""Temporal reuse: samples of the picture before, in the first samples of the next one while a dial is dragged.

Each pixel of the new picture finds what it sees in the picture before, by the first-order maps of both cameras and the
depth there. Those samples count the less, the more the circle of confusion has changed: noise and the error of an old
sample both grow with the contrast inside the circle, so that an old sample has the variance 1 + GHOST · q² of a new one
if the diameter has changed by the part q. Where the lens blurs, neighbouring new samples are averaged as well: they
lie closer together than the circle of confusion is wide. The traced light of small lights is kept apart. Raster points
in pixels, lengths in mm.
"""

from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.kernels.cache import njit
from lensbench.core.rendering.light_layer import first_order_map

MOST = 32.0             # old samples of a pixel that count at most
GHOST = 12.0            # variance of an old sample whose circle of confusion has doubled, in units of a new one's
SHARP = 1.0             # pixels: a circle of confusion smaller than a pixel is none
FARTHEST = 1e9          # mm; what lies farther is as far
LARGEST = 1e6           # pixels; a circle of confusion is no larger
SPREAD = 0.2            # of the diameter of the circle of confusion: distance of the new pixels that are averaged,
FARTHEST_TAP = 3        # at most (pixels)
GONE = 16               # new samples from which on the old ones have no weight

# A first-order map and its film, as of `Gaussian` and `film_from_raster`: rows of the kernel's parameters
PLANE_Z, ORIGIN_FILM, ORIGIN_PUPIL, SLOPE_FILM, SLOPE_PUPIL, PITCH_X, EDGE_X, PITCH_Y, EDGE_Y = range(9)


class Reusable(NamedTuple):
    """A picture whose samples the next one may use.

    image: (h, w, 3) linear RGB without the light layer. counts: (h, w) samples that it is worth. depth: (h, w) mm from
    the film along the axis, inf for the sky. blur: (h, w) diameter of the circle of confusion (pixels).
    """

    camera: Camera
    image: np.ndarray
    counts: np.ndarray
    depth: np.ndarray
    blur: np.ndarray | None = None

    def carried(self, camera: Camera, pool: Executor, threads: int) -> "Reusable | None":
        """The same samples in the picture of another camera; None where a map or the size of the film differs."""
        old, new, film = first_order_map(self.camera), first_order_map(camera), camera.film
        if old is None or new is None or self.depth.shape != (film.pixels_y, film.pixels_x):
            return None
        reused = Reusable(camera, np.zeros_like(self.image), np.zeros_like(self.counts), np.zeros_like(self.depth),
                         np.zeros_like(self.counts))
        maps = np.array([[*lens[:5], *each.film_step.parameters] for lens, each in ((old, self.camera), (new, camera))],
                        np.float32)
        was, now = self.camera.world_from_camera_at(0.0), camera.world_from_camera_at(0.0)      # neither moves
        old_from_new = np.linalg.inv(was) @ now
        places = np.stack([old_from_new, np.linalg.inv(old_from_new)]).astype(np.float32)
        is_still = np.array_equal(was, now)

        def carry(i: int) -> None:
            top, bottom = film.pixels_y * i // threads, film.pixels_y * (i + 1) // threads
            _carry(reused.image, reused.counts, reused.depth, reused.blur, self.image, self.counts, self.depth, maps,
                   places, is_still, top, bottom)

        list(pool.map(carry, range(threads)))
        return reused

    def mixed(self, image: np.ndarray, samples: int, pool: Executor, threads: int) -> "Reusable":
        """The same with `samples` new samples per pixel, whose mean is `image`."""
        share = np.float32(max(0.0, 1.0 - (samples - 1) / (GONE - 1.0)))
        counts, means = np.empty_like(self.counts), np.empty_like(self.image)
        blur, rows = self.blur if self.blur is not None else np.zeros_like(counts), len(counts)

        def mix(i: int) -> None:
            _mix(means, counts, image, np.float32(samples), self.image, self.counts, blur, share, rows * i // threads,
                 rows * (i + 1) // threads)

        list(pool.map(mix, range(threads)))
        return self._replace(image=means, counts=counts)


@njit(nogil=True, cache=True, error_model="numpy")
def _carry(image, counts, depth, blur, old_image, old_counts, old_depth, maps, places, is_still, top, bottom):
    """Fill the rows top … bottom − 1.

    maps (2, 7): the old camera's and the new one's. places (2, 4, 4): old from new, and back. is_still: both are the
    same. Single precision: it is a thousandth of a pixel, and twice as fast.
    """
    h, w = depth.shape
    old, new = maps[0], maps[1]
    one, half, farthest = np.float32(1), np.float32(0.5), np.float32(FARTHEST)
    ghost, most, sharp = np.float32(GHOST), np.float32(MOST), np.float32(SHARP)
    across, down = one / old[PITCH_X], one / old[PITCH_Y]
    for i in range(top, bottom):
        film_y = (np.float32(i) + half) * new[PITCH_Y] - new[EDGE_Y]
        for j in range(w):
            # Find the place in the old picture: the depth of the same pixel leads to it, then the depth there
            film_x = new[EDGE_X] - (np.float32(j) + half) * new[PITCH_X]
            far = min(old_depth[i, j], farthest)
            x, y, there = np.float32(j) + half, np.float32(i) + half, far
            row, column = np.uint32(i), np.uint32(j)
            for _ in range(2):
                if is_still:
                    size = _scale(new, far) / _scale(old, far)
                    x = (old[EDGE_X] - film_x * size) * across
                    y = (old[EDGE_Y] + film_y * size) * down
                else:
                    x, y = _old_place(film_x, film_y, far, old, new, places)
                if not ((x >= 0) & (x < w) & (y >= 0) & (y < h)):
                    far = np.float32(np.nan)
                    break
                row, column = np.uint32(y), np.uint32(x)
                there = min(old_depth[row, column], farthest)
                if there == far and is_still:
                    break
                far = there if is_still else _new_depth(x, y, there, old, places)
            depth[i, j] = far if far < farthest else np.float32(np.inf) if far >= farthest else old_depth[i, j]
            if not far > 0:
                continue

            # Weigh its samples by the change of the circle of confusion
            before, now = _diameter(old, there), _diameter(new, far)
            blur[i, j] = now
            change, wide = now - before, max(now, before) + sharp
            known = min(old_counts[row, column], most)
            counts[i, j] = known * wide * wide / (wide * wide + known * ghost * change * change)

            # Interpolate them
            a, b = x - half, y - half
            j0, i0 = int(a + one) - 1, int(b + one) - 1
            a, b = a - np.float32(j0), b - np.float32(i0)
            upper, lower = old_image[max(i0, 0)], old_image[min(i0 + 1, h - 1)]
            left, right = np.uint32(max(j0, 0)), np.uint32(min(j0 + 1, w - 1))      # unsigned: no index from the end
            for c in range(3):
                image[i, j, c] = ((one - b) * ((one - a) * upper[left, c] + a * upper[right, c])
                                  + b * ((one - a) * lower[left, c] + a * lower[right, c]))


@njit(nogil=True, cache=True, error_model="numpy")
def _scale(lens, far):
    """Scene mm per film mm at a depth, with its sign."""
    return lens[ORIGIN_FILM] + (lens[PLANE_Z] + far) * lens[SLOPE_FILM]


@njit(nogil=True, cache=True, error_model="numpy")
def _diameter(lens, far):
    """Diameter (pixels) of the circle of confusion at a depth, LARGEST at most: it has no bound at the lens."""
    diameter = abs(np.float32(2) * (lens[ORIGIN_PUPIL] + (lens[PLANE_Z] + far) * lens[SLOPE_PUPIL])
                   / (_scale(lens, far) * lens[PITCH_X]))
    return diameter if diameter < np.float32(LARGEST) else np.float32(LARGEST)      # nan too, at a pinhole itself


@njit(nogil=True, cache=True, error_model="numpy")
def _old_place(film_x, film_y, far, old, new, places):
    """Raster point in the old picture of what the new camera's film point (mm) sees at a depth."""
    size, m = _scale(new, far), places[0]
    px, py, pz = film_x * size, film_y * size, -far
    ox = m[0, 0] * px + m[0, 1] * py + m[0, 2] * pz + m[0, 3]
    oy = m[1, 0] * px + m[1, 1] * py + m[1, 2] * pz + m[1, 3]
    oz = m[2, 0] * px + m[2, 1] * py + m[2, 2] * pz + m[2, 3]
    if oz >= 0:
        return np.float32(-1), np.float32(-1)
    back = _scale(old, -oz)
    return (old[EDGE_X] - ox / back) / old[PITCH_X], (old[EDGE_Y] + oy / back) / old[PITCH_Y]


@njit(nogil=True, cache=True, error_model="numpy")
def _new_depth(x, y, far, old, places):
    """Depth from the new camera of what the old picture shows at a raster point and depth."""
    if far >= np.float32(FARTHEST):
        return far
    size, m = _scale(old, far), places[1]
    px, py = (old[EDGE_X] - x * old[PITCH_X]) * size, (y * old[PITCH_Y] - old[EDGE_Y]) * size
    return -(m[2, 0] * px + m[2, 1] * py - m[2, 2] * far + m[2, 3])


@njit(nogil=True, cache=True, error_model="numpy")
def _mix(means, counts, image, samples, old_image, old_counts, blur, share, top, bottom):
    """Fill the rows top … bottom − 1 with the mean of new samples, `image`, and old ones, `share` of their number.

    Where the lens blurs, nine new pixels are one: no detail is finer than the circle of confusion.
    """
    h, w = counts.shape
    for i in range(top, bottom):
        for j in range(w):
            step = int(min(blur[i, j] * np.float32(SPREAD * share), np.float32(FARTHEST_TAP)))
            red = green = blue = np.float32(0)
            taps = 0
            for k in range(-step, step + 1, max(step, 1)):
                row = np.uint32(min(max(i + k, 0), h - 1))
                for m in range(-step, step + 1, max(step, 1)):
                    column = np.uint32(min(max(j + m, 0), w - 1))
                    if blur[row, column] * np.float32(SPREAD * share) >= step:
                        red += image[row, column, 0]
                        green += image[row, column, 1]
                        blue += image[row, column, 2]
                        taps += 1
            one = np.float32(1) / np.float32(taps)
            old, new = share * old_counts[i, j], samples * np.float32(taps)
            counts[i, j] = old + new
            weight = old / (old + new)
            red, green, blue = red * one, green * one, blue * one
            means[i, j, 0] = red + weight * (old_image[i, j, 0] - red)
            means[i, j, 1] = green + weight * (old_image[i, j, 1] - green)
            means[i, j, 2] = blue + weight * (old_image[i, j, 2] - blue)
