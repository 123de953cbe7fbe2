"""Fuzzy search: what a person means comes first."""

import pytest

from lensbench.app.session.lens_shelf import ranked, score

TEXTS = ["Focus peaking", "Focus position: Paraxial", "Circles of confusion as colours", "Clipping",
         "Degree of the polynomial", "Difference of A and B", "Dispersion: Off", "Panel: Depth of field", "Panel: MTF",
         "Lens: Minolta Tele f/2.8", "Lens: Double Gauss 50 mm f/2", "Lens: Petzval portrait lens",
         "Scene: Night lights", "Export", "Lens: Canon EF 28–105 mm f/4–5.6", "Lens: Angénieux 50 mm f/1.5",
         "Film: 36 × 24"]


@pytest.mark.parametrize(("query", "wanted"), [
    ("peak", "Focus peaking"), ("fp", "Focus peaking"), ("coc", "Circles of confusion as colours"),
    ("petz", "Lens: Petzval portrait lens"), ("gauss double", "Lens: Double Gauss 50 mm f/2"),
    ("night", "Scene: Night lights"), ("EXP", "Export"), ("para", "Focus position: Paraxial"),
    ("dof", "Panel: Depth of field"), ("mtf", "Panel: MTF"), ("deg", "Degree of the polynomial"),
    ("28-105", "Lens: Canon EF 28–105 mm f/4–5.6"), ("angenieux", "Lens: Angénieux 50 mm f/1.5"),
    ("36 x 24", "Film: 36 × 24")])
def test_the_first_answer_is_the_one_that_is_meant(query, wanted):
    assert TEXTS[ranked(query, TEXTS, 3)[0]] == wanted


def test_a_missing_character_is_no_answer_and_an_empty_query_has_all():
    assert score("xyzzy", "Focus peaking") is None
    assert ranked("xyzzy", TEXTS, 5) == []
    assert ranked(" ", TEXTS, 5) == [0, 1, 2, 3, 4]
