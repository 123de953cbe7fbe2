"""`lensbench lightfield`: what was recorded comes back from its file, and can be focused; what cannot be is said."""

import json

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.cli import main
from lensbench.app.export import ExportError, read_settings
from lensbench.app.light_field_file import load_light_field, save_light_field
from lensbench.app.optics import camera
from lensbench.app.settings import Settings

SMALL = ["--size", "36x24", "--views", "3x2", "--samples", "2"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("field") / "field.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--focus", "1.2m", *SMALL, "-o", str(path)]) == 0
    return path


def test_a_light_field_comes_back_bit_for_bit(recorded, tmp_path):
    field, settings = load_light_field(recorded)
    assert field.views == (3, 2) and (settings.pixels_x, settings.pixels_y) == (36, 24)
    save_light_field(tmp_path / "again.npz", field, settings)
    again, same = load_light_field(tmp_path / "again.npz")
    assert np.array_equal(again.light, field.light) and np.array_equal(again.coverage, field.coverage)
    assert same == settings and (again.reach, again.fill) == (field.reach, field.fill)
    assert np.array_equal(again.refocus(900.0), field.refocus(900.0))


def test_it_is_the_very_one_that_the_library_captures(recorded):
    field, settings = load_light_field(recorded)
    direct = lb.capture_light_field(camera(settings), lb.builtin_scene(settings.scene), (3, 2), 2, settings.seed)
    assert np.array_equal(direct.light, field.light)


def test_a_picture_of_it_carries_its_settings(recorded, tmp_path, capsys):
    picture = tmp_path / "near.png"
    assert main(["lightfield", "refocus", str(recorded), "--focus", "0.9m", "--f-number", "5.6", "-o",
                 str(picture)]) == 0
    assert "focused at 0.9 m" in capsys.readouterr().out
    settings = read_settings(picture)
    assert (settings.focus_distance, settings.f_number) == (900.0, 5.6)


def test_a_distance_that_the_lens_cannot_be_focused_at_is_taken_for_the_nearest_and_said(recorded, tmp_path, capsys):
    assert main(["lightfield", "refocus", str(recorded), "--focus", "1cm", "-o", str(tmp_path / "a.png")]) == 0
    assert "the nearest distance in place of 0.01 m" in capsys.readouterr().out


def test_what_cannot_be_is_one_line(recorded, tmp_path, capsys):
    cut, other = tmp_path / "cut.npz", tmp_path / "other.npz"
    cut.write_bytes(recorded.read_bytes()[:2000])
    np.savez(other, light=np.zeros(3))
    fake = tmp_path / "fake.npz"
    with np.load(recorded) as archive:
        np.savez(fake, **{**archive, "coverage": np.zeros((2, 3, 5, 5), np.float16)})
    for arguments, says in (
            (["refocus", str(cut)], "cut short"), (["refocus", str(tmp_path / "no.npz")], "No such file"),
            (["refocus", str(other)], "no light field of lensbench"),
            (["refocus", str(fake)], "not those of its settings"),
            (["refocus", str(recorded), "--f-number", "1"], "was not recorded"),
            (["refocus", str(recorded), "--view", "x"], "two numbers"),
            (["capture", "pbrt-dgauss-50mm", "--views", "0x3"], "views across and down"),
            (["capture", "pbrt-dgauss-50mm", "--model", "pinhole"], "through a lens"),
            (["capture", "--model", "environment"], "not projective")):
        suffix = ".npz" if arguments[0] == "capture" else ".png"
        assert main(["lightfield", *arguments, "-o", str(tmp_path / f"out{suffix}")]) == 2
        error = capsys.readouterr().err
        assert says in error and error.count("\n") == 1, error
        assert not (tmp_path / f"out{suffix}").exists()
    with pytest.raises(ExportError, match=r"written as \.npz"):
        save_light_field(tmp_path / "a.zip", load_light_field(recorded)[0], Settings())


def test_the_archive_is_one_that_numpy_reads(recorded):
    with np.load(recorded, allow_pickle=False) as archive:
        assert archive["light"].dtype == np.float16 and archive["light"].shape == (2, 3, 3, 24, 36)
        assert json.loads(str(archive["settings"]))["lens"] == "pbrt-dgauss-50mm"
