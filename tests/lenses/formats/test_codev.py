"""CODE V sequence files: radii or curvatures, commands, glasses, units, refusals, and round trips."""

from dataclasses import replace
from functools import partial
from math import hypot, radians, tan

import pytest
from hypothesis import given, settings

import lensbench as lb
from lensbench import Glass, lenses
from lensbench.lenses import Kind
from lensbench.lenses.glass import catalogue
from tests.lenses.samples import DATA, bare, changed_sample, loaded, plain_words, prescriptions, refusal

SAMPLE = (DATA / "triplet.seq").read_text()
sample = partial(changed_sample, "triplet.seq")


def test_surfaces_glasses_stop_and_image_distance_are_read(tmp_path):
    lens = sample(tmp_path)
    radii = [22.0, -435.7, -22.2, 20.3, 79.7, -18.4]
    assert [s.curvature for s in lens.surfaces] == pytest.approx([1.0 / r for r in radii], rel=1e-15)
    assert [s.thickness for s in lens.surfaces] == [3.3, 6.0, 1.0, 4.75, 2.95, 42.2]
    assert [s.semi_diameter for s in lens.surfaces] == [8.5, 8.0, 5.5, lens.stop.semi_diameter, 7.0, 7.25]
    assert 2.0 * lb.first_order(lens, 0.5876).entrance_pupil.radius == pytest.approx(10.0, rel=1e-12)     # EPD
    assert lens.surfaces[0].glass == catalogue.find("N-SK16", "SCHOTT")
    assert lens.surfaces[4].glass == Glass(1.62041, 60.32)
    assert lens.surfaces[2].conic == -0.25
    assert lens.surfaces[2].aspheric == ((4, 1.5e-6), (6, -0.2e-8), (10, 1e-13))
    assert (lens.stop_index, lens.name) == (3, "Made-up triplet")


def test_a_private_glass_has_the_indices_of_its_table(tmp_path):
    glass = sample(tmp_path).surfaces[2].glass
    assert (glass.name, glass.n_d) == ("MINE", pytest.approx(1.62, abs=1e-12))
    assert glass.v_d == pytest.approx(0.62 / 0.01, rel=1e-9)
    glass = sample(tmp_path, ("  'MINE' 1.6170 1.6200 1.6270", "'MINE' 1.617 1.62 1.627 1.636"),
                   ("486.1327", "486.1327 404.7")).surfaces[2].glass
    assert [glass.index(w) for w in (0.4047, 0.4861327, 0.6562725)] == [1.636, 1.627, 1.617]


def test_curvatures_and_radii_are_recognised_if_the_file_does_not_state_them(tmp_path):
    told = sample(tmp_path)
    silent = sample(tmp_path, ("RDM;LEN", "LEN"))
    assert silent == told and any("read as radii" in finding.message for finding in silent.findings)
    curved = "\n".join(_curved(line) for line in SAMPLE.split("\n"))
    for first in ("RDM N;LEN", "LEN"):
        lens = loaded(tmp_path, "curved.seq", curved.replace("RDM;LEN", first))
        assert [s.curvature for s in lens.surfaces] == pytest.approx([s.curvature for s in told.surfaces], rel=1e-14)
        assert lens.stop_index == told.stop_index


def _curved(line):
    words = line.split()
    if words[:1] != ["S"]:
        return line
    return " ".join(["S", repr(1.0 / float(words[1])), *words[2:]])


@pytest.mark.parametrize(("unit", "mm"), [("C", 10.0), ("I", 25.4)])
def test_units_are_converted_with_a_finding(tmp_path, unit, mm):
    lens = sample(tmp_path, ("DIM   M", f"DIM {unit}"))
    same = sample(tmp_path).scaled(mm)
    assert lens.stop.semi_diameter == pytest.approx(same.stop.semi_diameter, rel=1e-14)
    assert lens.with_stop_radius(1.0) == same.with_stop_radius(1.0)
    assert any(f"{mm:g} mm" in finding.message for finding in lens.findings)


def test_commands_may_name_their_surface_and_go_on_over_lines(tmp_path):
    lens = sample(tmp_path, ("  PIM\n", "THI S3 1.5; CUY S1 0.05\nK S1 &\n -2 ; STO S2\n"), ("  STO\n", ""))
    assert (lens.surfaces[2].thickness, lens.surfaces[0].curvature, lens.surfaces[0].conic) == (1.5, 0.05, -2.0)
    assert lens.stop_index == 1


def test_without_a_stop_the_first_surface_is_the_stop(tmp_path):
    lens = sample(tmp_path, ("  STO\n", ""))
    assert lens.stop_index == 0 and any("STO" in finding.message for finding in lens.findings)


def test_a_zoom_has_its_positions_from_wide_to_tele(tmp_path):
    zoom = "ZOO 3\nZOO TIT\nTIT Z1 'near'\nTIT Z3 'far'\nZOO EPD 24 24 24\nZOO THI S2 5.5 6.5 &\n 7.5\nGO\n"
    lens = sample(tmp_path, ("GO\n", zoom))
    positions = lens.positions
    lengths = [lb.first_order(lens.at(zoom=position)).efl for position in positions.zoom_stations]
    assert lengths == sorted(lengths)
    gaps = [row[0][0] for row in positions.thicknesses]
    assert positions.gaps == (1, 5) and sorted(gaps) == [5.5, 6.5, 7.5]         # PIM: the image follows
    assert dict(zip(gaps, positions.names, strict=True)) == {5.5: "near", 6.5: "", 7.5: "far"}
    assert any("from wide to tele" in finding.message for finding in lens.findings) == (gaps != [5.5, 6.5, 7.5])
    assert lens.name == sample(tmp_path).name


def test_a_single_position_can_be_named_and_losses_are_reported(tmp_path):
    lens = sample(tmp_path, ("GO\n", "ZOO 2\nZOO THI S2 5.5 5.5\nTHI S2 Z2 7.5\nZOO WTF 24 20\nGO\n"))
    assert sorted(row[0][0] for row in lens.positions.thicknesses) == [5.5, 7.5]
    assert any("WTF: of what differs between the configurations" in finding.message for finding in lens.findings)
    assert sample(tmp_path, ("GO\n", "ZOO 2\nZOO THI S2 5.5 5.5\nGO\n")).positions is None


@pytest.mark.parametrize(("code", "n_d", "v_d"), [("517642", 1.517, 64.2), ("517.642", 1.517, 64.2),
                                                  ("517000.641700", 1.517, 64.17), ("1.5168:64.17", 1.5168, 64.17)])
def test_codes_of_glasses(tmp_path, code, n_d, v_d):
    glass = sample(tmp_path, ("1.62041:60.32", code)).surfaces[4].glass
    assert (glass.n_d, glass.v_d) == (n_d, v_d)


def test_a_cylinder_bends_one_section_alone(tmp_path):
    flat = sample(tmp_path, ("  CIR 8.5", "  CYL\n  CIR 8.5")).surfaces[0]
    assert flat.curvature_x == 0.0
    assert sample(tmp_path, ("  CIR 8.5", "  YTO\n  RDX -40\n  CIR 8.5")).surfaces[0].curvature_x == -0.025


@pytest.mark.parametrize(("old", "new", "told"), [
    ("79.7 2.95 1.62041:60.32", "79.7 -2.95 REFL", "mirror"),
    ("  PIM", "  ADE 5; BEN", "BEN"),
    ("  PIM", "  XOD 0.0; YOD 1.5", "YOD"),
    ("  PIM", "  RET S1", "RET"),
    ("  PIM", "  DIF GRT", "DIF"),
    ("  PIM", "  SPS ODD", "SPS"),
    ("NSK16_SCHOTT", "NSK99_SCHOTT", "NSK99"),
    ("DIM   M", "DIM   X", "DIM"),
    ("S     22.0", "S     nan", "radius"),
    ("CIR 8.5", "CIR -8.5", "CIR"),
])
def test_untraceable_features_are_refused_with_line_and_keyword(tmp_path, old, new, told):
    error = refusal(tmp_path, "lens.seq", SAMPLE.replace(old, new, 1))
    assert error.line == SAMPLE.count("\n", 0, SAMPLE.index(old)) + 1 and told in error.reason


def test_a_title_that_begins_like_a_zoom_position_is_kept(tmp_path):
    lens = replace(sample(tmp_path), name="Zeiss Sonnar")
    assert [str(remark) for remark in lenses.save(lens, tmp_path / "b.seq") if remark.kind is Kind.TEXT] == []
    assert "TITLE ' Zeiss Sonnar'" in (tmp_path / "b.seq").read_text()
    assert lenses.load(tmp_path / "b.seq").name == "Zeiss Sonnar"


def test_a_decentre_of_nothing_is_harmless(tmp_path):
    assert sample(tmp_path, ("  PIM", "  XDE 0.0; YDE 0.0; ADE 0")) == sample(tmp_path)


@given(prescriptions(range(4, 21, 2), name=plain_words))
@settings(max_examples=100)
def test_a_saved_lens_loads_equal_to_the_last_bit_but_for_names_of_glasses(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.seq"
    named = any(s.glass.name for s in lens.surfaces)
    assert bool(lenses.save(lens, path)) == named
    unnamed = tuple(replace(s, glass=replace(s.glass, name="")) for s in lens.surfaces)
    assert bare(lenses.load(path), lens) == replace(lens, surfaces=unnamed)


def test_catalogue_glasses_come_back_and_losses_are_reported(tmp_path):
    lens = sample(tmp_path)
    glass = catalogue.find("N-SF5")
    lens = replace(lens, surfaces=(*lens.surfaces[:2], replace(lens.surfaces[2], glass=glass), *lens.surfaces[3:]))
    assert any("9.98365 mm is written" in str(remark) for remark in lenses.save(lens, tmp_path / "b.seq"))
    lens = lenses.load(tmp_path / "b.seq")              # with the aperture that this glass gives
    assert lenses.save(lens, tmp_path / "b.seq") == ()
    assert lenses.load(tmp_path / "b.seq") == lens
    odd = replace(lens, surfaces=(replace(lens.surfaces[0], aspheric=((3, 1e-6),)), *lens.surfaces[1:]), year=1950)
    remarks = lenses.save(odd, tmp_path / "c.seq")
    assert any(remark.kind is Kind.SHAPE and "odd powers" in str(remark) for remark in remarks)
    assert "left out: year" in map(str, remarks)


def test_glasses_that_are_written_by_their_numbers_are_named_in_one_line(tmp_path):
    lens = sample(tmp_path)
    named = tuple(replace(s, glass=Glass(1.62041, 60.32, f"MY{i}")) if i in (0, 4) else s
                  for i, s in enumerate(lens.surfaces))
    messages = [str(remark) for remark in lenses.save(replace(lens, surfaces=named), tmp_path / "b.seq")
                if remark.kind is Kind.GLASS]
    assert [text for text in messages if "by these numbers" in text] == [
        "surfaces 0, 2, 4: known by n_d and V_d, and not as a catalogue has it, the glass is written by these numbers, "
        "its name as a comment"], messages


def test_other_air_and_a_curved_image_are_said(tmp_path):
    def told(*changes):
        return [str(finding) for finding in sample(tmp_path, *changes).findings]

    assert not any("°C" in text or "curved" in text for text in told(("DIM   M", "DIM M; TEM 22; PRE 760")))
    assert any("designed for 60 °C and 0 atmospheres" in text for text in told(("DIM   M", "DIM M; TEM 60; PRE 0")))
    line = next(line for line in SAMPLE.split("\n") if line.startswith("SI"))
    assert any("image surface is curved, with a radius of -80 mm" in text for text in told((line, "SI -80 0")))
    assert any("a defocus of 0.05 mm, is left out" in text for text in told((line, "SI 0 0.05")))
    assert any("a defocus of -2.54 mm" in text for text in told((line, f"{line}; THI SI -0.1"), ("DIM   M", "DIM I")))


def test_afocal_and_telecentric_spaces_are_said(tmp_path):
    def told(new):
        return [str(finding) for finding in sample(tmp_path, ("DIM   M", f"DIM M; {new}")).findings]

    assert any("afocal image space (AFI) is left out" in text for text in told("AFI YES"))
    assert any("telecentric in the object's space (TEL) is left out" in text for text in told("TEL"))
    assert not any("AFI" in text or "not read" in text for text in told("AFI N; DDM M"))


@pytest.mark.parametrize(("object_", "fields", "rim"), [
    # At 10° the beam of ± 5 mm in the stop, 20 mm behind, lies 20 tan 10° lower in front: −y juts out
    ("1e13", "YAN 0 10", 5.0 + 20.0 * tan(radians(10.0))),
    ("1e13", "YAN 0 10; VUY 0 0.1; VLY 0 0.4", 0.6 * 5.0 + 20.0 * tan(radians(10.0))),
    ("1e13", "YAN 0 -10; VUY 0 0.4; VLY 0 0.1", 0.6 * 5.0 + 20.0 * tan(radians(10.0))),
    ("1e13", "YAN 0 10; VUY 0 0.9; VLY 0 0.9", hypot(5.0, 20.0 * tan(radians(10.0)))),         # the rays across
    ("1e13", "YAN 0 10; VUY 0 0.9; VLY 0 0.9; VUX 0 0.9; VLX 0 0.9", 5.0),                     # those of the axis
    ("1e13", "XAN 0 10; VUX 0 0.1; VLX 0 0.4", 0.6 * 5.0 + 20.0 * tan(radians(10.0))),
    ("1e13", "YAN 0 7 10; VLY 0 0 0.9; VLX 0 0 0.9; VUX 0 0 0.9", 5.0 + 20.0 * tan(radians(7.0))),
    # An object 30 mm above the axis, 200 mm in front: its beam, 200 / 220 as wide as in the stop, is 30 × 20 / 220 high
    ("200", "YOB 0 30; VUY 0 0.5; VLY 0 0.1; VUX 0 0.5; VLX 0 0.5", 30.0 * 20.0 / 220.0 + 0.5 * 5.0 * 200.0 / 220.0),
])
def test_estimated_rims_pass_the_beams_that_vignetting_factors_leave(tmp_path, object_, fields, rim):
    text = (f"RDM;LEN\nEPD 10\nDIM M\nWL 587.6\n{fields}\nSO 0 {object_}\nS 0 20\nS 0 1\n  STO\n"
            "S 50 5 NBK7_SCHOTT\nS -50 45\nSI 0 0\n")
    lens = loaded(tmp_path, "lens.seq", text)
    assert lens.surfaces[0].semi_diameter == pytest.approx(rim, rel=1e-12)
    assert lens.stop.semi_diameter == pytest.approx(5.0, rel=1e-12)
