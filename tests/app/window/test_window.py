"""The whole window on no display: each control by a real mouse, files, undo, and what must never end it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import hello_imgui, imgui
from PIL import Image

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.framing import with_scene
from lensbench.app.drawing.controls import chord
from lensbench.app.panels.image import camera_strip
from lensbench.app.panels.lens_section import panel as section_panel
from lensbench.app.settings.camera_facts import CAMERA_KINDS, LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.app.window import window
from lensbench.core.kernels.cache import NotCompiledError
from lensbench.lenses.library import catalogue
from tests.app.conftest import SMALL

CTRL, SHIFT = imgui.Key.mod_ctrl, imgui.Key.mod_shift


@pytest.mark.slow
@pytest.mark.parametrize(("dial", "field"), [
    ("Focus distance", "focus_distance"), ("Aperture", "f_number"), ("Field of view", "crop"),
    ("Focal length", "focal_length"), ("Exposure", "exposure"),
])
def test_a_drag_turns_a_dial_and_is_one_step_of_undo(drive, dial, field):
    def use(hand):
        item = f"**/{dial}"
        hand.picture()
        before = hand.settings
        hand.drag(hand.at(item, 0.55, 0.5), hand.at(item, 0.7, 0.5), steps=8)
        after = hand.settings
        assert getattr(after, field) != getattr(before, field)
        hand.picture()
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == before
        hand.press(chord(CTRL, SHIFT, imgui.Key.z))
        assert hand.settings == after

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_slower_lens_opens_as_far_as_it_can_and_focuses_as_near_as_it_can(drive):
    def use(hand):
        hand.session.chooser.locked |= {"aperture", "focus"}
        hand.session.dropped(None, [str(catalogue.path_of("lib-goerz-dagor"))])
        hand.ctx.yield_(3)
        hand.picture()
        assert hand.settings.f_number is None
        nearest = lb.nearest_focus(lenses.load("lib-goerz-dagor"))
        assert math.isclose(hand.settings.focus_distance, nearest, rel_tol=1e-3)

    drive(use, replace(SMALL, focus_distance=700.0))


@pytest.mark.slow
def test_every_model_and_film_can_be_chosen(drive):
    def use(hand):
        for name, model in LENS_MODELS.items():
            hand.ctx.item_click("//Controls/##Camera")
            hand.ctx.item_click(f"//##Combo_00/{model.title}")
            hand.picture()
            assert hand.settings.lens_model == name
        for name, kind in CAMERA_KINDS.items():
            if kind.has_lens:
                continue
            hand.ctx.item_click("//Controls/##Camera")
            hand.ctx.item_click(f"//##Combo_00/{kind.title}")
            hand.picture()
            assert hand.settings.camera == name
        for name, size in lb.FORMATS.items():
            hand.ctx.item_click("//Controls/##Film")
            hand.ctx.item_click("//##Combo_00/" + name.replace("/", "\\/"))
            hand.ctx.yield_(2)
            assert (hand.settings.film_width, hand.settings.film_height) == size
        hand.ctx.item_click("//Controls/##Film")
        hand.ctx.item_click("//##Combo_00/6 × 6 cm 56 × 56")
        hand.picture()
        assert hand.settings.film_width == hand.settings.film_height == 56.0
        assert hand.settings.pixels_x == hand.settings.pixels_y == 120

    assert drive(use).view.messages == []


def test_a_click_focuses_on_what_is_under_it(drive):
    def use(hand):
        hand.picture()
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.5, 0.6))
        hand.ctx.yield_(2)
        hand.ctx.mouse_click(0)
        hand.wait(lambda: hand.settings.focus_distance != 2000.0, "the focus")
        hand.picture()
        depth = hand.session.worker.newest().depth
        assert np.nanmin(np.abs(depth - hand.settings.focus_distance)) < 1.0      # the lens breathes a little
        assert hand.session.view.mark.distance == hand.settings.focus_distance
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings.focus_distance == 2000.0

    drive(use, replace(SMALL, focus_distance=2000.0))


@pytest.mark.slow
def test_drags_orbit_and_pan_and_the_wheel_dollies_and_none_of_them_focuses(drive):
    def use(hand):
        hand.picture()
        start, end = hand.at("**/Picture", 0.5, 0.5), hand.at("**/Picture", 0.6, 0.5)
        hand.drag(start, end)
        orbited = hand.settings
        pivot = np.array([0.0, 0.0, -SMALL.focus_distance])
        assert orbited.yaw < 0.0 and orbited.focus_distance == SMALL.focus_distance
        assert math.isclose(np.linalg.norm(pivot - orbited.position), SMALL.focus_distance, rel_tol=1e-9)
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == SMALL

        hand.drag(start, end, button=1)
        assert hand.settings.position[0] < 0.0 == hand.settings.position[2] and hand.settings.yaw == 0.0
        hand.press(chord(CTRL, imgui.Key.z))
        hand.ctx.mouse_move_to_pos(start)
        hand.ctx.mouse_wheel_y(1.0)
        hand.ctx.yield_(2)
        assert hand.settings.position[2] < 0.0
        hand.picture()

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_the_tools_of_the_picture(drive):
    def use(hand):
        hand.picture()
        for tool, overlay in (("Focus peaking", "peaking"), ("CoC overlay", "coc"), ("Plane of focus", "plane"),
                              ("Clipping", "clipping")):
            hand.ctx.item_click(f"**/{tool}")
            hand.ctx.yield_(3)
            assert hand.settings.overlay == overlay
        hand.ctx.item_click("**/Clipping")
        hand.ctx.item_click("**/Histogram")
        hand.ctx.yield_(3)
        assert hand.settings.overlay == "none" and hand.session.view.histogram
        hand.ctx.item_click("**/100 %")
        hand.ctx.yield_(2)
        assert hand.session.view.scale == 1.0
        hand.ctx.item_click("**/Fit")
        hand.ctx.item_click("**/Pause")
        hand.ctx.yield_(2)
        assert hand.session.worker.paused
        hand.press(imgui.Key.space)
        assert not hand.session.worker.paused
        generation = hand.session.worker.generation
        hand.ctx.item_click("**/Restart")
        hand.ctx.yield_(2)
        assert hand.session.worker.generation == generation + 1
        hand.ctx.item_click("**/Picture size")
        hand.ctx.item_click("//$FOCUSED/agx")
        hand.ctx.item_click("//$FOCUSED/64")
        hand.ctx.yield_(2)
        assert (hand.settings.tone, hand.settings.samples) == ("agx", 64)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_menus_undo_redo_theme_and_panels(drive):
    def use(hand):
        hand.picture()
        hand.drag(hand.at("**/Exposure", 0.5, 0.5), hand.at("**/Exposure", 0.7, 0.5))
        after = hand.settings
        hand.ctx.menu_click("//##MainMenuBar/Edit/Undo")
        hand.ctx.yield_(2)
        assert hand.settings == SMALL
        hand.ctx.menu_click("//##MainMenuBar/Edit/Redo")
        hand.ctx.yield_(2)
        assert hand.settings == after
        hand.ctx.menu_click("//##MainMenuBar/Edit/Reset all")
        hand.ctx.yield_(2)
        fresh = replace(Settings(), pixels_x=hand.settings.pixels_x, pixels_y=hand.settings.pixels_y)
        assert hand.settings == with_scene(fresh, fresh.scene)
        hand.ctx.menu_click("//##MainMenuBar/View/Theme/Light theme")
        hand.ctx.yield_(2)
        assert not hand.session.dark
        hand.ctx.menu_click("//##MainMenuBar/View/Panels/Section")
        hand.ctx.yield_(2)
        docking = hello_imgui.get_runner_params().docking_params       # a new layout makes the list of panels anew
        assert not docking.dockable_window_of_name("Section").is_visible
        hand.ctx.menu_click("//##MainMenuBar/View/Reset layout")
        hand.wait(lambda: docking.dockable_window_of_name("Section").is_visible, "the layout")
        hand.press(imgui.Key.f1)
        hand.ctx.yield_(2)
        hand.press(imgui.Key.escape)

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_an_error_in_a_panel_is_shown_and_the_window_lives_on(drive, monkeypatch, capsys):
    def broken(settings, *rest):
        imgui.begin_child("half")
        raise RuntimeError("a panel in pieces")

    def use(hand):
        hand.picture()
        monkeypatch.setattr(section_panel, "lens_section_panel", broken)
        hand.ctx.yield_(5)
        assert hand.session.view.messages == ["Section: RuntimeError: a panel in pieces"]
        monkeypatch.undo()
        hand.picture()
        hand.drag(hand.at("**/Exposure", 0.5, 0.5), hand.at("**/Exposure", 0.7, 0.5))
        assert hand.settings.exposure > 0.0

    drive(use)
    assert capsys.readouterr().err.count("RuntimeError: a panel in pieces") == 1


@pytest.mark.slow
def test_settings_that_cannot_be_rendered_are_said_and_taken_back(drive, tmp_path):
    def use(hand):
        hand.picture()
        session = hand.session
        session.history.edit(replace(SMALL, scene=str(tmp_path / "gone.toml")), False, 0.0)
        hand.wait(lambda: session.view.messages, "the message")
        hand.ctx.yield_(2)
        assert hand.settings == SMALL and "gone" in session.view.messages[0]
        hand.picture()

    drive(use)


def test_a_window_without_room_lives_on(drive):
    def use(hand):
        for size in ((1, 1), (40, 30), (300, 200), (1280, 720)):
            hello_imgui.change_window_size(size)
            hand.ctx.yield_(4)
        hand.picture()

    assert drive(use).view.messages == []


def test_a_screenshot_shows_the_whole_window(tmp_path):
    path = tmp_path / "window.png"
    assert window.run(SMALL, screenshot=path) == 0
    with Image.open(path) as saved:
        picture = np.asarray(saved)
    assert picture.shape == (720, 1280, 3)
    # the render is in colour, the panels around it are grey
    assert np.ptp(picture[60:470, 320:940].astype(int), axis=2).max() > 100
    assert np.ptp(picture[2:18, 400:900].astype(int), axis=2).max() == 0


def test_a_screenshot_before_the_picture_is_ready_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(window, "SCREENSHOT_SECONDS", 0.0)
    path = tmp_path / "window.png"
    assert window.run(SMALL, screenshot=path) == 1
    assert path.exists()


@pytest.mark.slow
def test_a_screenshot_that_cannot_be_written_is_an_error(tmp_path):
    with pytest.raises(OSError, match=r"nowhere.*No such file"):
        window.run(SMALL, screenshot=tmp_path / "nowhere" / "window.png")


@pytest.mark.parametrize("dark", [True, False])
def test_both_themes_are_neutral_around_the_picture(drive, tmp_path, dark):
    def use(hand):
        hand.picture()
        hand.photograph(tmp_path / "window.png")

    drive(use, dark=dark)
    with Image.open(tmp_path / "window.png") as saved:
        picture = np.asarray(saved).astype(int)
    # Corners of menu bar and toolbar, beside the picture, and at the end of the status bar: without text
    for corner in (picture[4, 700], picture[24, 980], picture[300, 285], picture[717, 640]):
        assert np.ptp(corner) == 0 and bool(corner.mean() < 128) is dark


@pytest.mark.slow
def test_the_picture_is_drawn_while_the_kernels_of_the_camera_strip_are_compiled(drive, monkeypatch, tmp_path, capfd):
    def refused(_settings):
        raise NotCompiledError

    def use(hand):
        monkeypatch.setattr(camera_strip, "readings", refused)
        hand.ctx.yield_(3)
        hand.wait(lambda: hand.session.presenter.update is not None, "the picture")
        hand.ctx.yield_(3)
        hand.photograph(tmp_path / "window.png")
        monkeypatch.undo()
        hand.picture()

    assert drive(use).view.messages == []
    with Image.open(tmp_path / "window.png") as saved:
        picture = np.asarray(saved).astype(int)
    assert np.std(picture[200:360, 500:800]) > 20.0                     # the scene, and no empty panel
    printed = capfd.readouterr()
    assert "Missing" not in printed.out + printed.err                   # of ImGui: what was pushed is popped


@pytest.mark.slow
def test_a_lens_is_opened_by_its_path_and_a_wrong_path_is_said_where_it_was_typed(drive, tmp_path):
    good = tmp_path / "mine.toml"
    lenses.save(lenses.load("lv-czj-tessar-50-f28"), good)

    def use(hand):
        hand.picture()
        hand.press(chord(CTRL, imgui.Key.o))
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(tmp_path / "nothing.toml"))
        hand.ctx.yield_(2)
        assert hand.settings == SMALL
        hand.ctx.item_input_value("//$FOCUSED/##Name", str(tmp_path))
        hand.ctx.yield_(2)
        hand.ctx.item_click("//###File/**/mine.toml")
        hand.ctx.item_click("//###File/Open")
        hand.picture()
        assert hand.settings.lens == str(good)

    assert drive(use).view.messages == []


def test_a_screenshot_that_failed_in_an_open_window_is_no_error_at_its_end(monkeypatch):
    monkeypatch.setattr(window, "parameters", lambda session: setattr(session, "shot_problem", "no space is left"))
    monkeypatch.setattr(window, "show", lambda _: None)
    assert window.run(SMALL) == 0
