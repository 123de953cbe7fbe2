"""Rays of small lights on the film: lists of them, their sum, and the light layer that one picture lends to another.

While a dial is dragged, the selection and the tracing of small lights take longer than the camera's first sample. The
picture then shows the rays of the setting before, re-imaged: the blurred disc of each light moves to its new place and
takes its new size, by the first-order maps of both cameras. Raster points in pixels.
"""

from collections.abc import Callable
from concurrent.futures import Executor
from typing import NamedTuple

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.ideal_lens import Gaussian
from lensbench.cameras.rays import CameraError
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.imaging.coordinate_spaces import transform_points
from lensbench.kernels.cache import njit
from lensbench.rendering.light_selection import SelectedLight
from lensbench.scenery.small_lights import POINTS, ExcludedLight

LEAST, MOST = 0.125, 8.0    # of the scale of a disc: beyond it the rays of a sharp light would lie far apart
SHARPEST = 0.25             # pixels: least radius of a disc, where a light is in focus

# Rows of a list of rays: raster point, radiance × weight, and V0
LIST_X, LIST_Y, LIST_RED, LIST_GREEN, LIST_BLUE, LIST_V0 = range(6)
LIST_SIZE = 6


class Placed(NamedTuple):
    """Images of n points: raster x and y, signed radius of the blur in pixels, film mm for each mm of the scene."""

    x: np.ndarray
    y: np.ndarray
    blur: np.ndarray
    scale: np.ndarray


class LightLayer(NamedTuple):
    """The light image of a picture by its rays.

    camera: of that picture. rays: (LIST_SIZE, n) of its first pass. parts: (m, 3) index of a light, its first ray, and
    the end of its rays. Of each light: centres (k, 3) in the world (mm), discs (k, 2) centres of the blurred images,
    images (k, 2, 2) of the half-axes (pixels), points (k, POINTS, 5) and shared (k,) as of `SelectedLight`. excluded:
    light that the camera's rays must not see beside this layer; None without such lights.
    """

    camera: Camera
    rays: np.ndarray
    parts: np.ndarray
    centres: np.ndarray
    discs: np.ndarray
    images: np.ndarray
    points: np.ndarray
    shared: np.ndarray
    excluded: ExcludedLight | None

    @classmethod
    def of(cls, camera: Camera, lights: list[SelectedLight], kept: list[tuple[int, np.ndarray]],
           excluded: ExcludedLight | None) -> "LightLayer":
        """The layer of these lights. kept: indices of lights, and lists (LIST_SIZE, n) of their rays."""
        ends = np.cumsum([0, *(found.shape[1] for _, found in kept)])
        parts = np.column_stack([[light for light, _ in kept], ends[:-1], ends[1:]]).astype(np.int64)
        rays = np.concatenate([np.empty((LIST_SIZE, 0), np.float32), *(found for _, found in kept)], 1)
        centres = np.array([light.centre for light in lights]).reshape(-1, 3)
        if lights:
            centres = transform_points(camera.world_from_camera, centres)
        return cls(camera, rays, parts, centres, np.array([light.disc[:2] for light in lights]).reshape(-1, 2),
                   np.array([light.image for light in lights], np.float32).reshape(-1, 2, 2),
                   np.array([light.points for light in lights], np.float32).reshape(-1, POINTS, 5),
                   np.array([light.shared for light in lights], np.int64), excluded)

    def suits(self, camera: Camera) -> bool:
        """Whether the layer can be re-imaged for another camera."""
        return first_order_map(self.camera) is not None and first_order_map(camera) is not None

    def seen_by(self, camera: Camera, pool: Executor, threads: int, wanted: Callable[[], bool]) -> np.ndarray:
        """The light (h, w, 3) as a camera sees it that the layer suits; incomplete where `wanted` returns False."""
        film = camera.film
        across, down = film.pixels_x, film.pixels_y
        image = np.zeros((down * across, 3), np.float32)
        if not len(self.centres):
            return image.reshape(down, across, 3)

        # Place and scale of each disc, before and after
        old, new = _placed(self.camera, self.centres), _placed(camera, self.centres)
        sharp = np.maximum(0.5 * np.abs(self.images).sum((1, 2)), SHARPEST)
        with np.errstate(invalid="ignore", divide="ignore"):
            grown = np.clip(np.hypot(new.blur, sharp) / np.hypot(old.blur, sharp), LEAST, MOST)
            grown *= np.where(old.blur * new.blur < 0.0, -1.0, 1.0)
            enlarged = np.abs(new.scale / old.scale)
            images = self.images * enlarged[:, None, None].astype(np.float32)
        # With relative weights, each has as much light as its sharp image has area
        moves = np.column_stack([grown, new.x - old.x + (1.0 - grown) * self.discs[:, 0],
                                 new.y - old.y + (1.0 - grown) * self.discs[:, 1], enlarged**2])
        known = np.isfinite(moves).all(1)
        moves = np.where(known[:, None], moves, [1.0, 0.0, 0.0, 1.0]).astype(np.float32)
        images = np.where(known[:, None, None], images, self.images)

        def add(i: int) -> None:
            if wanted():
                _add_moved(image, self.rays, self.parts, moves, across, down * i // threads,
                           down * (i + 1) // threads, images, self.points, self.shared)

        list(pool.map(add, range(threads)))
        return image.reshape(down, across, 3)


def first_order_map(camera: Camera) -> Gaussian | None:
    """The first-order map of a camera that does not move, its film in line; None without one."""
    try:
        return (None if isinstance(camera.world_from_camera, AnimatedTransform) or not camera.film_pose.is_upright
                else camera.gaussian)
    except CameraError:
        return None


def _placed(camera: Camera, centres: np.ndarray) -> Placed:
    """Images of points (n, 3) of the world (mm); NaN for those behind the camera."""
    lens = first_order_map(camera)
    assert lens is not None
    points = transform_points(np.linalg.inv(camera.world_from_camera_at(0.0)), centres)         # it does not move
    before = lens.z - points[:, 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(before > 0.0, 1.0 / (lens.origin_film + before * lens.slope_film), np.nan)
        raster = camera.raster_from_film(points[:, :2] * scale[:, None])
        blur = (lens.origin_pupil + before * lens.slope_pupil) * scale / camera.film_step.parameters[0]
    return Placed(raster[:, 0], raster[:, 1], blur, scale)


@njit(nogil=True, cache=True, error_model="numpy")
def add_rays(sums, found, n, across, top, bottom, image, points, shared):
    """Add listed rays to the pixels on which they fall, in the rows top … bottom − 1.

    Each ray represents `shared` rays from points of its light; 0: only itself. points (POINTS, 5): place in both
    half-axes, and colour. V0, which is stratified together with the places before the lens, selects the points.
    """
    # Find where the points of the light fall, and how much each adds
    aside, tints = np.zeros((POINTS, 2), np.float32), np.ones((POINTS, 3), np.float32)
    reach, share = np.float32(0), np.float32(1.0 / max(shared, 1))
    for j in range(POINTS if shared > 0 else 0):            # loops: sums of whole arrays take seconds to compile
        for c in range(2):
            aside[j, c] = points[j, 0] * image[0, c] + points[j, 1] * image[1, c]
        for c in range(3):
            tints[j, c] = points[j, 2 + c] * share
        reach = max(reach, abs(aside[j, 1]))

    # Add the rays that can reach these rows
    shared = max(shared, 1)
    step = POINTS // shared
    for k in range(n):
        x, y = found[LIST_X, k], found[LIST_Y, k]
        red, green, blue = found[LIST_RED, k], found[LIST_GREEN, k], found[LIST_BLUE, k]
        if not ((y + reach >= top) & (y - reach < bottom)):
            continue
        start = int(found[LIST_V0, k] * np.float32(step))
        for j in range(start, POINTS, step):
            px, py = x + aside[j, 0], y + aside[j, 1]
            if (px >= 0.0) & (px < across) & (py >= top) & (py < bottom):
                i = int(py) * across + int(px)
                sums[i, 0] += red * tints[j, 0]
                sums[i, 1] += green * tints[j, 1]
                sums[i, 2] += blue * tints[j, 2]


@njit(nogil=True, cache=True, error_model="numpy")
def _add_moved(sums, rays, parts, moves, across, top, bottom, images, points, shared):
    """`add_rays` of all lights, each moved: a raster point p becomes size · p + (right, below).

    moves (k, 4): size, right, below, and the gain of the light, of each.
    """
    for light, first, end in parts:
        found = rays[:, first:end].copy()
        size, right, below, gain = moves[light]
        for k in range(end - first):
            found[LIST_X, k] = size * found[LIST_X, k] + right
            found[LIST_Y, k] = size * found[LIST_Y, k] + below
            for colour in range(LIST_RED, LIST_BLUE + 1):
                found[colour, k] *= gain
        add_rays(sums, found, end - first, across, top, bottom, images[light], points[light], shared[light])
