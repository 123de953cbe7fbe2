"""Lenses in JSON: surfaces, glasses and refusals of Optiland's and rayoptics' files."""

import json
from copy import deepcopy
from dataclasses import replace

import pytest
from hypothesis import given, settings

import lensbench as lb
from lensbench import AIR, Glass, Lens, Surface, lenses
from lensbench.lenses import WRITERS, Kind
from lensbench.lenses.glass import catalogue, media
from tests.lenses.samples import DATA, bare, changed_json, loaded, plain_words, prescriptions, refusal

OPTILAND = json.loads((DATA / "four.json").read_text())
RAYOPTICS = json.loads((DATA / "pair.roa").read_text())


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
    assert [s.glass for s in lens.surfaces] == [catalogue.find("N-BK7"), AIR, AIR, Glass(1.62, 36.3), AIR]
    assert (lens.surfaces[1].conic, lens.surfaces[1].aspheric) == (-0.5, ((4, 1.5e-6), (6, -2e-9)))
    assert lens.surfaces[4].aspheric == ((3, 1e-6),)
    assert (lens.stop_index, lens.name, lens.findings) == (2, "Made-up four", ())


def test_optiland_rims_that_are_missing_are_estimated(tmp_path):
    lens = loaded(tmp_path, "lens.json", changed_json(OPTILAND, surface(1, "aperture"), None))
    assert lens.surfaces[0].semi_diameter > 6.0
    assert any(told.kind is Kind.RIM and told.surface == 0 for told in lens.findings)


@pytest.mark.parametrize(("keys", "value", "told"), [
    (surface(2, "is_reflective"), True, "mirror"), (surface(2, "geometry", "cs", "rx"), 0.1, "tilt"),
    (surface(2, "geometry", "cs", "y"), 0.1, "decentre"), (surface(2, "geometry", "type"), "Zernike", "Zernike"),
    (surface(2, "geometry", "coefficients"), [1.0], "another"), (surface(2, "geometry", "radius"), None, "radius"),
    (surface(4, "material_post"), {"type": "Material", "name": "N-BK77"}, "N-BK7"),
    (surface(5, "geometry", "coefficients"), [1e-3], "cone"), (surface(2, "type"), "ParaxialSurface", "Paraxial"),
    (surface(2, "geometry", "cs", "z"), float("nan"), "z is nan")])
def test_optiland_refusals_name_surface_and_line(tmp_path, keys, value, told):
    text = changed_json(OPTILAND, keys, value)
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
    assert [s.semi_diameter for s in lens.surfaces] == [9.5, 9.0, lens.stop.semi_diameter, 7.0, 7.5]
    assert 2.0 * lb.first_order(lens).entrance_pupil.radius == pytest.approx(12.5, rel=1e-6)        # the pupil's value
    assert [s.glass for s in lens.surfaces] == [catalogue.find("N-BK7"), AIR, AIR, Glass(1.62, 36.3), AIR]
    assert (lens.surfaces[1].conic, lens.surfaces[1].aspheric) == (-0.5, ((4, 1.5e-6), (6, -2e-9)))
    assert lens.surfaces[3].conic == 0.25 and lens.surfaces[4].aspheric == ((3, 1e-6),)
    assert (lens.stop_index, lens.name) == (2, "Made-up pair")


def test_rayoptics_refracts_at_a_cemented_plane_of_glasses_with_one_index(tmp_path):
    """A plane of a direct-vision prism bends every colour but one; rayoptics lets rays pass a dummy straight on."""
    crown, flint = Glass(1.6, 60.0), Glass(1.6, 40.0)
    lens = Lens((Surface(5.0, 10.0, crown, curvature=0.02), Surface(3.0, 10.0, crown, curvature=0.0),
                 Surface(3.0, 10.0, flint, curvature=0.0),
                 Surface(0.0, 10.0, curvature=0.0)), 1)
    lenses.save(lens, tmp_path / "prism.roa")
    model = json.loads((tmp_path / "prism.roa").read_text())["optical_model"]["attributes"]["seq_model"]["attributes"]
    modes = [item["attributes"]["interact_mode"] for item in model["ifcs"]]
    assert modes == ["dummy", "transmit", "dummy", "transmit", "transmit", "dummy"]


def test_rayoptics_rims_of_one_everywhere_are_none(tmp_path):
    model = deepcopy(RAYOPTICS)
    for item in model["optical_model"]["attributes"]["seq_model"]["attributes"]["ifcs"]:
        item["attributes"]["max_aperture"] = 1.0
    lens = loaded(tmp_path, "lens.roa", json.dumps(model))
    assert lens.surfaces[0].semi_diameter > 6.25 and any("any surface" in told.message for told in lens.findings)


def test_optiland_newer_files_say_mirror_and_field_in_other_places(tmp_path):
    text = changed_json(OPTILAND, surface(2, "interaction_model"), {"type": "RefractiveReflectiveModel",
                                                               "is_reflective": True})
    assert "mirror" in refusal(tmp_path, "lens.json", text).reason
    for effect in ("ThinLensInteractionModel", "PhaseInteractionModel"):
        text = changed_json(OPTILAND, surface(2, "interaction_model"), {"type": effect})
        assert effect in refusal(tmp_path, "lens.json", text).reason
    model = json.loads(changed_json(OPTILAND, surface(1, "aperture"), None))
    estimated = loaded(tmp_path, "lens.json", json.dumps(model)).surfaces[0].semi_diameter
    model["fields"] = {"fields": [{"x": 0.0, "y": 10.0}], "field_definition": {"field_type": "AngleField"}}
    assert loaded(tmp_path, "lens.json", json.dumps(model)).surfaces[0].semi_diameter == estimated > 6.0


def test_rayoptics_newer_fields_and_older_coefficients_are_read(tmp_path):
    model = deepcopy(RAYOPTICS)
    attributes = model["optical_model"]["attributes"]
    for item in attributes["seq_model"]["attributes"]["ifcs"]:
        item["attributes"]["max_aperture"] = 1.0
    estimated = loaded(tmp_path, "lens.roa", json.dumps(model)).surfaces[0].semi_diameter
    field = attributes["optical_spec"]["attributes"]["field_of_view"]["attributes"]
    del field["value"]
    field |= {"_value": 10.0, "is_relative": True,
              "fields": [{"__instance_type__": ["rayoptics.raytr.opticalspec", "Field"],
                          "attributes": {"_x": 0.0, "_y": 1.0}}]}
    shape = attributes["profile_dict"]["3"]["attributes"]
    shape["coefs"], shape["coef4"], shape["coef6"] = [0.0] * 10, 1.5e-06, -2e-09
    lens = loaded(tmp_path, "lens.roa", json.dumps(model))
    assert lens.surfaces[0].semi_diameter == estimated
    assert lens.surfaces[1].aspheric == ((4, 1.5e-6), (6, -2e-9))


def test_rayoptics_tables_of_indices_become_the_glass_that_they_are(tmp_path):
    def medium(label, maker, points):
        return changed_json(RAYOPTICS, sequence("gaps", 1, "attributes", "medium"), {
            "__instance_type__": ["opticalglass.opticalmedium", "InterpolatedMedium"],
            "attributes": {"label": label, "_catalog": maker, "wvls": [1000.0 * w for w, _ in points],
                           "rndx": [n for _, n in points]}})
    glass = catalogue.find("S-LAL14")
    lines = (0.4, 0.5, 0.6, 0.7)
    known = loaded(tmp_path, "lens.roa", medium("S-LAL14", "OHARA", [(w, glass.index(w)) for w in lines]))
    assert known.surfaces[0].glass == glass
    other = loaded(tmp_path, "lens.roa", medium("S-LAL14", "OHARA", [(w, glass.index(w) + 1e-3) for w in lines]))
    assert other.surfaces[0].glass.formula == "table"
    assert other.surfaces[0].glass.index(0.5) == pytest.approx(glass.index(0.5) + 1e-3, abs=1e-12)


def medium(kind, **attributes):
    return {"__instance_type__": ["opticalglass.opticalmedium", kind], "attributes": attributes}


def test_rayoptics_units_and_media_are_read_in_every_spelling(tmp_path):
    def read(wrapped, dimensions="mm"):
        model = json.loads(changed_json(RAYOPTICS, sequence("gaps", 1, "attributes", "medium"), wrapped))
        system = model["optical_model"]["attributes"]["system_spec"]["attributes"]
        system.pop("_dimensions", None)
        system["dimensions"] = dimensions
        return loaded(tmp_path, "lens.roa", json.dumps(model))

    bk7 = medium("SchottGlass", gname="N-BK7", coefs=[])
    assert read(bk7, "MM") == read(bk7) and read(bk7, "Cm") == read(bk7).scaled(10.0)
    for vacuum in (medium("Vacuum"), medium("ConstantIndex", label="VACUUM", n=0.999727)):
        assert read(vacuum).surfaces[0].glass == AIR
    thin = read(medium("ConstantIndex", label="helium", n=0.999982))
    assert thin.surfaces[0].glass.index() == 1.0
    assert [str(f) for f in thin.findings if f.kind is Kind.GLASS] == [
        "helium of index 0.999982 is read as air, of index 1"]
    silica = read(medium("RIIMedium", label="SiO2", rndx_fct_name="eval_formula_1", data_range={
        "__ndarray__": [0.21, 6.7]}, coefs={"__ndarray__": [0.0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794,
                                                            9.896161]}))
    assert silica.surfaces[0].glass.index(0.248272) == pytest.approx(1.50840, abs=3e-5)
    assert "data_range" in str(refusal(tmp_path, "lens.roa", changed_json(
        RAYOPTICS, sequence("gaps", 1, "attributes", "medium"), medium("RIIMedium", rndx_fct_name="eval_formula_1"))))


def test_optiland_materials_from_a_file_are_those_of_the_catalogue(tmp_path):
    for file, name in (
            ("/home/x/data-nk/glass/schott/N-BK7.yml", "N-BK7"), ("data\\main\\SiO2\\Malitson.yml", "SIO2")):
        text = changed_json(OPTILAND, surface(1, "material_post"), {"type": "MaterialFile", "filename": file})
        assert loaded(tmp_path, "lens.json", text).surfaces[0].glass.name == name


@pytest.mark.parametrize("suffix", [".zmx", ".roa", ".toml", ".len"])
def test_fused_silica_keeps_its_dispersion(tmp_path, suffix):
    lens = Lens((Surface(4.0, 9.0, catalogue.find("F_SILICA"), curvature=0.02),
                 Surface(40.0, 9.0, curvature=-0.02)), 0)
    assert not [f for f in lenses.save(lens, tmp_path / f"a{suffix}") if f.kind is Kind.GLASS]
    assert lenses.load(tmp_path / f"a{suffix}").surfaces[0].glass == lens.surfaces[0].glass


@pytest.mark.parametrize("suffix", [".json", ".seq"])
def test_a_format_that_keeps_only_numbers_of_fused_silica_says_so(tmp_path, suffix):
    lens = Lens((Surface(4.0, 9.0, catalogue.find("F_SILICA"), curvature=0.02),
                 Surface(40.0, 9.0, curvature=-0.02)), 0)
    remarks = lenses.save(lens, tmp_path / f"a{suffix}")
    assert any("only n_d and V_d are written" in str(remark) for remark in remarks)


@given(prescriptions(range(2, 21), toroids=False, name=plain_words))
@settings(max_examples=100)
@pytest.mark.parametrize("suffix", [".json", ".roa"])
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, suffix, lens):
    path = tmp_path_factory.getbasetemp() / f"any{suffix}"
    assert lenses.save(lens, path) == ()
    assert bare(lenses.load(path), lens) == lens


@pytest.mark.parametrize("suffix", [".json", ".roa"])
def test_losses_are_reported(tmp_path, suffix):
    lens = lenses.load("pbrt-dgauss-50mm")
    assert [str(remark) for remark in lenses.save(lens, tmp_path / f"a{suffix}")] == [
        "the lens states no fields: the image heights 0, 0.7 and 1 of its film's half-diagonal, 21.63 mm, are written",
        "left out: kind, year, source, stated focal length, stated f-number, notes, designer, patent, film size"]
    table = media.tabulated("MINE", [(0.4, 1.51), (0.5875618, 1.5), (0.7, 1.49)])
    formula = replace(catalogue.find("N-BK7"), name="MINE")
    for glass, kept in ((table, suffix == ".roa"), (formula, False)):
        odd = Lens((Surface(5.0, 9.0, glass, curvature=0.01), Surface(90.0, 9.0, curvature=0.0)), 1)
        remarks = lenses.save(odd, tmp_path / f"b{suffix}")
        glass_read = lenses.load(tmp_path / f"b{suffix}").surfaces[0].glass
        assert bool(remarks) != kept and (glass_read.coefficients == glass.coefficients) == kept
        assert glass_read.n_d == glass.n_d and glass_read.name == "MINE"


@pytest.mark.parametrize(("keys", "value", "told"), [
    (ifc(2, "interact_mode"), "reflect", "mirror"), (ifc(2, "decenter"), {"dec": 1}, "tilt"),
    (ifc(2, "phase_element"), {}, "grating"), (ifc(2, "profile_id"), "77", "profile"),
    (sequence("ifcs", 2, "__instance_type__"), ["rayoptics.oprops.thinlens", "ThinLens"], "ThinLens"),
    (sequence("gaps", 2, "attributes", "thi"), "x", "thi")])
def test_rayoptics_refusals_name_surface_and_line(tmp_path, keys, value, told):
    text = changed_json(RAYOPTICS, keys, value)
    error = refusal(tmp_path, "lens.roa", text)
    assert told in error.reason and "surface 2:" in error.reason
    assert text.split("\n")[error.line - 1].strip() == "{"


def test_a_rayoptics_glass_without_its_class_is_found_by_its_name(tmp_path):
    text = changed_json(RAYOPTICS, sequence("gaps", 1, "attributes", "medium", "__instance_type__"), [])
    assert loaded(tmp_path, "lens.roa", text).surfaces[0].glass == catalogue.find("N-BK7")


def test_other_json_is_no_lens(tmp_path):
    for name in ("a.json", "a.roa"):
        assert "no " in refusal(tmp_path, name, '{"a": [1, 2]}').reason
        assert "braces" in refusal(tmp_path, name, "[1, 2]").reason
        assert refusal(tmp_path, name, '{"a":\n 1,}').line == 2
        assert "nested" in refusal(tmp_path, name, '{"a":' * 100_000).reason


def test_a_curved_image_is_said(tmp_path):
    told = "image surface is curved, with a radius of -80 mm"
    last = len(OPTILAND["surface_group"]["surfaces"]) - 1
    lens = loaded(tmp_path, "lens.json", changed_json(OPTILAND, surface(last, "geometry", "radius"), -80.0))
    assert any(told in str(finding) for finding in lens.findings)
    model = RAYOPTICS["optical_model"]["attributes"]
    profile = model["seq_model"]["attributes"]["ifcs"][-1]["attributes"]["profile_id"]
    keys = ["optical_model", "attributes", "profile_dict", str(profile), "attributes", "cv"]
    lens = loaded(tmp_path, "lens.roa", changed_json(RAYOPTICS, keys, -1.0 / 80.0))
    assert any(told in str(finding) for finding in lens.findings)


def test_an_old_mirror_of_rayoptics_is_refused(tmp_path):
    """Before 0.4.5 the mode stood in refract_mode."""
    text, _ = WRITERS[".roa"](lenses.load("lenshh-cooke-triplet-50"))
    old = text.replace('"delta_n"', '"refract_mode": "REFL", "delta_n"', 2)
    assert "mirror" in refusal(tmp_path, "a.roa", old).reason
