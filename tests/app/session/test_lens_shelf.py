"""The shelf of the lens browser: relevance of a search, filters, orders and parts."""

import math
from dataclasses import replace

import pytest

from lensbench import lenses
from lensbench.app.session.lens_shelf import (
    ERAS, FORMATS, LENGTHS, ORDERS, SPEEDS, Shelf, film_of, kinds, makers, noted, shelved
)

CARDS = lenses.describe()


def names(**asked) -> list[str]:
    return [card.name for card in shelved(CARDS, Shelf(**asked))]


def test_a_search_orders_the_filtered_lenses_by_relevance():
    assert names(search="zeiss biogon 1955")[0] == "lv-zeiss-biogon-21-f45"
    fisheyes = {card.name for card in CARDS if card.kind == "fisheye"}
    assert set(names(search="minolta", kind="fisheye")) <= fisheyes and names(search="minolta", kind="fisheye")


@pytest.mark.parametrize(("field", "choices", "holds"), [
    ("kind", kinds(CARDS), lambda card, value: card.kind == value),
    ("maker", makers(CARDS), lambda card, value: card.maker == value),
    ("era", ERAS, lambda card, value: ERAS[value][0] <= card.year <= ERAS[value][1]),
    ("speed", SPEEDS, lambda card, value: card.f_number <= 1.02 * SPEEDS[value]),
    ("length", LENGTHS, lambda card, value: card.efl <= LENGTHS[value][1]
     and (card.tele_efl or card.efl) >= LENGTHS[value][0]),
    ("film", FORMATS, lambda card, value: FORMATS[value][0] <= math.hypot(*film_of(card)) < FORMATS[value][1]),
])
def test_a_filter_shows_lenses_that_pass_it_and_all_of_them_together(field, choices, holds):
    seen: set[str] = set()
    for value in choices:
        shown = shelved(CARDS, Shelf(**{field: value}))
        assert all(holds(card, value) for card in shown)
        seen |= {card.name for card in shown}
    known = {"kind": "kind", "maker": "maker", "era": "year", "speed": "f_number", "length": "efl"}.get(field)
    wanted = {card.name for card in CARDS if (getattr(card, known) if known else film_of(card))}
    assert seen == wanted or field == "speed" and seen < wanted


def test_zooms_and_aspheres():
    assert {card.name for card in shelved(CARDS, Shelf(zooms=True))} == {card.name for card in CARDS if card.zooms}
    assert all(card.has_aspheres for card in shelved(CARDS, Shelf(aspheric=True)))


@pytest.mark.parametrize("order", ORDERS)
def test_an_order_is_kept_and_loses_nothing(order):
    shown = shelved(CARDS, Shelf(order=order))
    keys = [ORDERS[order][1](card) for card in shown]
    assert keys == sorted(keys) and len(shown) == len(CARDS)


def test_favourites_and_recent_lenses():
    some = [card.name for card in CARDS[:5]]
    assert {card.name for card in shelved(CARDS, Shelf(part="favourites"), some)} == set(some)
    recent = [some[3], some[0]]
    assert [card.name for card in shelved(CARDS, Shelf(part="recent"), (), recent)] == recent
    assert noted(recent, some[0], 5) == [some[0], some[3]] and noted(recent, some[1], 2) == [some[1], some[3]]


def test_a_search_is_no_filter_and_clearing_keeps_it():
    shelf = Shelf(search="zeiss", kind="fisheye", order="year")
    assert shelf.is_filtered and shelf.without_filters() == replace(shelf, kind="")
    assert not shelf.without_filters().is_filtered
