"""Configurations of other programs: round trips in every format that has them, and lists of zoom and distance."""

from dataclasses import replace
from math import inf

import pytest
from hypothesis import assume, given, settings, strategies as st

import lensbench as lb
from lensbench import Glass, Lens, Positions, Surface, lenses
from lensbench.lenses import Kind
from lensbench.lenses.editing.elements import reversed_lens
from lensbench.lenses.tables.stations import Station, focus_fractions, stations_of, with_stations, zoom_fractions
from tests.lenses.samples import DATA, loaded

GLASS = Glass(1.5, 60.0)
NAMED = (".zmx", ".seq")


def two_groups(gap, back, rim=8.0):
    """A diverging group before a converging one."""
    return (Surface(1.0, rim, GLASS, curvature=-0.0125), Surface(gap, rim, curvature=0.0125),
            Surface(2.0, rim, GLASS, curvature=0.025),
            Surface(back, rim, curvature=-0.025))


@st.composite
def zooms(draw, suffix):
    """A zoom of one to three settings at one to three distances, with stations where a reader places them."""
    count, near = draw(st.integers(1, 3)), draw(st.integers(0, 2))
    assume(count + near > 1)
    separations = sorted(draw(st.lists(st.floats(1.0, 60.0), min_size=count, max_size=count, unique=True)))[::-1]
    shifts = sorted(draw(st.lists(st.floats(0.01, 0.9), min_size=near, max_size=near, unique=True)))
    backs = draw(st.lists(st.floats(10.0, 200.0), min_size=count, max_size=count, unique=True))    # all gaps vary
    table = tuple(tuple((d - shift, back + shift) for shift in (0.0, *shifts))
                  for d, back in zip(separations, backs, strict=True))
    lens = Lens(two_groups(separations[0], backs[0]), 2)
    lengths = [lb.first_order(Lens(two_groups(row[0][0], row[0][1]), 2)).efl for row in table]
    assume(all(a < b for a, b in zip(lengths, lengths[1:], strict=False)))
    far = sorted(draw(st.lists(st.floats(150.0, 1e6), min_size=near, max_size=near, unique=True)))[::-1]
    distances = tuple((inf, *far) for _ in table) if near else ()
    named = suffix in NAMED and count > 1 and draw(st.booleans())
    stops = suffix != ".txt" and draw(st.booleans())
    stated = suffix == ".txt" and count > 1
    return replace(lens, positions=Positions(
        (1, 3), table, zoom_fractions(lengths), focus_fractions(distances[0]) if near else (0.0,),
        tuple(f"setting {i}" for i in range(count)) if named else (),
        tuple(map(float, range(20, 20 + count))) if stated else (), tuple(2.0 for _ in table) if stated else (),
        distances, tuple(tuple(4.0 + i + 0.5 * j for j in range(near + 1)) for i in range(count)) if stops else (),
    )).at()


@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".len", ".txt"])
@given(data=st.data())
@settings(max_examples=40)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, suffix, data):
    path = tmp_path_factory.getbasetemp() / f"zoom{suffix}"
    lens = data.draw(zooms(suffix))
    told = lenses.save(lens, path)
    assert all("stated" in str(remark) for remark in told)
    read = lenses.load(path)
    # a distance from the film is written as one from the first vertex: for some pairs no such number gives it back
    for row, kept in zip(lens.positions.distances, read.positions.distances, strict=True):
        assert kept == pytest.approx(row, rel=3e-16)
    assert replace(read.positions, distances=lens.positions.distances,
                   focus_stations=lens.positions.focus_stations) == lens.positions
    assert read.positions.focus_stations == pytest.approx(lens.positions.focus_stations, rel=1e-15)
    assert read.surfaces == lens.surfaces and read.stop_index == lens.stop_index


@pytest.mark.parametrize("name", ["lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", "lv-minolta-af-100mm-f28-macro"])
@pytest.mark.parametrize("suffix", [".zmx", ".seq", ".len", ".txt"])
def test_lenses_of_the_library_keep_their_stations_in_every_format_that_has_them(tmp_path, name, suffix):
    lens = lenses.load(name)
    lenses.save(lens.at(close=0.7), tmp_path / f"a{suffix}")
    read = lenses.load(tmp_path / f"a{suffix}")
    assert (read.positions.gaps, read.positions.thicknesses) == (lens.positions.gaps, lens.positions.thicknesses)
    assert read.positions.distances == lens.positions.distances
    assert [s.thickness for s in read.surfaces] == [s.thickness for s in lens.surfaces]


@pytest.mark.parametrize("suffix", [".dat", ".json", ".roa"])
def test_a_format_of_one_position_says_that_the_others_are_left_out(tmp_path, suffix):
    lens = lenses.load("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", zoom=1.0)
    assert any(remark.kind is Kind.POSITION for remark in lenses.save(lens, tmp_path / f"a{suffix}"))
    read = lenses.load(tmp_path / f"a{suffix}")
    assert read.positions is None and read.length == pytest.approx(lens.length, rel=1e-14)
    plain = replace(lens, positions=None)
    assert not any(remark.kind is Kind.POSITION for remark in lenses.save(plain, tmp_path / f"b{suffix}"))


def test_a_reversed_lens_keeps_its_present_position_and_reports_the_loss():
    lens = lenses.load("lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed", zoom=1.0)
    turned = reversed_lens(lens)
    assert turned.positions is None and any(finding.kind is Kind.POSITION for finding in turned.findings)
    # the focal length is the same from either side
    assert lb.first_order(turned).efl == pytest.approx(lb.first_order(lens).efl, rel=1e-12)


def test_losses_of_positions_are_reported(tmp_path):
    lens = lenses.load("lv-pentax-02-standard-zoom-5-15-f28-45")
    renamed = replace(lens, positions=replace(lens.positions, names=("W", "M", "T"), zoom_stations=(0.0, 0.5, 1.0)))
    for suffix in (".zmx", ".seq", ".len", ".txt"):
        told = lenses.save(renamed.at(zoom=0.5), tmp_path / f"a{suffix}")
        assert any("written in its first position" in str(remark) for remark in told)
        assert any("zoom positions between 0 and 1 are left out" in str(remark) for remark in told)
        assert any("names of its positions" in str(remark) for remark in told) == (suffix in (".len", ".txt"))


ZOOM = DATA / "zoom.zmx"


def solved(text, solve):
    """The file without the last gap of each configuration, and with a solve for it."""
    kept = "\n".join(line for line in text.split("\n") if not line.startswith("THIC 4"))
    return kept.replace("  DISZ 57.7778", f"  DISZ 57.7778\n  {solve}")


def test_a_back_focus_that_a_zemax_file_leaves_to_a_solve_is_that_of_the_paraxial_image(tmp_path):
    lens = loaded(tmp_path, "a.zmx", solved(ZOOM.read_text(), "MAZH 0 0"))
    assert any("MAZH: the back focus of each position" in finding.message for finding in lens.findings)
    for zoom, before in ((0.0, 787.0222), (1.0, 813.4667)):
        far, near = lens.at(zoom=zoom), lens.at(zoom=zoom, close=1.0)
        # at infinity; and the object of a near position lies where the file has it
        assert far.surfaces[3].thickness == pytest.approx(lb.first_order(far).bfl, rel=1e-12)
        distance = lb.focused_distance(near, near.surfaces[3].thickness)
        assert distance - near.length - near.surfaces[3].thickness == pytest.approx(before, rel=1e-9)


def test_the_first_position_keeps_the_digits_that_its_file_has(tmp_path):
    solve = solved(ZOOM.read_text(), "MAZH 0 0")
    gap = loaded(tmp_path, "a.zmx", solve).surfaces[3].thickness
    again = loaded(tmp_path, "b.zmx", solve.replace("DISZ 57.7778", f"DISZ {gap:.9g}"))
    assert again.surfaces[3].thickness == float(f"{gap:.9g}") != gap


@pytest.mark.parametrize("solve", ["TCOM 2 107.7778", "TOLE 2 111.7778"])
def test_gaps_that_a_zemax_file_makes_up_to_a_sum_follow_the_zoom(tmp_path, solve):
    lens = loaded(tmp_path, "a.zmx", solved(ZOOM.read_text(), solve))
    for row in lens.positions.thicknesses:
        for gaps in row:                                        # those behind surfaces 2 and 4; between them stand 4 mm
            assert sum(gaps) == pytest.approx(107.7778, rel=1e-12)
    stated = ZOOM.read_text().replace("  DISZ 57.7778", f"  DISZ 57.7778\n  {solve}")
    assert loaded(tmp_path, "b.zmx", stated).positions == lenses.load(ZOOM).positions      # what is stated counts


def test_a_back_focus_that_a_codev_file_leaves_to_a_solve_is_that_of_the_paraxial_image(tmp_path):
    text = (DATA / "zoom.seq").read_text().partition("ZOO THI S4")[0] + "GO\n"
    lens = loaded(tmp_path, "a.seq", text.replace("SI 0.0", "  PIM\nSI 0.0"))
    assert any("PIM: the back focus of each position" in finding.message for finding in lens.findings)
    for zoom in lens.positions.zoom_stations:
        far = lens.at(zoom=zoom)
        assert far.surfaces[3].thickness == pytest.approx(lb.first_order(far).bfl, rel=1e-12)


def stations(*rows):
    return [Station({1: gap, 3: back}, distance) for gap, back, distance in rows]


WIDE, TELE = (50.0, 104.0), (10.0, 160.0)
NEAR_WIDE, NEAR_TELE = (44.0, 110.0), (7.5, 162.5)


@pytest.mark.parametrize("order", ["settings first", "distances first", "tele first"])
def test_a_list_of_settings_and_distances_becomes_a_table_of_both(order):
    rows = {"settings first": ((*WIDE, inf), (*TELE, inf), (*NEAR_WIDE, 800.0), (*NEAR_TELE, 790.0)),
            "distances first": ((*WIDE, inf), (*NEAR_WIDE, 800.0), (*TELE, inf), (*NEAR_TELE, 790.0)),
            "tele first": ((*TELE, inf), (*WIDE, inf), (*NEAR_TELE, 790.0), (*NEAR_WIDE, 800.0))}[order]
    lens, told = with_stations(Lens(two_groups(*rows[0][:2]), 2), stations(*rows))
    assert lens.positions.thicknesses == ((WIDE, NEAR_WIDE), (TELE, NEAR_TELE))
    assert lens.positions.distances == ((inf, 800.0 + 1.0 + 44.0 + 2.0 + 110.0), (inf, 790.0 + 1.0 + 7.5 + 2.0 + 162.5))
    assert lens.surfaces == two_groups(*WIDE)
    assert bool(told) == (order == "tele first")


def test_configurations_that_form_no_table_keep_those_at_infinity_with_a_finding():
    rows = ((*WIDE, inf), (*TELE, inf), (*NEAR_WIDE, 800.0))
    lens, told = with_stations(Lens(two_groups(*WIDE), 2), stations(*rows))
    assert lens.positions.thicknesses == ((WIDE,), (TELE,)) and "only those at infinity are kept" in str(told[0])


def test_positions_that_are_all_alike_are_none():
    lens = Lens(two_groups(*WIDE), 2)
    assert with_stations(lens, stations((*WIDE, inf), (*WIDE, inf))) == (lens, [])
    assert with_stations(lens, []) == (lens, []) and stations_of(lens) == ([], [])


def test_a_near_position_without_a_distance_is_written_with_that_of_its_paraxial_image():
    lens = Lens(two_groups(*WIDE), 2)
    table = Positions((1, 3), ((WIDE, NEAR_WIDE),), focus_stations=(0.0, 1.0))
    written, told = stations_of(replace(lens, positions=table))
    near = replace(lens, positions=table).at(close=1.0)
    # by 1/f = 1/s + 1/s' of the whole lens, from its principal planes
    fo = lb.first_order(near)
    image = NEAR_WIDE[1] - fo.rear_principal
    in_front = 1.0 / (1.0 / fo.efl - 1.0 / image) - fo.front_principal
    assert written[1].distance == pytest.approx(in_front, rel=1e-9) and "paraxial" in str(told[0])


def test_stations_are_placed_by_focal_length_and_by_the_reciprocal_of_the_distance():
    assert zoom_fractions([10.0, 20.0, 40.0]) == pytest.approx((0.0, 0.5, 1.0), abs=1e-15)
    assert zoom_fractions([10.0, 5.0, 40.0]) == (0.0, 0.5, 1.0) and zoom_fractions([7.0]) == (0.0,)
    assert focus_fractions([inf, 2000.0, 500.0]) == (0.0, 0.25, 1.0)
    assert focus_fractions([0.0, 0.0]) == (0.0, 1.0) and focus_fractions([inf]) == (0.0,)


def test_a_unit_other_than_mm_holds_for_every_position(tmp_path):
    lens = Lens(two_groups(*WIDE), 2, positions=Positions((1, 3), ((WIDE,), (TELE,)), (0.0, 1.0)))
    lenses.save(lens, tmp_path / "a.zmx")
    text = (tmp_path / "a.zmx").read_text()
    inches = loaded(tmp_path, "b.zmx", text.replace("UNIT MM", "UNIT IN"))
    for zoom in (0.0, 1.0):
        assert [s.thickness for s in inches.at(zoom=zoom).surfaces] == [
            s.thickness * 25.4 for s in lens.at(zoom=zoom).surfaces]
