"""The error of a lens file, in one line; its checked numbers; and files that may be opened."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from decimal import Decimal
from math import inf, isinf, isnan
from os import PathLike
from pathlib import Path
from typing import BinaryIO

from lensbench.core.text import cut, escaped, excerpt


class LensFileError(ValueError):
    """A lens file that holds no lens or cannot be written, or an unknown lens name.

    Args:
        path: The file, or the name.
        line: Line from 1; None: the whole file.
        reason: What is wrong and what to do, in one sentence.
    """

    def __init__(self, path: str | PathLike[str], line: int | None, reason: str):
        self.path, self.line, self.reason = str(path), line, _one_line(reason)
        position = "" if line is None else f":{line}"
        super().__init__(f"{_one_line(self.path)}{position}: {self.reason}")


def _one_line(text: str) -> str:
    """The text with line ends and control characters escaped, cut if long: a damaged file can contain anything."""
    return cut(escaped(text), 300)


class RowError(ValueError):
    """An invalid value in a row or a header; the reader adds the file and the line."""


@contextmanager
def located(path: str, line: int | None, before: str = "") -> Iterator[None]:
    """Make errors of values LensFileErrors: with the file, the line, and what stands before their words."""
    try:
        yield
    except LensFileError:
        raise
    except (ValueError, ArithmeticError) as error:
        raise LensFileError(path, line, f"{before}{error}") from None


@contextmanager
def replacing(path: Path, what: str = "") -> Iterator[Path]:
    """A path in the same folder, whose file becomes `path` at the end; after an error the old file is still there.

    what: begins the reason of the LensFileError where it cannot be written.
    """
    partial = path.with_name(f".{path.name[:100]}.{os.getpid()}.part")
    try:
        yield partial
        partial.replace(path)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LensFileError(path, None, f"{what}cannot be written: {reason}") from None
    finally:
        with suppress(OSError, ValueError):
            partial.unlink()


def number(value: object, name: str, infinite: bool = False) -> float:
    """The value, a number or its text, as a float. RowError: no number, NaN, or infinite without permission."""
    if isinstance(value, bool) or not isinstance(value, int | float | str | Decimal):
        raise RowError(f"{name} is {excerpt(value)}: it must be a number")
    try:
        result = float(value)
    except OverflowError:
        result = inf
    except ValueError:
        raise RowError(f"{name} is {excerpt(value)}: it must be a number") from None
    if isnan(result) or (isinf(result) and not infinite):
        raise RowError(f"{name} is {result}: it must be a finite number")
    return result


def not_understood(what: str) -> str:
    """The reason for which a file with an unknown command or entry is refused."""
    return f"{cut(what)} is not understood, and may change the lens: if it does not, remove it"


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """A file opened for reading at its first byte; links are followed.

    OSError where it is missing or unreadable, or is a folder, pipe, device or socket: `strerror` states which. A pipe
    that nobody writes would block, and a device may have no end.
    """
    try:
        _check(os.stat(path).st_mode)       # before it is opened: that alone makes some devices act
    except ValueError as error:             # a NUL in the path
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)) from error
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        _check(os.fstat(handle).st_mode)    # another file may have taken its place
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def _check(mode: int) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "this is a folder, not a file")
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "this is a pipe, device or socket: give an ordinary file")
