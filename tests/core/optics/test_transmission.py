"""The working f-number of a lens that is dark along its axis, against the light of a disk aside in closed form."""

from math import pi, sqrt

import pytest

import lensbench as lb
from lensbench import lenses
from tests.core.oracles import of_one_colour


@pytest.mark.parametrize("aside", [6.5, 9.0, 15.0])
def test_a_rim_beside_the_axis_passes_the_light_of_a_disk_there(aside):
    rim, away = 4.0, 40.0
    lens = lb.Lens((lb.Surface(1.0, 60.0, curvature=0.0), lb.Surface(0.0, rim, curvature=0.0, pose=lb.SurfacePose(
        decentre_x=0.6 * aside, decentre_y=-0.8 * aside))), 0)
    # Illuminance under an even disk, parallel, over its radiance (Foote 1915)
    light = 0.5 * pi * (1.0 - (away**2 + aside**2 - rim**2) / sqrt((away**2 + aside**2 + rim**2) ** 2
                                                                  - 4.0 * aside**2 * rim**2))
    assert lb.working_f_number(lens, away) == pytest.approx(0.5 * sqrt(pi / light), rel=0.02)


def test_a_t_number_is_that_of_the_colour():
    """Focal length and pupil are those of this colour, as the reflectances are."""
    lens = lenses.load("lib-tronnier-1953")
    blue = lb.t_number(lens, wavelength=0.4358)
    assert blue == pytest.approx(lb.t_number(of_one_colour(lens, 0.4358)), rel=1e-12)
    assert blue != pytest.approx(lb.t_number(lens), rel=1e-4)
    fo = lb.first_order(lens, 0.4358)
    passed = lb.transmission(lens, 0.4358)
    assert blue == pytest.approx(fo.efl / (2.0 * fo.entrance_pupil.radius * sqrt(passed)), rel=1e-12)
