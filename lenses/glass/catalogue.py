"""Glasses of Schott, Ohara, Hoya, CDGM, Sumita and Hikari, and of the user's AGF files, by name or by code.

Coefficients are those of the makers' data sheets (`glasses.csv`; Hikari's of 1 April 2020). MISC holds media that no
maker lists: fused silica, CaF2 and BaF2 (I. H. Malitson, 1963 to 1965), and plastics (Zemax's MISC.AGF). The user's
files are in `lensbench/glass` in the configuration folder ($XDG_CONFIG_HOME, else ~/.config), and have priority. Both
are read when the first glass is requested. No assumption is silent: an unknown glass is an error that lists the nearest
names, and `resolve` states what it assumed.
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

from lensbench.core.optics.glass import Glass, GlassError, from_formula
from lensbench.core.text import excerpt, fixed
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.glass import agf

MAKERS = ("SCHOTT", "OHARA", "HOYA", "CDGM", "SUMITA", "HIKARI", "MISC")      # in order of preference
FILE = Path(__file__).parent / "glasses.csv"
PREFIXES = ("N", "S", "H", "E", "K", "D", "P", "L", "M", "J", "Q")    # of newer kinds of a glass: N-BK7 followed BK7
RENAMED = {"E-": "J-"}                                        # Hikari's former and present names of a glass
MOULDED = re.compile(r"[_-]MOLD(ED)?$", re.IGNORECASE)
MOULDING = "moulding lowers the index, by an estimated 0.001 to 0.006"      # by how much is an estimate of ours
TOLERANCE_N, TOLERANCE_V = 5e-4, 5e-3                         # of one melt: n_d, and V_d as a share of it


class UnknownGlass(GlassError):  # noqa: N818 — the name is part of what the user reads
    """A glass that is in no catalogue; the message lists the nearest names."""


@dataclass(frozen=True)
class Entry:
    """A line of a catalogue: published n_d and V_d (None: infrared glass); obsolete: no longer made.

    doubt: a sentence about figures of a user's file that contradict each other, or "".
    """

    maker: str
    name: str
    n_d: float | None
    v_d: float | None
    obsolete: bool
    make: Callable[[], Glass]
    doubt: str = ""

    @property
    def rank(self) -> tuple[bool, int]:
        """Order of preference, smallest first: current before obsolete, the user's own, then by maker."""
        return self.obsolete, MAKERS.index(self.maker) if self.maker in MAKERS else -1

    def __str__(self) -> str:
        if self.n_d is None or self.v_d is None:
            return f"{self.maker} {self.name}"
        return f"{self.maker} {self.name} (n_d {fixed(self.n_d, 5)}, V_d {fixed(self.v_d, 2)})"


class Resolved(NamedTuple):
    """A glass, its maker, and what was assumed or is in doubt ("" if name and maker are unique)."""

    glass: Glass
    maker: str
    note: str


def key(name: str) -> str:
    """Common form of a name that is spelled in several ways: capitals, without hyphens, spaces and dots."""
    return re.sub(r"[\s._-]", "", name).upper()


def user_folder() -> Path:
    """Folder of the user's AGF files."""
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

    return Entry(maker, name, float(n_d) if n_d else None, float(v_d) if v_d else None, status == "old",
                 partial(_made, name, formula, coefficients, float(low), float(high)))


@cache
def _made(name: str, formula: str, coefficients: str, low: float, high: float) -> Glass:
    return from_formula(name, formula, [float(c) for c in coefficients.split()], (low, high))


class _Known(NamedTuple):
    """All glasses, the user's first; glasses by `key`; the makers; findings about the user's files."""

    entries: tuple[Entry, ...]
    table: dict[str, list[Entry]]
    makers: set[str]
    findings: tuple[str, ...]


def _known() -> _Known:
    """The present glasses; changes of the user's files take effect at once."""
    try:
        files = sorted(path for path in user_folder().iterdir() if path.suffix.lower() == ".agf")
        stamps = tuple((path, path.stat().st_mtime_ns) for path in files)
    except (FileNotFoundError, NotADirectoryError, RuntimeError):           # no such folder, no home
        return _read(())
    except OSError as error:
        return _read((), f"{user_folder()} cannot be read: {error.strerror or error}")
    return _read(stamps)


@lru_cache(maxsize=1)
def _read(stamps: tuple[tuple[Path, int], ...], problem: str = "") -> _Known:
    own: list[Entry] = []
    findings = [problem] if problem else []
    for path, _ in stamps:
        try:
            catalogue = agf.read(path)
        except LensFileError as error:
            findings.append(str(error))
            continue
        findings += catalogue.findings
        own += [Entry(catalogue.maker, glass.name, glass.n_d if glass.v_d else None, glass.v_d, False,
                      partial(replace, glass), catalogue.doubts.get(glass.name, "")) for glass in catalogue.glasses]
    table: dict[str, list[Entry]] = {}
    for entry in (*own, *shipped()):
        table.setdefault(key(entry.name), []).append(entry)
    return _Known((*own, *shipped()), table, {*MAKERS, *(entry.maker for entry in own)}, tuple(findings))


def entries() -> tuple[Entry, ...]:
    """All known glasses, the user's first."""
    return _known().entries


def replacements(maker: str | None = None) -> tuple[Glass, ...]:
    """Glasses with n_d and V_d that are still made, of one maker or of all; GlassError for an unknown maker."""
    known = [entry for entry in entries() if maker in (None, entry.maker)]
    if not known:
        raise GlassError(f"no glass of {maker}: choose one of {', '.join(dict.fromkeys(e.maker for e in entries()))}")
    return tuple(entry.make() for entry in sorted(known, key=lambda entry: (entry.rank, entry.name))
                 if entry.n_d and entry.v_d and not entry.obsolete)


def findings() -> tuple[str, ...]:
    """Sentences about files and glasses in the user's folder that could not be read; for others see `resolve`."""
    return _known().findings


def unread_text() -> str:
    """The first of `findings` and the number of the others, in a few words; "" for none."""
    unread = findings()
    return f"{unread[0]}{f', and {len(unread) - 1} more' if len(unread) > 1 else ''}" if unread else ""


def _maker_in(name: str, maker: str | None, makers: set[str]) -> tuple[str, str | None]:
    """Glass and maker that a text names together: "NBK7_SCHOTT", "Schott N-BK7"."""
    for sign in ("_", " ", ":"):
        for front, back in (name.strip().rpartition(sign)[::2], name.strip().partition(sign)[::2][::-1]):
            if front and back.upper() in makers:
                return front, back.upper()
    return name, maker.strip().upper() if maker else None


def _preferred(same: Iterable[Entry], maker: str | None, spelled: str) -> Entry:
    return min(same, key=lambda entry: (entry.maker != maker, entry.maker in MAKERS, entry.name != spelled, entry.rank))


def resolve(name: str, maker: str | None = None) -> Resolved:
    """The glass of a name, a name with its maker, a six-digit code, or the name of an older or newer kind.

    maker: preferred if several makers use the name. UnknownGlass lists the nearest names if there is none.
    """
    known = _known()
    glass, maker_name = _maker_in(name, maker, known.makers)
    table = known.table
    if same := table.get(key(glass)):
        entry = _preferred(same, maker_name, glass.strip())
        others = sorted({other.maker for other in same} - {entry.maker})
        note = ""
        if maker_name and entry.maker != maker_name:
            note = f"{maker_name} makes no {entry.name}: that of {entry.maker} is used"
            if entry.maker == "MISC":
                note = f"no {entry.name} of {maker_name} is known: that of the catalogue MISC is used"
        elif not maker_name and others and entry.maker in MAKERS:
            note = f"{entry.name} is made by {' and '.join((entry.maker, *others))}: that of {entry.maker} is used"
        return Resolved(entry.make(), entry.maker, "; ".join(filter(None, (note, entry.doubt))))
    if numbers := code_numbers(glass):
        entry = _by_code(*numbers, maker_name)
        return Resolved(entry.make(), entry.maker, f"code {glass.strip()} is read as {entry}")
    if MOULDED.search(glass):
        unmoulded = resolve(MOULDED.sub("", glass), maker_name)
        return unmoulded._replace(note=f"{glass.strip()}, a moulded glass, is read as unmoulded "
                                       f"{unmoulded.maker} {unmoulded.glass.name}, n_d "
                                       f"{fixed(unmoulded.glass.n_d, 5)}: {MOULDING}")
    for former, present in RENAMED.items():
        if glass.strip().upper().startswith(former) and (
                same := table.get(key(present + glass.strip()[len(former):]))):
            entry = _preferred(same, maker_name, glass)
            return Resolved(entry.make(), entry.maker,
                            f"{glass.strip()} is in no catalogue: {entry}, its current name, is used instead")
    bare = key(glass)
    kinds = [entry for prefix in PREFIXES for entry in table.get(prefix + bare, ())]
    if bare[:1] in PREFIXES and re.match(r"\s*\w-", glass):
        kinds += table.get(bare[1:], ())
    if kinds:
        entry = _preferred(kinds, maker_name, glass)
        return Resolved(entry.make(), entry.maker, f"{glass.strip()} is in no catalogue: {entry} is used instead")
    raise UnknownGlass(_unknown(glass.strip(), known))


def _unknown(name: str, known: _Known) -> str:
    near = get_close_matches(key(name)[:60], known.table, n=4, cutoff=0.6)
    hint = " or ".join(str(_preferred(known.table[k], None, "")) for k in near)
    unread = unread_text()
    return (f"glass {excerpt(name)} is in no catalogue{f': did you mean {hint}?' if near else '.'} "
            f"An AGF file that contains it can be put into {user_folder()}"
            + (f" (there: {unread})" if unread else ""))


def find(name: str, maker: str | None = None) -> Glass:
    """The glass of a name in any spelling, alone or with its maker.

    Args:
        name: "N-BK7", "nbk7" or "Schott N-BK7". `from_code` takes codes, and `resolve` takes similar names.
        maker: Preferred if several makers use the name.
    Returns:
        Glass of the catalogues that are shipped, or of an AGF file in `user_folder()`, with its dispersion.
    Raises:
        UnknownGlass: No catalogue has the name; the message names the nearest ones.
    """
    glass = lookup(name, maker)
    if glass is None:
        known = _known()
        raise UnknownGlass(_unknown(_maker_in(name, maker, known.makers)[0].strip(), known))
    return glass


def lookup(name: str, maker: str | None = None) -> Glass | None:
    """The glass that `find` returns, or None if no catalogue has the name."""
    entry = _named(name, maker)
    return entry.make() if entry else None


def _named(name: str, maker: str | None) -> Entry | None:
    known = _known()
    glass, maker_name = _maker_in(name, maker, known.makers)
    same = known.table.get(key(glass))
    return _preferred(same, maker_name, glass.strip()) if same else None


def makers(name: str) -> list[str]:
    """Makers of a glass of this name, the preferred one first."""
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
    """The glass of a six-digit code, or the nearest one (`resolve` states which); GlassError if the text is no code."""
    numbers = code_numbers(code)
    if not numbers:
        raise GlassError(f"{excerpt(code)} is no glass code: six digits, three of n_d − 1 and three of V_d")
    return _by_code(*numbers, maker).make()


def _by_code(n_d: float, v_d: float, maker: str | None) -> Entry:
    """The preferred glass with exactly this code, else the nearest."""
    same = [entry for entry in entries() if entry.n_d and entry.v_d
            and round(entry.n_d, 3) == n_d and round(entry.v_d, 1) == v_d]
    return _preferred(same, maker and maker.upper(), "") if same else _nearest(n_d, v_d, maker)


def nearest(n_d: float, v_d: float, maker: str | None = None) -> Glass:
    """The glass nearest to an index and an Abbe number, each relative to the tolerance of one melt (0.0005, 0.5 %).

    maker: restrict the search to a known maker. Of two about equally near, the one in production.
    """
    return _nearest(n_d, v_d, maker).make()


def _nearest(n_d: float, v_d: float, maker: str | None) -> Entry:
    maker_name = maker and maker.upper()
    known = [entry for entry in entries() if entry.n_d and entry.v_d]
    own = [entry for entry in known if entry.maker == maker_name]
    return min(own or known, key=lambda entry: (distance(entry, n_d, v_d) + 0.2 * entry.obsolete, entry.rank))


def distance(entry: Entry, n_d: float, v_d: float) -> float:
    """Distance of a glass from an index and an Abbe number, in melt tolerances; inf if it has none."""
    if entry.n_d is None or entry.v_d is None:
        return float("inf")
    return hypot((entry.n_d - n_d) / TOLERANCE_N, (entry.v_d - v_d) / (TOLERANCE_V * v_d))
