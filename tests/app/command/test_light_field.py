"""`lensbench lightfield`: a recording comes back from its file and can be focused; errors in one line."""

import json

import numpy as np
import OpenEXR
import pytest
from PIL import Image

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.tone import depth_codes, ends
from lensbench.app.command.main import main
from lensbench.app.session.export import ExportError, read_settings
from lensbench.app.session.recordings import load_light_field, save_light_field

pytestmark = pytest.mark.slow

SMALL = ["--size", "36x24", "--views", "3x2", "--samples", "2"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("field") / "field.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--focus", "1.2m", *SMALL, "-o", str(path)]) == 0
    return path


def test_a_light_field_comes_back_bit_for_bit(recorded, tmp_path):
    recording = load_light_field(recorded)
    field, settings = recording.field, recording.settings
    assert field.views == (3, 2) and (settings.pixels_x, settings.pixels_y) == (36, 24)
    save_light_field(tmp_path / "again.npz", recording)
    again, same = load_light_field(tmp_path / "again.npz").field, load_light_field(tmp_path / "again.npz").settings
    assert np.array_equal(again.light, field.light) and np.array_equal(again.coverage, field.coverage)
    assert same == settings and (again.reach, again.fill) == (field.reach, field.fill)
    assert np.array_equal(again.refocus(900.0), field.refocus(900.0))


def test_it_is_the_very_one_that_the_library_captures(recorded):
    field, settings = load_light_field(recorded).field, load_light_field(recorded).settings
    direct = lb.capture_light_field(camera(settings), lb.builtin_scene(settings.scene), (3, 2), 2, settings.seed)
    assert np.array_equal(direct.light, field.light)


def test_what_a_light_field_does_not_record_is_named_and_left_out(recorded, tmp_path, capsys):
    path = tmp_path / "field.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--focus", "1.2m", *SMALL, "--ghosts", "--stars",
                 "--view", "depth", "-o", str(path)]) == 0
    said = capsys.readouterr().err
    assert "ghosts and stars are left out" in said and "the view depth is left out" in said
    assert load_light_field(path).settings == load_light_field(recorded).settings   # refocused pictures are developed


@pytest.mark.parametrize("command", [["capture", "--views", "1x1"], ["array", "--views", "1x1"],
                                     ["chart", "--views", "1"]], ids=lambda command: command[0])
def test_what_the_reader_of_a_scene_changed_is_reported(command, tmp_path, capsys):
    OpenEXR.File({}, {name: np.eye(4, 8, dtype=np.float32) - 0.1 for name in "RGB"}).write(str(tmp_path / "sky.exr"))
    (tmp_path / "a.toml").write_text('[sky]\nimage = "sky.exr"\n')
    output = [] if command[0] == "chart" else ["-o", str(tmp_path / "a.npz")]
    assert main(["lightfield", *command, "pbrt-dgauss-50mm", "--scene", str(tmp_path / "a.toml"), "--size", "8x6",
                 "--lens-model", "thin", "--samples", "1", *output]) == 0
    assert "are negative and count as 0" in capsys.readouterr().err


def test_a_picture_of_it_carries_its_settings(recorded, tmp_path, capsys):
    picture = tmp_path / "near.png"
    assert main(["lightfield", "refocus", str(recorded), "--focus", "0.9m", "--f-number", "5.6", "-o",
                 str(picture)]) == 0
    assert "focused at 0.9 m" in capsys.readouterr().out
    settings = read_settings(picture)
    assert (settings.focus_distance, settings.f_number) == (900.0, 5.6)


def test_a_distance_that_the_lens_cannot_be_focused_at_is_taken_for_the_nearest_and_said(recorded, tmp_path, capsys):
    assert main(["lightfield", "refocus", str(recorded), "--focus", "1cm", "-o", str(tmp_path / "a.png")]) == 0
    assert "the nearest distance instead of 0.01 m" in capsys.readouterr().out


def test_a_lens_focused_by_real_rays_is_captured_and_refocused(tmp_path, capsys):
    field = tmp_path / "real.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--focus-position=real", *SMALL, "-o", str(field)]) == 0
    assert "can be focused without gaps from" in capsys.readouterr().out
    assert main(["lightfield", "refocus", str(field), "--focus", "1cm", "-o", str(tmp_path / "near.png")]) == 0
    assert read_settings(tmp_path / "near.png").focus_distance == load_light_field(field).field.nearest


def looked_at(recorded, tmp_path, capsys, *arguments):
    """The floats of the picture that `lightfield view` writes, and its figures."""
    path = tmp_path / "looked.exr"
    assert main(["lightfield", "view", str(recorded), *map(str, arguments), "-o", str(path), "--json"]) == 0
    return OpenEXR.File(str(path)).channels()["RGB"].pixels, json.loads(capsys.readouterr().out)


def test_views_pixels_and_lines_are_those_that_were_recorded(recorded, tmp_path, capsys):
    field = load_light_field(recorded).field
    picture, figures = looked_at(recorded, tmp_path, capsys, "--at", 0.6, 0.5)
    assert figures["view"] == [2, 1] and np.array_equal(picture, field.view(2, 1))
    assert figures["place"] == pytest.approx(field.places[1, 2].tolist())
    picture, figures = looked_at(recorded, tmp_path, capsys, "--pixel", 20, 10)
    assert np.allclose(figures["radiance"], [[field.view(i, j)[10, 20] for i in range(3)] for j in range(2)])
    assert np.array_equal(picture[0, 2], field.view(2, 1)[10, 20])          # v runs up, lines down
    # The rays of one pixel leave the film within a pixel, and the pupil's cells are as far apart as they are wide
    assert np.ptp(np.array(figures["film_mm"])[..., 0]) < 1.0 and np.array(figures["film_mm"]).shape == (2, 3, 2)
    exit_pupil = lb.first_order(field.camera.lens).exit_pupil
    assert np.diff(np.array(figures["pupil_mm"])[0, :, 0]) == pytest.approx(2.0 / 3.0 * field.reach * exit_pupil.radius,
                                                                            rel=0.01)
    picture, figures = looked_at(recorded, tmp_path, capsys, "--epipolar", 7)
    assert np.array_equal(picture[::-1], [field.view(i, 1)[7] for i in range(3)]) and figures["line"] == 7


def test_limits_of_the_depth_are_named_where_no_depth_is_asked_for(recorded, tmp_path, capsys):
    assert main(["lightfield", "view", str(recorded), "--at", "0", "0", "--nearest", "1m", "--farthest", "2m", "-o",
                 str(tmp_path / "a.png")]) == 0
    said = capsys.readouterr().err
    assert "--nearest has no effect" in said and "--farthest has no effect" in said


def test_depth_is_metres_in_linear_files_and_colours_in_others(recorded, tmp_path, capsys):
    field = load_light_field(recorded).field
    depth = lb.find_depth(field, 600.0, 3000.0)
    limits = ("--nearest", "0.6m", "--farthest", "3m")
    picture, figures = looked_at(recorded, tmp_path, capsys, "--depth", *limits)
    assert np.allclose(picture[..., 0], depth.distance / 1000.0)
    assert depth.distance.min() >= 600.0 - 1e-3 and depth.distance.max() <= 3000.0 + 1e-3
    assert (figures["farthest_m"], figures["nearest_m"]) == pytest.approx([end / 1000.0 for end in ends(depth)])
    picture, _ = looked_at(recorded, tmp_path, capsys, "--all-in-focus", *limits)
    assert np.array_equal(picture, depth.picture)
    path = tmp_path / "depth.png"
    assert main(["lightfield", "view", str(recorded), "--depth", *limits, "-o", str(path)]) == 0
    with Image.open(path) as coloured:
        assert np.abs(np.asarray(coloured) / 255.0 - depth_codes(depth)).max() < 0.003      # half a step of 255


def test_a_plenoptic_camera_is_recorded_saved_and_looked_into(tmp_path, capsys):
    path = tmp_path / "sensor.npz"
    assert main(["lightfield", "capture", "pbrt-dgauss-50mm", "--size", "36x24", "--microlenses", "3", "--samples", "1",
                 "--microlens-f-number", "4", "-o", str(path)]) == 0
    told = capsys.readouterr().out
    recording = load_light_field(path)
    plenoptic = lb.PlenopticCamera(camera(recording.settings), 3, 4.0)
    raw = plenoptic.expose(lb.builtin_scene("still-life"), 1, recording.settings.seed)
    assert np.array_equal(recording.raw.picture, raw.picture) and np.array_equal(recording.raw.white, raw.white)
    assert np.array_equal(recording.field.light, raw.decoded().light)
    assert f"{100.0 * plenoptic.spilled:.0f} % of the light spilled" in told and plenoptic.spilled > 0.05
    picture, figures = looked_at(path, tmp_path, capsys, "--sensor")
    assert np.array_equal(picture, raw.picture) and figures["fill"] == pytest.approx(plenoptic.fill) and \
        figures["microlenses"] == [36, 24]
    picture, figures = looked_at(path, tmp_path, capsys, "--microlens", 20, 10)
    assert np.array_equal(picture, raw.behind(20, 10)) and np.allclose(figures["radiance"], picture)
    assert main(["lightfield", "refocus", str(path), "--focus", "2m", "-o", str(tmp_path / "far.png")]) == 0
    for arguments, says in ((["capture", "pbrt-dgauss-50mm", "--microlens-f-number", "4", "-o", "a.npz"], "goes with"),
                            (["view", str(path), "--microlens", "36", "0", "--json"], "0 to 35"),
                            (["capture", "pbrt-dgauss-50mm", "--microlenses", "0", "-o", "a.npz"], "0")):
        assert main(["lightfield", *arguments]) == 2
        assert says in capsys.readouterr().err


def test_what_cannot_be_is_one_line(recorded, tmp_path, capsys):
    cut, other = tmp_path / "cut.npz", tmp_path / "other.npz"
    cut.write_bytes(recorded.read_bytes()[:2000])
    np.savez(other, light=np.zeros(3))
    fake = tmp_path / "fake.npz"
    with np.load(recorded) as archive:
        arrays = {name: archive[name] for name in archive if name != "checksum"}
        np.savez(fake, **arrays | {"coverage": np.zeros((2, 3, 5, 5), np.float16)})
    for arguments, says in (
            (["refocus", str(cut)], "cut short"), (["refocus", str(tmp_path / "no.npz")], "No such file"),
            (["refocus", str(other)], "lightfield capture records one"),
            (["refocus", str(fake)], "not those of its settings"),
            (["refocus", str(recorded), "--f-number", "1"], "was not recorded"),
            (["refocus", str(recorded), "--view", "x"], "two numbers"),
            (["refocus", str(recorded), "--focus=-1m"], "focus distance -1000 mm: it must lie from"),
            (["refocus", str(recorded), "--focus=0"], "focus distance 0 mm: it must lie from"),
            (["refocus", str(recorded), "--focus=1e20"], "it must lie from"),
            (["capture", "pbrt-dgauss-50mm", "--views", "0x3"], "views across and down"),
            (["capture", "pbrt-dgauss-50mm", "--lens-model", "pinhole"], "through a lens"),
            (["capture", "--camera", "environment"], "not projective")):
        suffix = ".npz" if arguments[0] == "capture" else ".png"
        assert main(["lightfield", *arguments, "-o", str(tmp_path / f"out{suffix}")]) == 2
        error = capsys.readouterr().err
        assert says in error and error.count("\n") == 1, error
        assert not (tmp_path / f"out{suffix}").exists()
    upside_down = ["--depth", "--nearest", "9m", "--farthest", "2m"]
    for arguments, says in ((["--at", "3", "0"], "reach from"), (["--pixel", "36", "0"], "0 to 35 across"),
                            (["--epipolar", "24"], "0 to 23"), (upside_down, "must be nearer"),
                            (["--depth", "--nearest=-1m"], "must be positive"),
                            (["--sensor"], "without microlenses"), ([], "one of the arguments")):
        assert main(["lightfield", "view", str(recorded), *arguments, "--json"]) == 2
        error = capsys.readouterr().err
        assert says in error and error.count("\n") == 1, error
    assert main(["lightfield", "view", str(recorded), "--at", "0", "0"]) == 2
    assert "-o FILE" in capsys.readouterr().err
    with pytest.raises(ExportError, match=r"written as \.npz"):
        save_light_field(tmp_path / "a.zip", load_light_field(recorded))


def test_the_archive_is_one_that_numpy_reads(recorded):
    with np.load(recorded, allow_pickle=False) as archive:
        light = archive["light"]                # of twice the pixels, with a margin
        assert light.dtype == np.float16 and light.shape[:3] == (2, 3, 3)
        assert 48 <= light.shape[3] <= 48 + 4 * 3 and 72 <= light.shape[4] <= 72 + 4 * 4
        assert json.loads(str(archive["settings"]))["lens"] == "pbrt-dgauss-50mm"
