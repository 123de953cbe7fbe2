"""The views of samples on the screen and in files: codes that anyone can compute from the rays."""

from dataclasses import replace

import numpy as np
import OpenEXR
import pytest
from imgui_bundle import imgui
from PIL import Image

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.tone import NOTES, aov_codes, aov_note
from lensbench.app.command.main import main
from lensbench.app.settings.setting_table import VIEWS
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL


def test_every_view_of_the_core_can_be_chosen_and_says_what_it_shows():
    assert set(VIEWS) == {"picture", *lb.VIEWS} and set(NOTES) == set(lb.VIEWS)
    for view in lb.VIEWS:
        assert aov_note(replace(Settings(), view=view))


def test_a_direction_is_written_as_its_colour_code_by_code(tmp_path):
    path = tmp_path / "a.png"
    assert main(["render", "pbrt-dgauss-50mm", "--lens-model", "pinhole", "--size", "24x16", "--view", "direction",
                 "--samples", "256", "--exposure", "+3", "-o", str(path)]) == 0
    with Image.open(path) as read:
        shown = np.asarray(read, float)
    of = camera(replace(Settings(), lens_model="pinhole", pixels_x=24, pixels_y=16))
    y, x = (np.mgrid[0:16, 0:24] + 0.5).reshape(2, -1)
    rays = of.generate_rays(np.array([x, y]).T, np.full((x.size, 2), 0.5))
    expected = (rays.directions.reshape(16, 24, 3) + 1.0) / 2.0 * 255.0
    # half a code of rounding; the mean over a pixel and the direction of its middle differ by less than a tenth
    assert np.abs(shown - expected).max() <= 0.6


def test_an_exr_holds_what_the_core_found(tmp_path):
    path = tmp_path / "a.exr"
    assert main(["render", "pbrt-dgauss-50mm", "--scene", "white-wall", "--size", "24x16", "--view", "depth",
                 "--samples", "4", "-o", str(path)]) == 0
    near = OpenEXR.File(str(path)).channels()["RGB"].pixels
    depth = lb.depth_map(camera(replace(Settings(), scene="white-wall", pixels_x=24, pixels_y=16)),
                         lb.builtin_scene("white-wall"))
    np.testing.assert_allclose(near[8, 12], 1000.0 / depth[8, 12], rtol=1e-3)


def test_codes_lie_within_black_and_white_and_the_origin_spans_the_front_lens():
    settings = replace(Settings(), view="origin")
    of = camera(settings)
    z = -of.film_distance - of.lens.length
    radius = of.lens.surfaces[0].semi_diameter
    image = np.array([[[0.0, 0.0, z], [radius, -radius, z + radius], [9e9, np.nan, -9e9]]], np.float32)
    wanted = [[[0.5, 0.5, 0.5], [1.0, 0.0, 1.0], [1.0, 0.5, 0.0]]]
    np.testing.assert_allclose(aov_codes(image, settings), wanted, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("view", ["fate", "depth"])
def test_a_view_is_chosen_from_the_tools_and_drawn(drive, view):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/Views")
        hand.ctx.item_click(f"//$FOCUSED/{view}")
        hand.picture()
        assert hand.settings == replace(SMALL, view=view)
        assert hand.session.presenter.update.settings.view == view
        hand.press(imgui.Key.v)
        assert hand.settings.view == list(VIEWS)[(list(VIEWS).index(view) + 1) % len(VIEWS)]

    assert drive(use).view.messages == []
