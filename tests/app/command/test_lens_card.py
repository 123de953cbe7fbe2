"""`lensbench info`: provenance, elements, glasses, what is estimated, and the result of the check."""

import json
from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.command.main import main
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, Wavelength

ZOOM = "canon-ef-usm-28-200-f35"

THIN = ("no doubts; surface 1: the element between surfaces 1 and 2, 61.6 mm across, is 0.21 mm thick at its estimated "
        "clear aperture: an edge chips below 0.5 % of the diameter, or 0.1 mm")


def lines(capsys, *arguments):
    assert main(["info", *arguments]) == 0
    return capsys.readouterr().out.splitlines()


def value(printed, label):
    return next((line[46:].strip() for line in printed if line.startswith(label)), None)


def test_provenance_elements_and_check_are_printed(capsys):
    printed = lines(capsys, ZOOM)
    assert [value(printed, label) for label in ("Maker", "Designer", "Patent", "Made for", "Elements", "Check")] == [
        "Canon", "Makoto Mitsusaka", "JP 2001-350095 A", "36 × 24 mm",
        "16 in 12 groups, 2 aspheres, 1 focus group", THIN]
    assert value(printed, "Estimated").startswith("all rims")


def test_figures_that_follow_from_estimates_have_a_star_and_others_have_none(capsys):
    printed = lines(capsys, ZOOM)
    assert value(printed, "Nearest focus").endswith("m*") and value(printed, "f-number").endswith("*")
    assert "*" not in value(printed, "Effective focal length")
    glasses = [line for line in printed if "S-TIH53WN" in line]
    assert len(glasses) == 4 and all("1.84666  23.90" in line and "*" in line for line in glasses)
    published = lines(capsys, "pbrt-dgauss-50mm")
    assert not any("*" in line for line in published) and value(published, "Estimated") is None


def test_json_has_glasses_counts_and_findings(capsys, tmp_path):
    assert main(["info", "lv-nikon-z-58f095-noct", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["elements"], data["groups"], data["maker"], data["film_size"]) == (17, 10, "Nikon", [36.0, 24.0])
    lens = lenses.load("lv-nikon-z-58f095-noct")
    assert [(glass["n_d"], glass["v_d"]) for glass in data["glasses"]] == [
        (s.glass.n_d, s.glass.v_d) for s in lens.surfaces[:-1] if s.glass.n_d != 1.0]
    assert data["check"] == []

    # The check of a lens with an error: its sign of a radius lost
    broken = list(lens.surfaces)
    broken[0] = replace(broken[0], curvature=-broken[0].curvature)
    lenses.save(replace(lens, surfaces=tuple(broken)), tmp_path / "broken.toml")
    assert main(["info", str(tmp_path / "broken.toml"), "--json"]) == 0
    assert any(finding["severity"] == "warning" for finding in json.loads(capsys.readouterr().out)["check"])
    assert "lensbench check" in value(lines(capsys, str(tmp_path / "broken.toml")), "Check")


def test_what_a_file_states_of_the_system_is_printed(capsys, tmp_path):
    path = tmp_path / "near.toml"
    system = SystemData(Aperture(ApertureKind.WORKING_F_NUMBER, (5.6,)), FieldKind.OBJECT_HEIGHT,
                        (FieldPoint(0.0, 0.0), FieldPoint(0.0, 12.5, 2.0, (0.0, 0.0, 0.1, 0.3))),
                        (Wavelength(0.486), Wavelength(0.588), Wavelength(0.656)), 1, (420.0,))
    lenses.save(replace(lenses.load("pbrt-dgauss-50mm"), system=system), path)
    printed = lines(capsys, str(path))
    assert [value(printed, f"Designed {quantity}") for quantity in ("aperture", "fields", "wavelengths", "object")] == [
        "working f-number 5.6", "object height 0, 12.5 mm, weights 1, 2, with vignetting factors",
        "486, 588, 656 nm, the primary one 588 nm", "420 mm before the first vertex"]
    assert main(["info", str(path), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["system"]["aperture"] == {"kind": "working f-number", "values": [5.6]}
    assert data["system"]["fields"][1]["vignetting"] == [0.0, 0.0, 0.1, 0.3]
    assert data["system"]["object_distances"] == [420.0] and data["system"]["primary"] == 1
    assert not any(line.startswith("Designed") for line in lines(capsys, "pbrt-dgauss-50mm"))


@pytest.mark.parametrize("options", [("--f-number", "8"), ("--zoom", "1", "--close", "1")])
def test_the_check_is_that_of_the_design_at_any_setting(capsys, options):
    assert value(lines(capsys, ZOOM, *options), "Check") == THIN


@pytest.mark.parametrize("command", ["info", "check", "convert"])
def test_terminal_escapes_of_a_lens_file_are_shown_and_not_sent(tmp_path, capsys, command):
    evil = "red\x1b[31m\nline"
    lens = lenses.load("pbrt-dgauss-50mm")
    glass = replace(lens.surfaces[0].glass, name=evil)
    lens = replace(lens, name=evil, notes=evil, maker=evil, patent=evil,
                   surfaces=(replace(lens.surfaces[0], glass=glass), *lens.surfaces[1:]))
    lenses.save(lens, tmp_path / "evil.toml")
    assert lenses.load(tmp_path / "evil.toml").name == evil
    target = [str(tmp_path / "a.zmx")] if command == "convert" else []
    assert main([command, str(tmp_path / "evil.toml"), *target]) == 0
    told = "".join(capsys.readouterr())
    assert "\x1b" not in told and (command != "info" or r"red\x1b[31m\nline" in told)


def test_a_plane_plate_has_no_field_of_view(capsys, tmp_path):
    lenses.save(lb.Lens((lb.Surface(1.0, 5.0, lb.Glass(1.5), curvature=0.0), lb.Surface(10.0, 5.0, curvature=0.0)), 0),
                tmp_path / "a.toml")
    assert value(lines(capsys, str(tmp_path / "a.toml")), "Field of view") == (
        "none: this lens does not converge: it forms no real image and has no nearest distance")
