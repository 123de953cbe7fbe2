"""The declarations of the settings: ranges, choices, options, what a change restarts, and names of earlier versions."""

import math
import os
import re
from dataclasses import fields, replace

import pytest

from lensbench.app.command.main import main
from lensbench.app.state.build import camera
from lensbench.app.state.camera_kinds import CAMERA_KINDS, LENS_MODELS
from lensbench.app.state.geometry.plan import things
from lensbench.app.state.scene_file import cached_scene
from lensbench.app.state.setting import Interval, spec
from lensbench.app.state.settings import VERSION, Settings, SettingsError
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


# Names of earlier versions


@pytest.mark.parametrize(("word", "settings"), [
    *((name, Settings(lens_model=name)) for name in LENS_MODELS),
    *((name, Settings(camera=name)) for name in ("perspective", "orthographic", "fisheye", "environment")),
    ("hole", Settings(camera="finite-pinhole")), ("bare", Settings(camera="bare-sensor")),
    ("table", Settings(lens_model="polynomial"))])
def test_settings_of_version_3_open_under_the_present_names_and_name_them_once(word, settings):
    said = []
    assert Settings.from_dict({"version": 3, "model": word}, said.append) == settings
    assert len(said) == 1 and ("camera" in said[0] or "lens_model" in said[0])


def test_former_fields_keep_their_values_and_name_the_present_ones():
    said = []
    former = {"version": 3, "splats": False, "wet": True, "focusing": "real"}
    assert Settings.from_dict(former, said.append) == Settings(light_tracing=False, immersed=True,
                                                               focus_position="real")
    assert len(said) == 1 and all(name in said[0] for name in ("light_tracing", "immersed", "focus_position"))


def test_present_settings_come_back_without_a_word():
    said = []
    settings = replace(Settings(), camera="finite-pinhole", lens_model="thin", immersed=True)
    assert settings.to_dict()["version"] == VERSION == 5
    assert Settings.from_dict(settings.to_dict(), said.append) == settings and not said


@pytest.mark.parametrize(("words", "changes", "said"), [
    (["--model", "thin"], {"lens_model": "thin"}, "--lens-model thin"),
    (["--model", "perspective"], {"camera": "perspective"}, "--camera perspective"),
    (["--model", "hole"], {"camera": "finite-pinhole"}, "--camera finite-pinhole"),
    (["--model", "finite-pinhole"], {"camera": "finite-pinhole"}, "--camera finite-pinhole"),
    (["--model", "bare"], {"camera": "bare-sensor"}, "--camera bare-sensor"),
    (["--model", "table"], {"lens_model": "polynomial"}, "a polynomial is faster"),
    (["--no-splats"], {"light_tracing": False}, "--no-light-tracing"),
    (["--wet", "--medium", "water"], {"immersed": True}, "--immersed"),
    (["--focusing", "real"], {"focus_position": "real"}, "--focus-position")])
def test_a_former_option_works_and_names_the_present_one(viewed, capsys, words, changes, said):  # noqa: F811
    found = settings_of(viewed, LENS, *words)
    assert {name: getattr(found, name) for name in changes} == changes
    error = capsys.readouterr().err
    ignored = 0 if found.has_lens else 1                # the lens, which this camera does not have
    assert said in error and error.count("\n") == 1 + ignored and error.count("has no effect") == ignored


def test_a_present_option_says_nothing(viewed, capsys):  # noqa: F811
    found = settings_of(viewed, LENS, "--camera", "lens", "--lens-model", "thin", "--no-light-tracing", "--immersed",
                        "--medium", "water")
    assert (found.lens_model, found.light_tracing, found.immersed) == ("thin", False, True)
    assert capsys.readouterr().err == ""


def test_a_lens_model_asks_for_the_camera_that_has_a_lens(viewed, tmp_path):  # noqa: F811
    (tmp_path / "a.toml").write_text('version = 4\ncamera = "fisheye"\n')
    found = settings_of(viewed, "--settings", str(tmp_path / "a.toml"), "--lens-model", "thin")
    assert (found.camera, found.lens_model) == ("lens", "thin")


def test_a_file_of_version_3_is_named_on_stderr(viewed, capsys, tmp_path):  # noqa: F811
    (tmp_path / "a.toml").write_text('version = 3\nmodel = "hole"\n')
    assert settings_of(viewed, "--settings", str(tmp_path / "a.toml")).camera == "finite-pinhole"
    error = capsys.readouterr().err
    assert "a.toml" in error and 'camera = "finite-pinhole"' in error and error.count("\n") == 1


def test_an_unknown_model_is_refused_with_the_words(viewed, capsys):  # noqa: F811
    assert main(["view", LENS, "--model", "magic"]) == 2
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


def test_a_focus_in_water_of_a_former_version_becomes_the_true_distance():
    said = []
    former = {"version": 4, "lens": "double-gauss-100-f412", "medium": "water", "focus_distance": 1200.0,
              "f_number": None}
    found = Settings.from_dict(former, said.append)
    assert camera(found).focus_distance == pytest.approx(1200.0, rel=1e-9) and found.focus_distance > 1500.0
    assert len(said) == 1 and "1.20 m became 1.56 m" in said[0]
    assert Settings.from_dict({**former, "version": 5}).focus_distance == 1200.0
    for same in ({"medium": "air"}, {"immersed": True}, {"focus_distance": "inf"}):
        plain = {**former, **same}
        assert Settings.from_dict(plain) == Settings.from_dict({**plain, "version": 5})
    assert Settings.from_dict({**former, "lens": "gone.toml"}).focus_distance == pytest.approx(1.333 * 1200.0)
