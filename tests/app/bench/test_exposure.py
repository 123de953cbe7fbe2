"""The exposure triangle and the sensor in the bench: the laws of the light, and what hands and options do."""

import math
import shlex
from dataclasses import replace

import numpy as np
import OpenEXR
import pytest
from imgui_bundle import imgui
from PIL import Image

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.exposure import applied_exposure, exposed, exposure_text, look
from lensbench.app.session.export import save_picture
from lensbench.app.settings.dial_scales import ISOS, iso_scale
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_iso, read_electrons, read_iso
from tests.app.command.test_main import LENS, settings_of, viewed  # noqa: F401 - the fixture

TRIANGLE = replace(Settings(), exposing="triangle", focus_distance=math.inf)
PICTURE = np.random.default_rng(2).gamma(0.5, 1.0, (64, 96, 3)).astype(np.float32)


def gain(settings):
    return applied_exposure(settings, PICTURE).gain


def test_as_it_is_nothing_is_done_to_the_light():
    assert exposed(Settings(), PICTURE) is PICTURE
    assert look(Settings()) == look(replace(Settings(), shutter=3.0, iso=800.0, f_number=8.0))


def test_time_iso_and_the_square_of_the_stop_brighten_alike():
    here = gain(TRIANGLE)
    assert gain(replace(TRIANGLE, shutter=2.0 * TRIANGLE.shutter)) == pytest.approx(2.0 * here, rel=1e-12)
    assert gain(replace(TRIANGLE, iso=2.0 * TRIANGLE.iso)) == pytest.approx(2.0 * here, rel=1e-12)
    wide, slow = replace(TRIANGLE, f_number=4.0), replace(TRIANGLE, f_number=8.0)
    # the working f-number is that of the real marginal ray, whose aberrations at f/4 are a few per mille
    assert gain(wide) == pytest.approx(4.0 * gain(slow), rel=0.02)
    np.testing.assert_allclose(exposed(TRIANGLE, PICTURE), PICTURE * here, rtol=1e-6)


def test_automatic_iso_exposes_a_meters_grey_and_says_the_iso_that_does():
    automatic = replace(TRIANGLE, exposing="automatic")
    out = exposed(automatic, PICTURE)
    assert lb.metered_stops(out) == pytest.approx(0.0, abs=1e-5)
    iso = applied_exposure(automatic, PICTURE).iso
    np.testing.assert_allclose(exposed(replace(TRIANGLE, iso=iso), PICTURE), out, rtol=1e-5)
    bright = replace(automatic, metering="highlights")
    peak = exposed(bright, PICTURE).max(-1)
    assert np.mean(peak > 1.0) <= 0.001 and peak.max() >= 1.0


@pytest.mark.parametrize("change", [
    {}, {"shutter_ramp": 0.5}, {"shutter_ramp": 0.2, "shutter": 1.0 / 30.0}, {"medium": "water"},
    {"medium": "water", "immersed": True, "shutter_ramp": 0.3}], ids=["", "ramps", "slower", "window", "immersed"])
def test_the_triangle_gives_the_film_the_light_of_physical_weights(change):
    """On the axis, of radiance 1 or 1000 cd/m²: behind a window, in water, with a shutter that takes time to open."""
    settings = replace(TRIANGLE, focus_distance=1500.0, f_number=4.0, **change)
    view = replace(camera(settings), weights="physical")
    n = 4096
    k = np.arange(n)
    rays = view.generate_rays(np.tile([settings.pixels_x / 2.0, settings.pixels_y / 2.0], (n, 1)),
                              np.stack([(k + 0.5) / n, k * 0.6180339887 % 1.0], 1))
    lux_seconds = 1000.0 * rays.weights.mean()
    assert gain(settings) == pytest.approx(lux_seconds * settings.iso / 78.0, rel=2e-3)
    applied = applied_exposure(settings, PICTURE)
    assert applied.share * applied.triangle.lux_seconds == pytest.approx(lux_seconds, rel=2e-3)
    automatic = applied_exposure(replace(settings, exposing="automatic"), PICTURE)
    assert automatic.gain == pytest.approx(lux_seconds * automatic.iso / 78.0, rel=2e-3)
    assert look(settings) != look(replace(settings, shutter_ramp=0.1))


def test_the_noise_of_an_even_light_is_that_of_its_photons():
    settings = replace(Settings(), noise=True, full_well=10_000.0, read_noise=0.0, bits=16)
    grey = np.full((200, 200, 3), 0.25, np.float32)
    electrons = exposed(settings, grey).astype(float) * 10_000.0
    # 120,000 numbers: the mean to 0.15 electrons, the variance to 0.4 %
    assert electrons.mean() == pytest.approx(2500.0, abs=1.0)
    assert electrons.var() == pytest.approx(2500.0, rel=0.02)
    assert exposed(settings, np.full((4, 4, 3), 9.0, np.float32)).max() == pytest.approx(1.0)
    assert not np.array_equal(exposed(replace(settings, seed=1), grey), exposed(settings, grey))


def test_a_png_is_exposed_and_an_exr_holds_the_light(tmp_path):
    settings = replace(TRIANGLE, tone="none", shutter=TRIANGLE.shutter / 4.0)
    for name in ("a.png", "a.exr"):
        save_picture(tmp_path / name, PICTURE, settings)
    np.testing.assert_array_equal(OpenEXR.File(str(tmp_path / "a.exr")).channels()["RGB"].pixels, PICTURE)
    with Image.open(tmp_path / "a.png") as read:
        shown = np.asarray(read, float)
    save_picture(tmp_path / "b.png", PICTURE * np.float32(gain(settings)), settings.plain("exposing"))
    with Image.open(tmp_path / "b.png") as read:
        np.testing.assert_array_equal(shown, np.asarray(read, float))


def test_what_the_triangle_comes_to_is_told():
    text = exposure_text(applied_exposure(replace(TRIANGLE, f_number=4.0, shutter=1.0 / 60.0, iso=200.0), PICTURE))
    assert "EV 9.9" in text and "ISO 100 8.9" in text and "lx s" in text
    assert "no exposure value" in exposure_text(applied_exposure(replace(TRIANGLE, camera="environment"), PICTURE))


def test_isos_are_third_stops_and_read_as_written():
    for k, iso in enumerate(ISOS):
        # engraved figures are round, none off by half the way to its neighbour
        assert abs(math.log2(iso / 25.0) - k / 3.0) < 1.0 / 6.0
        assert read_iso(format_iso(iso)) == iso
    assert iso_scale().stepped(100.0, 3) == 200.0
    assert read_electrons("50k") == 50_000.0 and read_electrons("3 e") == 3.0


def test_options_arrive(viewed):  # noqa: F811
    settings = settings_of(viewed, LENS, *shlex.split(
        "--exposing triangle --iso 400 --shutter 1/30 --noise --full-well 20k --quantum-efficiency 60% "
        "--read-noise 2.5 --sensor-bits 12 --blades 7 --roundness 30% --blade-rotation 10"))
    assert (settings.exposing, settings.iso, settings.noise, settings.bits) == ("triangle", 400.0, True, 12)
    assert (settings.full_well, settings.quantum_efficiency, settings.read_noise) == (20_000.0, 0.6, 2.5)
    assert (settings.blades, settings.roundness) == (7, 0.3)


@pytest.mark.slow
def test_sensor_and_stop_are_set_by_hand_and_only_the_stop_renders_anew(drive):
    def use(hand):
        hand.picture()
        generation = hand.session.worker.generation
        hand.ctx.item_click("**/Mode M")
        hand.ctx.item_click("**/###Strip ISO")
        hand.ctx.yield_(2)
        hand.drag(hand.at("**/ISO", 0.2, 0.5), hand.at("**/ISO", 0.5, 0.5))
        hand.press(imgui.Key.escape)
        hand.ctx.item_click("**/###Drawer Noise")
        hand.ctx.item_click("//$FOCUSED/Sensor with noise")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/Bits 8")
        hand.ctx.yield_(3)
        settings = hand.settings
        assert settings.iso > 200.0 and settings.noise and settings.bits == 8 and settings.exposing == "triangle"
        presenter = hand.session.presenter
        np.testing.assert_array_equal(presenter.light, exposed(settings, presenter.update.image))
        assert hand.session.worker.generation == generation
        hand.press(imgui.Key.escape)
        hand.ctx.item_click("**/Mode I")
        hand.ctx.yield_(2)
        assert hand.session.presenter.applied_exposure(hand.settings).iso != settings.iso
        hand.ctx.item_click("**/###Drawer Flare")
        hand.ctx.item_click("//$FOCUSED/Blades & coating")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/Blades 6")
        hand.picture()
        assert hand.settings.blades == 6 and hand.session.worker.generation > generation
        hand.ctx.item_click("//$FOCUSED/Blades 0")
        hand.picture()
        assert hand.settings.blades is None         # as the lens was designed
        hand.press(imgui.Key.escape)

    assert drive(use).view.messages == []
