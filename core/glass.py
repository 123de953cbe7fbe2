"""Glasses: the refractive index of a medium against wavelength.

Wavelengths in micrometres; indices relative to air, which is n = 1.
"""

from dataclasses import dataclass
from math import isfinite

F_LINE = 0.4861327
D_LINE = 0.5875618
C_LINE = 0.6562725


class GlassError(ValueError):
    """A glass that cannot be, or that is not known at the wavelength asked for; the message says what to do."""


@dataclass(frozen=True)
class Glass:
    """A medium: its index at the d line, its Abbe number V_d (None: no dispersion is known), and how it disperses.

    name: what the maker calls it, "" where only the numbers are known.
    formula: "model" knows n_d and V_d alone; others, with their coefficients,
    stand in FORMULAS. wavelengths: the range (µm) in which they hold, None: any.
    """

    n_d: float = 1.0
    v_d: float | None = None
    name: str = ""
    formula: str = "model"
    coefficients: tuple = ()
    wavelengths: tuple[float, float] | None = None

    def __post_init__(self):
        if not (isfinite(self.n_d) and self.n_d >= 1.0):
            raise GlassError(f"index {self.n_d} of a glass: it must be a number of at least 1")
        if self.v_d is not None and not (isfinite(self.v_d) and self.v_d > 0.0):
            raise GlassError(f"Abbe number {self.v_d} of a glass: it must be a positive number, or left out")

    def index(self, wavelength: float = D_LINE) -> float:
        """Index at a wavelength (µm): Cauchy's A + B / λ² through n_d with n_F − n_C = (n_d − 1) / V_d."""
        if self.v_d is None or self.n_d == 1.0:
            return self.n_d
        b = (self.n_d - 1.0) / self.v_d / (F_LINE**-2 - C_LINE**-2)
        return self.n_d + b * (wavelength**-2 - D_LINE**-2)


AIR = Glass()
