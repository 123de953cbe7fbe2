"""The modes P, A and S: what the meter chooses exposes the picture as it would have it, within the camera's range."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.exposure import NARROWEST, TIMES, Metering, meter_stops, metered, mode_of, with_mode
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

START = with_mode(replace(Settings(), f_number=5.6, shutter=1.0 / 60.0), "M")
GREY = np.full((8, 8, 3), 0.3, np.float32)


def lux_seconds(settings):
    return lb.Exposure(readings(settings).working_f_number, settings.shutter, settings.iso).lux_seconds


@pytest.mark.parametrize("mode", ["P", "A", "S"])
def test_a_mode_reaches_the_exposure_of_iso_12232(mode):
    taken = metered(START, GREY, mode)
    # 10 / ISO lux seconds for the mean; the working f-number moves by hundredths of a stop against the engraved one
    assert math.log2(0.3 * lux_seconds(taken) / (10.0 / taken.iso)) == pytest.approx(0.0, abs=0.03)
    assert abs(meter_stops(taken, GREY)) < 0.03
    assert metered(taken, GREY, mode) == taken                  # and stays there
    assert (taken.f_number == START.f_number) is (mode == "A")
    assert (taken.shutter == START.shutter) is (mode == "S")


def test_the_meter_ends_at_the_range_of_lens_and_shutter():
    dark, bright = GREY * 1e-6, GREY * 1e6
    assert metered(START, dark, "S").f_number is None           # wide open
    assert metered(START, bright, "S").f_number == NARROWEST
    assert metered(START, dark, "A").shutter == TIMES.high
    assert metered(START, bright, "A").shutter == TIMES.low
    opened = metered(START, GREY / 256.0, "P")                  # what the stop cannot give the time gives
    assert opened.f_number is None and abs(meter_stops(opened, GREY / 256.0)) < 0.05


def test_the_time_alone_follows_where_no_f_number_can_be_set():
    settings = with_mode(of_kind(START, "finite-pinhole"), "M")
    for mode in ("P", "A"):
        taken = metered(settings, GREY, mode)
        assert taken == replace(settings, shutter=taken.shutter) and abs(meter_stops(taken, GREY)) < 0.03
    assert metered(settings, GREY, "S") == settings


def test_the_correction_is_over_the_choice_of_the_meter():
    corrected = replace(START, exposure=2.0)
    assert metered(corrected, GREY, "A") == replace(metered(START, GREY, "A"), exposure=2.0)
    assert meter_stops(metered(corrected, GREY, "A"), GREY) == pytest.approx(2.0, abs=0.03)


def test_modes_and_settings_name_each_other():
    for mode in ("off", "M", "I"):
        assert mode_of(with_mode(Settings(), mode), "") == mode
    for mode in ("P", "A", "S"):
        assert mode_of(with_mode(Settings(), mode), mode) == mode
    assert mode_of(Settings(), "A") == "off"


@pytest.mark.parametrize("mode", ["P", "S"])
def test_the_noise_of_the_first_samples_does_not_keep_the_meter_going(mode):
    """Each choice of an f-number starts the picture anew, and few samples have brighter highlights than many."""
    rng = np.random.default_rng(7)
    pictures = {n: (0.2 * rng.gamma(0.05 * n, 1.0 / (0.05 * n), (128, 128, 1)) * np.ones(3)).astype(np.float32)
                for n in (1, 2, 4, 8, 16, 64, 256)}
    settings, meter, starts = replace(START, metering="highlights"), Metering(), 0
    samples = iter(pictures)
    while (n := next(samples, None)) is not None:
        chosen = meter.chosen(settings, pictures[n], n, mode)
        if chosen.f_number != settings.f_number:
            settings, starts, samples = chosen, starts + 1, iter(pictures)
            assert starts <= len(pictures)
    assert starts >= 2                                          # the highlights of one sample are those of noise
    assert abs(meter_stops(settings, pictures[256])) <= 1.0 / 6.0


@pytest.mark.slow
def test_a_mode_can_be_chosen_again_after_a_change_in_m(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/Mode P")
        hand.picture()
        hand.ctx.item_click("**/Mode M")
        hand.picture()
        hand.session.take(replace(hand.settings, f_number=11.0))
        hand.picture()
        hand.ctx.item_click("**/Mode P")
        hand.picture()
        assert mode_of(hand.settings, hand.session.view.program) == "P"
        assert hand.settings.f_number != 11.0

    drive(use, replace(SMALL, samples=4))


@pytest.mark.slow
def test_the_strip_sets_the_camera_and_a_hand_on_what_the_meter_sets_leads_to_m(drive):
    def use(hand):
        view, presenter = hand.session.view, hand.session.presenter
        hand.picture()
        hand.ctx.item_click("**/Mode S")
        hand.picture()
        assert view.program == "S" and abs(presenter.off_meter(hand.settings)) < 0.3
        assert hand.settings.f_number != SMALL.f_number and hand.settings.shutter == SMALL.shutter
        before = hand.settings.f_number or readings(hand.settings).widest_f_number
        hand.ctx.mouse_move_to_pos(hand.at("**/###Strip Time", 0.5, 0.5))
        hand.ctx.mouse_wheel_y(3.0)                             # a stop shorter
        hand.picture()
        after = hand.settings.f_number or readings(hand.settings).widest_f_number
        assert hand.settings.shutter < SMALL.shutter and after < before
        hand.drag(hand.at("//Controls/**/Aperture", 0.6, 0.5), hand.at("//Controls/**/Aperture", 0.8, 0.5))
        hand.picture()
        assert view.program == "" and hand.settings.exposing == "triangle" and hand.settings.f_number > 8.0
        hand.ctx.item_click("**/###Strip ISO")
        hand.ctx.yield_(2)
        hand.drag(hand.at("**/ISO", 0.2, 0.5), hand.at("**/ISO", 0.5, 0.5))
        assert hand.settings.iso > 200.0
        hand.press(imgui.Key.escape)
        hand.ctx.item_click("**/Mode off")
        hand.ctx.yield_(2)
        assert hand.settings.exposing == "plain"

    assert drive(use).view.messages == []
