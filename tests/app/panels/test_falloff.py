"""Falloff: what it says of cameras without a lens is what their rays weigh."""

import math
from dataclasses import replace

import pytest

from lensbench.app.panels.falloff import without_lens
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind


@pytest.mark.parametrize(("kind", "distance"), [("perspective", 18.0), ("finite-pinhole", 18.0)])
def test_the_corner_of_a_camera_without_a_lens_falls_by_cos4(kind, distance):
    settings = replace(of_kind(SMALL, kind), hole_distance=distance, f_number=None,
                       fov=2.0 * math.atan(0.5 * min(SMALL.film_width, SMALL.film_height) / distance))
    cos4 = 1.0 / (1.0 + (0.5 * settings.film.diagonal / distance) ** 2) ** 2
    assert f"{math.log2(cos4):.1f} EV in the corner".replace("-", "−") in without_lens(settings)


@pytest.mark.parametrize("kind", ["orthographic", "environment", "fisheye", "bare-sensor"])
def test_cameras_that_weigh_all_rays_alike_have_no_falloff(kind):
    assert "no falloff" in without_lens(of_kind(SMALL, kind))
