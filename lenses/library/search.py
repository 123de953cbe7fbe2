"""Search, filters and orders of the lens library, shared by the window and the command line. Lengths in mm.

    from lensbench.lenses import describe, search
    found = search.searched(search.filtered(describe(), kind="macro", fastest=2.8), "nikkor 1988")

A filter drops cards and keeps their order; a search orders by relevance.
"""

import math
import re
import unicodedata
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import lru_cache
from typing import Any

from lensbench.core.text import excerpt
from lensbench.lenses.library.catalogue import USES, Card

WEIGHTS = (("title", 8.0), ("kind", 5.0), ("uses", 5.0), ("maker", 4.0), ("designer", 4.0), ("patent", 3.0),
           ("year", 3.0), ("name", 2.0), ("source", 1.5), ("notes", 0.5))
INSIDE, AT_START, WHOLE = 1.0, 2.0, 4.0         # weight of a text within a word, at its start, and of a whole word
PRIME, NOMINAL = 12.0, 0.05                     # of the focal length of a prime lens; an “85 mm” may have 82.45 mm
NEAR_YEARS = 10                                 # a year also finds lenses this many years before and after it
ROUNDED = 1.02                                  # an engraved f/2 may be f/2.03
ALIKE = 0.75                                    # of a word that no card has, to the one that it is read as

FILMS: dict[str, tuple[float, float]] = {       # by the diagonal of the film, from … up to …
    "phone or compact": (0.0, 12.0), "1 inch": (12.0, 17.0), "micro four thirds": (17.0, 23.0), "APS-C": (23.0, 36.0),
    "full frame": (36.0, 46.0), "medium format": (46.0, 110.0), "large format": (110.0, math.inf)}

Order = Callable[[Card], tuple[Any, ...]]


def _late(value: float | None) -> float:
    return math.inf if value is None else value


ORDERS: dict[str, Order] = {                    # what is not known comes last
    "name": lambda card: (card.name,),
    "focal": lambda card: (_late(card.efl), _late(card.f_number), card.name),
    "speed": lambda card: (_late(card.f_number), _late(card.efl), card.name),
    "year": lambda card: (_late(card.year), _late(card.efl), card.name)}


class SearchError(ValueError):
    """A filter that no lens can pass; the message says what there is."""


def searched(cards: Sequence[Card], text: str) -> tuple[Card, ...]:
    """Cards in which every word of a text occurs, the most relevant first; all cards for an empty text.

    Words, or beginnings of words, of title, kind, uses, maker, designer, patent, year, name, source and notes, in any
    order; case, accents and commas do not count. A year also finds lenses of the ten years around it; a focal length
    puts prime lenses before zooms whose range ends there. A word without digits that occurs nowhere is read as the word
    most like it. Equally relevant cards keep their order.
    """
    words = plain(text).split()
    if not words:
        return tuple(cards)
    ranked = _ranked(cards, words)
    if ranked:
        return ranked
    known = sorted({word for card in cards for _, text in _texts(card)[:-2] for word in text.split()})
    return _ranked(cards, [_known(word, known) for word in words])


def _known(word: str, known: Sequence[str]) -> str:
    if any(word in term for term in known) or any(c.isdigit() for c in word):
        return word
    return (get_close_matches(word, known, 1, ALIKE) or [word])[0]


def _ranked(cards: Sequence[Card], words: Sequence[str]) -> tuple[Card, ...]:
    scored = []
    for card in cards:
        scores = [_score(card, word) for word in words]
        if all(scores):
            scored.append((sum(scores), card))
    return tuple(card for _, card in sorted(scored, key=lambda score: -score[0]))


def _score(card: Card, word: str) -> float:
    """Relevance of a card for one word; 0 where it does not occur."""
    best = 0.0
    for weight, text in _texts(card):
        if word in text:
            words = text.split()
            rank = WHOLE if word in words else AT_START if any(own.startswith(word) for own in words) else INSIDE
            best = max(best, weight * rank)
    if best and not card.zooms and card.efl and re.fullmatch("[0-9]{1,4}", word) and (
            abs(card.efl - int(word)) <= NOMINAL * int(word)):
        best += PRIME                               # before zooms whose range ends there
    if card.year is not None and re.fullmatch("1[89][0-9]{2}|20[0-9]{2}", word):
        best = max(best, 12.0 * max(0.0, 1.0 - abs(card.year - int(word)) / (NEAR_YEARS + 1.0)))
    return best


@lru_cache(maxsize=4096)
def _texts(card: Card) -> tuple[tuple[float, str], ...]:
    """Weights and searched texts of a card."""
    return tuple((weight, plain(" ".join(card.uses) if name == "uses" else str(getattr(card, name) or "")))
                 for name, weight in WEIGHTS)


@lru_cache(maxsize=4096)
def plain(text: str) -> str:
    """A text without case, accents and commas, with “f/1.4” for “F1.4” and “50 mm” for “50mm”."""
    bare = "".join(c for c in unicodedata.normalize("NFKD", text.lower()) if not unicodedata.combining(c))
    bare = re.sub(r"(?<=\d),(?=\d{3})", "", bare)
    bare = re.sub(r"\bf(?=\d)", "f/", re.sub(r"(?<=\d)mm\b", " mm", bare))
    return re.sub(r"[^\w./]+", " ", bare).strip()


def filtered(cards: Sequence[Card], *, kind: str = "", maker: str = "", fastest: float | None = None,
             focal: tuple[float, float] | None = None, years: tuple[float, float] | None = None,
             zooms: bool | None = None, aspheres: bool | None = None, film: str = "", use: str = ""
             ) -> tuple[Card, ...]:
    """Cards that pass all filters, in their order.

    kind, maker: a part of its kind or maker, as in "macro" or "zeiss". fastest: the slowest f-number that passes.
    focal: the range of focal lengths (mm); zooms pass whose range meets it. years: of lenses whose year is known.
    zooms, aspheres: only lenses that zoom, or have an asphere (True), or do not (False). film: a part of a name in
    `FILMS`, or width x height in mm, of the film that the lens was made for. use: one of `USES`. SearchError for a
    kind, maker, film or use that no card has.
    """
    kept = [card for card in cards if _has(card, fastest, focal, years, zooms, aspheres)]
    if use:
        named = set(_named("use", use, [*USES]))
        kept = [card for card in kept if named.intersection(card.uses)]
    for what, asked, known in (("kind", kind, [card.kind for card in cards]),
                               ("maker", maker, [card.maker for card in cards])):
        if asked:
            named = set(_named(what, asked, known))
            kept = [card for card in kept if getattr(card, what) in named]
    if film:
        is_asked = _film(film)
        kept = [card for card in kept if card.film_size is not None and is_asked(card.film_size)]
    return tuple(kept)


def _has(card: Card, fastest: float | None, focal: tuple[float, float] | None, years: tuple[float, float] | None,
         zooms: bool | None, aspheres: bool | None) -> bool:
    if fastest is not None and not _late(card.f_number) <= ROUNDED * fastest:
        return False
    if focal is not None and not (card.efl is not None and card.efl <= focal[1]
                                  and (card.tele_efl or card.efl) >= focal[0]):
        return False
    if years is not None and not (card.year is not None and years[0] <= card.year <= years[1]):
        return False
    return (zooms is None or card.zooms == zooms) and (aspheres is None or card.has_aspheres == aspheres)


def _named(what: str, asked: str, known: Sequence[str]) -> list[str]:
    """The kinds or makers that a text names: itself, else those with a word that starts with it, else any with it."""
    there = sorted({name for name in known if name}, key=plain)
    text = plain(asked)
    for is_one in (lambda name: name == text, lambda name: f" {text}" in f" {name}", lambda name: text in name):
        if text and (matches := [name for name in there if is_one(plain(name))]):
            return matches
    near = get_close_matches(text, {plain(name): name for name in there}, 3, 0.6)
    hint = f"; did you mean {' or '.join(name for name in there if plain(name) in near)}?" if near else \
        f"; there are {', '.join(there)}"
    raise SearchError(f"no lens of the library is of {what} {excerpt(asked)}{hint}")


def _film(asked: str) -> Callable[[tuple[float, float]], bool]:
    """Whether a film (mm) is the one that a text names."""
    size = re.fullmatch(r"\s*([\d.]+)\s*[x×]\s*([\d.]+)\s*(mm)?\s*", asked)
    try:
        sides = sorted((float(size[1]), float(size[2]))) if size else None
    except ValueError:
        sides = None
    if sides is not None:
        return lambda film: all(abs(a - b) <= 0.03 * b for a, b in zip(sorted(film), sides, strict=True))
    text = plain(asked).replace(" ", "")
    classes = [ends for name, ends in FILMS.items() if text and text in plain(name).replace(" ", "")]
    if not classes:
        raise SearchError(f"no film format is {excerpt(asked)}: name one of {', '.join(FILMS)}, or width x height "
                          "in mm")
    return lambda film: any(low <= math.hypot(*film) < high for low, high in classes)
