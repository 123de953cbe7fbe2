"""Opening and saving lens files: the format by suffix, a file whole or not at all."""

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import fixed, significant
from lensbench.lenses.file_error import LensFileError, open_regular, replacing
from lensbench.lenses.formats.table import READERS, UTF8_SUFFIXES, WRITERS, Writer
from lensbench.lenses.library import catalogue
from lensbench.lenses.stop_picture import with_picture_beside
from lensbench.lenses.tables.text import decoded

if TYPE_CHECKING:
    from lensbench.lenses.editing.document import LensDocument

LARGEST_FILE = 1_000_000    # bytes; the longest known prescriptions have a hundredth of that


def load(name_or_path: str | os.PathLike[str], zoom: float | None = None, close: float | None = None) -> Lens:
    """The lens of a library name, or of a file in the format of its suffix.

    Args:
        name_or_path: A name of the library ("pbrt-dgauss-50mm") or the path of a file.
        zoom: Zoom position from 0 (wide) to 1 (tele); by default the one of the file, which is 0.
        close: Position of the focus groups from 0 (infinity) to 1 (nearest); by default the one of the file, which is
            0.
    Returns:
        Lengths in mm; a file of another unit is converted. It keeps its other positions, see `Lens.at`; its `findings`
            say what had to be assumed to read the file.
    Raises:
        LensFileError: The name is unknown, or the file holds no lens; it names the line.
        LensError: The lens has no such position.
    """
    path = _path(name_or_path)
    content = _content(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise LensFileError(path, None, f"lens files of type {path.suffix or 'none'} are not supported; "
                                        f"supported are {', '.join(READERS)}")
    return reader(content, str(path)).at(zoom, close)


def load_document(name_or_path: str | os.PathLike[str]) -> "LensDocument":
    """The lens of a library name or of a file, as `load`, with the comments, solves and pickups of a .toml file.

    Args:
        name_or_path: As of `load`.
    Returns:
        As it is in the file: nothing is solved anew. `save` writes it again.
    Raises:
        LensFileError: The name is unknown, or the file holds no lens; it names the line.
    """
    from lensbench.lenses.editing.document import LensDocument, from_text

    path = _path(name_or_path)
    return from_text(_content(path), str(path)) if path.suffix.lower() == ".toml" else LensDocument(load(path))


def _path(name_or_path: str | os.PathLike[str]) -> Path:
    """The file of a library name or a path; LensFileError for a name that the library does not have."""
    text = os.fspath(name_or_path)
    if isinstance(name_or_path, str) and text in catalogue.names():
        return catalogue.path_of(text)
    if isinstance(name_or_path, str) and not _is_path(text):
        raise LensFileError(text or '""', None, f"no library lens has this name; {catalogue.suggestion(text)}")
    return Path(text)


def writer_of(path: Path) -> Writer:
    """The writer of the format that the suffix says; LensFileError where there is none, or no place for the file."""
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LensFileError(path, None, f"lens files of type {path.suffix or 'none'} cannot be written; "
                                        f"supported are {', '.join(WRITERS)}")
    if not path.parent.is_dir():
        raise LensFileError(path, None, f"there is no folder {path.parent}")
    if path.is_dir():
        raise LensFileError(path, None, "this is a folder")
    return writer


def save(lens: "Lens | LensDocument", path: str | os.PathLike[str]) -> tuple[Finding, ...]:
    """Write a lens in the format of the suffix.

    The file is written beside its place and then moved there: an old one survives whatever goes wrong. A picture in the
    stop is kept as a file in the same folder, which a .toml file names; it is copied there if it lies elsewhere.

    Args:
        lens: The lens to write; a document with its comments, solves and pickups, which .toml holds.
        path: The file; its suffix, one of `WRITERS`, says the format.
    Returns:
        What the format could not hold; a WARNING where what is written is another lens.
    Raises:
        LensFileError: No format with this suffix can be written, or the place cannot; or the file would not open again.
    """
    from lensbench.lenses.editing.document import LensDocument, lost_edits, with_edits

    path = Path(path)
    writer = writer_of(path)
    document = lens if isinstance(lens, LensDocument) else LensDocument(lens)
    remarks: list[Finding] = []
    if document is not lens and any(finding.kind is Kind.RULE for finding in document.lens.findings):
        remarks.append(note(Kind.LEFT_OUT, "left out: solves and pickups of the file that the lens came from; "
                                           "lenses.load_document keeps them"))
    if path.suffix.lower() == ".toml":
        kept, placed = with_picture_beside(document.lens, path)
        text, lost = writer(kept)
        text, remarks = with_edits(text, document), [*remarks, *placed, *lost]
    else:
        text, lost = writer(document.lens.with_round_stop)
        remarks += [*lost, *lost_edits(document)]
    _check_opens(text, path)
    with replacing(path) as partial, open(partial, "w", encoding="utf-8", errors="replace", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    return tuple(remarks)


def _check_opens(text: str, path: Path) -> None:
    """Raise LensFileError for a text that `load` would refuse: it is not written."""
    size = len(text.encode(errors="replace"))
    try:
        if size > LARGEST_FILE:
            raise LensFileError(path, None, f"{fixed(size / 1e6, 1)} MB are more than the "
                                            f"{significant(LARGEST_FILE / 1e6)} MB of a lens file")
        READERS[path.suffix.lower()](text, str(path))
    except LensFileError as error:
        raise LensFileError(path, None, f"is not written, as it would not open again: {error.reason}") from None


def _is_path(text: str) -> bool:
    """Whether a text is a path: it contains a separator or a suffix, or such a file exists."""
    separators = {os.sep, os.altsep or os.sep}
    try:
        if any(sep in text for sep in separators) or re.search(r"\.[A-Za-z]\w*$", text):
            return True
        return text != "" and Path(text).exists()
    except (OSError, ValueError):           # a name too long, or with a NUL in it
        return False


def _content(path: Path) -> str:
    """Text of a lens file. LensFileError: missing, not a file, too large, or not text."""
    try:
        with open_regular(path) as file:
            size = os.fstat(file.fileno()).st_size
            if size > LARGEST_FILE:
                raise LensFileError(path, None, f"{fixed(size / 1e6, 1)} MB is no lens file: at most "
                                                f"{significant(LARGEST_FILE / 1e6)} MB")
            data = file.read(LARGEST_FILE)
    except FileNotFoundError:
        raise LensFileError(path, None, "there is no such file") from None
    except OSError as error:
        raise LensFileError(path, None, f"cannot be read: {error.strerror or error}") from None
    if not data.strip():
        raise LensFileError(path, None, "the file is empty")
    try:
        if path.suffix.lower() not in UTF8_SUFFIXES:
            return decoded(data)
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        what = "a binary file" if b"\0" in data else "not UTF-8"
        raise LensFileError(path, line, f"this is {what}: lens files are UTF-8 text") from None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise LensFileError(path, line, "this is a binary file: lens files are UTF-8 text")
    return text.replace("\r\n", "\n").replace("\r", "\n")
