"""Scenes that lensbench ships as files: found by their names, without notices, and bright as a meter has them."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.exposure import meter_stops
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.scenes.scene_file import SHIPPED, cached_scene, load_scene, scene_stamp
from lensbench.app.settings.settings import Settings
from lensbench.core.scenery.builtin.library import SHIPPED as NAMES

ROOT = Path(__file__).parents[3]


def test_every_shipped_file_has_its_name_among_the_scenes():
    assert sorted(NAMES) == sorted(path.stem for path in SHIPPED.glob("*.toml")) and {*NAMES} <= {*lb.SCENES}


def test_every_asset_is_used_and_its_source_and_licence_are_stated():
    scenes = " ".join(path.read_text(encoding="utf-8") for path in SHIPPED.glob("*.toml"))
    sources = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
    made = (ROOT / "trials" / "shipped_meshes.py").read_text(encoding="utf-8")
    assets = [path.name for path in SHIPPED.iterdir() if path.suffix != ".toml"]
    assert assets and all(f'"{name}"' in scenes for name in assets)
    assert all(f"`{name}`" in sources or f'"{name}"' in made for name in assets)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert "THIRD_PARTY.md" in project["project"]["license-files"]


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_scene_is_a_builtin_one_that_states_its_subject_and_needs_no_notice(name):
    scene = lb.builtin_scene(name)
    assert scene == load_scene(SHIPPED / f"{name}.toml") and cached_scene(name) is scene and scene_stamp(name) == ()
    assert scene.name == name and scene.notes == ()
    distance, height = scene.subject
    assert scene.depth_range[0] < distance < scene.depth_range[1] and height < distance


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_meter_would_change_a_shipped_scene_by_less_than_a_stop(name):
    """As the window opens it, by the plain exposure; the meter would have the mean of the picture grey."""
    settings = with_lens(replace(Settings(), scene=name, pixels_x=48, pixels_y=32), "pbrt-dgauss-50mm")
    picture = lb.render(camera(settings), lb.builtin_scene(name), samples=16)
    assert abs(meter_stops(settings, picture)) < 1.0
