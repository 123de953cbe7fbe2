"""A picture in the stop of a lens file: kept beside it, right side up, and read from nowhere else."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Picture

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.lenses.editing.document import LensDocument, from_text, to_text
from lensbench.lenses.editing.faults import faults
from lensbench.lenses.stop_picture import read_picture

LENS = lenses.load("pbrt-dgauss-50mm")
LETTER = np.zeros((20, 14), np.uint8)                   # an F: no turn and no mirror leaves it as it is
LETTER[2:18, 3:5], LETTER[2:4, 3:12], LETTER[9:11, 3:9] = 255, 255, 188


@pytest.fixture
def pictured(tmp_path):
    """A lens file with its picture in a folder below."""
    (tmp_path / "stops").mkdir()
    Picture.fromarray(LETTER).save(tmp_path / "stops" / "f.png")
    lenses.save(LENS, tmp_path / "lens.toml")
    with open(tmp_path / "lens.toml", "a", encoding="utf-8") as file:
        file.write('\n[stop]\nimage = "stops/f.png"\n')
    return tmp_path / "lens.toml"


def test_a_lens_file_names_its_picture_which_is_right_side_up(pictured):
    image = lenses.load(pictured).stop_image
    assert image.name == "stops/f.png" and image.grid.shape == (20, 20)
    assert image.at(-0.3, 0.75) == 1.0 and image.at(-0.3, -0.75) == 1.0         # the stem of the F, x right and y up
    assert image.at(0.3, 0.75) == 1.0 and image.at(0.3, -0.75) == 0.0           # its arms above
    assert image.at(0.1, 0.05) == pytest.approx(0.5029, abs=1e-3)               # grey 188 as linear light


def test_a_saved_lens_takes_its_picture_along_and_loads_equal(pictured, tmp_path):
    lens, other = lenses.load(pictured), tmp_path / "other"
    other.mkdir()
    (said,) = lenses.save(lens, other / "copy.toml")
    assert "copied next to it, as 'f.png'" in str(said)
    assert (other / "f.png").read_bytes() == (tmp_path / "stops" / "f.png").read_bytes()
    assert lenses.load(other / "copy.toml") == lens
    assert lenses.save(lenses.load(other / "copy.toml"), other / "copy.toml") == ()     # it is there already
    assert lenses.save(lens, tmp_path / "twin.toml") == () and lenses.load(tmp_path / "twin.toml") == lens
    # Another picture of this name stays
    Picture.fromarray(255 - LETTER).save(other / "f.png")
    lenses.save(lens, other / "copy.toml")
    assert lenses.load(other / "copy.toml") == lens and (other / "f-2.png").exists()
    assert sorted(file.name for file in other.iterdir()) == ["copy.toml", "f-2.png", "f.png"]


def test_a_check_takes_the_stop_as_its_circle(pictured, tmp_path, capsys):
    lens = lenses.load(pictured)
    assert lenses.check(lens) == lenses.check(lens.with_open_stop) and faults(LensDocument(lens)) == ()
    assert main(["convert", str(pictured), str(tmp_path / "stops" / "copy.toml")]) == 0
    said = capsys.readouterr().out
    assert "Also: " not in said and "Not kept" not in said              # it lies there already
    (tmp_path / "new").mkdir()
    main(["convert", str(pictured), str(tmp_path / "new" / "copy.toml")])
    assert "Also: the picture in the stop was copied next to it, as 'f.png'" in capsys.readouterr().out


def test_a_picture_without_a_file_is_written_to_sixteen_bits(tmp_path):
    image = lb.StopImage.of(np.random.default_rng(0).random((30, 30)))
    (said,) = lenses.save(replace(LENS, stop_image=image), tmp_path / "made.toml")
    assert "30 × 30 pixels of 16 bits" in str(said)
    read = lenses.load(tmp_path / "made.toml").stop_image
    assert read.name == "made-stop.png" and np.abs(read.grid - image.grid).max() < 2e-5


@pytest.mark.parametrize("suffix", [name for name in lenses.WRITERS if name != ".toml"])
def test_every_other_format_names_the_loss(pictured, tmp_path, suffix):
    lost = lenses.save(lenses.load(pictured), tmp_path / f"lens{suffix}")
    assert sum("the picture in the stop is left out" in str(remark) for remark in lost) == 1


@pytest.mark.parametrize(("name", "says"), [
    ("../f.png", "must lie in the folder of the lens file"), ("/tmp/f.png", "must lie in the folder"),
    ("C:\\\\f.png", "must lie in the folder"), ("stops/../../f.png", "must lie in the folder"),
    ("link.png", "a link out of the folder"), ("gone.png", "No such file"), ("lens.toml", "pictures are .png"),
    ("", "path of a picture"), ("stops", "pictures are .png")])
def test_pictures_elsewhere_are_refused_at_their_line(pictured, tmp_path, name, says):
    folder = tmp_path / "within"
    folder.mkdir()
    Picture.fromarray(LETTER).save(tmp_path / "f.png")
    os.symlink(tmp_path / "f.png", folder / "link.png")
    text = pictured.read_text(encoding="utf-8").replace("stops/f.png", name)
    (folder / "lens.toml").write_text(text, encoding="utf-8")
    with pytest.raises(lenses.LensFileError, match=says) as caught:
        lenses.load(folder / "lens.toml")
    assert text.split("\n")[caught.value.line - 1] == "[stop]" and "\n" not in str(caught.value)


def test_blades_beside_a_picture_and_other_values_are_refused(pictured):
    text = pictured.read_text(encoding="utf-8")
    for line, says in (("blades = 7", "place of the blades"), ("picture = 1", "must be a table")):
        pictured.write_text(text + line + "\n", encoding="utf-8")
        with pytest.raises(lenses.LensFileError, match=says):
            lenses.load(pictured)
    pictured.write_text(text.replace('"stops/f.png"', "3"), encoding="utf-8")
    with pytest.raises(lenses.LensFileError, match="path of a picture"):
        lenses.load(pictured)


def test_the_text_of_an_edited_lens_finds_its_picture_by_the_folder_of_the_lens(pictured):
    lens = lenses.load(pictured)
    text = to_text(LensDocument(lens))
    assert from_text(text, folder=Path(pictured).parent).lens == lens
    with pytest.raises(lenses.LensFileError, match="no file, in whose folder"):
        from_text(text)


def test_clear_parts_of_a_picture_pass_no_light(tmp_path):
    picture = np.full((20, 20, 4), 255, np.uint8)
    picture[:10, :, 3], picture[10:, :10, 3] = 0, 51                    # clear above; a fifth at the lower left
    Picture.fromarray(picture).save(tmp_path / "clear.png")
    image = read_picture(tmp_path / "clear.png")
    assert image.at(0.3, 0.3) == 0.0 and image.at(0.3, -0.3) == 1.0
    assert image.at(-0.3, -0.3) == pytest.approx(0.2, abs=1e-6)


def test_a_picture_of_too_many_pixels_is_refused(tmp_path, monkeypatch):
    Picture.fromarray(LETTER).save(tmp_path / "f.png")
    monkeypatch.setattr("lensbench.lenses.stop_picture.MOST_PIXELS", 20 * 14 - 1)
    with pytest.raises(lb.StopImageError, match="make it smaller"):
        read_picture(tmp_path / "f.png")
    monkeypatch.setattr("lensbench.lenses.stop_picture.MOST_PIXELS", 20 * 14)
    assert read_picture(tmp_path / "f.png").side == 20


def test_a_picture_that_is_a_little_darker_is_another_one(pictured, tmp_path):
    lens, other = lenses.load(pictured), tmp_path / "other"
    other.mkdir()
    Picture.fromarray((0.98 * LETTER).astype(np.uint8)).save(other / "f.png")       # 5 % less light
    lenses.save(lens, other / "copy.toml")
    assert lenses.load(other / "copy.toml").stop_image.name == "f-2.png"
    assert lenses.load(other / "copy.toml") == lens
