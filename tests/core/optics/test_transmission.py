"""The working f-number of a lens that is dark along its axis, against the light of a disk aside in closed form."""

from math import pi, sqrt

import pytest

import lensbench as lb


@pytest.mark.parametrize("aside", [6.5, 9.0, 15.0])
def test_a_rim_beside_the_axis_passes_the_light_of_a_disk_there(aside):
    rim, away = 4.0, 40.0
    lens = lb.Lens((lb.Surface(0.0, 1.0, 60.0), lb.Surface(0.0, 0.0, rim, pose=lb.SurfacePose(
        decentre_x=0.6 * aside, decentre_y=-0.8 * aside))), 0)
    # Illuminance under an even disk, parallel, over its radiance (Foote 1915)
    light = 0.5 * pi * (1.0 - (away**2 + aside**2 - rim**2) / sqrt((away**2 + aside**2 + rim**2) ** 2
                                                                  - 4.0 * aside**2 * rim**2))
    assert lb.working_f_number(lens, away) == pytest.approx(0.5 * sqrt(pi / light), rel=0.02)
