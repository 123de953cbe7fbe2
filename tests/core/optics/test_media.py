"""Which surfaces bend light, by the reference tracer: a ray that meets them aslant turns or goes straight on."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.optics.prescription import front_medium, medium_before, refracts
from lensbench.lenses.glass import catalogue

MEDIA = (lb.AIR, lb.Glass(1.0, 50.0, "VACUUM"), lb.Glass(1.6), lb.Glass(1.6, name="named"), lb.Glass(1.6, 60.0),
         lb.Glass(1.6, 60.0, "crown"), lb.Glass(1.6, 40.0), catalogue.find("N-BK7"),
         replace(catalogue.find("N-BK7"), name="BOROSILICATE"), catalogue.find("N-SF6"))


@pytest.mark.parametrize(("before", "after"), list(product(MEDIA, MEDIA)))
def test_a_surface_refracts_where_an_oblique_ray_turns_at_any_wavelength(before, after):
    lens = lb.Lens((lb.Surface(1.0, 10.0, before, curvature=0.0), lb.Surface(1.0, 10.0, after, curvature=0.0),
                    lb.Surface(0.0, 10.0, curvature=0.0)),
                   0)
    slant = np.array([0.0, 0.5, 1.0]) / np.hypot(0.5, 1.0)
    turns = False
    for wavelength in (lb.F_LINE, lb.D_LINE, lb.C_LINE):
        paths = lb.trace(lens, [0.0, 0.0, -1.0], slant, wavelength, record=True).paths[0]
        turns |= not np.allclose(np.diff(paths[1:], axis=0)[0], np.diff(paths[1:], axis=0)[1], rtol=0.0, atol=1e-12)
    assert refracts(lens, 1) == turns


def test_the_medium_in_front_is_air_or_that_in_which_the_lens_stands():
    lens = lb.Lens((lb.Surface(5.0, 10.0, curvature=0.0), lb.Surface(3.0, 10.0, lb.Glass(1.6), curvature=0.02)), 0)
    assert front_medium(lens) is lb.AIR and not refracts(lens, 0)
    immersed = replace(lens, front_index=1.33)
    assert front_medium(immersed) == lb.Glass(1.33) and refracts(immersed, 0)
    assert medium_before(immersed, 0) == lb.Glass(1.33)
    assert [medium_before(lens, i) for i in (0, 1, 2)] == [lb.AIR, lb.AIR, lb.Glass(1.6)]
