"""The lens library as a browser shows it, and fuzzy search. Lengths in mm."""

import math
import re
import unicodedata
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import lensbench as lb
from lensbench.app.bench.lens_choice import covered_format
from lensbench.app.settings.settings import Settings
from lensbench.core.text import significant
from lensbench.lenses import Card
from lensbench.lenses.library import search
from lensbench.lenses.library.search import plain, searched

WORD, RUN, FIRST = 8.0, 5.0, 6.0        # points: for the beginning of a word, a run of characters, the first of all
VERBATIM, INITIALS = 2.0, 1.5           # more for a part as it is written, and for the initials of successive words
GAP = 0.15                              # points lost for each character that is passed over
KEYS = str.maketrans("–—−×", "---x")    # characters that keyboards lack, and those that are typed for them


def score(query: str, text: str) -> float | None:
    """How well a text answers a query, the higher the better; None where a character of the query is missing.

    Spaces of the query separate parts that may come in any order. Case and accents do not count, and a hyphen finds
    every dash.
    """
    total = 0.0
    for word in _typed(query).split():
        points = _part(word, _typed(text))
        if points is None:
            return None
        total += points
    return total - 0.02 * len(text)


@lru_cache(maxsize=4096)
def _typed(text: str) -> str:
    """The text as it is typed on a plain keyboard."""
    bare = "".join(c for c in unicodedata.normalize("NFKD", text.lower()) if not unicodedata.combining(c))
    return bare.translate(KEYS)


def _part(query_word: str, text: str) -> float | None:
    """The best score of one part, over all places where its first character begins."""
    best = None
    start = text.find(query_word)                # as it is written: at the beginning of a word if there is such a place
    while start >= 0:
        points = RUN * len(query_word) + (WORD if _begins(text, start) else 0.0) + (FIRST if start == 0 else 0.0)
        best = points if best is None else max(best, points)
        start = text.find(query_word, start + 1)
    if best is not None:
        return best + VERBATIM
    if len(query_word) > 2 and query_word in "".join(word[0] for word in re.findall(r"\w+", text)):
        return RUN * len(query_word) + WORD + INITIALS
    points, start, run = 0.0, -1, False
    for character in query_word:
        ahead = text.find(character, start + 1)
        if ahead < 0:
            return None
        word = next((i for i in range(ahead, len(text)) if text[i] == character and _begins(text, i)), None)
        if not (run and ahead == start + 1) and word is not None:
            ahead = word
        run = 0 <= start == ahead - 1
        points += (RUN if run else 0.0) + (WORD if _begins(text, ahead) else 0.0) - GAP * (ahead - start - 1)
        start = ahead
    return points


def _begins(text: str, position: int) -> bool:
    return position == 0 or not text[position - 1].isalnum()


def ranked(query: str, texts: list[str], most: int) -> list[int]:
    """Indices of the best answers to a query, the best first; the first texts for an empty query."""
    if not query.strip():
        return list(range(min(most, len(texts))))
    scores = [(score(query, text), i) for i, text in enumerate(texts)]
    return [i for _, i in sorted(((-value, i) for value, i in scores if value is not None))[:most]]


ANY = ""                        # of a filter: everything passes
ERAS = {"before 1900": (0, 1899), "1900–1945": (1900, 1945), "1946–1970": (1946, 1970), "1971–1999": (1971, 1999),
        "since 2000": (2000, 9999)}
LENGTHS = {"to 12 mm": (0.0, 12.0), "12–24 mm": (12.0, 24.0), "24–40 mm": (24.0, 40.0), "40–65 mm": (40.0, 65.0),
           "65–110 mm": (65.0, 110.0), "110–220 mm": (110.0, 220.0), "over 220 mm": (220.0, math.inf)}
SPEEDS = {"f/1.2 or faster": 1.2, "f/1.5 or faster": 1.5, "f/2 or faster": 2.0, "f/2.8 or faster": 2.8,
          "f/4 or faster": 4.0}
FORMATS = {name[0].upper() + name[1:]: ends for name, ends in search.FILMS.items()}       # diagonals


@dataclass(frozen=True)
class Shelf:
    """What a browser shows: the text that is searched, the filters and the order. ANY lets everything pass."""

    search: str = ""
    kind: str = ANY
    era: str = ANY
    maker: str = ANY
    length: str = ANY
    speed: str = ANY
    film: str = ANY
    use: str = ANY
    zooms: bool = False         # zoom lenses only
    aspheric: bool = False      # lenses with an asphere only
    part: str = "all"           # "all", "favourites" or "recent"
    order: str = "length"

    @property
    def is_filtered(self) -> bool:
        """Whether a filter hides lenses; the search and the part do not count."""
        plain = Shelf(search=self.search, part=self.part, order=self.order)
        return any(getattr(self, f.name) != getattr(plain, f.name) for f in fields(self))

    def without_filters(self) -> "Shelf":
        """The same search, part and order."""
        return Shelf(search=self.search, part=self.part, order=self.order)


ORDERS: dict[str, tuple[str, Callable[[Card], tuple]]] = {
    "length": ("Focal length", search.ORDERS["focal"]),
    "speed": ("Speed", search.ORDERS["speed"]),
    "year": ("Year", search.ORDERS["year"]),
    "title": ("Name", lambda card: (plain(card.title), card.name)),
    "maker": ("Maker", lambda card: (not card.maker, plain(card.maker), *search.ORDERS["focal"](card))),
    "kind": ("Kind", lambda card: (not card.kind, plain(card.kind), *search.ORDERS["focal"](card))),
}


def shelved(cards: Sequence[Card], shelf: Shelf, favourites: Collection[str] = (),
            recent: Sequence[str] = ()) -> tuple[Card, ...]:
    """The cards that a shelf shows, in its order, a search by relevance; recent: names, the newest first."""
    kept = _filtered(cards, shelf)
    if shelf.part == "favourites":
        kept = [card for card in kept if card.name in favourites]
    kept.sort(key=ORDERS[shelf.order][1])
    if shelf.part == "recent":
        kept = sorted((card for card in kept if card.name in recent), key=lambda card: recent.index(card.name))
    return searched(kept, shelf.search) if shelf.search.strip() else tuple(kept)


def _filtered(cards: Sequence[Card], shelf: Shelf) -> list[Card]:
    kept = search.filtered(
        cards, kind=shelf.kind, use=shelf.use, maker=shelf.maker, fastest=SPEEDS[shelf.speed] if shelf.speed else None,
        focal=LENGTHS[shelf.length] if shelf.length else None, years=ERAS[shelf.era] if shelf.era else None,
        zooms=shelf.zooms or None, aspheres=shelf.aspheric or None)
    if not shelf.film:
        return list(kept)
    low, high = FORMATS[shelf.film]
    return [card for card in kept if (size := film_of(card)) is not None and low <= math.hypot(*size) < high]


def film_of(card: Card) -> tuple[float, float] | None:
    """Width and height (mm) of the film of a lens: stated, else of its image circle; None where neither is known."""
    if card.film_size is not None:
        return card.film_size
    return None if card.image_circle is None else covered_format(card.image_circle)


def film_name(size: tuple[float, float]) -> str:
    """The name of a film format, or its size."""
    for name, known in lb.FORMATS.items():
        if math.isclose(size[0], known[0]) and math.isclose(size[1], known[1]):
            return name
    return f"{significant(size[0])} × {significant(size[1])} mm"


def format_name(settings: Settings) -> str:
    """The camera body, the film format, or the size of the film of these settings."""
    return settings.sensor.name if settings.sensor else film_name((settings.film_width, settings.film_height))


def kinds(cards: Sequence[Card]) -> list[str]:
    """All kinds, in alphabetical order."""
    return sorted({card.kind for card in cards if card.kind}, key=plain)


def makers(cards: Sequence[Card]) -> list[str]:
    """All makers, in alphabetical order."""
    return sorted({card.maker for card in cards if card.maker}, key=plain)


def noted(names: Sequence[str], name: str, most: int) -> list[str]:
    """The names with one at the front, at most so many."""
    return [name, *(other for other in names if other != name)][:most]
