"""Formats that are only read: DeepLens, lensoptics, FlareSim and LensHH; every value, the stop, zooms, refusals."""

import json
import math

import pytest

import lensbench as lb
from lensbench import AIR, Glass, lenses
from lensbench.core.optics.system import ApertureKind, FieldKind
from lensbench.lenses import Kind
from lensbench.lenses.glass import catalogue
from tests.lenses.samples import DATA, changed_json, changed_sample, loaded, refusal

LENSHH = json.loads((DATA / "zoom.lhlt").read_text())
DEEPLENS = json.loads((DATA / "phone.json").read_text())


def kinds(lens):
    return {finding.kind for finding in lens.findings}


def test_flaresim_rims_are_diameters_and_the_stop_is_a_plane():
    lens = lenses.load(DATA / "triplet.lens")
    assert (lens.name, lens.stated_efl, lens.stop_index) == ("Made-up triplet 50 mm f/4", 50.0, 3)
    radii = [22.5, -420.25, -21.0, None, 20.75, 75.0, -18.4]
    assert [s.curvature for s in lens.surfaces] == [pytest.approx(1.0 / r, rel=1e-15) if r else 0.0 for r in radii]
    assert [s.semi_diameter for s in lens.surfaces] == [7.5, 7.25, 5.5, 4.875, 5.25, 6.75, 7.0]
    assert [s.thickness for s in lens.surfaces] == [3.25, 5.5, 1.0, 0.75, 4.5, 2.9, 42.25]
    assert lens.surfaces[2].glass == Glass(1.64769, 33.79) and lens.surfaces[1].glass == AIR
    assert kinds(lens) == {Kind.CONVENTION}


def test_flaresim_cylinders_and_toroids_are_curved_in_their_sections(tmp_path):
    def first(kind):
        return changed_sample("triplet.lens", tmp_path, ("15.000    1", f"15.000    1   {kind}")).surfaces[0]

    c = 1.0 / 22.5
    assert [(first(kind).curvature, first(kind).curvature_x) for kind in ("cyl_x", "cyl_y", "toric -50")] == [
        (c, 0.0), (0.0, c), (-0.02, c)]
    assert first("sph").curvature_x is None


@pytest.mark.parametrize(("old", "new", "line", "told"), [
    ("15.000    1", "15.000    1 toric", 7, "surface 0: a toric surface needs"),
    ("15.000    1", "15.000    1 cone", 7, "surface 0: the type cone"),
    ("15.000    1", "0 1", 7, "surface 0: semi_ap is 0"),
    ("1.62041  60.32    15.000    1", "1.6", 7, "surface 0: the line has 3 values"),
    ("-420.25", "wide", 8, "surface 1: radius"),
    ("surfaces:", "surface:", 5, "surface is not understood"),
])
def test_flaresim_mistakes_name_their_line(tmp_path, old, new, line, told):
    error = refusal(tmp_path, "a.lens", (DATA / "triplet.lens").read_text().replace(old, new, 1))
    assert error.line == line and told in error.reason


def test_lensoptics_surfaces_are_scaled_and_named_and_have_three_positions():
    lens = lenses.load(DATA / "zoom.fx")
    assert (lens.name, lens.stop_index) == ("Made-up zoom", 3)
    radii = [48.5, -120.25, None, None, 70.0, -52.5]
    assert [s.curvature for s in lens.surfaces] == [pytest.approx(1.0 / r, rel=1e-15) if r else 0.0 for r in radii]
    assert [s.semi_diameter for s in lens.surfaces] == [10.0, 9.75, 9.5, 6.25, 8.0, 8.25]
    assert lens.surfaces[1].glass == Glass(1.64769, 33.79, "N-SF2") and lens.surfaces[3].glass == AIR
    assert lens.surfaces[4].conic == -1.0
    # #!scale holds for lengths: the sag of the half-size asphere at half the height is half
    assert dict(lens.surfaces[4].aspheric) == pytest.approx({4: 8e-5, 6: -6.4e-7}, rel=1e-12)
    assert [row[0] for row in lens.positions.thicknesses] == [(3.5, 40.25), (6.0, 42.875), (9.25, 45.5)]
    assert lens.positions.names == ("wide", "middle", "tele")


def test_a_lensoptics_cylinder_is_curved_across_and_says_so(tmp_path):
    lens = changed_sample("zoom.fx", tmp_path, ("N-SF2 ", "cx_N-SF2 "))
    assert (lens.surfaces[1].curvature, lens.surfaces[1].curvature_x) == (0.0, pytest.approx(-1.0 / 120.25, rel=1e-15))
    assert lens.surfaces[1].glass.name == "N-SF2" and Kind.CONVENTION in kinds(lens)


@pytest.mark.parametrize(("old", "new", "told"), [
    ("60.32  20 ", "", "surface 0: the medium abbe needs n_d, V_d"),
    ("19.5", "-19.5", "surface 1: the housing radius"),
    ("7/12/18.5", "7/12/18/19", "surface 2: 4 thicknesses"),
    ("97.0", "x", "surface 0: radius"),
    ("=-1,1e-5", "=-1,a", "surface 4: #!aspheric"),
])
def test_lensoptics_mistakes_name_their_surface(tmp_path, old, new, told):
    error = refusal(tmp_path, "a.fx", (DATA / "zoom.fx").read_text().replace(old, new, 1))
    assert told in error.reason and error.line is not None


def test_deeplens_surfaces_media_and_gaps_are_read():
    lens = lenses.load(DATA / "phone.json")
    assert (lens.name, lens.stop_index, lens.stated_efl, lens.stated_f_number) == ("Made-up phone lens", 0, 4.25, 2.0)
    assert lens.film_size == (4.8, 3.6)
    assert [s.curvature for s in lens.surfaces] == [0.0, 0.5, -0.1, 0.05, 0.0, 0.0]     # roc goes before c
    assert [s.thickness for s in lens.surfaces] == pytest.approx([0.05, 0.8, 0.5, 2.9, 0.25, 0.4], abs=1e-12)
    assert dict(lens.surfaces[1].aspheric) == {4: 0.002, 6: -0.0005} and lens.surfaces[1].conic == -0.5
    assert lens.surfaces[2].glass == Glass(1.64769, 33.8)
    assert lens.surfaces[4].glass == catalogue.find("N-BK7")
    assert [s.semi_diameter for s in lens.surfaces] == [1.05, 1.25, 1.5, 1.6, 2.5, 2.6]


@pytest.mark.parametrize(("keys", "value", "told"), [
    (["surfaces", 2, "type"], "ThinLens", "surface 2: the type ThinLens is not traced"),
    (["surfaces", 3, "mat2"], "unobtainium", "surface 3: glass 'unobtainium'"),
    (["surfaces", 3, "r"], None, "surface 3: r is missing"),
    (["surfaces", 1, "ai"], [0.0] * 10 + [1e-9], "surface 1: a term in r^22"),
    (["surfaces"], [], "there is no lens"),
])
def test_deeplens_refusals_name_the_surface(tmp_path, keys, value, told):
    assert told in str(refusal(tmp_path, "a.json", changed_json(DEEPLENS, keys, value)))


@pytest.mark.parametrize(("keys", "value", "told"), [
    (["surfaces", 0, "mat1"], "water", "the medium water in front of the lens"),
])
def test_what_deeplens_holds_beside_is_named(tmp_path, keys, value, told):
    lens = loaded(tmp_path, "a.json", changed_json(DEEPLENS, keys, value))
    whole = lenses.load(DATA / "phone.json").findings
    assert [told in finding.message for finding in lens.findings if finding not in whole] == [True]


def test_deeplens_coefficients_begin_with_r4_where_the_file_says_so(tmp_path):
    lens = loaded(tmp_path, "a.json", changed_json(DEEPLENS, ["surfaces", 1, "use_ai2"], False))
    assert dict(lens.surfaces[1].aspheric) == {6: 0.002, 8: -0.0005}


def test_lenshh_surfaces_system_data_and_zoom_positions_are_read():
    lens = lenses.load(DATA / "zoom.lhlt")
    assert (lens.name, lens.notes, lens.designer, lens.stop_index) == ("Made-up zoom", "For the tests", "Nobody", 3)
    assert [s.curvature for s in lens.surfaces[:2]] == [1.0 / 48.5, -1.0 / 120.25]
    assert lens.surfaces[4].conic == -0.5 and dict(lens.surfaces[4].aspheric) == {4: 1e-5, 6: -2e-8}
    assert lens.surfaces[0].glass == catalogue.find("N-SK16")
    assert lens.surfaces[4].glass == catalogue.find("LAF2", "HOYA")               # the file's first catalogue
    assert lens.system.aperture.kind is ApertureKind.PUPIL_DIAMETER and lens.system.aperture.values[0] == 8.0
    assert lens.system.field_kind is FieldKind.ANGLE and lens.system.largest_field == 14.5
    assert lens.system.primary_wavelength == 0.5876 and lens.system.wavelengths[1].weight == 2.0
    assert [row[0] for row in lens.positions.thicknesses] == [(3.5, 40.25), (9.25, 45.5)]
    assert math.isfinite(lb.first_order(lens.at(zoom=1.0)).efl)


@pytest.mark.parametrize(("keys", "value", "told"), [
    (["Surfaces", 2, "Type"], "CoordinateBreak", "surface 2: the type CoordinateBreak is not traced"),
    (["Surfaces", 2, "Material"], "MIRROR", "surface 2: a mirror is not traced"),
    (["Surfaces", 2, "Radius"], "wide", "surface 2: radius"),
    (["ConfigurationEditor", "Configurations", 1, "Values"], [1.0], "configuration 2 has 1 values for 2 operands"),
    (["Surfaces"], [], "there is no lens"),
])
def test_lenshh_refusals_name_the_surface(tmp_path, keys, value, told):
    assert told in str(refusal(tmp_path, "a.lhlt", changed_json(LENSHH, keys, value)))


@pytest.mark.parametrize(("keys", "value", "told"), [
    (["Aperture", "Type"], "Magic", "an aperture of the type Magic"),
    (["FieldType"], "Magic", "fields of the type Magic"),
    (["Pickups"], [{"TargetSurfaceIndex": 3, "Parameter": "Glass"}], "(pickup of Glass) that cannot be checked"),
    (["Surfaces", 3, "ObscurationRadius"], 2.0, "obscuration"),
    (["ConfigurationEditor", "Operands", 0, "Type"], "Curvature", "Curvature: of what differs"),
])
def test_what_lensbench_does_not_hold_of_a_lenshh_file_is_a_finding(tmp_path, keys, value, told):
    lens = loaded(tmp_path, "a.lhlt", changed_json(LENSHH, keys, value))
    assert any(told in str(finding) for finding in lens.findings)


FLARESIM = """\
name: {name}
surfaces:
# radius  thickness  ior   abbe  semi_ap
  100     6          1.5   60    {a}
  -100    2          1     0     {a}
  stop    96         1     0     {b}
"""


@pytest.mark.parametrize(("name", "a", "b", "rims", "told"), [
    ("Lens 100 mm f/5", 12, 10, (12.0, 10.0), "semi-diameters: the f-number in the name, f/5"),
    ("Lens 100 mm f/5", 24, 20, (12.0, 10.0), "diameters: the f-number in the name, f/5"),
    ("Lens 100mm F5", 24, 20, (12.0, 10.0), "diameters"), ("Lens 100mm T5.0", 12, 10, (12.0, 10.0), "semi-diameters"),
    ("Lens", 110, 20, (55.0, 10.0), "diameters: as semi-diameters they exceed what the radii allow"),
    ("Lens", 40, 20, (20.0, 10.0), "diameters: as semi-diameters they exceed"),        # the element has no edge
    ("Lens 5 mm", 12, 10, (12.0, 10.0), "two stops too wide")])
def test_flaresim_rims_are_what_the_name_or_the_radii_ask_for(tmp_path, name, a, b, rims, told):
    """f/5 of a thin biconvex lens, R 100, n 1.5: 100 mm over a pupil of 20 mm."""
    lens = loaded(tmp_path, "a.lens", FLARESIM.format(name=name, a=a, b=b))
    assert (lens.surfaces[0].semi_diameter, lens.stop.semi_diameter) == rims
    (finding,) = (finding for finding in lens.findings if finding.kind is Kind.CONVENTION)
    assert told in str(finding) and (finding.severity == "warning") == (told == "two stops too wide")


def test_lenshh_leaves_out_what_is_usual_and_has_model_glasses(tmp_path):
    model = json.loads((DATA / "zoom.lhlt").read_text())
    del model["Aperture"]["Type"], model["FieldType"]
    for surface in model["Surfaces"]:
        if surface["Type"] == "Standard":
            del surface["Type"]
    assert loaded(tmp_path, "a.lhlt", json.dumps(model)) == lenses.load(DATA / "zoom.lhlt")
    model["Surfaces"][1] |= {"Material": "", "ModelIndexEnabled": True, "ModelNd": 1.62, "ModelVd": 60.0}
    assert loaded(tmp_path, "b.lhlt", json.dumps(model)).surfaces[0].glass == Glass(1.62, 60.0)
    model["Surfaces"][1] |= {"ClearAperturePercent": 90.0}
    assert loaded(tmp_path, "c.lhlt", json.dumps(model)).surfaces[0].semi_diameter == 9.0
    model["Surfaces"][1] |= {"FloatingApertureRadius": 8.5}
    assert loaded(tmp_path, "d.lhlt", json.dumps(model)).surfaces[0].semi_diameter == 8.5


def test_lenshh_in_another_configuration_than_the_first_is_refused_where_surfaces_differ(tmp_path):
    model = json.loads((DATA / "zoom.lhlt").read_text())
    model["ConfigurationEditor"] |= {"ActiveConfiguration": 1}
    assert loaded(tmp_path, "a.lhlt", json.dumps(model)).positions == lenses.load(DATA / "zoom.lhlt").positions
    model["ConfigurationEditor"]["Operands"][0]["Type"] = "Curvature"
    assert "save the file in its first" in refusal(tmp_path, "b.lhlt", json.dumps(model)).reason


def test_deeplens_coefficients_one_by_one_are_read_where_there_is_no_list(tmp_path):
    model = json.loads((DATA / "phone.json").read_text())
    terms = model["surfaces"][1].pop("ai")
    model["surfaces"][1] |= {f"ai{2 * i}": a for i, a in enumerate(terms, start=1)}
    assert loaded(tmp_path, "a.json", json.dumps(model)) == lenses.load(DATA / "phone.json")
