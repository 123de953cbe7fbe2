"""The search of a glass: names, and what is near to a text that names none."""

import re

import pytest

from lensbench.app.panels.lens_table.glass import OFFERED, matches, nearest
from lensbench.core.optics.glass import AIR
from lensbench.lenses.glass import catalogue

KNOWN = catalogue.entries()


@pytest.mark.parametrize(("text", "wanted"), [("N-BK77", "N-BK7"), ("sk 166", "N-SK16"), ("lack9", "N-LAK9")])
def test_an_unknown_name_is_offered_names_like_it(text, wanted):
    assert matches(text, "", KNOWN, AIR) == ()
    assert wanted in [entry.name for entry in nearest(text, "", KNOWN)]


@pytest.mark.parametrize(("text", "family"), [("sf", "SF"), ("bk", "BK"), ("sk1", "SK")])
def test_the_glasses_of_a_family_come_before_names_that_hold_its_letters(text, family):
    """A name is a prefix such as N-, the letters of its family and a number: LASF9 is no SF."""
    names = [entry.name for entry in matches(text, "SCHOTT", KNOWN, AIR)]
    own = [re.fullmatch(rf"([A-Z]-)?{family}\d.*", name) is not None for name in names]
    assert any(own) and own == sorted(own, reverse=True)


def test_a_name_comes_before_its_successor_and_longer_names():
    names = [entry.name for entry in matches("sf1", "SCHOTT", KNOWN, AIR)]
    assert names[:2] == ["SF1", "N-SF1"] and names.index("N-SF10") < names.index("BASF1")


@pytest.mark.parametrize("text", ["1.5168 64.2", "1,5168 64,2", "517642"])
def test_an_index_with_an_abbe_number_and_a_code_are_offered_the_nearest_glasses(text):
    offered = nearest(text, "", KNOWN)
    assert len(offered) == OFFERED and "N-BK7" in [entry.name for entry in offered]
    near, every = (sorted(catalogue.distance(entry, 1.5168, 64.2) for entry in entries if entry.n_d and entry.v_d)
                   for entries in (offered, KNOWN))
    assert near[-1] <= every[2 * OFFERED]                       # the code has three digits
    assert {entry.maker for entry in nearest(text, "SCHOTT", KNOWN)} == {"SCHOTT"}


@pytest.mark.parametrize("text", ["", "   ", "qqqqqqqq", "nan nan", "inf 3", "1.5 60 2"])
def test_odd_texts_end_no_search(text):
    assert len(nearest(text, "", KNOWN)) <= OFFERED
