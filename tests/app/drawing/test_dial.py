"""The dial under a real mouse and keyboard."""

import math
from dataclasses import dataclass

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.drawing.dial import dial
from lensbench.app.settings.dial_scales import aperture_scale, exposure_scale, focus_scale
from tests.app.stand import centre, drive

FOCUS = focus_scale(300.0, reset=1200.0)
APERTURE = aperture_scale(2.0, reset=2.8)


@dataclass
class Dials:
    """What the window shows."""

    focus: float = 1200.0
    aperture: float = 2.8
    exposure: float = 0.0

    def show(self) -> None:
        self.focus = dial("Focus distance", self.focus, FOCUS, "Distance in focus, d", (1156.0, 1248.0))
        self.aperture = dial("Aperture", self.aperture, APERTURE, "f-number, N")
        self.exposure = dial("Exposure", self.exposure, exposure_scale(), "Exposure")


def at(ctx, ref: str, scale, value: float) -> ImVec2:
    """Where a value is engraved: the bar's ends lie .72 em (10.8 pixels, rounded 11) inside it."""
    box = ctx.item_info(ref).rect_full
    left, right = box.min.x + 11.0, box.max.x - 11.0
    return ImVec2(left + scale.to_unit(value) * (right - left), 0.5 * (box.min.y + box.max.y))


def test_a_ring_answers_drag_click_wheel_keys_and_double_click():
    dials = Dials()
    seen = {}

    def test(ctx):
        # A drag from the index line follows the mouse, without a jump at its start
        start = at(ctx, "**/Focus distance", FOCUS, 1200.0)
        end = at(ctx, "**/Focus distance", FOCUS, 3000.0)
        ctx.mouse_move_to_pos(start)
        ctx.mouse_down(0)
        ctx.yield_(2)
        seen["pressed"] = dials.focus
        ctx.mouse_move_to_pos(end)
        ctx.mouse_up(0)
        ctx.yield_(2)
        seen["dragged"] = dials.focus
        # Beyond the right end it is infinity
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos(ImVec2(end.x + 500.0, end.y))
        ctx.mouse_up(0)
        ctx.yield_(2)
        seen["beyond"] = dials.focus

        # A click goes to the nearest third stop, a drag to anything
        place = at(ctx, "**/Aperture", APERTURE, 7.9)
        ctx.mouse_move_to_pos(place)
        ctx.mouse_click(0)
        ctx.yield_(2)
        seen["clicked"] = dials.aperture
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 8.0))
        ctx.mouse_wheel(ImVec2(0.0, 1.0))
        ctx.yield_(2)
        seen["wheel"] = dials.aperture
        ctx.yield_(40)                                  # so that the next click makes no double click
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 9.0))
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 13.5))
        ctx.mouse_up(0)
        ctx.yield_(2)
        seen["between"] = dials.aperture
        ctx.mouse_double_click(0)
        ctx.yield_(2)
        seen["reset"] = dials.aperture

    drive(dials.show, test, (270, 230))
    assert seen["pressed"] == 1200.0
    # The mouse stands on whole pixels: one of 228 is .0044 of the dial
    assert FOCUS.to_unit(seen["dragged"]) == pytest.approx(FOCUS.to_unit(3000.0), abs=0.009)
    assert seen["beyond"] == math.inf
    assert seen["clicked"] == 8.0 and seen["wheel"] == 9.0
    assert seen["between"] not in APERTURE.snaps
    assert APERTURE.to_unit(seen["between"]) == pytest.approx(APERTURE.to_unit(13.5), abs=0.009)
    assert seen["reset"] == 2.8


def test_a_ring_takes_typed_values_and_says_why_it_refuses_others():
    dials = Dials()
    seen = {}

    def type_into(ctx, ref: str, text: str) -> None:
        ctx.mouse_move_to_pos(centre(ctx, ref))
        ctx.key_down(imgui.Key.mod_ctrl)
        ctx.mouse_click(0)
        ctx.key_up(imgui.Key.mod_ctrl)
        ctx.yield_(3)
        ctx.key_chars_replace_enter(text)
        ctx.yield_(3)

    def test(ctx):
        type_into(ctx, "**/Focus distance", "250cm")
        seen["typed"] = dials.focus
        dials.focus = 1234.5678                         # shown as 1.23 m
        ctx.key_down(imgui.Key.mod_ctrl)
        ctx.mouse_click(0)
        ctx.key_up(imgui.Key.mod_ctrl)
        ctx.yield_(3)
        ctx.key_press(imgui.Key.enter)
        ctx.yield_(3)
        seen["nothing typed"] = dials.focus
        type_into(ctx, "**/Focus distance", "inf")
        seen["infinity"] = dials.focus
        type_into(ctx, "**/Aperture", "f/5.6")
        seen["f-number"] = dials.aperture
        # What cannot be is refused, the entry stays open, and Escape leaves the dial as it was
        type_into(ctx, "**/Aperture", "f/1.0")
        seen["refused"] = dials.aperture
        ctx.key_chars_replace_enter("4")
        ctx.yield_(2)
        seen["mended"] = dials.aperture
        type_into(ctx, "**/Exposure", "lots")
        ctx.key_press(imgui.Key.escape)
        ctx.yield_(2)
        seen["escaped"] = dials.exposure
        type_into(ctx, "**/Exposure", "-1.5 EV")
        seen["after"] = dials.exposure

    drive(dials.show, test, (270, 230))
    assert seen == {"typed": 2500.0, "nothing typed": 1234.5678, "infinity": math.inf, "f-number": 5.6, "refused": 5.6,
                    "mended": 4.0, "escaped": 0.0, "after": -1.5}


def test_a_ring_can_be_turned_by_keys_alone():
    dials = Dials()
    seen = {}

    def test(ctx):
        ctx.key_press(imgui.Key.tab)
        ctx.key_press(imgui.Key.tab)
        ctx.yield_(2)
        ctx.key_press(imgui.Key.right_arrow)
        ctx.yield_(2)
        seen["right"] = (dials.focus, dials.aperture)
        ctx.key_press(imgui.Key.left_arrow)
        ctx.key_press(imgui.Key.left_arrow)
        ctx.yield_(2)
        seen["left"] = dials.aperture

    drive(dials.show, test, (270, 230))
    assert seen == {"right": (1200.0, 3.2), "left": 2.5}


@pytest.mark.parametrize("size", [(8, 8), (40, 30), (90, 200), (1200, 200)])
def test_a_ring_lives_in_any_window_and_with_any_value(size):
    dials = Dials(focus=math.inf, aperture=math.nan, exposure=-1e9)
    drive(dials.show, lambda ctx: ctx.yield_(3), size)
