"""The magnifier: the pixels that it shows, their codes, and its keys."""

import numpy as np
import pytest
from imgui_bundle import imgui

from lensbench.app.bench import tone
from lensbench.app.display.frame import Light
from lensbench.app.panels.image.overlays import STEPS, USUAL, cells, codes


def test_cells_are_the_pixels_about_the_middle_and_nothing_beyond_the_edge():
    picture = np.arange(4 * 6 * 3, dtype=np.float32).reshape(4, 6, 3)
    np.testing.assert_array_equal(cells(picture, 2, 2, 3, 3), picture[1:4, 1:4])
    corner = cells(picture, 0, 3, 3, 5)
    assert np.isnan(corner[:, 0]).all() and np.isnan(corner[3:]).all()
    np.testing.assert_array_equal(corner[:3, 1:], picture[1:4, :2])


def test_codes_are_those_of_the_screen():
    values = np.random.default_rng(1).gamma(0.5, 1.0, (3, 4, 3))
    light = Light(values.astype(np.float32), exposure=0.5, tone="filmic")
    np.testing.assert_array_equal(codes(light, values), tone.develop(values, 0.5, "filmic"))
    apart = codes(Light(light.values, tone="difference", scale=2.0), values)
    np.testing.assert_allclose(apart, tone.srgb(np.clip(values / 2.0, 0.0, 1.0)))


@pytest.mark.slow
def test_the_magnifier_is_switched_by_key_tool_and_menu_and_magnifies_by_the_wheel(drive, monkeypatch):
    words = []
    add = imgui.ImDrawList.add_text
    monkeypatch.setattr(imgui.ImDrawList, "add_text", lambda draw, *args: words.append(args[-1]) or add(draw, *args))

    def use(hand):
        view = hand.session.view
        hand.picture()
        before = hand.settings
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.5, 0.5))
        hand.press(imgui.Key.m)
        assert view.magnifier == USUAL
        words.clear()
        hand.ctx.yield_(2)
        x, y = (int(coordinate) for coordinate in view.links.hover)
        value = hand.session.presenter.light[y, x]
        code = np.round(255.0 * tone.develop(value, hand.settings.exposure, hand.settings.tone)).astype(int)
        assert f"{x}, {y}   #" + "".join(f"{channel:02x}" for channel in code) in words
        few = len(words)
        hand.ctx.key_down(imgui.Key.mod_alt)
        for _ in range(6):
            hand.ctx.mouse_wheel_y(1.0)
            hand.ctx.yield_()
        hand.ctx.key_up(imgui.Key.mod_alt)
        assert view.magnifier == len(STEPS)
        words.clear()
        hand.ctx.yield_(2)
        assert len(words) > few + 3 * 25                                # a number for each part of each pixel
        hand.ctx.item_click("**/Magnifier")
        assert view.magnifier == 0
        hand.ctx.menu_click("//##MainMenuBar/View/Magnifier")
        assert view.magnifier == USUAL and hand.settings == before

    assert drive(use).view.messages == []
