"""Lens files of pbrt: both conventions of the gap, the stop by radius 0, units, mistakes, and round trips."""

from dataclasses import replace

import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.lenses import Kind
from tests.library import CLASSICS

# A thick meniscus, a stop and a biconvex lens; lensmaker's thick-lens values below are computed by hand from these rows
NEW = """# A made-up pair
# for tests
# radius thickness index diameter
 40    5    1.6  24
 60    6    1    22
 0     4    1    12
 80    4    1.5  20
 -45   0    1    20
"""
OLD = """# A made-up pair
# for tests
# radius axpos N aperture
 40    0    1.6  24
 60    5    1    22
 0     6    0    12
 80    4    1.5  20
 -45   4    1    20
"""


def test_rows_are_radius_gap_index_and_diameter_in_mm(tmp_path):
    lens = load_text(tmp_path, NEW)
    assert [s.thickness for s in lens.surfaces] == [5.0, 6.0, 4.0, 4.0, 0.0]
    assert [s.semi_diameter for s in lens.surfaces] == [12.0, 11.0, 6.0, 10.0, 10.0]
    assert [s.glass.n_d for s in lens.surfaces] == [1.6, 1.0, 1.0, 1.5, 1.0]
    assert lens.surfaces[0].curvature == 1.0 / 40.0 and lens.stop_index == 2
    assert lens.name == "A made-up pair" and lens.notes == "for tests" and not lens.findings


def test_the_focal_length_is_that_of_two_thick_lenses(tmp_path):
    # powers by the lensmaker's equation, joined at the distance of their principal planes
    def thick(r1, r2, t, n):
        p1, p2 = (n - 1.0) / r1, (1.0 - n) / r2
        power = p1 + p2 - p1 * p2 * t / n
        return power, (n - 1.0) / n * t * -p2 / (n - 1.0) / power, (n - 1.0) / n * t * p1 / (n - 1.0) / power
    a, _, back = thick(40.0, 60.0, 5.0, 1.6)
    b, _, _ = thick(80.0, -45.0, 4.0, 1.5)
    front = 4.0 / 1.5 * (0.5 / 45.0) / b
    gap = 10.0 + back + front
    assert lb.first_order(load_text(tmp_path, NEW)).efl == pytest.approx(1.0 / (a + b - a * b * gap), rel=1e-12)


def test_gaps_before_their_surfaces_are_recognised_and_reported(tmp_path):
    lens = load_text(tmp_path, OLD)
    assert lens == load_text(tmp_path, NEW)
    assert len(lens.findings) == 1 and "before their surfaces" in lens.findings[0].message


def test_gaps_before_their_surfaces_need_no_header_to_be_recognised(tmp_path):
    lens = load_text(tmp_path, OLD.replace("axpos", "thickness"))
    assert lens == load_text(tmp_path, NEW) and "before" in lens.findings[0].message


def test_an_old_header_over_new_gaps_is_not_believed(tmp_path):
    lens = load_text(tmp_path, NEW.replace("thickness", "axpos"))
    assert lens == load_text(tmp_path, NEW)
    assert len(lens.findings) == 1 and "axpos" in lens.findings[0].message


def test_if_both_readings_make_a_lens_the_header_decides(tmp_path):
    text = "0 0 1 10\n50 4 1.5 12\n-50 45 1 12\n"
    lens = load_text(tmp_path, f"# radius axpos N aperture\n{text}")
    assert [s.thickness for s in lens.surfaces] == [4.0, 45.0, 0.0] and "before" in lens.findings[0].message


def test_a_stop_at_the_front_vertex_is_not_taken_for_the_old_convention(tmp_path):
    lens = load_text(tmp_path, "0 0 1 10\n50 4 1.5 12\n-50 45 1 12\n")
    assert lens.stop_index == 0 and [s.thickness for s in lens.surfaces] == [0.0, 4.0, 45.0] and not lens.findings


@pytest.mark.parametrize("words, factor", [("units: m", 1e-3), ("lengths in metres", 1e-3), ("all in meters", 1e-3),
                                           ("(cm)", 0.1), ("in millimetres", 1.0), ("scaled to 10 mm", 1.0)])
def test_a_comment_may_name_the_unit(tmp_path, words, factor):
    rows = [[float(word) for word in line.split()] for line in NEW.split("\n") if line and line[0] != "#"]
    text = "".join(f"{r * factor!r} {t * factor!r} {n} {d * factor!r}\n" for r, t, n, d in rows)
    lens, expected = load_text(tmp_path, f"# {words}\n{text}"), load_text(tmp_path, NEW)
    for read, known in zip(lens.surfaces, expected.surfaces, strict=True):
        assert read.thickness == pytest.approx(known.thickness, rel=1e-14)
        assert read.semi_diameter == pytest.approx(known.semi_diameter, rel=1e-14)
        assert read.curvature == pytest.approx(known.curvature, rel=1e-14)
    assert any("converted" in finding.message for finding in lens.findings) == (factor != 1.0)


def test_notes_that_speak_of_metres_do_not_scale_what_was_saved(tmp_path):
    lens = replace(load_text(tmp_path, NEW), notes="distances in metres")
    lenses.save(lens, tmp_path / "noted.dat")
    assert lenses.load(tmp_path / "noted.dat").surfaces == lens.surfaces


def test_without_a_stop_the_smallest_rim_limits_with_a_finding(tmp_path):
    lens = load_text(tmp_path, NEW.replace(" 0     4    1    12\n", ""))
    assert lens.stop_index == 2 and lens.surfaces[2].semi_diameter == 10.0 and "no stop" in lens.findings[0].message


def test_of_two_stops_the_one_that_limits_the_axial_beam_is_the_stop(tmp_path):
    lens = load_text(tmp_path, NEW + "0 0 1 4\n")
    assert lens.stop_index == 5 and "2 stops" in lens.findings[0].message
    assert load_text(tmp_path, NEW + "0 0 1 40\n").stop_index == 2


def test_a_plane_of_glass_is_no_stop(tmp_path):
    lens = load_text(tmp_path, NEW.replace(" 80 ", " 0 "))
    assert lens.stop_index == 2 and lens.surfaces[3].curvature == 0.0 and "plane" in lens.findings[0].message


MISTAKES = {
    "too few columns": (" 60    6    1    22", " 60    6    1", 5, "four columns"),
    "too many columns": (" 60    6    1    22", " 60    6    1    22 3", 5, "four columns"),
    "half a row": (" -45   0    1    20\n", " -4", 8, "1 value"),
    "not a number": (" 60 ", " sixty ", 5, "radius is 'sixty'"),
    "nan": (" 60 ", " nan ", 5, "nan"),
    "infinite gap": ("60    6 ", "60    inf ", 5, "thickness is inf"),
    "negative diameter": ("1    22", "1    -22", 5, "diameter is -22"),
    "no diameter": ("1    22", "1    0", 5, "diameter is 0"),
    "index below one": ("1.6", "0.6", 4, "index"),
    "index zero": ("1.6", "0", 4, "index"),
    "only comments": (NEW[NEW.index(" 40"):], "", None, "no surfaces"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_clear_line_with_its_place(tmp_path, mistake):
    old, new, line, reason = MISTAKES[mistake]
    assert old in NEW
    with pytest.raises(lenses.LensFileError) as caught:
        load_text(tmp_path, NEW.replace(old, new))
    assert caught.value.line == line and reason in caught.value.reason and "\n" not in str(caught.value)


SPHERICAL = [name for name in CLASSICS if all(s.is_spherical for s in lenses.load(name).surfaces)]


@pytest.mark.parametrize("name", sorted(set(CLASSICS) - set(SPHERICAL)))
def test_of_an_aspheric_lens_every_surface_that_is_lost_is_named(tmp_path, name):
    lens = lenses.load(name)
    remarks = lenses.save(lens, tmp_path / "lost.dat")
    lost = [remark for remark in remarks if remark.kind is Kind.SHAPE and "cannot hold" in str(remark)]
    assert len(lost) == sum(not surface.is_spherical for surface in lens.surfaces) > 0


@pytest.mark.parametrize("name", SPHERICAL)
def test_the_geometry_survives_the_way_through_pbrt(tmp_path, name):
    # planes become radii of 1 km: 1e-3 of a power of at most 1/10 mm; a stop on a curved rim becomes a plane beside it
    lens, path = lenses.load(name), tmp_path / "through.dat"
    remarks = lenses.save(lens, path)
    back = lenses.load(path)
    before, after = lb.first_order(lens), lb.first_order(back)
    assert after.efl == pytest.approx(before.efl, rel=1e-4)
    assert after.f_number == pytest.approx(before.f_number, rel=0.01)
    assert back.name == lens.name and not back.findings
    if len(back.surfaces) == len(lens.surfaces) and not any("1 km" in str(remark) for remark in remarks):
        for one, other in zip(back.surfaces, lens.surfaces, strict=True):
            assert (one.curvature, one.thickness, one.semi_diameter) == \
                   (other.curvature, other.thickness, other.semi_diameter)


def test_losses_of_pbrt_files_are_reported(tmp_path):
    remarks = " | ".join(map(str, lenses.save(lenses.load("lenshh-cooke-triplet-50"), tmp_path / "triplet.dat")))
    for word in ("Abbe", "glasses", "comments", "stated", "the stop is at surface 3"):
        assert word in remarks


def load_text(folder, text):
    path = folder / "lens.dat"
    path.write_text(text, encoding="utf-8")
    return lenses.load(path)


def test_other_shapes_than_spheres_are_reported_as_losses(tmp_path):
    lens = lb.Lens((lb.Surface(4.0, 10.0, lb.Glass(1.5), curvature=0.02, conic=-1.0),
                    lb.Surface(3.0, 10.0, curvature=-0.02),
                    lb.Surface(3.0, 8.0, curvature=0.0), lb.Surface(60.0, 10.0, curvature=0.01, curvature_x=0.0)), 2)
    remarks = lenses.save(lens, tmp_path / "shaped.dat")
    assert any("surface 0 is a conic" in str(remark) for remark in remarks)
    assert any("surface 3 is a cylinder" in str(remark) for remark in remarks)
    assert not any(remark.surface == 1 for remark in remarks)
