"""Positions in the project's lens file: read, written to the last bit, and each mistake with its line."""

from dataclasses import replace
from math import inf
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench import Lens, Positions, Surface, lenses
from lensbench.lenses import Kind
from tests.lenses.samples import curvatures, loaded, refusal

TEXT = """format = 1
columns = ["radius", "thickness", "n_d", "semi_diameter"]
surfaces = [
    [-40.0, 1.0, 1.5, 10.0],
    [0, 50.0, 1.0, 10.0],
    [20.0, 2.0, 1.5, 8.0, "stop"],
    [0, 104.0, 1.0, 9.0],
]

[positions]
names = ["wide", "tele"]
focus_stations = [0, 1]
focal_lengths = [30, 60]
distances = [[inf, 900], [inf, 900]]

[positions.gaps]
1 = [[50.0, 44], [10, 7.5]]
3 = [[104.0, 110], [160, 163.5]]
"""

inner_positions = st.lists(st.floats(0.01, 0.99), max_size=3, unique=True).map(sorted)
ends = inner_positions.map(lambda inside: (0.0, *inside, 1.0)) | st.just((0.0,))
lengths = st.floats(-1e3, 1e3)
positive = st.floats(1e-3, 1e4)


@st.composite
def lenses_with_positions(draw):
    table = tuple(Surface(1.0, 5.0, curvature=c) for c in draw(st.lists(curvatures, min_size=1, max_size=5)))
    gaps = tuple(sorted(draw(st.sets(st.integers(0, len(table) - 1), min_size=1))))
    zooms, focuses = draw(ends), draw(ends)

    def grid(values):
        return tuple(tuple(draw(values) for _ in focuses) for _ in zooms)

    def row(values):
        return tuple(draw(values) for _ in zooms) if draw(st.booleans()) else ()

    positions = Positions(
        gaps, grid(st.tuples(*[lengths] * len(gaps))), zooms, focuses, row(st.text("abcä \"\\", max_size=5)),
        row(lengths), row(positive), grid(positive | st.just(inf)) if draw(st.booleans()) else (),
        grid(positive) if draw(st.booleans()) else (),
        draw(st.floats(0.0, 1.0)) if len(zooms) > 1 else 0.0, draw(st.floats(0.0, 1.0)) if len(focuses) > 1 else 0.0)
    return Lens(table, draw(st.integers(0, len(table) - 1)), positions=positions).at()


@given(lenses_with_positions())
@settings(max_examples=100)
def test_a_saved_lens_loads_equal_to_the_last_bit(tmp_path_factory, lens):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    assert lenses.save(lens, path) == ()
    assert lenses.load(path) == lens


def test_a_table_is_read_and_its_stations_are_placed_by_focal_length(tmp_path):
    lens = loaded(tmp_path, "a.toml", TEXT)
    assert lens.findings == () and lens.zooms and lens.has_focus_groups
    positions = lens.positions
    assert positions.gaps == (1, 3)
    assert positions.thicknesses == (((50.0, 104.0), (44.0, 110.0)), ((10.0, 160.0), (7.5, 163.5)))
    assert positions.zoom_stations == positions.focus_stations == (0.0, 1.0)
    assert positions.distances == ((inf, 900.0), (inf, 900.0))
    assert (lens.stated_efl, lens.at(zoom=1.0).stated_efl) == (30.0, 60.0)


def test_load_takes_a_position(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(TEXT)
    near_tele = lenses.load(path, zoom=1.0, close=1.0)
    assert [s.thickness for s in near_tele.surfaces] == [1.0, 7.5, 2.0, 163.5]
    assert near_tele == lenses.load(path).at(zoom=1.0, close=1.0)
    assert lenses.load(path, zoom=0.0, close=0.0) == lenses.load(path)
    between = lenses.load(path, zoom=0.25, close=0.5)
    assert between.surfaces[1].thickness == pytest.approx(0.5 * (40.0 + 34.875), rel=1e-14)     # two stations: a line
    with pytest.raises(lb.LensError, match="between 0 .wide. and 1 .tele."):
        lenses.load(path, zoom=1.5)
    with pytest.raises(lb.LensError, match="does not zoom"):
        lenses.load("pbrt-dgauss-50mm", zoom=0.5)
    with pytest.raises(lb.LensError, match="has no focus groups"):
        lenses.load("pbrt-dgauss-50mm", close=0.5)


def test_a_row_with_another_gap_than_its_position_is_reported(tmp_path):
    lens = loaded(tmp_path, "a.toml", TEXT.replace("[0, 50.0,", "[0, 55.0,"))
    assert lens.surfaces[1].thickness == 50.0
    (finding,) = lens.findings
    assert (finding.kind, finding.surface) == (Kind.POSITION, 1)
    assert str(finding) == ("surface 1: the thickness of its row, 55 mm, is not that of its position, 50 mm, which is "
                            "used")


@pytest.mark.parametrize(("old", "new", "line", "told"), [
    ("names = [", "titles = [", 11, "'titles' is unknown"),
    ('names = ["wide", "tele"]', "names = [1, 2]", 11, "names must be a list of texts"),
    ("[inf, 900], [", "[inf, 900, 3], [", None, "distances must have a row"),
    ("[30, 60]", "[30, nan]", 13, "focal_lengths"),
    ("[30, 60]", "30", 13, "must be a list"),
    ("focus_stations = [0, 1]", "focus_stations = [0, 0.5, 1]", None, "must have a row"),
    ("3 = [[104.0", "4 = [[104.0", 18, "there is no surface '4'"),
    ("3 = [[104.0", "1 = [[104.0", None, "TOML"),
    ("3 = [[104.0", "03 = [[x", None, "TOML"),
    ("3 = [[104.0, 110]", "3 = [[104.0]", 18, "another number of positions"),
    ("3 = [[104.0, 110]", "3 = [104.0", 18, "list of"),
    ("3 = [[104.0, 110]", "3 = [[104.0, inf]", 18, "finite"),
    ("[positions.gaps]\n", "", None, "unknown"),
])
def test_mistakes_name_their_line(tmp_path, old, new, line, told):
    assert old in TEXT
    error = refusal(tmp_path, "a.toml", TEXT.replace(old, new, 1))
    assert told in error.reason
    assert line is None or error.line == line


def test_positions_that_are_no_table_are_refused(tmp_path):
    head = TEXT.partition("[positions]")[0]
    assert "must be a table" in refusal(tmp_path, "a.toml", head.replace("format", "positions = 3\nformat", 1)).reason
    assert "the varying gaps are missing" in refusal(tmp_path, "a.toml", head + "[positions]\n").reason


def test_the_example_of_the_documentation_is_read(tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "lens-files.md").read_text(encoding="utf-8")
    lens = loaded(tmp_path, "a.toml", text.partition("```toml\n")[2].partition("```")[0])
    assert lens.findings == () and (lens.blades, lens.roundness) == (9, 0.4)
    assert lens.surfaces[4].aspheric == ((4, 1.5e-6), (6, -2e-9), (7, 1e-11)) and lens.surfaces[1].conic == -0.5
    assert lens.surfaces[0].glass.formula == "sellmeier" and lens.positions.label(1, 1) == "tele, close"
    assert lens.surfaces[1].pose == replace(lens.surfaces[0].pose, pivot=1)
    assert [str(finding) for finding in lenses.check(lens)] == [
        "tilted or decentred surfaces: the lens is checked as if centred"]
    for zoom, stated in ((0.0, 34.8), (1.0, 48.9)):
        assert lb.first_order(lens.at(zoom=zoom)).efl == pytest.approx(stated, rel=1e-3)      # three digits
        assert lens.at(zoom=zoom).stated_efl == stated


ZOOMS = {"lv-nikon-afs-vr-zoom-nikkor-70-200-f28g-if-ed": 1500.0, "lv-pentax-02-standard-zoom-5-15-f28-45": 300.0}


@pytest.mark.parametrize("name", ZOOMS)
def test_the_zooms_of_the_library_have_their_published_focal_lengths_and_distances(name):
    lens = lenses.load(name)
    positions = lens.positions
    for zoom, stated in zip(positions.zoom_stations, positions.focal_lengths, strict=True):
        far = lens.at(zoom=zoom)
        fo = lb.first_order(far)
        # printed to 5 mm / 100: the patent's own figures, and gaps of three decimals
        assert fo.efl == pytest.approx(stated, rel=5e-4)
        assert fo.bfl == pytest.approx(far.surfaces[-1].thickness, abs=6e-3)
        near = far.at(close=1.0)
        off = lb.first_order(far).bfl - far.surfaces[-1].thickness
        in_focus = lb.focused_distance(near, near.surfaces[-1].thickness + off)
        assert in_focus == pytest.approx(ZOOMS[name], rel=0.01)
        assert lb.nearest_focus(far) == pytest.approx(in_focus, rel=1e-12)


@pytest.mark.parametrize(("name", "metres", "magnification"), [
    ("lv-minolta-af-100mm-f28-macro", 0.35, -1.0), ("lv-nikon-z-58f095-noct", 0.5, None)])
def test_floating_groups_focus_down_to_the_published_distance(name, metres, magnification):
    lens = lenses.load(name)
    assert lb.nearest_focus(lens) == pytest.approx(1000.0 * metres, rel=0.006)      # engraved to two digits
    near = lb.focused(lens, lb.nearest_focus(lens))
    fo, film = lb.first_order(near), lb.film_distance(lens, lb.nearest_focus(lens))
    if magnification is not None:
        assert (fo.bfl - film) / fo.efl == pytest.approx(magnification, rel=1e-3)
