"""Light fields of a part of the screen: a crop, or the rise of a view camera."""

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.lightfields.light_field import LightField

WHITE = lb.Scene("white", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))


def camera(window, pixels=(120, 80)):
    return lb.PerspectiveCamera(lb.Film(36.0, 24.0, *pixels), 1.2, lens_radius=8.0, focus_distance=1500.0,
                                window=window)


@pytest.mark.parametrize("distance", [700.0, 4000.0])
def test_views_of_a_crop_lie_as_many_pixels_apart_as_the_same_pixels_of_the_whole(distance):
    """A tenth of the screen, across and down, has the pixels of ten times as many on the whole."""
    def apart(view):
        shape = (view.film.pixels_y, view.film.pixels_x)
        return LightField(view, 1.0, np.zeros((9, 9, 3, *shape), np.float16), np.ones((9, 9, *shape), np.float16)
                          ).apart(distance)

    part = apart(camera((-0.15, 0.15, -0.1, 0.1)))
    assert part == pytest.approx(apart(camera(None, (1200, 800))), rel=1e-9)
    # the image of a point at the distance d, on a film b behind the lens, moves by b (1/d − 1/focus) for each mm
    behind = camera(None).film_distance
    step = 2.0 * 8.0 / 9.0 * behind * abs(1.0 / distance - 1.0 / 1500.0)
    assert part == pytest.approx(step / (0.1 * 36.0 / 120.0), rel=1e-9)


@pytest.mark.parametrize("window, views", [((0.3, 1.8, -0.5, 0.5), (3, 3)), ((-0.5, 0.5, 0.6, 1.3), (1, 1))])
def test_a_picture_beside_the_axis_is_as_bright_as_that_of_the_camera(window, views):
    view = camera(window)
    direct = lb.render(view, WHITE, samples=16)
    field = lb.capture_light_field(view, WHITE, views, 256)
    assert field.refocus(1500.0).mean() == pytest.approx(direct.mean(), rel=0.01)
    assert lb.picture_through(view, WHITE, (0.0, 0.0), 1.0, 256).mean() == pytest.approx(direct.mean(), rel=0.01)
