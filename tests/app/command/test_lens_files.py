"""`lensbench convert` and `lensbench trace`: what is written, what is said, and mistakes in one line."""

import io
import json
import sys
import types
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.lens_files import read_rays
from lensbench.app.command.main import main
from lensbench.lenses.editing.elements import reversed_lens

LENS = "pbrt-dgauss-50mm"
RAYS = "x,y,z,l,m,n\n0,0,-10,0,0,1\n0,5,-10,0,0.02,2\n0,15,-10,0,0,1\n"


def refused(capsys, *words):
    assert main(list(words)) == 2
    error = capsys.readouterr().err
    assert error.startswith("lensbench: ") and error.count("\n") == 1
    return error


@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".txt", ".len", ".toml"])
def test_convert_there_and_back_is_the_same_lens(tmp_path, capsys, suffix):
    there, back = tmp_path / f"there{suffix}", tmp_path / "back.toml"
    assert main(["convert", LENS, str(there)]) == main(["convert", str(there), str(back)]) == 0
    assert "11 surfaces, the stop at surface 5" in capsys.readouterr().out
    assert lenses.load(back).surfaces == lenses.load(LENS).surfaces
    assert lenses.load(back).stop_index == lenses.load(LENS).stop_index


def test_convert_says_what_was_assumed_and_what_was_lost(tmp_path, capsys):
    (tmp_path / "a.seq").write_text("SO 0 1e14\nS 50 5 1.5:60\nS -50 48\nSI 0 0\nEPD 10\n")
    assert main(["convert", str(tmp_path / "a.seq"), str(tmp_path / "b.dat")]) == 0
    said = capsys.readouterr().out
    assert "Found: no stop is marked (STO)" in said and "Not kept: Abbe numbers" in said


def test_convert_scales_and_turns_round(tmp_path, capsys):
    lens = lenses.load(LENS)
    assert main(["convert", LENS, str(tmp_path / "a.toml"), "--scale", "2", "--reverse"]) == 0
    turned = lenses.load(tmp_path / "a.toml")
    assert turned == reversed_lens(lens.scaled(2.0))
    # By the law of equal focal lengths in air on both sides, and with front and back exchanged
    before, after = lb.first_order(lens), lb.first_order(turned)
    assert after.efl == pytest.approx(2.0 * before.efl, rel=1e-12)
    assert after.bfl == pytest.approx(-2.0 * before.ffl, rel=1e-12)
    twice = reversed_lens(reversed_lens(lens))
    assert twice == replace(lens, surfaces=(*lens.surfaces[:-1], replace(lens.surfaces[-1], thickness=0.0)),
                            stated_f_number=None)
    glued = replace(lens, surfaces=(*lens.surfaces[:-1], replace(lens.surfaces[-1], glass=lb.Glass(1.33))))
    with pytest.raises(lb.LensError, match="cannot be reversed"):
        reversed_lens(glued)


def test_convert_refuses_in_one_line(tmp_path, capsys):
    lens = tmp_path / "a.toml"
    assert main(["convert", LENS, str(lens)]) == 0
    assert "another one" in refused(capsys, "convert", str(lens), str(lens))
    assert ".zmx" in refused(capsys, "convert", LENS, str(tmp_path / "a.xyz"))
    assert "no such file" in refused(capsys, "convert", str(tmp_path / "none.zmx"), str(tmp_path / "b.toml"))
    assert "scale" in refused(capsys, "convert", LENS, str(tmp_path / "b.toml"), "--scale", "-1")
    assert "semi-diameter" in refused(capsys, "convert", LENS, str(tmp_path / "b.toml"), "--scale", "1e9")
    assert not (tmp_path / "b.toml").exists()               # no reader would take it
    (tmp_path / "m.zmx").write_text("SURF 0\nSURF 1\n  GLAS MIRROR\nSURF 2\n")
    told = refused(capsys, "convert", str(tmp_path / "m.zmx"), str(tmp_path / "b.toml"))
    assert "m.zmx:3: SURF 1 is a mirror" in told


def test_trace_writes_what_the_tracer_says_to_the_last_bit(tmp_path, capsys):
    rays = tmp_path / "rays.csv"
    rays.write_text(RAYS)
    expected = lb.trace(lenses.load(LENS), [[0, 0, -10], [0, 5, -10], [0, 15, -10]],
                        [[0, 0, 1], [0, 0.02, 2], [0, 0, 1]], wavelength=0.5)
    assert main(["trace", LENS, "--rays", str(rays), "--wavelength", "0.5"]) == 0
    head, *rows = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    assert head == ["x", "y", "z", "l", "m", "n", "fate", "surface"]
    assert np.array_equal([[float(cell) for cell in row[:3]] for row in rows], expected.points)
    assert np.array_equal([[float(cell) for cell in row[3:6]] for row in rows], expected.directions)
    assert [row[6:] for row in rows] == [["PASSED", "10"], ["PASSED", "10"], ["CLIPPED", "0"]]

    assert main(["trace", LENS, "--rays", str(rays), "--wavelength", "0.5", "-o", str(tmp_path / "out.json")]) == 0
    assert "3 rays: 2 PASSED, 1 CLIPPED" in capsys.readouterr().out
    columns = json.loads((tmp_path / "out.json").read_text())
    assert columns["z"] == expected.points[:, 2].tolist() and columns["fate"] == ["PASSED", "PASSED", "CLIPPED"]
    assert main(["trace", LENS, "--rays", str(rays), "--no-clip", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["surface"][0] == 10


@pytest.mark.parametrize("text", [
    "0 1 2 0 0 1", "0;1;2;0;0;1\n", "0\t1\t2\t0\t0\t1", "# rays\n\n0, 1, 2, 0, 0, 1 # the first",
    '"0","1","2","0","0","1"',
    "n,m,l,z,y,x,weight\n1,0,0,2,1,0,9", "dx dy dz x y z\n0 0 1 0 1 2", "X;Y;Z;L;M;N\n0;1;2;0;0;1"])
def test_tables_of_rays_in_other_hands(tmp_path, text):
    path = tmp_path / "rays.csv"
    path.write_text(text)
    assert read_rays(str(path)) == [[0.0, 1.0, 2.0, 0.0, 0.0, 1.0]]


def test_rays_come_from_the_standard_input(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdin", types.SimpleNamespace(buffer=io.BytesIO(RAYS.encode())))
    assert main(["trace", LENS, "--rays", "-"]) == 0
    assert capsys.readouterr().out.count("\n") == 4


@pytest.mark.parametrize(("text", "told"), [
    ("0 0 0 0 0\n", "rays.csv:1: a ray needs 6 columns"), ("0,0,0,0,0,1\n0,0,x,0,0,1\n", "rays.csv:2: z is 'x'"),
    ("0 0 0 0 0 0", "rays.csv:1: the direction"), ("0 0 0 0 nan 1", "m is 'nan'"), ("", "no rays"),
    ("x y z l m\n", "one column 'n'"), ("\udcff", "no text")])
def test_tables_that_are_none_are_refused_with_their_line(tmp_path, capsys, text, told):
    path = tmp_path / "rays.csv"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    assert told in refused(capsys, "trace", LENS, "--rays", str(path))


@pytest.mark.parametrize(("wavelength", "told"), [
    ("nan", "must be a positive number"), ("-1", "must be a positive number"),
    ("587", "give it in micrometres, such as 0.55 for 550 nm")])
def test_trace_refuses_what_is_no_wavelength_also_of_glasses_of_one_index(tmp_path, capsys, wavelength, told):
    (tmp_path / "rays.csv").write_text(RAYS)
    assert told in refused(capsys, "trace", LENS, "--rays", str(tmp_path / "rays.csv"), f"--wavelength={wavelength}")


@pytest.mark.parametrize(("lens", "wavelength", "told"), [
    (LENS, "0.5", "no dispersion data for this lens: all wavelengths take the same paths"),
    (LENS, "0.5875618", ""), ("lenshh-cooke-triplet-50", "0.5", "")])
def test_trace_says_where_a_wavelength_changes_nothing(tmp_path, capsys, lens, wavelength, told):
    (tmp_path / "rays.csv").write_text(RAYS)
    assert main(["trace", lens, "--rays", str(tmp_path / "rays.csv"), "--wavelength", wavelength]) == 0
    assert capsys.readouterr().err == (f"lensbench: {lens}: {told}\n" if told else "")


def test_trace_refuses_in_one_line(tmp_path, capsys):
    (tmp_path / "rays.csv").write_text(RAYS)
    rays = ["--rays", str(tmp_path / "rays.csv")]
    assert "No such file" in refused(capsys, "trace", LENS, "--rays", str(tmp_path / "none.csv"))
    assert ".csv or .json" in refused(capsys, "trace", LENS, *rays, "-o", str(tmp_path / "out.png"))
    assert "there is no folder" in refused(capsys, "trace", LENS, *rays, "-o", str(tmp_path / "nowhere" / "out.csv"))
    (tmp_path / "a.zmx").write_text("SURF 0\nSURF 1\n CURV 0.02\n DISZ 5\n DIAM 9\n GLAS N-BK7 0 0 1.5 40\n"
                                    "SURF 2\n DISZ 5\n DIAM 9\nSURF 3\n")
    error = refused(capsys, "trace", str(tmp_path / "a.zmx"), *rays, "--wavelength", "20")
    assert "0.3" in error and "2.5" in error            # the range of the glass, µm


def test_the_intrinsics_of_a_lens_are_its_focal_length_in_pixels_and_the_middle_of_the_picture(capsys):
    assert main(["info", LENS, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    intrinsics = data["intrinsics"]
    assert (intrinsics["width"], intrinsics["height"], intrinsics["cx"], intrinsics["cy"]) == (960, 640, 480.0, 320.0)
    assert intrinsics["fx"] == intrinsics["fy"] == pytest.approx(data["efl"] / 36.0 * 960, rel=1e-9)
    assert main(["info", LENS]) == 0
    assert f"fx {intrinsics['fx']:.2f}" in capsys.readouterr().out
