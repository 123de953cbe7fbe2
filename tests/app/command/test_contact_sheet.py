"""Contact sheets: lenses in one framing, and snapshots as they are, in a grid or one after the other."""

import numpy as np
import pytest
from PIL import Image, ImageSequence

from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.app.session.contact_sheet import Cell, found_lenses, write_sheet
from lensbench.app.session.export import save_picture
from lensbench.app.settings.settings import Settings

RED, BLUE = (np.full((60, 90, 3), colour, np.uint8) for colour in ((200, 0, 0), (0, 0, 200)))


def read(path):
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"))


@pytest.mark.parametrize(("text", "count"), [("six 50 mm lenses", 6), ("3 50 mm lenses", 3), ("50 mm", 6),
                                             ("two macro lenses", 2), ("85 mm f/1.4 lenses", 3)])
def test_words_ask_for_lenses_of_the_library(text, count):
    names, number = found_lenses(text)
    assert len(set(names)) == len(names) >= count == number
    for name in names[:count]:
        card = lenses.card(name)
        assert "50 mm" not in text or card.efl < 53.0 < (card.tele_efl or card.efl) + 6.0
        assert "macro" not in text or "macro" in f"{card.kind} {card.title}".lower()


def test_words_without_a_lens_are_refused():
    with pytest.raises(ValueError, match="no lens of the library matches"):
        found_lenses("six 7777 mm lenses")


def test_a_grid_shows_every_picture_with_its_caption(tmp_path):
    write_sheet(tmp_path / "a.png", [Cell(RED, "A", "50 mm"), Cell(BLUE, "B", "85 mm"), Cell(RED, "C", "")])
    pixels = read(tmp_path / "a.png")
    red, blue = ((pixels == picture[0, 0]).all(axis=2) for picture in (RED, BLUE))
    assert red.sum() == 2 * RED[..., 0].size and blue.sum() == BLUE[..., 0].size
    rows, columns = np.nonzero(blue)
    below = pixels[rows.max() + 2:rows.max() + 26, columns.min():columns.max()]
    assert below.max() > 230 and (np.ptp(below.astype(int), axis=2) == 0).all()      # grey letters
    write_sheet(tmp_path / "a.jpg", [Cell(RED, "A", "50 mm")])
    assert (tmp_path / "a.jpg").read_bytes()[:3] == b"\xff\xd8\xff"


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_pictures_follow_each_other_for_the_time_asked_for(tmp_path, suffix):
    tall = np.full((120, 60, 3), (0, 0, 200), np.uint8)
    write_sheet(tmp_path / f"a{suffix}", [Cell(RED, "A", ""), Cell(tall, "B", "")], 0.5)
    frames, durations = [], []
    with Image.open(tmp_path / f"a{suffix}") as moving:
        for frame in ImageSequence.Iterator(moving):
            frames.append(np.asarray(frame.convert("RGB")).astype(int))
            durations.append(frame.info["duration"])
    assert durations == [500, 500] and frames[0].shape == frames[1].shape
    assert np.abs(frames[0][30, 45] - RED[0, 0]).max() < 12 and np.abs(frames[1][30, 45] - BLUE[0, 0]).max() < 12
    assert frames[1][30, 2].max() < 60                          # a narrower picture has free sides


def test_another_suffix_is_refused_before_any_work(tmp_path, capsys):
    assert main(["contact-sheet", "pbrt-dgauss-50mm", "-o", str(tmp_path / "a.bmp")]) == 2
    assert ".png .jpg" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_renders_lenses_in_one_framing_and_names_what_has_no_picture(tmp_path, capsys):
    sheet = tmp_path / "sheet.png"
    assert main(["contact-sheet", "pbrt-dgauss-50mm", "no-such-lens", "two 85 mm lenses", "--scene", "white-wall",
                 "--size", "90x60", "--samples", "2", "-o", str(sheet)]) == 1
    shown = capsys.readouterr()
    assert "3 pictures" in shown.out and "no-such-lens" in shown.err and "“two 85 mm lenses”: " in shown.err
    assert sheet.is_file()


@pytest.mark.slow
def test_snapshots_are_joined_as_they_are(tmp_path, capsys):
    paths = []
    for name, level in (("dark", 0.05), ("bright", 0.7)):
        paths.append(str(tmp_path / f"{name}.png"))
        save_picture(paths[-1], np.full((60, 90, 3), level, np.float32), Settings())
    assert main(["contact-sheet", *paths, "--scene", "room", "-o", str(tmp_path / "a.png")]) == 0
    pixels = read(tmp_path / "a.png")
    for path in paths:
        codes = read(path)[0, 0]
        assert (pixels == codes).all(axis=2).sum() >= 60 * 90
    assert "--scene has no effect" in capsys.readouterr().err
