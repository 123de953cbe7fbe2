"""Glass catalogues in the AGF format (Zemax): for each glass its formula, coefficients and range.

The records that matter: NM name formula code n_d V_d …; CD coefficients; LD shortest and longest wavelength (µm). A
record may continue on the next lines: a line without one of the two-letter keywords belongs to the record before it.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from os import PathLike
from pathlib import Path

from lensbench.core.optics.glass import C_LINE, F_LINE, Glass, GlassError, from_formula
from lensbench.core.text import cut, escaped, fixed
from lensbench.lenses.file_error import LensFileError, open_regular
from lensbench.lenses.tables.text import decoded

# Of each formula number, the name of the formula and how many coefficients it takes.
FORMULAS = {1: ("schott", 6), 2: ("sellmeier", 6), 3: ("herzberger", 6), 4: ("sellmeier-2", 5), 5: ("conrady", 3),
            6: ("sellmeier", 8), 7: ("handbook-1", 4), 8: ("handbook-2", 4), 9: ("sellmeier-4", 5),
            10: ("schott", 8), 11: ("sellmeier", 10), 12: ("extended-2", 8), 13: ("extended-3", 9)}
LARGEST = 20_000_000        # bytes
KEYWORD = re.compile(r"[A-Z]{2}")
DOUBTFUL, WRONG = 2e-5, 1e-3    # differences of the formula from n_d, and n_F − n_C, of the NM record


@dataclass(frozen=True)
class Catalogue:
    """Glasses of one file, in its order; maker: the file's name in capitals.

    findings: what was left out, with the reasons. doubts: by the names of glasses whose formula and NM record differ by
    more than DOUBTFUL, a sentence with both values.
    """

    maker: str
    glasses: tuple[Glass, ...]
    findings: tuple[str, ...] = ()
    doubts: Mapping[str, str] = field(default_factory=dict)


@dataclass
class _Record:
    line: int
    words: list[str]
    coefficients: list[float]
    wavelengths: tuple[float, float] | None = None


def read(path: str | PathLike[str]) -> Catalogue:
    """The glasses of an AGF file in UTF-8, UTF-16 or Latin-1; LensFileError if it contains none."""
    path = Path(path)
    try:
        with open_regular(path) as file:
            data = file.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise LensFileError(path, None, f"larger than {LARGEST // 10**6} MB: this is no glass catalogue")
        text = decoded(data)
    except OSError as error:
        raise LensFileError(path, None, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise LensFileError(path, None, "this is a binary file: a glass catalogue is text") from None
    glasses: dict[str, Glass] = {}
    findings, doubts = [], {}
    for record in _records(text):
        try:
            glass, doubt = _glass(record)
        except (ValueError, IndexError) as error:
            what = record.words[1] if len(record.words) > 1 else "a glass without a name"
            findings.append(escaped(f"{path.name}:{record.line}: {cut(what)} is left out: {error}"))
            continue
        if glass.name in glasses:
            findings.append(escaped(f"{path.name}:{record.line}: {cut(glass.name)} is listed twice; the first entry is "
                                    "used"))
            continue
        glasses[glass.name] = glass
        if doubt:
            doubts[glass.name] = escaped(f"{path.name}:{record.line}: {cut(glass.name)}: {doubt}; the formula is used")
    if not glasses:
        raise LensFileError(path, None, f"holds no glass{': ' + findings[0] if findings else ' (no NM line)'}")
    return Catalogue(path.stem.upper(), tuple(glasses.values()), tuple(findings), doubts)


def _records(text: str) -> Iterator[_Record]:
    """The records of each glass; one that cannot be read leaves its glass incomplete, which is reported later."""
    glass = None
    for number, keyword, words in _joined(text):
        if keyword == "NM":
            if glass:
                yield glass
            glass = _Record(number, [keyword, *words], [])
        elif glass and keyword == "CD":
            glass.coefficients = [_number(word) for word in words]
        elif glass and keyword == "LD" and len(words) >= 2:
            glass.wavelengths = _number(words[0]), _number(words[1])
    if glass:
        yield glass


def _joined(text: str) -> Iterator[tuple[int, str, list[str]]]:
    """Each record with its continuation lines: the number of its first line, its keyword, and its words."""
    first, keyword, words = 0, "", list[str]()
    for number, line in enumerate(text.splitlines(), 1):
        head, *rest = line.split() or [""]
        if KEYWORD.fullmatch(head):
            yield first, keyword, words
            first, keyword, words = number, head, rest
        elif head:
            words += [head, *rest]
    yield first, keyword, words


def _number(word: str) -> float:
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return float("nan")


def _glass(record: _Record) -> tuple[Glass, str]:
    """The glass of a record, and how its formula and its NM record differ ("": not). GlassError: left out."""
    if len(record.words) < 6:
        raise GlassError("its NM line needs a name, a formula, a code, n_d and V_d")
    number = _number(record.words[2])
    if number not in FORMULAS:
        raise GlassError(f"formula {cut(record.words[2])} is none of 1 to {max(FORMULAS)}")
    formula, count = FORMULAS[int(number)]
    coefficients = [*record.coefficients, *[0.0] * count][:count]
    if not any(coefficients):
        raise GlassError("it has no coefficients (CD)")
    glass = from_formula(record.words[1], formula, coefficients, record.wavelengths)
    n_d, v_d = _number(record.words[4]), _number(record.words[5])
    if glass.v_d is None or not isfinite(n_d):          # a glass of the infrared: its n_d is at another wavelength
        return glass, ""
    if abs(n_d - glass.n_d) > WRONG:
        raise GlassError(f"its formula gives n_d {fixed(glass.n_d, 5)}, its NM record states {fixed(n_d, 5)}")
    doubts = []
    if abs(n_d - glass.n_d) > DOUBTFUL:
        doubts.append(f"n_d {fixed(glass.n_d, 6)}, its NM record states {fixed(n_d, 6)}")
    if v_d > 0.0 and abs((n_d - 1.0) / v_d - glass.index(F_LINE) + glass.index(C_LINE)) > DOUBTFUL:
        doubts.append(f"V_d {fixed(glass.v_d, 2)}, its NM record states {fixed(v_d, 2)}")
    return glass, f"its formula gives {' and '.join(doubts)}" if doubts else ""
