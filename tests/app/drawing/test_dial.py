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
    values = {}

    def test(ctx):
        # A drag from the index line follows the mouse, without a jump at its start
        start = at(ctx, "**/Focus distance", FOCUS, 1200.0)
        end = at(ctx, "**/Focus distance", FOCUS, 3000.0)
        ctx.mouse_move_to_pos(start)
        ctx.mouse_down(0)
        ctx.yield_(2)
        values["pressed"] = dials.focus
        ctx.mouse_move_to_pos(end)
        ctx.mouse_up(0)
        ctx.yield_(2)
        values["dragged"] = dials.focus
        # Beyond the right end it is infinity
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos(ImVec2(end.x + 500.0, end.y))
        ctx.mouse_up(0)
        ctx.yield_(2)
        values["beyond"] = dials.focus

        # A click goes to the nearest third stop, a drag to anything
        point = at(ctx, "**/Aperture", APERTURE, 7.9)
        ctx.mouse_move_to_pos(point)
        ctx.mouse_click(0)
        ctx.yield_(2)
        values["clicked"] = dials.aperture
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 8.0))
        ctx.mouse_wheel(ImVec2(0.0, 1.0))
        ctx.yield_(2)
        values["wheel"] = dials.aperture
        ctx.yield_(40)                                  # so that the next click makes no double click
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 9.0))
        ctx.mouse_down(0)
        ctx.mouse_move_to_pos(at(ctx, "**/Aperture", APERTURE, 13.5))
        ctx.mouse_up(0)
        ctx.yield_(2)
        values["between"] = dials.aperture
        ctx.mouse_double_click(0)
        ctx.yield_(2)
        values["reset"] = dials.aperture

    drive(dials.show, test, (270, 230))
    assert values["pressed"] == 1200.0
    # The mouse stands on whole pixels: one of 228 is .0044 of the dial
    assert FOCUS.to_unit(values["dragged"]) == pytest.approx(FOCUS.to_unit(3000.0), abs=0.009)
    assert values["beyond"] == math.inf
    assert values["clicked"] == 8.0 and values["wheel"] == 9.0
    assert values["between"] not in APERTURE.snaps
    assert APERTURE.to_unit(values["between"]) == pytest.approx(APERTURE.to_unit(13.5), abs=0.009)
    assert values["reset"] == 2.8


def test_a_ring_takes_typed_values_and_says_why_it_refuses_others():
    dials = Dials()
    values = {}

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
        values["typed"] = dials.focus
        dials.focus = 1234.5678                         # shown as 1.23 m
        ctx.key_down(imgui.Key.mod_ctrl)
        ctx.mouse_click(0)
        ctx.key_up(imgui.Key.mod_ctrl)
        ctx.yield_(3)
        ctx.key_press(imgui.Key.enter)
        ctx.yield_(3)
        values["nothing typed"] = dials.focus
        type_into(ctx, "**/Focus distance", "inf")
        values["infinity"] = dials.focus
        type_into(ctx, "**/Aperture", "f/5.6")
        values["f-number"] = dials.aperture
        # What cannot be is refused, the entry stays open, and Escape leaves the dial as it was
        type_into(ctx, "**/Aperture", "f/1.0")
        values["refused"] = dials.aperture
        ctx.key_chars_replace_enter("4")
        ctx.yield_(2)
        values["corrected"] = dials.aperture
        type_into(ctx, "**/Exposure", "lots")
        ctx.key_press(imgui.Key.escape)
        ctx.yield_(2)
        values["escaped"] = dials.exposure
        type_into(ctx, "**/Exposure", "-1.5 EV")
        values["after"] = dials.exposure

    drive(dials.show, test, (270, 230))
    assert values == {"typed": 2500.0, "nothing typed": 1234.5678, "infinity": math.inf, "f-number": 5.6,
                      "refused": 5.6, "corrected": 4.0, "escaped": 0.0, "after": -1.5}


def test_a_ring_can_be_turned_by_keys_alone():
    dials = Dials()
    values = {}

    def test(ctx):
        ctx.key_press(imgui.Key.tab)
        ctx.key_press(imgui.Key.tab)
        ctx.yield_(2)
        ctx.key_press(imgui.Key.right_arrow)
        ctx.yield_(2)
        values["right"] = (dials.focus, dials.aperture)
        ctx.key_press(imgui.Key.left_arrow)
        ctx.key_press(imgui.Key.left_arrow)
        ctx.yield_(2)
        values["left"] = dials.aperture

    drive(dials.show, test, (270, 230))
    assert values == {"right": (1200.0, 3.2), "left": 2.5}


@pytest.mark.parametrize("size", [(8, 8), (40, 30), (90, 200), (1200, 200)])
def test_a_ring_lives_in_any_window_and_with_any_value(size):
    dials = Dials(focus=math.inf, aperture=math.nan, exposure=-1e9)
    drive(dials.show, lambda ctx: ctx.yield_(3), size)
