"""The lenses that are shipped: their names, their headers, and the nearest to a name that is none of them."""

from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path

from lensbench.lenses import toml_format
from lensbench.lenses.file_error import LensFileError

LIBRARY = Path(__file__).parent / "library"


@dataclass(frozen=True)
class Card:
    """What a list of lenses shows of one: from its header alone. Lengths in mm; None: not published."""

    name: str                               # what `load` takes
    title: str
    kind: str = ""
    year: int | None = None
    source: str = ""
    efl: float | None = None                # as computed; of a zoom, its shortest
    tele_efl: float | None = None           # of a zoom, its longest
    f_number: float | None = None           # wide open: as stated, else as computed
    stated_efl: float | None = None
    image_circle: float | None = None       # diameter that the design covers, focused at infinity
    notes: str = ""


@lru_cache(maxsize=1)
def _names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in LIBRARY.glob("*.toml")))


def names() -> list[str]:
    """The names of the library's lenses, in order of the alphabet."""
    return list(_names())


def path_of(name: str) -> Path:
    """The file of a library lens."""
    return LIBRARY / f"{name}.toml"


@lru_cache(maxsize=1)
def describe() -> tuple[Card, ...]:
    """A card of each library lens, in the order of `names`; read once, from the headers alone."""
    return tuple(_card(name) for name in _names())


def _card(name: str) -> Card:
    path = path_of(name)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise LensFileError(path, None, f"cannot be read: {error.strerror}") from None
    head = text.partition("\ncolumns")[0]
    header = toml_format.check_header(toml_format.parse(head, str(path)), head, str(path))
    return Card(name, header["title"], header["kind"], header.get("year"), header["source"],
                efl=header.get("computed_efl"), tele_efl=header.get("computed_tele_efl"),
                f_number=header.get("stated_f_number", header.get("computed_f_number")),
                stated_efl=header.get("stated_efl"), image_circle=header.get("image_circle"),
                notes=header.get("notes", ""))


def suggestion(name: str) -> str:
    """The library names nearest to one that is none of them, as the end of a sentence."""
    typed = name.strip().lower()[:80]
    titles = {card.name: f"{card.name} {card.title} {card.kind}".lower() for card in describe()}
    near = [known for known, title in titles.items() if len(typed) > 2 and typed in title]
    near += get_close_matches(typed, titles, n=4, cutoff=0.7)
    for word in get_close_matches(typed, sorted({word for title in titles.values() for word in title.split()})):
        near += [known for known, title in titles.items() if word in title.split()]
    near = list(dict.fromkeys(near))
    if not near:
        return f"`lensbench lenses` lists the {len(titles)} there are"
    return f"did you mean {' or '.join(near[:4])}?"
