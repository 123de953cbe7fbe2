"""`lensbench analyse`: numbers, sheets of every format, what is left out, and refusals."""

import argparse
import json

import numpy as np
import pytest
from PIL import Image

from lensbench import lenses
from lensbench.app.command.analyse import _options, add_analyse_options
from lensbench.app.command.main import main
from lensbench.app.plots.catalogue import ANALYSES
from lensbench.app.plots.light_plots import Ripple, ripple_surface

NAME = "lib-tronnier-1953"
STOP = lenses.load(NAME).stop_index


def test_the_numbers_of_the_analyses_are_written_as_json_and_csv(capsys, tmp_path):
    path = tmp_path / "numbers.json"
    ask = ["analyse", NAME, "--f-number", "5.6", "--points", "16", "--what", "spots,axial"]
    assert main([*ask, "-o", str(path), "--json"]) == 0
    printed, kept = json.loads(capsys.readouterr().out), json.loads(path.read_text(encoding="utf-8"))
    assert printed == kept and list(kept["analyses"]) == ["spots", "axial"]
    columns = kept["analyses"]["spots"]["columns"]
    assert min(columns["rms radius (um)"]) > 0.0 and len(set(map(len, columns.values()))) == 1
    assert main([*ask, "-o", str(tmp_path / "numbers.csv")]) == 0
    text = (tmp_path / "numbers.csv").read_text(encoding="utf-8")
    assert text.startswith("Spots\nfield (mm)") and "\nLongitudinal aberration and chromatic focal shift\n" in text


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "begins"), [("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")])
def test_the_figures_are_drawn_on_a_sheet(tmp_path, suffix, begins):
    path = tmp_path / f"sheet.{suffix}"
    assert main(["analyse", NAME, "--points", "16", "-o", str(path)]) == 0
    content = path.read_bytes()
    assert content.startswith(begins) and len(content) > 10_000
    if suffix == "pdf":
        assert content.count(b"/Type /Page ") == len(ANALYSES) - 1         # a round stop has no sunstar


def test_fields_wavelengths_and_frequencies_are_those_of_the_options(capsys):
    ask = ["analyse", NAME, "--points", "16", "--what", "fans,mtf", "--fields", "0,10mm", "--wavelengths", "550",
           "--frequencies", "20,60", "--stack", "2", "--coating", "uncoated", "--json"]
    assert main(ask) == 0
    captured = capsys.readouterr()
    sheet = json.loads(captured.out)["analyses"]
    fans, mtf = sheet["fans"]["columns"], sheet["mtf"]["columns"]
    assert {round(field, 6) for field in fans["field (mm)"]} == {0.0, 10.0} and set(fans["wavelength (um)"]) == {0.55}
    assert set(mtf["frequency (lp/mm)"]) == {20.0, 60.0} and len(set(mtf["field (mm)"])) > 2
    assert "--fields has no effect on mtf" in captured.err and "--stack has no effect on fans, mtf" in captured.err
    assert "--coating has no effect on fans, mtf" in captured.err
    assert "--frequencies" not in captured.err


def test_a_picture_in_place_of_the_lens_has_its_focus_unless_another_is_given(capsys, tmp_path):
    path = str(tmp_path / "near.png")
    assert main(["render", NAME, "--focus", "1.2m", "--size", "6x4", "--samples", "1", "-o", path]) == 0
    for options, lens, words in (((), path, "1.20 m"), (("--focus", "2m"), path, "2.00 m"),
                              (("--focus", "inf"), path, "∞"), ((), NAME, "∞")):
        capsys.readouterr()
        assert main(["analyse", lens, *options, "--what", "spots", "--points", "16"]) == 0
        assert f"object {words} ·" in capsys.readouterr().out


def test_a_picture_in_the_stop_weighs_the_rays(capsys, tmp_path):
    """A disc of half the stop's diameter is the stop two stops down."""
    x, y = np.meshgrid(*[np.arange(256) - 127.5] * 2)
    Image.fromarray(np.uint8(255 * (np.hypot(x, y) < 64.0))).save(tmp_path / "disc.png")

    def cone(f_number, *more):
        """How the squared rms radius of the axis point grows with the squared shift of the film."""
        assert main(["analyse", NAME, "--what", "spots", "--points", "64", "--fields", "0", "--wavelengths", "588",
                     "--f-number", f_number, *more, "--json"]) == 0
        columns = json.loads(capsys.readouterr().out)["analyses"]["spots"]["columns"]
        return np.polyfit(columns["film shift (mm)"], 1e-6 * np.square(columns["rms radius (um)"]), 2)[0]

    pictured = cone("4", "--stop-image", str(tmp_path / "disc.png"))
    assert pictured == pytest.approx(cone("8"), rel=0.02) == pytest.approx(1.0 / (8.0 * 8.0**2), rel=0.02)
    assert main(["analyse", NAME, "--stop-image", str(tmp_path / "none.png")]) == 2
    assert "none.png" in capsys.readouterr().err


def test_what_a_lens_does_not_have_is_left_out_with_its_reason(capsys):
    lens = "lentil-schneider-anamorphic-31-2001"
    assert main(["analyse", lens, "--points", "8", "--what", "spots,axial"]) == 0
    captured = capsys.readouterr()
    assert "Left out: axial: " in captured.err and "cylinder" in captured.err and captured.out.startswith("Spots: ")
    assert main(["analyse", lens, "--what", "axial,seidel"]) == 2
    error = capsys.readouterr().err
    assert "no plot of this lens is possible" in error and error.count("cylinder") == 1    # both for one reason


@pytest.mark.parametrize(("arguments", "said"), [
    (["--what", "glare"], "choose from spots"), (["--stack", "2,x"], "1 to 3 numbers"),
    (["--what", "bokeh", "--ripple", "99,1,1"], "numbered from 0 to 8"),
    (["--ripple", f"{STOP},1,1"], f"surface {STOP} is the aperture stop"),
    (["--what", "bokeh", "--ripple", "1.5,1,1"], "no surface 1.5"),
    (["--what", "stack", "--stack", "99"], "no room"),
    (["-o", "sheet.gif"], ".json: choose one"),
    (["--fields", "0,1.5"], "parts of the largest"), (["--fields", "0,80deg", "--what", "spots"], "no ray through"),
    (["--wavelengths", "0.55"], "in nanometres"), (["--frequencies", "0"], "up to 2000 lp/mm"),
    (["--wavelengths", "120", "--what", "spots"], "not at 0.12 µm"),
    (["--points", "3"], "8 to 512"), (["--f-number", "0.1"], "maximum aperture"),
])
def test_impossible_demands_end_with_2_and_one_line(capsys, arguments, said):
    assert main(["analyse", NAME, *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


@pytest.mark.parametrize(("name", "options", "value"), [
    ("ghosts", ["--coating", "uncoated"], {"coating": "uncoated"}), ("ghosts", ["--coating", "auto"], {}),
    ("bokeh", ["--ripple", "0,1,200"], {"ripple": Ripple(0, 1.0, 1e-6 * 200.0)}),
    ("bokeh", ["--ripple", "asphere,1,200"], {"ripple": Ripple(ripple_surface(lenses.load(NAME)), 1.0, 1e-6 * 200.0)})])
def test_options_of_one_analysis_reach_its_figure(name, options, value):
    """--coating was read and had no effect on the ghosts."""
    parser = argparse.ArgumentParser()
    add_analyse_options(parser)
    assert _options(name, parser.parse_args([NAME, *options]), lenses.load(NAME)) == value


def test_the_names_are_listed_without_a_lens(capsys):
    assert main(["analyse", "--what", "list"]) == 0
    assert capsys.readouterr().out.startswith("spots ")
    assert main(["analyse"]) == 2 and "which LENS?" in capsys.readouterr().err
