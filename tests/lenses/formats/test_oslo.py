"""OSLO files: commands, glasses, units, aspheric kinds, refusals, and round trips."""

from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given, settings

import lensbench as lb
from lensbench import AIR, Glass, lenses
from lensbench.lenses.glass import catalogue
from tests.lenses.samples import DATA, bare, changed_sample, plain_words, prescriptions, refusal

WITHOUT_DIGITS = {ord(sign): None for sign in "0123456789. "}
SAMPLE = (DATA / "pair.len").read_text()
sample = partial(changed_sample, "pair.len")


def test_surfaces_glasses_stop_and_image_distance_are_read(tmp_path):
    lens = sample(tmp_path)
    assert [s.curvature for s in lens.surfaces] == [1.0 / 45.0, -1.0 / 90.0, 0.0, -0.01, -1.0 / 70.0]
    assert [s.thickness for s in lens.surfaces] == [4.0, 2.5, 3.0, 2.0, 55.0]
    assert [s.semi_diameter for s in lens.surfaces] == [8.0, 7.5, lens.stop.semi_diameter, 6.5, 7.0]
    assert lb.first_order(lens, 0.58756).entrance_pupil.radius == pytest.approx(5.0, rel=1e-12)       # EBR
    assert lens.surfaces[0].glass == catalogue.find("N-BK7")
    assert (lens.surfaces[1].conic, lens.surfaces[1].aspheric) == (-0.75, ((4, 1.5e-6), (8, -2e-11)))
    assert lens.surfaces[3].aspheric == ((12, 1e-15),)
    assert (lens.stop_index, lens.name) == (2, "Made-up pair") and lens.surfaces[4].glass == AIR


def test_a_model_glass_has_an_index_for_each_wavelength(tmp_path):
    glass = sample(tmp_path).surfaces[3].glass
    assert (glass.name, glass.n_d, glass.v_d) == ("MODEL1", 1.6201, pytest.approx(60.4, rel=1e-9))
    four = sample(tmp_path, ("WV 0.58756 0.48613 0.65627\nGLA MOD MODEL1      1.6201 1.6272360458395 1.6169694895481",
                             "WV 0.58756 0.48613 0.65627 0.4\nGLA MOD X 1.62 1.627 1.617 1.636")).surfaces[3].glass
    assert [four.index(w) for w in (0.4, 0.4861327, 0.5875618, 0.6562725)] == [1.636, 1.627, 1.62, 1.617]


@pytest.mark.parametrize(("line", "glass"), [
    ("GLA 1.52", Glass(1.52)), ("GLA MOD X 1.52 60.5", Glass(1.52, 60.5, "X")), ("GLA 517642", Glass(1.517, 64.2)),
    ("GLA bk7_schott", None), ("GLA AIR", AIR)])
def test_ways_to_name_a_glass(tmp_path, line, glass):
    read = sample(tmp_path, ("GLA N-BK7", line)).surfaces[0].glass
    assert read == glass if glass else read.n_d == pytest.approx(1.5168, abs=1e-4)


def test_units_are_converted_with_a_finding(tmp_path):
    lens = sample(tmp_path, ("UNI  1.0", "UNI 25.4"))
    assert lens == sample(tmp_path).scaled(25.4) and any("25.4 mm" in finding.message for finding in lens.findings)


def test_aspheres_of_any_power_and_cylinders(tmp_path):
    assert sample(tmp_path, ("AP   6.5; ASP ASR 6", "ASP ARA 6; AP 6.5")).surfaces[3].aspheric == ((6, 1e-15),)
    lens = sample(tmp_path, ("CC   -0.75", "RDX 0"), ("AD   1.5e-06\n", ""), ("AF   -2.0e-11\n", ""))
    assert lens.surfaces[1].curvature_x == 0.0


@pytest.mark.parametrize(("old", "new", "told"), [
    ("GLA N-BK7", "RFL", "mirror"), ("GLA N-BK7", "GLA N-BK77", "N-BK7"), ("RD   45.0", "TLA 5", "tilt"),
    ("RD   45.0", "DCY 1.0", "decentre"), ("RD   45.0", "PFL 50", "ideal lens"), ("RD   45.0", "RD nan", "RD"),
    ("RD   45.0", "ASP ZRN 3", "ZRN"), ("RD   45.0", "AS5 1e-9", "ASP"), ("AP   8.0", "AP -8", "AP"),
    ("UNI  1.0", "UNI 0", "UNI"), ("RD   45.0", "PK CV 3", "pick-up")])
def test_untraceable_features_are_refused_with_line_and_keyword(tmp_path, old, new, told):
    error = refusal(tmp_path, "lens.len", SAMPLE.replace(old, new, 1))
    assert error.line == SAMPLE.count("\n", 0, SAMPLE.index(old)) + 1 and told in error.reason


def test_another_file_is_refused(tmp_path):
    assert "LEN NEW" in refusal(tmp_path, "a.len", "a letter\n").reason


@given(prescriptions(range(2, 21), toroids=False,
                     name=plain_words.map(lambda text: f"lens {text.translate(WITHOUT_DIGITS)}".strip())))
@settings(max_examples=100)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.len"
    assert lenses.save(lens, path) == ()
    assert bare(lenses.load(path), lens) == lens


def test_a_number_in_a_name_would_be_read_as_one_of_the_arguments(tmp_path):
    remarks = lenses.save(replace(sample(tmp_path), name='The "50" 1.8 lens'), tmp_path / "b.len")
    assert len(remarks) == 1 and lenses.load(tmp_path / "b.len").name == "The lens"


def test_catalogue_glasses_come_back_and_losses_are_reported(tmp_path):
    lens = sample(tmp_path)
    remarks = lenses.save(replace(lens, stated_efl=60.0), tmp_path / "b.len")
    assert [str(remark) for remark in remarks] == ["left out: stated focal length"]
    assert lenses.load(tmp_path / "b.len") == lens
    table = Glass(1.5, 60.0, "MINE", "table", ((0.4, 1.51), (0.7, 1.49)))
    odd = replace(lens, surfaces=(replace(lens.surfaces[0], glass=table), *lens.surfaces[1:]))
    assert any("MINE" in str(remark) for remark in lenses.save(odd, tmp_path / "c.len"))


def test_other_air_and_a_curved_image_are_said(tmp_path):
    usual = sample(tmp_path, ("UNI  1.0", "TEM 20\nPRE 1")).findings
    assert not any("°C" in str(finding) or "curved" in str(finding) for finding in usual)
    findings = sample(tmp_path, ("UNI  1.0", "TEM -20\nPRE 0"), ("NXT\nAIR\nWV", "NXT\nAIR\nRD -80\nWV")).findings
    assert any("designed for -20 °C and 0 atmospheres" in str(finding) for finding in findings)
    assert any("image surface is curved, with a radius of -80 mm" in str(finding) for finding in findings)
