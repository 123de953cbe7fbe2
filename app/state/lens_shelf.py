"""The lens library as a browser shows it: searched, filtered and sorted cards. Lengths in mm."""

import math
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import lensbench as lb
from lensbench.app.state.lens_choice import covered_format
from lensbench.kernels.figures import significant
from lensbench.lenses import Card, search
from lensbench.lenses.search import plain, searched

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
    """The cards that a shelf shows, in its order.

    Parameters
    ----------
    cards : sequence of Card
        The library.
    shelf : Shelf
        Search, filters and order. A search orders by relevance, the recent lenses by their use.
    favourites : collection of str
        Names of the part "favourites".
    recent : sequence of str
        Names of the part "recent", the newest first.

    Returns
    -------
    tuple of Card
        Equal relevance follows the order of the shelf.
    """
    kept = _filtered(cards, shelf)
    if shelf.part == "favourites":
        kept = [card for card in kept if card.name in favourites]
    kept.sort(key=ORDERS[shelf.order][1])
    if shelf.part == "recent":
        kept = sorted((card for card in kept if card.name in recent), key=lambda card: recent.index(card.name))
    return searched(kept, shelf.search) if shelf.search.strip() else tuple(kept)


def _filtered(cards: Sequence[Card], shelf: Shelf) -> list[Card]:
    kept = search.filtered(
        cards, kind=shelf.kind, maker=shelf.maker, fastest=SPEEDS[shelf.speed] if shelf.speed else None,
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


@lru_cache(maxsize=4096)
def short_title(card: Card) -> str:
    """The title without focal length and f-number, which a card shows beside it."""
    left = re.sub(r"(\s+at)?\s+[\d.–]+\s*mm\b|\s+f/[\d.–]+", " ", card.title)
    return re.sub(r"\s+(?=[\s,)])", "", left).strip(" ,") or card.title


def kinds(cards: Sequence[Card]) -> list[str]:
    """All kinds, in alphabetical order."""
    return sorted({card.kind for card in cards if card.kind}, key=plain)


def makers(cards: Sequence[Card]) -> list[str]:
    """All makers, in alphabetical order."""
    return sorted({card.maker for card in cards if card.maker}, key=plain)


def noted(names: Sequence[str], name: str, most: int) -> list[str]:
    """The names with one at the front, at most so many."""
    return [name, *(each for each in names if each != name)][:most]
