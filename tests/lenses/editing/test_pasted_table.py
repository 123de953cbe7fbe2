"""Tables as people copy them, from patents, spreadsheets and books; a cell that cannot be read is named."""

import pytest

from lensbench import lenses
from lensbench.core.optics.finding import Kind
from lensbench.lenses.editing.document import EditError
from lensbench.lenses.editing.pasted_table import pasted

TRIPLET = lenses.load("lenshh-cooke-triplet-50")
ROWS = [(22.01359, 3.25896, 1.62041, 60.32, 8.6452), (-435.76044, 6.00755, None, None, 8.0786),
        (-22.21328, 0.99997, 1.62004, 36.37, 4.0207), (20.29192, 4.75041, None, None, 3.8961),
        (79.6836, 2.95208, 1.62041, 60.32, 6.9733), (-18.39533, 42.20778, None, None, 7.3426)]


def table(separator, decimal=".", minus="-", heading=None, blank="", numbered=True, stop="4", ends=False):
    lines = [] if heading is None else [separator.join(heading)]
    for i, row in enumerate(ROWS, start=1):
        cells = [stop if i == 4 else str(i)] if numbered else []
        cells += [blank if value is None else str(value).replace(".", decimal).replace("-", minus) for value in row]
        lines.append(separator.join(cells))
    if ends:
        lines.insert(1, separator.join(("OBJ", "Infinity", "Infinity", "", "", "")))
        lines.append(separator.join(("IMA", "Infinity", "", "", "", "12")))
    return "\n".join(lines)


HEADING = ("Surf", "Radius", "Thickness", "nd", "Vd", "Semi-Diameter")
TABLES = {
    "spreadsheet": table("\t", heading=HEADING, stop="STO", ends=True),
    "german": table("\t", ",", heading=("Fläche", "Radius", "Dicke", "nd", "νd", "Halbmesser")),
    "semicolons": table(";", ",", heading=("#", "r", "d", "n", "v", "h")),
    "csv": table(",", heading=HEADING),
    "bars": "| " + table(" | ", heading=HEADING).replace("\n", " |\n| ") + " |",
    "true minus": table("\t", minus="−", heading=HEADING),
    "blanks": table(" ").replace("  ", " "),
    "bare": table("\t", numbered=False),
    "windows": table("\t", heading=HEADING).replace("\n", "\r\n"),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_read_however_it_is_written(name):
    document = pasted(TABLES[name])
    for made, (radius, thickness, n_d, v_d, rim) in zip(document.surfaces, ROWS, strict=True):
        assert (1.0 / made.curvature, made.thickness, made.semi_diameter) == pytest.approx((radius, thickness, rim))
        assert made.glass.n_d == (n_d or 1.0) and made.glass.v_d == v_d
    assert document.lens.stop_index == 3
    headless = name in ("blanks", "bare")
    assert (Kind.CONVENTION in [f.kind for f in document.findings]) == headless


def test_letters_with_numbers_are_read_as_patents_print_them():
    text = "\n".join(f"r{i} = {r}  d{i} = {d}" + (f"  n{(i + 1) // 2} = {n}  ν{(i + 1) // 2} = {v}" if n else "")
                     for i, (r, d, n, v, _) in enumerate(ROWS, start=1))
    document = pasted(text, f_number=4.9)
    assert [s.glass.n_d for s in document.surfaces] == [s.glass.n_d for s in TRIPLET.surfaces]
    assert [1.0 / s.curvature for s in document.surfaces] == pytest.approx([row[0] for row in ROWS])
    assert {Kind.RIM, Kind.NO_STOP} <= {f.kind for f in document.findings}
    assert all(s.semi_diameter > 4.0 for s in document.surfaces)


def test_glass_names_diameters_planes_and_comments():
    document = pasted("r\td\tglass\tdia\tremark\n∞\t2\tN-BK7\t30\tfilter\nplano\t5\t\t30\t\n"
                      "50,5*\t3\tF2\t20\tfront\nSTOP\t1,5\t\t18\t\n-1.234,5\t60\tair\t20\t")
    assert [s.glass.name for s in document.surfaces] == ["N-BK7", "", "F2", "", ""]
    assert [s.semi_diameter for s in document.surfaces] == [15.0, 15.0, 10.0, 9.0, 10.0]
    assert [s.curvature for s in document.surfaces] == [0.0, 0.0, 1.0 / 50.5, 0.0, 1.0 / -1234.5]
    assert document.lens.stop_index == 3 and document.comments == ("filter", "", "front", "", "")


@pytest.mark.parametrize("text, words", [
    ("", "no table"), ("hello", "no columns"), ("a\tb\nc\td", "no columns"), ("x" * 1_000_001, "1000001 characters"),
    ("1\t2\n" * 2000, "at most 1000 surfaces"),
    (TABLES["spreadsheet"].replace("0.99997", "abc"), "line 5, column “thickness”: 'abc' is no number"),
    (TABLES["spreadsheet"].replace("20.29192", "nan"), "line 6, column “radius”: 'nan'"),
    (TABLES["spreadsheet"].replace("1.62004", "0.2"), "line 5, column “n_d”"),
    ("r\td\tglass\tdia\n10\t2\tN-BK77\t8\n-10\t9\t\t8", "line 2, column “glass”: .*did you mean"),
    ("r\td\tnd\tdia\n10\t2\t1.5\t-8\n-10\t9\t\t8", "line 2, column “semi-diameter”"),
    ("r1 = 10 d1 = 2 n1 = 1.5\nr1 = 12 d2 = 3", "line 2: r1 is given twice"),
    ("r\td\tnd\tA4\n10\t2\t1.5\t1e-5\n-10\t9\t\t", "'A4' seems to be a column of aspheric terms"),
    ("r\td\tnd\n10\t2\t1\n-10\t9\t1", "afocal")])
def test_a_cell_that_cannot_be_read_is_named(text, words):
    with pytest.raises(EditError, match=words):
        pasted(text)


def test_headings_of_another_line_unit_or_meaning_are_named():
    body = "\t1.51872\t63.96\t10\n-50\t45\t\t\t10\n"
    messages = [str(finding) for finding in pasted("r\td\tne\tve\tChip zone\n50\t5" + body).findings]
    assert any("the numbers of 'ne' and 've', of the e line, are used as n_d and V_d" in text for text in messages)
    assert any("not read: the column 'Chip zone'" in text for text in messages)
    plain = pasted("r\td\tnd\tνd\tSemi-diameter (mm)\n50\t5" + body).findings
    assert not any("e line" in str(finding) or "not read" in str(finding) for finding in plain)
    for unit in ("in", "inches", "cm"):
        with pytest.raises(EditError, match="line 1: the heading .*another unit than mm"):
            pasted(f"r ({unit})\td ({unit})\tnd\tvd\tSD\n50\t5" + body)


@pytest.mark.parametrize("titles", [["Table 1"], ["Table 1", "Example of a triplet, lengths in mm"]])
def test_titles_above_a_heading_hide_none_of_its_columns(titles):
    """In an order that no guess from the numbers finds."""
    lines = [",".join(reversed(line.split(","))) for line in TABLES["csv"].splitlines()]
    document = pasted("\n".join([*titles, *lines]))
    for surface, (radius, thickness, *_, semi_diameter) in zip(document.surfaces, ROWS, strict=True):
        assert (1.0 / surface.curvature, surface.thickness, surface.semi_diameter) == pytest.approx(
            (radius, thickness, semi_diameter), rel=1e-12)
