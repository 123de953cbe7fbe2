"""Lenses in JSON: Optiland's and rayoptics' files, what they say of surfaces and glasses, and what is refused."""

import json
from copy import deepcopy

import pytest

from lensbench import AIR, Glass
from lensbench.lenses import glass_catalogue
from tests.lenses.samples import DATA, loaded, refusal

OPTILAND = json.loads((DATA / "four.json").read_text())
RAYOPTICS = json.loads((DATA / "pair.roa").read_text())


def changed(model, keys, value):
    """The text of the file with one value set."""
    model = deepcopy(model)
    place = model
    for key in keys[:-1]:
        place = place[key]
    place[keys[-1]] = value
    return json.dumps(model, indent=1)


def surface(i, *keys):
    return ["surface_group", "surfaces", i, *keys]


def sequence(*keys):
    return ["optical_model", "attributes", "seq_model", "attributes", *keys]


def ifc(i, *keys):
    return sequence("ifcs", i, "attributes", *keys)


def test_optiland_surfaces_and_places(tmp_path):
    lens = loaded(tmp_path, "lens.json", json.dumps(OPTILAND))
    assert [s.curvature for s in lens.surfaces] == [1 / 40, -1 / 80, 0.0, -1 / 60, 1 / 90]
    assert [s.thickness for s in lens.surfaces] == [5.5, 2.5, 3.25, 2.0, 100.0]
    assert [s.semi_diameter for s in lens.surfaces] == [9.5, 9.0, 6.0, 7.0, 7.5]
    assert [s.glass for s in lens.surfaces] == [glass_catalogue.find("N-BK7"), AIR, AIR, Glass(1.62, 36.3), AIR]
    assert (lens.surfaces[1].conic, lens.surfaces[1].aspheric) == (-0.5, ((4, 1.5e-6), (6, -2e-9)))
    assert lens.surfaces[4].aspheric == ((3, 1e-6),)
    assert (lens.stop_index, lens.name, lens.findings) == (2, "Made-up four", ())


def test_optiland_rims_that_are_missing_are_estimated(tmp_path):
    lens = loaded(tmp_path, "lens.json", changed(OPTILAND, surface(1, "aperture"), None))
    assert lens.surfaces[0].semi_diameter > 6.0 and any("no rim for surface 0" in told for told in lens.findings)


@pytest.mark.parametrize(("keys", "value", "told"), [
    (surface(2, "is_reflective"), True, "mirror"), (surface(2, "geometry", "cs", "rx"), 0.1, "tilt"),
    (surface(2, "geometry", "cs", "y"), 0.1, "decentre"), (surface(2, "geometry", "type"), "Zernike", "Zernike"),
    (surface(2, "geometry", "coefficients"), [1.0], "another"), (surface(2, "geometry", "radius"), None, "radius"),
    (surface(4, "material_post"), {"type": "Material", "name": "N-BK77"}, "N-BK7"),
    (surface(5, "geometry", "coefficients"), [1e-3], "cone"), (surface(2, "type"), "ParaxialSurface", "Paraxial"),
    (surface(2, "geometry", "cs", "z"), float("nan"), "z is nan")])
def test_optiland_refusals_name_surface_and_line(tmp_path, keys, value, told):
    text = changed(OPTILAND, keys, value)
    if told == "another":                               # an r² term alone is a lens
        assert loaded(tmp_path, "lens.json", text).surfaces[1].aspheric == ((2, 1.0),)
        return
    error = refusal(tmp_path, "lens.json", text)
    assert told in error.reason and f"surface {keys[2]}:" in error.reason
    assert text.split("\n")[error.line - 1].strip() == "{"


def test_rayoptics_surfaces_gaps_and_profiles(tmp_path):
    lens = loaded(tmp_path, "lens.roa", json.dumps(RAYOPTICS))
    assert [s.curvature for s in lens.surfaces] == [0.025, -0.0125, 0.0, -0.02, 0.0]
    assert [s.thickness for s in lens.surfaces] == [5.5, 2.5, 3.25, 2.0, 100.0]
    assert [s.semi_diameter for s in lens.surfaces] == [9.5, 9.0, 6.0, 7.0, 7.5]
    assert [s.glass for s in lens.surfaces] == [glass_catalogue.find("N-BK7"), AIR, AIR, Glass(1.62, 36.3), AIR]
    assert (lens.surfaces[1].conic, lens.surfaces[1].aspheric) == (-0.5, ((4, 1.5e-6), (6, -2e-9)))
    assert lens.surfaces[3].conic == 0.25 and lens.surfaces[4].aspheric == ((3, 1e-6),)
    assert (lens.stop_index, lens.name) == (2, "Made-up pair")


def test_rayoptics_rims_of_one_everywhere_are_none(tmp_path):
    model = deepcopy(RAYOPTICS)
    for item in model["optical_model"]["attributes"]["seq_model"]["attributes"]["ifcs"]:
        item["attributes"]["max_aperture"] = 1.0
    lens = loaded(tmp_path, "lens.roa", json.dumps(model))
    assert lens.surfaces[0].semi_diameter > 6.25 and any("every surface" in told for told in lens.findings)


@pytest.mark.parametrize(("keys", "value", "told"), [
    (ifc(2, "interact_mode"), "reflect", "mirror"), (ifc(2, "decenter"), {"dec": 1}, "tilt"),
    (ifc(2, "phase_element"), {}, "grating"), (ifc(2, "profile_id"), "77", "profile"),
    (sequence("ifcs", 2, "__instance_type__"), ["rayoptics.oprops.thinlens", "ThinLens"], "ThinLens"),
    (sequence("gaps", 2, "attributes", "thi"), "x", "thi")])
def test_rayoptics_refusals_name_surface_and_line(tmp_path, keys, value, told):
    text = changed(RAYOPTICS, keys, value)
    error = refusal(tmp_path, "lens.roa", text)
    assert told in error.reason and "surface 2:" in error.reason
    assert text.split("\n")[error.line - 1].strip() == "{"


def test_other_json_is_no_lens(tmp_path):
    for name in ("a.json", "a.roa"):
        assert "no " in refusal(tmp_path, name, '{"a": [1, 2]}').reason
        assert "braces" in refusal(tmp_path, name, "[1, 2]").reason
        assert refusal(tmp_path, name, '{"a":\n 1,}').line == 2
        assert "nested" in refusal(tmp_path, name, '{"a":' * 100_000).reason
