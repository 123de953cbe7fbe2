"""Fog and water before the camera of the bench."""

import shlex
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench.app.bench.build import bench_of, design, medium
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.constraints import with_camera
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from tests.app.command.test_main import LENS, settings_of, viewed  # noqa: F401 - the fixture
from tests.app.conftest import SMALL


@pytest.mark.slow
def test_clear_air_is_nothing_and_fog_takes_contrast_by_its_visibility():
    assert medium(Settings()) is None and camera(SMALL).medium is None
    fog = medium(replace(Settings(), medium="fog", visibility=5000.0, fog_light=0.7))
    np.testing.assert_allclose(fog.transmittance(5000.0), 0.02, rtol=1e-12)
    np.testing.assert_allclose(fog.seen(np.zeros(3), 1e9), 0.7, rtol=1e-12)


def test_a_lens_in_the_water_has_no_window_and_one_behind_a_window_is_the_lens_in_air():
    water = replace(SMALL, medium="water", visibility=8000.0)
    assert design(water) == design(SMALL) and camera(water).medium.index == pytest.approx(1.333)
    assert design(replace(water, immersed=True)).front_index == pytest.approx(1.333)


def test_the_read_outs_of_an_immersed_lens_are_those_of_the_stop_in_the_picture():
    immersed = replace(SMALL, medium="water", immersed=True, f_number=2.8)
    assert bench_of(immersed).lens.stop == camera(immersed).lens.stop
    assert bench_of(immersed).reason == "" and readings(immersed).f_number == pytest.approx(2.8, rel=1e-9)
    assert readings(immersed).widest_f_number == readings(SMALL).widest_f_number


def test_a_panorama_leaves_the_water():
    assert with_camera(replace(SMALL, medium="water"), "environment").medium == "air"
    assert with_camera(replace(SMALL, medium="fog"), "environment").medium == "fog"


def test_options_arrive_and_what_cannot_be_is_said(viewed, capsys):  # noqa: F811
    from lensbench.app.command.main import main

    settings = settings_of(viewed, LENS, *shlex.split("--medium fog --visibility 3m --fog-light 0.4"))
    assert (settings.medium, settings.visibility, settings.fog_light) == ("fog", 3000.0, 0.4)
    with pytest.raises(SettingsError, match="visibility 0"):
        replace(settings, visibility=0.0).checked()
    assert main(["render", LENS, "--medium", "water", "--visibility", "90m", "-o", "a.png"]) == 2
    assert "in pure water one sees 69 m" in capsys.readouterr().err


@pytest.mark.slow
def test_fog_is_made_by_hand(drive):
    def use(hand):
        hand.picture()
        clear = hand.session.presenter.update.image
        hand.ctx.item_click("**/###Drawer Air")
        hand.ctx.item_click("//$FOCUSED/Medium fog")
        hand.picture()
        assert hand.settings == replace(SMALL, medium="fog")
        foggy = hand.session.presenter.update.image
        assert foggy.std() < clear.std()                # the far fades
        hand.drag(hand.at("**/Visibility", 0.5, 0.5), hand.at("**/Visibility", 0.2, 0.5))
        hand.picture()
        assert hand.settings.visibility < 10_000.0
        hand.press(imgui.Key.escape)
        assert isinstance(camera(hand.settings).medium, lb.Medium)

    assert drive(use).view.messages == []
