"""A homogeneous medium around the camera: fog, smoke, water. What it takes from light, and what it adds.

Along a ray of length d from the camera a radiance L becomes
L e^(−σ d) + (σ_s / σ) J (1 − e^(−σ d)), σ = σ_a + σ_s the extinction (1/mm), and J the radiance that is scattered
into the ray, the same everywhere (Beer and Lambert; Koschmieder's airlight). Light reaches the surfaces of
the scene as through clear air, and is scattered once. The index refracts at a flat window before the camera, or at
the front surface of a lens that stands in the medium itself (`Lens.front_index`).
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.kernels.block import A0, BLUE, DEPTH, GREEN, RED, SB, SG, SR, TB, TG, TR, B, Step, rows, stage

Triple = tuple[float, float, float]
DARK = 40.0             # σ d from which nothing comes through
CONTRAST = 0.02         # of an object that is just seen, by which visibility is told
WATER = (0.340, 0.0565, 0.00922)        # 1/m: absorption of pure water at 0.65, 0.55, 0.45 µm (Pope and Fry 1997)
WATER_INDEX = 1.333


class MediumError(ValueError):
    """A medium that cannot be; the message says what to do."""


@dataclass(frozen=True)
class Medium:
    """index of refraction before the camera; absorption and scattering (1/mm) and the in-scattered radiance, r g b."""

    index: float = 1.0
    absorption: Triple = (0.0, 0.0, 0.0)
    scattering: Triple = (0.0, 0.0, 0.0)
    light: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self):
        if not (math.isfinite(self.index) and 1.0 <= self.index <= 3.0):
            raise MediumError(f"index {self.index:g} of a medium: it must lie between 1 (air) and 3")
        for name in ("absorption", "scattering", "light"):
            values = tuple(float(x) for x in getattr(self, name))
            if len(values) != 3 or not all(math.isfinite(x) and x >= 0.0 for x in values):
                raise MediumError(f"{name} of a medium: it must be three numbers, 0 or positive")
            object.__setattr__(self, name, values)

    @classmethod
    def fog(cls, visibility: float, light: Triple = (1.0, 1.0, 1.0)) -> "Medium":
        """Fog that absorbs nothing, of this visibility (mm): there a black object has a fiftieth of its contrast."""
        return cls(scattering=(_extinction(visibility),) * 3, light=light)

    @classmethod
    def water(cls, visibility: float, light: Triple = (1.0, 1.0, 1.0)) -> "Medium":
        """Water of this visibility (mm) in green: what water itself absorbs, and grey scattering by what floats in it.

        MediumError beyond the 69 m of pure water.
        """
        absorption = tuple(1e-3 * x for x in WATER)
        scattering = _extinction(visibility) - absorption[1]
        if scattering < 0.0:
            raise MediumError(f"visibility {visibility / 1e3:g} m: in pure water one sees "
                              f"{-math.log(CONTRAST) / WATER[1]:.0f} m")
        return cls(WATER_INDEX, (absorption[0], absorption[1], absorption[2]), (scattering,) * 3, light)

    @property
    def extinction(self) -> np.ndarray:
        """(3,) 1/mm."""
        return np.add(self.absorption, self.scattering)

    @property
    def is_clear(self) -> bool:
        """Whether light goes through it unchanged, but for its index."""
        return not self.extinction.any()

    @property
    def airlight(self) -> np.ndarray:
        """(3,) the radiance of so much of it that nothing is seen through."""
        return np.divide(np.multiply(self.scattering, self.light), self.extinction, out=np.zeros(3),
                         where=self.extinction > 0.0)

    def transmittance(self, distance) -> np.ndarray:
        """(…, 3) the part of light that passes distances (…) in mm."""
        return np.exp(-np.asarray(distance, float)[..., None] * self.extinction)

    def seen(self, radiance, distance) -> np.ndarray:
        """(…, 3) what is seen of radiances (…, 3) through distances (…) in mm."""
        passed = self.transmittance(distance)
        return radiance * passed + self.airlight * (1.0 - passed)

    @property
    def steps(self) -> list[Step]:
        """The step after what a path meets; none where the medium is clear."""
        return [] if self.is_clear else [Step(fog, np.concatenate([self.extinction, self.airlight]))]

    @property
    def dimming(self) -> list[Step]:
        """The step that takes from RED, GREEN, BLUE what is lost over DEPTH; none where the medium is clear."""
        return [] if self.is_clear else [Step(dim, self.extinction)]


def _extinction(visibility: float) -> float:
    if not (math.isfinite(visibility) and visibility > 0.0):
        raise MediumError(f"visibility {visibility:g} mm: it must be a positive number")
    return -math.log(CONTRAST) / visibility


@stage
def _passed(lanes, out, depth, sigma):
    """Out becomes e^(−σ d): the 64th power of a polynomial, of e^(−σ d / 64)."""
    real = lanes.dtype.type
    row = rows(lanes)
    d, o = row[depth], row[out]
    part = sigma * real(1 / 64)
    for i in range(B):
        x = part * d[i]
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
def fog(lanes, p, key):
    """Over DEPTH, what the path carries on (T) is dimmed, and what is scattered into it is gathered (S).

    p: extinction (3, 1/mm), airlight (3).
    """
    real = lanes.dtype.type
    row = rows(lanes)
    e, tr, tg, tb, sr, sg, sb = row[A0], row[TR], row[TG], row[TB], row[SR], row[SG], row[SB]
    _passed(lanes, A0, DEPTH, p[0])
    for i in range(B):
        sr[i] += tr[i] * (real(1) - e[i]) * p[3]
        tr[i] *= e[i]
    _passed(lanes, A0, DEPTH, p[1])
    for i in range(B):
        sg[i] += tg[i] * (real(1) - e[i]) * p[4]
        tg[i] *= e[i]
    _passed(lanes, A0, DEPTH, p[2])
    for i in range(B):
        sb[i] += tb[i] * (real(1) - e[i]) * p[5]
        tb[i] *= e[i]


@stage
def dim(lanes, p, key):
    """RED, GREEN, BLUE lose what is absorbed and scattered over DEPTH. p: extinction (3, 1/mm)."""
    row = rows(lanes)
    e, red, green, blue = row[A0], row[RED], row[GREEN], row[BLUE]
    _passed(lanes, A0, DEPTH, p[0])
    for i in range(B):
        red[i] *= e[i]
    _passed(lanes, A0, DEPTH, p[1])
    for i in range(B):
        green[i] *= e[i]
    _passed(lanes, A0, DEPTH, p[2])
    for i in range(B):
        blue[i] *= e[i]
