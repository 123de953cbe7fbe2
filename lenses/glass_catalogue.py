"""The glasses of Schott, Ohara, Hoya, CDGM and Sumita, and those of the user's AGF files: found by name or by code.

Coefficients as the makers' data sheets publish them, in `glasses.csv`; the user's files lie in
`lensbench/glass` in the configuration folder ($XDG_CONFIG_HOME, else ~/.config), and go first. Both are
read when the first glass is asked for. Nothing here guesses silently: what is not known is an error
that names the nearest names, and `resolve` says what it assumed.
"""

import os
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache, lru_cache, partial
from math import hypot
from pathlib import Path
from typing import NamedTuple

from lensbench.lenses import agf
from lensbench.lenses.file_error import LensFileError
from lensbench.optics.glass import Glass, GlassError, from_formula

MAKERS = ("SCHOTT", "OHARA", "HOYA", "CDGM", "SUMITA")       # in the order in which they are preferred
FILE = Path(__file__).parent / "glasses.csv"
PREFIXES = ("N", "S", "H", "E", "K", "D", "P", "L", "M", "J", "Q")    # of newer kinds of a glass: N-BK7 followed BK7
MOULDED = re.compile(r"[_-]MOLD(ED)?$", re.IGNORECASE)        # moulding lowers the index by some thousandths
TOLERANCE_N, TOLERANCE_V = 5e-4, 5e-3                         # of one melt: n_d, and V_d as a share of it


class UnknownGlass(GlassError):  # noqa: N818 — named for what the user reads
    """A glass that no catalogue knows; the message names the nearest names."""


@dataclass(frozen=True)
class Entry:
    """A line of a catalogue: n_d and V_d as published (None: a glass for the infrared); obsolete: no longer made."""

    maker: str
    name: str
    n_d: float | None
    v_d: float | None
    obsolete: bool
    make: Callable[[], Glass]

    @property
    def rank(self) -> tuple[bool, int]:
        """Smaller is preferred: current before obsolete, the user's own, then the makers in their order."""
        return self.obsolete, MAKERS.index(self.maker) if self.maker in MAKERS else -1

    def __str__(self) -> str:
        numbers = "" if self.n_d is None or self.v_d is None else f" (n_d {self.n_d:.5f}, V_d {self.v_d:.2f})"
        return f"{self.maker} {self.name}{numbers}"


class Resolved(NamedTuple):
    """A glass, who makes it, and in one sentence what was assumed ("" where name and maker are plain)."""

    glass: Glass
    maker: str
    note: str


def key(name: str) -> str:
    """What makers, programs and people write differently, alike: capitals, without hyphens, spaces and dots."""
    return re.sub(r"[\s._-]", "", name).upper()


def user_folder() -> Path:
    """Where the user's own AGF files lie."""
    home = os.environ.get("XDG_CONFIG_HOME")
    return (Path(home) if home else Path("~").expanduser() / ".config") / "lensbench" / "glass"


@cache
def shipped() -> tuple[Entry, ...]:
    """The makers' glasses."""
    with FILE.open(encoding="utf-8") as file:
        next(file)
        return tuple(_entry(line) for line in file)


def _entry(line: str) -> Entry:
    maker, name, n_d, v_d, status, formula, low, high, coefficients = line.split(",")

    def make() -> Glass:
        return from_formula(name, formula, [float(c) for c in coefficients.split()], (float(low), float(high)))
    return Entry(maker, name, float(n_d) if n_d else None, float(v_d) if v_d else None, status == "old", cache(make))


class _Known(NamedTuple):
    """All glasses, the user's first; the same by `key`; the makers; what of the user's files could not be read."""

    entries: tuple[Entry, ...]
    table: dict[str, list[Entry]]
    makers: set[str]
    findings: tuple[str, ...]


def _known() -> _Known:
    """What is known now: a file of the user that comes, goes or changes is met at once."""
    try:
        files = sorted(path for path in user_folder().iterdir() if path.suffix.lower() == ".agf")
        stamps = tuple((path, path.stat().st_mtime_ns) for path in files)
    except (OSError, RuntimeError):
        stamps = ()
    return _read(stamps)


@lru_cache(maxsize=1)
def _read(stamps: tuple[tuple[Path, int], ...]) -> _Known:
    own: list[Entry] = []
    findings: list[str] = []
    for path, _ in stamps:
        try:
            catalogue = agf.read(path)
        except LensFileError as error:
            findings.append(str(error))
            continue
        findings += catalogue.findings
        own += [Entry(catalogue.maker, glass.name, glass.n_d if glass.v_d else None, glass.v_d, False,
                      partial(replace, glass)) for glass in catalogue.glasses]
    table: dict[str, list[Entry]] = {}
    for entry in (*own, *shipped()):
        table.setdefault(key(entry.name), []).append(entry)
    return _Known((*own, *shipped()), table, {*MAKERS, *(entry.maker for entry in own)}, tuple(findings))


def entries() -> tuple[Entry, ...]:
    """All glasses known, the user's first."""
    return _known().entries


def findings() -> tuple[str, ...]:
    """In one sentence each, what of the user's folder could not be read."""
    return _known().findings


def _maker_in(name: str, maker: str | None, makers: set[str]) -> tuple[str, str | None]:
    """The glass and the maker that a text names together: "NBK7_SCHOTT", "Schott N-BK7"."""
    for sign in ("_", " ", ":"):
        for front, back in (name.strip().rpartition(sign)[::2], name.strip().partition(sign)[::2][::-1]):
            if front and back.upper() in makers:
                return front, back.upper()
    return name, maker.strip().upper() if maker else None


def _preferred(same: Iterable[Entry], maker: str | None, spelled: str) -> Entry:
    return min(same, key=lambda entry: (entry.maker != maker, entry.maker in MAKERS, entry.name != spelled, entry.rank))


def resolve(name: str, maker: str | None = None) -> Resolved:
    """The glass that is meant by a name, a name with its maker, a six-digit code, or an older or newer kind's name.

    maker: preferred where several makers use the name. UnknownGlass, with the nearest names, where there is none.
    """
    known = _known()
    glass, wanted = _maker_in(name, maker, known.makers)
    table = known.table
    if same := table.get(key(glass)):
        entry = _preferred(same, wanted, glass.strip())
        others = sorted({other.maker for other in same} - {entry.maker})
        note = ""
        if wanted and entry.maker != wanted:
            note = f"{wanted} makes no {entry.name}: that of {entry.maker} is taken"
        elif not wanted and others and entry.maker in MAKERS:
            note = f"{entry.name} is made by {entry.maker} and {', '.join(others)}: that of {entry.maker} is taken"
        return Resolved(entry.make(), entry.maker, note)
    if numbers := code_numbers(glass):
        entry = _by_code(*numbers, wanted)
        return Resolved(entry.make(), entry.maker, f"code {glass.strip()} is taken for {entry}")
    if MOULDED.search(glass):
        unmoulded = resolve(MOULDED.sub("", glass), wanted)
        return unmoulded._replace(note=f"{glass.strip()}, a moulded glass, is taken as unmoulded "
                                       f"{unmoulded.maker} {unmoulded.glass.name}")
    bare = key(glass)
    kinds = [entry for prefix in PREFIXES for entry in table.get(prefix + bare, ())]
    if bare[:1] in PREFIXES and re.match(r"\s*\w-", glass):
        kinds += table.get(bare[1:], ())
    if kinds:
        entry = _preferred(kinds, wanted, glass)
        return Resolved(entry.make(), entry.maker, f"{glass.strip()} is in no catalogue: {entry} is taken for it")
    raise UnknownGlass(_unknown(glass.strip(), known))


def _unknown(name: str, known: _Known) -> str:
    near = get_close_matches(key(name)[:60], known.table, n=4, cutoff=0.6)
    hint = " or ".join(str(_preferred(known.table[k], None, "")) for k in near)
    unread = known.findings
    return (f"glass {name[:60]!r} is in no catalogue{f': did you mean {hint}?' if near else '.'} "
            f"An AGF file that holds it can be laid into {user_folder()}"
            + (f" (there: {unread[0]}{f', and {len(unread) - 1} more' if len(unread) > 1 else ''})" if unread else ""))


def find(name: str, maker: str | None = None) -> Glass:
    """The glass of a name, however it is spelled, alone or with its maker; maker: preferred where several use it.

    UnknownGlass for all other texts: codes are for `from_code`, and `resolve` takes what is near.
    """
    glass = lookup(name, maker)
    if glass is None:
        known = _known()
        raise UnknownGlass(_unknown(_maker_in(name, maker, known.makers)[0].strip(), known))
    return glass


def lookup(name: str, maker: str | None = None) -> Glass | None:
    """The glass that `find` gives, None where no catalogue has the name."""
    known = _known()
    glass, wanted = _maker_in(name, maker, known.makers)
    same = known.table.get(key(glass))
    return _preferred(same, wanted, glass.strip()).make() if same else None


def makers(name: str) -> list[str]:
    """Who has a glass of this name, the preferred one first."""
    same = sorted(_known().table.get(key(name), ()), key=lambda entry: (entry.maker in MAKERS, entry.rank))
    return list(dict.fromkeys(entry.maker for entry in same))


def code_numbers(text: str) -> tuple[float, float] | None:
    """(n_d, V_d) of a six-digit code: "517642", also "517.642" and "517:642"; None where the text is none."""
    match = re.fullmatch(r"\s*(\d{3})[.:/-]?(\d{3})(?:\.\d+)?\s*", text, re.ASCII)
    if not match or match[2] == "000":
        return None
    n = int(match[1]) / 1000.0
    return n + (2.0 if n < 0.3 else 1.0), int(match[2]) / 10.0


def from_code(code: str, maker: str | None = None) -> Glass:
    """The glass of a six-digit code, or the nearest; GlassError where the text is no code. `resolve` says which."""
    numbers = code_numbers(code)
    if not numbers:
        raise GlassError(f"{code[:60]!r} is no glass code: six digits, three of n_d − 1 and three of V_d")
    return _by_code(*numbers, maker).make()


def _by_code(n_d: float, v_d: float, maker: str | None) -> Entry:
    """Of the glasses with this very code the preferred one, else the nearest."""
    same = [entry for entry in entries() if entry.n_d and entry.v_d
            and round(entry.n_d, 3) == n_d and round(entry.v_d, 1) == v_d]
    return _preferred(same, maker and maker.upper(), "") if same else _nearest(n_d, v_d, maker)


def nearest(n_d: float, v_d: float, maker: str | None = None) -> Glass:
    """The glass nearest to an index and an Abbe number, each against what one melt may differ by (0.0005, 0.5 %).

    maker: of this maker alone, where he is known. Of two about as near, the one that is still made.
    """
    return _nearest(n_d, v_d, maker).make()


def _nearest(n_d: float, v_d: float, maker: str | None) -> Entry:
    wanted = maker and maker.upper()
    known = [entry for entry in entries() if entry.n_d and entry.v_d]
    own = [entry for entry in known if entry.maker == wanted]
    return min(own or known, key=lambda entry: (distance(entry, n_d, v_d) + 0.2 * entry.obsolete, entry.rank))


def distance(entry: Entry, n_d: float, v_d: float) -> float:
    """How far a glass is from an index and an Abbe number: 1 is what one melt may differ by. inf: it has none."""
    if entry.n_d is None or entry.v_d is None:
        return float("inf")
    return hypot((entry.n_d - n_d) / TOLERANCE_N, (entry.v_d - v_d) / (TOLERANCE_V * v_d))
