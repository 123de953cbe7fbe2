"""A click in the picture focuses at what it pointed at, and at nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from lensbench.app.display.frame import Click, Picture, View
from lensbench.app.panels.image.image_panel import focused_by_click
from tests.app.conftest import SMALL

DEPTH = np.full((80, 120), 2500.0, np.float32)


def clicked(after):
    """The settings once the depth of the settings `after` is known, for a click made before them."""
    view = View(pending=Click(0.5, 0.5, SMALL.aim))
    assert focused_by_click(SMALL, Picture(), view) == SMALL and view.pending is not None       # it waits
    focused = focused_by_click(after, Picture(depth=DEPTH), view)
    assert view.pending is None
    return focused


@pytest.mark.parametrize("change", [{}, {"f_number": 8.0}, {"pixels_x": 240, "pixels_y": 160}, {"exposure": 1.0}])
def test_a_click_focuses_as_soon_as_the_depth_is_known(change):
    assert clicked(replace(SMALL, **change)).focus_distance == 2500.0


@pytest.mark.parametrize("change", [{"lens": "pbrt-wide-22mm"}, {"scene": "portrait"}, {"camera": "perspective"},
                                    {"yaw": 0.5}, {"crop": 0.5}])
def test_a_click_in_a_picture_that_is_no_longer_shown_is_void(change):
    after = replace(SMALL, **change)
    assert clicked(after) == after
