"""Rays of small lights on the film: lists of them, their sum, and the light layer that one picture lends to another.

While a dial is dragged, the selection and the tracing of small lights take longer than the camera's first sample. The
picture then shows the rays of the setting before, re-imaged: the blurred disc of each light moves to its new place and
takes its new size, by the first-order maps of both cameras. Raster points in pixels.

Light period: how many passes of a picture come with one pass of light rays, by the noise of both kinds of rays.

Camera rays of a pass that take the time t and have the variance V leave the variance V / n after n passes, and light
rays likewise. In a given time the sum of both is least when the period is √(V / t) of the camera over √(V / t) of the
lights. The power of two that is nearest serves as well.

The first passes of a picture all trace lights. Their halves tell the variance of the light rays, on a grid of pixels.
That of the camera's rays comes from a trial of some blocks of the film, with which pass DECIDED begins, so that the
period does not depend on how a picture is stopped, resumed, or cut into bands. Until then it follows from the number of
rays and the film that lights cover. As in `sample_allocation`, each luminance is compared with itself and the mean of
the picture, so that no exposure enters.
"""

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from itertools import product
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.cameras.shutter import CameraError
from lensbench.core.imaging.coordinate_spaces import transform_points
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import B, lane_buffer
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.rendering.light_selection import SelectedLight
from lensbench.core.scenery.small_lights import POINTS, ExcludedLight

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
        ends = np.cumsum([0, *(listed.shape[1] for _, listed in kept)])
        parts = np.column_stack([[light for light, _ in kept], ends[:-1], ends[1:]]).astype(np.int64)
        rays = np.concatenate([np.empty((LIST_SIZE, 0), np.float32), *(listed for _, listed in kept)], 1)
        centres = np.array([light.centre for light in lights]).reshape(-1, 3)
        if lights:
            centres = transform_points(np.asarray(camera.world_from_camera), centres)
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
    """The first-order map of a camera that does not move, its film centred; None without one."""
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


def add_mean(picture: np.ndarray, sums: np.ndarray, passes: int) -> None:
    """Add the mean of passes to lines (lines, w, 3) one after the other: a large picture has no room to spare."""
    share = np.float32(1.0 / max(passes, 1))
    for line, own in zip(picture, sums, strict=True):
        line += own * share


@njit(nogil=True, cache=True, error_model="numpy")
def add_rays(sums, rays, n, across, top, bottom, image, points, shared):
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
        x, y = rays[LIST_X, k], rays[LIST_Y, k]
        red, green, blue = rays[LIST_RED, k], rays[LIST_GREEN, k], rays[LIST_BLUE, k]
        if not ((y + reach >= top) & (y - reach < bottom)):
            continue
        start = int(rays[LIST_V0, k] * np.float32(step))
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
        moved = rays[:, first:end].copy()
        size, right, below, gain = moves[light]
        for k in range(end - first):
            moved[LIST_X, k] = size * moved[LIST_X, k] + right
            moved[LIST_Y, k] = size * moved[LIST_Y, k] + below
            for colour in range(LIST_RED, LIST_BLUE + 1):
                moved[colour, k] *= gain
        add_rays(sums, moved, end - first, across, top, bottom, images[light], points[light], shared[light])


FIRST_PASSES = 4        # passes of a picture that all trace lights
DECIDED = 16            # number of the first pass with the period that noise decides
PERIOD = 4              # of the passes between, one in so many does, at the most,
LONGEST = 8             # and one in PERIOD times so many at the least
FULL_COVER = 0.1        # share of the film that light images cover where they deserve the time of the camera's samples
DENSEST, RAREST = 2, 32     # bounds of the period that noise decides, powers of two
RAY_TIME = 0.8          # of a light ray in terms of a camera sample: 0.45 of one in `night-lights`, 1.2 in `still-life`
TRIAL_SAMPLES = 16      # of a block
TRIAL_SHARE, TRIAL_LEAST, TRIAL_MOST = 1 / 16, 16, 64       # of the blocks of the film, and bounds of their number
GRID = 1 << 16          # pixels on which light images are compared, at the most
LUMINANCE = np.array([0.25, 0.5, 0.25], np.float32)     # weights of red, green and blue


class LightPeriod:
    """The period of a picture's light passes, and what decides it. shape: (h, w) pixels of the film."""

    def __init__(self, shape: tuple[int, int], seed: np.uint32):
        self._shape, self._seed = shape, seed
        step = math.ceil(math.sqrt(math.prod(shape) / GRID))
        self._grid = slice(step // 2, None, step)
        down, across = (len(range(pixels)[self._grid]) for pixels in shape)
        self._halves = np.zeros((2, down, across), np.float32)  # luminances after half of the first passes, and all
        self._early, self._cost = PERIOD, 0.0                   # cost: light rays for each pixel in one pass
        self._decided = np.zeros((), np.int64)                  # 0: not yet

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The arrays by name, for `restore`."""
        return {"light_halves": self._halves, "light_period": self._decided}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over the arrays of another picture of the same arguments."""
        for name, own in self.state.items():
            if own is not state[name]:
                own[...] = state[name]

    def clear(self) -> None:
        """Begin the picture anew."""
        self._decided[...] = 0

    def set_early(self, rays: float, covered: float) -> None:
        """Set the period until noise decides it: longer where lights take long or cover little.

        rays: of all lights in one pass; covered: pixels of their images, each weighed by its squared brightness.
        """
        pixels = math.prod(self._shape)
        self._cost, cover = rays / pixels, covered / pixels
        self._early = round(PERIOD * min(max(math.sqrt(self._cost * FULL_COVER / max(cover, 1e-9)), 1.0), LONGEST))

    @property
    def is_decided(self) -> bool:
        """Whether noise has decided the period."""
        return bool(self._decided)

    def traces(self, number: int) -> bool:
        """Whether a pass of this number traces lights."""
        return number < FIRST_PASSES or number % (self._early if number < DECIDED else self._late) == 0

    def before(self, number: int) -> int:
        """How many of the passes before this number trace lights."""
        if number <= FIRST_PASSES:
            return number
        early = FIRST_PASSES + _multiples(FIRST_PASSES, min(number, DECIDED), self._early)
        return early if number <= DECIDED else early + _multiples(DECIDED, number, self._late)

    @property
    def _late(self) -> int:
        """The period from DECIDED on."""
        return int(self._decided) or self._early

    def note(self, passes: int, sums: np.ndarray) -> None:
        """Note the sums (h w, 3) of the first passes, where these are a half of FIRST_PASSES or all of them."""
        if passes in (FIRST_PASSES // 2, FIRST_PASSES):
            image = sums.reshape(*self._shape, 3)[self._grid, self._grid]
            self._halves[2 * passes // FIRST_PASSES - 1] = image @ LUMINANCE

    def decide(self, program: Program, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Set the period of the passes from DECIDED on; False when `wanted` cancelled.

        program: the camera's samples of the d line. Threads of the pool, so many at a time, trace the trial.
        """
        camera = self._trial(program, pool, threads, wanted)
        if camera is None:
            return False
        halves = self._halves / np.float32(FIRST_PASSES / 2)
        with np.errstate(invalid="ignore", over="ignore"):
            mean = float(camera.mean() + 0.5 * halves[1].mean())
            noisy = _variance(camera[0], camera[1], mean) * TRIAL_SAMPLES
            light = _variance(halves[0], halves[1] - halves[0], mean) * FIRST_PASSES
        ratio = noisy / light if light > 0.0 else math.inf      # NaN where any sample is no number
        best = math.sqrt(RAY_TIME * self._cost * ratio) if ratio < math.inf else RAREST
        self._decided[...] = 2 ** round(math.log2(min(max(best, DENSEST), RAREST)))
        return True

    def _trial(self, program: Program, pool: Executor, threads: int, wanted: Callable[[], bool]) -> np.ndarray | None:
        """Mean luminances (2, lanes) of both halves of the samples of some blocks of the camera's rays.

        None when `wanted` cancelled.
        """
        blocks = max(math.prod(self._shape) // B, 1)
        n = min(round(min(max(blocks * TRIAL_SHARE, TRIAL_LEAST), TRIAL_MOST)), blocks)
        places = ((np.arange(n) + np.random.default_rng(0).random(n)) * blocks / n).astype(int)
        half = TRIAL_SAMPLES // 2
        sums = np.zeros((2, n, 3 * B), program.real)

        def work(first: int) -> bool:
            lanes = lane_buffer(program.real)
            for k, q in product(range(first, n, threads), range(2)):
                if not wanted():
                    return False
                program.expose(sums[q, k:k + 1], lanes, places[k], places[k] + 1, q * half, half, self._seed,
                               places[k])
            return True

        if not all(list(pool.map(work, range(threads)))):
            return None
        return np.einsum("pkcb,c->pkb", sums.reshape(2, n, 3, B), LUMINANCE).reshape(2, -1) / half


def _multiples(begin: int, end: int, period: int) -> int:
    """How many multiples of the period there are from `begin` to `end` − 1."""
    return (end - 1) // period - (begin - 1) // period


def _variance(a: np.ndarray, b: np.ndarray, mean: float) -> float:
    """Variance of the mean of two luminances, each divided by itself and the mean of the picture."""
    whole = 0.5 * (a + b)
    apart = 0.5 * (a - b) / (whole + max(mean, 1e-30))
    return float((apart.astype(float) ** 2).mean())
