"""The command line: what people write becomes Settings; bad input ends with 2 and one line."""

import json
import math
import os
import re
import shlex
import sys
import types
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

import lensbench as lb
from lensbench import lenses
from lensbench.app.bench.framing import framed
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.command import options
from lensbench.app.command.main import main
from lensbench.app.session import picture_render
from lensbench.app.session.export import read_settings, save_picture
from lensbench.app.session.states import save_session, session_path, state_text
from lensbench.app.settings import text_values
from lensbench.app.settings.settings import Settings

README = Path(__file__).parents[3] / "README.md"
COMMANDS = README.parent / "docs" / "commands.md"
LENS = "pbrt-dgauss-50mm"


@pytest.fixture
def viewed(monkeypatch, tmp_path):
    """What `lensbench view` hands to the window, instead of a window; the machine has a display."""
    calls = []
    window = types.ModuleType("lensbench.app.window.window")
    window.run = lambda settings, screenshot=None, **_: calls.append((settings, screenshot))
    monkeypatch.setitem(sys.modules, "lensbench.app.window.window", window)
    monkeypatch.setattr("lensbench.app.window.window", window, raising=False)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))          # no earlier session
    return calls


@pytest.fixture
def rendered(monkeypatch):
    """What `lensbench render` hands to the export, instead of rendering."""
    calls = []
    def export_render(settings, path, bits, progress, **rest):
        calls.append((settings, str(path), {"bits": bits, **rest}))
        progress(0.5)
        return picture_render.Rendered((settings.pixels_y, settings.pixels_x), settings.samples)

    monkeypatch.setattr(picture_render, "export_render", export_render)
    return calls


def settings_of(viewed, *words):
    assert main(["view", *words]) == 0
    return viewed[-1][0]


# Units


@pytest.mark.parametrize(("read", "text", "value"), [
    (options.read_size, "960x640", (960, 640)),
    (options.read_size, " 1920 × 1080 ", (1920, 1080)),
    (options.read_film, "36x24", (36.0, 24.0)),
    (options.read_film, "5.6 x 4.2mm", (5.6, 4.2)),
    (options.read_film, "aps-c", (23.5, 15.6)),
    (options.read_film, "Full Frame", (36.0, 24.0)),
    (options.read_film, "micro-four-thirds", (17.3, 13.0)),
    (options.read_film, "6x7", (70.0, 56.0)),
    (options.read_film, "44x33", (44.0, 33.0)),
    (text_values.read_aperture, "f/2.8", 2.8),
    (text_values.read_aperture, "open", None),
    (text_values.read_extent, "2 cm", 20.0),
    (text_values.read_position, "0,20cm,-1.5m", (0.0, 200.0, -1500.0)),
    (text_values.read_count, "12", 12),
    (text_values.read_seed, "0", 0),
])
def test_a_value_with_its_unit_is_read_in_the_units_of_the_core(read, text, value):
    assert read(text) == (pytest.approx(value) if value is not None else None)


@pytest.mark.parametrize("name", lb.FORMATS)
def test_every_film_format_is_found_by_its_full_name(name):
    assert options.read_film(name) == lb.FORMATS[name]


@pytest.mark.parametrize(("read", "text", "said"), [
    (options.read_size, "960", "such as 960x640"),
    (options.read_size, "-4x3", "such as 960x640"),
    (options.read_size, "0x10", "at least 1 each, such as 960x640"),
    (options.read_size, "10x0", "at least 1 each"),
    (text_values.read_extent, "nan", "a length of at least 0, such as 21.6 mm"),
    (text_values.read_extent, "-1", "a length of at least 0"),
    (options.read_film, "apsc-d", "APS-C"),
    (options.read_film, "1", "36x24"),
    (text_values.read_aperture, "wide-ish", "such as f/2.8"),
    (text_values.read_position, "1,2", "three distances"),
    (text_values.read_count, "0", "at least 1"),
    (text_values.read_count, "1.5", "at least 1"),
    (text_values.read_seed, "4294967296", "4294967295"),
])
def test_a_value_that_makes_no_sense_is_answered_by_what_to_type(read, text, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        read(text)


# Settings


def test_without_a_command_the_bench_opens_as_it_is(viewed):
    assert main([]) == 0
    assert viewed == [(Settings(), None)]


def test_the_bench_opens_as_it_was_closed_unless_something_is_asked_for(viewed, capsys):
    last = replace(Settings(), f_number=8.0, scene="room")
    save_session(last)
    assert main([]) == 0 and main(["view", "--scene", "night-lights"]) == 0
    assert viewed[0][0] == last and viewed[1][0].f_number == Settings().f_number
    assert capsys.readouterr().err == ""
    session_path().write_text("broken")
    assert main([]) == 0 and viewed[2][0] == Settings()
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "the last session is not opened again" in said and str(session_path()) in said


def test_the_bench_opens_without_a_picture_in_the_stop_that_is_gone(viewed, capsys, tmp_path):
    last = replace(Settings(), f_number=8.0, stop_image=str(tmp_path / "gone.png"))
    save_session(last)
    assert main([]) == 0
    assert viewed[0][0] == replace(last, stop_image="")
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "gone.png" in said and "opens without it" in said
    assert main(["view", "--settings", str(session_path())]) == 0 and viewed[1] == viewed[0]
    assert "opens without it" in capsys.readouterr().err
    assert main(["view", LENS, "--stop-image", last.stop_image]) == 2
    assert "No such file" in capsys.readouterr().err and len(viewed) == 2


def test_a_state_text_opens_the_bench(viewed, capsys):
    state = replace(Settings(), f_number=4.0, scene="room", pixels_x=300, pixels_y=200)
    assert settings_of(viewed, state_text(state)) == state
    assert main(["view", state_text(state)[:-6]]) == 2 and "damaged" in capsys.readouterr().err


def test_every_option_arrives_in_the_settings(viewed):
    settings = settings_of(viewed, LENS, *shlex.split(
        "--focus 120cm --f-number f/4 --scene room --lens-model thin --film 24x16 --size 300x200 --position 1,0,-0.5 "
        "--yaw 10 --pitch=-5deg --samples 9 --seed 7 --exposure -1.5 --tone agx --focal-length 35mm"))
    assert settings == Settings(
        lens=LENS, focus_distance=pytest.approx(1200.0), f_number=4.0, scene="room", lens_model="thin", film_width=24.0,
        film_height=16.0, pixels_x=300, pixels_y=200, position=pytest.approx((1000.0, 0.0, -500.0)),
        yaw=pytest.approx(math.radians(10.0)), pitch=pytest.approx(math.radians(-5.0)), samples=9, seed=7,
        exposure=-1.5, tone="agx", focal_length=35.0)


def test_pixels_alone_cut_the_film_to_their_shape(viewed):
    settings = settings_of(viewed, LENS, "--size", "640x360")
    assert (settings.film_width, settings.film_height) == pytest.approx((36.0, 20.25))
    assert (settings_of(viewed, LENS, "--size", "100x100").film_width) == pytest.approx(24.0)


def test_a_film_alone_gets_pixels_of_its_shape(viewed):
    settings = settings_of(viewed, LENS, "--film", "6x6")
    assert settings.pixels_x == settings.pixels_y == Settings().pixels_x


def test_a_film_and_pixels_of_another_shape_are_taken_as_they_are(viewed):
    settings = settings_of(viewed, LENS, "--film", "36x24", "--size", "100x100")
    assert (settings.film_width, settings.film_height, settings.pixels_x, settings.pixels_y) == (36.0, 24.0, 100, 100)


def test_the_field_of_view_crops_the_film_behind_a_lens(viewed):
    settings = settings_of(viewed, LENS, "--fov", "20deg")
    efl = lb.first_order(lenses.load(LENS)).efl
    assert 2.0 * math.degrees(math.atan(settings.film.height / 2.0 / efl)) == pytest.approx(20.0)
    assert settings_of(viewed, LENS, "--fov", "20deg", "--camera", "perspective").crop == 1.0


def test_a_lens_opens_at_its_best_except_for_what_the_options_name(viewed):
    telephoto = "pbrt-telephoto-250mm"
    assert settings_of(viewed, telephoto) == with_lens(Settings(), telephoto)
    got = settings_of(viewed, telephoto, "--f-number", "8", "--focus", "3m", "--film", "24x16")
    assert (got.f_number, got.focus_distance, got.position) == (8.0, 3000.0, (0.0, 0.0, 0.0))
    assert (got.film_width, got.film_height) == (24.0, 16.0)
    zoom = "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"
    assert settings_of(viewed, zoom, "--zoom", "1") == with_lens(Settings(), zoom, zoom=1.0)
    room = settings_of(viewed, telephoto, "--scene", "room")
    assert room == with_lens(replace(Settings(), scene="room", exposure=0.3), telephoto)


def test_the_camera_is_placed_by_framing_film_and_field_of_view(viewed, capsys):
    for line in ("--framing head", "--film aps-c", "--fov 10deg", "--framing head --film 6x6"):
        settings = settings_of(viewed, LENS, "--scene", "portrait", *line.split())
        assert framed(settings) == settings, line
    assert settings.framing == "head" and settings.film_width == 56.0
    assert main(["view", LENS, "--framing", "head"]) == 2
    assert "this scene has close, subject, whole-scene" in capsys.readouterr().err
    assert main(["view", LENS, "--framing", "close", "--focus", "2m"]) == 2
    assert "leave out --focus" in capsys.readouterr().err


def test_a_lens_that_cannot_focus_at_the_default_is_focused_near_its_nearest(viewed):
    settings = settings_of(viewed, LENS, "--focal-length", "800mm")
    assert settings.focus_distance > 3000.0
    lb.film_distance(lenses.load(LENS).scaled(800.0 / lb.first_order(lenses.load(LENS)).efl), settings.focus_distance)


def test_an_exported_picture_in_place_of_a_lens_brings_its_settings(viewed, tmp_path, rendered):
    import numpy as np

    exported = replace(Settings(), lens=LENS, seed=5, focus_distance=math.inf)
    save_picture(tmp_path / "a.png", np.zeros((4, 6, 3), np.float32), exported)
    assert settings_of(viewed, str(tmp_path / "a.png")) == exported
    assert settings_of(viewed, str(tmp_path / "a.png"), "--focus", "2", "--f-number", "open") == replace(
        exported, focus_distance=2000.0, f_number=None)


def test_a_lens_file_is_remembered_by_its_whole_path(viewed, tmp_path, monkeypatch):
    lenses.save(lenses.load(LENS), tmp_path / "mine.toml")
    monkeypatch.chdir(tmp_path)
    assert settings_of(viewed, "mine.toml").lens == str(tmp_path / "mine.toml")


def test_the_bench_does_not_open_on_a_scene_that_is_not_there(viewed, capsys):
    assert main(["view", "--scene", "still-live"]) == 2
    assert "did you mean still-life?" in capsys.readouterr().err
    assert main(["view", "--scene", "gone.toml"]) == 2
    assert "gone.toml" in capsys.readouterr().err and viewed == []


# Where it goes


def test_without_a_display_the_window_is_written_to_a_file(viewed, monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    assert main(["view"]) == 0
    assert viewed[-1][1] == Path("lensbench-window.png")
    assert "lensbench-window.png" in capsys.readouterr().out


@pytest.mark.parametrize(("name", "content", "kind"), [
    ("a.bin", b"glTF....", "opened"), ("a.obj", b"v 0 0 0\n", "opened"), ("a.hdr", b"#?RADIANCE\n", "opened"),
    ("a.jpg", b"\xff\xd8\xff\xe0", "opened"), ("a.npz", b"PK\x03\x04", "opened"),
    ("a.toml", b"[[sphere]]\ncentre = [0, 0, -900]\nradius = 70\n", "scene"), ("b.toml", b"version = 1\n", "settings")])
def test_the_window_opens_every_kind_of_file_in_place_of_the_lens(viewed, monkeypatch, tmp_path, name, content, kind):
    path = tmp_path / name
    path.write_bytes(content)
    monkeypatch.setattr(sys.modules["lensbench.app.window.window"], "run",
                        lambda settings, screenshot, opened, **_: viewed.append((settings, opened)) or 0)
    assert main(["view", str(path)]) == 0
    settings, given = viewed[-1]
    assert given == (path if kind == "opened" else None)
    assert settings.scene == (str(path) if kind == "scene" else Settings().scene)


def test_a_screenshot_before_the_picture_is_ready_ends_with_1(viewed, monkeypatch, capsys):
    monkeypatch.setattr(sys.modules["lensbench.app.window.window"], "run",
                        lambda settings, screenshot, **_: 1)
    assert main(["view", "--screenshot", "w.png"]) == 1
    assert "not ready in time" in capsys.readouterr().err


def test_a_screenshot_that_cannot_be_written_ends_with_2(viewed, monkeypatch, capsys, tmp_path):
    def run(settings, screenshot, **_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(sys.modules["lensbench.app.window.window"], "run", run)
    assert main(["view", "--screenshot", str(tmp_path / "w.png")]) == 2
    assert "w.png: Permission denied" in one_line(capsys)


@pytest.mark.parametrize(("path", "told"), [("w.jpg", "is written as .png"), ("w", "is written as .png"),
                                            ("no/w.png", "there is no folder")])
def test_a_screenshot_that_is_no_png_is_refused_before_the_window_opens(viewed, capsys, path, told):
    assert main(["view", "--screenshot", path]) == 2
    assert told in one_line(capsys) and not viewed


def test_a_missing_system_library_is_answered_by_its_package(viewed, monkeypatch, capsys):
    monkeypatch.setattr("lensbench.app.command.view.LIBRARIES", ("libEGL.so.1", "libmissing.so.9"))
    monkeypatch.setattr(sys, "platform", "linux")
    assert main(["view"]) == 2
    assert re.search(r"libmissing.so.9.*apt-get install libegl1", one_line(capsys))
    assert not viewed


def test_a_render_goes_to_its_file_with_its_depth_and_threads(rendered, capsys):
    assert main(["render", LENS, "--bits", "16", "--threads", "3", "--size", "60x40", "-o", "x.png"]) == 0
    settings, path, rest = rendered[0]
    assert (settings.pixels_x, settings.pixels_y, path) == (60, 40, "x.png")
    assert (rest["bits"], rest["threads"]) == (16, 3)
    out, err = capsys.readouterr()
    assert out.startswith("x.png: 60 × 40 pixels, 256 samples") and not err


def test_a_picture_is_rendered_with_figures_and_no_bar_off_a_terminal(tmp_path, capsys):
    path = tmp_path / "out.png"
    assert main(["render", LENS, "--size", "24x16", "--samples", "2", "--json", "-o", str(path)]) == 0
    out, err = capsys.readouterr()
    figures = json.loads(out)
    assert figures["pixels"] == [24, 16] and figures["samples"] == 2 and figures["samples_per_second"] > 0.0
    assert not err
    with Image.open(path) as read:
        assert read.size == (24, 16)
    assert read_settings(path).samples == 2


def test_the_bar_is_drawn_on_a_terminal_and_cleared(rendered, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    assert main(["render", LENS, "-o", "x.png"]) == 0
    err = capsys.readouterr().err
    assert "50 %" in err and err.endswith("\r")


def test_the_data_of_a_lens_are_those_of_the_core(capsys):
    assert main(["info", LENS, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    lens = lenses.load(LENS)
    fo = lb.first_order(lens)
    assert data["efl"] == fo.efl and data["f_number"] == fo.f_number
    assert data["t_number"] > data["f_number"]
    assert data["nearest_focus"] == lb.nearest_focus(lens)


@pytest.mark.parametrize("name, index", [
    (LENS, 1.0), (LENS, 1.333), ("canon-178-degree-fisheye-y-155-f28", 1.0)])
def test_the_field_of_view_is_that_of_the_rays_to_the_edge_of_the_film(name, index, capsys, tmp_path):
    lens = replace(lenses.load(name), front_index=index)
    lenses.save(lens, tmp_path / "a.toml")
    capsys.readouterr()
    assert main(["info", str(tmp_path / "a.toml"), "--json"]) == 0
    angles = json.loads(capsys.readouterr().out)["field_of_view"]
    film = lens.length + lb.film_distance(lens, math.inf)
    for axis, half in (("horizontal", 18.0), ("vertical", 12.0), ("diagonal", math.hypot(18.0, 12.0))):
        ray = lb.chief_ray(lens, math.radians(0.5 * angles[axis]))
        y = ray.points[-1, 1] + (film - ray.points[-1, 2]) * ray.direction[1] / ray.direction[2]
        assert abs(y) == pytest.approx(half, abs=1e-4)


def test_the_data_follow_focal_length_and_aperture(capsys):
    assert main(["info", LENS, "--focal-length", "100", "--f-number", "4", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["efl"] == pytest.approx(100.0)
    assert data["f_number"] == pytest.approx(4.0)


def test_the_f_number_of_a_lens_that_is_focused_closer_is_that_at_infinity(capsys):
    """The efl of the near focus over its entrance pupil is no f-number: f/2.21 for a lens of f/2.88."""
    name = "lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed"
    data = {}
    for close in ("0", "1"):
        assert main(["info", name, "--zoom", "1", "--close", close, "--json"]) == 0
        data[close] = json.loads(capsys.readouterr().out)
    for key in ("f_number", "t_number", "transmission", "intrinsics"):
        assert data["1"][key] == pytest.approx(data["0"][key], rel=1e-9)
    assert data["1"]["f_number"] == pytest.approx(2.88, abs=5e-3) and data["1"]["efl"] > 1.03 * data["0"]["efl"]
    assert data["0"]["working_f_number"] is None and data["0"]["focus_distance"] is None
    lens = lenses.load(name).at(zoom=1.0)
    nearest = lb.nearest_focus(lens)
    working = lb.working_f_number(lb.focused(lens, nearest), lb.film_distance(lens, nearest))
    assert data["1"]["focus_distance"] == pytest.approx(nearest)
    assert data["1"]["working_f_number"] == pytest.approx(working) == pytest.approx(3.26, abs=5e-3)
    assert main(["info", name, "--zoom", "1", "--close", "1"]) == 0
    out = capsys.readouterr().out
    assert "f/2.88, focused at infinity" in out and "f/3.26, focused at 1.50 m" in out
    assert "cy 320.00, focused at infinity" in out


def test_the_data_are_printed_for_people_too(capsys):
    assert main(["info", LENS]) == 0
    out = capsys.readouterr().out
    assert "Effective focal length" in out and "Nearest focus" in out


@pytest.mark.parametrize("rows", ["-50 3 1.5 20\n50 5 1 20\n0 2 0 10\n", "0 3 1.5 20\n0 5 1 20\n0 2 0 10\n"])
def test_the_data_of_a_lens_that_forms_no_image_are_printed_all_the_same(tmp_path, capsys, rows):
    (tmp_path / "a.dat").write_text(rows)
    assert main(["info", str(tmp_path / "a.dat")]) == 0
    assert "forms no real image" in capsys.readouterr().out
    assert main(["info", str(tmp_path / "a.dat"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nearest_focus"] is None


@pytest.mark.parametrize("words", [["--help"], ["--version"], *([name, "--help"] for name in (
    "view", "render", "info", "lenses"))])
def test_every_command_explains_itself(words, capsys):
    assert main(words) == 0
    assert "lensbench" in capsys.readouterr().out


# Bad input


def one_line(capsys):
    out, err = capsys.readouterr()
    assert not out and len(err.splitlines()) == 1, (out, err)
    return err


@pytest.mark.parametrize(("line", "said"), [
    ("views", "view"),
    ("render pbrt-dgauss-50mm", "--output"),
    ("render -o a.png", "LENS"),
    ("render pbrt-dgauss-50mm -o a.jpg", ".exr"),
    ("render pbrt-dgauss-50mm -o a", ".png"),
    ("render pbrt-dgauss-50mm -o no/such/folder/a.png", "there is no folder"),
    ("render pbrt-dgaus-50mm -o a.png", "pbrt-dgauss-50mm"),
    ("render missing.toml -o a.png", "missing.toml"),
    ("render pbrt-dgauss-50mm --focus 10cm -o a.png", " m"),
    ("render pbrt-dgauss-50mm --focus near -o a.png", "1.2 m"),
    ("render pbrt-dgauss-50mm --focus -1m -o a.png", "--focus"),
    ("render pbrt-dgauss-50mm --f-number 0.5 -o a.png", "f/"),
    ("render pbrt-dgauss-50mm --f-number 0 -o a.png", "f-number"),
    ("render pbrt-dgauss-50mm --f-number=-2 -o a.png", "f-number"),
    ("render pbrt-dgauss-50mm --f-number nan -o a.png", "f/2.8"),
    ("render pbrt-dgauss-50mm --size 0x10 -o a.png", "at least 1 each, such as 960x640"),
    ("render pbrt-dgauss-50mm --size 1000000x1000 -o a.png", "pixels"),
    ("render pbrt-dgauss-50mm --size 99999999x66666666 -o a.png", "pixels across 99999999: it must lie from 1 to"),
    ("improve lenshh-cooke-triplet-50 --image-height nan", "a length of at least 0, such as 21.6 mm"),
    ("improve lenshh-cooke-triplet-50 --edge -1", "a length of at least 0"),
    ("lightfield novel a.npz --at nan 0 0 -o a.png", "--at nan 0 0: type finite numbers"),
    ("lightfield novel a.npz --turn 0 inf -o a.png", "--turn 0 ∞: type finite numbers"),
    ("lightfield novel a.npz --size 0x10 -o a.png", "at least 1 each, such as 960x640"),
    ("render pbrt-dgauss-50mm --film 0x24 -o a.png", "film"),
    ("render pbrt-dgauss-50mm --fov 90deg -o a.png", "--film"),
    ("render pbrt-dgauss-50mm --fov 0 -o a.png", "from 0.001° to 179.99°"),
    ("render pbrt-dgauss-50mm --fov 0.5deg -o a.png", "sees 1.37° along its shorter side: take a smaller --film"),
    ("render pbrt-dgauss-50mm --samples 0 -o a.png", "at least 1"),
    ("render pbrt-dgauss-50mm --ghosts --ghost-pair 3-99 -o a.png", "from 0 to 10"),
    ("view pbrt-dgauss-50mm --ghosts --ghost-pair 0-5", "surfaces of this lens that reflect"),
    ("render pbrt-dgauss-50mm --bits 12 -o a.png", "16"),
    ("render pbrt-dgauss-50mm --tone warm -o a.png", "filmic"),
    ("render pbrt-dgauss-50mm --lens-model magic -o a.png", "pinhole"),
    ("render pbrt-dgauss-50mm --scene nowhere -o a.png", "lensbench scenes lists the names"),
    ("render pbrt-dgauss-50mm --focal-length 0 -o a.png", "focal length"),
    ("render pbrt-dgauss-50mm --lens-model thin --focal-length 300mm --focus 25cm -o a.png", " m"),
    ("render pbrt-dgauss-50mm --camera perspective --fov 10deg --focus 5cm -o a.png", "0.275 m"),
    ("render other.png -o x.png", "not exported by lensbench"),
    ("view cut.png", "cut.png"),
    ("view missing.png", "missing.png"),
    ("info binary.toml", "binary.toml"),
    ("info folder", "folder"),
    ("info pbrt-dgauss-50mm --f-number 0.3", "f/"),
])
def test_bad_input_ends_with_2_and_one_line_that_says_what_to_do(line, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Image.new("RGB", (8, 8)).save("other.png")
    Path("cut.png").write_bytes(Path("other.png").read_bytes()[:40])
    Path("binary.toml").write_bytes(bytes(range(256)))
    Path("folder").mkdir()
    before = sorted(os.listdir())
    assert main(shlex.split(line)) == 2
    assert said in one_line(capsys)
    assert sorted(os.listdir()) == before


def test_a_failure_of_the_program_ends_with_1_and_one_line(monkeypatch, capsys):
    def broken():
        raise RuntimeError("a\nb\x1b[2J")

    monkeypatch.delenv("LENSBENCH_DEBUG", raising=False)
    monkeypatch.setattr("lensbench.app.command.info.describe", broken)
    assert main(["lenses"]) == 1
    assert r"RuntimeError: a\nb\x1b[2J" in one_line(capsys)
    monkeypatch.setenv("LENSBENCH_DEBUG", "1")
    with pytest.raises(RuntimeError):
        main(["lenses"])


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.slow
def test_the_example_of_the_readme_runs_as_it_stands(capsys):
    (example,) = blocks(README, "python")
    exec(compile(example, str(README), "exec"), {})
    assert re.match(r".*: [\d.]+ mm, f/[\d.]+\n", capsys.readouterr().out)


@pytest.mark.slow
@pytest.mark.long
def test_the_commands_of_the_pages_are_understood(viewed, rendered, monkeypatch, tmp_path, capsys):
    import numpy as np

    from lensbench.app.session import contact_sheet
    from lensbench.app.studies.stability import plots

    monkeypatch.chdir(tmp_path)
    # Each sweep has tests of its own; all of them take a minute
    monkeypatch.setattr(plots, "FAMILIES", {"Refraction": plots.FAMILIES["Refraction"]})
    for name in ("out.png", "stars.png"):
        save_picture(name, np.zeros((4, 6, 3), np.float32), Settings())
    monkeypatch.setattr(contact_sheet, "render", lambda settings, *rest: (np.zeros((4, 6, 3), np.float32), None))
    lines = [line.partition("#")[0] for page in (README, COMMANDS)
             for block in blocks(page, "sh") for line in block.splitlines()]
    assert len(lines) >= 25
    for line in lines:
        assert main(shlex.split(line)[1:]) == 0, line
        assert "has no effect" not in capsys.readouterr().err, line
