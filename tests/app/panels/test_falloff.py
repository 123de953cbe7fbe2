"""Falloff: what it says of cameras without a lens is what their rays weigh; names stand clear of their curves."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.drawing.plot_axes import PlotMap
from lensbench.app.panels.falloff import name_corner, without_lens
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

PLOT = PlotMap(0.0, 0.0, 200.0, 100.0, 0.0, 1.0, 0.0, 1.0, False)
EXTENT, GAP = (8.0, 12.0), 3.0


@pytest.mark.parametrize(("kind", "distance"), [("perspective", 18.0), ("finite-pinhole", 18.0)])
def test_the_corner_of_a_camera_without_a_lens_falls_by_cos4(kind, distance):
    settings = replace(of_kind(SMALL, kind), hole_distance=distance, f_number=None,
                       fov=2.0 * math.atan(0.5 * min(SMALL.film_width, SMALL.film_height) / distance))
    cos4 = 1.0 / (1.0 + (0.5 * settings.film.diagonal / distance) ** 2) ** 2
    assert f"{math.log2(cos4):.1f} EV in the corner".replace("-", "−") in without_lens(settings)


@pytest.mark.parametrize("kind", ["orthographic", "environment", "fisheye", "bare-sensor"])
def test_cameras_that_weigh_all_rays_alike_have_no_falloff(kind):
    assert "no falloff" in without_lens(of_kind(SMALL, kind))


@pytest.mark.parametrize(("end", "slope"), [(120.0, 1.0), (199.0, 3.0), (199.0, -3.0), (199.0, 0.0)])
def test_the_name_of_a_curve_does_not_lie_on_it(end, slope):
    x = np.linspace(0.0, end, 49)
    points = np.column_stack([x, 50.0 + slope * (x - end) if slope >= 0.0 else 8.0 + slope * (x - end)])
    left, top = name_corner(points, PLOT, EXTENT, GAP)
    near = np.linspace(0.0, end, 5000)
    y = np.interp(near, *points.T)
    inside = (near > left) & (near < left + EXTENT[0]) & (y > top) & (y < top + EXTENT[1])
    assert not inside.any()
    assert left + EXTENT[0] <= PLOT.right and PLOT.top <= top <= PLOT.bottom - EXTENT[1]


def test_a_curve_without_points_has_no_name():
    assert name_corner(np.full((3, 2), np.nan), PLOT, EXTENT, GAP) is None
