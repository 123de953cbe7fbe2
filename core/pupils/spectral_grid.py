"""Film grids by wavelength: exit-pupil regions for pictures behind a lens without rotational symmetry.

The regions move with the refractive indices, which are nearly a parabola in 1 / λ². Three wavelengths are solved, and
the grid of any other is interpolated between theirs.
"""

from functools import cached_property
from math import prod

from lensbench.imaging.film_pose import UPRIGHT, FilmPose
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid_sampler import PupilGrid

SOLVED = (0.44, D_LINE, 0.64)           # µm; the d line is solved for every camera
FIRST, LAST = 0.42, 0.651               # range of wavelengths (µm) in a picture


class SpectralPupilGrid:
    """Grids of one lens, with a film of half_width and half_height at film_distance (all mm), in a pose."""

    def __init__(self, lens: Lens, film_distance: float, half_width: float, half_height: float,
                 pose: FilmPose = UPRIGHT):
        self._film, self._pose = (lens, film_distance, half_width, half_height), pose

    def _solve(self, wavelength: float) -> PupilGrid:
        """Grid at a wavelength (µm), not interpolated."""
        return PupilGrid.of(*self._film, wavelength, self._pose)

    @cached_property
    def _at_d_line(self) -> PupilGrid:
        return self._solve(D_LINE)

    @cached_property
    def _solved(self) -> list[PupilGrid]:
        return [self._at_d_line if wavelength == D_LINE else self._solve(wavelength) for wavelength in SOLVED]

    @property
    def _can_interpolate(self) -> bool:
        """Whether the nodes of the solved grids are crowded alike: light ends at all these wavelengths, or at none."""
        return len({grid.nodes.crowding for grid in self._solved}) == 1

    def at(self, wavelength: float) -> PupilGrid:
        """Grid at a wavelength (µm).

        Outside the range of pictures, and where the light ends at some wavelengths only, it is solved by itself.
        """
        if wavelength == D_LINE:
            return self._at_d_line
        if not FIRST <= wavelength <= LAST or not self._can_interpolate:
            return self._solve(wavelength)
        w, nodes = wavelength**-2, [solved**-2 for solved in SOLVED]
        shares = [prod((w - other) / (node - other) for other in nodes if other != node) for node in nodes]
        return PupilGrid.interpolated(self._solved, shares)
