"""A and B: the difference is what arithmetic says, the shader shows it, and hands find their way."""

from dataclasses import replace

import moderngl
import numpy as np
import pytest
from hypothesis import given, strategies as st
from imgui_bundle import imgui

from lensbench.app.bench import tone
from lensbench.app.bench.tone import Difference, round_above
from lensbench.app.display.gl_texture import Development, Screen
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.image.compare import differences, plate_lines
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL


def picture(seed, height=12, width=16):
    return np.random.default_rng(seed).gamma(0.5, 1.0, (height, width, 3)).astype(np.float32)


def test_rms_and_maximum_are_those_of_all_pixels_and_channels():
    a, b = picture(1), picture(2)
    difference = Difference.of(a, b)
    apart = (b.astype(float) - a).ravel()
    assert difference.rms == pytest.approx(np.sqrt(np.dot(apart, apart) / apart.size), rel=1e-6)
    assert difference.largest == pytest.approx(np.abs(apart).max(), rel=1e-6)
    assert Difference.of(b, a) == difference
    same = Difference.of(a, a)
    assert same.rms == same.largest == 0.0 and same.scale == 1.0


def test_places_that_are_no_number_in_either_count_as_alike():
    a, b = np.ones((4, 4, 3), np.float32), np.ones((4, 4, 3), np.float32)
    a[0, 0], b[1, 1] = np.nan, np.inf
    b[2, 2] = 1.5
    assert Difference.of(a, b).largest == 0.5


@given(st.lists(st.text("abc 1", min_size=1, max_size=9), min_size=1, max_size=6), st.integers(1, 60))
def test_a_plate_breaks_at_commas_where_it_is_wider_than_its_room(parts, room):
    lines = plate_lines("A   " + ", ".join(parts), "8 samples", room, len)
    assert "".join("".join(lines).split(", ")).replace("8 samples", "").split() == \
        "".join(("A   " + "".join(parts)).split(", ")).split()
    whole = [f"A   {parts[0]}", *parts[1:], "8 samples"]
    assert all(len(line) <= room or line in whole for line in lines)


@given(st.floats(1e-9, 1e9))
def test_a_scale_ends_at_the_next_of_1_2_5(value):
    end = round_above(value)
    assert value * (1.0 - 1e-9) <= end <= 2.5 * value * (1.0 + 1e-9)
    assert f"{end:.6e}"[0] in "125"


def test_the_shader_shows_the_difference_as_arithmetic_has_it():
    context = moderngl.create_context(standalone=True, backend="egl")
    one, other = Screen(context), Screen(context)
    a, b = picture(1), picture(2)
    one.load(a)
    assert one.apart(other, 1.0) == 0
    other.load(b)
    one.developed(Development())
    assert one.apart(other, 2.0) > 0
    expected = tone.srgb(np.clip(np.abs(a - b).astype(float) / 2.0, 0.0, 1.0)) * 255.0
    assert np.abs(one.read_apart() - expected).max() <= 1.0
    other.load(a)                               # the same texture again, with another picture in it
    one.apart(other, 2.0)
    assert one.read_apart().max() == 0
    other.load(picture(3, 6, 8))
    assert one.apart(other, 2.0) == 0           # of another size
    context.release()


def test_plates_say_in_what_two_settings_differ():
    plain = Settings()
    assert differences(plain, replace(plain, f_number=8.0, focus_distance=2000.0)) == ("f/2.8, 1.20 m", "f/8, 2.00 m")
    assert differences(plain, plain)[0] == "the same settings"
    assert differences(plain, replace(plain, medium="fog", iso=400.0)) == ("medium air, iso 100", "medium fog, iso 400")
    film = replace(plain, film_width=23.5, film_height=15.6)
    assert differences(plain, film)[1] == "APS-C 23.5 × 15.6"


@pytest.mark.slow
def test_a_picture_is_pinned_and_compared_by_keys_and_mouse(drive):
    key = imgui.Key

    def use(hand):
        hand.picture()
        hand.press(key.w)
        assert hand.settings.compare == "off" and "as A first" in hand.session.view.messages[0]
        hand.ctx.item_click("**/Compare")
        hand.ctx.item_click("//$FOCUSED/Pin picture as A")
        hand.ctx.yield_(3)
        # what was missing is there: nothing asks for it any more
        assert hand.session.presenter.pinned.settings == SMALL and hand.session.view.messages == []
        generation = hand.session.worker.generation
        hand.press(key.w)
        assert hand.settings.compare == "wipe"
        before = hand.settings
        hand.drag(hand.at("**/Wipe", 0.5, 0.3), hand.at("**/Picture", 0.7, 0.3))
        assert 0.55 < hand.settings.wipe < 0.85 and hand.settings.yaw == 0.0
        hand.press(chord(key.mod_ctrl, key.z))
        assert hand.settings == before
        hand.press(key.d)
        assert hand.settings.compare == "difference"
        assert hand.session.presenter.picture(hand.settings, hand.session.view).difference.largest == 0.0
        assert hand.session.worker.generation == generation       # none of this renders anything
        hand.press(key.s)
        hand.drag(hand.at("**/Exposure", 0.5, 0.5), hand.at("**/Exposure", 0.7, 0.5))
        hand.drag(hand.at("**/Aperture", 0.5, 0.5), hand.at("**/Aperture", 0.7, 0.5))
        hand.picture()
        hand.press(key.d)
        hand.ctx.yield_(2)
        assert hand.session.presenter.picture(hand.settings, hand.session.view).difference.rms > 0.0
        hand.ctx.item_click("**/Compare")
        hand.ctx.item_click("//$FOCUSED/Apply A's settings")
        hand.picture()
        assert hand.settings == replace(SMALL, compare="difference")
        hand.press(key.d)
        assert hand.settings == SMALL

    assert drive(use).view.messages == []
