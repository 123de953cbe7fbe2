"""The same lens in every encoding, line end, way to write a number, and unit, whatever the format."""

import codecs
import re

import pytest

from lensbench import lenses
from tests.lenses.samples import DATA, loaded

SAMPLES = sorted(path.name for path in DATA.iterdir())
ENCODINGS = {
    "utf-8": lambda text: text.encode(),
    "utf-8 with its mark": lambda text: codecs.BOM_UTF8 + text.encode(),
    "latin-1": lambda text: text.encode("latin-1"),
    "utf-16-le": lambda text: text.encode("utf-16-le"),
    "utf-16-be": lambda text: text.encode("utf-16-be"),
    "utf-16-le with its mark": lambda text: codecs.BOM_UTF16_LE + text.encode("utf-16-le"),
    "utf-16-be with its mark": lambda text: codecs.BOM_UTF16_BE + text.encode("utf-16-be"),
}


@pytest.mark.parametrize("name", SAMPLES)
def test_encodings_and_line_ends_do_not_matter(tmp_path, name):
    text = (DATA / name).read_text()
    whole = lenses.load(DATA / name)
    for encoding, encoded in ENCODINGS.items():
        for end in ("\n", "\r\n", "\r"):
            lens = loaded(tmp_path, name, encoded(text.replace("\n", end)))
            assert lens == whole and lens.findings == whole.findings, (encoding, end)


@pytest.mark.parametrize("name", [name for name in SAMPLES if not name.endswith((".json", ".lhlt", ".roa"))])
def test_decimal_commas_and_fortran_exponents_do_not_matter(tmp_path, name):
    text, whole = (DATA / name).read_text(), lenses.load(DATA / name)
    commas = re.sub(r"(?<![\w.])(-?\d+)\.(\d+)(?![\w.])", r"\1,\2", text)
    assert commas != text
    assert loaded(tmp_path, name, commas).surfaces == whole.surfaces
    fortran = re.sub(r"(?<=\d)[eE](?=[-+]?\d)", "D", text)
    assert loaded(tmp_path, name, fortran).surfaces == whole.surfaces


# Where each format says the unit, and what an inch, a centimetre and a metre are called there
UNITS = {
    "doublet.zmx": ("UNIT MM", "UNIT {}", {"IN": 25.4, "CM": 10.0, "METER": 1000.0}),
    "triplet.seq": ("DIM   M", "DIM {}", {"I": 25.4, "C": 10.0}),
    "pair.len": ("UNI  1.0", "UNI {}", {"25.4": 25.4, "10": 10.0, "1e3": 1000.0}),
    "pair.roa": ('"_dimensions": "mm"', '"_dimensions": "{}"', {"inches": 25.4, "cm": 10.0, "meters": 1000.0}),
}


@pytest.mark.parametrize("name", UNITS)
def test_a_file_in_another_unit_is_the_scaled_lens_with_a_finding(tmp_path, name):
    old, new, units = UNITS[name]
    text, whole = (DATA / name).read_text(), lenses.load(DATA / name)
    assert old in text
    for unit, mm in units.items():
        lens = loaded(tmp_path, name, text.replace(old, new.format(unit)))
        same = whole.scaled(mm)
        assert lens.stop.semi_diameter == pytest.approx(same.stop.semi_diameter, rel=1e-14)     # from the aperture
        assert lens.with_stop_radius(1.0) == same.with_stop_radius(1.0)
        assert any(f"{mm:g} mm" in finding.message for finding in lens.findings)
