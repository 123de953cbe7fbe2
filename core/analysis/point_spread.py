"""Point spread functions of a ray grid: by diffraction near focus, by rays far from it; line spread, encircled energy.

Lengths in mm. The samples of a field lie on a square grid about the centroid of its light, along the sagittal (columns)
and the tangential (rows) axis. Values are densities of the light.

The diffraction pattern is the Fourier transform of the pupil function at the wanted samples (by Bluestein's algorithm).
Where rays land farther from the centre than half of λ / (spacing of the pupil's grid), it would fold over itself: there
the density of the rays replaces it; between the two limits both are blended.

References:
    Goodman, "Introduction to Fourier Optics", ch. 6. L. I. Bluestein, IEEE Trans. Audio Electroacoust. 18 (1970).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.grids.field_conditions import each_of
from lensbench.core.analysis.grids.traced_grid import RayGrid
from lensbench.core.analysis.spot_diagram import light_shares, spots
from lensbench.core.analysis.transfer_function import FAST, PAD, cosine_of_turns, pupil_functions, sine_of_turns
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.lens_surface import LensError

SAMPLES = 256
METHODS = ("auto", "diffraction", "geometric")
WAVES_END, RAYS_BEGIN = 0.8, 1.2        # × half of λ / spacing: diffraction alone below, rays alone beyond
AIRY_RADII = 10.0                       # to the edge of the window, at the least
SPOT_RADII = 1.15                       # the same of the farthest ray
PER_SAMPLE, FINEST = 2.0, 24.0          # rays of the density along a side of a sample, and of a cell at most


@dataclass(frozen=True, eq=False)
class PointSpread:
    """Point spread functions of F fields and C wavelengths on M × M samples, from `psf`; NaN where no light falls.

    Args:
        rays: The ray grid.
        shift: Of the film along +z, mm.
        pitch: (F,) spacing of the samples, mm.
        pixel: Side of the square pixel over which the light is averaged, mm; 0 for none.
        centres: (F, 2) middle of the window, sagittal and tangential, mm from the reference point.
        density: (F, C, M, M) float32, part of the light per mm²; rows tangential, columns sagittal, both rising.
        diffraction: (F, C) share of the diffraction pattern in the result, 0 (rays alone) to 1.
        findings: Where rays alone had to take its place.
    """

    rays: RayGrid
    shift: float
    pitch: np.ndarray
    pixel: float
    centres: np.ndarray
    density: np.ndarray
    diffraction: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def offsets(self) -> np.ndarray:
        """(F, M) distance of the columns or rows from the middle of the window, mm."""
        count = self.density.shape[-1]
        return self.pitch[:, None] * (np.arange(count) - 0.5 * (count - 1))

    @property
    def white(self) -> np.ndarray:
        """(F, M, M) density of all wavelengths with their light."""
        shares = np.where(self.rays.lit[:, None], light_shares(self.rays), np.nan).astype(np.float32)
        return np.einsum("fcij,fc->fij", np.nan_to_num(self.density), shares)

    @property
    def captured(self) -> np.ndarray:
        """(F, C) part of the light that the window holds."""
        return self.density.sum((2, 3), dtype=float) * self.pitch[:, None] ** 2

    @property
    def line_spread(self) -> np.ndarray:
        """(F, C, 2, M) part of the light per mm across a line: along the sagittal and the tangential axis."""
        return np.stack([self.density.sum(axis, dtype=float) for axis in (2, 3)], 2) * self.pitch[:, None, None, None]


def psf(rays: RayGrid, samples: int = SAMPLES, window: float | None = None, pixel: float = 0.0, shift: float = 0.0,
        method: str = "auto") -> PointSpread:
    """Point spread functions of a ray grid.

    Args:
        rays: From `ray_grid`; 64 points across the pupil resolve blurs of a few Airy disks.
        samples: M, at least 8.
        window: Side of the window, mm; None: for each field what holds its rays and ten Airy radii.
        pixel: Side of the pixel over which light is averaged, mm.
        shift: Of the film along +z, mm.
        method: {"auto", "diffraction", "geometric"}. "auto": diffraction where the grid resolves it, else the density
            of the rays.
    Raises:
        LensError: For another method, fewer than 8 samples, sizes that are not positive, and a shift that is not
            finite.
    """
    if method not in METHODS:
        raise LensError(f"PSF method {method!r}: choose one of {', '.join(METHODS)}")
    if samples < 8:
        raise LensError(f"{samples} samples across a PSF: at least 8 are needed")
    if not (window is None or 0.0 < window < np.inf) or not 0.0 <= pixel < np.inf:
        raise LensError("the window and the pixel of a PSF must be positive lengths")
    fields, colours = rays.opd.shape[:2]
    lines = 1e-3 * np.array(rays.conditions.wavelengths)
    spot = spots(rays, "centroid", [shift])
    centres, geo = spot.references[:, 0], np.nan_to_num(spot.geo[:, :, 0]).max(1)
    airy = np.nan_to_num(spot.airy_radius).max((1, 2))
    side = np.maximum(2.0 * AIRY_RADII * airy, 2.0 * SPOT_RADII * geo + pixel) if window is None else \
        np.full(fields, window)
    pitch = np.where(rays.lit, side / samples, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        fold = geo[:, None] * 2.0 * rays.steps.max(1)[:, None] / lines
    share = np.clip((RAYS_BEGIN - fold) / (RAYS_BEGIN - WAVES_END), 0.0, 1.0)
    if method != "auto":
        share = np.full(share.shape, float(method == "diffraction"))
    share = np.where(rays.lit[:, None], share, np.nan)
    density = np.full((fields, colours, samples, samples), np.nan, np.float32)
    pupils = pupil_functions(rays, shift)[1, :, :, :, PAD:-PAD]

    def fill(field_and_colour: tuple[int, int]) -> None:
        """One pattern."""
        f, c = field_and_colour
        made = np.zeros((samples, samples), np.float32)
        if share[f, c] > 0.0:
            made += share[f, c] * _pattern(pupils[f, c], rays, f, lines[c], centres[f], pitch[f], samples)
        if share[f, c] < 1.0:
            made += (1.0 - share[f, c]) * ray_density(rays, f, c, shift, centres[f], pitch[f], samples)
        density[f, c] = _over_pixel(made, pixel / pitch[f]) if pixel else made

    work = [(int(f), int(c)) for f in np.flatnonzero(rays.lit)
            for c in np.flatnonzero(rays.coverage[f].any((1, 2)))]
    each_of(fill, work)
    return PointSpread(rays, shift, pitch, pixel, centres, density, share, _findings(share, method))


def _findings(share: np.ndarray, method: str) -> tuple[Finding, ...]:
    rough = int((np.nan_to_num(share, nan=1.0) < 1.0).any(1).sum())
    if method != "auto" or not rough:
        return ()
    return (Finding(Kind.SAMPLING, None, f"{rough} field{'s' if rough > 1 else ''}: the blur is too large for the grid "
                                         "of the pupil, and the density of rays is taken for the diffraction pattern",
                    figures={"fields": float(rough)}),)


def _pattern(pupil: np.ndarray, rays: RayGrid, f: int, line: float, centre: np.ndarray, pitch: float,
             samples: int) -> np.ndarray:
    """Diffraction pattern (M, M) of a pupil (4, N, N) of `pupil_functions`: one period λ / step, dark beyond it."""
    w, _, cover, root = pupil
    n = w.shape[-1]
    step_s, step_t = rays.steps[f]
    tilted = w - (centre[0] * rays.pupil[f, 0] + centre[1] * rays.pupil[f, 1][:, None]) / line
    pupil_field = np.empty((n, n), np.complex64)
    _wave(tilted, cover * root, pupil_field)
    wave = _zoom(np.ascontiguousarray(_zoom(pupil_field, pitch * step_s / line, samples).T), pitch * step_t / line,
                 samples)                                           # (sagittal, tangential)
    light = float((cover * root * root).sum())
    distance = np.abs(pitch * (np.arange(samples) - 0.5 * (samples - 1)))
    wave[distance > 0.5 * line / step_s] = 0.0
    wave[:, distance > 0.5 * line / step_t] = 0.0
    return ((wave.real**2 + wave.imag**2) * np.float32(step_s * step_t / (line * line * light))).T


def _zoom(rows: np.ndarray, beta: float, samples: int) -> np.ndarray:
    """Σ_n rows[:, n] exp(2πi β m n) for M samples m about 0, but for a phase of m alone: Bluestein's algorithm."""
    count = rows.shape[-1]
    chirp, turn, length = _chirp(count, samples, beta)
    return np.fft.ifft(np.fft.fft(rows * turn, length) * chirp)[:, :samples]


@lru_cache(maxsize=64)
def _chirp(count: int, samples: int, beta: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Transform of the chirp of `_zoom`, the factors (N,) of its input, and the length of the transforms."""
    length = count + samples - 1
    while _largest_prime(length) > 5:
        length += 1
    n, q = np.arange(count), np.arange(-(count - 1), samples)
    chirp = np.zeros(length, complex)
    chirp[q] = np.exp(-1j * np.pi * beta * q * q)
    turn = np.exp(1j * np.pi * beta * (n * n - (samples - 1.0) * n))
    return np.fft.fft(chirp).astype(np.complex64), turn.astype(np.complex64), length


def _largest_prime(number: int) -> int:
    for prime in (2, 3, 5):
        while number % prime == 0:
            number //= prime
    return number


@njit(fastmath=FAST, cache=True, nogil=True, error_model="numpy")
def _wave(w, amplitude, out):
    """Amplitude × exp(−2πi W), W (N, N) in wavelengths."""
    for i in range(w.shape[0]):
        for j in range(w.shape[1]):
            x = -(w[i, j] - np.floor(w[i, j] + 0.5))
            u = x * x
            out[i, j] = amplitude[i, j] * (cosine_of_turns(u) + 1j * x * sine_of_turns(u))


def ray_density(rays: RayGrid, field: int, colour: int, shift: float, centre: np.ndarray, pitch: float,
                samples: int) -> np.ndarray:
    """Density (M, M) of the light of one field and colour by rays alone, float32: part of the light per mm².

    centre: (2,) middle of the samples, mm from the reference point; rows tangential, columns sagittal, both rising.
    """
    s, t = (rays.light[a, field, colour] + shift * rays.light[2 + a, field, colour] - centre[a] for a in (0, 1))
    out = np.zeros((samples, samples))
    _add_to_cells(s / pitch, t / pitch, rays.weight[field, colour], out)
    return (out / (rays.weight[field, colour].sum() * pitch * pitch)).astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy")
def _add_to_cells(s, t, weight, out):
    """Add the light of cells to samples (M, M): each cell as PER_SAMPLE² rays a sample or more, up to FINEST².

    s, t: (N, N) landing points in samples from the middle, linear between cells. The rays of a cell are a Fibonacci
    lattice: a square one would beat with the samples.
    """
    rows, columns = s.shape
    samples = out.shape[0]
    middle = 0.5 * (samples - 1)
    for i in range(rows):
        for j in range(columns):
            if not weight[i, j] > 0.0:
                continue
            s_i, t_i = _gap(s, weight, i, j, 1, 0), _gap(t, weight, i, j, 1, 0)
            s_j, t_j = _gap(s, weight, i, j, 0, 1), _gap(t, weight, i, j, 0, 1)
            reach = max(abs(s_i), abs(t_i), abs(s_j), abs(t_j))
            target = min(PER_SAMPLE * reach, FINEST) ** 2
            step, count = 5, 8
            while count < target:
                step, count = count, step + count
            light = weight[i, j] / count
            for k in range(count):
                di = (k + 0.5) / count - 0.5
                dj = (k * step % count + 0.5) / count - 0.5
                x = s[i, j] + di * s_i + dj * s_j + middle
                y = t[i, j] + di * t_i + dj * t_j + middle
                if not (0.0 <= x < samples - 1 and 0.0 <= y < samples - 1):
                    continue
                left, low = int(x), int(y)
                u, v = x - left, y - low
                out[low, left] += light * (1.0 - u) * (1.0 - v)
                out[low, left + 1] += light * u * (1.0 - v)
                out[low + 1, left] += light * (1.0 - u) * v
                out[low + 1, left + 1] += light * u * v


@njit(cache=True, nogil=True, error_model="numpy")
def _gap(values, weight, i, j, di, dj):
    """Change of a value per cell in a direction, from the neighbours that carry light."""
    rows, columns = values.shape
    after = i + di < rows and j + dj < columns and weight[i + di, j + dj] > 0.0
    before = i >= di and j >= dj and weight[i - di, j - dj] > 0.0
    if after and before:
        return 0.5 * (values[i + di, j + dj] - values[i - di, j - dj])
    if after:
        return values[i + di, j + dj] - values[i, j]
    return values[i, j] - values[i - di, j - dj] if before else 0.0


def _over_pixel(density: np.ndarray, side: float) -> np.ndarray:
    """The density (M, M) averaged over a square of this side in samples, 0 beyond the window."""
    for axis in (0, 1):
        total = np.cumsum(np.moveaxis(density, axis, 0), 0, dtype=float)
        total = np.concatenate([np.zeros((1, total.shape[1])), total])          # the integral up to each edge
        edges = np.arange(len(total) - 1) + 0.5

        def up_to(position: np.ndarray, total: np.ndarray = total) -> np.ndarray:
            position = np.clip(position, 0.0, len(total) - 1.0)
            low = np.minimum(position.astype(int), len(total) - 2)
            share = (position - low)[:, None]
            return total[low] * (1.0 - share) + total[low + 1] * share

        density = np.moveaxis((up_to(edges + 0.5 * side) - up_to(edges - 0.5 * side)) / side, 0, axis)
    return density


def encircled_energy(spread: PointSpread, radii: ArrayLike) -> np.ndarray:
    """The part of the light within circles about the centroid of each field.

    Args:
        spread: From `psf`.
        radii: (K,) array_like. Radii of the circles, mm.
    Returns:
        (F, C, K), NaN where no light falls and for circles that the window does not hold.
    Raises:
        LensError: For a radius that is negative or NaN.
    """
    circles = np.atleast_1d(np.asarray(radii, float))
    if not (circles >= 0.0).all():
        raise LensError("the radius of a circle must be a number and not negative")
    count = spread.density.shape[-1]
    offsets = np.arange(count) - 0.5 * (count - 1)
    r = np.hypot(offsets, offsets[:, None]).ravel()
    order = np.argsort(r)
    out = np.full((*spread.density.shape[:2], circles.size), np.nan)
    for f in np.flatnonzero(spread.rays.lit):
        # A circle takes the part of the samples within it that its area has, so that it grows smoothly
        size = circles / spread.pitch[f]
        within = np.searchsorted(r[order], size)
        fair = np.pi * size**2
        for c in range(out.shape[1]):
            total = np.concatenate([[0.0], np.cumsum(spread.density[f, c].ravel()[order], dtype=float)])
            number = np.arange(len(total), dtype=float)
            value = np.interp(fair, number, total) * spread.pitch[f] ** 2
            out[f, c] = np.where((size <= 0.5 * count) & (within <= len(r)), value, np.nan)
    return out
