"""Glass catalogues in the AGF format (Zemax): for each glass its formula, coefficients and range.

The lines that matter: NM name formula code n_d V_d …; CD coefficients; LD shortest and longest wavelength (µm).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from os import PathLike
from pathlib import Path

from lensbench.lenses.encoding import decoded
from lensbench.lenses.file_error import LensFileError
from lensbench.optics.glass import Glass, GlassError, from_formula

# Of each formula number, the name of the formula and how many coefficients it takes.
FORMULAS = {1: ("schott", 6), 2: ("sellmeier", 6), 3: ("herzberger", 6), 4: ("sellmeier-2", 5), 5: ("conrady", 3),
            6: ("sellmeier", 8), 7: ("handbook-1", 4), 8: ("handbook-2", 4), 9: ("sellmeier-4", 5),
            10: ("schott", 8), 11: ("sellmeier", 10), 12: ("extended-2", 8), 13: ("extended-3", 9)}
LARGEST = 20_000_000        # bytes


@dataclass(frozen=True)
class Catalogue:
    """Glasses of one file; `findings` lists what was left out, with the reasons."""

    maker: str                          # the file's name in capitals
    glasses: tuple[Glass, ...]
    findings: tuple[str, ...] = ()


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
        if path.stat().st_size > LARGEST:
            raise LensFileError(path, None, f"larger than {LARGEST // 10**6} MB: this is no glass catalogue")
        text = decoded(path.read_bytes())
    except OSError as error:
        raise LensFileError(path, None, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise LensFileError(path, None, "this is a binary file: a glass catalogue is text") from None
    glasses: dict[str, Glass] = {}
    findings = []
    for record in _records(text):
        try:
            glass = _glass(record)
        except (ValueError, IndexError) as error:
            what = record.words[1] if len(record.words) > 1 else "a glass without a name"
            findings.append(f"{path.name}:{record.line}: {what} is left out: {error}")
            continue
        if glass.name in glasses:
            findings.append(f"{path.name}:{record.line}: {glass.name} is listed twice; the first entry is used")
        glasses.setdefault(glass.name, glass)
    if not glasses:
        raise LensFileError(path, None, f"holds no glass{': ' + findings[0] if findings else ' (no NM line)'}")
    return Catalogue(path.stem.upper(), tuple(glasses.values()), tuple(findings))


def _records(text: str) -> Iterator[_Record]:
    """Lines of each glass; a line that cannot be read leaves its glass incomplete, which is reported later."""
    record = None
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words:
            continue
        if words[0] == "NM":
            if record:
                yield record
            record = _Record(number, words, [])
        elif record and words[0] == "CD":
            record.coefficients = [_number(word) for word in words[1:]]
        elif record and words[0] == "LD" and len(words) >= 3:
            record.wavelengths = _number(words[1]), _number(words[2])
    if record:
        yield record


def _number(word: str) -> float:
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return float("nan")


def _glass(record: _Record) -> Glass:
    if len(record.words) < 6:
        raise GlassError("its NM line needs a name, a formula, a code, n_d and V_d")
    number = _number(record.words[2])
    if number not in FORMULAS:
        raise GlassError(f"formula {record.words[2]} is none of 1 to {max(FORMULAS)}")
    formula, count = FORMULAS[int(number)]
    coefficients = [*record.coefficients, *[0.0] * count][:count]
    if not any(coefficients):
        raise GlassError("it has no coefficients (CD)")
    glass = from_formula(record.words[1], formula, coefficients, record.wavelengths)
    n_d = _number(record.words[4])
    if glass.v_d is not None and isfinite(n_d) and abs(n_d - glass.n_d) > 1e-3:
        raise GlassError(f"its formula gives n_d {glass.n_d:.5f}, its NM line says {n_d:g}")
    return glass
