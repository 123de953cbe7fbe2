"""The look around in a panorama, against the rays of its camera."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.pose import NARROWEST, STEEPEST_LOOK, WIDEST, LookAround

SIZE = (600.0, 400.0)
FILMS = {"equirectangular": lb.Film(36.0, 18.0, 360, 180), "equal-area": lb.Film(24.0, 24.0, 240, 240),
         "cube-map": lb.Film(32.0, 24.0, 320, 240)}
LOOKS = [LookAround(), LookAround(0.7, 0.3, 1.2), LookAround(-2.9, -1.1, 2.0), LookAround(1.5, STEEPEST_LOOK, 0.4)]


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("layout", FILMS)
def test_a_place_of_the_view_is_the_pixel_whose_ray_goes_there(layout, look):
    film = FILMS[layout]
    places = [(0.5, 0.5), (0.1, 0.2), (0.9, 0.3), (0.3, 0.95)]
    raster = np.array([look.raster(place, SIZE, film, layout) for place in places])
    found = lb.EnvironmentCamera(film, layout=layout).generate_rays(raster, np.full((4, 2), 0.5)).directions
    # A perspective camera that is turned alike: yaw about y, then pitch about its own x
    cy, sy, cp, sp = math.cos(look.yaw), math.sin(look.yaw), math.cos(look.pitch), math.sin(look.pitch)
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
    half = math.tan(0.5 * look.fov)
    wanted = np.array([turn @ [(2 * x - 1) * half, (1 - 2 * y) * half * 400 / 600, -1.0] for x, y in places])
    wanted /= np.linalg.norm(wanted, axis=1)[:, None]
    np.testing.assert_allclose(found, wanted, atol=2e-6)            # rays in single precision


def test_a_drag_takes_the_middle_along_and_the_wheel_stays_within_its_range():
    film = FILMS["equirectangular"]
    before = LookAround(0.4, 0.0, 1.0)
    after = before.dragged(60.0, 0.0, SIZE)
    assert after.yaw > before.yaw                                   # the sphere goes right: one looks to the left
    np.testing.assert_allclose(after.raster((0.6, 0.5), SIZE, film, "equirectangular"),
                               before.raster((0.5, 0.5), SIZE, film, "equirectangular"))
    assert LookAround(pitch=1.5).dragged(0.0, 1e9, SIZE).pitch == STEEPEST_LOOK
    assert LookAround().zoomed(100.0).fov == NARROWEST and LookAround().zoomed(-100.0).fov == WIDEST
