"""The title of a scene in the left column, in snapshots and in comparisons."""

from pathlib import Path

import pytest

from lensbench.app.panels.controls.controls import scene_title
from tests.app.scenes.test_scene_file import save_picture

FLOOR = '[floor]\ntile = "8 cm"\n'
PHOTOGRAPH = '[photograph]\nimage = "img_0001.png"\ndepth = "depth.png"\nfov = 40\nnear = "1 m"\nfar = "5 m"\n'


@pytest.mark.parametrize("text, title", [
    ('name = "Two balls and\\n a light"\n' + FLOOR, "Two balls and a light"), (FLOOR, "mine"),
    ('name = ""\n' + FLOOR, "mine"),
    ("nothing", "mine"), (PHOTOGRAPH, "mine"), ('name = "The beach"\n' + PHOTOGRAPH, "The beach")])
def test_a_scene_file_has_the_name_that_it_states_else_its_own(tmp_path: Path, text, title):
    save_picture(tmp_path / "img_0001.png", [[[9, 99, 199]] * 4] * 3)
    save_picture(tmp_path / "depth.png", [[50, 60, 70, 80]] * 3)
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert scene_title(str(path)) == title


def test_built_in_scenes_and_files_that_are_gone_have_titles():
    assert scene_title("dusk-street") == "Dusk street" and scene_title("/gone/away.toml") == "away"
