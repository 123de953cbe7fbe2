"""Search and filters of the library."""

from dataclasses import replace

import pytest

from lensbench import lenses
from lensbench.lenses.library import search
from lensbench.lenses.library.catalogue import Card

CARDS = lenses.describe()
MADE = (Card("a-sonnar", "Sonnar 50 mm f/1.5", "Sonnar", 1931, maker="Carl Zeiss", patent="US 1,998,704", efl=50.0,
             f_number=1.5, film_size=(36.0, 24.0)),
        Card("b-planar", "Planar 80 mm f/2.8", "double Gauss", 1950, notes="Better than a Sonnar.", efl=80.0,
             f_number=2.85, film_size=(56.0, 56.0), aspheres=1),
        Card("c-heliar", "Voigtländer Heliar", "Heliar", 1902, maker="Voigtländer", efl=100.0, f_number=4.5),
        Card("d-zoom", "Zoom 70–200 mm", "telephoto zoom", None, efl=70.0, tele_efl=200.0, film_size=(24.0, 36.0)))


def names(cards):
    return [card.name for card in cards]


@pytest.mark.parametrize(("text", "expected"), [
    ("sonnar", ["a-sonnar", "b-planar"]),                   # the title before the notes
    ("SONNAR zeiss", ["a-sonnar"]), ("zeiss 50mm F1.5", ["a-sonnar"]), ("1998704", ["a-sonnar"]),
    ("US 1,998,704", ["a-sonnar"]), ("voigtlander", ["c-heliar"]), ("heliar 1905", ["c-heliar"]),
    ("1931", ["a-sonnar"]), ("1935", ["a-sonnar"]), ("1971", []), ("plan", ["b-planar"]), ("plannar", ["b-planar"]),
    ("", ["a-sonnar", "b-planar", "c-heliar", "d-zoom"]), ("zoom sonnar", []), ("qqqq", [])])
def test_a_search_finds_every_word_and_ranks_by_where_it_stands(text, expected):
    assert names(search.searched(MADE, text)) == expected


@pytest.mark.parametrize("text", ["200", "200mm", "zeiss 200"])
def test_a_focal_length_finds_prime_lenses_before_zooms_that_end_there(text):
    prime = replace(MADE[0], name="e-tele", title="Tele 200 mm f/3.5", efl=195.0, maker="Carl Zeiss")
    zoom = replace(MADE[3], maker="Carl Zeiss")
    assert names(search.searched((zoom, prime), text)) == ["e-tele", "d-zoom"]
    assert names(search.searched((prime, zoom), "70-200"))[0] == "d-zoom"


@pytest.mark.parametrize(("asked", "expected"), [
    ({"kind": "gauss"}, ["b-planar"]), ({"maker": "zeiss"}, ["a-sonnar"]), ({"maker": "voigtlander"}, ["c-heliar"]),
    ({"fastest": 2.8}, ["a-sonnar", "b-planar"]),           # f/2.85 is engraved f/2.8
    ({"focal": (90.0, 120.0)}, ["c-heliar", "d-zoom"]), ({"focal": (210.0, 900.0)}, []),
    ({"years": (1900.0, 1931.0)}, ["a-sonnar", "c-heliar"]), ({"zooms": True}, ["d-zoom"]),
    ({"zooms": False, "aspheres": False}, ["a-sonnar", "c-heliar"]), ({"aspheres": True}, ["b-planar"]),
    ({"film": "full frame"}, ["a-sonnar", "d-zoom"]), ({"film": "fullframe"}, ["a-sonnar", "d-zoom"]),
    ({"film": "medium"}, ["b-planar"]), ({"film": "36x24"}, ["a-sonnar", "d-zoom"]),
    ({"film": "56 × 56 mm"}, ["b-planar"])])
def test_filters_keep_what_passes_all_of_them(asked, expected):
    assert names(search.filtered(MADE, **asked)) == expected


@pytest.mark.parametrize(("asked", "reason"), [
    ({"kind": "makro"}, "did you mean macro"), ({"maker": "niccon"}, "did you mean .*Nikon"),
    ({"kind": "xyz"}, "there are .*Tessar.*"), ({"film": "35 mm"}, "name one of .*full frame"),
    ({"film": "1.2.3x4"}, "width x height")])
def test_a_filter_that_no_lens_can_pass_says_what_there_is(asked, reason):
    with pytest.raises(search.SearchError, match=reason):
        search.filtered(CARDS, **asked)


@pytest.mark.slow
def test_every_lens_is_found_first_by_its_title():
    # titles that are the beginning of another one, or end in the same words, may stand second
    for card in CARDS:
        assert card in search.searched(CARDS, card.title)[:2], card.name


def test_orders_put_the_unknown_last():
    for order, known in (("focal", "efl"), ("speed", "f_number"), ("year", "year")):
        values = [getattr(card, known) for card in sorted(CARDS, key=search.ORDERS[order])]
        there = [value for value in values if value is not None]
        assert there == sorted(there) and values[:len(there)] == there
