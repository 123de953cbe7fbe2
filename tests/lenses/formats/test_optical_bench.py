"""Optical Bench files: columns, variable distances, aspheric powers, the stop, mistakes, and round trips."""

from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given, settings, strategies as st

from lensbench import AIR, Glass, lenses
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, FieldPoint, SystemData
from lensbench.lenses import READERS, WRITERS
from lensbench.lenses.glass import catalogue
from tests.lenses.samples import DATA, changed_sample, plain_words, prescriptions, refusal

SAMPLE = (DATA / "zoom.txt").read_text()
sample = partial(changed_sample, "zoom.txt")


def test_surfaces_glasses_stop_and_both_positions_are_read(tmp_path):
    lens = sample(tmp_path)
    radii = [48.5, -120.25, None, -60.0, 70.0, -52.5]
    assert [s.curvature for s in lens.surfaces] == [1.0 / r if r else 0.0 for r in radii]
    assert [s.thickness for s in lens.surfaces] == [4.0, 1.5, 2.0, 3.5, 3.0, 40.25]
    assert [s.semi_diameter for s in lens.surfaces] == [10.0, 9.75, 9.5, 6.25, 8.0, 8.25]
    assert [s.glass for s in lens.surfaces] == [Glass(1.62041, 60.32), Glass(1.64769, 33.79, "N-SF2"), AIR, AIR,
                                                Glass(1.5168, 64.2), AIR]
    assert (lens.stop_index, lens.stated_efl, lens.stated_f_number) == (3, 50.0, 4.0)
    assert (lens.name, lens.notes) == ("Made-up zoom", "Two lines of notes")
    assert lens.findings == ()
    assert lens.positions.thicknesses == (((3.5, 40.25),), ((9.25, 45.5),)) and lens.positions.gaps == (3, 5)
    assert lens.positions.focal_lengths == (50.0, 80.0) and lens.at(zoom=1.0).stated_efl == 80.0


def test_the_stop_has_the_diameter_of_its_row_at_each_position(tmp_path):
    lens = sample(tmp_path, ("d0\t", "Aperture Diameter\t12.5\t15.5\nd0\t"))
    assert lens.positions.stops == ((6.25,), (7.75,)) and lens.findings == ()
    assert (lens.stop.semi_diameter, lens.at(zoom=1.0).stop.semi_diameter) == (6.25, 7.75)
    assert lenses.save(lens, tmp_path / "again.txt") == ()
    assert lenses.load(tmp_path / "again.txt") == lens
    assert lens == sample(tmp_path, ("d0\t", "Aperture Diameter\t12.5\t15.5\nd0\t"),
                          ("d4\t\t12.5", "d4\t\tAperture Diameter"))
    other = sample(tmp_path, ("d0\t", "Aperture Diameter\t10\nd0\t"))
    assert other.stop.semi_diameter == 5.0 and other.positions.stops == ()
    remark, = other.findings
    assert remark.kind is lenses.Kind.STOP_SIZE and remark.surface == 3
    assert "12.5 mm" in str(remark) and "10 mm" in str(remark)
    error = refusal(tmp_path, "lens.txt", SAMPLE.replace("d0\t", "Aperture Diameter\t12.5\t0\nd0\t", 1))
    assert error.line == 8 and "Aperture Diameter is 0" in error.reason


def test_positions_are_the_columns_that_have_distances(tmp_path):
    lens = sample(tmp_path, ("d0\t", "Magnification\t1\t2\t3\t4\t5\t6\t7\nImage Height\t43.2\t43.2\t43.2\nd0\t"))
    assert lens.positions == sample(tmp_path).positions
    assert lens.findings == () and lens.system.largest_field == 21.6
    assert sample(tmp_path, ("3.5\t9.25", "3.5"), ("40.25\t45.5", "40.25"),
                  ("Infinity\tInfinity", "Infinity")).positions is None


@pytest.mark.parametrize(("rows", "kind", "largest", "left_out"), [
    ("Angle of View\t63\t28\nImage Height\t43.2\t43.2\n", FieldKind.ANGLE, 31.5, "Image Height 43.2"),
    ("Image Height\t43.2\n", FieldKind.REAL_IMAGE_HEIGHT, 21.6, ""),
    ("Angle of View\tundefined\nImage Height\t43.2\n", FieldKind.REAL_IMAGE_HEIGHT, 21.6, "")])
def test_the_field_is_half_the_angle_of_view_or_half_the_height_of_the_image(tmp_path, rows, kind, largest, left_out):
    lens = sample(tmp_path, ("d0\t", f"{rows}d0\t"))
    assert lens.system.field_kind is kind and lens.system.fields == (FieldPoint(0.0, largest),)
    assert [left_out in str(finding) for finding in lens.findings] == ([True] if left_out else [])
    assert lenses.save(lens, tmp_path / "again.txt") == ()
    again = lenses.load(tmp_path / "again.txt")
    assert again == lens and again.system == lens.system


def test_an_f_number_that_was_stated_as_the_aperture_is_written(tmp_path):
    lens = replace(sample(tmp_path), stated_f_number=None, positions=None,
                   system=SystemData(Aperture(ApertureKind.F_NUMBER, (5.6,))))
    lenses.save(lens, tmp_path / "again.txt")
    assert lenses.load(tmp_path / "again.txt").stated_f_number == 5.6


def test_powers_of_the_aspheric_columns_follow_from_the_constants(tmp_path):
    def terms(constant):
        return sample(tmp_path, ("AsphericalOddCount\t1", constant)).surfaces[5].aspheric

    assert sample(tmp_path).surfaces[5].conic == -0.5
    assert terms("AsphericalOddCount\t1") == ((3, 1e-6), (4, -2e-7), (6, 3e-10))
    assert terms("AsphericalOddCount\t2") == terms("AsphericalOddCount") == ((3, 1e-6), (4, -2e-7), (5, 3e-10))
    assert terms("AsphericalA2") == ((2, 1e-6), (4, -2e-7), (6, 3e-10))
    assert terms("AsphericalOddCount\t0") == ((4, 1e-6), (6, -2e-7), (8, 3e-10))


def test_the_stop_is_a_plane_of_its_own_or_on_a_surface(tmp_path):
    lens = sample(tmp_path, ("3\tInfinity", "3\tAS"), ("4AS", "4"))
    assert lens.stop_index == 2
    lens = sample(tmp_path, ("4AS", "4"))
    assert lens.stop_index == 3 and any("no stop" in finding.message for finding in lens.findings)


def test_a_glass_by_its_name_alone_is_that_of_the_catalogue(tmp_path):
    lens = sample(tmp_path, ("1.64769\t19.5\t33.79\tN-SF2\tSchott", "\t19.5\t\tN-SF2\tSchott"))
    assert lens.surfaces[1].glass == catalogue.find("N-SF2")


@pytest.mark.parametrize(("old", "new", "told"), [
    ("4\t1.62041", "d7\t1.62041", "d7"),
    ("1\t48.5", "1\tabc", "radius"),
    ("1.62041\t20", "1.62041\t-20", "diameter"),
    ("1.62041\t20", "0.62041\t20", "n_d"),
    ("6\t-52.5\t-0.5", "9\t-52.5\t-0.5", "'9'"),
    ("6\t-52.5\t-0.5\t1e-6", "6\t-52.5\t-0.5\tnan", "r^3"),
    ("d4\t3.5", "d4\tx", "d4"),
    ("d4\t3.5\t9.25", "d4\t3.5\ty", "d4"),
    ("\t\t19.5\t\tXX", "\t\t19.5\t\tXX", "XX"),
])
def test_mistakes_name_their_line(tmp_path, old, new, told):
    text = SAMPLE.replace("1.64769\t19.5\t33.79\tN-SF2\tSchott", "\t19.5\t\tXX") if told == "XX" else SAMPLE
    old, new = ("2\t-120.25", "2\t-120.25") if told == "XX" else (old, new)
    error = refusal(tmp_path, "lens.txt", text.replace(old, new, 1))
    assert error.line == SAMPLE.count("\n", 0, SAMPLE.index(old)) + 1 and told in error.reason


def test_another_file_is_refused(tmp_path):
    assert "[lens data]" in refusal(tmp_path, "a.txt", "[constants]\n").reason
    assert "before the first section" in refusal(tmp_path, "a.txt", "A letter to a friend\n").reason


odd_or_even = st.sampled_from([tuple(range(2, 21, 2)), tuple(range(3, 21))])


@given(odd_or_even.flatmap(lambda powers: prescriptions(
    powers, cylinders=False, name=plain_words, notes=plain_words, stated_efl=st.none() | st.floats(-1e3, 1e3),
    stated_f_number=st.none() | st.floats(0.5, 64.0))))
@settings(max_examples=100)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.txt"
    assert lenses.save(lens, path) == ()
    assert lenses.load(path) == lens


def test_catalogue_glasses_come_back_and_losses_are_reported(tmp_path):
    lens = sample(tmp_path)
    lens = replace(lens, surfaces=(replace(lens.surfaces[0], glass=catalogue.find("N-SK16")),
                                   *lens.surfaces[1:]), year=1999)
    assert [str(remark) for remark in lenses.save(lens, tmp_path / "b.txt")] == ["left out: year"]
    assert lenses.load(tmp_path / "b.txt") == replace(lens, year=None)
    rod = replace(lens, surfaces=(replace(lens.surfaces[0], curvature_x=0.0), *lens.surfaces[1:-1],
                                  replace(lens.surfaces[-1], aspheric=((2, 1e-5), (3, 1e-6)))))
    remarks = lenses.save(rod, tmp_path / "c.txt")
    assert any("cylinder" in str(remark) for remark in remarks) and any("r^2" in str(remark) for remark in remarks)


def test_the_f_number_that_a_file_states_is_written_before_that_of_the_design():
    for stated, expected in ((2.0, 2.0), (None, 2.03)):
        lens = replace(lenses.load("pbrt-dgauss-50mm"), stated_f_number=stated, system=SystemData(
            aperture=Aperture(ApertureKind.F_NUMBER, (2.03,))))
        assert READERS[".txt"](WRITERS[".txt"](lens)[0], "x.txt").stated_f_number == expected
