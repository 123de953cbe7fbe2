"""The lens library: names, headers, and suggestions for an unknown name."""

from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from math import hypot
from pathlib import Path

from lensbench.core.lazy import hashed_once
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.formats import toml_header

LIBRARY = Path(__file__).parent
COPIED = ("title", "kind", "year", "source", "maker", "designer", "patent", "film_size", "estimates", "stated_efl",
          "computed_f_number", "image_circle", "notes")       # from the header
FULL_FRAME = hypot(36.0, 24.0)          # mm
FAST = 2.95                             # an f/2.8 as computed
USES = {"portrait": "70 to 150 mm and f/2.8 or faster, or soft focus", "landscape": "35 mm or wider, not a fisheye",
        "street": "one focal length of 27 to 55 mm, f/2.8 or faster, on full frame or smaller",
        "macro": "of this kind", "astro": "36 mm or wider, f/2.8 or faster", "wildlife": "290 mm or longer",
        "travel": "a zoom of 4 times or more", "cinema": "anamorphic, or made for 16 mm film",
        "phone": "of this kind"}        # focal lengths are those of the same view on full frame


@hashed_once
@dataclass(frozen=True)
class Card:
    """Header of a library lens, for lists. Lengths in mm; None or "": not known.

    Attributes:
        name: What `load` takes.
        title, kind, source, notes: As the file has them; `kind` is "double Gauss", "fisheye", …
        year: Year of the design.
        maker, designer, patent: Who sold it (else whose patent it is), who designed it, the patent's number.
        film_size: (2,) tuple of float or None. Width and height of the film or sensor that the lens was made for.
        estimates: What of the prescription is not published but estimated, such as "all rims"; "" where nothing is.
        efl, tele_efl: Computed focal length; of a zoom the shortest and the longest.
        f_number, computed_f_number: Wide open: stated, else computed; and as computed.
        stated_efl: Focal length as published.
        image_circle: Diameter that the design covers, focused at infinity.
        surfaces, elements, groups, aspheres, focus_groups: What it consists of, see `Counts`; a lens without focus
            groups is focused as a whole.
    """

    name: str
    title: str
    kind: str = ""
    year: int | None = None
    source: str = ""
    maker: str = ""
    designer: str = ""
    patent: str = ""
    film_size: tuple[float, float] | None = None
    estimates: str = ""
    efl: float | None = None
    tele_efl: float | None = None
    f_number: float | None = None
    computed_f_number: float | None = None
    stated_efl: float | None = None
    image_circle: float | None = None
    surfaces: int = 0
    elements: int = 0
    groups: int = 0
    aspheres: int = 0
    focus_groups: int = 0
    notes: str = ""

    @property
    def zooms(self) -> bool:
        """Whether the focal length varies."""
        return self.tele_efl is not None

    @property
    def equivalents(self) -> tuple[float, float] | None:
        """Focal lengths (mm) of the same view on 36 × 24 mm, the shortest and the longest; None for unknown film."""
        diagonal = hypot(*self.film_size) if self.film_size is not None else self.image_circle
        if diagonal is None or self.efl is None:
            return None
        return self.efl * FULL_FRAME / diagonal, (self.tele_efl or self.efl) * FULL_FRAME / diagonal

    @property
    def uses(self) -> tuple[str, ...]:
        """What the lens is good for, by the rules of `USES`; only what the kind says where its film is unknown."""
        kind, is_fast = self.kind, self.f_number is not None and self.f_number <= FAST
        wide, tele = self.equivalents or (0.0, 0.0)
        is_plain = bool(wide) and kind not in ("fisheye", "phone lens", "enlarger or process")
        film = self.film_size or (0.0, 0.0)
        rules = {"portrait": is_plain and is_fast and wide <= 150.0 and tele >= 70.0 or kind == "soft focus",
                 "landscape": is_plain and wide <= 35.0,
                 "street": is_plain and is_fast and not self.zooms and 27.0 <= wide <= 55.0
                 and hypot(*film) < 1.05 * FULL_FRAME,
                 "macro": kind == "macro", "astro": 0.0 < wide <= 36.0 and is_fast and kind != "phone lens",
                 "wildlife": is_plain and tele >= 290.0, "travel": is_plain and tele >= 4.0 * wide,
                 "cinema": kind == "anamorphic" or film == (10.26, 7.49), "phone": kind == "phone lens"}
        return tuple(use for use in USES if rules[use])

    @property
    def has_aspheres(self) -> bool:
        """Whether a surface is aspheric."""
        return self.aspheres > 0


@lru_cache(maxsize=1)
def _names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in LIBRARY.glob("*.toml")))


def names() -> list[str]:
    """Names of the library lenses.

    Returns:
        In alphabetical order; each is an argument for `load`.
    """
    return list(_names())


def path_of(name: str) -> Path:
    """The file of a library lens."""
    return LIBRARY / f"{name}.toml"


@lru_cache(maxsize=1)
def describe() -> tuple[Card, ...]:
    """Headers of the library lenses, read once.

    Returns:
        In the order of `names`.
    Raises:
        LensFileError: A file of the library cannot be read.
    """
    return tuple(_card(name) for name in _names())


def card(name: str) -> Card | None:
    """Header of one library lens; no other file is read.

    Args:
        name: Any text.
    Returns:
        None where the library has no lens of this name.
    Raises:
        LensFileError: The file cannot be read.
    """
    return _card(name) if name in _names() else None


@lru_cache(maxsize=1024)
def _card(name: str) -> Card:
    path = path_of(name)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise LensFileError(path, None, f"cannot be read: {error.strerror}") from None
    header = toml_header.of_file(text, str(path))
    copied = {key: header[key] for key in COPIED if key in header}
    return Card(name, efl=header.get("computed_efl"), tele_efl=header.get("computed_tele_efl"),
                f_number=header.get("stated_f_number", header.get("computed_f_number")), **copied,
                **header.get("counts", {}))


def one_of_each_kind() -> list[str]:
    """The first name of each kind of library lens, sorted, for charts and sweeps that take long for each lens."""
    first: dict[str, str] = {}
    for card in describe():
        first.setdefault(card.kind, card.name)
    return sorted(first.values())


def suggestion(name: str) -> str:
    """Library names nearest to an unknown one, as the end of a sentence."""
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
