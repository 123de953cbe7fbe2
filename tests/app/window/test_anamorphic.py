"""A lens with cylinders in the bench: opened from a file, focused, stopped down; and every panel says what it means."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera, readings, unfit
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.bench.readouts import dark_corners
from lensbench.app.command.main import main
from lensbench.app.panels.exit_pupil import UPWARDS
from lensbench.app.panels.falloff import EVERY_WAY
from lensbench.app.panels.lens_section.handles import SIDE, TOP
from lensbench.app.panels.readouts import Status, rows
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.window.palette import answers
from tests.app.conftest import SMALL

NAME = "lentil-schneider-anamorphic-31-2001"
NEAR = replace(Settings(), lens=NAME, focus_distance=3000.0)


def said(settings):
    return {row.name: row for row in rows(settings, readings(settings), Status())}


def test_the_read_outs_tell_both_sections():
    table = said(NEAR)
    assert (table["Focal length"].value, table["Focal length across"].value) == ("60.6", "31.5")
    stand = bench_of(NEAR)
    foci = lb.section_foci(stand.lens, 3000.0, stand.film_distance)
    across, up = (focus - stand.film_distance for focus in foci)
    assert table["Foci across, up"].value == f"−{abs(across):.2f} +{up:.2f}" and across < 0.0 < up
    assert "0.52 times as wide" in table["Focal length across"].meaning
    # The field across is that of the focal length across
    assert readings(NEAR).fov_horizontal == pytest.approx(2.0 * math.atan(18.0 / readings(NEAR).across))
    assert "Focal length across" not in said(Settings())


@pytest.mark.slow
def test_what_ends_the_light_is_told_along_the_film_s_diagonal():
    stand = bench_of(NEAR)
    share = float(dark_corners(NEAR).split(" at ")[1].split(" %")[0]) / 100.0
    for factor, dark in ((0.985, False), (1.015, True)):            # it is told to a hundredth
        film_point = factor * share * np.array([18.0, 12.0])
        assert (len(lb.open_region(stand.lens, stand.film_distance, film_point)) == 0) == dark
    assert dark_corners(replace(NEAR, crop=0.5)) == ""


def test_info_tells_both_sections(capsys):
    assert main(["info", NAME]) == 0
    told = capsys.readouterr().out
    assert "60.555 mm\n  across, in the section x–z                  31.488 mm" in told and "43.1° × 17.5°" in told
    assert main(["info", "pbrt-dgauss-50mm"]) == 0
    assert "across" not in capsys.readouterr().out


@pytest.mark.slow
def test_a_file_with_cylinders_is_opened_and_turned_by_hand(drive, tmp_path, monkeypatch):
    path, words = tmp_path / "squeeze.zmx", []
    lenses.save(replace(lenses.load(NAME), name="Squeeze"), path)
    colour, dim, add = imgui.text_colored, imgui.text_disabled, imgui.ImDrawList.add_text
    monkeypatch.setattr(imgui, "text_colored", lambda tint, text: words.append(text) or colour(tint, text))
    monkeypatch.setattr(imgui, "text_disabled", lambda text: words.append(text) or dim(text))
    monkeypatch.setattr(imgui.ImDrawList, "add_text",
                        lambda draw, *arguments: words.append(arguments[-1]) or add(draw, *arguments))

    def use(hand):
        hand.picture()
        assert UPWARDS not in words and not any(str(word).endswith(SIDE) for word in words)
        hand.session.dropped(None, [str(path)])
        hand.picture()
        assert hand.settings.lens == str(path)
        words.clear()
        hand.ctx.yield_(3)
        assert {UPWARDS, "Focal length across", "Foci across, up"} <= set(words)
        assert any(str(word).endswith(SIDE) for word in words)
        hand.ctx.item_click("**/Section side")
        hand.ctx.yield_(3)
        assert hand.session.panels.kept.section.above and any(str(word).endswith(TOP) for word in words)
        hand.ctx.item_click("**/Section side")
        hand.ctx.window_focus("//Falloff")
        hand.ctx.yield_(3)
        assert EVERY_WAY in words
        hand.ctx.window_focus("//Exit pupil")

        # The rings turn it, and the picture follows; the film can be drawn away from the lens
        squeezed = hand.session.worker.newest().image.copy()
        hand.drag(hand.at("**/Focus distance", 0.9, 0.5), hand.at("**/Focus distance", 0.5, 0.5), steps=3)
        assert 300.0 < hand.settings.focus_distance < 20000.0
        hand.drag(hand.at("**/Aperture", 0.3, 0.5), hand.at("**/Aperture", 0.7, 0.5), steps=3)
        assert hand.settings.f_number > 4.0
        hand.picture()
        assert np.abs(hand.session.worker.newest().image - squeezed).max() > 0.05
        before = hand.settings.focus_distance
        middle = hand.at("**/Film plane", 0.5, 0.5)
        hand.drag(middle, imgui.ImVec2(middle.x + 3.0, middle.y))
        assert hand.settings.focus_distance < before
        hand.drag(hand.at("**/Film radius", 0.69, 0.5), hand.at("**/Film radius", 0.3, 0.5))

    drive(use, replace(SMALL, samples=2, focus_distance=math.inf))


@pytest.mark.parametrize("model", LENS_MODELS)
def test_a_model_is_unfit_where_no_camera_can_be_made_with_it(model):
    try:
        camera(replace(NEAR, lens_model=model))
        made = True
    except lb.CameraError:
        made = False
    assert bool(unfit(NEAR, model)) is not made and unfit(Settings(), model) == ""
    assert with_lens(replace(Settings(), lens_model=model), NAME).lens_model == (model if made else "auto")


@pytest.mark.slow
def test_models_that_the_lens_cannot_have_are_not_offered(drive):
    """The list offered a pinhole, thin and thick lens and a polynomial; each was refused when it was chosen."""
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Camera")
        hand.ctx.item_click("//##Combo_00/Pinhole")
        hand.ctx.yield_(3)
        assert hand.settings.lens_model == "auto" and "cylinder or toroid" in unfit(hand.settings, "pinhole")
        hand.ctx.item_click("//##Combo_00/Full lens trace")
        hand.ctx.yield_(3)
        assert hand.settings.lens_model == "trace"
        assert not any("Pinhole" in entry.text for entry in answers("lens model pinhole", hand.session)[:1])

    assert drive(use, replace(SMALL, lens=NAME, f_number=None, focus_distance=3000.0)).view.messages == []
