"""A sensor: photons become electrons, electrons a voltage, and that a number, each with its noise and limit.

A pixel of area A collects PHOTONS · A · H photons of an exposure of H lux seconds, all of 555 nm; the losses of colour
filters are part of the quantum efficiency, the probability that a photon makes an electron: Poisson's law. The well
saturates at its full capacity; reading adds normal noise; the gain, ISO over base ISO, amplifies both; the converter
rounds, and clips.
"""

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist

import numpy as np
from numba import uint32
from numpy.typing import ArrayLike

from lensbench.core.imaging.exposure import PHOTONS, SATURATION, ExposureError, checked_positive
from lensbench.core.imaging.film import Film
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import mix
from lensbench.core.text import significant

CELLS = 4096            # of the table of the normal distribution
PART = 1 << 16          # numbers in one task of a thread
FEW = 8.0               # electrons, below which Poisson's law is summed term by term
PEDESTAL = 1 / 64       # of the converter's range, below black: room for noise


@dataclass(frozen=True)
class Sensor:
    """A sensor of one kind of pixel, with a channel for each colour at every place.

    Args:
        full_well: Capacity of a pixel (electrons).
        quantum_efficiency: Electrons per photon, from 0 (excluded) to 1.
        read_noise: Standard deviation (electrons).
        base_iso: ISO at which the full well is the top of the converter's range.
        bits: Of the converter, 8 to 16.
        pitch: Side of a pixel (µm). None: such that the exposure that saturates at base_iso, SATURATION / base_iso lux
            seconds, fills the well.
    Raises:
        ExposureError: For other numbers.

    References:
        ISO 12232, saturation-based speed.
    """

    full_well: float = 50_000.0
    quantum_efficiency: float = 0.5
    read_noise: float = 3.0
    base_iso: float = 100.0
    bits: int = 14
    pitch: float | None = None

    def __post_init__(self) -> None:
        checked_positive("full well", self.full_well)
        checked_positive("base ISO", self.base_iso)
        if self.pitch is not None:
            checked_positive("pixel pitch", self.pitch)
        if not 0.0 < self.quantum_efficiency <= 1.0:
            raise ExposureError(f"quantum efficiency {significant(self.quantum_efficiency)}: it must lie "
                                f"between 0 and 1")
        if not (math.isfinite(self.read_noise) and self.read_noise >= 0.0):
            raise ExposureError(f"read noise {significant(self.read_noise)} electrons: it must be 0 or positive")
        if self.bits not in range(8, 17):
            raise ExposureError(f"{self.bits} bits: a converter has 8 to 16 of them")

    @classmethod
    def of(cls, film: Film, quantum_efficiency: float = 0.5, read_noise: float = 3.0, base_iso: float = 100.0,
           bits: int = 14) -> "Sensor":
        """The sensor with the pixels of a film, whose wells are full at saturation at the ISO speed base_iso.

        quantum_efficiency: electrons per photon; read_noise: electrons rms; bits: of the converter.
        """
        pitch = film.pitch * 1000.0
        per_lux_second = quantum_efficiency * PHOTONS * pitch**2
        checked_positive("base ISO", base_iso)
        return cls(per_lux_second * SATURATION / base_iso, quantum_efficiency, read_noise, base_iso, bits, pitch)

    @property
    def electrons(self) -> float:
        """Electrons per lux second."""
        if self.pitch is None:
            return self.full_well * self.base_iso / SATURATION
        return self.quantum_efficiency * PHOTONS * self.pitch**2

    @property
    def pixel_pitch(self) -> float:
        """Side of a pixel (µm): as given, or as it follows from the full well."""
        return math.sqrt(self.electrons / (self.quantum_efficiency * PHOTONS))

    def top(self, iso: float) -> float:
        """Electrons at the top of the converter's range at an ISO speed, iso; ExposureError if it is not positive."""
        return self.full_well * self.base_iso / checked_positive("ISO", iso)

    def clips_at(self, iso: float) -> float:
        """Exposure (lux s) at which pictures clip at an ISO speed, iso: the well is full, or the converter at its end.

        ExposureError if it is not positive.
        """
        return min(self.full_well, self.top(iso)) / self.electrons

    @property
    def dynamic_range(self) -> float:
        """Dynamic range at the base ISO, in stops: the full well over the noise of reading and rounding."""
        step = self.full_well / (2**self.bits - 1)
        return math.log2(self.full_well / math.hypot(self.read_noise, step / math.sqrt(12.0)))

    def record(self, image: ArrayLike, iso: float, lux_seconds: float = 1.0, seed: int = 0, top: int = 0) -> np.ndarray:
        """The recorded picture of a linear one. The noise of a pixel depends on the seed and its place alone.

        Args:
            image: (h, w, 3) array. Linear picture.
            iso: ISO speed.
            lux_seconds: Exposure that the value 1 of the picture represents: `Exposure.lux_seconds` for relative
                weights, LUMINANCE for physical ones.
            seed: Seed of the noise.
            top: Of some lines of a picture, the place of the first one from above.
        Returns:
            (h, w, 3) array. float32, in the unit of the given picture, black at 0; noise may be negative.
        Raises:
            ExposureError: For an invalid ISO speed or exposure.
        """
        most = self.top(iso)
        values = np.ascontiguousarray(image, np.float32)
        out, begin = np.empty_like(values), top * math.prod(values.shape[1:])
        unit = self.electrons * checked_positive("exposure", lux_seconds)
        levels = 2**self.bits - 1
        numbers = [np.float32(x) for x in (unit, self.full_well, self.read_noise, most / levels, levels)]

        def work(first: int) -> None:
            piece = slice(first, first + PART)
            _record(values.reshape(-1)[piece], out.reshape(-1)[piece], begin + first, _normal(),
                    np.uint32(seed & 0xFFFFFFFF), *numbers)

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(work, range(0, values.size, PART)))
        return out


@lru_cache(maxsize=1)
def _normal() -> np.ndarray:
    """Quantiles (CELLS + 1,) of the normal distribution; the outer ones give linear interpolation the variance 1."""
    normal = NormalDist()
    inner = np.array([normal.inv_cdf(i / CELLS) for i in range(1, CELLS)])
    a, b = inner[:-1], inner[1:]
    left = (3.0 * CELLS - (a * a + a * b + b * b).sum()) / 2.0          # = a² + a b + b² of the outermost cells
    last = inner[-1]
    end = 0.5 * (-last + math.sqrt(4.0 * left - 3.0 * last**2))
    return np.concatenate([[-end], inner, [end]]).astype(np.float32)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})
def _record(values, out, first, normal, seed, unit, full_well, read_noise, step, levels):
    """Exposures in `unit` electrons, converted by the sensor; step: electrons to a number of the converter.

    first: index of values[0] in the whole picture. Poisson's law by the sum of its terms below FEW electrons; above, a
    normal distribution corrected for the third moment (Cornish and Fisher), its variance reduced by correction and
    rounding.
    """
    real = np.float32
    start = mix(uint32(seed * uint32(0x9E3779B9) + uint32(0x51ED270B)))
    cell, cell_width = uint32(20), real(1.0 / 1048576.0)
    low, back = np.floor(-real(PEDESTAL) * levels), step / unit
    for i in range(values.size):
        a = mix(uint32(uint32(first + i) * uint32(0x9E3779B9) + start))
        b = mix(uint32(a + uint32(0x85EBCA6B)))
        j, k = a >> cell, b >> cell
        f, g = real(np.int32(a & uint32(0xFFFFF))) * cell_width, real(np.int32(b & uint32(0xFFFFF))) * cell_width
        z = normal[j] + f * (normal[j + 1] - normal[j])

        # Electrons of the well
        mean = values[i] * unit
        mean = mean if mean > real(0) else real(0)              # also for NaN
        mean = mean if mean < real(1e9) else real(1e9)
        if mean >= real(FEW):
            count = np.floor(mean + math.sqrt(mean - real(5.0 / 36.0)) * z + (z * z - real(1)) * real(1.0 / 6.0)
                             + real(0.5))
        else:
            u = real(np.int32(mix(uint32(a ^ uint32(0x68E31DA4))) >> uint32(8))) * real(1.0 / 16777216.0)
            term = real(math.exp(-mean))
            count = real(0)
            while u >= term and count < real(64):
                u -= term
                count += real(1)
                term *= mean / count
        count = count if count > real(0) else real(0)
        count = count if count < full_well else full_well

        # Read and convert
        noise = read_noise * (normal[k] + g * (normal[k + 1] - normal[k]))
        number = np.floor((count + noise) / step + real(0.5))
        number = number if number > low else low
        number = number if number < levels else levels
        out[i] = number * back
