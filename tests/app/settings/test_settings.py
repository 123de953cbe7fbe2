"""The declarations of the settings: ranges, choices, options, and what a change restarts."""

import math
import os
import re
from dataclasses import fields, replace

import pytest

from lensbench.app.command.main import main
from lensbench.app.plots.plan import things
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.camera_facts import CAMERA_KINDS
from lensbench.app.settings.setting import Interval, SettingsError, spec
from lensbench.app.settings.settings import VERSION, Settings
from tests.app.command.test_main import LENS, settings_of, viewed  # noqa: F401 - the fixture

BOUNDED = [field for field in fields(Settings) if spec(field).bounds is not None]
CHOICES = [field for field in fields(Settings) if spec(field).choices]


def outside(interval: Interval) -> list[float]:
    """Numbers just outside an interval, and nan."""
    return [math.nan, -math.inf, interval.low - 1.0, math.nextafter(interval.low, -math.inf),
            math.nextafter(interval.high, math.inf), *([] if interval.infinite else [math.inf])]


@pytest.mark.parametrize("field", BOUNDED, ids=lambda field: field.name)
def test_a_number_outside_its_range_is_refused_with_the_range(field):
    Settings().checked()
    for value in outside(spec(field).bounds):
        wrong = (0.0, value, 0.0) if "position" in field.name else value
        with pytest.raises(SettingsError, match=r": (each coordinate )?it must (be|lie) "):
            replace(Settings(), **{field.name: wrong}).checked()


def test_a_message_shows_all_digits_of_a_whole_number():
    with pytest.raises(SettingsError, match="seed 4294967296: "):
        replace(Settings(), seed=1 << 32).checked()


@pytest.mark.parametrize("field", CHOICES, ids=lambda field: field.name)
def test_a_value_that_is_no_choice_is_refused_with_the_choices(field):
    with pytest.raises(SettingsError, match=r"choose one of|3 to 24"):
        replace(Settings(), **{field.name: 1 if field.name in ("blades", "degree", "bits") else "no-such"}).checked()
    for choice in spec(field).choices:
        replace(Settings(), **{field.name: choice}).checked()


@pytest.mark.parametrize(("value", "inside"), [
    (0.0, True), (0.5, True), (1.0, True), (math.nan, False), (1.5, False), (-0.5, False), (-math.inf, False)])
def test_an_interval_holds_its_ends_and_infinity_where_it_says_so(value, inside):
    assert (value in Interval(0.0, 1.0)) is (value in Interval(0.0, 1.0, infinite=True)) is inside
    assert math.inf in Interval(0.0, 1.0, infinite=True) and math.inf not in Interval(0.0, 1.0)


def test_every_number_has_choices_or_a_finite_range():
    numbers = [field for field in fields(Settings) if re.search("float|int", str(field.type))]
    for field in numbers:
        about = spec(field)
        if not about.choices:
            assert about.bounds is not None and math.isfinite(about.bounds.low) and math.isfinite(about.bounds.high)
    assert len(numbers) > 30


@pytest.mark.parametrize("value", [10**400, -10**400, 10**5000, "x" * 10**5, [[0.0] * 9999], {"a": "b" * 9999}, None],
                         ids=["huge", "hugely negative", "5000 digits", "text", "list", "table", "none"])
def test_a_value_of_any_size_is_refused_in_a_short_message_or_taken(value):
    for name in ("version", "an unknown name", *(field.name for field in fields(Settings))):
        try:
            Settings.from_dict({"version": VERSION, name: value})
        except ValueError as error:
            assert len(str(error)) < 400 and "\n" not in str(error)


def test_what_restarts_nothing_leaves_the_picture_alone_and_what_moves_it_does_so_only_where_something_moves():
    start, moving = Settings(), replace(Settings(), end_position=(1.0, 0.0, 0.0))
    assert replace(start, exposure=1.0, tone="agx", wipe=0.2, samples=3).picture == start.picture
    assert replace(start, shutter=1.0).picture == start.picture
    assert replace(moving, shutter=1.0).picture != moving.picture
    assert replace(start, view="time", shutter=1.0).picture != replace(start, view="time").picture
    assert replace(start, seed=1).picture != start.picture and replace(start, seed=1).optics == start.optics
    assert replace(start, limit="pixel").optics != start.optics


# Names of cameras and lens models


def test_settings_come_back_equal():
    settings = replace(Settings(), camera="finite-pinhole", lens_model="thin", immersed=True)
    assert Settings.from_dict(settings.to_dict()) == settings


def test_a_present_option_says_nothing(viewed, capsys):  # noqa: F811
    found = settings_of(viewed, LENS, "--camera", "lens", "--lens-model", "thin", "--no-light-tracing", "--immersed",
                        "--medium", "water")
    assert (found.lens_model, found.light_tracing, found.immersed) == ("thin", False, True)
    assert capsys.readouterr().err == ""


def test_a_lens_model_asks_for_the_camera_that_has_a_lens(viewed, tmp_path):  # noqa: F811
    (tmp_path / "a.toml").write_text('version = 1\ncamera = "fisheye"\n')
    found = settings_of(viewed, "--settings", str(tmp_path / "a.toml"), "--lens-model", "thin")
    assert (found.camera, found.lens_model) == ("lens", "thin")


def test_an_unknown_model_is_refused_with_the_words(viewed, capsys):  # noqa: F811
    assert main(["view", LENS, "--camera", "magic"]) == 2
    assert "finite-pinhole" in capsys.readouterr().err


def test_only_a_camera_with_a_lens_follows_one():
    for name, kind in CAMERA_KINDS.items():
        assert Settings(camera=name, lens_model="trace").follows_lens is kind.has_lens
        assert Settings(camera=name).is_automatic is kind.has_lens
    assert not Settings(lens_model="pinhole").focuses and not Settings(lens_model="pinhole").has_stop


# Files that change

STILL = '[[sphere]]\ncentre = [0, 0, -1000]\nradius = 100\n'


def test_an_edited_scene_file_is_seen_by_the_same_settings(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(STILL)
    settings = replace(Settings(), scene=str(path))
    assert not settings.moves and settings.picture == replace(settings, shutter=1.0).picture
    assert len(things(str(path), 0.0)) == 1
    path.write_text(STILL + 'velocity = [100, 0, 0]\n')
    assert settings.moves and settings.picture != replace(settings, shutter=1.0).picture
    path.write_text(2 * STILL)
    assert len(things(str(path), 0.0)) == 2


def test_an_edited_texture_is_seen(tmp_path):
    from PIL import Image

    path = tmp_path / "a.toml"
    path.write_text('[[disk]]\ncentre = [0, 0, -1000]\nnormal = [0, 0, 1]\nradius = 100\n'
                    'material = { texture = "t.png" }\n')
    levels = []
    for level in (0, 255):
        Image.new("RGB", (4, 4), (level,) * 3).save(tmp_path / "t.png")
        os.utime(tmp_path / "t.png", ns=(level, level))
        levels.append(cached_scene(str(path)).plates[0].material.pattern.image)
    assert levels[0] != levels[1]
