"""One *Open…* for everything: by the dialog, by a drop, from the command line; and the form of what was opened."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

import lensbench as lb
from lensbench import lenses
from lensbench.app.drawing.controls import chord
from lensbench.app.scenes.scene_file import load_scene
from lensbench.app.scenes.scene_writer import is_own
from lensbench.app.session.export import save_picture
from tests.app.conftest import SMALL

CTRL = imgui.Key.mod_ctrl
CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 2) for z in (0, 1)) + (
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n")


@pytest.fixture(autouse=True)
def own_data(tmp_path, monkeypatch):
    """The program's own scenes go to a folder of the test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


def opened(hand, path):
    """Open a file by Ctrl+O and its name, and wait until it is read."""
    hand.press(chord(CTRL, imgui.Key.o))
    hand.ctx.item_input_value("//###File/##Name", str(path))
    hand.ctx.yield_(2)
    hand.wait(lambda: hand.session.opening is None, "the file")
    hand.ctx.yield_(3)


@pytest.mark.slow
def test_a_mesh_opens_standing_on_a_floor_at_a_height_that_is_typed(drive, tmp_path):
    path = tmp_path / "cube.obj"
    path.write_text(CUBE)

    def use(hand):
        hand.picture()
        opened(hand, path)
        assert is_own(hand.settings.scene) and hand.session.view.messages == []
        scene = load_scene(hand.settings.scene)
        box = np.concatenate([mesh.points for mesh in scene.meshes])
        assert np.ptp(box[:, 1]) == pytest.approx(300.0) and box[:, 1].min() == pytest.approx(scene.floor.height)
        hand.picture()
        first = hand.settings
        hand.ctx.item_input_value("//###Opened/###Height", 12.0)
        hand.ctx.yield_(3)
        hand.wait(lambda: hand.session.opening is None and hand.settings.scene != first.scene, "the smaller mesh")
        box = np.concatenate([mesh.points for mesh in load_scene(hand.settings.scene).meshes])
        assert np.ptp(box[:, 1]) == pytest.approx(120.0)
        hand.picture()
        hand.photograph(tmp_path / "mesh.png")
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == first
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == SMALL

    drive(use)


@pytest.mark.slow
def test_a_photograph_asks_for_its_depth_map_and_for_its_distances(drive, tmp_path):
    photograph, depth = tmp_path / "beach.jpg", tmp_path / "map.png"
    Image.fromarray(np.tile(np.linspace(40, 220, 90).astype(np.uint8), (60, 1))).save(photograph)
    Image.fromarray(np.tile(np.linspace(10, 200, 45).astype(np.uint8), (30, 1))).save(depth)

    def use(hand):
        hand.picture()
        hand.session.dropped(None, [str(photograph)])
        hand.ctx.yield_(4)
        assert hand.settings == SMALL
        hand.photograph(tmp_path / "asked.png")
        hand.ctx.item_click("//###Opened/Choose depth map…")
        hand.ctx.item_input_value("//###File/##Name", str(depth))
        hand.wait(lambda: hand.settings.scene != SMALL.scene, "the photograph")
        hand.picture()
        assert load_scene(hand.settings.scene).depth_range[1] == pytest.approx(12_000.0, rel=0.2)
        before = hand.settings.scene
        hand.ctx.item_input_value("//###Opened/###Farthest", 4.0)
        hand.ctx.yield_(3)
        hand.wait(lambda: hand.settings.scene != before, "the nearer end")
        assert load_scene(hand.settings.scene).depth_range[1] == pytest.approx(4800.0, rel=0.2)
        hand.picture()
        hand.photograph(tmp_path / "photograph.png")

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_sky_surrounds_the_objects_of_the_scene_or_balls_and_the_scene_is_saved(drive, tmp_path):
    sky, scene = tmp_path / "sky.hdr", tmp_path / "one.toml"
    sky.write_bytes(b"#?RADIANCE\n\n-Y 8 +X 16\n" + bytes((128, 100, 90, 129)) * 128)
    scene.write_text('name = "One ball"\n[sun]\ndirection = [0, 1, 0]\n'
                     '[[sphere]]\ncentre = [0, 0, -900]\nradius = 70\n')

    def use(hand):
        hand.picture()
        for path in (scene, sky):
            hand.session.dropped(None, [str(path)])
            hand.wait(lambda: hand.session.opening is None, "the file")
            hand.ctx.yield_(3)
        under = load_scene(hand.settings.scene)
        assert len(under.spheres) == 1 and under.sun is None and isinstance(under.sky, lb.ImageSky)
        hand.picture()
        hand.photograph(tmp_path / "sky.png")
        hand.ctx.item_click("//###Opened/##Under it")
        hand.ctx.item_click("//##Combo_00/###Three balls")
        hand.wait(lambda: len(load_scene(hand.settings.scene).spheres) == 3, "the balls")
        (tmp_path / "kept").mkdir()
        balls = load_scene(hand.settings.scene)
        hand.ctx.item_click("//###Opened/Save scene as…")
        hand.ctx.yield_(2)
        hand.ctx.item_input_value("//###File/##Name", str(tmp_path / "kept" / "mine.toml"))
        hand.wait(lambda: hand.settings.scene == str(tmp_path / "kept" / "mine.toml"), "the saved scene")
        assert load_scene(hand.settings.scene) == balls
        assert hand.session.view.messages == ["Scene saved as mine.toml, with a copy of sky.hdr"]

    drive(use)


@pytest.mark.slow
def test_settings_in_a_picture_a_lens_and_a_light_field_open_by_the_same_entry(drive, tmp_path):
    picture, lens, field = tmp_path / "shot.png", tmp_path / "mine.toml", tmp_path / "field.npz"
    save_picture(picture, np.full((8, 12, 3), 0.2, np.float32), replace(SMALL, f_number=5.6))
    lenses.save(lenses.load("lv-czj-tessar-50-f28"), lens)
    np.savez(field, nothing=np.zeros(3))

    def use(hand):
        hand.picture()
        opened(hand, picture)
        assert hand.settings.f_number == 5.6
        opened(hand, lens)
        assert hand.settings.lens == str(lens)
        opened(hand, field)
        hand.wait(lambda: hand.session.light_field.worker.messages or hand.session.view.messages, "the refusal")
        assert hand.session.recent[:3] == [field, lens, picture]

    drive(use)


@pytest.mark.slow
def test_the_export_goes_to_the_folder_that_was_used_last(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.session.files.prompt.folder = tmp_path
        hand.ctx.item_click("**/Export")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//Export/Save as it is now")
        hand.wait((tmp_path / "lensbench.png").exists, "the picture")

    drive(use)


@pytest.mark.slow
def test_a_plain_picture_of_all_directions_is_used_as_a_sky_and_a_broken_mesh_changes_nothing(drive, tmp_path):
    picture, broken = tmp_path / "around.png", tmp_path / "broken.glb"
    Image.new("RGB", (32, 16), (90, 120, 200)).save(picture)
    broken.write_bytes(b"glTF and nothing more")

    def use(hand):
        hand.picture()
        opened(hand, broken)
        assert hand.settings == SMALL and "broken.glb" in hand.session.view.messages[0]
        hand.session.view.notices.forget()
        opened(hand, picture)
        hand.ctx.item_click("//###Opened/Use as sky")
        hand.wait(lambda: hand.settings.scene != SMALL.scene, "the sky")
        assert isinstance(load_scene(hand.settings.scene).sky, lb.ImageSky)
        hand.press(chord(CTRL, imgui.Key.z))
        assert hand.settings == SMALL and hand.session.view.messages == []

    drive(use)
