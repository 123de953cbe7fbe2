"""Settings as a file: what is written comes back, by hand too, and what cannot be is named by file, line and key."""

import math
import os
import shlex
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings as profile, strategies as st

from lensbench.app.command.main import main
from lensbench.app.session.export import ExportError, save_picture
from lensbench.app.session.states import load_settings, save_settings
from lensbench.app.settings.camera_facts import CAMERAS, LENS_MODELS
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.setting_table import TONES
from lensbench.app.settings.settings import VERSION, Settings

finite = st.floats(-1e6, 1e6)


@given(st.builds(Settings, lens=st.text(st.characters(exclude_categories=["Cs"]), max_size=9),
                 focal_length=st.none() | st.floats(1.0, 900.0),
                 f_number=st.none() | st.floats(0.5, 64.0), focus_distance=st.just(math.inf) | st.floats(1e-3, 1e12),
                 position=st.tuples(finite, finite, finite), camera=st.sampled_from(list(CAMERAS)),
                 lens_model=st.sampled_from(list(LENS_MODELS)),
                 tone=st.sampled_from(list(TONES)), exposure=st.floats(-60.0, 60.0), seed=st.integers(0, 2**32 - 1)))
@profile(max_examples=60)
def test_settings_come_back_from_their_file_to_the_last_bit(tmp_path_factory, settings):
    path = tmp_path_factory.mktemp("settings") / "a.toml"
    save_settings(path, settings)
    assert load_settings(path) == settings


def test_what_a_hand_has_written_is_read_and_what_it_left_out_is_as_the_bench_has_it(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text('version = 1\nf_number = "open"  # as far as it goes\nfocus_distance = inf\nexposure = 1\n'
                    'position = [0, 1.5, 2]\n')
    read = load_settings(path)
    assert read == replace(Settings(), f_number=None, focus_distance=math.inf, exposure=1.0, position=(0.0, 1.5, 2.0))
    assert isinstance(read.exposure, float) and isinstance(read.position[0], float)


def test_a_lens_beside_the_settings_is_found_from_anywhere(tmp_path):
    (tmp_path / "mine.dat").write_text("")
    (tmp_path / "a.toml").write_text('version = 1\nlens = "mine.dat"\n')
    assert load_settings(tmp_path / "a.toml").lens == str(tmp_path / "mine.dat")


@pytest.mark.parametrize(("text", "said"), [
    ("", "no `version`"), ("version = 1\n\ncrop = 3.0\n", ":3: crop:"), ("version = 1\nfov = 4.0", ":2: fov:"),
    ("version = 1\nfilm_width = -36", ":2: film_width:"), ("version = 1\nf_number = 'wide'", ":2: f_number:"),
    ("version = 1\nposition = [1, 2]", ":2: position:"), ("version = 1\nlense = 'x'", ":2: lense:"),
    ("version = 1\nsamples = true", "whole number"), ("version = 1\npixels_x = 1e3", "whole number"),
    ("version = 1\nlens_model = 'zoom'", "auto, trace"), (f"version = {VERSION + 1}", "update lensbench"),
    ("version = 1\nfov = ", "not TOML: "), ("[version]\na = 1", ":1: version:|no `version`"),
    ("version = 1\npixels_x = 20000\npixels_y = 20000", "million are possible"),
])
def test_what_cannot_be_is_named_by_file_line_and_key(tmp_path, text, said):
    path = tmp_path / "odd.toml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=rf"odd\.toml.*({said})"):
        load_settings(path)


def test_a_file_that_is_no_text_or_not_there_is_said(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SettingsError, match="not UTF-8 text"):
        load_settings(tmp_path / "a.toml")
    with pytest.raises(SettingsError, match="No such file"):
        load_settings(tmp_path / "b.toml")


def test_settings_are_written_whole_or_not_at_all(tmp_path):
    (tmp_path / "a.toml").write_text("the old file")
    with pytest.raises(UnicodeEncodeError):
        save_settings(tmp_path / "a.toml", replace(Settings(), lens="\udcff"))
    assert os.listdir(tmp_path) == ["a.toml"] and (tmp_path / "a.toml").read_text() == "the old file"
    with pytest.raises(SettingsError, match=r"written as \.toml"):
        save_settings(tmp_path / "a.json", Settings())
    with pytest.raises(ExportError, match="there is no folder"):
        save_settings(tmp_path / "no" / "a.toml", Settings())


def test_a_picture_is_repeated_from_the_settings_saved_with_it_and_options_change_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = shlex.split("render pbrt-dgauss-50mm --f-number 4 --scene grid-wall --size 24x16 --samples 2")
    assert main([*words, "-o", "a.ppm", "--save-settings", "a.toml"]) == 0
    assert main(["render", "--settings", "a.toml", "-o", "b.ppm"]) == 0
    assert (tmp_path / "a.ppm").read_bytes() == (tmp_path / "b.ppm").read_bytes()
    assert load_settings("a.toml").f_number == 4.0
    assert main(["render", "--settings", "a.toml", "--exposure", "+3", "-o", "b.ppm"]) == 0
    assert (tmp_path / "a.ppm").read_bytes() != (tmp_path / "b.ppm").read_bytes()


def test_a_render_of_nothing_is_refused(capsys):
    assert main(["render", "-o", "a.png"]) == 2
    assert "--settings" in capsys.readouterr().err


def test_an_exported_picture_is_a_settings_file_too(tmp_path):
    settings = replace(Settings(), lens_model="thin", f_number=4.0, exposure=-0.5)
    for name in ("a.png", "a.ppm", "a.exr"):
        save_picture(tmp_path / name, np.zeros((640, 960, 3), np.float32), settings)
        assert load_settings(tmp_path / name) == settings
    (tmp_path / "a.png").write_bytes(b"version = 1")
    with pytest.raises(ExportError, match="neither a PNG"):
        load_settings(tmp_path / "a.png")
