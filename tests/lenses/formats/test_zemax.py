"""Zemax files: encodings, units, surface types, glasses, configurations, refusals, and round trips."""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings

import lensbench as lb
from lensbench import AIR, Glass, lenses
from lensbench.lenses import Kind, Severity
from lensbench.lenses.glass import catalogue
from tests.lenses.samples import DATA, bare, changed_sample, loaded, plain_words, prescriptions, refusal

SAMPLE = (DATA / "doublet.zmx").read_text()
sample = partial(changed_sample, "doublet.zmx")


def test_surfaces_glasses_stop_and_image_distance_are_read(tmp_path):
    lens = sample(tmp_path)
    assert [s.curvature for s in lens.surfaces] == [0.016, -0.022, -0.007]
    assert [s.thickness for s in lens.surfaces] == [6.5, 2.5, 95.0]
    assert [s.semi_diameter for s in lens.surfaces] == [12.0, lens.stop.semi_diameter, 11.25]
    assert 2.0 * lb.first_order(lens).entrance_pupil.radius == pytest.approx(23.8, rel=1e-12)      # ENPD, not DIAM 11.5
    assert [s.glass for s in lens.surfaces] == [catalogue.find("N-BK7"), Glass(1.62, 36.3), AIR]
    assert lens.surfaces[2].conic == -0.5
    assert lens.surfaces[2].aspheric == ((4, 1.25e-7), (6, -2e-11))
    assert (lens.stop_index, lens.name, lens.notes) == (1, "Small achromat with an asphere", "Made up for the tests")


@pytest.mark.parametrize("encode", [
    lambda text: text.encode("utf-16"), lambda text: text.encode("utf-16-le"), lambda text: text.encode("utf-16-be"),
    lambda text: text.encode("utf-8-sig"), lambda text: text.encode("latin-1"),
    lambda text: text.replace("\n", "\r\n").encode("utf-16"), lambda text: text.replace("\n", "\r").encode()])
def test_every_encoding_and_line_end_is_the_same_lens(tmp_path, encode):
    text = SAMPLE.replace("Small", "Kleiner Zweilinser für")
    lens = loaded(tmp_path, "lens.zmx", encode(text.replace("ü", "ue") if encode("ü") == "ü".encode() else text))
    assert lens.surfaces == sample(tmp_path).surfaces
    assert lens.name.startswith("Kleiner Zweilinser f")


def test_decimal_commas_are_points(tmp_path):
    text = "\n".join(line.replace(".", ",") if line.strip()[:4] in ("CURV", "DISZ", "DIAM", "PARM", "CONI") else line
                     for line in SAMPLE.split("\n"))
    assert loaded(tmp_path, "lens.zmx", text) == sample(tmp_path)


@pytest.mark.parametrize(("unit", "mm"), [("CM", 10.0), ("IN", 25.4), ("METER", 1000.0)])
def test_units_are_converted_with_a_finding(tmp_path, unit, mm):
    lens, same = sample(tmp_path, ("UNIT MM", f"UNIT {unit}")), sample(tmp_path).scaled(mm)
    assert lens.stop.semi_diameter == pytest.approx(same.stop.semi_diameter, rel=1e-14)
    assert lens.with_stop_radius(1.0) == same.with_stop_radius(1.0)
    assert any(f"{mm:g} mm" in finding.message for finding in lens.findings)


def test_types_of_surfaces(tmp_path):
    def last(kind, *parameters):
        lines = "\n".join(f"  {parameter}" for parameter in parameters)
        return sample(tmp_path, ("  TYPE EVENASPH", f"  TYPE {kind}\n{lines}"), ("  PARM 1 0\n", ""),
                      ("  PARM 2 1.25E-7\n", ""), ("  PARM 3 -2.0E-11\n", ""), ("  PARM 4 0\n", "")).surfaces[2]

    assert last("ODDASPHE", "PARM 3 1e-5", "PARM 8 2e-9").aspheric == ((3, 1e-5), (8, 2e-9))
    assert last("XASPHERE", "XDAT 1 9", "XDAT 2 2", "XDAT 3 4.0", "XDAT 11 1.0").aspheric == ((2, 1.0), (18, 2.0**-18))
    assert last("XODDASPH", "XDAT 1 3", "XDAT 2 10", "XDAT 5 2.0", "XDAT 6 9.9").aspheric == ((3, 2e-3),)


def test_a_cylinder_bends_one_section_alone(tmp_path):
    lens = sample(tmp_path, ("  TYPE STANDARD\n  CURV 1.6E-2", "  TYPE TOROIDAL\n  PARM 1 0\n  CURV 1.6E-2"))
    assert (lens.surfaces[0].curvature, lens.surfaces[0].curvature_x) == (0.016, 0.0)
    lens = sample(tmp_path, ("  TYPE STANDARD\n  CURV 1.6E-2", "  TYPE TOROIDAL\n  PARM 1 40\n  CURV 0"))
    assert (lens.surfaces[0].curvature, lens.surfaces[0].curvature_x) == (0.0, 0.025)
    lens = sample(tmp_path, ("  TYPE STANDARD\n  CURV 1.6E-2", "  TYPE BICONICX\n  PARM 1 -50\n  CURV 1.6E-2"))
    assert (lens.surfaces[0].curvature, lens.surfaces[0].curvature_x) == (0.016, -0.02)


@pytest.mark.parametrize(("old", "new", "told"), [
    ("GLAS N-BK7 0", "GLAS MIRROR 0", "mirror"),
    ("  TYPE EVENASPH", "  TYPE DGRATING", "DGRATING"),
    ("  TYPE EVENASPH", "  TYPE DGRATING", "grating"),
    ("  TYPE EVENASPH", "  TYPE PARAXIAL", "PARAXIAL"),
    ("  TYPE EVENASPH", "  TYPE BINARY_2", "BINARY_2"),
    ("  TYPE EVENASPH\n", "  TYPE TOROIDAL\n  PARM 1 30\n", "TOROIDAL"),
    ("GLAS N-BK7 0", "GLAS N-BQ73 0", "BK7"),
    ("CURV 1.6E-2", "CURV nan", "CURV"),
    ("CURV 1.6E-2", "CURV 1_6", "CURV"),
    ("  DISZ 6.5", "  DISZ INFINITY", "infinite"),
    ("UNIT MM", "UNIT FURLONG", "FURLONG"),
    ("MODE SEQ", "MODE NSC", "NSC"),
    ("1 0 1.62 36.3", "1 0 0.62 36.3", "n_d"),
])
def test_untraceable_features_are_refused_with_line_and_keyword(tmp_path, old, new, told):
    error = refusal(tmp_path, "lens.zmx", SAMPLE.replace(old, new, 1))
    line = SAMPLE.count("\n", 0, SAMPLE.index(old)) + 1
    assert error.line == (line if told != "infinite" else 20) and told in error.reason


def test_numbers_beside_a_name_count_only_where_no_catalogue_has_it(tmp_path):
    known = sample(tmp_path, ("GLAS N-BK7 0 0 1.5 4.0E+1", "GLAS N-BK7 0 0 1.7 4.5E+1"))
    assert known.surfaces[0].glass == catalogue.find("N-BK7")
    assert not any(finding.kind is Kind.GLASS for finding in known.findings)
    lens = sample(tmp_path, ("GLAS N-BK7 0 0 1.5 4.0E+1", "GLAS QQ-XY9 0 0 1.7 4.5E+1"))
    assert lens.surfaces[0].glass == Glass(1.7, 45.0, "QQ-XY9")
    assert any("QQ-XY9" in finding.message for finding in lens.findings)


def test_several_configurations_are_the_positions_of_a_zoom(tmp_path):
    listed = 'MNUM 2 2\nLTTL 0 1 "one" 0\nTHIC   2   1 4.5 0 0 0\nTHIC   2   2 2.5 0 0 0\nWAVE 1 1 0.4\nWAVE 1 2 0.5'
    lens = sample(tmp_path, ("MNUM 1 1", listed))
    stations = [[s.thickness for s in lens.at(zoom=zoom).surfaces] for zoom in lens.positions.zoom_stations]
    assert sorted(stations) == [[6.5, 2.5, 95.0], [6.5, 4.5, 95.0]]
    lengths = [lb.first_order(lens.at(zoom=zoom)).efl for zoom in (0.0, 1.0)]
    assert lengths[0] < lengths[1] and lens == lens.at(zoom=0.0)
    assert lens.positions.names[stations.index([6.5, 4.5, 95.0])] == "one"
    assert any("WAVE 1: of what differs between the configurations" in finding.message for finding in lens.findings)


def test_missing_rims_are_estimated_from_aperture_and_field_with_a_finding(tmp_path):
    lens = loaded(tmp_path, "lens.zmx", _without(SAMPLE, "DIAM"))
    # The entrance pupil must come out as the file's 23.8 mm, and the estimate lie above the axial beam
    assert 2.0 * lb.first_order(lens).entrance_pupil.radius == pytest.approx(23.8, rel=1e-12)
    assert 11.9 < lens.surfaces[0].semi_diameter < 12.5
    assert any("no semi-diameter for any surface" in finding.message for finding in lens.findings)
    error = refusal(tmp_path, "lens.zmx", _without(SAMPLE, "DIAM", "ENPD"))
    assert "semi-diameters are missing" in error.reason


def _without(text, *keys):
    return "\n".join(line for line in text.split("\n") if line.split()[:1] not in [[key] for key in keys])


def test_a_near_object_is_reported(tmp_path):
    lens = sample(tmp_path, ("DISZ INFINITY", "DISZ 250"))
    assert any("250 mm before" in finding.message for finding in lens.findings)


def test_a_lens_for_a_near_object_is_not_held_to_a_focus_at_infinity(tmp_path):
    # The sample's image of an object 250 mm away lies far behind its focus: only that of infinity is checked
    near = sample(tmp_path, ("DISZ INFINITY", "DISZ 250"), ("DISZ 9.5E+1", "DISZ 1.6E+2"))
    far = sample(tmp_path, ("DISZ 9.5E+1", "DISZ 1.6E+2"))
    assert "back-focus" in {finding.kind for finding in lenses.check(far)}
    assert {finding.kind for finding in lenses.check(near)} == {Kind.NEAR_OBJECT, Kind.STOP_SIZE}
    assert not any(finding.severity is Severity.WARNING for finding in lenses.check(near))


def test_an_object_within_glass_gets_a_plane_in_front(tmp_path):
    lens = sample(tmp_path, ("DISZ INFINITY", "DISZ 250\n  GLAS N-BK7 0 0 1.5 40"))
    plain = sample(tmp_path)
    cover, glass = lens.surfaces[0], catalogue.find("N-BK7")
    assert lens.with_stop_radius(1.0).surfaces[1:] == plain.with_stop_radius(1.0).surfaces
    assert lens.stop_index == plain.stop_index + 1
    assert (cover.curvature, cover.thickness, cover.glass) == (0.0, 250.0, glass)
    assert any("added as surface 0" in finding.message for finding in lens.findings)
    assert "object lies in" in refusal(tmp_path, "a.zmx", SAMPLE.replace(
        "  DISZ INFINITY", "  DISZ INFINITY\n  GLAS N-BK7 0 0 1.5 40")).reason


def _with_a_surface(text, before, kind, lines):
    """The file with one more surface before one of its surfaces, the later ones counted on."""
    head, *blocks = text.split("\nSURF ")
    blocks.insert(before, f"{before}\n  TYPE {kind}\n  CURV 0\n" + "\n".join(f"  {line}" for line in lines))
    return "\nSURF ".join([head, *(f"{i}{block[len(block.split()[0]):]}" for i, block in enumerate(blocks))])


def test_a_coordinate_break_that_moves_nothing_is_left_out_and_its_gap_kept(tmp_path):
    still = ["PARM 1 0", "PARM 3 0.0", "PARM 6 1", "DISZ 1.5"]
    plain, lens = sample(tmp_path), loaded(tmp_path, "b.zmx", _with_a_surface(SAMPLE, 2, "COORDBRK", still))
    gaps = [s.thickness for s in plain.surfaces]
    gaps[0] += 1.5
    assert [s.thickness for s in lens.surfaces] == gaps
    assert any("SURF 2: a coordinate break" in finding.message for finding in lens.findings)
    error = refusal(tmp_path, "c.zmx", _with_a_surface(SAMPLE, 2, "COORDBRK", ["PARM 3 0.1", "DISZ 0"]))
    assert "the axis does not return to its line before the image" in error.reason


def test_an_ideal_lens_before_the_image_is_left_out_and_one_before_the_lens_refused(tmp_path):
    ideal, last = ["PARM 1 10", "DISZ 10"], SAMPLE.count("\nSURF ") - 1
    lens = loaded(tmp_path, "b.zmx", _with_a_surface(SAMPLE, last, "PARAXIAL", ideal))
    plain = sample(tmp_path)
    assert [s.curvature for s in lens.surfaces] == [s.curvature for s in plain.surfaces]
    assert lens.surfaces[-1].thickness == 0.0 and any("ideal lens" in finding.message for finding in lens.findings)
    assert "PARAXIAL" in refusal(tmp_path, "c.zmx", _with_a_surface(SAMPLE, 1, "PARAXIAL", ideal)).reason


def test_a_torus_of_revolution_is_a_biconic_toroid_and_the_finding_says_how_far(tmp_path):
    lens = sample(tmp_path, ("COMM front\n  TYPE STANDARD", "COMM front\n  TYPE TOROIDAL\n  PARM 1 80"))
    surface = lens.surfaces[0]
    assert surface.curvature_x == 1 / 80 and surface.curvature == sample(tmp_path).surfaces[0].curvature
    (told,) = (finding for finding in lens.findings if finding.kind is Kind.SHAPE)
    # Independent of the reader: the arc of y–z, turned about an axis along y through x = 0, z = 80
    angle = np.linspace(0.0, np.pi / 2, 1001)
    x, y = surface.semi_diameter * np.sin(angle), surface.semi_diameter * np.cos(angle)
    profile = 1 / surface.curvature - np.sqrt(surface.curvature ** -2 - y * y)
    torus = 80.0 - np.sqrt((80.0 - profile) ** 2 - x * x)
    apart = float(np.abs(torus - surface.sag(x, y)).max())
    assert told.figures["departure"] == pytest.approx(apart, rel=0.005)


@given(prescriptions(range(2, 21), name=plain_words, notes=plain_words))
@settings(max_examples=100)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.zmx"
    assert lenses.save(lens, path) == ()
    assert bare(lenses.load(path), lens) == lens


def test_catalogue_glasses_come_back_and_losses_are_reported(tmp_path):
    lens = sample(tmp_path)
    remarks = lenses.save(replace(lens, kind="achromat", year=2001, stated_efl=100.0), tmp_path / "b.zmx")
    assert [str(remark) for remark in remarks] == ["left out: kind, year, stated focal length"]
    assert lenses.load(tmp_path / "b.zmx") == lens
    table = Glass(1.5, 60.0, "MINE", "table", ((0.4, 1.51), (0.7, 1.49)))
    odd = replace(lens, surfaces=(replace(lens.surfaces[0], glass=table), *lens.surfaces[1:]))
    assert any("MINE" in str(remark) for remark in lenses.save(odd, tmp_path / "c.zmx"))
    assert lenses.load(tmp_path / "c.zmx").surfaces[0].glass == Glass(1.5, 60.0, "MINE")


def test_the_catalogues_of_the_file_say_whose_glass_a_name_is(tmp_path):
    """Zemax takes the first catalogue of GCAT that has the name."""
    plain = SAMPLE.replace("GLAS N-BK7", "GLAS F2").replace("GCAT SCHOTT\n", "")
    for catalogues, maker in (("SUMITA SCHOTT", "SUMITA"), ("SCHOTT SUMITA", "SCHOTT"), ("SUMITA_AUG2011", "SUMITA"),
                              ("OHARA SUMITA", "SUMITA")):
        lens = loaded(tmp_path, "a.zmx", f"GCAT {catalogues}\n{plain}")
        assert lens.surfaces[0].glass == catalogue.find("F2", maker)
        assert not any("made by" in str(finding) for finding in lens.findings)
        lenses.save(lens, tmp_path / "b.zmx")
        assert lenses.load(tmp_path / "b.zmx").surfaces[0].glass == lens.surfaces[0].glass
    told = loaded(tmp_path, "a.zmx", plain).findings
    assert any("that of SCHOTT is used" in str(finding) for finding in told)


def test_tabs_part_words_as_spaces_do(tmp_path):
    tabbed = "\n".join(line.replace(" ", "\t") if line.startswith("  ") else line for line in SAMPLE.split("\n"))
    assert loaded(tmp_path, "lens.zmx", tabbed) == sample(tmp_path)


@pytest.mark.parametrize(("old", "new", "told"), [
    ("SURF 4\n  TYPE STANDARD\n  CURV 0.0", "SURF 4\n  TYPE STANDARD\n  CURV -0.01",
     "the image surface is curved, with a radius of -100 mm: a plane is used instead"),
    ("CURV 0.0 0 0 0 0 \"\"\n  DISZ INFINITY", "CURV 0.002 0 0 0 0 \"\"\n  DISZ 800",
     "the object surface is curved, with a radius of 500 mm: a plane is used instead"),
    ("ENVD 2.0E+1 1 0", "ENVD -4.0E+1 0 1", "designed for -40 °C and 0 atmospheres"),
    ("ENVD 2.0E+1 1 0", "ENVD 2.0E+1 1 0\nAFOC 1", "afocal image space (AFOC) is left out"),
    ("  DIAM 11.25", "  CLAP 2.0 11.25 0\n  DIAM 11.25", "SURF 3: a central obscuration (CLAP) is left out"),
    ("1.62 36.3 0", "1.62 36.3 0.02", "partial dispersion, 0.02, is left out"),
])
def test_what_changes_the_image_and_is_not_traced_is_said(tmp_path, old, new, told):
    assert not any(told in str(finding) for finding in sample(tmp_path).findings)
    assert any(told in str(finding) for finding in sample(tmp_path, (old, new)).findings)


def test_the_shape_of_an_object_at_infinity_needs_no_remark(tmp_path):
    lens = sample(tmp_path, ("CURV 0.0 0 0 0 0 \"\"\n  DISZ INFINITY", "CURV 0.002 0 0 0 0 \"\"\n  DISZ INFINITY"))
    assert not any("is curved" in str(finding) for finding in lens.findings)


def test_a_clear_aperture_without_an_inner_radius_obscures_nothing(tmp_path):
    lens = sample(tmp_path, ("  DIAM 11.25", "  CLAP 0.0 11.25 0"))
    assert not any("obscuration" in str(finding) for finding in lens.findings)
    assert lens.surfaces == sample(tmp_path).surfaces


def test_indices_of_the_catalogues_need_no_remark(tmp_path):
    for air in ("ENVD -4.0E+1 0 0", "ENVD 22.0 1.0 1"):         # not applied; and near 20 °C, 1 atmosphere
        assert not any("°C" in str(finding) for finding in sample(tmp_path, ("ENVD 2.0E+1 1 0", air)).findings)


def test_an_extended_asphere_without_extra_data_is_read_from_its_parameters(tmp_path):
    def asphere(kind, lines):
        lens = sample(tmp_path, ("TYPE EVENASPH", f"TYPE {kind}"),
                      ("  PARM 1 0\n  PARM 2 1.25E-7\n  PARM 3 -2.0E-11\n  PARM 4 0", lines))
        return dict(lens.surfaces[2].aspheric), [finding for finding in lens.findings
                                                 if finding.kind is Kind.CONVENTION]

    extra = "  XDAT 1 3\n  XDAT 2 10\n  XDAT 3 0\n  XDAT 4 1.25E-3"
    newer = "  PARM 13 3\n  PARM 14 10\n  PARM 15 0\n  PARM 16 1.25E-3"
    assert asphere("XASPHERE", extra) == ({4: pytest.approx(1.25e-7)}, [])
    terms, (remark,) = asphere("XASPHERE", newer)
    assert terms == {4: pytest.approx(1.25e-7)} and "PARM 13" in str(remark)
    for kind, powers in (("XASPHERE", (4, 6)), ("XODDASPH", (2, 3))):
        terms, (remark,) = asphere(kind, "  PARM 2 1.25E-7\n  PARM 3 -2.0E-11")
        assert terms == dict(zip(powers, (1.25e-7, -2e-11), strict=True)) and remark.severity == "warning"
    text = SAMPLE.replace("TYPE EVENASPH", "TYPE XASPHERE").replace("  PARM 1 0", extra)
    assert "PARM 2 together with XDAT" in refusal(tmp_path, "a.zmx", text).reason
    assert "PARM 9 is not understood" in refusal(tmp_path, "a.zmx", SAMPLE.replace("PARM 1 0", "PARM 9 1e-30")).reason


@pytest.mark.parametrize("key", ["WAVL", "WAVN"])
def test_wavelengths_of_older_files_are_read(tmp_path, key):
    waves = re.sub("(?m)^WAVM.*\n", "", SAMPLE).replace("PWAV 2", f"{key} 0.85 0.94 1.06\nWWGT 1 0.5 2\nPWAV 2")
    system = loaded(tmp_path, "a.zmx", waves).system
    assert [(wave.micrometres, wave.weight) for wave in system.wavelengths] == [(0.85, 1.0), (0.94, 0.5), (1.06, 2.0)]
    assert system.primary_wavelength == 0.94


def test_values_of_a_later_configuration_in_the_table_are_not_taken_for_the_first(tmp_path):
    """MNUM 2 2: the table of surfaces is that of configuration 2; its conic follows, but a glass is not known."""
    listed = "MNUM 2 2\nCONN 3 1 -0.75\nCONN 3 2 -0.5"
    assert sample(tmp_path, ("MNUM 1 1", listed)).surfaces[2].conic == -0.75
    error = refusal(tmp_path, "a.zmx", SAMPLE.replace("MNUM 1 1", "MNUM 2 2\nGLSS 1 1 F2\nGLSS 1 2 N-BK7"))
    assert "GLSS 1 differ in the first" in error.reason


def test_a_moulded_glass_says_how_far_off_it_is(tmp_path):
    lens = sample(tmp_path, ("GLAS N-BK7 0 0 1.5 4.0E+1", "GLAS L-TIM28_MOLD 0 0 1.5 4.0E+1"))
    n_d = catalogue.find("L-TIM28").n_d
    told = f"n_d {n_d:.5f}: moulding lowers the index, by an estimated 0.001 to 0.006"
    assert any(told in str(finding) for finding in lens.findings)
