"""The ray grid and what is read from it against CODE V's listing of a double Gauss, to its printed digits."""

from math import radians, tan

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.analysis.grids.field_beams import OFFSET_S, OFFSET_T, SLOPE_S, SLOPE_T
from tests.core.analysis.grids.test_ray_grid import of_angles
from tests.core.optics.test_reference_lenses import LISTING, listed, printed

DEGREES = [0.0, 10.0, 14.0]
LEVER = 65.0            # mm from the last surface to the film, by which the slopes' sixth digits move the landing


@pytest.fixture(scope="module")
def grid():
    return of_angles(listed("d"), LISTING["film"], *DEGREES, pupil=16)


def test_the_reference_points_foci_and_distortion_of_the_grid_are_the_listed_ones(grid):
    foci, stack = lb.analysis.close_foci(grid)[:, 0], grid.lens
    for f, degrees in enumerate(DEGREES[1:], 1):
        expected = LISTING["chief"][f"{degrees:.0f}"]
        assert grid.images[f, 1] == printed(expected["image_y"], 6)
        curves = lb.analysis.field_curves(stack, LISTING["film"], of_angles(
            stack, LISTING["film"], degrees, pupil=8).conditions, 3)
        for sagittal, tangential in (foci[f], (curves.sagittal[-1, 0], curves.tangential[-1, 0])):
            assert sagittal == pytest.approx(expected["x_focus"], abs=1e-6)
            assert tangential == pytest.approx(expected["y_focus"], abs=3e-5)    # see test_reference_lenses
        # CODE V takes the ideal point in the paraxial focus along the real chief ray, the curves along the paraxial one
        fo = lb.first_order(stack)
        slope = np.divide(*grid.beams.chief.image_directions[f, 1:])
        ideal = fo.efl * tan(radians(degrees)) + (LISTING["film"] - fo.bfl) * slope
        assert 100.0 * (grid.images[f, 1] / ideal - 1.0) == printed(expected["distortion_percent"], 4)


def test_rays_of_the_grid_land_where_the_listed_rays_do(grid):
    """Each listed ray, given by its point on the first surface, is one of its field's beam."""
    for ray in LISTING["rays"]:
        f = DEGREES.index(float(ray["field_deg"]))
        direction = grid.beams.chief.directions[f]
        points = np.broadcast_to(np.array(ray["surface1_point"])[:, None, None], (3, len(DEGREES), 1))
        place = grid.beams.across(points, np.broadcast_to(direction[:, None, None], points.shape))[f]
        landed, _ = grid.beams.forward(lb.D_LINE, np.array([f]), grid.beams.starts(np.array([f]), place))
        exit_, slopes = np.array(ray["surface11_point"]), np.array(ray["exit_tan_xy"])
        on_film = exit_[:2] + (LISTING["film"] - exit_[2]) * slopes - grid.images[f]
        axes = grid.beams.axes[f]
        found = landed[[OFFSET_S, OFFSET_T], 0] @ axes, landed[[SLOPE_S, SLOPE_T], 0] @ axes
        np.testing.assert_allclose(found[0], on_film, rtol=0.0, atol=1.5e-6 * (1.0 + LEVER))
        np.testing.assert_allclose(found[1], slopes, rtol=0.0, atol=1.5e-6)
