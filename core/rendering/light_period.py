"""Light period: how many passes of a picture come with one pass of light rays, by the noise of both kinds of rays.

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

import numpy as np

from lensbench.kernels.block import B, lane_buffer
from lensbench.kernels.program import Program

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
    """The period of a picture's light passes, and what it is decided by.

    Parameters
    ----------
    shape
        (h, w) pixels of the film.
    seed
        Sampler seed.
    """

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
            for k, part in product(range(first, n, threads), range(2)):
                if not wanted():
                    return False
                program.expose(sums[part, k:k + 1], lanes, places[k], places[k] + 1, part * half, half, self._seed,
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
