"""What a camera samples at any wavelength of a picture behind a lens without rotational symmetry.

The regions move with the indices, which are nearly a parabola in 1 / λ²: three wavelengths are solved, and the grid of
any other lies between theirs.
"""

from functools import cached_property
from math import prod

from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid_sampler import PupilGrid

SOLVED = (0.44, D_LINE, 0.64)           # µm; the first picture of the d line has one of them already
FIRST, LAST = 0.42, 0.651               # the wavelengths that a picture sees


class SpectralPupilGrid:
    """The grids of one lens with its film at film_distance, half_width and half_height (mm)."""

    def __init__(self, lens: Lens, film_distance: float, half_width: float, half_height: float):
        self._film = lens, film_distance, half_width, half_height

    @cached_property
    def _at_d_line(self) -> PupilGrid:
        return PupilGrid.of(*self._film)

    @cached_property
    def _solved(self) -> list[PupilGrid]:
        return [self._at_d_line if wavelength == D_LINE else PupilGrid.of(*self._film, wavelength)
                for wavelength in SOLVED]

    @property
    def _alike(self) -> bool:
        return len({grid.nodes.crowding for grid in self._solved}) == 1

    def at(self, wavelength: float) -> PupilGrid:
        """The grid of a wavelength (µm).

        Solved for itself where no picture sees it, and where the light ends for some colours alone.
        """
        if wavelength == D_LINE:
            return self._at_d_line
        if not FIRST <= wavelength <= LAST or not self._alike:
            return PupilGrid.of(*self._film, wavelength)
        w, nodes = wavelength**-2, [solved**-2 for solved in SOLVED]
        shares = [prod((w - other) / (node - other) for other in nodes if other != node) for node in nodes]
        return PupilGrid.interpolated(self._solved, shares)
