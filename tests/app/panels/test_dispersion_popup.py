"""The choice of dispersion: what it does to the picture, where it can be made, and what is said where it cannot."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.constraints import constrained
from lensbench.app.bench.readouts import colours
from lensbench.app.command.main import main
from lensbench.app.panels.readouts import NONE, Status, rows
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from tests.app.command.test_main import settings_of, viewed  # noqa: F401 - the fixture
from tests.app.conftest import SMALL

NAMED = replace(SMALL, lens="lenshh-cooke-triplet-50", f_number=None, scene="grid-wall", samples=3)     # SK16 and F2
NAMELESS = replace(NAMED, lens="pbrt-dgauss-50mm")                          # of whose glasses n_d alone is known


def said(settings):
    return {row.name: row for row in rows(settings, readings(settings), Status())}["Colours"]


def picture(settings):
    return lb.render(camera(settings), lb.builtin_scene(settings.scene), samples=3)


def test_off_is_the_picture_of_the_d_line_and_on_that_of_all_wavelengths():
    off, on, auto = (picture(replace(NAMED, dispersion=choice)) for choice in ("off", "on", "auto"))
    grey = [np.abs(image[..., 0] / image[..., 1] - image.mean((0, 1))[0] / image.mean((0, 1))[1]).max()
            for image in (off, on)]
    assert np.array_equal(on, auto) and not np.array_equal(on, off)
    assert grey[1] > 3.0 * grey[0]                      # lines of a grey wall have coloured edges
    assert not camera(replace(NAMED, dispersion="off")).disperses


def test_the_read_out_says_what_is_used_and_why(tmp_path):
    assert (said(NAMED).value, said(replace(NAMED, dispersion="off")).value) == ("24 wavelengths", "d line")
    assert "turned off" in said(replace(NAMED, dispersion="off")).meaning
    assert said(NAMELESS).value == "d line" and "no dispersion data" in said(NAMELESS).meaning
    assert "ideal" in said(replace(NAMED, lens_model="thin")).meaning
    assert said(replace(NAMED, camera="perspective")).value == NONE
    assert "no library lens" in said(replace(NAMED, lens="nothing")).meaning
    lens = lenses.load(NAMED.lens)
    glass = replace(lens.surfaces[0].glass, name="NARROW", wavelengths=(0.5, 0.7))
    lenses.save(replace(lens, surfaces=(replace(lens.surfaces[0], glass=glass), *lens.surfaces[1:])),
                tmp_path / "narrow.toml")
    narrow = replace(NAMED, lens=str(tmp_path / "narrow.toml"))
    assert said(narrow).value == "d line" and "NARROW is known from 0.5 to 0.7 µm" in said(narrow).meaning
    assert not camera(narrow).disperses


def test_a_lens_that_cannot_disperse_turns_on_back_to_auto_and_keeps_off():
    assert constrained(replace(NAMELESS, dispersion="on")).dispersion == "auto"
    assert constrained(replace(NAMELESS, dispersion="off")).dispersion == "off"
    assert constrained(replace(NAMED, dispersion="on")).dispersion == "on"


def test_the_choice_is_checked_kept_and_changes_of_a_paraxial_focus_its_contrast_alone():
    with pytest.raises(SettingsError, match="dispersion 'some'"):
        replace(NAMED, dispersion="some").checked()
    assert Settings.from_dict(replace(NAMED, dispersion="off").to_dict()).dispersion == "off"
    paraxial = replace(NAMED, focus_position="paraxial")
    off, on = readings(replace(paraxial, dispersion="off")), readings(paraxial)
    assert off.focusing.contrasts != on.focusing.contrasts and off == replace(on, focusing=off.focusing)


def test_on_the_command_line(viewed, capsys, tmp_path):  # noqa: F811
    assert settings_of(viewed, NAMED.lens, "--dispersion", "off").dispersion == "off"
    assert settings_of(viewed, NAMED.lens, "--dispersion", "on").dispersion == "on"
    assert main(["render", NAMELESS.lens, "--dispersion", "on", "--size", "8x8", "-o", str(tmp_path / "a.png")]) == 2
    error = capsys.readouterr().err
    assert "no dispersion data" in error and error.count("\n") == 1 and not (tmp_path / "a.png").exists()


@pytest.mark.slow
def test_by_hand(drive, tmp_path):
    def test(hand):
        hand.picture()
        assert colours(hand.settings).used
        hand.ctx.item_click("**/###Drawer Colour")
        hand.ctx.item_click("**/Off")
        hand.picture()
        assert hand.settings.dispersion == "off"
        hand.photograph(tmp_path / "popup.png")
    drive(test, NAMED)

    def without(hand):
        hand.picture()
        assert not hand.ctx.item_exists("**/###Drawer Colour")
    drive(without, NAMELESS)
