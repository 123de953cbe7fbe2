"""A homogeneous medium around the camera: fog, smoke or water.

Along a ray of length d from the camera a radiance L becomes
L e^(−σ d) + (σ_s / σ) J (1 − e^(−σ d)), where σ = σ_a + σ_s is the extinction (1/mm) and J the radiance that is
scattered into the ray, the same everywhere (Beer and Lambert; Koschmieder's airlight). Light reaches the surfaces of
the scene as through clear air, and is scattered once. The index refracts at a flat window before the camera, or at
the front surface of a lens that lies in the medium itself (`Lens.front_index`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import (
    A0, BLUE, DEPTH, GREEN, RED, SB, SG, SR, TB, TG, TR, B, Step, offsets, pack, rows, stage, vector
)
from lensbench.core.scenery.values import Triple
from lensbench.core.text import fixed, significant

DARK = 40.0             # σ d beyond which nothing is transmitted
CONTRAST = 0.02         # of an object that is just visible, which defines the visibility
WATER = (0.340, 0.0565, 0.00922)        # 1/m: absorption of pure water at 0.65, 0.55, 0.45 µm (Pope and Fry 1997)
WATER_INDEX = 1.333
EXTINCTION, AIRLIGHT, FOG = offsets(3, 3)       # parameters of `fog`


class MediumError(ValueError):
    """An invalid medium; the message says how to correct it."""


@dataclass(frozen=True)
class Medium:
    """Homogeneous medium between the camera and the scene, compared by value.

    Args:
        index: Index of refraction before the camera, 1 (air) to 3.
        absorption, scattering: (r, g, b). Coefficients σ_a and σ_s, 1/mm.
        light: (r, g, b). Radiance J scattered into every ray, relative as in `Scene`.
    Raises:
        MediumError: If a value is out of range.
    """

    index: float = 1.0
    absorption: Triple = (0.0, 0.0, 0.0)
    scattering: Triple = (0.0, 0.0, 0.0)
    light: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.index) and 1.0 <= self.index <= 3.0):
            raise MediumError(f"index {significant(self.index)} of a medium: it must lie between 1 (air) and 3")
        for name in ("absorption", "scattering", "light"):
            values = tuple(float(x) for x in getattr(self, name))
            if len(values) != 3 or not all(math.isfinite(x) and x >= 0.0 for x in values):
                raise MediumError(f"{name} of a medium: it must be three numbers, 0 or positive")
            object.__setattr__(self, name, values)

    @classmethod
    def fog(cls, visibility: float, light: Triple = (1.0, 1.0, 1.0)) -> "Medium":
        """Fog, which absorbs nothing.

        Args:
            visibility: Distance in mm at which a black object has 1/50 of its contrast.
            light: (r, g, b). Radiance scattered into every ray.
        """
        return cls(scattering=(_extinction(visibility),) * 3, light=light)

    @classmethod
    def water(cls, visibility: float, light: Triple = (1.0, 1.0, 1.0)) -> "Medium":
        """Water with particles: the absorption of pure water, and grey scattering.

        Args:
            visibility: Distance in mm at which a black object has 1/50 of its contrast in green light.
            light: (r, g, b). Radiance scattered into every ray.
        Raises:
            MediumError: If the visibility exceeds that of pure water, 69 m.

        References:
            Pope and Fry, "Absorption spectrum (380-700 nm) of pure water", Applied Optics 36 (1997).
        """
        absorption = tuple(1e-3 * x for x in WATER)
        scattering = _extinction(visibility) - absorption[1]
        if scattering < 0.0:
            raise MediumError(f"visibility {significant(visibility / 1e3)} m: in pure water one sees "
                              f"{fixed(-math.log(CONTRAST) / WATER[1], 0)} m")
        return cls(WATER_INDEX, (absorption[0], absorption[1], absorption[2]), (scattering,) * 3, light)

    @property
    def extinction(self) -> np.ndarray:
        """Absorption plus scattering, (3,), 1/mm."""
        return np.add(self.absorption, self.scattering)

    @property
    def is_clear(self) -> bool:
        """Whether the medium neither absorbs nor scatters."""
        return not self.extinction.any()

    @property
    def airlight(self) -> np.ndarray:
        """Radiance of an endless length of the medium, (3,)."""
        return np.divide(np.multiply(self.scattering, self.light), self.extinction, out=np.zeros(3),
                         where=self.extinction > 0.0)

    def transmittance(self, distance: ArrayLike) -> np.ndarray:
        """Part of the light that the medium transmits.

        Args:
            distance: array_like, shape (…). Length of the way through the medium, mm.
        Returns:
            ndarray, shape (…, 3). For red, green and blue, from 0 to 1.
        """
        return np.exp(-np.asarray(distance, float)[..., None] * self.extinction)

    def seen(self, radiance: ArrayLike, distance: ArrayLike) -> np.ndarray:
        """Radiance as seen through the medium.

        Args:
            radiance: array_like, shape (…, 3). Radiance at the surfaces, linear red, green and blue.
            distance: array_like, shape (…). Length of the way through the medium, mm.
        Returns:
            ndarray, shape (…, 3). With the airlight of the way.
        """
        passed = self.transmittance(distance)
        return np.asarray(radiance) * passed + self.airlight * (1.0 - passed)

    @property
    def steps(self) -> list[Step]:
        """The stage after the intersection of a path; none if the medium is clear."""
        return [] if self.is_clear else [Step(fog, pack(FOG, {EXTINCTION: self.extinction, AIRLIGHT: self.airlight}))]

    @property
    def dimming(self) -> list[Step]:
        """The stage that attenuates RED, GREEN, BLUE over DEPTH; none if the medium is clear."""
        return [] if self.is_clear else [Step(dim, self.extinction)]


def _extinction(visibility: float) -> float:
    if not (math.isfinite(visibility) and visibility > 0.0):
        raise MediumError(f"visibility {significant(visibility)} mm: it must be a positive number")
    return -math.log(CONTRAST) / visibility


@stage
def _transmitted(lanes, out, depth, sigma):
    """Write e^(−σ d) to the row `out`: the 64th power of a polynomial for e^(−σ d / 64)."""
    real = lanes.dtype.type
    row = rows(lanes)
    d, o = row[depth], row[out]
    step = sigma * real(1 / 64)
    for i in range(B):
        x = step * d[i]
        x = x if x < real(DARK / 64) else real(DARK / 64)
        e = real(1) - x * real(1 / 9) * (real(1) - x * real(1 / 10))
        e = real(1) - x * (real(1) - x * real(1 / 2) * (real(1) - x * real(1 / 3) * (real(1) - x * real(1 / 4) * (
            real(1) - x * real(1 / 5) * (real(1) - x * real(1 / 6) * (real(1) - x * real(1 / 7) * (
                real(1) - x * real(1 / 8) * e)))))))
        e2 = e * e
        e4 = e2 * e2
        e8 = e4 * e4
        e16 = e8 * e8
        e32 = e16 * e16
        o[i] = e32 * e32


@stage
def fog(lanes, p, ints, key):
    """Attenuate the throughput T over DEPTH, and add what is scattered into the path to S.  p: FOG numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    e, tr, tg, tb, sr, sg, sb = row[A0], row[TR], row[TG], row[TB], row[SR], row[SG], row[SB]
    r, g, b = vector(p, AIRLIGHT)
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION])
    for i in range(B):
        sr[i] += tr[i] * (real(1) - e[i]) * r
        tr[i] *= e[i]
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION + 1])
    for i in range(B):
        sg[i] += tg[i] * (real(1) - e[i]) * g
        tg[i] *= e[i]
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION + 2])
    for i in range(B):
        sb[i] += tb[i] * (real(1) - e[i]) * b
        tb[i] *= e[i]


@stage
def dim(lanes, p, ints, key):
    """Attenuate RED, GREEN, BLUE over DEPTH.  p: extinction (3, 1/mm)."""
    row = rows(lanes)
    e, red, green, blue = row[A0], row[RED], row[GREEN], row[BLUE]
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION])
    for i in range(B):
        red[i] *= e[i]
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION + 1])
    for i in range(B):
        green[i] *= e[i]
    _transmitted(lanes, A0, DEPTH, p[EXTINCTION + 2])
    for i in range(B):
        blue[i] *= e[i]
