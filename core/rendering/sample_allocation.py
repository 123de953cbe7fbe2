"""Sample allocation: blocks of the film with a larger error take more of a picture's samples.

The first EVEN samples of a picture are the same for all blocks. Rounds follow, each of which ends with GROWTH times the
samples of its beginning. For a round every block is given a share, a power of two from 1 / 4 to 4: so many times the
samples of an even round, each of which counts so many times less. Shares that are 1 on average and in proportion to the
error of a block make the error of the picture least.

The picture stays unbiased: a share follows from samples of earlier rounds alone, and what a round counts in the picture
does not depend on the shares. (Means over as many samples as a block happened to get would be too dark where the first
samples missed a light.) A share depends on no other samples than those of its band of lines (`sampling`), so that a
picture that is finished band by band is the same, bit for bit, and so is one that was stopped and resumed.

The error of a block is estimated from the difference of the means of the first and the second half of its samples. Each
luminance is compared with itself and the mean of the band, as an eye or a tone curve does, so that no exposure enters.
"""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from lensbench.core.kernels.block import B
from lensbench.core.kernels.cache import njit

EVEN = 16               # samples a pixel before the first round
GROWTH = 4              # of the samples in a round; both are powers of two, so that the samples of rounds are nets
LEAST, MOST = -2, 2     # log₂ of the shares


class SampleAllocation:
    """Shares of the blocks of a picture in its current round.

    band: number of blocks in each band of lines but the last; real: the type of the sums; even: all blocks take the
    same samples throughout.
    """

    def __init__(self, blocks: int, band: int, real: type, even: bool = False):
        self._band, self._even = band, even
        self._levels = np.zeros(blocks, np.int64)       # log2 of the shares
        self._starts = np.zeros(blocks, np.int64)       # number of the first sample of the round
        self._earlier: np.ndarray = np.zeros((0 if even else blocks, B), real)  # luminances, half-way

    @property
    def state(self) -> dict[str, np.ndarray]:
        """Arrays by name, all 0 at first, for `restore`; none for even samples."""
        return {} if self._even else {"levels": self._levels, "starts": self._starts, "earlier": self._earlier}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over the arrays of another allocation for the same picture."""
        for name, own in self.state.items():
            if own is not state[name]:
                own[:] = state[name]

    def clear(self, blocks: int | None = None) -> None:
        """Begin a picture anew, or another band of `blocks` blocks."""
        self._levels, self._starts = self._levels[:blocks], self._starts[:blocks]
        self._earlier = self._earlier[:blocks]
        self._levels[:] = self._starts[:] = 0

    def pieces(self, done: int, end: int) -> Iterator[tuple[int, int]]:
        """The samples from `done` to `end` in pieces that end where `finish` is to be called: (first, last + 1)."""
        while done < end:
            bound = GROWTH * self._round_start(done) or EVEN
            stop = end if self._even else min(bound // 2 if done < bound // 2 else bound, end)
            yield done, stop
            done = stop

    def samples(self, done: int, end: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What each block does between two numbers of samples a pixel, of one piece.

        Returns for each block the number of its first sample, the number of its samples (int64), and the weight of
        each.
        """
        start = self._round_start(done)
        before = _scaled(done - start, self._levels)
        count = _scaled(end - start, self._levels) - before
        return self._starts + before, count, np.exp2(-self._levels, dtype=self._earlier.dtype)

    def weights(self, done: int) -> np.ndarray:
        """Sum of the weights of the samples of each block, (blocks,), of `done` samples a pixel.

        It is `done`, or up to three more where a part of a block's samples is under way.
        """
        start = self._round_start(done)
        return start + np.exp2(-self._levels) * _scaled(done - start, self._levels)

    def finish(self, done: int, sums: np.ndarray) -> None:
        """Note the end of a piece. At the end of a round, share the samples of the next one out among the blocks.

        done: samples a pixel so far; sums: (blocks, 3 B), the weighted colours of these samples.
        """
        start, former, half = self._round_start(done), self._round_start(done - 1), done // 2
        if self._even or done < EVEN // 2:
            return
        if start == done:
            # Errors of one sample: `half` even ones would have a variance of 1 / half in each half
            shares = np.exp2(self._levels)
            variances = (former + (half - former) / shares) / half**2 + 1.0 / (half * shares)
            used = self._starts + _scaled(done - former, self._levels)
            for first in range(0, len(sums), self._band):
                band = slice(first, first + self._band)
                self._levels[band] = _levels(_errors(sums[band], self._earlier[band]) / np.sqrt(variances[band]))
            # The samples that would follow if the share had always been this one, in a part of the net not used before
            begin, whole = _scaled(done, self._levels), _scaled(GROWTH * done, self._levels)
            self._starts[:] = begin + np.where(used > begin, -(-used // whole) * whole, 0)
        elif 2 * done == (GROWTH * start or EVEN):
            _luminances(sums, self._earlier)

    def _round_start(self, done: int) -> int:
        """Samples a pixel at the beginning of the round to which sample `done` belongs; 0 for the even samples."""
        if self._even or done < EVEN:
            return 0
        start = EVEN
        while GROWTH * start <= done:
            start *= GROWTH
        return start


def _scaled(count: int, levels: np.ndarray) -> np.ndarray:
    """A number of samples times the shares, rounded up."""
    return -((-count << np.maximum(levels, 0)) >> np.maximum(-levels, 0))


def _errors(sums: np.ndarray, earlier: np.ndarray) -> np.ndarray:
    """Error of each block of a band as float64: root mean square over its lanes.

    sums: (blocks, 3 B) colours; earlier: (blocks, B), luminances at half of the samples.
    """
    errors = np.zeros(len(sums))
    if (mean := _mean(sums)) > 0.0:
        _differences(sums, earlier, mean, errors)
    return errors


def _levels(errors: np.ndarray) -> np.ndarray:
    """log₂ of shares that are 1 on average and in proportion to the errors, as far as the bounds allow.

    From the least share of all on, the share that is doubled next is the one with the largest error for its samples:
    that lowers the sum of error² / share most for each sample.
    """
    n = len(errors)
    errors = np.maximum(errors, 1e-9)                               # all of them 0: as many samples for each
    steps = np.arange(LEAST, MOST)
    gains, costs = errors[:, None] / np.exp2(steps), np.broadcast_to(1 << (steps - LEAST), (n, len(steps)))
    order = np.argsort(-gains.ravel(), kind="stable")
    costs, left = costs.ravel()[order], (n << -LEAST) - n           # in units of the least share
    taken = np.cumsum(costs) <= left
    left -= costs[taken].sum()
    for index in np.nonzero(~taken)[0]:                             # what is left for cheaper steps
        if left == 0:
            break
        if costs[index] <= left:
            taken[index] = True
            left -= costs[index]
    return LEAST + np.bincount(order[taken] // len(steps), minlength=n)


@njit(inline="always")
def _luminance(sums, block, i):
    """Luminance of a lane: weights 1, 2 and 1 of red, green and blue, over 4."""
    quarter, half = sums.dtype.type(0.25), sums.dtype.type(0.5)
    return quarter * (sums[block, i] + sums[block, 2 * B + i]) + half * sums[block, B + i]


@njit(nogil=True, cache=True, error_model="numpy")
def _luminances(sums, luminances):
    """Luminances (blocks, B) of colours (blocks, 3 B)."""
    for block in range(len(sums)):
        for i in range(B):
            luminances[block, i] = _luminance(sums, block, i)


@njit(nogil=True, cache=True, error_model="numpy")
def _mean(sums):
    """Mean luminance of colours (blocks, 3 B)."""
    total = 0.0
    for block in range(len(sums)):
        for i in range(B):
            total += _luminance(sums, block, i)
    return total / (len(sums) * B)


@njit(nogil=True, cache=True, error_model="numpy")
def _differences(sums, earlier, mean, errors):
    """Root mean square difference of the halves of each block, each luminance divided by itself and the mean."""
    for block in range(len(sums)):
        total = 0.0
        for i in range(B):
            now = _luminance(sums, block, i)
            apart = (now - 2.0 * earlier[block, i]) / (now + mean)
            total += apart * apart
        errors[block] = math.sqrt(total / B)
