"""Picture files for the stop: what passes, what is refused, and how settings carry one."""

import os
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as Picture

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.build import design, stop_picture, stop_picture_path, with_readable_stop
from lensbench.app.bench.camera_kinds import _stop
from lensbench.app.session.edited_lens import edited as edit, save_document
from lensbench.app.session.states import load_settings, save_settings
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.app.window.state import FileWatch
from lensbench.lenses.editing.cells import with_value


def saved(folder, name, pixels, mode=None):
    path = folder / name
    Picture.fromarray(pixels, mode).save(path)
    return str(path)


def test_white_passes_black_and_clear_parts_are_opaque_and_grey_is_linear(tmp_path):
    grey = np.array([[255, 0], [188, 255]], np.uint8)               # sRGB 188: half the light, to 0.1 %
    plain = stop_picture(saved(tmp_path, "grey.png", grey)).grid
    np.testing.assert_allclose(plain, [[1.0, 0.0], [0.5029, 1.0]], atol=1e-3)
    clear = np.dstack([np.full((2, 2, 3), 255, np.uint8), np.array([[255, 0], [51, 255]], np.uint8)])
    np.testing.assert_allclose(stop_picture(saved(tmp_path, "clear.png", clear)).grid, [[1.0, 0.0], [0.2, 1.0]],
                               atol=1e-6)
    deep = (grey.astype(np.uint16) * 257)
    np.testing.assert_allclose(stop_picture(saved(tmp_path, "deep.png", deep)).grid, plain, atol=1e-6)


def test_pictures_that_cannot_be_are_one_clear_line(tmp_path, monkeypatch):
    black = saved(tmp_path, "black.png", np.zeros((4, 4), np.uint8))
    (tmp_path / "text.png").write_text("no picture")
    large = saved(tmp_path, "large.png", np.full((8, 8), 255, np.uint8))
    for path, says in ((black, "passes no light"), (str(tmp_path / "text.png"), "no picture of the kinds"),
                       (str(tmp_path / "gone.png"), "No such file")):
        with pytest.raises(SettingsError, match=says) as caught:
            stop_picture(path)
        assert "\n" not in str(caught.value)
    monkeypatch.setattr("lensbench.lenses.stop_picture.MOST_PIXELS", 63)
    with pytest.raises(SettingsError, match="million pixels"):
        stop_picture(large)


def test_settings_open_without_a_picture_that_cannot_be_read(tmp_path):
    said = []
    gone = replace(Settings(), f_number=4.0, stop_image=str(tmp_path / "gone.png"))
    assert with_readable_stop(gone, said.append) == replace(gone, stop_image="")
    assert len(said) == 1 and said[0].endswith("No such file or directory; the stop opens without it")
    there = replace(gone, stop_image=saved(tmp_path, "there.png", np.full((2, 2), 255, np.uint8)))
    assert with_readable_stop(there, said.append) == there and len(said) == 1


def test_a_typed_path_is_relative_to_the_lens_file_and_an_error_names_the_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lenses").mkdir()
    lenses.save(lenses.load("pbrt-dgauss-50mm"), tmp_path / "lenses" / "lens.toml")
    here = saved(tmp_path, "half.png", np.repeat(np.array([[255], [0]], np.uint8), 2, 1))
    settings = Settings(lens=str(tmp_path / "lenses" / "lens.toml"))
    assert stop_picture_path(settings, "half.png") == here == stop_picture_path(Settings(), here)
    beside = saved(tmp_path / "lenses", "half.png", np.repeat(np.array([[0], [255]], np.uint8), 2, 1))
    assert stop_picture_path(settings, " half.png") == beside
    with pytest.raises(SettingsError, match="no picture 'gone.png' in .*lenses and .*") as caught:
        stop_picture_path(settings, "gone.png")
    assert str(tmp_path / "lenses") in str(caught.value) and "\n" not in str(caught.value)


def test_settings_carry_the_picture_in_place_of_blades_and_find_it_beside_their_file(tmp_path):
    path = saved(tmp_path, "half.png", np.repeat(np.array([[255], [0]], np.uint8), 2, 1))
    settings = replace(Settings(), blades=7, stop_image=path)
    lens = design(settings)
    assert lens.blades == 0 and lens.stop_image == stop_picture(path)
    assert lens.iris.area == pytest.approx(np.pi / 2, rel=1e-3)
    assert _stop(settings) == {"stop_image": lens.stop_image}
    assert isinstance(lens.stop_image, lb.StopImage)
    save_settings(tmp_path / "s.toml", replace(settings, stop_image="half.png"))
    assert load_settings(tmp_path / "s.toml").stop_image == path


def test_the_picture_of_a_lens_file_gives_way_to_blades_and_to_that_of_the_settings_and_outlives_edits(tmp_path):
    half = saved(tmp_path, "half.png", np.repeat(np.array([[255], [0]], np.uint8), 2, 1))
    other = saved(tmp_path, "other.png", np.repeat(np.array([[0], [255]], np.uint8), 2, 1))
    lenses.save(replace(lenses.load("pbrt-dgauss-50mm"), stop_image=stop_picture(half)), tmp_path / "lens.toml")
    settings = Settings(lens=str(tmp_path / "lens.toml"))
    assert design(settings).stop_image == stop_picture(half)
    assert design(replace(settings, stop_image=other)).stop_image == stop_picture(other)
    assert design(replace(settings, blades=0)).iris.is_round
    edited, _ = edit(settings, lambda document: with_value(document, 0, "thickness", 3.9))
    assert edited.edited and design(edited).stop_image == stop_picture(half)
    (tmp_path / "there").mkdir()
    kept, remarks = save_document(edited, tmp_path / "there" / "saved.toml")
    assert kept.edited == "" and design(kept).stop_image == stop_picture(half)
    assert any("copied next to it" in str(each) for each in remarks)


def test_a_picture_of_a_lens_that_changes_on_disk_is_read_again(tmp_path):
    half = saved(tmp_path, "half.png", np.repeat(np.array([[255], [0]], np.uint8), 2, 1))
    lenses.save(replace(lenses.load("pbrt-dgauss-50mm"), stop_image=stop_picture(half)), tmp_path / "lens.toml")
    settings, watch = Settings(lens=str(tmp_path / "lens.toml")), FileWatch()
    before = design(settings).stop_image
    assert watch.changed(settings, 0.0) == ([], {})
    saved(tmp_path, "half.png", np.tile(np.array([[255, 0, 255]], np.uint8), (3, 1)))
    os.utime(half, ns=(1, 1))                               # another time than that of the first, on any disk
    assert watch.changed(settings, 1.0) == ([half], {})
    assert design(settings).stop_image == stop_picture(half) != before
    os.remove(half)
    assert design(settings).stop_image is not None          # as it was read
