"""The kind of a file is told by its own keys and first bytes."""

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.scenes.scene_writer import save_scene
from lensbench.app.session.file_kinds import file_kind
from lensbench.app.session.states import save_settings
from lensbench.app.settings.settings import Settings
from lensbench.lenses.library.catalogue import path_of


def test_every_scene_lens_and_settings_file_is_told_by_its_keys(tmp_path):
    for name in lb.SCENES:
        save_scene(name, tmp_path / f"{name}.toml")
        assert file_kind(tmp_path / f"{name}.toml") == "scene", name
    assert {file_kind(path_of(name)) for name in lenses.names()} == {"lens"}
    save_settings(tmp_path / "settings.toml", Settings())
    assert file_kind(tmp_path / "settings.toml") == "settings"


@pytest.mark.parametrize(("text", "kind"), [
    ("# shiny surfaces\n[floor]\nheight = 0\n", "scene"), ("surfaces = [\n[1,\n", "lens"), ("version = \n", "settings"),
    ("[[sphere]\n", "scene")])
def test_words_elsewhere_in_a_file_do_not_count_and_a_damaged_one_keeps_its_kind(tmp_path, text, kind):
    path = tmp_path / "a.toml"
    path.write_text(text)
    assert file_kind(path) == kind
