"""Outlines of tilted and decentred surfaces: they are cuts of the true surfaces by the meridional plane."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench import lenses
from lensbench.app.plots.section import elements, surface_curves
from tests.core.optics.test_surface_pose import posed

TRIPLET = lenses.load("lenshh-cooke-triplet-50")


@pytest.mark.parametrize("pose", [{"decentre_y": 1.5, "tilt_x": 0.2}, {"decentre_x": 2.0, "tilt_y": -0.15,
                                                                      "tilt_x": 0.1}])
def test_curves_lie_on_the_surfaces_and_in_the_plane(pose):
    lens = posed(TRIPLET, 2, 3, **pose)
    for i, curve in enumerate(surface_curves(lens)):
        z, y = curve.T
        own = lens.in_frame_of(i, np.column_stack([0.0 * y, y, z]))
        rim = lens.surfaces[i].semi_diameter
        radii = np.hypot(own[:, 0], own[:, 1])
        assert radii[[0, -1]] == pytest.approx(rim, rel=2e-2)
        assert np.abs(own[:, 2] - lens.surfaces[i].sag(own[:, 0], own[:, 1]))[radii <= rim].max() < 1e-9
    made = [replace(s, curvature_x=0.3 * s.curvature) if i == 2 else s for i, s in enumerate(TRIPLET.surfaces)]
    cylindrical = posed(replace(TRIPLET, surfaces=tuple(made)), 2, 3, roll=1.3, **pose)
    z, y = surface_curves(cylindrical)[2].T
    own = cylindrical.in_frame_of(2, np.column_stack([0.0 * y, y, z]))
    within = np.hypot(own[:, 0], own[:, 1]) <= cylindrical.surfaces[2].semi_diameter
    assert np.abs(own[:, 2] - cylindrical.surfaces[2].sag(own[:, 0], own[:, 1]))[within].max() < 1e-9
    still, moved = elements(TRIPLET), elements(lens)
    assert (moved[0].outline == still[0].outline).all() and (moved[2].outline == still[2].outline).all()
    _, y, z = lens.frames[2].at(lens.vertices[2] + 0.5)                      # in the middle of the glass
    assert moved[1].holds(z, y)
    assert moved[1].strips.shape == still[1].strips.shape
