"""Published tables in JSON: every value of each surface, positions, missing rims, and refusals."""

import json
import math
from functools import partial

import pytest

import lensbench as lb
from lensbench import lenses
from tests.lenses.samples import DATA, changed_json, loaded, refusal

TABLE = json.loads((DATA / "zoom.json").read_text())
changed = partial(changed_json, TABLE)


def test_every_value_of_the_table_is_in_the_lens():
    lens = lenses.load(DATA / "zoom.json")
    assert (lens.name, lens.kind, lens.source) == ("Two groups", "zoom", "made up for the tests")
    assert lens.stop_index == 4 and lens.stated_f_number == 4.0
    for surface, row in zip(lens.surfaces, TABLE["surfaces"], strict=True):
        c = 0.0 if row["R"] is None else 1.0 / row["R"]
        up, across = {"cyl_y": (c, 0.0), "cyl_x": (0.0, c)}.get(row["geometry"], (c, None))
        assert surface.curvature == pytest.approx(up, rel=1e-15)        # from its digits, rounded once
        assert surface.curvature_x == (across and pytest.approx(across, rel=1e-15))
        assert (surface.semi_diameter, surface.conic) == (row["semi_ap"], row["k"])
        assert (surface.glass.n_d, surface.glass.v_d, surface.glass.name) == (row["nd"], row["vd"], row["glass"] or "")
        assert dict(surface.aspheric) == {int(power): a for power, a in row.get("A", {}).items()}


def test_the_groups_have_the_gaps_of_the_table():
    lens = lenses.load(DATA / "zoom.json")
    for zoom in (0, 1):
        for close in (0, 1):
            moved = lens.at(zoom=float(zoom), close=float(close))
            for gap in TABLE["variable"]["gaps"]:
                assert moved.surfaces[gap["surface"]].thickness == gap["values"][zoom][close]
    assert lens.positions.focal_lengths == (50.0, 70.0)
    assert [row[1] for row in lens.positions.distances] == pytest.approx([900.0, 900.0], rel=1e-12)     # from the film


def stated(tmp_path, **values):
    return loaded(tmp_path, "a.json", json.dumps(TABLE | values))


def test_the_provenance_of_the_table_is_in_the_lens(tmp_path):
    lens = stated(tmp_path, patent="US 2,645,156", aperture_blades=9, format="aps-c",
                  semi_diameters="published in part", source={
                      "maker": "Voigtlander", "assignee": "Voigtlander AG", "designer": "A. W. Tronnier",
                      "example": "Example 2", "year": 1953, "year_note": "from the patent number"})
    assert (lens.maker, lens.designer, lens.patent) == ("Voigtlander", "A. W. Tronnier", "US 2,645,156")
    assert (lens.source, lens.year) == ("US 2,645,156, Example 2", 1953)
    assert (lens.blades, lens.film_size) == (9, (23.5, 15.6))
    assert lens.estimates == "some rims, the year (from the patent number)"
    book = stated(tmp_path, patent="Laikin, Lens Design", year=2007, format=[70.0, 52.2], semi_diameters="published",
                  source={"assignee": "Zeiss"})
    assert (book.source, book.patent, book.maker, book.year) == ("Laikin, Lens Design", "", "Zeiss", 2007)
    assert (book.film_size, book.estimates) == ((70.0, 52.2), "")


def test_each_zoom_setting_keeps_its_f_number(tmp_path):
    variable = TABLE["variable"] | {"f_numbers": [3.6, 4.5]}
    assert stated(tmp_path, variable=variable).positions.f_numbers == (3.6, 4.5)
    assert stated(tmp_path).positions.f_numbers == ()
    refused = refusal(tmp_path, "b.json", json.dumps(TABLE | {"variable": variable | {"f_numbers": [3.6]}}))
    assert "f_numbers has 1 values for 2 zoom settings" in str(refused)


@pytest.mark.parametrize(("values", "left_out"), [
    ({"projection": "equisolid"}, "equisolid"),
    ({"projection": {"kind": "fisheye-equidistant"}}, "fisheye-equidistant"),
    ({"aperture_blades": 2}, "2 blades"),
    ({"format": "disc"}, "'disc'"),
])
def test_a_statement_that_a_lens_cannot_hold_is_a_finding(tmp_path, values, left_out):
    assert not [finding for finding in stated(tmp_path).findings if finding.kind is lenses.Kind.LEFT_OUT]
    left, = [finding for finding in stated(tmp_path, **values).findings if finding.kind is lenses.Kind.LEFT_OUT]
    assert left_out in left.message


def test_a_lens_whose_last_gap_alone_varies_is_focused_as_a_whole(tmp_path):
    text = changed(["variable"], {"zoom_positions_mm": None, "close_focus_m": 0.9,
                                  "gaps": [{"surface": 7, "values": [38.2, 42.0]}]})
    assert loaded(tmp_path, "a.json", text).positions is None


def test_missing_rims_are_estimated_with_a_finding(tmp_path):
    lens = loaded(tmp_path, "a.json", changed(["surfaces", 0, "semi_ap"], None))
    assert 6.0 < lens.surfaces[0].semi_diameter < 20.0
    assert any("no semi-diameter for surface 0" in finding.message for finding in lens.findings)
    unit = loaded(tmp_path, "b.json", changed(["units"], "normalised"))
    assert any("normalised" in finding.message for finding in unit.findings)
    stopless = loaded(tmp_path, "c.json", changed(["stop_index"], None))
    assert any("no stop is marked" in finding.message for finding in stopless.findings)


@pytest.mark.parametrize(("path", "value", "told"), [
    (["surfaces", 2, "geometry"], "biconic", ":14: surface 2: the geometry biconic"),
    (["surfaces", 2, "nd"], 0.5, ":14: surface 2: index"),
    (["surfaces", 2, "t"], "thick", ":14: surface 2: t is 'thick'"),
    (["variable", "gaps", 0, "values"], [[4.5, 5.25]], "a varying gap has too few values"),
    (["surfaces"], [], "there is no lens"),
])
def test_an_invalid_table_is_refused_in_one_line(tmp_path, path, value, told):
    data = json.loads(changed(path, value))
    lines = json.dumps({**data, "surfaces": []}, indent=1)[:-1]
    text = json.dumps(data) if path[0] != "surfaces" or not data["surfaces"] else lines.replace(
        '"surfaces": []', '"surfaces": [\n' + ",\n".join(map(json.dumps, data["surfaces"])) + "]") + "}"
    assert told in str(refusal(tmp_path, "a.json", text))


def test_an_anamorphic_table_is_traced_in_both_sections():
    lens = lenses.load(DATA / "zoom.json")
    assert not lens.is_rotationally_symmetric
    assert lb.first_order(lens.section("x")).efl != pytest.approx(lb.first_order(lens).efl, rel=1e-3)
    assert math.isfinite(lb.film_distance(lens, 8000.0))
