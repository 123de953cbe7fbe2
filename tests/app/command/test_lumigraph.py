"""`lensbench lightfield array | novel`: an array of pinholes comes back from its file; errors."""

import re

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.command.main import main
from lensbench.app.session.export import read_settings
from lensbench.app.session.recordings import load_lumigraph, save_lumigraph

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("array") / "array.npz"
    assert main(["lightfield", "array", "pbrt-dgauss-50mm", "--lens-model", "thin", "--focus", "1.2m",
                 "--size", "36x24", "--views", "3x2", "--spacing", "4mm", "--samples", "2", "-o", str(path)]) == 0
    return path


def test_a_lumigraph_comes_back_bit_for_bit(recorded, tmp_path):
    made, settings = load_lumigraph(recorded)
    assert made.views == (3, 2) and made.spacing == 4.0 and settings.film.pixels_x == 36
    direct = lb.capture_lumigraph(camera(settings), lb.builtin_scene(settings.scene), (3, 2), 4.0, None, 2,
                                  settings.seed)
    assert np.array_equal(direct.pictures, made.pictures) and np.array_equal(direct.nearness, made.nearness)
    assert direct.distance == made.distance
    save_lumigraph(tmp_path / "again.npz", made, settings)
    again, same = load_lumigraph(tmp_path / "again.npz")
    assert np.array_equal(again.pictures, made.pictures) and same == settings
    assert np.array_equal(again.camera.placement(), made.camera.placement())


def test_a_novel_view_says_how_much_of_it_was_recorded(recorded, tmp_path, capsys):
    def said(*arguments):
        picture = tmp_path / "novel.png"
        assert main(["lightfield", "novel", str(recorded), "-o", str(picture), *arguments]) == 0
        assert read_settings(picture).pixels_x == int(re.search(r"(\d+) × ", text := capsys.readouterr().out)[1])
        return text

    assert "18 × 12 pixels; the whole view was recorded" in said()
    assert "; 0 % of the view was recorded" in said("--at", "4.1", "0", "0")
    before = int(re.search(r"(\d+) % of the view", said("--at", "0", "0", "-30", "--size", "36x24"))[1])
    assert 0 < before < 100
    assert "the whole view" in said("--flat") and "the whole view" in said("--surface", "1.5m")
    assert "% of the view" in said("--turn", "5", "0")


def test_what_cannot_be_is_one_line(recorded, tmp_path, capsys):
    cut = tmp_path / "cut.npz"
    cut.write_bytes(recorded.read_bytes()[:2000])
    np.savez(tmp_path / "other.npz", light=np.zeros(3))
    for arguments, says in (
            (["novel", str(cut)], "cut short"), (["novel", str(tmp_path / "no.npz")], "No such file"),
            (["novel", str(tmp_path / "other.npz")], "lightfield array records one"),
            (["novel", str(recorded), "--flat", "--surface", "1m"], "choose one of them"),
            (["novel", str(recorded), "--surface", "0"], "must be positive"),
            (["array", "pbrt-dgauss-50mm", "--spacing", "0mm"], ""),
            (["array", "pbrt-dgauss-50mm", "--views", "0x3"], "views across and down"),
            (["array", "pbrt-dgauss-50mm", "--focus", "inf"], "finite distance"),
            (["array", "--camera", "environment"], "not projective")):
        suffix = ".npz" if arguments[0] == "array" else ".png"
        assert main(["lightfield", *arguments, "-o", str(tmp_path / f"out{suffix}")]) == 2
        error = capsys.readouterr().err
        assert says in error and error.count("\n") == 1, error
        assert not (tmp_path / f"out{suffix}").exists()
